"""The shaft line of a validated case as arrays, referred to the speed of the crankshaft."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.kinds import has_crank_train
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts import tables as train_parts
from vibecalc.parts.crank_train import build_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.from_dimensions import (
    Ring,
    reciprocating_inertia,
    section_modulus,
    shaft_stiffness,
    stiffness_by_formula,
    throw_inertia,
    throw_stiffness,
)
from vibecalc.torsion.line import Line
from vibecalc.torsion.shaft_line_tables import (
    Layout,
    LineDamper,
    Section,
    Shaft,
    ShaftLine,
    Throw,
    has_laws,
)
from vibecalc.torsion.speed_damping import (
    SpeedDamping,
    SpeedLaw,
    element_laws,
    load_law,
    referred,
    station_laws,
    turning,
)

if TYPE_CHECKING:
    from vibecalc.torsion.couplings import Coupling

# ----------------------------------------------------------------------------
# Inertias of stations, and what lies between them, each at its own speed, from a case.
# ----------------------------------------------------------------------------


class Element(NamedTuple):
    """One elastic element between the stations `first` and `second`, on the shaft of the first.

    Stiffness in N m/rad (with `speed_stiffness` per (rad/s)^2 of that shaft), damping in N m s/rad,
    polar section modulus in m^3, lengths in m; 0 where the case does not say it. The second end of
    a damper is its ring, of an `inertia` in kg m^2.
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
    inertia: float = 0.0


def station_inertia(case: Case, line: ShaftLine) -> list[float]:
    """Inertia of each station at its own speed, kg m^2, given or of its throw.

    Of a throw: its metal, rotating masses on its pin, reciprocating ones as their mean.
    """
    given = case.machine.crank_train
    train = build_crank_train(given) if has_crank_train(case.machine) else None
    found = []
    for station in line.stations:
        inertia = station.inertia
        if inertia is None:
            assert station.throw is not None and train is not None  # one of the two, says the form
            places = [train.names.index(name) for name in station.turned_by]
            radius, sliding = given.crank_radius, float(sum(train.reciprocating_mass[places]))
            inertia = throw_inertia(station.throw, radius)
            inertia += float(sum(train.rotating_mass[places])) * radius**2
            inertia += reciprocating_inertia(sliding, radius, given.rod_length)
        found.append(inertia)
    return found


def shaft_elements(
    line: ShaftLine,
    layout: Layout,
    given: train_parts.CrankTrain | None,
    inertia: Sequence[float],
) -> list[Element]:
    """All shafts; a damping ratio is that of the two neighbours against each other alone."""
    elements, radius = [], 0.0 if given is None else given.crank_radius
    for shaft, name, ends in zip(line.shafts, layout.sections, layout.ends, strict=True):
        first, second = (layout.at[end] for end in ends)
        stiffness = stiffness_of(shaft, radius)
        damping = shaft.damping or 0.0
        if shaft.damping_ratio:
            one, other = inertia[first], inertia[second]
            both = one * other / (one + other) if one + other > 0.0 else 0.0
            damping = 2.0 * shaft.damping_ratio * math.sqrt(stiffness * both)
        outer, bore = _ring(shaft)
        elements.append(
            Element(
                name,
                "shaft",
                first,
                second,
                stiffness,
                damping,
                shaft.eta,
                section_modulus=shaft.section_modulus
                or (section_modulus(outer, bore) if outer else 0.0),
                diameter=outer,
                bore=bore,
                tensile_strength=shaft.tensile_strength or 0.0,
            )
        )
    return elements


def stiffness_of(shaft: Shaft, crank_radius: float) -> float:
    """In N m/rad; NumericalFailure where none follows from the dimensions of a throw or cone."""
    if shaft.stiffness is not None:
        return shaft.stiffness
    if shaft.coupling is not None:
        from vibecalc.torsion.couplings import nominal

        return nominal(shaft.coupling).stiffness
    part, throw = shaft.section, shaft.throw
    if part is not None:
        return shaft_stiffness(part.shear_modulus, part.length, section_ends(part))
    assert throw is not None  # one of the four, says the form
    return throw_stiffness(throw, crank_radius, throw.formula)


