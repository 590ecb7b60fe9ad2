"""Claim: a shaft line through a transient moves as closed forms and another integrator say; changes
in time that a case asks for are what they say, from the case to the report.
"""

import re
import tomllib
from pathlib import Path

import mpmath
import numpy as np
import pytest
import tomli_w
from engine_cases import GEARED, GENSET, ran, replaced

from vibecalc.core.case.load import validate
from vibecalc.core.report.pages import conclusion
from vibecalc.core.report.text import as_json, render_report, render_verdicts
from vibecalc.core.results.record import BROKEN, Record
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.schema import Case
from vibecalc.torsion.adapters import transient_motion
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.adapters.variable_inertia import gas_torque, system_of
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.report import first_page
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import course_of, stretch, time_of_speed
from vibecalc.torsion.transient.trace import extremes, traces


def pair(damping: float = 0.0, stiffness: float = 4000.0) -> Line:
    line = chain(np.array([2.0, 3.0]), np.array([stiffness]))
    return line._replace(damping=np.array([damping]))


REDUCED = 2.0 * 3.0 / 5.0


def step_times(run: TransientRun) -> np.ndarray:
    """Times at the ends of all steps, with the start of each block again."""
    return np.concatenate(
        [
            run.course.time[p.stretch] + p.offset + p.step * np.arange(p.steps + 1)
            for p in run.blocks
        ]
    )


def torques(run: TransientRun) -> np.ndarray:
    return np.concatenate([x @ run.system.torque.T for x in run.states])


def chirp_twist(
    t: float, line: Line, torque: complex, order: float, speed: float, acceleration: float
) -> float:
    """Twist of two free inertias from rest under Re(torque e^{i q theta}) on the first.

    One pole s: int_0^t e^{s (t - u)} e^{i q (w u + a u^2 / 2)} du, an error function of complex
    argument after completing the square.
    """
    mp = mpmath.mp
    k, c = mp.mpf(line.stiffness[0]), mp.mpf(line.damping[0])
    half, square = c / mp.mpf(REDUCED) / 2, k / mp.mpf(REDUCED)
    split = mp.sqrt(square - half**2)
    total = mp.mpc(0)
    for sign in (1, -1):
        pole = -half + 1j * sign * split
        slope = 1j * mp.mpf(order) * mp.mpf(speed) - pole
        root = mp.sqrt(-1j * mp.mpf(order) * mp.mpf(acceleration) / 2)
        shift = slope / (2 * root)
        part = (mp.erf(root * t - shift) - mp.erf(-shift)) * mp.exp(shift**2 + pole * t)
        total += sign * part * mp.sqrt(mp.pi) / (2 * root) / (2j * split)
    return float(mp.re(total * mp.mpmathify(torque) / 2))


@pytest.mark.parametrize(
    ("damping", "speed", "acceleration"),
    [(4.0, 1.0, 7.0), pytest.param(0.0, 90.0, -8.0, marks=pytest.mark.long)],
)
def test_chirp_through_a_critical_is_the_error_function(
    damping: float, speed: float, acceleration: float
) -> None:
    line, torque = pair(damping), 30.0 - 12.0j
    gas = np.array([[torque], [0.0]])
    run = transient(line, np.array([1.5]), [stretch(10.0, acceleration, gas)], speed)
    times, values = step_times(run), torques(run)
    with mpmath.workdps(60):
        for k in np.linspace(5, times.size - 1, 9).astype(int):
            t = times[k]
            near = [chirp_twist(t + d, line, torque, 1.5, speed, acceleration) for d in (0.0, 1e-9)]
            exact = line.stiffness[0] * near[0] + damping * (near[1] - near[0]) / 1e-9
            slack = 1e-6 * damping  # of the difference quotient, which has a damper only
            assert abs(values[k, 0] - exact) <= run.torque_error[0] + slack
    assert run.torque_error[0] < 1e-8 * np.abs(values).max()


def test_load_step_on_undamped_line_doubles_the_static_torque_for_ever() -> None:
    none = np.zeros((2, 1), dtype=complex)
    part = stretch(40.0, 0.0, none, load=np.array([0.0, -70.0]))
    run = transient(pair(), np.array([1.0]), [part], 50.0, reaction=np.array([1.0, 0.0]))
    exact = 70.0 * (1.0 - np.cos(np.sqrt(4000.0 / REDUCED) * step_times(run)))
    assert np.abs(torques(run)[:, 0] - exact).max() <= run.torque_error[0] < 1e-8
    border = np.linspace(0.0, 40.0, 51)
    low, high, error = extremes(traces(run, border)[0], border[:-1], border[1:])
    assert np.all(np.abs(high - 140.0) <= error) and np.all(np.abs(low) <= error)
    # all peaks are alike, so each window uncertainties whether another one is higher
    assert error.max() < 1e-4 * 140.0


