"""Claim: switching transients keep the symmetries of the physics and of the description.

Fewer orders are fewer orders, and the errors say what that costs; a short watch is reported, and no
peak lies below the steady motion after it; samples stand where the machine puts them.
"""

from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from response_machines import run
from switching_machines import BOTH, ONLY_A, ONLY_B, SPEED, compressor, compressor_loads
from test_consistency_switching_stage import STEM, switching

from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import tolerance_warning
from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.follow import Transient, follow
from vibecalc.response.switching.instant import instantaneous, worst_instant
from vibecalc.response.switching.motion import PANEL_PHASE, follow_profile, panel_grid, runs_of
from vibecalc.response.switching.readings import columns
from vibecalc.response.switching.system import Loads, ModalSystem, SpeedSegment, modal_loads

REVERSAL = [
    SpeedSegment(0.3, SPEED, 0.0, BOTH),
    SpeedSegment(0.1, 0.0, 0.0, BOTH),
    SpeedSegment(0.2, 0.0, -SPEED, ONLY_A),
    SpeedSegment(0.1, -SPEED, -SPEED, ONLY_A),
]
SYSTEM, LOADS = compressor(), compressor_loads(12, rotor=0.002)


@cache
def plain() -> Transient:
    return follow(SYSTEM, LOADS, REVERSAL, angle=0.5)


def assert_same(other: Transient, scale: float | np.ndarray = 1.0) -> None:
    """Same readings, up to a given scale of each, within both errors."""
    off = np.abs(other.peaks.value - scale * plain().peaks.value)
    assert np.all(off <= (other.peaks.error + scale * plain().peaks.error))
    off = np.abs(other.final.value - scale * plain().final.value)
    assert np.all(off <= (other.final.error + scale * plain().final.error))
    assert other.settling.time == pytest.approx(plain().settling.time, rel=1e-9)
    assert other.peaks.time == pytest.approx(plain().peaks.time, abs=1e-5)


@given(st.lists(st.sampled_from([-1.0, 1.0]), min_size=6, max_size=6), st.permutations(range(6)))
@settings(max_examples=2, deadline=None)
def test_sign_and_sequence_of_the_modes_do_not_matter(
    signs: list[float], sequence: list[int]
) -> None:
    turned = ModalSystem(
        (SYSTEM.shape * np.array(signs))[:, sequence],
        SYSTEM.frequency[sequence],
        SYSTEM.damping_ratio[sequence],
    )
    assert_same(follow(turned, LOADS, REVERSAL, angle=0.5))


def test_unit_of_a_coordinate_does_not_matter() -> None:
    unit = np.array([1.0, 1.0, 1.0, 1e-3, 1e3, 1.0])
    system = SYSTEM._replace(shape=SYSTEM.shape * unit[:, None])
    loads = Loads(LOADS.orders, LOADS.per_speed_squared / unit, LOADS.per_acceleration / unit)
    scale = np.concatenate([unit, 1.0 / unit, np.ones(3)])
    assert_same(follow(system, loads, REVERSAL, angle=0.5), scale)


@given(st.floats(1e-6, 1e6))
@settings(max_examples=2, deadline=None)
def test_response_is_proportional_to_the_loads(size: float) -> None:
    loads = Loads(LOADS.orders, size * LOADS.per_speed_squared, size * LOADS.per_acceleration)
    scale = np.concatenate([np.full(12, size), np.full(3, size**2)])
    assert_same(follow(SYSTEM, loads, REVERSAL, angle=0.5), scale)


def test_a_clock_twice_as_fast_makes_everything_faster() -> None:
    quick = SYSTEM._replace(frequency=2.0 * SYSTEM.frequency)
    profile = [SpeedSegment(p.duration / 2, 2 * p.start_speed, 2 * p.end_speed, p.operation)
              for p in REVERSAL]  # fmt: skip
    done = follow(quick, LOADS, profile, angle=0.5)
    scale = np.concatenate([np.ones(6), np.full(9, 4.0)])
    assert np.all(
        np.abs(done.peaks.value - scale * plain().peaks.value)
        <= (done.peaks.error + scale * plain().peaks.error)
    )
    assert done.settling.time == pytest.approx(0.5 * plain().settling.time, rel=1e-10)


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
    done = follow(SYSTEM, LOADS, REVERSAL[:number] + cut + REVERSAL[number + 1 :], angle=0.5)
    assert np.all(
        np.abs(done.peaks.value - plain().peaks.value) <= (done.peaks.error + plain().peaks.error)
    )
    if number < 3:
        assert done.settling.time == pytest.approx(plain().settling.time, rel=1e-9)


def test_turning_the_other_way_mirrors_the_crank() -> None:
    """theta -> -theta with conjugate loads is the same motion."""
    mirrored = Loads(LOADS.orders, LOADS.per_speed_squared.conj(), -LOADS.per_acceleration)
    profile = [
        SpeedSegment(p.duration, -p.start_speed, -p.end_speed, p.operation) for p in REVERSAL
    ]
    assert_same(follow(SYSTEM, mirrored, profile, angle=-0.5))


def test_no_change_leaves_the_steady_motion() -> None:
    done = instantaneous(SYSTEM, LOADS, ONLY_A, ONLY_A, SPEED, angle=0.3)
    assert done.settling.time == 0.0 and done.settling.deviation < 1e-12
    assert np.all(
        np.abs(done.peaks.value - done.final.value) <= done.peaks.error + done.final.error
    )
    worst = worst_instant(SYSTEM, LOADS, ONLY_A, ONLY_A, SPEED)
    assert np.array_equal(worst.value, done.final.value)


