"""Adapter, continued: what a case may ask for beside the running state of a roll machine."""

import numpy as np

from vibecalc.case.roll_tables import Roll
from vibecalc.machine.roll import RollParts, roll_drive
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.roll import FORCES, ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.roll_observed import Looks, Seen
from vibecalc.response.roll.altered import changes
from vibecalc.response.roll.classical import by_cylinder, classical
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.running import Running, running_state
from vibecalc.response.roll.sensitivity import sensitivity
from vibecalc.response.roll.turn import Turn, harmonics, level
from vibecalc.response.roll.ways import Asked, find

#: dB; what rounding leaves in a level
_ROUNDING = 1e-11
#: dB below the largest harmonic, from which on there is only rounding
_SILENT = 240.0
#: parameters are altered by this share, up and down
_SHARE = 0.1
#: crank angles at which forces are held against those of the textbook
_GRID = 1441


def emit_interpolations(
    scene: Scene, parts: RollParts, options: Roll, machine: RollMachine, motor: RollDrive
) -> None:
    """Levels with every way to read the gas tables, and what these differ by."""
    found, doubt = [], []
    orders = np.arange(1, options.orders + 1)
    for way in parts.interpolations:
        drive = motor._replace(gas=roll_drive(parts, way).gas)
        running = running_state(
            machine,
            drive,
            rtol=scene.case.accuracy.rtol,
            orders=options.orders,
            started_at=options.started_at,
        )
        each = [
            _levels(machine, drive, state.turn, options.orders)
            for state in (running.state, running.check)
        ]
        found.append(each[0])
        doubt.append(np.abs(_apart(*each)))
    if not found:
        return
    values, error = np.array(found), np.array(doubt) + _ROUNDING
    axes = {"interpolant": parts.interpolations, "order": orders}
    scene.emit(f"{ROOT}/interpolation/level", values, error, axes)
    known = np.all(np.isfinite(values), axis=0)
    lowest, highest = (np.where(known, f(values, axis=0), 0.0) for f in (np.min, np.max))
    scene.emit(
        f"{ROOT}/interpolation/spread", highest - lowest, 2.0 * np.max(error), {"order": orders}
    )


def emit_methods(
    scene: Scene,
    options: Roll,
    machine: RollMachine,
    drive: RollDrive,
    running: Running,
) -> None:
    """Levels by other methods, less those of the method of the case, and the work of each."""
    fading = float(np.max(np.abs(running.multiplier)))
    asked = Asked(None, options.step, options.started_at, running.state.momentum, fading)
    levels, doubts, works = [], [], []
    names = tuple(dict.fromkeys(options.compare))
    own, twin = (
        _levels(machine, drive, state.turn, options.orders)
        for state in (running.state, running.check)
    )
    for name in names:
        if name == "collocation":
            turn, finer = running.state.turn, running.check.turn
            work = running.state.evaluations
        else:
            found = find(name, machine, drive, asked)
            turn, finer, work = found.turn, found.finer, found.work
        each = [_levels(machine, drive, one, options.orders) for one in (turn, finer)]
        levels.append(each[0])
        # no other method is known better than it agrees with collocation
        apart = np.abs(_apart(each[0], own)) + np.abs(_apart(own, twin))
        doubts.append(np.maximum(2.0 * np.abs(_apart(*each)), apart) + _ROUNDING)
        works.append(work)
    axes = {"method": names, "order": np.arange(1, options.orders + 1)}
    values, error = np.array(levels), np.array(doubts)
    scene.emit(f"{ROOT}/method/level", values, error, axes)
    scene.emit(f"{ROOT}/method/difference", _apart(values, own), error, axes)
    scene.emit(f"{ROOT}/method/work", works, 0.0, axes)


