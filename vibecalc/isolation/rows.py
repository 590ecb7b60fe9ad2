"""What a run-up evaluates: mount forces and couples over crank speed, with their slopes."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.linear import (
    Linear,
    UndrivenModes,
    dynamics_by_order,
    each_order,
    law,
    response,
)
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

    points = np.broadcast_shapes(first.still.shape[:-3], others.still.shape[:-3])

    def both(*pair: np.ndarray) -> np.ndarray:
        rows = [np.broadcast_to(part, (*points, *part.shape[-3:])) for part in pair]
        return np.concatenate(rows, axis=-3)

    uncertainty = max(first.uncertainty, others.uncertainty)
    return Readout(both(first.still, others.still), both(first.rising, others.rising), uncertainty)


def distinct(readout: Readout) -> tuple[np.ndarray, np.ndarray]:
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
    rows = signed.reshape(len(signed), -1)
    same = np.all(rows[:, None] == rows, axis=-1)
    first, which = np.unique(np.argmax(same, axis=1), return_inverse=True)
    return first, which


# ----------------------------------------------------------------------------
# Rows of a readout as functions of crank speed, with their slopes: what a run-up examines.
# ----------------------------------------------------------------------------

#: stands for what was not asked for
EMPTY = np.zeros(0)


class Jet(NamedTuple):
    """Harmonics of the rows at some speeds, each array (speeds, rows, components, orders).

    Or a couple (speeds, orders).

    `slope` and `curvature` are the first and second derivative by crank speed; errors are
    absolute. `turn_error` (speeds, rows, components) is what orders that are left out do to the
    derivative by crank angle. What was not asked for has no size.
    """

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray = EMPTY
    slope_error: np.ndarray = EMPTY
    curvature: np.ndarray = EMPTY
    turn_error: np.ndarray = EMPTY


class HarmonicsAt(Protocol):
    """Harmonics of some rows, or of a couple, at crank speeds (speeds,): with derivatives where
    `slopes` are asked for, and with what is left out in the errors where `errors` are."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet: ...


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

    def sized(dropped: np.ndarray) -> np.ndarray:
        return np.asarray(np.asarray(factor)[..., None, None] * np.abs(dropped).sum(axis=-1))

    def added(error: np.ndarray, dropped: np.ndarray) -> np.ndarray:
        total = error.copy()
        total[..., -1] += sized(dropped)
        return total

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        jet = rows(speed, slopes, errors)
        if not errors:
            return jet
        dropped = left_out(speed, slopes)
        jet = jet._replace(error=added(jet.error, dropped.value))
        if not slopes:
            return jet
        slope_error = added(jet.slope_error, dropped.slope)
        return jet._replace(slope_error=slope_error, turn_error=sized(dropped.value * beyond))

    return harmonics_at


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
    are those of each mount, `still` being multiplied by its factors f(w).

    With D = K* - w^2 M, P = f(w) still + w rising at w = n v, and ' for d/dv:

        D X = F,    D X' = F' - D' X,     D X'' = F'' - D'' X - 2 D' X'
        r = P X,    r' = P' X + P X',     r'' = P'' X + 2 P' X' + P X''
    """
    order, axis = np.asarray(orders, dtype=float), 0.0 if about is None else about
    none = Jet(*np.zeros((5, 1, 1)))
    _, rising = law(matrices.stiffness, matrices.structural, matrices.damping)
    mass, rising = matrices.mass[..., None, :, :], rising[..., None, :, :]
    still, moving = readout.still[..., None, :, :, :], readout.rising[..., None, :, :, :]

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        at_rate = each_order(matrices) if spectral is None else spectral.at(rate)
        system = dynamics_by_order(at_rate, rate, undriven)
        column, n = speed[:, None, None], order[:, None, None]
        factor: list[Any] = [1.0, 0.0, 0.0]
        if spectral is not None and passed_on:
            factor = [spectral.spectrum(rate, k)[..., None, None] for k in range(3)]
        passing = factor[0] * still + rate[..., None, None, None] * moving
        added = none if couple_at is None else couple_at(speed, slopes, errors)
        load = force * (column * column) + _about(added.value, added.error, axis)
        motion = response(system, *load)
        value, error = _read(passing, motion, readout.uncertainty)
        if not slopes:
            return Jet(value, error)
        turn, bend = rising - 2.0 * rate[..., None, None] * mass, -2.0 * mass
        if spectral is not None:
            turn, bend = turn + spectral.slope(rate, 1), bend + spectral.slope(rate, 2)
        turn, bend = n * turn, np.square(n) * bend
        load = force * (2.0 * column) + _about(added.slope, added.slope_error, axis)
        slope = response(system, *(load - (rounded(turn, 24) @ motion[..., None])[..., 0]))
        push = 2.0 * force.value + added.curvature[..., None] * axis
        push = push - _apply(bend, motion.value) - 2.0 * _apply(turn, slope.value)
        curved = _apply(system.inverse, push)
        turned = n[..., None] * (factor[1] * still + moving)
        first = _read(passing, slope, readout.uncertainty)
        first = first + _read(turned, motion, readout.uncertainty)
        second = _rows(passing, curved) + 2.0 * _rows(turned, slope.value)
        if spectral is not None:
            second = second + _rows(np.square(n[..., None]) * factor[2] * still, motion.value)
        return Jet(value, error, first.value, first.error, second)

    return harmonics_at


def _about(value: np.ndarray, error: np.ndarray, axis: Any) -> Bounded:
    """Couples (speeds, orders) as loads about an axis (f,)."""
    return Bounded(value[..., None] * axis, error[..., None] * np.abs(axis))


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product


def _rows(matrix: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Matrices (..., orders, rows, components, f) by motions (speeds, orders, f), orders last."""
    return np.moveaxis((matrix @ motion[..., None, :, None])[..., 0], 1, -1)


def _read(matrix: np.ndarray, motion: Bounded, uncertainty: float) -> Bounded:
    """The same with errors, that of the matrix a share of its entries."""
    off = motion.error + uncertainty * np.abs(motion.value)
    return Bounded(_rows(matrix, motion.value), _rows(np.abs(matrix), off))
