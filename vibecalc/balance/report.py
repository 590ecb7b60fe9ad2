"""The section of the weights sought for the least force and couple."""

import json
import math
from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.sections import Section, by_size, having, labels, section, table_of
from vibecalc.core.report.writing import Column, number, paragraph, read, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.units import convert

ROOT, _WEIGHT = "balance", "balance/weight"
#: what is shown by order: path below before and after, words
_BY_ORDER = (("force", "force N"), ("couple", "couple N m"), ("roll_couple", "roll N m"),
             ("residual", "residual N"))  # fmt: skip
#: share of the largest residual below which an order is left out, where no weight turns at it
_FAINT = 1e-6
#: m, within which weights stand at one place
_MET = 1e-6


def balance(result: Result) -> Section | None:
    """The weights, what they leave by order, and how they stand in a case; None without them."""
    unbalance = having(result.record, f"{_WEIGHT}/unbalance", "weight")
    if unbalance is None:
        return None
    shown = {path for path in result.record if path.startswith(f"{ROOT}/")}
    blocks = [_weights(result, unbalance), _orders(result), _words(result), _as_case(result)]
    return section("Balance: weights for the least force and couple", blocks, shown=shown)


def axis_of(result: Result) -> int:
    """Which of x, y, z the crankshaft lies along."""
    return "xyz".index(str(table_of(result.case, "machine", "crank_train").get("axis", "x")))


def angle_of(record: Record, at: int) -> str:
    """The angle at which a weight stands, for the first table."""
    if not record[f"{_WEIGHT}/unbalance"].values[at]:
        return ""
    return f"at {show(math.degrees(record[f'{_WEIGHT}/phase'].values[at]))} deg"


def _known(record: Record, name: str, axis: str) -> dict[str, float]:
    """What only some of the weights have, by their names."""
    found = having(record, f"{_WEIGHT}/{name}", axis)
    if found is None:
        return {}
    return dict(zip(labels(found.axes[0]), map(float, found.values), strict=True))


def _weights(result: Result, unbalance: Quantity) -> list[str]:
    record = result.record
    phase, position, ratio = (
        record[f"{_WEIGHT}/{name}"] for name in ("phase", "position", "speed_ratio")
    )
    along = axis_of(result)
    mass, use = _known(record, "mass", "balance_radius"), _known(record, "use", "balance_bound")
    unit, unit_of_mass = by_size("g*mm", unbalance.values), by_size("g", [*mass.values(), 0.0])
    factor, of_mass = convert(1.0, "kg*m", unit), convert(1.0, "kg", unit_of_mass)
    rows = []
    for i, name in enumerate(labels(unbalance.axes[0])):
        size = float(unbalance.values[i])
        rows.append(
            [
                name,
                f"{ratio.values[i]:+.0f}",
                show(factor * size, factor * unbalance.error_estimate),
                show(math.degrees(phase.values[i])) if size else "-",
                show(1e3 * float(position.values[i][along]), 1e-9),
                show(of_mass * mass[name]) if name in mass else "",
                f"{100.0 * use[name]:.1f} %" if name in use else "",
            ]
        )
    heads = [
        Column("weight"), number("speed\nratio"), number(f"unbalance\n{read(unit)}"),
        number("phase\ndeg"), number("position\nmm"),
        number(f"mass at its\nradius {unit_of_mass}"),
        number("of its\nbound")
    ]  # fmt: skip
    return table(heads, rows)


def _orders(result: Result) -> list[str]:
    record, both = result.record, ("before", "after")
    found = [
        [having(record, f"{ROOT}/{when}/{name}", "order") for when in both] for name, _ in _BY_ORDER
    ]
    known = [one for pair in found for one in pair if one is not None]
    if len(known) < 2 * len(_BY_ORDER):
        return []
    free = having(record, f"{ROOT}/free_directions", "balanced_order")
    counting = () if free is None else free.axes[0].values
    orders, residuals = known[0].axes[0].values, [one.values for one in known[-2:]]
    faint = np.max(residuals, axis=0) <= _FAINT * residuals[0].max(initial=0.0)
    rows = [
        [f"{order:g}", *(show(one.values[i], one.estimate) for one in known)]
        for i, order in enumerate(orders)
        if order in counting or not faint[i]
    ]
    if len(orders) > 1:
        rows.append(["all", *_all_orders(record)])
    heads = [Column("order")]
    for _, words in _BY_ORDER:
        heads += [number(f"{words}\nbefore"), number("\nafter")]
    return table(heads, rows)


