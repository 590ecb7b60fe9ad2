"""What `check` shows: the case in a few lines, then what a run would do and why."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from vibecalc.report.tables import pairs, paragraph

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase
    from vibecalc.case.schema import Case

#: keys of a plan row, in the order shown, with their headings
ROWS = (
    ("why", "why"),
    ("parts", "reads"),
    ("orders", "orders"),
    ("cost", "cost"),
    ("quantities", "makes"),
)


def plan_object(
    loaded: "LoadedCase", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> dict[str, Any]:
    """What `check --json` prints of one case; `plan` and `total` as for `render_plan`."""
    from vibecalc.parts.cautions import machine_warnings

    return {
        "case": str(loaded.path),
        "title": loaded.case.title,
        "sha256": loaded.sha256,
        "warnings": machine_warnings(loaded.case),
        "plan": plan,
        "needs": total,
    }


def render_plan(
    path: str, case: "Case", plan: Sequence[Mapping[str, Any]], total: Mapping[str, Any]
) -> str:
    """The plan as text: stages, why, what they read, orders, cost, quantities; the whole.

    `plan` and `total` are those of `study.check_rows`.
    """
    from vibecalc.parts.cautions import machine_warnings

    lines = [f"{path}: {case.title}", f"no problems; accuracy rtol = {case.accuracy.rtol:g}"]
    for words in machine_warnings(case):
        lines += paragraph(words, "warning:")
    for number, stage in enumerate(plan, start=1):
        lines += ["", f"{number}. {stage['stage']}"]
        shown = {**stage, "quantities": _by_folder(stage.get("quantities", ""))}
        lines += pairs([(name, shown[key]) for key, name in ROWS if shown.get(key)], width=8)
    counted = [row for row in case.reference if row.kind == "published"]
    counted = [row for row in counted if not row.known_difference]
    lines += [
        "",
        str(total["text"]),
        f"{_count(len(case.reference), 'reference')}, {len(counted)} of them counted; "
        f"{_count(len(case.limit), 'limit')}",
    ]
    return "\n".join(lines)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def _by_folder(quantities: str) -> str:
    """One line per folder of result paths, so that no path is broken in two."""
    folders: dict[str, list[str]] = {}
    for path in quantities.split(", "):
        folder, _, name = path.rpartition("/")
        folders.setdefault(folder, []).append(name)
    return "\n".join(f"{folder}: {', '.join(names)}" for folder, names in folders.items() if folder)
