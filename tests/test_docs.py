"""Claim: the numbers in docs/validation*.md are what the cases give, to every digit shown."""

import re
from typing import Any

import numpy as np
import pytest
import roll_page
from herold_simulation import open_tables, simulate
from pages import computed, is_shown, missing_names, rows, shows, stated, table, text_of
from roll_machines import source_drive, source_machine
from shipped_cases import CASES, ROOT, table_of

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.run import run_case
from vibecalc.roll.turn import level

PAGES = sorted(path.stem for path in (ROOT / "docs").glob("*.md"))
#: page -> its case, where no line says it; least number of quantities on it
NUMBERS = {
    "validation": ("generator", 30),
    "validation_compressor": ("", 15),
    "validation_roll": ("", 12),
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
ROLL = text_of("validation_roll")


@pytest.mark.long
def test_shorter_steps_lead_to_the_computed_levels() -> None:
    """Two thousandths of his step: what remains is mostly the first interval of the gas tables."""
    fine = simulate(source_machine(), open_tables(source_drive()), step=1e-5)
    assert np.max(np.abs(fine.level - level(roll_page.best_estimate()))) < 0.08


def _measured(path: str, where: dict[str, Any], unit: str) -> float:
    return computed("roll_measured", f"measurement/{path}", where, unit)


def test_derived_quantities_of_the_measurement() -> None:
    """Table 1: compatible where the computed digits are not the printed ones."""
    found = table(ROLL, "symbol")
    assert len(found) == 10
    for symbol, quantity, printed, numbers, compatible in found:
        path, permutation = re.fullmatch(r"`measurement/([\w/]+)` ?(\S*)", quantity).groups()
        unit = symbol.split(", ")[1]
        pairs = zip(printed.split(", "), numbers.split(", "), strict=True)
        off = []
        for order, (read, number) in enumerate(pairs, start=1):
            where: dict[str, Any] = {"order": order}
            if permutation:
                where = {"candidate": f"{order} {permutation}", "position": "corner 6"}
            value = _measured(path, where, unit)
            assert shows(number, value), (quantity, order, value)
            if not shows(read, value):
                off.append(str(order))
        assert off == (compatible.split(", ") if compatible else []), quantity


def test_summary_of_the_measurement() -> None:
    """Input apart, the numbers are references of the case: measured, within, or known to differ."""
    references = load_case(CASES["roll_measured"]).case.reference
    for number, _, _, *counts in table(ROLL, "table"):
        mine = [one for one in references if one.source.startswith(f"Table {number}")]
        read = [one for one in mine if one.kind == "measured"]
        off = [one for one in mine if one.known_difference]
        numbers = [len(read), len(mine) - len(read) - len(off), len(off)]
        assert numbers == [int(cell or 0) for cell in counts], number


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
