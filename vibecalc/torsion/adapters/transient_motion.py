"""A change in time of a case as stretches of prescribed motion, and the slip of its clutch."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import phasor, weighted
from vibecalc.kinds import has_crank_train
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.adapters.motion import solved
from vibecalc.torsion.adapters.setup import Setup, motored_torque, placed
from vibecalc.torsion.line import Line, part_of
from vibecalc.torsion.question_tables import AT_CONSTANT_SPEED, Transient
from vibecalc.torsion.shaft_line_tables import Layout
from vibecalc.torsion.speed_damping import SpeedLaw
from vibecalc.torsion.study_results import TRANSIENT
from vibecalc.torsion.transient.clutch import Clutch, Engagement, engage, slip_view
from vibecalc.torsion.transient.march import TransientRun
from vibecalc.torsion.transient.motion import Stretch, TorqueInTime, stretch

if TYPE_CHECKING:
    from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# A loss factor has no form in time: k (1 + i eta) is of a steady vibration. A dashpot
# c = eta k / w has the same complex stiffness at the frequency w, magnitude and heat, so that a
# resonance there keeps its height. Each element has its own w:
#
# - of a change that passes speeds, and of the onset of a misfire, the frequency at which one order
#   twists the element most in the steady vibration at the speeds on the way, to five digits: a
#   flat maximum has no more, and the dashpots shall not hang on a rounding;
# - of a jolt, after which the line swings by itself, and where no order twists the element, the
#   natural frequency of the mode in which it has its largest share of the strain energy.
# ----------------------------------------------------------------------------

#: speeds of the first look; speeds about the best of it, each time this many times closer
_SPEEDS, _NEARBY, _CLOSER = 601, 17, 8


class Equivalent(NamedTuple):
    """`frequency` (e,) in rad/s and `damping` (e,) in N m s/rad, referred, 0 without loss.

    `resonance` (e,) says of which the frequency is a natural one.
    """

    frequency: FloatArray
    damping: FloatArray
    resonance: BoolArray


def without_loss(
    setup: Setup, speed: float, between: tuple[float, float] | None
) -> tuple[Line, Equivalent | None]:
    """The line at a crank speed with dashpots for loss factors, and these; None without any.

    `between` two speeds in rad/s orders count, None after a jolt.
    """
    line = setup.model.at(speed)
    lossy = line.loss_factor > 0.0
    if not np.any(lossy):
        return line, None
    natural = _most_strained(setup, line)
    frequency = natural if between is None else _most_twisted(setup, between)
    resonance = (frequency == 0.0) | (between is None)
    frequency = np.where(lossy, np.where(frequency > 0.0, frequency, natural), 0.0)
    of_loss = lossy & (frequency > 0.0)
    damping = np.where(
        of_loss, line.loss_factor * line.stiffness / np.where(of_loss, frequency, 1.0), 0.0
    )
    plain = line._replace(
        damping=line.damping + damping, loss_factor=np.zeros_like(line.loss_factor)
    )
    return plain, Equivalent(frequency, damping, resonance & lossy)


def _most_strained(setup: Setup, line: Line) -> FloatArray:
    """Natural frequency (e,) of the mode in which each element has its largest share of energy."""
    modes = setup.modes
    twist = modes.shape[:, line.first] - modes.shape[:, line.second]
    energy = line.stiffness * twist**2
    total = energy.sum(axis=1, keepdims=True)
    moving = (modes.frequency > 0.0)[:, None] & (total > 0.0)
    share = np.where(moving, energy / np.where(moving, total, 1.0), 0.0)
    found: FloatArray = modes.frequency[np.argmax(share, axis=0)]
    return found


def _most_twisted(setup: Setup, between: tuple[float, float]) -> FloatArray:
    """Frequency (e,) at which a single order twists each element most, 0 where none does."""
    low, high = min(between), max(between)
    low = max(low, 1e-3 * high)
    cards = setup.drive.card_speed
    if len(cards) > 1:
        low, high = (float(np.clip(one, cards[0], cards[-1])) for one in (low, high))
    speeds = np.linspace(low, high, _SPEEDS if high > low else 1)
    order, natural = setup.drive.order, setup.modes.frequency
    critical = np.divide.outer(natural[natural > 0.0], order).ravel()
    inside = critical[(critical > low) & (critical < high)]
    speeds = np.union1d(speeds, inside)

    def largest(speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest twist (s, e) of one order at speeds (s,) and its frequency (s, e)."""
        state = solved(setup.model, setup.drive, speed)
        twist = np.where(np.isfinite(state.twist), np.abs(state.twist), 0.0)
        best = np.argmax(twist, axis=1)
        return np.max(twist, axis=1), np.take_along_axis(state.frequency, best, axis=1)

    size, frequency = largest(speeds)
    top = np.argmax(size, axis=0)
    section = np.arange(size.shape[1])
    best, found = size[top, section], frequency[top, section]
    for one in section[setup.model.line.loss_factor > 0.0]:
        at = float(speeds[top[one]])
        width = float(speeds[1] - speeds[0]) if len(speeds) > 1 else 0.0
        while width > 1e-7 * high:
            near = np.clip(at + width * np.linspace(-1.0, 1.0, _NEARBY), low, high)
            size, frequency = largest(near)
            place = int(np.argmax(size[:, one]))
            if size[place, one] > best[one]:
                best[one], found[one] = size[place, one], frequency[place, one]
                at = float(near[place])
            width /= _CLOSER
    return np.array([float(f"{one:.5g}") for one in np.where(best > 0.0, found, 0.0)])


