"""References, limits and objectives against the plan: do the results they name exist?"""

import difflib
import functools
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.results.catalogue import AXES, CATALOGUE, NAMES, OWNER
from vibecalc.core.results.record import AT_START, Entry
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.stage import Entries, subjects
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.kinds import has_crank_train

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Entries of numbered axes that a run will have, as far as the case tells before it.
# ----------------------------------------------------------------------------

#: as in `results/select.py`: two numbers this close, relatively, are the same entry
_SAME = 1e-9
_SHOWN = 12
#: axes whose entries are numbered 1, 2, 3, ...
_NUMBERED = (
    *("mode", "other_mode", "damped_mode", "bare_mode", "elastic_mode", "pole", "multiplier"),
    *("peak", "passage", "contact", "turn", "cage", "hammering", "barred", "limit", "wedge"),
    *("unstable", "basin"),
)


class KnownEntries(NamedTuple):
    """What a case says of the entries of axes: names by the result, numbers by result and axis.

    `varies`: a sweep may change the numbers. References are of the case as it is written: `run`
    holds them against its result, a sweep does not.
    """

    names: Callable[[str], Mapping[str, tuple[str, ...]]]
    numbers: Callable[[str, str], Entries | None]
    varies: bool


def entries_of(case: "Case") -> KnownEntries:
    """What a case says of the entries of axes before its run."""
    everywhere = _names(case)

    @functools.cache
    def of_subject(name: str) -> dict[str, tuple[str, ...]]:
        return everywhere | subjects()[name].names(case)

    def names(quantity: str) -> dict[str, tuple[str, ...]]:
        owner = OWNER.get(quantity.removeprefix(AT_START))
        return everywhere if owner is None else of_subject(owner)

    @functools.cache
    def numbers(quantity: str, axis: str) -> Entries | None:
        path = quantity.removeprefix(AT_START)
        return subjects()[OWNER[path]].entries(case, path, axis) if path in OWNER else None

    return KnownEntries(names, numbers, case.sweep is not None)


def _missing_entries(
    path: KeyPath, quantity: str, where: Mapping[str, int | float | str], entries: KnownEntries
) -> Iterator[Problem]:
    """Problems of a `where` that picks a clearance, an order or a mode that no run will have."""
    for axis, wanted in where.items():
        known = entries.numbers(quantity, axis)
        numbered = axis in _NUMBERED and quantity.removeprefix(AT_START) in OWNER  # else texts
        if known is None and not numbered:
            continue
        try:
            value = _number(wanted, AXES[axis][0])
        except UnitError as error:
            yield Problem(
                path=(*path, "where"),
                message=f"{axis} of {quantity} cannot be read: {error.message}",
                found=f"{axis} = {wanted!r}",
                allowed=error.allowed,
                hint=error.hint,
            )
            continue
        if known is None:
            there = value >= 1.0 and abs(value - round(value)) <= _SAME * value
            allowed, because = "1, 2, 3, ...", ""
        else:
            values, because, between = known
            there = between and values[0] <= value <= values[-1]
            there = there or any(
                abs(value - one) <= _SAME * max(abs(value), abs(one)) for one in values
            )
            allowed = _listed(values, wanted, axis)
            allowed = allowed.replace(", ", " to ") if between else allowed
        if not there:
            article = "an" if axis[0] in "aeiou" else "a"
            yield Problem(
                path=(*path, "where"),
                message=f"this {_row(path)} asks for {article} {axis} that {quantity} lacks",
                found=f"{axis} = {wanted!r}",
                allowed=allowed,
                hint=because,
            )


def _row(path: KeyPath) -> str:
    return f"[[{path[0]}]]" if isinstance(path[1], int) else str(path[1])


def _number(wanted: int | float | str, unit: str) -> float:
    from vibecalc.units import parse_quantity

    return parse_quantity(wanted, unit)


def _listed(entries: tuple[float, ...], wanted: int | float | str, axis: str) -> str:
    """The entries in the unit that the case writes, the first and the last of many."""
    from vibecalc.units import convert, split_number

    unit = AXES[axis][0]
    written = split_number(wanted)[1] if isinstance(wanted, str) else ""
    values = [convert(one, unit, written) if written else one for one in entries]
    texts = [f"{value:.9g} {written or unit}".rstrip() for value in values]
    if len(texts) > _SHOWN:
        short = axis != "clearance"
        return f"{texts[0]} to {texts[-1]}" if short else ", ".join(texts[:_SHOWN])
    return ", ".join(texts)


