"""Claim: benchmarks report in one form, and the README quotes the recorded results."""

import ast
import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
BENCHMARKS = ROOT / "benchmarks"
#: what benchmarks share
HELPERS = {"rows", "run", "timing", "machine_peaks"}


@pytest.fixture
def modules(monkeypatch: pytest.MonkeyPatch) -> tuple[ModuleType, ModuleType]:
    """`rows` and `run` of the benchmarks."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    for name in ("rows", "run"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    found = importlib.import_module("rows"), importlib.import_module("run")
    for name in ("rows", "run"):
        monkeypatch.delitem(sys.modules, name)
    return found


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split(" |")]


def tables(text: str) -> list[list[list[str]]]:
    """Every table of a Markdown text as rows of cells, the heading first, the rule left out."""
    found: list[list[list[str]]] = []
    inside = False
    for line in text.splitlines():
        if not line.startswith("|"):
            inside = False
            continue
        if not inside:
            found.append([])
        inside = True
        if not line.startswith("| ---"):
            found[-1].append(cells(line))
    return found


def test_every_benchmark_is_listed_and_offers_a_report(
    modules: tuple[ModuleType, ModuleType],
) -> None:
    _, run = modules
    names = {path.stem for path in BENCHMARKS.glob("*.py")} - HELPERS
    assert names == set(run.NAMES)
    for name in names:
        tree = ast.parse((BENCHMARKS / f"{name}.py").read_text(encoding="utf-8"))
        functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        returns = functions["measure"].returns
        assert isinstance(returns, ast.Name) and returns.id == "Report", name


def test_aims_are_judged_in_their_direction(modules: tuple[ModuleType, ModuleType]) -> None:
    rows, _ = modules
    quick = rows.Row("a", "b", "c", 49.0, aim=50.0)
    assert quick.missed and quick.ratio_text == "49 times faster"
    assert quick.aim_text == "at least 50: **missed**"
    assert not quick._replace(ratio=51.0).missed and not quick._replace(aim=None).missed
    dear = rows.Row("a", "b", "c", 3.1, aim=3.0, cost=True)
    assert dear.missed and dear.ratio_text == "3.1 times its time"
    assert not dear._replace(ratio=2.9).missed
    assert rows.Row("a", "b", "c", 0.25).ratio_text == "4 times slower"


def test_a_report_survives_its_file_and_becomes_tables(
    modules: tuple[ModuleType, ModuleType],
) -> None:
    rows, run = modules
    report = rows.Report(
        "Title", "Words.", [rows.Row("a", "b", "c", 12.0, 50.0, "1e-9")],
        [rows.Table("More", ["x", "y"], [["1", ""]])], ["A remark."],
    )  # fmt: skip
    again = rows.unpacked(rows.packed(report))
    assert again.rows == list(report.rows) and again.title == report.title
    first, second = tables(rows.shown(again))
    assert first == [list(rows.COLUMNS), list(report.rows[0].cells())]
    assert second == [["x", "y"], ["1", ""]]
    text = run.results({"one": report, "two": None}, "- machine: m\n", 60.0)
    assert "12 times faster against c, aim at least 50: **missed**" in text
    assert "two: no result" in text


def test_the_table_of_the_readme_is_replaced_between_its_markers(
    modules: tuple[ModuleType, ModuleType],
) -> None:
    _, run = modules
    text = f"before\n{run.BEGIN}\nold\n{run.END}\nafter\n"
    new = run.with_table(text, "| new |\n")
    assert new == f"before\n{run.BEGIN}\n| new |\n{run.END}\nafter\n"
    with pytest.raises(SystemExit, match="README"):
        run.with_table("no markers", "")


def test_results_name_their_machine_and_the_readme_quotes_them(
    modules: tuple[ModuleType, ModuleType],
) -> None:
    rows, run = modules
    recorded = (BENCHMARKS / "RESULTS.md").read_text(encoding="utf-8")
    for word in ("UTC", "- machine:", "load average", "numpy", "scipy", "opentorsion", "BLAS"):
        assert word in recorded
    assert "## Failed" not in recorded
    every = [row for table in tables(recorded) if table[0] == list(rows.COLUMNS) for row in table]
    places = [rows.COLUMNS.index(name) for name in run.SHOWN]
    known = [[row[k] for k in places] for row in every]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    block = readme.partition(run.BEGIN)[2].partition(run.END)[0]
    ((heading, *quoted),) = tables(block)
    assert heading == list(run.SHOWN) and 8 <= len(quoted) <= 12
    assert all(row in known for row in quoted)
    # every aim that was missed is said at the beginning
    missed = sum("**missed**" in cell for row in every for cell in row)
    before = recorded.partition("## Aims missed")[2].partition("\n## ")[0]
    assert before.count("**missed**") == missed
