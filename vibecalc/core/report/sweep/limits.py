"""Limits of a case at every point of its sweep: shares, nearest points, the region in words."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.goals import written_at
from vibecalc.core.report.sections import read_as
from vibecalc.core.report.sweep.statistics import Worst, alike, numeric, worst
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import number, paragraph, show, table
from vibecalc.core.results.printed import read_printed
from vibecalc.core.results.select import STANDARD_ERRORS, Side
from vibecalc.core.results.tolerance import remedy
from vibecalc.core.results.verdicts import Bound, bounds_of, held
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Limits of a case judged at every point of its sweep, and the points that keep all of them.
# ----------------------------------------------------------------------------


class Limit(NamedTuple):
    """One side of a `[[limit]]` at all points, (points,) each; bound and margin are in SI.

    `margin` is positive inside, NaN where nothing was computed. `kept` says where the whole
    interval of the value and its error lies inside, `broken` where it lies outside. `shown` is the
    bound as written, with its unit.
    """

    quantity: str
    where: Mapping[str, Any]
    source: str
    side: Side
    bound: float
    shown: str
    unit: str
    worst: Worst
    margin: np.ndarray
    kept: np.ndarray
    broken: np.ndarray


def judge(sweep: SweepView) -> tuple[list[Limit], list[str]]:
    """Limits on what the sweep keeps, in the order of the case, and quantities it does not keep."""
    limits: list[Limit] = []
    missing: list[str] = []
    rows: Any = sweep.case.get("limit") or ()
    for row in rows:
        path = str(row["quantity"])
        if path not in sweep.quantities:
            missing.append(path)
            continue
        unit = sweep.quantities[path].unit
        limits += [_judge(sweep, row, path, bound) for bound in bounds_of(row, unit)]
    return limits, list(dict.fromkeys(missing))


def keeping_all(sweep: SweepView, limits: Sequence[Limit]) -> np.ndarray:
    """Which points are computed and keep every limit, (points,)."""
    return np.asarray(np.all([sweep.done, *(limit.kept for limit in limits)], axis=0))


def breaking_any(sweep: SweepView, limits: Sequence[Limit]) -> np.ndarray:
    """Which points are computed and break a limit, (points,); the rest is kept or undecided."""
    broken = [np.zeros_like(sweep.done), *(limit.broken for limit in limits)]
    return np.asarray(np.any(broken, axis=0))


def best(sweep: SweepView, limits: Sequence[Limit]) -> tuple[int, Limit] | None:
    """The point that keeps all limits with the most room in the first kept result with a limit.

    None if no point keeps them all, or there is no limit. Where several points are the same
    within their errors the first one counts.
    """
    first = goal(sweep, limits)
    kept = keeping_all(sweep, limits)
    if first is None or not kept.any():
        return None
    room = np.where(kept, first.margin, -np.inf)
    point = int(np.argmax(room))
    if math.isfinite(room[point]):
        slack = alike(first.worst.errors[point], first.worst.values[point])
        point = int(np.argmax(room >= room[point] - 2.0 * slack))
    return point, first


def goal(sweep: SweepView, limits: Sequence[Limit]) -> Limit | None:
    """The limit on the first of the kept results that has one."""
    first = (one for path in numeric(sweep) for one in limits if one.quantity == path)
    return next(first, None)


def least_broken(sweep: SweepView, limits: Sequence[Limit]) -> tuple[int, Limit, float] | None:
    """The point nearest to keeping all limits where none does: how far, relative to the bound.

    Its worst limit is by the smallest share of its bound beyond it; the limit and share are named.
    """
    if not limits or not sweep.done.any():
        return None
    shares = np.stack([limit.margin / (abs(limit.bound) or 1.0) for limit in limits])
    shares = np.where(np.isnan(shares), -np.inf, shares)
    smallest = shares.min(axis=0)
    point = int(np.argmax(np.where(sweep.done, smallest, -np.inf)))
    if not math.isfinite(smallest[point]):
        return None
    return point, limits[int(np.argmin(shares[:, point]))], float(-smallest[point])


def _judge(sweep: SweepView, row: Mapping[str, Any], path: str, bound: Bound) -> Limit:
    unit = sweep.quantities[path].unit
    printed = read_printed(bound.written, default_unit=unit)
    where = dict(row.get("where") or {})
    counted = worst(sweep, path, where, bound.side)
    with np.errstate(invalid="ignore"):
        margin = bound.left(counted.values)
        spread = 0.0 if counted.spread is None else STANDARD_ERRORS * counted.spread
        state = held(margin, counted.errors + spread, bound.value)
    return Limit(
        quantity=path,
        where=where,
        source=str(row.get("source") or ""),
        side=bound.side,
        bound=bound.value,
        shown=f"{printed.number:g} {printed.unit}".rstrip(),
        unit=unit,
        worst=counted,
        margin=margin,
        kept=np.asarray(sweep.done & (state > 0)),
        broken=np.asarray(sweep.done & (state < 0)),
    )


# ----------------------------------------------------------------------------
# Distances between points of a sweep: which one is nearest to the case as it is written.
# ----------------------------------------------------------------------------

_BLOCK = 1 << 18


def case_values(sweep: SweepView) -> np.ndarray | None:
    """What the varied keys are in the case itself, (keys,); None if one of them is not there."""
    found = []
    for key in sweep.keys:
        value = written_at(sweep.case, key.key)
        if key.names and str(value) in key.names:
            found.append(float(key.names.index(str(value))))
        elif isinstance(value, int | float) and not isinstance(value, bool) and not key.names:
            found.append(float(value))
        else:
            return None
    return np.array(found)


def nearest(sweep: SweepView, among: np.ndarray) -> int | None:
    """The point of `among` (points,) nearest to the case, None if there is none or no case.

    Each key counts in shares of its range (of the range of its logarithm on a logarithmic axis); a
    choice is as far from another as the whole range.
    """
    here = case_values(sweep)
    points = np.flatnonzero(among)
    if here is None or not points.size:
        return None
    logarithmic, low, width = _scales(sweep)
    centre = _scaled(here[None, :], logarithmic, low, width)[0]
    choice = np.array([bool(key.names) for key in sweep.keys])
    smallest, point = np.inf, int(points[0])
    for start in range(0, points.size, _BLOCK):
        block = points[start : start + _BLOCK]
        apart = np.abs(_scaled(sweep.values_of(block), logarithmic, low, width) - centre)
        apart = np.where(choice, apart > 0.0, apart)
        # round-off must not choose between two neighbours at one distance
        distance = np.round(np.sum(apart**2, axis=1), 12)
        place = int(np.argmin(distance))
        if distance[place] < smallest:
            smallest, point = float(distance[place]), int(block[place])
    return point


def ranges(sweep: SweepView, among: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of each key over the points of `among`, (keys,) each, in SI."""
    points = np.flatnonzero(among)
    low = np.full(len(sweep.keys), np.inf)
    high = -low
    for start in range(0, points.size, _BLOCK):
        values = sweep.values_of(points[start : start + _BLOCK])
        low, high = np.minimum(low, values.min(axis=0)), np.maximum(high, values.max(axis=0))
    return low, high


