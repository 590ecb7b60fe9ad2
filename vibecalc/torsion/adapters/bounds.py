"""The limits of a case as stresses or torques allowed in sections and gears at any speeds."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.adapters.curves import actual_per_referred, mean_torques
from vibecalc.torsion.adapters.loads import load_ratios
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.model import ShaftLineModel
from vibecalc.torsion.stress_limits import (
    HIGHEST_RATIO,
    SHAFT_KINDS,
    counted_strength,
    covered,
    propulsion_shaft_limits,
    size_factor,
)

if TYPE_CHECKING:
    from vibecalc.torsion.limit_tables import StressCurve, TorqueCurve, TorsionLimit

# ----------------------------------------------------------------------------
# Adapter: the limits of a case as stresses or torques allowed in loads of the line, at any speeds.
#
# A load is a section or, behind all sections, a gear. What a limit is for is its torque over a
# modulus: a stress over the polar section modulus, a torque over one.
# ----------------------------------------------------------------------------

#: speed over the rated one at which the formula of M68 turns into a constant
CORNER_RATIO = 0.9
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

    The `quantity` is a "stress" in Pa or a "torque" in N m: own torque over `modulus` (r,), or
    referred one times `factor` (r,). `continuous` and `transient` are infinite where the limit says
    nothing; `alike`: both have one course. `corners` (k,) are the speeds at which their slopes may
    jump, or that they end at. `formula`: the rule bars a range by its formula. `roundings`:
    relative error of what is allowed, in units of rounding.
    """

    load: IntArray
    quantity: str
    modulus: FloatArray
    factor: FloatArray
    continuous: Allowed
    transient: Allowed
    basis: Basis
    corners: FloatArray
    alike: bool = True
    formula: bool = False
    roundings: float = ROUNDINGS


def bounds(setup: Setup) -> list[Bound]:
    """The limits of a case in their order."""
    return [_bound(setup, limit) for limit in setup.torsion.limits]


def _bound(setup: Setup, limit: "TorsionLimit") -> Bound:
    if limit.alternating_share is not None:
        return _alternating(setup, limit, limit.alternating_share)
    if limit.torque is not None:
        load = np.concatenate([_sections(setup, limit), _gears(setup, limit)])
        return _table(setup, load, np.ones(len(load)), limit.torque, limit.torque.torque, "torque")
    if limit.rule == "iacs_m53":
        return _crank_rule(setup, limit)
    load = np.flatnonzero(setup.shaft.section_modulus > 0.0)
    if limit.sections:
        load = np.intersect1d(load, _sections(setup, limit))
    if limit.curve is None:
        return _class_rule(setup, limit, load)
    modulus = setup.shaft.section_modulus[load]
    return _table(setup, load, modulus, limit.curve, limit.curve.stress, "stress")


def _sections(setup: Setup, limit: "TorsionLimit") -> IntArray:
    names = np.array(setup.shaft.section_names, dtype=object)
    # an elastic gear or a damper may have the name of a shaft
    shafts = np.arange(len(names)) < len(setup.shaft.throws)
    return np.flatnonzero(np.isin(names, limit.sections) & shafts)


def _gears(setup: Setup, limit: "TorsionLimit") -> IntArray:
    names = [one.name for one in setup.shaft.gears]
    chosen = np.isin(np.array(names, dtype=object), limit.gears)
    return np.flatnonzero(chosen) + len(setup.shaft.section_names)


def made(
    setup: Setup,
    load: IntArray,
    modulus: FloatArray,
    quantity: str,
    continuous: Allowed,
    transient: Allowed | None = None,
) -> Bound:
    """A limit of loads (r,) without a basis."""
    none = np.zeros(len(load))
    return Bound(
        load,
        quantity,
        modulus,
        1.0 / (modulus * load_ratios(setup.shaft)[load]),
        continuous,
        transient or (lambda speed: np.full((*speed.shape, len(load)), np.inf)),
        Basis(none, none, none, none, none, 0.0),
        np.zeros(0),
    )


