"""The shaft line of a validated case as arrays, referred to the speed of the crankshaft."""

import math
from collections.abc import Mapping, Sequence
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
from vibecalc.parts.crank_train import CrankTrain, build_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.dampings import element_laws, load_law, station_laws
from vibecalc.torsion.from_dimensions import Throw as Dimensions
from vibecalc.torsion.from_dimensions import (
    disc_ended_web_inertia,
    journal_inertia,
    offset_body_inertia,
    pin_inertia,
    reciprocating_inertia,
    rectangular_web_inertia,
    section_modulus,
    shaft_stiffness,
    stiffness_spread,
    throw_inertia,
    throw_stiffness,
)
from vibecalc.torsion.line import Line
from vibecalc.torsion.shaft_line_tables import (
    Section,
    Shaft,
    ShaftLine,
    Throw,
    crank_station,
    gear_ratio,
    has_laws,
    joints,
    loss_factor,
    merged,
    shaft_ends,
    speed_ratios,
)
from vibecalc.torsion.shaft_line_tables import ShaftLine as Parts
from vibecalc.torsion.speed_damping import SpeedDamping, SpeedLaw, referred

if TYPE_CHECKING:
    from vibecalc.torsion.couplings import Coupling

# ----------------------------------------------------------------------------
# Inertias of stations, and what lies between them, each at its own speed, from a case.
# ----------------------------------------------------------------------------


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


class AttachedElement(NamedTuple):
    """A damper: its element, whose second end is its ring, and the inertia of the ring."""

    element: Element
    kind: str
    inertia: float


def station_inertia(
    line: ShaftLine, given: train_parts.CrankTrain | None, train: CrankTrain | None
) -> list[float]:
    """Inertia of each station at its own speed, kg m^2, given or of its throw."""
    found = []
    for station in line.stations:
        names = [n for n in (station.cylinder, *station.cylinders) if n is not None]
        inertia = station.inertia
        if inertia is None:
            assert station.throw is not None and given is not None and train is not None
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
    given: train_parts.CrankTrain | None,
    at: Mapping[str, int],
    inertia: Sequence[float] | NDArray[np.float64],
) -> list[Element]:
    """All shafts; a damping ratio is that of the two neighbours against each other alone."""
    elements, radius = [], 0.0 if given is None else given.crank_radius
    for shaft, (first, second) in zip(line.shafts, shaft_ends(line), strict=True):
        stiffness = _stiffness(shaft, radius)
        damping = shaft.damping or 0.0
        if shaft.damping_ratio:
            one, other = float(inertia[at[first]]), float(inertia[at[second]])
            both = one * other / (one + other) if one + other > 0.0 else 0.0
            damping = 2.0 * shaft.damping_ratio * math.sqrt(stiffness * both)
        outer, bore = _diameters(shaft)
        modulus = shaft.section_modulus or (
            float(section_modulus(outer, bore).value) if outer else 0.0
        )
        elements.append(
            Element(
                name=shaft.name or f"{first} - {second}",
                kind="shaft",
                first=at[first],
                second=at[second],
                stiffness=stiffness,
                damping=damping,
                loss_factor=loss_factor(shaft),
                section_modulus=modulus,
                diameter=outer,
                bore=bore,
                tensile_strength=shaft.tensile_strength or 0.0,
            )
        )
    return elements


def _stiffness(shaft: Shaft, crank_radius: float) -> float:
    if shaft.stiffness is not None:
        return shaft.stiffness
    if shaft.coupling is not None:
        from vibecalc.torsion.coupling_model import nominal

        return nominal(shaft.coupling).stiffness
    if shaft.section is not None:
        part = shaft.section
        ends = (part.end_outer_diameter, part.end_inner_diameter)
        plain = (part.shear_modulus, part.length, part.outer_diameter, part.inner_diameter)
        return float(shaft_stiffness(*plain, *ends).value)
    throw = shaft.throw
    assert throw is not None  # one of the four, says the form
    dimensions, modulus = throw_dimensions(throw, crank_radius), np.asarray(throw.shear_modulus)
    return float(throw_stiffness(dimensions, modulus, throw.formula).value)


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


