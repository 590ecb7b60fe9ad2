"""Topic of the kinematics: the acceleration that the orders beyond the last one kept would add."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.dropped_orders import dropped_acceleration
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.poles import pole, series_terms
from vibecalc.kinematics.slider_crank import piston_path

#: the topic needs a tail that doubles can show
SMALLEST_TAIL = 1e-290


def dropped_topic(ratio: float, offset: float, kept: int) -> Topic:
    """What the orders above `kept` add at most; `ratio` is R/L, `offset` e/R."""
    near = pole(np.asarray(ratio), np.asarray(abs(offset)))
    tail = series_terms(near.radius, "sum of the dropped orders", limit=10**9)

    def after(count: float) -> Answer:
        found = motion_harmonics(ratio, kept + int(count), offset, derivative=2)
        total = np.sum(np.abs(found[kept + 1 :])[::-1])
        if not total > SMALLEST_TAIL:
            raise NumericalFailure(f"the next {count:.0f} orders after {kept} are all zero")
        return Answer(np.array([total]), count)

    def default(_: float) -> Answer:
        return Answer(np.array([float(dropped_acceleration(ratio, kept, offset))]), tail)

    def measured(points: float) -> Answer:
        angle = 2.0 * np.pi * (np.arange(int(points)) + 0.5) / points
        found = motion_harmonics(ratio, kept, offset, derivative=2)
        cut = (np.exp(1j * np.multiply.outer(angle, np.arange(kept + 1))) @ found).real
        exact = piston_path(angle, ratio, 1.0, ratio * offset).acceleration / ratio
        return Answer(np.array([np.max(np.abs(exact - cut))]), points * (kept + 1))

    steps = tuple(float(x) for x in (2, 4, 8, 16, 32, 64) if x < tail)
    return Topic(
        stage="kinematics",
        name="dropped acceleration",
        words=f"most that the orders above {kept} add to the acceleration, over R w^2",
        quantity="kinematics/dropped_acceleration",
        unit="",
        work="orders",
        reference=lambda: _dropped_reference(ratio, offset, kept),
        ladders=(
            Ladder(
                "dropped_acceleration",
                "sum of the tail to the order below which rounding hides the rest",
                "",
                NOTHING_TO_SET,
                default,
                default=1.0,
                citation="docs/theory.md",
            ),
            Ladder(
                "the next orders",
                "magnitudes of the next N orders added",
                "orders",
                steps,
                after,
                theory="geometric",
            ),
            Ladder(
                "exact minus kept",
                "largest difference of closed form and kept orders at N angles",
                "angles",
                (8.0, 32.0, 128.0, 512.0),
                measured,
            ),
        ),
        default_extra=3.0,
        default_why="its number of orders is safe for every R/L, wherever the kept orders end",
    )


def _dropped_reference(ratio: float, offset: float, kept: int) -> Reference:
    """Closed form of the whole sum less the kept orders in many digits, and the tail itself.

    The acceleration's sum of magnitudes is the second derivative of the rod's projection at the
    angle nearest to the pole, y / sqrt(1 - y^2) with y = (R + |e|)/L.
    """
    import mpmath

    small = float(dropped_acceleration(ratio, kept, offset))
    digits = 40 + int(max(-np.log10(small), 0.0))
    with mpmath.workdps(digits):
        lam, shift = mpmath.mpf(ratio), mpmath.mpf(ratio) * abs(mpmath.mpf(offset))
        radius = float(pole(np.asarray(ratio), np.asarray(abs(offset))).radius)
        points = 4 * (kept + 8 + int(digits / max(-np.log10(radius), 0.02)))
        waves = [mpmath.expjpi(mpmath.mpf(2 * k) / points) for k in range(points)]
        rod = [mpmath.sqrt(1 - (lam * wave.imag - shift) ** 2) / lam for wave in waves]
        kept_sum = mpmath.mpf(0)
        for order in range(1, kept + 1):
            part = mpmath.fdot(rod, (waves[order * k % points] for k in range(points)))
            kept_sum += order**2 * 2 * abs(part) / points
        reach = lam + shift
        total = reach / mpmath.sqrt(1 - reach * reach)
        value = float(total - kept_sum)
    agreement = abs(small / value - 1.0)
    return Reference(
        np.array([value]),
        agreement,
        f"closed form of the whole sum less {kept} orders in {digits} digits (mpmath), against "
        "the sum of the tail in doubles",
    )
