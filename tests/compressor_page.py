"""docs/validation_compressor.md, read: its tables, its numbers, and the results behind them."""

import re
import runpy
from functools import cache
from typing import Any, NamedTuple

from shipped_cases import CASES, ROOT, result_of
from test_docs import rows, shows

from vibecalc.core.case.load import load_case
from vibecalc.core.report.writing import read_printed
from vibecalc.core.results.record import Record
from vibecalc.core.results.select import Where, scalar
from vibecalc.units import convert

MAIN_PAGE = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "validation_compressor.md").read_text(encoding="utf-8")
#: running words without the line breaks
WORDS = " ".join(PAGE.split())
#: paragraphs, tables, headings
BLOCKS = PAGE.split("\n\n")
QUANTITY = re.compile(r"^`([\w/]+)`((?: \w+=\S+)*?)(?: with ((?:`[^`]+` ?)+))?$")
NUMBER = re.compile(r"^(-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?: (\S+))?$")
RANGE = re.compile(r"^(\S+) \.\. (\S+)$")


class Stated(NamedTuple):
    """A quantity of a case under its settings, as the page shows it and as the source prints it."""

    case: str
    path: str
    where: Where
    settings: tuple[str, ...]
    number: str
    unit: str
    printed: str


def table(first_cell: str, below: str = "") -> list[list[str]]:
    """Rows of the table whose head begins with that cell, after a heading; without the head."""
    start = next(i for i, block in enumerate(BLOCKS) if below in block)
    for block in BLOCKS[start:]:
        lines = rows(block)
        if lines and lines[0][0] == first_cell:
            return lines[2:]
    raise LookupError(first_cell)


def picked(text: str) -> dict[str, int | str]:
    """`order=2 direction=y` as a selection; `clearance=1e-4in` holds a unit."""
    pairs = (pair.split("=", 1) for pair in text.split())
    return {key: int(v) if v.isdigit() else v for key, v in pairs}


def bare(where: Where) -> dict[str, Any]:
    """A selection whose texts have no blanks."""
    return {k: v.replace(" ", "") if isinstance(v, str) else v for k, v in where.items()}


def stated() -> list[Stated]:
    """Rows with a quantity and a computed number, with the case of their section."""
    every, case = [], ""
    for block in BLOCKS:
        named = re.search(r"Cases?: `cases/(\w+)\.toml`", block)
        case = named[1] if named else case
        lines = rows(block)
        if not lines or "quantity" not in lines[0] or "computed" not in lines[0]:
            continue
        column = {name: place for place, name in enumerate(lines[0])}
        for cells in lines[2:]:
            quantity = QUANTITY.match(cells[column["quantity"]])
            number = NUMBER.match(cells[column["computed"]])
            assert quantity and number, cells
            settings = tuple(re.findall(r"`([^`]+)`", quantity[3] or ""))
            printed = cells[column["printed"]] if "printed" in column else ""
            row = (quantity[1], picked(quantity[2]), settings, number[1], number[2] or "", printed)
            every.append(Stated(case, *row))
    return every


@cache
def record(case: str, *settings: str) -> Record:
    """Results of a shipped case, with some keys set."""
    return result_of(case, *settings).record


def computed(case: str, path: str, where: Where, unit: str, *settings: str) -> float:
    """Magnitude of one entry of a result in a unit."""
    quantity = record(case, *settings)[path]
    value = scalar(quantity, where)
    real = abs(value) if isinstance(value, complex) else value
    return convert(real, quantity.unit, unit) if unit else real


@cache
def references(case: str) -> list[tuple[str, str, dict[str, Any]]]:
    """Digits, quantity and selection of all reference rows of a case."""
    return [
        (read_printed(row.value, row.unit or "").text, row.quantity, bare(row.where))
        for row in load_case(CASES[case]).case.reference
    ]


def is_printed(text: str, case: str, path: str, where: Where) -> bool:
    """Some reference row of the case has these digits for this entry."""
    wanted = text.split(" ")[0].lstrip("-")
    return (wanted, path, bare(where)) in references(case)


def shown(text: str, value: float) -> None:
    """Assert that the number on the page is the value, to each digit shown."""
    assert shows(text.lower(), value), f"{text} is shown, {value!r} computed"


@cache
def published(name: str) -> dict[str, Any]:
    """The parts of a test of published numbers."""
    return runpy.run_path(str(ROOT / "tests" / "published" / f"test_published_{name}.py"))


def found(pattern: str) -> str:
    """What the group of a pattern matches in the running words of the page."""
    match = re.search(pattern, WORDS)
    assert match is not None, pattern
    return match[1]
