"""The run-up: largest couple over lever, and the speeds that were left out."""

import numpy as np

from vibecalc.report.lookup import along
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.section import scalars
from vibecalc.report.tables import number, paragraph, table
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
        lines += _left_out(record)
    return lines, shown | set(masked)


def _left_out(record: Record) -> list[str]:
    """One row per interval; its ends agree to so many digits that its width says more."""
    low, centre, high, order, mode = (
        record[_MASKED + name].values for name in ("low", "centre", "high", "order", "mode")
    )
    rows = [
        [
            f"{order[i]:g}",
            str(int(mode[i])),
            show(float(centre[i])),
            show(rpm(float(centre[i]))),
            f"{(high[i] - low[i]) / (2.0 * centre[i]):.1e}",
        ]
        for i in range(len(centre))
    ]
    columns = (
        number("order", 8),
        number("mode", 8),
        number("rad/s", 14),
        number("rpm", 14),
        number("half width, relative", 22),
    )
    return table(columns, rows)
