"""Shaft lines that openTorsion reads: TORS, its JSON of components, as stations, shafts, gears.

openTorsion 0.3.2, `opentorsion/parser.py` (Aalto-Arotor/openTorsion, MIT), says what a file means:
it goes along the elements of a component and of those that hang on it, and numbers nodes on its
way. A `Disk` is an inertia (kg m^2) with a damping to ground (N m s/rad) on the node where it is; a
`ShaftDiscrete` leads to the next node with stiffness (N m/rad) and damping (N m s/rad); so does a
`ShaftContinuous` by length, outer and inner diameter in mm, of G = 80 GPa and 8000 kg/m^3 unless
`density` says another, without damping. A `GearElement` without parent stands on the node where it
is, one with a `parent` on a node of its own: R theta + R' theta' = 0 with `teeth`, else `diameter`,
as R. Every value is that of its own shaft, none is referred to another.
"""

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

from vibecalc.core.case.raw import nearest
from vibecalc.core.results.visible import fits_a_line
from vibecalc.torsion.tors_form import (
    NUMBERS,
    OTHERS,
    SHEAR_MODULUS,
    NoAssembly,
    components_of,
    once,
    parsed,
)

# ----------------------------------------------------------------------------
# What is read, in the words of a case.
# ----------------------------------------------------------------------------


class LineRead(NamedTuple):
    """Tables of a shaft line as a case has them, values as texts with units, and remarks."""

    title: str
    stations: list[dict[str, Any]]
    shafts: list[dict[str, Any]]
    gears: list[dict[str, Any]]
    dampers: list[dict[str, Any]]
    remarks: list[str]


class Element(NamedTuple):
    """One element of a component, with the name that it has in a case."""

    own: str
    component: str
    kind: str
    numbers: dict[str, float]
    parent: str | None
    name: str = ""


def read_assembly(text: str) -> LineRead:
    """The shaft line of a TORS file. Raises NoAssembly with all that is wrong with its form."""
    data, remarks = parsed(text), list[str]()
    components = components_of(data)
    line = _Line(remarks)
    for element in _named(list(_walk(components, _order(data), remarks)), len(components) == 1):
        line.add(element)
    title = data.get("name")
    named = isinstance(title, str) and bool(title.strip()) and fits_a_line(title)
    return line.read(str(title) if named else "a shaft line")


# ----------------------------------------------------------------------------
# The way along the components, as openTorsion goes it.
# ----------------------------------------------------------------------------


def _order(data: dict[str, Any]) -> dict[str, dict[str, str]]:
    """Component -> element -> the component that hangs on it."""
    structure = data.get("structure", [])
    found: dict[str, dict[str, str]] = {}
    for place, pair in enumerate(structure if isinstance(structure, list) else [structure]):
        ends = [one.split(".") for one in pair if isinstance(one, str)] if _is_pair(pair) else []
        if [len(end) for end in ends] != [2, 2]:
            raise NoAssembly(
                f"structure[{place}] is {str(pair)[:60]!r}, wanted two texts "
                "'component.element', where no name has a point"
            )
        (one, element), (other, _) = ends
        hanging = found.setdefault(one, {})
        if element in hanging:
            raise NoAssembly(
                f"structure: two components hang on '{one[:40]}.{element[:40]}'; openTorsion "
                "reads one of them only"
            )
        hanging[element] = other
    return found


def _is_pair(pair: Any) -> bool:
    return isinstance(pair, list) and len(pair) == 2