def _ring(shaft: Shaft) -> Ring:
    """Outer and inner diameter where the stress is read; the journal of a throw; 0 for none."""
    if shaft.diameter is not None:
        return shaft.diameter, 0.0
    if shaft.section_modulus is not None:
        return 0.0, 0.0
    if shaft.section is not None:
        # of a cone, at the end where the stress is larger
        return min(section_ends(shaft.section), key=lambda end: section_modulus(*end))
    if shaft.throw is not None:
        return shaft.throw.journal_diameter, shaft.throw.journal_bore
    return 0.0, 0.0


def section_ends(section: Section) -> tuple[Ring, Ring]:
    """Outer and inner diameter at both ends of a shaft."""
    outer, inner = section.outer_diameter, section.inner_diameter
    last, bore = section.end_outer_diameter, section.end_inner_diameter
    return (outer, inner), (outer if last is None else last, inner if bore is None else bore)


def damper_element(one: LineDamper, station: int) -> Element:
    """A damper; pendulums are the ring and the spring that they are equal to.

    A pendulum of mass m on an arm of length r at the radius R swings in the field of the rotation.
    With the angle theta + s r / (R + r) of its mass about the axis (s its swing) it is a ring of
    inertia m (R + r)^2 on a spring of m (R + r)^2 n^2 w^2, n^2 = R / r, at the speed w.
    """
    inertia, spring = 0.0 if one.inertia is None else one.inertia, 0.0
    if one.order is not None and one.mass is not None and one.arm_radius is not None:
        reach = one.arm_radius * (1.0 + 1.0 / one.order**2)
        inertia = one.count * one.mass * reach**2
        spring = inertia * one.order**2
    stiffness = 0.0 if one.stiffness is None else one.stiffness
    values = (stiffness, one.damping, one.loss_factor, spring)
    return Element(one.name, "damper", station, -1, *values, inertia=inertia)


# ----------------------------------------------------------------------------
# The shaft line of a validated case as arrays, referred to the speed of the crankshaft.
#
# With the own speed ratio r of a station or shaft (own speed over crank speed, signed): the own
# angle is r times the referred one, an inertia, stiffness or damping counts r^2 times, an own
# torque is the referred one over r, and a torque on a station counts r times.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]
Places = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Gearing:
    """A gear between two stations; `element` is that of its teeth, -1 where they are rigid."""

    name: str
    first: int
    second: int
    ratio: float
    pitch_radius: float
    element: int


@dataclass(frozen=True, kw_only=True)
class AttachedDamper:
    """A damper: the freedom that carries it, that of its ring, its element; SI values as given.

    `inertia`, `stiffness` and `damping` are actual ones; those of pendulums are the ring and the
    spring at one rad/s of the station that they are equal to, to which the damping belongs, and
    they swing by `swing_per_twist` times the angle between station and ring, (R + r) / r.
    """

    name: str
    kind: str
    station: int
    carrier: int
    ring: int
    element: int
    inertia: float
    stiffness: float
    damping: float
    swing_per_twist: float = 1.0


