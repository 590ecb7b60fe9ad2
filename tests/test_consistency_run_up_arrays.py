"""Claim: run-ups of many machines at once have the peaks that each has by itself.

Machines are random, with close modes, light and heavy damping, peaks at an end of the range, and
resonances below it. By itself each is solved exactly at every speed, many at once are looked at by
their poles first. The peaks of a machine do not depend on those next to it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from isolation_machines import gibson_body, random_body, shows

from vibecalc.isolation.at_mounts import mount_readout
from vibecalc.isolation.rows import Readout, body_rows
from vibecalc.isolation.run_up import Range, run_up_peak
from vibecalc.isolation.run_up_peaks import RunUpPeak
from vibecalc.isolation.run_up_poles import peaks_of_bodies
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.parts.matrices import assemble, displacement_at
from vibecalc.response.modes import Modes, modes
from vibecalc.response.system import MountedBody


class Drawn(NamedTuple):
    """Machines of one first axis, and the range of speeds they pass."""

    matrices: Linear
    shapes: Modes
    readout: Readout
    orders: np.ndarray
    load: Bounded
    start: float
    stop: float


def together(
    bodies: Sequence[tuple[np.ndarray, ...]], masses: list[np.ndarray]
) -> tuple[Linear, Modes, Readout]:
    """Matrices, modes and readout of machines side by side."""
    parts = [assemble(mass, *mounts) for mass, mounts in zip(masses, bodies, strict=True)]
    matrices = Linear(*(np.stack(part) for part in zip(*parts, strict=True)))
    read = [mount_readout(displacement_at(at), *held) for at, *held in bodies]
    readout = Readout(
        np.stack([one.still for one in read]),
        np.stack([one.rising for one in read]),
        read[0].uncertainty,
    )
    return matrices, modes(matrices), readout


def drawn(seed: int, count: int) -> Drawn:
    """Random bodies on as many mounts each, under random forces of the same orders."""
    generator = np.random.default_rng(9000 + seed)
    supports = int(generator.integers(3, 8))
    light = float(generator.choice([8.0, 1.0, 0.1, 1e-3]))
    orders = np.unique(generator.integers(1, 13, size=generator.integers(1, 9)))
    bodies: list[tuple[np.ndarray, ...]] = []
    masses, number = [], 1000 * seed
    while len(bodies) < count:
        body, number = random_body(number), number + 1
        position, stiffness, damping, structural = body.mounts
        if len(position) == supports:
            bodies.append((position, stiffness, light * damping, light * structural))
            masses.append(body.mass_matrix)
    matrices, shapes, readout = together(bodies, masses)
    value = generator.normal(size=(count, len(orders), 6)) + 0j
    value *= np.exp(-generator.uniform(0.0, 1.5) * (orders - 1))[:, None]
    load = Bounded(value, 1e-16 * np.abs(value))
    own = np.median(shapes.natural_frequency, axis=0)
    stop = float(generator.choice([3.0 * own[-1], own[-1] / orders[0], own[2], 1.2 * own[0]]))
    start = float(generator.choice([0.0, 0.0, 0.3, 0.9])) * stop
    return Drawn(matrices, shapes, readout, orders, load, start, stop)


def run_ups(given: Drawn, which: slice | list[int] = slice(None)) -> tuple[RunUpPeak, np.ndarray]:
    """Peaks of some of the machines, and which of these are left alone."""
    matrices = Linear(*(part[which] for part in given.matrices))
    shapes = Modes(*(part[which] for part in given.shapes))
    readout = given.readout.rows(which, slice(None))
    load, kept = given.load[which], len(given.orders)
    none, count = np.zeros(0, dtype=int), len(load.value)
    system = MountedBody(matrices=matrices, shapes=shapes)
    return peaks_of_bodies(
        system, readout, load, 0.0, given.orders, kept, none, given.start, given.stop,
        np.zeros(count, dtype=bool),
    )  # fmt: skip


def alone(given: Drawn, number: int) -> RunUpPeak:
    """The peaks of one machine, every speed solved exactly."""
    matrices = Linear(*(part[number] for part in given.matrices))
    shapes, load = Modes(*(part[number] for part in given.shapes)), given.load[number]
    readout = given.readout.rows(number, slice(None))
    body = MountedBody(matrices=matrices, shapes=shapes)
    met = body.with_poles(body.resonances(load), load)
    seen = shows(readout, shapes.shape, shapes.natural_frequency)
    rows = body_rows(matrices, readout, given.orders, load)
    return run_up_peak(Range(rows, given.orders, met, given.start, given.stop, seen))


def check(given: Drawn) -> None:
    found, left = run_ups(given)
    machines = np.flatnonzero(~left)
    assert len(machines)
    for number in machines.tolist():
        one = alone(given, number)
        many = RunUpPeak(*(part[number] for part in found))
        assert np.all(np.abs(many.value - one.value) <= many.error + one.error), number
        assert np.all(np.abs(many.speed - one.speed) <= many.speed_error + one.speed_error), number
        assert np.all(many.error <= 1.5 * one.error), number


@pytest.mark.parametrize("seed", [1, 2, 20])
def test_peaks_of_many_are_those_of_each(seed: int) -> None:
    check(drawn(seed, 6))


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("first", range(100, 160, 10))
def test_peaks_of_a_thousand_machines(first: int) -> None:
    for seed in range(first, first + 10):
        check(drawn(seed, 20))


def of_gibson(damping: list[float]) -> Drawn:
    """The three-cylinder generator, whose modes repeat, with dampers of its mounts."""
    bodies = [gibson_body(one) for one in damping]
    matrices, shapes, readout = together(
        [tuple(body.mounts) for body in bodies], [body.mass_matrix for body in bodies]
    )
    value = np.zeros((len(bodies), 2, 6), dtype=complex)
    value[:, 0, 4], value[:, 1, 2], value[:, 1, 0] = 0.01, 0.003, 0.001j
    load = Bounded(value, 1e-16 * np.abs(value))
    return Drawn(matrices, shapes, readout, np.array([1, 2]), load, 0.0, 500.0)


def test_what_nothing_damps_and_double_poles_are_left_alone() -> None:
    mass, stiffness = 100.0, 1e4
    # of four springs, so that a mode has one pole twice
    critical = float(np.sqrt(4.0 * stiffness * mass)) * 2.0 / 4.0
    given = of_gibson([0.0, 50.0, critical, 300.0])
    _, left = run_ups(given)
    assert left.tolist() == [True, False, True, False]
    check(of_gibson([0.3, 50.0, 300.0, 3000.0]))
