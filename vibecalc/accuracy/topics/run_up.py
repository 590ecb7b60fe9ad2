"""Topics of the run-up: the largest support force at any speed, with that speed."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.grids import (
    Highest,
    chebyshev_maximum,
    golden_maximum,
    grid_maximum,
    parabola_maximum,
)
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up import cycle_peaks, run_up, run_up_peak
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing
from vibecalc.pipeline.stages.isolation_common import RunUpSetup, isolation_of

GRIDS = tuple(float(25 * 4**k) for k in range(6))
STARTS = tuple(float(25 * 2**k) for k in range(6))
#: relative half-widths of the interval about the maximum, widest first, for the reference
WINDOWS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4)


class _Curve:
    """The peak of one row against speed, counting the speeds it was asked for."""

    def __init__(self, rows: HarmonicsAt, orders: np.ndarray, row: int) -> None:
        self.rows, self.orders, self.row, self.asked = rows, orders, row, 0

    def __call__(self, speed: np.ndarray) -> np.ndarray:
        return cycle_peaks(self.counted, self.orders, speed).value[:, self.row]

    def counted(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        self.asked += len(speed)
        return self.rows(speed, slopes=slopes, errors=errors)


def topics(scene: Scene) -> list[Topic]:
    """The row with the largest finite maximum; none where all grow without bound."""
    forcing: Forcing = scene.handed_on["forcing"]
    setup: RunUpSetup = scene.handed_on["run_up"]
    span = isolation_of(scene).run_up
    if span is None:
        return []
    orders = forcing.orders[: forcing.kept]
    found = run_up_peak(setup.rows, orders, setup.resonances, span.start, span.stop, setup.shows)
    # a couple over a lever stands before the supports
    heights = np.where(np.isfinite(found.value), found.value, -1.0)
    supports = setup.row_of[setup.lever_rows :]
    row = int(supports[int(np.argmax(heights[supports]))])
    if not heights[row] > 0.0:
        return []
    return [_topic(setup, orders, row, span.start, span.stop, float(found.speed[row]))]


def _topic(
    setup: RunUpSetup, orders: np.ndarray, row: int, start: float, stop: float, known: float
) -> Topic:
    def curve() -> _Curve:
        return _Curve(setup.rows, orders, row)

    def answer(asked: _Curve, value: float, position: float) -> Answer:
        return Answer(np.array([value]), asked.asked, position)

    def refined(tolerance: float) -> Answer:
        one = curve()
        given = (one.counted, orders, setup.resonances, start, stop, setup.shows)
        peak = run_up(*given, curve_tolerance=tolerance).peak
        return answer(one, float(peak.value[row]), float(peak.speed[row]))

    def alone(_: float) -> Answer:
        one = curve()
        peak = run_up_peak(one.counted, orders, setup.resonances, start, stop, setup.shows)
        return answer(one, float(peak.value[row]), float(peak.speed[row]))

    def by(search: Callable[..., Highest]) -> Callable[[float], Answer]:
        def solve(points: float) -> Answer:
            one = curve()
            best = search(one, start, stop, int(points), known)
            return answer(one, best.value, best.position)

        return solve

    def bounded(points: float) -> Answer:
        one = curve()
        best = _bounded(one, start, stop, int(points))
        return answer(one, best.value, best.position)

    ladders = (
        Ladder(
            "curve and summit",
            "speeds at every resonance, halved where the curve bends, Newton at the summits",
            "curve tolerance",
            (1e-1, 3e-2, 1e-2, 3e-3, 1e-3),
            refined,
            default=1e-3,
            theory="the summit does not depend on the curve",
            citation="docs/theory.md, quasi-steady run-up",
        ),
        Ladder(
            "summit alone",
            "the same without the curve, as searches take it",
            "",
            NOTHING_TO_SET,
            alone,
        ),
        Ladder(
            "grid", "highest of N even speeds, a quarter of a step beside the known summit",
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
            "bounded Brent search around the best of N speeds",
            "speeds",
            STARTS,
            bounded,
        ),
    )  # fmt: skip
    return Topic(
        stage="run_up",
        name="largest force of the run-up",
        words=f"largest force of a support between {start:.6g} and {stop:.6g} rad/s",
        quantity="isolation/support_force/run_up_peak",
        unit="N",
        work="speeds",
        reference=lambda: _reference(curve(), start, stop, known),
        ladders=ladders,
        position="crank speed [rad/s]",
        default_extra=30.0,
        default_why="it draws the whole curve as well, and starts at every resonance, so that a "
        "needle between the speeds of a grid is not missed",
    )


def _bounded(curve: _Curve, start: float, stop: float, points: int) -> Highest:
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


def _reference(curve: _Curve, start: float, stop: float, known: float) -> Reference:
    """A polynomial through exact peaks about the summit against golden section there.

    The narrowest window in which two degrees agree best gives the place. A summit at an end of
    the range is the end.
    """
    if known <= start * (1.0 + 1e-12) or known >= stop * (1.0 - 1e-12):
        end = start if known <= start * (1.0 + 1e-12) else stop
        values = curve(np.array([end]))
        grid = grid_maximum(curve, start, stop, 4001)
        over = max(grid.value / float(values[0]) - 1.0, 0.0)
        return Reference(
            values, over, "value at the end of the range; no speed of 4001 is higher", end
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
    dense = grid_maximum(curve, start, stop, 2001)
    agreement = max(abs(golden.value / value - 1.0), dense.value / value - 1.0, 0.0)
    return Reference(
        np.array([value]),
        agreement,
        "zero of the slope of a polynomial through exact peaks, golden section agrees to "
        f"{agreement:.1e}; no speed of 2001 is higher",
        best.position,
    )
