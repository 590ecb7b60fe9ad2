"""A change in time of a shaft line, next to the steady vibration on the way."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, concatenate, maximum, where
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.numerics.synthesis import Cycles, over_cycle
from vibecalc.torsion.adapters.curves import sweep
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.adapters.transient_damping import Equivalent
from vibecalc.torsion.adapters.transient_motion import Journey, journey, running
from vibecalc.torsion.section_loads import twist_and_torque
from vibecalc.torsion.study_results import PASSAGES, TRANSIENT
from vibecalc.torsion.transient.cycles import (
    SlidingExtremes,
    largest_steady,
    largest_swings,
    section_peaks,
    sliding,
    time_uncertainty,
)
from vibecalc.torsion.transient.march import TransientRun, static_state, transient
from vibecalc.torsion.transient.motion import (
    Stretch,
    acceleration_at,
    angle_at,
    load_at,
    mean_torque,
    speed_at,
    torque_law,
)
from vibecalc.torsion.transient.peaks import (
    Envelope,
    KnownTools,
    SectionHistory,
    envelope,
    frequency_window,
    order_window,
    points_in,
    section_history,
)

# ----------------------------------------------------------------------------
# Adapter: a change in time of a shaft line, next to the steady vibration on the way.
# ----------------------------------------------------------------------------

#: tolerance of the march: nothing that is read off it is reported more sharply
_RTOL = 1e-7
#: windows in which peaks are searched; of a cycle, in a time of fewer cycles than that, where
#: the speed stays
_FEWEST, _MOST, _PER_CYCLE, _SHORT = 4, 400, 6, 20
#: speeds of the steady curve before its peaks are added
_SPEEDS = 1201
#: share of the highest speed below which the line stands: a steady vibration there is rounding
_STANDS = 1e-6
#: share of a speed that is rounding
_ROUNDED = 1e-12
#: share by which the frequency of a loss factor may be off the highest point, in five digits
_PLACED = 6e-5
#: peaks of each section that are examined again, and speeds about each
_PEAKS, _CLOSE, _ZOOMS = 3, 17, 5


def run_torsion_transient(scene: Scene) -> None:
    """Emit everything for [response.torsion.transient]."""
    setup = build_setup(running(scene.case))
    options = setup.torsion.transient
    if options is None:
        raise ValueError("the case has no [response.torsion.transient]")
    rtol = max(_RTOL, scene.case.accuracy.rtol)
    passes = options.kind in PASSAGES
    if setup.model.over_speed is not None and passes:
        scene.warn(
            "dampings that follow the speed stay as they are at the mean speed of the change while "
            "it lasts; the steady vibration next to it has those of each speed"
        )
    if options.kind == "clutch_in":
        from vibecalc.torsion.adapters.transient_clutch import run_clutch

        path, run_ = run_clutch(scene, setup, options, rtol)
    else:
        path = journey(setup, scene.case.machine, options)
        run_ = transient(
            path.line, path.order, path.stretches, path.speed, start=path.start,
            reaction=path.reaction, rtol=rtol,
        )  # fmt: skip
    if path.equivalent is not None:
        emit_equivalent(scene, setup, path.equivalent)
    extremes = envelope(run_, _windows(setup, run_, not passes))
    size = np.abs(setup.shaft.section_ratio)
    slide = emit_envelope(scene, setup, run_)
    worst = _emit_peaks(scene, setup, run_, extremes)
    if passes:
        _emit_passage(scene, setup, path, run_, extremes, slide)
        emit_supply(scene, setup, run_, extremes)
    else:
        _emit_steps(scene, setup, path, run_, extremes, size)
    emit_histories(scene, setup, run_, worst)
    if options.counting is not None:
        from vibecalc.torsion.adapters.transient_counting import emit_counting

        emit_counting(scene, setup, options.counting, run_)
    scene.cite(
        "exact propagation of the line over steps with the torque as a polynomial, crank speed "
        "prescribed; envelope from states inside the steps",
        "transient",
        "matrix exponential and its integrals in Legendre polynomials; "
        "docs/theory_torsion_studies.md",
    )


def _windows(setup: Setup, run_: TransientRun, constant: bool) -> int:
    """Windows of a whole cycle at least, but for the slowest part of a start.

    Finer in a short time at one speed, where no half ranges are read from them.
    """
    total, cycle = float(run_.borders.time[-1]), setup.drive.firing.cycle
    mean = float(run_.borders.angle[-1]) / total
    slowest = max(float(run_.borders.speed.min()), 0.5 * mean)
    cycles = total * slowest / cycle
    count = cycles * _PER_CYCLE if constant and cycles < _SHORT else cycles
    return int(np.clip(count, _FEWEST, _MOST))


def _axes(setup: Setup) -> dict[str, object]:
    return {"section": setup.shaft.section_names}


def _emit_peaks(scene: Scene, setup: Setup, run_: TransientRun, extremes: Envelope) -> int:
    """Largest magnitudes; gives the section of the largest, counted from 0."""
    peaks, axes = section_peaks(run_, extremes), _axes(setup)
    actual = peaks.peak / np.abs(setup.shaft.section_ratio)
    scene.emit(f"{TRANSIENT}peak", actual, peaks.error / np.abs(setup.shaft.section_ratio), axes)
    uncertainty = float(np.max(time_uncertainty(run_, peaks)))
    scene.emit(f"{TRANSIENT}peak_time", peaks.time, uncertainty, axes)
    fastest = float(np.max(np.abs(acceleration_at(run_.stretches, run_.borders, extremes.time))))
    slip = fastest * uncertainty + 8.0 * EPSILON * float(np.max(peaks.speed))
    scene.emit(f"{TRANSIENT}peak_speed", peaks.speed, slip, axes)
    worst = int(np.argmax(actual))
    scene.emit(f"{TRANSIENT}worst_section", worst + 1, 0.0)
    stressed = np.flatnonzero(setup.shaft.section_modulus)
    if len(stressed):
        modulus = setup.shaft.section_modulus[stressed]
        error = (peaks.error / np.abs(setup.shaft.section_ratio))[stressed] / modulus
        of_stressed = {"section": tuple(setup.shaft.section_names[e] for e in stressed)}
        scene.emit(f"{TRANSIENT}peak_stress", actual[stressed] / modulus, error, of_stressed)
    return worst


def emit_equivalent(scene: Scene, setup: Setup, found: Equivalent) -> None:
    """The dashpots that stand for loss factors, with the frequencies that they are equal at."""
    lossy = np.flatnonzero(found.frequency)
    names = tuple(setup.shaft.section_names[e] for e in lossy)
    frequency, own = found.frequency[lossy], setup.shaft.section_ratio[lossy] ** 2
    damping = found.damping[lossy] / own
    axes = {"section": names}
    scene.emit(f"{TRANSIENT}equivalent/frequency", frequency, _PLACED * frequency.max(), axes)
    scene.emit(f"{TRANSIENT}equivalent/damping", damping, _PLACED * damping.max(), axes)
    each = ", ".join(
        f"{name!r} at {one / (2.0 * np.pi):.4g} Hz" + (" (natural frequency)" if resonance else "")
        for name, one, resonance in zip(names, frequency, found.resonance[lossy], strict=True)
    )
    scene.warn(
        "a loss factor has no form in time: dashpots of stiffness times loss factor over frequency "
        f"take its place and keep the magnitude at one frequency each: {each}"
    )


def _emit_passage(
    scene: Scene, setup: Setup, path: Journey, run_: TransientRun, extremes: Envelope,
    slide: SlidingExtremes | None,
) -> None:  # fmt: skip
    """Half ranges of the windows next to the steady ones at the same speeds."""
    size = np.abs(setup.shaft.section_ratio)
    start, end = path.moving
    inside = np.flatnonzero(
        (extremes.time[:-1] >= start - 1e-12) & (extremes.time[1:] <= end + 1e-12)
    )
    if inside.size < 3:
        raise NumericalFailure(
            "the change of speed takes so short a part of the time watched that nothing can be "
            "compared with the steady vibration: watch a shorter time before and after"
        )
    # with the windows that reach beyond the change: what counts is examined between its ends
    rows = slice(max(int(inside[0]) - 1, 0), int(inside[-1]) + 2)
    within = Envelope(
        extremes.time[rows.start : rows.stop + 1], *(part[rows] for part in extremes[1:])
    )
    ends = speed_at(run_.stretches, run_.borders, np.array([start, end]))
    turning = ends[ends > _STANDS * ends.max()]
    speeds, steady, uncertainty, damped = _steady(setup, np.concatenate([turning, extremes.speed]))
    close = EPSILON * float(speeds[-1])
    between = float(ends.min()) - close, float(ends.max()) + close
    largest, at_largest = largest_steady(speeds, steady, between)
    # samples at the ends of the change belong to it
    slip = 8.0 * EPSILON * float(run_.borders.time[-1])
    cycle = setup.drive.firing.cycle
    swings = largest_swings(run_, within, cycle, (start - slip, end + slip))
    if slide is not None:
        emit_half_ranges(scene, setup, slide, speeds, steady, uncertainty)
    axes = _axes(setup)
    error = swings.error
    scene.emit(f"{TRANSIENT}peak_half_range", swings.half_range / size, error / size, axes)
    rate = acceleration_at(run_.stretches, run_.borders, within.time)
    step = float(np.max(np.abs(rate))) * swings.time_error + 8.0 * EPSILON * float(speeds[-1])
    scene.emit(f"{TRANSIENT}peak_half_range_speed", swings.speed, step, axes)
    top = largest if damped else np.full_like(largest, np.inf)
    slack = _slack(speeds, steady, at_largest)
    scene.emit(f"{TRANSIENT}steady_half_range", top / size, slack / size, axes)
    place = np.clip(np.searchsorted(speeds, at_largest), 1, len(speeds) - 2)
    width = np.maximum(speeds[place + 1] - speeds[place], speeds[place] - speeds[place - 1])
    scene.emit(f"{TRANSIENT}steady_half_range_speed", at_largest, width, axes)
    over = swings.half_range / top - 1.0
    uncertainty_over = np.where(np.isfinite(top), (error + slack) / largest, 0.0)
    scene.emit(f"{TRANSIENT}overshoot", over, uncertainty_over + 1e-12, axes)
    lag = np.sign(within.speed[-1] - within.speed[0]) * (swings.speed - at_largest)
    scene.emit(f"{TRANSIENT}lag", lag, step + width, axes)
    if not damped:
        scene.warn(
            "nothing damps the shaft line: its steady vibration has no bound on a critical, the "
            "quasi-steady curve next to the transient is as high as its speeds are close"
        )


def _slack(speeds: FloatArray, steady: FloatArray, top: FloatArray) -> FloatArray:
    """How much higher than the largest value (e,) at the speeds `top` the curve may be next to it.

    The peak may have a corner, where crest and trough change places: half the second difference.
    """
    place, section = np.searchsorted(speeds, top), np.arange(len(top))
    half_range = steady[place, section]
    sides = steady[np.maximum(place - 1, 0), section], steady[
        np.minimum(place + 1, len(speeds) - 1), section
    ]  # fmt: skip
    bend = np.maximum(half_range - sides[0], 0.0) + np.maximum(half_range - sides[1], 0.0)
    # at an end of the range nothing lies beyond
    inside = (place > 0) & (place < len(speeds) - 1)
    slack: FloatArray = np.where(inside, 0.5 * bend, 0.0) + _ROUNDED * half_range
    return slack


def _steady(setup: Setup, passed: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, bool]:
    """Speeds (k,), referred half ranges (k, e), their errors (e,), and whether anything damps."""
    low, high = float(passed.min()), float(passed.max())
    cards = setup.drive.card_speed
    if len(cards) > 1:  # an end may be a rounding away from that of the cards
        low, high = (
            edge if abs(one - edge) <= _ROUNDED * edge else one
            for one, edge in ((low, float(cards[0])), (high, float(cards[-1])))
        )
    if len(cards) > 1 and (low < cards[0] or high > cards[-1]):
        raise NumericalFailure(
            f"the run goes from {low:.6g} to {high:.6g} rad/s, gas is given from {cards[0]:.6g} "
            f"to {cards[-1]:.6g} rad/s: no steady vibration to compare with"
        )

    def curve(speed: FloatArray) -> FloatArray:
        return sweep(setup.model, setup.drive, speed, None, angles=False).torque

    speeds = np.linspace(low, high, _SPEEDS)
    values = curve(speeds)
    coarse = values[::2]
    bounded = np.all(np.isfinite(values), axis=1)
    line = setup.model.line
    damped = bool(
        np.any(line.damping)
        or np.any(line.loss_factor)
        or np.any(line.absolute_damping)
        or setup.model.modal is not None
    )
    uncertainty = np.array([
        np.max(np.abs(np.interp(speeds[bounded], speeds[::2], coarse[:, s]) - values[bounded, s]))
        if np.all(bounded) else 0.0
        for s in range(values.shape[1])
    ]) / 3.0  # fmt: skip
    speeds, values = speeds[bounded], values[bounded]
    if damped and np.all(bounded):
        speeds, values = _zoomed(curve, speeds, values)
        # peaks that were not examined again may rise between their speeds
        inner = values[1:-1]
        overshoot = 0.5 * (2.0 * inner - values[:-2] - values[2:])
        top = (inner > values[:-2]) & (inner >= values[2:])
        uncertainty = np.maximum(uncertainty, np.max(np.where(top, overshoot, 0.0), axis=0))
    if low == high or len(speeds) < 2:
        raise NumericalFailure("the speed hardly changes: nothing to compare the run with")
    return speeds, values, uncertainty, damped


def _zoomed(
    curve: Callable[[FloatArray], FloatArray], speeds: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The curve with close speeds about the highest peaks of each section, twice closer."""
    width = float(speeds[1] - speeds[0])
    for _ in range(_ZOOMS):
        inner = values[1:-1]
        local = np.where((inner > values[:-2]) & (inner >= values[2:]), inner, -np.inf)
        top = 1 + np.argsort(-local, axis=0, kind="stable")[:_PEAKS]
        tops = np.unique(speeds[np.union1d(top.ravel(), np.argmax(values, axis=0))])
        close = (tops[:, None] + width * np.linspace(-1.0, 1.0, _CLOSE)).ravel()
        close = np.setdiff1d(close[(close > speeds[0]) & (close < speeds[-1])], speeds)
        every = np.concatenate([speeds, close])
        order = np.argsort(every, kind="stable")
        speeds, values = every[order], np.concatenate([values, curve(close)])[order]
        width *= 2.0 / (_CLOSE - 1)
    return speeds, values


