"""Whatever no other section has shown, so that a new stage is reported from its first day."""

from collections.abc import Iterable

import numpy as np

from vibecalc.report.generic import LONGEST, grouped
from vibecalc.report.lookup import START
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import paragraph
from vibecalc.results.record import Result


def other(result: Result, shown: Iterable[str]) -> Section | None:
    """Scalars and short vectors left over, and the names of what only the file holds."""
    done = set(shown)
    left = [
        quantity
        for path, quantity in result.record.items()
        if path not in done and not path.startswith(START)
    ]
    if not left:
        return None
    lines = grouped(left)
    large = [
        quantity.path
        for quantity in left
        if len(quantity.axes) > 1 or np.size(quantity.values) > LONGEST
    ]
    if large:
        lines += [""] if lines else []
        lines += paragraph("in the result file only: " + ", ".join(large))
    if not lines:
        return None
    return Section("Further results", lines, frozenset(quantity.path for quantity in left))
