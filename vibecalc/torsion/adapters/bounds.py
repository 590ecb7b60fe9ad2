"""The limits of a case as stresses or torques allowed in sections and gears at any speeds."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, FloatArray, IntArray
from vibecalc.torsion.adapters.motion import Reading, actual_per_referred, mean_torques
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.model import ShaftLineModel
from vibecalc.torsion.stress_limits import (
    ACCEPTABILITY,
    CRANKSHAFT_KINDS,
    HIGHEST_RATIO,
    NO_BARRED_RANGE,
    SHAFT_KINDS,
    bending_stresses,
    counted_strength,
    covered,
    crank_throws,
    equivalent_stress,
    fatigue_strength,
    permissible_torsion,
    propulsion_shaft_limits,
    size_factor,
    stress_concentration,
    torsion_ratio,
)

if TYPE_CHECKING:
    from vibecalc.torsion.question_tables import StressCurve, TorqueCurve, TorsionLimit

# ----------------------------------------------------------------------------
# Adapter: the limits of a case as stresses or torques allowed in loads of the line, at any speeds.
#
# A load is a section or, behind all sections, a gear. What a limit is for is its torque over a
# modulus: a stress over the polar section modulus, a torque over one.
# ----------------------------------------------------------------------------

#: speed over the rated one at which the formula of M68 turns into a constant
CORNER_RATIO = 0.9
#: relative distance up to which two speeds are one
SAME = 1e-13
#: of what a limit allows, where nothing else is said
ROUNDINGS = 128.0


class Basis(NamedTuple):
    """What a limit is made of, by load (r,): SI; 0 where it has no such number.

    `rated_speed` in rad/s is the one that a rule counts from, 0 for a table.
    """

    diameter: FloatArray
    tensile_strength: FloatArray
    counted_strength: FloatArray
    size_factor: FloatArray
    design_factor: FloatArray
    rated_speed: float


Allowed = Callable[[FloatArray], FloatArray]


class Bound(NamedTuple):
    """One limit: the places (r,) of its loads, and what is allowed (..., r) in them at speeds.

    The `quantity` is a "stress" in Pa or a "torque" in N m, own torque over `modulus` (r,).
    `continuous` and `transient` are infinite where the limit says nothing; `transient` is None
    where it does so at every speed. `corners` (k,) are the speeds at which their slopes may jump,
    or that they end at. `formula`: a class rule, which bars a range by its formula and allows more
    in passing in one ratio at every speed. `roundings`: relative error of what is allowed.
    """

    load: IntArray
    quantity: str
    modulus: FloatArray
    continuous: Allowed
    transient: Allowed | None
    basis: Basis
    corners: FloatArray = np.zeros(0)
    formula: bool = False
    roundings: float = ROUNDINGS

    def allowed(self, course: str, speed: FloatArray | float) -> FloatArray:
        """One of both courses (..., r)."""
        at, allowed = np.asarray(speed, dtype=float), getattr(self, course)
        if allowed is None:
            return np.full((*at.shape, len(self.load)), np.inf)
        return np.asarray(allowed(at))

    def use(self, names: tuple[str, ...], course: str = "continuous", last: float = 0.0) -> Reading:
        """Load over allowed, 0 where the limit says nothing and below a `last` speed.

        `names` are those of sections, of which loads are none but these where there are no gears.
        """

        def scale(speed: FloatArray) -> FloatArray:
            share = 1.0 / (self.modulus * self.allowed(course, speed))
            return np.where(speed[:, None] >= last, share, 0.0)

        signal = "torque" if np.all(self.load < len(names)) else "load"
        return Reading(signal, self.load, "half_range", "", (), scale, self.roundings)


def bounds(setup: Setup) -> list[Bound]:
    """The limits of a case in their order."""
    return [_bound(setup, limit) for limit in setup.torsion.limits]


def limit_corners(setup: Setup) -> FloatArray:
    """Speeds at which the course of a limit has a corner or an end, or ranges may not be barred."""
    corners = [(*one.corners, NO_BARRED_RANGE * one.basis.rated_speed) for one in bounds(setup)]
    return np.concatenate([np.zeros(0), *corners])


def _bound(setup: Setup, limit: "TorsionLimit") -> Bound:
    shaft, sections = setup.shaft, len(setup.shaft.section_names)
    # an elastic gear or a damper may have the name of a shaft
    shafts = np.array(shaft.section_names[: len(shaft.throws)], dtype=object)
    named = np.flatnonzero(np.isin(shafts, limit.sections))
    gears = np.flatnonzero(np.isin([one.name for one in shaft.gears], limit.gears)) + sections
    if limit.alternating_share is not None:
        load = gears if limit.gears else np.arange(len(shaft.gears)) + sections
        return _alternating(setup, load, limit.alternating_share)
    if limit.torque is not None:
        load = np.concatenate([named, gears])
        return _table(setup, load, np.ones(len(load)), limit.torque, limit.torque.torque, "torque")
    if limit.rule == "iacs_m53":
        return _crank_rule(setup, limit)
    load = np.flatnonzero(shaft.section_modulus > 0.0)
    load = np.intersect1d(load, named) if limit.sections else load
    if limit.curve is None:
        return _class_rule(setup, limit, load)
    return _table(
        setup, load, shaft.section_modulus[load], limit.curve, limit.curve.stress, "stress"
    )


def _basis(count: int, **known: Any) -> Basis:
    """Of so many loads, with what is known."""
    none = np.zeros(count)
    return Basis(none, none, none, none, none, 0.0)._replace(**known)


def _table(
    setup: Setup,
    load: IntArray,
    modulus: FloatArray,
    curve: "StressCurve | TorqueCurve",
    lasting: tuple[float, ...],
    quantity: str,
) -> Bound:
    """Straight lines between the rows of a table."""
    nodes, basis = np.array(curve.speed), _basis(len(load))

    def allowed(values: FloatArray, speed: FloatArray) -> FloatArray:
        # an end is met to its last digits
        ends = np.isclose(speed[..., None], nodes[[0, -1]], rtol=SAME, atol=0.0)
        at = np.where(ends[..., 0], nodes[0], np.where(ends[..., 1], nodes[-1], speed))
        found = np.interp(at, nodes, values, left=np.inf, right=np.inf)
        return np.repeat(found[..., None], len(load), axis=-1)

    passing = None if curve.transient is None else partial(allowed, np.array(curve.transient))
    if quantity == "stress":
        given = setup.shaft.tensile_strength[load]
        basis = _basis(len(load), diameter=_diameters(setup.shaft, load), tensile_strength=given)
    lasts = partial(allowed, np.array(lasting))
    return Bound(load, quantity, modulus, lasts, passing, basis, nodes)


def _alternating(setup: Setup, load: IntArray, share: float) -> Bound:
    """A share of the mean torque of gears at the operating speed.

    Raises NumericalFailure where a gear carries none.
    """
    gear = load - len(setup.shaft.section_names)
    mean = mean_torques(setup, np.array([setup.speed])).gear[0] * actual_per_referred(setup.shaft)
    size, error = np.abs(mean.value)[gear], np.broadcast_to(mean.error, mean.shape)[gear]
    idle = np.flatnonzero(size <= 4.0 * error)
    if len(idle):
        name = setup.shaft.gears[gear[idle[0]]].name
        raise NumericalFailure(
            f"gear {name!r} carries no mean torque at the operating speed, of which "
            "alternating_share could be a share; give a torque over speed for it"
        )
    roundings = ROUNDINGS + float(np.max(error / size)) / EPSILON
    lasts = _level(share * size)
    ones = np.ones(len(load))
    return Bound(load, "torque", ones, lasts, None, _basis(len(load)), roundings=roundings)


def _level(most: FloatArray) -> Allowed:
    """The same (r,) at every speed."""
    return lambda speed: np.broadcast_to(most, (*speed.shape, len(most)))


def _class_rule(setup: Setup, limit: "TorsionLimit", load: IntArray) -> Bound:
    """IACS UR M68 with the operating speed as the rated one."""
    shaft = setup.shaft
    diameter, given = _diameters(shaft, load), shaft.tensile_strength[load]
    factor = limit.design_factor if limit.shaft_kind is None else SHAFT_KINDS[limit.shaft_kind]
    strength = np.where(given > 0.0, given, limit.tensile_strength or 0.0)

    def course(name: str, speed: FloatArray) -> FloatArray:
        ratio = speed[..., None] / setup.speed
        end = np.isclose(ratio, HIGHEST_RATIO, rtol=SAME, atol=0.0)
        ratio = np.where(end, HIGHEST_RATIO, ratio)
        inside = covered(ratio)
        found = propulsion_shaft_limits(np.where(inside, ratio, 1.0), strength, diameter, factor)
        return np.where(inside, getattr(found, name), np.inf)

    basis = Basis(
        diameter,
        strength,
        counted_strength(strength),
        size_factor(diameter),
        np.full(len(load), factor),
        setup.speed,
    )
    corners = setup.speed * np.array([CORNER_RATIO, HIGHEST_RATIO * (1.0 - 4.0 * EPSILON)])
    courses = partial(course, "continuous"), partial(course, "transient")
    modulus = shaft.section_modulus[load]
    return Bound(load, "stress", modulus, *courses, basis, corners, formula=True)


def _crank_rule(setup: Setup, limit: "TorsionLimit") -> Bound:
    """IACS UR M53 as a limit of the nominal torsional stress of the pin, at every speed."""
    judged = Judged(setup, limit)
    load, pin, bore = judged.load, judged.throw.pin_diameter, judged.throw.pin_bore
    known = {"diameter": pin, "tensile_strength": judged.tensile, "rated_speed": setup.speed}
    return Bound(
        load, "stress", np.pi / 16.0 * (pin**4 - bore**4) / pin, _level(judged.allowed()), None,
        _basis(len(load), **known), roundings=judged.roundings(),
    )  # fmt: skip


def _diameters(shaft: ShaftLineModel, section: IntArray) -> FloatArray:
    """Outer diameter (r,); of a section modulus alone that of the solid shaft which has it."""
    solid = np.cbrt(16.0 * shaft.section_modulus[section] / np.pi)
    given = shaft.section_diameter[section]
    return np.where(given > 0.0, given, solid)


# ----------------------------------------------------------------------------
# Adapter: the nominal torsional stress of the pin with which the worst place of a throw just keeps
# its acceptability factor, as a limit of the stress.
#
# The factor falls as that stress rises, so that a use below one is a factor above 1.15.
# ----------------------------------------------------------------------------

#: relative, of sums of many terms that cancel in stress concentration factors
CANCELLED = 4096.0


class Judged:
    """Throws (r,) of a limit: stress concentration, fatigue strength, bending and torsion."""

    def __init__(self, setup: Setup, limit: "TorsionLimit") -> None:
        shaft = setup.shaft
        names = shaft.section_names[: len(shaft.throws)]
        usable = [limit.crank or (one if one is not None and one.pin_fillet else None)
                  for one in shaft.throws]  # fmt: skip
        asked = limit.sections or [
            name for name, one in zip(names, shaft.throws, strict=True) if one and one.pin_fillet
        ]
        self.load = np.array([e for e, name in enumerate(names) if name in asked], dtype=np.int64)
        radius = float(setup.drive.geometry.crank_radius)
        self.throw = crank_throws([one for e in self.load if (one := usable[e])], radius)
        given = shaft.tensile_strength[self.load]
        self.tensile = np.where(given > 0.0, given, limit.tensile_strength or 0.0)
        self.kind_factor = CRANKSHAFT_KINDS[limit.crankshaft_kind or "free_form"]
        self.concentration = stress_concentration(self.throw)
        self.strength = fatigue_strength(self.throw, self.tensile, self.kind_factor)
        assert limit.bending is not None  # the rule needs it, says the form
        self.bending = bending_stresses(self.concentration, limit.bending)
        self.bored = np.stack(
            [*np.ones((2, len(self.load)), bool), self.throw.oil_bore > 0.0], axis=-1
        )
        #: torsional stress at the places over the nominal one of the pin
        self.torsion = self.concentration.torsion * torsion_ratio(self.throw)

    def allowed(self) -> FloatArray:
        """Nominal torsional stress (r,) of the pin with which the worst place has 1.15."""
        most = permissible_torsion(self.bending, self.strength)
        each = np.where(self.bored, most / np.where(self.bored, self.torsion, 1.0), np.inf)
        return np.asarray(np.min(each, axis=-1))

    def roundings(self) -> float:
        """Relative error of what is allowed, in units of rounding: bending is taken off."""
        most = self.strength / ACCEPTABILITY
        near = most / np.maximum(most - self.bending, 1e-9 * most)
        return CANCELLED * float(np.max(near, initial=1.0))

    def made_of(self, name: str) -> FloatArray:
        """What the factors come from (r, 3), by the names of the results."""
        parts = {
            "bending_factor": self.concentration.bending,
            "torsion_factor": self.concentration.torsion,
            "bending_stress": self.bending,
            "fatigue_strength": self.strength,
        }
        return parts[name]

    def acceptability(self, stress: Bounded) -> Bounded:
        """Q (r, 3) for nominal torsional stresses (r,) of the pin; 0 where nothing bounds them."""
        endless = ~np.isfinite(stress.value)
        size = np.where(endless, 0.0, stress.value)[:, None]
        error = np.broadcast_to(stress.error, stress.shape)[:, None]

        def factor(torsion: FloatArray) -> FloatArray:
            found = equivalent_stress(self.bending, self.torsion * torsion)
            some = (found > 0.0) & self.bored & ~endless[:, None]
            return np.where(some, self.strength / np.where(some, found, 1.0), 0.0)

        value = factor(size)
        low, high = factor(size + error), factor(np.maximum(size - error, 0.0))
        moved = np.maximum(np.abs(value - low), np.abs(high - value))
        return Bounded(value, moved + CANCELLED * UNIT_ROUNDOFF * value)
