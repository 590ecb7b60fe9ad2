"""Stresses and torques of a shaft line against the limits of a case, over speeds and at one."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, bounded, rounded, stack, where
from vibecalc.numerics.rounding import (
    EPSILON,
    UNIT_ROUNDOFF,
    FloatArray,
    IntArray,
    distinct,
    first_of_largest,
    firsts_of_largest,
)
from vibecalc.torsion.adapters.bounds import CANCELLED, ROUNDINGS, SAME, Bound, Judged, bounds
from vibecalc.torsion.adapters.motion import Motion, Reading, of_finite
from vibecalc.torsion.adapters.search import Search, Top
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.critical_speeds import RIVAL, barred_ranges, maxima, slopes
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.stress_limits import NO_BARRED_RANGE, PLACES, barred_range

# ----------------------------------------------------------------------------
# Adapter: stresses and torques of a shaft line against the limits of a case, ranges to be barred.
#
# What a limit says is informative: `stress_limits.py` has edition and scope of each rule.
# ----------------------------------------------------------------------------

PLACE = f"{ROOT}/limit"
#: results of crankshafts that hold at every speed
MADE_OF = ("bending_factor", "torsion_factor", "bending_stress", "fatigue_strength")
#: what a limit is of -> what its results begin with where they have that unit
QUANTITIES = {"stress": "", "torque": "torque_"}


def uses(setup: Setup, unbarred: bool = False) -> dict[str, Reading]:
    """Uses of the limits of a case as readings: "use 0", and for passing through "transient 0".

    `unbarred`: instead of those, "unbarred 0", at speeds that no barred range of a rule may hold.
    """
    names, found = setup.shaft.section_names, {}
    for number, bound in enumerate(bounds(setup)):
        found[f"use {number}"] = bound.use(names)
        if unbarred and bound.basis.rated_speed:
            last = NO_BARRED_RANGE * bound.basis.rated_speed
            found[f"unbarred {number}"] = bound.use(names, last=last)
        elif not unbarred and bound.transient is not None and not bound.formula:
            found[f"transient {number}"] = bound.use(names, "transient")
    return found


def emit_operating_use(scene: Scene, setup: Setup, motion: Motion) -> None:
    """Limits and what they are made of, with the load of the `motion` at the operating speed."""
    asked, at = bounds(setup), setup.speed
    readings, table = _only_uses(setup), LimitTable(scene, setup, asked)
    use = [one.of(motion)[0] for one in readings]
    largest = stack([one.max() for one in use], axis=0)
    scene.emit(f"{PLACE}/operating_utilisation", largest, axes=table.axes)
    if any(bound.quantity == "stress" for bound in asked):
        rated = np.array([bound.basis.rated_speed for bound in asked])
        scene.emit(f"{PLACE}/basis/rated_speed", rated, 0.0, table.axes)
        for name in ("diameter", "tensile_strength", "counted_strength", "design_factor"):
            table.emit(f"basis/{name}", [bounded(getattr(bound.basis, name)) for bound in asked])
        table.emit("basis/size_factor", [known(bound.basis.size_factor) for bound in asked])
    loads = []
    for bound, reading in zip(asked, readings, strict=True):
        per = rounded(1.0 / bound.modulus, 2.0)
        own = reading._replace(scale=None).of(motion)[0]
        loads.append(of_finite(own, per.__mul__))
    table.emit_quantity("operating", "load", loads)
    for name, course in COURSES.items():
        rows = [known(bound.allowed(course, at), bound.roundings) for bound in asked]
        table.emit_quantity("operating", name, rows)
    table.emit("operating/utilisation", use)
    _crank(table, loads, "operating_acceptability")


#: results of what is allowed -> the course of a limit
COURSES = {"allowed": "continuous", "transient": "transient"}


def _only_uses(setup: Setup) -> list[Reading]:
    return [bound.use(setup.shaft.section_names) for bound in bounds(setup)]


def emit_limits(scene: Scene, setup: Setup, search: Search, speed: FloatArray) -> None:
    """Largest uses and barred ranges; courses of the limits at the speeds (s,) of the sweep."""
    asked = bounds(setup)
    tops = [search.top(f"use {number}").of(0) for number in range(len(asked))]
    table, each = LimitTable(scene, setup, asked), list(zip(asked, tops, strict=True))
    columns = [_at_top(*one) for one in each]
    through = [_passing(search, k, *one, columns[k]) for k, one in enumerate(each)]
    _worst(scene, setup, asked, tops, through, speed)
    table.emit("each/utilisation", [one.value for one in tops])
    table.emit("each/speed", [_speed(one) for one in tops])
    table.emit("each/passage_utilisation", through)
    for name, rows in zip(("load", *COURSES), zip(*columns, strict=True), strict=True):
        table.emit_quantity("each", name, list(rows))
    rated = [rounded(1.0 / (bound.basis.rated_speed or np.inf), ROUNDINGS) for bound in asked]
    ratios = [_speed(one) * by for one, by in zip(tops, rated, strict=True)]
    table.emit("each/speed_ratio", ratios)
    _crank(table, [load for load, *_ in columns], "acceptability")
    ranges = [exceeded_of(search, number, bound) for number, bound in enumerate(asked)]
    if emit_barred(scene, ROOT, ranges, setup.speed):
        scene.warn(
            "a limit for continuous operation is exceeded in a range around the operating "
            "speed: it cannot be barred, and the line is not acceptable there"
        )


def _speed(top: Top) -> Bounded:
    value, error = top.speed
    return Bounded(value, error + 8.0 * UNIT_ROUNDOFF * value)


def _at_top(bound: Bound, top: Top) -> tuple[Bounded, Bounded, Bounded]:
    """Load (r,) of the largest uses, and what both courses allow there."""
    (speed, off), row = top.speed, np.arange(len(bound.load))
    rows = []
    for course in COURSES.values():
        value = bound.allowed(course, speed)[row, row]
        beside = [bound.allowed(course, speed + side * off)[row, row] for side in (-1, 1)]
        says = np.isfinite(value)
        moves = [np.where(says & np.isfinite(one), one, value) for one in beside]
        here = known(value, bound.roundings)
        moved = [np.abs(np.where(says, one, 0.0) - np.where(says, value, 0.0)) for one in moves]
        rows.append(Bounded(value, here.error + np.max(moved, axis=0)))
    allowed, transient = rows
    says = np.isfinite(allowed.value)
    load = of_finite(where(says, top.value, 0.0), lambda one: one * where(says, allowed, 1.0))
    return load, allowed, transient


def _passing(
    search: Search, number: int, bound: Bound, top: Top, column: tuple[Bounded, Bounded, Bounded]
) -> Bounded:
    """Largest uses (r,) of what is allowed for passing through; 0 where the limit has none."""
    if not bound.formula:
        if bound.transient is None:
            return 0.0 * bounded(np.where(np.isfinite(top.value.value), top.value.value, 0.0))
        return search.top(f"transient {number}").of(0).value
    # where both have one course, the largest use of both is in one place
    _, allowed, transient = (one.value for one in column)
    ruled = np.isfinite(transient)
    share = np.divide(allowed, transient, out=np.zeros_like(allowed), where=ruled)
    return where(ruled, of_finite(top.value, lambda one: one * share), 0.0)


def _worst(
    scene: Scene,
    setup: Setup,
    asked: list[Bound],
    tops: list[Top],
    through: list[Bounded],
    speed: FloatArray,
) -> None:
    """Largest use of each limit, and the course of the limit in the load that has it."""
    place = [first_of_largest(one.value.value) for one in tops]
    axes = {"limit": np.arange(1, len(asked) + 1), "speed": speed}
    for quantity, prefix in QUANTITIES.items():
        if not any(bound.quantity == quantity for bound in asked):
            continue
        for name, course in COURSES.items():
            rows = [
                known(bound.allowed(course, speed)[:, worst], bound.roundings)
                if bound.quantity == quantity
                else known(np.full(len(speed), np.inf))
                for bound, worst in zip(asked, place, strict=True)
            ]
            scene.emit(f"{PLACE}/{prefix}{name}", stack(rows, axis=0), axes=axes)
    each = list(zip(tops, place, strict=True))
    number = np.array([bound.load[k] + 1 for bound, k in zip(asked, place, strict=True)])
    sections = len(setup.shaft.section_names)
    scene.emit(
        f"{PLACE}/largest_utilisation", stack([one.value[k] for one, k in each], axis=0), axes=axes
    )
    scene.emit(f"{PLACE}/speed", stack([_speed(one)[k] for one, k in each], axis=0), axes=axes)
    scene.emit(f"{PLACE}/section", np.where(number <= sections, number, 0), 0.0, axes)
    if any(one.gears or one.alternating_share for one in setup.torsion.limits):
        scene.emit(f"{PLACE}/gear", np.maximum(number - sections, 0), 0.0, axes)
    scene.emit(
        f"{PLACE}/passage_utilisation", stack([one.max() for one in through], axis=0), axes=axes
    )


# ----------------------------------------------------------------------------
# Adapter: uses of limits in some conditions, each with the load that has the largest one.
# ----------------------------------------------------------------------------


def emit_uses(
    scene: Scene,
    place: str,
    motions: Sequence[Motion],
    search: Search | None,
    axes: Mapping[str, Any],
    here: bool = True,
) -> None:
    """In conditions (c,), the `motions` at the operating speed, and over those of a `search`.

    Without an axis of conditions in `axes` those of the only one, and those of the operating speed
    only `here`. With a search also the ranges above the limits.
    """
    lines = [one.setup for one in motions]
    held = [bounds(one) for one in lines]
    only = 0 if "condition" not in axes else slice(None)

    def put(name: str, value: Any) -> None:
        scene.emit(f"{place}/{name}", value[only], axes=axes)

    def element(start: str, worst: IntArray, speed: FloatArray) -> None:
        """The loads (c, l) by their places among those of a limit, and what is allowed in them."""
        load, allowed = np.zeros(worst.shape, dtype=np.int64), np.full(worst.shape, np.inf)
        for at, chosen in np.ndenumerate(worst):
            bound = held[at[0]][at[1]]
            allowed[at] = bound.allowed("continuous", speed[at])[chosen]
            load[at] = bound.load[chosen] + 1 if np.isfinite(allowed[at]) else 0
        put(f"{start}element", load)
        of = np.array([one.quantity for one in held[0]])
        for quantity, prefix in QUANTITIES.items():
            if quantity in of:
                put(f"{start}{prefix}allowed", known(np.where(of == quantity, allowed, np.inf)))

    uses = [[one.of(motion)[0] for one in _only_uses(motion.setup)] for motion in motions]
    use = stack([stack([one.max() for one in row]) for row in uses], axis=0)
    if here:
        worst = np.array([[first_of_largest(one.value) for one in row] for row in uses])
        put("operating_utilisation", use)
        element("operating_", worst, np.full(worst.shape, lines[0].speed))
    if search is None:
        return
    best, unbarred = [], []
    for number, bound in enumerate(held[0]):
        top = search.top(f"use {number}")
        best.append((firsts_of_largest(top.value.value, axis=1), top))
        above = use[:, number]
        if bound.basis.rated_speed:
            high = search.top(f"unbarred {number}").value.max()
            above = where(high.value > above.value, high, above)
        unbarred.append(above)
    row = np.arange(len(lines))
    put("largest_utilisation", stack([top.value[row, at] for at, top in best]))
    speed = stack([top.speed[row, at] for at, top in best])
    put("speed", speed)
    element("", np.stack([at for at, _ in best], axis=-1), speed.value)
    put("unbarred_utilisation", stack(unbarred))
    ranges = [exceeded_of(search, number, bound, line)
              for line, own in enumerate(held) for number, bound in enumerate(own)]  # fmt: skip
    count = len(lines) if "condition" in axes else 0
    emit_barred(scene, place.removesuffix("/limit"), ranges, lines[0].speed, count)


# ----------------------------------------------------------------------------
# Adapter: limits of a shaft line in a table by load.
# ----------------------------------------------------------------------------


def _crank(table: "LimitTable", loads: list[Bounded], name: str) -> None:
    """Acceptability factors of crankshafts at these stresses (r,) of each limit, as `name`.

    What they are made of stands with those at the operating speed.
    """
    limits = table.setup.torsion.limits
    if not any(one.rule == "iacs_m53" for one in limits):
        return
    judged = [Judged(table.setup, one) if one.rule == "iacs_m53" else None for one in limits]
    pairs = zip(judged, loads, strict=True)
    table.emit_crank(name, [one.acceptability(load) if one else None for one, load in pairs])
    for path in MADE_OF if name.startswith("operating") else ():
        rows = [None if one is None else one.made_of(path) * one.bored for one in judged]
        table.emit_crank(
            path,
            [None if row is None else rounded(row, CANCELLED) for row in rows],
        )


def known(value: FloatArray, roundings: float = ROUNDINGS) -> Bounded:
    """What a limit says, with its rounding; infinite where it says nothing."""
    return Bounded(value, rounded(np.where(np.isfinite(value), value, 0.0), roundings).error)


class LimitTable:
    """Emits values by limit and load; columns are the sections and gears that some limit is for."""

    def __init__(self, scene: Scene, setup: Setup, asked: list[Bound]) -> None:
        self.scene, self.setup, self.places = scene, setup, [bound.load for bound in asked]
        self.quantities = [bound.quantity for bound in asked]
        self.columns = np.flatnonzero(np.bincount(np.concatenate(self.places)))
        every = (*setup.shaft.section_names, *(one.name for one in setup.shaft.gears))
        names = tuple(every[e] for e in self.columns)
        self.axes = {"limit": np.arange(1, len(asked) + 1), "section": names}

    def emit(self, path: str, rows: list[Bounded]) -> None:
        """Rows (r,) of each limit."""
        values = self._filled([one.value for one in rows])
        errors = self._filled([np.broadcast_to(one.error, one.shape) for one in rows])
        self.scene.emit(f"{PLACE}/{path}", values, errors, self.axes)

    def emit_quantity(self, place: str, name: str, rows: list[Bounded]) -> None:
        """Rows (r,) of each limit, those of stresses apart from those of torques."""
        for quantity, prefix in QUANTITIES.items():
            if quantity in self.quantities:
                path = quantity if name == "load" else f"{prefix}{name}"
                chosen = [one == quantity for one in self.quantities]
                none = [bounded(np.zeros(row.shape)) for row in rows]
                kept = [row if on else no for row, no, on in zip(rows, none, chosen, strict=True)]
                self.emit(f"{place}/{path}", kept)

    def _filled(self, rows: list[FloatArray]) -> FloatArray:
        found = np.zeros((len(rows), len(self.columns)))
        for line, place, row in zip(found, self.places, rows, strict=True):
            line[np.searchsorted(self.columns, place)] = row
        return found

    def emit_crank(self, name: str, rows: Sequence[Bounded | None]) -> None:
        """Rows (r, 3) of each limit for crankshafts, by place of the throw."""
        value = np.zeros((len(rows), len(self.columns), len(PLACES)))
        error = np.zeros_like(value)
        for number, (row, place) in enumerate(zip(rows, self.places, strict=True)):
            if row is not None:
                columns = np.searchsorted(self.columns, place)
                value[number, columns], error[number, columns] = row.value, row.error
        axes = {**self.axes, "crank_place": PLACES}
        self.scene.emit(f"{PLACE}/crank/{name}", value, error, axes)


# ----------------------------------------------------------------------------
# Adapter: ranges of speeds in which a limit is exceeded, and the barred ranges that follow.
#
# A class rule bars more than the range in which the stress exceeds its limit: all of its formula's
# range about the speed of largest use.
# ----------------------------------------------------------------------------

#: minima above a limit, lowest first, that are searched between the speeds
DIPS = 64


class ExceededRanges(NamedTuple):
    """Ranges (b,) above one limit in rad/s: ends, speed of the largest use inside, with errors.

    `rule` (b, 2) is what the formula of a class rule bars about that speed, 0 without a rule.
    """

    start: FloatArray
    end: FloatArray
    error: FloatArray
    peak: FloatArray
    peak_error: FloatArray
    rule: FloatArray
    permitted: IntArray


def exceeded_of(search: Search, number: int, bound: Bound, line: int = 0) -> ExceededRanges:
    """Ranges of a line above a limit, from the samples of its use and the largest of each load."""
    setup, columns = search.lines[line], search.columns[f"use {number}"]
    own = search.clear & (search.pairs.real == line)
    use, speed = search.samples[own][:, columns], search.pairs.imag[own]
    top, undamped = search.top(f"use {number}").of(line), search.undamped_at
    if np.all(top.value.value <= 1.0):
        none = np.zeros(0)
        return ExceededRanges(*5 * (none,), np.zeros((0, 2)), np.zeros(0, dtype=np.int64))
    first, most = line * search.count + columns.start, np.max(use, axis=1, initial=0.0)

    def value(row: IntArray, where: FloatArray) -> FloatArray:
        return search.value(row + first, where)

    def excess(at: FloatArray) -> FloatArray:
        place = np.minimum(np.searchsorted(speed, at), len(speed) - 1)
        found, new = most[place], np.flatnonzero(speed[place] != at)
        if len(new):
            there = use_of.of(Motion(setup, at[new])).value
            found[new] = np.max(there, axis=1, initial=0.0)
        return np.asarray(found - 1.0)

    use_of = search.readings[line][f"use {number}"]
    # maxima that may exceed the limit between the speeds, or are the largest of a range
    inside = use[1:-1]
    high = (inside > use[:-2]) & (inside >= use[2:]) & (inside >= RIVAL)
    place, section = np.nonzero(high & np.isfinite(use[:-2] + use[2:]))
    near = maxima(value, use, speed, section, place + 1, undamped)
    every = [speed, top.speed.value, undamped, near.speed, _dips(excess, use, speed)]
    ranges = barred_ranges(excess, distinct(np.concatenate(every)))
    start, end = (_at_corner(one, bound.corners) for one in (ranges.start, ranges.end))
    known = np.concatenate([
        [near.value, near.speed, near.speed_error],
        [top.value.value, *top.speed],
        np.stack([use.max(axis=1, initial=0.0), speed, np.zeros(len(speed))]),
        [np.full(len(undamped), np.inf), undamped, 1e-10 * undamped],
    ], axis=1)  # fmt: skip
    peak, peak_error = 0.5 * (start + end), 0.5 * (end - start)  # narrower than the steps
    for row, ends in enumerate(zip(start, end, strict=True)):
        held = known[:, (known[1] >= ends[0]) & (known[1] <= ends[1])]
        if held.size:
            _, peak[row], peak_error[row] = held[:, np.argmax(held[0])]
    rule, permitted = np.zeros((len(start), 2)), np.ones(len(start), dtype=np.int64)
    rated = bound.basis.rated_speed
    if rated and len(start):
        below = end <= NO_BARRED_RANGE * rated
        if bound.formula:
            barred = barred_range(peak, rated)
            rule = np.stack([barred.lower, barred.upper], axis=1)
            below = below & barred.permitted
        permitted = below.astype(np.int64)
    # nobody runs in a range that is barred
    permitted = np.where((start <= setup.speed) & (setup.speed <= end), 0, permitted)
    # what errors of the use move an end by: over the slope there
    at = np.concatenate([start, end])
    off = np.max([use_of.of(Motion(setup, part, bounded=True)).errors.max(axis=1, initial=0.0)
                  for part in (start, end)], axis=0) if len(start) else start  # fmt: skip
    with np.errstate(invalid="ignore", divide="ignore"):
        moved = np.tile(off, 2) / slopes(excess, at, float(speed[0]), float(speed[-1]))
    moved = 2.0 * np.where(np.isfinite(moved), moved, 0.0) + 8.0 * EPSILON * at
    error = np.max(moved.reshape(2, -1), axis=0)
    return ExceededRanges(start, end, error, peak, peak_error, rule, permitted)


def _at_corner(at: FloatArray, corners: FloatArray) -> FloatArray:
    """Speeds (b,) as those of corners (k,) where they are these but for the last digits."""
    for corner in corners.tolist():
        at = np.where(np.isclose(at, corner, rtol=2.0 * SAME, atol=0.0), corner, at)
    return at


def emit_barred(
    scene: Scene, root: str, ranges: list[ExceededRanges], speed: float, conditions: int = 0
) -> bool:
    """Ranges above each limit, in the order of the limits, and what is barred for all of them.

    Those of so many `conditions` follow each other, and what is barred is barred in any of them.
    No range may be that holds the operating `speed` in rad/s; tells whether one does.
    """
    place = f"{root}/exceeded"
    start, end, error, peak, peak_error, rule, permitted = (
        np.concatenate(part) for part in zip(*ranges, strict=True)
    )
    many = [len(one.start) for one in ranges]
    condition, number = np.divmod(np.repeat(np.arange(len(ranges)), many),
                                  len(ranges) // (conditions or 1))  # fmt: skip
    axes = {"exceeded": np.arange(1, len(start) + 1)}
    if conditions:
        scene.emit(f"{place}/condition", condition + 1, 0.0, axes)
    scene.emit(f"{place}/from", start, error, axes)
    scene.emit(f"{place}/to", end, error, axes)
    scene.emit(f"{place}/limit", number + 1, 0.0, axes)
    peak_error = peak_error + 4.0 * EPSILON * peak
    scene.emit(f"{place}/peak_speed", peak, peak_error, axes)
    # the ends move by at most 9/8 of what the peak does
    off = np.where(rule[:, 0] > 0.0, 1.2 * peak_error + 8.0 * EPSILON * peak, 0.0)
    scene.emit(f"{place}/formula_from", rule[:, 0], off, axes)
    scene.emit(f"{place}/formula_to", rule[:, 1], off, axes)
    scene.emit(f"{place}/permitted", permitted, 0.0, axes)
    ruled = rule[:, 0] > 0.0
    lower = np.where(ruled, np.minimum(start, rule[:, 0]), start)
    upper = np.where(ruled, np.maximum(end, rule[:, 1]), end)
    joined = united(lower, upper)
    axes = {"barred": np.arange(1, len(joined) + 1)}
    uncertainty = np.maximum(error, off)
    off_of = np.array([np.max(uncertainty[group]) for group in joined])
    for name, value in (
        ("from", [np.min(lower[group]) for group in joined]),
        ("to", [np.max(upper[group]) for group in joined]),
    ):
        scene.emit(f"{root}/barred/{name}", np.array(value), off_of, axes)
    allowed = np.array([np.min(permitted[group]) for group in joined], dtype=np.int64)
    held = [np.min(lower[group]) <= speed <= np.max(upper[group]) for group in joined]
    allowed = np.where(np.array(held, dtype=bool), 0, allowed)
    scene.emit(f"{root}/barred/permitted", allowed, 0.0, axes)
    return any(held)


def united(lower: FloatArray, upper: FloatArray) -> list[IntArray]:
    """Places of the ranges (b,) that overlap or touch, group by group, by rising speed."""
    groups: list[list[int]] = []
    reach = -np.inf
    for place in np.argsort(lower, kind="stable").tolist():
        if lower[place] > reach:
            groups.append([])
        groups[-1].append(place)
        reach = max(reach, float(upper[place]))
    return [np.array(group, dtype=np.int64) for group in groups]


def _dips(
    excess: Callable[[FloatArray], FloatArray], use: FloatArray, speed: FloatArray
) -> FloatArray:
    """Speeds (k,) of minima above a limit that may be below it between the speeds (s,)."""
    worst = np.max(use, axis=1)
    inside = worst[1:-1]
    low = (inside <= worst[:-2]) & (inside <= worst[2:]) & (inside > 1.0)
    place = np.flatnonzero(low) + 1
    place = np.sort(place[np.argsort(worst[place], kind="stable")][:DIPS])
    if not len(place):
        return np.zeros(0)
    start, at, end = speed[place - 1], speed[place], speed[place + 1]
    row, share = np.arange(len(place)), np.linspace(0.0, 1.0, 9)
    for _ in range(3):
        where = np.concatenate(
            [start[:, None] + (at - start)[:, None] * share,
             at[:, None] + (end - at)[:, None] * share[1:]], axis=1,
        )  # fmt: skip
        values = excess(where.ravel()).reshape(where.shape)
        best = np.clip(np.argmin(values, axis=1), 1, where.shape[1] - 2)
        start, at, end = where[row, best - 1], where[row, best], where[row, best + 1]
    return at
