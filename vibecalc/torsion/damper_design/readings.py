"""What counts of a state: half range of each section, heat and travel of the damper."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.damper_design.problem import Damper, System, solve, states, torque_at

# ----------------------------------------------------------------------------
# Highest and lowest place in a cycle of many signals of integer harmonics, refined in batch.
# ----------------------------------------------------------------------------

SAMPLES_PER_HARMONIC = 16
_NEWTON_STEPS = 5
#: from farther away
_MORE_STEPS = 8


def extremes(
    amplitude: ComplexArray, harmonic: IntArray, near: FloatArray | None = None
) -> FloatArray:
    """Phases (r, 2) of the highest and the lowest point of rows (r, m), Re sum_m X_m exp(i h_m p).

    With phases `near` (r, 2) it is the crest uphill of the first and the trough downhill of the
    second, be there higher and lower ones or not.
    """
    if near is None:
        found = synthesis(harmonic, amplitude)
        near = np.stack([found.highest_angle, found.lowest_angle], axis=-1)
    # the trough is the crest of the negative
    up, down = (
        _climbed(sign * amplitude, harmonic, start[:, None], _MORE_STEPS)[0]
        for sign, start in ((1.0, near[:, 0]), (-1.0, near[:, 1]))
    )
    return np.hstack([up, down])


def crests(amplitude: ComplexArray, harmonic: IntArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Phases (r, most) and values (r, most) of the highest crests; -infinity where there is none.

    Phases may lie a little beyond [0, 2 pi).
    """
    value = sampled(amplitude, harmonic, SAMPLES_PER_HARMONIC)
    around = np.concatenate([value[:, -1:], value, value[:, :1]], axis=-1)
    peak = (value >= around[:, :-2]) & (value > around[:, 2:])
    height = np.where(peak, -value, np.inf)
    rank = np.argpartition(height, most, axis=-1)[:, :most]
    rank = np.take_along_axis(rank, np.argsort(np.take_along_axis(height, rank, -1), -1), -1)
    start = 2.0 * np.pi / value.shape[-1] * rank
    phase, refined = _climbed(amplitude, harmonic, start, _NEWTON_STEPS)
    refined = np.where(np.take_along_axis(peak, rank, axis=-1), refined, -np.inf)
    return phase, refined


def sampled(amplitude: ComplexArray, harmonic: IntArray, per_harmonic: int) -> FloatArray:
    """Values (..., samples) over the cycle of rows (..., m)."""
    highest = int(harmonic.max())
    count = per_harmonic * highest
    spectrum = np.zeros((*amplitude.shape[:-1], highest + 1), dtype=complex)
    for column, h in enumerate(harmonic):
        spectrum[..., h] += amplitude[..., column]
    value: FloatArray = np.fft.irfft(spectrum, count, axis=-1) * (0.5 * count)
    return value


def _climbed(
    amplitude: ComplexArray, harmonic: IntArray, start: FloatArray, steps: int
) -> tuple[FloatArray, FloatArray]:
    """Crests uphill of phases (r, q): Newton's method, sample by sample where the signal is hollow.

    Phases (r, q) and values (r, q).
    """
    phase = start
    sample = 2.0 * np.pi / (SAMPLES_PER_HARMONIC * int(harmonic.max()))
    number = harmonic.astype(float)
    slopes = np.stack([number, np.square(number)], axis=-1)
    in_sequence = harmonic[0] == 1 and harmonic[-1] == len(harmonic)
    for _ in range(steps):
        if in_sequence:
            # powers of one number take a tenth of the time of as many exponentials
            turn = np.repeat(np.exp(1j * phase)[..., None], len(harmonic), axis=-1)
            np.multiply.accumulate(turn, axis=-1, out=turn)
        else:
            turn = np.exp(1j * phase[..., None] * harmonic)
        wave = amplitude[:, None, :] * turn
        first, second = -(wave.imag @ slopes[:, 0]), -(wave.real @ slopes[:, 1])
        step = np.divide(-first, second, out=np.sign(first) * sample, where=second < 0.0)
        phase = phase + np.clip(step, -sample, sample)
    value = np.sum((amplitude[:, None, :] * np.exp(1j * phase[..., None] * harmonic)).real, -1)
    return phase, value