def _emit_steps(
    scene: Scene, setup: Setup, path: Journey, run_: TransientRun, extremes: Envelope,
    size: FloatArray,
) -> None:  # fmt: skip
    """Largest magnitudes of the steady vibration before and after, and what the change adds."""
    if not path.ends:
        return
    axes = _axes(setup)
    ends = [_steady_peak(setup, path, run_, part) for part in path.ends]
    for name, end in zip(("before", "after")[-len(ends) :], ends, strict=True):
        scene.emit(f"{TRANSIENT}steady_{name}", end / size, axes=axes)
    larger, peaks = maximum(ends[0], ends[-1]), section_peaks(run_, extremes)
    moves = larger.value > 0.0
    factor = Bounded(peaks.peak, peaks.error) / where(moves, larger, 1.0)
    scene.emit(f"{TRANSIENT}dynamic_factor", where(moves, factor, 1.0), axes=axes)


def _steady_peak(setup: Setup, path: Journey, run_: TransientRun, part: Stretch) -> Bounded:
    """Largest referred torque (e,) of a state that lasts, mean in it."""
    system, speed = run_.system, path.speed
    law = torque_law(path.order, part, system.balance, system.inertia, np.array([speed, speed]))
    mean = load_at(law, np.array(speed)) + law.harmonic[0][:, 0]
    mean = mean + speed**2 * law.harmonic[2][:, 0]
    still = system.torque @ static_state(system, mean)
    load = (part.gas + speed**2 * part.inertia).T[1:]
    every = np.arange(load.shape[1])
    solved = setup.model.solve(np.array([speed]), speed * path.order[None, 1:], load[None], every)
    if np.any(solved.masked):
        raise NumericalFailure(
            f"no steady vibration at {speed:.6g} rad/s: an order meets an undamped natural "
            "frequency"
        )
    frequency = speed * path.order[1:]
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


