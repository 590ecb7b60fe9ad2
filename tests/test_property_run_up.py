"""Claim: what a run-up finds from few speeds is what it finds from many, and no more is computed.

Machines are random, some with light damping; the truth is the peak of a curve that was drawn
finely. Looks about a turn of a roll machine, smooth or with jumps, are held against dense samples.
"""

from collections.abc import Callable

import numpy as np
import pytest
from isolation_machines import random_body, shows
from random_machines import random_machine, without_damping
from shipped_cases import result_of

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.isolation.at_mounts import mount_readout
from vibecalc.isolation.rows import HarmonicsAt, Jet, body_rows
from vibecalc.isolation.run_up import Range, RunUp, cycle_peaks, run_up, run_up_peak
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.matrices import assemble, displacement_at
from vibecalc.response.modes import modes
from vibecalc.response.system import MountedBody
from vibecalc.roll.turn import peak

FULL = 2.0 * np.pi


class Counted:
    """Rows that count the speeds they are asked for."""

    def __init__(self, rows: HarmonicsAt) -> None:
        self.rows, self.asked = rows, 0

    def __call__(self, speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        self.asked += len(speed)
        return self.rows(speed, slopes, errors)


def drawn(seed: int, light: float) -> Range:
    """What a run-up of a random body takes: rows, orders, resonances, range, rows that are seen."""
    body = random_body(seed)
    position, stiffness, damping, structural = body.mounts
    mounts = (position, stiffness, light * damping, light * structural)
    matrices = assemble(body.mass_matrix, *mounts)
    generator = np.random.default_rng(seed + 77)
    orders = np.unique(generator.integers(1, 13, size=generator.integers(1, 9)))
    value = generator.normal(size=(len(orders), 6)) + 0j
    value *= np.exp(-generator.uniform(0.0, 1.5) * (orders - 1))[:, None]
    load = Bounded(value, 1e-16 * np.abs(value))
    shapes, readout = modes(matrices), mount_readout(displacement_at(mounts[0]), *mounts[1:])
    own = shapes.natural_frequency
    stop = float(generator.choice([3.0 * own[-1], own[-1] / orders[0], own[2], 1.2 * own[0]]))
    start = float(generator.choice([0.0, 0.0, 0.3, 0.9])) * stop
    rows = Counted(body_rows(matrices, readout, orders, load))
    resonances = MountedBody(matrices=matrices, shapes=shapes).resonances(load)
    return Range(rows, orders, resonances, start, stop, shows(readout, shapes.shape, own))


def passed(seed: int, light: float, tolerance: float) -> tuple[RunUp, RunUpPeak, int, int]:
    """A random run-up: with its curve, its peaks alone, and the speeds that each took."""
    given = drawn(seed, light)
    whole = run_up(given, tolerance)
    first = given.harmonics_at.asked
    alone = run_up_peak(given)
    return whole, alone, first, given.harmonics_at.asked - first


def check(seeds: range, light: float) -> tuple[float, float]:
    """Mean speeds with the curve and alone."""
    counts = []
    for seed in seeds:
        whole, alone, *count = passed(seed, light, 1e-3)
        counts.append(count)
        finite = np.isfinite(whole.peak.value)
        assert np.array_equal(finite, np.isfinite(alone.value))
        allowed = 1e-10 * whole.peak.value[finite] + whole.peak.error[finite]
        assert np.all(np.abs(alone.value - whole.peak.value)[finite] <= allowed), seed
        top = whole.curve.value.max(axis=0)[finite]
        assert np.all(top <= whole.peak.value[finite] + allowed), seed
        # but for climbs, and for orders left out, every speed was computed once
        assert count[0] < len(whole.speed) + 500
    return tuple(np.mean(counts, axis=0))


@pytest.mark.parametrize("light", [pytest.param(1.0, marks=pytest.mark.long), 1e-3])
def test_peaks_alone_are_those_of_the_curve(light: float) -> None:
    curve, alone = check(range(6), light)
    assert alone < 0.5 * curve


def test_branches_that_cross_and_ends_that_hide_a_peak() -> None:
    """Machines of a search whose peaks lay on another branch, on a ridge, or next to an end.

    The last two have two peaks that a kink parts.
    """
    for seed in (500, 705, 3432, 7335, 53590, 52738):
        check(range(seed, seed + 1), 1.0)
    check(range(52908, 52909), 8.0)


@pytest.mark.long
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("light", [8.0, 1.0, 1e-3])
def test_peaks_of_many_machines(light: float) -> None:
    check(range(7000, 7400), light)


@pytest.mark.long
@pytest.mark.parametrize("seed", [3, 8])
def test_a_dense_sweep_shows_the_same_in_blocks_of_any_size(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = drawn(seed, 1.0)
    rows, orders, _, start, stop, _ = given
    whole = run_up(given)
    highest = whole.peak.value
    near = [speed * (1.0 + np.linspace(-0.01, 0.01, 101)) for speed in whole.peak.speed]
    sweep = np.concatenate([np.linspace(start, stop, 3000), *near])
    sweep = sweep[(sweep >= start) & (sweep <= stop)]
    monkeypatch.setattr("vibecalc.isolation.run_up_samples.MOST_AT_ONCE", 40)
    top = np.max(cycle_peaks(rows, orders, sweep).value, axis=0)
    assert np.all(top <= highest * (1.0 + 1e-12) + whole.peak.error)
    assert top == pytest.approx(highest, rel=1e-5)
    between = 0.7 * whole.speed[1:] + 0.3 * whole.speed[:-1]
    line = 0.7 * whole.curve.value[1:] + 0.3 * whole.curve.value[:-1]
    # the test of midpoints sees a grid of angles, which is good to some 4e-4
    assert np.all(np.abs(cycle_peaks(rows, orders, between).value - line) <= 2e-3 * highest)
    again = run_up(given)
    assert again.peak.value == pytest.approx(highest, rel=1e-12)
    assert again.peak.speed == pytest.approx(whole.peak.speed, rel=1e-11)


def wave(seed: int, kind: str) -> Callable[[np.ndarray], np.ndarray]:
    """Twenty harmonics, and kinks or jumps at three places."""
    generator = np.random.default_rng(seed)
    size = generator.normal(size=20) * np.exp(-0.3 * np.arange(20))
    phase, place = generator.uniform(0.0, FULL, 20), generator.uniform(0.0, FULL, 3)
    rough = generator.normal(size=3)

    def function(at: np.ndarray) -> np.ndarray:
        values = np.cos(np.outer(at, np.arange(1, 21)) + phase) @ size
        if kind == "kinks":
            values += np.abs(np.sin(0.5 * (at[:, None] - place))) @ rough
        if kind == "jumps":
            values += 0.1 * (np.mod(at[:, None] - place, FULL) < 2.0) @ rough
        return np.asarray(values)

    return function


@pytest.mark.parametrize(
    ("kind", "looks", "close"),
    [
        pytest.param("smooth", 60, 1e-14, marks=pytest.mark.long),
        ("kinks", 250, 1e-12),
        ("jumps", 600, 1e-6),
    ],
)
def test_peak_of_a_turn_is_no_lower_than_dense_samples(kind: str, looks: int, close: float) -> None:
    dense = np.linspace(0.0, FULL, 40_001)
    for seed in range(5):
        function, count = wave(seed, kind), [0]

        def counted(at: np.ndarray, function=function, count=count) -> np.ndarray:
            assert np.all(np.diff(at) >= 0.0) and at[0] >= 0.0 and at[-1] < FULL
            count[0] += len(at)
            return function(at)

        top, left = peak(counted)
        values = function(dense)
        best = dense[np.argmax(values)] + (dense[1] - dense[0]) * np.linspace(-1.0, 1.0, 4001)
        highest = max(float(values.max()), float(function(best).max()))
        assert top >= highest - close * abs(highest)
        assert top <= highest + 1e-6 * abs(highest) if kind != "jumps" else True
        assert left <= 1e-9 * abs(top)
        assert count[0] <= 720 + looks


def test_undamped_resonances_that_are_met_to_the_last_bit_are_masked() -> None:
    """Resonances moved by damping stand where they were when there is none."""
    table = without_damping(random_machine(101, "rigid_body"))
    record = run_case(validate(table))
    centres = record["isolation/masked/centre"].values
    assert len(centres) > 4 and np.all(np.isfinite(record["isolation/support_force/run_up"].values))


def places_of(name: str, orders: int) -> dict[str, tuple[np.ndarray, float, np.ndarray, float]]:
    """Of each maximum over the run-up: speeds with their error, heights with theirs."""
    record = result_of(name, f"excitation.orders={orders}").record
    found = {}
    for path in record:
        if path.endswith(("run_up_peak_speed", "largest_speed", "travel_speed")):
            place, height = record[path], record[path.removesuffix("_speed")]
            found[path] = (place.values, place.error_estimate, height.values, height.error_estimate)
    return found


@pytest.mark.parametrize(
    ("name", "few"),
    [("genset_skid", 2), pytest.param("genset_skid", 6, marks=pytest.mark.long),
     pytest.param("genset_points", 6, marks=pytest.mark.long)],
)  # fmt: skip
def test_orders_left_out_move_no_maximum_out_of_its_error(name: str, few: int) -> None:
    """Highest places may move to another resonance; where all orders are kept they are known."""
    whole, part = places_of(name, 24), places_of(name, few)
    assert len(part) >= 2
    for path, (place, off, height, height_off) in part.items():
        true, more, high, high_more = whole[path]
        assert np.all(np.abs(place - true) <= off + more), path
        assert np.all(np.abs(height - high) <= height_off + high_more), path
        if "rms" in path:
            assert more < 1e-5