def _scales(sweep: SweepView) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    flags = [axis.logarithmic for axis in sweep.grid for _ in axis.keys]
    logarithmic = np.array(flags or [False] * len(sweep.keys))
    low, high = ranges(sweep, np.ones(sweep.count, dtype=bool))
    logarithmic &= low > 0.0
    low = np.where(logarithmic, np.log(np.where(logarithmic, low, 1.0)), low)
    high = np.where(logarithmic, np.log(np.where(logarithmic, high, 1.0)), high)
    width = np.where(high > low, high - low, 1.0)
    return logarithmic, low, width


def _scaled(
    values: np.ndarray, logarithmic: np.ndarray, low: np.ndarray, width: np.ndarray
) -> np.ndarray:
    usable = logarithmic & (values > 0.0)
    logs = np.log(np.where(usable, values, 1.0))
    # a value that has no logarithm is further off than any point
    shown = np.where(logarithmic, np.where(usable, logs, low - width), values)
    return np.asarray((shown - low) / width)


# ----------------------------------------------------------------------------
# Where a sweep keeps the limits of its case: shares, nearest points, and the region in words.
# ----------------------------------------------------------------------------

_LIMITS = "limit on", number("bound"), number("kept at"), "nearest to the case that keeps it"
_REGION = (
    "key", number("swept from"), number("to"), number("kept from"), number("to"), "unit", "",
)  # fmt: skip


def limit_lines(sweep: SweepView, limits: Sequence[Limit], missing: Sequence[str]) -> list[str]:
    """Table of the limits, then the region where all are kept, the best point and the nearest."""
    lines: list[str] = []
    if limits:
        rows = [_row(sweep, limit) for limit in limits]
        lines += table(_LIMITS, rows)
        lines += ["", *_region(sweep, limits)]
    for path in missing:
        lines += paragraph(f"the limit on {path} is not judged: the sweep does not keep it")
    return lines


def share_within_limits(sweep: SweepView, limits: Sequence[Limit]) -> str:
    """`all 3 limits are kept at 120 of 441 (27.2 %) computed points`."""
    counted = sweep.done & sweep.independent
    kept = int(np.count_nonzero(keeping_all(sweep, limits) & counted))
    computed = int(np.count_nonzero(counted))
    which = {1: "the limit is", 2: "both limits are"}.get(
        len(limits), f"all {len(limits)} limits are"
    )
    open_ = sweep.done & ~keeping_all(sweep, limits) & ~breaking_any(sweep, limits)
    undecided = int(np.count_nonzero(open_ & sweep.independent))
    words = f", undecided at {undecided}: {_decided_by(sweep, limits)}" if undecided else ""
    return f"{which} kept at {_of(kept, computed)} computed points{words}"


