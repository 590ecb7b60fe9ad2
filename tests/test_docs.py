"""Claim: the numbers in docs/validation*.md are what the cases give, to every digit shown."""

import re
from collections import Counter
from typing import Any

import engine_page
import engine_source as source
import numpy as np
import pytest
import roll_page
from herold_simulation import open_tables, simulate
from pages import computed, is_shown, missing_names, rows, shows, stated, table, text_of
from roll_machines import source_drive, source_machine
from shipped_cases import ROOT, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.roll.turn import level

PAGES = sorted(path.stem for path in (ROOT / "docs").glob("*.md"))
VERDICTS = (
    "reproduced",
    "with the slip",
    "misprint",
    "garbled",
    "compatible",
    "not reproducible",
    "measured",
)
#: page -> its case, where no line says it; least number of quantities on it
NUMBERS = {
    "validation": ("generator", 40),
    "validation_compressor": ("", 20),
    "validation_roll_control": ("roll_control", 40),
}


@pytest.mark.parametrize("page", NUMBERS)
def test_numbers_are_what_the_case_gives(page: str) -> None:
    case, least = NUMBERS[page]
    found = list(stated(text_of(page), case))
    assert len(found) >= least
    assert [one for one in found if not is_shown(one)] == []


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_names_is_there(page: str) -> None:
    assert missing_names(text_of(page)) == []


@pytest.mark.parametrize("page", [name for name in PAGES if name.startswith("theory")])
def test_functions_that_theory_names_are_there(page: str) -> None:
    """Rows of "Computed by": a file, then the functions or classes of it."""
    found = re.findall(r"`(vibecalc/[\w/]+\.py)`((?: `\w+`)+)", text_of(page))
    assert found
    for path, names in found:
        written = (ROOT / path).read_text(encoding="utf-8")
        for name in re.findall(r"\w+", names):
            assert re.search(rf"^(def|class) {name}\b", written, re.M), (path, name)


def test_pages_that_the_program_names_are_there() -> None:
    named = re.compile(r"docs/(\w+)\.md")
    for path in (*(ROOT / "vibecalc").rglob("*.py"), *(ROOT / "cases").glob("*.toml")):
        assert set(named.findall(path.read_text(encoding="utf-8"))) <= set(PAGES), path


@pytest.mark.parametrize(
    "page", [name for name in PAGES if "| printed numbers | reproduced " in text_of(name)]
)
def test_summaries_count_the_verdicts(page: str) -> None:
    text = text_of(page)
    block = next(one for one in text.split("\n\n") if "| printed numbers | reproduced " in one)
    (_, _, *verdicts), _, *lines = rows(block)
    assert set(verdicts) <= set(VERDICTS)
    for title, total, *counts in lines:
        numbers = [int(cell or 0) for cell in counts]
        assert int(total) == sum(numbers), title
        found: Counter[str] = Counter()
        for body in text.split("\n## ")[1:]:
            for one in body.split("\n\n") if body.startswith(title) else ():
                head, *cells = rows(one) or [[]]
                places = [i for i, name in enumerate(head) if name == "verdict"]
                found += Counter(row[i] for row in cells[1:] for i in places if row[i])
        if found:
            assert numbers == [found[verdict] for verdict in verdicts], title


# ----------------------------------------------------------------------------
# The published engine
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("title", engine_page.SECTIONS)
def test_engine_rows_and_their_verdicts(title: str) -> None:
    """Reproduced where the right number has the printed digits, else with the slip."""
    text = text_of("validation_engine")
    cells = rows(text.split(f"\n## {title}\n")[1].split("\n## ")[0])[2:]
    for (place, printed, *others), one in zip(cells, engine_page.SECTIONS[title](), strict=True):
        slipped, right, verdict, reason = others
        assert (place, printed, verdict, reason) == (*one[:2], one.verdict, one.reason)
        assert one.right is not None and shows(right, one.right), one
        assert (slipped == "") == (one.source is None)
        assert one.source is None or shows(slipped, one.source), one
        assert (verdict == "reproduced") == shows(printed, one.right), one
        assert (verdict == "with the slip") == (
            one.source is not None and shows(printed, one.source)
        )
        assert reason or verdict == "reproduced"


def test_engine_shapes() -> None:
    text = text_of("validation_engine")
    body = text.split(f"\n## {engine_page.SHAPES}\n")[1].split("\n## ")[0]
    cells = [row for row in rows(body) if row[1] in ("printed", "computed")]
    modes = [one for freedoms in (7, 8) for one in engine_page.shape_cells(freedoms)]
    assert sum(len(one[1]) for one in modes) == sum(
        map(len, source.SHAPE_7[1:] + source.SHAPE_8[1:])
    )
    for (place, printed, value), above, below in zip(modes, cells[::2], cells[1::2], strict=True):
        assert above == [place, "printed", *printed] and below[:2] == ["", "computed"]
        assert all(shows(one, float(v)) for one, v in zip(below[2:], value, strict=True)), place


# ----------------------------------------------------------------------------
# Ong's compressor
# ----------------------------------------------------------------------------
COMPRESSOR = text_of("validation_compressor")
AT_WORK = {"A+B": "compressor", "A": "compressor_a", "B": "compressor_b"}
ENERGIES = {
    "### 3.3 Table 4.1": "kinetic",
    "### 3.4 Table 4.3": "potential",
    "### 3.6 Tables 4.5": "kinetic",
    "### 3.7 Table 4.6": "potential",
}


