"""What a run-up evaluates: mount forces and couples over crank speed, with their slopes."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import (
    Linear,
    UndrivenModes,
    dynamics_by_order,
    each_order,
    law,
    response,
)
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.spectral import SpectralSystem

# ----------------------------------------------------------------------------
# Readings of the body's motion: forces of the mounts on the ground, couple over a lever.
# ----------------------------------------------------------------------------


class Readout(NamedTuple):
    """Rows that are read as (still + w rising) X, each array (rows, components, coordinates).

    A row of several components is a vector, whose length counts; `uncertainty` is the relative
    error of the entries.
    """

    still: np.ndarray
    rising: np.ndarray
    uncertainty: float

    def rows(self, *place: object) -> "Readout":
        """Some of the rows, by an index of the arrays without components and coordinates."""
        pick: Any = (*place, slice(None), slice(None))
        return self._replace(still=self.still[pick], rising=self.rising[pick])


def joined_rows(first: Readout, others: Readout) -> Readout:
    """Rows of both, one after the other; either may lack the axis of the machines."""

    def both(*pair: np.ndarray) -> np.ndarray:
        points = np.broadcast_shapes(*(part.shape[:-3] for part in pair))
        rows = [np.broadcast_to(part, (*points, *part.shape[-3:])) for part in pair]
        return np.concatenate(rows, axis=-3)

    return Readout(
        both(first.still, others.still),
        both(first.rising, others.rising),
        max(first.uncertainty, others.uncertainty),
    )


def distinct(readout: Readout) -> tuple[list[int], np.ndarray]:
    """Rows that repeat none before them, up to sign, and which one of these each is (rows,).

    Equal supports at the same distance on either side feel the same force at opposite times. Of
    many machines (..., rows, components, coordinates) those that repeat another in each of them.
    """
    both = np.broadcast_arrays(readout.still, readout.rising)
    flat = [part.reshape(*part.shape[:-2], -1) for part in both]
    entries = np.concatenate([part for one in flat for part in (one.real, one.imag)], axis=-1)
    leading = np.argmax(entries != 0.0, axis=-1)[..., None]
    negative = np.take_along_axis(entries, leading, -1) < 0.0
    signed = np.moveaxis(entries * np.where(negative, -1.0, 1.0), -2, 0)
    number_of: dict[bytes, int] = {}
    # -0.0 and 0.0 are one
    rows = [(row + 0.0).tobytes() for row in signed]
    which = np.array([number_of.setdefault(row, len(number_of)) for row in rows])
    first = [int(np.argmax(which == number)) for number in range(len(number_of))]
    return first, which


# ----------------------------------------------------------------------------
# Rows of a readout as functions of crank speed, with their slopes: what a run-up examines.
# ----------------------------------------------------------------------------

#: stands for what was not asked for
EMPTY = np.zeros(0)


class Jet(NamedTuple):
    """Harmonics of the rows at some speeds, each array (speeds, rows, components, orders).

    Or of the motion of a body (speeds, orders, coordinates), or of a couple (speeds, orders).

    `slope` and `curvature` are the first and second derivative by crank speed; errors are
    absolute. `turn_error` (speeds, rows, components) is what orders that are left out do to the
    derivative by crank angle. What was not asked for has no size.
    """

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray
    turn_error: np.ndarray = EMPTY


class HarmonicsAt(Protocol):
    """Harmonics of some rows, or of a couple, at crank speeds (speeds,), as much of the jet as is
    asked for."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet: ...


class Factors(NamedTuple):
    """What mounts pass on of `still` at the frequency of each order, (speeds, orders, rows).

    With the first and second derivative by frequency.
    """

    value: np.ndarray
    first: np.ndarray
    second: np.ndarray


