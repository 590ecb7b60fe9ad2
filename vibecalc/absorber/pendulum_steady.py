"""Steady motion of a rotor with its pendulum under a torque of one order, until it jumps."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.pendulum_order import Pendulum, largest_swing, terms, tuning_order
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, ComplexArray, FloatArray, floats

# ----------------------------------------------------------------------------
# A pendulum, for small swings, as a secondary system on the rotor.
#
# Written for swings p and a small motion t of the rotor on its mean rotation W, the equations are
#
#     A t'' + B p'' = torque,    B t'' + C p'' + b p' + n^2 W^2 C p = 0
#
# with the coefficients of the kinetic energy at the vertex. With theta_2 = t + (C / B) p they are
# those of an inertia J2 = B^2 / C that hangs on the rotor by K2 = n^2 W^2 J2 and c2 = b (B / C)^2,
# while J1 = A - J2 turns with the rotor. A point on an arm has J2 = m c^2 and leaves J1 the rotor's
# alone.
# ----------------------------------------------------------------------------


class Secondary(NamedTuple):
    """Inertias in kg m^2, stiffness in N m/rad, damping in N m s/rad; swing over relative angle.

    The swing angle is `swing_per_twist` (theta_2 - theta_1). `error` is relative, of every one.
    """

    primary_inertia: FloatArray
    inertia: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    swing_per_twist: FloatArray
    error: FloatArray


def as_secondary(
    pendulum: Pendulum, rotor_inertia: ArrayLike, speed: ArrayLike, damping: ArrayLike = 0.0
) -> Secondary:
    """The secondary system that small swings at a rotor speed (rad/s) amount to. Broadcasts.

    `damping` in N m s/rad acts on the swing angle.
    """
    rotor, turning, drag = floats(rotor_inertia, speed, damping)
    at_rest = terms(pendulum, np.zeros(()))
    order = tuning_order(pendulum)
    ratio = at_rest.coupling / at_rest.swing
    inertia = at_rest.coupling * ratio
    left = rotor + at_rest.carried - inertia
    # what turns with the rotor is what the pendulum has beyond J2: it may cancel
    size = (np.abs(rotor) + at_rest.carried + inertia) / np.abs(left)
    error = 16.0 * UNIT_ROUNDOFF * (1.0 + size) + 2.0 * order.error / order.value
    square = np.square(order.value * turning)
    return Secondary(left, inertia, square * inertia, drag * ratio**2, ratio, error)


class SmallMotion(NamedTuple):
    """Complex amplitudes in rad, 0-to-peak, of rotor and swing angle for a torque amplitude."""

    rotor: ComplexArray
    swing: ComplexArray
    rotor_error: FloatArray
    swing_error: FloatArray


def small_motion(
    secondary: Secondary, frequency: ArrayLike, torque: ArrayLike, stiffness: ArrayLike = 0.0
) -> SmallMotion:
    """Response to a torque (N m, complex, 0-to-peak) on the rotor at an angular frequency (rad/s).

    `stiffness` (N m/rad) holds the rotor, 0 leaves it free. Infinite on an undamped resonance. At
    the order of an undamped pendulum the rotor rests and the swing carries all the torque.
    """
    first, second, stiff, drag, per_twist, relative = secondary
    w, load, hold = (np.asarray(value) for value in (frequency, torque, stiffness))
    link = stiff + 1j * w * drag
    pendulum_stiffness = link - second * w * w
    whole = (hold - first * w * w) * pendulum_stiffness - second * w * w * link
    pendulum_size = np.abs(link) + second * w * w
    size = (np.abs(hold) + first * w * w) * pendulum_size + second * w * w * np.abs(link)
    with np.errstate(divide="ignore", invalid="ignore"):
        rotor = np.where(whole == 0.0, np.inf, load * pendulum_stiffness / whole)
        swing = np.where(whole == 0.0, np.inf, load * per_twist * second * w * w / whole)
        uncertainty = (relative + 8.0 * UNIT_ROUNDOFF) * (1.0 + 2.0 * size / np.abs(whole))
        rotor_error = np.abs(load) * pendulum_size / np.abs(whole) * uncertainty
        swing_error = np.abs(swing) * uncertainty
    return SmallMotion(rotor, swing, rotor_error, swing_error)


# ----------------------------------------------------------------------------
# Exact steady motion of a rotor and its undamped pendulum under a torque of one order.
#
# The torque is T0 sin(n T) of the rotor's own angle T. With the square of the rotor speed y = T'^2
# and ' for the derivative by T, and M = A + B p',
#
#     (y M^2)' = 2 M T0 sin(n T)
#     C p'' + C_p p'^2 / 2 - A_p / 2 + (y' / 2 y) (B + C p') = 0.
#
# Turned about T = 0 and run backwards a motion is a motion again; the steady one that grows out of
# rest is its own mirror image: p is a series of sines of k n T. The first equation is integrated
# term by term, the second holds at equidistant points, and Newton's method finds the torque and all
# sines but the first, whose amplitude is given: a response that folds back over the torque is a
# function of it. Derivatives for Newton are taken by complex steps.
# ----------------------------------------------------------------------------

_STEP = 1e-30
_MOST_ITERATIONS = 15

#: change of all unknowns, over the largest sine, at which Newton's method has arrived
_SETTLED = 1e-13

#: no sine of a swing is as large, in rad
_WILD = 10.0

#: shares of the swing through which the solution is led up to the one asked for
_STAGES = 6


class SteadyMotion(NamedTuple):
    """Motions (...,); torque over the square of the mean rotor speed in kg m^2, with its sign.

    `swing` (..., k) sines of the swing angle in rad; `largest` its largest value over the cycle.
    `acceleration` (..., k) sines of the rotor's angular acceleration over the square of the mean
    speed, by the rotor's angle. A positive torque accelerates the rotor while n T is below pi.
    """

    torque: Bounded
    swing: Bounded
    largest: Bounded
    acceleration: Bounded


def steady_motion(
    pendulum: Pendulum, rotor_inertia: ArrayLike, order: ArrayLike, swing: ArrayLike,
    harmonics: int = 24,
) -> SteadyMotion:  # fmt: skip
    """Steady motions with a given first sine of the swing angle (rad). Everything broadcasts.

    Computed with `harmonics` sines and half as many again, the change being the error. Raises
    NumericalFailure where Newton's method fails or the swing would leave the path.
    """
    coarse = _solved(pendulum, rotor_inertia, order, swing, harmonics)
    fine = _solved(pendulum, rotor_inertia, order, swing, harmonics + harmonics // 2)
    results = []
    for rough, good in zip(coarse, fine, strict=True):
        common = good[..., : rough.shape[-1]]
        uncertainty = 2.0 * np.abs(common - rough) + 64.0 * UNIT_ROUNDOFF * np.abs(common)
        size = np.max(np.abs(common), axis=-1, keepdims=True)
        results.append(Bounded(common, uncertainty + 256.0 * UNIT_ROUNDOFF * size))
    torque, sines, largest, acceleration = results
    return SteadyMotion(_single(torque), sines, _single(largest), acceleration)


def _single(value: Bounded) -> Bounded:
    return Bounded(value.value[..., 0], value.error[..., 0])


def _solved(
    pendulum: Pendulum, rotor_inertia: ArrayLike, order: ArrayLike, swing: ArrayLike, count: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    rotor, number, first = floats(rotor_inertia, order, swing)
    parts = [np.asarray(value, dtype=float) for value in pendulum]
    shape = np.broadcast_shapes(rotor.shape, number.shape, first.shape, *(p.shape for p in parts))
    body = Pendulum(*(np.broadcast_to(part, shape)[..., None] for part in parts))
    frame = _Frame(
        body, np.broadcast_to(rotor, shape)[..., None], np.broadcast_to(number, shape)[..., None]
    )
    target = np.broadcast_to(first, shape)[..., None]
    unknown = np.zeros((*shape, count))
    unknown[..., :1] = _small_torque(frame, target / _STAGES)
    for stage in range(1, _STAGES + 1):
        unknown = _newton(frame, unknown, target * stage / _STAGES)
        if stage < _STAGES:
            unknown = unknown * (1.0 + 1.0 / stage)
    sines = np.concatenate([target, unknown[..., 1:]], axis=-1)
    return _readings(frame, sines, unknown[..., :1])


class _Frame(NamedTuple):
    """Pendulum, rotor inertia and order with an axis for the points."""

    pendulum: Pendulum
    rotor: FloatArray
    order: FloatArray


def _small_torque(frame: _Frame, first: FloatArray) -> FloatArray:
    """Torque of small swings, over the square of A T'."""
    at_rest = terms(frame.pendulum, np.zeros(()))
    carried = frame.rotor + at_rest.carried
    tuned, forced = tuning_order(frame.pendulum).value, frame.order
    stiff = at_rest.swing * (tuned**2 - forced**2) + (forced * at_rest.coupling) ** 2 / carried
    return np.asarray(-first * stiff / (at_rest.coupling * carried))