def test_responses_to_loads_add_up_at_every_time() -> None:
    def states(operation: int) -> np.ndarray:
        profile = [SpeedSegment(0.2, SPEED, -0.5 * SPEED, operation)]
        modal = modal_loads(SYSTEM, LOADS)._replace(push=np.zeros((4, 6)))
        found = follow_profile(SYSTEM, modal, profile, angle=0.2, before=operation, longest=0.01)
        return np.concatenate([segment.state for segment in found])

    both, first, second = states(BOTH), states(ONLY_A), states(ONLY_B)
    assert np.max(np.abs(both - first - second)) < 1e-13 * np.max(np.abs(both))


def test_histories_hold_the_peaks_in_their_buckets() -> None:
    edges = plain().history.time
    assert np.all(np.isfinite(plain().history.low)) and np.all(
        plain().history.low <= plain().history.high
    )
    extreme = np.maximum(np.abs(plain().history.low), np.abs(plain().history.high))
    top = np.max(extreme, axis=0)
    assert np.all(top <= plain().peaks.value + plain().peaks.error)
    assert np.all(top >= 0.98 * plain().peaks.value)
    assert edges[0] == 0.0 and edges[-1] == pytest.approx(0.7)
    assert plain().history.speed[0] == SPEED and plain().history.speed[-1] == -SPEED
    kinetic = columns().kinetic
    assert np.all(plain().history.low[:, kinetic:] >= 0.0)


@given(st.floats(-400.0, 400.0), st.floats(-400.0, 400.0), st.floats(1e-3, 5.0))
@example(-1.0, 1.8284668242094822e-214, 3.34375)
@example(1e-320, -1.0, 3.34375)
@settings(max_examples=40, deadline=None)
def test_grid_is_fine_enough_everywhere(start: float, end: float, duration: float) -> None:
    modal = modal_loads(SYSTEM, LOADS)
    for piece in runs_of([SpeedSegment(duration, start, end, BOTH)], 0.0):
        grid = panel_grid(SYSTEM, modal, piece, duration / 50)
        assert grid[0] == 0.0 and grid[-1] == piece.duration and np.all(np.diff(grid) > 0.0)
        fastest = np.maximum(np.abs(piece.speed_at(grid[:-1])), np.abs(piece.speed_at(grid[1:])))
        phase = np.diff(grid) * (12.0 * np.minimum(fastest, np.inf))
        turned = 12.0 * np.abs(np.diff(piece.angle_at(grid)))
        assert np.all(turned + np.diff(grid) * np.max(SYSTEM.frequency) <= PANEL_PHASE + 1e-9)
        # within a panel the speed changes little against what it turns
        assert np.all(phase <= 2.0 * PANEL_PHASE)
        assert np.all(np.diff(grid) <= duration / 50 * (1.0 + 1e-12))


NAMES = ("kinetic_energy_peak", "translation_peak", "ground_force_peak", "settle_time",
         "kinetic_energy_high", "translation_high", "translation_low")  # fmt: skip
WANTED = (
    f"{STEM}/steady_energy",
    f"{STEM}/instant/worst_kinetic_energy_peak",
    *(f"{STEM}/{way}/{name}" for way in ("instant", "reversal") for name in NAMES),
)


@cache
def with_orders(orders: int | None) -> Record:
    table = switching(after="1 s")
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
    assert "more help ([excitation] orders)" in (tolerance_warning(few, 1e-9) or "")
    assert "undamped" not in (tolerance_warning(few, 1e-9) or "")


def test_no_peak_is_below_the_steady_motion_after_it_and_a_short_watch_is_reported() -> None:
    paths = (f"{STEM}/steady_energy", *(f"{STEM}/instant/{name}" for name in (
        "kinetic_energy_peak", "peak_time", "peak_speed", "translation_peak")))  # fmt: skip
    short, long = (run(switching(after=after), *paths) for after in ("1 ms", "1 s"))
    peaks, steady = short[f"{STEM}/instant/kinetic_energy_peak"], short[f"{STEM}/steady_energy"]
    assert np.all(peaks.values >= steady.values[::-1])
    assert peaks.values[0] == steady.values[1] < long[peaks.path].values[0]
    assert short[f"{STEM}/instant/peak_time"].values[0] == pytest.approx(1e-3, rel=1e-12)
    (reported,) = [words for words in short.warnings if "before the body has settled" in words]
    assert (
        "A+B to A at once settles in 0.645 s" in reported
        and "kinetic energy (up to 1.8" in reported
    )
    assert not any("before the body has settled" in words for words in long.warnings)


def test_samples_do_not_move_with_the_steps_inside() -> None:
    """More orders make finer steps; the samples change by the orders alone."""
    system = compressor()
    profile = [SpeedSegment(0.2, SPEED, 0.0, 0), SpeedSegment(0.1, -0.0, -SPEED, ONLY_A)]
    few, many = (
        follow(system, compressor_loads(10)._replace(retained=kept), profile, buckets=40)
        if kept
        else follow(system, compressor_loads(24), profile, buckets=40)
        for kept in (6, None)
    )
    assert few.history.samples == many.history.samples > 1
    uncertainty = few.peaks.error + many.peaks.error
    for ours, other in zip(few.history[2:4], many.history[2:4], strict=True):
        assert np.all(np.abs(ours - other) <= uncertainty + 1e-12 * many.peaks.value)