def emit_supply(scene: Scene, setup: Setup, run: TransientRun, extremes: Envelope) -> None:
    """The torque of the acceleration where it is largest, its source, and peaks without it."""
    system, shaft = run.system, setup.shaft
    time = np.union1d(run.borders.time, extremes.time)
    # a value at a border belongs to the stretch behind it: a little before it counts too
    time = np.union1d(time, np.maximum(time - 1e-9 * time[-1], 0.0))
    rate = acceleration_at(run.stretches, run.borders, time)
    place = int(np.argmax(np.abs(rate)))
    top = float(rate[place])
    axes = {"section": shaft.section_names}
    scene.emit(f"{TRANSIENT}acceleration", top, 8.0 * EPSILON * abs(top))
    inertia = system.inertia
    whole = top * float(inertia.sum())
    scene.emit(f"{TRANSIENT}acceleration_torque", whole, 1e-14 * abs(whole))
    pull = -inertia * top
    supplied = float((system.balance @ pull - pull)[shaft.load_freedom])
    # the mean torques of cylinders and loads at that moment, and what they leave to the station
    number = int(np.clip(np.searchsorted(run.borders.time, time[place], side="right") - 1, 0,
                         len(run.stretches) - 1))  # fmt: skip
    part = run.stretches[number]
    since = float(time[place] - run.borders.time[number])
    speeds = run.borders.speed[number : number + 2]
    speed = float(speed_at(run.stretches, run.borders, time[place : place + 1])[0])
    mean = mean_torque(part, speeds, speed, since)
    supplied += float((system.balance @ mean - mean)[shaft.load_freedom])
    station_ratio = float(shaft.station_ratio[shaft.load_station])
    size = abs(whole) + float(np.abs(mean).sum())
    scene.emit(
        f"{TRANSIENT}acceleration_supplied",
        supplied / station_ratio,
        1e-12 * size / abs(station_ratio),
    )
    scene.emit(f"{TRANSIENT}acceleration_supplied_at", shaft.load_station + 1, 0.0)
    carried = system.torque @ static_state(system, system.balance @ pull)
    uncertainty = 1e-12 * np.max(np.abs(carried), initial=0.0)
    ratio = shaft.section_ratio
    scene.emit(f"{TRANSIENT}acceleration_part", carried / ratio, uncertainty / np.abs(ratio), axes)
    middle = 0.5 * (extremes.time[:-1] + extremes.time[1:])
    ends = acceleration_at(run.stretches, run.borders, extremes.time)
    now = acceleration_at(run.stretches, run.borders, middle)
    off = np.maximum(np.abs(ends[:-1] - now), np.abs(ends[1:] - now)) / abs(top)
    supplied_part = np.outer(now / top, carried)
    slack = extremes.error + np.outer(off, np.abs(carried)) + uncertainty
    left = np.maximum(np.abs(extremes.high - supplied_part), np.abs(extremes.low - supplied_part))
    row, column = left.argmax(axis=0), np.arange(left.shape[1])
    error = np.maximum(slack[row, column], (left + slack).max(axis=0) - left[row, column])
    values = left[row, column] / np.abs(ratio)
    scene.emit(f"{TRANSIENT}peak_without_acceleration", values, error / np.abs(ratio), axes)


