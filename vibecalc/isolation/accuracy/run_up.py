"""Accuracy of a run-up: largest force of each support, curves between sampled speeds."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_searches import (
    Function,
    Highest,
    chebyshev_maximum,
    golden_maximum,
    grid_maximum,
    parabola_maximum,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.run_up import sections
from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.isolation.run_up import cycle_peaks, run_up, run_up_peak
from vibecalc.isolation.run_up_grid import squares
from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.response.resonances import Resonances, masked_speeds

# ----------------------------------------------------------------------------
# Supports of a run-up as functions of the speed, with a count of the speeds examined.
# ----------------------------------------------------------------------------

#: supports whose maxima and speeds agree to this are alike by symmetry
ALIKE = 1e-9


class Counted:
    """Rows of a run-up that count the speeds at which they were asked for."""

    def __init__(self, rows: HarmonicsAt) -> None:
        self._rows, self.asked = rows, 0

    def __call__(self, speed: FloatArray, slopes: bool = False, errors: bool = False) -> Jet:
        self.asked += len(speed)
        return self._rows(speed, slopes=slopes, errors=errors)


class Peaks:
    """Peaks over the cycle of some rows; the same speeds asked again, for another row, are kept."""

    def __init__(self, rows: HarmonicsAt, orders: IntArray, which: IntArray) -> None:
        self._rows, self._orders, self._which = rows, orders, which
        self._last: tuple[FloatArray, FloatArray] = np.zeros(0), np.zeros((0, len(which)))

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Peaks (speeds, rows)."""
        if not np.array_equal(speed, self._last[0]):
            found = cycle_peaks(self._rows, self._orders, speed).value[:, self._which]
            self._last = speed, found
        return self._last[1]

    def row(self, number: int) -> Function:
        """The peak of one row (speeds,) as a function of the speed."""
        return lambda speed: self(np.asarray(speed))[:, number]


class Asked(NamedTuple):
    """What a run-up of a case is asked.

    `rows` : those whose maxima are finite and that differ, as places in what the model gives.
    `known`, `height` : speeds and values of their maxima as a run finds them; `first` is the place
        of the largest among them.
    """

    model: HarmonicsAt
    orders: IntArray
    resonances: Resonances
    shows: np.ndarray
    start: float
    stop: float
    rows: IntArray
    known: tuple[float, ...]
    height: FloatArray
    first: int

    def counted(self) -> Counted:
        """The model's rows with a count of their own."""
        return Counted(self.model)

    def peaks(self) -> Peaks:
        """Peaks of the rows that are asked for."""
        return Peaks(self.model, self.orders, self.rows)


def asked_of(scene: Scene) -> Asked | None:
    """The supports of the case; None without a run-up or without a support of finite maximum."""
    if isolation_of(scene).run_up is None:
        return None
    peaks = []
    for part in sections(scene):
        given = (part.setup.harmonics, part.setup.resonances, part.start, part.stop)
        peaks.append((part, run_up_peak(part.setup.rows, *given, part.setup.shows)))
    # of a range in parts the one with the largest force
    (setup, start, stop), found = max(peaks, key=lambda pair: float(pair[1].value.max()))
    chosen: list[int] = []
    # a couple over a lever stands before the supports
    for row in dict.fromkeys(setup.row_of[setup.lever_rows :].tolist()):
        value, speed = found.value[row], found.speed[row]
        new = all(
            abs(value - found.value[one]) > ALIKE * value
            or abs(speed - found.speed[one]) > ALIKE * speed
            for one in chosen
        )
        if np.isfinite(value) and value > 0.0 and new:
            chosen.append(int(row))
    if not chosen:
        return None
    rows = np.array(chosen)
    height = found.value[rows]
    known = tuple(float(one) for one in found.speed[rows])
    return Asked(setup.rows, setup.harmonics, setup.resonances, setup.shows, start, stop, rows,
                 known, height, int(np.argmax(height)))  # fmt: skip


