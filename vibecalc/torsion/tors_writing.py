"""A shaft line as TORS, the JSON that openTorsion reads (`tors_reading.py` says what it means).

The format has one way from node to node, and branches behind gears only. What branches off without
a gear here begins with a wheel that turns as its parent does: with R and -R the condition
R theta - R theta' = 0 is a rigid joint. Teeth that are elastic are the shaft k R^2 on the first
shaft and a rigid gear behind it, a ring in oil stands behind a shaft without stiffness.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from vibecalc.errors import UsageError
from vibecalc.torsion.tors_form import once


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
