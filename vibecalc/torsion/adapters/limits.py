"""Stresses and torques of a shaft line against the limits of a case, over speeds and at one."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, bounded, rounded, stack, where
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, IntArray
from vibecalc.torsion.adapters.bounds import ROUNDINGS, Bound, bounds
from vibecalc.torsion.adapters.critical import UndampedResonances, undamped_speeds
from vibecalc.torsion.adapters.curves import (
    Curves,
    CurveUncertainty,
    curve_uncertainty,
    of_finite,
    sweep,
)
from vibecalc.torsion.adapters.exceeded import emit_barred, exceeded_of
from vibecalc.torsion.adapters.loads import (
    endless_loads,
    limits_gears,
    load_uncertainty,
    own_loads,
)
from vibecalc.torsion.adapters.maxima import (
    DenseSweep,
    added,
    torque_value,
    with_narrow_resonances,
)
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.crank_strength import PLACES
from vibecalc.torsion.critical_speeds import Maxima, Value, by_machine, largest, telling_speeds
from vibecalc.torsion.model import ShaftLineModel
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.stress_limits import NO_BARRED_RANGE

# ----------------------------------------------------------------------------
# Adapter: stresses and torques of a shaft line against the limits of a case, ranges to be barred.
#
# What a limit says is informative: `stress_limits.py` has edition and scope of each rule.
# ----------------------------------------------------------------------------


class Uses(NamedTuple):
    """Of one limit: load over allowed (s, r) at the speeds, the largest of each load."""

    curve: FloatArray
    top: Maxima
    make: Callable[[IntArray], Value]


def limited_loads(setup: Setup, curves: Curves) -> FloatArray:
    """Referred half ranges (s, e) of sections, and of gears behind them if a limit is for some."""
    return (
        np.concatenate([curves.torque, curves.gear], axis=1)
        if limits_gears(setup)
        else curves.torque
    )


def limit_levels(setup: Setup, speed: FloatArray, torque: FloatArray) -> tuple[FloatArray, ...]:
    """Referred torques (s, e) of each limit that would be a new largest use, or break it.

    `torque` (s, e) is what a sweep has seen, gears behind sections; infinite where a limit says
    nothing.
    """
    levels = []
    for bound in bounds(setup):
        for course in [bound.continuous, *([] if bound.alike else [bound.transient])]:
            load = bound.load
            allowed = course(speed) / bound.factor
            says = np.isfinite(allowed)
            some = np.where(says, allowed, 1.0)
            use = np.where(says, torque[:, load] / some, 0.0)
            level = np.full_like(torque, np.inf)
            level[:, load] = np.where(says, some * np.minimum(np.max(use, axis=0), 1.0), np.inf)
            levels.append(level)
    return tuple(levels)


def limit_corners(setup: Setup, speed: FloatArray) -> FloatArray:
    """Speeds inside a range at which the course of a limit has a corner or an end."""
    every = np.concatenate([bound.corners for bound in bounds(setup)])
    return np.asarray(every[(every > speed[0]) & (every < speed[-1])])


class Range(NamedTuple):
    """A line over speeds (s,): its curves with their errors, and what a search starts from.

    `top` are the largest referred torques of its sections at any speed.
    """

    curves: Curves
    uncertainty: CurveUncertainty
    undamped: UndampedResonances
    dense: DenseSweep
    top: Maxima

    @property
    def torques(self) -> FloatArray:
        """Of sections alone (r, e), at the speeds of the search."""
        return self.dense.torque[:, : self.curves.torque.shape[1]]


def over_range(
    setup: Setup,
    speed: FloatArray,
    limited: bool,
    shaft: ShaftLineModel | None,
    angles: bool = False,
    reported: Callable[[FloatArray], FloatArray] | None = None,
) -> Range:
    """The line over speeds (s,), with gears if a `shaft` is given.

    What it has limits for is examined as closely as its largest values where it is `limited`, and
    so is what reaches the levels (e,) `reported` of its largest torques (s, e).
    """
    curves = sweep(setup.model, setup.drive, speed, shaft, angles)
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    torque = limited_loads(setup, curves) if limited else curves.torque
    levels = limit_levels(setup, speed, torque) if limited else ()
    if reported is not None:
        levels = (*levels, reported(torque))
    dense = with_narrow_resonances(setup, speed, torque, undamped, levels)
    if limited:
        dense = added(setup, dense, by_machine(0, limit_corners(setup, speed)))
    sections = dense.torque[:, : curves.torque.shape[1]]
    make = partial(torque_value, setup.model, setup.drive)
    top = largest(make, sections, dense.speed, undamped.speed, undamped.endless)
    telling = telling_speeds(speed, curves.torque, undamped.speed)
    return Range(curves, curve_uncertainty(setup, speed, telling), undamped, dense, top)


def uses_of(setup: Setup, bound: Bound, dense: DenseSweep, undamped: UndampedResonances) -> Uses:
    """From referred half ranges of torques."""
    speed, torque, _ = dense
    limit = bound.continuous(speed)
    use = np.where(np.isfinite(limit), torque[:, bound.load] * bound.factor / limit, 0.0)
    make = _use_of(setup, bound)
    endless = endless_loads(setup, undamped)[bound.load]
    top = largest(make, use, speed, undamped.speed, _inside(bound, endless))
    return Uses(use, _within(bound, top, use, speed, make), make)


def _within(
    bound: Bound, top: Maxima, use: FloatArray, speed: FloatArray, make: Callable[[IntArray], Value]
) -> Maxima:
    """Largest uses (r,) inside the scope of a limit, its corners and ends among the speeds.

    Where a use drops to nothing at an end, a search for a slope of zero finds no maximum.
    """
    ends = bound.corners[(bound.corners > speed[0]) & (bound.corners < speed[-1])]
    if not len(ends):
        return top
    row = np.arange(len(bound.load))
    lost = ~np.isfinite(bound.continuous(top.speed)[row, row]) & (top.value > 0.0)
    at = np.where(lost, speed[np.argmax(use, axis=0)], top.speed)
    error = np.where(lost, 0.0, top.speed_error)
    there = make(row)(np.repeat(ends[None, :], len(row), axis=0))
    best = np.argmax(there, axis=1)
    more = (there[row, best] >= top.value) & (there[row, best] > 0.0)
    return Maxima(
        top.section,
        np.where(more, ends[best], at),
        np.where(more, 0.0, error),
        np.where(more, there[row, best], top.value),
        np.where(more, 0.0, top.value_error),
    )


def emit_limits(
    scene: Scene,
    setup: Setup,
    speed: FloatArray,
    dense: DenseSweep,
    undamped: UndampedResonances,
) -> None:
    """Uses and barred ranges from referred half ranges of torques.

    `speed` (s,) are those of the sweep, at which the limits are reported.
    """
    asked = bounds(setup)
    uses = [uses_of(setup, bound, dense, undamped) for bound in asked]
    each = [
        largest_of_loads(setup, bound, one, dense, undamped)
        for bound, one in zip(asked, uses, strict=True)
    ]
    _worst(scene, setup, asked, each, speed)
    table = LimitTable(scene, setup, asked)
    for name in ("use", "speed", "transient_use"):
        table.emit(f"each/{name}", [getattr(one, name) for one in each])
    for name in ("load", "allowed", "transient"):
        table.emit_quantity("each", name, [getattr(one, name) for one in each])
    rated = [bound.basis.rated_speed or np.inf for bound in asked]
    ratios = [one.speed * rounded(1.0 / by, ROUNDINGS) for one, by in zip(each, rated, strict=True)]
    table.emit("each/speed_ratio", ratios)
    _crank(table, [one.load for one in each], "acceptability")
    ranges = [
        exceeded_of(setup, bound, one.curve, one.top, one.make, dense.speed, undamped.speed)
        for bound, one in zip(asked, uses, strict=True)
    ]
    emit_barred(scene, ranges, setup.speed)


class LargestUse(NamedTuple):
    """Of one limit, by load (r,): the largest use, its speed, stress or torque and limits there.

    Infinite where nothing damps an order, and limits where they say nothing. `transient_use` is the
    largest at any speed.
    """

    use: Bounded
    speed: Bounded
    load: Bounded
    allowed: Bounded
    transient: Bounded
    transient_use: Bounded


def largest_of_loads(
    setup: Setup, bound: Bound, uses: Uses, dense: DenseSweep, undamped: UndampedResonances
) -> LargestUse:
    """Of all loads of a limit, with the errors."""
    top = uses.top
    row = np.arange(len(top.speed))
    allowed, transient = (
        known(limit_at(top.speed)[row, row], bound.roundings)
        for limit_at in (bound.continuous, bound.transient)
    )
    use, there, moved = _with_errors(setup, bound, top)
    says, passes = np.isfinite(allowed.value), np.isfinite(transient.value)
    # where both have one course, the largest use of both is in one place
    passing = np.where(passes, np.where(passes, transient.value, 0.0) / there.value, 0.0)
    ruled = passing > 0.0
    if bound.alike:
        through = of_finite(use, lambda one: one / np.where(ruled, passing, 1.0))
        through = where(ruled, through, 0.0)
    else:
        other = bound._replace(continuous=bound.transient)
        through = _with_errors(setup, other, uses_of(setup, other, dense, undamped).top)[0]
    return LargestUse(
        use=use,
        speed=Bounded(top.speed, top.speed_error + 8.0 * UNIT_ROUNDOFF * top.speed),
        load=of_finite(where(says, use, 0.0), lambda one: one * there),
        allowed=Bounded(allowed.value, moved + allowed.error),
        transient=Bounded(transient.value, moved * passing + transient.error),
        transient_use=through,
    )


def _with_errors(setup: Setup, bound: Bound, top: Maxima) -> tuple[Bounded, Bounded, FloatArray]:
    """Largest uses (r,), what is allowed there (1: nothing is said), what speeds move it by."""
    row = np.arange(len(top.speed))
    allowed = known(bound.continuous(top.speed)[row, row], bound.roundings)
    says = np.isfinite(allowed.value)
    safe = where(says, allowed, 1.0)
    steps = np.array([bound.continuous(top.speed + s * top.speed_error)[row, row] for s in (-1, 1)])
    steps = np.where(np.isfinite(steps), steps, safe.value)
    moved = np.where(says, np.max(np.abs(steps - safe.value), axis=0), 0.0)
    error = load_uncertainty(setup, top.speed, bound.load) * bound.factor
    off = np.where(says, error / safe.value, 0.0) + top.value_error
    some = np.where(np.isfinite(top.value), top.value, 0.0)
    more = max(bound.roundings - ROUNDINGS, 0.0) * some
    use = Bounded(top.value, off + (ROUNDINGS + more) * UNIT_ROUNDOFF)
    return use, Bounded(safe.value, moved + safe.error), moved


def _worst(
    scene: Scene, setup: Setup, asked: list[Bound], each: list[LargestUse], speed: FloatArray
) -> None:
    """Largest use of each limit, and the course of the limit in the load that has it."""
    place = [int(np.argmax(one.use.value)) for one in each]
    axes = {"limit": np.arange(1, len(each) + 1), "speed": speed}
    both = list(zip(asked, place, strict=True))
    for quantity, prefix in QUANTITIES.items():
        if not any(bound.quantity == quantity for bound in asked):
            continue
        for name, get in (("allowed", "continuous"), ("transient", "transient")):
            rows = [
                known(getattr(bound, get)(speed)[:, worst], bound.roundings)
                if bound.quantity == quantity
                else known(np.full(len(speed), np.inf))
                for bound, worst in both
            ]
            scene.emit(f"{PLACE}/{prefix}{name}", stack(rows, axis=0), axes=axes)
    use, at = (
        stack([getattr(one, name)[worst] for one, worst in zip(each, place, strict=True)], axis=0)
        for name in ("use", "speed")
    )
    number = np.array([bound.load[worst] + 1 for bound, worst in both], dtype=np.int64)
    sections = len(setup.shaft.section_names)
    through = stack([one.transient_use.max() for one in each], axis=0)
    scene.emit(f"{PLACE}/largest_use", use, axes=axes)
    scene.emit(f"{PLACE}/speed", at, axes=axes)
    scene.emit(f"{PLACE}/section", np.where(number <= sections, number, 0), 0.0, axes)
    if limits_gears(setup):
        scene.emit(f"{PLACE}/gear", np.maximum(number - sections, 0), 0.0, axes)
    scene.emit(f"{PLACE}/transient_use", through, axes=axes)


def unbarred_use(
    operating: float, bound: Bound, uses: Uses, dense: DenseSweep, undamped: UndampedResonances
) -> float:
    """Largest use of a limit at speeds that no barred range may hold.

    That is the operating one, and those from a share of the rated speed of a rule on.
    """
    row, last = np.arange(len(bound.load)), NO_BARRED_RANGE * bound.basis.rated_speed
    high = dense.speed >= last
    at = [operating, *([last] if last > dense.speed[0] and np.any(high) else [])]
    most = np.max(uses.make(row)(np.broadcast_to(at, (len(row), len(at)))), initial=0.0)
    if not bound.basis.rated_speed or not np.any(high):
        return float(most)
    none = np.full(len(row), np.nan)
    top = largest(uses.make, uses.curve[high], dense.speed[high], undamped.speed, none)
    endless = uses.top.value[uses.top.speed >= last]
    return float(max(most, np.max(top.value), np.max(endless, initial=0.0)))


def emit_element(
    scene: Scene,
    stem: str,
    asked: list[Bound],
    load: IntArray,
    share: FloatArray,
    axes: Mapping[str, Any],
) -> None:
    """Of limits (..., l) the load of largest use, and what is allowed in it there.

    `share` is the use per own torque in 1/(N m), 0 where the limit says nothing.
    """
    says, modulus = share > 0.0, np.ones((len(asked), int(load.max(initial=0)) + 1))
    for row, bound in zip(modulus, asked, strict=True):
        held = bound.load < len(row)
        row[bound.load[held]] = bound.modulus[held]
    per = np.where(says, share * modulus[np.arange(len(asked)), load], 1.0)
    scene.emit(f"{stem}element", np.where(says, load + 1, 0), 0.0, axes)
    for quantity, prefix in QUANTITIES.items():
        chosen = np.array([one.quantity == quantity for one in asked])
        if np.any(chosen):
            value = known(np.where(says & chosen, 1.0 / per, np.inf))
            scene.emit(f"{stem}{prefix}allowed", value, axes=axes)


def _inside(bound: Bound, endless: FloatArray) -> FloatArray:
    """Endless speeds (r,) at which the limit says something, else NaN."""
    known = ~np.isnan(endless)
    says = bound.continuous(np.where(known, endless, 0.0))
    row = np.arange(len(endless))
    return np.where(known & np.isfinite(says[row, row]), endless, np.nan)


def _use_of(setup: Setup, bound: Bound) -> Callable[[IntArray], Value]:
    """Load over allowed of places among the loads of a limit."""
    shaft = setup.shaft if limits_gears(setup) else None

    def make(place: IntArray) -> Value:
        torque = torque_value(setup.model, setup.drive, bound.load[place], shaft)
        share = bound.factor[place][:, None]

        def value(speed: FloatArray) -> FloatArray:
            limit = bound.continuous(speed)
            at_place = np.take_along_axis(limit, place[:, None, None], axis=2)[..., 0]
            return np.where(np.isfinite(at_place), torque(speed) * share / at_place, 0.0)

        return value

    return make


# ----------------------------------------------------------------------------
# Adapter: limits of a shaft line in a table by load, and the load at the operating speed.
# ----------------------------------------------------------------------------

PLACE = f"{ROOT}/limit"
#: results of crankshafts that hold at every speed
MADE_OF = ("bending_factor", "torsion_factor", "bending_stress", "fatigue_strength")
#: what a limit is of -> what its results begin with where they have that unit
QUANTITIES = {"stress": "", "torque": "torque_"}


def operating_uses(setup: Setup, torque: Bounded) -> list[Bounded]:
    """Load over allowed (r,) by limit at the operating speed; own half ranges (e,) of torques."""
    at, uses, own = np.array(setup.speed), [], own_loads(setup, torque)
    for bound in bounds(setup):
        allowed = bound.modulus * bound.continuous(at)
        share = rounded(1.0 / allowed, bound.roundings)
        uses.append(of_finite(own[bound.load], share.__mul__))
    return uses


def largest_uses(uses: list[Bounded]) -> Bounded:
    """Largest (l,) of each limit."""
    return stack([one.max() for one in uses], axis=0)


def emit_operating_use(scene: Scene, setup: Setup, torque: Bounded) -> None:
    """Limits and what they are made of, with the load at the operating speed.

    Own half ranges (e,) of torques of sections.
    """
    asked, at, own = bounds(setup), np.array(setup.speed), own_loads(setup, torque)
    uses, table = operating_uses(setup, torque), LimitTable(scene, setup, asked)
    scene.emit(f"{PLACE}/operating_use", largest_uses(uses), axes=table.axes)
    if any(bound.quantity == "stress" for bound in asked):
        rated = np.array([bound.basis.rated_speed for bound in asked])
        scene.emit(f"{PLACE}/basis/rated_speed", rated, 0.0, table.axes)
        for name in ("diameter", "tensile_strength", "counted_strength", "design_factor"):
            table.emit(f"basis/{name}", [bounded(getattr(bound.basis, name)) for bound in asked])
        table.emit("basis/size_factor", [known(bound.basis.size_factor) for bound in asked])
    loads = [own[bound.load] / bound.modulus for bound in asked]
    table.emit_quantity("operating", "load", loads)
    for name, get in (("allowed", "continuous"), ("transient", "transient")):
        rows = [known(getattr(bound, get)(at), bound.roundings) for bound in asked]
        table.emit_quantity("operating", name, rows)
    table.emit("operating/use", uses)
    _crank(table, loads, "operating_acceptability")


def _crank(table: "LimitTable", loads: list[Bounded], name: str) -> None:
    """Acceptability factors of crankshafts at these stresses (r,) of each limit, as `name`.

    What they are made of stands with those at the operating speed.
    """
    limits = table.setup.torsion.limits
    if not any(one.rule == "iacs_m53" for one in limits):
        return
    from vibecalc.torsion.adapters.crank_limits import CANCELLED, Judged

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
