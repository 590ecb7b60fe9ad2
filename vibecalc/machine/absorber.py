"""A primary system, its absorbers and their parts as the kernels take them."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.case.absorber_parts import NamedSecondary, Primary, Secondary
from vibecalc.case.schema import Case, Machine
from vibecalc.hardware.oils import oil_damping
from vibecalc.hardware.rings import ring_inertia
from vibecalc.hardware.rods import torsional_stiffness
from vibecalc.machine.absorber_hardware import (
    Bending,
    BuiltSprings,
    Filling,
    Stock,
    bending,
    built_springs,
    filling,
    stock,
)

if TYPE_CHECKING:
    from vibecalc.response.absorber.model import Absorber

#: name of the primary where secondaries say what carries them
PRIMARY = "primary"


class Scale(NamedTuple):
    """What ratios are relative to: kg m^2 and N m/rad in torsion, kg and N/m in translation."""

    inertia: float
    stiffness: float
    torsion: bool

    @property
    def frequency(self) -> float:
        """w1 = sqrt(K1 / J1) in rad/s."""
        return math.sqrt(self.stiffness / self.inertia)

    @property
    def damping(self) -> float:
        """2 sqrt(K1 J1): a damping over it is a ratio referred to the primary."""
        return 2.0 * math.sqrt(self.stiffness) * math.sqrt(self.inertia)


class Branch(NamedTuple):
    """One of several absorbers, in ratios to the primary; None is what [tuning] finds.

    `carrier` is the position of what carries it, before its own, -1 for the primary.
    """

    name: str
    carrier: int
    mass_ratio: float
    stiffness_ratio: float | None
    secondary_damping: float | None


@dataclass(frozen=True, kw_only=True)
class AbsorberParts:
    """A primary system with one absorber, or with several in `branches`.

    `absorber` holds the ratios as given or as built of springs and oil; its spring or damper is
    NaN where the case says none, and [tuning] finds it. `scale` is None for ratios alone.
    """

    primary_damping: float
    scale: Scale | None
    absorber: "Absorber | None"
    branches: tuple[Branch, ...]
    bending: Bending | None
    springs: BuiltSprings | None
    filling: Filling | None
    stock: Stock

    @property
    def is_complete(self) -> bool:
        """Whether one absorber has both spring and damper, so that its response is known."""
        one = self.absorber
        if one is None:
            return False
        found = np.isnan(np.asarray(one.stiffness_ratio)) | np.isnan(one.secondary_damping)
        return not bool(found)


def build_absorber(case: Case) -> AbsorberParts:
    """Ratios and parts of a case with a primary system.

    Raises ValueError for a case without one, which the checks refuse, and NumericalFailure as the
    viscosity line and the gap do, which they refuse, too.
    """
    machine = case.machine
    primary = machine.primary
    if primary is None:
        raise ValueError("an absorber needs a primary system")
    scale = primary_scale(machine)
    return AbsorberParts(
        primary_damping=primary_damping(primary, scale),
        scale=scale,
        absorber=single_absorber(machine),
        branches=_branches(machine.secondaries, scale),
        bending=bending(machine),
        springs=built_springs(machine),
        filling=filling(machine),
        stock=stock(machine),
    )


def single_absorber(machine: Machine) -> "Absorber | None":
    """The ratios of [machine.secondary], or of a ring alone, as given or as built."""
    one = machine.secondary
    if one is None and machine.ring is not None:
        one = Secondary()
    if one is None or machine.primary is None:
        return None
    scale = primary_scale(machine)
    given = ratios(one, scale, _ring(machine))
    spring, damper = _as_built(given, scale, built_springs(machine), filling(machine))
    from vibecalc.response.absorber.model import Absorber  # only absorbers need it

    return Absorber(primary_damping(machine.primary, scale), given.mass, spring, damper)


def primary_scale(machine: Machine) -> Scale | None:
    """Inertia and stiffness of the primary, the latter also from the rod; None for ratios."""
    primary, rod = machine.primary, machine.rod
    if primary is None:
        return None
    if primary.mass is not None and primary.linear_stiffness is not None:
        return Scale(primary.mass, primary.linear_stiffness, False)
    stiffness = primary.stiffness
    if rod is not None and rod.length is not None and rod.shear_modulus is not None:
        found = torsional_stiffness(rod.shear_modulus, rod.diameter, rod.length, rod.bore)
        stiffness = float(found.value)
    if primary.inertia is None or stiffness is None:
        return None
    return Scale(primary.inertia, stiffness, True)


def primary_damping(primary: Primary, scale: Scale | None) -> float:
    """c1 / (2 sqrt(K1 J1)); zero where nothing is said."""
    given = primary.damping if primary.damping is not None else primary.linear_damping
    if given is not None and scale is not None:
        return given / scale.damping
    return primary.damping_ratio or 0.0


class Ratios(NamedTuple):
    """Mass, spring and damper of one secondary over the primary; None is what is not said."""

    mass: float
    stiffness: float | None
    damping: float | None


def ratios(one: Secondary, scale: Scale | None, ring: float | None = None) -> Ratios:
    """What a secondary says, in ratios; `ring` is the inertia that a ring gives it."""
    heavy = next((x for x in (one.inertia, one.mass, ring) if x is not None), None)
    stiff = one.stiffness if one.stiffness is not None else one.linear_stiffness
    drag = one.damping if one.damping is not None else one.linear_damping
    mass, stiffness, damping = one.mass_ratio, one.stiffness_ratio, one.damping_ratio
    if scale is not None:
        mass = mass if heavy is None else heavy / scale.inertia
        stiffness = stiffness if stiff is None else stiff / scale.stiffness
        damping = damping if drag is None else drag / scale.damping
    if mass is None:
        raise ValueError("a secondary needs a mass")
    if one.own_damping_ratio is not None and stiffness is not None:
        from vibecalc.response.absorber.model import damping_from_own_ratio

        damping = float(damping_from_own_ratio(one.own_damping_ratio, mass, stiffness))
    return Ratios(mass, stiffness, damping)


def _as_built(
    given: Ratios, scale: Scale | None, springs: BuiltSprings | None, filled: Filling | None
) -> tuple[float, float]:
    """Ratios of spring and damper, from the parts where no number says them, else NaN."""
    stiffness, damping = given.stiffness, given.damping
    if stiffness is None and scale is not None and springs is not None:
        built = springs.stiffness
        stiffness = None if built is None else built / scale.stiffness
    if damping is None and scale is not None and filled is not None and filled.oil is not None:
        found = oil_damping(filled.oil, filled.gap, filled.temperature)
        damping = float(found.value) / scale.damping
    return (
        math.nan if stiffness is None else stiffness,
        math.nan if damping is None else damping,
    )


def _ring(machine: Machine) -> float | None:
    ring = machine.ring
    if ring is None:
        return None
    found = ring_inertia(ring.density, ring.outer_radius, ring.inner_radius, ring.width)
    return float(found.polar.value)


def _branches(given: tuple[NamedSecondary, ...], scale: Scale | None) -> tuple[Branch, ...]:
    """The absorbers by name, each behind what carries it: in no way by the order of the case."""
    left, placed = sorted(given, key=lambda one: one.name), {PRIMARY: -1}
    found: list[Branch] = []
    while left:
        one = next(one for one in left if one.on in placed)
        left.remove(one)
        placed[one.name] = len(found)
        found.append(Branch(one.name, placed[one.on], *ratios(one, scale)))
    return tuple(found)
