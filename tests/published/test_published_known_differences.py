"""Claim: every published number that is said to be wrong is wrong, and a test shows the slip.

A `[[reference]]` with `known_difference` names in `shown_by` a test that reproduces the printed
value from the slip, or says "not reproducible" and what was tried. That the named test passes is
the test's own business. Every other published number comes out, and every limit is kept.
"""

import ast
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest
from shipped_cases import CASES, ROOT, result_of, takes_long

from vibecalc.core.report.verdicts import ReferenceRow, counted_misses, judge_references
from vibecalc.core.results.verdicts import verdicts_of

#: the base of the sweep is the case compressor_impact; its points are golden
JUDGED = [
    pytest.param(name, marks=pytest.mark.long) if name.endswith("_sweep") else name
    for name in CASES
    if not takes_long(name)
]


DIFFERING = [name for name, path in CASES.items() if "known_difference" in path.read_text("utf-8")]


@cache
def names_of_tests(path: Path) -> frozenset[str]:
    """Names of the test functions of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    return frozenset(name for name in names if name.startswith("test_"))


def complaint(shown_by: str) -> str:
    """What is missing in a `shown_by`, or nothing."""
    if shown_by.startswith("not reproducible"):
        tried = shown_by.removeprefix("not reproducible").lstrip(":, ")
        return "" if len(tried.split()) >= 3 else "says not what was tried"
    file_name, _, function = shown_by.partition("::")
    path = ROOT / file_name
    if not file_name.startswith("tests/published/") or not path.is_file():
        return f"there is no file {file_name!r} in tests/published"
    return "" if function in names_of_tests(path) else f"{file_name} has no test {function!r}"


@cache
def judged(name: str) -> Sequence[ReferenceRow]:
    return judge_references(result_of(name))


@pytest.mark.parametrize("name", DIFFERING)
def test_known_differences_are_shown_by_a_test_and_are_there(name: str) -> None:
    assert any(row.known_difference for row in judged(name))
    for row in judged(name):
        if row.known_difference:
            assert complaint(row.shown_by) == "", row.shown_by
            assert not row.agrees, f"{row.quantity} {row.where} agrees after all: count it"


@pytest.mark.parametrize(
    ("shown_by", "words"),
    [
        ("", "there is no file"),
        ("tests/published/test_published_nothing.py::test_it", "there is no file"),
        ("tests/test_architecture.py::test_every_file_has_a_docstring", "there is no file"),
        ("tests/published/test_published_kinematics.py::test_nothing", "has no test"),
        ("tests/published/test_published_kinematics.py", "has no test"),
        ("not reproducible", "what was tried"),
        ("not reproducible: hm", "what was tried"),
    ],
)
def test_an_empty_promise_is_found(shown_by: str, words: str) -> None:
    assert words in complaint(shown_by)


@pytest.mark.parametrize("name", JUDGED)
def test_every_counted_number_comes_out_and_every_limit_is_kept(name: str) -> None:
    result = result_of(name)
    outside = [row for row in judged(name) if row.within is False]
    broken = [row for row in verdicts_of(result) if not row.satisfied]
    assert (outside, broken) == ([], [])
    assert counted_misses(result) == 0


def test_the_generator_is_held_against_all_that_the_source_prints() -> None:
    rows = judge_references(result_of("generator")) + judge_references(result_of("generator_180"))
    tables = {row.source.split(",")[0] for row in rows if row.source.startswith("Table")}
    assert tables == {"Table 1", "Table 2", "Table 3", "Table 4"}
    assert sum(row.source.startswith("Table") for row in rows) == 4 * 16
    assert sum(row.source.startswith("section") for row in rows) == 10