# ----------------------------------------------------------------------------
# Adapter, continued: the envelope of a change in time over a cycle that slides along it.
# ----------------------------------------------------------------------------

#: times of the envelope
_TIMES = 200
_RESULTS = ("speed", "torque_low", "torque_high", "half_range", "quasi_steady")


def emit_envelope(scene: Scene, setup: Setup, run: TransientRun) -> SlidingExtremes | None:
    """Emit speed and extremes; None where nobody asks for them, or no cycle can slide."""
    if not scene.wants(*(TRANSIENT + name for name in _RESULTS)):
        return None
    moving = sliding(run, setup.drive.firing.cycle, _TIMES)
    if moving is None:
        scene.warn(
            "the change in time is watched for hardly a cycle of the machine: there is no "
            "envelope over a whole cycle; watch a longer time after it"
        )
        return None
    axes = {"section": setup.shaft.section_names, "transient_time": moving.time}
    top = float(np.max(moving.speed, initial=0.0))
    scene.emit(f"{TRANSIENT}speed", moving.speed, 8.0 * EPSILON * top, axes)
    # an own torque has the sign of its shaft's sense
    ratio = setup.shaft.section_ratio
    ends = np.sort(np.stack([moving.low / ratio, moving.high / ratio]), axis=0)
    error = moving.error / np.abs(ratio)
    scene.emit(f"{TRANSIENT}torque_low", ends[0].T, error, axes)
    scene.emit(f"{TRANSIENT}torque_high", ends[1].T, error, axes)
    return moving