def _walk(
    components: dict[str, dict[str, Any]], order: dict[str, dict[str, str]], remarks: list[str]
) -> Iterator[Element]:
    """Elements without their names, in the order of nodes."""
    hanging = [other for elements in order.values() for other in elements.values()]
    for name in [*order, *hanging]:
        if name not in components:
            raise NoAssembly(
                f"structure: no component is named {name[:40]!r} "
                f"{nearest(name, list(components))}".rstrip()
            )
    starts = [name for name in components if name not in hanging]
    if len(starts) != 1:
        raise NoAssembly(
            f"the assembly is in {len(starts)} pieces, which begin with "
            + ", ".join(repr(name[:40]) for name in starts[:6])
            if starts
            else "the components hang on each other in a loop: openTorsion finds no first one"
        )
    for carrier, hung in order.items():
        names = [element["name"] for element in components[carrier]["elements"]]
        for name in hung:
            if name not in names:
                raise NoAssembly(
                    f"structure: component {carrier[:40]!r} has no element {name[:40]!r} "
                    f"{nearest(name, names)}".rstrip()
                )
    left_out: set[str] = set()
    went, stack = {starts[0]}, [(components[starts[0]], 0)]
    while stack:
        one, place = stack.pop()
        if place >= len(one["elements"]):
            continue
        element = one["elements"][place]
        stack.append((one, place + 1))
        kind = element["type"]
        numbers = {
            key: float(element.get(key, default))
            for key, (_, _, default) in NUMBERS[kind].items()
            if element.get(key, default) is not None
        }
        left_out |= {key for key in element if key not in (*NUMBERS[kind], *OTHERS)}
        left_out |= {"excitation"} & element.keys()
        if kind in ("ShaftContinuous", "GearElement") and numbers["damping"]:
            left_out.add(f"damping of a {kind}, which openTorsion does not read either")
        parent = element.get("parent") if kind == "GearElement" else None
        before = [
            other["name"] for other in one["elements"][:place] if other["type"] == "GearElement"
        ]
        if parent is not None and parent not in before:
            raise NoAssembly(
                f"component {one['name'][:40]!r}: gear {element['name'][:40]!r} has the parent "
                f"{str(parent)[:40]!r}, and no gear before it has that name"
            )
        yield Element(element["name"], one["name"], kind, numbers, parent)
        other = order.get(one["name"], {}).get(element["name"])
        if other is None:
            continue
        if other in went:
            raise NoAssembly(f"component {other[:40]!r} hangs on two others: the line has a loop")
        follows = one["elements"][place + 1 : place + 2]
        if follows and follows[0].get("parent") is None:
            raise NoAssembly(
                f"component {other[:40]!r} hangs on '{one['name'][:40]}.{element['name'][:40]}', "
                f"and {follows[0]['name'][:40]!r} comes behind it: openTorsion would put that at "
                "the far end of what hangs there; only the end of a branch can carry a component"
            )
        went.add(other)
        stack.append((components[other], 0))
    astray = [name for name in components if name not in went]
    if astray:
        raise NoAssembly(f"nothing joins component {astray[0][:40]!r} to the line")
    if left_out:
        said = sorted(key[:80] if fits_a_line(key) else ascii(key[:80]) for key in left_out)
        remarks.append("not carried: " + ", ".join(said[:12]) + ", ..." * (len(said) > 12))


def _named(elements: list[Element], alone: bool) -> Iterator[Element]:
    """With names, each once among what is of its kind: short where there is no doubt."""
    size = Counter(one.component for one in elements)
    taken: set[Any] = set()
    for one in elements:
        name = one.own if alone else one.component
        if not alone and size[one.component] > 1:
            name = f"{one.component}, {one.own}"
        # stations, and sections: shafts and gears
        yield one._replace(name=once(name.strip()[-70:].strip(), taken, one.kind == "Disk"))


# ----------------------------------------------------------------------------
# Nodes to stations, elements to shafts, gears and dampers.
# ----------------------------------------------------------------------------


class _Station:
    def __init__(self) -> None:
        self.inertia = self.damping = 0.0
        self.name, self.gear = "", ""