# ----------------------------------------------------------------------------
# The stretches of a change in time.
# ----------------------------------------------------------------------------

#: share of the whole change of speed within which a card lies at the end of a stretch
_CLOSE = 1e-9
#: share of a start from rest during which torque of the cylinders and acceleration grow evenly
RAMP = 0.25
#: share of any other change during which the acceleration grows, and of all in which it fades
SWING = 0.1
#: changes after which the line swings by itself
_JOLTS = ("load_step", "short_circuit", "torque_history", "clutch_in")
#: share of the time within which rows of a table are equally far apart
_EVEN = 1e-9


class Journey(NamedTuple):
    """What the march in time needs; `order` (m + 1,) begins with 0, the mean.

    `moving` (2,) is the span of time in s with changing speed, empty where it is constant.
    `reaction` (n,) are the shares that take what the mean torques leave over, None by inertia.
    `ends` are what lasts before and after a change at constant speed. `equivalent` are the dashpots
    of the line that stand for loss factors.
    """

    line: Line
    order: FloatArray
    stretches: tuple[Stretch, ...]
    speed: float
    start: str
    reaction: FloatArray | None
    moving: tuple[float, float]
    ends: tuple[Stretch, ...] = ()
    equivalent: Equivalent | None = None

    @property
    def passes(self) -> bool:
        """Whether the speed changes along a prescribed way."""
        return self.moving[1] > self.moving[0]

    @property
    def fastest(self) -> float:
        """Largest acceleration of the crank in magnitude, in rad/s^2."""
        ends = [
            (one.acceleration, one.acceleration + one.acceleration_rate * one.duration)
            for one in self.stretches
        ]
        return float(np.max(np.abs(ends)))


def running(case: "Case") -> "Case":
    """The case as it runs during its change: no cylinder of an engine that stops has fuel."""
    assert case.response is not None and case.response.torsion is not None
    torsion = case.response.torsion
    if torsion.transient is None or torsion.transient.kind != "stop":
        return case
    if not has_crank_train(case.machine):
        return case
    names = tuple(one.name for one in case.machine.crank_train.cylinders)
    torsion = torsion.model_copy(update={"misfire": names, "misfire_kind": "motored"})
    response = case.response.model_copy(update={"torsion": torsion})
    return case.model_copy(update={"response": response})


