"""Natural frequencies and modes of a shaft line, and the Holzer tables of those that matter."""

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import hertz, rpm, show
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_holzer import holzer
from vibecalc.report.sections.torsion_scenes import CLOSE
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    asked,
    cell,
    elastic_modes,
    has_pendulums,
    line_of,
    order_text,
    range_words,
    vector,
)
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

MODES = TORSION + "modes/"
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
    for block in (_separation(result), _damped(result), _bare(result.record), tables):
        if block:
            lines += ["", *block]
    return Section("Natural frequencies and modes of the line", lines, frozenset())


def _frequencies(result: Result, natural: Quantity) -> list[str]:
    """Both ways side by side, with the estimate of damping and where the mode lies."""
    record = result.record
    doubt = vector(record, "modes/frequency_error", "mode")
    second = having(record, MODES + "transfer_matrix_frequency", "mode")
    ratio = having(record, MODES + "energy_damping_ratio", "mode")
    nearest = vector(record, "margin/nearest_order", "mode")
    distance = having(record, TORSION + "margin/distance", "mode")
    columns = [
        number("mode", 4),
        number("rad/s", 11),
        number("Hz", 10),
        number("cpm", 10),
        number("by transfer\nmatrix,\nrad/s", 11),
        number("damping\nratio", 9),
        number("near\norder", 5),
        number("margin\n%", 7),
        Column("strain energy in", 23),
    ]
    rows = []
    values = np.asarray(natural.values, dtype=float)
    for i, value in enumerate(values[:_MOST]):
        error = natural.error_estimate if doubt is None else float(doubt[i])
        rigid = value == 0.0
        rows.append([
            str(i + 1), show(value, error), show(hertz(value), hertz(error)),
            show(rpm(value), rpm(error)), cell(second, i, digits=6),
            "" if rigid else cell(ratio, i, digits=3),
            "" if rigid or nearest is None or not nearest[i] else order_text(nearest[i]),
            "" if rigid or distance is None else _margin(float(distance.values[i])),
            "rigid" if rigid else _seat(record, i),
        ])  # fmt: skip
    lines = table(columns, rows)
    if values.size > _MOST:
        lines += paragraph(f"and {values.size - _MOST} higher modes, in the result file")
    words = "Undamped, by eigenvalues and by transfer matrix with mode count; damping: an estimate "
    words += "from work and energy of the undamped shape."
    if second is not None and _branches(result):
        words += (
            " This line branches: its eigenvalues are found by the same mode count, so that the "
            "second column repeats the first and is no check of it."
        )
    if nearest is not None:
        words += (
            " Margin: of the natural frequency from the nearest order at the operating speed; "
            "blank where all orders of the case lie below the mode."
        )
    return lines + paragraph(words)


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
    there = [way for way in ways if all(parts[way, n] for n in ("margin", "half_order", "kept"))]
    kinds = labels(first.axes[1])
    columns = [number("mode", 4)]
    titles = {"operating": "at speed\n", "range": "any speed\n"}
    for way in there:
        for kind in kinds:
            columns += [number(f"{titles[way]}{kind}\norder", 9), number("margin\n%", 7)]
        columns += [Column("API 618", 8)]
    rows = []
    for mode in np.flatnonzero(natural[:_MOST] > 0.0):
        row = [str(mode + 1)]
        for way in there:
            away, order, kept = (
                np.asarray(one.values)[mode]
                for n in ("margin", "half_order", "kept")
                if (one := parts[way, n]) is not None
            )
            for k in range(len(kinds)):
                far = not np.isfinite(away[k]) or not order[k]
                inside = "inside" if away[k] < 0.0 else f"{100.0 * away[k]:.1f}"
                row += ["", ""] if far else [order_text(order[k]), inside]
            known = np.any(np.isfinite(away) & (order > 0.0))
            row += ["" if not known else "kept" if np.all(kept) else CLOSE]
        if any(row[1:]):
            rows.append(row)
    if not rows:
        return []
    words = (
        "Separation of natural frequencies from the orders, at the operating speed"
        + (f", and over {range_words(result)} (any)" if "range" in there else "")
        + "; inside: the critical lies within the range. API 618 asks 10 % of order 1 and 5 % of "
        "orders 2 to 10, and nothing of half orders and higher ones; it is for reciprocating "
        "compressors, and informative here."
    )
    return [*paragraph(words), *table(columns, rows)]


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


def _damped(result: Result) -> list[str]:
    record, line = result.record, line_of(result)
    lossy = line is not None and bool(np.any(line.line.loss_factor))
    pole = having(record, TORSION + "damped/frequency", "damped_mode")
    ratio = having(record, TORSION + "damped/damping_ratio", "damped_mode")
    if pole is None or ratio is None:
        if not asked(result).get("damping_model"):
            return []
        return paragraph(
            "No damped natural frequencies: ratios given by mode have no damping in time of their "
            "own; see the damping ratios above."
        )
    columns = [number("damped\nmode", 7), number("rad/s", 12), number("Hz", 11),
               number("cpm", 11), number("damping\nratio", 12), Column("", 24)]  # fmt: skip
    rows = []
    for i, value in enumerate(np.asarray(pole.values, dtype=float)[:_MOST]):
        error, over = pole.error_estimate, float(ratio.values[i]) >= 1.0
        rows.append([
            str(i + 1), show(value, error), show(hertz(value), hertz(error)),
            show(rpm(value), rpm(error)), cell(ratio, i),
            "does not swing" if over else "",
        ])  # fmt: skip
    if not np.any(ratio.values):
        return paragraph("Nothing damps the line: its poles are the undamped frequencies.")
    words = (
        "With the damping of shafts, stations and dampers in full, whether in proportion to mass "
        "and stiffness or not; frequency: magnitude of the pole"
    )
    if lossy:
        words += (
            "; a loss factor counts as its equivalent viscous dashpot, stiffness times factor over "
            "the frequency, at each mode's own frequency"
        )
    return [*paragraph(words + ":"), *table(columns, rows)]


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
    rows = [
        [name, *(cell(shape, (mode, place)) for mode in modes)]
        for place, name in enumerate(labels(shape.axes[1]))
    ]
    words = "No Holzer tables: the line is too long for them, or has a loop. "
    words += "Mode shapes instead, own angles of the stations:"
    return [*paragraph(words), *table(columns, rows)]
