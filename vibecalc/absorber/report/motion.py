"""Absorbers in units in the report: motions and forces; a tuning within a band, with tolerances."""

import numpy as np

from vibecalc.absorber.asked_tables import AMPLITUDES
from vibecalc.absorber.motion_results import (
    IN_BAND_ROOT,
    MOTION_ROOT,
    TORSION,
    TRANSLATION,
    WITHOUT_ROOT,
)
from vibecalc.core.report.rows import Cells, by_name
from vibecalc.core.report.sections import Section, labels, scalar_of, section, table_of
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Motions and forces for the amplitude of a case.
# ----------------------------------------------------------------------------

_UNITS = {
    "force": "N",
    "torque": "N m",
    "unbalance": "kg m",
    "base_displacement": "m",
    "base_acceleration": "m/s^2",
}


def absorber_motion(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(f"{MOTION_ROOT}/"))
    if not shown:
        return None
    options = table_of(result.case, "response", "absorber")
    cause = next((key for key in AMPLITUDES if options.get(key) is not None), "")
    said = (
        f" for {cause.replace('_', ' ')} = {show(options[cause])} {_UNITS[cause]}" if cause else ""
    )
    roots = [(f"{MOTION_ROOT}/largest", f"{MOTION_ROOT}/largest_at")]
    heads = [number("with\nabsorber"), number("at Hz")]
    if any(path.startswith(IN_BAND_ROOT) for path in shown):
        roots.insert(0, (IN_BAND_ROOT, f"{IN_BAND_ROOT}/at"))
        heads = [number("in the\nband"), number("at Hz"), *heads]
    roots += [(f"{WITHOUT_ROOT}/largest", f"{WITHOUT_ROOT}/largest_at")]
    columns = [Column("maximum over the frequency range"), *heads,
               number("without\nabsorber"), number("at Hz")]  # fmt: skip
    rows = []
    for names in (TRANSLATION, TORSION):
        for name, unit, read, words in names.values():
            each = record.quantities.get(f"{MOTION_ROOT}/largest/each/{name}")
            if each is not None:
                whose, path = [f" {label}" for label in labels(each.axes[0])], f"each/{name}"
            elif f"{MOTION_ROOT}/{name}" in record:
                whose, path = [""], name
            else:
                continue
            factor = convert(1.0, unit, read)
            for place, label in enumerate(whose):
                row = [f"{words}{label}, {read}"]
                for values, places in roots:
                    top, where = (
                        record.quantities.get(f"{table}/{path}") for table in (values, places)
                    )
                    if top is None or where is None:
                        row += ["", ""]
                        continue
                    height, at = (np.ravel(np.abs(one.values))[place] for one in (top, where))
                    met = height > 0.0 and np.isfinite(at)
                    row.append(show(factor * float(height), factor * top.error_estimate))
                    row.append(show(float(at)) if met else "")
                rows.append(row)
    nominal = table_of(result.case, "tuning").get("tolerances")
    parts = " of nominal parts, not of the worst case of the tolerances," if nominal else ""
    lines = paragraph(f"amplitudes (0-to-peak){parts}{said}, with and without the absorber:")
    return section("Motions and forces", [[*lines, *table(columns, rows)]], {}, shown)


# ----------------------------------------------------------------------------
# Words and tables of a tuning within a band.
# ----------------------------------------------------------------------------


def band_words(result: Result) -> str:
    """Where the largest amplitude counts, as the end of a sentence; empty everywhere."""
    options = table_of(result.case, "tuning")
    for key in ("band", "band_ratios"):
        band = options.get(key)
        if isinstance(band, dict):
            hz = key == "band"
            ends = [float(band.get(end) or 0.0) for end in ("from", "to")]
            low, high = (show(hertz(end) if hz else end) for end in ends)
            words = f" from {low} to {high} " + ("Hz" if hz else "of the primary's frequency")
            worst = " in the worst case of the tolerances" if options.get("tolerances") else ""
            return words + worst
    return ""


def in_percent(value: float, error: float) -> str:
    """A share in percent with three digits, as far as its error lets them be known."""
    return show(100.0 * value, 100.0 * error, 3)


#: what is tuned for -> where its ratios stand, and its peaks
_TUNED_FOR = {
    "tolerances": ("", "tolerances/"),
    "nominal parts": ("tolerances/exact/", "tolerances/exact/"),
}
TOLERANCES = (
    Cells("{0}stiffness_ratio", "stiffness\nratio"),
    Cells("{0}damping_over_primary_critical", "damping / critical\nof primary"),
    Cells("{1}nominal_peak", "nominal\npeak"),
    Cells("{1}worst_peak", "worst-case\npeak"),
)


def tolerances(record: Record) -> list[str]:
    """What tolerances cost, and what a tuning that knows none of them would."""
    if "tuning/tolerances/worst_peak" not in record:
        return []
    columns = TOLERANCES if "tuning/stiffness_ratio" in record else TOLERANCES[2:]
    lines, _ = by_name(record, "tuned for", _TUNED_FOR, columns, "tuning")
    inside = scalar_of(record, "tuning/tolerances/inside_peak")
    if inside is not None:
        lines += paragraph(
            "worst case of all combinations of lower end, middle and upper end of each "
            f"tolerance; of random values in between: {show(inside)}"
        )
    return lines
