"""The stage of impacts in joints with play."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import (
    Entries,
    Harmonics,
    Stage,
    Subject,
    Unit,
    Work,
    below,
    first_orders,
)

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_impact(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [response.impact]."""
    if case.response is not None and case.response.impact is not None:
        yield _impact(case)


def _impact(case: "Case") -> Stage:
    options, machine = case.response, case.machine
    assert options is not None and options.impact is not None
    study, joints = options.impact, machine.joints
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
    turns = study.discard + study.revolutions
    runs = study.members * max(len(study.clearances), 1)
    return Stage(
        name="impact",
        adapter="vibecalc.impact.adapter:run_impact",
        why="[response.impact] is in the case",
        parts=("crank_train", "joints"),
        orders=f"1 to {study.orders} of the joint force",
        cost=f"{runs} runs of {turns} turns in one batch{steps}",
        quantities=below("response/impact/", without=left_out),
        is_last=True,
        harmonics=_orders_of_impact,
        work=_work_of_impact,
        topics=("vibecalc.impact.accuracy:impact_topics",),
    )


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def _orders_of_impact(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.impact is not None
    return first_orders(case.response.impact.orders, "[response.impact] orders, of the joint force")


def _work_of_impact(case: "Case", orders: int) -> Work:
    from vibecalc.impact.checks import impact_work  # loads what follows the contacts

    work = impact_work(case)
    return ((0 if work is None else math.ceil(work.total), "contact_step"),)


_WRIST_PIN_CLEARANCE = "machine.joints.wrist_pin.clearance"


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    study = None if case.response is None else case.response.impact
    if study is None:
        return None
    if axis == "order":
        return Entries.up_to(study.orders, "orders of [response.impact] is the highest")
    return _clearances(case, study.clearances) if axis == "clearance" else None


def _clearances(case: "Case", listed: tuple[float, ...] | None) -> Entries | None:
    joints, search = case.machine.joints, case.optimisation
    if listed:
        return Entries(listed, "clearances of [response.impact] takes more of them")
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