@dataclass(frozen=True, kw_only=True)
class ShaftLineModel:
    """s stations, n freedoms (merged stations, then rings of dampers), e elements (sections).

    `line` holds the referred values at standstill; `speed_stiffness` (e,) is what a crank speed
    adds to the stiffness, in N m/rad per (rad/s)^2 (pendulums). `freedom` (s,) and
    `station_ratio` (s,) belong to stations, `ring_ratio` to the dampers, `section_*` (e,) to
    elements: shafts, elastic gears, dampers; `section_ends` (e, 2) are their stations, -1 for a
    ring, and `station_values` (3, s) the referred inertia, absolute damping and stiffness to
    ground of each station. `section_modulus` in m^3, `section_diameter` in m and
    `tensile_strength` in Pa are 0 where the case does not say them; `throws` are those of the
    shafts, which come first. `cylinder_station` and `cylinder_freedom` (c,) follow the cylinders of
    the crank train. Of `loads` (k,) there are the torque at the operating speed, exponent and law
    on their own shafts. Where dampings follow speed, load or a mode, `line` has those of the
    operating speed, `station_laws` (s,) are the absolute ones of own shafts and `over_speed` is
    what is another one at another speed. `couplings` are those elements that have the table of a
    maker, nominal values of which stand in `line`.
    """

    line: Line
    speed_stiffness: Array
    station_names: tuple[str, ...]
    station_ratio: Array
    freedom: Places
    freedom_names: tuple[str, ...]
    freedom_ratio: Array
    station_values: Array
    section_ends: Places
    section_names: tuple[str, ...]
    section_kinds: tuple[str, ...]
    section_ratio: Array
    section_modulus: Array
    section_diameter: Array
    section_bore: Array
    tensile_strength: Array
    throws: tuple[Throw | None, ...]
    cylinder_station: Places
    cylinder_freedom: Places
    gears: tuple[Gearing, ...]
    dampers: tuple[AttachedDamper, ...]
    load_station: int
    load_freedom: int
    taken_station: Places
    taken_torque: Array
    taken_exponent: Array
    taken_laws: tuple[SpeedLaw, ...]
    station_laws: tuple[tuple[SpeedLaw, ...], ...] = ()
    over_speed: SpeedDamping | None = None
    couplings: tuple["Coupling", ...] = ()

    def at(self, speed: float | Array) -> Line:
        """The line at crank speeds (...) in rad/s; what follows them gets their leading axes."""
        return turning(self.line, self.over_speed, self.speed_stiffness, speed)

    def taken(self, speed: float | Array) -> Array:
        """What each of `loads` takes (..., k) at crank speeds (...), referred, in N m."""
        at = np.asarray(speed, dtype=float)
        found = [np.zeros((*at.shape, 0)), *(one.at(at)[..., None] for one in self.taken_laws)]
        # it brakes, whichever way its shaft turns
        ratio = np.abs(self.station_ratio[self.taken_station])
        return np.concatenate(found, axis=-1) * ratio

    def mean_load(self, speed: float) -> Array:
        """What `loads` take from each freedom (n,), referred, positive braking, in N m."""
        taken = np.zeros(len(self.freedom_names))
        np.add.at(taken, self.freedom[self.taken_station], self.taken(speed))
        return taken

    def station_damping(self, speed: float | Array) -> Array:
        """Referred absolute damping of each station (..., s) at crank speeds (...), N m s/rad."""
        if not self.station_laws:
            return np.asarray(self.station_values[1])
        at = np.asarray(speed, dtype=float)
        found = [
            sum((one.at(at) for one in laws), np.zeros(at.shape)) for laws in self.station_laws
        ]
        return np.asarray(np.stack(found, axis=-1) * self.station_ratio**2)


