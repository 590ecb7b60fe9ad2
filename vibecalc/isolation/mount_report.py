"""The mounts in the report: static load, stiffness in use, distance to their stops."""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, first, others, rows_of
from vibecalc.core.report.sections import Section, labels, section
from vibecalc.core.results.record import Result, Verdict
from vibecalc.core.results.verdicts import judge
from vibecalc.isolation.results import AT_REST, BY_ORDER, MOVING, OF_RUN_UP, OF_STOPS, OfMounts

_COLUMNS: tuple[Sequence[Cells | str], ...] = (
    (*AT_REST[:3], Cells(AT_REST[3], note="along the load axis of the mount; stiffness: "
                         "dynamic, about the rest position, stops in contact included")),
    [Cells(path, blank=True) for path in (*OF_STOPS, *MOVING, *OF_RUN_UP)],
)  # fmt: skip
_OVER_ORDERS = Rows(
    "order", "order",
    (Cells(BY_ORDER[0], "stiffness {} kN/mm", "kN/mm"), Cells(BY_ORDER[1], "loss factor {}")),
    label="{:g}", places=first(4), rest=others("{left} more orders in the result file"),
)  # fmt: skip


def mounts(result: Result) -> Section | None:
    """Tables by mount; None where their stiffness is constant."""
    record = result.record
    shown = {path for path in record if path.startswith(f"{OfMounts.ROOT}/")}
    tables = [Rows("mount", "mount", columns, merge=True) for columns in _COLUMNS]
    lines = [rows_of(record, one) for one in (*tables, _OVER_ORDERS)]
    return section("Mounts: static load, stiffness, clearance", lines, shown=shown)


def stop_verdicts(result: Result) -> Iterator[Verdict]:
    """No mount meets a stop that it does not stand on at rest: the least distance to one."""
    rest = result.record.quantities.get(OF_STOPS[0])
    for path, words in ((MOVING[1], "at speed"), (OF_RUN_UP[2], "in the run-up")):
        found = result.record.quantities.get(path)
        if found is None or rest is None:
            continue
        left = np.where(np.asarray(rest.values) > 0.0, found.values, np.inf)
        if np.isfinite(left).any():
            name = labels(found.axes[0])[int(np.argmin(left))]
            asked = {"quantity": path, "where": {"mount": name}, "min": "0 mm"}
            row = judge(result, {**asked, "source": "stops of the mounts"})
            row = row._replace(where={}, label=f"mount={name}", element=f"mount {name}")
            yield row._replace(limit=f"clearance to a stop {words}")
