"""A primary system, its absorbers and their hardware, from a case to what the kernels take."""

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.absorber import tables as parts
from vibecalc.absorber.hardware.oil_gap import Oil, RingGap, Walther, clearance_rule, oil_damping
from vibecalc.absorber.hardware.rods_and_springs import (
    EndBody,
    OverhungRod,
    bending_stiffness,
    couple_stiffness,
    largest_extension,
    mass_per_length,
    ring_inertia,
    spring_rate,
    torsional_stiffness,
)
from vibecalc.absorber.tables import ICE, NamedSecondary, Primary, Secondary
from vibecalc.numerics.rounding import FloatArray
from vibecalc.schema import Case, Machine

if TYPE_CHECKING:
    from vibecalc.absorber.modal import Modes
    from vibecalc.absorber.transfer import Absorber

# ----------------------------------------------------------------------------
# Rod, springs, gap, oils and stock of a validated case as the hardware kernels take them.
# ----------------------------------------------------------------------------

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
    """What can be bought: springs by name and rate (n,) in N/m with how many act together, those
    behind each other as parts of one (NaN: as many as there are places), oils, and dampers by name
    and damping (d,) in N s/m, of all that act together.

    Mixtures of kinds, by their mean rate, stand behind the `plain_springs` and `plain_dampers`.
    `unmixed`: kinds are so many that not all of their mixtures are tried.
    """

    spring_names: tuple[str, ...]
    spring_rates: FloatArray
    spring_counts: FloatArray
    oils: tuple[Oil, ...]
    damper_names: tuple[str, ...]
    dampings: FloatArray
    plain_springs: int
    plain_dampers: int
    unmixed: bool


def bending(machine: Machine) -> Bending | None:
    """How the rod bends, of a machine with a flywheel."""
    rod, wheel = machine.rod, machine.flywheel
    if rod is None or wheel is None:
        return None
    assert rod.elastic_modulus is not None and rod.span is not None and rod.total_length is not None
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
            extension = largest_extension(
                rate, wire, coil, springs.allowed_stress, springs.initial_tension
            )
            longest = float(extension.value)
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
    kinds = [arranged(one) for one in machine.stock_springs]
    springs = [row for kind in kinds for row in kind]
    table = machine.spring_catalogue
    if table is not None:
        catalogue = zip(table.part, table.rate, strict=True)
        springs += [(str(part), rate, math.nan) for part, rate in catalogue]
    oils = [oil_of(one.name, one) for one in machine.stock_oils]
    rows = machine.oil_catalogue
    if rows is not None:
        columns = zip(rows.part, rows.viscosity_40, rows.viscosity_100, rows.density, strict=True)
        oils += [
            Oil(str(part), Walther((_COOL, _WARM), (thick, thin)), density)
            for part, thick, thin, density in columns
        ]
    sets = [side_by_side(one) for one in machine.stock_dampers]
    dampers = [row for one in sets for row in one]
    plain = len(springs), len(dampers)
    given = zip(machine.stock_springs, kinds, strict=True)
    mixed, some = mixtures([rows for one, rows in given if one.parallel is not None])
    springs += mixed
    damped, few = mixtures([
        [(name, drag, 1.0) for name, drag in rows]
        for one, rows in zip(machine.stock_dampers, sets, strict=True) if one.parallel > 1
    ])  # fmt: skip
    dampers += [(name, drag * count) for name, drag, count in damped]
    return Stock(
        tuple(name for name, _, _ in springs),
        np.array([rate for _, rate, _ in springs], dtype=float),
        np.array([count for _, _, count in springs], dtype=float),
        tuple(oils),
        tuple(name for name, _ in dampers),
        np.array([drag for _, drag in dampers], dtype=float),
        *plain,
        some or few,
    )


#: mixtures that are tried
_MIXTURES = 1000


