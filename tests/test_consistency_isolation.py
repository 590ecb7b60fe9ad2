"""Claim: the maximum of a run-up is that of a dense sweep, however the speeds are cut in blocks."""

import numpy as np
import pytest
from isolation_machines import (
    ORDERS,
    SPEED,
    Body,
    gibson,
    gibson_couple,
    random_body,
    shows,
)

from vibecalc.isolation.pitch import (
    pitch_resonances,
)
from vibecalc.isolation.rigid_body import (
    mount_readout,
)
from vibecalc.isolation.rows import HarmonicsAt, body_rows, pitch_rows
from vibecalc.isolation.run_up import RunUpPeak, cycle_peaks, run_up, run_up_peak
from vibecalc.numerics.rounding import WithError
from vibecalc.response.modal_damping import body_resonances
from vibecalc.response.modes import modes

ALL_ROWS = np.ones((1, 5), dtype=bool)


def six(couple: WithError) -> WithError:
    """A couple about y as forces (orders, 6)."""
    value = np.zeros((len(couple.value), 6), dtype=complex)
    error = np.zeros(value.shape)
    value[:, 4], error[:, 4] = couple.value, couple.error
    return WithError(value, error)


def gibson_rows(damping: float = 50.0) -> HarmonicsAt:
    return pitch_rows(*gibson(damping), ORDERS, gibson_couple())




def body_run_up(body: Body, load: WithError, orders: np.ndarray, stop: float) -> RunUpPeak:
    readout = mount_readout(*body.mounts)
    shapes = modes(body.matrices)
    seen = shows(readout, shapes.shape, shapes.natural_frequency)
    rows = body_rows(body.matrices, readout, orders, load)
    resonances = body_resonances(body.matrices, shapes, load)
    whole = run_up(rows, orders, resonances, 0.0, stop, seen)
    alone = run_up_peak(rows, orders, resonances, 0.0, stop, seen)
    assert whole.unresolved == 0
    assert alone.value == pytest.approx(whole.peak.value, rel=1e-11)
    assert alone.speed == pytest.approx(whole.peak.speed, rel=1e-9)
    return whole.peak


def test_blocks_of_speeds_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    body, load = random_body(5), six(gibson_couple())
    whole = body_run_up(body, load, ORDERS, SPEED)
    curve = cycle_peaks(gibson_rows(), ORDERS, np.linspace(1.0, SPEED, 500))
    monkeypatch.setattr("vibecalc.isolation.run_up.MOST_AT_ONCE", 40)
    parts = body_run_up(body, load, ORDERS, SPEED)
    assert parts.value == pytest.approx(whole.value, rel=1e-12)
    assert parts.speed == pytest.approx(whole.speed, rel=1e-11)
    pieces = cycle_peaks(gibson_rows(), ORDERS, np.linspace(1.0, SPEED, 500))
    assert pieces.value == pytest.approx(curve.value, rel=1e-13)
    assert pieces.error.shape == curve.error.shape


@pytest.mark.parametrize("seed", range(2))
def test_run_up_of_random_bodies_holds_against_dense_sweeps(seed: int) -> None:
    body = random_body(seed)
    orders = np.array([1, 2, 4])
    generator = np.random.default_rng(seed)
    value = generator.normal(size=(3, 6)) * np.array([[1.0], [0.3], [0.05]]) + 0j
    load = WithError(value, ORDERS[0] * 1e-16 * np.abs(value))
    stop = 3.0 * float(modes(body.matrices).natural_frequency[-1])
    peak = body_run_up(body, load, orders, stop)
    rows = body_rows(body.matrices, mount_readout(*body.mounts), orders, load)
    near = [v * (1.0 + np.linspace(-0.01, 0.01, 101)) for v in peak.speed]
    sweep = np.concatenate([np.linspace(0.0, stop, 3000), *near])
    swept = cycle_peaks(rows, orders, sweep[sweep <= stop])
    top = np.max(swept.value, axis=0)
    assert np.all(top <= peak.value * (1.0 + 1e-12) + peak.error)
    assert top == pytest.approx(peak.value, rel=1e-5)


def test_curve_between_its_speeds_is_a_straight_line_to_the_tolerance() -> None:
    resonances = pitch_resonances(gibson()[0], gibson_couple())
    passed = run_up(gibson_rows(), ORDERS, resonances, 0.0, SPEED, ALL_ROWS, curve_tolerance=1e-3)
    between = 0.7 * passed.speed[1:] + 0.3 * passed.speed[:-1]
    line = 0.7 * passed.curve.value[1:, 0] + 0.3 * passed.curve.value[:-1, 0]
    true = cycle_peaks(gibson_rows(), ORDERS, between).value[:, 0]
    # the test of midpoints sees a grid of angles, which is good to some 4e-4
    assert np.max(np.abs(true - line)) <= 2e-3 * passed.peak.value[0]
    assert len(passed.speed) < 600