# ----------------------------------------------------------------------------
# References, limits and objectives against the plan: do the results they name exist?
# ----------------------------------------------------------------------------


def check_targets(case: "Case", extra: Mapping[str, Entry] | None = None) -> list[Problem]:
    """Problems of every quantity, axis, entry and unit that the case names.

    `extra` holds paths next to the stages' own (what a study adds).
    """
    planned, entries = planned_quantities(case), entries_of(case)
    known = {**planned, **(extra or {})}
    problems: list[Problem] = []
    for index, reference in enumerate(case.reference):
        path: KeyPath = ("reference", index)
        problems += _check_name(path, reference.quantity, reference.where, known, entries)
        problems += _several(path, reference.quantity, reference.where, known, entries)
        for key, value in (("value", reference.value), ("atol", reference.atol)):
            problems += _check_unit((*path, key), value, reference.quantity, known, reference.unit)
    for index, limit in enumerate(case.limit):
        path = ("limit", index)
        problems += _check_name(path, limit.quantity, limit.where, known, entries)
        for key, value in (("max", limit.max), ("min", limit.min)):
            problems += _check_unit((*path, key), value, limit.quantity, known)
    for index, search in enumerate(case.find):
        path = ("find", index)
        problems += _check_name(path, search.quantity, search.where, planned, entries)
        for key, value in (("target", search.target), ("change", search.change)):
            problems += _check_unit((*path, key), value, search.quantity, planned)
    for name, table in (("optimisation", case.optimisation), ("sweep", case.sweep)):
        goal = None if table is None else table.objective
        if goal is not None:
            path = (name, "objective")
            problems += _check_name(path, goal.quantity, goal.where, known, entries)
    return problems


def _check_name(
    path: KeyPath,
    quantity: str,
    where: Mapping[str, int | float | str],
    known: Mapping[str, Entry],
    entries: KnownEntries,
) -> Iterator[Problem]:
    entry = known.get(quantity)
    if entry is None:
        yield unknown_quantity(path, quantity, known)
        return
    names = entries.names(quantity)
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
    if not entries.varies or path[0] == "reference":
        named = {axis: value for axis, value in where.items() if axis in entry.axes}
        yield from _missing_entries(path, quantity, named, entries)


def _several(
    path: KeyPath,
    quantity: str,
    where: Mapping[str, int | float | str],
    known: Mapping[str, Entry],
    entries: KnownEntries,
) -> Iterator[Problem]:
    """A reference is held against one entry: each axis with several has to be named."""
    for axis in known[quantity].axes if quantity in known else ():
        numbers = entries.numbers(quantity, axis)
        found = entries.names(quantity).get(axis) or (numbers[0] if numbers else ())
        if axis not in where and len(found) > 1:
            shown = ", ".join(map(str, found[:_SHOWN]))
            yield Problem(
                path=(*path, "where") if where else path,
                message=f"this [[reference]] is of one {axis}, and {quantity} has {len(found)}",
                allowed=f"where = {{ {axis} = ... }} with one of {shown}",
            )


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
        written = f"{value} {unit}" if unit else str(value)
        parse_quantity(written, entry.unit, difference=path[-1] in ("change", "atol"))
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
    """Entries of the axes of several subjects, and of those that are the same in every case."""
    names = NAMES | {
        "cylinder": tuple(cylinder.name for cylinder in train.cylinders) if turns else (),
        "counterweight": tuple(w.name for w in train.counterweights) if turns else (),
        "direction": ("x", "y", "z"),
        "coordinate": ("x", "y", "z", "rx", "ry", "rz"),
    }
    if mounts is not None:
        named = tuple(mount.name for mount in mounts.individual or ())
        names["mount"] = named or tuple(str(i + 1) for i in range(len(mounts.positions or ())))
    return names


def _nearest(word: str, allowed: tuple[str, ...]) -> str:
    close = difflib.get_close_matches(word, allowed, n=1, cutoff=0.5)
    return f"did you mean {close[0]!r}?" if close else ""