def emit_half_ranges(
    scene: Scene, setup: Setup, moving: SlidingExtremes, speeds: FloatArray, steady: FloatArray,
    uncertainty: FloatArray,
) -> None:  # fmt: skip
    """Half ranges next to the largest steady ones (k, e) at the speeds (k,) of each window."""
    size = np.abs(setup.shaft.section_ratio)
    axes = {"section": setup.shaft.section_names, "transient_time": moving.time}
    half = 0.5 * (moving.high - moving.low)
    ends = [
        np.stack([np.interp(side, speeds, part) for part in steady.T], axis=1)
        for side in (moving.speed_low, moving.speed_high)
    ]
    nearby = np.maximum(*ends)
    first = np.searchsorted(speeds, moving.speed_low)
    last = np.searchsorted(speeds, moving.speed_high, side="right")
    for row in np.flatnonzero(last > first):
        nearby[row] = np.maximum(nearby[row], steady[first[row] : last[row]].max(axis=0))
    scene.emit(f"{TRANSIENT}half_range", (half / size).T, moving.error / size, axes)
    scene.emit(f"{TRANSIENT}quasi_steady", (nearby / size).T, uncertainty / size, axes)


# ----------------------------------------------------------------------------
# Adapter, continued: the course of the worst section about its peak, and its waterfalls.
# ----------------------------------------------------------------------------

