"""Topic of the run-up: the curves of all supports, drawn as straight lines between speeds."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.run_up_rows import Asked, asked_of
from vibecalc.isolation.envelope import squares
from vibecalc.isolation.run_up import run_up
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.response.singular import masked_speeds

#: speeds at which a curve is held against the truth: over the range, and beside each summit
HELD, BESIDE, REACH = 1500, 25, 3e-2
COUNTS = tuple(float(25 * 2**k) for k in range(7))
#: crank angles over the waves of the highest order, of the second way to the truth
ANGLES = 256
#: share of the golden section: even in the long run, on no grid
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def topics(scene: Scene) -> list[Topic]:
    """The curves of the supports that differ; none where an undamped resonance cuts them."""
    asked = asked_of(scene)
    if asked is None:
        return []
    if len(masked_speeds(asked.resonances, asked.orders, asked.start, asked.stop).low):
        return []
    return [_topic(asked)]


def _topic(asked: Asked) -> Topic:
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
        reference=lambda: _reference(asked, places),
        ladders=(
            Ladder(
                "halved where it bends",
                "speeds at every resonance, halved until the middle lies on the line",
                "curve tolerance",
                (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4),
                refined,
                default=1e-3,
                theory="order 1: what is asked for",
                citation="docs/theory.md, quasi-steady run-up",
            ),
            Ladder(
                "even speeds", "straight lines between N of them", "speeds", COUNTS,
                by(lambda count: np.linspace(start, stop, count)), theory="order 2",
            ),
            Ladder(
                "geometric speeds", "straight lines between N of them from half the lowest "
                "resonance on", "speeds", COUNTS, by(geometric), theory="order 2",
            ),
            Ladder(
                "spline of geometric speeds", "the same with scipy's cubic spline, which kinks of "
                "the curve disturb", "speeds", COUNTS, splined,
            ),
        ),
    )  # fmt: skip


def _places(asked: Asked) -> FloatArray:
    """Speeds spread over the range and beside the summits, on no grid."""
    even = np.remainder(GOLDEN * np.arange(1, HELD + 1), 1.0)
    near = [
        known * (1.0 + REACH * (2.0 * np.remainder(GOLDEN * np.arange(1, BESIDE + 1), 1.0) - 1.0))
        for known in asked.known
    ]
    places = np.concatenate([asked.start + (asked.stop - asked.start) * even, *near])
    return np.sort(places[(places > asked.start) & (places < asked.stop)])


def _reference(asked: Asked, places: FloatArray) -> Reference:
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
