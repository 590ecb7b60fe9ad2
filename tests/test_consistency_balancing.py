"""Claim: weights that turn have one best balance, and angles have no ends."""

import math
import re
from pathlib import Path

import pytest

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem
from vibecalc.errors import CaseError

#: 90-degree V6 with split pins: its couple of order 1 needs weights on the crank and on a shaft
V6 = """
schema = 1
title = "V6"
[machine]
kind = "machine"
speed = "5000 rpm"
[machine.crank_train]
crank_radius = "43.2 mm"
rod_length = "150 mm"
reciprocating_mass = "520 g"
rotating_mass = "300 g"
cylinders = [
  { name = "1L", position = "-125 mm", bank_angle = "-45 deg", crank_phase = "15 deg" },
  { name = "2R", position = "-105 mm", bank_angle = "45 deg",  crank_phase = "-15 deg" },
  { name = "3L", position = "-10 mm",  bank_angle = "-45 deg", crank_phase = "135 deg" },
  { name = "4R", position = "10 mm",   bank_angle = "45 deg",  crank_phase = "105 deg" },
  { name = "5L", position = "105 mm",  bank_angle = "-45 deg", crank_phase = "255 deg" },
  { name = "6R", position = "125 mm",  bank_angle = "45 deg",  crank_phase = "225 deg" },
]
counterweights = [
  { name = "front", unbalance = "0.02 kg*m", phase = "0 deg", position = "170 mm" },
  { name = "rear", unbalance = "0.02 kg*m", phase = "180 deg", position = "-170 mm" },
]
balance_shafts = [
  { name = "a", unbalance = 5e-4, phase = "0 deg", speed_ratio = -1, position = [0.17, 0, 0.12] },
  { name = "b", unbalance = 5e-4, phase = "180 deg", speed_ratio = -1, position = [-0.17,0,0.12] },
]
[excitation]
orders = 1
residual = { reference_length = "340 mm" }
[optimisation]
objective = { quantity = "excitation/residual" }
starts = 3
"""
WEIGHT, SHAFT = "machine.crank_train.counterweights", "machine.crank_train.balance_shafts"
ROOT = "optimisation/"
#: a phase that takes another key along
TURNED = (
    f'{{{{ key = "{WEIGHT}[0].phase", min = "0 deg", max = "360 deg", followed_by = [{{}}] }}}}'
)


def _variable(key: str, lower: str, upper: str, ties: str = "") -> str:
    return f'{{ key = "{key}", min = "{lower}", max = "{upper}"{ties} }}'


def _both(which: str, index: int, most: str) -> list[str]:
    key = f"{which}[{index}]"
    return [
        _variable(f"{key}.unbalance", "0 kg*m", most),
        _variable(f"{key}.phase", "0 deg", "360 deg"),
    ]


def _four(shafts: str = "0.02 kg*m") -> list[str]:
    weights = [one for index in (0, 1) for one in _both(WEIGHT, index, "0.2 kg*m")]
    return weights + [one for index in (0, 1) for one in _both(SHAFT, index, shafts)]


def _run(folder: Path, variables: list[str], more: str = "") -> Record:
    return execute(load_checked([_file(folder, variables, more)])[0]).record


def _file(folder: Path, variables: list[str], more: str = "") -> Path:
    path = folder / "v6.toml"
    path.write_text(f"{V6}variables = [{', '.join(variables)}]\n{more}", encoding="utf-8")
    return path


def _value(record: Record, name: str) -> float:
    return float(record[f"{ROOT}{name}"].values)


def _degrees(record: Record, which: str, index: int) -> float:
    return math.degrees(_value(record, f"variable/{which}[{index}].phase"))


def test_two_weights_and_two_shafts_leave_nothing_of_the_first_order(tmp_path: Path) -> None:
    record = _run(tmp_path, _four())
    start = float(record["optimisation/start/excitation/residual"].values)
    assert _value(record, "objective") <= 1e-13 * start
    assert _value(record, "lower_bound") == 0.0
    # the couple is that of three throws: on the crank and backwards 15 degrees off the first throw
    angles = [_degrees(record, which, index) for which in (WEIGHT, SHAFT) for index in (0, 1)]
    assert angles == pytest.approx([30.0, 210.0, 150.0, 330.0], abs=1e-9)
    assert record["optimisation/optima/objective"].values.size == 1
    for key in ("counterweights[0].phase", "balance_shafts[1].phase"):
        assert _value(record, f"active_bound/machine.crank_train.{key}") == 0