@pytest.mark.parametrize("below", ENERGIES)
def test_energies_of_the_compressor(below: str) -> None:
    """By order for each operation, or by operation and balance: mean and peak with ranges."""
    path, by_order = f"response/{ENERGIES[below]}_energy/peak_by_order", "Table 4.1 4.3"
    if below.split()[-1] in by_order:
        for order, *numbers in table(COMPRESSOR, "order", below):
            for case, number in zip(AT_WORK.values(), numbers[1::2], strict=True):
                assert shows(number, computed(case, path, {"order": int(order)}, "in*lbf"))
        return
    path = f"response/operations/{ENERGIES[below]}_energy"
    for at_work, balance, _, *numbers in table(COMPRESSOR, "at work", below):
        where = {"operation": at_work, "balance": balance}
        for reading, number, both in (("mean", *numbers[:2]), ("peak", *numbers[2:])):
            assert shows(number, computed("compressor", f"{path}/{reading}", where, "in*lbf"))
            for end, side in zip(both.split(" .. ") if both else (), ("low", "high"), strict=False):
                value = computed("compressor", f"{path}/{reading}_{side}", where, "in*lbf")
                assert shows(end, value), (where, reading, side)


def test_changes_of_operation_of_the_compressor() -> None:
    for label, quantity, *numbers in table(COMPRESSOR, "change"):
        path, _, direction = quantity.partition("` ")
        axis = "operation" if "steady_energy" in path else "change"
        names = ("A+B", "A") if axis == "operation" else ("A+B to A", "A to A+B")
        if label.startswith("steady, force"):
            continue  # of other cases, with damping
        for number, name in zip(numbers, names, strict=True):
            where = {axis: name, **({"direction": "y"} if direction else {})}
            value = computed("compressor_switching", path.strip("`"), where, "")
            assert shows(number, value if number.startswith("-") else abs(value)), label


# ----------------------------------------------------------------------------
# Herold's compressor
# ----------------------------------------------------------------------------


@pytest.mark.long
def test_numbers_by_name_of_the_roll_page() -> None:
    """In the columns after the quantity: what is computed, and what would be needed."""
    numbers = roll_page.numbers()
    seen = set()
    for cells in rows(roll_page.PAGE):
        for place, name in enumerate(cells):
            if name in numbers:
                seen.add(name)
                shown = [one.split(" ")[0] for one in cells[place + 1 :]]
                # the least levels have what is printed in between
                shown = shown[1:] if name in roll_page.least_numbers() else shown
                for value, number in zip(numbers[name], shown, strict=False):
                    assert shows(number, value), (name, number, value)
    assert seen == set(numbers)


@pytest.mark.long
def test_shorter_steps_lead_to_the_computed_levels() -> None:
    """Two thousandths of his step: what remains is mostly the first interval of the gas tables."""
    fine = simulate(source_machine(), open_tables(source_drive()), step=1e-5)
    assert np.max(np.abs(fine.level - level(roll_page.best_estimate()))) < 0.08


# ----------------------------------------------------------------------------
# Herold's measurement
# ----------------------------------------------------------------------------
MEASURED = text_of("validation_roll_measured")
LEVELS = ("standard", "no_roll", "only_roll", "only_pitch")


def _measured(path: str, where: dict[str, Any], unit: str) -> float:
    return computed("roll_measured", f"measurement/{path}", where, unit)


def test_numbers_of_the_measurement() -> None:
    for _, _, read, name, value, _ in table(MEASURED, "reading"):
        where = {"reading": name.strip("`")}
        assert shows(read, _measured("reading/read", where, "dB"))
        assert shows(value, _measured("reading/computed", where, "dB"))
    for _, order, shown, quantity, value, _ in table(MEASURED, "symbol"):
        path, *picks = re.findall(r"`([^`]+)`", quantity)
        where: dict[str, Any] = {"order": int(order)}
        if picks:
            where = {"candidate": picks[0], "position": "corner 6"}
        assert shows(value.split()[0], computed("roll_measured", path, where, shown.split()[1]))
    cells = table(MEASURED, "position")
    for above, below in zip(cells[::2], cells[1::2], strict=True):
        where = {"position": above[0], "order": int(above[1])}
        for part, value in zip(LEVELS, below[4:], strict=True):
            assert shows(value, _measured(f"level/{part}", where, "dB")), (where, part)


def test_four_cylinders() -> None:
    """The train of the case at other crank angles."""
    cells = rows(text_of("validation").split("| four cylinders at")[1].split("\n\n")[0])[1:]
    assert len(cells) == 4
    case = table_of("four_cylinder")
    train = case["machine"]["crank_train"]
    for angles, *numbers in cells:
        turned = [
            cylinder | {"crank_phase": f"{angle} deg"}
            for cylinder, angle in zip(train["cylinders"], angles.split(", "), strict=True)
        ]
        machine = case["machine"] | {"crank_train": train | {"cylinders": turned}}
        plain = {key: part for key, part in case.items() if key != "optimisation"}
        record = run_case(validate(plain | {"machine": machine}))
        force = np.abs(record["excitation/force"].values[:, 2])
        couple = np.abs(record["excitation/couple"].values[:, 1])
        values = [force[0], force[1], force[3], couple[0], couple[1]]
        values.append(float(record["excitation/residual"].values))
        for number, value in zip(numbers, values, strict=True):
            assert shows(number, value if value > 1e-9 else 0.0), (angles, number, value)