def _newton(frame: _Frame, unknown: FloatArray, first: FloatArray) -> FloatArray:
    count = unknown.shape[-1]
    # one more axis for the direction of the derivative
    body = Pendulum(*(np.asarray(part)[..., None, :] for part in frame.pendulum))
    wide = _Frame(body, frame.rotor[..., None, :], frame.order[..., None, :])
    aside = 1j * _STEP * np.eye(count)
    for _ in range(_MOST_ITERATIONS):
        value = _residual(frame, unknown, first)
        slope = _residual(wide, unknown[..., None, :] + aside, first[..., None, :]).imag / _STEP
        try:
            change = np.linalg.solve(np.swapaxes(slope, -1, -2), value[..., None])[..., 0]
        except np.linalg.LinAlgError:
            break
        unknown = unknown - change
        size = np.max(np.abs(unknown[..., 1:]), axis=-1, keepdims=True) + np.abs(first)
        if not np.all(size <= _WILD):
            break
        if np.all(np.abs(change) <= _SETTLED * (size + np.abs(unknown))):
            return unknown
    raise NumericalFailure(
        "no steady motion of the pendulum found: the swing asked for is beyond what this path "
        "and rotor can carry, or needs more harmonics"
    )


def _residual(frame: _Frame, unknown: FloatArray, first: FloatArray) -> FloatArray:
    """The second equation at the inner points, for unknown torque and sines."""
    torque = unknown[..., :1]
    sines = np.concatenate([np.broadcast_to(first, torque.shape), unknown[..., 1:]], axis=-1)
    return _equation(frame, sines, torque)[0][..., 1:-1]