def damper_elements(line: ShaftLine, at: Mapping[str, int]) -> list[AttachedElement]:
    """Dampers, with pendulums as the ring and the spring that they are equal to.

    A pendulum of mass m on an arm of length r at the radius R swings in the field of the rotation.
    With the angle theta + s r / (R + r) of its mass about the axis (s its swing) it is a ring of
    inertia m (R + r)^2 on a spring of m (R + r)^2 n^2 w^2, n^2 = R / r, at the speed w.
    """
    elements = []
    for one in line.dampers:
        inertia, spring = 0.0 if one.inertia is None else one.inertia, 0.0
        if one.order is not None and one.mass is not None and one.arm_radius is not None:
            reach = one.arm_radius * (1.0 + 1.0 / one.order**2)
            inertia = one.count * one.mass * reach**2
            spring = inertia * one.order**2
        element = Element(
            name=one.name,
            kind="damper",
            first=at[one.on],
            second=-1,
            stiffness=0.0 if one.stiffness is None else one.stiffness,
            damping=one.damping,
            loss_factor=one.loss_factor,
            speed_stiffness=spring,
        )
        elements.append(AttachedElement(element, one.kind, inertia))
    return elements


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
    spring at one rad/s of the station that they are equal to.
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
        line = self.line if self.over_speed is None else self.over_speed.on(self.line, speed)
        if not np.any(self.speed_stiffness):
            return line
        square = np.asarray(speed, dtype=float)[..., None] ** 2
        stiffness = self.line.stiffness + square * self.speed_stiffness
        return line._replace(stiffness=stiffness)

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
    train = build_crank_train(case.machine.crank_train) if has_crank_train(case.machine) else None
    names = tuple(station.name for station in parts.stations)
    at = {name: place for place, name in enumerate(names)}
    ratio = np.array(speed_ratios(len(names), joints(parts), crank_station(parts)).ratio)
    rigid = [g.between for g in parts.gears if g.mesh_stiffness is None]
    freedom = np.array(merged(len(names), [(at[a], at[b]) for a, b in rigid]), dtype=np.int64)
    inertia_of = np.array(station_inertia(parts, case.machine.crank_train, train))
    stations = int(freedom.max()) + 1
    damped = [station.absolute_damping for station in parts.stations]
    held = [station.ground_stiffness for station in parts.stations]
    shafts = shaft_elements(parts, case.machine.crank_train, at, inertia_of)
    meshes = gear_elements(parts, at)
    attached = damper_elements(parts, at)
    elements = [*shafts, *meshes, *(one.element for one in attached)]
    element_ratio = np.array([ratio[one.first] for one in elements])
    ring = np.arange(stations, stations + len(attached), dtype=np.int64)
    ends = [(freedom[one.first], freedom[one.second]) for one in (*shafts, *meshes)]
    ends += [(freedom[one.element.first], place) for one, place in zip(attached, ring, strict=True)]
    square, n = element_ratio**2, stations + len(attached)
    line = Line(
        inertia=_gathered(inertia_of, ratio, freedom, n) + _rings(attached, ratio, stations),
        absolute_damping=_gathered(damped, ratio, freedom, n),
        ground_stiffness=_gathered(held, ratio, freedom, n),
        first=np.array([a for a, _ in ends], dtype=np.int64),
        second=np.array([b for _, b in ends], dtype=np.int64),
        stiffness=square * side_by_side([one.stiffness for one in elements]),
        damping=square * side_by_side([one.damping for one in elements]),
        loss_factor=side_by_side([one.loss_factor for one in elements]),
    )
    leaders = np.unique(freedom, return_index=True)[1].tolist()
    gathered: list[list[str]] = [[] for _ in range(stations)]
    for name, place in zip(names, freedom.tolist(), strict=True):
        gathered[place].append(name)
    together = [" + ".join(one) for one in gathered]
    load = at[parts.load] if parts.load is not None else len(names) - 1
    cylinder = _cylinder_stations(parts, () if train is None else train.names)
    laws = tuple(load_law(one, case.machine.speed) for one in parts.loads)
    built = ShaftLineModel(
        line=line,
        # a pendulum feels the speed of its own station
        speed_stiffness=square**2 * np.array([one.speed_stiffness for one in elements]),
        station_names=names,
        station_ratio=ratio,
        freedom=freedom,
        freedom_names=(*together, *(one.element.name for one in attached)),
        freedom_ratio=np.array([*ratio[leaders], *(ratio[one.element.first] for one in attached)]),
        station_values=ratio**2 * np.array([inertia_of, damped, held]),
        section_ends=np.array(
            [(one.first, one.second) for one in elements], dtype=np.int64
        ).reshape(-1, 2),
        section_names=tuple(one.name for one in elements),
        section_kinds=tuple(one.kind for one in elements),
        section_ratio=element_ratio,
        section_modulus=np.array([one.section_modulus for one in elements], dtype=float),
        section_diameter=np.array([one.diameter for one in elements], dtype=float),
        section_bore=np.array([one.bore for one in elements], dtype=float),
        tensile_strength=np.array([one.tensile_strength for one in elements], dtype=float),
        throws=tuple(shaft.throw for shaft in parts.shafts),
        cylinder_station=cylinder,
        cylinder_freedom=freedom[cylinder],
        gears=_gearings(parts, at, meshes, len(shafts)),
        dampers=tuple(
            AttachedDamper(
                name=one.element.name,
                kind=one.kind,
                station=one.element.first,
                carrier=int(freedom[one.element.first]),
                ring=int(place),
                element=len(shafts) + len(meshes) + number,
                inertia=one.inertia,
                # pendulums have no other spring
                stiffness=one.element.stiffness + one.element.speed_stiffness,
                damping=one.element.damping,
            )
            for number, (one, place) in enumerate(zip(attached, ring, strict=True))
        ),
        load_station=load,
        load_freedom=int(freedom[load]),
        taken_station=np.array([at[one.on] for one in parts.loads], dtype=np.int64),
        taken_torque=np.array([float(one.at(case.machine.speed)) for one in laws], dtype=float),
        taken_exponent=np.array([one.exponent for one in parts.loads], dtype=float),
        taken_laws=laws,
        couplings=_couplings(parts, [one.name for one in shafts], element_ratio),
    )
    if not has_laws(parts):
        return built
    return _with_laws(built, parts, at, inertia_of, case.machine.speed)