def read(
    readout: Readout,
    order: np.ndarray,
    rate: np.ndarray,
    motion: Jet,
    factors: Factors | None = None,
) -> Jet:
    """Apply the readout to a motion and its derivatives, as far as they are there.

    The readout may have an axis of speeds of its own, each being that of another machine. With P =
    f(w) still + w rising at w = n v, and ' for d/dv:

        r = P X,    r' = P' X + P X',    r'' = P'' X + 2 P' X' + P X''
    """
    still, rising = readout.still[..., None, :, :, :], readout.rising[..., None, :, :, :]
    frequency, n = rate[..., None, None, None], order[:, None, None, None]
    value, first, second = (
        (1.0, 0.0, 0.0) if factors is None else (part[..., None, None] for part in factors)
    )
    passing, turn = value * still + frequency * rising, n * (first * still + rising)

    def applied(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
        """Matrices (..., orders, rows, components, f) to (speeds, rows, components, orders)."""
        return np.moveaxis((matrix @ vector[..., None, :, None])[..., 0], 1, -1)

    error = slope = slope_error = curvature = EMPTY
    if motion.slope is not EMPTY:
        slope = applied(passing, motion.slope) + applied(turn, motion.value)
        curvature = applied(passing, motion.curvature) + 2.0 * applied(turn, motion.slope)
        if factors is not None:
            curvature = curvature + applied(np.square(n) * second * still, motion.value)
    if motion.error is not EMPTY:
        size, spread = np.abs(passing), motion.error + readout.uncertainty * np.abs(motion.value)
        error = applied(size, spread)
        if motion.slope is not EMPTY:
            steeper = motion.slope_error + readout.uncertainty * np.abs(motion.slope)
            slope_error = applied(size, steeper) + applied(np.abs(turn), spread)
    return Jet(applied(passing, motion.value), error, slope, slope_error, curvature)


# ----------------------------------------------------------------------------
# What the orders that are not kept may add to the rows of a run-up.
# ----------------------------------------------------------------------------


def with_left_out(
    rows: HarmonicsAt, left_out: HarmonicsAt, factor: float | np.ndarray, beyond: np.ndarray
) -> HarmonicsAt:
    """Rows whose errors count the harmonics of `left_out`, orders `beyond`, too, `factor` times.

    The magnitudes of the orders left out, and of their slopes by speed, are added to the errors of
    the last order kept. So they enter the error of every peak, and of the speed of a maximum,
    which moves with the slope of what was left out. A factor of 0 leaves nothing out; it may be
    one for each speed (speeds,).
    """

    if np.all(factor == 0.0):
        return rows

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        jet = rows(speed, slopes, errors)
        if not errors:
            return jet
        dropped = left_out(speed, slopes)
        error = _added(jet.error, dropped.value, factor)
        if not slopes:
            return jet._replace(error=error)
        slope_error = _added(jet.slope_error, dropped.slope, factor)
        turn_error = _sized(dropped.value * beyond, factor)
        return jet._replace(error=error, slope_error=slope_error, turn_error=turn_error)

    return harmonics_at


def _added(error: np.ndarray, dropped: np.ndarray, factor: float | np.ndarray) -> np.ndarray:
    total = error.copy()
    total[..., -1] += _sized(dropped, factor)
    return total


def _sized(dropped: np.ndarray, factor: float | np.ndarray) -> np.ndarray:
    return np.asarray(np.asarray(factor)[..., None, None] * np.abs(dropped).sum(axis=-1))


# ----------------------------------------------------------------------------
# Rows of a rigid body on its mounts as functions of crank speed, with their slopes.
# ----------------------------------------------------------------------------


def body_rows(
    matrices: Linear,
    readout: Readout,
    orders: np.ndarray,
    force: Bounded,
    undriven: UndrivenModes | None = None,
    couple_at: HarmonicsAt | None = None,
    about: np.ndarray | None = None,
    spectral: SpectralSystem | None = None,
    passed_on: bool = True,
) -> HarmonicsAt:
    """Rows of a body under forces (orders, f) per squared crank speed, N s^2 and N m s^2.

    `couple_at` is added, a couple about the vector `about` (f,), as a function of the speed.
    Matrices, readout and forces may have an axis of speeds, each being that of another machine.
    Where stiffness follows the frequency, `spectral` has it, and rows that mounts have `passed_on`
    are those of each mount, `still` being what its factors multiply.

    With D = K* - w^2 M, w = n v at speed v and order n, and ' for d/dv:

        D X' = F' - D' X,    D X'' = F'' - D'' X - 2 D' X'
    """
    order = np.asarray(orders, dtype=float)
    axis = np.zeros(force.value.shape[-1]) if about is None else about
    none = Jet(*np.zeros((5, 1, 1)))
    _, rising = law(matrices.stiffness, matrices.structural, matrices.damping)
    mass, rising = matrices.mass[..., None, :, :], rising[..., None, :, :]

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        at_rate = each_order(matrices) if spectral is None else spectral.at(rate)
        system = dynamics_by_order(at_rate, rate, undriven)
        column, n = speed[:, None, None], order[:, None, None]
        added = none if couple_at is None else couple_at(speed, slopes, errors)
        load = column * column * force.value + added.value[..., None] * axis
        error = slope = slope_error = curvature = EMPTY
        if errors:
            load_error = column * column * force.error + 4.0 * UNIT_ROUNDOFF * np.abs(load)
            load_error = load_error + added.error[..., None] * np.abs(axis)
            value, error = response(system, load, load_error)
        else:
            value = _apply(system.inverse, load)
        if slopes:
            turn, bend = rising - 2.0 * rate[..., None, None] * mass, -2.0 * mass
            if spectral is not None:
                turn, bend = turn + spectral.slope(rate, 1), bend + spectral.slope(rate, 2)
            turn, bend = n * turn, np.square(n) * bend
            load_slope = 2.0 * column * force.value + added.slope[..., None] * axis
            load_bend = 2.0 * force.value + added.curvature[..., None] * axis
            slope = _apply(system.inverse, load_slope - _apply(turn, value))
            bent = load_bend - _apply(bend, value) - 2.0 * _apply(turn, slope)
            curvature = _apply(system.inverse, bent)
        if slopes and errors:
            uncertainty = _apply(np.abs(turn), error + 32.0 * UNIT_ROUNDOFF * np.abs(value))
            uncertainty = (
                uncertainty + _apply(system.error, np.abs(slope)) + 2.0 * column * force.error
            )
            uncertainty = uncertainty + 16.0 * UNIT_ROUNDOFF * np.abs(load_slope)
            uncertainty = uncertainty + added.slope_error[..., None] * np.abs(axis)
            slope_error = _apply(np.abs(system.inverse), uncertainty)
            slope_error = slope_error + 16.0 * UNIT_ROUNDOFF * np.abs(slope)
        motion = Jet(value, error, slope, slope_error, curvature)
        factors = None
        if spectral is not None and passed_on:
            factors = Factors(*(spectral.spectrum(rate, derivative) for derivative in range(3)))
        return read(readout, order, rate, motion, factors)

    return harmonics_at


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
