"""References, limits and objectives against the plan: do the results they name exist?"""

import difflib
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from vibecalc.case.kinds import has_crank_train
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.pipeline.catalogue import AXES, CATALOGUE
from vibecalc.pipeline.entries.entry import Entry
from vibecalc.pipeline.numeric_entries import missing_entries
from vibecalc.pipeline.plan import planned_quantities

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def check_targets(case: "Case", extra: Mapping[str, Entry] | None = None) -> list[Problem]:
    """Problems of every quantity, axis, entry and unit that the case names.

    `extra` holds paths beside the stages' own (what a study adds).
    """
    planned = planned_quantities(case)
    known = {**planned, **(extra or {})}
    problems: list[Problem] = []
    for index, reference in enumerate(case.reference):
        path: KeyPath = ("reference", index)
        problems += _check_name(path, reference.quantity, reference.where, known, case)
        for key, value in (("value", reference.value), ("atol", reference.atol)):
            problems += _check_unit((*path, key), value, reference.quantity, known, reference.unit)
    for index, limit in enumerate(case.limit):
        path = ("limit", index)
        problems += _check_name(path, limit.quantity, limit.where, known, case)
        for key, value in (("max", limit.max), ("min", limit.min)):
            problems += _check_unit((*path, key), value, limit.quantity, known)
    for index, search in enumerate(case.find):
        path = ("find", index)
        problems += _check_name(path, search.quantity, search.where, planned, case)
        for key, value in (("target", search.target), ("change", search.change)):
            problems += _check_unit((*path, key), value, search.quantity, planned)
    if case.optimisation:
        goal = case.optimisation.objective
        problems += _check_name(
            ("optimisation", "objective"), goal.quantity, goal.where, known, case
        )
    return problems


def _check_name(
    path: KeyPath,
    quantity: str,
    where: Mapping[str, int | float | str],
    known: Mapping[str, Entry],
    case: "Case",
) -> Iterator[Problem]:
    entry = known.get(quantity)
    if entry is None:
        yield unknown_quantity(path, quantity, known)
        return
    names = _names(case)
    for axis, value in where.items():
        if axis not in entry.axes:
            allowed = ", ".join(entry.axes) or "no axes: it is one number"
            yield Problem(
                path=(*path, "where"),
                message=f"{quantity} has no axis {axis!r}",
                found=axis,
                allowed=allowed,
                hint=_nearest(axis, entry.axes),
            )
        elif axis in names and str(value) not in names[axis]:  # a CSV file has 3 for "3"
            yield Problem(
                path=(*path, "where"),
                message=f"there is no {axis} named {value!r}",
                found=repr(value),
                allowed=", ".join(repr(name) for name in names[axis]),
                hint=_nearest(str(value), names[axis]),
            )
    if case.sweep is None:  # which may change them, and computes no references
        own = {axis: value for axis, value in where.items() if axis in entry.axes}
        yield from missing_entries(path, quantity, own, case)


def unknown_quantity(path: KeyPath, quantity: str, known: Mapping[str, Entry]) -> Problem:
    """The problem of a table at `path` that names none of the `known` quantities."""
    if quantity in CATALOGUE:
        hint = "vibecalc can compute it, but no table of this case asks for it"
        if "run_up" in quantity:
            hint += "; add run_up to [isolation]"
    else:
        hint = _nearest(quantity, tuple(known))
    return Problem(
        path=(*path, "quantity"),
        message="this case does not compute such a quantity",
        found=quantity,
        allowed="a path that `vibecalc check` lists",
        hint=hint,
    )


def _check_unit(
    path: KeyPath,
    value: float | str | None,
    quantity: str,
    known: Mapping[str, Entry],
    unit: str = "",
) -> Iterator[Problem]:
    from vibecalc.units import parse_quantity

    entry = known.get(quantity)
    if entry is None or value is None:
        return
    try:
        parse_quantity(f"{value} {unit}" if unit else str(value), entry.unit)
    except UnitError as error:
        yield Problem(
            path=path,
            message=f"does not fit {quantity}",
            found=f"{value} {unit}".strip(),
            allowed=error.allowed or f"a value in {entry.unit or 'plain numbers'}",
            hint=error.hint,
        )


def _names(case: "Case") -> dict[str, tuple[str, ...]]:
    mounts = case.machine.mounts
    turns = has_crank_train(case.machine)
    train = case.machine.crank_train
    names = {
        "cylinder": tuple(cylinder.name for cylinder in train.cylinders) if turns else (),
        "counterweight": tuple(w.name for w in train.counterweights) if turns else (),
        "direction": ("x", "y", "z"),
        "coordinate": ("x", "y", "z", "rx", "ry", "rz"),
    }
    names |= _names_of_response(case)
    names |= _names_of_absorber(case)
    names |= _names_of_shaft_line(case)
    if case.measurement is not None:
        names["position"] = tuple(position.name for position in case.measurement.positions)
    if case.response is not None and case.response.roll is not None and turns:
        from vibecalc.roll.model import gas_tables, interpolations

        names["interpolant"] = interpolations(gas_tables(case))
    if mounts is not None:
        named = tuple(mount.name for mount in mounts.individual or ())
        names["mount"] = named or tuple(str(i + 1) for i in range(len(mounts.positions or ())))
    return {axis: entries for axis, entries in names.items() if axis in AXES}


def _names_of_response(case: "Case") -> dict[str, tuple[str, ...]]:
    response = case.response
    if response is None:
        return {}
    operations = tuple(operation.name for operation in response.operations)
    balances = tuple(balance.name for balance in response.balances)
    names = {"operation": operations, "balance": balances or ("as in the case",)}
    if response.switching is not None:
        there, back = response.switching.between
        names["change"] = (f"{there} to {back}", f"{back} to {there}")
    if response.roll is not None:
        names["method"] = tuple(dict.fromkeys((response.roll.method, *response.roll.compare)))
    return names


def _names_of_absorber(case: "Case") -> dict[str, tuple[str, ...]]:
    machine = case.machine
    if machine.primary is None:
        return {}
    from vibecalc.absorber.model import stock

    known = stock(machine)
    return {
        "absorber": tuple(one.name for one in machine.secondaries),
        "stock_spring": known.spring_names,
        "stock_oil": tuple(oil.name for oil in known.oils),
        "stock_damper": known.damper_names,
    }


def _names_of_shaft_line(case: "Case") -> dict[str, tuple[str, ...]]:
    line = case.machine.shaft_line
    if line is None:
        return {}
    from vibecalc.torsion.shaft_line_tables import section_names

    gears = tuple(one.name or " - ".join(one.between) for one in line.gears)
    elastic = [
        n for n, one in zip(gears, line.gears, strict=True) if one.mesh_stiffness is not None
    ]
    dampers = tuple(one.name for one in line.dampers)
    return {
        "station": tuple(one.name for one in line.stations),
        "section": (*section_names(line), *elastic, *dampers),
        "damper": dampers,
        "gear": gears,
        "order_class": ("major", "other"),
    }


def _nearest(word: str, allowed: tuple[str, ...]) -> str:
    close = difflib.get_close_matches(word, allowed, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else ""
