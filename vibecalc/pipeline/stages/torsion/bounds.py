"""Adapter: the limits of a case as stresses allowed in sections of the line at any speeds."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.case.torsion_tables import TorsionLimit
from vibecalc.hardware.shaft_limits import (
    HIGHEST_RATIO,
    counted_strength,
    covered,
    propulsion_shaft_limits,
    size_factor,
)
from vibecalc.machine.shaft_line import ShaftLine
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.setup import Setup

#: speed over the rated one at which the formula of M68 turns into a constant
CORNER_RATIO = 0.9


class Basis(NamedTuple):
    """What a limit is made of, by section (r,): SI; 0 where it has no such number.

    `rated_speed` in rad/s is the one that a rule counts from, 0 for a table.
    """

    diameter: FloatArray
    tensile_strength: FloatArray
    counted_strength: FloatArray
    size_factor: FloatArray
    design_factor: FloatArray
    rated_speed: float


class Bound(NamedTuple):
    """One limit: the places (r,) of its sections, and stresses (..., r) in Pa allowed at speeds.

    `continuous` and `transient` are infinite where the limit says nothing: outside of `scope`,
    two speeds. `corners` (k,) are the speeds at which their slopes may jump.
    """

    section: IntArray
    continuous: Callable[[FloatArray], FloatArray]
    transient: Callable[[FloatArray], FloatArray]
    basis: Basis
    scope: tuple[float, float]
    corners: FloatArray


def bounds(setup: Setup) -> list[Bound]:
    """The limits of a case in their order."""
    return [_bound(setup, limit) for limit in setup.torsion.limits]


def _bound(setup: Setup, limit: TorsionLimit) -> Bound:
    shaft = setup.shaft
    names = np.array(shaft.section_names, dtype=object)
    chosen = np.isin(names, limit.sections) if limit.sections else np.ones(len(names), bool)
    section = np.flatnonzero(chosen & (shaft.section_modulus > 0.0))
    diameter, strength = _diameters(shaft, section), shaft.tensile_strength[section]
    if limit.curve is None:
        return _class_rule(setup, limit, section, diameter, strength)
    nodes, values = np.array(limit.curve.speed), np.array(limit.curve.stress)

    def course(speed: FloatArray) -> FloatArray:
        found = np.interp(speed, nodes, values, left=np.inf, right=np.inf)
        return np.repeat(found[..., None], len(section), axis=-1)

    none = np.zeros(len(section))
    return Bound(
        section,
        course,
        lambda speed: np.full((*speed.shape, len(section)), np.inf),
        Basis(diameter, strength, none, none, none, 0.0),
        (float(nodes[0]), float(nodes[-1])),
        nodes,
    )


def _class_rule(
    setup: Setup,
    limit: TorsionLimit,
    section: IntArray,
    diameter: FloatArray,
    given: FloatArray,
) -> Bound:
    """IACS UR M68 with the operating speed as the rated one."""
    factor = limit.design_factor
    strength = np.where(given > 0.0, given, limit.tensile_strength or 0.0)

    def both(speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        ratio = speed[..., None] / setup.speed
        inside = covered(ratio)
        found = propulsion_shaft_limits(np.where(inside, ratio, 1.0), strength, diameter)
        steady = np.where(inside, found.continuous * factor, np.inf)
        passing = np.where(inside, found.transient * np.sqrt(factor), np.inf)
        return steady, passing

    basis = Basis(
        diameter,
        strength,
        counted_strength(strength),
        size_factor(diameter),
        np.full(len(section), factor),
        setup.speed,
    )
    highest = HIGHEST_RATIO * setup.speed * (1.0 - 4.0 * EPSILON)
    return Bound(
        section,
        lambda speed: both(speed)[0],
        lambda speed: both(speed)[1],
        basis,
        (0.0, highest),
        np.array([CORNER_RATIO * setup.speed, highest]),
    )


def _diameters(shaft: ShaftLine, section: IntArray) -> FloatArray:
    """Outer diameter (r,); of a section modulus alone that of the solid shaft which has it."""
    solid = np.cbrt(16.0 * shaft.section_modulus[section] / np.pi)
    given = shaft.section_diameter[section]
    return np.where(given > 0.0, given, solid)