def _equation(
    frame: _Frame, sines: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Left side of the second equation, y' / 2 and y where n T is i pi / (k + 1), i = 0 .. k + 1.

    The scale of y is that of (y M^2) = 1 at n T = 0.
    """
    count = sines.shape[-1]
    number, (wave, place, sine, cosine) = frame.order, _waves(count)
    angle = sines @ sine
    slope = number * ((sines * wave) @ cosine)
    bend = -(number**2) * ((sines * wave**2) @ sine)
    term = terms(frame.pendulum, angle)
    moved = frame.rotor + term.carried + term.coupling * slope
    moved_slope = (
        term.carried_slope * slope + term.coupling_slope * slope * slope + term.coupling * bend
    )
    # the integral of M sin, by the sines of the integrand
    driven = moved * np.sin(place)
    shares = (2.0 / (count + 1)) * (driven @ sine.T) / wave
    done = np.sum(shares, axis=-1, keepdims=True) - shares @ cosine
    square = 1.0 + 2.0 * torque / number * done
    half_rate = torque * driven / square - moved_slope / moved
    left = (
        term.swing * bend
        + 0.5 * term.swing_slope * slope * slope
        - 0.5 * term.carried_slope
        + half_rate * (term.coupling + term.swing * slope)
    )
    speed_square = square / (moved * moved)
    return left, half_rate * speed_square, speed_square


def _readings(
    frame: _Frame, sines: FloatArray, torque: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    count = sines.shape[-1]
    wave, place = np.arange(1, count + 1), _places(count)
    _, rate, square = _equation(frame, sines, torque)
    if np.any(square <= 0.0):
        raise NumericalFailure("the torque stops the rotor within the cycle: no steady motion")
    largest = cycle_peak(-1j * sines, wave).value[..., None]
    if np.any(largest >= np.broadcast_to(largest_swing(frame.pendulum), largest.shape)):
        raise NumericalFailure("the swing leaves the path of the pendulum within the cycle")
    # the mean speed is an angle over its time; the ends of the half cycle count half
    slowness = 1.0 / np.sqrt(square)
    inner = np.sum(slowness[..., 1:-1], axis=-1) + 0.5 * (slowness[..., 0] + slowness[..., -1])
    mean_square = np.square((count + 1) / inner[..., None])
    acceleration = (2.0 / (count + 1)) * (rate @ np.sin(np.outer(wave, place)).T)
    return torque / mean_square, sines, largest, acceleration / mean_square


@lru_cache(maxsize=16)
def _waves(count: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Numbers of sines, their places in half a cycle, sines and cosines (count, places) there."""
    wave: FloatArray = np.arange(1.0, count + 1.0)
    place = _places(count)
    turned: FloatArray = np.outer(wave, place)
    return wave, place, np.asarray(np.sin(turned)), np.asarray(np.cos(turned))


def _places(count: int) -> FloatArray:
    return np.asarray(np.pi * np.arange(count + 2) / (count + 1))


# ----------------------------------------------------------------------------
# The torque at which a pendulum jumps: where its steady motion folds back.
#
# On a circle a pendulum falls below its order as it swings further. The torque that it balances
# rises with the swing to a greatest value and falls again: beyond that torque the motion that grew
# out of rest is gone, and the pendulum jumps to one in step with the torque, which makes the rotor
# move more than it would without it.
# ----------------------------------------------------------------------------

#: first sines tried, as shares of the largest swing of the path
_SCAN = np.linspace(0.0, 0.9, 37)[1:]
_BLOCK = 4

#: points of the polynomial through the torque around its greatest value
_POINTS = 13


class Jump(NamedTuple):
    """Torque over the square of the mean speed (kg m^2); largest angle of swing over the cycle and
    first sine of the swing (rad), which differ by the other sines.
    """

    torque: Bounded
    swing: Bounded
    first_sine: Bounded


def jump(pendulum: Pendulum, rotor_inertia: float, order: float) -> Jump:
    """Greatest torque of an order that the motion out of rest can carry; one pendulum at a time.

    Raises NumericalFailure where the torque grows as far as steady motions are found.
    """
    end = float(largest_swing(pendulum))
    swings, torques = _ascending_branch(pendulum, rotor_inertia, order, end)
    top = int(np.argmax(torques))
    if top in (0, len(torques) - 1):
        raise NumericalFailure(
            f"no jump: the torque grows with the swing as far as steady motions are found "
            f"(first sine {swings[-1]:.4g} rad of {end:.4g})"
        )
    low, high = swings[top - 1], swings[top + 1]
    node = np.cos(np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    motion = steady_motion(
        pendulum, rotor_inertia, order, 0.5 * (low + high) + 0.5 * (high - low) * node
    )
    fits = [
        np.polynomial.Chebyshev.fit(
            node[:: 1 + skip], np.abs(motion.torque.value[:: 1 + skip]), degree
        )
        for skip, degree in ((0, _POINTS - 1), (1, _POINTS // 2))
    ]
    good, rough = (_greatest(fit) for fit in fits)
    noise = float(np.max(motion.torque.error))
    half = 0.5 * (high - low)
    bend = abs(float(fits[0].deriv(2)(good[0])))
    uncertainty = abs(good[0] - rough[0]) + np.sqrt(2.0 * noise / bend)
    reach = np.polynomial.Chebyshev.fit(node, motion.largest.value, _POINTS - 1)
    off = abs(float(reach.deriv()(good[0]))) * uncertainty + 2.0 * float(
        np.max(motion.largest.error)
    )
    return Jump(
        Bounded(np.asarray(good[1]), np.asarray(abs(good[1] - rough[1]) + 2.0 * noise)),
        Bounded(np.asarray(reach(good[0])), np.asarray(off)),
        Bounded(np.asarray(0.5 * (low + high) + half * good[0]), np.asarray(half * uncertainty)),
    )


def _ascending_branch(
    pendulum: Pendulum, rotor_inertia: float, order: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Swings and torques until the torque falls, or until no motion is found."""
    swings, torques = np.zeros(1), np.zeros(1)
    for start in range(0, len(_SCAN), _BLOCK):
        block = end * _SCAN[start : start + _BLOCK]
        try:
            torque = steady_motion(pendulum, rotor_inertia, order, block, 16).torque.value
        except NumericalFailure:
            break
        swings = np.concatenate([swings, block])
        torques = np.concatenate([torques, np.abs(torque)])
        if np.any(np.diff(torques) < 0.0):
            last = int(np.argmax(np.diff(torques) < 0.0)) + 2
            return swings[:last], torques[:last]
    return swings, torques


def _greatest(fit: np.polynomial.Chebyshev) -> tuple[float, float]:
    """Place in [-1, 1] and value of the greatest value of a polynomial."""
    roots = fit.deriv().roots()
    inside = roots.real[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1.0)]
    places = np.concatenate([inside, [-1.0, 1.0]])
    values = fit(places)
    best = int(np.argmax(values))
    return float(places[best]), float(values[best])