# ----------------------------------------------------------------------------
# What counts of a state: half range of each section, heat and travel of the damper, with slopes.
#
# Rows: 0 to e - 1 the weighted sections, e the heat in the dashpot, e + 1 and e + 2 the travel of
# the ring, hub ahead and hub behind: two readings, since each is smooth where they change places.
# ----------------------------------------------------------------------------


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
    near: FloatArray | None = None, by_damper: bool = True,
) -> Readings:  # fmt: skip
    """Row row[i] at speed[i], all arrays (s,): of the highest crest and the lowest trough.

    With phases `near` (s, 2) the crest and the trough next to them are read instead. Without
    `by_damper` there are no derivatives by it (s, 0).
    """
    sections = system.twist.shape[0]
    state = states(system, damper, speed, by_damper)
    here = np.arange(speed.size)
    value, slope = np.empty(speed.size), np.empty((len(state.slope), speed.size))
    phases = np.zeros((speed.size, 2))
    heat = row == sections
    travel = row > sections
    order = np.asarray(system.problem.order, dtype=float)
    relative, change = state.value[..., -1], state.slope[..., -1]
    if np.any(heat):
        power, by = _heat(relative[heat], change[:, heat], speed[heat][:, None] * order, damper)
        by[-1] += 2.0 * power / speed[heat]
        value[heat], slope[:, heat] = power, by
    other = ~heat
    if np.any(other):
        section = np.where(row < sections, row, 0)
        factor, rate = section_factor(system, speed)
        factor, rate = factor[here, :, section], rate[here, :, section]
        twist = np.einsum("smn,sn->sm", state.value, system.twist[section])
        amplitude = factor * twist
        by_all = factor * np.einsum("dsmn,sn->dsm", state.slope, system.twist[section])
        by_all[-1] += rate * twist
        amplitude = np.where(travel[:, None], relative, amplitude)[other]
        by_all = np.where(travel[:, None], change, by_all)[:, other]
        phase = extremes(amplitude, system.harmonic, None if near is None else near[other])
        high, low = np.moveaxis(np.exp(1j * phase[..., None] * system.harmonic), 1, 0)
        upper = (row[other] == sections + 1)[:, None]
        wave = np.where(travel[other][:, None], np.where(upper, high, -low), 0.5 * (high - low))
        value[other] = np.sum((amplitude * wave).real, axis=-1)
        slope[:, other] = np.sum((by_all * wave).real, axis=-1)
        used = np.where(upper, phase[:, :1], phase[:, 1:])
        phases[other] = np.where(travel[other][:, None], used, phase)
    return Readings(value, slope[-1], slope[:-1].T, phases)


def signals(system: System, damper: Damper, speed: FloatArray, row: IntArray) -> ComplexArray:
    """Amplitudes (s, m) of the course that row[i], a section or a travel, reads at speed[i]."""
    value = states(system, damper, speed).value
    section_row = np.where(row < system.twist.shape[0], row, 0)
    factor = section_factor(system, speed)[0][np.arange(speed.size), :, section_row]
    section = factor * np.einsum("smn,sn->sm", value, system.twist[section_row])
    amplitude: ComplexArray = np.where(
        (row < system.twist.shape[0])[:, None], section, value[..., -1]
    )
    return amplitude


def _heat(
    relative: ComplexArray, change: ComplexArray, w: FloatArray, damper: Damper
) -> tuple[FloatArray, FloatArray]:
    """Mean power (s,) of the dashpot and its slopes (4, s) or (1, s), at fixed w in the last."""
    share = damper.damping * w**2
    power = 0.5 * np.sum(share * np.abs(relative) ** 2, axis=-1)
    by = np.sum(share * (np.conj(relative) * change).real, axis=-1)
    by[2:3] += power
    return power, by


def reading_error(
    system: System, damper: Damper, speed: FloatArray, row: IntArray, phase: FloatArray
) -> FloatArray:
    """Round-off (s,) of `readings` at phases (s, 2), by those of a line moved by last bits."""

    def kernel(
        mass: FloatArray, loss: FloatArray, spring: ComplexArray, damper: Damper
    ) -> FloatArray:
        moved = system._replace(mass=mass, loss=loss, spring=spring)
        return readings(moved, damper, speed, row, phase, by_damper=False).value

    found: Bounded = with_errors(kernel, system.mass, system.loss, system.spring, damper)
    return found.errors