def test_critically_damped_pair_with_a_double_pole() -> None:
    natural = np.sqrt(4000.0 / REDUCED)
    line = pair(2.0 * REDUCED * natural)
    none = np.zeros((2, 1), dtype=complex)
    part = stretch(0.5, 0.0, none, load=np.array([0.0, -70.0]))
    run = transient(line, np.array([1.0]), [part], 0.0, reaction=np.array([1.0, 0.0]))
    x = natural * step_times(run)
    # spring and dashpot: 70 (1 - (1 + x) e^-x) and 70 (2 x e^-x)
    exact = 70.0 * (1.0 + (x - 1.0) * np.exp(-x))
    assert np.abs(torques(run)[:, 0] - exact).max() <= run.torque_error[0] < 1e-9


def test_a_run_down_that_fades_out_ends_at_rest() -> None:
    gas, speed, duration = np.zeros((1, 1)), 50.0 * np.pi, 3.0
    top = -speed / (0.9 * duration)
    ends, middle = 0.1 * duration, 0.8 * duration
    parts = [
        stretch(ends, 0.0, gas, acceleration_rate=top / ends),
        stretch(middle, top, gas),
        stretch(ends, top, gas, acceleration_rate=-top / ends),
    ]
    course = course_of(parts, speed)
    assert course.speed[-1] == 0.0
    assert float(course.angle[-1]) == pytest.approx(0.5 * speed * duration, rel=1e-14)
    time = np.linspace(0.0, duration, 3001)
    speeds, angles, _ = course.at(time)
    np.testing.assert_allclose(np.gradient(angles, time, edge_order=2), speeds, atol=1e-4)
    back = time_of_speed(parts[2], float(course.speed[2]), 1.0)
    assert course.at(np.array(ends + middle + back))[0] == pytest.approx(1.0)


def test_the_method_of_the_steady_response_is_none_of_the_motion_in_time() -> None:
    text = GENSET.replace("loss_factor = 0.1, ", "")
    text += 'damping_model = { kind = "rayleigh", modes = [3, 4], ratios = [0.02] }\n'
    text += (
        'transient = { kind = "load_step", on = "generator", torque = "100 N*m", '
        "time_after = 0.01 }\n"
    )
    methods = ('method = "modal"\n', "")
    by_modes, other = (run_case(validate(tomllib.loads(text + one))) for one in methods)
    for name in ("peak", "peak_time", "history/torque"):
        path = f"response/torsion/transient/{name}"
        assert by_modes[path].values == pytest.approx(other[path].values, rel=1e-9)


