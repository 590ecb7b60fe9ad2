"""Claim: a shaking that is called settled stays where it is, however it got there.

Synthetic turns whose size decays geometrically to 1, evenly, from side to side, or beating. The
turn that `settled_turn` names is then within the share of the limit; a decay so slow that it is
still on its way is not called settled, though one turn hardly differs from the next.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibecalc.roll.start_up_readings import (
    QUANTITIES,
    TimeHistory,
    Turns,
    settled_turn,
    steps_between,
    stretches,
)
from vibecalc.roll.start_up_system import LoadSteps


def turns(amplitude: np.ndarray) -> Turns:
    count = len(amplitude)
    return Turns(0.1 * np.arange(count), np.full(count, 0.1), amplitude)


@given(
    ratio=st.floats(0.3, 0.97),
    beat=st.sampled_from([0.0, np.pi, 0.54 * 2.0 * np.pi, 0.31]),
    size=st.floats(0.05, 2.0),
    count=st.integers(6, 120),
    share=st.sampled_from([0.002, 0.01, 0.05]),
)
def test_what_is_called_settled_is_near_its_limit(
    ratio: float, beat: float, size: float, count: int, share: float
) -> None:
    n = np.arange(count)
    amplitude = 1.0 + 0.4 * size * ratio**n * np.cos(beat * n)
    place = settled_turn(turns(amplitude), share)
    if place is None:
        return
    # the last turn may itself be a share away from the limit
    assert np.all(np.abs(amplitude[place:] - 1.0) < 2.0 * share + 2.0 * share**2)


@pytest.mark.parametrize("beat", [0.0, np.pi, 0.54 * 2.0 * np.pi])
def test_a_long_look_at_a_decay_settles_it(beat: float) -> None:
    n = np.arange(80)
    place = settled_turn(turns(1.0 + 0.4 * 0.84**n * np.cos(beat * n)), 0.01)
    assert place is not None and 10 <= place <= 30


def test_a_heavy_rotor_is_not_settled_by_small_changes_alone() -> None:
    """Four per mille from turn to turn, and a fifth still to go."""
    n = np.arange(40)
    amplitude = 1.0 + 0.4 * 0.98**n
    assert np.max(np.abs(np.diff(amplitude[-10:]))) < 0.01
    assert settled_turn(turns(amplitude), 0.01) is None


def test_stretches_part_peaks_and_speeds_at_the_changes_of_load() -> None:
    """Three steps of one second with seven looks each; the load changes after two of them."""
    begin = np.repeat([0.0, 1.0, 2.0], 7)
    time = begin + np.tile(np.arange(7) / 6.0, 3)
    value = np.zeros((len(QUANTITIES), len(time)))
    row = QUANTITIES.index("motor_torque")
    value[row] = np.where(begin < 2.0, 3.0 * time, -40.0)
    shown = TimeHistory(time, value)
    found = Turns(np.array([0.0, 0.9, 2.0]), np.array([0.9, 0.9, 0.5]), np.ones(3))
    parts = stretches(shown, found, LoadSteps(np.array([0.0, 2.0, 9.0]), np.array([0.0, 1.0, 0.5])))
    np.testing.assert_array_equal(parts.begin, [0.0, 2.0])
    np.testing.assert_array_equal(parts.factor, [0.0, 1.0])
    np.testing.assert_allclose(parts.speed, 2.0 * np.pi / np.array([0.9, 0.5]))
    np.testing.assert_allclose(parts.peaks.value[:, row], [6.0, 40.0])
    assert steps_between(shown, 1.0, 2.0).time.tolist() == time[7:14].tolist()
