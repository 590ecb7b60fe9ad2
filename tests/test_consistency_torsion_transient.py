"""Claim: a shaft line through a transient moves as closed forms and another integrator say."""

import tomllib
from pathlib import Path

import mpmath
import numpy as np
import pytest
import tomli_w
from engine_cases import GENSET
from scipy.special import fresnel

from vibecalc.core.case.load import validate
from vibecalc.core.report.pages import conclusion
from vibecalc.core.report.text import as_json, render_verdicts
from vibecalc.core.results.record import BROKEN
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.torsion.line import Line, chain, dynamic_stiffness
from vibecalc.torsion.report import first_page
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import course_of, stretch, time_of_speed
from vibecalc.torsion.transient.trace import extremes, section_peaks, traces


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


def test_slow_undamped_passage_is_the_fresnel_integral() -> None:
    # from far below the critical: amplitude F / (2 w_n) sqrt(pi / a) |int e^{i pi x^2 / 2} dx|,
    # whose first maximum lies at x = 1.2172, after the critical (Lewis 1932)
    line, natural = pair(), np.sqrt(4000.0 / REDUCED)
    rate = 2.0
    gas = np.array([[100.0 + 0j], [0.0]])
    run = transient(line, np.array([1.0]), [stretch(57.0, rate, gas)], 0.0)
    peak = section_peaks(run, traces(run))
    x = np.linspace(0.5, 2.0, 4001)
    sine, cosine = fresnel(x)
    size = np.hypot(sine + 0.5, cosine + 0.5)
    force = 100.0 / 2.0 * 4000.0
    expected = force / (2.0 * natural) * np.sqrt(np.pi / rate) * size.max()
    assert peak.peak[0] == pytest.approx(expected, rel=0.01)
    assert x[size.argmax()] == pytest.approx(1.2172, abs=1e-3)
    # the vibration follows its envelope to a period
    expected_speed = natural + x[size.argmax()] * np.sqrt(np.pi * rate)
    at_peak = run.course.at(peak.time)[0, 0]
    assert at_peak == pytest.approx(expected_speed, abs=rate * 2 * np.pi / natural)


def test_a_steady_start_at_constant_speed_stays_on_the_forced_response() -> None:
    line = chain(np.array([1.0, 2.0, 4.0]), np.array([3000.0, 2000.0]))._replace(
        absolute_damping=np.array([0.0, 1.5, 0.0])
    )
    order, speed, angle = np.array([0.5, 3.0, 4.0]), 17.0, 1.1
    gas = np.array([[5.0, 3.0j, 2.0], [1.0, 1.0, -4.0j], [0.0, 0.0, 0.0]])
    inertia = 0.01j * gas
    run = transient(line, order, [stretch(5.0, 0.0, gas, inertia)], speed, angle, start="steady")
    total = gas + speed**2 * inertia
    matrix = dynamic_stiffness(line, order * speed)
    phi = np.linalg.solve(matrix, total.T[..., None])[..., 0]
    section = (phi[:, :-1] - phi[:, 1:]) * line.stiffness
    times = step_times(run)
    phase = np.exp(1j * order * (angle + speed * times[:, None]))
    expected = (phase @ section).real
    error = np.abs(torques(run) - expected).max(axis=0)
    # 1e-13: the two ways to the amplitudes at the start
    assert np.all(error <= run.torque_error + 1e-13 * np.abs(expected).max())
    # from rest the same vibration is reached: the slowest pole is that of the damped rigid mode
    rest = transient(line, order, [stretch(90.0, 0.0, gas, inertia)], speed, angle)
    size = np.abs(expected).max(axis=0)
    late = np.abs(rest.states[-1] @ run.system.torque.T)[-2000:].max(axis=0)
    np.testing.assert_allclose(late, size, rtol=0.01)


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
