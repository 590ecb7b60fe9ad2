"""The stages of vibration at points: at the operating speed, and over the run-up."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import (
    Entries,
    Leading,
    Stage,
    Subject,
    Unit,
    Work,
    below,
)
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.firing import table_that_moves, with_torque
from vibecalc.parts.mount_needs import moves_with_machine
from vibecalc.response.stage import entries_of_loads, loads_on

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_points(case: "Case") -> Iterator[Stage]:
    """Planned where the case has points on a body that some table moves."""
    if not case.point:
        return
    moved_by, names = table_that_moves(case), ", ".join(one.name for one in case.point[:3])
    torque, loads = moved_by in with_torque(case), loads_on(case, moved_by)
    without = ["/run_up/"]
    severity = case.vibration_severity
    if severity is None:
        without += ["points/severity", "points/zone"]
    else:
        given = [name for name in ("displacement", "velocity", "acceleration")
                 if severity.grades is None and getattr(severity, name) is None]  # fmt: skip
        without += [f"zone_boundary/{name}" for name in given]
        without += ["points/zone"] if len(given) == 3 else []
    yield Stage(
        name="points",
        adapter="vibecalc.points.adapter:run_points",
        why=f"[[point]] is in the case: {names}" + ", ..." * (len(case.point) > 3),
        parts=("body", "mounts"),
        orders=loads.words,
        cost="a product with the motion of the body per reading and order",
        quantities=below("points/", tuple(without)),
        is_last=True,
        harmonics=loads.harmonics,
        work=_work,
        topics=("vibecalc.points.accuracy:points_topics",),
        leading=None if torque or moves_with_machine(case) else Leading(MOUNT_KEYS, most=1024),
    )
    if case.isolation is None or case.isolation.run_up is None:
        return
    first, last = case.isolation.run_up.start, case.isolation.run_up.stop
    yield Stage(
        name="points in the run-up",
        adapter="vibecalc.points.run_up_adapter:run_points_run_up",
        why="[[point]] and [isolation] run_up are in the case",
        parts=loads.parts,
        orders=loads.words,
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=below("points/run_up/", ("severity",) if severity is None else ()),
        is_last=True,
        harmonics=loads.harmonics,
        work=_work_of_run_up,
        topics=("vibecalc.points.accuracy:points_run_up_topics",),
    )


#: speeds that a run-up of readings takes
_RUN_UP = 400


def _readings(case: "Case") -> int:
    return sum(1 if one.direction is not None else 3 for one in case.point)


def _work(case: "Case", orders: int) -> Work:
    return ((_readings(case) * orders, "reading_order"),)


def _work_of_run_up(case: "Case", orders: int) -> Work:
    return (
        (2 * orders * _RUN_UP, "body_solve"),
        (3 * _readings(case) * orders * _RUN_UP, "reading_order"),
    )


def names_of(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axis that the points of the case make."""
    if not case.point:
        return {}
    from vibecalc.points.model import readings_of

    return {"sensor": readings_of(case).names}


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    if axis == "speed":
        options = case.isolation
        return Entries.of_speeds(options and options.run_up, "isolation.run_up")
    return entries_of_loads(case, axis, table_that_moves(case))


SUBJECT = Subject(
    stages=(plan_points,),
    names=names_of,
    entries=_entries,
    concerns=lambda case: bool(case.point) or case.vibration_severity is not None,
    units={"reading_order": Unit(1.0e-6, "orders of readings at points")},
    checks=("vibecalc.points.model:points_problems",),
    cautions=("vibecalc.points.model:points_cautions",),
    sections=("vibecalc.points.report:points",),
    pictures={
        "points_by_order": "vibecalc.points.pictures:BY_ORDER",
        "points_run_up": "vibecalc.points.pictures:OVER_SPEED",
    },
)
