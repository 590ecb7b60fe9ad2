"""Shaft lines as TORS, the JSON of components that openTorsion reads: reading and writing.

openTorsion 0.3.2, `opentorsion/parser.py` (Aalto-Arotor/openTorsion, MIT), says what a file means:
it goes along the elements of a component and of those that hang on it, and numbers nodes on its
way. A `Disk` is an inertia (kg m^2) with a damping to ground (N m s/rad) on the node where it is; a
`ShaftDiscrete` leads to the next node with stiffness (N m/rad) and damping (N m s/rad); so does a
`ShaftContinuous` by length, outer and inner diameter in mm, of G = 80 GPa and 8000 kg/m^3 unless
`density` says another, without damping. A `GearElement` without parent stands on the node where it
is, one with a `parent` on a node of its own: R theta + R' theta' = 0 with `teeth`, else `diameter`,
as R. Every value is that of its own shaft, none is referred to another.

The format has one way from node to node, and branches behind gears only. What branches off without
a gear here begins with a wheel that turns as its parent does: with R and -R the condition
R theta - R theta' = 0 is a rigid joint. Teeth that are elastic are the shaft k R^2 on the first
shaft and a rigid gear behind it, a ring in oil stands behind a shaft without stiffness.
"""

import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from vibecalc.core.case.raw import nearest
from vibecalc.core.results.visible import fits_a_line
from vibecalc.errors import UsageError

# ----------------------------------------------------------------------------
# The form of a file: elements with their numbers, all that is wrong with them at once.
# ----------------------------------------------------------------------------

LARGEST_FILE = 5_000_000
MOST_PROBLEMS, LARGEST_NUMBER = 8, 1e30
#: of the steel of a ShaftContinuous in openTorsion
SHEAR_MODULUS, DENSITY = 80e9, 8000.0

#: type of an element -> its numbers, smallest value, whether it may be that, what is assumed
NUMBERS: dict[str, dict[str, tuple[float, bool, float | None]]] = {
    "Disk": {"inertia": (0.0, True, None), "damping": (0.0, True, 0.0)},
    "ShaftDiscrete": {"stiffness": (0.0, True, None), "damping": (0.0, True, 0.0)},
    "ShaftContinuous": {
        "length": (0.0, False, None),
        "outerDiameter": (0.0, False, None),
        "innerDiameter": (0.0, True, 0.0),
        "density": (0.0, True, DENSITY),
        "damping": (0.0, True, 0.0),
    },
    "GearElement": {
        "inertia": (0.0, True, 0.0),
        "diameter": (-math.inf, False, None),
        "teeth": (-math.inf, False, None),
        "damping": (0.0, True, 0.0),
    },
}
OTHERS = ("name", "type", "parent", "excitation")
_WANTED = "'components', each with its 'elements', and 'structure', as openTorsion reads them"


class NoAssembly(Exception):
    """What is wrong with a file, a line for each problem."""


def parsed(text: str) -> dict[str, Any]:
    """The file as JSON reads it, with components. Raises NoAssembly."""

    def unrepeated(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in pairs]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise NoAssembly(f"an object of the file has the key {twice[:40]!r} twice")
        return dict(pairs)

    try:
        data = json.loads(text, object_pairs_hook=unrepeated)
    except json.JSONDecodeError as error:
        line = text.splitlines()[error.lineno - 1].strip()[:60] if text.strip() else ""
        raise NoAssembly(
            f"line {error.lineno}, column {error.colno} is not JSON: {line!r}"
            if line
            else "the file is not JSON, it ends too early"
        ) from None
    except (RecursionError, ValueError):  # brackets without end, a number of 5000 digits
        raise NoAssembly("the file is not readable JSON") from None
    if not isinstance(data, dict) or not isinstance(data.get("components"), list):
        found = f"the keys {', '.join(map(repr, list(data)[:6]))}" if isinstance(data, dict) else ""
        raise NoAssembly(
            "the file is JSON and no assembly of openTorsion: it has "
            + (found or f"a {type(data).__name__}")
            + f"; wanted: {_WANTED}"
        )
    return data