def build_shaft_line(case: Case) -> ShaftLineModel:
    """Arrays of `machine.shaft_line`; a case without problems has one piece and one ratio each.

    Numbers of rings that are arrays (points,) give `line` leading axes.
    """
    parts = case.machine.shaft_line
    assert parts is not None, "only planned where there is a shaft line"
    layout, train = Layout(parts), case.machine.crank_train
    ratio, freedom = np.array(layout.ratio), np.array(layout.freedom, dtype=np.int64)
    inertia = station_inertia(case, parts)
    shafts = shaft_elements(parts, layout, train, inertia)
    # elastic teeth: k R^2 on the shaft of the first wheel
    meshes = [
        Element(
            gear.label,
            "mesh",
            layout.at[gear.between[0]],
            layout.at[gear.between[1]],
            gear.mesh_stiffness * (gear.pitch_radius or 0.0) ** 2,
        )
        for gear in parts.gears
        if gear.mesh_stiffness is not None
    ]
    rings = [damper_element(one, layout.at[one.on]) for one in parts.dampers]
    elements = [*shafts, *meshes, *rings]
    stations, before = int(freedom.max()) + 1, len(shafts) + len(meshes)
    ring = np.arange(stations, stations + len(rings), dtype=np.int64)
    ends = np.array([(one.first, one.second) for one in elements], dtype=np.int64).reshape(-1, 2)
    own = ratio[ends[:, 0]]
    square = own**2

    def column(name: str) -> Array:
        return side_by_side([getattr(one, name) for one in elements])

    damped = [station.absolute_damping for station in parts.stations]
    held = [station.ground_stiffness for station in parts.stations]
    values = ratio**2 * np.array([inertia, damped, held])
    gathered = np.zeros((len(ring) + stations, 3))
    np.add.at(gathered, freedom, values.T)
    of_rings = [one.inertia * ratio[one.first] ** 2 for one in rings]
    line = Line(
        inertia=gathered[:, 0] + side_by_side([*np.zeros(stations), *of_rings]),
        absolute_damping=gathered[:, 1],
        ground_stiffness=gathered[:, 2],
        first=freedom[ends[:, 0]],
        second=np.concatenate([freedom[ends[:before, 1]], ring]),
        stiffness=square * column("stiffness"),
        damping=square * column("damping"),
        loss_factor=column("loss_factor"),
    )
    members: list[list[str]] = [[] for _ in range(stations)]
    for name, place in zip(layout.names, layout.freedom, strict=True):
        members[place].append(name)
    leaders = np.unique(freedom, return_index=True)[1]
    turned = {name: n for n, one in enumerate(parts.stations) for name in one.turned_by}
    cylinders = train.cylinders if has_crank_train(case.machine) else ()
    fired = np.array([turned[one.name] for one in cylinders], dtype=np.int64)
    laws = tuple(load_law(one, case.machine.speed) for one in parts.absorbed_torques)
    elastic = iter(range(len(shafts), before))
    built = ShaftLineModel(
        line=line,
        # a pendulum feels the speed of its own station
        speed_stiffness=square**2 * column("speed_stiffness"),
        station_names=tuple(layout.names),
        station_ratio=ratio,
        freedom=freedom,
        freedom_names=(*(" + ".join(one) for one in members), *(one.name for one in rings)),
        freedom_ratio=np.concatenate([ratio[leaders], own[before:]]),
        station_values=values,
        section_ends=ends,
        section_names=tuple(one.name for one in elements),
        section_kinds=tuple(one.kind for one in elements),
        section_ratio=own,
        section_modulus=column("section_modulus"),
        section_diameter=column("diameter"),
        section_bore=column("bore"),
        tensile_strength=column("tensile_strength"),
        throws=tuple(shaft.throw for shaft in parts.shafts),
        cylinder_station=fired,
        cylinder_freedom=freedom[fired],
        gears=tuple(
            Gearing(
                name=gear.label,
                first=layout.at[gear.between[0]],
                second=layout.at[gear.between[1]],
                ratio=gear.signed_ratio,
                pitch_radius=gear.pitch_radius or 0.0,
                element=-1 if gear.mesh_stiffness is None else next(elastic),
            )
            for gear in parts.gears
        ),
        dampers=tuple(
            AttachedDamper(
                name=one.name,
                kind=given.kind,
                station=one.first,
                carrier=int(freedom[one.first]),
                ring=stations + number,
                element=before + number,
                inertia=one.inertia,
                # pendulums have no other spring
                stiffness=one.stiffness + one.speed_stiffness,
                damping=one.damping,
                swing_per_twist=1.0 if given.order is None else 1.0 + given.order**2,
            )
            for number, (one, given) in enumerate(zip(rings, parts.dampers, strict=True))
        ),
        load_station=layout.load,
        load_freedom=int(freedom[layout.load]),
        taken_station=np.array(
            [layout.at[one.on] for one in parts.absorbed_torques], dtype=np.int64
        ),
        taken_torque=np.array([float(one.at(case.machine.speed)) for one in laws], dtype=float),
        taken_exponent=np.array([one.exponent for one in parts.absorbed_torques], dtype=float),
        taken_laws=laws,
        couplings=_couplings(parts, layout, own),
    )
    if not has_laws(parts):
        return built
    return _with_laws(built, parts, layout, case.machine.speed)


