"""Adapter: rotor, pistons and shell in time, from a start to what becomes of it."""

from typing import Any

import numpy as np

from vibecalc.case.roll_tables import StartUp
from vibecalc.machine.roll import build_roll, roll_drive
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.start_up import HISTORIES, PEAKS, ROOT, STEPPED
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_plan import below
from vibecalc.pipeline.stages.start_angles import emit_start_angles
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.start_up import StartUp as Found
from vibecalc.response.roll.start_up import start_up
from vibecalc.response.roll.start_up_states import FULL_LOAD, Load
from vibecalc.response.roll.start_up_view import QUANTITIES, mean_speed

#: intervals of the histories
BUCKETS = 400
#: the tolerance of a step is this share of the case's, within these
SHARE, FINEST, COARSEST = 0.1, 1e-10, 1e-6
_ROUNDING = 64.0 * EPSILON
_RUNS = ("settled", "running")
_TURNS_OVER = (*_RUNS, "crawling")
_ANGLES = f"{ROOT}/start_angles/"


def run(scene: Scene) -> None:
    """Emit what becomes of the start, its peaks, energies and histories, and the start angles."""
    response = scene.case.response
    if response is None or response.start_up is None:
        raise ValueError("the case has no [response.start_up]")
    options, parts = response.start_up, build_roll(scene.case)
    machine, drive = parts.machine, roll_drive(parts)
    tolerance = min(max(SHARE * scene.case.accuracy.rtol, FINEST), COARSEST)
    if scene.wants(*below(f"{ROOT}/", without=(_ANGLES,))):
        _emit_march(scene, options, machine, drive, tolerance)
    if options.angles is not None and scene.wants(*below(_ANGLES)):
        emit_start_angles(scene, options, machine, drive)


def load_of(options: StartUp) -> Load:
    """The factor on the gas forces in time."""
    if options.load is None:
        return FULL_LOAD
    return Load(np.array(options.load.time), np.array(options.load.factor))


def _emit_march(
    scene: Scene, options: StartUp, machine: RollMachine, drive: RollDrive, tolerance: float
) -> None:
    scene.cite(
        "Dormand and Prince's pair of order 5 in time, a step ending on every kink; dry friction "
        "as it is",
        "start-up and changes of load",
        "docs/theory_roll.md; cf. Hairer, Norsett and Wanner (1993), sections II.5 and II.6",
    )
    found = start_up(
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
    if found.verdict not in _RUNS:
        scene.warn(f"the machine does not start within {options.duration:.6g} s: {found.reason}")
    elif found.verdict == "running":
        scene.warn(
            f"start-up: {found.reason} within {100.0 * options.settled:.3g} % after "
            f"{options.duration:.6g} s; a longer duration shows when"
        )
    _emit_verdict(scene, options, found)
    _emit_peaks(scene, found)
    _emit_energies(scene, found)
    _emit_courses(scene, found)
    if options.load is not None:
        _emit_load(scene, found)


def _emit_verdict(scene: Scene, options: StartUp, found: Found) -> None:
    runs, error = found.verdict in _RUNS, found.error
    scene.emit(f"{ROOT}/started", int(runs))
    scene.emit(f"{ROOT}/settled", int(found.verdict == "settled"))
    turning = found.verdict in _TURNS_OVER and found.speed is not None
    scene.emit(
        f"{ROOT}/running_speed",
        found.speed if turning else 0.0,
        error.get("speed", 0.0) if turning else 0.0,
    )
    for name in ("time_to_speed", "time_to_steady"):
        value = getattr(found, name)
        known = value is not None and runs
        scene.emit(f"{ROOT}/{name}", value if known else np.inf, error.get(name, 0.0) * known)
    turns = np.inf
    if runs and found.time_to_steady is not None:
        since = float(found.stretches.begin[-1])
        begun = found.turns.begin
        turns = float(np.sum((begun >= since) & (begun < found.time_to_steady)))
    scene.emit(f"{ROOT}/turns_to_steady", turns)


def _emit_peaks(scene: Scene, found: Found) -> None:
    for name in PEAKS:
        row, top = QUANTITIES.index(name), found.peaks
        scene.emit(f"{ROOT}/{name}_peak", top.value[row], top.error[row])
        scene.emit(f"{ROOT}/{name}_peak_time", top.time[row], top.time_error[row])


def _emit_energies(scene: Scene, found: Found) -> None:
    work, error = found.energies, found.error
    taken = {
        "motor": work.motor,
        "gas": -work.gas,
        "friction": -work.friction,
        "mounts": -work.mounts,
        "stored": work.gain,
        "residual": work.residual,
    }
    size = _ROUNDING * (abs(work.motor) + abs(work.gas) + abs(work.gain))
    for name, value in taken.items():
        off = error["gain" if name == "stored" else name]
        scene.emit(f"{ROOT}/energy/{name}", value + 0.0, off + size)


def _emit_courses(scene: Scene, found: Found) -> None:
    axes: dict[str, Any] = {"start_time": found.history.time[1:]}
    for name in HISTORIES:
        row = QUANTITIES.index(name)
        for end, values in (("low", found.history.low), ("high", found.history.high)):
            error = found.history_error[row]
            scene.emit(f"{ROOT}/history/{name}_{end}", values[row], error, axes)
    turns, off = found.turns, found.turn_error
    axes = {"turn": np.arange(1, len(turns.begin) + 1)}
    speed = mean_speed(turns)
    scene.emit(f"{ROOT}/turn/begin", turns.begin, off.begin, axes)
    scene.emit(f"{ROOT}/turn/speed", speed, speed / turns.period * off.period, axes)
    scene.emit(f"{ROOT}/turn/shell_acceleration", turns.amplitude, off.amplitude, axes)


def _emit_load(scene: Scene, found: Found) -> None:
    steps = found.stretches
    axes = {"load_step": steps.begin}
    scene.emit(f"{ROOT}/load/factor", steps.factor, 0.0, axes)
    scene.emit(f"{ROOT}/load/speed", steps.speed, found.stretch_speed_error, axes)
    for name in STEPPED:
        row = QUANTITIES.index(name)
        values, error = steps.peaks.value[:, row], steps.peaks.error[:, row]
        scene.emit(f"{ROOT}/load/{name}_peak", values, error, axes)
