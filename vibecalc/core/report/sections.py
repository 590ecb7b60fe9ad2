"""What a section is made of: quantities found in a result, and tables that fit any of them."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report.writing import DIGITS, number, paragraph, show, table
from vibecalc.core.results.catalogue import CATALOGUE, HEADLINES, OWNER
from vibecalc.core.results.record import AT_START, READ, Axis, Quantity, Record, Result
from vibecalc.core.results.tolerance import UNRESOLVED
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Finding things in a result: the quantity a row of the case asks for, labels of axes, pieces.
# ----------------------------------------------------------------------------


def labels(axis: Axis) -> list[str]:
    """The entries of an axis as words: names and whole numbers as they are, others shortened."""
    if axis.values.dtype.kind in "iu":
        return [str(int(value)) for value in axis.values]
    if axis.values.dtype.kind == "f":
        return [show(value) for value in axis.values]
    return [str(value) for value in axis.values]


def magnitudes(quantity: Quantity) -> np.ndarray:
    """Real values: the magnitude of what is complex, else the values themselves."""
    values = np.asarray(quantity.values)
    return np.abs(values) if np.iscomplexobj(values) else values


def largest_of(values: np.ndarray) -> float:
    """The one of the largest magnitude, with its sign; of two that rounding parts the positive."""
    low, high = float(np.min(values)), float(np.max(values))
    return low if -low > (1.0 + 1e-9) * max(high, 0.0) else high


def scalar_of(record: Record, path: str) -> float | None:
    """A scalar quantity as a float, None if the record does not have it as one."""
    quantity = record.quantities.get(path)
    if quantity is None or quantity.axes:
        return None
    return float(magnitudes(quantity))


def along(record: Record, path: str, axis: str) -> tuple[Quantity, np.ndarray] | None:
    """A quantity of the one axis `axis` and that axis' values; None if there is none such."""
    quantity = record.quantities.get(path)
    if quantity is None or [one.name for one in quantity.axes] != [axis]:
        return None
    return quantity, np.asarray(quantity.axes[0].values)


def having(record: Record, path: str, *axes: str) -> Quantity | None:
    """A quantity with just these axes, in this order, and an entry at least; else None."""
    quantity = record.quantities.get(path)
    if quantity is None or tuple(axis.name for axis in quantity.axes) != axes:
        return None
    return quantity if np.size(quantity.values) else None


def turns_of(record: Record, path: str) -> str:
    """Over what the results next to one repeat: `a turn`, `two turns` where half orders act."""
    root = path.rpartition("/")[0]
    axes = (axis.values for other, one in record.items() if other.startswith(f"{root}/")
            for axis in one.axes if axis.name == "order")  # fmt: skip
    return "two turns" if any(np.any(values % 1.0) for values in axes) else "a turn"


def speed_of(result: Result) -> float | None:
    """Operating speed in rad/s: of the optimum if it was a variable, else of the case."""
    found = scalar_of(result.record, "optimisation/variable/machine.speed")
    given = table_of(result.case, "machine").get("speed")
    if found is None and isinstance(given, int | float):
        return float(given)
    return found


def table_of(case: Mapping[str, Any], *keys: str) -> Mapping[str, Any]:
    """A table of the case by its keys, empty if it is absent."""
    for key in keys:
        found = case.get(key)
        if not isinstance(found, Mapping):
            return {}
        case = found
    return case


# ----------------------------------------------------------------------------
# What a section of the report is: a title, its lines, and the results it has shown.
# ----------------------------------------------------------------------------


class Section(NamedTuple):
    """A titled part of the report; `shown` holds the paths that need no generic line any more.

    `detail` stands in a full report only: `detail_name` says what it is, as in "Holzer tables".
    """

    title: str
    lines: list[str]
    shown: frozenset[str]
    detail_name: str = ""
    detail: Iterable[str] = ()


#: m^3, below which a volume is read in cm^3
_LITRES = 0.01
_VARIABLE = "optimisation/variable/"
#: unit -> from which size in SI on another one is read
_LARGER = {"N*m": (1e4, "kN*m"), "W": (1e4, "kW"), "g*mm": (0.1, "kg*m"), "g": (10.0, "kg")}


