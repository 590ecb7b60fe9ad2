"""The worst of many conditions of the cylinders: all fire, each misfires, pressures differ."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.bounds import limit_corners
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.irregularity import degrees
from vibecalc.torsion.adapters.motion import Motion, Reading, blocks, of_finite, readings_of
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import (
    Drive,
    Setup,
    build_drive,
    line_speeds,
    motored_torque,
    with_gas,
)
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.curve_results import CONDITIONS
from vibecalc.torsion.curve_tables import condition_names
from vibecalc.torsion.rough_range import rough_range

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

#: readings whose worst condition is told
WORST = ("torque_half_range", "stress_half_range", "angle_half_range")


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
    for name in WORST:
        if name in known:
            each(name, known[name])
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
    known = readings_of(setup)
    own = {name: known[name] for name in ("torque_half_range", "angle_half_range")}
    held = [limits.uses(one, unbarred=True) for one in lines]
    gears = np.arange(len(setup.shaft.gears))
    last = len(setup.shaft.section_names)
    corners = limit_corners(setup) if held[0] else np.zeros(0)
    readings = [own | one for one in held]
    search = Search(lines, speed, readings, list(readings[0]), corners)
    # by place over all conditions, by limit in each
    group, number = np.zeros((len(lines), search.count), dtype=np.int64), 0
    for name, columns in search.columns.items():
        size = columns.stop - columns.start
        if name in own:
            group[:, columns] = number + np.arange(size)
            number += size
        else:
            group[:, columns] = number + np.arange(len(lines))[:, None]
            number += len(lines)
    search.group = group
    loads = [own["torque_half_range"], own["angle_half_range"]]
    if any(one.signal == "load" for one in held[0].values()):
        loads.append(Reading("gear", gears, "half_range", "gear", ()))
    sizes = np.cumsum([0, *(len(one.place) for one in loads)])
    limited = np.zeros(sizes[-1], dtype=bool)
    place = {}
    for name, reading in held[0].items():
        behind = reading.place >= last
        place[name] = np.where(behind, reading.place - last + sizes[2], reading.place)
        limited[place[name]] = True
    half = half_ranges(lines, loads, search.grid, limited)
    samples = np.empty((len(lines), len(search.grid), search.count))
    for name, columns in search.columns.items():
        if name in own:
            first = sizes[list(own).index(name)]
            samples[..., columns] = half[..., first : first + columns.stop - columns.start]
            continue
        for row, uses, loaded in zip(samples, held, half, strict=True):
            scale = uses[name].scale(search.grid)
            chosen = loaded[:, place[name]]
            row[:, columns] = np.where(scale > 0.0, chosen, 0.0) * scale
    search.samples = samples.reshape(-1, search.count)
    return search


def _emit_worst(scene: Scene, search: Search) -> None:
    """The worst at each speed, and at any of them."""
    setup, speed = search.lines[0], search.speed
    known, stressed = readings_of(setup), np.flatnonzero(setup.shaft.section_modulus > 0.0)
    per = 1.0 / setup.shaft.section_modulus[stressed]
    for name in ("torque_half_range", "angle_half_range"):
        reading, top = known[name], search.top(name)
        worst = np.max([search.curves(name, one) for one in range(len(search.lines))], axis=0)
        off = np.broadcast_to(search.uncertainty(name), worst.shape)
        condition, row = np.argmax(top.value.value, axis=0), np.arange(worst.shape[1])
        most, axes = top.value[condition, row], {reading.axis: reading.names}
        curve, over = Bounded(worst, off), {reading.axis: reading.names, "speed": speed}
        scene.emit(f"{CONDITIONS}/speeds/{name}", curve.T, axes=over)
        place = f"{CONDITIONS}/largest"
        scene.emit(f"{place}/{name}", most, axes=axes)
        scene.emit(f"{place}/{reading.axis}_speed", top.speed[condition, row], axes=axes)
        scene.emit(f"{place}/{reading.axis}_condition", condition + 1, 0.0, axes)
        if name == "torque_half_range" and len(stressed):
            stress = known["stress_half_range"]
            own = {"section": stress.names}
            for stem, value in (
                (f"{CONDITIONS}/speeds", curve[:, stressed].T),
                (place, most[stressed]),
            ):
                by = per[:, None] if value.value.ndim > 1 else per
                found = of_finite(value, lambda one, by=by: one * by)
                both = {**own, "speed": speed} if value.value.ndim > 1 else own
                scene.emit(f"{stem}/stress_half_range", found, axes=both)
