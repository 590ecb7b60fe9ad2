"""What the torque of an engine's cylinders does to its body, about the crankshaft."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from vibecalc.isolation.rows import HarmonicsAt, Jet
from vibecalc.numerics.bounded import Bounded, reshaped, rounded, where
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.modes import Modes

if TYPE_CHECKING:
    from vibecalc.torsion.line import Line

# ----------------------------------------------------------------------------
# What the torque of an engine's cylinders does to its body, about the crankshaft.
#
# Torques are positive in the crank's sense of rotation, right-handed about `axis`, and so are the
# couples on the body. The side thrusts of the pistons turn the body with minus the torque T that
# they give the crankshaft, by gas and inertia. What else holds depends on where the driven machine
# stands:
#
# - elsewhere: its stator turns the ground, not the body. -T remains, its mean too. What damps a
#   station of the line against the ground is taken to stand on the ground.
# - on the body, without a shaft line: a stator follows no pulsation and gives the mean back; -T
#   remains without its mean. A rotor of finite inertia leaves a share of it
#   (`excitation.inertia_torque.rotor_share`), wherever the driven machine stands.
# - on the body, with a shaft line of finite inertia: the body gives the line all its torques (of
#   the cylinders, of the loads, of what damps a station against the body), so that it feels minus
#   the change of the line's angular momentum. With loads that do not alternate and no damping
#   against the body that is -T again, however elastic the line: the torque goes into its speed.
#   Gears turn some of the inertia the other way round, or faster. There is no mean: the stator
#   gives it back.
# ----------------------------------------------------------------------------

#: some of the orders
Part: TypeAlias = slice | np.ndarray
#: orders beyond twice the highest against those up to there: forces that fall as order^-2 or faster
TAIL = 2.0
#: relative step of speed of numerical derivatives, and the slowest speed of a line, rad/s
STEP = 1e-4
SLOWEST = 1e-2
#: share of the largest modal force from which on an order is said to drive a mode
DRIVES = 1e-3


def line_transfer(line: "Line", spin_inertia: Bounded, frequency: np.ndarray) -> Bounded:
    """Couple on the body for a unit torque on each freedom, (..., m, n) complex, and its error.

    Parameters
    ----------
    line
        n freedoms referred to the crankshaft; its bearings, gears and loads are on the body.
    spin_inertia
        (n,) in kg m^2: own inertia times own speed ratio, summed over what turns with a freedom.
        Times the referred angular velocity it is angular momentum, signed as the crank turns.
    frequency
        (..., m) in rad/s, above 0; leading axes of the line go with it.

    As -d/dt sum h phi' is w^2 h.X and the dynamic stiffness symmetric, one solution under the
    torques w^2 h is the transfer from every freedom. It is -1 everywhere for a line without gears
    and without damping or springs to the body, also where an undamped one has no other answer.

    Raises
    ------
    NumericalFailure
        A frequency is a natural frequency of a line without damping.
    """
    from vibecalc.torsion.forced import forced

    rate = np.asarray(frequency, dtype=float)
    losses = (line.absolute_damping, line.ground_stiffness, line.damping, line.loss_factor)
    turns_as_one = np.allclose(spin_inertia.value, line.inertia, rtol=4.0 * EPSILON, atol=0.0)
    if turns_as_one and not any(np.any(one) for one in losses):
        shape = (*rate.shape, line.inertia.shape[-1])
        return Bounded(np.full(shape, -1.0 + 0.0j), np.zeros(shape))
    spin = np.stack([*spin_inertia]).reshape(2, *(1,) * rate.ndim, -1)
    response = forced(line, rate, np.square(rate)[..., None] * spin)
    value, uncertainty = response.angle
    error = 2.0 * response.error[0] + response.error[1] + np.max(np.abs(uncertainty), axis=-1)
    error = error + 16.0 * EPSILON * np.max(np.abs(value), axis=-1)
    return Bounded(value, np.broadcast_to(error[..., None], value.shape))


def couple_on_body(torque: Bounded, transfer: Bounded | None = None, share: float = 1.0) -> Bounded:
    """Couple (..., m) on the body, N m complex, of the torques (..., c, m) of its cylinders.

    `transfer` (m, c) belongs to the freedoms of the cylinders; without one it is minus `share`.
    """
    if transfer is None:
        return (torque * rounded(-share, 32)).sum(-2)
    return (reshaped(transfer, lambda part: np.swapaxes(part, -1, -2)) * torque).sum(-2)


def linear_couple(
    by_speed: Callable[[np.ndarray], Bounded], low: float, high: float
) -> HarmonicsAt:
    """Couple (speeds, m) of a law (speeds,) to (speeds, m) that is linear between two speeds."""
    span, ends = high - low, by_speed(np.array([low, high]))
    slope = (ends.value[1] - ends.value[0]) / span
    uncertainty = ends.error.sum(0) / span

    def couple_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        share = ((speed - low) / span)[:, None]
        value, error = ends[0] * (1.0 - share) + ends[1] * share
        empty = np.zeros_like(value)
        return Jet(value, error, empty + slope, empty.real + uncertainty, empty)

    return couple_at


def couple_by_differences(
    by_speed: Callable[[np.ndarray], Bounded], low: float, high: float
) -> HarmonicsAt:
    """Couple of any law (speeds,) to (speeds, m) between two speeds, derivatives by differences.

    The differences are central, and next to the ends those of the nearest place that has room for
    them: the law is asked at no speed beyond `low` and `high`. The derivatives only lead a search
    for maxima: what they are off is in the error of the slope.
    """

    def couple_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        at = np.maximum(speed, SLOWEST)
        value, error = by_speed(at)
        if not slopes:
            return Jet(value, error)
        step = np.minimum(STEP * at, 0.25 * (high - low))
        middle = np.clip(at, low + 2.0 * step, high - 2.0 * step)
        far_before, before, here, after, far_after = (
            by_speed(np.clip(middle + steps * step, low, high)) for steps in range(-2, 3)
        )
        step, moved = step[:, None], (at - middle)[:, None]
        slope, uncertainty = (after - before) / (2.0 * step)
        wider = (far_after.value - far_before.value) / (4.0 * step)
        curvature = (after.value - 2.0 * here.value + before.value) / np.square(step)
        uncertainty = uncertainty + np.abs(wider - slope)
        return Jet(value, error, slope + curvature * moved, uncertainty, curvature)

    return couple_at


def nearest_driven(
    shapes: Modes, loads: Bounded, half_order: np.ndarray, speed: float
) -> tuple[np.ndarray, Bounded]:
    """Of each mode the order nearest to it, of those of the loads (m, 6) that drive it, 0 if none
    does; and the frequency of that order over the natural frequency, less 1, or infinite.

    An order drives a mode if its modal force is no rounding, and a thousandth of the largest one.
    """
    force = loads @ shapes.bounded_shape
    size = np.abs(force.value)
    drives = (size > 4.0 * force.error) & (size >= DRIVES * size.max(axis=0))
    ratio = (half_order * speed)[:, None] / shapes.bounded_frequency
    away = np.where(drives, np.abs(ratio.value - 1.0), np.inf)
    place = np.argmin(away, axis=0)
    modes = np.arange(len(place))
    none = np.isinf(away[place, modes])
    margin = where(none, np.inf, ratio[place, modes] - 1.0)
    return np.where(none, 0.0, half_order[place]), margin