class _Line:
    """A line on the way along its elements."""

    def __init__(self, remarks: list[str]) -> None:
        self.remarks, self.stations, self.at = remarks, [_Station()], 0
        self.shafts: list[tuple[int, int, Element]] = []
        self.gears: list[tuple[int, int, Element, Element]] = []
        self.on: dict[tuple[str, str], tuple[int, Element]] = {}
        self.from_shafts = 0.0

    def add(self, one: Element) -> None:
        """The next element."""
        if one.kind.startswith("Shaft"):
            self.stations.append(_Station())
            self.shafts.append((self.at, len(self.stations) - 1, one))
            self._spread(one)
            self.at = len(self.stations) - 1
            return
        if one.kind == "GearElement":
            self._gear(one)
            self.stations[self.at].gear = self.stations[self.at].gear or one.name
        else:
            self.stations[self.at].name = self.stations[self.at].name or one.name
            self.stations[self.at].damping += one.numbers["damping"]
        self.stations[self.at].inertia += one.numbers["inertia"]

    def _spread(self, one: Element) -> None:
        """Half the inertia of a round shaft to each of its ends."""
        if one.kind != "ShaftContinuous":
            return
        length, outer, inner = (
            1e-3 * one.numbers[key] for key in ("length", "outerDiameter", "innerDiameter")
        )
        inertia = one.numbers["density"] * math.pi * (outer**4 - inner**4) / 32.0 * length
        self.from_shafts += inertia
        for place in (self.at, len(self.stations) - 1):
            self.stations[place].inertia += 0.5 * inertia

    def _gear(self, one: Element) -> None:
        """A wheel where the line is, or the first of a branch; one of -R turns as its parent."""
        if one.parent is not None:
            place, parent = self.on[one.component, one.parent]
            if ("teeth" in one.numbers) != ("teeth" in parent.numbers):
                raise NoAssembly(
                    f"gears {parent.name[:40]!r} and {one.name[:40]!r}: one has teeth, the other a "
                    "diameter alone; openTorsion would take the one for the other"
                )
            self.at = place
            if _size(one) != -_size(parent):
                self.stations.append(_Station())
                self.at = len(self.stations) - 1
                self.gears.append((place, self.at, parent, one))
        self.on[one.component, one.own] = self.at, one

    def read(self, title: str) -> LineRead:
        """Tables of all that was added."""
        taken: set[Any] = set()
        names = [
            once(one.name or one.gear or f"node {place}", taken)
            for place, one in enumerate(self.stations)
        ]
        loose = [shaft for shaft in self.shafts if shaft[2].numbers.get("stiffness") == 0.0]
        dampers, rings = [], set()
        for first, second, one in loose:
            carrier, ring = self._ring(first, second, one)
            rings.add(ring)
            dampers.append(
                {
                    "name": names[ring],
                    "on": names[carrier],
                    "kind": "viscous",
                    "inertia": _text(self.stations[ring].inertia, "kg*m^2"),
                    "damping": _text(one.numbers["damping"], "N*m*s/rad"),
                }
            )
        stations = []
        for place, (station, name) in enumerate(zip(self.stations, names, strict=True)):
            if place not in rings:
                stations.append({"name": name, "inertia": _text(station.inertia, "kg*m^2")})
                if station.damping:
                    stations[-1]["absolute_damping"] = _text(station.damping, "N*m*s/rad")
        if self.from_shafts:
            self.remarks.append(
                f"the inertia of round shafts, {self.from_shafts:.4g} kg*m^2 in "
                "all, is put on their stations, half to each end; openTorsion spreads it along "
                "them with a consistent mass matrix. Natural frequencies differ where it counts "
                "against the inertia of the stations: cut such shafts into several"
            )
        return LineRead(
            title=title,
            stations=stations,
            shafts=[self._shaft(*one, names) for one in self.shafts if one not in loose],
            gears=[_gear_table(names[a], names[b], p, c) for a, b, p, c in self.gears],
            dampers=dampers,
            remarks=self.remarks,
        )

    def _ring(self, first: int, second: int, one: Element) -> tuple[int, int]:
        """Carrier and ring of a shaft without stiffness: a damper, if nothing else is on the ring.

        A ring has no damping of its own against the ground.
        """
        ends = [place for a, b, _ in self.shafts for place in (a, b)]
        ends += [place for a, b, _, _ in self.gears for place in (a, b)]
        for carrier, ring in ((first, second), (second, first)):
            station = self.stations[ring]
            if ends.count(ring) == 1 and station.inertia > 0.0 and not station.damping:
                return carrier, ring
        raise NoAssembly(
            f"shaft {one.name[:40]!r} has no stiffness: that holds nothing but the ring of a "
            "damper, alone at its end, with an inertia and without damping to the ground"
        )

    def _shaft(self, first: int, second: int, one: Element, names: list[str]) -> dict[str, Any]:
        table: dict[str, Any] = {"name": one.name, "between": [names[first], names[second]]}
        if one.kind == "ShaftContinuous":
            keys = ("outerDiameter", "innerDiameter", "length")
            section = {_SNAKE[key]: _text(one.numbers[key], "mm") for key in keys}
            return table | {"section": section | {"shear_modulus": _text(SHEAR_MODULUS, "Pa")}}
        table["stiffness"] = _text(one.numbers["stiffness"], "N*m/rad")
        if one.numbers["damping"]:
            table["damping"] = _text(one.numbers["damping"], "N*m*s/rad")
        return table


_SNAKE = {
    "outerDiameter": "outer_diameter",
    "innerDiameter": "inner_diameter",
    "length": "length",
}


def _text(number: float, unit: str) -> str:
    return f"{number!r} {unit}"


def _size(gear: Element) -> float:
    """R of R theta + R' theta' = 0, negative for a wheel with teeth inside."""
    return gear.numbers["teeth"] if "teeth" in gear.numbers else gear.numbers["diameter"]


def _gear_table(first: str, second: str, parent: Element, child: Element) -> dict[str, Any]:
    one, other = _size(parent), _size(child)
    table: dict[str, Any] = {"name": child.name, "between": [first, second]}
    if "teeth" in parent.numbers and min(abs(one), abs(other)) >= 3.0 and one % 1 == other % 1 == 0:
        table["teeth"] = [round(abs(one)), round(abs(other))]
    elif abs(one) == 1.0:  # the ratio as it stands, not one over it
        table |= {"between": [second, first], "ratio": abs(other)}
    else:
        table["ratio"] = abs(one / other)
    return table if one * other > 0.0 else table | {"reverses": False}
