"""Exact steady motion of a rotor and its undamped pendulum under a torque of one order.

The torque is T0 sin(n T) of the rotor's own angle T. With the square of the rotor speed y = T'^2
and ' for the derivative by T, and M = A + B p',

    (y M^2)' = 2 M T0 sin(n T)
    C p'' + C_p p'^2 / 2 - A_p / 2 + (y' / 2 y) (B + C p') = 0.

Turned about T = 0 and run backwards a motion is a motion again; the steady one that grows out of
rest is its own mirror image: p is a series of sines of k n T. The first equation is integrated term
by term, the second holds at equidistant points, and Newton's method finds the torque and all sines
but the first, whose amplitude is given: a response that folds back over the torque is a function of
it. Derivatives for Newton are taken by complex steps.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.pendulum.model import Pendulum, terms
from vibecalc.response.pendulum.order import largest_swing, tuning_order

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

    torque: WithError
    swing: WithError
    largest: WithError
    acceleration: WithError


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
    found = []
    for rough, good in zip(coarse, fine, strict=True):
        kept = good[..., : rough.shape[-1]]
        doubt = 2.0 * np.abs(kept - rough) + 64.0 * UNIT_ROUNDOFF * np.abs(kept)
        size = np.max(np.abs(kept), axis=-1, keepdims=True)
        found.append(WithError(kept, doubt + 256.0 * UNIT_ROUNDOFF * size))
    torque, sines, largest, acceleration = found
    return SteadyMotion(_single(torque), sines, _single(largest), acceleration)


def _single(value: WithError) -> WithError:
    return WithError(value.value[..., 0], value.error[..., 0])


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
    rest = terms(frame.pendulum, np.zeros(()))
    carried = frame.rotor + rest.carried
    tuned, forced = tuning_order(frame.pendulum).value, frame.order
    stiff = rest.swing * (tuned**2 - forced**2) + (forced * rest.coupling) ** 2 / carried
    return np.asarray(-first * stiff / (rest.coupling * carried))


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
    wave, place, number = np.arange(1, count + 1), _places(count), frame.order
    sine, cosine = np.sin(np.outer(wave, place)), np.cos(np.outer(wave, place))
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
    largest = _largest(sines, np.linspace(0.0, np.pi, 16 * count + 1), wave)
    if np.any(largest >= np.broadcast_to(largest_swing(frame.pendulum), largest.shape)):
        raise NumericalFailure("the swing leaves the path of the pendulum within the cycle")
    # the mean speed is an angle over its time; the ends of the half cycle count half
    slowness = 1.0 / np.sqrt(square)
    inner = np.sum(slowness[..., 1:-1], axis=-1) + 0.5 * (slowness[..., 0] + slowness[..., -1])
    mean_square = np.square((count + 1) / inner[..., None])
    acceleration = (2.0 / (count + 1)) * (rate @ np.sin(np.outer(wave, place)).T)
    return torque / mean_square, sines, largest, acceleration / mean_square


def _places(count: int) -> FloatArray:
    return np.asarray(np.pi * np.arange(count + 2) / (count + 1))


def _largest(sines: FloatArray, fine: FloatArray, wave: FloatArray) -> FloatArray:
    """Largest magnitude over the half cycle, by Newton from the largest of many points."""
    course = np.abs(sines @ np.sin(np.outer(wave, fine)))
    place = fine[np.argmax(course, axis=-1)][..., None]
    for _ in range(6):
        slope = np.sum(sines * wave * np.cos(wave * place), axis=-1, keepdims=True)
        bend = -np.sum(sines * wave**2 * np.sin(wave * place), axis=-1, keepdims=True)
        there = bend != 0.0
        place = place - np.where(there, slope / np.where(there, bend, 1.0), 0.0)
    return np.asarray(np.abs(np.sum(sines * np.sin(wave * place), axis=-1, keepdims=True)))
