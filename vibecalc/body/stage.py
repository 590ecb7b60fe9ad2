"""The stage of a body that is assembled of parts."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Stage, Subject, below

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_body(case: "Case") -> Iterator[Stage]:
    """Planned where the body has parts."""
    body = case.machine.body
    if body is None or body.parts is None:
        return
    yield Stage(
        name="body",
        adapter="vibecalc.body.adapter:run_body",
        why="[[machine.body.parts]] are in the case",
        parts=("body",),
        orders="none",
        cost=f"{len(body.parts)} parts added up",
        quantities=below("body/"),
        is_last=True,
    )


SUBJECT = Subject(
    stages=(plan_body,),
    concerns=lambda case: case.machine.body is not None and case.machine.body.parts is not None,
    units={},
    sections=("vibecalc.body.report:body",),
    assumes=("The machine is one rigid body made of its parts.",),
)