def components_of(data: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Components by name. Raises NoAssembly with every problem of their elements."""
    problems: list[str] = []
    found: dict[str, dict[str, Any]] = {}
    for place, one in enumerate(data["components"]):
        where = f"components[{place}]"
        if not isinstance(one, dict) or not _is_name(one.get("name")):
            problems.append(f"{where} has no name of up to 80 letters")
            continue
        where = f"component {one['name'][:40]!r}"
        if one["name"] in found:
            problems.append(f"two components are named {one['name'][:40]!r}")
        elements = one.get("elements")
        if not isinstance(elements, list) or not elements:
            problems.append(f"{where} has no elements")
            continue
        found[one["name"]] = one
        seen: set[tuple[str, str]] = set()
        for number, element in enumerate(elements):
            problems += _problems(element, f"{where}, elements[{number}]", seen)
    if not problems and not found:
        problems.append("the file has no components")
    if not problems and not any(
        element["type"].startswith("Shaft") for one in found.values() for element in one["elements"]
    ):
        problems.append("the assembly has no shaft: nothing twists")
    if problems:
        more = len(problems) - MOST_PROBLEMS
        raise NoAssembly(
            "\n  ".join([*problems[:MOST_PROBLEMS], *([f"and {more} more"] if more > 0 else [])])
        )
    return found


def _problems(element: Any, where: str, seen: set[tuple[str, str]]) -> Iterator[str]:
    """What is wrong with one element."""
    if not isinstance(element, dict):
        yield f"{where} is no element"
        return
    name, kind = element.get("name"), element.get("type")
    group = str(kind)[:5]  # both types of shaft are one group: openTorsion keeps one of a name
    if not isinstance(name, str) or not _is_name(name):
        yield f"{where} has no name of up to 80 letters"
    elif (group, name) in seen:
        yield f"{where}: two elements of a kind are named {name[:40]!r}"
    else:
        seen.add((group, name))
        where = f"{where} {name[:40]!r}"
    if not isinstance(kind, str) or kind not in NUMBERS:
        known = list(NUMBERS)
        hint = nearest(kind, known) if isinstance(kind, str) else ""
        yield f"{where}: type {str(kind)[:40]!r}, wanted one of {', '.join(known)} {hint}".rstrip()
        return
    for key, (least, may_be, default) in NUMBERS[kind].items():
        value = element.get(key, default)
        if value is None and key in ("teeth", "diameter"):
            continue
        if value is None:
            others = [other for other in element if other not in OTHERS]
            yield f"{where} has no {key!r} {nearest(key, others)}".rstrip()
        elif not _is_number(value):
            yield f"{where}: {key} is {str(value)[:40]!r}, no finite number"
        elif abs(value) > LARGEST_NUMBER:
            yield f"{where}: {key} is {value:g}, wanted up to {LARGEST_NUMBER:g}"
        elif value < least or (value == least and not may_be):
            yield f"{where}: {key} is {value:g}, wanted {'>=' if may_be else '>'} {least:g}"
    if kind == "GearElement" and not element.get("teeth" if "teeth" in element else "diameter"):
        yield f"{where} has neither teeth nor a diameter"
    if kind == "ShaftContinuous" and _bore_too_wide(element):
        yield f"{where}: innerDiameter is no smaller than outerDiameter"


def once(name: str, taken: set[Any], group: Any = None) -> str:
    """The name, with a number if it is taken among those of a group; it is taken then."""
    tried, number = name, 2
    while (group, tried) in taken:
        tried, number = f"{name} ({number})", number + 1
    taken.add((group, tried))
    return tried


def _is_name(name: Any) -> bool:
    return isinstance(name, str) and bool(name.strip()) and len(name) <= 80 and fits_a_line(name)


def _is_number(value: Any) -> bool:
    try:
        return (
            isinstance(value, int | float)
            and not isinstance(value, bool)
            and math.isfinite(float(value))
        )
    except OverflowError:
        return False


def _bore_too_wide(element: dict[str, Any]) -> bool:
    both = [element.get(key, 0.0) for key in ("innerDiameter", "outerDiameter")]
    return all(map(_is_number, both)) and bool(both[0] >= both[1] > 0.0)


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
        named = pair if isinstance(pair, list) else []
        ends = [one.split(".") if isinstance(one, str) else [] for one in named]
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


class Twist(NamedTuple):
    """An elastic element between stations `first` and `second`, at the speed of the first.

    Stiffness in N m/rad and damping in N m s/rad. `wheels` are R of the wheels on first and second
    where these are elastic teeth, R of the first is then positive; None for a shaft.
    """

    name: str
    first: int
    second: int
    stiffness: float
    damping: float
    wheels: tuple[float, float] | None = None


class Mesh(NamedTuple):
    """A rigid gear: R theta + R' theta' = 0 of the wheels on stations `first` and `second`."""

    name: str
    first: int
    second: int
    wheels: tuple[float, float]
    key: str


Joint = Twist | Mesh
Numbered = dict[str, Any]


def tors(
    title: str,
    names: Sequence[str],
    inertia: Sequence[float],
    damping: Sequence[float],
    joints: Sequence[Joint],
) -> Numbered:
    """The file of a line: `names`, inertias (kg m^2) and dampings to the ground (N m s/rad) of n
    stations or rings, each at its own speed, and n - 1 joints between them.

    Raises UsageError where joints close a loop, which the format cannot say.
    """
    neighbours: list[list[int]] = [[] for _ in names]
    for place, joint in enumerate(joints):
        neighbours[joint.first].append(place)
        neighbours[joint.second].append(place)
    start = next((n for n, found in enumerate(neighbours) if len(found) <= 1), 0)
    elements: list[Numbered] = []
    work: list[Numbered | tuple[int, int]] = [(start, -1)]
    met: set[int] = set()
    while work:
        one = work.pop()
        if isinstance(one, dict):
            elements.append(one)
            continue
        station, came = one
        if station in met:
            joint = joints[came]
            raise UsageError(
                f"{joint.name!r} between {names[joint.first]!r} and {names[joint.second]!r} closes "
                "a loop of the line, and the JSON of openTorsion has branches only; CSV files "
                "carry it"
            )
        met.add(station)
        disk = {"inertia": float(inertia[station]), "damping": float(damping[station])}
        begin: list[Numbered | tuple[int, int]] = [{"name": names[station], "type": "Disk", **disk}]
        begin += _branches(station, came, names, [(p, joints[p]) for p in neighbours[station]])
        work += reversed(begin)
    _finish(elements)
    return {
        "name": title,
        "components": [{"name": "line", "elements": elements}],
        "structure": [],
    }


def _branches(
    station: int, came: int, names: Sequence[str], there: Sequence[tuple[int, Joint]]
) -> "list[Numbered | tuple[int, int]]":
    """Wheels on a station, what goes straight on from it, and its branches behind their wheels."""
    straight: list[Numbered | tuple[int, int]] = []
    branches: list[Numbered | tuple[int, int]] = []
    wheels: list[Numbered] = []
    root: Numbered | None = None
    for place, joint in there:
        if place == came:
            continue
        ahead = joint.first == station
        other = joint.second if ahead else joint.first
        if isinstance(joint, Mesh):
            own, far = joint.wheels if ahead else joint.wheels[::-1]
            wheels.append(_wheel(f"{names[station]}, {joint.name}", own, joint.key))
            child = _wheel(joint.name, far, joint.key, wheels[-1])
            branches += [child, (other, place)]
            continue
        name = joint.name if joint.wheels is None else f"{joint.name}, teeth"
        leads: list[Numbered | tuple[int, int]] = [_shaft(joint._replace(name=name))]
        if joint.wheels is None:
            leads.append((other, place))
        elif ahead:
            front = _wheel(f"{joint.name}, first", joint.wheels[0], "diameter")
            back = _wheel(joint.name, joint.wheels[1], "diameter", front)
            leads += [front, back, (other, place)]
        else:
            wheels.append(_wheel(f"{joint.name}, first", joint.wheels[1], "diameter"))
            child = _wheel(joint.name, joint.wheels[0], "diameter", wheels[-1])
            branches += [child, *leads, (other, place)]
            continue
        if not straight:
            straight = leads
            continue
        if root is None:
            root = _wheel(f"{names[station]}, branches", 1.0, "diameter")
            wheels.append(root)
        branches += [_wheel(f"{joint.name}, branch", -1.0, "diameter", root), *leads]
    return [*wheels, *straight, *branches]


def _shaft(joint: Twist) -> Numbered:
    values = {"stiffness": float(joint.stiffness), "damping": float(joint.damping)}
    return {"name": joint.name, "type": "ShaftDiscrete", **values}


def _wheel(name: str, size: float, key: str, parent: Numbered | None = None) -> Numbered:
    """A wheel; its parent is named when all elements have their names."""
    child = {} if parent is None else {"parent": parent}
    return {"name": name, "type": "GearElement", "inertia": 0.0, key: size, **child}


def _finish(elements: list[Numbered]) -> None:
    """Number the names that come again among disks, shafts or wheels; name the parents of wheels.

    openTorsion keeps one element of a name and a type only.
    """
    taken: set[Any] = set()
    for one in elements:
        one["name"] = once(one["name"], taken, one["type"])
    for one in elements:
        if "parent" in one:
            one["parent"] = one["parent"]["name"]
