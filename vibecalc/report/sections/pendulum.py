"""Pendulums on a rotor: their order, what it becomes with the swing, what they absorb."""

import math

import numpy as np

from vibecalc.report.lookup import having, scalar_of, table_of
from vibecalc.report.numbers import show
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import number, paragraph, table
from vibecalc.results.record import Record, Result

PENDULUM = "pendulum/"
_SCALARS = (
    *("order", "path_radius", "path_exponent", "detuning", "largest_swing", "mass_ratio"),
    *("inertia", "stiffness", "small/rotor", "small/swing", "small/rotor_without"),
    *("jump/torque", "jump/swing"),
)
_COURSE = 9


def pendulum(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(PENDULUM))
    if not shown:
        return None
    lines, _ = scalars(record, (PENDULUM + name for name in _SCALARS), PENDULUM)
    for block in (_course(record), _words(result)):
        if block:
            lines += ["", *block]
    return Section("Centrifugal pendulums", lines, shown)


def _course(record: Record) -> list[str]:
    found = having(record, PENDULUM + "order_of_swing", "swing")
    if found is None:
        return []
    swings = np.asarray(found.axes[0].values, dtype=float)
    chosen = np.unique(np.linspace(0, len(swings) - 1, _COURSE).round().astype(int))
    small = float(found.values[0])
    columns = (number("swing, deg", 12), number("order", 13), number("off by, %", 12))
    rows = []
    for i in chosen:
        value = float(found.values[i])
        off = 100.0 * (value / small - 1.0)
        slack = 200.0 * found.error_estimate / small
        rows.append([f"{math.degrees(swings[i]):.1f}", show(value), show(off, slack, 3)])
    return table(columns, rows)


def _words(result: Result) -> list[str]:
    record = result.record
    rotor, alone = (scalar_of(record, PENDULUM + f"small/{x}") for x in ("rotor", "rotor_without"))
    lines = []
    if rotor is not None and alone is not None:
        swing = scalar_of(record, PENDULUM + "small/swing") or 0.0
        share = show(alone / rotor, digits=3) if rotor > 0.0 else "any"
        lines += paragraph(
            f"small swings of {show(math.degrees(swing), digits=4)} deg bring the rotor's motion "
            f"down by a factor {share}"
        )
    torque = table_of(result.case, "machine", "pendulum").get("torque")
    limit = scalar_of(record, PENDULUM + "jump/torque")
    if limit is not None and math.isfinite(limit):
        words = f"beyond {show(limit)} N*m the pendulums jump out of step with the torque"
        if isinstance(torque, int | float) and torque:
            words += f", {show(limit / torque, digits=3)} times the one of the case"
        lines += paragraph(words)
    return lines
