"""Claim: a run takes what `vibecalc check` says, and a table that is left out takes its cost along.

`make golden` holds the modules, stages and harmonics of every shipped case; here are a few.
"""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from long_but import long_but
from needs_cases import FOLDER, NAMES, case_of, lighter_cases, table_of
from shipped_cases import ROOT
from test_start_up import computing, modules_after, roots

from vibecalc.core.case.load import validate
from vibecalc.core.report.check import counted_seconds, time_in_words
from vibecalc.core.results.catalogue import OWNER
from vibecalc.core.results.record import AT_START, Result
from vibecalc.core.results.store import read_result
from vibecalc.core.run.plan import Needs, StageNeeds, needs_of, plan_case
from vibecalc.core.run.targets import KnownEntries
from vibecalc.subjects import SUBJECTS

GOLDEN = ROOT / "tests" / "golden"


def harmonic_differences(needs: Needs, result: Result) -> Iterator[tuple[str, str]]:
    """Stages whose results have other harmonics than `check` says, and how they differ."""
    for stage in needs.stages:
        said = stage.harmonics
        if said is None:
            continue
        number, highest = harmonics_found(stage, result)
        if said.is_least and number >= said.number and highest >= said.highest:
            continue
        if number and (number, highest) != (said.number, said.highest):
            yield stage.plan.name, f"said {said.words()}; computed {number} up to {highest:g}"


def harmonics_found(stage: StageNeeds, result: Result) -> tuple[int, float]:
    """Number and highest of the orders of a stage's results, the mean apart; 0 without any."""
    longest = (0, 0.0)
    for path in stage.plan.quantities:
        quantity = result.record.quantities.get(path)
        for axis in () if quantity is None else quantity.axes:
            if axis.name == "order":
                orders = [float(order) for order in axis.values if order]
                longest = max(longest, (len(orders), max(orders, default=0.0)))
    return longest


#: of each kind of machine what others say as well is left to `make test-long`
FEW = (
    "absorber", "absorber_pendulum", "compressor", "engine_run_up", "generator", "pump",
    "roll_measured", "roll_mounted",
)  # fmt: skip


@pytest.mark.parametrize(
    "name", long_but([name for name in NAMES if (GOLDEN / f"{name}.h5").is_file()], *FEW)
)
def test_harmonics_of_every_golden_result_are_those_said(name: str) -> None:
    case = case_of(table_of(name))
    assert case is not None
    golden = read_result(GOLDEN / f"{name}.h5")
    assert list(harmonic_differences(needs_of(case), golden)) == []


#: axes with names that only a run knows
FOUND_BY_RUNS = {
    *("candidate", "further", "reading", "signal", "bound", "motor_parameter", "parameter"),
    *("cause", "component", "crank_place", "damper_curve", "freedom", "slave_rod"),
}


@pytest.mark.parametrize(
    "name", long_but([name for name in NAMES if (GOLDEN / f"{name}.h5").is_file()], *FEW)
)
def test_names_of_every_golden_result_are_those_known_before(name: str) -> None:
    case = case_of(table_of(name))
    assert case is not None
    entries = KnownEntries(case)
    for path, quantity in read_result(GOLDEN / f"{name}.h5").record.items():
        for axis in quantity.axes if path.removeprefix(AT_START) in OWNER else ():
            texts = [one for one in axis.values.tolist() if isinstance(one, str)]
            if texts and axis.name not in FOUND_BY_RUNS:
                assert set(texts) <= {*entries.names(path)[axis.name]}, (path, axis.name)


def test_check_of_every_kind_imports_no_stage_and_no_library(tmp_path: Path) -> None:
    names = ("engine_run_up", "absorber", "roll_dynamic_motor")
    modules = modules_after("check", *(str(FOLDER / f"{n}.toml") for n in names), cwd=tmp_path)
    assert not roots(modules) & {"scipy", "h5py", "pint", "matplotlib"}
    assert not {name for name in modules if ".adapter" in name}


