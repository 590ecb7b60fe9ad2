"""Claim: changes in time that a case asks for are what they say, from the case to the report."""

import re
import tomllib

import numpy as np
import pytest
from engine_cases import GENSET, ran

from vibecalc.core.case.load import validate
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case
from vibecalc.torsion.adapters.setup import build_setup

ROOT = "response/torsion/transient/"
EQUIVALENT = ("equivalent/frequency", "equivalent/damping")
NAMES = ["a - b", "b - c", "rear", "coupling", "ring"]


def asked(change: str, text: str = GENSET) -> Case:
    case = validate(tomllib.loads(f"{text}transient = {{ {change} }}\n"))
    assert check_machine(case) == []
    return case


def run(change: str, text: str = GENSET, wanted: tuple[str, ...] = ("peak",)) -> Record:
    return run_case(asked(change, text), wanted=frozenset(ROOT + one for one in wanted))


def value(record: Record, name: str) -> np.ndarray:
    return np.asarray(record[ROOT + name].values)


def test_without_damping_the_steady_vibration_has_no_bound() -> None:
    text = GENSET.replace("loss_factor = 0.1, ", "").replace(', damping = "5 N*m*s/rad"', "")
    text = re.sub(r"dampers = .*\n", "", text)
    change = 'kind = "run_up", from = "1000 rpm", to = "1150 rpm", duration = "1 s"'
    change += ', time_after = "0.1 s"'
    names = ("peak_half_range", "steady_half_range", "overshoot")
    record = run(change, text, names)
    assert np.all(np.isinf(value(record, "steady_half_range")))
    assert np.all(value(record, "overshoot") == -1.0)
    assert any("an undamped critical speed is passed" in one for one in record.warnings)


def test_after_a_jolt_the_mode_of_the_coupling_counts() -> None:
    change = 'kind = "load_step", on = "generator", torque = "300 N*m", time_after = "0.2 s"'
    record = run(change, wanted=EQUIVALENT)
    natural = build_setup(validate(tomllib.loads(GENSET))).modes.frequency
    gap = np.abs(natural - value(record, "equivalent/frequency")[0])
    assert gap.min() < 1e-9 * natural.max()
    assert natural[np.argmin(gap)] == np.min(natural[natural > 1.0])
    told = [one for one in record.warnings if "loss factor" in one]
    assert len(told) == 1 and "'coupling' at 26.96 Hz (natural frequency)" in told[0]


@pytest.mark.long
def test_a_stop_is_a_run_down_without_fuel() -> None:
    names = ("peak_half_range", "steady_half_range", "peak_half_range_speed")
    stop = run('kind = "stop", from = "1000 rpm", duration = "1.5 s"', wanted=names)
    motored = GENSET + 'misfire = ["1", "2", "3"]\nmisfire_kind = "motored"\n'
    down = 'kind = "run_down", from = "1000 rpm", to = "40 rpm", duration = "1.5 s"'
    down += ', time_after = "0.1 s"'
    slowed = run(down, motored, names)
    first = slice(0, 3)  # whose largest are at the begin
    for name in names[1:2]:
        np.testing.assert_allclose(value(stop, name)[first], value(slowed, name)[first], rtol=1e-6)
    np.testing.assert_allclose(
        value(stop, names[0])[first], value(slowed, names[0])[first], rtol=0.02
    )
    with_fuel = run(down)
    assert np.all(value(with_fuel, "peak")[first] > 1.01 * value(stop, names[0])[first])


def test_a_clutch_from_case_to_report() -> None:
    change = (
        'kind = "clutch_in", clutch = "coupling", driven_speed = "100 rpm", '
        'friction_torque = "6 kN*m", engaging_time = "0.2 s", time_after = "0.6 s", '
        'counting = { sections = ["coupling"], changes = 1000 }'
    )
    result = ran(f"{GENSET}transient = {{ {change} }}\n")
    case, record = asked(change), result.record
    line = build_setup(case).shaft.line
    inertia = np.array([line.inertia.sum() - 1.0, 1.0])
    speeds = np.array([50.0, 100.0 / 30.0]) * np.pi
    common = float(inertia @ speeds / inertia.sum())
    assert value(record, "clutch/common_speed") == pytest.approx(common, rel=1e-12)
    gap = speeds[0] - speeds[1]
    rigid = 0.5 * inertia.prod() / inertia.sum() * gap**2
    # the vibration of both parts changes the heat a little
    assert value(record, "clutch/heat") == pytest.approx(rigid, rel=0.03)
    damage, all_of_it = value(record, "counted/damage"), value(record, "counted/damage_of_all")
    assert all_of_it == pytest.approx(1000.0 * damage, rel=1e-14)
    text = render_report(result, full=True)
    for words in ("Clutch coupling engages", "The clutch slips for", "Rainflow cycles"):
        assert words in text