def _with_laws(
    built: ShaftLineModel, parts: ShaftLine, layout: Layout, speed: float
) -> ShaftLineModel:
    """The line with the dampings that follow speed, load or a mode; `line` has them at `speed`.

    Raises NumericalFailure for a damping of the engine by a mode that does not vibrate.
    """

    @cache
    def natural() -> Array:
        from vibecalc.torsion.modes import natural_modes

        return natural_modes(built.at(speed)).frequency

    ratio, line, square = built.station_ratio, built.line, built.section_ratio**2
    inertia, _, held = built.station_values
    stations = station_laws(parts, layout, inertia / ratio**2, speed, natural)
    dashpot = element_laws(parts, layout, line.damping / square)
    loss = element_laws(parts, layout, line.loss_factor)
    own = ratio**2 * [sum(float(one.at(speed)) for one in laws) for laws in stations]
    gathered = np.zeros(len(line.inertia))
    np.add.at(gathered, built.freedom, own)
    line = line._replace(
        absolute_damping=gathered,
        damping=square * [float(one.at(speed)) for one in dashpot],
        loss_factor=np.array([float(one.at(speed)) for one in loss]),
    )
    return replace(
        built,
        line=line,
        station_values=np.array([inertia, own, held]),
        station_laws=stations,
        over_speed=referred(stations, layout.freedom, ratio, dashpot, loss, built.section_ratio),
    )


def _couplings(parts: ShaftLine, layout: Layout, ratio: Array) -> tuple["Coupling", ...]:
    given = [(n, one.coupling) for n, one in enumerate(parts.shafts) if one.coupling is not None]
    if not given:
        return ()
    from vibecalc.torsion.couplings import coupling_of

    return tuple(coupling_of(one, layout.sections[n], n, float(ratio[n])) for n, one in given)


# ----------------------------------------------------------------------------
# Angular momentum of a shaft line: how much, and which way round, its freedoms carry.
# ----------------------------------------------------------------------------


def spin_inertia(case: Case, built: ShaftLineModel) -> Bounded:
    """Own inertia times own speed ratio (n,) in kg m^2, summed over what turns with a freedom.

    Times the referred angular velocity it is the angular momentum about the crankshaft, positive in
    its sense; the referred inertia holds the ratio twice. Inertias of stations count as those of
    parts that turn.
    """
    line = case.machine.shaft_line
    assert line is not None, "only asked of a machine with a shaft line"
    inertia = np.array(station_inertia(case, line))
    total, size = np.zeros(len(built.freedom_names)), np.zeros(len(built.freedom_names))
    spin = inertia * built.station_ratio
    np.add.at(total, built.freedom, spin)
    np.add.at(size, built.freedom, np.abs(spin))
    for damper in built.dampers:
        total[damper.ring] = damper.inertia * built.station_ratio[damper.station]
    size += np.abs(total)
    return Bounded(total, (len(inertia) + 2) * EPSILON * size)


# ----------------------------------------------------------------------------
# How sure the stiffness of a crank throw from its dimensions can be.
# ----------------------------------------------------------------------------


def throw_cautions(case: Case) -> list[str]:
    """A sentence for each kind of throw whose formulas are compared."""
    line = case.machine.shaft_line
    if line is None:
        return []
    named: dict[str, list[str]] = {}
    for shaft, name in zip(line.shafts, Layout(line).sections, strict=True):
        if shaft.throw is None or shaft.stiffness is not None:
            continue
        found = stiffness_by_formula(shaft.throw, case.machine.crank_train.crank_radius).values()
        low, high = min(found), max(found)
        words = (
            f"throw stiffness by the formulas {low:.3g} to {high:.3g} N*m/rad, +-"
            f"{100.0 * (high - low) / (high + low):.0f} % about the middle (used: "
            f"'{shaft.throw.formula}'): natural frequencies of modes that twist the throws are "
            "uncertain by up to that share"
        )
        named.setdefault(words, []).append(name)
    return [f"{', '.join(names)}: {words}" for words, names in named.items()]
