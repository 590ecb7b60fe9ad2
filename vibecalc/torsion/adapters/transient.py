"""A change in time of a shaft line, next to the steady vibration on the way."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, concatenate, maximum, where
from vibecalc.numerics.rounding import EPSILON, FloatArray, distinct, first_of_largest
from vibecalc.numerics.synthesis import Cycles, over_cycle
from vibecalc.torsion.adapters.motion import (
    TORQUE,
    actual_per_referred,
    gear_shares,
    mean_torques,
    readings_of,
)
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.adapters.transient_motion import Equivalent, Journey, journey, running
from vibecalc.torsion.asked import has_friction_damper
from vibecalc.torsion.critical_speeds import by_machine
from vibecalc.torsion.forced import twist_and_torque
from vibecalc.torsion.line_part_tables import FatigueLine
from vibecalc.torsion.question_tables import CycleCounting
from vibecalc.torsion.study_results import PASSAGES, TRANSIENT
from vibecalc.torsion.transient.march import (
    TransientRun,
    TransientSystem,
    static_state,
    transient,
    transient_system,
)
from vibecalc.torsion.transient.motion import Stretch, mean_law
from vibecalc.torsion.transient.trace import (
    FINER,
    Peaks,
    Samples,
    Strength,
    Trace,
    Windows,
    equivalent_number,
    extremes,
    largest_swings,
    miner_sum,
    points_in,
    rainflow_cycles,
    range_table,
    samples,
    section_peaks,
    sliding,
    slope_below,
    traces,
    window_amplitudes,
)

# ----------------------------------------------------------------------------
# Adapter: a change in time of a shaft line, next to the steady vibration on the way.
# ----------------------------------------------------------------------------

#: tolerance of the march: nothing that is read off it is reported more sharply
_RTOL = 1e-7
#: times of the envelope, and speeds of the steady curve before its peaks are added
_TIMES, _SPEEDS = 200, 1201
#: share of a speed that is rounding
_ROUNDED = 1e-12
#: share by which the frequency of a loss factor may be off the highest point, in five digits
_PLACED = 6e-5
_ENVELOPE = ("speed", "torque_low", "torque_high", "half_range", "quasi_steady")


@dataclass(frozen=True)
class Change:
    """A run of a case, with the traces of its sections; `windows` of its envelope, where asked."""

    scene: Scene
    setup: Setup
    path: Journey
    run: TransientRun
    seen: list[Trace]
    windows: Windows | None

    @property
    def ratio(self) -> FloatArray:
        """Of the own shafts of the sections (e,): referred torques over their own."""
        return self.setup.shaft.section_ratio

    @property
    def held(self) -> TransientSystem:
        """The line with its clutch, or ring on dry friction, holding."""
        return transient_system(self.path.line, self.path.reaction)

    @property
    def cycle(self) -> float:
        """Of the machine, in rad."""
        return self.setup.drive.firing.cycle

    def emit(self, name: str, value: Any, error: Any = 0.0, **axes: Any) -> None:
        """A result by section where no axes are given."""
        axes = axes or {"section": self.setup.shaft.section_names}
        self.scene.emit(TRANSIENT + name, value, error, axes)

    def emit_own(self, name: str, value: FloatArray, error: FloatArray) -> None:
        """Sizes of referred torques (e,) as those of the own shafts."""
        size = np.abs(self.ratio)
        self.emit(name, value / size, error / size)


def run_torsion_transient(scene: Scene) -> None:
    """Emit everything for [response.torsion.transient]."""
    setup = build_setup(running(scene.case))
    options = setup.torsion.transient
    assert options is not None
    rtol = max(_RTOL, scene.case.accuracy.rtol)
    passes = options.kind in PASSAGES
    if setup.model.over_speed is not None and passes:
        scene.warn(
            "speed-dependent damping is kept constant during the change, at its value for the mean "
            "speed; the steady vibration compared with it uses the value at each speed"
        )
    if options.kind == "clutch_in":
        from vibecalc.torsion.adapters.transient_motion import run_clutch

        path, run = run_clutch(scene, setup, options, rtol)
    else:
        path = journey(setup, scene.case.machine, options)
        if has_friction_damper(scene.case):
            run = _run_dragged(scene, setup, path, rtol)
        else:
            run = transient(
                path.line, path.order, path.stretches, path.speed, start=path.start,
                reaction=path.reaction, rtol=rtol,
            )  # fmt: skip
    windows = _windows(scene, setup, run)
    times = [np.array(path.moving), run.course.time, *(windows or ())]
    change = Change(scene, setup, path, run, traces(run, np.concatenate(times)), windows)
    if path.equivalent is not None:
        _emit_equivalent(change, path.equivalent)
    peaks = section_peaks(run, change.seen)
    _emit_peaks(change, peaks)
    _emit_gears(change)
    _emit_envelope(change)
    if passes:
        _emit_passage(change)
        _emit_supply(change)
    elif path.ends:
        _emit_steps(change, peaks)
    worst = int(np.argmax(peaks.peak / np.abs(change.ratio)))
    _emit_history(change, worst, float(peaks.time[worst]))
    _emit_waterfalls(change, worst)
    if options.counting is not None:
        emit_counting(scene, setup, options.counting, change.seen)
    scene.cite(
        "exact propagation of the line over steps with the torque as a polynomial, crank speed "
        "prescribed; envelope from states inside the steps",
        "transient",
        "matrix exponential and its integrals in Legendre polynomials; "
        "docs/theory_torsion_studies.md",
    )


def _run_dragged(scene: Scene, setup: Setup, path: Journey, rtol: float) -> TransientRun:
    """The run of a line whose ring slips; emits what its friction does."""
    from vibecalc.torsion.adapters.friction_damper import friction_damper
    from vibecalc.torsion.transient.clutch import Clutch
    from vibecalc.torsion.transient.friction_damper import drag

    line = scene.case.machine.shaft_line
    assert line is not None
    given = friction_damper(line)
    assert given is not None and given[1].friction_torque is not None
    damper = setup.shaft.dampers[given[0]]
    torque = given[1].friction_torque * abs(float(setup.shaft.station_ratio[damper.station]))
    ring = np.arange(path.line.inertia.size) == damper.ring
    clutch = Clutch(damper.element, torque, 0.0, ring, 0.0)
    found = drag(
        path.line, path.order, clutch, path.stretches, path.speed, path.start, path.reaction, rtol
    )
    # errors of the torque, as energies, in the velocities of both ends
    ends = path.line.inertia[[damper.carrier, damper.ring]]
    slack = float(found.run.torque_error[damper.element])
    slack /= float(np.sqrt(path.line.stiffness[damper.element] * np.min(ends)))
    late = 2.0 * (1 + found.locks) * slack * float(np.max(ends)) / torque
    stem = f"{TRANSIENT}friction_damper/"
    scene.emit(f"{stem}slip_time", found.slip_time, late + 1e-12 * found.run.course.time[-1])
    scene.emit(f"{stem}heat", found.heat, found.heat_error + torque * slack * found.slip_time)
    scene.emit(f"{stem}locks", found.locks, 0.0)
    scene.warn(
        f"damper {given[1].name!r}: the transient begins with its ring locked, and steady "
        "vibration beside it is with a locked ring"
    )
    return found.run


def _windows(scene: Scene, setup: Setup, run: TransientRun) -> Windows | None:
    """Of the envelope; None where nobody asks for it, or no cycle can slide."""
    if not scene.wants(*(TRANSIENT + name for name in _ENVELOPE)):
        return None
    windows = sliding(run.course, setup.drive.firing.cycle, _TIMES)
    if windows is None:
        scene.warn(
            "the simulated time is hardly a cycle of the machine: no envelope over a whole cycle; "
            "simulate a longer time after the change"
        )
    return windows


def _emit_peaks(change: Change, peaks: Peaks) -> None:
    """Largest magnitudes, with their stresses, and the section of the largest of all."""
    change.emit_own("peak", peaks.peak, peaks.error)
    change.emit("peak_time", peaks.time, float(np.max(peaks.time_error)))
    speed = change.run.course.at(peaks.time)[0]
    slip = change.path.fastest * np.max(peaks.time_error) + 8.0 * EPSILON * np.max(speed)
    change.emit("peak_speed", speed, float(slip))
    own = Bounded(peaks.peak, peaks.error) / np.abs(change.ratio)
    change.scene.emit(f"{TRANSIENT}worst_section", first_of_largest(own.value) + 1, 0.0)
    shaft = change.setup.shaft
    stressed = np.flatnonzero(shaft.section_modulus)
    if len(stressed):
        stress = own[stressed] / shaft.section_modulus[stressed]
        change.emit("peak_stress", stress, section=tuple(shaft.section_names[e] for e in stressed))


#: parts of a run of which the torque of teeth is sampled one by one: memory does not grow with it
_PARTS = 64


def _emit_gears(change: Change) -> None:
    """The least torque of the teeth in the sense of the mean, and which of them part.

    A rigid gear carries the torques of its shafts less what speeds up the wheels on its lighter
    side. That is told by the torques of shafts where nothing else acts on these wheels.
    """
    setup, shaft = change.setup, change.setup.shaft
    if not shaft.gears:
        return
    of_sections, of_stations = gear_shares(shaft)
    line, inertia = change.path.line, shaft.station_values[0]
    acting = {*shaft.freedom[list(setup.drive.station)], *shaft.freedom[shaft.taken_station]}
    acting |= {int(shaft.freedom[shaft.load_station])}
    acting |= {*np.flatnonzero(line.absolute_damping), *np.flatnonzero(line.ground_stiffness)}
    on = setup.torsion.transient and setup.torsion.transient.on
    if on in shaft.station_names:
        acting |= {int(shaft.freedom[shaft.station_names.index(on)])}
    weights = of_sections.copy()
    for station, gear in zip(*np.nonzero(of_stations), strict=True):
        freedom = shaft.freedom[station]
        faster = (line.second == freedom).astype(float) - (line.first == freedom)
        share = inertia[station] / line.inertia[freedom]
        weights[:, gear] -= of_stations[station, gear] * share * faster
    mean = mean_torques(setup, np.array([setup.speed])).gear.value[0]
    sense = np.where(mean < 0.0, -1.0, 1.0)
    least, off = np.full(len(mean), np.inf), np.zeros(len(mean))
    ends = np.linspace(0.0, float(change.run.course.time[-1]), _PARTS + 1)
    for begin, end in pairwise(ends.tolist()):
        torque = sense * (samples(change.run, begin, end, FINER).value @ weights)
        bend = np.abs(np.diff(torque, 2, axis=0)).max(axis=0, initial=0.0) / 8.0
        lower = torque.min(axis=0)
        off, least = np.where(lower < least, bend, off), np.minimum(least, lower)
    size = np.abs(actual_per_referred(shaft))
    error = (off + change.run.torque_error @ np.abs(weights)) * size
    known = []
    for place, gear in enumerate(shaft.gears):
        wheels = {int(shaft.freedom[one]) for one in np.flatnonzero(of_stations[:, place])}
        if wheels & acting:
            change.scene.warn(
                f"gear {gear.name!r}: whether its teeth part in the transient is not examined, as "
                "other torques act on its wheels"
            )
            continue
        known.append(place)
        if least[place] * size[place] < -error[place]:
            change.scene.warn(
                f"gear {gear.name!r}: the torque of its teeth reverses in the transient, down to "
                f"{least[place] * size[place]:.4g} N*m on its first wheel; the teeth part, and the "
                "transient is computed without backlash"
            )
    if known:
        names = tuple(shaft.gears[one].name for one in known)
        change.emit("gear_minimum_torque", (least * size)[known], error[known], gear=names)


def _emit_equivalent(change: Change, found: Equivalent) -> None:
    """The dashpots that stand for loss factors, with the frequencies that they are equal at."""
    lossy = np.flatnonzero(found.frequency)
    names = tuple(change.setup.shaft.section_names[e] for e in lossy)
    frequency, damping = found.frequency[lossy], found.damping[lossy] / change.ratio[lossy] ** 2
    change.emit("equivalent/frequency", frequency, _PLACED * frequency.max(), section=names)
    change.emit("equivalent/damping", damping, _PLACED * damping.max(), section=names)
    each = ", ".join(
        f"{name!r} at {one / (2.0 * np.pi):.4g} Hz" + (" (natural frequency)" if resonance else "")
        for name, one, resonance in zip(names, frequency, found.resonance[lossy], strict=True)
    )
    change.scene.warn(
        "in the time domain loss factors are replaced by dashpots, stiffness x loss factor / "
        f"frequency, each of equal magnitude at one frequency: {each}"
    )


def _emit_envelope(change: Change) -> None:
    """Speed and extremes over a whole cycle that slides along the run."""
    windows, setup = change.windows, change.setup
    if windows is None:
        return
    speed = change.run.course.at(windows.middle)[0]
    top = float(np.max(speed, initial=0.0))
    change.emit("speed", speed, 8.0 * EPSILON * top, transient_time=windows.middle)
    # an own torque has the sign of its shaft's sense
    found = [extremes(one, windows.begin, windows.end) for one in change.seen]
    ends = np.sort(
        [np.stack(one[:2]) / r for one, r in zip(found, change.ratio, strict=True)], axis=1
    )
    error = np.array([one[2] for one in found]) / np.abs(change.ratio)[:, None]
    axes = {"section": setup.shaft.section_names, "transient_time": windows.middle}
    change.emit("torque_low", ends[:, 0], error, **axes)
    change.emit("torque_high", ends[:, 1], error, **axes)
    if change.path.passes:
        change.emit("half_range", 0.5 * (ends[:, 1] - ends[:, 0]), error, **axes)


# ----------------------------------------------------------------------------
# Adapter, continued: a passage next to the steady vibration at the speeds on the way.
# ----------------------------------------------------------------------------


def _emit_passage(change: Change) -> None:
    """The largest half range of any cycle next to the largest steady one."""
    setup, path, course = change.setup, change.path, change.run.course
    ends = course.at(np.array(path.moving))
    if ends[1, 1] - ends[1, 0] < change.cycle:
        raise NumericalFailure(
            "the change of speed takes so short a part of the time watched that nothing can be "
            "compared with the steady vibration: watch a shorter time before and after"
        )
    passed = course.at(np.linspace(0.0, course.time[-1], 2 * _TIMES + 1)[1::2])[0]
    speed = _speeds(setup, np.append(passed, ends[0][ends[0] > _ROUNDED * ends[0].max()]))
    steady = Search([setup], speed, [{TORQUE: readings_of(setup)[TORQUE]}], [TORQUE])
    found, ratio = steady.found, np.abs(setup.shaft.section_ratio)
    size = found.value_error + _ROUNDED * np.abs(found.value)
    top = Bounded(found.value * ratio, size * ratio)
    finite = np.isfinite(top.value)
    if np.any(top.value <= 0.0):
        raise NumericalFailure("a section has no steady response to compare with")
    _emit_quasi_steady(change, steady)
    swings = largest_swings(change.run, change.seen, change.cycle, path.moving)
    change.emit_own("peak_half_range", swings.half_range, swings.error)
    at = course.at(swings.time)[0]
    step = float(path.fastest * np.max(swings.time_error) + 8.0 * EPSILON * speed[-1])
    change.emit("peak_half_range_speed", at, step)
    change.emit_own("steady_half_range", top.value, np.where(finite, top.error, 0.0))
    change.emit("steady_half_range_speed", found.speed, found.speed_error)
    over = Bounded(swings.half_range, swings.error) / where(finite, top, 1.0) - 1.0
    change.emit("overshoot", where(finite, over, -1.0))
    way = np.sign(ends[0, 1] - ends[0, 0])
    change.emit("lag", way * (at - found.speed), step + found.speed_error)
    if not np.all(finite):
        change.scene.warn(
            "an undamped critical speed is passed: the steady vibration is unbounded there, the "
            "height of the quasi-steady curve depends only on its speed step"
        )


def _speeds(setup: Setup, passed: FloatArray) -> FloatArray:
    """Even steps over the speeds that are passed."""
    low, high = float(passed.min()), float(passed.max())
    cards = setup.drive.card_speed
    if len(cards) > 1:  # an end may be a rounding away from that of the cards
        low, high = (
            edge if abs(one - edge) <= _ROUNDED * edge else one
            for one, edge in ((low, float(cards[0])), (high, float(cards[-1])))
        )
        if low < cards[0] or high > cards[-1]:
            raise NumericalFailure(
                f"the run goes from {low:.6g} to {high:.6g} rad/s, gas is given from "
                f"{cards[0]:.6g} to {cards[-1]:.6g} rad/s: no steady vibration to compare with"
            )
    if low == high:
        raise NumericalFailure("the speed hardly changes: nothing to compare the run with")
    return np.linspace(low, high, _SPEEDS)


def _emit_quasi_steady(change: Change, steady: Search) -> None:
    """The largest steady half ranges at the speeds of each window of the envelope."""
    windows, course = change.windows, change.run.course
    if windows is None:
        return
    extra = by_machine(0, distinct(steady.found.speed[~np.isin(steady.found.speed, steady.grid)]))
    at = np.concatenate([steady.pairs, extra])
    rising = np.argsort(at.imag, kind="stable")
    sampled = np.concatenate([steady.samples, steady.sampled(extra)])[rising]
    bounded = np.all(np.isfinite(sampled), axis=1)
    speed, torque = at.imag[rising][bounded], (sampled * np.abs(change.ratio))[bounded]
    if len(speed) < 2:
        raise NumericalFailure("the speed hardly changes: nothing to compare the run with")
    # the speed of a window may turn at a border of two stretches
    inner = [
        course.at(np.append([a, b], course.time[(course.time > a) & (course.time < b)]))[0]
        for a, b in zip(windows.begin, windows.end, strict=True)
    ]
    ends = np.array([[one.min(), one.max()] for one in inner])
    nearby = [np.interp(ends, speed, one).max(axis=1) for one in torque.T]
    first, last = np.searchsorted(speed, ends[:, 0]), np.searchsorted(speed, ends[:, 1], "right")
    for row in np.flatnonzero(last > first):
        for one, curve in zip(nearby, torque.T, strict=True):
            one[row] = max(one[row], curve[first[row] : last[row]].max())
    error = np.zeros(len(nearby))
    if np.all(bounded):
        coarse = [np.interp(speed, speed[::2], one[::2]) for one in torque.T]
        error = np.max(np.abs(np.array(coarse) - torque.T), axis=1) / 3.0
        # a peak may rise between its speeds
        inner_values = torque[1:-1]
        rise = 0.5 * (2.0 * inner_values - torque[:-2] - torque[2:])
        tops = (inner_values > torque[:-2]) & (inner_values >= torque[2:])
        error = np.maximum(error, np.max(np.where(tops, rise, 0.0), axis=0))
    size = np.abs(change.ratio)
    axes = {"section": change.setup.shaft.section_names, "transient_time": windows.middle}
    change.emit("quasi_steady", np.array(nearby) / size[:, None], error / size, **axes)


# ----------------------------------------------------------------------------
# Adapter, continued: a change at constant speed next to what lasts before and after it.
# ----------------------------------------------------------------------------


def _emit_steps(change: Change, peaks: Peaks) -> None:
    """Largest magnitudes of the steady vibration before and after, and what the change adds."""
    ends = [_steady_peak(change, part) for part in change.path.ends]
    for name, end in zip(("before", "after")[-len(ends) :], ends, strict=True):
        change.emit(f"steady_{name}", end / np.abs(change.ratio))
    larger = maximum(ends[0], ends[-1])
    moves = larger.value > 4.0 * larger.errors  # a ratio to rounding tells nothing
    factor = Bounded(peaks.peak, peaks.error) / where(moves, larger, 1.0)
    change.emit("dynamic_factor", where(moves, factor, 1.0))


def _steady_peak(change: Change, part: Stretch) -> Bounded:
    """Largest referred torque (e,) of a state that lasts, mean in it."""
    setup, system, speed = change.setup, change.held, change.path.speed
    means = mean_law(part, system.balance, system.inertia, np.array([speed, speed]))
    mean = means.at(np.zeros(()), np.array(speed), np.zeros(()))
    still = system.torque @ static_state(system, mean)
    load = (part.gas + speed**2 * part.inertia).T[1:]
    every = np.arange(load.shape[1])
    frequency = speed * change.path.order[1:]
    solved = setup.model.solve(np.array([speed]), frequency[None], load[None], every)
    if np.any(solved.masked):
        raise NumericalFailure(
            f"no steady vibration at {speed:.6g} rad/s: an order meets an undamped natural "
            "frequency"
        )
    angle = Bounded(solved.angle[0], solved.error[0][:, None])
    _, torque = twist_and_torque(setup.model.at(speed), frequency, angle)
    whole = concatenate([Bounded(still, 1e-13 * np.abs(still))[None], torque], axis=0)
    with_mean = Cycles(
        *(np.concatenate([np.zeros(1, one.dtype), one]) for one in setup.drive.cycles)
    )
    return over_cycle(with_mean, whole.T).peak


# ----------------------------------------------------------------------------
# Adapter, continued: who accelerates a shaft line, and what of its torques that is.
# ----------------------------------------------------------------------------


def _emit_supply(change: Change) -> None:
    """The torque of the acceleration where it is largest, its source, and peaks without it."""
    course, system, shaft = change.run.course, change.held, change.setup.shaft
    # it grows and fades along straight lines: of a stretch it is largest at an end
    ends = [(one.acceleration, k, 0.0) for k, one in enumerate(course.parts)]
    ends += [
        (one.acceleration + one.acceleration_rate * one.duration, k, 1.0)
        for k, one in enumerate(course.parts)
    ]
    top, number, share = max(ends, key=lambda one: abs(one[0]))
    change.scene.emit(f"{TRANSIENT}acceleration", top, 8.0 * EPSILON * abs(top))
    whole = top * float(system.inertia.sum())
    change.scene.emit(f"{TRANSIENT}acceleration_torque", whole, 1e-14 * abs(whole))
    # the mean torques of cylinders and loads at that moment, and what they leave to the station
    part, speeds = course.parts[number], course.speed[number : number + 2]
    means = mean_law(part, np.eye(len(system.inertia)), system.inertia, speeds)
    mean = means.at(np.zeros(()), np.array(speeds[int(share)]), np.array(share))
    station_ratio = float(shaft.station_ratio[shaft.load_station])
    supplied = float((system.balance @ mean - mean)[shaft.load_freedom]) / station_ratio
    size = abs(whole) + float(np.abs(mean).sum())
    slack = 1e-12 * size / abs(station_ratio)
    change.scene.emit(f"{TRANSIENT}acceleration_supplied", supplied, slack)
    change.scene.emit(f"{TRANSIENT}acceleration_supplied_at", shaft.load_station + 1, 0.0)
    carried = system.torque @ static_state(system, system.balance @ (-system.inertia * top))
    uncertainty = 1e-12 * np.max(np.abs(carried), initial=0.0)
    change.emit("acceleration_part", carried / change.ratio, uncertainty / np.abs(change.ratio))
    left = []
    for trace, own in zip(change.seen, carried, strict=True):
        share_of_top = course.at(trace.time)[2] / top
        value = np.abs(trace.value - own * share_of_top)
        # between two points in turn it is no further off than the acceleration changes
        apart = np.abs(np.diff(share_of_top, append=share_of_top[-1]))
        error = trace.error + abs(own) * np.maximum(apart, np.roll(apart, 1)) + uncertainty
        left.append((value.max(), np.max(value + error) - value.max()))
    change.emit_own("peak_without_acceleration", *np.array(left).T)


# ----------------------------------------------------------------------------
# Adapter, continued: the course of the worst section about its peak, and its waterfalls.
# ----------------------------------------------------------------------------

_WINDOWS, _FREQUENCIES = 60, 160
#: turns of a window of orders: halves are distinguished
_TURNS = 8.0
#: turns on both sides of the peak, and points that are kept of them
_ABOUT, _POINTS = 6.0, 3000
#: samples of all sections that are held at once
_HELD = 4_000_000
#: radians of the fastest that is there between two points of a waterfall
_RADIANS = 1.0
#: points of a window at least, as far as there are so many
_LEAST = 40.0


def _emit_history(change: Change, section: int, when: float) -> None:
    """Course of one section, counted from 0, about its peak."""
    run, ratio = change.run, float(change.ratio[section])
    reach = 2.0 * np.pi * _ABOUT * np.array([-1.0, 1.0])
    start, end = run.course.time_of(run.course.at(np.array(when))[1] + reach)
    history = samples(run, start, max(end, start + 1e-9))
    every = max(1, -(-len(history.time) // _POINTS))
    value, error = history.value[::every, section] / ratio, run.torque_error[section] / abs(ratio)
    change.emit("history/torque", value, error, history_time=history.time[::every])


def _emit_waterfalls(change: Change, section: int) -> None:
    """Orders and frequencies of one section, counted from 0, in windows along the run."""
    run, order = change.run, change.setup.drive.order
    if not change.scene.wants(
        *(f"{TRANSIENT}waterfall/{n}" for n in ("speed", "order", "frequency"))
    ):
        return
    course, total = run.course, float(run.course.time[-1])
    begin, whole = float(course.angle[0]), float(course.angle[-1])
    # of turns and of time
    turned = 2.0 * np.pi * min(_TURNS, whole / (2.0 * np.pi) / 2.5)
    fastest, natural = float(course.speed.max()), change.setup.modes.frequency
    top = min(float(order[-1]) * fastest, 1.15 * float(natural[-1]))
    frequency = np.linspace(0.0, top, _FREQUENCIES)
    width = min(4.0 * np.pi / (frequency[1] - frequency[0]), total / 6.0)
    reach = 0.51 * turned
    first, last = course.time_of(np.array([begin + reach, whole - reach]))
    centre = np.linspace(max(first, 0.52 * width), min(last, total - 0.52 * width), _WINDOWS)
    angle = course.at(centre)[1]
    low = np.maximum(np.minimum(course.time_of(angle - reach), centre - 0.51 * width), 0.0)
    high = np.minimum(np.maximum(course.time_of(angle + reach), centre + 0.51 * width), total)
    limit = _RADIANS / max(float(order[-1]) * fastest, float(natural[-1]))
    # the windows of a change of a few periods are short: they keep their points
    limit = min(limit, width / _LEAST, turned / fastest / _LEAST)
    # windows that overlap share their samples, where these are few enough to be held at once
    count = sum(one.steps * points_in(run, number) for number, one in enumerate(run.blocks))
    few = count * run.torque_error.size <= _HELD
    every = samples(run, 0.0, total) if few else None
    rows, sums = [], np.zeros(2)
    for row, (start, end) in enumerate(zip(low, high, strict=True)):
        if every is None:
            near = samples(run, start, end)
        else:
            held = slice(*np.searchsorted(every.time, [start, np.nextafter(end, np.inf)]))
            near = Samples(every.time[held], every.value[held])
        # no two further apart than that (or as far as they are)
        step = max(1, int(limit / float(np.max(np.diff(near.time)))))
        time, value = near.time[::step], near.value[::step, section]
        of_order = window_amplitudes(course.at(time)[1], value, order, angle[row], turned)
        of_frequency = window_amplitudes(time, value, frequency, centre[row], width)
        rows.append((of_order[0], of_frequency[0]))
        sums = np.maximum(sums, [of_order[1].max(), of_frequency[1].max()])
    speed = course.at(centre)[0]
    change.emit("waterfall/speed", speed, 8.0 * EPSILON * fastest, waterfall_time=centre)
    # a mean of values, so that what the values are off adds no more than theirs
    ratio = float(change.ratio[section])
    error = (2.0 * run.torque_error[section] + sums) / abs(ratio)
    axes = {"order": order}, {"waterfall_frequency": frequency}
    for name, values, off, axis in zip(
        ("order", "frequency"), zip(*rows, strict=True), error, axes, strict=True
    ):
        value = np.array(values) / ratio
        change.emit(f"waterfall/{name}", value, float(off), waterfall_time=centre, **axis)


# ----------------------------------------------------------------------------
# Adapter: cycles of a change in time, torques of the sections' own shafts.
# ----------------------------------------------------------------------------


def emit_counting(scene: Scene, setup: Setup, options: CycleCounting, seen: list[Trace]) -> None:
    """Ranges with means and numbers, equivalent numbers, and sums of Miner."""
    shaft, names = setup.shaft, setup.shaft.section_names
    chosen = [names.index(one) for one in options.sections] or list(range(len(names)))
    given = scene.case.machine.shaft_line
    assert given is not None
    lines = {place: one.fatigue for place, one in enumerate(given.shafts) if one.fatigue}
    cycles = {}
    for one in chosen:
        own = float(shaft.section_ratio[one])
        value, error = seen[one].value / own, seen[one].error / abs(own)
        cycles[one] = rainflow_cycles(value, error, options.ignore)

    def emit(name: str, sections: list[int], values: Any, error: Any, **axes: Any) -> None:
        axes["section"] = tuple(names[one] for one in sections)
        scene.emit(f"{TRANSIENT}counted/{name}", np.array(values), error, axes)

    tables = [range_table(one, options.bins) for one in cycles.values()]
    bins = np.arange(1, options.bins + 1)
    off = {place: float(np.max(one.error, initial=0.0)) for place, one in cycles.items()}
    for name, slack in (
        ("range", max(off.values())),
        ("number", max(float(np.max(one.error)) for one in tables)),
        ("mean", max(one.mean_error for one in tables)),
    ):
        emit(name, chosen, [getattr(one, name) for one in tables], slack, range_bin=bins)
    strength = {
        one: _strength(lines[one], float(shaft.section_modulus[one])) if one in lines
        else Strength(1.0, 1.0, options.slope, options.slope)
        for one in chosen
    }  # fmt: skip
    equal = [equivalent_number(cycles[one], strength[one]) for one in chosen]
    number, error = np.array(equal).T
    emit("equivalent_number", chosen, number, error.max())
    largest = {one: float(cycles[one].range.max(initial=0.0)) for one in chosen}
    emit("largest_range", chosen, list(largest.values()), max(off.values()))
    stressed = [one for one in chosen if shaft.section_modulus[one]]
    if stressed:
        modulus = shaft.section_modulus[stressed]
        values, errors = (np.array([part[one] for one in stressed]) for part in (largest, off))
        emit("largest_stress_range", stressed, values / modulus, errors / modulus)
    lasting = [one for one in chosen if one in lines]
    if lasting:
        sums = np.array([miner_sum(cycles[one], strength[one]) for one in lasting])
        emit("damage", lasting, sums[:, 0], sums[:, 1].max())
        whole = options.changes * sums
        emit("damage_of_all", lasting, whole[:, 0], whole[:, 1].max())
    scene.cite(
        "rainflow counting of the torques of sections, ranges and means",
        "transient",
        "ASTM E1049-85, 5.4.4; sum of n / N by Palmgren 1924 and Miner 1945",
    )


def _strength(line: FatigueLine, modulus: float) -> Strength:
    """An S-N line in torques of the own shaft."""
    amplitude = line.torque if line.torque is not None else (line.stress or 0.0) * modulus
    return Strength(amplitude, line.cycles, line.slope, slope_below(line.slope, line.below))
