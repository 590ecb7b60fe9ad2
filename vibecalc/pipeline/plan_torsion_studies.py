"""What a case asks of a shaft line beside its steady response: one stage for each question."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.machine.transient_checks import least_steps
from vibecalc.pipeline.entries.torsion_studies import (
    OF_PASSAGES,
    OF_STEPS,
    PUBLISHED,
    TRANSIENT,
    VARIABLE,
)
from vibecalc.pipeline.stage_plan import StagePlan, below

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.case.torsion_tables import Torsion

PARTS = ("crank_train", "shaft_line")
#: changes at constant speed
_STEPS = ("load_step", "misfire_onset")


def plan_torsion_studies(case: "Case") -> Iterator[StagePlan]:
    """The modal route as published, the variable inertia and the transient, where asked for."""
    torsion = None if case.response is None else case.response.torsion
    if torsion is None or case.machine.shaft_line is None:
        return
    if torsion.as_published is not None:
        yield _published(case)
    if torsion.variable_inertia is not None:
        yield _variable(case)
    if torsion.transient is not None:
        yield _transient(case)


def line_orders(case: "Case") -> str:
    """Orders of the excitation in words."""
    torsion = None if case.response is None else case.response.torsion
    given = None if torsion is None else torsion.orders
    if given is None or given.count is None:
        highest = 12.0 if given is None or given.highest is None else given.highest
        return f"up to {highest:g}, mean torque apart"
    return f"the first {given.count}, mean torque apart"


def has_loss(case: "Case") -> bool:
    """Whether something on the line has a loss factor, which has no form in time."""
    line = case.machine.shaft_line
    assert line is not None
    shafts, dampers = line.shafts, line.dampers
    return any(one.loss_factor for one in shafts) or any(one.loss_factor for one in dampers)


def _published(case: "Case") -> StagePlan:
    torsion = _torsion(case)
    options = torsion.as_published
    assert options is not None
    without = ("/twist", "/largest_twist") if torsion.speeds is None else ()
    paths = below(PUBLISHED, without=without)
    if torsion.speeds is None:
        paths += (f"{PUBLISHED}twist_at_critical", f"{PUBLISHED}largest_twist")
        paths += (f"{PUBLISHED}largest_twist_order",)
    if options.magnifier == "undamped":
        paths = tuple(p for p in paths if "critical" not in p and "largest_twist" not in p)
    return StagePlan(
        stage="modal route as published",
        adapter="vibecalc.pipeline.stages.torsion.published:run",
        why="[response.torsion.as_published] is in the case",
        parts=PARTS,
        orders=line_orders(case),
        cost=f"closed forms for {options.modes} modes, each order"
        + ("" if torsion.speeds is None else f" and each of {torsion.speeds.points} speeds"),
        quantities=paths,
        is_last=True,
    )


def _variable(case: "Case") -> StagePlan:
    torsion = _torsion(case)
    there = list(below(VARIABLE))
    if torsion.speeds is None:
        over = (f"{VARIABLE}{name}" for name in ("speeds/", "wedge/", "unstable/", "largest_"))
        there = [path for path in there if not path.startswith(tuple(over))]
    if has_loss(case):
        timed = (f"{VARIABLE}growth", f"{VARIABLE}unstable/")
        there = [path for path in there if not path.startswith(timed)]
    return StagePlan(
        stage="variable inertia",
        adapter="vibecalc.pipeline.stages.torsion.variable:run",
        why="[response.torsion.variable_inertia] is in the case",
        parts=PARTS,
        orders=line_orders(case) + ", and further ones of the motion",
        cost=_all_orders(torsion.speeds.points if torsion.speeds is not None else 0),
        quantities=tuple(there),
        is_last=True,
    )


def _transient(case: "Case") -> StagePlan:
    change = _torsion(case).transient
    assert change is not None
    steps = change.kind in _STEPS
    left_out = OF_PASSAGES if steps else OF_STEPS
    return StagePlan(
        stage="transient",
        adapter="vibecalc.pipeline.stages.torsion.transient:run",
        why=f'[response.torsion.transient] is in the case, kind = "{change.kind}"',
        parts=PARTS,
        orders=line_orders(case),
        cost=f"matrix exponentials over {round(least_steps(case))} steps of a third of the highest "
        "order's period, or more",
        quantities=tuple(path for path in below(TRANSIENT) if path not in left_out),
        is_last=True,
    )


def _all_orders(speeds: int) -> str:
    over = f"{speeds} solves of all orders at once, and " if speeds else ""
    return f"{over}Newton's method with all orders at the operating speed"


def _torsion(case: "Case") -> "Torsion":
    assert case.response is not None and case.response.torsion is not None
    return case.response.torsion
