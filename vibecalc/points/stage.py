"""The stages of vibration at points: at the operating speed, and over the run-up."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Leading, Stage, Subject, Unit, below
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.firing import table_that_moves, with_torque
from vibecalc.parts.mount_needs import moves_with_machine
from vibecalc.points.results import UNITS
from vibecalc.response.stage import entries_of_loads, loads_on

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_points(case: "Case") -> Iterator[Stage]:
    """Planned where the case has points on a body that some table moves."""
    if not case.point:
        return
    from vibecalc.points.tables import zoned

    moved_by, names = table_that_moves(case), ", ".join(one.name for one in case.point[:3])
    torque, loads = moved_by in with_torque(case), loads_on(case, moved_by)
    severity, zones = case.vibration_severity, zoned(case.vibration_severity)
    without = ["/run_up/", *(f"zone_boundary/{name}" for name in UNITS if name not in zones)]
    without += ["points/zone"] * (not zones) + ["points/severity"] * (severity is None)
    readings = sum(1 if one.direction is not None else 3 for one in case.point)
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
        work=lambda _, orders: ((readings * orders, "reading_order"),),
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
        work=lambda _, orders: (
            (2 * orders * _RUN_UP, "body_solve"),
            (3 * readings * orders * _RUN_UP, "reading_order"),
        ),
        topics=("vibecalc.points.accuracy:points_run_up_topics",),
    )


#: speeds that a run-up of readings takes
_RUN_UP = 400


def names_of(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    """Entries of the axis that the points of the case make."""
    if not case.point:
        return {}
    from vibecalc.points.model import readings_of

    return {"sensor": readings_of(case).names}


SUBJECT = Subject(
    stages=(plan_points,),
    names=names_of,
    entries=lambda case, _, axis: entries_of_loads(case, axis, table_that_moves(case)),
    concerns=lambda case: bool(case.point) or case.vibration_severity is not None,
    units={"reading_order": Unit(1.0e-6, "orders of readings at points")},
    checks=("vibecalc.points.model:points_problems",),
    cautions=("vibecalc.points.model:points_cautions",),
    sections=("vibecalc.points.report:points",),
    pictures={
        "points_by_order": "vibecalc.points.pictures:BY_ORDER",
        "points_run_up": "vibecalc.points.pictures:OVER_SPEED",
    },
    assumes=("Points are fixed to the rigid machine.",),
)
