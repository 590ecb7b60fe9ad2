"""Claim: peaks, settling, worst angles and resonances are those that a plain search finds."""

import numpy as np
import pytest
from switching_machines import (
    BOTH,
    ONLY_A,
    REVERSAL,
    SPEED,
    at_once,
    compressor,
    compressor_loads,
    followed,
    modal_loads,
    motion,
)

from vibecalc.response.switching.follow import passages
from vibecalc.response.switching.readings import ENERGY, read, steady_peaks
from vibecalc.response.switching.system import SpeedSegment


def test_final_peaks_and_settling_are_those_of_the_motion_itself() -> None:
    system, loads = compressor(), compressor_loads(16)
    done = at_once(system, loads, BOTH, ONLY_A, 1.5, angle=1.0)
    profile = [SpeedSegment(1.5, SPEED, SPEED, ONLY_A)]
    time = np.linspace(0.0, 1.5, 30001)
    moved, final = (
        motion(followed(system, loads, profile, 1.0, first), time) for first in (BOTH, ONLY_A)
    )
    deviation = np.sqrt(read(system, moved - final)[0, :, ENERGY])
    top = np.sqrt(np.max(read(system, final)[0, :, ENERGY]))
    steady = steady_peaks(system, modal_loads(system, loads), ONLY_A, SPEED)
    assert top**2 == pytest.approx(steady.value[ENERGY], rel=1e-5)
    below = time[np.argmax(deviation <= 0.05 * top)]
    assert 0.0 <= below - done.settled.value + 1e-12 <= 1.5 / 30000
    assert np.all(np.diff(deviation) <= 1e-12 * top)


def test_passages_are_where_an_order_turns_as_fast_as_a_mode() -> None:
    system, loads = compressor(), compressor_loads(12)
    found = passages(system, modal_loads(system, loads), REVERSAL)
    starts = np.cumsum([0.0, *(piece.duration for piece in REVERSAL)])
    segment = np.searchsorted(starts, found.time, side="right") - 1
    gain = np.array([(p.end_speed - p.start_speed) / p.duration for p in REVERSAL])[segment]
    first = np.array([piece.start_speed for piece in REVERSAL])[segment]
    assert first + gain * (found.time - starts[segment]) == pytest.approx(found.speed, rel=1e-12)
    met = system.frequency[found.mode - 1]
    assert found.order * np.abs(found.speed) == pytest.approx(met)
    # six modes, order 1 and the even ones, down with two pistons and up with one
    assert sorted(set(zip(found.order.tolist(), segment.tolist(), strict=True))) == sorted(
        (n, segment) for n in (1, 2, 4, 6, 8, 10, 12) for segment in (0, 2)
    )
    top = int(np.argmax(found.energy))
    shape, frequency = system.shape[:, found.mode[top] - 1], met[top]
    force = np.asarray(loads.per_speed_squared)[ONLY_A, found.order[top] - 1] @ shape
    amplitude = abs(force) * found.speed[top] ** 2 / (0.06 * frequency**2)
    assert found.energy[top] == pytest.approx(0.5 * (frequency * amplitude) ** 2, rel=1e-9)
