"""Claim: hard transients are right to their error, impossible ones are refused in words."""

import numpy as np
import pytest
from switching_machines import (
    BOTH,
    ONLY_A,
    SPEED,
    Loads,
    at_once,
    compressor,
    compressor_loads,
    followed,
    integrate,
    modal_loads,
    one_mode,
    transient,
)

from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.follow import passages, worst_instant
from vibecalc.response.switching.readings import steady_peaks
from vibecalc.response.switching.system import ModalSystem, SpeedSegment, modal_size

STOP = [SpeedSegment(0.2, SPEED, 0.0, BOTH)]


def test_a_mode_at_rest_needs_neither_stiffness_nor_damping() -> None:
    """Two masses of which only one is driven, on the resonance of the other."""
    loads = Loads(np.array([1]), np.array([[[1.0, 0.0]], [[0.5, 0.0]]]))
    alone, one = one_mode(50.0, 0.1, [1], np.array([[1.0], [0.5]]))
    profile = [SpeedSegment(0.5, 80.0, 20.0, 1), SpeedSegment(0.2, 20.0, 20.0, 1)]
    first = transient(alone, one, profile, before=0)
    for frequency in (0.0, 80.0):
        system = ModalSystem(np.eye(2), np.array([50.0, frequency]), np.array([0.1, 0.0]))
        both = transient(system, loads, profile, before=0)
        value = both.peaks.height.value
        assert value[[0, 2, 4, 5, 6]] == pytest.approx(first.peaks.height.value, rel=1e-11)
        assert value[1] == 0.0 and value[3] == 0.0
        assert both.settled.value == pytest.approx(first.settled.value, rel=1e-11)
        worst, _ = worst_instant(system, modal_loads(system, loads), 0, 1, 80.0)
        assert np.isfinite(worst.value)


def test_too_long_a_course_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="more than can be followed"):
        transient(compressor(), compressor_loads(), [SpeedSegment(1e5, SPEED, 0.0, BOTH)])
    with pytest.raises(NumericalFailure, match="strongly damped"):
        transient(compressor(1e7), compressor_loads(), STOP)
    # each segment alone would do
    profile = [SpeedSegment(150.0, SPEED, 0.0, BOTH), SpeedSegment(150.0, 0.0, SPEED, BOTH)] * 3
    with pytest.raises(NumericalFailure, match="more than can be followed"):
        transient(compressor(), compressor_loads(), profile)


def test_nearly_undamped_change_settles_far_away() -> None:
    system, loads = compressor(1e-6), compressor_loads(3)
    done = at_once(system, loads, BOTH, ONLY_A, 0.1)
    value, error = done.peaks.height
    assert done.settled.value > 1e4
    # nothing has decayed: the bound on what is still to come says so
    assert np.all(done.later > value * (1.0 - 1e-4))
    assert np.all(error < 1e-9 * value)
    times = np.linspace(0.0, 0.1, 81)
    truth = integrate(system, loads, [SpeedSegment(0.1, SPEED, SPEED, ONLY_A)], times, before=BOTH)
    assert np.all(
        np.max(np.abs(truth[:, :6]), axis=0) <= done.peaks.height.value[:6] * (1.0 + 1e-9)
    )


def test_a_tolerance_below_rounding_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="larger settle tolerance"):
        transient(
            compressor(),
            compressor_loads(),
            [SpeedSegment(0.05, SPEED, 0.01, BOTH), SpeedSegment(1.0, 0.01, 0.01, BOTH)],
            tolerance=1e-9,
        )


@pytest.mark.parametrize("turns", [1.0, 0.01])
def test_a_ramp_of_one_turn_or_less(turns: float) -> None:
    system, loads = compressor(), compressor_loads(12)
    duration = turns * 2.0 * np.pi / (0.5 * SPEED)
    profile = [SpeedSegment(duration, SPEED, 0.0, BOTH), SpeedSegment(0.05, 0.0, 0.0, BOTH)]
    done = transient(system, loads, profile, angle=0.9)
    times = np.unique(
        np.concatenate([np.linspace(0.0, duration, 80), duration + np.linspace(0.0, 0.05, 400)])
    )
    truth = integrate(system, loads, profile, times[:-1], angle=0.9)
    sampled = np.max(np.abs(truth[:, :6]), axis=0)
    assert np.all(done.peaks.height.value[:6] >= sampled * (1.0 - 1e-8))
    assert np.all(done.peaks.height.value[:6] <= sampled * (1.0 + 1e-2))


def test_two_hundred_orders_that_hardly_fall_off() -> None:
    """Against the same course in which the orders act one by one."""
    generator = np.random.default_rng(4)
    orders = np.arange(1, 201)
    phase = np.exp(2j * np.pi * generator.uniform(size=200))
    amplitude = (phase / orders)[None]
    system, loads = one_mode(400.0, 0.05, orders.tolist(), amplitude)
    profile = [SpeedSegment(0.3, 40.0, 0.0, 0), SpeedSegment(0.1, 0.0, -20.0, 0)]
    whole = followed(system, loads, profile, 0.2, 0)
    total = np.zeros((1, 2))
    for n in range(0, 200, 20):
        some = Loads(orders[n : n + 20], amplitude[:, n : n + 20, None])
        total += followed(system, some, profile, 0.2, 0).state[-1]
    off = whole.state[-1] - total
    assert np.hypot(400.0 * off[0, 0], off[0, 1]) <= whole.error[0]
    assert whole.error[0] < 1e-10 * np.max(modal_size(system, whole.state))
    found = passages(system, modal_loads(system, loads), profile[:1])
    assert len(found.mode) == 191  # orders from 10 up


def test_order_on_a_damped_natural_frequency_at_the_operating_speed() -> None:
    """Cutting in at resonance builds up as 1 - exp(-zeta w t), in closed form."""
    ratio, frequency = 0.01, 361.0
    system, loads = one_mode(frequency, ratio, [1], np.array([[0.0], [1.0]]))
    done = at_once(system, loads, 0, 1, 1.0, buckets=50)
    assert steady_peaks(system, modal_loads(system, loads), 1, SPEED).value[0] == pytest.approx(
        1.0 / (2.0 * ratio), rel=1e-12
    )
    # a bucket is a little longer than a swing, over which the crest grows by less than 7 %
    growth = (1.0 - np.exp(-ratio * frequency * done.history.time)) / (2.0 * ratio)
    crest = np.maximum(done.history.high, -done.history.low)[:, 0]
    assert np.all(crest >= 0.97 * growth[:-1]) and np.all(crest <= 1.01 * growth[1:])
    # sqrt(energy) of the deviation: 5 % after ln(20) / (zeta w), within the swing of its rate
    expected = np.log(20.0) / (ratio * frequency)
    assert done.settled.value == pytest.approx(expected, rel=0.02)
