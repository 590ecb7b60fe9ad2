"""Where a sweep keeps the limits of its case: shares, nearest points, and the region in words."""

from collections.abc import Sequence

import numpy as np

from vibecalc.pipeline.tolerance import remedy
from vibecalc.report.numbers import show
from vibecalc.report.sweep.limits import (
    Limit,
    best,
    breaking_any,
    goal,
    keeping_all,
    least_broken,
)
from vibecalc.report.sweep.nearest import case_values, nearest, ranges
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.tables import Column, fold, number, paragraph, table

_LIMITS = (
    Column("limit on", 38),
    number("bound", 13),
    number("kept at", 16),
    Column("nearest to the case that keeps it", 28),
)
_REGION = (
    Column("key", 30),
    number("swept from", 12),
    number("to", 12),
    number("kept from", 12),
    number("to", 12),
    Column("unit", 9),
    Column("", 5),
)


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


def kept_share(sweep: SweepView, limits: Sequence[Limit]) -> str:
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
    said = dict.fromkeys(remedy(sweep.kept[one.quantity], sweep.case) for one in open_)
    return f"{' and '.join(said)} would decide it"


def _row(sweep: SweepView, limit: Limit) -> list[str]:
    name = limit.quantity
    picks = ", ".join(f"{axis}={entry}" for axis, entry in limit.where.items())
    for remark in (picks, f"({limit.source})" if limit.source else ""):
        name += "".join(f"\n  {line}" for line in fold(remark, _LIMITS[0].width - 2) if line)
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
    lines: list[str] = []
    if not kept.any():
        lines += paragraph("No computed point keeps all limits.")
        found = least_broken(sweep, limits)
        if found is not None:
            point, limit, share = found
            text = f"least broken at {sweep.words_of(point)}: {limit.quantity} is "
            text += f"{show(100.0 * share, digits=3)} % of its bound beyond it"
            label = limit.worst.label(point)
            lines += paragraph(text + (f" ({label})." if label else "."))
        return lines
    lines += [*paragraph("where all limits are kept:"), *_extent(sweep, kept), ""]
    for words in (_best(sweep, limits), _nearest(sweep, kept)):
        lines += paragraph(words) if words else []
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
    shown = show(limit.worst.values[point], limit.worst.estimate(point))
    return (
        f"best: {sweep.words_of(point)} has the {sense} {limit.quantity} of these points, "
        f"{shown} {limit.unit}".rstrip()
        + (f" ({label})." if label else ".")
    )


def _nearest(sweep: SweepView, kept: np.ndarray) -> str:
    here = case_values(sweep)
    near = nearest(sweep, kept)
    if here is None or near is None:
        return ""
    pairs = zip(sweep.keys, here, strict=True)
    own = ", ".join(f"{key.words} = {key.shown(value)}" for key, value in pairs)
    return f"nearest to the case as written ({own}): {sweep.words_of(near)}."
