"""The section of the weights sought for the least force and couple."""

import json
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Made, Rows, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels, scalar_of, section, table_of
from vibecalc.core.report.writing import paragraph, show
from vibecalc.core.results.record import Quantity, Record, Result

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
    record = result.record
    if having(record, f"{_WEIGHT}/unbalance", "weight") is None:
        return None
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    words = [line for one in (*_reached(record), *_together(record)) for line in paragraph(one)]
    blocks = [_weights(result), _orders(record), words, _as_case(result)]
    return section("Balance weights for minimum force and couple", blocks, shown=shown)


def axis_of(result: Result) -> int:
    """Which of x, y, z the crankshaft lies along."""
    return "xyz".index(str(table_of(result.case, "machine", "crank_train").get("axis", "x")))


def angle_of(record: Record, at: int, _path: str) -> str:
    """A weight with the angle at which it stands, for the first table."""
    size, phase = (record[f"{_WEIGHT}/{name}"].values[at] for name in ("unbalance", "phase"))
    name = labels(record[f"{_WEIGHT}/unbalance"].axes[0])[at]
    return name + (f" at {show(math.degrees(phase))} deg" if size else "")


# ----------------------------------------------------------------------------
# Tables: the weights; what is left by order.
# ----------------------------------------------------------------------------


def _of_some(name: str) -> Made:
    """What only some of the weights have, among all of them."""

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(f"{_WEIGHT}/{name}")
        if found is None:
            return None
        return replace(found, axes=(replace(found.axes[0], name="weight"),))

    return made


def _weights(result: Result) -> list[str]:
    record, along = result.record, axis_of(result)
    size = record[f"{_WEIGHT}/unbalance"].values

    def phase(record: Record) -> Quantity:
        found = record[f"{_WEIGHT}/phase"]
        return replace(found, values=np.where(size > 0.0, found.values, np.inf))

    def position(record: Record) -> Quantity:
        found = record[f"{_WEIGHT}/position"]
        return part_of(found, found.values[:, along], found.axes[0])

    columns = (
        Cells(f"{_WEIGHT}/speed_ratio", "speed\nratio", lambda value, _: f"{value:+.0f}"),
        Cells(f"{_WEIGHT}/unbalance", "unbalance\n{unit}", "g*mm"),
        Cells(phase, "phase\ndeg", "deg", blank=True),
        Cells(position, "position\nmm", lambda value, _: show(1e3 * value, 1e-9)),
        Cells(_of_some("mass"), "mass\n{unit}", "g"),
        Cells(
            _of_some("utilisation"), "share of\nmaximum", lambda value, _: f"{100.0 * value:.1f} %"
        ),
    )
    return rows_of(record, Rows("weight", "weight", columns))[0]


def _orders(record: Record) -> list[str]:
    free = having(record, f"{ROOT}/free_directions", "balanced_order")
    counting = () if free is None else free.axes[0].values

    def places(found: Found) -> np.ndarray:
        left = np.max([one.values for one in found[-2:]], axis=0)
        chosen = np.isin(found[0].axes[0].values, counting)
        return np.flatnonzero(chosen | (left > _FAINT * np.max(found[-2].values)))

    columns = [
        Cells(f"{when}/{name}", head)
        for name, words in _BY_ORDER
        for when, head in (("before", f"{words}\nwithout"), ("after", "\nwith"))
    ]
    return rows_of(record, Rows("order", "order", columns, ROOT, "{:g}", places=places))[0]


# ----------------------------------------------------------------------------
# What was reached, what of it is free, and which weights are one.
# ----------------------------------------------------------------------------


