"""Claim: the computed numbers in docs/validation.md are what the cases give, to every digit."""

import re
from typing import NamedTuple

import numpy as np
import pytest
from shipped_cases import ROOT, result_of, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.select import scalar
from vibecalc.core.run.run import run_case

TEXT = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
QUANTITY = re.compile(r"^`([\w/]+)`((?: \w+=\w+)*)(?: with `([^`]+)`)?$")
NUMBER = re.compile(r"^(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)(?: \S+)?$")
SUMS = {
    "sin a": ("sine", 1),
    "cos a": ("cosine", 1),
    "sin 2a": ("sine", 2),
    "cos 2a": ("cosine", 2),
}


class Stated(NamedTuple):
    """A quantity with its conditions and the number that the page shows for it."""

    path: str
    where: dict[str, int | str]
    setting: str
    number: str
    exact: bool


def rows(text: str) -> list[list[str]]:
    """Cells of all table rows."""
    lines = [line for line in text.split("\n") if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def stated() -> list[Stated]:
    """Every `path` cell of the page with the number to its right; with two, both motions."""
    found = []
    for cells in rows(TEXT):
        for place, cell in enumerate(cells[:-1]):
            quantity = QUANTITY.match(cell)
            if quantity is None:
                continue
            path, where, setting = quantity[1], quantity[2].split(), quantity[3] or ""
            pairs = (pair.split("=") for pair in where)
            picked = {k: int(v) if k == "order" else v for k, v in pairs}
            numbers = [NUMBER.match(one) for one in cells[place + 1 : place + 3]]
            assert numbers[0] is not None, cells
            found.append(Stated(path, picked, setting, numbers[0][1], False))
            if len(numbers) > 1 and numbers[1] is not None:
                found.append(Stated(path, picked, setting, numbers[1][1], True))
    return found


@pytest.fixture(scope="module")
def exact_motion() -> Record:
    table = {key: part for key, part in table_of("generator").items() if key != "kinematics"}
    return run_case(validate(table))


def shows(number: str, value: float) -> bool:
    """The value, rounded to the digits of the number, is the number; 0 stands for noise."""
    if number == "0":
        return abs(value) < 1e-12
    mantissa, _, exponent = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    unit = 10.0 ** (int(exponent or 0) - decimals)
    return abs(value - float(number)) <= 0.5000001 * unit


@pytest.mark.parametrize("row", stated(), ids=lambda row: f"{row.path}-{row.number}")
def test_computed_number_is_what_the_case_gives(row: Stated, exact_motion: Record) -> None:
    settings = [row.setting] if row.setting else []
    record = exact_motion if row.exact else result_of("generator", *settings).record
    value = abs(scalar(record[row.path], row.where))
    assert shows(row.number, value), f"{row.number} is shown, {value!r} computed"


def test_the_page_states_enough_numbers() -> None:
    found = stated()
    assert len(found) > 40
    assert sum(row.exact for row in found) == 10
    assert {row.setting for row in found} == {"", "machine.mounts.each.stiffness=2500.0"}


def test_tables_1_to_4() -> None:
    cells = rows(TEXT.split("### 1.2")[1].split("### 1.3")[0])[2:]
    assert len(cells) == 2 * 16
    for printed, computed in zip(cells[::2], cells[1::2], strict=True):
        number, name = int(printed[0]), printed[1]
        assert (printed[2], computed[:3]) == ("printed", ["", "", "computed"])
        record = result_of("generator" if number in (1, 3) else "generator_180").record
        place = "position_" if name.startswith("z ") else ""
        column, order = SUMS[name.removeprefix("z ")]
        entries = record[f"excitation/balance/{place}{column}"]
        total = record[f"excitation/balance/total_{place}{column}"]
        values = [scalar(entries, {"order": order, "cylinder": c}) for c in "123"]
        values.append(scalar(total, {"order": order}))
        assert all(shows(cell, float(v)) for cell, v in zip(computed[3:], values, strict=True))


def four_cylinders(angles: str, length: str = "150 mm") -> Record:
    """The train of the case at other crank angles, over a reference length."""
    case = table_of("four_cylinder")
    train = case["machine"]["crank_train"]
    cylinders = [
        cylinder | {"crank_phase": f"{angle} deg"}
        for cylinder, angle in zip(train["cylinders"], angles.split(", "), strict=True)
    ]
    residual = case["excitation"]["residual"] | {"reference_length": length}
    changed = {
        "machine": case["machine"] | {"crank_train": train | {"cylinders": cylinders}},
        "excitation": case["excitation"] | {"residual": residual},
    }
    plain = {key: part for key, part in case.items() if key != "optimisation"}
    return run_case(validate(plain | changed))


def test_four_cylinders_over_a_longer_reference_length() -> None:
    words = " ".join(TEXT.split())
    found = re.search(r"falls from (\S+) N to (\S+) N at phases of ([\d., ]+) degrees", words)
    assert found is not None
    mirrored = re.search(r"mirror image ([\d., ]+)\)", words)
    assert mirrored is not None
    places = (("0, 180, 180, 0", found[1]), (found[3], found[2]), (mirrored[1], found[2]))
    for angles, number in places:
        record = four_cylinders(angles, "300 mm")
        assert shows(number, float(record["excitation/residual"].values))


def test_four_cylinders() -> None:
    cells = rows(TEXT.split("| four cylinders at")[1].split("\n\n")[0])[1:]
    assert len(cells) == 4
    for angles, *numbers in cells:
        record = four_cylinders(angles)
        force = np.abs(record["excitation/force"].values[:, 2])
        couple = np.abs(record["excitation/couple"].values[:, 1])
        values = [force[0], force[1], force[3], couple[0], couple[1]]
        values.append(float(record["excitation/residual"].values))
        for number, value in zip(numbers, values, strict=True):
            assert shows(number, value if value > 1e-9 else 0.0), (angles, number, value)


def test_mount_designs_from_their_variables() -> None:
    """The rest of the table follows from stiffness, damping and block."""
    header, *cells = rows("| mount design" + TEXT.split("| mount design")[1].split("\n\n")[0])
    table = {row[0]: row[1:] for row in cells[1:]}
    quantities = {
        "objective, m": "isolation/support_displacement/excursion",
        "sag, m": "isolation/support_displacement/sag",
        "amplitude of a support, m": "isolation/support_displacement/vertical_peak",
        "natural frequency, rad/s": "isolation/pitch/natural_frequency",
        "damping ratio": "isolation/pitch/damping_ratio",
        "steady force of one support, N": "isolation/support_force/steady_peak",
        "run-up force of one support, N": "isolation/support_force/run_up_peak",
    }
    for column, name in enumerate(header[1:]):
        case = table_of("generator_mount_design" if column == 0 else name)
        machine = case["machine"]
        block = machine["body"]["inertia_block"] | {"mass": float(table["block, kg"][column])}
        each = {
            "stiffness": float(table["stiffness, N/m"][column]),
            "damping": float(table["damping, N s/m"][column]),
        }
        machine = machine | {
            "mounts": machine["mounts"] | {"each": each},
            "body": machine["body"] | {"inertia_block": block},
        }
        plain = {k: v for k, v in case.items() if k not in ("optimisation", "limit")}
        record = run_case(validate(plain | {"machine": machine}))
        for row, path in quantities.items():
            value = float(np.max(record[path].values))
            # the variables are shown with eight digits
            assert float(table[row][column]) == pytest.approx(value, rel=5e-8), (name, row)


def test_every_test_that_the_page_names_is_there() -> None:
    for name in re.findall(r"`((?:tests/)[\w/]+\.py)`", TEXT):
        assert (ROOT / name).is_file(), name
    published = "".join(
        p.read_text(encoding="utf-8") for p in (ROOT / "tests/published").glob("*.py")
    )
    named = re.findall(r"`(test_\w+)`", TEXT)
    assert len(named) >= 4
    for name in named:
        assert f"def {name}(" in published, name
