"""Cost against size: CPU time, peak memory, and exponents fitted to both next to those of theory.

The exponent of time is fitted to the four largest sizes (least squares of log time on log size),
where what every call costs matters least; memory is the peak that numpy and Python ask for during
one call (tracemalloc), output included, fitted in the same way. A fitted exponent below theory says
that fixed costs still count.
"""

import os
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from roll_machines import FIRST_MASS, SECOND_MASS, SYNCHRONOUS, source_drive, source_machine
from rows import Report, Table, digits, reported, seconds
from timing import Work, each_of

from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.design import make_design
from vibecalc.core.study.sweep.evaluate import ArrayEvaluator
from vibecalc.excitation.inertia_forces import reciprocating_excitation
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.synthesis import synthesis
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.steady import steady_state
from vibecalc.torsion.forced import forced
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.modes import natural_modes

CASES = Path(__file__).resolve().parents[1] / "cases"
#: sizes whose call takes longer than this are measured once
LONG = 0.3
#: so many of the largest sizes make the exponents
KEPT = 4


class Scaling(NamedTuple):
    """What grows, its sizes, the exponents of theory (time, memory), and the work at a size."""

    what: str
    unit: str
    sizes: tuple[int, ...]
    theory: tuple[str, str]
    work: Callable[[int], Work]


def row_of(stations: int) -> Line:
    """A shaft line with dashpots in its shafts."""
    generator = np.random.default_rng(stations)
    line = chain(1.0 + generator.random(stations), 1e6 * (1.0 + generator.random(stations - 1)))
    return line._replace(damping=1e-5 * line.stiffness)


def modes_by_stations(stations: int) -> Work:
    """All frequencies and shapes."""
    line = row_of(stations)
    return lambda: natural_modes(line)


def forced_by_stations(stations: int) -> Work:
    """300 frequencies, one driven station."""
    line, w = row_of(stations), np.linspace(20.0, 3000.0, 300)
    return lambda: forced(line, w, np.ones((300, 1), dtype=complex), stations=[0])


def forced_in_a_ring(stations: int) -> Work:
    """The line closed to a loop, solved dense at 20 frequencies."""
    line = row_of(stations)
    ring = line._replace(
        first=np.append(line.first, stations - 1), second=np.append(line.second, 0),
        stiffness=np.append(line.stiffness, 1e6), damping=np.append(line.damping, 10.0),
        loss_factor=np.append(line.loss_factor, 0.0),
    )  # fmt: skip
    w = np.linspace(20.0, 3000.0, 20)
    return lambda: forced(ring, w, np.ones((20, 1), dtype=complex), stations=[0])


def forced_by_speeds(count: int) -> Work:
    """7 inertias, ten orders of one torque, all speeds in one call."""
    line, w = row_of(7), np.linspace(20.0, 300.0, count)[:, None] * np.arange(1, 11)
    return lambda: forced(line, w, np.ones((10, 1), dtype=complex), stations=[0])


def forced_by_blocks(count: int) -> Work:
    """The same as a run does it: blocks of 64 speeds, of which only the largest angle is kept."""
    line, speed, torque = (
        row_of(7),
        np.linspace(20.0, 300.0, count),
        np.ones((10, 1), dtype=complex),
    )
    starts = range(0, count, 64)

    def largest(start: int) -> float:
        w = speed[start : start + 64, None] * np.arange(1, 11)
        return float(np.max(np.abs(forced(line, w, torque, stations=[0]).angle)))

    return lambda: max(largest(start) for start in starts)


def shaking(cylinders: int) -> Work:
    """Forces and couples of 20 orders."""
    motion, place = motion_harmonics(0.3, 20), np.arange(cylinders)
    return lambda: reciprocating_excitation(
        motion, crank_radius=0.06, reciprocating_mass=np.full(cylinders, 0.4),
        crank_phase=1.1 * place, bank_angle=0.0 * place, position=0.1 * place,
        origin=np.zeros(3), axis=np.eye(3)[0], stroke=np.eye(3)[2], across=np.eye(3)[1],
    )  # fmt: skip


def engine_by_cylinders(cylinders: int) -> Work:
    """A crankshaft with its flywheel, every throw driven, 20 orders at 200 speeds."""
    line = row_of(cylinders + 1)
    w = np.linspace(20.0, 300.0, 200)[:, None] * np.arange(1, 21)
    torque = np.ones((20, cylinders), dtype=complex)
    return lambda: forced(line, w, torque, stations=list(range(cylinders)))


def sweep_points(count: int) -> Work:
    """`vibecalc sweep` by arrays over rod lengths of the generator, largest force kept."""
    (loaded,) = load_checked([CASES / "generator.toml"])
    key = "machine.crank_train.rod_length"
    axis = {"key": key, "from": "0.15 m", "to": "0.3 m", "points": count}
    design = make_design(Sweep.model_validate({"axes": [axis]}), loaded.resolved)
    keep = ("excitation/force_peak", "excitation/couple_peak")
    # a sweep hands out its points in chunks
    chunks = [np.arange(k, min(k + 1000, count)) for k in range(0, count, 1000)]
    evaluator = ArrayEvaluator(loaded, design, keep)
    return lambda: [evaluator(chunk) for chunk in chunks]


def roll_by_panels(panels: int) -> Work:
    """Running state with four points on each panel."""
    machine, drive = as_batch(source_machine()), source_drive()
    width = 2.0 * np.pi / panels
    return lambda: steady_state(
        machine, drive, 4, started_at=SYNCHRONOUS, tolerance=1e-9, widest=width
    )


