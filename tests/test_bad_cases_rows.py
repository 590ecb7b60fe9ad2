"""Claim: what a case contradicts itself in is refused in words at its key: rows of `refusals/`."""

import json
import math
import shutil
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from engine_cases import CRANK, ENGINE, GEARED, ran
from mounted_sets import tables
from refused import changed, problems_of, refusal, refusals, said_of, with_keys
from shipped_cases import CASES
from stock_cases import BASE, PICKED, ROBUST

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.core.run.targets import check_targets
from vibecalc.errors import NumericalFailure, dotted

Data = dict[str, Any]
LINES = {"pump": "pump_drive", "geared": "engine_geared", "v8": "engine_v8"}
BEARINGS = {"engine": "engine_bearing_loads", "radial": "radial_articulated"}
LIMITED = {"engine": ENGINE, "geared": GEARED}


@cache
def resolved(name: str, *without: str) -> Data:
    """A shipped case with the numbers of its files, without some of its tables."""
    found = load_case(CASES[name]).resolved
    return {key: one for key, one in found.items() if key not in without}


def without_excitations() -> Data:
    """The marine line without what some of the rows ask for in another way."""
    return with_keys(resolved("marine_propulsion"), '{"machine.shaft_line.excitations": null}')


#: table of rows -> tables of a case by its short name
OF_TABLES: dict[str, Callable[[str], Data]] = {
    "balance": lambda case: resolved(f"balance_{case}"),
    "base": lambda _: resolved("genset_on_deck"),
    "damping": lambda _: without_excitations(),
    "line": lambda case: resolved(LINES[case], "reference", "reference_table", "limit"),
    "mounts": lambda _: tables(),
    "points": lambda _: resolved("genset_points"),
}
#: table of rows -> text of a case by its short name
OF_TEXTS: dict[str, Callable[[str], str]] = {
    "bearing_loads": lambda case: CASES[BEARINGS[case]].read_text(encoding="utf-8"),
    "limits": lambda case: LIMITED[case],
}
#: table of rows -> text of a case in a file, with a record next to it
MASS_BY = '{ key = "machine.body.mass", half_width = "10 %" }'
IN_FILES = {
    "choices": BASE + PICKED,
    "fit": CASES["generator_mount_fit"].read_text(encoding="utf-8"),
    "records": CASES["roll_records"].read_text(encoding="utf-8"),
    "robust": BASE
    + ROBUST.replace("QUANTITY", "isolation/pitch/stiffness").replace("TOLERANCES", MASS_BY),
}
#: of these other problems may come first: they name files that lie elsewhere
NOT_FIRST = ("bearing_loads",)
#: what another kind of machine lacks is said at several of its tables
AT_SEVERAL = ("line",)


@pytest.mark.parametrize("table", [*OF_TABLES, *OF_TEXTS])
def test_refused_at_its_key(table: str) -> None:
    for row in refusals(table):
        case, change, place, words = row.values
        if table in OF_TABLES:
            data = with_keys(OF_TABLES[table](case), change, NAN=math.nan)
        else:
            text = changed(OF_TEXTS[table](case), change.replace("CRANK", CRANK))
            data = tomllib.loads(text)
        found = problems_of(data)
        there = [one for one in found if place in (".".join(map(str, one.path)), dotted(one.path))]
        assert there and (there[0] is found[0] or table in NOT_FIRST), (change, found)
        said = " ".join(map(said_of, found if table in AT_SEVERAL else there))
        assert [word for word in words if word not in said] == [], (change, said)
        assert len({(one.path, one.message) for one in found}) == len(found)


@pytest.mark.parametrize("table", IN_FILES)
def test_refused_in_its_file(table: str, tmp_path: Path) -> None:
    shutil.copy(CASES["roll_records"].with_suffix(".csv"), tmp_path)
    for row in refusals(table):
        _, change, place, words = row.values
        said = refusal(tmp_path, "case", changed(IN_FILES[table], change))
        expected = (*words, *([place] if place != "-" else []))
        assert [word for word in expected if word not in said] == [], (change, said)


@pytest.mark.parametrize("table", OF_TABLES)
def test_the_plain_cases_are_fine(table: str) -> None:
    for case in {row.values[0] for row in refusals(table)}:
        assert problems_of(OF_TABLES[table](case)) == [], case


def test_damping_by_modes_that_does_not_count_is_said() -> None:
    case = validate(with_keys(resolved("genset_on_deck"), '{"machine.mounts.modal_damping": 0.05}'))
    (said,) = (one for one in machine_warnings(case) if "modal_damping" in one)
    assert said.endswith("not to [isolation], [foundation], [base_motion]")


def test_a_reading_and_an_order_that_are_not_there_are_refused() -> None:
    wrong = json.dumps({"sensor": "governer x"})
    data = with_keys(resolved("genset_points"), f'{{"limit[0].where": {wrong}}}')
    data["reference"] = [
        {"quantity": "points/velocity", "where": {"sensor": "base", "order": 0.25}, "value": 1.0,
         "source": "none"}
    ]  # fmt: skip
    order, reading = check_targets(validate(data))
    assert "there is no sensor named 'governer x'" in reading.message
    assert "governor x" in reading.hint and reading.path == ("limit", 0, "where")
    assert "asks for an order that points/velocity lacks" in order.message
    assert order.allowed == "0.5 to 16"
    data["sweep"] = {"axes": [{"key": "machine.speed", "values": [150.0, 160.0]}]}
    assert len(check_targets(validate(data))) == 2, "`run` holds the case against its references"


def test_a_gear_without_a_mean_torque_has_no_share_of_it() -> None:
    with pytest.raises(NumericalFailure, match="'wheel - take-off' carries no mean torque"):
        ran(GEARED + "limits = [{ alternating_share = 0.3 }]\n")
