"""The mounts in the report: static load, stiffness in use, distance to their stops."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Made, Rows, rows_of
from vibecalc.core.report.sections import Section, labels, section
from vibecalc.core.results.record import Estimate, Quantity, Record, Result, Verdict
from vibecalc.core.results.verdicts import state_of
from vibecalc.isolation.mount_results import MOVING, OF_RUN_UP, OF_STOPS, OfMounts

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


_AT_REST = (
    Cells("load", "load kN", "kN"),
    Cells("deflection", "deflection mm", "mm"),
    Cells("static_stiffness", "static stiffness kN/mm", "kN/mm"),
    Cells("stiffness", "dynamic stiffness kN/mm", "kN/mm", "along the axis of the mount that "
          "carries; the dynamic stiffness is that about the rest, with stops that it stands on"),
)  # fmt: skip
_STOPS = (
    Cells("clearance_at_rest", "to stops at rest mm", "mm", blank=True),
    Cells("travel", "travel at speed mm", "mm"),
    Cells("clearance", "least clearance mm", "mm", blank=True),
    Cells("run_up_travel", "travel in the run-up mm", "mm"),
    Cells("run_up_travel_speed", "at rpm", "rpm"),
    Cells("run_up_clearance", "clearance left mm", "mm", blank=True),
)
_OVER_ORDERS = (
    Cells(_first("order_stiffness"), "order {} kN/mm", "kN/mm"),
    Cells(_first("order_loss_factor"), "loss factor {}"),
)


def mounts(result: Result) -> Section | None:
    """Tables by mount; None where their stiffness is constant."""
    record, root = result.record, OfMounts.ROOT
    shown = {path for path in record if path.startswith(f"{root}/")}
    tables = [
        rows_of(record, Rows("mount", "mount", columns, root=root, merge=True))
        for columns in (_AT_REST, _STOPS, _OVER_ORDERS)
    ]
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
