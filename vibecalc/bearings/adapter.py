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
from vibecalc.bearings.results import NAMES, ROOT
from vibecalc.bearings.rod_forces import RodForces, RunningGear, rod_forces
from vibecalc.bearings.tables import BearingLoads, BearingSize, MainBearing
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, concatenate
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
    """One kind of bearing: its folder of results, its forces, its members with their areas in m^2.

    `areas` are diameter times length, zero where the case does not say them.
    """

    name: str
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
            "main", loads.main, "main_bearing", mains, [_area(one) for one in table.main_bearings]
        ),
        Part("crank_pin", loads.crank_pin, "cylinder", pins, [_area(table.crank_pin)] * len(pins)),
    ]
    if case.machine.crank_train.rod is not None:
        areas = [_area(table.wrist_pin)] * len(pins)
        parts.append(Part("wrist_pin", loads.wrist_pin, "cylinder", pins, areas))
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
    paths = [f"{ROOT}/{part.name}/{name}" for name in ("force", "force_of_throw")]
    if not scene.wants(*paths):
        return
    train, angle = scene.parts.crank_train, _angles(scene)
    names, across_shaft = _axes_across(train)
    force, error = part.at(angle, np.asarray(scene.case.machine.speed))
    known = {part.axis: part.members, "direction": names, "crank_angle": angle}
    components = np.stack([_along(force, one) for one in across_shaft], axis=-2)
    scene.emit(paths[0], components.T, error.max(), known, terms=np.abs(force).max())
    if part.name != "crank_pin":
        return
    own = force * np.exp(-1j * (angle[:, None] + train.crank_phase))
    both = np.stack([own.real, own.imag], axis=-2)
    lost = error.max() + 8.0 * EPSILON * angle[-1] * np.abs(own).max()
    known |= NAMES
    scene.emit(paths[1], both.T, lost, known, terms=np.abs(own).max())


def _peaks(scene: Scene, loads: Loads, part: Part) -> None:
    path, train, axes = f"{ROOT}/{part.name}", scene.parts.crank_train, {part.axis: part.members}
    names = ("peak", "peak_angle", "peak_direction", "peak_pressure")
    if not scene.wants(*(f"{path}/{name}" for name in names)):
        return
    found, top, off = highest_loads(scene, loads, part.at, np.asarray(scene.case.machine.speed))
    if part.name == "crank_pin":
        top = top * np.exp(-1j * (found.angle.value + train.crank_phase))
    size = np.where(np.abs(top) > 0.0, np.abs(top), 1.0)
    direction = Bounded(np.angle(top), off / size + 4.0 * EPSILON)
    scene.emit(f"{path}/peak", found.height, axes=axes)
    scene.emit(f"{path}/peak_angle", found.angle, axes=axes)
    scene.emit(f"{path}/peak_direction", direction, axes=axes)
    if all(part.areas):
        scene.emit(f"{path}/peak_pressure", found.height / np.array(part.areas), axes=axes)


def _means(scene: Scene, loads: Loads, part: Part) -> None:
    path, speed = f"{ROOT}/{part.name}", np.asarray(scene.case.machine.speed)
    names = ("mean", "mean_force", "mean_pressure")
    if not scene.wants(*(f"{path}/{name}" for name in names)):
        return
    directions, across_shaft = _axes_across(scene.parts.crank_train)
    axes = {part.axis: part.members, "direction": directions}
    grid = _grid(scene, loads, PANELS)
    means, lost = cycle_means(_every(part.at, speed), grid), part.at(grid, speed)[1].max(axis=0)
    mean = means.magnitude + Bounded(np.zeros(len(part.members)), lost)
    vector = np.stack([_along(means.vector.value, one) for one in across_shaft], axis=-1)
    off = (means.vector.error + lost).max()
    scene.emit(f"{path}/mean", mean, axes=axes)
    scene.emit(f"{path}/mean_force", vector, off, axes, terms=mean.value.max())
    if all(part.areas):
        scene.emit(f"{path}/mean_pressure", mean / np.array(part.areas), axes=axes)


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
    known = {"cylinder": scene.parts.crank_train.names, "crank_angle": angle}
    path = f"{ROOT}/side_thrust"
    scene.emit(f"{path}/force", force.real.T, error.max(), known, terms=np.abs(force).max())
    peaks, _, _ = highest_loads(scene, loads, loads.wall, speed)
    scene.emit(f"{path}/peak", peaks.height, axes=known)
    scene.emit(f"{path}/peak_angle", peaks.angle, axes=known)


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
    for part, at in (("main", loads.main), ("crank_pin", loads.crank_pin)):
        path = f"{ROOT}/speeds/{part}_peak"
        if scene.wants(path):
            blocks = [speeds[low : low + at_once] for low in range(0, len(speeds), at_once)]
            heights = [highest_loads(scene, loads, at, block)[0].height for block in blocks]
            of_speeds = concatenate(heights).value.reshape(len(speeds), -1)
            errors = concatenate(heights).error.reshape(len(speeds), -1)
            scene.emit(path, Bounded(of_speeds.T, errors.T), axes=known)
