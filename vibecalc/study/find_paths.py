"""Result paths that [[find]] adds to those of the stages, and its row of the plan."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.case.load import resolve
from vibecalc.case.overrides import field_unit, number_at
from vibecalc.pipeline.catalogue import CATALOGUE
from vibecalc.pipeline.entries.entry import Entry
from vibecalc.pipeline.plan import needed_stages, planned_quantities

if TYPE_CHECKING:
    from vibecalc.case.find_tables import Find
    from vibecalc.case.schema import Case

ROOT = "find"
#: below it the results of the machine that a search found
MACHINE = "machine"


def find_entries(case: "Case") -> dict[str, Entry]:
    """Catalogue entries of everything under `find/` for a case that searches."""
    if not case.find:
        return {}
    planned, resolved = planned_quantities(case), resolve(case)
    found: dict[str, Entry] = {}
    for search in case.find:
        goal = planned.get(search.quantity)
        unit, kind = (goal.unit, goal.amplitude) if goal else ("", None)
        written = number_at(resolved, search.key, math.nan)
        found |= {entry.path: entry for entry in _entries(search, written, unit, kind)}
        for path in machine_paths(case, search):
            entry = planned[path]._replace(path=f"{ROOT}/{search.name}/{MACHINE}/{path}")
            found[entry.path] = entry
    return found


def machine_paths(case: "Case", search: "Find") -> tuple[str, ...]:
    """Results without axes of the stages that a search runs: of the machine found, too."""
    stages = needed_stages(case, frozenset({search.quantity}))
    paths = (path for stage in stages for path in stage.quantities)
    return tuple(path for path in paths if not CATALOGUE[path].axes)


def _entries(search: "Find", written: float, unit: str, kind: str | None) -> Iterator[Entry]:
    root, key, own = f"{ROOT}/{search.name}", search.key, field_unit(search.key)
    yield Entry(f"{root}/value", (), own, f"{key} that brings what is wanted")
    is_written = math.isfinite(written)
    if is_written and written != 0.0:
        yield Entry(f"{root}/ratio", (), "", "that value over the one written")
    yield Entry(f"{root}/reached", (), unit, f"{search.quantity} there", kind)
    if search.seek is None:
        yield Entry(f"{root}/wanted", (), unit, f"{search.quantity} that is wanted", kind)
    if is_written:
        yield Entry(f"{root}/written", (), own, f"{key} as written")
    yield Entry(f"{root}/others", ("solution",), own, f"further values of {key} between the bounds")
    yield Entry(
        f"{root}/others_reached", ("solution",), unit, f"{search.quantity} with these", kind
    )
    for other in search.also:
        yield Entry(f"{root}/also/{other}", (), field_unit(other), f"{other} with that value")
    yield Entry(f"{root}/evaluations", (), "", "points evaluated")
    yield Entry(f"{root}/failures", (), "", "points that could not be evaluated")


def describe_find(case: "Case") -> dict[str, str]:
    """The row of the plan that the searches add."""
    keys = (key for search in case.find for key in (search.key, *search.also))
    runs = " + ".join(str(search.points) for search in case.find)
    return {
        "stage": "find",
        "why": "[[find]] is in the case",
        "parts": ", ".join(dict.fromkeys(keys)),
        "orders": "",
        "modules": ", ".join(f"study.{name}" for name in _modules(case)),
        "cost": f"{runs} runs, and some 15 for each solution, of the stages that make "
        + ", ".join(dict.fromkeys(search.quantity for search in case.find)),
        "quantities": ", ".join(find_entries(case)),
    }


def _modules(case: "Case") -> Iterator[str]:
    if any(search.seek is None for search in case.find):
        yield "find_roots"
    if any(search.seek is not None for search in case.find):
        yield "find_extremes"
