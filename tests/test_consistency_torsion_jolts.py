"""Claim: torques in time move a shaft line as closed forms say."""

import numpy as np
import pytest

from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import Stretch, TorqueInTime, stretch
from vibecalc.torsion.transient.trace import section_peaks, traces

NONE = np.zeros(0, dtype=complex)
QUIET = np.zeros((2, 1), dtype=complex)
ORDER = np.array([1.0])
J1, J2, K = 2.0, 3.0, 4000.0
REDUCED = J1 * J2 / (J1 + J2)


def pair(damping: float = 0.0) -> Line:
    return chain(np.array([J1, J2]), np.array([K]))._replace(damping=np.array([damping]))


def step_ends(run: TransientRun) -> tuple[np.ndarray, np.ndarray]:
    """Times (k,) and section torques (k, e) at the ends of all steps."""
    times, torques = [], []
    for block, states in zip(run.blocks, run.states, strict=True):
        since = float(run.course.time[block.stretch]) + block.offset
        times.append(since + block.step * np.arange(block.steps + 1))
        torques.append(states @ run.system.torque.T)
    return np.concatenate(times), np.concatenate(torques)


def acting(part: Stretch, torque: TorqueInTime) -> Stretch:
    return part._replace(in_time=torque)


def test_a_constant_torque_at_once_has_the_peak_factor_two() -> None:
    torque = TorqueInTime(np.array([0.0, -1.0]), NONE, NONE, 70.0)
    run = transient(pair(), ORDER, [acting(stretch(2.0, 0.0, QUIET), torque)], 50.0)
    time, found = step_ends(run)
    # the load is on the far end: J1 / (J1 + J2) of it goes through the shaft
    still = 70.0 * J1 / (J1 + J2)
    exact = still * (1.0 - np.cos(np.sqrt(K / REDUCED) * time))
    assert np.abs(found[:, 0] - exact).max() <= run.torque_error[0] < 1e-8
    peak = section_peaks(run, traces(run))
    assert abs(peak.peak[0] - 2.0 * still) <= peak.error[0]
    assert peak.peak[0] == pytest.approx(2.0 * still, rel=1e-6)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_decaying_sines_on_an_oscillator(damping: float) -> None:
    amplitude = np.array([900.0 * -1j, -450.0 * np.exp(0.3j)])
    rate = np.array([-8.0 + 314.0j, -5.0 + 628.0j])
    torque = TorqueInTime(np.array([0.0, -1.0]), amplitude, rate)
    run = transient(pair(damping), ORDER, [acting(stretch(0.6, 0.0, QUIET), torque)], 50.0)
    time, found = step_ends(run)
    # twist'' + c / m twist' + k / m twist = T / J2, from rest; T = Re sum A e^(s t)
    forced = amplitude / J2 / (rate**2 + damping / REDUCED * rate + K / REDUCED)
    poles = np.roots([1.0, damping / REDUCED, K / REDUCED])
    twist, speed = np.zeros(time.size), np.zeros(time.size)
    for part, s in zip(forced, rate, strict=True):
        for value, pole in ((part, s), (np.conj(part), np.conj(s))):
            # the free motion that takes back twist and speed of the forced one at the begin
            free = np.linalg.solve(np.array([[1.0, 1.0], poles]), -value * np.array([1.0, pole]))
            waves = value * np.exp(pole * time), free[:, None] * np.exp(poles[:, None] * time)
            twist += 0.5 * (waves[0] + waves[1].sum(axis=0)).real
            speed += 0.5 * (pole * waves[0] + (poles[:, None] * waves[1]).sum(axis=0)).real
    exact = K * twist + damping * speed
    assert np.abs(found[:, 0] - exact).max() <= run.torque_error[0] + 1e-9
    assert run.torque_error[0] < 1e-7 * np.abs(exact).max()
