"""Limits of a case judged at every point of its sweep, and the points that keep all of them."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.report.printed import read_printed
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.sweep.worst import Side, Worst, numeric, worst
from vibecalc.results.select import STANDARD_ERRORS, held
from vibecalc.units import convert


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
    found: list[Limit] = []
    missing: list[str] = []
    rows: Any = sweep.case.get("limit") or ()
    for row in rows:
        path = str(row["quantity"])
        if path not in sweep.kept:
            missing.append(path)
            continue
        sides: tuple[Side, Side] = ("max", "min")
        found += [_judge(sweep, row, path, side) for side in sides if row.get(side) is not None]
    return found, list(dict.fromkeys(missing))


def keeping_all(sweep: SweepView, limits: Sequence[Limit]) -> np.ndarray:
    """Which points are computed and keep every limit, (points,)."""
    kept = sweep.done.copy()
    for limit in limits:
        kept &= limit.kept
    return kept


def breaking_any(sweep: SweepView, limits: Sequence[Limit]) -> np.ndarray:
    """Which points are computed and break a limit, (points,); the rest is kept or undecided."""
    broken = np.zeros_like(sweep.done)
    for limit in limits:
        broken |= limit.broken
    return broken


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
    slack = first.worst.errors[point]
    if math.isfinite(slack) and math.isfinite(room[point]):
        point = int(np.argmax(room >= room[point] - 2.0 * slack))
    return point, first


def goal(sweep: SweepView, limits: Sequence[Limit]) -> Limit | None:
    """The limit on the first of the kept results that has one."""
    for path in numeric(sweep):
        for limit in limits:
            if limit.quantity == path:
                return limit
    return None


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


def _judge(sweep: SweepView, row: Mapping[str, Any], path: str, side: Side) -> Limit:
    unit = sweep.kept[path].unit
    printed = read_printed(row[side], default_unit=unit)
    where = dict(row.get("where") or {})
    bound = convert(printed.number, printed.unit, unit)
    counted = worst(sweep, path, where, side)
    with np.errstate(invalid="ignore"):
        margin = bound - counted.values if side == "max" else counted.values - bound
        spread = 0.0 if counted.spread is None else STANDARD_ERRORS * counted.spread
        state = held(margin, counted.errors + spread, bound)
    return Limit(
        quantity=path,
        where=where,
        source=str(row.get("source") or ""),
        side=side,
        bound=bound,
        shown=f"{printed.number:g} {printed.unit}".rstrip(),
        unit=unit,
        worst=counted,
        margin=margin,
        kept=np.asarray(sweep.done & (state > 0)),
        broken=np.asarray(sweep.done & (state < 0)),
    )
