"""Rod, springs, gap, oils and stock of a validated case as the hardware kernels take them."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibecalc.case import absorber_hardware as parts
from vibecalc.case.absorber_fields import ICE
from vibecalc.case.schema import Machine
from vibecalc.hardware.clearance import clearance_rule
from vibecalc.hardware.gap import RingGap
from vibecalc.hardware.oils import Oil
from vibecalc.hardware.overhung_parts import EndBody, OverhungRod
from vibecalc.hardware.rods import bending_stiffness, mass_per_length
from vibecalc.hardware.spring_couple import couple_stiffness
from vibecalc.hardware.springs import largest_extension, spring_rate
from vibecalc.hardware.viscosity import Walther
from vibecalc.numerics.typing import FloatArray

#: K, of the two columns of viscosities in a catalogue of oils
_COOL, _WARM = ICE + 40.0, ICE + 100.0


class Bending(NamedTuple):
    """A rod with a body on its end, the spin of it in rad/s, and how many modes are asked for."""

    rod: OverhungRod
    body: EndBody
    spin: float
    modes: int


@dataclass(frozen=True)
class BuiltSprings:
    """Springs of an absorber in SI; `radius` is 1 for a mass that moves in a line.

    `rate` in N/m and `stiffness` of all together (N m/rad, or N/m) are None for places whose
    springs [tuning] finds, `largest_extension` in m where no stress bounds it.
    """

    count: int
    radius: float
    angle: float
    rate: float | None
    stiffness: float | None
    largest_extension: float | None


class Filling(NamedTuple):
    """The gap around the mass, its temperature in K and its oil; NaN, None where not said."""

    gap: RingGap
    temperature: float
    oil: Oil | None


class Stock(NamedTuple):
    """What can be bought: springs by name and rate (n,) in N/m, oils, and dampers by name and
    damping (d,) in N s/m, of all that act together."""

    spring_names: tuple[str, ...]
    spring_rates: FloatArray
    oils: tuple[Oil, ...]
    damper_names: tuple[str, ...]
    dampings: FloatArray


def bending(machine: Machine) -> Bending | None:
    """How the rod bends, of a machine with a flywheel."""
    rod, wheel = machine.rod, machine.flywheel
    if rod is None or wheel is None:
        return None
    if rod.elastic_modulus is None or rod.span is None or rod.total_length is None:
        raise ValueError("a rod that bends needs span, total_length and elastic_modulus")
    if rod.mass is not None:
        line = rod.mass / rod.total_length
    else:
        line = float(mass_per_length(rod.density or 0.0, rod.diameter, rod.bore).value)
    beam = OverhungRod(
        float(bending_stiffness(rod.elastic_modulus, rod.diameter, rod.bore).value),
        line,
        rod.span,
        rod.total_length - rod.span,
    )
    body = EndBody(wheel.mass, wheel.diametral_inertia, wheel.polar_inertia, wheel.offset)
    return Bending(beam, body, wheel.spin, wheel.modes)


def built_springs(machine: Machine) -> BuiltSprings | None:
    """The springs of the absorber, with their stiffness where their rate is known."""
    springs = machine.springs
    if springs is None:
        return None
    rate, longest = springs.rate, None
    wire, coil, modulus = springs.wire_diameter, springs.coil_diameter, springs.shear_modulus
    if wire is not None and coil is not None and modulus is not None and springs.turns is not None:
        rate = float(spring_rate(modulus, wire, coil, springs.turns).value)
        if springs.allowed_stress is not None:
            found = largest_extension(
                rate, wire, coil, springs.allowed_stress, springs.initial_tension
            )
            longest = float(found.value)
    radius = 1.0 if springs.radius is None else springs.radius
    whole = None
    if rate is not None:
        whole = float(couple_stiffness(rate, springs.count, radius, springs.angle).value)
    return BuiltSprings(springs.count, radius, springs.angle, rate, whole, longest)


def clearance(gap: parts.Gap) -> float:
    """Clearance at rim and sides in m: that of the case, or by the rule."""
    if gap.clearance is not None:
        return gap.clearance
    return float(clearance_rule(gap.outer_radius).value)


def filling(machine: Machine) -> Filling | None:
    """Gap and oil of the absorber."""
    gap = machine.gap
    if gap is None:
        return None
    play = clearance(gap)
    return Filling(
        RingGap(
            gap.outer_radius,
            gap.inner_radius,
            gap.width,
            play,
            play if gap.side_clearance is None else gap.side_clearance,
            math.inf if gap.bore_clearance is None else gap.bore_clearance,
        ),
        math.nan if gap.temperature is None else gap.temperature,
        None if machine.oil is None else oil_of("as built", machine.oil),
    )


def oil_of(name: str, oil: parts.Oil) -> Oil:
    """An oil of the case under a name."""
    return Oil(name, Walther(oil.temperatures, oil.viscosities), oil.density, oil.expansion)


def stock(machine: Machine) -> Stock:
    """All that can be bought: the lists of the case, then the rows of its catalogues."""
    springs = [(one.name, one.rate) for one in machine.stock_springs]
    table = machine.spring_catalogue
    if table is not None:
        springs += [(str(part), rate) for part, rate in zip(table.part, table.rate, strict=True)]
    oils = [oil_of(one.name, one) for one in machine.stock_oils]
    rows = machine.oil_catalogue
    if rows is not None:
        columns = zip(rows.part, rows.viscosity_40, rows.viscosity_100, rows.density, strict=True)
        oils += [
            Oil(str(part), Walther((_COOL, _WARM), (thick, thin)), density)
            for part, thick, thin, density in columns
        ]
    return Stock(
        tuple(name for name, _ in springs),
        np.array([rate for _, rate in springs], dtype=float),
        tuple(oils),
        tuple(one.name for one in machine.stock_dampers),
        np.array([one.count * one.linear_damping for one in machine.stock_dampers], dtype=float),
    )
