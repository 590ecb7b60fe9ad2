"""The shaft line of a validated case as arrays, referred to the speed of the crankshaft.

With the own speed ratio r of a station or shaft (own speed over crank speed, signed): the own angle
is r times the referred one, an inertia, stiffness or damping counts r^2 times, an own torque is the
referred one over r, and a torque on a station counts r times.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vibecalc.case.schema import Case
from vibecalc.case.shaft_parts import ShaftLine as Parts
from vibecalc.machine.crank_train import CrankTrain, build_crank_train
from vibecalc.machine.shaft_line_elements import (
    Element,
    HungElement,
    damper_elements,
    gear_elements,
    shaft_elements,
    station_inertia,
)
from vibecalc.machine.shaft_line_graph import (
    crank_station,
    gear_ratio,
    joints,
    merged,
    speed_ratios,
)
from vibecalc.response.torsion.line import Line

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
class Hung:
    """A damper: the freedom that carries it, that of its ring, its element; SI values as given.

    `inertia`, `stiffness` and `damping` are own ones; those of pendulums are the ring and the
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
class ShaftLine:
    """s stations, n freedoms (merged stations, then rings of dampers), e elements (sections).

    `line` holds the referred values at standstill; `speed_stiffness` (e,) is what a crank speed
    adds to the stiffness, in N m/rad per (rad/s)^2 (pendulums). `freedom` (s,) and
    `station_ratio` (s,) belong to stations, `ring_ratio` to the dampers, `section_*` (e,) to
    elements: shafts, elastic gears, dampers; `section_ends` (e, 2) are their stations, -1 for a
    ring, and `station_values` (3, s) the referred inertia, absolute damping and stiffness to
    ground of each station. `section_modulus` in m^3, `section_diameter` in m and
    `tensile_strength` in Pa are 0 where the case does not say them. `cylinder_station` and
    `cylinder_freedom` (c,) follow the cylinders of the crank train.
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
    cylinder_station: Places
    cylinder_freedom: Places
    gears: tuple[Gearing, ...]
    dampers: tuple[Hung, ...]
    load_station: int
    load_freedom: int
    taken_station: Places
    taken_torque: Array
    taken_exponent: Array

    def at(self, speed: float | Array) -> Line:
        """The line at crank speeds (...) in rad/s; the stiffness gets their leading axes."""
        if not np.any(self.speed_stiffness):
            return self.line
        square = np.asarray(speed, dtype=float)[..., None] ** 2
        stiffness = self.line.stiffness + square * self.speed_stiffness
        return self.line._replace(stiffness=stiffness)

    def mean_load(self, speed: float, operating_speed: float) -> Array:
        """What `loads` take from each freedom (n,), referred, positive braking, in N m."""
        taken = np.zeros(len(self.freedom_names))
        factor = (speed / operating_speed) ** self.taken_exponent
        places = self.freedom[self.taken_station]
        # it brakes, whichever way its shaft turns
        ratio = np.abs(self.station_ratio[self.taken_station])
        np.add.at(taken, places, self.taken_torque * factor * ratio)
        return taken


def build_shaft_line(case: Case) -> ShaftLine:
    """Arrays of `machine.shaft_line`; a case without problems has one piece and one ratio each."""
    parts = case.machine.shaft_line
    assert parts is not None, "only planned where there is a shaft line"
    train = build_crank_train(case.machine.crank_train)
    names = tuple(station.name for station in parts.stations)
    at = {name: place for place, name in enumerate(names)}
    ratio = np.array(speed_ratios(len(names), joints(parts), crank_station(parts)).ratio)
    rigid = [g.between for g in parts.gears if g.mesh_stiffness is None]
    freedom = np.array(merged(len(names), [(at[a], at[b]) for a, b in rigid]), dtype=np.int64)
    own = np.array(station_inertia(parts, case.machine.crank_train, train))
    stations = int(freedom.max()) + 1
    damped = [station.absolute_damping for station in parts.stations]
    held = [station.ground_stiffness for station in parts.stations]
    shafts = shaft_elements(parts, case.machine.crank_train, at, own)
    meshes = gear_elements(parts, at)
    hung = damper_elements(parts, at)
    elements = [*shafts, *meshes, *(one.element for one in hung)]
    element_ratio = np.array([ratio[one.first] for one in elements])
    ring = np.arange(stations, stations + len(hung), dtype=np.int64)
    ends = [(freedom[one.first], freedom[one.second]) for one in (*shafts, *meshes)]
    ends += [(freedom[one.element.first], place) for one, place in zip(hung, ring, strict=True)]
    square, n = element_ratio**2, stations + len(hung)
    line = Line(
        inertia=_gathered(own, ratio, freedom, n) + _rings(hung, ratio, stations, n),
        absolute_damping=_gathered(damped, ratio, freedom, n),
        ground_stiffness=_gathered(held, ratio, freedom, n),
        first=np.array([a for a, _ in ends], dtype=np.int64),
        second=np.array([b for _, b in ends], dtype=np.int64),
        stiffness=square * np.array([one.stiffness for one in elements]),
        damping=square * np.array([one.damping for one in elements]),
        loss_factor=np.array([one.loss_factor for one in elements], dtype=float),
    )
    leaders = [int(np.flatnonzero(freedom == place)[0]) for place in range(stations)]
    together = [
        " + ".join(name for name, f in zip(names, freedom, strict=True) if f == place)
        for place in range(stations)
    ]
    load = at[parts.load] if parts.load is not None else len(names) - 1
    cylinder = _cylinder_stations(parts, train)
    return ShaftLine(
        line=line,
        # a pendulum feels the speed of its own station
        speed_stiffness=square**2 * np.array([one.speed_stiffness for one in elements]),
        station_names=names,
        station_ratio=ratio,
        freedom=freedom,
        freedom_names=(*together, *(one.element.name for one in hung)),
        freedom_ratio=np.array([*ratio[leaders], *(ratio[one.element.first] for one in hung)]),
        station_values=ratio**2 * np.array([own, damped, held]),
        section_ends=np.array([(one.first, one.second) for one in elements], dtype=np.int64),
        section_names=tuple(one.name for one in elements),
        section_kinds=tuple(one.kind for one in elements),
        section_ratio=element_ratio,
        section_modulus=np.array([one.section_modulus for one in elements], dtype=float),
        section_diameter=np.array([one.diameter for one in elements], dtype=float),
        section_bore=np.array([one.bore for one in elements], dtype=float),
        tensile_strength=np.array([one.tensile_strength for one in elements], dtype=float),
        cylinder_station=cylinder,
        cylinder_freedom=freedom[cylinder],
        gears=_gearings(parts, at, meshes, len(shafts)),
        dampers=tuple(
            Hung(
                name=one.element.name,
                kind=one.kind,
                station=one.element.first,
                carrier=int(freedom[one.element.first]),
                ring=int(place),
                element=len(shafts) + len(meshes) + number,
                inertia=one.inertia,
                stiffness=one.element.stiffness or one.element.speed_stiffness,
                damping=one.element.damping,
            )
            for number, (one, place) in enumerate(zip(hung, ring, strict=True))
        ),
        load_station=load,
        load_freedom=int(freedom[load]),
        taken_station=np.array([at[one.on] for one in parts.loads], dtype=np.int64),
        taken_torque=np.array([one.torque for one in parts.loads], dtype=float),
        taken_exponent=np.array([one.exponent for one in parts.loads], dtype=float),
    )


def _gathered(own: Array | list[float], ratio: Array, freedom: Places, n: int) -> Array:
    """Values by station, referred and summed over those of one freedom."""
    total = np.zeros(n)
    np.add.at(total, freedom, np.asarray(own, dtype=float) * ratio**2)
    return total


def _rings(hung: list[HungElement], ratio: Array, stations: int, n: int) -> Array:
    inertia = np.zeros(n)
    inertia[stations:] = [one.inertia * ratio[one.element.first] ** 2 for one in hung]
    return inertia


def _cylinder_stations(parts: Parts, train: CrankTrain) -> Places:
    at = {
        name: place
        for place, station in enumerate(parts.stations)
        for name in (*station.cylinders, *([station.cylinder] if station.cylinder else []))
    }
    return np.array([at[name] for name in train.names], dtype=np.int64)


def _gearings(
    parts: Parts, at: dict[str, int], meshes: list[Element], shafts: int
) -> tuple[Gearing, ...]:
    found, elastic = [], {one.name: shafts + place for place, one in enumerate(meshes)}
    for gear in parts.gears:
        first, second = gear.between
        name = gear.name or f"{first} - {second}"
        found.append(
            Gearing(
                name=name,
                first=at[first],
                second=at[second],
                ratio=gear_ratio(gear),
                pitch_radius=gear.pitch_radius or 0.0,
                element=elastic.get(name, -1) if gear.mesh_stiffness is not None else -1,
            )
        )
    return tuple(found)