_WINDOWS, _FREQUENCIES = 60, 160
#: turns of a window of orders: halves are distinguished
_TURNS = 8.0
#: turns on both sides of the peak, and points that are kept of them
_ABOUT, _POINTS = 6.0, 3000
_TABLE = 20001
#: samples of all sections that are held at once
_HELD = 4_000_000
#: radians of the fastest that is there between two points of a waterfall
_RADIANS = 1.0


def emit_histories(scene: Scene, setup: Setup, run: TransientRun, section: int) -> None:
    """Course and waterfalls of one section, counted from 0."""
    times = np.linspace(0.0, float(run.borders.time[-1]), _TABLE)
    angles = angle_at(run.stretches, run.borders, times)
    ratio = float(setup.shaft.section_ratio[section])
    _emit_history(scene, run, section, ratio, (times, angles))
    paths = [f"{TRANSIENT}waterfall/{name}" for name in ("speed", "order", "frequency")]
    if not scene.wants(*paths):
        return
    _emit_waterfalls(scene, setup, run, section, ratio, (times, angles))


def _emit_history(
    scene: Scene, run: TransientRun, section: int, ratio: float,
    table: tuple[FloatArray, FloatArray],
) -> None:  # fmt: skip
    times, angles = table
    when = float(scene.record[f"{TRANSIENT}peak_time"].values[section]) if (
        f"{TRANSIENT}peak_time" in scene.record.quantities
    ) else float(times[-1])  # fmt: skip
    middle, reach = float(np.interp(when, times, angles)), 2.0 * np.pi * _ABOUT
    start, end = (float(np.interp(middle + s * reach, angles, times)) for s in (-1.0, 1.0))
    history = section_history(run, start, max(end, start + 1e-9))
    every = max(1, -(-len(history.time) // _POINTS))
    value = history.value[::every, section] / ratio
    error = run.torque_error[section] / abs(ratio)
    axes = {"history_time": history.time[::every]}
    scene.emit(f"{TRANSIENT}history/torque", value, error, axes)


def _thinned(history: SectionHistory, longest: float) -> SectionHistory:
    """Every so many-th point, no two further apart than `longest` s (or as far as they are)."""
    every = max(1, int(longest / float(np.max(np.diff(history.time)))))
    return SectionHistory(*(part[::every] for part in history))


def _emit_waterfalls(
    scene: Scene, setup: Setup, run: TransientRun, section: int, ratio: float,
    table: tuple[FloatArray, FloatArray],
) -> None:  # fmt: skip
    times, angles = table
    order = setup.drive.order
    total, whole = float(times[-1]), float(angles[-1])
    turns = min(_TURNS, whole / (2.0 * np.pi) / 2.5)
    reach = 0.5 * 2.0 * np.pi * turns * 1.02
    fastest = float(run.borders.speed.max())
    natural = setup.modes.frequency
    top = min(float(order[-1]) * fastest, 1.15 * float(natural[-1]))
    frequency = np.linspace(0.0, top, _FREQUENCIES)
    width = min(4.0 * np.pi / (frequency[1] - frequency[0]), total / 6.0)
    first = max(float(np.interp(angles[0] + reach, angles, times)), 0.52 * width)
    last = min(float(np.interp(angles[-1] - reach, angles, times)), total - 0.52 * width)
    centre = np.linspace(first, last, _WINDOWS)
    limit = _RADIANS / max(float(order[-1]) * fastest, float(natural[-1]))
    of_order = np.empty((_WINDOWS, len(order)), dtype=complex)
    of_frequency = np.empty((_WINDOWS, _FREQUENCIES), dtype=complex)
    sums, known = np.zeros(2), KnownTools()
    # windows that overlap share their samples, where these are few enough to be held at once
    samples = sum(one.steps * points_in(run, number) for number, one in enumerate(run.blocks))
    few = samples * run.torque_error.size <= _HELD
    whole_run = section_history(run, 0.0, total, known=known) if few else None
    for row, when in enumerate(centre):
        place = float(np.interp(when, times, angles))
        ends = [float(np.interp(place + s * reach, angles, times)) for s in (-1.0, 1.0)]
        low, high = min(ends[0], when - 0.51 * width), max(ends[1], when + 0.51 * width)
        low, high = max(low, 0.0), min(high, total)
        if whole_run is None:
            near = section_history(run, low, high, known=known)
        else:
            rows = slice(*np.searchsorted(whole_run.time, [low, np.nextafter(high, np.inf)]))
            near = SectionHistory(*(part[rows] for part in whole_run))
        history = _thinned(near, limit)
        of_order[row], off = order_window(history, section, order, float(when), turns)
        of_frequency[row], away = frequency_window(history, section, frequency, float(when), width)
        sums = np.maximum(sums, [off.max(), away.max()])
    speed = speed_at(run.stretches, run.borders, centre)
    axes = {"waterfall_time": centre, "half_order": order, "waterfall_frequency": frequency}
    scene.emit(f"{TRANSIENT}waterfall/speed", speed, 8.0 * EPSILON * fastest, axes)
    # a mean of values, so that what the values are off adds no more than theirs
    error = (2.0 * run.torque_error[section] + sums) / abs(ratio)
    scene.emit(f"{TRANSIENT}waterfall/order", of_order / ratio, float(error[0]), axes)
    scene.emit(f"{TRANSIENT}waterfall/frequency", of_frequency / ratio, float(error[1]), axes)
