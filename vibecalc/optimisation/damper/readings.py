"""What counts of a state: half range of each section, heat and travel of the damper, with slopes.

Rows: 0 to e - 1 the weighted sections, e the heat in the dashpot, e + 1 and e + 2 the travel of the
ring, hub ahead and hub behind: two readings, since each is smooth where they change places.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.optimisation.damper.half_range import extremes
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.relative import System
from vibecalc.optimisation.damper.states import solution_error, states


class Readings(NamedTuple):
    """Values (s,), derivatives (s,) by speed and (s, 3) by the logarithms of J, k, c of the damper.

    Angles of the extremes are held in the derivatives: there the signal is stationary. `phase`
    (s, 2) of the crest and the trough that were read, in periods of the cycle of 2 pi; travel has
    one extreme, twice, and heat none (zeros).
    """

    value: FloatArray
    by_speed: FloatArray
    by_damper: FloatArray
    phase: FloatArray


def section_factor(system: System, speed: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Weighted factors (s, m, e) from twist to what is read, and their derivatives by speed."""
    problem = system.problem
    order = np.asarray(problem.order, dtype=float)
    weight = np.asarray(problem.weight, dtype=float)
    shape = (speed.size, order.size, weight.size)
    if problem.quantity == "twist":
        return np.broadcast_to(weight + 0j, shape), np.zeros(shape, dtype=complex)
    line = problem.line
    rate = 1j * order[:, None] * line.damping * weight
    held = weight * line.stiffness * (1.0 + 1j * line.loss_factor)
    return held + speed[:, None, None] * rate, np.broadcast_to(rate, shape)


def readings(
    system: System, damper: Damper, speed: FloatArray, row: IntArray,
    near: FloatArray | None = None,
) -> Readings:  # fmt: skip
    """Row row[i] at speed[i], all arrays (s,): of the highest crest and the lowest trough.

    With phases `near` (s, 2) the crest and the trough next to them are read instead.
    """
    sections = system.twist.shape[0]
    found = states(system, damper, speed)
    here = np.arange(speed.size)
    value, slope = np.empty(speed.size), np.empty((4, speed.size))
    phases = np.zeros((speed.size, 2))
    heat = row == sections
    travel = row > sections
    order = np.asarray(system.problem.order, dtype=float)
    relative, change = found.value[..., -1], found.slope[..., -1]
    if np.any(heat):
        power, by = _heat(relative[heat], change[:, heat], speed[heat][:, None] * order, damper)
        by[3] += 2.0 * power / speed[heat]
        value[heat], slope[:, heat] = power, by
    other = ~heat
    if np.any(other):
        own = np.where(row < sections, row, 0)
        factor, rate = section_factor(system, speed)
        factor, rate = factor[here, :, own], rate[here, :, own]
        twist = np.einsum("smn,sn->sm", found.value, system.twist[own])
        amplitude = factor * twist
        by_all = factor * np.einsum("dsmn,sn->dsm", found.slope, system.twist[own])
        by_all[3] += rate * twist
        amplitude = np.where(travel[:, None], relative, amplitude)[other]
        by_all = np.where(travel[:, None], change, by_all)[:, other]
        phase, _ = extremes(amplitude, system.harmonic, None if near is None else near[other])
        high, low = np.moveaxis(np.exp(1j * phase[..., None] * system.harmonic), 1, 0)
        upper = (row[other] == sections + 1)[:, None]
        wave = np.where(travel[other][:, None], np.where(upper, high, -low), 0.5 * (high - low))
        value[other] = np.sum((amplitude * wave).real, axis=-1)
        slope[:, other] = np.sum((by_all * wave).real, axis=-1)
        used = np.where(upper, phase[:, :1], phase[:, 1:])
        phases[other] = np.where(travel[other][:, None], used, phase)
    return Readings(value, slope[3], slope[:3].T, phases)


def signals(system: System, damper: Damper, speed: FloatArray, row: IntArray) -> ComplexArray:
    """Amplitudes (s, m) of the course that row[i], a section or a travel, reads at speed[i]."""
    value = states(system, damper, speed).value
    own = np.where(row < system.twist.shape[0], row, 0)
    factor = section_factor(system, speed)[0][np.arange(speed.size), :, own]
    section = factor * np.einsum("smn,sn->sm", value, system.twist[own])
    amplitude: ComplexArray = np.where(
        (row < system.twist.shape[0])[:, None], section, value[..., -1]
    )
    return amplitude


def _heat(
    relative: ComplexArray, change: ComplexArray, w: FloatArray, damper: Damper
) -> tuple[FloatArray, FloatArray]:
    """Mean power (s,) of the dashpot and its slopes (4, s), at fixed w in the last but one."""
    share = damper.damping * w**2
    power = 0.5 * np.sum(share * np.abs(relative) ** 2, axis=-1)
    by = np.sum(share * (np.conj(relative) * change).real, axis=-1)
    by[2] += power
    return power, by


def reading_error(system: System, damper: Damper, speed: FloatArray, row: IntArray) -> FloatArray:
    """Round-off (s,) of `readings`: that of each order is bounded, and of orders the squares add.

    Every order is a solution of its own, so that their roundings know nothing of each other.
    """
    sections = system.twist.shape[0]
    error = solution_error(system, damper, speed)
    value = np.abs(states(system, damper, speed).value)
    here = np.arange(speed.size)
    own = np.minimum(row, sections - 1)
    factor = np.abs(section_factor(system, speed)[0][here, :, own])
    size = np.abs(system.twist[own])
    of_section = factor * np.einsum("smn,sn->sm", error, size)
    rounding = 8.0 * UNIT_ROUNDOFF * factor * np.einsum("smn,sn->sm", value, size)
    of_heat = damper.damping * (speed[:, None] * np.asarray(system.problem.order)) ** 2
    of_heat = of_heat * value[..., -1] * (error[..., -1] + 8.0 * UNIT_ROUNDOFF * value[..., -1])
    of_travel = error[..., -1] + 8.0 * UNIT_ROUNDOFF * value[..., -1]
    picked = np.where((row == sections)[:, None], of_heat, of_section + rounding)
    each = np.where((row > sections)[:, None], of_travel, picked)
    total: FloatArray = np.sqrt(np.sum(np.square(each), axis=-1))
    return total
