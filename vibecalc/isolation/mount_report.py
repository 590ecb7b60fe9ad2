"""The mounts in the report: static load, stiffness in use, distance to their stops."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import Section, labels, section, stacked
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Estimate, Record, Result, Verdict
from vibecalc.core.results.verdicts import state_of
from vibecalc.isolation.mount_results import (
    AT_REST,
    BY_ORDER,
    MOVING,
    OF_RUN_UP,
    OF_STOPS,
    OfMounts,
)

#: orders shown of stiffness over frequency
_ORDERS = 4
_LOADS = (
    (AT_REST[0], "load", "kN"),
    (AT_REST[1], "deflection", "mm"),
    ("isolation/support_displacement/sag", "sag of\nthe body", "mm"),
    (AT_REST[2], "static\nstiffness", "kN/mm"),
    (AT_REST[3], "dynamic\nstiffness", "kN/mm"),
)
_TRAVEL = (
    (OF_STOPS[0], "clearance\nat rest", "mm"),
    (MOVING[0], "travel\nat speed", "mm"),
    (MOVING[1], "least\nclearance", "mm"),
)
_RUN_UP = (
    (OF_RUN_UP[0], "travel", "mm"),
    (OF_RUN_UP[1], "at", "rpm"),
    (OF_RUN_UP[2], "clearance left", "mm"),
)


def mounts(result: Result) -> Section | None:
    """Tables by mount; None where their stiffness is constant."""
    record = result.record
    shown = {path for path in record if path.startswith(f"{OfMounts.ROOT}/")}
    if not shown:
        return None
    loads = by_axis(record, "mount", "mount", _LOADS) if AT_REST[0] in record else []
    none = (*OF_STOPS, MOVING[1], OF_RUN_UP[2])
    stops, passed = (
        by_axis(record, "mount", title, columns, blank=none)
        for title, columns in (("distance to stops", _TRAVEL), ("largest in the run-up", _RUN_UP))
    )
    lines = stacked(loads, stops, passed, _over_orders(record))
    if loads:
        lines += paragraph(
            "load, deflection and stiffness along the axis of the mount that carries; the dynamic "
            "stiffness is that about the rest, with stops that it stands on"
        )
    return section("Mounts: load, sag, stiffness in use, clearance", [(lines, shown)])


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


def _over_orders(record: Record) -> list[str]:
    """Stiffness and loss factor of each mount at the first orders."""
    stiffness, loss = (record.quantities.get(path) for path in BY_ORDER)
    if stiffness is None or loss is None:
        return []
    orders = [int(order) for order in stiffness.axes[1].values[:_ORDERS]]
    rows: dict[tuple[str, ...], list[str]] = {}
    for place, name in enumerate(labels(stiffness.axes[0])):
        cells = tuple(
            f"{show(float(k) * 1e-6)}, {show(float(eta))}"
            for k, eta in zip(
                np.abs(stiffness.values[place, : len(orders)]),
                loss.values[place, : len(orders)],
                strict=True,
            )
        )
        rows.setdefault(cells, []).append(name)
    columns = [Column("kN/mm, loss factor"), *(number(f"order {order}") for order in orders)]
    return table(columns, [[", ".join(names), *cells] for cells, names in rows.items()])
