"""Adapter: running gear, gas and crankshaft of a case to the loads on its bearings."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

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
    CrankPin,
    MainLoad,
    OverSpeeds,
    SideThrust,
    WristPin,
)
from vibecalc.bearings.tables import BearingSize, MainBearing
from vibecalc.core.results.described import Group
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, reshaped
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.crank_train import CrankTrain
from vibecalc.parts.firing import cycle_angle


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
    axes = {
        "main_bearing": loads.shaft.names,
        "cylinder": pins,
        "direction": [DIRECTIONS[i] for i in _across(scene.parts.crank_train)],
        "crank_angle": np.linspace(0.0, cycle_angle(case.machine), table.crank_angles),
        **NAMES,
    }
    crank_pins, wrist_pins = ([size] * len(pins) for size in (table.crank_pin, table.wrist_pin))
    _emit(scene, loads, MainLoad, Loads.main, table.main_bearings, axes)
    _emit(scene, loads, CrankPin, Loads.crank_pin, crank_pins, axes)
    if case.machine.crank_train.rod is not None:
        _emit(scene, loads, WristPin, Loads.wrist_pin, wrist_pins, axes)
    _emit(scene, loads, SideThrust, Loads.wall, [None] * len(pins), axes)
    if table.speeds is not None:
        speeds = np.linspace(table.speeds.start, table.speeds.stop, table.speeds.points)
        _over_speeds(scene, loads, speeds, axes)


def _emit(
    scene: Scene,
    loads: Loads,
    group: type[Group],
    kind: Kind,
    sizes: Sequence[BearingSize | MainBearing | None],
    axes: dict[str, Any],
) -> None:
    """Forces over the cycle, their peaks and their means, as far as they are results of a group."""
    speed, areas = np.asarray(scene.case.machine.speed), np.array([_area(one) for one in sizes])
    own_axes = Loads.crank_pin_of_throw if kind is Loads.crank_pin else kind

    @cache
    def peaks() -> Peaks:
        return highest_loads(scene, loads, kind, speed)

    def direction() -> Bounded:
        at = peaks().angle
        every = force_with_error(own_axes, loads, at[:, None], speed)
        top = reshaped(every, lambda one: np.diagonal(one[:, 0]))
        size = np.where(np.abs(top.value) > 0.0, np.abs(top.value), 1.0)
        return Bounded(np.angle(top.value), top.error / size + 4.0 * EPSILON)

    @cache
    def means() -> Means:
        grid = _grid(scene, loads, PANELS)
        found = cycle_means(lambda angle: kind(loads, angle, speed).T, grid)
        lost = Bounded(0.0 * areas, force_with_error(kind, loads, grid, speed).error.max(0))
        return Means(found.magnitude + lost, found.vector + lost)

    def mean_force() -> Summed:
        size, (vector, error) = means()
        return Summed(_components(scene, vector), error.max(), size.value.max())

    def across(force: ComplexArray) -> FloatArray:
        return force.real if group is SideThrust else _components(scene, force, axis=1)

    def over_cycle(kind: Kind, components: Callable[[ComplexArray], FloatArray]) -> Summed:
        force, error = force_with_error(kind, loads, axes["crank_angle"], speed)
        return Summed(components(force.T), error.max(), np.abs(force).max())

    found = {
        "force": lambda: over_cycle(kind, across),
        "force_of_throw": lambda: over_cycle(
            own_axes, lambda own: np.stack([own.real, own.imag], axis=1)
        ),
        "peak": lambda: peaks().height,
        "peak_angle": lambda: peaks().angle,
        "peak_direction": direction,
        "mean": lambda: means().magnitude,
        "mean_force": mean_force,
    }
    if all(areas):
        found["peak_pressure"] = lambda: peaks().height / areas
        found["mean_pressure"] = lambda: means().magnitude / areas
    known = {name: one for name, one in found.items() if name in group.__dataclass_fields__}
    scene.emit_all(group(**known), axes)


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
