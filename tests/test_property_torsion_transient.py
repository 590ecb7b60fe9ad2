"""Claim: error estimates, soft starts and sliding envelopes of a transient behave as they must."""

import numpy as np
import pytest
from torsion_lines import engine

from vibecalc.torsion.line import chain
from vibecalc.torsion.transient import march as transient_pieces
from vibecalc.torsion.transient.march import TransientRun, transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.trace import extremes, section_peaks, sliding, traces

CYCLE = 4.0 * np.pi
ORDERS = np.arange(1, 17) / 2
LINE = chain(np.array([18.0, 19.0, 18.0, 900.0]), np.array([22e6, 21e6, 19e6]))._replace(
    damping=np.array([900.0, 800.0, 800.0])
)


def gas(orders: np.ndarray, stations: int, fires: dict[int, int]) -> np.ndarray:
    """Torques (stations, m), each of its station after as many sixths of a turn."""
    found = np.zeros((stations, orders.size), dtype=complex)
    for station, place in fires.items():
        found[station] = 3000.0 / orders * np.exp(-1j * orders * place * np.pi / 3.0)
    return found


THREE, TWO = gas(ORDERS, 4, {0: 0, 1: 8, 2: 4}), gas(ORDERS, 4, {0: 0, 2: 4})


def test_error_estimates_bound_the_error_and_the_order_is_high(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    line = engine(damper=True)._replace(damping=np.array([2000.0] + [800.0] * 6))
    orders = np.arange(1, 31) / 2
    part = stretch(1.0, 40.0, gas(orders, 8, {1: 0, 2: 8, 3: 4, 4: 10, 5: 2, 6: 6}))

    def ends(length: float) -> TransientRun:
        monkeypatch.setattr(transient_pieces, "ORDER_STEP", length)
        monkeypatch.setattr(transient_pieces, "MODE_STEP", 6.0 * length)
        return transient(line, orders, [part], 100.0, rtol=np.inf)

    exact = ends(0.5)
    errors = []
    for length in (4.0, 8.0):
        run = ends(length)
        gap = (run.states[-1][-1] - exact.states[-1][-1]) @ exact.system.torque.T
        assert np.all(np.abs(gap) <= run.torque_error + exact.torque_error)
        errors.append(np.abs(gap).max())
    # sixteen radians of the highest order in a step of the rough march: still distinguished
    assert errors[1] > 2**9 * errors[0]


def test_start_from_rest_ramps_the_torque_in() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4000.0]))._replace(damping=np.array([2.8]))
    grip, order = np.array([[40.0, 50.0], [0.0, 0.0]], dtype=complex), np.array([0.0, 1.0])
    ramp = [stretch(2.0, 5.0, grip, scale=(0.0, 1.0)), stretch(2.0, 5.0, grip)]
    soft = transient(line, order, ramp, 0.0)
    hard = transient(line, order, [stretch(4.0, 5.0, grip)], 0.0)
    early = [np.abs(run.states[0][:40] @ run.system.torque.T).max() for run in (soft, hard)]
    assert early[0] < 0.2 * early[1]
    assert soft.course.speed[-1] == pytest.approx(20.0) and soft.course.time.size == 3


def test_a_steady_motion_has_a_flat_envelope() -> None:
    run = transient(LINE, ORDERS, [stretch(1.0, 0.0, THREE)], 83.0, start="steady")
    windows = sliding(run.course, CYCLE, 61)
    assert windows is not None
    seen = traces(run, np.concatenate(windows))
    for trace in seen:
        low, high, error = extremes(trace, windows.begin, windows.end)
        for values in (low, high):
            assert np.all(np.abs(values - values[0]) <= error + error[0])
            assert np.ptp(values) == pytest.approx(0.0, abs=2e-6 * high.max())
        assert np.all(error < 1e-5 * high.max())
        assert np.all(np.abs(high - trace.value.max()) <= error + error.max())


def test_a_long_run_is_left_out_nowhere_and_a_short_one_has_no_envelope() -> None:
    """A misfire sets in within a cycle."""
    parts = [stretch(0.4, 0.0, THREE), stretch(1.6, 0.0, TWO)]
    run = transient(LINE, ORDERS, parts, 83.0, start="steady")
    few = sliding(run.course, CYCLE, 4)
    assert few is not None
    seen = traces(run, np.concatenate(few))
    peaks = section_peaks(run, seen)
    for section, trace in enumerate(seen):
        low, high, _ = extremes(trace, few.begin, few.end)
        assert max(high.max(), -low.min()) == pytest.approx(peaks.peak[section], rel=1e-5)
    short = transient(LINE, ORDERS, [stretch(0.1, 0.0, THREE)], 83.0, start="steady")
    assert sliding(short.course, CYCLE) is None
