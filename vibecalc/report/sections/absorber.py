"""Response of a primary system with its absorber: peaks, frequencies, poles."""

import math

import numpy as np

from vibecalc.report.lookup import having, labels, scalar_of, table_of
from vibecalc.report.numbers import hertz, show
from vibecalc.report.sections.by_axis import by_axis
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

ABSORBER = "response/absorber/"
_MARKS = ("primary_frequency", "antiresonance", "locked_frequency_ratio")


def absorber(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(ABSORBER))
    if not shown:
        return None
    lines: list[str] = []
    # without a spring nothing stands still anywhere
    at_rest = scalar_of(record, ABSORBER + "antiresonance") == 0.0
    names = [name for name in _MARKS if not (at_rest and name == "antiresonance")]
    marks, _ = scalars(record, (ABSORBER + name for name in names), ABSORBER)
    natural = by_axis(
        record,
        "mode",
        "undamped mode",
        [(ABSORBER + "natural_frequency_ratio", "frequency\nratio")],
    )
    fixed = by_axis(
        record, "fixed_point", "fixed point",
        [(ABSORBER + "fixed_point/frequency_ratio", "frequency\nratio"),
         (ABSORBER + "fixed_point/magnitude", "height")],
    )  # fmt: skip
    for block in (_curves(result), _summits(record), marks, natural, fixed, _poles(record)):
        if block:
            lines += ["", *block] if lines else block
    return Section("Response of primary and absorber", lines, shown) if lines else None


def _curves(result: Result) -> list[str]:
    lines = by_axis(
        result.record, "curve", "curve",
        [(ABSORBER + name, words) for name, words in (
            ("largest", "largest\nresponse"),
            ("largest_frequency_ratio", "at frequency\nratio"),
            ("largest_travel", "largest\ntravel"),
        )], width=30,
    )  # fmt: skip
    if not lines:
        return []
    moved = having(result.record, ABSORBER + "each/largest_travel", "curve", "absorber")
    if moved is not None:
        columns = [Column("largest travel of curve", 30)]
        columns += [number(name, 14) for name in labels(moved.axes[1])]
        rows = [
            [name, *(show(float(one), moved.error_estimate) for one in values)]
            for name, values in zip(labels(moved.axes[0]), np.asarray(moved.values), strict=True)
        ]
        lines += ["", *table(columns, rows)]
    options = table_of(result.case, "response", "absorber")
    tuning = table_of(result.case, "tuning")
    what = options.get("response") or tuning.get("response") or "displacement"
    cause = options.get("excitation") or tuning.get("excitation") or "force"
    words = f"{str(what).replace('_', ' ')} under excitation by {cause}, as ratios: "
    return [
        *paragraph(words + "displacements over T0 / K1, or over the motion of the ground"),
        *lines,
    ]


def _summits(record: Record) -> list[str]:
    """Every maximum of every curve."""
    height = having(record, ABSORBER + "summit/magnitude", "curve", "summit")
    place = having(record, ABSORBER + "summit/frequency_ratio", "curve", "summit")
    if height is None or place is None:
        return []
    own = scalar_of(record, ABSORBER + "primary_frequency")
    columns = [Column("maxima of curve", 30), number("frequency\nratio", 13)]
    columns += [number("Hz", 12)] if own is not None else []
    columns += [number("height", 13)]
    rows = []
    tops, spots = np.asarray(height.values), np.asarray(place.values)
    for label, heights, places in zip(labels(height.axes[0]), tops, spots, strict=True):
        for top, spot in zip(heights, places, strict=True):
            if top > 0.0:
                row = [label, show(spot)]
                row += [show(hertz(own * spot))] if own is not None else []
                rows.append([*row, show(top, height.error_estimate)])
    return table(columns, rows) if rows else []


def _poles(record: Record) -> list[str]:
    found = having(record, ABSORBER + "pole", "pole")
    if found is None:
        return []
    columns = (number("pole", 6), number("decay", 13), number("frequency\nratio", 13),
               number("damping\nratio", 13))  # fmt: skip
    rows = []
    for place, value in enumerate(np.asarray(found.values), start=1):
        if value.imag < -found.error_estimate:
            continue
        size = abs(value)
        rows.append([
            str(place), show(-value.real, found.error_estimate),
            show(value.imag, found.error_estimate),
            show(-value.real / size if size > 0.0 and math.isfinite(size) else 0.0, 1e-15),
        ])  # fmt: skip
    return [*paragraph("poles over the primary's own frequency, one of each pair:"),
            *table(columns, rows)]  # fmt: skip