# ----------------------------------------------------------------------------
# Topic of the run-up: the largest force of each support at any speed, with the speed.
# ----------------------------------------------------------------------------

GRIDS = tuple(float(25 * 4**k) for k in range(6))
STARTS = tuple(float(25 * 2**k) for k in range(6))
#: relative half-widths of the interval about the maximum, widest first, for the reference
WINDOWS = (3e-2, 1e-2, 3e-3, 1e-3, 3e-4)
#: speeds of which none may be higher than the reference
DENSE = 2001
#: speeds over those of the cheapest search that is as accurate: 1.0 to 1.4 in the shipped cases
_EXTRA = 2.0


def run_up_topics(scene: Scene) -> list[Topic]:
    """All supports that differ and have a finite maximum; none where all grow without bound."""
    asked = asked_of(scene)
    return [] if asked is None else [_peak_topic(asked)]


def _peak_topic(asked: Asked) -> Topic:
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

    solvers = (
        Solver(
            "resonances and peaks",
            "few speeds between the resonances and at them, closer about those that can win, "
            "Newton's method in speed and angle at the peaks",
            "",
            NOTHING_TO_SET,
            alone,
            default=1.0,
            citation="docs/theory.md, quasi-steady run-up",
        ),
        Solver(
            "grid", "highest of N even speeds, a quarter of a step next to the known peaks",
            "speeds", GRIDS, by(grid_maximum),
            theory="order 2",
        ),
        Solver(
            "grid with parabola",
            "parabola through the best of N speeds and its neighbours",
            "speeds",
            GRIDS,
            by(parabola_maximum),
        ),
        Solver(
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
        solvers=solvers,
        position="crank speed of the largest [rad/s]",
        default_extra=_EXTRA,
        default_why="it examines every resonance, so that a narrow one between speeds of a grid is "
        "not missed, at the other branches of a peak, and at what a kink parts from it",
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
        _peak_reference(asked.peaks().row(number), asked.start, asked.stop, known)
        for number, known in enumerate(asked.known)
    ]
    return Reference(
        np.concatenate([one.values for one in found]),
        max(one.agreement for one in found),
        found[asked.first].words,
        found[asked.first].position,
    )


def _peak_reference(curve: Function, start: float, stop: float, known: float) -> Reference:
    """A polynomial through exact peaks about the peak against golden section there.

    The narrowest window in which two degrees agree best gives the place. A peak at an end of
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
        raise NumericalFailure("the reference finds no smooth peak of the run-up")
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


# ----------------------------------------------------------------------------
# Topic of the run-up: the curves of all supports, drawn as straight lines between speeds.
# ----------------------------------------------------------------------------

#: speeds at which a curve is held against the truth: over the range, and next to each peak
HELD, NEARBY, REACH = 1500, 25, 3e-2
COUNTS = tuple(float(25 * 2**k) for k in range(7))
#: crank angles over the waves of the highest order, of the second way to the truth
ANGLES = 256
#: share of the golden section: even in the long run, on no grid
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def run_up_curve_topics(scene: Scene) -> list[Topic]:
    """The curves of the supports that differ; none where an undamped resonance cuts them."""
    asked = asked_of(scene)
    if asked is None:
        return []
    if len(masked_speeds(asked.resonances, asked.orders, asked.start, asked.stop).low):
        return []
    return [_curve_topic(asked)]


def _curve_topic(asked: Asked) -> Topic:
    start, stop = asked.start, asked.stop
    places = _places(asked)

    def drawn(speed: FloatArray, values: FloatArray) -> FloatArray:
        """Straight lines at the places, and the highest point, of each support."""
        lines = [np.interp(places, speed, column) for column in values.T]
        return np.concatenate([*lines, values.max(axis=0)])

    def refined(tolerance: float) -> Answer:
        rows = asked.counted()
        given = (rows, asked.orders, asked.resonances, start, stop, asked.shows)
        found = run_up(*given, curve_tolerance=tolerance)
        shown = drawn(found.speed, found.curve.value[:, asked.rows])
        shown[-len(asked.rows) :] = found.peak.value[asked.rows]
        return Answer(shown, rows.asked)

    def by(spread: Callable[[int], FloatArray]) -> Callable[[float], Answer]:
        def solve(count: float) -> Answer:
            speed = spread(int(count))
            return Answer(drawn(speed, asked.peaks()(speed)), len(speed))

        return solve

    def splined(count: float) -> Answer:
        from scipy.interpolate import CubicSpline

        speed = geometric(int(count))
        values = asked.peaks()(speed)
        curve = CubicSpline(speed, values, axis=0)(places)
        return Answer(np.concatenate([curve.T.ravel(), values.max(axis=0)]), len(speed))

    def geometric(count: int) -> FloatArray:
        lowest = 0.5 * float(asked.resonances.frequency.min() / asked.orders.max())
        low = max(start, min(lowest, 0.5 * stop))
        speed = np.geomspace(low, stop, count)
        speed[0], speed[-1] = low, stop
        # the curve rises with the square of the speed below
        below = np.linspace(start, low, count // 10 + 2)[:-1]
        return speed if low <= start else np.concatenate([below, speed])

    return Topic(
        stage="run_up",
        name="curves of the run-up",
        words=f"force of {len(asked.rows)} supports that differ against speed, by straight lines "
        f"at {len(places)} speeds, and its highest value",
        quantity="isolation/support_force/run_up",
        unit="N",
        work="speeds",
        reference=lambda: _curve_reference(asked, places),
        solvers=(
            Solver(
                "halved where it bends",
                "speeds at every resonance, halved until the middle lies on the line",
                "curve tolerance",
                (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4),
                refined,
                default=1e-3,
                theory="order 1: what is asked for",
                citation="docs/theory.md, quasi-steady run-up",
            ),
            Solver(
                "even speeds", "straight lines between N of them", "speeds", COUNTS,
                by(lambda count: np.linspace(start, stop, count)), theory="order 2",
            ),
            Solver(
                "geometric speeds", "straight lines between N of them from half the lowest "
                "resonance on", "speeds", COUNTS, by(geometric), theory="order 2",
            ),
            Solver(
                "spline of geometric speeds", "the same with scipy's cubic spline, which kinks of "
                "the curve disturb", "speeds", COUNTS, splined,
            ),
        ),
    )  # fmt: skip


def _places(asked: Asked) -> FloatArray:
    """Speeds spread over the range and next to the peaks, on no grid."""
    even = np.remainder(GOLDEN * np.arange(1, HELD + 1), 1.0)
    near = [
        known * (1.0 + REACH * (2.0 * np.remainder(GOLDEN * np.arange(1, NEARBY + 1), 1.0) - 1.0))
        for known in asked.known
    ]
    places = np.concatenate([asked.start + (asked.stop - asked.start) * even, *near])
    return np.sort(places[(places > asked.start) & (places < asked.stop)])


def _curve_reference(asked: Asked, places: FloatArray) -> Reference:
    """Proven peaks over the cycle, against samples of it."""
    curve = asked.peaks()(places)
    values = np.concatenate([curve.T.ravel(), asked.height])
    orders = asked.orders
    count = ANGLES * int(orders.max())
    angle = np.arange(count) * (2.0 * np.pi / count)
    some = places[:: max(len(places) // 100, 1)]
    sampled = squares(asked.model(some).value[:, asked.rows], orders, angle).max(axis=-1)
    close = curve[:: max(len(places) // 100, 1)]
    apart = float(np.max(np.abs(np.sqrt(sampled) - close)) / np.max(asked.height))
    return Reference(
        values,
        apart,
        f"proven peaks over the cycle at each speed; the best of {count} crank angles agrees to "
        f"{apart:.1e}",
    )
