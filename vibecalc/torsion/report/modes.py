"""Natural frequencies and modes of a shaft line, and the Holzer tables of those that matter."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of
from vibecalc.core.report.writing import Column, hertz, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.coupling_results import COUPLING
from vibecalc.torsion.report.first_page import CLOSE
from vibecalc.torsion.report.limits import separation_rule
from vibecalc.torsion.report.line import (
    TORSION,
    Detail,
    asked,
    cell,
    elastic_modes,
    has_pendulums,
    highest_frequency,
    is_chain,
    joined,
    line_of,
    mode_names,
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
    lines = [*_modes(result, natural), *_bare(result)]
    if has_pendulums(result):
        lines += paragraph(
            "All at the operating speed: the field that pendulums swing in grows with the speed, "
            "and with it these natural frequencies."
        )
    return Section(
        "Natural frequencies and modes of the line",
        lines,
        frozenset(),
        "all modes and their margins, Holzer tables or mode shapes",
        Detail(result, _frequencies, _separation, holzer_or_shapes),
    )


def _modes(result: Result, natural: Quantity) -> list[str]:
    """The modes that orders of the case meet: frequency, damping ratio, nearest orders."""
    record, names, chosen = result.record, mode_names(result), elastic_modes(result)
    if not chosen:
        return paragraph("The line has no elastic mode.")
    errors = vector(record, "modes/frequency_error", "mode")
    ratio = having(record, MODES + "damping_ratio", "mode")
    margin, order, sufficient = (
        having(record, f"{TORSION}separation/operating/{name}", "mode", "order_class")
        for name in ("margin", "half_order", "sufficient")
    )
    kinds = [] if margin is None or order is None else labels(margin.axes[1])
    columns = [Column("mode"), number("no."), number("Hz"), number("cpm"),
               number("damping\nratio")]  # fmt: skip
    for kind in kinds:
        columns += [number(f"nearest\n{kind}"), number("margin\n%")]
    rule = separation_rule(result)
    columns += [Column("by rule")] if rule else []
    columns += [Column("strain energy in")]
    rows = []
    for i in chosen:
        value = float(natural.values[i])
        error = natural.error_estimate if errors is None else float(errors[i])
        row = [names[i], str(i + 1), show(hertz(value), hertz(error), 4),
               show(rpm(value), rpm(error), 4), cell(ratio, i, digits=3)]  # fmt: skip
        for k in range(len(kinds)):
            assert margin is not None and order is not None  # or there are no kinds
            row += _away(float(margin.values[i, k]), float(order.values[i, k]))
        if rule:
            known = sufficient is not None and any(row[5:])
            close = sufficient is not None and not np.all(sufficient.values[i])
            row.append("" if not known else CLOSE if close else "kept")
        rows.append([*row, _seat(record, i)])
    more = int(np.count_nonzero(natural.values)) - len(chosen)
    words = "no.: in result files, where rigid and overdamped modes count. "
    if kinds and any(away for row in rows for away in row[5 : 5 + 2 * len(kinds)]):
        words += "Margin: from the nearest order at the operating speed. "
    line = line_of(result)
    if names[chosen[0]].endswith("-node") and line and any(one.stiffness for one in line.dampers):
        words += "Nodes in springs of dampers count. "
    if more:
        words += f"{more} higher mode{'s' * (more > 1)}: `--full`."
    return [*table(columns, rows), *paragraph(words.strip())]


def _away(margin: float, order: float) -> list[str]:
    """Nearest order and its margin in %, blank where there is none."""
    if not np.isfinite(margin) or not order:
        return ["", ""]
    return [order_text(order), "inside" if margin < 0.0 else f"{100.0 * margin:.1f}"]


def _frequencies(result: Result) -> list[str]:
    """All modes in rad/s, by a second way where there is one, and what damping does to them."""
    record = result.record
    natural = record[MODES + "natural_frequency"]
    errors = vector(record, "modes/frequency_error", "mode")
    undamped = vector(record, "modes/undamped_frequency", "mode")
    # of the undamped line: for frequencies of the damped one it is no second way
    second = having(record, TRANSFER, "mode") if undamped is None else None
    ratio = having(record, MODES + "damping_ratio", "mode")
    names, values = mode_names(result), np.asarray(natural.values, dtype=float)
    columns = [Column("mode"), number("no."), number("rad/s"), number("Hz")]
    columns += [number("by transfer\nmatrix, rad/s"), number("damping\nratio")]
    columns += [number("undamped\nHz"), Column("strain energy in")]
    rows = [
        [names[i], str(i + 1), show(value, error, 6), show(hertz(value), hertz(error), 6),
         cell(second, i, digits=6), cell(ratio, i) if value else "",
         "" if undamped is None or i >= undamped.size else show(hertz(undamped[i]), digits=6),
         _seat(record, i) if value else ""]
        for i, value in enumerate(values[:_MOST])
        for error in [natural.error_estimate if errors is None else float(errors[i])]
    ]  # fmt: skip
    lines = table(columns, rows)
    if values.size > _MOST:
        lines += paragraph(f"and {values.size - _MOST} higher modes, in the result file")
    words = _frequency_words(result) if undamped is None else _DAMPED
    line = line_of(result)
    if second is not None and line is not None and not is_chain(line):
        words += (
            " This line branches: its eigenvalues are found by the same mode count, so that the "
            "second column repeats the first and is no check of it."
        )
    if ratio is not None and asked(result).get("damping_model"):
        words += " Damping ratio: by the damping model of the case."
    elif ratio is not None and np.any(ratio.values):
        words += " Damping ratio: of the pole, -Re s / |s|" + _lossy_words(result) + "."
    return [*lines, *paragraph(words)]


_DAMPED = (
    "Natural frequency: magnitude |s| of the pole of the line with all its damping, since how much "
    "of a damper's ring goes along depends on the frequency. Undamped: rings of the dampers free."
)


def _frequency_words(result: Result) -> str:
    methods = "by eigenvalues"
    if TRANSFER in result.record:
        methods += " and by transfer matrix with mode count"
    return f"Natural frequencies of the line without damping, {methods}."


def _lossy_words(result: Result) -> str:
    line = line_of(result)
    if line is None or not np.any(line.line.loss_factor):
        return ""
    return (
        "; a loss factor counts as its equivalent viscous dashpot, stiffness times factor over the "
        "frequency, at the frequency of each mode"
    )


def _separation(result: Result) -> list[str]:
    """Distance of each mode from major and other orders over the range of speeds."""
    margin, order, sufficient = (
        having(result.record, f"{TORSION}separation/range/{name}", "mode", "order_class")
        for name in ("margin", "half_order", "sufficient")
    )
    if margin is None or order is None:
        return []
    rule, names = separation_rule(result), mode_names(result)
    columns = [Column("mode")]
    for kind in labels(margin.axes[1]):
        columns += [number(f"nearest {kind}\norder"), number("margin\n%")]
    columns += [] if rule is None else [Column("by rule")]
    rows = []
    for i in range(min(len(names), _MOST)):
        pairs_ = zip(margin.values[i], order.values[i], strict=True)
        row = [cell_ for one in pairs_ for cell_ in _away(float(one[0]), float(one[1]))]
        if any(row):
            close = sufficient is not None and not np.all(sufficient.values[i])
            row += [] if rule is None else [CLOSE if close else "kept"]
            rows.append([names[i], *row])
    words = f"Margins to the orders over {range_words(result)}; inside: the critical lies in it."
    if rule is not None:
        words += f" {rule.rule.name} asks {_asks(rule.margin)}, and nothing of other orders; it is "
        words += f"for {rule.rule.scope.split(':')[0]}, and informative here."
    return [*paragraph(words), *table(columns, rows)] if rows else []


def _asks(margin: dict[float, float]) -> str:
    """`10 % of order 1 and 5 % of orders 2 to 10`."""
    parts = []
    for share in sorted(set(margin.values()), reverse=True):
        first, *others = sorted(order for order, one in margin.items() if one == share)
        which = f"orders {first:g} to {others[-1]:g}" if others else f"order {first:g}"
        parts.append(f"{100.0 * share:g} % of {which}")
    return joined(parts)


def _seat(record: Record, mode: int) -> str:
    """The section with the largest share of the strain energy."""
    share = having(record, MODES + "strain_energy_share", "mode", "section")
    if share is None:
        return ""
    row, section = np.asarray(share.values, dtype=float)[mode], labels(share.axes[1])
    most = int(np.argmax(row))
    return f"{section[most]} {100.0 * row[most]:.0f} %" if row[most] > 0.0 else ""


def _bare(result: Result) -> list[str]:
    natural = vector(result.record, "bare/natural_frequency", "bare_mode")
    if natural is None:
        return []
    listed = ", ".join(show(hertz(value), digits=4) for value in natural[:12] if value > 0.0)
    return paragraph(f"Without its dampers the line has {listed} Hz.")


def holzer_or_shapes(result: Result) -> list[str]:
    """What a mode looks like, in tables."""
    return holzer(result) or _shapes(result)


def _shapes(result: Result) -> list[str]:
    """Angles of the stations in each mode, where there is no Holzer table."""
    shape = having(result.record, MODES + "shape", "mode", "station")
    modes = elastic_modes(result)
    if shape is None or not modes:
        return []
    names = mode_names(result)
    columns = [Column("station"), *(number(names[i]) for i in modes)]
    angle = np.real(shape.values)
    rows = [
        [name, *(show(angle[mode, place], shape.error_estimate, 4) for mode in modes)]
        for place, name in enumerate(labels(shape.axes[1]))
    ]
    words = "No Holzer tables: the line is too long for them, or has a loop. "
    words += "Mode shapes instead, angles of the stations, each on its own shaft:"
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


def holzer(result: Result, most: int = 0) -> list[str]:
    """A table for each mode that matters, as far as the page goes; nothing without them.

    Of the lowest `most` modes, where that is not 0, without a word on the others.
    """
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
    of_mode = result.record.quantities.get(f"{COUPLING}/mode_stiffness")
    lines: list[str] = []
    shown: list[int] = []
    names = mode_names(result, undamped=True)
    for mode in elastic_modes(result, undamped=True)[: most or None]:
        if shown and (len(shown) + 1) * len(rows.freedom) > _ROWS:
            break
        lines += [""] if lines else []
        if of_mode is not None:
            stiffness = line.stiffness.copy()
            for place, one in enumerate(shaft.couplings):
                stiffness[one.element] = one.ratio**2 * of_mode.values[place, mode]
            rows = holzer_rows(line._replace(stiffness=stiffness))
        lines += _table(result.record, line, rows, angle, mode, names[mode])
        shown.append(mode)
    return lines if most else lines + _modes_without_table(result, shown)


def _modes_without_table(result: Result, shown: list[int]) -> list[str]:
    """Which modes have no table here, and why."""
    natural = undamped_frequency(result.record)
    if natural is None:
        return []
    left = [int(i) for i in np.flatnonzero(natural > 0.0) if i not in shown]
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
    record: Record, line: "Line", rows: "HolzerRows", angle: Quantity, mode: int, name: str
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
    columns = [Column("station"), number("J\nkg m^2"), number("J w^2\nN m/rad"),
               number("angle\nrad"), number("J w^2\nx angle\nN m"),
               number("sum of\ntorques\nN m"), number("stiffness\nN m/rad"),
               number("twist\nrad")]  # fmt: skip
    named = labels(angle.axes[1])
    cells = [
        named, [_short(one, 9) for one in inertia], _column(inertia * natural**2, 0.0),
        [show(one, noise, 5) for one in turned], _torques(torque, mode, len(named)),
        _torques(total, mode, len(named)), [*_column(rows.stiffness, 0.0), ""],
        [*(show(one, noise, 5) for one in twist), ""],
    ]  # fmt: skip
    residual = vector(record, "modes/holzer_residual", "mode")
    words = f"Holzer table of {'undamped ' * _differs(record)}mode {mode + 1} ({name}), "
    words += f"{show(hertz(natural), digits=4)} Hz = {show(rpm(natural), digits=4)} cpm"
    words += ", rings of dampers free" if _differs(record) else ""
    words += ", referred to the crankshaft"
    if residual is not None:
        scale = 1.0 if torque is None else float(np.max(magnitudes(torque)[mode], initial=0.0))
        share = residual[mode] / scale if scale > 0.0 else 0.0
        words += f"; residual {residual[mode]:.1e} N m, {share:.0e} of the largest torque"
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
