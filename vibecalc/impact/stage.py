"""The stage of impacts in joints with play."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Entries, Stage, Subject, Unit, below, first_orders

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_impact(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [response.impact]."""
    study = None if case.response is None else case.response.impact
    if study is None:
        return
    machine, joints = case.machine, case.machine.joints
    left_out = tuple(
        f"/impact/{part}"
        for part, given in (
            ("crank_pin/", joints is not None and joints.crank_pin is not None),
            ("bore/", joints is not None and joints.bore is not None),
            ("motor", machine.motor is not None and case.excitation is not None),
        )
        if not given
    )
    from vibecalc.impact.checks import impact_work  # loads what follows the contacts

    work = impact_work(case)
    steps = "" if work is None else f", about {work.steps:.2g} steps per turn"
    counted = 0 if work is None else math.ceil(work.total)
    turns = study.discard + study.revolutions
    runs = study.members * max(len(study.clearances), 1)
    orders = first_orders(study.orders, "[response.impact] orders, of the joint force")
    yield Stage(
        name="impact",
        adapter="vibecalc.impact.adapter:run_impact",
        why="[response.impact] is in the case",
        parts=("crank_train", "joints"),
        orders=f"1 to {study.orders} of the joint force",
        cost=f"{runs} runs of {turns} turns in one batch{steps}",
        quantities=below("response/impact/", without=left_out),
        is_last=True,
        harmonics=lambda _: orders,
        work=lambda *_: ((counted, "contact_step"),),
        topics=("vibecalc.impact.accuracy:impact_topics",),
    )


_WRIST_PIN_CLEARANCE = "machine.joints.wrist_pin.clearance"


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    study = None if case.response is None else case.response.impact
    if study is None:
        return None
    if axis == "order":
        return Entries.up_to(study.orders, "orders of [response.impact] is the highest")
    if axis != "clearance":
        return None
    if study.clearances:
        return Entries(study.clearances, "clearances of [response.impact] takes more of them")
    joints, search = case.machine.joints, case.optimisation
    varied = search is not None and any(one.key == _WRIST_PIN_CLEARANCE for one in search.variables)
    if joints is None or varied:
        return None
    because = "clearances of [response.impact] takes others, or more"
    return Entries((joints.wrist_pin.clearance,), because)


SUBJECT = Subject(
    stages=(plan_impact,),
    entries=_entries,
    concerns=lambda case: (
        case.machine.joints is not None
        or (case.response is not None and case.response.impact is not None)
    ),
    units={
        "contact_step": Unit(6.0e-4, "batched steps from contact to contact"),
    },
    checks=("vibecalc.impact.checks:joint_problems",),
    sections=("vibecalc.impact.report:impact",),
    pictures={
        "impact_clearance": "vibecalc.impact.pictures:IMPACT_CLEARANCE",
        "impact_time": "vibecalc.impact.pictures:IMPACT_TIME",
        "impact_spectrum": "vibecalc.impact.pictures:draw_impact_spectrum",
        "dominance": "vibecalc.impact.pictures:DOMINANCE",
    },
    assumes=(
        "The crank turns at constant speed; the pin strikes springs across a gap. The "
        "motion is chaotic: results are means over many runs, with their standard error.",
    ),
)
