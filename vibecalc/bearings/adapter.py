"""Adapter: running gear, gas and crankshaft of a case to the loads on its bearings."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.bearings.crank_loads import (
    PANELS,
    EveryAt,
    ForcesAt,
    Peaks,
    cycle_means,
    cycle_peaks,
    grid_of,
)
from vibecalc.bearings.model import Gas, Shaft, gas_of, running_gear, shaft_of
from vibecalc.bearings.results import (
    NAMES,
    BearingLoad,
    CrankPin,
    MainLoad,
    OverSpeeds,
    SideThrust,
    WristPin,
)
from vibecalc.bearings.rod_forces import RodForces, RunningGear, rod_forces
from vibecalc.bearings.tables import BearingLoads, BearingSize, MainBearing
from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, reshaped
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.crank_train import CrankTrain
from vibecalc.parts.firing import cycle_angle


class Loads(NamedTuple):
    """What loads the bearings of one machine, at any crank angle and speed."""

    gear: RunningGear
    bank: FloatArray
    gas: Gas
    shaft: Shaft

    def rods(self, angle: FloatArray, speed: FloatArray) -> RodForces:
        """Forces (..., c) along the axes of each cylinder."""
        return rod_forces(self.gear, self.gas.at(angle, speed), angle, speed)

    def crank_pin(self, angle: FloatArray, speed: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Forces (..., c) along the stroke + i ahead of it, with their errors."""
        found = self.rods(angle, speed)
        return found.crank_pin * np.exp(1j * self.bank), found.error

    def wrist_pin(self, angle: FloatArray, speed: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """As of the crank pin."""
        found = self.rods(angle, speed)
        return found.wrist_pin * np.exp(1j * self.bank), found.error

    def wall(self, angle: FloatArray, speed: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Side thrust (..., c), positive ahead."""
        found = self.rods(angle, speed)
        return found.wall.astype(complex), found.error

    def main(self, angle: FloatArray, speed: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Forces (..., b) on the main bearings, as of the crank pin."""
        rods, shaft = self.rods(angle, speed), self.shaft
        square = np.square(np.asarray(speed, dtype=float))[..., None]
        turned = np.asarray(angle, dtype=float)[..., None] + shaft.weight_angle
        weights = shaft.unbalance * square * np.exp(1j * turned)
        of_rods = rods.without_big_end * np.exp(1j * self.bank)
        total = of_rods @ shaft.rod_share.T + weights @ shaft.weight_share.T + shaft.at_rest
        error = rods.error @ np.abs(shaft.rod_share).T + 16.0 * EPSILON * (
            np.abs(of_rods) @ np.abs(shaft.rod_share).T
            + (np.abs(weights) * (1.0 + np.abs(turned))) @ np.abs(shaft.weight_share).T
            + np.abs(shaft.at_rest)
        )
        return total, error


#: forces (..., rows) with their errors, at crank angles (...) and speeds (...)
At = Callable[[FloatArray, FloatArray], tuple[ComplexArray, FloatArray]]


class Part(NamedTuple):
    """One kind of bearing: its results, its forces, its members with their areas in m^2.

    `areas` are diameter times length, zero where the case does not say them.
    """

    results: type[BearingLoad]
    at: At
    axis: str
    members: tuple[str, ...]
    areas: list[float]


def run_bearing_loads(scene: Scene) -> None:
    """Emit forces over the cycle, their peaks and means, and the peaks over speeds."""
    case, train = scene.case, scene.parts.crank_train
    table = case.bearing_loads
    if table is None:
        raise ValueError("the case has no [bearing_loads]")
    loads = loads_of(scene, table)
    scene.cite(
        "levers of each bay of the crankshaft", "main bearing loads",
        "statically determinate crankshaft; docs/theory_bearings.md",
    )  # fmt: skip
    scene.cite(
        "Newton and Euler for piston and rod", "loads of crank pins, wrist pins and walls",
        "docs/theory_bearings.md; cf. Biezeno and Grammel (1953), ch. XI",
    )  # fmt: skip
    mains, pins = loads.shaft.names, train.names
    parts = [
        Part(
            MainLoad, loads.main, "main_bearing", mains, [_area(one) for one in table.main_bearings]
        ),
        Part(CrankPin, loads.crank_pin, "cylinder", pins, [_area(table.crank_pin)] * len(pins)),
    ]
    if case.machine.crank_train.rod is not None:
        areas = [_area(table.wrist_pin)] * len(pins)
        parts.append(Part(WristPin, loads.wrist_pin, "cylinder", pins, areas))
    for part in parts:
        _forces(scene, part)
        _peaks(scene, loads, part)
        _means(scene, loads, part)
    _side_thrust(scene, loads)
    if table.speeds is not None:
        _over_speeds(scene, loads, table)


def loads_of(scene: Scene, table: BearingLoads) -> Loads:
    """What loads the bearings of a scene."""
    case, train = scene.case, scene.parts.crank_train
    shaft = shaft_of(case, table, train, scene.parts.rotating_masses)
    return Loads(running_gear(case, train), train.bank_angle, gas_of(case, train), shaft)


def _angles(scene: Scene) -> FloatArray:
    table = scene.case.bearing_loads
    count = 361 if table is None else table.crank_angles
    return np.linspace(0.0, cycle_angle(scene.case.machine), count)


def _forces(scene: Scene, part: Part) -> None:
    """Forces over the crank angle in axes of the machine, of crank pins also of the throw."""
    train, angle = scene.parts.crank_train, _angles(scene)
    speed = np.asarray(scene.case.machine.speed)
    names, across_shaft = _axes_across(train)

    def of_machine() -> Summed:
        force, error = part.at(angle, speed)
        components = np.stack([_along(force, one) for one in across_shaft], axis=-2)
        return Summed(components.T, error.max(), np.abs(force).max())

    def of_throw() -> Summed:
        force, error = part.at(angle, speed)
        own = force * np.exp(-1j * (angle[:, None] + train.crank_phase))
        both = np.stack([own.real, own.imag], axis=-2)
        size = np.abs(own).max()
        return Summed(both.T, error.max() + 8.0 * EPSILON * angle[-1] * size, size)

    known = {part.axis: part.members, "direction": names, "crank_angle": angle, **NAMES}
    scene.emit_all(part.results(force=of_machine), known)
    if part.results is CrankPin:
        scene.emit_all(CrankPin(force_of_throw=of_throw), known)


def _peaks(scene: Scene, loads: Loads, part: Part) -> None:
    names = ("peak", "peak_angle", "peak_direction", "peak_pressure")
    if not scene.wants(*paths_of(part.results, *names)):
        return
    found, top, off = highest_loads(scene, loads, part.at, np.asarray(scene.case.machine.speed))
    if part.results is CrankPin:
        top = top * np.exp(-1j * (found.angle.value + scene.parts.crank_train.crank_phase))
    size = np.where(np.abs(top) > 0.0, np.abs(top), 1.0)
    results = part.results(
        peak=found.height,
        peak_angle=found.angle,
        peak_direction=Bounded(np.angle(top), off / size + 4.0 * EPSILON),
        peak_pressure=found.height / np.array(part.areas) if all(part.areas) else None,
    )
    scene.emit_all(results, {part.axis: part.members})


def _means(scene: Scene, loads: Loads, part: Part) -> None:
    speed = np.asarray(scene.case.machine.speed)
    if not scene.wants(*paths_of(part.results, "mean", "mean_force", "mean_pressure")):
        return
    directions, across_shaft = _axes_across(scene.parts.crank_train)
    grid = _grid(scene, loads, PANELS)
    means, lost = cycle_means(_every(part.at, speed), grid), part.at(grid, speed)[1].max(axis=0)
    mean = means.magnitude + Bounded(np.zeros(len(part.members)), lost)
    vector = np.stack([_along(means.vector.value, one) for one in across_shaft], axis=-1)
    results = part.results(
        mean=mean,
        mean_force=Summed(vector, (means.vector.error + lost).max(), mean.value.max()),
        mean_pressure=mean / np.array(part.areas) if all(part.areas) else None,
    )
    scene.emit_all(results, {part.axis: part.members, "direction": directions})


def _area(size: BearingSize | MainBearing | None) -> float:
    """Diameter times length in m^2, zero for a bearing whose size is not said."""
    if size is None or size.diameter is None or size.length is None:
        return 0.0
    return size.diameter * size.length


def _axes_across(train: CrankTrain) -> tuple[list[str], list[complex]]:
    """The two axes of the machine across the shaft, each as stroke + i ahead."""
    across = [i for i in range(3) if not train.axis[i]]
    along = [complex(train.stroke[i], -train.across[i]) for i in across]
    return [DIRECTIONS[i] for i in across], along


def _along(force: ComplexArray, axis: complex) -> FloatArray:
    return np.asarray(force.real * axis.real + force.imag * axis.imag)


def _grid(scene: Scene, loads: Loads, parts: int | None = None) -> FloatArray:
    cycle = cycle_angle(scene.case.machine)
    if parts is None:
        return grid_of(loads.gas.breaks, cycle)
    return grid_of(loads.gas.breaks, cycle, parts)


def _every(at: At, speed: FloatArray) -> EveryAt:
    return lambda angle: at(angle, speed)[0].T


def _rows(at: At, count: int, speed: FloatArray) -> ForcesAt:
    """Rows are `count` bearings at each of the speeds (s,), or at the one."""
    speeds = np.atleast_1d(speed)

    def forces(row: IntArray, angle: FloatArray) -> ComplexArray:
        every = at(angle, speeds[row // count][:, None])[0]
        chosen = (row % count).reshape(-1, 1, 1)
        return np.take_along_axis(every, chosen, axis=-1)[..., 0]

    return forces


def highest_loads(
    scene: Scene, loads: Loads, at: At, speed: FloatArray
) -> tuple[Peaks, ComplexArray, FloatArray]:
    """Peaks of all rows with the error of the forces, the forces there, errors of both."""
    grid = _grid(scene, loads)
    speeds = np.atleast_1d(speed)
    on_grid = [at(grid, one)[0].T for one in speeds]
    count = on_grid[0].shape[0]
    forces_at = _rows(at, count, speed)
    found = cycle_peaks(forces_at, np.concatenate(on_grid), grid)
    row = np.arange(count * len(speeds))
    error = at(found.angle.value[:, None], speeds[row // count][:, None])[1][:, 0]
    lost = np.take_along_axis(error, (row % count)[:, None], axis=-1)[:, 0]
    # how far the force turns within the error of the place
    step = np.maximum(found.angle.error, 1e-7)
    near = forces_at(row, found.angle.value[:, None] + np.stack([0.0 * step, step], axis=-1))
    slope = np.abs(near[:, 1] - near[:, 0]) / step
    height = Bounded(found.height.value, found.height.error + lost)
    return Peaks(height, found.angle), near[:, 0], lost + slope * found.angle.error


def _side_thrust(scene: Scene, loads: Loads) -> None:
    angle, speed = _angles(scene), np.asarray(scene.case.machine.speed)
    force, error = loads.wall(angle, speed)
    peaks, _, _ = highest_loads(scene, loads, loads.wall, speed)
    found = SideThrust(
        force=Summed(force.real.T, error.max(), np.abs(force).max()),
        peak=peaks.height,
        peak_angle=peaks.angle,
    )
    scene.emit_all(found, {"cylinder": scene.parts.crank_train.names, "crank_angle": angle})


#: crank angles times speeds that are followed at once
_MOST_PLACES = 100_000


def _over_speeds(scene: Scene, loads: Loads, table: BearingLoads) -> None:
    asked = table.speeds
    assert asked is not None
    speeds = np.linspace(asked.start, asked.stop, asked.points)
    known = {
        "main_bearing": loads.shaft.names,
        "cylinder": scene.parts.crank_train.names,
        "speed": speeds,
    }
    at_once = max(1, _MOST_PLACES // len(_grid(scene, loads)))

    def highest(at: At) -> Bounded:
        blocks = [speeds[low : low + at_once] for low in range(0, len(speeds), at_once)]
        heights = concatenate([highest_loads(scene, loads, at, one)[0].height for one in blocks])
        return reshaped(heights, lambda part: part.reshape(len(speeds), -1).T)

    found = OverSpeeds(
        main_peak=lambda: highest(loads.main), crank_pin_peak=lambda: highest(loads.crank_pin)
    )
    scene.emit_all(found, known)
