"""Section of a fit: keys with their uncertainty, what is told apart, points against computed."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.core.report.goals import FITTED, SIDES, bound_unit, in_unit
from vibecalc.core.report.sections import (
    Part,
    Section,
    having,
    labels,
    read_as,
    scalar_of,
    section,
    table_of,
)
from vibecalc.core.report.writing import number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Result
from vibecalc.units import convert, parse_quantity

PREFIX = "fit/"
#: points of the short report, the worst first
_MOST = 8


def fit(result: Result) -> Section | None:
    """The section, None if nothing was fitted."""
    paths = [path for path in result.record if path.startswith(PREFIX)]
    if not paths:
        return None
    blocks: list[Part] = [_keys(result), _goodness(result), _paste(result), _correlation(result)]
    blocks.append(_points(result, _MOST))
    details: dict[str, Part] = {"combinations of keys": _combinations(result)}
    if len(_residuals(result)) > _MOST:
        details["all measured points"] = _points(result, None)
    return section("Fit to measured points", blocks, details, paths)


def _variables(result: Result) -> list[Mapping[str, Any]]:
    return list(table_of(result.case, "fit").get("variables") or ())


def _keys(result: Result) -> list[str]:
    """A row for each key: as written, fitted, its standard uncertainty, and the bounds."""
    rows = []
    for variable in _variables(result):
        key = str(variable["key"])
        unit = bound_unit(variable, result.record[FITTED + key].unit)
        (fitted, error), (size, _), start = (
            in_unit(result.record[f"{PREFIX}{part}/{key}"], unit)
            for part in ("value", "standard_error", "start")
        )
        known = math.isfinite(size)
        share = f"{100.0 * size / abs(fitted):.2g} %" if known and fitted else ""
        off = show(size, digits=2) if known else "not identifiable"
        side = int(scalar_of(result.record, f"{PREFIX}active_bound/{key}") or 0)
        shown = show(*start), show(fitted, error, _digits(fitted, size))
        rows.append([key, *shown, off, unit, share, SIDES[side]])
    heads = number("start"), number("fitted"), number("+-"), "unit", number(""), ""
    return table(("fitted key", *heads), rows)


def _digits(value: float, deviation: float) -> int:
    """As many digits as the standard uncertainty leaves, with two of its own."""
    if not (math.isfinite(deviation) and deviation > 0.0 and value != 0.0):
        return 4
    return int(np.clip(math.ceil(math.log10(abs(value) / deviation)) + 2, 2, 8))


def _goodness(result: Result) -> list[str]:
    record = result.record
    chi, spare, growth = (
        float(scalar_of(record, PREFIX + name) or 0.0)
        for name in ("chi_square", "degrees_of_freedom", "growth")
    )
    words = f"{len(_residuals(result))} measured points; chi square {show(chi)} for "
    words += f"{spare:g} degrees of freedom"
    if spare > 0:
        chance = float(scalar_of(record, PREFIX + "probability") or 0.0)
        shown = f"{chance:.2g}" if chance > 1e-9 else "less than 1e-9"
        words += f" (probability of a larger value: {shown})"
    before = scalar_of(record, PREFIX + "start_chi_square")
    if before is not None:
        words += f"; start {show(before)}"
    words += "; +- is the standard uncertainty"
    if growth > 1.0:
        words += f", scaled by {growth:.3g}"
    searches = record.quantities.get(PREFIX + "search_chi_square")
    if searches is not None and len(searches.values) > 1:
        same = int(np.sum(np.asarray(searches.values) <= chi * (1.0 + 1e-3) + 1e-9))
        words += f"; {same} of {len(searches.values)} searches agree"
    return paragraph(words)


def _correlation(result: Result) -> list[str]:
    """The correlation of each pair of keys, the strongest first."""
    found = result.record[PREFIX + "correlation"]
    keys, values = labels(found.axes[0]), np.asarray(found.values)
    pairs = ((i, j) for i in range(len(keys)) for j in range(i))
    strongest = sorted(pairs, key=lambda pair: -abs(values[pair]))[:_MOST]
    rows = [[keys[j], keys[i], f"{values[i, j]:+.3f}"] for i, j in strongest]
    return table(("correlation of", "with", number("")), rows)


def _paste(result: Result) -> list[str]:
    """How to run the case with the fitted values, ties included."""
    settings = []
    for variable in _variables(result):
        quantity = result.record[FITTED + str(variable["key"])]
        value, unit = float(quantity.values), quantity.unit
        settings.append((variable["key"], value, unit))
        for tie in variable.get("followed_by") or ():
            offset = parse_quantity(tie.get("offset") or 0.0, unit)
            settings.append((tie["key"], float(tie.get("factor", 1.0)) * value + offset, unit))
    told = (f"--set '{key}={f'{value:.7g} {unit}'.rstrip()}'" for key, value, unit in settings)
    return paragraph(f"to run with the fitted values: --unset fit {' '.join(told)}")


# ----------------------------------------------------------------------------
# Points: measured, computed as written and fitted, residuals over uncertainties.
# ----------------------------------------------------------------------------


def _residuals(result: Result) -> np.ndarray:
    return np.asarray(result.record[PREFIX + "residual"].values)


def quantities_of(result: Result) -> dict[str, dict[str, Quantity]]:
    """Measured quantities, each with `measured`, `uncertainty`, `computed` and `at_start`."""
    found: dict[str, dict[str, Quantity]] = {}
    for path, quantity in result.record.items():
        name, _, measured = path.removeprefix(PREFIX).partition("/")
        if name in ("measured", "uncertainty", "computed", "at_start"):
            found.setdefault(measured, {})[name] = quantity
    return found


def _points(result: Result, most: int | None) -> list[str]:
    """The points that are off most in their uncertainties; all in the order of the case."""
    rows: list[tuple[float, list[str]]] = []
    for path, parts in quantities_of(result).items():
        name, unit = read_as(path, parts["measured"].unit)
        factor = convert(1.0, parts["measured"].unit, unit)
        for place, label in enumerate(labels(parts["measured"].axes[0])):
            at = {key: float(one.values[place]) * factor for key, one in parts.items()}
            off = (at["computed"] - at["measured"]) / at["uncertainty"]
            words = f", {label.replace('=', ' ').replace('_', ' ')}" * (label != "-")
            start = show(at["at_start"]) if "at_start" in at else "-"
            shown = show(at["measured"]), show(at["uncertainty"], digits=2), start
            cells = [f"{name}{words}", *shown, show(at["computed"]), unit, f"{off:+.2f}"]
            rows.append((abs(off), cells))
    if most is not None:
        rows = sorted(rows, key=lambda row: -row[0])[:most]
    words = "measured point" if most is None else "measured point, worst first"
    columns = (words, number("measured"), number("+-"), number("start"), number("fitted"), "unit",
               number("error / +-"))  # fmt: skip
    return table(columns, [cells for _, cells in rows])


def _combinations(result: Result) -> list[str]:
    """How well orthogonal combinations of the keys are known, the best first."""
    found = result.record[PREFIX + "combination"]
    deviation = having(result.record, PREFIX + "combination_uncertainty", "combination")
    if deviation is None or len(found.values) < 2:
        return []
    rows = []
    for vector, size in zip(found.values, deviation.values.tolist(), strict=True):
        parts = (f"{part:+.2f} {key.rpartition('.')[2]}"
                 for key, part in zip(labels(found.axes[1]), vector, strict=True)
                 if abs(part) >= 0.02)  # fmt: skip
        off = f"{100.0 * size:.2g} %" if math.isfinite(size) else "not identifiable"
        rows.append([" ".join(parts), off])
    return table(("combination of scaled keys", number("+-, of the range")), rows)
