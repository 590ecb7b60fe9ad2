"""What a run-up evaluates: mount forces and couples over crank speed, with their slopes."""

from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.isolation.pitch import Pitch, pitch_dynamic_stiffness
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.forced import UndrivenModes, dynamics, response

# ----------------------------------------------------------------------------
# Readings of the body's motion: forces of the mounts on the ground, couple over a lever.
# ----------------------------------------------------------------------------


class Readout(NamedTuple):
    """Rows that are read as (spring + i w damper) X, each array (rows, components, coordinates).

    A row of three components is a vector, whose length counts; `uncertainty` is the relative error
    of the entries.
    """

    spring: np.ndarray
    damper: np.ndarray
    uncertainty: float


def pitch_readout(
    pitch: Pitch,
    lever: float | np.ndarray,
    position: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Readout:
    """Couple over lever in the first row, then the vertical force of each mount on the ground."""
    passing = -position * (stiffness + 1j * structural)
    couple = (pitch.stiffness + 1j * pitch.structural) / lever
    spring = _rows_of_pitch(couple, passing)
    damper = _rows_of_pitch(pitch.damping / lever, -position * damping)
    return Readout(spring, damper, pitch.rounding + 8.0 * UNIT_ROUNDOFF)


def _rows_of_pitch(first: np.ndarray, others: np.ndarray) -> np.ndarray:
    """A number (...) and those of the mounts (..., mounts) as rows (..., rows, 1, 1)."""
    points = np.broadcast_shapes(np.shape(first), others.shape[:-1])
    parts = np.asarray(first)[..., None], others
    rows = [np.broadcast_to(part, (*points, part.shape[-1])) for part in parts]
    return np.concatenate(rows, axis=-1)[..., None, None]


def distinct(readout: Readout) -> tuple[Readout, np.ndarray]:
    """Leave out rows that repeat another up to sign; also tell which one each row is (rows,).

    Equal supports at the same distance on either side feel the same force at opposite times. Of
    many machines (..., rows, components, coordinates) those that repeat another in each of them.
    """
    *points, count, _, _ = readout.spring.shape
    spring, damper = (part.reshape(*points, count, -1) for part in (readout.spring, readout.damper))
    entries = np.concatenate([spring.real, spring.imag, damper], axis=-1)
    leading = np.argmax(entries != 0.0, axis=-1)[..., None]
    negative = np.take_along_axis(entries, leading, -1) < 0.0
    signed = np.moveaxis(entries * np.where(negative, -1.0, 1.0), -2, 0)
    number_of: dict[bytes, int] = {}
    # -0.0 and 0.0 are one
    rows = [(row + 0.0).tobytes() for row in signed]
    which = np.array([number_of.setdefault(row, len(number_of)) for row in rows])
    first = [int(np.argmax(which == number)) for number in range(len(number_of))]
    few = readout._replace(
        spring=readout.spring[..., first, :, :], damper=readout.damper[..., first, :, :]
    )
    return few, which


# ----------------------------------------------------------------------------
# Rows of a readout as functions of crank speed, with their slopes: what a run-up examines.
# ----------------------------------------------------------------------------

#: stands for what was not asked for
EMPTY = np.zeros(0)


class Jet(NamedTuple):
    """Harmonics of the rows at some speeds, each array (speeds, rows, components, orders).

    `slope` and `curvature` are the first and second derivative by crank speed; errors are
    absolute. What was not asked for has no size.
    """

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


class HarmonicsAt(Protocol):
    """Harmonics of some rows at crank speeds (speeds,), as much of the jet as is asked for."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet: ...


class BodyMotion(NamedTuple):
    """Coordinates (speeds, orders, coordinates), derivatives by speed, errors."""

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


def read(readout: Readout, order: np.ndarray, rate: np.ndarray, motion: BodyMotion) -> Jet:
    """Apply the readout to a motion and its derivatives, as far as they are there.

    The readout may have an axis of speeds of its own, each being that of another machine.
    """
    *_, rows, components, width = readout.spring.shape
    spring, damper = (
        part.reshape(*part.shape[:-3], rows * components, width).mT
        for part in (readout.spring, readout.damper)
    )
    frequency = rate[..., None]
    each_order = order[:, None]

    def laid_out(flat: np.ndarray) -> np.ndarray:
        """(speeds, orders, rows * components) to (speeds, rows, components, orders)."""
        return flat.swapaxes(1, 2).reshape(len(flat), rows, components, len(order))

    damped = motion.value @ damper
    value = motion.value @ spring + 1j * frequency * damped
    error = slope = slope_error = curvature = EMPTY
    if motion.slope is not EMPTY:
        damped_slope = motion.slope @ damper
        slope = motion.slope @ spring + 1j * (frequency * damped_slope + each_order * damped)
        curvature = motion.curvature @ spring + 1j * (
            frequency * (motion.curvature @ damper) + 2.0 * each_order * damped_slope
        )
        slope, curvature = laid_out(slope), laid_out(curvature)
    if motion.error is not EMPTY:
        spring_size, damper_size = np.abs(spring), np.abs(damper)
        spread = motion.error + readout.uncertainty * np.abs(motion.value)
        damped_spread = spread @ damper_size
        error = laid_out(spread @ spring_size + frequency * damped_spread)
        if motion.slope is not EMPTY:
            steeper = motion.slope_error + readout.uncertainty * np.abs(motion.slope)
            slope_error = steeper @ spring_size + frequency * (steeper @ damper_size)
            slope_error = laid_out(slope_error + each_order * damped_spread)
    return Jet(laid_out(value), error, slope, slope_error, curvature)


# ----------------------------------------------------------------------------
# What the orders that are not kept may add to the rows of a run-up.
# ----------------------------------------------------------------------------


def with_left_out(
    rows: HarmonicsAt, left_out: HarmonicsAt, factor: float | np.ndarray
) -> HarmonicsAt:
    """Rows whose errors count the harmonics of `left_out` too, `factor` times.

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
        return jet._replace(error=error, slope_error=slope_error)

    return harmonics_at


def _added(error: np.ndarray, dropped: np.ndarray, factor: float | np.ndarray) -> np.ndarray:
    total = error.copy()
    total[..., -1] += np.asarray(factor)[..., None, None] * np.abs(dropped).sum(axis=-1)
    return total


# ----------------------------------------------------------------------------
# Rows of the pitch model as functions of crank speed, with their slopes.
# ----------------------------------------------------------------------------


def pitch_rows(
    pitch: Pitch,
    readout: Readout,
    orders: np.ndarray,
    couple: Bounded,
    left_out: np.ndarray | bool = False,
) -> HarmonicsAt:
    """Rows of the pitch model under couples (orders,) per squared crank speed, N m s^2.

    `left_out` (orders,) as in `angle_harmonics`. All may have an axis of speeds, each being that of
    another machine.
    """
    order = np.asarray(orders, dtype=float)
    per_square = couple.value
    inertia, damping = (np.asarray(part)[..., None] for part in (pitch.inertia, pitch.damping))

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        column = speed[:, None]
        rate = column * order
        system = pitch_dynamic_stiffness(pitch, rate)
        flexibility = np.where(left_out, 0.0, 1.0 / np.where(left_out, 1.0, system.value))
        angle = column * column * per_square * flexibility
        error = slope = slope_error = curvature = EMPTY
        if slopes:
            turn = order * (1j * damping - 2.0 * inertia * rate)
            load_slope = 2.0 * column * per_square
            slope = flexibility * (load_slope - turn * angle)
            bent = 2.0 * per_square + 2.0 * inertia * order * order * angle
            curvature = flexibility * (bent - 2.0 * turn * slope)
        if errors:
            size, gain = np.abs(angle), np.abs(flexibility)
            load_error = column * column * couple.error
            error = gain * (size * system.error + load_error) + 16.0 * UNIT_ROUNDOFF * size
        if slopes and errors:
            uncertainty = np.abs(turn) * error + np.abs(slope) * system.error
            uncertainty = uncertainty + 2.0 * column * couple.error
            terms = np.abs(load_slope) + np.abs(turn) * size
            slope_error = gain * (uncertainty + (pitch.rounding + 16.0 * UNIT_ROUNDOFF) * terms)
        motion = BodyMotion(angle, error, slope, slope_error, curvature)
        each = BodyMotion(*(EMPTY if part is EMPTY else part[..., None] for part in motion))
        return read(readout, order, rate, each)

    return harmonics_at


# ----------------------------------------------------------------------------
# Rows of a rigid body on its mounts as functions of crank speed, with their slopes.
# ----------------------------------------------------------------------------


class Couple(NamedTuple):
    """A couple (speeds, orders) in N m with its error; slope and curvature are by crank speed."""

    value: np.ndarray
    error: np.ndarray
    slope: np.ndarray
    slope_error: np.ndarray
    curvature: np.ndarray


class CoupleAt(Protocol):
    """A couple at crank speeds (speeds,), as much of it as is asked for."""

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Couple: ...


def body_rows(
    matrices: Matrices,
    readout: Readout,
    orders: np.ndarray,
    force: Bounded,
    undriven: UndrivenModes | None = None,
    couple_at: CoupleAt | None = None,
    about: np.ndarray | None = None,
) -> HarmonicsAt:
    """Rows of a rigid body under forces (orders, 6) per squared crank speed, N s^2 and N m s^2.

    `couple_at` is added, a couple about the unit vector `about` (6,), as a function of the speed.
    Matrices, readout and forces may have an axis of speeds, each being that of another machine.
    """
    order = np.asarray(orders, dtype=float)
    axis = np.zeros(force.value.shape[-1]) if about is None else about

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        system = dynamics(matrices, rate, undriven)
        column = speed[:, None, None]
        load = column * column * force.value
        added = None if couple_at is None else couple_at(speed, slopes, errors)
        if added is not None:
            load = load + added.value[..., None] * axis
        error = slope = slope_error = curvature = EMPTY
        if errors:
            load_error = column * column * force.error + 4.0 * UNIT_ROUNDOFF * np.abs(load)
            if added is not None:
                load_error = load_error + added.error[..., None] * np.abs(axis)
            value, error = response(system, load, load_error)
        else:
            value = _apply(system.inverse, load)
        if slopes:
            turn = order[:, None, None] * (
                1j * matrices.damping[..., None, :, :]
                - 2.0 * rate[..., None, None] * matrices.mass[..., None, :, :]
            )
            load_slope = 2.0 * column * force.value
            load_bend = 2.0 * force.value
            if added is not None:
                load_slope = load_slope + added.slope[..., None] * axis
                load_bend = load_bend + added.curvature[..., None] * axis
            slope = _apply(system.inverse, load_slope - _apply(turn, value))
            bent = load_bend + 2.0 * np.square(order)[:, None] * (value @ matrices.mass.mT)
            curvature = _apply(system.inverse, bent - 2.0 * _apply(turn, slope))
        if slopes and errors:
            uncertainty = _apply(np.abs(turn), error + 32.0 * UNIT_ROUNDOFF * np.abs(value))
            uncertainty = (
                uncertainty + _apply(system.error, np.abs(slope)) + 2.0 * column * force.error
            )
            uncertainty = uncertainty + 16.0 * UNIT_ROUNDOFF * np.abs(load_slope)
            if added is not None:
                uncertainty = uncertainty + added.slope_error[..., None] * np.abs(axis)
            slope_error = _apply(np.abs(system.inverse), uncertainty)
            slope_error = slope_error + 16.0 * UNIT_ROUNDOFF * np.abs(slope)
        motion = BodyMotion(value, error, slope, slope_error, curvature)
        return read(readout, order, rate, motion)

    return harmonics_at


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product
