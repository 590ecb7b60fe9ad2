"""Adapter: running gear, gas and crankshaft of a case to the loads on its bearings."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from vibecalc.bearings.crank_loads import ForcesAt, cycle_means, cycle_peaks
from vibecalc.bearings.loads import Kind, Loads, force_with_error
from vibecalc.bearings.model import loads_of
from vibecalc.bearings.results import NAMES, CrankPin, MainLoad, OverSpeeds, SideThrust, WristPin
from vibecalc.bearings.tables import BearingSize, MainBearing
from vibecalc.core.results.described import Group
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.numerics.bounded import Bounded, Summed, reshaped, stack
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.parts.body import DIRECTIONS


def run_bearing_loads(scene: Scene) -> None:
    """Emit forces over the cycle, their peaks and means, and the peaks over speeds."""
    table, train = scene.case.bearing_loads, scene.parts.crank_train
    assert table is not None
    loads = loads_of(scene)
    scene.cite(
        "levers of each bay of the crankshaft", "main bearing loads",
        "statically determinate crankshaft; docs/theory.md",
    )  # fmt: skip
    scene.cite(
        "Newton and Euler for piston and rod", "loads of crank pins, wrist pins and walls",
        "docs/theory.md; cf. Biezeno and Grammel (1953), ch. XI",
    )  # fmt: skip
    axes = {
        "main_bearing": loads.shaft.names,
        "cylinder": train.names,
        "direction": [DIRECTIONS[i] for i in np.flatnonzero(train.axis == 0.0)],
        "crank_angle": np.linspace(0.0, loads.cycle, table.crank_angles),
        **NAMES,
    }
    _emit(scene, loads, MainLoad, Loads.main, table.main_bearings, axes)
    _emit(scene, loads, CrankPin, Loads.crank_pin, [table.crank_pin], axes)
    if scene.case.machine.crank_train.rod is not None:
        _emit(scene, loads, WristPin, Loads.wrist_pin, [table.wrist_pin], axes)
    _emit(scene, loads, SideThrust, Loads.wall, (), axes)
    if table.speeds is not None:
        speeds = np.linspace(table.speeds.start, table.speeds.stop, table.speeds.points)
        found = OverSpeeds(
            main_peak=lambda: highest_loads(loads, Loads.main, speeds)[0].T,
            crank_pin_peak=lambda: highest_loads(loads, Loads.crank_pin, speeds)[0].T,
        )
        scene.emit_all(found, {**axes, "speed": speeds})


def _emit(
    scene: Scene,
    loads: Loads,
    group: type[Group],
    kind: Kind,
    sizes: Sequence[BearingSize | MainBearing | None],
    axes: dict[str, Any],
) -> None:
    """Forces over the cycle, their peaks and their means, as far as they are results of a group.

    The `sizes` are those of all bearings, or the one of each of them.
    """
    speed, train = np.asarray(scene.case.machine.speed), scene.parts.crank_train
    of_throw = Loads.crank_pin_of_throw if kind is Loads.crank_pin else kind
    across = (train.stroke - 1j * train.across)[train.axis == 0.0]
    areas = [one.diameter * one.length for one in sizes if one and one.diameter and one.length]

    @cache
    def peaks() -> tuple[Bounded, Bounded]:
        height, angle = highest_loads(loads, kind, speed[None])
        return height[0], angle[0]

    @cache
    def over_cycle(kind: Kind) -> Bounded:
        return force_with_error(kind, loads, axes["crank_angle"], speed).T

    @cache
    def means() -> tuple[Bounded, Bounded]:
        found = cycle_means(_forces(loads, kind, speed), loads.gas.kinks, loads.cycle)
        lost = Bounded(np.zeros(()), over_cycle(kind).error.max(axis=1))
        return found[0] + lost, found[1] + lost

    def direction() -> Bounded:
        top = reshaped(force_with_error(of_throw, loads, peaks()[1], speed), np.diagonal)
        size = np.where(np.abs(top.value) > 0.0, np.abs(top.value), 1.0)
        return Bounded(np.angle(top.value), top.error / size + 4.0 * EPSILON)

    def along(axes: ComplexArray, force: Bounded) -> Summed:
        """Components (rows, 2, ...) of forces (rows, ...) along two directions in their plane."""
        parts = np.einsum("d,r...->rd...", axes.conj(), force.value).real
        return Summed(parts, force.error.max(), np.abs(force.value).max())

    def mean_force() -> Summed:
        size, vector = means()
        return along(across, vector)._replace(terms=size.value.max())

    known = {
        "force": lambda: along(across, over_cycle(kind)),
        "force_of_throw": lambda: along(np.array([1.0, 1j]), over_cycle(of_throw)),
        "peak": lambda: peaks()[0],
        "peak_angle": lambda: peaks()[1],
        "peak_direction": direction,
        "mean": lambda: means()[0],
        "mean_force": mean_force,
    }
    if areas:
        known["peak_pressure"] = lambda: peaks()[0] / areas
        known["mean_pressure"] = lambda: means()[0] / areas
    if group is SideThrust:
        known["force"] = lambda: with_terms(over_cycle(kind).real)
    found = {name: one for name, one in known.items() if name in group.KNOWN}
    scene.emit_all(group(**found), axes)


def highest_loads(loads: Loads, kind: Kind, speeds: FloatArray) -> tuple[Bounded, Bounded]:
    """Highest magnitudes (s, rows) over a cycle at speeds (s,), and the crank angles of them."""
    found = [cycle_peaks(_forces(loads, kind, one), loads.gas.kinks, loads.cycle) for one in speeds]
    height, place = (stack([one[i] for one in found], axis=0) for i in range(2))
    lost = force_with_error(kind, loads, place.value, speeds[:, None]).error
    return height + Bounded(np.zeros(()), np.diagonal(lost, axis1=1, axis2=2)), place


def _forces(loads: Loads, kind: Kind, speed: FloatArray) -> ForcesAt:
    return lambda angle: kind(loads, angle, speed)