def by_size(unit: str, values: Any) -> str:
    """The unit that people read in place of `unit` where the largest of values in SI is large."""
    least, larger = _LARGER.get(unit, (math.inf, unit))
    size = np.abs(values)
    return larger if np.any((size >= least) & np.isfinite(size)) else unit


def read_as(path: str, unit: str, *, entry: bool = False) -> tuple[str, str]:
    """What a quantity is called in a table, and the unit that people read it in.

    The words of the first table, else, and for an entry of an array, those of its path:
    `natural frequency, pitch`.
    """
    if path.startswith(_VARIABLE):
        return path.removeprefix(_VARIABLE), unit
    if path in HEADLINES and not entry:
        return HEADLINES[path].name, "%" if CATALOGUE[path].share else HEADLINES[path].unit or unit
    turns = unit == "rad/s" and path.endswith("speed")  # by its path a speed of rotation
    share = path in CATALOGUE and CATALOGUE[path].share
    shown = "rpm" if turns else "%" if share else READ.get(unit, unit)
    shown = "N/mm^2" if unit == "Pa" and "stress" in path else shown
    if unit == "rad":  # as the first table has it of what is called the same
        same = (one.unit for other, one in HEADLINES.items()
                if _last(other) == _last(path) and CATALOGUE[other].unit == unit)  # fmt: skip
        shown = next(filter(None, same), shown)
    if path in CATALOGUE and CATALOGUE[path].name:
        return CATALOGUE[path].name, shown
    parts = path.replace("_", " ").replace("run up", "run-up").split("/")
    *folders, name = parts[1:] if path in OWNER else parts
    return ", ".join([name, *reversed(folders)]), shown


def written(quantity: Quantity, unit: str, digits: int = DIGITS) -> Callable[[Any], str]:
    """What writes values of a quantity in a unit, with its error; texts stay as they are."""
    factor = 1.0 if unit == quantity.unit else convert(1.0, quantity.unit, unit)
    error = quantity.estimate * factor

    def text(value: Any) -> str:
        known = value if factor == 1.0 or isinstance(value, str) else value * factor
        return known if isinstance(known, str) else show(known, error, digits)

    return text


def _last(path: str) -> str:
    return path.rpartition("/")[2]


#: blocks of a section, alone or with the paths that they show
Part = list[str] | tuple[list[str], Iterable[str]]


def stacked(*blocks: Sequence[str]) -> list[str]:
    """Blocks of lines with a blank one between; an empty block is none."""
    return [line for block in blocks if block for line in ("", *block)][1:]


def together(*blocks: Part) -> tuple[list[str], set[str]]:
    """Several blocks as one."""
    parts = [(block, ()) if isinstance(block, list) else block for block in blocks]
    return stacked(*(lines for lines, _ in parts)), {path for _, paths in parts for path in paths}


def section(
    title: str,
    blocks: Iterable[Part],
    details: Mapping[str, Part] | None = None,
    shown: Iterable[str] = (),
) -> Section | None:
    """A section of blocks; `details`, by name, are for a full report."""
    further = {name: together(block) for name, block in (details or {}).items()}
    lines, paths = together(*blocks)
    more, more_paths = together(*further.values())
    if not lines and not more:
        return None
    names = ", ".join(name for name, (block, _) in further.items() if block)
    detail = tuple(["", *more] if lines and more else more)
    return Section(title, lines, frozenset({*paths, *more_paths, *shown}), names, detail)


SCALARS = ("quantity", number("value"), "unit", "note")


def scalar_rows(quantities: Iterable[Quantity], prefix: str = "") -> list[list[str]]:
    """Rows for `SCALARS`: name by its path (without `prefix`), value in the unit people read."""
    rows = []
    for one in quantities:
        name, unit = read_as(one.path, one.unit)
        if one.path not in HEADLINES and not (one.path in CATALOGUE and CATALOGUE[one.path].name):
            name, _ = read_as(one.path.removeprefix(prefix), one.unit)
        value = magnitudes(one)[()]
        unit = "cm^3" if unit == "m^3" and abs(value) < _LITRES else unit
        notes = [one.amplitude or "", UNRESOLVED * one.estimate.unresolved(float(value))]
        rows.append([name, written(one, unit)(value), unit, " ".join(filter(None, notes))])
    return rows


