"""Checks of form that take two keys of a case: one way or the other, from below to, doubled names.

They work on the case as tomllib reads it, so that they also run where the schema found problems;
what they cannot read they leave to the schema.
"""

from collections.abc import Callable, Iterator
from typing import Any

from vibecalc.core.case.raw import Data, either, misspelt, table_at, tables_at
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.kinds import check_kinds
from vibecalc.parts.rules import check_parts
from vibecalc.units import si_value, split_number


def cross_check(data: Data) -> list[Problem]:
    """Return all problems between keys of a case; never raises on nonsense."""
    return [problem for check in _CHECKS for problem in check(data)]


def _masses(data: Data) -> Iterator[Problem]:
    path: KeyPath = ("machine", "crank_train")
    train = table_at(data, *path)
    if not train:
        return
    cylinders = tables_at(data, "machine", "crank_train", "cylinders")
    key, ways = "reciprocating_mass", ("piston_mass", "pin_mass", "rod")
    own = bool(cylinders) and all(key in entry for _, entry in cylinders)
    if not (own or train.keys() & {key, *ways}):
        meant = [misspelt(entry, (*path, "cylinders", place), key) for place, entry in cylinders]
        own = any(meant)  # which is told of the misspelt key
    yield from either(train, path, key, ways, needed=not own)
    parts = [key for key in ("pin_mass", "rod") if key in train]
    if parts and "piston_mass" not in train and "reciprocating_mass" not in train and not own:
        yield Problem(
            path=(*path, parts[0]),
            message=f"{parts[0]} without piston_mass",
            allowed="piston_mass, with pin_mass and rod where they count",
        )
    rod = train.get("rod")
    if isinstance(rod, dict):
        one = "crank_pin_to_mass_centre"
        yield from either(rod, (*path, "rod"), one, ("reciprocating_fraction",))


def _kinematics(data: Data) -> Iterator[Problem]:
    table = table_at(data, "kinematics")
    truncated = table.get("series") == "truncated"
    if truncated and "terms" not in table:
        yield Problem(
            path=("kinematics",),
            message="a truncated series needs its number of terms",
            allowed="terms = 1 for the classic first and second order, or more",
        )
    if "terms" in table and not truncated:
        yield Problem(
            path=("kinematics", "terms"),
            message="terms belong to a truncated series",
            allowed='series = "truncated"',
            also=("kinematics", "series") if "series" in table else None,
        )


_NAMED: tuple[tuple[str, ...], ...] = (
    ("machine", "crank_train", "cylinders"),
    ("machine", "mounts", "individual"),
    ("response", "operations"),
    ("response", "balances"),
    ("machine", "shaft_line", "stations"),
    ("machine", "shaft_line", "shafts"),
    ("machine", "shaft_line", "gears"),
    ("machine", "shaft_line", "dampers"),
)


def _names(data: Data) -> Iterator[Problem]:
    for path in _NAMED:
        seen: dict[str, int] = {}
        for position, entry in tables_at(data, *path):
            name = entry.get("name")
            if not isinstance(name, str):
                continue
            if name in seen:
                yield Problem(
                    path=(*path, position, "name"),
                    message=f"two entries of {path[-1]} are named {name[:60]!r}",
                    hint="give each its own name",
                    also=(*path, seen[name], "name"),
                )
            seen.setdefault(name, position)


def _references(data: Data) -> Iterator[Problem]:
    for position, reference in tables_at(data, "reference"):
        path: KeyPath = ("reference", position)
        yield from either(reference, path, "rtol", ("atol",), needed=False)
        unit = reference.get("unit")
        value = reference.get("value")
        if unit and isinstance(unit, str) and isinstance(value, str) and _unit_of(value):
            yield Problem(
                path=(*path, "unit"),
                message="the unit stands twice",
                found=f"value = {value!r} and unit = {unit!r}",
                also=(*path, "value"),
            )


def _si_value(value: Any) -> float | None:
    if value is None or isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return si_value(value)
    except (UnitError, OverflowError):
        return None


def _unit_of(value: str) -> str:
    try:
        return split_number(value)[1]
    except UnitError:
        return ""


def _limits(data: Data) -> Iterator[Problem]:
    bounds: dict[str, dict[str, tuple[float, KeyPath]]] = {}
    for position, limit in tables_at(data, "limit"):
        path: KeyPath = ("limit", position)
        if "max" not in limit and "min" not in limit:
            yield Problem(
                path=path,
                message="a limit needs max or min",
                allowed='max = "100 N", or min, or both',
            )
        if limit.get("expect") == "broken":
            continue
        where = limit.get("where")
        entries = sorted(map(repr, where.items())) if isinstance(where, dict) else []
        place = repr((limit.get("quantity"), entries, limit.get("at", "optimum")))
        for key, sign in (("max", 1.0), ("min", -1.0)):
            value = _si_value(limit.get(key))
            mine = bounds.setdefault(place, {})
            if value is not None and (key not in mine or sign * value < sign * mine[key][0]):
                mine[key] = (value, (*path, key))
    for pair in bounds.values():
        if len(pair) == 2 and pair["min"][0] > pair["max"][0]:
            (_, low), (_, high) = pair["min"], pair["max"]
            first, second = sorted((low, high), key=lambda path: path[1])
            yield Problem(
                path=second,
                message="two bounds contradict each other: no value can keep both",
                found=f"min = {_shown(data, low)} and max = {_shown(data, high)}",
                allowed="min <= max",
                also=first,
            )


def _shown(data: Data, path: KeyPath) -> str:
    name, position, key = path
    return repr(data[str(name)][position][key])[:60]


def _optimisation(data: Data) -> Iterator[Problem]:
    if isinstance(data.get("optimisation"), dict):
        from vibecalc.core.case.search_checks import check_variables

        yield from check_variables(data)


def _find(data: Data) -> Iterator[Problem]:
    if "find" in data:
        from vibecalc.core.case.search_checks import check_find

        yield from check_find(data)


def _drive(data: Data) -> Iterator[Problem]:
    if isinstance(table_at(data, "machine").get("motor"), dict):
        from vibecalc.parts.drive_rules import check_motor

        yield from check_motor(data)


def _asked(data: Data) -> Iterator[Problem]:
    if data.keys() & {"isolation", "response", "reference_table"}:
        from vibecalc.response.form import check_asked

        yield from check_asked(data)


_CHECKS: tuple[Callable[[Data], Iterator[Problem]], ...] = (
    check_kinds,
    _drive,
    _masses,
    check_parts,
    _asked,
    _kinematics,
    _names,
    _references,
    _limits,
    _optimisation,
    _find,
)
