"""Stresses of a shaft line against the limits of a case, over the range and at operating speed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, bounded, rounded, stack, where
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, IntArray
from vibecalc.torsion.adapters.critical import UndampedResonances
from vibecalc.torsion.adapters.curves import of_finite, section_uncertainty
from vibecalc.torsion.adapters.exceeded import Bound, bounds, emit_barred, exceeded_of
from vibecalc.torsion.adapters.maxima import DenseSweep, torque_value
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.critical_speeds import Maxima, Value, largest
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: stresses of a shaft line against the limits of a case, and ranges to be barred.
#
# What a limit says is informative: `hardware/shaft_rules.py` has edition and scope of each rule.
# ----------------------------------------------------------------------------


class Uses(NamedTuple):
    """Of one limit: stress over allowed (s, r) at the speeds, the largest of each section."""

    curve: FloatArray
    top: Maxima
    make: Callable[[IntArray], Value]


def per_torque(setup: Setup) -> FloatArray:
    """Own stress over referred torque (e,) in 1/m^3, 0 for sections without a modulus."""
    modulus = setup.shaft.section_modulus
    factor = 1.0 / np.where(modulus > 0.0, modulus, np.inf)
    return np.asarray(factor / np.abs(setup.shaft.section_ratio))


def limit_levels(setup: Setup, speed: FloatArray, torque: FloatArray) -> tuple[FloatArray, ...]:
    """Referred torques (s, e) of each limit that would be a new largest use, or break it.

    `torque` (s, e) is what a sweep has seen; infinite where a limit says nothing.
    """
    factor = per_torque(setup)
    levels = []
    for bound in bounds(setup):
        section = bound.section
        allowed = bound.continuous(speed) / factor[section]
        says = np.isfinite(allowed)
        some = np.where(says, allowed, 1.0)
        use = np.where(says, torque[:, section] / some, 0.0)
        level = np.full_like(torque, np.inf)
        level[:, section] = np.where(says, some * np.minimum(np.max(use, axis=0), 1.0), np.inf)
        levels.append(level)
    return tuple(levels)


def limit_corners(setup: Setup, speed: FloatArray) -> FloatArray:
    """Speeds inside a range at which the course of a limit has a corner or an end."""
    every = np.concatenate([bound.corners for bound in bounds(setup)])
    return np.asarray(every[(every > speed[0]) & (every < speed[-1])])


def uses_of(setup: Setup, bound: Bound, dense: DenseSweep, undamped: UndampedResonances) -> Uses:
    """From referred half ranges of torques."""
    speed, torque = dense
    factor, section = per_torque(setup), bound.section
    limit = bound.continuous(speed)
    use = np.where(np.isfinite(limit), torque[:, section] * factor[section] / limit, 0.0)
    make = _use_of(setup, bound, factor)
    top = largest(make, use, speed, undamped.speed, _inside(bound, undamped.endless[section]))
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
    row = np.arange(len(bound.section))
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
    asked, factor = bounds(setup), per_torque(setup)
    uses = [uses_of(setup, bound, dense, undamped) for bound in asked]
    each = [largest_of_sections(setup, bound, one) for bound, one in zip(asked, uses, strict=True)]
    _worst(scene, asked, each, speed)
    table = LimitTable(scene, setup, asked)
    for name in LargestUse._fields:
        table.emit(f"each/{name}", [getattr(one, name) for one in each])
    rated = [bound.basis.rated_speed or np.inf for bound in asked]
    ratios = [one.speed * rounded(1.0 / by, ROUNDINGS) for one, by in zip(each, rated, strict=True)]
    table.emit("each/speed_ratio", ratios)
    ranges = [
        exceeded_of(
            *(setup, bound, one.curve, one.top, one.make, dense.speed, undamped.speed),
            factor[bound.section],
        )
        for bound, one in zip(asked, uses, strict=True)
    ]
    emit_barred(scene, ranges)


class LargestUse(NamedTuple):
    """Of one limit, by section (r,): the largest use, its speed, stress and limits there.

    Infinite where nothing damps an order, and limits where they say nothing.
    """

    use: Bounded
    speed: Bounded
    stress: Bounded
    allowed: Bounded
    transient: Bounded
    transient_use: Bounded


def stress_uncertainty(setup: Setup, bound: Bound, top: Maxima) -> FloatArray:
    """Errors (r,) of the stresses at the largest uses of a limit."""
    torque = section_uncertainty(setup, top.speed, bound.section)[1]
    return np.asarray(torque * per_torque(setup)[bound.section])


def largest_of_sections(setup: Setup, bound: Bound, uses: Uses) -> LargestUse:
    """Of all sections of a limit, with the errors."""
    top = uses.top
    row = np.arange(len(top.speed))
    allowed, transient = (
        known(limit_at(top.speed)[row, row]) for limit_at in (bound.continuous, bound.transient)
    )
    says, passes = np.isfinite(allowed.value), np.isfinite(transient.value)
    safe = where(says, allowed, 1.0)
    steps = np.array([bound.continuous(top.speed + s * top.speed_error)[row, row] for s in (-1, 1)])
    steps = np.where(np.isfinite(steps), steps, safe.value)
    moved = np.where(says, np.max(np.abs(steps - safe.value), axis=0), 0.0)
    off = np.where(says, stress_uncertainty(setup, bound, top) / safe.value, 0.0)
    use = Bounded(top.value, off + top.value_error + ROUNDINGS * UNIT_ROUNDOFF)
    there = Bounded(safe.value, moved + safe.error)
    # the two limits of a rule have one course, so that the largest use of both is in one place
    passing = np.where(passes, np.where(passes, transient.value, 0.0) / safe.value, 0.0)
    ruled = passing > 0.0
    through = of_finite(use, lambda one: one / np.where(ruled, passing, 1.0))
    return LargestUse(
        use=use,
        speed=Bounded(top.speed, top.speed_error + 8.0 * UNIT_ROUNDOFF * top.speed),
        stress=of_finite(where(says, use, 0.0), lambda one: one * there),
        allowed=Bounded(allowed.value, moved + allowed.error),
        transient=Bounded(transient.value, moved * passing + transient.error),
        transient_use=where(ruled, through, 0.0),
    )


def _worst(scene: Scene, asked: list[Bound], each: list[LargestUse], speed: FloatArray) -> None:
    """Largest use of each limit, and the course of the limit in the section that has it."""
    place = [int(np.argmax(one.use.value)) for one in each]
    axes = {"limit": np.arange(1, len(each) + 1), "speed": speed}
    both = list(zip(asked, place, strict=True))
    allowed = np.array([bound.continuous(speed)[:, worst] for bound, worst in both])
    passing = np.array([bound.transient(speed)[:, worst] for bound, worst in both])
    scene.emit(f"{PLACE}/allowed", known(allowed), axes=axes)
    scene.emit(f"{PLACE}/transient", known(passing), axes=axes)
    use, at = (
        stack([getattr(one, name)[worst] for one, worst in zip(each, place, strict=True)], axis=0)
        for name in ("use", "speed")
    )
    section = np.array([bound.section[worst] + 1 for bound, worst in both], dtype=np.int64)
    through = np.array([np.max(one.transient_use.value) for one in each])
    scene.emit(f"{PLACE}/largest_use", use, axes=axes)
    scene.emit(f"{PLACE}/speed", at, axes=axes)
    scene.emit(f"{PLACE}/section", section, 0.0, axes)
    scene.emit(f"{PLACE}/transient_use", through, use.error, axes)


def _inside(bound: Bound, endless: FloatArray) -> FloatArray:
    """Endless speeds (r,) at which the limit says something, else NaN."""
    known = ~np.isnan(endless)
    says = bound.continuous(np.where(known, endless, 0.0))
    row = np.arange(len(endless))
    return np.where(known & np.isfinite(says[row, row]), endless, np.nan)


def _use_of(setup: Setup, bound: Bound, factor: FloatArray) -> Callable[[IntArray], Value]:
    """Stress over allowed of places among the sections of a limit."""

    def make(place: IntArray) -> Value:
        torque = torque_value(setup.model, setup.drive, bound.section[place])
        share = factor[bound.section[place]][:, None]

        def value(speed: FloatArray) -> FloatArray:
            limit = bound.continuous(speed)
            at_place = np.take_along_axis(limit, place[:, None, None], axis=2)[..., 0]
            return np.where(np.isfinite(at_place), torque(speed) * share / at_place, 0.0)

        return value

    return make


# ----------------------------------------------------------------------------
# Adapter: limits of a shaft line in a table by section, and the stress at the operating speed.
# ----------------------------------------------------------------------------

PLACE = f"{ROOT}/limit"
ROUNDINGS = 128.0


def operating_uses(setup: Setup, torque: Bounded) -> list[Bounded]:
    """Stress over allowed (r,) by limit at the operating speed; own half ranges (e,) of torques."""
    modulus, at, uses = setup.shaft.section_modulus, np.array(setup.speed), []
    for bound in bounds(setup):
        allowed = modulus[bound.section] * bound.continuous(at)
        share = rounded(1.0 / allowed, ROUNDINGS)
        uses.append(of_finite(torque[bound.section], share.__mul__))
    return uses


def largest_uses(uses: list[Bounded]) -> Bounded:
    """Largest (l,) of each limit."""
    return stack([one.max() for one in uses], axis=0)


def emit_operating_use(scene: Scene, setup: Setup, torque: Bounded) -> None:
    """Limits and what they are made of, with the stress at the operating speed.

    Own half ranges (e,) of torques.
    """
    asked, at = bounds(setup), np.array(setup.speed)
    modulus = setup.shaft.section_modulus
    uses, table = operating_uses(setup, torque), LimitTable(scene, setup, asked)
    scene.emit(f"{PLACE}/operating_use", largest_uses(uses), axes=table.axes)
    rated = np.array([bound.basis.rated_speed for bound in asked])
    scene.emit(f"{PLACE}/basis/rated_speed", rated, 0.0, table.axes)
    for name in ("diameter", "tensile_strength", "counted_strength", "design_factor"):
        table.emit(f"basis/{name}", [bounded(getattr(bound.basis, name)) for bound in asked])
    table.emit("basis/size_factor", [known(bound.basis.size_factor) for bound in asked])
    stress = [torque[bound.section] / modulus[bound.section] for bound in asked]
    table.emit("operating/stress", stress)
    table.emit("operating/allowed", [known(bound.continuous(at)) for bound in asked])
    table.emit("operating/transient", [known(bound.transient(at)) for bound in asked])
    table.emit("operating/use", uses)


def known(value: FloatArray) -> Bounded:
    """What a limit says, with its rounding; infinite where it says nothing."""
    return Bounded(value, rounded(np.where(np.isfinite(value), value, 0.0), ROUNDINGS).error)


class LimitTable:
    """Emits values by limit and section; columns are the sections that some limit is for."""

    def __init__(self, scene: Scene, setup: Setup, asked: list[Bound]) -> None:
        self.scene, self.places = scene, [bound.section for bound in asked]
        self.columns = np.flatnonzero(np.bincount(np.concatenate(self.places)))
        names = tuple(setup.shaft.section_names[e] for e in self.columns)
        self.axes = {"limit": np.arange(1, len(asked) + 1), "section": names}

    def emit(self, path: str, rows: list[Bounded]) -> None:
        """Rows (r,) of each limit."""
        values = self._filled([one.value for one in rows])
        errors = self._filled([np.broadcast_to(one.error, one.shape) for one in rows])
        self.scene.emit(f"{PLACE}/{path}", values, errors, self.axes)

    def _filled(self, rows: list[FloatArray]) -> FloatArray:
        found = np.zeros((len(rows), len(self.columns)))
        for line, place, row in zip(found, self.places, rows, strict=True):
            line[np.searchsorted(self.columns, place)] = row
        return found
