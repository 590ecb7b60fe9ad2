"""The worst of many conditions of the cylinders: all fire, each misfires, pressures differ."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import (
    CylinderTorque,
    cylinder_gas,
    phasor,
)
from vibecalc.numerics.bounded import Bounded, reshaped, rounded, stack
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.bounds import limit_corners
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.irregularity import degrees
from vibecalc.torsion.adapters.motion import Motion, Reading, blocks, of_finite, readings_of
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import (
    PHASOR_ROUNDINGS,
    SPEED_ROUNDINGS,
    Drive,
    Setup,
    build_drive,
    line_speeds,
    motored_torque,
    placed,
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


class Condition(NamedTuple):
    """A name, and the torques that act then."""

    name: str
    drive: Drive


def conditions_of(case: "Case", setup: Setup) -> list[Condition]:
    """All cylinders firing first, then each misfiring, each out of balance, given pressures."""
    options, shaft = setup.torsion.conditions, setup.shaft
    assert options is not None
    well = build_drive(case, shaft, all_fire=True)
    names, scale = well.firing.names, np.asarray(well.firing.pressure_scale, dtype=float)
    count = len(names)
    each, nobody = np.eye(count, dtype=bool), np.zeros(count, dtype=bool)
    drives = [well]
    if options.misfire == "each":
        without = None
        if options.misfire_kind == "motored":
            without = motored_torque(case.machine, well)
        drives += [changed_drive(setup, well, scale, out, without) for out in each]
    less = [scale * np.where(one, 1.0 - options.imbalance, 1.0) for one in each
            if options.imbalance is not None]  # fmt: skip
    given = [scale * np.array(options.pressure_scale)] if options.pressure_scale else []
    drives += [changed_drive(setup, well, one, nobody, None) for one in (*less, *given)]
    called = condition_names(options, names)
    return [Condition(*both) for both in zip(called, drives, strict=True)]


def changed_drive(
    setup: Setup, drive: Drive, scale: FloatArray, out: BoolArray, motored: CylinderTorque | None
) -> Drive:
    """A drive whose cylinders have other factors (c,) on their gas pressure, or misfire.

    What the other cylinders and everything but gas do stays, and its errors with it.
    """
    shaft, one, firing = setup.shaft, drive.cylinder, drive.firing
    old = cylinder_gas(one, firing.pressure_scale)
    new = cylinder_gas(one, scale, misfiring=out, motored=motored)
    other = (out | (scale != firing.pressure_scale)).astype(float)
    gas, mean = (new[0] - old[0]) * other[:, None], (new[1] - old[1]) * other
    where = placed(np.searchsorted(drive.station, shaft.cylinder_station), len(drive.station))
    on = where * shaft.station_ratio[shaft.cylinder_station][:, None]
    turned = rounded(phasor(one.order, firing.angle).T, PHASOR_ROUNDINGS)
    more = reshaped(gas * turned, lambda part: np.swapaxes(part, -1, -2)) @ on
    return drive._replace(
        gas=drive.gas + more,
        mean=drive.mean + mean @ rounded(on, SPEED_ROUNDINGS),
    )


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
    lines = [coupled(setup._replace(drive=one.drive)) for one in found]
    at, conditions = np.array([setup.speed]), tuple(one.name for one in found)
    motions = [Motion(one, at, bounded=True) for one in lines]
    axes: dict[str, Any] = {"condition": conditions}
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