def roll_by_machines(count: int) -> Work:
    """Running states of machines with different rods, in one batch."""
    masses = np.tile([FIRST_MASS, SECOND_MASS], (count, 1))
    rods = np.linspace(0.2, 0.6, count)
    machine, drive = source_machine(rod_length=rods, reciprocating_mass=masses), source_drive()
    return lambda: steady_state(machine, drive, 6, started_at=SYNCHRONOUS, tolerance=1e-11)


def tunings(count: int) -> Work:
    """Best springs and dampers for so many masses."""
    mass = np.geomspace(0.01, 1.0, count)
    return lambda: minimax(0.1, mass)


def signals(orders: int) -> np.ndarray:
    """Ten of random harmonics."""
    generator = np.random.default_rng(orders)
    return generator.normal(size=(10, orders)) + 1j * generator.normal(size=(10, orders))


def peaks_by_orders(orders: int) -> Work:
    """Exact peaks over the cycle."""
    some, order = signals(orders), np.arange(1, orders + 1)
    return lambda: cycle_peak(some, order)


def ranges_by_orders(orders: int) -> Work:
    """Highest and lowest value over the cycle."""
    some, order = signals(orders), np.arange(1, orders + 1)
    return lambda: synthesis(order, some)


def by_decades(first: int, last: int) -> tuple[int, ...]:
    """Sizes 1, 2, 5, 10 ... between two."""
    every = (digit * 10**power for power in range(6) for digit in (1, 2, 5))
    return tuple(size for size in every if first <= size <= last)


STATIONS = (7, 14, 25, 50, 100, 200, 400, 800)
SCALINGS = (
    Scaling("modes of a shaft line, with shapes", "stations", STATIONS, ("2", "2"),
            modes_by_stations),
    Scaling("forced response, 300 frequencies", "stations", STATIONS, ("1", "1"),
            forced_by_stations),
    Scaling("forced response of a closed loop, 20 frequencies", "stations",
            (7, 14, 25, 50, 100, 200), ("3", "2, less by blocks"), forced_in_a_ring),
    Scaling("forced response, 7 inertias, 10 orders", "speeds", by_decades(10, 50_000),
            ("1", "1"), forced_by_speeds),
    Scaling("the same by blocks of 64 speeds", "speeds", by_decades(500, 10_000), ("1", "0"),
            forced_by_blocks),
    Scaling("exact harmonics of the motion, R/L = 0.9", "harmonics", by_decades(10, 1000),
            ("1", "1"), lambda n: lambda: motion_harmonics(0.9, n)),
    Scaling("peak over the cycle of 10 signals", "harmonics", by_decades(10, 1000),
            ("1 and a logarithm", "1"), peaks_by_orders),
    Scaling("half ranges of 10 signals", "harmonics", by_decades(10, 1000),
            ("1 and a logarithm", "2, of a table that is kept"), ranges_by_orders),
    Scaling("shaking forces, 20 orders", "cylinders", (1, 2, 3, 4, 6, 8, 12, 24), ("1", "1"),
            shaking),
    Scaling("forced response of an engine, 20 orders, 200 speeds", "cylinders",
            (1, 2, 3, 4, 6, 8, 12, 24), ("1", "1"), engine_by_cylinders),
    Scaling("sweep by arrays, peaks of force and couple", "points", by_decades(10, 100_000),
            ("1", "0: points in chunks"), sweep_points),
    Scaling("running state of a roll, 4 points on a panel", "panels", (36, 72, 144, 288, 576),
            ("1", "1"), roll_by_panels),
    Scaling("running states of rolls in one batch", "machines", by_decades(1, 200),
            ("1", "1"), roll_by_machines),
    Scaling("tunings of absorbers in one batch", "tunings", by_decades(1, 5000), ("1", "1"),
            tunings),
)  # fmt: skip


def peak_memory(work: Work) -> float:
    """Bytes asked for at the worst moment of one call."""
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return float(peak)


def fitted(sizes: tuple[int, ...], numbers: list[float]) -> float:
    """Exponent over the largest sizes."""
    return float(np.polyfit(np.log(sizes[-KEPT:]), np.log(numbers[-KEPT:]), 1)[0])


def line_of(scaling: Scaling) -> list[str]:
    """Times and memory of one scaling as text."""
    spent, memory = [], []
    for size in scaling.sizes:
        work = scaling.work(size)
        # each_of warms up by its first call
        spent.append(each_of(work, repeats=1 if spent and spent[-1] > LONG else 3))
        memory.append(peak_memory(work))
    sizes = scaling.sizes
    return [
        scaling.what, f"{sizes[0]} to {sizes[-1]} {scaling.unit}",
        f"{seconds(spent[0])} to {seconds(spent[-1])}", scaling.theory[0],
        f"{fitted(sizes, spent):.2f}",
        f"{digits(memory[0] / 2**20)} to {digits(memory[-1] / 2**20)} MiB", scaling.theory[1],
        f"{fitted(sizes, memory):.2f}",
    ]  # fmt: skip


def measure() -> Report:
    """All scalings."""
    columns = [
        "what", "sizes", "CPU time", "exponent of theory", "fitted",
        "peak memory", "exponent of theory", "fitted",
    ]  # fmt: skip
    table = Table("Exponents", columns, [line_of(one) for one in SCALINGS])
    return Report(
        "Cost against size",
        "Exponents are fitted to the four largest sizes; one below theory says that what each "
        "call costs still counts. Memory is what one call asks for at its worst moment, "
        "with what it returns.",
        tables=[table],
    )


if __name__ == "__main__":
    reported(measure)
