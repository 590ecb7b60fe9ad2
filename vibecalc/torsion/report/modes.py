"""Natural frequencies and modes of a shaft line, and the Holzer tables of those that matter."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of
from vibecalc.core.report.writing import Column, hertz, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.report.first_page import CLOSE, separation_rule
from vibecalc.torsion.report.line import (
    TORSION,
    asked,
    cell,
    elastic_modes,
    has_pendulums,
    highest_frequency,
    joined,
    line_of,
    order_text,
    range_words,
    undamped_frequency,
    vector,
)

if TYPE_CHECKING:
    from vibecalc.torsion.holzer import HolzerRows
    from vibecalc.torsion.line import Line

MODES = TORSION + "modes/"
TRANSFER = MODES + "transfer_matrix_frequency"
_MOST = 40


def torsion_modes(result: Result) -> Section | None:
    """The section, None without natural frequencies of a line."""
    natural = having(result.record, MODES + "natural_frequency", "mode")
    if natural is None:
        return None
    lines = _frequencies(result, natural)
    if has_pendulums(result):
        lines += paragraph(
            "All at the operating speed: the field that pendulums swing in grows with the speed, "
            "and with it these natural frequencies."
        )
    tables = holzer(result) or _shapes(result)
    for block in (_separation(result), _bare(result.record)):
        if block:
            lines += ["", *block]
    title = "Natural frequencies and modes of the line"
    return Section(title, lines, frozenset(), "Holzer tables or mode shapes", ("", *tables))


def _frequencies(result: Result, natural: Quantity) -> list[str]:
    """One frequency and one damping ratio a mode, and where it lies."""
    record = result.record
    doubt = vector(record, "modes/frequency_error", "mode")
    undamped = vector(record, "modes/undamped_frequency", "mode")
    # of the undamped line: beside frequencies of the damped one it is no second way
    second = having(record, TRANSFER, "mode") if undamped is None else None
    ratio = having(record, MODES + "damping_ratio", "mode")
    nearest = vector(record, "margin/nearest_order", "mode")
    distance = having(record, TORSION + "margin/distance", "mode")
    columns = [number("mode", 4), number("rad/s", 11), number("Hz", 10), number("cpm", 10)]
    if second is not None:
        columns.append(number("by transfer\nmatrix,\nrad/s", 11))
    columns += [
        number("damping\nratio", 9), number("near\norder", 5), number("margin\n%", 7),
        Column("strain energy in", 23),
    ]  # fmt: skip
    rows = []
    values = np.asarray(natural.values, dtype=float)
    for i, value in enumerate(values[:_MOST]):
        error = natural.error_estimate if doubt is None else float(doubt[i])
        rigid = value == 0.0
        other = [] if second is None else [cell(second, i, digits=6)]
        rows.append([
            str(i + 1), show(value, error), show(hertz(value), hertz(error)),
            show(rpm(value), rpm(error)), *other,
            "" if rigid else cell(ratio, i, digits=3),
            "" if rigid or nearest is None or not nearest[i] else order_text(nearest[i]),
            "" if rigid or distance is None else _margin(float(distance.values[i])),
            _still(record, i) if rigid else _seat(record, i),
        ])  # fmt: skip
    lines = table(columns, rows)
    if values.size > _MOST:
        lines += paragraph(f"and {values.size - _MOST} higher modes, in the result file")
    words = _frequency_words(result) if undamped is None else _DAMPED
    if second is not None and _branches(result):
        words += (
            " This line branches: its eigenvalues are found by the same mode count, so that the "
            "second column repeats the first and is no check of it."
        )
    if ratio is not None and asked(result).get("damping_model"):
        words += " Damping ratio: by the damping model of the case."
    elif ratio is not None and np.any(ratio.values):
        words += " Damping ratio: of the pole, -Re s / |s|" + _lossy_words(result) + "."
    if nearest is not None:
        words += (
            " Margin: of the natural frequency from the nearest order at the operating speed; "
            "blank where all orders of the case lie below the mode."
        )
    lines += paragraph(words)
    if undamped is not None:
        listed = ", ".join(show(hertz(value), digits=5) for value in undamped[:12])
        lines += paragraph(
            f"Without any damping, the rings of the dampers free, the line would have {listed} Hz."
        )
    return lines


_DAMPED = (
    "Natural frequency: magnitude |s| of the pole of the line with all its damping, since how much "
    "of a damper's ring goes along depends on the frequency."
)


def _frequency_words(result: Result) -> str:
    ways = "by eigenvalues"
    if TRANSFER in result.record:
        ways += " and by transfer matrix with mode count"
    return f"Natural frequencies of the line without damping, {ways}."


def _lossy_words(result: Result) -> str:
    line = line_of(result)
    if line is None or not np.any(line.line.loss_factor):
        return ""
    return (
        "; a loss factor counts as its equivalent viscous dashpot, stiffness times factor over the "
        "frequency, at each mode's own frequency"
    )


def _still(record: Record, mode: int) -> str:
    """What a mode without a frequency is."""
    ratio = vector(record, "modes/damping_ratio", "mode")
    return "overdamped" if ratio is not None and ratio[mode] == 1.0 else "rigid"


def _branches(result: Result) -> bool:
    """Whether three or more springs meet somewhere in the line, parallel ones counted once."""
    shaft = line_of(result)
    if shaft is None:
        return False
    line = shaft.line
    joined = (line.stiffness != 0.0) | (shaft.speed_stiffness != 0.0)
    ends = np.sort(np.stack([line.first, line.second], axis=1)[joined], axis=1)
    return bool(np.max(np.bincount(np.unique(ends, axis=0).ravel()), initial=0) > 2)


def _separation(result: Result) -> list[str]:
    """Distance of each mode from major and other orders, at the speed and over the range."""
    ways = ("operating", "range")
    parts = {
        (way, name): having(result.record, f"{TORSION}separation/{way}/{name}", "mode",
                            "order_class")
        for way in ways for name in ("margin", "half_order", "kept")
    }  # fmt: skip
    first = parts["operating", "margin"]
    natural = vector(result.record, "modes/natural_frequency", "mode")
    if first is None or natural is None:
        return []
    rule = separation_rule(result)
    there = [way for way in ways if all(parts[way, n] for n in ("margin", "half_order"))]
    kinds = labels(first.axes[1])
    columns = [number("mode", 4)]
    titles = {"operating": "at speed\n", "range": "any speed\n"}
    for way in there:
        for kind in kinds:
            columns += [number(f"{titles[way]}{kind}\norder", 9), number("margin\n%", 7)]
        columns += [] if rule is None else [Column("by rule", 8)]
    rows = []
    for mode in np.flatnonzero(natural[:_MOST] > 0.0):
        row = [str(mode + 1)]
        for way in there:
            away, order, kept = (
                None if one is None else np.asarray(one.values)[mode]
                for one in (parts[way, n] for n in ("margin", "half_order", "kept"))
            )
            assert away is not None and order is not None  # or it is not there
            for k in range(len(kinds)):
                far = not np.isfinite(away[k]) or not order[k]
                inside = "inside" if away[k] < 0.0 else f"{100.0 * away[k]:.1f}"
                row += ["", ""] if far else [order_text(order[k]), inside]
            if rule is not None:
                known = np.any(np.isfinite(away) & (order > 0.0))
                row.append("" if not known else "kept" if np.all(kept) else CLOSE)
        if any(row[1:]):
            rows.append(row)
    if not rows:
        return []
    words = (
        "Separation of natural frequencies from the orders, at the operating speed"
        + (f", and over {range_words(result)} (any)" if "range" in there else "")
        + "; inside: the critical lies within the range."
    )
    if rule is not None:
        words += f" {rule.rule.name} asks {_asks(rule.margin)}, and nothing of other orders; it is "
        words += f"for {rule.rule.scope.split(':')[0]}, and informative here."
    return [*paragraph(words), *table(columns, rows)]


def _asks(margin: dict[float, float]) -> str:
    """`10 % of order 1 and 5 % of orders 2 to 10`."""
    parts = []
    for share in sorted(set(margin.values()), reverse=True):
        own = sorted(order for order, one in margin.items() if one == share)
        which = f"order {own[0]:g}" if len(own) == 1 else f"orders {own[0]:g} to {own[-1]:g}"
        parts.append(f"{100.0 * share:g} % of {which}")
    return joined(parts)


def _margin(share: float) -> str:
    return f"{100.0 * abs(share):.1f}" if np.isfinite(share) else ""


def _seat(record: Record, mode: int) -> str:
    """The section with the largest share of the strain energy."""
    share = having(record, MODES + "strain_energy_share", "mode", "section")
    if share is None:
        return ""
    row, section = np.asarray(share.values, dtype=float)[mode], labels(share.axes[1])
    most = int(np.argmax(row))
    return f"{section[most]} {100.0 * row[most]:.0f} %" if row[most] > 0.0 else ""


def _bare(record: Record) -> list[str]:
    natural = vector(record, "bare/natural_frequency", "bare_mode")
    if natural is None:
        return []
    listed = ", ".join(show(hertz(value), digits=5) for value in natural[:12])
    return paragraph(f"Without its dampers the line has {listed} Hz.")


def _shapes(result: Result) -> list[str]:
    """Own angles of the stations in each mode, where there is no Holzer table."""
    shape = having(result.record, MODES + "shape", "mode", "station")
    modes = elastic_modes(result)
    if shape is None or not modes:
        return []
    columns = [Column("station", 22), *(number(f"mode {i + 1}", 11) for i in modes)]
    angle = np.real(shape.values)
    rows = [
        [name, *(show(angle[mode, place], shape.error_estimate, 5) for mode in modes)]
        for place, name in enumerate(labels(shape.axes[1]))
    ]
    words = "No Holzer tables: the line is too long for them, or has a loop. "
    words += "Mode shapes instead, own angles of the stations:"
    return [*paragraph(words), *table(columns, rows)]


# ----------------------------------------------------------------------------
# Holzer tables of the modes of a shaft line that matter, branch by branch.
# ----------------------------------------------------------------------------

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
    from vibecalc.torsion.holzer import holzer_rows

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