# ----------------------------------------------------------------------------
# Crests and troughs that all but reach the highest and the lowest of their cycle.
#
# The half range of a cycle is the largest of (crest - trough) / 2 over all its pairs. Each pair is
# smooth in speed and damper; their maximum has an edge where two change places. A search that sees
# only the highest pair runs into that edge blindly, so that close ones are named here.
# ----------------------------------------------------------------------------

#: share of the half range below which a pair is left out
_CLOSE = 0.02
#: crests (and troughs) examined, pairs kept of one cycle
_CRESTS, _PAIRS = 6, 4


def rivals(
    system: System, damper: Damper, speed: FloatArray, row: IntArray, phase: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Other pairs of readings row[i] at speed[i], read at phase[i] (s, 2): which i, phases (q, 2).

    Heat has none; travel has one extreme, which stands for both.
    """
    sections = system.twist.shape[0]
    which: list[int] = []
    starts: list[list[float]] = []
    waves = np.flatnonzero(row != sections)
    if waves.size:
        amplitude = signals(system, damper, speed[waves], row[waves])
        up, high = crests(amplitude, system.harmonic, _CRESTS)
        down, low = crests(-amplitude, system.harmonic, _CRESTS)
    for i, place in enumerate(waves.tolist()):
        if row[place] > sections:
            at, height = (up[i], high[i]) if row[place] == sections + 1 else (down[i], low[i])
            pair, value = np.stack([at, at], axis=-1), height
        else:
            pair = np.stack(np.meshgrid(up[i], down[i], indexing="ij"), axis=-1).reshape(-1, 2)
            value = (0.5 * (high[i][:, None] + low[i])).ravel()
        order = np.argsort(-value, kind="stable")
        order = order[value[order] >= (1.0 - _CLOSE) * value[order[0]]]
        pairs = 0
        for one in order[: _PAIRS + 1]:
            away = np.abs(np.angle(np.exp(1j * (pair[one] - phase[place]))))
            if np.any(away > 1e-6) and pairs < _PAIRS:
                which.append(place)
                starts.append(pair[one].tolist())
                pairs += 1
    return np.array(which, dtype=np.int64), np.array(starts, dtype=float).reshape(-1, 2)


# ----------------------------------------------------------------------------
# Readings of very many springs and dashpots: each changes the line by one rank.
#
# With a nominal damper s0 the hub turns by r0 against the ring, and a unit torque between them
# turns it by h. Another damper s, with d = s - s0, gives r0 / (1 + d h), and every unknown u
# becomes u0 - g d r0 / (1 + d h): no new solution. The bare line (s0 = 0) would be singular on its
# own frequencies; a nominal damper in the middle of the bounds keeps all of its orders finite.
# ----------------------------------------------------------------------------

MAP_SAMPLES = 6
_BLOCK = 1 << 21


class NominalTable(NamedTuple):
    """At s speeds and m orders with the nominal damper: `section` (s, m, e) what is read of each
    section, `section_unit` the same for a unit torque between hub and ring, `relative` and
    `relative_unit` (s, m) for hub less ring."""

    nominal: Damper
    speed: FloatArray
    frequency: FloatArray
    section: ComplexArray
    section_unit: ComplexArray
    relative: ComplexArray
    relative_unit: ComplexArray


def table(system: System, nominal: Damper, speed: FloatArray) -> NominalTable:
    """Solve once at speeds (s,), for all springs and dashpots on a ring of this inertia."""
    w = speed[:, None] * np.asarray(system.problem.order, dtype=float)
    matrix = system.dynamic(nominal, w)
    right = np.zeros((*matrix.shape[:-1], 2), dtype=complex)
    right[..., 0] = torque_at(system.problem.torque, speed)[0] @ system.angle
    right[..., -1, 1] = 1.0
    loaded, unit = np.moveaxis(solve(matrix, right), -1, 0)
    factor = section_factor(system, speed)[0]
    return NominalTable(
        nominal, speed, w, factor * (loaded @ system.twist.T), factor * (unit @ system.twist.T),
        loaded[..., -1], unit[..., -1],
    )  # fmt: skip


def amplitudes(
    responses: NominalTable, stiffness: FloatArray, damping: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Sections (b, s, m, e) and hub less ring (b, s, m) for dampers (b,)."""
    change = (stiffness - responses.nominal.stiffness)[:, None, None] + 1j * (
        damping - responses.nominal.damping
    )[:, None, None] * responses.frequency
    loop = 1.0 + change * responses.relative_unit
    relative = responses.relative / loop
    taken = responses.section_unit * (change / loop * responses.relative)[..., None]
    return responses.section - taken, relative


def map_readings(
    system: System, responses: NominalTable, stiffness: FloatArray, damping: FloatArray
) -> FloatArray:
    """Readings (b, s, e + 3) of dampers (b,), from samples of the cycle.

    They miss a few percent of the highest orders: good enough to find basins and brackets;
    `readings` has what is reported.
    """
    speeds, _, sections = responses.section.shape
    result = np.empty((stiffness.size, speeds, sections + 3))
    for part in _parts(system, responses, stiffness.size):
        section, relative = amplitudes(responses, stiffness[part], damping[part])
        result[part, :, :sections] = _ranges(np.moveaxis(section, -1, -2), system)[0]
        result[part, :, sections] = _heats(responses, damping[part], relative)
        _, result[part, :, sections + 1], result[part, :, sections + 2] = _ranges(relative, system)
    return result


def map_largest(
    system: System, responses: NominalTable, stiffness: FloatArray, damping: FloatArray
) -> FloatArray:
    """Largest section, heat and travel (b, 3) over all speeds, of `map_readings` of dampers (b,).

    Cycles are sampled where the sum of their orders reaches the largest found so far.
    """
    result = np.empty((stiffness.size, 3))
    for part in _parts(system, responses, stiffness.size):
        section, relative = amplitudes(responses, stiffness[part], damping[part])
        section = np.moveaxis(section, -1, -2)
        rows = section.reshape(len(section), -1, section.shape[-1])
        result[part, 0] = _largest(rows, system, _HALF)
        result[part, 1] = np.max(_heats(responses, damping[part], relative), axis=1)
        result[part, 2] = _largest(relative, system, _ENDS)
    return result


def _parts(system: System, responses: NominalTable, count: int) -> list[slice]:
    """Blocks of so many dampers."""
    speeds, _, sections = responses.section.shape
    highest = int(system.harmonic.max())
    block = max(1, _BLOCK // (speeds * (sections + 1) * MAP_SAMPLES * highest))
    return [slice(start, start + block) for start in range(0, count, block)]


def _heats(responses: NominalTable, damping: FloatArray, relative: ComplexArray) -> FloatArray:
    """In the dashpots (b, s), W."""
    square = np.sum(np.abs(responses.frequency * relative) ** 2, axis=-1)
    return np.asarray(0.5 * damping[:, None] * square)


#: of the sum of orders, what a parabola through samples may have at most
_OVER = 1.05
#: of what `_ranges` gives, the half range, and both ends
_HALF, _ENDS = slice(0, 1), slice(1, 3)


def _largest(amplitude: ComplexArray, system: System, which: slice) -> FloatArray:
    """The largest (b,) of some of `_ranges` among rows (b, r, m)."""

    def read(rows: ComplexArray) -> FloatArray:
        return np.asarray(np.max(_ranges(rows, system)[which], axis=0))

    most = _OVER * np.abs(amplitude).sum(axis=-1)
    best = read(amplitude[np.arange(len(most)), np.argmax(most, axis=1)])
    damper, row = np.nonzero(most > best[:, None])
    np.maximum.at(best, damper, read(amplitude[damper, row]))
    return best


def _ranges(amplitude: ComplexArray, system: System) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Half range, highest, minus lowest value: parabolas through the best of sampled cycles."""
    value = sampled(amplitude, system.harmonic, MAP_SAMPLES)
    high, low = _peak(value), -_peak(-value)
    return 0.5 * (high - low), high, -low


def _peak(value: FloatArray) -> FloatArray:
    best = np.argmax(value, axis=-1)[..., None]
    count = value.shape[-1]
    middle, left, right = (
        np.take_along_axis(value, (best + shift) % count, axis=-1)[..., 0] for shift in (0, -1, 1)
    )
    bend = np.maximum(2.0 * middle - left - right, 1e-300)
    peak: FloatArray = middle + 0.125 * (right - left) ** 2 / bend
    return peak