def journey(setup: Setup, machine: "Machine", options: Transient) -> Journey:
    """The stretches of a change."""
    constant = options.kind in AT_CONSTANT_SPEED
    order = np.append(0.0, setup.drive.order)
    line, equivalent = dampable(setup, options)
    if constant:
        before = options.time_before or setup.drive.firing.cycle / setup.speed
        parts, ends = _steps(setup, machine, options, before)
        return Journey(
            line, order, parts, setup.speed, "steady", None, (0.0, 0.0), ends, equivalent
        )
    driven = np.zeros(line.inertia.size)
    driven[setup.shaft.load_freedom] = 1.0
    begin = 0.0 if options.kind == "start" else float(options.start or 0.0)
    end, before = float(options.stop or 0.0), 0.0 if begin == 0.0 else options.time_before
    duration = options.duration
    if duration is None:
        assert options.acceleration is not None
        duration = abs(end - begin) / options.acceleration
        duration /= 1.0 - 0.5 * (_ramp_share(options.kind) + SWING)
    parts = _held(setup, begin, before) + _sweep(setup, begin, end, duration, options.kind)
    if end > 0.0:
        parts += _held(setup, end, options.time_after)
    start = "steady" if begin > 0.0 else "rest"
    moving = (before, before + duration)
    return Journey(line, order, parts, begin, start, driven, moving, equivalent=equivalent)


def dampable(setup: Setup, options: Transient) -> tuple[Line, Equivalent | None]:
    """The line with a form in time, and what stands for loss factors.

    Dampings that follow the speed are those of the mean speed of a change of it.
    """
    if options.kind in _JOLTS:
        return without_loss(setup, setup.speed, None)
    if options.kind in AT_CONSTANT_SPEED:
        return without_loss(setup, setup.speed, (setup.speed, setup.speed))
    ends = options.start or 0.0, options.stop or 0.0
    return without_loss(setup, 0.5 * sum(ends), ends)


def torques(setup: Setup, speed: float) -> tuple[ComplexArray, ComplexArray]:
    """Gas (n, m + 1) in N m and inertia (n, m + 1) in N m per (rad/s)^2 at one speed, mean first.

    Beyond the speeds of the cards the nearest card holds: a run may begin at rest. What is given at
    stations stands with the gas, or, where it goes with the square of the speed, with the inertia.
    """
    asked, drive, n = speed, setup.drive, setup.model.line.inertia.size
    if len(drive.card_speed):
        speed = float(np.clip(speed, drive.card_speed[0], drive.card_speed[-1]))
    share, on = drive.weights(np.asarray(speed)), placed(drive.freedom, n).T
    mean, waves = share @ drive.mean.value, np.tensordot(share, drive.gas.value, 1)
    gas = on @ np.vstack([mean, waves]).T
    inertia = np.zeros_like(gas)
    inertia[:, 1:] = on @ drive.inertia.value.T
    for column, place, harmonic in drive.given:
        at, amplitude, law = (drive.freedom[place], column + 1), harmonic.amplitude, harmonic.law
        if isinstance(law, SpeedLaw) and law.exponent == 2.0 and not len(law.entry):
            inertia[at] += amplitude * law.value / law.reference**2
        else:
            gas[at] += amplitude * law.at(np.array([asked]))[0]
    return gas, inertia


