"""Which stages a case asks for, and why: read from the case alone, nothing is computed.

A table that is absent from the case is a stage that is not planned, not imported, not run and
not reported.
"""

from typing import TYPE_CHECKING

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Entry
from vibecalc.core.run.stage import Stage, subjects

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_case(case: "Case") -> tuple[Stage, ...]:
    """The stages of `case` in the order in which they run."""
    return tuple(
        stage for subject in subjects().values() for make in subject.stages for stage in make(case)
    )


def needed_stages(case: "Case", wanted: frozenset[str] | None) -> tuple[Stage, ...]:
    """Of the stages of `case` those that bring what is wanted, None being all, in their order.

    A stage that others read from is there with any later one, since it may be read by that.
    """
    needed: list[Stage] = []
    for stage in reversed(plan_case(case)):
        brings = wanted is None or not wanted.isdisjoint(stage.quantities)
        if brings or (needed and not stage.is_last):
            needed.append(stage)
    return tuple(reversed(needed))


def planned_quantities(case: "Case") -> dict[str, Entry]:
    """Every result path that a run of `case` will hold, with its catalogue entry."""
    return {path: CATALOGUE[path] for stage in plan_case(case) for path in stage.quantities}
