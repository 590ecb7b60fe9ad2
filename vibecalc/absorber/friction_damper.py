"""Lanchester's damper on a primary of one mode: response to a harmonic force, best friction.

By the first harmonic of all the friction does, `vibecalc.parts.dry_friction`.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.parts.dry_friction import ALWAYS_SLIPS, settled, shares

#: errors: roundings of a response, place of a peak, relative ones of what conditions settle
_ROUNDINGS, _PLACE, _SETTLED = 64.0, 4e-8, 1e-10
_NOT_FOUND = (
    "the best friction is not found: with so heavy a damper, or so much damping of the primary, "
    "the mass sticks where the response is largest; say a friction_ratio"
)
#: complex step
_STEP = 1e-30
#: frequency ratios and friction ratios that are looked at first
_PLACES, _FRICTIONS = 81, np.geomspace(1e-3, 2.0, 12)


# ----------------------------------------------------------------------------
# Response of a primary of one mode to a harmonic force T0, over T0 / K1.
#
# f = F / T0 is all that counts of the friction. A guess of t gives Y K1 / T0 = f / (m x^2 t), and
# the force that this takes has to be T0; of several motions that do, the largest is given.
# ----------------------------------------------------------------------------


class DryFriction(NamedTuple):
    """Damping z1 of the primary, mass ratio m, friction over the amplitude of the force f."""

    primary_damping: float
    mass_ratio: float
    friction_ratio: float


def response(damper: DryFriction, frequency_ratio: ArrayLike) -> FloatArray:
    """Amplitudes (n,) at frequency ratios x (n,); infinite where friction takes too little."""
    z1, m, f = damper
    x = np.asarray(frequency_ratio, dtype=float)
    moved = m * np.square(x)

    def stiffness(t: FloatArray) -> FloatArray:
        """Force over K1 and amplitude."""
        share = shares(t)
        real, imaginary = 1.0 - x * x - moved * share.inertia, 2.0 * z1 * x + moved * share.damping
        return np.asarray(np.hypot(real, imaginary))

    if f == 0.0:
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / np.hypot(1.0 - x * x, 2.0 * z1 * x))
    return settled(stiffness, f, moved)[0]


def largest(damper: DryFriction) -> tuple[Bounded, float]:
    """The largest response over all frequencies, and the frequency ratio at which it is."""
    from scipy.optimize import minimize_scalar

    stuck = 1.0 / np.sqrt(1.0 + damper.mass_ratio)
    near = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _PLACES))
    x = np.concatenate([np.linspace(0.0, stuck, 40)[:-1], stuck + (1.0 - stuck) * near])
    found = response(damper, x)
    top = int(np.argmax(found))
    if np.isinf(found[top]):
        return Bounded(np.asarray(np.inf), np.asarray(0.0)), float(x[top])
    ends = x[max(top - 1, 0)], x[min(top + 1, len(x) - 1)]
    best = minimize_scalar(lambda at: -response(damper, [at])[0], bounds=ends, method="bounded",
                           options={"xatol": 1e-10})  # fmt: skip
    height, place = max((-float(best.fun), float(best.x)), (float(found[top]), float(x[top])))
    # next to a maximum the place counts by its square, over the width of a peak, 1 / height
    error = height * (_ROUNDINGS * EPSILON + min(1.0, (_PLACE * height) ** 2))
    return Bounded(np.asarray(height), np.asarray(error)), place


def best_friction(primary_damping: float, mass_ratio: float) -> tuple[Bounded, Bounded]:
    """The friction ratio with the least largest response, and that response.

    Of an undamped primary all curves pass the height 1 + pi^2 / (4 m), which the best friction
    pi / sqrt(8 (1 + 4 m / pi^2)) makes their peak: exact as far as the first harmonic is.
    Raises NumericalFailure where another peak is higher, with the mass sticking at times.
    """
    undamped = np.pi / np.sqrt(8.0 * (1.0 + 4.0 * mass_ratio / np.pi**2))
    ratio, height = undamped, 1.0 + np.pi**2 / (4.0 * mass_ratio)
    if primary_damping > 0.0:
        ratio, height = _searched(primary_damping, mass_ratio, undamped)
    top = largest(DryFriction(primary_damping, mass_ratio, ratio))[0]
    if top.value > height * (1.0 + 1e-8):
        raise NumericalFailure(_NOT_FOUND)
    return (Bounded(np.asarray(ratio), np.asarray(_SETTLED * ratio)),
            Bounded(np.asarray(height), np.asarray(_SETTLED * height)))  # fmt: skip


def _searched(primary_damping: float, mass_ratio: float, undamped: float) -> tuple[float, float]:
    """The same for a damped primary: by golden sections, then to the last digits."""
    from scipy.optimize import minimize_scalar

    def level(logarithm: float) -> float:
        damper = DryFriction(primary_damping, mass_ratio, float(np.exp(logarithm)))
        return float(largest(damper)[0].value)

    logs = np.log(undamped * _FRICTIONS)
    place = int(np.argmin([level(one) for one in logs.tolist()]))
    ends = logs[max(place - 1, 0)], logs[min(place + 1, len(logs) - 1)]
    best = minimize_scalar(level, bounds=ends, method="bounded", options={"xatol": 1e-9})
    found = DryFriction(primary_damping, mass_ratio, float(np.exp(best.x)))
    return _finished(found, largest(found)[1], float(best.fun))


def _finished(near: DryFriction, place: float, height: float) -> tuple[float, float]:
    """Friction and height where neither frequency nor friction change the height.

    Of a mass that slips all the time, from near there; with derivatives by complex steps.
    """
    from scipy.optimize import root

    z1, m, _ = near

    def rest(x: Any, f: Any, y: Any) -> Any:
        """Square of force over T0 less 1."""
        moved, away = m * x * x, 1.0 - x * x
        slow = np.pi * f / (2.0 * moved * y)
        plain = (away * y) ** 2 - 4.0 * away * f * f / moved + (4.0 * f / np.pi) ** 2
        drag = (2.0 * z1 * x * y) ** 2 + 16.0 / np.pi * z1 * x * y * f * np.sqrt(1.0 - slow**2)
        return plain + drag - 1.0

    def conditions(at: FloatArray) -> FloatArray:
        x, f, y = at.tolist()
        by_place, by_friction = rest(x + _STEP * 1j, f, y), rest(x, f + _STEP * 1j, y)
        return np.array([rest(x, f, y), by_place.imag / _STEP, by_friction.imag / _STEP])

    with np.errstate(invalid="ignore"):
        solved = root(conditions, [place, near.friction_ratio, height], tol=1e-14)
    x, ratio, best = solved.x.tolist()
    share = ratio / (m * x * x * best)
    if abs(best / height - 1.0) > 1e-5 or not 0.0 < share < ALWAYS_SLIPS:
        raise NumericalFailure(_NOT_FOUND)
    return ratio, best
