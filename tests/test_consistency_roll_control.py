"""Claim: speed, amplitudes and levels of the controlled machine are those of its equations: in
forty digits, and marched in time with lag and delay; tuned gains are the best allowed.
"""

from functools import cache

import numpy as np
import pytest
from mpmath import mp, mpc, mpf
from roll_control_loops import MOTOR_GAIN, SOURCE, TARGET, random_loops, source_load

from vibecalc.errors import NumericalFailure
from vibecalc.roll.control.gains import (
    BOUNDS,
    Demands,
    LoopLoad,
    certify,
    evaluate,
    evaluate_at_speed,
    objective_of,
    slacks,
    tune,
)
from vibecalc.roll.control.loop import Controller, loop_of, speed_feedback_for, steady_speed
from vibecalc.roll.control.poles import poles, root_locus


@pytest.mark.parametrize("late", [False, True])
def test_errors_of_speed_and_amplitudes_hold_against_forty_digits(late):
    mp.dps = 40
    count = 40
    model, controller = random_loops(11, count, late)
    draw = np.random.default_rng(12)
    torque = draw.normal(size=(count, 3)) + 1j * draw.normal(size=(count, 3))
    load = LoopLoad(94.25, draw.uniform(-400, 0, count), 100.0 * torque)
    found = evaluate(model, controller, load)
    assert 10 < np.sum(found.margins.stable) < count
    for place in np.flatnonzero(found.margins.stable):
        i, ratio, motor, viscous = (mpf(float(a[place])) for a in model)
        k, speed, shell, lag, delay = (mpf(float(a[place])) for a in controller)
        mean = mpf(float(load.mean[place]))
        w = (mean + k * motor * mpf(94.25)) / (motor + viscous + k * motor * speed)
        assert abs(float(w) - found.speed.value[place]) <= found.speed.error[place]
        assert found.speed.error[place] <= 1e-11 * abs(float(w))
        for n in (1, 2, 3):
            s = mpc(0, n * w)
            delivered = k * mp.exp(-s * delay) / (1 + lag * s)
            back = speed - shell * ratio * s
            d = mpc(complex(load.harmonics[place, n - 1]))
            rotor = d / (i * s + motor + viscous + motor * delivered * back)
            command = -delivered * back * rotor
            truth = (-ratio * s * rotor, s * rotor, rotor, motor * (command - rotor), command)
            for exact, part in zip(truth, found.harmonics, strict=True):
                miss = abs(complex(exact) - part.value[place, n - 1])
                assert miss <= part.error[place, n - 1] <= 1e-8 * abs(complex(exact))
            level = float(20 * mp.log10(abs(truth[0])))
            miss = abs(level - found.level.value[place, n - 1])
            assert miss <= found.level.error[place, n - 1] <= 1e-7


def marched(controller, load, turns, parts):
    """Rotor speed of the source's machine by Runge-Kutta steps that divide the delay."""
    i, ratio = float(SOURCE.inertia), float(SOURCE.ratio)
    k, k_r, k_s, lag, delay = (float(a) for a in controller)
    speed = float(steady_speed(SOURCE, controller, load.reference, load.mean).value)
    step = delay / parts if delay else 2.0 * np.pi / speed / 4000.0
    count = int(turns * 2.0 * np.pi / speed / step)
    demand = np.zeros(count + parts + 2)
    state = np.array([0.3, 0.0])
    history = np.empty(count)

    def rate(t, x, asked):
        w, u = x
        torque = sum(
            (d * np.exp(1j * (n + 1) * speed * t)).real for n, d in enumerate(load.harmonics)
        )
        moved = (MOTOR_GAIN * (u - w) + torque) / i
        return np.array([moved, (asked - u) / lag]), moved

    for row in range(count):
        t = row * step
        history[row] = state[0]
        _, moved = rate(t, state, 0.0)
        demand[row + parts] = -k * (k_r * state[0] - k_s * ratio * moved)
        # what the actuator is asked for during this step, a delay ago
        ends = (demand[row], 0.5 * (demand[row] + demand[row + 1]), demand[row + 1])
        a, _ = rate(t, state, ends[0])
        b, _ = rate(t + step / 2, state + step / 2 * a, ends[1])
        c, _ = rate(t + step / 2, state + step / 2 * b, ends[1])
        d, _ = rate(t + step, state + step * c, ends[2])
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
    return np.arange(count) * step, history, speed