def test_teeth_that_part_in_a_short_circuit_are_said(tmp_path: Path) -> None:
    """A geared generator: three rotors on the shaft of the turbine, marched by Runge and Kutta."""
    from scipy.integrate import solve_ivp

    case = {
        "schema": 1, "title": "geared short circuit",
        "machine": {
            "kind": "drive_train", "speed": "1500 rpm",
            "shaft_line": {
                "speed_of": "generator", "balanced_by": "turbine",
                "stations": [
                    {"name": name, "inertia": inertia} for name, inertia in
                    (("turbine", 1.4), ("pinion", 0.35), ("wheel", 22.0), ("generator", 95.0))
                ],
                "shafts": [
                    {"name": "quill", "between": ["turbine", "pinion"], "stiffness": 95e3,
                     "damping": 4.0, "diameter": 0.055},
                    {"name": "coupling", "between": ["wheel", "generator"], "stiffness": 3.6e6,
                     "damping": 900.0, "diameter": 0.14},
                ],
                "gears": [{"name": "gear", "between": ["pinion", "wheel"], "ratio": 0.15,
                           "reverses": True}],
                "absorbed_torques": [{"on": "generator", "torque": 9e3, "exponent": 0}],
                "excitations": [{"name": "none", "on": "generator", "orders": [1],
                                 "torques": [0.0]}],
            },
        },
        "response": {"torsion": {"transient": {
            "kind": "short_circuit", "on": "generator", "time_after": 0.3,
            "terms": [{"amplitude": 62e3, "frequency": "50 Hz", "time_constant": 0.12},
                      {"amplitude": -31e3, "frequency": "100 Hz", "time_constant": 0.12}],
        }}},
    }  # fmt: skip
    file = tmp_path / "turbine.toml"
    file.write_text(tomli_w.dumps(case), encoding="utf-8")
    result = execute(load_checked([file])[0])
    record, ratio, decay = result.record, 0.15, 0.12
    mass = np.array([1.4, 0.35 + 22.0 * ratio**2, 95.0])
    rows = np.array([[1.0, -1.0, 0.0], [0.0, ratio, -1.0]])
    stiff, damped = np.array([95e3, 3.6e6]), np.array([4.0, 900.0])

    def torques(state: np.ndarray) -> np.ndarray:
        return stiff * (rows @ state[:3]) + damped * (rows @ state[3:])

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        gap = 62e3 * np.sin(100.0 * np.pi * time) - 31e3 * np.sin(200.0 * np.pi * time)
        load = np.array([0.0, 0.0, -gap * np.exp(-time / decay)])
        return np.concatenate([state[3:], (load - rows.T @ torques(state)) / mass])

    found = solve_ivp(rates, (0.0, 0.3), np.zeros(6), rtol=1e-10, atol=1e-13, max_step=2e-4,
                      t_eval=np.linspace(0.0, 0.3, 30001))  # fmt: skip
    shafts = np.array([torques(one) for one in found.y.T])
    # what the turbine sends through the quill speeds up the pinion, the rest is that of the teeth
    faster = (shafts[:, 0] - ratio * shafts[:, 1]) / mass[1]
    teeth = 9e3 * ratio + shafts[:, 0] - 0.35 * faster
    path = "response/torsion/transient/gear_minimum_torque"
    assert teeth.min() < -1e3
    stated = float(record[path].error_estimate)
    assert abs(float(record[path].values[0]) - teeth.min()) < stated < 5e-4 * abs(teeth.min())
    (said,) = [one for one in record.warnings if "the torque of its teeth reverses" in one]
    assert f"down to {teeth.min():.4g} N*m" in said
    (row,) = [one for one in verdicts_of(result) if one.condition]
    assert (row.element, row.condition, row.state) == ("gear", "transient", BROKEN)
    assert row.computed == pytest.approx(1e-3 * teeth.min(), rel=5e-4) and np.isnan(row.utilisation)
    assert "gear hammer in 'gear' in the transient" in first_page.conclusion(result)
    words = "no torque reversal, transient"
    assert words in render_verdicts(result) and words in conclusion([], [row])
    assert "transient" in first_page.conclusion_table(result)[-2]
    told = [(one["element"], one["condition"], one["verdict"]) for one in as_json(result)["limits"]]
    assert ("gear", "transient", BROKEN) in told


# ----------------------------------------------------------------------------
# As a case asks for it.
# ----------------------------------------------------------------------------

TRANSIENT = "response/torsion/transient/"
EQUIVALENT = ("equivalent/frequency", "equivalent/damping")


def asked(change: str, text: str = GENSET) -> Case:
    case = validate(tomllib.loads(f"{text}transient = {{ {change} }}\n"))
    assert check_machine(case) == []
    return case


def run(change: str, text: str = GENSET, wanted: tuple[str, ...] = ("peak",)) -> Record:
    return run_case(asked(change, text), wanted=frozenset(TRANSIENT + one for one in wanted))


def value(record: Record, name: str) -> np.ndarray:
    return np.asarray(record[TRANSIENT + name].values)


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


def test_cylinders_of_stations_that_a_rigid_gear_joins_all_act() -> None:
    joined = replaced(
        GEARED,
        ('  { between = ["a", "b"], stiffness = "1e6 N*m/rad" },\n', ""),
        ("gears = [\n", 'gears = [\n  { between = ["a", "b"], ratio = 1.0, reverses = false },\n'),
    )
    setup = build_setup(validate(tomllib.loads(joined)))
    speed, drive = setup.speed, setup.drive
    assert len(set(drive.freedom.tolist())) < len(drive.freedom)
    gas, inertia = transient_motion.torques(setup, speed)
    both = (gas + speed**2 * inertia).sum(axis=0)[1:]
    load = drive.load(np.array([speed]))[0].sum(axis=-1)
    np.testing.assert_allclose(both, load, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(
        gas_torque(setup, speed)[1:].sum(axis=1), gas.sum(axis=0)[1:], atol=1e-9
    )
    # the inertia of both throws varies, by twice as much as that of one
    apart = build_setup(validate(tomllib.loads(GEARED)))
    whole, alone = (
        system_of(one, speed).variation[one.shaft.cylinder_freedom[0], 1] for one in (setup, apart)
    )
    assert whole == pytest.approx(2.0 * alone, rel=1e-9)
    # a solve adds them as well
    line, load = setup.model.line, np.array([[1.0, 2.0]], dtype=complex)
    place = int(drive.freedom[0])
    both, one = (
        forced_masked(line, np.array([50.0]), torque, stations=stations).angle
        for torque, stations in ((load, [place, place]), (load.sum(axis=1)[:, None], [place]))
    )
    np.testing.assert_array_equal(both, one)
