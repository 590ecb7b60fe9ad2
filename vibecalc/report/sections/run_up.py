"""The run-up: largest couple over lever, and the speeds that were left out."""

import numpy as np

from vibecalc.report.generic import grouped
from vibecalc.report.lookup import along
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.section import scalars
from vibecalc.report.tables import paragraph
from vibecalc.results.record import Record

_PEAKS = tuple(f"isolation/lever_force/{name}" for name in ("run_up_peak", "run_up_peak_speed"))
_MASKED = "isolation/masked/"


def run_up(record: Record) -> tuple[list[str], set[str]]:
    """Lines and the paths shown; nothing if the result has no run-up."""
    lines, shown = scalars(record, _PEAKS, "isolation/")
    hit = along(record, "isolation/lever_force/run_up", "speed")
    if hit is not None and hit[1].size:
        low, high = float(np.min(hit[1])), float(np.max(hit[1]))
        lines += paragraph(
            f"run-up over {hit[1].size} speeds from {show(rpm(low))} to {show(rpm(high))} rpm; "
            "at each the peak over the cycle"
        )
    masked = [path for path in record if path.startswith(_MASKED)]
    if any(record[path].values.size for path in masked):
        lines += [
            "",
            "  Speeds left out (an order on an undamped natural frequency: no bound there)",
        ]
        lines += grouped([record[path] for path in masked], _MASKED)
    return lines, shown | set(masked)
