"""References, limits and objectives against the plan: do the results they name exist?"""

import functools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from vibecalc.core.case.raw import nearest
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
    *("mode", "other_mode", "damped_mode", "mode_without_dampers", "elastic_mode"),
    *("pole", "multiplier"),
    *("peak", "passage", "contact", "turn", "cage", "hammering", "barred", "limit", "wedge"),
    *("unstable", "basin"),
)


class KnownEntries:
    """What a case says of the entries of axes before its run.

    `varies`: a sweep may change the numbers. References are of the case as it is written: `run`
    holds them against its result, a sweep does not.
    """

    def __init__(self, case: "Case"):
        self._case = case
        self._names: dict[str, dict[str, tuple[str, ...]]] = {"": _names(case)}
        self.varies = case.sweep is not None
        self.numbers = functools.cache(self._numbers)

    def names(self, quantity: str) -> Mapping[str, tuple[str, ...]]:
        """Names of the entries of axes of a result."""
        path = quantity.removeprefix(AT_START)
        if path not in OWNER:
            return self._names[""]
        if path not in self._names:
            self._names[path] = self._names[""] | subjects()[OWNER[path]].names(self._case, path)
        return self._names[path]

    def _numbers(self, quantity: str, axis: str) -> Entries | None:
        path = quantity.removeprefix(AT_START)
        return subjects()[OWNER[path]].entries(self._case, path, axis) if path in OWNER else None


def _missing_entries(
    path: KeyPath, quantity: str, where: Mapping[str, int | float | str], entries: KnownEntries
) -> Iterator[Problem]:
    """Problems of a `where` that picks a clearance, an order or a mode that no run will have."""
    from vibecalc.units import parse_quantity

    for axis, wanted in where.items():
        known = entries.numbers(quantity, axis)
        numbered = axis in _NUMBERED and quantity.removeprefix(AT_START) in OWNER  # else texts
        if known is None and not numbered:
            continue
        problem = Problem(path=(*path, "where"), message="", found=f"{axis} = {wanted!r}")
        try:
            value = parse_quantity(wanted, AXES[axis][0])
        except UnitError as error:
            message = f"{axis} of {quantity} cannot be read: {error.message}"
            yield problem._replace(message=message, allowed=error.allowed, hint=error.hint)
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
            row = f"[[{path[0]}]]" if isinstance(path[1], int) else path[1]
            article = "an" if axis[0] in "aeiou" else "a"
            message = f"this {row} asks for {article} {axis} that {quantity} lacks"
            yield problem._replace(message=message, allowed=allowed, hint=because)


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
    planned, entries = planned_quantities(case), KnownEntries(case)
    known = {**planned, **(extra or {})}
    goals = (("optimisation", case.optimisation), ("sweep", case.sweep))
    rows: list[tuple[KeyPath, Any, Mapping[str, Entry], tuple[str, ...]]] = [
        *(
            (("reference", k), one, known, ("value", "atol"))
            for k, one in enumerate(case.reference)
        ),
        *((("limit", k), one, known, ("max", "min")) for k, one in enumerate(case.limit)),
        *((("find", k), one, planned, ("target", "change")) for k, one in enumerate(case.find)),
        *(((name, "objective"), table.objective, known, ()) for name, table in goals if table),
    ]
    problems: list[Problem] = []
    for path, row, there, keys in rows:
        if row is None:
            continue
        entry, is_reference = there.get(row.quantity), path[0] == "reference"
        if entry is None:
            problems.append(unknown_quantity(path, row.quantity, there))
            continue
        problems += _check_where(path, row, entry, entries)
        if is_reference:
            problems += _several(path, row, entry, entries)
        for key in keys:
            unit = row.unit if is_reference else ""
            problems += _check_unit((*path, key), getattr(row, key), row.quantity, entry, unit)
    return problems


def _check_where(path: KeyPath, row: Any, entry: Entry, entries: KnownEntries) -> Iterator[Problem]:
    names = entries.names(row.quantity)
    problem = Problem(path=(*path, "where"), message="")
    for axis, value in row.where.items():
        if axis not in entry.axes:
            yield problem._replace(
                message=f"{row.quantity} has no axis {axis!r}",
                found=axis,
                allowed=", ".join(entry.axes) or "no axes: it is one number",
                hint=nearest(axis, entry.axes),
            )
        elif axis in names and str(value) not in names[axis]:  # a CSV file has 3 for "3"
            yield problem._replace(
                message=f"there is no {axis} named {value!r}",
                found=repr(value),
                allowed=", ".join(repr(name) for name in names[axis]),
                hint=nearest(str(value), names[axis]),
            )
    if not entries.varies or path[0] == "reference":
        named = {axis: value for axis, value in row.where.items() if axis in entry.axes}
        yield from _missing_entries(path, row.quantity, named, entries)


def _several(path: KeyPath, row: Any, entry: Entry, entries: KnownEntries) -> Iterator[Problem]:
    """A reference is held against one entry: each axis with several has to be named."""
    for axis in entry.axes:
        numbers = entries.numbers(row.quantity, axis)
        found = entries.names(row.quantity).get(axis) or (numbers[0] if numbers else ())
        if axis not in row.where and len(found) > 1:
            shown = ", ".join(map(str, found[:_SHOWN]))
            yield Problem(
                path=(*path, "where") if row.where else path,
                message=f"this [[reference]] is of one {axis}, and {row.quantity} has {len(found)}",
                allowed=f"where = {{ {axis} = ... }} with one of {shown}",
            )


def unknown_quantity(path: KeyPath, quantity: str, known: Mapping[str, Entry]) -> Problem:
    """The problem of a table at `path` that names none of the `known` quantities."""
    if quantity in CATALOGUE:
        hint = "vibecalc can compute it, but no table of this case requests it"
        if "run_up" in quantity:
            hint += "; add run_up to [isolation]"
    else:
        hint = nearest(quantity, [*known])
    return Problem(
        path=(*path, "quantity"),
        message="this case does not compute such a quantity",
        found=quantity,
        allowed="a path that `vibecalc check` lists",
        hint=hint,
    )


def _check_unit(
    path: KeyPath, value: float | str | None, quantity: str, entry: Entry, unit: str
) -> Iterator[Problem]:
    from vibecalc.units import parse_quantity

    written = f"{value} {unit}".strip()
    try:
        if value is not None:
            parse_quantity(written, entry.unit, difference=path[-1] in ("change", "atol"))
    except UnitError as error:
        yield Problem(
            path=path,
            message=f"does not fit {quantity}",
            found=written,
            allowed=error.allowed or f"a value in {entry.unit or 'plain numbers'}",
            hint=error.hint,
        )


def _names(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axes of several subjects, and of those that are the same in every case."""
    train = case.machine.crank_train if has_crank_train(case.machine) else None
    names = NAMES | {
        "cylinder": tuple(cylinder.name for cylinder in train.cylinders) if train else (),
        "counterweight": tuple(w.name for w in train.counterweights) if train else (),
        "direction": ("x", "y", "z"),
        "coordinate": ("x", "y", "z", "rx", "ry", "rz"),
    }
    if (mounts := case.machine.mounts) is not None:
        named = tuple(mount.name for mount in mounts.individual or ())
        names["mount"] = named or tuple(str(i + 1) for i in range(len(mounts.positions or ())))
    return names
