"""The mounts in the report: static load, stiffness in use, distance to their stops."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Made, Rows, rows_of
from vibecalc.core.report.sections import Section, labels, section
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Estimate, Quantity, Record, Result, Verdict
from vibecalc.core.results.verdicts import state_of
from vibecalc.isolation.mount_results import AT_REST, MOVING, OF_RUN_UP, OF_STOPS, OfMounts

#: orders shown of stiffness over frequency
_ORDERS = 4


def _first(name: str) -> Made:
    """The first orders of what each mount has."""

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(f"{OfMounts.ROOT}/{name}")
        if found is None:
            return None
        orders = replace(found.axes[1], values=found.axes[1].values[:_ORDERS])
        return replace(found, values=found.values[:, :_ORDERS], axes=(found.axes[0], orders))

    return made


_COLUMNS = (
    AT_REST[:4],
    [Cells(path, blank=True) for path in (*OF_STOPS, *MOVING, *OF_RUN_UP)],
    (Cells(_first("order_stiffness"), "order {} kN/mm", "kN/mm"),
     Cells(_first("order_loss_factor"), "loss factor {}")),
)  # fmt: skip
_NOTE = (
    "load, deflection and stiffness along the axis of the mount that carries; the dynamic "
    "stiffness is that about the rest, with stops that it stands on"
)


def mounts(result: Result) -> Section | None:
    """Tables by mount; None where their stiffness is constant."""
    record = result.record
    shown = {path for path in record if path.startswith(f"{OfMounts.ROOT}/")}
    tables = [rows_of(record, Rows("mount", "mount", one, merge=True)) for one in _COLUMNS]
    tables += [paragraph(_NOTE)] * any(map(any, tables))
    return section("Mounts: load, stiffness in use, clearance", tables, shown=shown)


def stop_verdicts(result: Result) -> Iterator[Verdict]:
    """No mount meets a stop that it does not stand on at rest: the least distance to one."""
    rest = result.record.quantities.get(OF_STOPS[0])
    for path, words in ((MOVING[1], "at speed"), (OF_RUN_UP[2], "in the run-up")):
        found = result.record.quantities.get(path)
        if found is None or rest is None:
            continue
        left = np.where(np.asarray(rest.values) > 0.0, found.values, np.inf)
        place = int(np.argmin(left))
        if np.isfinite(left[place]):
            name, error = labels(found.axes[0])[place], found.error_estimate
            state = state_of(left[place], error, float(rest.values[place]))
            least = 1e3 * float(left[place])
            yield Verdict(
                quantity=path, where={}, source="stops of the mounts", min=0.0,
                max=None, unit="mm", computed=least, label=f"mount={name}",
                error_estimate=Estimate(1e3 * error, 0.0), margin=least, state=state,
                element=f"mount {name}", limit=f"clearance to a stop {words}",
            )  # fmt: skip
