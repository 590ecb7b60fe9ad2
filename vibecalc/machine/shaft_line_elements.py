"""Inertias of stations, and what lies between them, each at its own speed, from a case."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts as train_parts
from vibecalc.case.shaft_parts import Section, Shaft, ShaftLine, Throw
from vibecalc.hardware.crank_stiffness import Throw as Dimensions
from vibecalc.hardware.crank_stiffness import throw_stiffness
from vibecalc.hardware.crank_throw import (
    disc_ended_web_inertia,
    journal_inertia,
    offset_body_inertia,
    pin_inertia,
    reciprocating_inertia,
    rectangular_web_inertia,
    throw_inertia,
)
from vibecalc.hardware.shaft_section import section_modulus, shaft_stiffness
from vibecalc.machine.crank_train import CrankTrain
from vibecalc.machine.shaft_line_graph import shaft_ends


class Element(NamedTuple):
    """One elastic element between the stations `first` and `second`, on the shaft of the first.

    Stiffness in N m/rad (with `speed_stiffness` per (rad/s)^2 of that shaft), damping in N m s/rad,
    polar section modulus in m^3, lengths in m; 0 where the case does not say it.
    """

    name: str
    kind: str
    first: int
    second: int
    stiffness: float
    damping: float = 0.0
    loss_factor: float = 0.0
    speed_stiffness: float = 0.0
    section_modulus: float = 0.0
    diameter: float = 0.0
    bore: float = 0.0
    tensile_strength: float = 0.0


class HungElement(NamedTuple):
    """A damper: its element, whose second end is its ring, and the inertia of the ring."""

    element: Element
    kind: str
    inertia: float


def station_inertia(
    line: ShaftLine, given: train_parts.CrankTrain, train: CrankTrain
) -> list[float]:
    """Inertia of each station at its own speed, kg m^2, given or of its throw."""
    found = []
    for station in line.stations:
        names = [n for n in (station.cylinder, *station.cylinders) if n is not None]
        inertia = station.inertia
        if inertia is None:
            assert station.throw is not None  # one of the two, says the form
            inertia = _of_throw(station.throw, given, train, names)
        found.append(inertia)
    return found


def _of_throw(
    throw: Throw, given: train_parts.CrankTrain, train: CrankTrain, names: Sequence[str]
) -> float:
    """Metal of the throw, rotating masses on its pin, reciprocating ones as their mean."""
    radius, density = given.crank_radius, throw.density
    if throw.beyond_journal is not None and throw.beyond_pin is not None:
        ends = (throw.beyond_journal, throw.beyond_pin)
        web = rectangular_web_inertia(density, throw.web_thickness, throw.web_width, *ends, radius)
    else:
        web = disc_ended_web_inertia(density, throw.web_thickness, throw.web_width, radius)
    places = [train.names.index(name) for name in names]
    turning = float(sum(train.rotating_mass[places]))
    sliding = float(sum(train.reciprocating_mass[places]))
    total = throw_inertia(
        journal_inertia(density, throw.journal_diameter, throw.journal_length, throw.journal_bore),
        pin_inertia(density, throw.pin_diameter, throw.pin_length, radius, throw.pin_bore),
        web,
        web,
        offset_body_inertia(turning, radius),
        reciprocating_inertia(sliding, radius, given.rod_length),
    )
    return float(total.value) + throw.balance_weight_inertia


def shaft_elements(
    line: ShaftLine,
    given: train_parts.CrankTrain,
    at: Mapping[str, int],
    inertia: Sequence[float] | NDArray[np.float64],
) -> list[Element]:
    """All shafts; a damping ratio is that of the two neighbours against each other alone."""
    found = []
    for shaft, (first, second) in zip(line.shafts, shaft_ends(line), strict=True):
        stiffness = _stiffness(shaft, given.crank_radius)
        damping = shaft.damping or 0.0
        if shaft.damping_ratio:
            one, other = float(inertia[at[first]]), float(inertia[at[second]])
            both = one * other / (one + other) if one + other > 0.0 else 0.0
            damping = 2.0 * shaft.damping_ratio * math.sqrt(stiffness * both)
        outer, bore = _diameters(shaft)
        modulus = shaft.section_modulus or (
            float(section_modulus(outer, bore).value) if outer else 0.0
        )
        found.append(
            Element(
                name=shaft.name or f"{first} - {second}",
                kind="shaft",
                first=at[first],
                second=at[second],
                stiffness=stiffness,
                damping=damping,
                loss_factor=shaft.loss_factor,
                section_modulus=modulus,
                diameter=outer,
                bore=bore,
                tensile_strength=shaft.tensile_strength or 0.0,
            )
        )
    return found


def _stiffness(shaft: Shaft, crank_radius: float) -> float:
    if shaft.stiffness is not None:
        return shaft.stiffness
    if shaft.section is not None:
        part = shaft.section
        ends = (part.end_outer_diameter, part.end_inner_diameter)
        plain = (part.shear_modulus, part.length, part.outer_diameter, part.inner_diameter)
        return float(shaft_stiffness(*plain, *ends).value)
    throw = shaft.throw
    assert throw is not None  # one of the three, says the form
    modulus = np.asarray(throw.shear_modulus)
    return float(throw_stiffness(throw_dimensions(throw, crank_radius), modulus, throw.formula)[0])


def throw_dimensions(throw: Throw, crank_radius: float) -> Dimensions:
    """What the formulas for the stiffness of a throw want to know."""
    keys = (
        *("journal_length", "journal_diameter", "journal_bore", "pin_length", "pin_diameter"),
        *("pin_bore", "web_thickness", "web_width"),
    )
    lengths = {key: np.asarray(getattr(throw, key)) for key in keys}
    return Dimensions(**lengths, crank_radius=np.asarray(crank_radius))


def _diameters(shaft: Shaft) -> tuple[float, float]:
    """Outer and inner diameter where the stress is read; the journal of a throw; 0 for none."""
    if shaft.diameter is not None:
        return shaft.diameter, 0.0
    if shaft.section_modulus is not None:
        return 0.0, 0.0
    if shaft.section is not None:
        # of a cone, at the end where the stress is larger
        return min(section_ends(shaft.section), key=lambda end: section_modulus(*end).value)
    if shaft.throw is not None:
        return shaft.throw.journal_diameter, shaft.throw.journal_bore
    return 0.0, 0.0


def section_ends(section: Section) -> tuple[tuple[float, float], tuple[float, float]]:
    """Outer and inner diameter at both ends of a shaft."""
    outer, inner = section.outer_diameter, section.inner_diameter
    last, bore = section.end_outer_diameter, section.end_inner_diameter
    return (outer, inner), (outer if last is None else last, inner if bore is None else bore)


def gear_elements(line: ShaftLine, at: Mapping[str, int]) -> list[Element]:
    """Gears with elastic teeth: k R^2 on the shaft of the first wheel."""
    return [
        Element(
            name=gear.name or " - ".join(gear.between),
            kind="mesh",
            first=at[gear.between[0]],
            second=at[gear.between[1]],
            stiffness=gear.mesh_stiffness * (gear.pitch_radius or 0.0) ** 2,
        )
        for gear in line.gears
        if gear.mesh_stiffness is not None
    ]


def damper_elements(line: ShaftLine, at: Mapping[str, int]) -> list[HungElement]:
    """Dampers, with pendulums as the ring and the spring that they are equal to.

    A pendulum of mass m on an arm of length r at the radius R swings in the field of the rotation.
    With the angle theta + s r / (R + r) of its mass about the axis (s its swing) it is a ring of
    inertia m (R + r)^2 on a spring of m (R + r)^2 n^2 w^2, n^2 = R / r, at the speed w.
    """
    found = []
    for one in line.dampers:
        inertia, spring = one.inertia or 0.0, 0.0
        if one.order is not None and one.mass is not None and one.arm_radius is not None:
            reach = one.arm_radius * (1.0 + 1.0 / one.order**2)
            inertia = one.count * one.mass * reach**2
            spring = inertia * one.order**2
        element = Element(
            name=one.name,
            kind="damper",
            first=at[one.on],
            second=-1,
            stiffness=one.stiffness or 0.0,
            damping=one.damping,
            loss_factor=one.loss_factor,
            speed_stiffness=spring,
        )
        found.append(HungElement(element, one.kind, inertia))
    return found
