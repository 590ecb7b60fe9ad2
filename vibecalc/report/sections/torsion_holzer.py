"""Holzer tables of the modes of a shaft line that matter, branch by branch."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.report.lookup import having, labels, magnitudes, speed_of
from vibecalc.report.numbers import hertz, rpm, show
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    elastic_modes,
    highest_frequency,
    joined,
    line_of,
    undamped_frequency,
    vector,
)
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from vibecalc.response.torsion.holzer import HolzerRows
    from vibecalc.response.torsion.line import Line

_MODES = TORSION + "modes/"
#: rows of all Holzer tables together
_ROWS = 120
#: of the largest entry of a Holzer table: less is rounding
_NOISE = 1e-11
#: from here on a column is written with powers of ten
_LARGE = 1e7


def holzer(result: Result) -> list[str]:
    """A table for each mode that matters, as far as the page goes; nothing without them."""
    angle = having(result.record, _MODES + "holzer_angle", "mode", "freedom")
    shaft = line_of(result)
    if angle is None or shaft is None:
        return []
    from vibecalc.response.torsion.holzer import holzer_rows

    square = (speed_of(result) or 0.0) ** 2
    line = shaft.line._replace(stiffness=shaft.line.stiffness + shaft.speed_stiffness * square)
    try:
        rows = holzer_rows(line)
    except NumericalFailure:
        return []
    lines: list[str] = []
    told: list[int] = []
    for mode in elastic_modes(result, undamped=True):
        if told and (len(told) + 1) * len(rows.freedom) > _ROWS:
            break
        lines += [""] if lines else []
        lines += _table(result.record, line, rows, angle, mode)
        told.append(mode)
    return lines + _rest(result, told)


def _rest(result: Result, told: list[int]) -> list[str]:
    """Which modes have no table here, and why."""
    natural = undamped_frequency(result.record)
    if natural is None:
        return []
    left = [int(i) for i in np.flatnonzero(natural > 0.0) if i not in told]
    top = highest_frequency(result)
    lines = []
    for modes, why in (
        ([i for i in left if natural[i] <= top], "only the lowest have, for want of room"),
        ([i for i in left if natural[i] > top],
         "no order of the case reaches so high within the speeds"),
    ):  # fmt: skip
        if modes:
            what = "Mode {} has" if len(modes) == 1 else "Modes {} have"
            which = what.format(joined(str(i + 1) for i in modes))
            which = f"Undamped {which.lower()}" if _differs(result.record) else which
            lines += paragraph(f"{which} no Holzer table here ({why}): in the result file.")
    return ["", *lines] if lines else []


def _table(
    record: Record, line: "Line", rows: "HolzerRows", angle: Quantity, mode: int
) -> list[str]:
    frequencies = undamped_frequency(record)
    assert frequencies is not None  # or there is no table
    natural = float(frequencies[mode])
    torque = having(record, _MODES + "holzer_inertia_torque", "mode", "freedom")
    total = having(record, _MODES + "holzer_torque", "mode", "freedom")
    turned = np.asarray(angle.values, dtype=float)[mode]
    inertia, below = line.inertia[rows.freedom], rows.below
    twist = turned[:-1] - turned[below[:-1]]
    # the estimate of the quantity is that of its highest mode, in which errors grow along the line
    noise = _NOISE * float(np.max(np.abs(turned)))
    columns = [Column("station", 16), number("J\nkg*m^2", 9), number("J w^2\nN*m/rad", 11),
               number("angle\nrad", 11), number("J w^2\nx angle\nN*m", 11),
               number("sum of\ntorques\nN*m", 11), number("stiffness\nN*m/rad", 11),
               number("twist\nrad", 11)]  # fmt: skip
    named = labels(angle.axes[1])
    cells = [
        named, [_short(one, 9) for one in inertia], _column(inertia * natural**2, 0.0),
        [show(one, noise, 5) for one in turned], _torques(torque, mode, len(named)),
        _torques(total, mode, len(named)), [*_column(rows.stiffness, 0.0), ""],
        [*(show(one, noise, 5) for one in twist), ""],
    ]  # fmt: skip
    residual = vector(record, "modes/holzer_residual", "mode")
    which = f"undamped mode {mode + 1}" if _differs(record) else f"mode {mode + 1}"
    words = f"Holzer table of {which}, {show(natural)} rad/s"
    words += f" = {show(hertz(natural))} Hz = {show(rpm(natural))} cpm"
    words += ", rings of dampers free" if _differs(record) else ""
    words += ", referred to the crankshaft"
    if residual is not None:
        scale = 1.0 if torque is None else float(np.max(magnitudes(torque)[mode], initial=0.0))
        share = residual[mode] / scale if scale > 0.0 else 0.0
        words += f"; residual {residual[mode]:.1e} N*m, {share:.0e} of the largest torque"
    lines = [*paragraph(words + ":"), *table(columns, zip(*cells, strict=True))]
    joints = [
        f"{named[i]} joins {named[below[i]]}" for i in range(len(below) - 1) if below[i] != i + 1
    ]
    if joints:
        lines += paragraph(f"Branches: {', '.join(joints)}; a sum goes on where its branch joins.")
    return lines


def _differs(record: Record) -> bool:
    """Whether a damper makes the modes of the line others than the undamped ones."""
    return _MODES + "undamped_frequency" in record


def _torques(quantity: Quantity | None, mode: int, count: int) -> list[str]:
    if quantity is None:
        return [""] * count
    row = np.asarray(quantity.values, dtype=float)[mode]
    return _column(row, _NOISE * float(np.max(np.abs(row))))


def _column(values: np.ndarray, noise: float) -> list[str]:
    """All entries alike: with five digits, or all with powers of ten where one is large."""
    if np.max(np.abs(values), initial=0.0) < _LARGE:
        return [show(value, noise, 5) for value in values]
    return ["0" if abs(value) <= noise else f"{value:.4e}" for value in values]


def _short(value: float, width: int) -> str:
    """As many digits as fit."""
    texts = [show(value, digits=digits) for digits in (6, 5, 4, 3)]
    return next((text for text in texts if len(text) <= width), texts[-1])
