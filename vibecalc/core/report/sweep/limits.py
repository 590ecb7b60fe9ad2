"""Limits of a case at every point of its sweep: shares, nearest points, the region in words."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibecalc.core.report.goals import goal_of, written_at
from vibecalc.core.report.sections import read_as, table_of
from vibecalc.core.report.sweep.statistics import Worst, first_of, worst
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import number, paragraph, show_in, table
from vibecalc.core.results.catalogue import deciding
from vibecalc.core.results.printed import read_printed
from vibecalc.core.results.select import STANDARD_ERRORS, Side
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import bounds_of, held
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Limits of a case judged at every point of its sweep, and the points that keep all of them.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Judged:
    """Whether points keep limits: `state` (points,) is 1 where the whole interval of value and
    error lies inside, -1 where it lies outside, 0 where neither is so, NaN where there is no value.
    """

    state: np.ndarray

    @property
    def kept(self) -> np.ndarray:
        """Points (points,) that are computed and keep them."""
        return np.asarray(self.state > 0)

    @property
    def broken(self) -> np.ndarray:
        """Points that break one."""
        return np.asarray(self.state < 0)

    @property
    def open(self) -> np.ndarray:
        """Points that do neither."""
        return np.asarray(self.state == 0)


@dataclass(frozen=True, kw_only=True)
class Limit(Judged):
    """One side of a `[[limit]]`; `bound` and `margin` (points,), positive inside, are in SI.

    `number` is the place in the case of the `[[limit]]`, which may have another side. `words` are
    the side and the bound as written, with its unit: `max 100 N`.
    """

    number: int
    quantity: str
    where: Mapping[str, Any]
    source: str
    side: Side
    bound: float
    words: str
    worst: Worst
    margin: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Limits(Judged):
    """All limits on what a sweep keeps, in the order of the case, and quantities it does not."""

    limits: list[Limit]
    missing: list[str]


def judge(sweep: SweepView) -> Limits:
    """All limits of the case at all points."""
    limits: list[Limit] = []
    missing: dict[str, None] = {}
    for place, row in enumerate(sweep.case.get("limit") or ()):
        path, where = str(row["quantity"]), dict(row.get("where") or {})
        sides: list[Side] = [side for side in ("max", "min") if row.get(side) is not None]
        for side in sides:
            extreme = deciding(path, where, side)
            found = extreme if extreme in sweep.quantities else path
            if found in sweep.quantities:
                limits.append(_judge(sweep, place, row, found, side))
            else:
                missing[path] = None
    known = np.where(sweep.done, 1.0, np.nan)
    state = np.min([known, *(limit.state for limit in limits)], axis=0)
    return Limits(state=state, limits=limits, missing=list(missing))


def _judge(sweep: SweepView, place: int, row: Mapping[str, Any], path: str, side: Side) -> Limit:
    (bound,) = bounds_of({side: row[side]}, sweep.quantities[path].unit)
    printed = read_printed(bound.written, default_unit=sweep.quantities[path].unit)
    where = dict(row.get("where") or {})
    counted = worst(sweep, path, where, side)
    with np.errstate(invalid="ignore"):
        margin = bound.left(counted.values)
        spread = 0.0 if counted.spread is None else STANDARD_ERRORS * counted.spread
        state = held(margin, counted.errors + spread, bound.value)
    return Limit(
        state=np.where(sweep.done, state, np.nan),
        number=place,
        quantity=path,
        where=where,
        source=str(row.get("source") or ""),
        side=side,
        bound=bound.value,
        words=f"{side} {printed.number:g} {printed.unit}".rstrip(),
        worst=counted,
        margin=margin,
    )


def best(sweep: SweepView, judged: Limits) -> tuple[int, str] | None:
    """The point that keeps all limits with the best objective, and words on it.

    That of [sweep], else of [optimisation]. None if no point keeps all limits, or no objective is
    kept. Where several points are the same within their errors the first one counts.
    """
    named = (table_of(sweep.case, study, "objective") for study in ("sweep", "optimisation"))
    given = next(filter(None, named), {})
    path = str(given.get("quantity"))
    if path not in sweep.quantities or not judged.kept.any():
        return None
    goal = goal_of(given, sweep.quantities[path].unit)
    counted = worst(sweep, path, goal.where, goal.side).times(goal.factor)
    values = np.where(judged.kept, counted.values, np.nan)
    point = int(first_of(values, counted.errors, "min" if goal.smaller else "max"))
    label, sense = counted.label(point), "smallest" if goal.smaller else "largest"
    shown = show_in(values[point], goal.unit, counted.estimate(point))
    words = f"best: {sweep.words_of(point)} has the {sense} {goal.name} of these points, {shown}"
    return point, words + (f" ({label})." if label else ".")


def least_broken(sweep: SweepView, limits: Sequence[Limit]) -> tuple[int, Limit, float] | None:
    """The point nearest to keeping all limits where none does: how far, relative to the bound.

    Its worst limit is by the smallest share of its bound beyond it; the limit and share are named.
    """
    if not limits:
        return None
    shares = np.stack([limit.margin / (abs(limit.bound) or 1.0) for limit in limits])
    shares = np.where(np.isnan(shares), -np.inf, shares)
    smallest = shares.min(axis=0)
    point = int(np.argmax(smallest))
    if not math.isfinite(smallest[point]):
        return None
    return point, limits[int(np.argmin(shares[:, point]))], float(-smallest[point])


# ----------------------------------------------------------------------------
# Distances between points of a sweep: which one is nearest to the case as it is written.
# ----------------------------------------------------------------------------


def case_values(sweep: SweepView) -> np.ndarray | None:
    """What the varied keys are in the case itself, (keys,); None if one of them is not there."""
    found = []
    for key in sweep.keys:
        value = written_at(sweep.case, key.key)
        if key.choices and str(value) in key.choices:
            found.append(float(key.choices.index(str(value))))
        elif isinstance(value, int | float) and not isinstance(value, bool) and not key.choices:
            found.append(float(value))
        else:
            return None
    return np.array(found)


def nearest(sweep: SweepView, among: np.ndarray) -> int | None:
    """The point of `among` (points,) nearest to the case, None if there is none or no case.

    Each key counts in shares of its range (of the range of its logarithm on a logarithmic axis); a
    choice is as far from another as the whole range.
    """
    here, points = case_values(sweep), np.flatnonzero(among)
    if here is None or not points.size:
        return None
    every = np.vstack([sweep.values_of(np.arange(sweep.count)), here])
    for column, key in enumerate(sweep.keys):
        if key.choices:
            every[:, column] = every[:, column] != here[column]
    flags = [bool(sweep.grid) and axis.logarithmic for axis in sweep.head.axes for _ in axis.keys]
    logarithmic = np.array(flags) & np.all(every[:-1] > 0.0, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        every = np.where(logarithmic, np.log(every), every)
    width = np.ptp(every[:-1], axis=0)
    width = np.where(width > 0.0, width, 1.0)
    # a value that has no logarithm is further off than any point
    centre = np.where(np.isfinite(every[-1]), every[-1], every[:-1].min(axis=0) - width)
    # round-off must not choose between two neighbours at one distance
    distance = np.round(np.sum(((every[points] - centre) / width) ** 2, axis=1), 12)
    return int(points[np.argmin(distance)])


# ----------------------------------------------------------------------------
# Where a sweep keeps the limits of its case: shares, nearest points, and the region in words.
# ----------------------------------------------------------------------------

_LIMITS = "limit on", number("bound"), number("kept at"), "nearest to the case that keeps it"
_REGION = (
    "key", number("swept from"), number("to"), number("kept from"), number("to"), "unit", "",
)  # fmt: skip


def limit_lines(sweep: SweepView, judged: Limits) -> list[str]:
    """Table of the limits, then the region where all are kept, the best point and the nearest."""
    rows = [_row(sweep, limit) for limit in judged.limits]
    lines = [*table(_LIMITS, rows), "", *_region(sweep, judged)] if rows else []
    for path in judged.missing:
        lines += paragraph(f"the limit on {path} is not judged: the sweep does not store it")
    return lines


def share_within_limits(sweep: SweepView, judged: Limits) -> str:
    """`all 3 limits are kept at 120 of 441 (27.2 %) computed points`."""
    limits = judged.limits
    count = len({one.number for one in limits})
    which = {1: "the limit is", 2: "both limits are"}.get(count, f"all {count} limits are")
    words = f"{which} kept at {_share(sweep, judged)} computed points"
    if undecided := np.count_nonzero(judged.open & sweep.independent):
        wanting = (sweep.quantities[one.quantity] for one in limits if np.any(one.open))
        remedies = dict.fromkeys(remedy(one, sweep.case) for one in wanting)
        words += f", undecided at {undecided}: {' and '.join(remedies)} would decide it"
    return words


def _row(sweep: SweepView, limit: Limit) -> list[str]:
    name = read_as(limit.quantity, sweep.quantities[limit.quantity].unit)[0]
    picks = ", ".join(f"{axis} {entry}" for axis, entry in limit.where.items())
    for remark in (picks, f"({limit.source})" if limit.source else ""):
        name += f"\n  {remark}" if remark else ""
    near = nearest(sweep, limit.kept)
    where = "-" if np.any(limit.kept & sweep.independent) else "none"
    if near is not None:
        where = sweep.words_of(near).replace(", ", "\n")
    share = _share(sweep, limit).replace(" (", "\n(")
    open_ = np.count_nonzero(limit.open & sweep.independent)
    share += f"\n{open_} undecided" if open_ else ""
    return [name, limit.words, share, where]


def _share(sweep: SweepView, judged: Judged) -> str:
    """How many of the computed points that are samples on their own: `120 of 441 (27.2 %)`."""
    count, total = (np.count_nonzero(one & sweep.independent) for one in (judged.kept, sweep.done))
    return f"{count} of {total}" + (f" ({100.0 * count / total:.3g} %)" if total else "")


def _region(sweep: SweepView, judged: Limits) -> list[str]:
    if judged.kept.any():
        lines = [*_extent(sweep, judged.kept), ""]
        if found := best(sweep, judged):
            lines += paragraph(found[1])
        here, near = case_values(sweep), nearest(sweep, judged.kept)
        if here is not None and near is not None:
            words = f"({sweep.words(here)}): {sweep.words_of(near)}"
            lines += paragraph(f"nearest to the case as written {words}.")
        return lines
    lines = paragraph("No computed point meets all limits.")
    if broken := least_broken(sweep, judged.limits):
        point, limit, _ = broken
        own = sweep.quantities[limit.quantity].unit
        name, unit = read_as(limit.quantity, own)
        value = limit.worst.times(convert(1.0, own, unit)).values[point]
        text = f"closest: {sweep.words_of(point)}; {name}: {show_in(value, unit)}, {limit.words}"
        label = limit.worst.label(point)
        lines += paragraph(text + (f" ({label})." if label else "."))
    return lines


def _extent(sweep: SweepView, kept: np.ndarray) -> list[str]:
    """The smallest box around all points that keep the limits; `>` where it meets the sweep's."""
    every = sweep.values_of(np.arange(sweep.count))
    lower, upper = every[kept].min(axis=0), every[kept].max(axis=0)
    within = np.count_nonzero(np.all((lower <= every) & (every <= upper), axis=1) & sweep.done)
    count = np.count_nonzero(kept)
    some = f" ({count} of the {within} points in these ranges)" if count < within else ""
    rows = []
    for key, swept, inside in zip(sweep.keys, every.T, every[kept].T, strict=True):
        if key.choices:
            names = ", ".join(key.choices[place] for place in np.unique(inside).astype(int))
            rows.append([f"{key.label}: {names}", "", "", "", "", "", ""])
            continue
        ends = np.array([(one.min(), one.max()) for one in (swept, inside)])
        low, high = ends[0] == ends[1]
        numbers = map(key.number, ends.ravel())
        rows.append([key.label, *numbers, key.written_unit, "<" * bool(low) + ">" * bool(high)])
    words = (
        "< and >: the region reaches the lower or upper end of the swept range and may extend "
        "beyond it"
    )
    return [
        *paragraph(f"where all limits are kept{some}:"),
        *table(_REGION, rows),
        *(paragraph(words) if any(row[-1] for row in rows) else []),
    ]
