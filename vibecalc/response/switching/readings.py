"""What is read off the motion: displacements, forces through the mounts, energies.

Columns, for a body of k coordinates (usually 6, x y z rx ry rz): `DISPLACEMENT` k displacements
of the reference point (m, rad), then k forces and couples through the mounts on the ground
(N, N m), then kinetic, potential and total energy (J).
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.cycle_peak import Peak, cycle_peak, vector_cycle_peak
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.response.switching.course import Motion
from vibecalc.response.switching.steady import Steady
from vibecalc.response.switching.system import ModalSystem


class Jet(NamedTuple):
    """Readings (times, columns) with their first and second derivative by time."""

    value: np.ndarray
    rate: np.ndarray
    bend: np.ndarray


class Columns(NamedTuple):
    """Where the readings of a body with k coordinates stand."""

    displacement: slice
    mount_force: slice
    kinetic: int
    potential: int
    energy: int


def columns(coordinates: int = 6) -> Columns:
    """Columns of the readings of a body."""
    k = coordinates
    return Columns(slice(0, k), slice(k, 2 * k), 2 * k, 2 * k + 1, 2 * k + 2)


def momentum_rows(system: ModalSystem) -> np.ndarray:
    """M V = inverse of V^T (coordinates, modes): brings modal forces back to coordinates."""
    rows: np.ndarray = np.linalg.inv(system.shape).T
    return rows


def read(system: ModalSystem, motion: Motion) -> Jet:
    """All readings of a motion.

    The mounts push the ground with K x + C x' = M V (w^2 q + 2 zeta w q'), the modal damping being
    the mounts'. Energies are half the sums of q'^2 and of w^2 q^2.
    """
    place, frequency = system.shape.T, system.frequency
    damping, back = 2.0 * system.damping_ratio * frequency, momentum_rows(system).T
    q, v, a, j = motion
    w2 = frequency**2
    kinetic = (0.5 * v**2, v * a, a**2 + v * j)
    potential = (0.5 * w2 * q**2, w2 * q * v, w2 * (v**2 + q * a))
    jets = []
    for n, (lower, upper) in enumerate(((q, v), (v, a), (a, j))):
        energies = [np.sum(kinetic[n], axis=-1), np.sum(potential[n], axis=-1)]
        parts = [lower @ place, (w2 * lower + damping * upper) @ back]
        jets.append(np.column_stack([*parts, *energies, energies[0] + energies[1]]))
    return Jet(*jets)


def linear_rows(system: ModalSystem) -> tuple[np.ndarray, np.ndarray]:
    """Factors (columns, modes) of q and of q' in displacements and mount forces."""
    back, frequency = momentum_rows(system), system.frequency
    on_velocity = np.zeros_like(back)
    return (
        np.concatenate([system.shape, back * frequency**2]),
        np.concatenate([on_velocity, back * 2.0 * system.damping_ratio * frequency]),
    )


def read_bound(system: ModalSystem, size: np.ndarray) -> np.ndarray:
    """Largest readings (..., columns) of motions whose modes have the sizes (..., modes).

    The size of a mode is sqrt(q'^2 + w^2 q^2). A mode that nothing holds must be at rest.
    """
    on_place, on_velocity = linear_rows(system)
    held = system.frequency > 0.0
    place = np.where(held, on_place / np.where(held, system.frequency, 1.0), 0.0)
    linear = size @ np.hypot(place, on_velocity).T
    energy = np.repeat(0.5 * np.sum(size**2, axis=-1, keepdims=True), 3, axis=-1)
    return np.concatenate([linear, energy], axis=-1)


def read_error(
    system: ModalSystem, value: np.ndarray, error: np.ndarray, largest: np.ndarray
) -> np.ndarray:
    """Absolute errors (..., columns) of readings, from those of the sizes of the modes (modes,).

    `largest` (modes,) are the sizes themselves; what rounding adds to the sums grows with them.
    """
    bound = read_bound(system, error + 8.0 * EPSILON * largest)
    spread = np.sqrt(2.0 * np.sum(error**2)) * np.sqrt(np.abs(value[..., -3:]))
    energy = bound[..., -3:] + spread + 8.0 * EPSILON * np.abs(value[..., -3:])
    linear = np.broadcast_to(bound[..., :-3], value[..., :-3].shape)
    return np.concatenate([linear, energy], axis=-1)


def steady_peaks(
    system: ModalSystem, steady: Steady, orders: np.ndarray, speed: float
) -> WithError:
    """Largest magnitudes (columns,) of all readings over a cycle of the steady motion."""
    rates = 1j * (orders * speed)[:, None] * steady.amplitude
    size = np.sum(np.hypot(system.frequency * np.abs(steady.amplitude), np.abs(rates)), axis=0)
    value, _, rounding = reading_peaks(system, steady.amplitude, rates, orders)
    return WithError(value, read_error(system, value, steady.error, size) + rounding)


def reading_peaks(
    system: ModalSystem, amplitude: np.ndarray, rate: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Peaks over a cycle from modal amplitudes of q and q' (..., orders, modes).

    Returns values, crank angles and the errors of rounding, each (..., columns).
    """
    on_place, on_velocity = linear_rows(system)
    linear = cycle_peak(np.swapaxes(amplitude @ on_place.T + rate @ on_velocity.T, -1, -2), orders)
    energies = [_energy_peak(system, amplitude, rate, orders, which) for which in range(3)]
    parts = zip(linear, *energies, strict=True)
    value, angle, error = (
        np.concatenate([first, *(one[..., None] for one in rest)], axis=-1)
        for first, *rest in parts
    )
    return value, angle, error


def reading_peak(
    system: ModalSystem,
    amplitude: np.ndarray,
    rate: np.ndarray,
    orders: np.ndarray,
    column: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Values and crank angles (...,) of one column of `reading_peaks`."""
    count = 2 * len(system.shape)
    if column >= count:
        peak = _energy_peak(system, amplitude, rate, orders, column - count)
    else:
        on_place, on_velocity = (rows[column] for rows in linear_rows(system))
        peak = cycle_peak(amplitude @ on_place + rate @ on_velocity, orders)
    return peak.value, peak.angle


def _energy_peak(
    system: ModalSystem, amplitude: np.ndarray, rate: np.ndarray, orders: np.ndarray, which: int
) -> Peak:
    """Peaks of kinetic, potential or total energy: half the squared length of a vector."""
    strained = system.frequency * amplitude
    parts = ([rate], [strained], [rate, strained])[which]
    vector = np.swapaxes(np.concatenate(parts, axis=-1), -1, -2)
    length = vector_cycle_peak(vector, orders)
    error = length.value * length.error + 0.5 * length.error**2
    return Peak(0.5 * length.value**2, length.angle, error)
