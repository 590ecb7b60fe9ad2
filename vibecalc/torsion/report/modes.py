"""Natural frequencies and modes of a shaft line, and the Holzer tables of those that matter."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, magnitudes, speed_of, stacked
from vibecalc.core.report.writing import Column, hertz, many, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.report.limits import separation_rule
from vibecalc.torsion.report.line import (
    TORSION,
    asked,
    cell,
    elastic_modes,
    every,
    first_shaft,
    frequencies,
    has_pendulums,
    highest_frequency,
    is_chain,
    joined,
    line_of,
    mode_names,
    order_text,
    range_words,
    titled,
    vector,
)
from vibecalc.torsion.study_results import COUPLING

if TYPE_CHECKING:
    from vibecalc.torsion.line import Line
    from vibecalc.torsion.model import ShaftLineModel

MODES = TORSION + "modes/"
_MOST = 40
#: modes whose shapes are tabled in a calculation; of the largest angle, what is on a node
_SHAPES, _NODE = 4, 1e-9
_PENDULUMS = (
    "Natural frequencies at the operating speed; with centrifugal pendulums they rise with speed."
)


def torsion_modes(result: Result) -> Section | None:
    """The section, None without natural frequencies of a line."""
    natural = having(result.record, MODES + "natural_frequency", "mode")
    if natural is None:
        return None
    lines = [*_modes(result, natural), *_bare(result)]
    lines += paragraph(_PENDULUMS) if has_pendulums(result) else []
    name = "all modes and their margins, Holzer tables or mode shapes"
    details = {name: (_frequencies, _separation, holzer_or_shapes)}
    return titled(result, "Natural frequencies and modes of the line", lines, details=details)


class _Margins:
    """Cells of each mode: the nearest order of each class with its margin, the verdict of a rule.

    There are none where the result does not have them.
    """

    def __init__(self, result: Result, where: str, what: str) -> None:
        stem = f"separation/{where}"
        found = every(result.record, stem, "mode order_class", "margin", "order")
        self.kinds = labels(found[0].axes[1]) if found else []
        self.found = [np.asarray(one.values, dtype=float) for one in found]
        enough = having(result.record, f"{TORSION}{stem}/sufficient", "mode", "order_class")
        self.enough = None if enough is None else enough.values
        self.rule = separation_rule(result)
        self.columns = [number(title) for kind in self.kinds
                        for title in (what.format(kind), "margin\n%")]  # fmt: skip
        self.columns += [Column("by rule")] if self.rule else []

    def cells(self, mode: int) -> list[str]:
        """Blank where there is no order near."""
        cells = list[str]()
        for k in range(len(self.kinds)):
            margin, order = (float(one[mode, k]) for one in self.found)
            near = bool(np.isfinite(margin) and order)
            away = "inside" if margin < 0.0 else f"{100.0 * margin:.1f}"
            cells += [order_text(order), away] if near else ["", ""]
        known = any(cells)
        if self.rule:
            enough = [] if self.enough is None else self.enough[mode]
            cells.append(("kept" if np.all(enough) else "CLOSE") * bool(len(enough)))
        return cells if known else [""] * len(cells)


def _modes(result: Result, natural: Quantity) -> list[str]:
    """The modes that orders of the case meet: frequency, damping ratio, nearest orders."""
    record, known, chosen = result.record, mode_names(result), elastic_modes(result)
    if not chosen:
        return paragraph("The line has no elastic mode.")
    errors = _errors(natural, record)
    ratio = having(record, MODES + "damping_ratio", "mode")
    margins = _Margins(result, "operating", "nearest\n{}")
    columns = [Column("mode"), number("no."), number("Hz"), number("cpm"),
               number("damping\nratio"), *margins.columns, Column("strain energy in")]  # fmt: skip
    near = [margins.cells(i) for i in chosen]
    rows = [
        [known[i], str(i + 1), show(hertz(natural.values[i]), hertz(errors[i])),
         show(rpm(natural.values[i]), rpm(errors[i])), cell(ratio, i, digits=3), *cells,
         _seat(record, i)]
        for i, cells in zip(chosen, near, strict=True)
    ]  # fmt: skip
    words = "no.: number in result files, with rigid and overdamped modes."
    if any(map(any, near)):
        words += " Margin: to the nearest order at the operating speed."
    line = line_of(result)
    if known[chosen[0]].endswith("-node") and line and any(one.stiffness for one in line.dampers):
        words += " Nodes in damper springs are counted."
    if _differs(record):
        words += " Frequencies: damped."
    if more := int(np.count_nonzero(natural.values)) - len(chosen):
        words += f" {many(more, 'higher mode')} not listed."
    return [*table(columns, rows), *paragraph(words)]


def _errors(natural: Quantity, record: Record) -> np.ndarray:
    errors = vector(record, "modes/frequency_error", "mode")
    known = np.full(natural.values.shape, float(natural.error_estimate))
    return known if errors is None else errors


def _frequencies(result: Result) -> list[str]:
    """All modes in rad/s, by a second way where there is one, and what damping does to them."""
    record = result.record
    natural, known = record[MODES + "natural_frequency"], mode_names(result)
    undamped = vector(record, "modes/undamped_frequency", "mode")
    # of the undamped line: for frequencies of the damped one it is no second way
    second = having(record, MODES + "transfer_matrix_frequency", "mode")
    second = second if undamped is None else None
    ratio = having(record, MODES + "damping_ratio", "mode")
    columns = [Column("mode"), number("no."), number("rad/s"), number("Hz"),
               number("by transfer\nmatrix, rad/s"), number("damping\nratio"),
               number("undamped\nHz"), Column("strain energy in")]  # fmt: skip
    rows = [
        [known[i], str(i + 1), show(value, error, 6), show(hertz(value), hertz(error), 6),
         cell(second, i, digits=6), cell(ratio, i) if value else "",
         "" if undamped is None or i >= undamped.size else show(hertz(undamped[i]), digits=6),
         _seat(record, i) if value else ""]
        for i, (value, error) in enumerate(
            zip(natural.values[:_MOST], _errors(natural, record), strict=False))
    ]  # fmt: skip
    lines = table(columns, rows)
    if natural.values.size > _MOST:
        more = natural.values.size - _MOST
        lines += paragraph(f"and {more} higher modes, in the result file")
    return [*lines, *paragraph(_frequency_words(result, second is not None, ratio))]


_DAMPED = (
    "Natural frequency: magnitude |s| of the damped pole, since the effective inertia of a damper "
    "ring depends on frequency. Undamped: with free damper rings."
)


def _frequency_words(result: Result, twice: bool, ratio: Quantity | None) -> str:
    line, words = line_of(result), _DAMPED
    if MODES + "undamped_frequency" not in result.record:
        words = "Undamped natural frequencies, from the eigenvalue problem"
        words += " and from the transfer matrix with mode count." if twice else "."
    if twice and line is not None and not is_chain(line):
        words += (
            " Branched line: both columns come from the same mode count, so they do not check "
            "each other."
        )
    if ratio is not None and asked(result).get("damping_model"):
        return words + " Damping ratio: by the damping model of the case."
    if ratio is None or not np.any(ratio.values):
        return words
    words += " Damping ratio: -Re s / |s| of the pole"
    if line is not None and np.any(line.line.loss_factor):
        words += (
            "; loss factors as equivalent viscous damping, stiffness x loss factor / frequency, at "
            "the frequency of each mode"
        )
    return words + "."


def _separation(result: Result) -> list[str]:
    """Distance of each mode from major and other orders over the range of speeds."""
    margins, known = _Margins(result, "range", "nearest {}\norder"), mode_names(result)
    near = [(name, margins.cells(i)) for i, name in enumerate(known[:_MOST])]
    rows = [[name, *cells] for name, cells in near if any(cells)]
    if not margins.kinds or not rows:
        return []
    words = f"Margins to the orders over {range_words(result)}; inside: critical in the range."
    if margins.rule is not None:
        rule, asks = margins.rule.rule, _asks(margins.rule.margin)
        words += f" {rule.name} requires {asks}, nothing for other orders; it "
        words += f"applies to {rule.scope.split(':')[0]} and is informative here."
    return [*paragraph(words), *table([Column("mode"), *margins.columns], rows)]


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
    natural = vector(result.record, "without_dampers/natural_frequency", "mode_without_dampers")
    if natural is None:
        return []
    listed = ", ".join(show(hertz(value)) for value in natural[:12] if value > 0.0)
    return paragraph(f"Natural frequencies without dampers: {listed} Hz.")


def holzer_or_shapes(result: Result) -> list[str]:
    """What a mode looks like, in tables."""
    words = "No Holzer tables: the line is too long or has a loop. "
    words += "Mode shapes instead, actual angles of the stations (not referred):"
    return holzer(result) or shapes(result, elastic_modes(result), words)


def shapes(
    result: Result, modes: list[int], words: str, titles: list[str] | None = None,
    totals: list[list[str]] | None = None,
) -> list[str]:  # fmt: skip
    """Angles of the stations in each mode below some words, nothing without modes."""
    shape = having(result.record, MODES + "shape", "mode", "station")
    if shape is None or not modes:
        return []
    known, angle = mode_names(result), np.real(shape.values)
    rows = [
        [name, *(show(angle[mode, place], shape.error_estimate) for mode in modes)]
        for place, name in enumerate(labels(shape.axes[1]))
    ]
    heads = titles or [known[i] for i in modes]
    return [*paragraph(words),
            *table([Column("station"), *map(number, heads)], rows, totals or [])]  # fmt: skip


def node_table(result: Result) -> list[str]:
    """Angles of the lowest elastic modes, how many nodes they have, and in which sections."""
    shape = having(result.record, MODES + "shape", "mode", "station")
    natural, known = frequencies(result.record), mode_names(result)
    line, modes = line_of(result), elastic_modes(result)[:_SHAPES]
    if shape is None or natural is None or line is None or not modes:
        return []
    titles = [f"{known[i]}\n{show(hertz(natural[i]))} Hz" for i in modes]
    nodes = [nodes_in(line, np.real(shape.values[i])) for i in modes]
    listed = "; ".join(
        f"{known[i]}: {joined(found) or 'none'}" for i, found in zip(modes, nodes, strict=True)
    )
    sprung = any(one.stiffness for one in line.dampers)
    rings = " The names of the modes count those in damper springs, too." if sprung else ""
    lines = shapes(
        result, modes, "Mode shapes: actual angles of the stations (not referred).", titles,
        [["nodes in shafts", *(str(len(found)) for found in nodes)]],
    )  # fmt: skip
    return [*lines, *paragraph(f"Nodes lie in: {listed}.{rings}")]


def nodes_in(line: "ShaftLineModel", angle: np.ndarray) -> list[str]:
    """Names of the sections between whose ends the angles (s,), referred, change their sign."""
    own = angle / line.station_ratio
    sides = np.where(np.abs(own) > _NODE * np.max(np.abs(own)), np.sign(own), 0.0)
    return [
        line.section_names[place]
        for place, (first, second) in enumerate(line.section_ends)
        if second >= 0 and sides[first] * sides[second] < 0.0
    ]


# ----------------------------------------------------------------------------
# Holzer tables of the modes of a shaft line that matter, branch by branch.
# ----------------------------------------------------------------------------

#: rows of all Holzer tables together
_ROWS = 120
#: of the largest entry of a Holzer table: less is rounding
_NOISE = 1e-11
#: from here on a column is written with powers of ten
_LARGE = 1e7
_HOLZER = ("station", "J\nkg m^2", "J w^2\nN m/rad", "angle\nrad", "J w^2\nx angle\nN m",
           "sum of\ntorques\nN m", "stiffness\nN m/rad", "twist\nrad")  # fmt: skip


def lowest_holzer(result: Result) -> list[str]:
    """Holzer tables of the two lowest elastic modes."""
    return holzer(result, most=2)


def holzer(result: Result, most: int = 0) -> list[str]:
    """A table for each mode that matters, as far as the page goes; nothing without them.

    Of the lowest `most` modes, where that is not 0, without a word on the others.
    """
    angle = having(result.record, MODES + "holzer_angle", "mode", "freedom")
    shaft = line_of(result)
    if angle is None or shaft is None:
        return []
    square = (speed_of(result) or 0.0) ** 2
    line = shaft.line._replace(stiffness=shaft.line.stiffness + shaft.speed_stiffness * square)
    of_mode = result.record.quantities.get(f"{COUPLING}/mode_stiffness")
    blocks, shown = list[list[str]](), list[int]()
    for mode in elastic_modes(result, undamped=True)[: most or None]:
        if shown and (len(shown) + 1) * len(angle.axes[1].values) > _ROWS:
            break
        if of_mode is not None:
            stiffness = line.stiffness.copy()
            for place, one in enumerate(shaft.couplings):
                stiffness[one.element] = one.ratio**2 * of_mode.values[place, mode]
            line = line._replace(stiffness=stiffness)
        try:
            blocks.append(_holzer_table(result, line, angle, mode))
        except NumericalFailure:
            return []
        shown.append(mode)
    return stacked(*blocks, [] if most else _modes_without_table(result, shown))


def _modes_without_table(result: Result, shown: list[int]) -> list[str]:
    """Which modes have no table here, and why."""
    natural = frequencies(result.record, undamped=True)
    if natural is None:
        return []
    left, top = np.setdiff1d(np.flatnonzero(natural > 0.0), shown), highest_frequency(result)
    lines = list[str]()
    for modes, why in (
        (left[natural[left] <= top], "only the lowest are printed"),
        (left[natural[left] > top], "above the highest excitation frequency"),
    ):
        what = "Mode {}" if len(modes) == 1 else "Modes {}"
        which = what.format(joined(str(i + 1) for i in modes))
        which = f"Undamped {which.lower()}" if _differs(result.record) else which
        words = f"{which} ({why}): Holzer tables in the result file only."
        lines += paragraph(words) if len(modes) else []
    return lines


def _holzer_table(result: Result, line: "Line", angle: Quantity, mode: int) -> list[str]:
    from vibecalc.torsion.modes_of_tree import holzer_rows

    record, rows, whole = result.record, holzer_rows(line), line_of(result)
    frequency = frequencies(record, undamped=True)
    assert frequency is not None  # or there is no table
    natural = float(frequency[mode])
    torque = having(record, MODES + "holzer_inertia_torque", "mode", "freedom")
    total = having(record, MODES + "holzer_torque", "mode", "freedom")
    turned = np.asarray(angle.values, dtype=float)[mode]
    inertia, below = line.inertia[rows.freedom], rows.below
    twist = turned[:-1] - turned[below[:-1]]
    # the estimate of the quantity is that of its highest mode, in which errors grow along the line
    noise = _NOISE * float(np.max(np.abs(turned)))
    named = labels(angle.axes[1])
    cells = [
        named, [_short(one, 9) for one in inertia], _column(inertia * natural**2, 0.0),
        [show(one, noise, 5) for one in turned], _torques(torque, mode, len(named)),
        _torques(total, mode, len(named)), [*_column(rows.stiffness, 0.0), ""],
        [*(show(one, noise, 5) for one in twist), ""],
    ]  # fmt: skip
    residual, differs = vector(record, "modes/holzer_residual", "mode"), _differs(record)
    name = mode_names(result, undamped=True)[mode]
    words = f"Holzer table of {'undamped ' * differs}mode {mode + 1} ({name}), "
    words += f"{show(hertz(natural))} Hz = {show(rpm(natural))} cpm"
    words += ", damper rings free" * differs
    words += "" if whole is None else f", referred to {first_shaft(whole)}"
    if residual is not None:
        scale = 1.0 if torque is None else float(np.max(magnitudes(torque)[mode], initial=0.0))
        share = residual[mode] / scale if scale > 0.0 else 0.0
        words += f"; residual {residual[mode]:.1e} N m, {share:.0e} of the largest torque"
    heads = [Column("station"), *map(number, _HOLZER[1:])]
    lines = [*paragraph(words + ":"), *table(heads, zip(*cells, strict=True))]
    joints = [
        f"{named[i]} joins {named[below[i]]}" for i in range(len(below) - 1) if below[i] != i + 1
    ]
    words = f"Branches: {', '.join(joints)}; torque sums continue at the junction."
    return lines + (paragraph(words) if joints else [])


def _differs(record: Record) -> bool:
    """Whether a damper makes the modes of the line others than the undamped ones."""
    return MODES + "undamped_frequency" in record


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
