"""Ranges of speeds above the limits of a shaft line, and what is barred for them."""

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, named_at, rows_of
from vibecalc.core.report.sections import Section, speed_of
from vibecalc.core.report.writing import turns
from vibecalc.core.results.record import Record, Result
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.torsion.report.conditions import VARIANTS, variant_words
from vibecalc.torsion.report.limits import (
    basis,
    crank_places,
    formulas,
    limited_words,
    numbered,
    origins,
    uses_by_section,
)
from vibecalc.torsion.report.line import TORSION, every, joined, titled, vector


def torsion_limits(result: Result) -> Section | None:
    """The section, None if the case has no limit of stress or torque."""
    record = result.record
    held = (f"{TORSION}limit/{which}_utilisation" for which in ("largest", "operating"))
    if not {*held} & set(record):
        return None
    blocks = uses_by_section(result), crank_places(result), exceeded_table(record)
    title = f"{limited_words(record).capitalize()} limits and barred ranges"
    return titled(
        result, title, *blocks, details={"rules of the limits": (formulas, basis, origins)}
    )


def barred_ranges(result: Result, *, permitted: bool = True, variant: str = "") -> list[str]:
    """Each range to be barred as words, `44.37 to 53.78 rpm`, or each that may not be.

    Those of the line as it is, or of a variant: `healthy/`, `conditions/`.
    """
    low, high = _ends(result.record, variant)
    chosen = np.flatnonzero(may_be_barred(result, variant) == permitted)
    return [f"{turns(low[i])} to {turns(high[i])} rpm" for i in chosen]


def may_be_barred(result: Result, variant: str = "") -> BoolArray:
    """Which of the ranges (b,) may be barred: none that holds the operating speed."""
    low, high = _ends(result.record, variant)
    may = vector(result.record, f"{variant}barred/permitted", "barred")
    may = np.ones(len(low)) if may is None else may
    inside = (low <= (at := speed_of(result) or 0.0)) & (at <= high)  # as an older file may not say
    return np.asarray((may > 0.0) & ~inside)


def _ends(record: Record, variant: str) -> list[FloatArray]:
    """Both ends of each range (b,), in rad/s; none without limits."""
    ends = [vector(record, f"{variant}barred/{name}", "barred") for name in ("from", "to")]
    return [np.zeros(0) if end is None else end for end in ends]


def acceptable(record: Record, place: int, _path: str) -> str:
    """What stands behind a range in the first table that may not be barred."""
    may = vector(record, "barred/permitted", "barred")
    return "" if may is None or may[place] else "NOT ACCEPTABLE: may not be barred"


def barred_by(record: Record, place: int, _path: str) -> str | None:
    """The limits that bar a range of the first table: `limits 1 and 2`."""
    found = every(record, "exceeded", "exceeded", "from", "to", "limit")
    if not found:
        return None
    start, stop, limit = (one.values for one in found)
    low, high = (float(record[f"{TORSION}barred/{end}"].values[place]) for end in ("from", "to"))
    return numbered(sorted({int(one) for one in limit[(start >= low) & (stop <= high)]}))


def ranges_in_words(result: Result, variant: str = "") -> list[str]:
    """What is barred, and where the line is not acceptable."""
    barred, not_ = (barred_ranges(result, permitted=one, variant=variant) for one in (True, False))
    lead = f"with {variant_words(result, variant)} " * bool(variant)
    words = []
    if barred:
        verb = "are" if len(barred) > 1 else "is"
        words.append(f"{lead}{joined(barred)} {verb} barred for continuous operation")
    if not_:
        why = "a limit for continuous operation is exceeded within, and barring is not permitted"
        words.append(f"{lead}the line is not acceptable from {joined(not_)}: {why}")
    return words


def all_ranges_in_words(result: Result) -> list[str]:
    """Those of the line as it is, of all cylinders firing, and of conditions of the cylinders."""
    of = ("", *VARIANTS)
    return [words for variant in of for words in ranges_in_words(result, variant)]


def exceeded_table(record: Record, variant: str = "") -> list[str]:
    """The ranges above the limits, and which of them may be barred."""
    above = (
        f"Speed ranges in which the {limited_words(record, 'or')} exceeds the limit for "
        "continuous operation:"
    )
    root = f"{TORSION}{variant}exceeded"
    condition = named_at(f"{root}/condition", f"{TORSION}conditions/torque_half_range")
    columns = Cells(condition, "condition"), *_EXCEEDED
    of = Rows("exceeded", "", [one._replace(of=f"{root}/{one.of}") if isinstance(one.of, str)
                               else one for one in columns], above=above)  # fmt: skip
    return rows_of(record, of)[0]


def _turns(speed: float, _error: float) -> str:
    return turns(speed) if speed else ""


def _number(value: float, _error: float) -> str:
    return str(int(value)) if value else ""


_EXCEEDED = (
    Cells("from", "from\nrpm", _turns, right=True),
    Cells("to", "to\nrpm", _turns),
    Cells("limit", "limit", _number),
    Cells("peak_speed", "worst at\nrpm", _turns),
    Cells("formula_from", "by formula\nfrom, rpm", _turns),
    Cells("formula_to", "to\nrpm", _turns),
    Cells("permitted", "barred range", lambda may, _: "acceptable" if may else "NOT ACCEPTABLE"),
)
