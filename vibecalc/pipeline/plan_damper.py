"""The stage that finds the damper of a shaft line."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.pipeline.entries.damper_design import OBJECTIVES, ROOT
from vibecalc.pipeline.plan_torsion_studies import PARTS, line_orders
from vibecalc.pipeline.stage_plan import StagePlan, below

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def plan_damper(case: "Case") -> Iterator[StagePlan]:
    """Planned where [damper_design] is in the case."""
    options = case.damper_design
    if options is None or case.machine.shaft_line is None:
        return
    left_out = [f"worst_{name}" for name in OBJECTIVES if name != options.objective]
    for stem in ("chart/", "ring/", "curve/"):
        left_out += [f"{stem}{name}" for name in OBJECTIVES if name != options.objective]
    if options.compare is None:
        left_out.append(f"{ROOT}table/")
    both = {"stiffness", "damping"} <= set(options.find)
    if not both:
        left_out.append(f"{ROOT}chart/")
    if not options.rings:
        left_out.append(f"{ROOT}ring/")
    count = 1 + len(options.rings)
    searches = f"{count} searches, one for each ring: " if options.rings else ""
    yield StagePlan(
        stage="damper design",
        adapter="vibecalc.pipeline.stages.damper_design:run",
        why="[damper_design] is in the case",
        parts=PARTS,
        orders=line_orders(case),
        cost=f"{searches}a map of dampers by changes of rank one, then descents and Newton's "
        "method",
        quantities=below(ROOT, without=tuple(left_out)),
        is_last=True,
    )
