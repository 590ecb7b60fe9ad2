"""Isolation efficiency in the report."""

import numpy as np

from vibecalc.core.report.rows import (
    OTHERS,
    Cells,
    Made,
    Rows,
    by_name,
    in_decibels,
    loud,
    others,
    part_of,
    reduced,
    rows_of,
)
from vibecalc.core.report.sections import Section, having, section, stacked
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.isolation.results import ByDirection, OfCouples, OfForces

#: orders below this share of the largest stay in the result file, as those beyond so many
LOUD = loud(1e-3, 12, 2)
ROOTS = {"force": OfForces.ROOT, "couple": OfCouples.ROOT}


def isolation_efficiency(result: Result) -> Section | None:
    """What the mounts keep from the ground; None where the case does not ask."""
    record = result.record
    if f"{ByDirection.ROOT}/transmissibility" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{ByDirection.ROOT}/")}
    overall = by_name(record, "on the ground", _OVERALL, _COLUMNS, ByDirection.ROOT)[0]
    each = Rows("coordinate", "r.m.s. along, about", _BY_DIRECTION, ByDirection.ROOT, across=True)
    lines = stacked(overall, rows_of(record, each)[0]) + paragraph(
        "Efficiency: 1 - load on the ground / load of the rigidly mounted machine; negative: "
        "amplification."
    )
    details = {f"isolation efficiency by order, {word}": rows_of(record, _by_order(root))
               for word, root in ROOTS.items()}  # fmt: skip
    return section("Isolation efficiency", [(lines, shown)], details)


def _percent(share: float, _error: float = 0.0) -> str:
    """Nothing where no load acts: the ratio is then of what arrives or of nothing."""
    return f"{100.0 * share:.2f} %" if np.isfinite(share) and share != 1.0 else "-"


def _level(share: float, _error: float) -> str:
    """Of the load held still over what arrives."""
    return in_decibels(1.0 / (1.0 - share)) if np.isfinite(share) and share != 1.0 else "-"


_OVERALL = {f"{word}, {said}": (word, name)
            for word in ROOTS for name, said in (("rms", "r.m.s."), ("peak", "peak"))}  # fmt: skip
_COLUMNS = (
    Cells("{}/held_{}", "rigidly\nmounted"),
    Cells("{}/ground_{}", "on mounts"),
    Cells("{}/{}", "efficiency", _percent),
    Cells("{}/{}", "dB", _level),
)
_BY_DIRECTION = (Cells("by_direction", "efficiency", _percent),)


def resultant(path: str) -> Made:
    """Efficiency by order for all components together; none where no order has one."""

    def made(record: Record) -> Quantity | None:
        share = having(record, f"{path}/by_order", "order", "component")
        if share is None or not np.any(np.isfinite(share.values[:, -1])):
            return None
        return part_of(share, share.values[:, -1], share.axes[0])

    return made


def _by_order(root: str) -> Rows:
    columns = (
        Cells(reduced(f"{root}/held"), "rigidly mounted {unit}"),
        Cells(reduced(f"{root}/ground"), "on mounts {unit}"),
        Cells("by_order", "{} %", lambda share, _: _percent(share).removesuffix(" %")),
        Cells(resultant(root), "dB", _level),
    )
    return Rows("order", "order", columns, root, label="{:g}", places=LOUD,
                rest=others(OTHERS))  # fmt: skip
