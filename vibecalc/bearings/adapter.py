"""Adapter: running gear, gas and crankshaft of a case to the loads on its bearings."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.bearings.crank_loads import (
    GRID,
    PANELS,
    Means,
    Peaks,
    cycle_means,
    cycle_peaks,
    grid_of,
)
from vibecalc.bearings.loads import Kind, Loads, force_with_error
from vibecalc.bearings.model import loads_of
from vibecalc.bearings.results import (
    NAMES,
    BearingLoad,
    CrankPin,
    MainLoad,
    OverSpeeds,
    SideThrust,
    WristPin,
)
from vibecalc.bearings.tables import BearingSize, MainBearing
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, reshaped
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.crank_train import CrankTrain
from vibecalc.parts.firing import cycle_angle


class Part(NamedTuple):
    """One kind of bearing: its results, its forces, the areas of its members in m^2.

    `areas` are diameter times length, zero where the case does not say them.
    """

    results: type[BearingLoad]
    kind: Kind
    areas: list[float]


def run_bearing_loads(scene: Scene) -> None:
    """Emit forces over the cycle, their peaks and means, and the peaks over speeds."""
    case, table, pins = scene.case, scene.case.bearing_loads, scene.parts.crank_train.names
    if table is None:
        raise ValueError("the case has no [bearing_loads]")
    loads = loads_of(scene)
    scene.cite(
        "levers of each bay of the crankshaft", "main bearing loads",
        "statically determinate crankshaft; docs/theory_bearings.md",
    )  # fmt: skip
    scene.cite(
        "Newton and Euler for piston and rod", "loads of crank pins, wrist pins and walls",
        "docs/theory_bearings.md; cf. Biezeno and Grammel (1953), ch. XI",
    )  # fmt: skip
    mains = [_area(one) for one in table.main_bearings]
    crank_pins, wrist_pins = (
        [_area(size)] * len(pins) for size in (table.crank_pin, table.wrist_pin)
    )
    axes = {
        "main_bearing": loads.shaft.names,
        "cylinder": pins,
        "direction": [DIRECTIONS[i] for i in _across(scene.parts.crank_train)],
        "crank_angle": np.linspace(0.0, cycle_angle(case.machine), table.crank_angles),
        **NAMES,
    }
    _emit(scene, loads, Part(MainLoad, Loads.main, mains), axes)
    _emit(scene, loads, Part(CrankPin, Loads.crank_pin, crank_pins), axes)
    if case.machine.crank_train.rod is not None:
        _emit(scene, loads, Part(WristPin, Loads.wrist_pin, wrist_pins), axes)
    _side_thrust(scene, loads, axes)
    if table.speeds is not None:
        speeds = np.linspace(table.speeds.start, table.speeds.stop, table.speeds.points)
        _over_speeds(scene, loads, speeds, axes)


def _emit(scene: Scene, loads: Loads, part: Part, axes: dict[str, Any]) -> None:
    """Forces over the cycle, their peaks and their means, as far as they are asked for."""
    speed, areas = np.asarray(scene.case.machine.speed), np.array(part.areas)
    of_throw = part.kind is Loads.crank_pin
    own_axes = Loads.crank_pin_of_throw if of_throw else part.kind

    @cache
    def peaks() -> Peaks:
        return highest_loads(scene, loads, part.kind, speed)

    def direction() -> Bounded:
        at = peaks().angle
        every = force_with_error(own_axes, loads, at[:, None], speed)
        top = reshaped(every, lambda one: np.diagonal(one[:, 0]))
        size = np.where(np.abs(top.value) > 0.0, np.abs(top.value), 1.0)
        return Bounded(np.angle(top.value), top.error / size + 4.0 * EPSILON)

    @cache
    def means() -> Means:
        grid = _grid(scene, loads, PANELS)
        found = cycle_means(lambda angle: part.kind(loads, angle, speed).T, grid)
        lost = Bounded(0.0 * areas, force_with_error(part.kind, loads, grid, speed).error.max(0))
        return Means(found.magnitude + lost, found.vector + lost)

    def mean_force() -> Summed:
        size, (vector, error) = means()
        return Summed(_components(scene, vector), error.max(), size.value.max())

    def over_cycle(kind: Kind, components: Callable[[ComplexArray], FloatArray]) -> Summed:
        force, error = force_with_error(kind, loads, axes["crank_angle"], speed)
        return Summed(components(force.T), error.max(), np.abs(force).max())

    results = part.results(
        force=lambda: over_cycle(part.kind, partial(_components, scene, axis=1)),
        peak=lambda: peaks().height,
        peak_angle=lambda: peaks().angle,
        peak_direction=direction,
        peak_pressure=(lambda: peaks().height / areas) if all(areas) else None,
        mean=lambda: means().magnitude,
        mean_force=mean_force,
        mean_pressure=(lambda: means().magnitude / areas) if all(areas) else None,
    )
    scene.emit_all(results, axes)
    if of_throw:
        both = partial(over_cycle, own_axes, lambda own: np.stack([own.real, own.imag], axis=1))
        scene.emit_all(CrankPin(force_of_throw=both), axes)


def _area(size: BearingSize | MainBearing | None) -> float:
    """Diameter times length in m^2, zero for a bearing whose size is not said."""
    if size is None or size.diameter is None or size.length is None:
        return 0.0
    return size.diameter * size.length


def _across(train: CrankTrain) -> list[int]:
    """The two axes of the machine across the shaft."""
    return [i for i in range(3) if not train.axis[i]]


def _components(scene: Scene, force: ComplexArray, axis: int = -1) -> FloatArray:
    """Forces along the stroke + i ahead of it in the axes across the shaft, along a new axis."""
    train = scene.parts.crank_train
    each = [force.real * train.stroke[i] - force.imag * train.across[i] for i in _across(train)]
    return np.stack(each, axis=axis)


def _grid(scene: Scene, loads: Loads, parts: int = GRID) -> FloatArray:
    return grid_of(loads.gas.kinks, cycle_angle(scene.case.machine), parts)


def highest_loads(scene: Scene, loads: Loads, kind: Kind, speed: FloatArray) -> Peaks:
    """Peaks at each of the speeds (s,), or at the one, of each bearing: all rows after another."""
    grid, speeds = _grid(scene, loads), np.atleast_1d(speed)
    on_grid = np.concatenate([kind(loads, grid, one).T for one in speeds])
    count = len(on_grid) // len(speeds)

    def of_row(row: IntArray, every: Any) -> Any:
        return np.take_along_axis(every, (row % count).reshape(-1, 1, 1), axis=-1)[..., 0]

    def forces_at(row: IntArray, angle: FloatArray) -> ComplexArray:
        return np.asarray(of_row(row, kind(loads, angle, speeds[row // count][:, None])))

    found, row = cycle_peaks(forces_at, on_grid, grid), np.arange(len(on_grid))
    at = found.angle.value[:, None]
    lost = of_row(row, force_with_error(kind, loads, at, speeds[row // count][:, None]).error)
    return found._replace(height=Bounded(found.height.value, found.height.error + lost[:, 0]))


def _side_thrust(scene: Scene, loads: Loads, axes: dict[str, Any]) -> None:
    speed = np.asarray(scene.case.machine.speed)
    force, error = force_with_error(Loads.wall, loads, axes["crank_angle"], speed)
    peaks = highest_loads(scene, loads, Loads.wall, speed)
    found = SideThrust(
        force=Summed(force.real.T, error.max(), np.abs(force).max()),
        peak=peaks.height,
        peak_angle=peaks.angle,
    )
    scene.emit_all(found, axes)


#: crank angles times speeds that are followed at once
_MOST_PLACES = 100_000


def _over_speeds(scene: Scene, loads: Loads, speeds: FloatArray, axes: dict[str, Any]) -> None:
    at_once = max(1, _MOST_PLACES // len(_grid(scene, loads)))
    blocks = [speeds[low : low + at_once] for low in range(0, len(speeds), at_once)]

    def highest(kind: Kind) -> Bounded:
        heights = concatenate([highest_loads(scene, loads, kind, one).height for one in blocks])
        return reshaped(heights, lambda part: part.reshape(len(speeds), -1).T)

    found = OverSpeeds(
        main_peak=lambda: highest(Loads.main), crank_pin_peak=lambda: highest(Loads.crank_pin)
    )
    scene.emit_all(found, {**axes, "speed": speeds})