def scalars(record: Record, paths: Iterable[str], prefix: str = "") -> tuple[list[str], set[str]]:
    """A table of those of `paths` that the record has as scalars, and which those were.

    What the first table of the report has is not repeated.
    """
    found = [record[path] for path in paths if path in record.quantities and not record[path].axes]
    new = [quantity for quantity in found if not leads(record, quantity.path)]
    return table(SCALARS, scalar_rows(new, prefix)), {quantity.path for quantity in found}


def leads(record: Record, path: str) -> bool:
    """Whether the first table has the quantity."""
    return path in HEADLINES and HEADLINES[path].unless not in record


def merged(rows: Iterable[Sequence[str]]) -> list[list[str]]:
    """Rows of a table, those that are equal but for their first cell as one: `1 to 4`, `1, 3`."""
    whole = [list(row) for row in rows]
    groups: dict[tuple[str, ...], list[int]] = {}
    for place, row in enumerate(whole):
        groups.setdefault(tuple(row[1:]), []).append(place)
    found = []
    for cells, places in groups.items():
        names = [whole[place][0] for place in places]
        run = len(places) > 2 and places[-1] - places[0] == len(places) - 1
        found.append([f"{names[0]} to {names[-1]}" if run else ", ".join(names), *cells])
    return found


# ----------------------------------------------------------------------------
# Tables for quantities that no section knows: new results show up without changes here.
# ----------------------------------------------------------------------------

#: Longer arrays belong into pictures and the result file.
LONGEST = 24


def grouped(quantities: Sequence[Quantity], prefix: str = "") -> list[str]:
    """Scalars in one table, then one table for each axis that short vectors share.

    What is longer than `LONGEST` or has more axes is left out; `prefix` is cut from the paths.
    """
    scalars = scalar_rows((one for one in quantities if not one.axes), prefix)
    vectors: dict[tuple[str, ...], list[Quantity]] = {}
    for quantity in quantities:
        if len(quantity.axes) == 1 and 0 < np.size(quantity.values) <= LONGEST:
            (axis,) = quantity.axes
            vectors.setdefault((axis.name, *labels(axis)), []).append(quantity)
    blocks = [table(SCALARS, scalars)]
    for (name, *entries), members in vectors.items():
        (axis,), told = members[0].axes, name.rpartition(".")[2].replace("_", " ")
        unit = read_as(told, axis.unit)[1]
        if unit != axis.unit:
            entries = [show(value * convert(1.0, axis.unit, unit)) for value in axis.values]
        heads, columns = [f"{told} {unit}".rstrip()], [entries]
        for one in members:
            text = written(one, read_as(one.path, one.unit)[1])
            heads.append("\n".join(read_as(one.path.removeprefix(prefix), one.unit)))
            columns.append([text(value) for value in magnitudes(one)])
        blocks.append(table(heads, zip(*columns, strict=True)))
    return stacked(*blocks)


# ----------------------------------------------------------------------------
# Whatever no other section has shown, so that a new stage is reported from its first day.
# ----------------------------------------------------------------------------


def other(result: Result, shown: Iterable[str]) -> Section | None:
    """Scalars and short vectors left over, and the names of what only the file holds."""
    done = set(shown)
    left = [
        quantity
        for path, quantity in result.record.items()
        if path not in done and not path.startswith(AT_START) and not leads(result.record, path)
    ]
    large = [one.path for one in left if len(one.axes) > 1 or np.size(one.values) > LONGEST]
    held = paragraph("in the result file only: " + ", ".join(large)) if large else []
    return section("Further results", [grouped(left), held], shown=[one.path for one in left])


#: orders below this share of the largest are counted instead of shown
FAINT = 1e-6
