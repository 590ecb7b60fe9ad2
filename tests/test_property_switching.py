"""Claim: switching transients keep the symmetries of the physics and of the description.

Fewer orders are fewer orders, and the errors say what that costs; a short watch is reported, and no
peak lies below the steady motion after it; samples stand where the machine puts them.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from response_machines import run
from switching_machines import (
    BOTH,
    ONLY_A,
    SPEED,
    at_once,
    at_worst,
    compressor,
    compressor_loads,
    modal_loads,
    transient,
)
from test_consistency_switching_stage import STEM, switching

from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import tolerance_warning
from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.follow import Transient
from vibecalc.response.switching.readings import KINETIC, steady_peaks
from vibecalc.response.switching.system import SpeedSegment

REVERSAL = [
    SpeedSegment(0.3, SPEED, 0.0, BOTH),
    SpeedSegment(0.1, 0.0, 0.0, BOTH),
    SpeedSegment(0.2, 0.0, -SPEED, ONLY_A),
    SpeedSegment(0.1, -SPEED, -SPEED, ONLY_A),
]
SYSTEM, LOADS = compressor(), compressor_loads(12)


@cache
def plain() -> Transient:
    return transient(SYSTEM, LOADS, REVERSAL, angle=0.5)


@given(st.floats(0.05, 0.95), st.integers(0, 3))
@settings(max_examples=2, deadline=None)
def test_a_piece_may_be_cut_in_two(share: float, number: int) -> None:
    segment = REVERSAL[number]
    middle = segment.start_speed + share * (segment.end_speed - segment.start_speed)
    cut = [
        SpeedSegment(share * segment.duration, segment.start_speed, middle, segment.operation),
        SpeedSegment(
            (1.0 - share) * segment.duration, middle, segment.end_speed, segment.operation
        ),
    ]
    done = transient(SYSTEM, LOADS, REVERSAL[:number] + cut + REVERSAL[number + 1 :], angle=0.5)
    (ours, error), (value, off) = done.peaks.height, plain().peaks.height
    assert np.all(np.abs(ours - value) <= error + off)
    if number < 3:
        assert done.settled.value == pytest.approx(plain().settled.value, rel=1e-9)


def test_no_change_leaves_the_steady_motion() -> None:
    done = at_once(SYSTEM, LOADS, ONLY_A, ONLY_A, angle=0.3)
    final = steady_peaks(SYSTEM, modal_loads(SYSTEM, LOADS), ONLY_A, SPEED)
    assert done.settled.value == 0.0
    assert np.all(
        np.abs(done.peaks.height.value - final.value) <= done.peaks.height.error + final.error
    )
    worst, angle = at_worst(SYSTEM, LOADS, ONLY_A, ONLY_A)
    assert (worst.value, angle) == (final.value[KINETIC], 0.0)


def test_histories_hold_the_peaks_in_their_buckets() -> None:
    edges = plain().history.time
    assert np.all(np.isfinite(plain().history.low)) and np.all(
        plain().history.low <= plain().history.high
    )
    extreme = np.maximum(np.abs(plain().history.low), np.abs(plain().history.high))
    top = np.max(extreme, axis=0)
    value, error = plain().peaks.height
    assert np.all(top <= value + error) and np.all(top >= 0.98 * value)
    assert edges[0] == 0.0 and edges[-1] == pytest.approx(0.7)
    assert plain().history.speed[0] == SPEED and plain().history.speed[-1] == -SPEED
    assert np.all(plain().history.low[:, KINETIC:] >= 0.0)


NAMES = ("kinetic_energy_peak", "translation_peak", "ground_force_peak", "settle_time",
         "kinetic_energy_high", "translation_high", "translation_low")  # fmt: skip
WANTED = (
    f"{STEM}/steady_energy",
    f"{STEM}/instant/worst_kinetic_energy_peak",
    *(f"{STEM}/{way}/{name}" for way in ("instant", "reversal") for name in NAMES),
)


@cache
def with_orders(orders: int | None) -> Record:
    table = switching(time_after="1 s")
    if orders is not None:
        table["excitation"]["orders"] = orders
    return run(table, *WANTED)


def test_too_few_orders_to_tell_when_it_has_settled() -> None:
    with pytest.raises(NumericalFailure, match=r"dropped orders may add.*keep more orders"):
        with_orders(1)


@pytest.mark.long
@pytest.mark.parametrize("orders", [2, 3])
def test_dropped_orders_are_dropped_and_within_the_errors(orders: int) -> None:
    few, all_of_them = with_orders(orders), with_orders(None)
    for path in WANTED:
        ours, truth = few[path], all_of_them[path]
        apart = np.abs(ours.values - truth.values).max()
        assert apart <= ours.error_estimate + truth.error_estimate, path
    energy, truth = (record[f"{STEM}/instant/kinetic_energy_peak"] for record in (few, all_of_them))
    apart = np.abs(energy.values - truth.values).max()
    assert apart > 1e4 * truth.error_estimate
    assert energy.error_estimate < 300.0 * apart
    assert "add orders ([excitation] orders)" in (tolerance_warning(few, 1e-9) or "")
    assert "undamped" not in (tolerance_warning(few, 1e-9) or "")


def test_no_peak_is_below_the_steady_motion_after_it_and_a_short_watch_is_reported() -> None:
    paths = (f"{STEM}/steady_energy", *(f"{STEM}/instant/{name}" for name in (
        "kinetic_energy_peak", "peak_time", "peak_speed", "translation_peak")))  # fmt: skip
    short, long = (run(switching(time_after=after), *paths) for after in ("1 ms", "1 s"))
    peaks, steady = short[f"{STEM}/instant/kinetic_energy_peak"], short[f"{STEM}/steady_energy"]
    assert np.all(peaks.values >= steady.values[::-1])
    assert peaks.values[0] == steady.values[1] < long[peaks.path].values[0]
    assert short[f"{STEM}/instant/peak_time"].values[0] == pytest.approx(1e-3, rel=1e-12)
    (reported,) = [words for words in short.warnings if "the body has not settled" in words]
    assert (
        "A+B to A at once settles in 0.645 s" in reported
        and "kinetic energy (up to 1.8" in reported
    )
    assert not any("the body has not settled" in words for words in long.warnings)


def test_samples_do_not_move_with_the_steps_inside() -> None:
    """More orders make finer steps; the samples change by the orders alone."""
    system = compressor()
    profile = [
        SpeedSegment(0.2, SPEED, 0.0, 0),
        SpeedSegment(0.1, 0.0, -SPEED, ONLY_A),
        SpeedSegment(0.05, -SPEED, -SPEED, ONLY_A),
    ]
    few, many = (
        transient(system, loads, profile, buckets=40)
        for loads in (compressor_loads(10)._replace(retained=6), compressor_loads(24))
    )
    assert few.history.samples == many.history.samples > 1
    value, error = many.peaks.height
    uncertainty = few.peaks.height.error + error
    for ours, other in zip(few.history[2:4], many.history[2:4], strict=True):
        assert np.all(np.abs(ours - other) <= uncertainty + 1e-12 * value)