def _reached(record: Record) -> Iterator[str]:
    """What is left of each order that counts, and what is proven of it."""
    free = having(record, f"{ROOT}/free_directions", "balanced_order")
    after, before = (having(record, f"{ROOT}/{when}/residual", "order")
                     for when in ("after", "before"))  # fmt: skip
    if free is None or after is None or before is None:
        return
    bounds = record.quantities.get(f"{_WEIGHT}/utilisation")
    use = {} if bounds is None else dict(zip(labels(bounds.axes[0]), bounds.values, strict=True))
    names = np.array(labels(record[f"{_WEIGHT}/unbalance"].axes[0]))
    turns = np.abs(record[f"{_WEIGHT}/speed_ratio"].values)
    for order, count in zip(free.axes[0].values, free.values.astype(int), strict=True):
        place = int(np.flatnonzero(after.axes[0].values == order)[0])
        left, was = float(after.values[place]), float(before.values[place])
        mine = names[turns == order]
        if after.zero[place] and before.zero[place]:
            yield f"order {order} is balanced without weights{_uncounted(record, place)}"
            continue
        words = f"order {order} is fully balanced{_uncounted(record, place)}"
        if not after.zero[place]:
            share = show(100.0 * left / (was or left), digits=3)
            words = f"order {order}: residual reduced to {share} %"
        at_bound = [name for name in mine if use.get(name, 0.0) >= 1.0 - 1e-9]
        if at_bound:
            words += f"; {', '.join(at_bound)} at the maximum unbalance"
        yield words + (f"; {_freedom(count, [name in use for name in mine])}" if count else "")
    gap, total, residual = (
        scalar_of(record, f"{ROOT}/{name}") for name in ("gap", "residual_before", "residual")
    )
    if gap is not None and total is not None and residual is not None and gap > 1e-9 * total:
        proven = "no lower bound is proven"
        if residual > gap:
            proven = f"proven lower bound of the residual {show(residual - gap)} N"
        yield f"free positions found by a search from several starts; {proven}"


def _uncounted(record: Record, place: int) -> str:
    """What is left of an order of which the residual is zero."""
    after = {words.split()[0]: having(record, f"{ROOT}/after/{name}", "order")
             for name, words in _BY_ORDER[:-1]}  # fmt: skip
    found = [name for name, one in after.items() if one is not None and not one.zero[place]]
    return f", except for its {' and '.join(found)} (not counted)" if found else ""


def _freedom(count: int, bounded: list[bool]) -> str:
    """Which of equally good weights are given."""
    each = ", each as a share of its maximum" if any(bounded) else ""
    if each and not all(bounded):
        each += ", or of the largest maximum where it has none"
    return (
        f"not unique: {count} of {len(2 * bounded)} unknowns are free; the smallest weights are "
        f"shown, by the sum of squares of the unbalances{each}"
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
            yield f"{met} coincide: only their sum counts, so one weight is enough"


# ----------------------------------------------------------------------------
# The weights as a case has them, to be pasted into it.
# ----------------------------------------------------------------------------


def _as_case(result: Result) -> list[str]:
    record, along = result.record, axis_of(result)
    given = table_of(result.case, "balance").get("counterweights", ())
    on_the_crank = {str(one["name"]) for one in given}
    names = labels(record[f"{_WEIGHT}/unbalance"].axes[0])
    paths = ("unbalance", "phase", "position", "speed_ratio")
    columns = [record[f"{_WEIGHT}/{name}"].values for name in paths]
    on_crank, on_shafts = [], []
    for name, size, phase, place, ratio in zip(names, *columns, strict=True):
        known = {"name": json.dumps(name, ensure_ascii=False)}
        known |= {"unbalance": _number(size), "phase": _number(phase)}
        if size and name in on_the_crank:
            known["position"] = _number(place[along])
            words = ", ".join(f"{key} = {value}" for key, value in known.items())
            on_crank.append(f"    {{ {words} }},")
        elif size:
            known["speed_ratio"] = f"{ratio:.0f}"
            known["position"] = f"[{', '.join(map(_number, place))}]"
            on_shafts += ["", "  [[machine.crank_train.balance_shafts]]"]
            on_shafts += [f"  {key} = {value}" for key, value in known.items()]
    if on_crank:
        on_crank = ["  [machine.crank_train]", "  counterweights = [", *on_crank, "  ]"]
    lines = [*on_crank, *on_shafts[0 if on_crank else 1 :]]
    head = paragraph("To add these weights to the case (kg m, rad, m):")
    return [*head, *lines] if lines else []


def _number(value: float) -> str:
    """A number in the fewest digits that give it to twelve."""
    return f"{value:.12g}" if value else "0"
