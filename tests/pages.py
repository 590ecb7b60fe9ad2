"""The pages of docs/ as tests read them: tables, numbers of quantities, names of tests, files."""

import re
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import groupby
from typing import Any, NamedTuple

from shipped_cases import ROOT, result_of, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.select import scalar
from vibecalc.core.run.run import run_case
from vibecalc.units import convert

QUANTITY = re.compile(r"^`([\w/]+)`((?: \w+=\S+)*?)(?: with ((?:`[^`]+` ?)+))?$")
NUMBER = re.compile(r"^(-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?: (\S+))?$")


class Row(NamedTuple):
    """One printed number; None where there is no such value."""

    place: str
    printed: str
    right: float | None
    source: float | None
    verdict: str
    reason: str = ""


VERDICTS = (
    "reproduced",
    "with the slip",
    "misprint",
    "garbled",
    "compatible",
    "not reproducible",
    "measured",
)


def says_what_it_is(row: Row) -> bool:
    """The numbers of a row give its verdict, and all but plain ones have a reason; `< 4` binds."""
    number = row.printed
    if number.startswith("< "):
        return (
            row.verdict == "reproduced" and row.right is not None and row.right < float(number[2:])
        )
    right = row.right is not None and shows(number, row.right)
    slipped = row.source is not None and shows(number, row.source)
    fits = {
        "reproduced": right,
        "with the slip": slipped and not right,
        "misprint": not right and not slipped,
        "not reproducible": not right and not slipped,
        # what its reason leaves open is a few hundredths at most
        "compatible": row.verdict == "compatible"
        and min(abs(one / float(number) - 1.0) for one in (row.right, row.source) if one) < 0.05,
    }
    explained = bool(row.reason) or row.verdict in ("reproduced", "measured")
    return row.verdict in VERDICTS and fits.get(row.verdict, True) and explained


def merged(found: Iterable[Row]) -> list[list[Row]]:
    """Neighbouring rows alike but for their numbers and the last part of their places."""

    def alike(row: Row) -> tuple[object, ...]:
        shown = () if row.verdict == "reproduced" else (row.right is None, row.source is None)
        return row.place.rpartition(", ")[0], row.verdict, row.reason, *shown

    return [list(group) for _, group in groupby(found, alike)]


def place_of(group: list[Row]) -> str:
    """`Table 3.5, Hz (S, M, L)`; words that all last parts begin with stand once."""
    if len(group) == 1:
        return group[0].place
    stem = group[0].place.rpartition(", ")[0]
    labels = [row.place.rpartition(", ")[2] for row in group]
    if len({label.rpartition(" ")[0] for label in labels}) == 1:
        labels[1:] = [label.rpartition(" ")[2] for label in labels[1:]]
    return f"{stem} ({', '.join(labels)})"


def reproduced(found: Iterable[Row]) -> str:
    """Printed numbers that are reproduced, as the sentence of a page."""
    parts = []
    for group in merged(row for row in found if row.verdict == "reproduced"):
        reason = f" ({group[0].reason})" if group[0].reason else ""
        parts.append(f"{place_of(group)}: {', '.join(row.printed for row in group)}{reason}")
    return f"Reproduced: {'; '.join(parts)}." if parts else ""


class Stated(NamedTuple):
    """A quantity of a case under its settings, and the number that a page shows for it."""

    case: str
    path: str
    where: dict[str, Any]
    settings: tuple[str, ...]
    number: str
    unit: str


def text_of(page: str) -> str:
    """docs/PAGE.md."""
    return (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")


def rows(text: str) -> list[list[str]]:
    """Cells of all table rows."""
    lines = [line for line in text.split("\n") if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def table(page: str, first_cell: str, below: str = "") -> list[list[str]]:
    """Rows of the table whose head begins with that cell, after some words; without the head."""
    for block in page[page.index(below) :].split("\n\n"):
        lines = rows(block)
        if lines and lines[0][0] == first_cell:
            return lines[2:]
    raise LookupError(first_cell)


def shows(number: str, value: float) -> bool:
    """The value, rounded to the digits of the number, is the number; 0 stands for noise."""
    if number == "0":
        return abs(value) < 1e-12
    mantissa, _, exponent = number.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    unit = 10.0 ** (int(exponent or 0) - decimals)
    return abs(value - float(number)) <= 0.5000001 * unit


def stated(page: str, case: str = "") -> Iterator[Stated]:
    """Cells of quantities with the number to their right; with two, without `[kinematics]` too.

    Below "Case: `cases/x.toml`" they are those of that case.
    """
    for block in page.split("\n\n"):
        named = re.search(r"Cases?: `cases/(\w+)\.toml`", block)
        case = named[1] if named else case
        lines = rows(block)
        if not lines or not {"computed", "exact"} & set(lines[0]):
            continue
        for cells in lines[2:]:
            for place, cell in enumerate(cells[:-1]):
                quantity = QUANTITY.match(cell)
                number = NUMBER.match(cells[place + 1])
                if quantity is None or number is None:
                    continue
                settings = tuple(re.findall(r"`([^`]+)`", quantity[3] or ""))
                own = (case, quantity[1], picked(quantity[2]))
                yield Stated(*own, settings, number[1], number[2] or "")
                if "exact" in lines[0]:
                    yield Stated(*own, (EXACT,), cells[place + 2], "")


#: the setting that leaves the published series of the generator out
EXACT = "without [kinematics]"


def picked(text: str) -> dict[str, Any]:
    """`order=2 direction=y gain=10.0` as a selection."""
    found: dict[str, Any] = {}
    for pair in text.split():
        key, value = pair.split("=", 1)
        number = re.fullmatch(r"\d+(\.\d+)?", value)
        found[key] = value if number is None else float(value) if number[1] else int(value)
    return found


@cache
def record(case: str, *settings: str) -> Record:
    """Results of a shipped case, with some keys set."""
    if settings == (EXACT,):
        data = {key: part for key, part in table_of(case).items() if key != "kinematics"}
        return run_case(validate(data))
    return result_of(case, *settings).record


def computed(case: str, path: str, where: dict[str, Any], unit: str, *settings: str) -> float:
    """One entry of a result in a unit; of a complex one the magnitude."""
    quantity = record(case, *settings)[path]
    value = scalar(quantity, where)
    real = abs(value) if isinstance(value, complex) else float(value)
    return convert(real, quantity.unit, unit) if unit else real


def is_shown(one: Stated) -> bool:
    """The number is that of the case to each digit, or within four standard errors."""
    value = computed(one.case, one.path, one.where, one.unit, *one.settings)
    quantity = record(one.case, *one.settings)[one.path]
    if quantity.standard_error:
        scatter = convert(quantity.standard_error, quantity.unit, one.unit or quantity.unit)
        return abs(float(one.number) - value) <= 4.0 * scatter
    return shows(one.number, value if one.number.startswith("-") else abs(value))


def missing_names(page: str, folder: str = "docs") -> list[str]:
    """Tests and files that a page of that folder names and that are not there."""
    written = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py"))
    named = re.findall(r"`(test_\w+)`", page)
    missing = [name for name in named if f"def {name}(" not in written]
    paths = re.findall(r"`((?:tests|cases|vibecalc)/[\w/.]+\.\w+)`", page)
    paths += [f"{folder}/{name}" for name in re.findall(r"\]\(((?:pictures/)?[\w.]+\.\w+)\)", page)]
    return missing + [path for path in paths if not (ROOT / path).exists()]