def test_shafts_that_are_too_light_end_at_their_bounds_and_at_the_lower_bound(
    tmp_path: Path,
) -> None:
    most = 0.001
    record = _run(tmp_path, _four(f"{most} kg*m"))
    objective, bound = _value(record, "objective"), _value(record, "lower_bound")
    assert objective == pytest.approx(bound, rel=1e-11)
    for index in (0, 1):
        assert _value(record, f"variable/{SHAFT}[{index}].unbalance") == most
        assert _value(record, f"active_bound/{SHAFT}[{index}].unbalance") == 1
    # what is left of the couple that turns backwards is in proportion to the weight not allowed
    full = _value(_run(tmp_path, _four()), f"variable/{SHAFT}[0].unbalance")
    square = float(load_checked([_file(tmp_path, _four())])[0].case.machine.speed ** 2)
    couple = (full - most) * square * 0.340
    assert objective == pytest.approx(math.sqrt(2.0) * couple / 0.340, rel=1e-9)


def test_keys_that_follow_a_variable_keep_to_it(tmp_path: Path) -> None:
    variables = []
    for which, most in ((WEIGHT, "0.2 kg*m"), (SHAFT, "0.02 kg*m")):
        follows = f', followed_by = [{{ key = "{which}[1].unbalance" }}]'
        opposite = f', followed_by = [{{ key = "{which}[1].phase", offset = "180 deg" }}]'
        variables.append(_variable(f"{which}[0].unbalance", "0 kg*m", most, follows))
        variables.append(_variable(f"{which}[0].phase", "0 deg", "360 deg", opposite))
    loaded = load_checked([_file(tmp_path, variables)])[0]
    result = execute(loaded)
    record = result.record
    start = float(record["optimisation/start/excitation/residual"].values)
    assert _value(record, "objective") <= 1e-13 * start
    assert _degrees(record, SHAFT, 0) == pytest.approx(150.0, abs=1e-9)
    words = " ".join(render_report(result).split())
    assert f"{SHAFT}[1].phase follows {SHAFT}[0].phase + 180 deg" in words


def test_an_optimum_at_the_ends_of_a_turn_is_on_no_bound() -> None:
    found = minimise(
        Problem(
            lambda x: (2.0 - math.cos(x[0]), []), [0.0], [math.tau], first=[5.0], period=math.tau
        ),
        starts=6,
    )
    assert abs(math.remainder(found.variables[0], 2.0 * math.pi)) <= 1e-7
    assert found.active_bounds[0] == 0
    assert len(found.optima) == 1
    assert found.optima[0].found_by == 7
    # between other ends it is the one at a bound
    half = minimise(
        Problem(lambda x: (2.0 - math.cos(x[0]), []), [0.5], [3.0], period=math.tau), starts=2
    )
    assert half.active_bounds[0] == -1


@pytest.mark.parametrize(
    ("variable", "words"),
    [
        (TURNED.format(f'{{ key = "{SHAFT}[1].unbalance" }}'), "they have other units"),
        (TURNED.format(f'{{ key = "{WEIGHT}[0].phase" }}'), "two variables change"),
        (
            TURNED.format(f'{{ key = "{WEIGHT}[1].phase", offset = "1 m" }}'),
            "no offset in the unit of the key",
        ),
        (
            TURNED.format(f'{{ key = "{WEIGHT}[1].phase" }}'),
            "as written is not what it is to follow",
        ),
        (TURNED.format('{ key = "machine.kind" }'), "the optimiser cannot change this key"),
        (
            f'{{ key = "{WEIGHT}[0].unbalance", min = "0 kg*m", max = "0.2 kg*m",'
            f' followed_by = [{{ key = "{WEIGHT}[1].unbalance", factor = -1 }}] }}',
            "would take a value outside its range",
        ),
        (
            _variable(f"{WEIGHT}[0].unbalance", "30 g*m", "0.2 kg*m"),
            "starts outside the bounds of machine.crank_train.* found 0.02 kg.m; allowed: 30 g.m",
        ),
    ],
    ids=["unit", "twice", "offset", "not followed", "no number", "negative", "outside"],
)
def test_variables_that_cannot_hold_are_refused(variable: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_checked([_file(tmp_path, [variable])])
    assert re.search(words, " ".join(str(caught.value).split()))