def test_the_machine_marched_in_time_settles_to_the_amplitudes():
    load = source_load()
    kept = speed_feedback_for(SOURCE, 5.0, load.reference, load.mean, TARGET).value
    controller = Controller(5.0, float(kept), -0.02, 2e-3, 4e-4)
    found = evaluate(SOURCE, controller, load)
    assert found.margins.status == 0
    time, history, speed = marched(controller, load, 9, 8)
    late = time > 5 * 2 * np.pi / speed
    basis = np.stack([
        f(n * speed * time[late]) for n in (1, 2) for f in (np.cos, np.sin)
    ] + [np.ones(np.sum(late))], axis=-1)  # fmt: skip
    part = np.linalg.lstsq(basis, history[late], rcond=None)[0]
    seen = np.array([part[0] - 1j * part[1], part[2] - 1j * part[3]])
    np.testing.assert_allclose(seen, found.harmonics.rotor_speed.value, rtol=3e-5)
    assert np.max(np.abs(basis @ part - history[late])) < 1e-4 * np.max(np.abs(seen))


@pytest.mark.parametrize("delay", [pytest.param(0.0, marks=pytest.mark.long), 3e-4])
def test_a_locus_follows_its_poles(delay):
    gains = np.geomspace(0.5, 60.0, 120)
    controller = Controller(1.0, 0.9, -0.02, 2e-3, delay)
    found = root_locus(SOURCE, controller, gains, source_load(), TARGET, count=4)
    for row in (0, 37, 119):
        at = Controller(gains[row], 0.0, -0.02, 2e-3, delay)
        kept = evaluate_at_speed(SOURCE, at, source_load(), TARGET).speed_feedback.value
        same = poles(loop_of(SOURCE, at._replace(speed_feedback=kept)), 4)
        np.testing.assert_allclose(
            np.sort_complex(found.pole[row]), np.sort_complex(same.value), rtol=1e-10
        )
    # columns are joined to the nearest, so the dominant one moves in small steps
    step = np.abs(np.diff(found.pole[:, 0]))
    assert np.max(step) < 0.15 * np.max(np.abs(found.pole[:, 0]))
    assert np.all(found.pole_error < 1e-6 * (1.0 + np.abs(found.pole)))


# ----------------------------------------------------------------------------
# Tuned gains are the best allowed.
# ----------------------------------------------------------------------------


LOAD = source_load()
WIDE = Demands((0.5, 100.0), (-10.0, 10.0), 6.0, np.radians(45.0), 5e-4)


def brute(controller, demands, orders, rows=160, columns=161):
    """Best level of a grid over all gains allowed, finer in feedback near zero."""
    gain = np.geomspace(*demands.gain, rows)[:, None]
    low, high = np.arcsinh(np.array(demands.acceleration_feedback) / 1e-3)
    feedback = 1e-3 * np.sinh(np.linspace(low, high, columns))
    tried = controller._replace(gain=gain, acceleration_feedback=feedback)
    found = evaluate_at_speed(SOURCE, tried, LOAD, TARGET)
    allowed = np.all(slacks(found, demands) >= 0.0, axis=-1) & found.margins.stable
    assert 0 < np.sum(allowed) < allowed.size
    return np.min(np.where(allowed, objective_of(found, orders), np.inf))


@cache
def tuned_with_lag():
    """What several tests look at."""
    return tune(SOURCE, Controller(1.0, 0.0, 0.0, 1e-3, 0.0), LOAD, TARGET, WIDE)


