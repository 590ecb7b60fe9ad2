"""Topic of the run-up: the largest force of each support at any speed, with the speed."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.grids import (
    Function,
    Highest,
    chebyshev_maximum,
    golden_maximum,
    grid_maximum,
    parabola_maximum,
)
from vibecalc.accuracy.yardsticks.run_up_rows import Asked, asked_of
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.run_up import run_up_peak
from vibecalc.pipeline.scene import Scene

GRIDS = tuple(float(25 * 4**k) for k in range(6))
STARTS = tuple(float(25 * 2**k) for k in range(6))
#: relative half-widths of the interval about the maximum, widest first, for the reference
WINDOWS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4)
#: speeds of which none may be higher than the reference
DENSE = 2001
#: speeds over those of the cheapest search that is as accurate: 1.0 to 1.4 in the shipped cases
_EXTRA = 2.0


def topics(scene: Scene) -> list[Topic]:
    """All supports that differ and have a finite maximum; none where all grow without bound."""
    asked = asked_of(scene)
    return [] if asked is None else [_topic(asked)]


def _topic(asked: Asked) -> Topic:
    start, stop, first = asked.start, asked.stop, asked.first

    def alone(_: float) -> Answer:
        rows = asked.counted()
        peak = run_up_peak(rows, asked.orders, asked.resonances, start, stop, asked.shows)
        return Answer(peak.value[asked.rows], rows.asked, float(peak.speed[asked.rows[first]]))

    def by(search: Callable[..., Highest]) -> Callable[[float], Answer]:
        def solve(points: float) -> Answer:
            peaks = asked.peaks()
            # the grid of the first row serves all
            best = [
                search(peaks.row(number), start, stop, int(points), known)
                for number, known in enumerate(asked.known)
            ]
            value = np.array([one.value for one in best])
            return Answer(value, float(best[first].evaluations), best[first].position)

        return solve

    def bounded(points: float) -> Answer:
        peaks = asked.peaks()
        best = [_bounded(peaks.row(k), start, stop, int(points)) for k in range(len(asked.rows))]
        work = points + sum(one.evaluations - points for one in best)
        return Answer(np.array([one.value for one in best]), work, best[first].position)

    ladders = (
        Ladder(
            "resonances and summits",
            "few speeds between the resonances and at them, closer about those that can win, "
            "Newton's method in speed and angle at the summits",
            "",
            NOTHING_TO_SET,
            alone,
            default=1.0,
            citation="docs/theory.md, quasi-steady run-up",
        ),
        Ladder(
            "grid", "highest of N even speeds, a quarter of a step beside the known summits",
            "speeds", GRIDS, by(grid_maximum),
            theory="order 2",
        ),
        Ladder(
            "grid with parabola",
            "parabola through the best of N speeds and its neighbours",
            "speeds",
            GRIDS,
            by(parabola_maximum),
        ),
        Ladder(
            "scipy minimize_scalar",
            "bounded Brent search for each support around the best of N speeds",
            "speeds",
            STARTS,
            bounded,
        ),
    )  # fmt: skip
    return Topic(
        stage="run_up",
        name="largest forces of the run-up",
        words=f"largest force of {len(asked.rows)} supports that differ, between {start:.6g} and "
        f"{stop:.6g} rad/s",
        quantity="isolation/support_force/run_up_peak",
        unit="N",
        work="speeds",
        reference=lambda: _references(asked),
        ladders=ladders,
        position="crank speed of the largest [rad/s]",
        default_extra=_EXTRA,
        default_why="it looks at every resonance, so that a needle between the speeds of a grid is "
        "not missed, at the other branches of a summit, and at what a kink parts from it",
    )


def _bounded(curve: Function, start: float, stop: float, points: int) -> Highest:
    from scipy.optimize import minimize_scalar

    best = grid_maximum(curve, start, stop, points)
    step = (stop - start) / (points - 1)
    found = minimize_scalar(
        lambda speed: -float(curve(np.array([speed]))[0]),
        bounds=(max(best.position - step, start), min(best.position + step, stop)),
        method="bounded",
        options={"xatol": 1e-10 * stop},
    )
    if not found.success:
        raise NumericalFailure(f"minimize_scalar gave up: {found.message}")
    return Highest(-float(found.fun), float(found.x), points + int(found.nfev))


def _references(asked: Asked) -> Reference:
    """Each support's own, together."""
    found = [
        _reference(asked.peaks().row(number), asked.start, asked.stop, known)
        for number, known in enumerate(asked.known)
    ]
    return Reference(
        np.concatenate([one.values for one in found]),
        max(one.agreement for one in found),
        found[asked.first].words,
        found[asked.first].position,
    )


def _reference(curve: Function, start: float, stop: float, known: float) -> Reference:
    """A polynomial through exact peaks about the summit against golden section there.

    The narrowest window in which two degrees agree best gives the place. A summit at an end of
    the range is the end.
    """
    if known <= start * (1.0 + 1e-12) or known >= stop * (1.0 - 1e-12):
        end = start if known <= start * (1.0 + 1e-12) else stop
        values = curve(np.array([end]))
        grid = grid_maximum(curve, start, stop, DENSE)
        over = max(grid.value / float(values[0]) - 1.0, 0.0)
        return Reference(
            values, over, f"value at the end of the range; no speed of {DENSE} is higher", end
        )
    half = 1e-3 * known
    low, high = max(known - half, start), min(known + half, stop)
    golden = golden_maximum(curve, low, high, 45)
    fits = []
    for window in WINDOWS:
        width = min(window * known, golden.position - start, stop - golden.position)
        try:
            fine, coarse = (
                chebyshev_maximum(curve, golden.position, width, degree) for degree in (16, 12)
            )
        except NumericalFailure:
            continue
        fits.append((abs(fine.position - coarse.position), fine))
    if not fits:
        raise NumericalFailure("the reference finds no smooth summit of the run-up")
    _, best = min(fits, key=lambda pair: pair[0])
    value = float(curve(np.array([best.position]))[0])
    dense = grid_maximum(curve, start, stop, DENSE)
    agreement = max(abs(golden.value / value - 1.0), dense.value / value - 1.0, 0.0)
    return Reference(
        np.array([value]),
        agreement,
        "zero of the slope of a polynomial through exact peaks, golden section agrees to "
        f"{agreement:.1e}; no speed of {DENSE} is higher",
        best.position,
    )
