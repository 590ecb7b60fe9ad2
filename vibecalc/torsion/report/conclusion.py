"""The conclusion of a calculation of a shaft line: a line for each limit that was judged."""

import numpy as np

from vibecalc.core.report.pages import conclusion, limit_verdict
from vibecalc.core.report.sections import having, read_as
from vibecalc.core.report.verdicts import place_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import (
    BARRED,
    Result,
    Verdict,
)
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.torsion.report.couplings import as_text
from vibecalc.torsion.report.limits import ranges_in_words
from vibecalc.torsion.report.line import TORSION, short, turns
from vibecalc.torsion.results import COUPLING


def in_one_sentence(result: Result) -> str:
    """How many limits are kept, which are not, and the speed ranges that are barred."""
    rows = verdicts_of(result)
    if not rows:
        return "The case sets no limit, so none is judged."
    ranges = ranges_in_words(result)
    if not ranges and having(result.record, f"{TORSION}limit/largest_use", "limit"):
        ranges = ["no speed range is barred"]
    return "; ".join([conclusion([], rows).rstrip("."), *ranges]) + "."


_BARRED = (
    "Kept but where barred: exceeded only in speed ranges that the rule lets be barred for "
    "continuous running, and not at the operating speed."
)
_INFORMATIVE = "Informative: the society's or the standard's current text counts."
_COUPLINGS = "Use of a coupling: T_KW counts by its frequency, a temperature by its rise."


def conclusion_table(result: Result) -> list[str]:
    """The sentence, and the table of limits."""
    rows = verdicts_of(result)
    columns = [Column("element"), Column("limit"), Column("rule"), Column("status"),
               number("allowed"), number("computed"), Column("unit"), number("use\n%"),
               number("at\nrpm"), Column("verdict")]  # fmt: skip
    coupled = any(row.element and row.quantity.startswith(COUPLING) for row in rows)
    words = [_BARRED] * any(row.state == BARRED for row in rows)
    words += [_INFORMATIVE] * any(row.status == "informative" for row in rows)
    words += [_COUPLINGS] * coupled
    return [*paragraph(in_one_sentence(result)), *table(columns, map(_cells, rows)),
            *paragraph(" ".join(words))[: len(words)]]  # fmt: skip


def _cells(row: Verdict) -> list[str]:
    use = show(100.0 * row.use) if np.isfinite(row.use) else ""
    at = turns(row.speed) if np.isfinite(row.speed) else ""
    sides = (("min", row.min), ("max", row.max))
    bounds = ", ".join(f"{side} {short(one)}" for side, one in sides if one is not None)
    if row.element:
        element, limit, source = row.element, row.limit, row.source
        limit += f"; {row.condition}" if row.condition else ""
        bare = not row.unit and row.max == 1.0  # the use itself
        bounds = bounds if row.min is not None else as_text(row.max or 0.0, row.unit)
        bounds, computed = ("", "") if bare else (bounds, as_text(row.computed, row.unit))
    else:
        picks = ", ".join(f"{axis.replace('_', ' ')} {one}" for axis, one in row.where.items())
        element = place_of(row).strip() or picks or "line"
        limit = read_as(row.quantity, row.unit)[0] + " (start)" * (row.at == "start")
        source, computed = row.source or "limit of the case", show(row.computed, row.error_estimate)
    return [element, limit, source, row.status, bounds, computed, row.unit, use, at,
            limit_verdict(row)]  # fmt: skip
