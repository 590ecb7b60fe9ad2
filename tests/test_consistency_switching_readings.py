"""Claim: peaks, settling, worst angles and resonances are those that a plain search finds."""

import numpy as np
import pytest
from switching_machines import (
    BOTH,
    IDLE,
    ONLY_A,
    REVERSAL,
    SPEED,
    THROUGH_ZERO,
    compressor,
    compressor_loads,
    followed,
)

from vibecalc.response.switching.follow import follow, slow_peaks
from vibecalc.response.switching.instant import instantaneous, worst_instant
from vibecalc.response.switching.motion import (
    ModalMotion,
    follow_profile,
    motion_at,
    passages,
    runs_of,
)
from vibecalc.response.switching.readings import columns, read
from vibecalc.response.switching.system import ModalSystem, SpeedSegment, modal_loads


@pytest.mark.long
def test_peaks_are_those_of_a_dense_search() -> None:
    system, loads = compressor(), compressor_loads(4)
    modal = modal_loads(system, loads)
    found = follow(system, loads, REVERSAL, angle=0.4)
    best, when, speed = np.zeros((3, 15))
    for segment in followed(system, loads, REVERSAL, 0.4, BOTH):
        time = np.linspace(0.0, segment.run.duration, 40001)
        value = np.abs(read(system, motion_at(system, modal, segment, time)).value)
        top = np.argmax(value, axis=0)
        higher = value[top, np.arange(15)] > best
        best = np.where(higher, value[top, np.arange(15)], best)
        when = np.where(higher, segment.run.start + time[top], when)
        speed = np.where(higher, segment.run.speed_at(time[top]), speed)
    assert np.all(found.peaks.value >= best - found.peaks.error)
    # a step of 1e-5 s: an eighth of (rate times step)^2 at 30 times the crank's speed
    assert np.all(found.peaks.value <= best * (1.0 + 1e-3))
    assert np.max(found.peaks.value / best - 1.0) < 1e-5
    assert np.max(np.abs(found.peaks.time - when)) < 2e-5
    assert np.max(np.abs(found.peaks.speed - speed)) < 0.05


def test_final_peaks_and_settling_are_those_of_the_motion_itself() -> None:
    system, loads = compressor(), compressor_loads(16)
    modal = modal_loads(system, loads)
    done = instantaneous(system, loads, BOTH, ONLY_A, SPEED, angle=1.0, duration=1.5)
    segment = followed(system, loads, [SpeedSegment(1.5, SPEED, SPEED, ONLY_A)], 1.0, BOTH)[0]
    late = followed(system, loads, [SpeedSegment(1.5, SPEED, SPEED, ONLY_A)], 1.0, ONLY_A)[0]
    energy = columns().energy
    time = np.linspace(0.0, 1.5, 30001)
    moved, final = (motion_at(system, modal, s, time) for s in (segment, late))
    gap = ModalMotion(*(a - b for a, b in zip(moved, final, strict=True)))
    deviation = np.sqrt(read(system, gap).value[:, energy])
    top = np.sqrt(np.max(read(system, final).value[:, energy]))
    assert top**2 == pytest.approx(done.final.value[energy], rel=1e-5)
    below = time[np.argmax(deviation <= 0.05 * top)]
    assert 0.0 <= below - done.settling.time + 1e-12 <= 1.5 / 30000
    assert np.all(np.diff(deviation) <= 1e-12 * top)
    assert done.settling.deviation == pytest.approx(deviation[0] / top, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(
    ("before", "after"),
    [
        (BOTH, ONLY_A),
        (ONLY_A, BOTH),
        (IDLE, ONLY_A),
    ],
)
def test_worst_instant_is_the_largest_over_the_angles(before: int, after: int) -> None:
    system, loads = compressor(), compressor_loads(3)
    worst = worst_instant(system, loads, before, after, SPEED)
    assert np.all(worst.error <= 1e-4 * worst.value)
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    peaks = [
        instantaneous(system, loads, before, after, SPEED, angle=a, duration=0.5).peaks.value
        for a in angles.tolist()
    ]
    largest = np.max(peaks, axis=0)
    assert np.all(largest <= worst.value + worst.error)
    assert np.all(largest >= 0.97 * worst.value)
    for column in (1, 7, columns().energy):
        there = instantaneous(
            system, loads, before, after, SPEED, angle=float(worst.angle[column]), duration=0.5
        ).peaks
        off = abs(there.value[column] - worst.value[column])
        assert off <= worst.error[column] + there.error[column]
        assert there.time[column] == pytest.approx(worst.time[column], abs=1e-5)


@pytest.mark.long
def test_slow_peaks_are_those_of_a_dense_scan_of_speeds() -> None:
    system, loads = compressor(), compressor_loads(4)
    slow = slow_peaks(system, loads, [SpeedSegment(1.0, 0.0, SPEED, ONLY_A)])
    modal = modal_loads(system, loads)
    scanned = np.zeros(15)
    for speed in np.linspace(45.0, 125.0, 201).tolist():
        turn = 2.0 * np.pi / speed
        course = [SpeedSegment(turn, speed, speed, ONLY_A)]
        segment = follow_profile(
            system, modal, course, angle=0.0, before=ONLY_A, longest=turn / 100
        )
        values = read(system, motion_at(system, modal, segment[0], segment[0].grid)).value
        scanned = np.maximum(scanned, np.max(np.abs(values), axis=0))
    assert np.all(scanned <= slow.value + slow.error)
    assert np.all(scanned >= 0.99 * slow.value)


def test_passages_are_where_an_order_turns_as_fast_as_a_mode() -> None:
    system, loads = compressor(), compressor_loads(12)
    found = passages(system, loads, REVERSAL)
    starts = np.cumsum([0.0, *(piece.duration for piece in REVERSAL)])
    for passage in found:
        piece = REVERSAL[passage.segment]
        gain = (piece.end_speed - piece.start_speed) / piece.duration
        speed = piece.start_speed + gain * (passage.time - starts[passage.segment])
        assert speed == pytest.approx(passage.speed, rel=1e-12)
        assert passage.order * abs(speed) == pytest.approx(system.frequency[passage.mode - 1])
    # six modes, order 1 and the even ones, down with two pistons and up with one
    assert sorted({(p.order, p.segment) for p in found}) == sorted(
        (n, segment) for n in (1, 2, 4, 6, 8, 10, 12) for segment in (0, 2)
    )
    assert len(runs_of(REVERSAL, 0.0)) == 4 and len(runs_of(THROUGH_ZERO, 0.0)) == 3
    highest = max(found, key=lambda passage: passage.slow_energy)
    system_of_one = ModalSystem(
        system.shape[:, [highest.mode - 1]],
        system.frequency[[highest.mode - 1]],
        system.damping_ratio[[highest.mode - 1]],
    )
    force = loads.per_speed_squared[ONLY_A, highest.order - 1] @ system_of_one.shape[:, 0]
    amplitude = abs(force) * highest.speed**2 / (0.06 * system_of_one.frequency[0] ** 2)
    energy = 0.5 * (system_of_one.frequency[0] * amplitude) ** 2
    assert highest.slow_energy == pytest.approx(energy, rel=1e-9)