def mixtures(
    kinds: list[list[tuple[str, float, float]]],
) -> tuple[list[tuple[str, float, float]], bool]:
    """Name, mean rate and count of every mixture of arrangements of two kinds or more.

    Also whether there are too many of all: then those of two kinds, or none, stand for them.
    """
    many = math.prod(len(rows) + 1 for rows in kinds) > _MIXTURES
    pairs = list(itertools.combinations(kinds, 2))
    if many and sum(len(one) * len(other) for one, other in pairs) > _MIXTURES:
        return [], True
    groups = pairs if many else (
        chosen for n in range(2, len(kinds) + 1) for chosen in itertools.combinations(kinds, n)
    )  # fmt: skip
    found = []
    for rows in itertools.chain.from_iterable(itertools.product(*chosen) for chosen in groups):
        count = sum(count for _, _, count in rows)
        total = sum(rate * count for _, rate, count in rows)
        found.append((" + ".join(name for name, _, _ in rows), total / count, count))
    return found, many and len(kinds) > 2


def side_by_side(one: parts.StockDamper) -> list[tuple[str, float]]:
    """Name and damping in N s/m of every number of a damper that act together."""
    return [
        (f"{n} x {one.name}" if n > 1 else one.name, n * one.count * one.linear_damping)
        for n in range(1, one.parallel + 1)
    ]


def arranged(one: parts.StockSpring) -> list[tuple[str, float, float]]:
    """Name, rate and count of every arrangement of a spring; those of equal stiffness once."""
    if one.parallel is None:
        return [(one.name, one.rate, math.nan)]
    rows = []
    for n in range(1, one.parallel + 1):
        for deep in range(1, (one.series or 1) + 1):
            if math.gcd(n, deep) == 1:
                lines = f"{n} x " if n > 1 else ""
                behind = f"{deep} in series of " if deep > 1 else ""
                rows.append((f"{lines}{behind}{one.name}", one.rate, n / deep))
    return rows


# ----------------------------------------------------------------------------
# A primary system, its absorbers and their parts as the kernels take them.
# ----------------------------------------------------------------------------

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
        return np.sqrt(self.stiffness / self.inertia)  # type: ignore[no-any-return]

    @property
    def damping(self) -> float:
        """2 sqrt(K1 J1): a damping over it is a ratio referred to the primary."""
        return 2.0 * np.sqrt(self.stiffness) * np.sqrt(self.inertia)  # type: ignore[no-any-return]


class Branch(NamedTuple):
    """One of several absorbers, in ratios to the primary; None is what [tuning] finds.

    `carrier` is the position of what carries it, before its own, -1 for the primary. `shapes` are
    ordinates of the modes of the primary, none for those where `shape_at_absorber` is.
    """

    name: str
    carrier: int
    mass_ratio: float
    stiffness_ratio: float | None
    secondary_damping: float | None
    shapes: tuple[float, ...] = ()


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
        missing = np.isnan(one.stiffness_ratio) | np.isnan(one.secondary_damping)
        return not np.any(missing)


def build_absorber(case: Case) -> AbsorberParts:
    """Ratios and parts of a case with a primary system.

    Raises ValueError for a case without one, which the checks refuse, and NumericalFailure as the
    viscosity line and the gap do, which they refuse, too.
    """
    machine = case.machine
    primary = machine.primary
    assert primary is not None
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
    given = ratios(one, scale, _seismic_inertia(machine))
    spring, damper = _as_built(given, scale, built_springs(machine), filling(machine))
    from vibecalc.absorber.transfer import Absorber  # only absorbers need it

    return Absorber(primary_damping(machine.primary, scale), given.mass, spring, damper)


def primary_scale(machine: Machine) -> Scale | None:
    """Inertia and stiffness of the primary, the latter also from the rod; None for ratios."""
    primary, rod = machine.primary, machine.rod
    if primary is None:
        return None
    if primary.modes:
        first = primary.modes[0]
        return Scale(first.modal_mass, first.modal_mass * first.natural_frequency**2, False)
    natural = primary.natural_frequency
    if primary.mass is not None and natural is not None:
        return Scale(primary.mass, primary.mass * natural**2, False)
    if primary.mass is not None and primary.linear_stiffness is not None:
        return Scale(primary.mass, primary.linear_stiffness, False)
    stiffness = primary.stiffness
    if primary.inertia is not None and natural is not None:
        stiffness = primary.inertia * natural**2
    if rod is not None and rod.length is not None and rod.shear_modulus is not None:
        found = torsional_stiffness(rod.shear_modulus, rod.diameter, rod.length, rod.bore)
        stiffness = float(found.value)
    if primary.inertia is None or stiffness is None:
        return None
    return Scale(primary.inertia, stiffness, True)


