"""The stage of bearing loads: when it is planned, what it counts, what it refuses."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.core.run.stage import Entries, Stage, Subject, Unit, Work, below

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_bearing_loads(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [bearing_loads]."""
    table = case.bearing_loads
    if table is None:
        return
    train = case.machine.crank_train
    there: dict[str, Any] = {"/wrist_pin/": train.rod, "/speeds/": table.speeds}
    sizes = {
        "main": table.main_bearings[0].diameter,
        "crank_pin": table.crank_pin,
        "wrist_pin": table.wrist_pin,
    }
    for name, size in sizes.items():
        there |= {f"/{name}/{one}_pressure": size for one in ("peak", "mean")}
    absent = tuple(path for path, one in there.items() if one is None)
    yield Stage(
        name="bearing_loads",
        adapter="vibecalc.bearings.adapter:run_bearing_loads",
        why="[bearing_loads] is in the case",
        parts=("crank_train", "rotating_masses"),
        orders="none: forces over the crank angle",
        cost=f"peaks and means of {len(table.main_bearings)} main bearings and "
        f"{len(train.cylinders)} rods over a cycle",
        quantities=below("bearing_loads/", without=absent),
        is_last=True,
        work=_work,
        topics=("vibecalc.bearings.accuracy:bearing_topics",),
    )


def _work(case: "Case", orders: int) -> Work:
    table = case.bearing_loads
    assert table is not None
    rows = len(table.main_bearings) + 3 * len(case.machine.crank_train.cylinders)
    points = 0 if table.speeds is None else table.speeds.points
    return ((rows * (1 + points), "load_cycles"),)


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    table = case.bearing_loads
    if table is None or axis != "speed":
        return None
    return Entries.of_speeds(table.speeds, "bearing_loads.speeds")


def _names(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    if case.bearing_loads is None:
        return {}
    return {"main_bearing": tuple(one.name for one in case.bearing_loads.main_bearings)}


SUBJECT = Subject(
    stages=(plan_bearing_loads,),
    concerns=lambda case: case.bearing_loads is not None,
    names=_names,
    entries=_entries,
    units={"load_cycles": Unit(2.0e-3, "loads followed over a cycle")},
    checks=("vibecalc.bearings.checks:bearing_problems",),
    cautions=("vibecalc.bearings.checks:bearing_cautions",),
    sections=("vibecalc.bearings.report:bearing_loads",),
    pictures={
        "bearing_forces": "vibecalc.bearings.pictures:FORCES",
        "main_bearing_polar": "vibecalc.bearings.pictures:draw_main_bearings",
        "crank_pin_polar": "vibecalc.bearings.pictures:draw_crank_pins",
    },
    assumes=(
        "Bearing loads are those of a rigid, straight crankshaft; alignment, shaft "
        "bending and oil films are left out. With more than two main bearings single "
        "loads may be off by tens of per cent.",
    ),
)
