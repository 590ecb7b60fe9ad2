"""Checks of form of a shaft line: each number said once, shafts from station to station."""

from collections.abc import Iterator

from vibecalc.case.raw import Data, either, misspelt, tables_at
from vibecalc.errors import KeyPath, Problem

LINE: KeyPath = ("machine", "shaft_line")
#: kind of damper -> keys that it needs, keys that it may have beside them
DAMPERS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "viscous": (("inertia", "damping"), ()),
    "spring": (("inertia", "stiffness"), ("damping", "loss_factor")),
    "pendulum": (("order", "mass", "arm_radius"), ("damping", "count")),
}
#: values of keys that say nothing: a resolved case holds them for every kind
_SILENT = {"loss_factor": 0.0, "count": 1, "damping": 0.0}


def check_shaft_line(data: Data) -> Iterator[Problem]:
    """Yield what stations, shafts, gears and dampers lack or say twice."""
    for place, station in tables_at(data, *map(str, LINE), "stations"):
        path: KeyPath = (*LINE, "stations", place)
        yield from _named(station, path, "station")
        yield from _one_of(station, path, "inertia", ("throw",))
        yield from either(station, path, "cylinder", ("cylinders",), needed=False)
        throw = station.get("throw")
        ends = [key for key in ("beyond_journal", "beyond_pin") if key in (throw or {})]
        if isinstance(throw, dict) and len(ends) == 1:
            yield Problem(
                path=(*path, "throw", ends[0]),
                message=f"{ends[0]} alone: a rectangular web has two ends",
                allowed="beyond_journal and beyond_pin, or neither for half discs at both ends",
            )
    shafts = tables_at(data, *map(str, LINE), "shafts")
    for place, shaft in shafts:
        path = (*LINE, "shafts", place)
        yield from _one_of(shaft, path, "stiffness", ("section", "throw"))
        yield from either(shaft, path, "damping", ("damping_ratio",), needed=False)
        yield from either(shaft, path, "diameter", ("section_modulus",), needed=False)
    said = [place for place, shaft in shafts if "between" in shaft]
    if said and len(said) < len(shafts):
        silent = next(place for place, shaft in shafts if "between" not in shaft)
        yield Problem(
            path=(*LINE, "shafts", silent),
            message="this shaft does not say between which stations it is, and others do",
            allowed="between = ['first', 'second'] for every shaft, or for none",
            also=(*LINE, "shafts", said[0], "between"),
        )
    for place, gear in tables_at(data, *map(str, LINE), "gears"):
        path = (*LINE, "gears", place)
        yield from _one_of(gear, path, "ratio", ("teeth",))
        if "mesh_stiffness" in gear and "pitch_radius" not in gear:
            yield Problem(
                path=(*path, "mesh_stiffness"),
                message="mesh_stiffness needs pitch_radius: it is along the line of action",
                allowed="pitch_radius of the first wheel beside it",
            )
    for place, damper in tables_at(data, *map(str, LINE), "dampers"):
        yield from _damper(damper, (*LINE, "dampers", place))


def _named(station: Data, path: KeyPath, what: str) -> Iterator[Problem]:
    """A station without a name is told by the schema; one of blanks alone is not."""
    name = station.get("name")
    if isinstance(name, str) and name and not name.strip():
        yield Problem(
            path=(*path, "name"),
            message=f"the {what} has a name of blanks",
            allowed="a name that can be read",
        )


def _one_of(table: Data, path: KeyPath, one: str, others: tuple[str, ...]) -> Iterator[Problem]:
    """Exactly one of these keys."""
    yield from either(table, path, one, others)
    given = [key for key in others if key in table]
    if one not in table and len(given) > 1:
        yield Problem(
            path=(*path, given[1]),
            message=f"{given[1]} and {given[0]} exclude each other",
            allowed=f"one of {', '.join((one, *others))}",
            also=(*path, given[0]),
        )


def _damper(damper: Data, path: KeyPath) -> Iterator[Problem]:
    kind = damper.get("kind")
    if not isinstance(kind, str) or kind not in DAMPERS:
        return
    needed, other = DAMPERS[kind]
    missing = [key for key in needed if key not in damper and not misspelt(damper, path, key)]
    if missing:
        yield Problem(
            path=path,
            message=f"a damper of kind {kind!r} needs {' and '.join(missing)}",
            allowed=", ".join((*needed, *other)),
            also=(*path, "kind"),
        )
    known = {key for row in DAMPERS.values() for keys in row for key in keys}
    for key in damper:
        said = key in known and damper[key] != _SILENT.get(key)
        if said and key not in (*needed, *other):
            yield Problem(
                path=(*path, key),
                message=f"a damper of kind {kind!r} has no {key}",
                allowed=", ".join((*needed, *other)),
                also=(*path, "kind"),
            )