def emit_sensitivity(
    scene: Scene,
    parts: RollParts,
    options: Roll,
    machine: RollMachine,
    drive: RollDrive,
    running: Running,
) -> None:
    """Slopes of the levels by every parameter, and what ten percent more and less of each do.

    All for the orders that are there at all.
    """
    levels = _levels(machine, drive, running.state.turn, options.orders)
    there = levels > np.max(levels) - _SILENT
    orders = [int(n) for n in np.arange(1, options.orders + 1)[there]]
    found = sensitivity(
        machine,
        drive,
        orders,
        parts.names,
        points=running.state.points,
        started_at=options.started_at,
    )
    axes = {"parameter": found.parameters, "order": orders}
    scene.emit(f"{ROOT}/sensitivity/level", found.value, found.error, axes)
    altered = changes(
        machine,
        drive,
        orders,
        parts.names,
        (1.0 + _SHARE, 1.0 - _SHARE),
        points=running.state.points,
        started_at=options.started_at,
    )
    for word, change in zip(("more", "less"), altered, strict=True):
        axes = {"parameter": change.parameters, "order": orders}
        scene.emit(f"{ROOT}/sensitivity/ten_percent_{word}", change.value, change.error, axes)
        for name, reason in change.lost:
            scene.warn(f"sensitivity: nothing is said of ten percent {word} of {name}: {reason}")
    scene.cite(
        "central differences in the logarithm of each parameter, extrapolated",
        "slopes of the levels of the shell",
        "docs/theory_roll.md, section 5",
    )
    scene.cite(
        "the running state of the machine with each parameter ten percent larger and smaller",
        "what to change on the machine",
        "docs/theory_roll.md, section 5",
    )


def emit_classical(
    scene: Scene,
    parts: RollParts,
    looks: Looks,
    orders: int,
) -> None:
    """What constant speed and a fixed shell get wrong in the forces at the pistons."""
    numbers = np.arange(1.0, orders + 1)
    each = looks.read(lambda seen: _mistakes(seen, numbers))
    for name in FORCES:
        largest = np.max(np.abs(each[0][name][0]))
        axes = {"cylinder": parts.names, "order": numbers.astype(int)}
        for what, *values in zip(_MISTAKES, *(found[name] for found in each), strict=True):
            error = looks.error(*values) + 1e-13 * largest
            scene.emit(f"{ROOT}/classical/{name}_{what}", values[0], error, axes)


_MISTAKES = ("peak", "error", "error_by_order")


def _mistakes(
    seen: Seen, numbers: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray, np.ndarray]]:
    """Peak, largest error over the peak, error of the harmonics; for each force, each cylinder."""
    machine, drive = seen.machine, seen.drive
    plain = classical(machine, drive, seen.turn, numbers)
    right = readings(machine, drive, seen.turn)
    # peaks and errors on an even grid, the same for every dial
    even = seen.course(np.linspace(0.0, 2.0 * np.pi, _GRID))
    flat, exact = classical(machine, drive, even, numbers), readings(machine, drive, even)
    found = {}
    for name, spectrum in (
        ("rod_force", plain.rod_harmonics),
        ("wall_force", plain.wall_harmonics),
    ):
        textbook = np.asarray(getattr(flat, name))[0]
        true = np.asarray(getattr(exact, name))[0]
        peak = np.max(np.abs(true), axis=0)
        off = np.max(np.abs(textbook - true), axis=0)
        harmonic = by_cylinder(seen.turn, np.asarray(getattr(right, name)), numbers)[0]
        found[name] = (
            np.max(np.abs(textbook), axis=0),
            off / np.where(peak > 0.0, peak, 1.0),
            spectrum[0] - harmonic,
        )
    return found


def _levels(machine: RollMachine, drive: RollDrive, turn: Turn, orders: int) -> FloatArray:
    """Levels of the shell's acceleration; orders that are nothing but rounding are zero, -inf."""
    read = readings(machine, drive, turn, pistons=False)
    found = level(harmonics(turn, read.shell_acceleration, np.arange(1.0, orders + 1)))[0]
    return np.where(found > np.max(found) - _SILENT, found, -np.inf)


def _apart(one: FloatArray, other: FloatArray) -> FloatArray:
    """Differences of levels; none where both are zero, or one of them."""
    both = np.isfinite(one) & np.isfinite(other)
    return np.where(both, np.where(both, one, 0.0) - np.where(both, other, 0.0), 0.0)