def _decided_by(sweep: SweepView, limits: Sequence[Limit]) -> str:
    """What would decide the limits that the error of a point reaches over."""
    open_ = [one for one in limits if np.any(sweep.done & ~one.kept & ~one.broken)]
    said = dict.fromkeys(remedy(sweep.quantities[one.quantity], sweep.case) for one in open_)
    return f"{' and '.join(said)} would decide it"


def _row(sweep: SweepView, limit: Limit) -> list[str]:
    name = read_as(limit.quantity, limit.unit)[0]
    picks = ", ".join(f"{axis} {entry}" for axis, entry in limit.where.items())
    for remark in (picks, f"({limit.source})" if limit.source else ""):
        name += f"\n  {remark}" if remark else ""
    counted = sweep.done & sweep.independent
    kept = int(np.count_nonzero(limit.kept & counted))
    computed = int(np.count_nonzero(counted))
    near = nearest(sweep, limit.kept)
    if near is not None:
        where = sweep.words_of(near).replace(", ", "\n")
    else:
        where = "-" if kept else "none"
    share = _of(kept, computed).replace(" (", "\n(")
    open_ = int(np.count_nonzero(counted & ~limit.kept & ~limit.broken))
    share += f"\n{open_} undecided" if open_ else ""
    return [name, f"{limit.side} {limit.shown}", share, where]


def _of(count: int, total: int) -> str:
    share = f" ({100.0 * count / total:.3g} %)" if total else ""
    return f"{count} of {total}{share}"


def _region(sweep: SweepView, limits: Sequence[Limit]) -> list[str]:
    kept = keeping_all(sweep, limits)
    if kept.any():
        said = filter(None, (_best(sweep, limits), _nearest(sweep, kept)))
        below = [line for words in said for line in paragraph(words)]
        return [*paragraph("where all limits are kept:"), *_extent(sweep, kept), "", *below]
    lines = paragraph("No computed point keeps all limits.")
    broken = least_broken(sweep, limits)
    if broken is not None:
        point, limit, share = broken
        text = f"least broken at {sweep.words_of(point)}: {read_as(limit.quantity, '')[0]} is "
        text += f"{show(100.0 * share, digits=3)} % of its bound beyond it"
        label = limit.worst.label(point)
        lines += paragraph(text + (f" ({label})." if label else "."))
    return lines


def _extent(sweep: SweepView, kept: np.ndarray) -> list[str]:
    """The smallest box around all points that keep the limits; `>` where it meets the sweep's."""
    swept = ranges(sweep, np.ones(sweep.count, dtype=bool))
    inside = ranges(sweep, kept)
    values = sweep.values_of(np.flatnonzero(kept))
    rows = []
    for column, key in enumerate(sweep.keys):
        if key.names:
            which = sorted({round(float(value)) for value in values[:, column]})
            names = ", ".join(key.names[place] for place in which)
            rows.append([f"{key.words}: {names}", "", "", "", "", "", ""])
            continue
        ends = [key.number(end[column]) for end in (*swept, *inside)]
        edges = [swept[side][column] == inside[side][column] for side in (0, 1)]
        mark = ("<" if edges[0] else "") + (">" if edges[1] else "")
        rows.append([key.words, *ends, key.unit, mark])
    lines = table(_REGION, rows)
    if any("<" in row[-1] or ">" in row[-1] for row in rows):
        lines += paragraph(
            "< and >: the region reaches the lower or the upper end of what was swept, and may "
            "go on beyond it"
        )
    return lines


def _best(sweep: SweepView, limits: Sequence[Limit]) -> str:
    found = best(sweep, limits)
    first = goal(sweep, limits)
    if found is None or first is None:
        return ""
    point, limit = found
    sense = "smallest" if limit.side == "max" else "largest"
    label = limit.worst.label(point)
    name, unit = read_as(limit.quantity, limit.unit)
    largest = limit.worst.times(convert(1.0, limit.unit, unit))
    shown = show(largest.values[point], largest.estimate(point))
    return (
        f"best: {sweep.words_of(point)} has the {sense} {name} of these points, "
        f"{shown} {unit}".rstrip()
        + (f" ({label})." if label else ".")
    )


def _nearest(sweep: SweepView, kept: np.ndarray) -> str:
    here = case_values(sweep)
    near = nearest(sweep, kept)
    if here is None or near is None:
        return ""
    pairs = zip(sweep.keys, here, strict=True)
    written = ", ".join(f"{key.words} = {key.shown(value)}" for key, value in pairs)
    return f"nearest to the case as written ({written}): {sweep.words_of(near)}."
