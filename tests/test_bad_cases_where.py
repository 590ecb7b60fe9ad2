"""Claim: a `where` with a number that the run will not have is refused before it, at its line.

What only the run can tell is reported after it, names the row and costs no result.
"""

import re
import shutil
from pathlib import Path

import pytest
from fuzzing import command
from refused import said_of

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import load_case
from vibecalc.core.run.targets import check_targets
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError

CASES = Path(__file__).resolve().parents[1] / "cases"
GENERATOR = CASES / "generator.toml"
ROW = """
[[reference]]
quantity = "{quantity}"
where = {{ {where} }}
value = {value}
source = "a table"
"""
MEAN = "response/impact/mean_force"
FORCE = "excitation/force"
MAXIMUM = "isolation/run_up/maxima/force"


def written(folder: Path, text: str, quantity: str, where: str, value: str = "1.0") -> Path:
    path = folder / "one.toml"
    path.write_text(text + ROW.format(quantity=quantity, where=where, value=value))
    return path


def generator(orders: int | None) -> str:
    """The shipped generator up to its references, with some orders of excitation or without."""
    text = re.sub(r"(?ms)^\[\[(reference|limit).*", "", GENERATOR.read_text())
    text = re.sub(r"(?m)^\[excitation\].*\n(^[^\[\n].*\n)*", "", text)
    return text + "\n[excitation]\n" + ("" if orders is None else f"orders = {orders}\n")


@pytest.mark.parametrize(
    ("quantity", "where", "allowed"),
    [
        (MEAN, 'clearance = "20 um"', "allowed: 10 um, 30 um"),
        (MEAN, "clearance = 2e-5", "allowed: 1e-05 m, 3e-05 m"),
        ("response/impact/spectrum", 'clearance = "10 um", order = 101', "allowed: 1 to 100"),
    ],
)
def test_clearances_are_known_before_the_run(
    tmp_path: Path, quantity: str, where: str, allowed: str
) -> None:
    path = written(tmp_path, starter("impact"), quantity, where)
    line = path.read_text().splitlines().index(f"where = {{ {where} }}") + 1
    with pytest.raises(CaseError) as refused:
        load_checked([path], ())
    text = str(refused.value)
    assert f"one.toml:{line}:" in text and "[[reference]]" in text
    assert f"that {quantity} lacks" in text and allowed in text


def test_the_clearance_of_the_joint_counts_where_no_others_are_given(tmp_path: Path) -> None:
    text = starter("impact").replace('clearances = ["10 um", "30 um"]', "")
    assert "clearances =" not in re.sub("(?m)^#.*", "", text)
    for where, problems in (('clearance = "0.03 mm"', 0), ('clearance = "10 um"', 1)):
        case = load_case(written(tmp_path, text, MEAN, where)).case
        assert len(check_targets(case)) == problems


@pytest.mark.parametrize(
    ("quantity", "order", "allowed"),
    [
        (FORCE, 5, "1, 2, 3, 4"),
        (FORCE, 0, "1, 2, 3, 4"),
        (FORCE, 1.5, "1, 2, 3, 4"),
        ("kinematics/position_harmonics", 5, "0, 1, 2, 3, 4"),
        ("kinematics/position_harmonics", 0, None),
        (FORCE, 4, None),
    ],
)
def test_orders_of_excitation_are_known_before_the_run(
    tmp_path: Path, quantity: str, order: float, allowed: str | None
) -> None:
    where = f"order = {order}" + ', direction = "z"' * (quantity == FORCE)
    path = written(tmp_path, generator(4), quantity, where)
    problems = check_targets(load_case(path).case)
    assert [problem.allowed for problem in problems] == ([] if allowed is None else [allowed])
    assert all(problem.path == ("reference", 0, "where") for problem in problems)


def test_an_order_that_the_tolerance_leaves_out_is_refused(tmp_path: Path) -> None:
    where = 'order = 399, direction = "z"'
    path = written(tmp_path, generator(None), FORCE, where, '"1 N"')
    (problem,) = check_targets(load_case(path).case)
    assert problem.path == ("reference", 0, "where")
    assert problem.hint == "orders that are kept: all of the truncated series"


def test_a_maximum_that_a_run_lacks_costs_no_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = generator(None).replace("run_up = {", "run_up_maxima = 0.5\nrun_up = {")
    path = written(tmp_path, text, MAXIMUM, "maximum = 399", '"1 N"')
    Path("outputs").mkdir()
    Path("outputs/one.txt").write_text("the report of an earlier run")
    outcome = command("run", str(path), "-q")
    assert outcome.code == 2
    assert f"the [[reference]] on {MAXIMUM} [maximum=399] (a table)" in outcome.err
    assert "outputs/one.h5, without a report" in outcome.err
    assert Path("outputs/one.h5").is_file() and not Path("outputs/one.txt").exists()


def test_a_sweep_may_change_the_clearance_that_a_limit_names(tmp_path: Path) -> None:
    path = written(tmp_path, starter("impact"), MEAN, 'clearance = "20 um"')
    key = "machine.joints.wrist_pin.stiffness"
    sweep = f'[[sweep.axes]]\nkey = "{key}"\nvalues = ["1e8 N/m", "2e8 N/m"]\n'
    assert len(check_targets(load_case(path).case)) == 1
    path.write_text(f"{path.read_text()}\n{sweep}")
    assert len(check_targets(load_case(path).case)) == 1, "`run` computes the case as written"
    limit = starter("impact") + STUDIES["limit"].replace(LARGEST, MEAN)
    path.write_text(
        limit.replace('curve = "locked"', 'clearance = "20 um"').replace("50.0", '"9 N"')
    )
    assert len(check_targets(load_case(path).case)) == 1
    path.write_text(f"{path.read_text()}\n{sweep}")
    assert check_targets(load_case(path).case) == []


