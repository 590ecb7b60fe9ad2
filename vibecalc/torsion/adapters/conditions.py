"""The worst of many conditions of the cylinders: all fire, each misfires, pressures differ."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.rounding import BoolArray, FloatArray, firsts_of_largest
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.bounds import limit_corners
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.motion import (
    ANGLE,
    STRESS,
    TORQUE,
    Motion,
    Reading,
    blocks,
    emit_readings,
    readings_of,
    stress_of,
)
from vibecalc.torsion.adapters.order_curves import degrees
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import (
    Drive,
    Setup,
    build_drive,
    line_speeds,
    motored_torque,
    with_gas,
)
from vibecalc.torsion.adapters.speeds import LEAST
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.critical_speeds import rough_range
from vibecalc.torsion.question_tables import condition_names
from vibecalc.torsion.results import CONDITIONS

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Conditions of the cylinders: the drive of all that fire with the gas of some changed.
# ----------------------------------------------------------------------------


def conditions_of(case: "Case", setup: Setup) -> dict[str, Drive]:
    """By name: all cylinders firing first, then each out, each out of balance, given pressures."""
    options, shaft = setup.torsion.conditions, setup.shaft
    assert options is not None
    well = build_drive(case, shaft, all_fire=True)
    scale = np.asarray(well.firing.pressure_scale, dtype=float)
    each, motored = np.eye(len(scale), dtype=bool), None
    if options.misfire == "each" and options.misfire_kind == "motored":
        motored = motored_torque(case.machine, well)
    rows = [(scale, out) for out in each if options.misfire == "each"]
    less, nobody = options.imbalance, np.zeros(len(scale), dtype=bool)
    if less is not None:
        rows += [(scale * np.where(one, 1.0 - less, 1.0), nobody) for one in each]
    if options.pressure_scale:
        rows.append((scale * np.array(options.pressure_scale), nobody))
    drives = [well, *(with_gas(well, shaft, *row, motored) for row in rows)]
    return dict(zip(condition_names(options, well.firing.names), drives, strict=True))


# ----------------------------------------------------------------------------
# Half ranges in all conditions. Where the line is the same in all of them it is eliminated once for
# each order and speed, with the torques of every condition on it; couplings that follow their load
# make another line of each. Of the sums over the cycle only those are formed that can be the
# largest.
# ----------------------------------------------------------------------------


def half_ranges(
    lines: list[Setup], readings: list[Reading], speed: FloatArray, every: BoolArray
) -> FloatArray:
    """Of the places of all readings (r,), in c conditions at speeds: (c, s, r); undamped inf.

    Those of places that `every` (r,) names, and the largest of the conditions of each other place;
    of the rest something lower.
    """
    first, parts = lines[0], []
    for part in blocks(first, len(speed), len(lines)):
        if all(one.model is first.model for one in lines):
            load = np.stack([one.drive.load(speed[part]) for one in lines])
            motions = [Motion(first, speed[part], load=load)]
        else:
            motions = [Motion(one, speed[part]) for one in lines]
        found = [
            np.concatenate([motion.orders(one.signal, one.place) for one in readings], axis=-1)
            for motion in motions
        ]
        masked = np.reshape([motion.masked for motion in motions], (len(lines), -1))
        # (c, r, s, m) with the orders last
        values = np.stack(found).reshape(len(lines), *found[0].shape[-3:])
        values = np.ascontiguousarray(np.moveaxis(values, -1, 1))
        low, high = rough_range(first.drive.order, values)
        needed = every[:, None] | (high >= low.max(axis=0))
        low[needed] = synthesis(first.drive.cycles, values[needed]).half_range
        parts.append(np.where(masked[:, None], np.inf, low))
    return np.moveaxis(np.concatenate(parts, axis=-1), 1, 2)


# ----------------------------------------------------------------------------
# Adapter: all conditions at the operating speed, the worst of them over the range.
# ----------------------------------------------------------------------------


def run_torsion_conditions(scene: Scene) -> None:
    """Emit half ranges by condition at speed, and over the range the worst with its condition."""
    setup = setup_of(scene)
    found = conditions_of(scene.case, setup)
    lines = [coupled(setup._replace(drive=drive)) for drive in found.values()]
    at = np.array([setup.speed])
    motions = [Motion(one, at, bounded=True) for one in lines]
    axes: dict[str, Any] = {"condition": tuple(found)}
    limit_axes = {**axes, "limit": np.arange(1, len(setup.torsion.limits) + 1)}

    def each(name: str, reading: Reading) -> None:
        value = stack([reading.of(one)[0] for one in motions], axis=0)
        scene.emit(f"{CONDITIONS}/{name}", value, axes={**axes, reading.axis: reading.names})

    known = readings_of(setup)
    for name in (TORQUE, STRESS, ANGLE):
        if name in known:
            each(name, known[name])
    if setup.shaft.gears:
        each(LEAST, known[LEAST])
    mean = stack([one.drive.mean_torque(at).sum()[0] for one in lines], axis=0)
    scene.emit(f"{CONDITIONS}/mean_torque", mean, axes=axes)
    if setup.torsion.irregularity:
        each("irregularity", degrees(setup)["degree"])
    search = None
    if setup.torsion.speeds is not None:
        speed = line_speeds(setup.torsion.speeds)
        search = _search(lines, speed)
        _emit_worst(scene, search)
    if setup.torsion.limits:
        limits.emit_uses(scene, f"{CONDITIONS}/limit", motions, search, limit_axes)
    of_couplings = [couplings.coupling_readings(one) for one in lines]
    if of_couplings[0]:
        couplings.emit_uses(scene, f"{CONDITIONS}/coupling", motions, axes)
        if setup.torsion.speeds is not None:
            own = Search(lines, speed, of_couplings, list(of_couplings[0]))
            couplings.emit_largest_uses(scene, f"{CONDITIONS}/coupling", own, axes)
    scene.cite(
        "one elimination for the torques of all conditions, each summed over the cycle",
        "worst of all cylinders firing, each misfiring, pressures out of balance",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def _search(lines: list[Setup], speed: FloatArray) -> Search:
    """Torques and angles, of which the worst condition counts, and uses of limits in each."""
    setup = lines[0]
    known, sections = readings_of(setup), len(setup.shaft.section_names)
    own = {name: known[name] for name in (TORQUE, ANGLE)}
    held = [limits.uses(one, unbarred=True) for one in lines]
    corners = limit_corners(setup) if held[0] else np.zeros(0)
    searched = [own | uses for uses in held]
    search = Search(lines, speed, searched, list(searched[0]), corners)
    # sections alone, or gears behind them where some limit is for one
    gears = any(one.signal == "load" for one in held[0].values())
    loads = np.arange(sections + gears * len(setup.shaft.gears))
    load = known[TORQUE]._replace(signal="load" if gears else "torque", place=loads)
    limited = np.zeros(len(loads) + len(own[ANGLE].place), dtype=bool)
    for one in held[0].values():
        limited[one.place] = True
    half = half_ranges(lines, [load, own[ANGLE]], search.grid, limited)
    samples = {TORQUE: half[..., :sections], ANGLE: half[..., len(loads) :]}
    # by place over all conditions, by limit in each
    number = sections + len(own[ANGLE].place)
    group = [np.tile(np.arange(number), (len(lines), 1))]
    for name, one in held[0].items():
        scale = np.stack([uses[name].scales(search.grid) for uses in held])
        samples[name] = np.where(scale > 0.0, half[..., one.place], 0.0) * scale
        group.append(np.repeat(number + np.arange(len(lines))[:, None], len(one.place), axis=1))
        number += len(lines)
    search.group = np.concatenate(group, axis=1)
    search.samples = np.concatenate(list(samples.values()), axis=-1).reshape(-1, search.count)
    return search


def _emit_worst(scene: Scene, search: Search) -> None:
    """The worst at each speed, and at any of them."""
    setup, speed, place = search.lines[0], search.speed, f"{CONDITIONS}/largest"
    known = readings_of(setup)
    for name in (TORQUE, ANGLE):
        reading, top = known[name], search.top(name)
        axes = {reading.axis: reading.names}
        worst = np.max([search.curves(name, one) for one in range(len(search.lines))], axis=0)
        curve = Bounded(worst, np.broadcast_to(search.uncertainty(name), worst.shape))
        condition, row = firsts_of_largest(top.value.value, axis=0), np.arange(worst.shape[1])
        most = top.value[condition, row]
        scene.emit(f"{place}/{reading.axis}_speed", top.speed[condition, row], axes=axes)
        scene.emit(f"{place}/{reading.axis}_condition", condition + 1, 0.0, axes)
        over, at_any = {name: curve}, {name: most}
        if name == TORQUE and STRESS in known:
            over[STRESS], at_any[STRESS] = (stress_of(setup, one) for one in (curve, most))
        emit_readings(scene, f"{CONDITIONS}/speeds", setup, over, {"speed": speed})
        emit_readings(scene, place, setup, at_any, {})
