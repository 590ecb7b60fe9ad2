"""Adapter: rotor, pistons and shell in time, from a start to what becomes of it."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.model import build_roll, roll_drive
from vibecalc.roll.results import HISTORIES, PEAKS, START, STEPPED
from vibecalc.roll.start_up import StartUp as StartUpResult
from vibecalc.roll.start_up import start_angles, start_up
from vibecalc.roll.start_up_readings import QUANTITIES, mean_speed
from vibecalc.roll.start_up_system import FULL_LOAD, LoadSteps
from vibecalc.roll.tables import StartUp

#: intervals of the histories
BUCKETS = 400
#: the tolerance of a step is this share of the case's, within these
SHARE, FINEST, COARSEST = 0.1, 1e-10, 1e-6
_ROUNDING = 64.0 * EPSILON
_RUNS = ("settled", "running")
_TURNS_OVER = (*_RUNS, "crawling")
_ANGLES = f"{START}/start_angles/"


def run_start_up(scene: Scene) -> None:
    """Emit what becomes of the start, its peaks, energies and histories, and the start angles."""
    response = scene.case.response
    assert response is not None and response.start_up is not None
    options, parts = response.start_up, build_roll(scene.case)
    machine, drive = parts.machine, roll_drive(parts)
    tolerance = min(max(SHARE * scene.case.accuracy.rtol, FINEST), COARSEST)
    if scene.wants(*below(f"{START}/", without=(_ANGLES,))):
        _emit_march(scene, options, machine, drive, tolerance)
    if options.angles is not None and scene.wants(*below(_ANGLES)):
        emit_start_angles(scene, options, machine, drive)


def load_of(options: StartUp) -> LoadSteps:
    """The factor on the gas forces in time."""
    if options.load is None:
        return FULL_LOAD
    return LoadSteps(np.array(options.load.time), np.array(options.load.factor))


def _emit_march(
    scene: Scene, options: StartUp, machine: RollMachine, drive: RollDrive, tolerance: float
) -> None:
    scene.cite(
        "Dormand and Prince's pair of order 5 in time, a step ending on every kink; dry friction "
        "as it is",
        "start-up and changes of load",
        "docs/theory_roll.md; cf. Hairer, Norsett and Wanner (1993), sections II.5 and II.6",
    )
    result = start_up(
        machine,
        drive,
        duration=options.duration,
        crank_angle=options.crank_angle,
        speed=options.speed,
        load=load_of(options),
        settled=options.settled,
        tolerance=tolerance,
        buckets=BUCKETS,
    )
    if result.verdict not in _RUNS:
        scene.warn(f"the machine does not start within {options.duration:.6g} s: {result.reason}")
    elif result.verdict == "running":
        scene.warn(
            f"start-up: {result.reason} within {100.0 * options.settled:.3g} % after "
            f"{options.duration:.6g} s; a longer duration shows when"
        )
    scene.emit_all({f"{START}/{name}": value for name, value in _verdict(result).items()})
    _emit_over_time(scene, result)
    if options.load is not None:
        _emit_load(scene, result)


def _verdict(result: StartUpResult) -> dict[str, Any]:
    """What has become of the start, its peaks and its energies, by name."""
    runs, error = result.verdict in _RUNS, result.error
    known: dict[str, float] = {"started": int(runs), "settled": int(result.verdict == "settled")}
    turning = result.verdict in _TURNS_OVER and result.speed is not None
    numbers = {"running_speed": (result.speed, error.get("speed", 0.0)) if turning else (0.0, 0.0)}
    for name in ("time_to_speed", "time_to_steady"):
        value = getattr(result, name) if runs else None
        numbers[name] = (np.inf, 0.0) if value is None else (value, error.get(name, 0.0))
    known["turns_to_steady"] = np.inf
    if runs and result.time_to_steady is not None:
        begun = result.turns.begin
        since = begun >= float(result.stretches.begin[-1])
        known["turns_to_steady"] = float(np.sum(since & (begun < result.time_to_steady)))
    top = result.peaks
    for name in PEAKS:
        row = QUANTITIES.index(name)
        numbers[f"{name}_peak"] = top.value[row], top.error[row]
        numbers[f"{name}_peak_time"] = top.time[row], top.time_error[row]
    work = result.energies
    size = _ROUNDING * (abs(work.motor) + abs(work.gas) + abs(work.gain))
    for name, field, sign in _WORKS:
        value = sign * getattr(work, field) + 0.0
        numbers[f"energy/{name}"] = value, error[field] + size
    return known | {
        name: Bounded(np.asarray(value), np.asarray(off)) for name, (value, off) in numbers.items()
    }


#: works by name, the field of each, and its sign
_WORKS = (
    ("motor", "motor", 1.0),
    ("gas", "gas", -1.0),
    ("friction", "friction", -1.0),
    ("mounts", "mounts", -1.0),
    ("stored", "gain", 1.0),
    ("residual", "residual", 1.0),
)


def _emit_over_time(scene: Scene, result: StartUpResult) -> None:
    history, turns, off = result.history, result.turns, result.turn_error
    speed = mean_speed(turns)
    axes = {"start_time": history.time[1:], "turn": np.arange(1, len(turns.begin) + 1)}
    for name in HISTORIES:
        row = QUANTITIES.index(name)
        for end, values in (("low", history.low), ("high", history.high)):
            error = result.history_error[row]
            scene.emit(f"{START}/history/{name}_{end}", values[row], error, axes)
    for name, values, error in (
        ("begin", turns.begin, off.begin),
        ("speed", speed, speed / turns.period * off.period),
        ("shell_acceleration", turns.amplitude, off.amplitude),
    ):
        scene.emit(f"{START}/turn/{name}", values, error, axes)


def _emit_load(scene: Scene, result: StartUpResult) -> None:
    steps = result.stretches
    axes = {"load_step": steps.begin}
    scene.emit(f"{START}/load/factor", steps.factor, 0.0, axes)
    scene.emit(f"{START}/load/speed", steps.speed, result.stretch_speed_error, axes)
    for name in STEPPED:
        row = QUANTITIES.index(name)
        values, error = steps.peaks.value[:, row], steps.peaks.error[:, row]
        scene.emit(f"{START}/load/{name}_peak", values, error, axes)


# ----------------------------------------------------------------------------
# The crank angles from which a machine at rest starts at all, for the start-up stage.
# ----------------------------------------------------------------------------

#: rad, within which every border is enclosed
WIDTH = 1e-5
#: of one step of these marches, which moves the borders by less
TOLERANCE = 1e-6


def emit_start_angles(
    scene: Scene, options: StartUp, machine: RollMachine, drive: RollDrive
) -> None:
    """Emit the intervals of angles, under the largest load of the case from the start on."""
    assert options.angles is not None
    largest = 1.0 if options.load is None else max(options.load.factor)
    result = start_angles(
        machine,
        drive,
        duration=options.start_within or options.duration,
        angles=options.angles,
        load=LoadSteps(np.zeros(1), np.array([largest])),
        width=WIDTH,
        tolerance=TOLERANCE,
    )
    stem = f"{START}/start_angles"
    starts = np.asarray(result.starts, dtype=np.int64)
    scene.emit(f"{stem}/starts", starts, 0.0, {"start_angle": result.angle})
    axes = {"start_interval": np.arange(1, len(result.interval) + 1)}
    for column, name in enumerate(("lower", "upper")):
        scene.emit(f"{stem}/{name}", result.interval[:, column], result.error + TOLERANCE, axes)
    moved = 2 * len(result.interval) * TOLERANCE / (2.0 * np.pi)
    error = result.fraction_error + moved + 8.0 * EPSILON
    scene.emit(f"{stem}/fraction", result.fraction, error)
    if result.islands:
        scene.warn(
            "start angles: more than one border between a start and a failed start; "
            "there are probably more: examine more angles"
        )
    dry = machine.friction_torque > 0.0 or machine.piston_friction > 0.0
    if 0.0 < result.fraction < 1.0 and not dry:
        scene.warn(
            "start angles: without dry friction a rocking machine may start on a later swing, so "
            "the start angles depend on the time limit, "
            f"{options.start_within or options.duration:.6g} s"
        )
