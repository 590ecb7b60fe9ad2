"""The cylinders of a pump: when the valves open, what is drawn, what it takes, torque by order."""

import numpy as np

from vibecalc.report.lookup import having, magnitudes
from vibecalc.report.numbers import show, show_phase
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

ROOT = "excitation/pump/"
_SCALARS = tuple(
    ROOT + name
    for name in ("suction_opens", "discharge_opens", "swept_volume", "volumetric_efficiency",
                 "flow", "work", "power", "mean_torque")
)  # fmt: skip
#: orders below this share of the largest one stay in the result file
_SMALL = 1e-2
_MOST = 12
_WORDS = (
    "The suction valve opens so long after top dead centre, the discharge valve after bottom dead "
    "centre; both close at the dead centres. Work is of one cylinder in a turn, flow and power are "
    "of all; the torque of the liquid brakes the crankshaft."
)


def pump(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    lines, shown = scalars(result.record, _SCALARS, ROOT)
    if not lines:
        return None
    orders, paths = _orders(result.record)
    lines += paragraph(_WORDS) + (["", *orders] if orders else [])
    return Section("Pump: valves, volumes and torque", lines, frozenset(shown | paths))


def _orders(record: Record) -> tuple[list[str], set[str]]:
    torque = having(record, ROOT + "torque", "order")
    if torque is None:
        return [], set()
    size = magnitudes(torque)
    large = np.flatnonzero((size > 4.0 * torque.error_estimate) & (size >= _SMALL * size.max()))
    rows = [
        [
            f"{torque.axes[0].values[place]:g}",
            show(size[place], torque.error_estimate),
            show_phase(complex(torque.values[place]), torque.error_estimate),
        ]
        for place in large[:_MOST]
    ]
    columns = (Column("order", 8), number("torque N*m", 16), number("phase deg", 12))
    left = len(size) - len(rows)
    words = f"the other {left} orders are zero or weaker, and in the result file"
    return table(columns, rows) + (paragraph(words) if left else []), {torque.path}