def primary_damping(primary: Primary, scale: Scale | None) -> float:
    """c1 / (2 sqrt(K1 J1)), of the first of several modes; zero where nothing is said."""
    if primary.modes:
        return primary.modes[0].damping_ratio
    given = primary.damping if primary.damping is not None else primary.linear_damping
    if given is not None and scale is not None:
        return given / scale.damping
    return 0.0 if primary.damping_ratio is None else primary.damping_ratio


def modes_of(primary: Primary, scale: Scale | None, branches: tuple[Branch, ...] = ()) -> "Modes":
    """The modes over the first of them, where one absorber, or each of several, hangs on them.

    A primary of its own spring is one mode of shape 1.
    """
    from vibecalc.absorber.modal import Modes, one_mode  # few absorbers need it

    if not primary.modes:
        return one_mode(primary_damping(primary, scale), max(1, len(branches)))
    first, rows = primary.modes[0], []
    for one in primary.modes:
        at_force = one.shape_at_response if one.shape_at_force is None else one.shape_at_force
        rows.append((
            one.modal_mass / first.modal_mass, one.natural_frequency / first.natural_frequency,
            one.damping_ratio, at_force, one.shape_at_response,
            0.0 if one.participation is None else one.participation,
        ))  # fmt: skip
    mass, frequency, damping, at_force, at_response, share = np.array(rows, dtype=float).T
    shapes = tuple(one.shape_at_absorber for one in primary.modes)
    at_absorber = [branch.shapes or shapes for branch in branches] or [shapes]
    return Modes(mass, frequency, damping, np.array(at_absorber).T, at_force, at_response, share)


class RubbedMass(NamedTuple):
    """A friction damper in ratios; the amplitude of the force on the primary, N m or N.

    None is a friction that is to be found, and a force that is not said.
    """

    mass_ratio: float
    friction_ratio: float | None
    force: float | None


def rubbed_mass(given: parts.FrictionDamper, scale: Scale | None) -> RubbedMass:
    """The friction damper of a case."""
    heavy = given.inertia if given.inertia is not None else given.mass
    mass = given.mass_ratio
    if heavy is not None and scale is not None:
        mass = heavy / scale.inertia
    assert mass is not None
    force = given.torque if given.torque is not None else given.force
    rub = given.friction_torque if given.friction_torque is not None else given.friction_force
    ratio = given.friction_ratio if rub is None or force is None else rub / force
    return RubbedMass(mass, ratio, force)


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
    mass, stiffness, damping = (
        one.mass_ratio,
        one.stiffness_ratio,
        one.damping_over_primary_critical,
    )
    if scale is not None:
        mass = mass if heavy is None else heavy / scale.inertia
        stiffness = stiffness if stiff is None else stiff / scale.stiffness
        damping = damping if drag is None else drag / scale.damping
    assert mass is not None
    if one.absorber_damping_ratio is not None and stiffness is not None:
        from vibecalc.absorber.transfer import damping_from_own_ratio

        found: Any = damping_from_own_ratio(one.absorber_damping_ratio, mass, stiffness)
        damping = found[()]  # a number, or one for each point
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


def _seismic_inertia(machine: Machine) -> float | None:
    ring = machine.ring
    if ring is None:
        return None
    found = ring_inertia(ring.density, ring.outer_radius, ring.inner_radius, ring.width)
    return float(found.polar.value)


def _branches(given: tuple[NamedSecondary, ...], scale: Scale | None) -> tuple[Branch, ...]:
    """The absorbers by name, each behind what carries it: in no way by the order of the case."""
    left, placed = sorted(given, key=lambda one: one.name), {PRIMARY: -1}
    branches: list[Branch] = []
    while left:
        one = next(one for one in left if one.on in placed)
        left.remove(one)
        placed[one.name] = len(branches)
        branches.append(Branch(one.name, placed[one.on], *ratios(one, scale), one.mode_shapes))
    return tuple(branches)