def _taken(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """What is driven, as the case gives it: loads (k, n) in N m/(rad/s)^e, exponents e (k,).

    What is left the load station takes.
    """
    shaft = setup.shaft
    exponent = np.unique(shaft.taken_exponent)
    load = np.zeros((len(exponent), len(shaft.freedom_names)))
    row = np.searchsorted(exponent, shaft.taken_exponent)
    # it brakes, whichever way its shaft turns
    size = shaft.taken_torque * np.abs(shaft.station_ratio[shaft.taken_station])
    size = size / setup.speed**shaft.taken_exponent
    np.subtract.at(load, (row, shaft.freedom[shaft.taken_station]), size)
    return load, exponent


def _held(setup: Setup, speed: float, duration: float) -> tuple[Stretch, ...]:
    if duration <= 0.0:
        return ()
    gas, inertia = torques(setup, speed)
    load, exponent = _taken(setup)
    return (stretch(duration, 0.0, gas, inertia, load=load, exponent=exponent),)


def _ramp_share(kind: str) -> float:
    """Share of the time in which the acceleration grows."""
    return RAMP if kind == "start" else SWING


def _sweep(
    setup: Setup, begin: float, end: float, duration: float, kind: str
) -> tuple[Stretch, ...]:
    """From one speed to another; cut at the speeds of the gas cards, between which gas is linear.

    The acceleration grows and fades along straight lines: one that jumped would strike the line.
    The torque of the cylinders grows from rest and leaks away towards standstill.
    """
    from scipy.optimize import brentq

    ramp = _ramp_share(kind)
    plain = np.array([0.0, ramp, 1.0 - SWING, 1.0])
    if kind == "stop":
        plain = np.insert(plain, 2, 1.0 - RAMP)

    def profile(share: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Speeds (k,) in rad/s and their slopes (k,) against the share of the time."""
        growth = np.minimum(np.minimum(share / ramp, (1.0 - share) / SWING), 1.0)
        added = 0.5 * (growth[1:] + growth[:-1]) * np.diff(share)
        speed = begin + (end - begin) * np.append(0.0, np.cumsum(added) / added.sum())
        return speed, (end - begin) / added.sum() * growth

    def beyond(at: float, card: float) -> float:
        share = np.union1d(plain, at)
        return float(profile(share)[0][np.searchsorted(share, at)] - card)

    known, close = profile(plain)[0], _CLOSE * abs(end - begin)
    cards = [
        brentq(beyond, 0.0, 1.0, args=(card,), xtol=1e-16, rtol=1e-15)
        for card in setup.drive.card_speed
        if min(begin, end) < card < max(begin, end) and np.all(np.abs(known - card) > close)
    ]
    share = np.union1d(plain, cards)
    speed, slope = profile(share)
    fired = {"start": share, "stop": 1.0 - share}.get(kind, np.ones_like(share))
    scale = np.minimum(fired / RAMP, 1.0)
    load, exponent = _taken(setup)
    at = [torques(setup, float(one)) for one in speed]
    return tuple(
        stretch(
            duration * length,
            float(slope[k]) / duration,
            *at[k],
            scale=(float(scale[k]), float(scale[k + 1])),
            load=load,
            exponent=exponent,
            acceleration_rate=float(slope[k + 1] - slope[k]) / (duration**2 * length),
            gas_end=at[k + 1][0],
        )
        for k, length in enumerate(np.diff(share))
    )


def _steps(
    setup: Setup, machine: "Machine", options: Transient, before: float
) -> tuple[tuple[Stretch, ...], tuple[Stretch, ...]]:
    """Constant speed before and after, and the two states that last.

    What is left over afterwards slows the line as a whole.
    """
    shaft, speed = setup.shaft, setup.speed
    gas, inertia = torques(setup, speed)
    load = -shaft.mean_load(speed)
    if not np.any(setup.model.line.ground_stiffness):
        load[shaft.load_freedom] -= float(np.sum(gas[:, 0].real + load))
    first = stretch(before, 0.0, gas, inertia, load=load)
    last = first._replace(duration=options.time_after)
    if options.kind == "misfire_onset":
        gas_after = gas - _lost(setup, machine, str(options.cylinder))
        last = last._replace(gas=gas_after, gas_end=gas_after)
        return (first, last), (first, last)
    assert options.on is not None
    station = shaft.station_names.index(options.on)
    share = np.zeros_like(load)
    # positive torques brake, whichever way the shaft turns
    share[shaft.freedom[station]] = -abs(float(shaft.station_ratio[station]))
    if options.kind == "short_circuit":
        return (first, last._replace(in_time=_decaying(options, share))), (first, first)
    if options.kind == "load_step":
        assert options.torque is not None
        last = last._replace(load=last.load + options.torque * share)
        return (first, last), (first, last)
    assert options.history is not None
    lasting = last._replace(load=last.load + options.history.torque[-1] * share)
    return (first, *_along_table(last, options, share)), (first, lasting)


def _decaying(options: Transient, share: FloatArray) -> TorqueInTime:
    """The sum of decaying sines of a short circuit."""
    amplitude = [-1j * one.amplitude * np.exp(1j * one.phase) for one in options.terms]
    rate = [complex(-1.0 / one.time_constant, one.frequency) for one in options.terms]
    return TorqueInTime(share, np.array(amplitude), np.array(rate))


def _along_table(part: Stretch, options: Transient, share: FloatArray) -> tuple[Stretch, ...]:
    """A stretch cut at the rows of a table of torques; its last torque goes on."""
    assert options.history is not None
    time, torque = (np.array(one) for one in (options.history.time, options.history.torque))
    lengths = np.diff(time)
    if np.ptp(lengths) <= _EVEN * time[-1]:  # equal steps share what is computed of a step
        lengths = np.full_like(lengths, lengths.mean())
    slopes = np.append(np.diff(torque) / lengths, 0.0)
    lengths = np.append(lengths, max(part.duration - time[-1], 0.0))
    none = np.zeros(0, dtype=complex)
    parts, left = [], part.duration
    for length, start, slope in zip(lengths, torque, slopes, strict=True):
        duration = min(float(length), left)
        if duration <= _EVEN * part.duration:
            continue
        acts = TorqueInTime(share, none, none, float(start), float(slope))
        parts.append(part._replace(duration=duration, in_time=acts))
        left -= duration
    return tuple(parts)


def _lost(setup: Setup, machine: "Machine", name: str) -> ComplexArray:
    """Gas torque (n, m + 1) that goes with a cylinder which stops firing."""
    drive, shaft = setup.drive, setup.shaft
    place = drive.firing.names.index(name)
    healthy = drive.healthy(setup.speed)
    value, mean = healthy.gas.value, healthy.mean.value
    if setup.torsion.misfire_kind == "motored":
        left = weighted(motored_torque(machine, drive), drive.weights(np.asarray(setup.speed)))
        value, mean = value - left.gas.value, mean - left.mean.value
    scale = drive.firing.pressure_scale[place] * shaft.station_ratio[shaft.cylinder_station[place]]
    turned = phasor(drive.order, drive.firing.angle[place])
    lost = np.zeros((setup.model.line.inertia.size, len(drive.order) + 1), dtype=complex)
    lost[shaft.cylinder_freedom[place]] = scale * np.append(mean, value * turned)
    return lost


# ----------------------------------------------------------------------------
# Clutch-in: before it each part turns steadily. What keeps it so, the governor of the engine and
# what drives or brakes the other part, goes on unchanged, so that mean torques are left out and the
# friction of the clutch alone moves momentum from one part to the other.
# ----------------------------------------------------------------------------

#: times of the slip that are kept
_TIMES = 400


def run_clutch(
    scene: Scene, setup: Setup, options: Transient, rtol: float
) -> tuple[Journey, TransientRun]:
    """The run with what lasts after it; emits what the clutch does."""
    assert options.clutch is not None and options.driven_speed is not None
    assert options.friction_torque is not None
    line, equivalent = dampable(setup, options)
    parts = scene.case.machine.shaft_line
    assert parts is not None
    shaft, speed, cycle = setup.shaft, setup.speed, setup.drive.firing.cycle
    element = shaft.section_names.index(options.clutch)
    ratio = abs(float(shaft.section_ratio[element]))
    joined = np.arange(line.stiffness.size) != element
    part = part_of(line, joined)
    clutch = Clutch(
        element,
        options.friction_torque * ratio,
        options.engaging_time or 0.0,
        np.asarray(part != part[shaft.freedom[Layout(parts).crank]]),
        options.driven_speed / ratio,
    )
    order = np.append(0.0, setup.drive.order)
    before = options.time_before or cycle / speed

    def vibrating(at: float) -> Stretch:
        gas, inertia = torques(setup, at)
        gas[:, 0] = 0.0
        return stretch(1.0, 0.0, gas, inertia)

    found = engage(line, order, clutch, vibrating, speed, before, options.time_after, cycle, rtol)
    _emit_clutch(scene, setup, line, clutch, found, ratio, before)
    scene.warn(
        "clutch-in: both parts of the line turn steadily before it; the torques that balance their "
        "means are assumed constant, and only the friction of the clutch changes the speeds"
    )
    held = np.isfinite(found.held)
    ends = (vibrating(found.common_speed),) if held else ()
    path = Journey(
        line, order, found.run.course.parts, found.common_speed, "steady", None, (0.0, 0.0), ends,
        equivalent,
    )  # fmt: skip
    return path, found.run


def _emit_clutch(
    scene: Scene, setup: Setup, line: Line, clutch: Clutch, found: Engagement, ratio: float,
    before: float,
) -> None:  # fmt: skip
    """Slip, heat and common speed; torques and speeds of the clutch on its own shaft."""
    run, stem = found.run, f"{TRANSIENT}clutch/"
    # the errors of the torques, as energies, in the velocities of the two ends
    energy = run.torque_error / np.sqrt(np.where(line.stiffness > 0.0, line.stiffness, np.inf))
    ends = line.inertia[[line.first[clutch.element], line.second[clutch.element]]]
    slack = float(np.max(energy) / np.sqrt(np.min(ends))) + 1e-12 * setup.speed
    inertia = np.array([line.inertia[~clutch.driven].sum(), line.inertia[clutch.driven].sum()])
    rate = clutch.friction_torque * float((1.0 / inertia).sum())
    late = 2.0 * (1 + found.engagements) * slack / rate + 1e-12 * float(run.course.time[-1])
    scene.emit(f"{stem}slip_time", found.slip_time, late)
    heat_error = found.heat_error + clutch.friction_torque * slack * found.slip_time
    scene.emit(f"{stem}heat", found.heat, heat_error)
    scene.emit(f"{stem}engagements", found.engagements, 0.0)
    if np.isfinite(found.held):
        scene.emit(f"{stem}held", found.held - before, late)
        scene.emit(f"{stem}common_speed", found.common_speed, 1e-12 * setup.speed + rate * late)
        use_error = float(run.torque_error[clutch.element]) / clutch.friction_torque + 1e-12
        scene.emit(f"{stem}utilisation", found.use, use_error)
    else:
        scene.warn(
            f"the clutch still slips after {float(run.course.time[-1]) - before:.4g} s: "
            "increase `time_after` to reach the common speed of both parts"
        )
    time, slip = _slips(line, clutch, found)
    scene.emit(f"{stem}slip_speed", ratio * slip, ratio * slack, {"clutch_time": time})


def _slips(line: Line, clutch: Clutch, found: Engagement) -> tuple[FloatArray, FloatArray]:
    """Times in s and slips in rad/s, referred, at ends of steps."""
    times, values = [], []
    run, last = found.run, found.run.blocks[-1]
    for block, states in zip(run.blocks, run.states, strict=True):
        since = float(run.course.time[block.stretch]) + block.offset
        kept = states if block is last else states[:-1]
        times.append(since + block.step * np.arange(len(kept)))
        slips = found.slip[block.stretch] != 0
        view = (
            slip_view(run.drive.systems[block.stretch], line, clutch) if slips else 0.0 * states[0]
        )
        values.append(kept @ view)
    time, value = np.concatenate(times), np.concatenate(values)
    every = max(1, -(-len(time) // _TIMES))
    return time[::every], value[::every]
