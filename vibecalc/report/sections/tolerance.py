"""The tolerance of a run: how much of it was reached, and what each stage took for that."""

from vibecalc.pipeline.tolerance import UNRESOLVED
from vibecalc.pipeline.tolerance_summary import ToleranceSummary, summarised
from vibecalc.report.lookup import table_of
from vibecalc.report.numbers import show_error
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, pairs, table
from vibecalc.results.record import Result

_STAGES = (Column("stage", 28), number("s", 10), number("share %", 8), Column("work", 48))


def tolerance(result: Result) -> Section | None:
    """Results that reach `[accuracy] rtol`, the worst of them, and those that are exempt."""
    found = _summary(result)
    if found is None:
        return None
    rows = [("asked for", f"rtol = {found.rtol:g} of the largest magnitude of each result")]
    rows.append(("reached by", f"{found.met} of {found.held} results"))
    if found.worst:
        rows.append(("the worst", f"{found.worst}, {_share(found.share)}"))
    rows += [("not held to it", f"{count}: {words}") for words, count in found.exempt]
    return Section("Tolerance", pairs(rows, 16), frozenset())


def tolerance_line(result: Result) -> str:
    """The same in one line without the path, empty where a result says nothing of a tolerance."""
    found = _summary(result)
    if found is None:
        return ""
    worst = f", the worst {_share(found.share, 'has ', 'is ')}" if found.worst else ""
    return f"rtol = {found.rtol:g} reached by {found.met} of {found.held} results{worst}"


def _share(share: float, has: str = "", is_: str = "") -> str:
    return f"{is_}{UNRESOLVED}" if share >= 1.0 else f"{has}{show_error(share)}"


def stage_times(result: Result) -> list[str]:
    """A table of seconds by stage, with the work that the plan says it takes."""
    total = sum(result.timings.values())
    if not total:
        return []
    planned = {row.get("stage", ""): row.get("cost", "") for row in result.plan}
    rows = [
        [stage, f"{seconds:.4f}", f"{100.0 * seconds / total:.1f}", planned.get(stage, "")]
        for stage, seconds in result.timings.items()
    ]
    if len(rows) > 1:
        rows.append(["together", f"{total:.4f}", "100.0", ""])
    return [*table(_STAGES, rows), ""]


def _summary(result: Result) -> ToleranceSummary | None:
    rtol = table_of(result.case, "accuracy").get("rtol")
    found = None if rtol is None else summarised(result.record, float(rtol))
    return None if found is None or not found.held + len(found.exempt) else found
