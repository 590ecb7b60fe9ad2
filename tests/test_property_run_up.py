"""Claim: what a run-up finds from few speeds is what it finds from many, and no more is computed.

Machines are random, some with light damping; the truth is the peak of a curve that was drawn
finely. Looks about a turn of a roll machine, smooth or with jumps, are held against dense samples.
"""

import numpy as np
import pytest
from isolation_machines import random_body, shows

from vibecalc.isolation.at_mounts import mount_readout
from vibecalc.isolation.rows import HarmonicsAt, Jet, body_rows
from vibecalc.isolation.run_up import Range, RunUp, run_up, run_up_peak
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.matrices import assemble, displacement_at
from vibecalc.response.modes import modes
from vibecalc.response.system import MountedBody


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
        # but for climbs of each readout, and for orders left out, every speed was computed once
        assert count[0] < len(whole.speed) + 200 * finite.size
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
