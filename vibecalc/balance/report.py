"""The section of the weights sought for the least force and couple."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibecalc.balance.results import ROOT
from vibecalc.core.report.sections import Section, having, labels, section, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Result

_WEIGHT = f"{ROOT}/weight"
#: what is shown by order: path below before and after, words
_BY_ORDER = (("force", "force N"), ("couple", "couple N m"), ("roll_couple", "roll N m"),
             ("residual", "residual N"))  # fmt: skip
#: share of the largest residual below which an order is left out, where no weight turns at it
_FAINT = 1e-6


def balance(result: Result) -> Section | None:
    """The weights, what they leave by order, and how they stand in a case; None without them."""
    unbalance = having(result.record, f"{_WEIGHT}/unbalance", "balance_weight")
    if unbalance is None:
        return None
    shown = {path for path in result.record if path.startswith(f"{ROOT}/")}
    blocks = [_weights(result, unbalance), _orders(result), _words(result), _as_case(result)]
    return section("Balance: weights for the least force and couple", blocks, shown=shown)


def axis_of(result: Result) -> int:
    """Which of x, y, z the crankshaft lies along."""
    return "xyz".index(str(table_of(result.case, "machine", "crank_train").get("axis", "x")))


def shaft_labels(shaft: Mapping[str, Any]) -> list[str]:
    """Names of the weights of a shaft as results have them."""
    name, weights = str(shaft["name"]), shaft["weights"]
    if len(weights) == 1:
        return [name]
    return [f"{name}, {one.get('name') or i + 1}" for i, one in enumerate(weights)]


def _bounds(result: Result) -> dict[str, float]:
    """Largest unbalance of each weight that has one, by its name."""
    given = table_of(result.case, "balance")
    found = {}
    for one in given.get("counterweights", ()):
        found[str(one["name"])] = one.get("largest_unbalance")
    for shaft in given.get("shafts", ()):
        for label, one in zip(shaft_labels(shaft), shaft["weights"], strict=True):
            found[label] = one.get("largest_unbalance")
    return {name: bound for name, bound in found.items() if bound is not None}


def _weights(result: Result, unbalance: Quantity) -> list[str]:
    record, bounds = result.record, _bounds(result)
    phase, position, ratio = (
        record[f"{_WEIGHT}/{name}"] for name in ("phase", "position", "speed_ratio")
    )
    along = axis_of(result)
    mass = having(record, f"{_WEIGHT}/mass", "balance_radius")
    masses = dict(zip(labels(mass.axes[0]), mass.values, strict=True)) if mass is not None else {}
    rows = []
    for i, name in enumerate(labels(unbalance.axes[0])):
        size, bound = float(unbalance.values[i]), bounds.get(name, math.inf)
        share = "" if math.isinf(bound) else f"{100.0 * size / bound:.1f} %"
        rows.append(
            [
                name,
                f"{ratio.values[i]:+.0f}",
                show(1e6 * size, 1e6 * unbalance.error_estimate),
                show(math.degrees(phase.values[i])) if size else "-",
                show(1e3 * float(position.values[i][along]), 1e-9),
                show(1e3 * masses[name]) if name in masses else "",
                share,
            ]
        )
    heads = [
        Column("weight", 26), number("speed\nratio", 6), number("unbalance\ng mm", 12),
        number("phase\ndeg", 9), number("position\nmm", 10), number("mass at its\nradius g", 12),
        number("of its\nbound", 9),
    ]  # fmt: skip
    return table(heads, rows)


def _orders(result: Result) -> list[str]:
    found = {
        (name, when): having(result.record, f"{ROOT}/{when}/{name}", "order")
        for name, _ in _BY_ORDER
        for when in ("before", "after")
    }
    if any(one is None for one in found.values()):
        return []
    known = {key: one for key, one in found.items() if one is not None}
    residual = known["residual", "before"]
    orders, largest = residual.axes[0].values, float(residual.values.max(initial=0.0))
    rows = []
    for i, order in enumerate(orders):
        sizes = [float(known["residual", when].values[i]) for when in ("before", "after")]
        if order > 2 and max(sizes) <= _FAINT * largest:
            continue
        cells = []
        for name, _ in _BY_ORDER:
            pair = [known[name, when] for when in ("before", "after")]
            cells += [show(one.values[i], one.estimate) for one in pair]
        rows.append([f"{order:g}", *cells])
    heads = [Column("order", 6)]
    for _, words in _BY_ORDER:
        heads += [number(f"{words}\nbefore", 10), number("\nafter", 10)]
    return table(heads, rows)


def _words(result: Result) -> list[str]:
    """What was reached, and what of it is free."""
    record = result.record
    free = having(record, f"{ROOT}/free_directions", "balanced_order")
    after = having(record, f"{ROOT}/after/residual", "order")
    before = having(record, f"{ROOT}/before/residual", "order")
    if free is None or after is None or before is None:
        return []
    lines = []
    names = {
        order: [
            label
            for label, ratio in zip(
                labels(record[f"{_WEIGHT}/unbalance"].axes[0]),
                record[f"{_WEIGHT}/speed_ratio"].values,
                strict=True,
            )
            if abs(ratio) == order
        ]
        for order in free.axes[0].values
    }
    for i, order in enumerate(free.axes[0].values):
        place = int(np.flatnonzero(after.axes[0].values == order)[0])
        left, was = float(after.values[place]), float(before.values[place])
        words = f"order {order}: "
        if was <= before.error_estimate and left <= after.error_estimate:
            words += "there is nothing of it that counts, with or without weights"
        elif left <= after.error_estimate:
            words += "what counts of it is balanced exactly, nothing is left but rounding"
        elif was > 0.0:
            words += f"{show(100.0 * left / was, digits=3)} % of the residual is left"
        bounds = _bounds(result)
        unbalance = record[f"{_WEIGHT}/unbalance"]
        at_bound = [
            name
            for name, size in zip(labels(unbalance.axes[0]), unbalance.values, strict=True)
            if name in names[order] and name in bounds and size >= bounds[name] * (1.0 - 1e-9)
        ]
        if at_bound:
            words += f"; {', '.join(at_bound)} at the largest unbalance"
        count = round(float(free.values[i]))
        if count:
            words += (
                f"; equally good weights form a continuum with {count} free "
                f"direction{'s' if count > 1 else ''}, of which the least weights are given"
            )
        lines += paragraph(words)
    gap = record.quantities.get(f"{ROOT}/gap")
    total = record.quantities.get(f"{ROOT}/residual_before")
    if gap is not None and total is not None and gap.values > 1e-9 * float(total.values):
        least = float(record[f"{ROOT}/residual"].values) - float(gap.values)
        proven = f"that no others leave less than {show(least)} N is proven" if least else ""
        lines += paragraph(
            "the places that are free were found by a search from several starts: "
            + (proven or "nothing is proven of what others leave")
        )
    return lines


def _as_case(result: Result) -> list[str]:
    """The weights as a case has them, to be pasted into it."""
    record, along = result.record, axis_of(result)
    shafts = {
        str(label)
        for shaft in table_of(result.case, "balance").get("shafts", ())
        for label in shaft_labels(shaft)
    }
    unbalance = record[f"{_WEIGHT}/unbalance"]
    columns = [record[f"{_WEIGHT}/{name}"].values for name in ("phase", "position", "speed_ratio")]
    on_crank, on_shafts = [], []
    for i, name in enumerate(labels(unbalance.axes[0])):
        size = float(unbalance.values[i])
        phase, place, ratio = (column[i] for column in columns)
        known = {"name": json.dumps(name, ensure_ascii=False), "unbalance": _number(size)}
        known["phase"] = _number(phase)
        if not size:
            continue
        if name not in shafts:
            words = ", ".join(f"{key} = {value}" for key, value in known.items())
            on_crank.append(f"    {{ {words}, position = {_number(place[along])} }},")
            continue
        known["speed_ratio"] = f"{ratio:.0f}"
        known["position"] = f"[{', '.join(map(_number, place))}]"
        on_shafts += ["", "  [[machine.crank_train.balance_shafts]]"]
        on_shafts += [f"  {key} = {value}" for key, value in known.items()]
    if on_crank:
        on_crank = ["  [machine.crank_train]", "  counterweights = [", *on_crank, "  ]"]
    lines = [*on_crank, *on_shafts[0 if on_crank else 1 :]]
    head = paragraph("These weights in a case, besides those that it has (kg m, rad, m):")
    return [*head, *lines] if lines else []


def _number(value: float) -> str:
    """A number in the fewest digits that give it to twelve."""
    return f"{value:.12g}" if value else "0"
