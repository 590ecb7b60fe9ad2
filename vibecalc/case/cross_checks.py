"""Checks of form that take two keys of a case: one way or the other, from below to, doubled names.

They work on the case as tomllib reads it, so that they also run where the schema found problems;
what they cannot read they leave to the schema.
"""

from collections.abc import Callable, Iterator
from typing import Any

from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import parse_quantity, si_value, split_number

Data = dict[str, Any]


def cross_check(data: Data) -> list[Problem]:
    """Return all problems between keys of a case; never raises on nonsense."""
    return [problem for check in _CHECKS for problem in check(data)]


def _table(data: Any, *path: str | int) -> Any:
    """Return what stands at a path, or an empty table if it is no such thing."""
    for part in path:
        if isinstance(part, str):
            data = data.get(part) if isinstance(data, dict) else None
        else:
            data = data[part] if isinstance(data, list) and part < len(data) else None
    return data if isinstance(data, dict) else {}


def _tables(data: Any, *path: str) -> list[tuple[int, Data]]:
    entries = _table(data, *path[:-1]).get(path[-1])
    if not isinstance(entries, list):
        return []
    return [(position, entry) for position, entry in enumerate(entries) if isinstance(entry, dict)]


def _read(value: Any, unit: str) -> float | None:
    if value is None or isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return parse_quantity(value, unit)
    except (UnitError, OverflowError):
        return None


def _either(
    table: Data, path: KeyPath, one: str, others: tuple[str, ...], needed: bool = True
) -> Iterator[Problem]:
    """`one`, or some of `others`: not both, and, if `needed`, not none of them."""
    given = [key for key in others if key in table]
    listed = " and ".join(filter(None, (", ".join(others[:-1]), others[-1])))
    if one in table and given:
        yield Problem(
            path=(*path, given[0]),
            message=f"{given[0]} and {one} exclude each other",
            allowed=f"{one}, or {listed}: one way or the other",
            also=(*path, one),
        )
    elif needed and one not in table and not given:
        yield Problem(
            path=path,
            message=f"[{'.'.join(map(str, path))}] has neither {one} nor {listed}",
            allowed=f"{one}, or {listed}",
        )


def _masses(data: Data) -> Iterator[Problem]:
    path: KeyPath = ("machine", "crank_train")
    train = _table(data, *path)
    if not train:
        return
    cylinders = _tables(data, "machine", "crank_train", "cylinders")
    own = bool(cylinders) and all("reciprocating_mass" in entry for _, entry in cylinders)
    ways = ("piston_mass", "pin_mass", "rod")
    yield from _either(train, path, "reciprocating_mass", ways, needed=not own)
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
        yield from _either(rod, (*path, "rod"), one, ("reciprocating_fraction",))


def _body(data: Data) -> Iterator[Problem]:
    path: KeyPath = ("machine", "body")
    body = _table(data, *path)
    if not body:
        return
    yield from _either(body, path, "inertia", ("box",))
    products = body.get("inertia_products")
    entries = products if isinstance(products, list) else []
    if "box" in body and any(_read(entry, "kg*m^2") for entry in entries):
        yield Problem(
            path=(*path, "inertia_products"),
            message="inertia_products go with inertia: a box has none",
            also=(*path, "box"),
        )


def _mounts(data: Data) -> Iterator[Problem]:
    path: KeyPath = ("machine", "mounts")
    mounts = _table(data, "machine").get("mounts")
    if not isinstance(mounts, dict):  # an empty table asks for mounts and has none
        return
    yield from _either(mounts, path, "positions", ("individual",))
    each = _table(mounts, "each")
    if "each" in mounts and not isinstance(mounts["each"], dict):
        return
    if "positions" in mounts and "stiffness" not in each:
        yield Problem(
            path=(*path, "each") if each else path,
            message="mounts given by positions have no stiffness",
            allowed="each = { stiffness = ... }",
        )
    for position, mount in _tables(data, "machine", "mounts", "individual"):
        if "stiffness" not in mount and "stiffness" not in each:
            yield Problem(
                path=(*path, "individual", position),
                message=f"mount {mount.get('name', position + 1)!r} has no stiffness",
                allowed="a stiffness of its own, or one in [machine.mounts.each]",
            )


def _isolation(data: Data) -> Iterator[Problem]:
    if not isinstance(data.get("isolation"), dict):
        return
    machine = _table(data, "machine")
    for part in ("body", "mounts"):
        if machine and part not in machine:
            yield Problem(
                path=("isolation",),
                message=f"[isolation] needs [machine.{part}]",
                hint="leave [isolation] out for forces and balance only",
            )
    run_up = _table(data, "isolation", "run_up")
    start, stop = _read(run_up.get("from", 0), "rad/s"), _read(run_up.get("to"), "rad/s")
    if start is not None and stop is not None and not start < stop:
        yield Problem(
            path=("isolation", "run_up", "from"),
            message="a run-up goes from a lower speed to a higher one",
            found=f"from {run_up.get('from', 0)} to {run_up.get('to')}",
            allowed="from < to",
        )


def _kinematics(data: Data) -> Iterator[Problem]:
    table = _table(data, "kinematics")
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


def _names(data: Data) -> Iterator[Problem]:
    for path in (("machine", "crank_train", "cylinders"), ("machine", "mounts", "individual")):
        seen: dict[str, int] = {}
        for position, entry in _tables(data, *path):
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
    for position, reference in _tables(data, "reference"):
        path: KeyPath = ("reference", position)
        yield from _either(reference, path, "rtol", ("atol",), needed=False)
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
    for position, limit in _tables(data, "limit"):
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
        from vibecalc.case.variable_checks import check_variables

        yield from check_variables(data)


_CHECKS: tuple[Callable[[Data], Iterator[Problem]], ...] = (
    _masses,
    _body,
    _mounts,
    _isolation,
    _kinematics,
    _names,
    _references,
    _limits,
    _optimisation,
)