@pytest.mark.parametrize(
    ("name", "others"),
    [
        pytest.param(
            *("generator", {"torsion", "roll", "absorber", "impact", "measurement"}),
            marks=pytest.mark.long,
        ),
        ("absorber_curves", set(SUBJECTS) - {"absorber"}),
    ],
)
def test_a_stage_whose_table_is_absent_is_not_imported(
    name: str, others: set[str], tmp_path: Path
) -> None:
    case = case_of(table_of(name))
    assert case is not None
    modules = modules_after("run", str(FOLDER / f"{name}.toml"), "-q", cwd=tmp_path)
    assert {stage.adapter.partition(":")[0] for stage in plan_case(case)} <= modules
    assert not {one for one in computing(modules) if one.split(".")[0] in others}
    planned = {stage.adapter.partition(":")[0] for stage in plan_case(case)}
    makers = {
        path.relative_to(ROOT).with_suffix("").as_posix().replace("/", ".")
        for path in (ROOT / "vibecalc").rglob("*.py")
        if re.search(r"^def run_\w+\(scene: Scene\)", path.read_text(encoding="utf-8"), re.M)
    }
    assert planned <= makers
    assert makers & modules <= planned | set(READ_BY_OTHERS)


#: adapters that others take a part of
READ_BY_OTHERS: tuple[str, ...] = ()


class Cost(Counter[str]):
    """Counted terms of a plan: stages and quantities."""


def _cost(needs: Needs) -> Cost:
    found = Cost()
    for stage in needs.stages:
        found["stages"] += 1
        found["quantities"] += len(stage.plan.quantities)
    return found


@pytest.mark.parametrize("name", long_but(NAMES, *FEW))
def test_a_table_left_out_takes_its_cost_along(name: str) -> None:
    counted = 0
    for key, whole, part in lighter_cases(name):
        before, after = _cost(needs_of(whole)), _cost(needs_of(part))
        grown = [what for what in before | after if after[what] > before[what]]
        cheaper = counted_seconds(part) < counted_seconds(whole)
        assert not grown or key in KEYS_THAT_STAND_FOR_LESS, (key, grown)
        assert after != before or cheaper or key in WITHOUT_A_COST, key
        counted += 1
    assert counted or name in BARE, name


#: a table that also says how the machine is driven: what it drives then counts as on the body
KEYS_THAT_STAND_FOR_LESS = (("excitation",),)


def test_the_time_is_an_order_of_magnitude_and_grows_as_the_work_does() -> None:
    said = [time_in_words(seconds) for seconds in (0.1, 0.8, 5.0, 59.0, 600.0, 3600.0, 2e4, 1e6)]
    words = (
        "less than a second",
        "about a second",
        "seconds",
        "about a minute",
        "minutes",
        "about an hour",
    )
    assert said == [*words, "hours", "days"]
    seconds = []
    for count in (500, 1000):
        inertia, shaft = {"inertia": "1 kg*m^2"}, {"stiffness": "1e5 N*m/rad"}
        line = {
            "speed_of": "s0",
            "stations": [{"name": f"s{n}", **inertia} for n in range(count)],
            "shafts": [{"name": f"k{n}", **shaft} for n in range(count - 1)],
            "excitations": [{"on": "s0", "orders": [1], "torques": ["1 N*m"]}],
        }
        machine = {"kind": "drive_train", "speed": "1000 rpm", "shaft_line": line}
        case = {"schema": 1, "title": "row", "machine": machine, "response": {"torsion": {}}}
        seconds.append(counted_seconds(validate(case)))
    assert time_in_words(seconds[0]) == "seconds" and seconds[1] > 5.0 * seconds[0]


#: forces that other tables need as well; natural frequencies that no pendulum moves with the speed
WITHOUT_A_COST = (
    *(("excitation",), ("document",), ("response", "torsion", "campbell")),
    # without these the ratios that a closed form needs
    ("response", "absorber", "frequency_ratios"),
)
#: cases with one table only, or none: there is no run without it
BARE = ("absorber_friction", "absorber_pendulum", "roll_measured", "roll_records")
