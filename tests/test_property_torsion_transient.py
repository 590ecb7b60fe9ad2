"""Claim: passages, envelopes, error estimates and spectra of a transient behave as they must."""

from types import SimpleNamespace

import numpy as np
import pytest

from vibecalc.torsion.line import chain, dynamic_stiffness
from vibecalc.torsion.transient import march as transient_pieces
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.trace import extremes, traces

PAIR = chain(np.array([2.0, 3.0]), np.array([4000.0]))._replace(damping=np.array([2.8]))
FORCE = np.array([[50.0 + 0j], [0.0]])
GRIP = np.array([[40.0, 50.0], [0.0, 0.0]], dtype=complex)
SPEEDS = np.linspace(30.0, 90.0, 1201)
MATRIX = dynamic_stiffness(PAIR, SPEEDS)
ANGLE = np.linalg.solve(MATRIX, np.broadcast_to(FORCE, (1201, 2, 1)))[..., 0]
STEADY = np.abs((4000.0 + 2.8j * SPEEDS) * (ANGLE[:, 0] - ANGLE[:, 1]))[:, None]

ENGINE = chain(
    np.array([27.5126, *[18.64] * 6, 2655.0]),
    np.array([5.9712e5, *[22.82e6] * 5, 19.21e6]),
)._replace(damping=np.array([2000.0] + [800.0] * 6))
ORDERS = np.arange(1, 31) / 2


def engine_gas() -> np.ndarray:
    gas = np.zeros((8, 30), dtype=complex)
    for cylinder, place in enumerate([0, 8, 4, 10, 2, 6]):
        gas[cylinder + 1] = 3000.0 / ORDERS * np.exp(-1j * ORDERS * place * np.pi / 3.0)
    return gas


def passage(acceleration: float):
    start = 40.0 if acceleration > 0.0 else 80.0
    parts = [stretch(40.0 / abs(acceleration), acceleration, FORCE)]
    run = transient(PAIR, np.array([1.0]), parts, start, start="steady")
    border = np.linspace(0.0, run.course.time[-1], 151)
    low, high, _ = extremes(traces(run, border)[0], border[:-1], border[1:])
    half, speed = 0.5 * (high - low), run.course.at(0.5 * (border[:-1] + border[1:]))[0]
    step = speed[1] - speed[0]
    inside = speed + step * np.linspace(-0.5, 0.5, 9)[:, None]
    steady = np.interp(inside, SPEEDS, STEADY[:, 0]).max(axis=0)
    peak, at = half.max(), SPEEDS[STEADY[:, 0].argmax()]
    lag = np.sign(acceleration) * (speed[half.argmax()] - at)
    return SimpleNamespace(
        half_range=half, steady=steady, peak=peak, overshoot=peak / STEADY.max() - 1.0, lag=lag
    )


def test_slow_passages_are_quasi_steady_and_fast_ones_lower_and_later() -> None:
    slow = passage(0.05)
    np.testing.assert_allclose(slow.half_range, slow.steady, rtol=0.03)
    assert abs(slow.overshoot) < 2e-3 and slow.lag < 0.5
    faster = [passage(a) for a in (0.5, 4.0, 30.0)]
    peaks = [slow.peak, *[each.peak for each in faster]]
    lags = [slow.lag, *[each.lag for each in faster]]
    assert np.all(np.diff(peaks) < 0.0) and np.all(np.diff(lags) > 0.0)
    down = passage(-4.0)
    assert down.overshoot < -0.05 and down.lag > 0.3


def test_error_estimates_bound_the_error_and_the_order_is_high(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def ends(length: float) -> TransientRun:
        monkeypatch.setattr(transient_pieces, "ORDER_STEP", length)
        monkeypatch.setattr(transient_pieces, "MODE_STEP", 6.0 * length)
        part = stretch(1.0, 40.0, engine_gas())
        return transient(ENGINE, ORDERS, [part], 100.0, rtol=np.inf)

    exact = ends(0.5)
    errors = []
    for length in (4.0, 8.0):
        run = ends(length)
        gap = (run.states[-1][-1] - exact.states[-1][-1]) @ exact.system.torque.T
        assert np.all(np.abs(gap) <= run.torque_error + exact.torque_error)
        errors.append((np.abs(gap).max(), run.torque_error.max()))
    # sixteen radians of the highest order in a step of the rough march: still distinguished
    assert errors[1][0] > 2**9 * errors[0][0]


def test_start_from_rest_ramps_the_torque_in() -> None:
    ramp = [stretch(2.0, 5.0, GRIP, scale=(0.0, 1.0)), stretch(2.0, 5.0, GRIP)]
    soft = transient(PAIR, np.array([0.0, 1.0]), ramp, 0.0)
    hard = transient(PAIR, np.array([0.0, 1.0]), [stretch(4.0, 5.0, GRIP)], 0.0)
    early = [np.abs(run.states[0][:40] @ run.system.torque.T).max() for run in (soft, hard)]
    assert early[0] < 0.2 * early[1]
    assert soft.course.speed[-1] == pytest.approx(20.0) and soft.course.time.size == 3


def test_ring_on_a_dashpot_is_dragged_along() -> None:
    # the ring of 3 kg m^2 follows the acceleration of 2 rad/s^2 only by the torque of its dashpot
    line = chain(np.array([5.0, 3.0]), np.array([0.0]))._replace(damping=np.array([9.0]))
    none = np.zeros((2, 1), dtype=complex)
    run = transient(
        line, np.array([1.0]), [stretch(8.0, 2.0, none)], 0.0, reaction=np.array([1.0, 0.0])
    )
    torque = run.states[-1][-1] @ run.system.torque.T
    exact = -np.expm1(-9.0 * 8.0 * (1 / 5.0 + 1 / 3.0)) * 3.0 * 2.0
    assert abs(torque[0] - exact) <= run.torque_error[0] < 1e-6


def test_shares_of_reaction_matter_for_the_mean_only() -> None:
    def torques(mean: float, share: np.ndarray | None) -> np.ndarray:
        gas = np.array([[mean, 20.0], [0.0, 5.0j]], dtype=complex)
        part = stretch(2.0, 0.0, gas)
        run = transient(PAIR, np.array([0.0, 1.0]), [part], 30.0, reaction=share)
        return run.states[-1] @ run.system.torque.T

    far = np.array([0.0, 1.0])
    np.testing.assert_allclose(torques(0.0, None), torques(0.0, far), rtol=0, atol=1e-9)
    # the far end holds the mean of 60 N m: it passes the shaft, and not 3/5 of it
    gain = torques(60.0, far) - torques(60.0, None)
    assert gain[-1, 0] == pytest.approx(60.0 * 2.0 / 5.0, rel=0.2)