def _all_orders(record: Record) -> list[str]:
    """Peak force, and the residual, of all orders together; couples follow different axes."""
    cells = []
    for name in ("force_peak", "", "", "all_orders"):
        both = [record.quantities.get(f"{ROOT}/{when}/{name}") for when in ("before", "after")]
        cells += [show(float(one.values), one.error_estimate) if one else "" for one in both]
    return cells


def _words(result: Result) -> list[str]:
    """What was reached, and what of it is free."""
    record = result.record
    free = having(record, f"{ROOT}/free_directions", "balanced_order")
    after = having(record, f"{ROOT}/after/residual", "order")
    before = having(record, f"{ROOT}/before/residual", "order")
    if free is None or after is None or before is None:
        return []
    lines = []
    use = _known(record, "use", "balance_bound")
    names = np.array(labels(record[f"{_WEIGHT}/unbalance"].axes[0]))
    turns = np.abs(record[f"{_WEIGHT}/speed_ratio"].values)
    for order, count in zip(free.axes[0].values, free.values, strict=True):
        place = int(np.flatnonzero(after.axes[0].values == order)[0])
        left, was = float(after.values[place]), float(before.values[place])
        mine = names[turns == order]
        rest = _not_counted(record, place)
        balanced = bool(after.zero[place])
        if balanced and before.zero[place]:
            lines += paragraph(f"order {order} is balanced already, without weights{rest}")
            continue
        share = show(100.0 * left / (was or left or 1.0), digits=3)
        words = f"order {order}: {share} % of the residual is left"
        if balanced:
            words = f"order {order} is balanced exactly, but for rounding{rest}"
        at_bound = [name for name in mine if use.get(name, 0.0) >= 1.0 - 1e-9]
        if at_bound:
            words += f"; {', '.join(at_bound)} at the largest unbalance"
        if round(float(count)):
            words += f"; {_freedom(round(float(count)), [name in use for name in mine])}"
        lines += paragraph(words)
    lines += [line for one in _together(record) for line in paragraph(one)]
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


def _not_counted(record: Record, place: int) -> str:
    """What is left of an order of which the residual is zero."""
    found = [
        words
        for name, words in (("force", "force"), ("couple", "couple"), ("roll_couple", "roll"))
        if (one := having(record, f"{ROOT}/after/{name}", "order")) is not None
        and not one.zero[place]
    ]
    return f", and for its {' and '.join(found)}, not counted" if found else ""


def _freedom(count: int, bounded: list[bool]) -> str:
    """Which of equally good weights are given."""
    each = ", each as a share of its bound" if any(bounded) else ""
    if each and not all(bounded):
        each += ", or of the largest bound where it has none"
    return (
        f"other weights are as good ({count} free direction{'s' if count > 1 else ''}): given are "
        f"those with the least sum of squares of the unbalances{each}"
    )


def _together(record: Record) -> Iterator[str]:
    """Weights whose places were free and that met at one: a single one does the same."""
    unbalance = record[f"{_WEIGHT}/unbalance"]
    names, size = labels(unbalance.axes[0]), unbalance.values
    place, ratio = (record[f"{_WEIGHT}/{name}"].values for name in ("position", "speed_ratio"))
    for i in range(len(names)):
        same = (ratio == ratio[i]) & (np.abs(place - place[i]).max(axis=1) <= _MET) & (size > 0.0)
        if size[i] and same.sum() > 1 and np.flatnonzero(same)[0] == i:
            met = ", ".join(names[k] for k in np.flatnonzero(same))
            yield f"{met} stand at one place: only their sum counts, and one weight does for them"


def _as_case(result: Result) -> list[str]:
    """The weights as a case has them, to be pasted into it."""
    record, along = result.record, axis_of(result)
    given = table_of(result.case, "balance").get("counterweights", ())
    on_the_crank = {str(one["name"]) for one in given}
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
        if name in on_the_crank:
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