def _table(
    setup: Setup,
    load: IntArray,
    modulus: FloatArray,
    curve: "StressCurve | TorqueCurve",
    lasting: tuple[float, ...],
    quantity: str,
) -> Bound:
    """Straight lines between the rows of a table."""
    nodes = np.array(curve.speed)

    def allowed(values: FloatArray, speed: FloatArray) -> FloatArray:
        found = np.interp(speed, nodes, values, left=np.inf, right=np.inf)
        return np.repeat(found[..., None], len(load), axis=-1)

    passing = None if curve.transient is None else partial(allowed, np.array(curve.transient))
    bound = made(setup, load, modulus, quantity, partial(allowed, np.array(lasting)), passing)
    shaft = setup.shaft
    inside = load[load < len(shaft.section_names)]
    diameter = np.zeros(len(load))
    if quantity == "stress":
        diameter[: len(inside)] = _diameters(shaft, inside)
        given = shaft.tensile_strength[load]
        basis = bound.basis._replace(diameter=diameter, tensile_strength=given)
        bound = bound._replace(basis=basis)
    return bound._replace(corners=nodes, alike=curve.transient is None)


def _alternating(setup: Setup, limit: "TorsionLimit", share: float) -> Bound:
    """A share of the mean torque of gears at the operating speed.

    Raises NumericalFailure where a gear carries none.
    """
    first = len(setup.shaft.section_names)
    load = _gears(setup, limit) if limit.gears else np.arange(len(setup.shaft.gears)) + first
    gear = load - first
    mean = mean_torques(setup, np.array([setup.speed])).gear[0] * actual_per_referred(setup.shaft)
    size, error = np.abs(mean.value)[gear], np.broadcast_to(mean.error, mean.shape)[gear]
    idle = np.flatnonzero(size <= 4.0 * error)
    if len(idle):
        name = setup.shaft.gears[gear[idle[0]]].name
        raise NumericalFailure(
            f"gear {name!r} carries no mean torque at the operating speed, of which "
            "alternating_share could be a share; give a torque over speed for it"
        )
    level = share * size
    bound = made(
        setup,
        load,
        np.ones(len(load)),
        "torque",
        lambda speed: np.broadcast_to(level, (*speed.shape, len(load))),
    )
    return bound._replace(roundings=ROUNDINGS + float(np.max(error / size)) / EPSILON)


def _class_rule(setup: Setup, limit: "TorsionLimit", load: IntArray) -> Bound:
    """IACS UR M68 with the operating speed as the rated one."""
    shaft = setup.shaft
    diameter, given = _diameters(shaft, load), shaft.tensile_strength[load]
    factor = limit.design_factor if limit.shaft_kind is None else SHAFT_KINDS[limit.shaft_kind]
    strength = np.where(given > 0.0, given, limit.tensile_strength or 0.0)

    def both(speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        ratio = speed[..., None] / setup.speed
        inside = covered(ratio)
        found = propulsion_shaft_limits(np.where(inside, ratio, 1.0), strength, diameter, factor)
        steady = np.where(inside, found.continuous, np.inf)
        passing = np.where(inside, found.transient, np.inf)
        return steady, passing

    basis = Basis(
        diameter,
        strength,
        counted_strength(strength),
        size_factor(diameter),
        np.full(len(load), factor),
        setup.speed,
    )
    highest = HIGHEST_RATIO * setup.speed * (1.0 - 4.0 * EPSILON)
    bound = made(
        setup,
        load,
        shaft.section_modulus[load],
        "stress",
        lambda speed: both(speed)[0],
        lambda speed: both(speed)[1],
    )
    corners = np.array([CORNER_RATIO * setup.speed, highest])
    return bound._replace(basis=basis, corners=corners, formula=True)


def _crank_rule(setup: Setup, limit: "TorsionLimit") -> Bound:
    """IACS UR M53 as a limit of the nominal torsional stress of the pin, at every speed."""
    from vibecalc.torsion.adapters.crank_limits import Judged

    judged = Judged(setup, limit)
    level, throw = judged.allowed(), judged.throw
    bound = made(
        setup,
        judged.load,
        np.pi / 16.0 * (throw.pin_diameter**4 - throw.pin_bore**4) / throw.pin_diameter,
        "stress",
        lambda speed: np.broadcast_to(level, (*speed.shape, len(level))),
    )
    basis = bound.basis._replace(
        diameter=throw.pin_diameter, tensile_strength=judged.tensile, rated_speed=setup.speed
    )
    return bound._replace(basis=basis, roundings=judged.roundings())


def _diameters(shaft: ShaftLineModel, section: IntArray) -> FloatArray:
    """Outer diameter (r,); of a section modulus alone that of the solid shaft which has it."""
    solid = np.cbrt(16.0 * shaft.section_modulus[section] / np.pi)
    given = shaft.section_diameter[section]
    return np.where(given > 0.0, given, solid)
