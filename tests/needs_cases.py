"""Shipped cases with one optional table less, as the tests of what a scene needs take them."""

import copy
from collections.abc import Iterator
from functools import cache
from typing import Any

from shipped_cases import CASES, ROOT
from shipped_cases import table_of as shipped

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import VibecalcError
from vibecalc.schema import Case

FOLDER = ROOT / "cases"
NAMES = tuple(name for name in CASES if not name.endswith("_sweep"))
#: tables that hold the case itself, or hold it against something
NEVER = (
    "schema",
    "title",
    "source",
    "machine",
    "accuracy",
    "reference",
    "reference_table",
    "limit",
)
#: tables below which there are optional ones
NESTED = (
    *(("response",), ("response", "torsion"), ("response", "roll"), ("response", "absorber")),
    *(("isolation",), ("tuning",)),
)
#: keys that choose how, and ask for nothing more
CHOICES = ("orders", "damping_model")
Key = tuple[str, ...]


@cache
def _read(name: str) -> dict[str, Any]:
    table = copy.deepcopy(shipped(name))
    assert attach_files(table, FOLDER) == []
    against = () if "fit" in table else ("reference", "reference_table")  # a fit is to these
    for key in (*against, "limit"):
        table.pop(key, None)
    return table


def table_of(name: str) -> dict[str, Any]:
    """A shipped case with its CSV files read, without what its results are held against."""
    return copy.deepcopy(_read(name))


def optional_keys(name: str) -> list[Key]:
    """Every table, list of tables and switch of a case that may be absent."""
    table = _read(name)
    keys: list[Key] = [(key,) for key in table if key not in NEVER]
    for path in NESTED:
        inside: Any = table
        for key in path:
            inside = inside.get(key, {}) if isinstance(inside, dict) else {}
        keys += [
            (*path, key)
            for key, value in inside.items()
            if key not in CHOICES and (isinstance(value, dict | list) or value is True)
        ]
    return keys


def case_of(table: dict[str, Any]) -> Case | None:
    """The case of a table; None where it lacks something that it needs."""
    try:
        case = validate(copy.deepcopy(table))
    except VibecalcError:
        return None
    return None if check_machine(case) else case


def without(table: dict[str, Any], key: Key) -> dict[str, Any]:
    """A copy of `table` with one key taken out."""
    found = copy.deepcopy(table)
    inside: Any = found
    for part in key[:-1]:
        inside = inside[part]
    del inside[key[-1]]
    return found


def lighter_cases(name: str) -> Iterator[tuple[Key, Case, Case]]:
    """(what is left out, the case, the case without it) wherever that is a case still."""
    table = table_of(name)
    whole = case_of(table)
    assert whole is not None
    for key in optional_keys(name):
        part = case_of(without(table, key))
        if part is not None:
            yield key, whole, part