CURVES = CASES / "absorber_damped.toml"
LARGEST = "response/absorber/largest"
STUDIES = {
    "reference": ROW.format(quantity=LARGEST, where='curve = "locked"', value="3.0"),
    "limit": f'[[limit]]\nquantity = "{LARGEST}"\nwhere = {{ curve = "locked" }}\nmax = 50.0\n',
    "find": f"""[[find]]
name = "one"
key = "machine.secondary.mass_ratio"
min = 0.1
max = 0.2
quantity = "{LARGEST}"
where = {{ curve = "locked" }}
change = 0.001
""",
    "objective": f"""[optimisation]
objective = {{ quantity = "{LARGEST}", where = {{ curve = "locked" }} }}
variables = [{{ key = "machine.secondary.mass_ratio", min = 0.1, max = 0.2 }}]
""",
    "second": f"""[optimisation]
objective = {{ quantity = "{LARGEST}", where = {{ curve = "as given" }} }}
second_objective = {{ quantity = "{LARGEST}", where = {{ curve = "locked" }} }}
variables = [{{ key = "machine.secondary.mass_ratio", min = 0.1, max = 0.2 }}]
""",
}


@pytest.mark.parametrize("study", STUDIES)
def test_curves_of_an_absorber_are_known_before_the_run(study: str, tmp_path: Path) -> None:
    text = re.sub(r"(?ms)^\[\[(reference|limit).*", "", CURVES.read_text())
    assert "\nlimits = true" in text
    path = tmp_path / "one.toml"
    for drawn in (True, False):
        path.write_text(
            text.replace("\nlimits = true", f"\nlimits = {str(drawn).lower()}") + STUDIES[study]
        )
        if drawn:
            load_checked([path], ())
            continue
        with pytest.raises(CaseError) as refused:
            load_checked([path], ())
        said = str(refused.value)
        line = next(
            number
            for number, one in enumerate(path.read_text().splitlines(), 1)
            if 'curve = "locked"' in one
        )
        assert f"one.toml:{line}:" in said
        assert "there is no curve named 'locked'" in said
        assert "'as given', 'absorber damping ratio 0'" in said


def test_a_limit_of_an_optimisation_has_a_name_and_no_number(tmp_path: Path) -> None:
    text = (CASES / "generator_mount_design.toml").read_text()
    name = "isolation/support_force/steady_peak max 100 N"
    load_checked([written(tmp_path, text, "optimisation/margin", f'limit = "{name}"', "0.0")])


@pytest.mark.parametrize(
    ("path", "axis", "allowed"),
    [
        ("tuning/method/peak", "method", "'den_hartog', 'nishihara_asami', 'numerical'"),
        ("tuning/sensitivity/peak", "ratio", "'primary_damping', 'mass_ratio'"),
        ("response/absorber/fixed_point/magnitude", "fixed_point", "'P', 'Q'"),
    ],
)
def test_names_of_a_tuning_are_known_before_the_run(
    path: str, axis: str, allowed: str, tmp_path: Path
) -> None:
    text = re.sub(r"(?ms)^\[\[(reference|limit).*", "", (CASES / "absorber.toml").read_text())
    case = load_case(written(tmp_path, text, path, f'{axis} = "none"')).case
    assert [problem.allowed for problem in check_targets(case)] == [allowed]


# ----------------------------------------------------------------------------
# Modes, peaks and keys that no machine of the kind has.
# ----------------------------------------------------------------------------

MODES = "response/torsion/modes/natural_frequency"
SHAFT = "a shaft line has at most one mode for each station and each damper"


@pytest.mark.parametrize(
    ("case", "quantity", "axis", "entry", "allowed"),
    [
        ("engine_undamped", MODES, "mode", 3000, SHAFT),
        ("engine_undamped", MODES, "mode", 0.15, SHAFT),
        ("engine_undamped", MODES, "mode", 0, SHAFT),
        ("engine_damped", "response/torsion/peak/speed", "peak", 0.5, "1, 2, 3"),
        ("compressor", "response/modes/natural_frequency", "mode", 7, "6 degrees of freedom"),
    ],
)  # fmt: skip
def test_a_mode_that_no_machine_of_the_kind_has(
    case: str, quantity: str, axis: str, entry: float, allowed: str, tmp_path: Path
) -> None:
    for table in CASES.glob("*.csv"):
        shutil.copy(table, tmp_path)
    text = (CASES / f"{case}.toml").read_text(encoding="utf-8")
    for number, problems in ((entry, 1), (2, 0)):
        path = written(tmp_path, text, quantity, f"{axis} = {number}", '"1 rad/s"')
        found = check_targets(load_case(path).case)
        assert len(found) == problems
        for one in found:
            assert f"asks for a {axis} that {quantity} lacks" in one.message
            assert one.found == f"{axis} = {number}" and allowed in said_of(one)


def test_ten_thousand_unknown_keys_are_counted(tmp_path: Path) -> None:
    """All of them; the nearest known keys are looked for where the first ones are."""
    path = tmp_path / "case.toml"
    keys = "".join(f"sped{number} = 1\n" for number in range(10_000))
    text = GENERATOR.read_text(encoding="utf-8")
    path.write_text(text.replace("[machine]\n", f"[machine]\n{keys}", 1), encoding="utf-8")
    with pytest.raises(CaseError) as raised:
        load_checked([path], ())
    assert len(raised.value.problems) == 10_000
    assert str(raised.value).count("did you mean 'speed'?") == 10