CASES = {
    "no lag": (0.0, 0.0, WIDE, (1, 2), {"delay margin"}),
    "lag": (1e-3, 0.0, WIDE, (1, 2), {"delay margin"}),
    "lag, few gains": (
        1e-3, 0.0, WIDE._replace(gain=(0.5, 15.0)), (1, 2),
        {"delay margin", "largest gain"},
    ),
    "delay": (0.0, 2e-4, WIDE, (1, 2), {"delay margin"}),
    "delay and gain": (
        0.0, 2e-4, WIDE._replace(gain=(0.5, 15.0)), (1, 2),
        {"gain margin", "largest gain"},
    ),
    "lag and delay": (1e-3, 2e-4, WIDE, (1,), None),
    "phase": (
        2e-3, 1e-4, WIDE._replace(phase_margin=np.radians(75.0), delay_margin=0.0), (1, 2),
        None,
    ),
}  # fmt: skip


#: these see nothing of the search that the others do not
_LONG = {"delay and gain", "lag and delay"}


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.long) if n in _LONG else n for n in CASES]
)
def test_no_grid_beats_tuned_gains(name):
    lag, delay, demands, orders, binding = CASES[name]
    controller = Controller(1.0, 0.0, 0.0, lag, delay)
    found = tune(SOURCE, controller, LOAD, TARGET, demands, orders)
    assert found.controlled.margins.stable
    assert np.all(slacks(found.controlled, demands) >= 0.0)
    assert demands.gain[0] <= found.gain.value <= demands.gain[1]
    assert found.controlled.speed.value == pytest.approx(TARGET, rel=1e-14)

    beaten = brute(controller, demands, orders, *((110, 121) if not delay else (36, 41)))
    assert found.objective.value <= beaten
    assert found.objective.value > beaten - 1.0  # the grid is near, so no other hill is missed
    proof = certify(SOURCE, controller, LOAD, TARGET, demands, found, orders)
    assert proof.residual < 1e-4
    assert np.any(proof.active)
    if binding is not None:
        assert {BOUNDS[i] for i in np.flatnonzero(proof.active)} == binding


@pytest.mark.long
def test_a_looser_demand_gains_what_the_multiplier_says():
    controller = Controller(1.0, 0.0, 0.0, 1e-3, 0.0)
    found = tuned_with_lag()
    proof = certify(SOURCE, controller, LOAD, TARGET, WIDE, found)
    looser = WIDE._replace(delay_margin=WIDE.delay_margin * (1.0 - 1e-4))
    better = tune(SOURCE, controller, LOAD, TARGET, looser)
    gained = float(found.objective.value - better.objective.value)
    expected = float(proof.multiplier[BOUNDS.index("delay margin")]) * 1e-4
    assert gained == pytest.approx(expected, rel=2e-3)
    assert all(one.error <= 1e-4 * abs(one.value) for one in found[:3])


@pytest.mark.long
def test_a_demand_that_no_gain_meets_is_refused_in_words():
    controller = Controller(1.0, 0.0, 0.0, 5e-3, 0.0)
    with pytest.raises(NumericalFailure, match="meets the margins asked for"):
        tune(SOURCE, controller, LOAD, TARGET, WIDE._replace(gain=(40.0, 90.0), delay_margin=0.1))


@pytest.mark.long
def test_the_gain_of_the_source_is_refused_for_any_delay_margin():
    """K near 10 and k_S near -10: 39 dB on paper, no delay allowed."""
    near = Demands((9.9, 10.1), (-10.1, -9.9), delay_margin=1e-9)
    with pytest.raises(NumericalFailure, match="margins"):
        tune(SOURCE, Controller(1.0, 0.0, 0.0), LOAD, TARGET, near)
    # asked for nothing but stability it is taken, and the status says on what terms
    found = tune(SOURCE, Controller(1.0, 0.0, 0.0), LOAD, TARGET, near._replace(delay_margin=0.0))
    assert found.controlled.margins.status == 1
