"""Readings of very many springs and dashpots: each changes the line by one rank.

With a nominal damper s0 the hub turns by r0 against the ring, and a unit torque between them turns
it by h. Another damper s, with d = s - s0, gives r0 / (1 + d h), and every unknown u becomes
u0 - g d r0 / (1 + d h): no new solution. The bare line (s0 = 0) would be singular on its own
frequencies; a nominal damper in the middle of the bounds keeps all of its orders finite.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.optimisation.damper.half_range import sampled
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.readings import section_factor
from vibecalc.optimisation.damper.relative import System
from vibecalc.optimisation.damper.speed_torque import torque_at
from vibecalc.optimisation.damper.states import solution_error, solve

MAP_SAMPLES = 6
_BLOCK = 1 << 21


class Table(NamedTuple):
    """At s speeds and m orders with the nominal damper: `section` (s, m, e) what is read of each
    section, `section_unit` the same for a unit torque between hub and ring, `relative` and
    `relative_unit` (s, m) for hub less ring; `..._error` bounds on their round-off."""

    nominal: Damper
    speed: FloatArray
    frequency: FloatArray
    section: ComplexArray
    section_unit: ComplexArray
    relative: ComplexArray
    relative_unit: ComplexArray
    section_error: FloatArray
    relative_error: FloatArray


def table(system: System, nominal: Damper, speed: FloatArray, *, bounded: bool = True) -> Table:
    """Solve once at speeds (s,), for all springs and dashpots on a ring of this inertia.

    Without `bounded` no errors are formed, and they are infinite: a search needs none.
    """
    w = speed[:, None] * np.asarray(system.problem.order, dtype=float)
    matrix = system.dynamic(nominal, w)
    right = np.zeros((*matrix.shape[:-1], 2), dtype=complex)
    right[..., 0] = torque_at(system.problem.torque, speed)[0] @ system.angle
    right[..., -1, 1] = 1.0
    loaded, unit = np.moveaxis(solve(matrix, right), -1, 0)
    factor = section_factor(system, speed)[0]
    own, of_section = np.full(w.shape, np.inf), np.full(factor.shape, np.inf)
    if bounded:
        error = solution_error(system, nominal, speed)
        own, of_section = error[..., -1], np.abs(factor) * (error @ np.abs(system.twist.T))
    return Table(
        nominal, speed, w, factor * (loaded @ system.twist.T), factor * (unit @ system.twist.T),
        loaded[..., -1], unit[..., -1],
        of_section, own,
    )  # fmt: skip


def amplitudes(
    found: Table, stiffness: FloatArray, damping: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Sections (b, s, m, e), hub less ring (b, s, m) for dampers (b,), and an error of sections.

    The error (b, s, m, e) grows by what cancels in 1 + d h and in the difference.
    """
    section, relative, taken, loop = _changed(found, stiffness, damping)
    grown = 1.0 + np.abs(loop) / np.abs(1.0 + loop)
    scale = found.relative_error / np.maximum(np.abs(found.relative), 1e-300)
    lost = (scale + 16.0 * UNIT_ROUNDOFF) * grown**2
    error = found.section_error * grown[..., None] + lost[..., None] * np.abs(taken)
    return section, relative, error


def _changed(
    found: Table, stiffness: FloatArray, damping: FloatArray
) -> tuple[ComplexArray, ComplexArray, ComplexArray, ComplexArray]:
    """Sections, hub less ring, what was taken from the nominal sections, and d h."""
    change = (stiffness - found.nominal.stiffness)[:, None, None] + 1j * (
        damping - found.nominal.damping
    )[:, None, None] * found.frequency
    loop = change * found.relative_unit
    share = change / (1.0 + loop)
    relative = found.relative / (1.0 + loop)
    taken = found.section_unit * (share * found.relative)[..., None]
    return found.section - taken, relative, taken, loop


def map_readings(
    system: System, found: Table, stiffness: FloatArray, damping: FloatArray
) -> FloatArray:
    """Readings (b, s, e + 3) of dampers (b,), from samples of the cycle.

    They miss a few percent of the highest orders: good enough to find basins and brackets;
    `readings` has what is reported.
    """
    speeds, _, sections = found.section.shape
    highest = int(system.harmonic.max())
    block = max(1, _BLOCK // (speeds * (sections + 1) * MAP_SAMPLES * highest))
    result = np.empty((stiffness.size, speeds, sections + 3))
    for start in range(0, stiffness.size, block):
        part = slice(start, start + block)
        section, relative, _, _ = _changed(found, stiffness[part], damping[part])
        result[part, :, :sections] = _ranges(np.moveaxis(section, -1, -2), system)[0]
        result[part, :, sections] = 0.5 * damping[part, None] * np.sum(
            np.abs(found.frequency * relative) ** 2, axis=-1
        )  # fmt: skip
        _, result[part, :, sections + 1], result[part, :, sections + 2] = _ranges(relative, system)
    return result


def _ranges(amplitude: ComplexArray, system: System) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Half range, highest, minus lowest value: parabolas through the best of sampled cycles."""
    value = sampled(amplitude, system.harmonic, MAP_SAMPLES)
    high, low = _summit(value), -_summit(-value)
    return 0.5 * (high - low), high, -low


def _summit(value: FloatArray) -> FloatArray:
    best = np.argmax(value, axis=-1)[..., None]
    count = value.shape[-1]
    middle, left, right = (
        np.take_along_axis(value, (best + shift) % count, axis=-1)[..., 0] for shift in (0, -1, 1)
    )
    bend = np.maximum(2.0 * middle - left - right, 1e-300)
    summit: FloatArray = middle + 0.125 * (right - left) ** 2 / bend
    return summit