def _with_laws(
    built: ShaftLineModel, parts: Parts, at: dict[str, int], inertia: Array, speed: float
) -> ShaftLineModel:
    """The line with the dampings that follow speed, load or a mode; `line` has them at `speed`.

    Raises NumericalFailure for a damping of the engine by a mode that does not vibrate.
    """

    @cache
    def natural() -> Array:
        from vibecalc.torsion.modes import natural_modes

        return natural_modes(built.at(speed)).frequency

    ratio, line, square = built.station_ratio, built.line, built.section_ratio**2
    stations = station_laws(parts, at, ratio, inertia, speed, natural)
    dashpot, loss = element_laws(
        parts, at, ratio, (line.damping / square).tolist(), line.loss_factor.tolist()
    )
    own = np.array([sum(float(one.at(speed)) for one in laws) for laws in stations])
    line = line._replace(
        absolute_damping=_gathered(own, ratio, built.freedom, len(line.inertia)),
        damping=square * np.array([float(one.at(speed)) for one in dashpot]),
        loss_factor=np.array([float(one.at(speed)) for one in loss]),
    )
    held = built.station_values
    return replace(
        built,
        line=line,
        station_values=np.array([held[0], ratio**2 * own, held[2]]),
        station_laws=stations,
        over_speed=referred(stations, built.freedom, ratio, dashpot, loss, built.section_ratio),
    )


def _couplings(parts: Parts, names: list[str], ratio: Array) -> tuple["Coupling", ...]:
    if all(shaft.coupling is None for shaft in parts.shafts):
        return ()
    from vibecalc.torsion.coupling_model import couplings_of

    return couplings_of([shaft.coupling for shaft in parts.shafts], names, ratio)


def _gathered(values: Array | list[float], ratio: Array, freedom: Places, n: int) -> Array:
    """Values by station, referred and summed over those of one freedom."""
    total = np.zeros(n)
    np.add.at(total, freedom, np.asarray(values, dtype=float) * ratio**2)
    return total


def _rings(attached: list[AttachedElement], ratio: Array, stations: int) -> Array:
    rings = [one.inertia * ratio[one.element.first] ** 2 for one in attached]
    return side_by_side([*np.zeros(stations), *rings])


def _cylinder_stations(parts: Parts, cylinders: Sequence[str]) -> Places:
    at = {
        name: place
        for place, station in enumerate(parts.stations)
        for name in (*station.cylinders, *([station.cylinder] if station.cylinder else []))
    }
    return np.array([at[name] for name in cylinders], dtype=np.int64)


def _gearings(
    parts: Parts, at: dict[str, int], meshes: list[Element], shafts: int
) -> tuple[Gearing, ...]:
    gearings, elastic = [], {one.name: shafts + place for place, one in enumerate(meshes)}
    for gear in parts.gears:
        first, second = gear.between
        name = gear.name or f"{first} - {second}"
        gearings.append(
            Gearing(
                name=name,
                first=at[first],
                second=at[second],
                ratio=gear_ratio(gear),
                pitch_radius=gear.pitch_radius or 0.0,
                element=elastic.get(name, -1) if gear.mesh_stiffness is not None else -1,
            )
        )
    return tuple(gearings)


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
    train = case.machine.crank_train
    inertia = np.array(station_inertia(line, train, build_crank_train(train)))
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
    for shaft, ends in zip(line.shafts, shaft_ends(line), strict=True):
        if shaft.throw is None or shaft.stiffness is not None:
            continue
        dimensions = throw_dimensions(shaft.throw, case.machine.crank_train.crank_radius)
        spread = stiffness_spread(dimensions, np.asarray(shaft.throw.shear_modulus))
        low, high = float(spread.stiffness.min()), float(spread.stiffness.max())
        words = (
            f"the formulas for the stiffness of a throw give {low:.3g} to {high:.3g} N*m/rad, "
            f"{100.0 * float(spread.uncertainty):.0f} % to either side of their middle, and "
            f"'{shaft.throw.formula}' is one of them: natural frequencies in which the throws "
            "twist are unsure by up to that share"
        )
        named.setdefault(words, []).append(shaft.name or " - ".join(ends))
    return [f"{', '.join(names)}: {words}" for words, names in named.items()]
