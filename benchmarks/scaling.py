"""How cost grows with what an engineer makes larger, and what a large sweep takes.

CPU time over sizes in steps of two, exponents by least squares of log time on log size with their
standard errors. Beside each stands the time of the operations that no way can leave out, at the
rates that numpy reaches on this machine. A whole sweep is split into the work of the processes
(in parallel) and that of the one that hands out, stores and joins (in series), merging apart; from
these rates a thousand million points are put on paper. `--picture FILE` also draws time against
size.
"""

import math
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import sizes
from impact import CLEARANCE, DAMPING, LENGTH, MASS, RADIUS, SPEED, STIFFNESS, gas_force
from machine_peaks import peaks
from rows import Report, Table, digits, reported, seconds
from timing import Work, each_of

import vibecalc
from vibecalc.core.study.sweep.assemble import merge
from vibecalc.impact.linkage import Joint, Linkage, Starts, slider_crank_drive
from vibecalc.impact.simulate import simulate
from vibecalc.torsion.forced import forced

#: points of the sweeps that are run whole, and the cores of the clusters on paper
WHOLE = (8192, 16384, 32768, 65536)
CORES = (2, 64, 1000, 10_000)
MANY = 1e9
#: cores of one part on paper: with more the process that stores would be late
BESIDE = 16

#: one station of a shaft line at one frequency: elimination and back substitution
STATION = {"complex reciprocal": 1.0, "complex product": 4.0, "complex sum": 3.0}


class Growth(NamedTuple):
    """What grows; the work at a size; least operations for one of it; exponent of theory."""

    what: str
    unit: str
    sizes: tuple[int, ...]
    work: Callable[[int], Work]
    least: Mapping[str, float]
    theory: float = 1.0


def doubling(first: int, count: int) -> tuple[int, ...]:
    """Sizes in steps of two."""
    return tuple(first * 2**k for k in range(count))


def times(number: float, operations: Mapping[str, float]) -> dict[str, float]:
    """So many of some operations."""
    return {name: number * each for name, each in operations.items()}


def forced_by_orders(orders: int) -> Work:
    """7 inertias, one torque, 200 speeds."""
    line = sizes.row_of(7)
    w = np.linspace(20.0, 300.0, 200)[:, None] * np.arange(1, orders + 1)
    torque = np.ones((orders, 1), dtype=complex)
    return lambda: forced(line, w, torque, stations=[0])


def impacts_by_runs(runs: int) -> Work:
    """One turn of the compressor of `impact.py` with play, runs side by side in one batch."""
    joint = Joint(CLEARANCE, STIFFNESS, DAMPING, DAMPING)
    linkage = Linkage(slider_crank_drive(RADIUS, LENGTH, SPEED), gas_force(), MASS, joint)
    gap = 1e-8 * np.random.default_rng(3).random((runs, 1))
    return lambda: simulate(linkage, Starts(gap, 0.0 * gap), 1, 100)


def transform(samples: int) -> dict[str, float]:
    """One Fourier transform."""
    return {"transform of m, over m log2 m": samples * math.log2(samples)}


GROWTHS = (
    Growth("forced response of an engine, 20 orders, 200 speeds", "cylinders", doubling(3, 5),
           sizes.engine_by_cylinders, times(4000, STATION)),
    Growth("forced response, 300 frequencies", "stations", doubling(50, 5),
           sizes.forced_by_stations, times(300, STATION)),
    Growth("forced response, 7 inertias, 200 speeds", "orders", doubling(5, 6),
           forced_by_orders, times(7 * 200, STATION)),
    Growth("forced response, 7 inertias, 10 orders, by blocks", "speeds", doubling(256, 5),
           sizes.forced_by_blocks, times(70, STATION)),
    Growth("peak over the cycle of 10 signals", "harmonics", doubling(32, 6),
           sizes.peaks_by_orders, times(10.0 / 32.0, transform(16 * 32))),
    Growth("impacts in a joint, one turn", "runs", doubling(60, 5), impacts_by_runs,
           # 220 steps: series of 22 terms, drive of 10 harmonics, four Newton steps at each event
           times(220, {"real product": 320.0, "real sum": 280.0})),
    Growth("sweep by arrays, peaks of force and couple", "points", doubling(1000, 6),
           sizes.sweep_points, times(2, transform(128))),
)  # fmt: skip


class Fit(NamedTuple):
    """Seconds at each size, and the exponent with its standard error."""

    spent: list[float]
    exponent: float
    uncertainty: float


def fit(numbers: tuple[int, ...], spent: list[float]) -> Fit:
    """Straight line through the logarithms, the smallest size left out."""
    x, y = np.log(numbers[1:]), np.log(spent[1:])
    (slope, offset), rest = np.polyfit(x, y, 1), 0.0
    rest = float(np.sum((y - slope * x - offset) ** 2)) / max(len(x) - 2, 1)
    return Fit(spent, float(slope), math.sqrt(rest / float(np.sum((x - np.mean(x)) ** 2))))


@cache
def fits() -> dict[str, Fit]:
    """Every growth measured once."""
    found = {}
    for one in GROWTHS:
        spent = [each_of(one.work(size), repeats=5) for size in one.sizes]
        found[one.what] = fit(one.sizes, spent)
    return found


def growth_rows() -> list[list[str]]:
    """The table of exponents."""
    rates, rows = peaks(), []
    for one in GROWTHS:
        found, last = fits()[one.what], one.sizes[-1]
        least = last * sum(rates[name] * count for name, count in one.least.items())
        rows.append(
            [
                one.what, f"{one.sizes[0]} to {last} {one.unit}",
                f"{seconds(found.spent[0])} to {seconds(found.spent[-1])}",
                seconds(found.spent[-1] / last), f"{one.theory:g}",
                f"{found.exponent:.2f} +- {found.uncertainty:.2f}", seconds(least / last),
                digits(found.spent[-1] / least),
            ]
        )  # fmt: skip
    return rows


class Split(NamedTuple):
    """CPU seconds of a sweep of some points: of one process in series, of those in parallel."""

    series: float
    parallel: float
    merging: float
    size: float


def whole_sweep(points: int) -> Split:
    """The sweep of `sizes.sweep_points` by two processes, as a user runs it, and its merging."""
    key = "machine.crank_train.rod_length"
    step = 0.15 / (points - 1)
    axis = {key: f"0.15:{0.15 + step * (points - 1)}:{points}"}
    keep = ["excitation/force_peak", "excitation/couple_peak"]
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "sweep.h5"
        children, own = children_seconds(), time.process_time()
        vibecalc.sweep(sizes.CASES / "generator.toml", output, grid=axis, keep=keep, jobs=2)
        series, parallel = time.process_time() - own, children_seconds() - children
        own = time.process_time()
        merge([output], Path(folder) / "merged.h5")
        merging = time.process_time() - own
        return Split(series, parallel, merging, float(output.stat().st_size))


def children_seconds() -> float:
    """CPU seconds of processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Rates(NamedTuple):
    """Of one point: seconds in parallel, in series, of merging, bytes; and of the beginning."""

    parallel: float
    series: float
    merging: float
    size: float
    beginning: float


@cache
def rates_of_sweep() -> Rates:
    """Straight lines through the splits, whose slopes are the rates."""
    whole_sweep(64)  # modules and what is made once
    splits = np.array([whole_sweep(points) for points in WHOLE])
    slope, offset = np.polyfit(np.array(WHOLE, dtype=float), splits, 1)
    series, parallel, merging, size = slope.tolist()
    # both processes begin anew
    return Rates(parallel, series, merging, size, float(offset[0] + 0.5 * offset[1]))


def paper_rows() -> list[list[str]]:
    """A thousand million points on clusters, from the rates."""
    one, rows = rates_of_sweep(), []
    for cores in CORES:
        parts = max(1, cores // BESIDE)
        computing, storing = MANY * one.parallel / cores, MANY * one.series / parts
        # storing goes on beside computing, but for joining, about half of it
        elapsed = max(computing, 0.5 * storing) + 0.5 * storing
        merging = MANY * one.merging if parts > 1 else 0.0
        rows.append(
            [
                f"{cores}", f"{parts}", hours(computing), hours(elapsed), hours(merging),
                hours(elapsed + merging), f"{MANY * one.size / 1e9:.0f} GB",
                f"{100.0 * computing / (elapsed + merging):.0f} %",
            ]
        )  # fmt: skip
    return rows


def hours(spent: float) -> str:
    """A time in hours."""
    return f"{spent / 3600.0:.3g} h"


def workers_row() -> list[list[str]]:
    """How much less time 2, 4 ... processes take for 1e6 points, each on a core of its own."""
    one = rates_of_sweep()
    series, parallel = one.beginning + 1e6 * one.series, 1e6 * one.parallel
    return [
        [
            f"{n}",
            seconds(series + parallel / n),
            f"{(series + parallel) / (series + parallel / n):.2f}",
        ]
        for n in (1, 2, 4, 8, 16, 64)
    ]


def measure() -> Report:
    """All tables."""
    one = rates_of_sweep()
    parts = [
        ["computing a point, in parallel", seconds(one.parallel)],
        ["handing out, storing and joining a point, in series", seconds(one.series)],
        ["merging a point, in series", seconds(one.merging)],
        ["beginning", seconds(one.beginning)],
        ["bytes of a point in the file", f"{one.size:.1f}"],
        [
            "values, errors, status, number and key alone",
            f"{2 * (3 + 1) * 8 + 1 + 2 * 8}",
        ],
    ]
    grown = [
        "what",
        "sizes",
        "CPU time",
        "for one",
        "theory",
        "fitted",
        "least for one",
        "times it",
    ]
    paper = ["cores", "parts", "computing", "with storing", "merging", "in all", "written", "busy"]
    return Report(
        "How cost grows",
        "Exponents are fitted without the smallest size, with their standard error. The least is "
        "the time of the operations that cannot be left out, at numpy's best rates here.",
        tables=[
            Table("Cost against size", grown, growth_rows()),
            Table("CPU time of a sweep, two quantities of each point", ["what", "each"], parts),
            Table("1e6 points on free cores", ["processes", "elapsed", "gain"], workers_row()),
            Table("1e9 points on paper, a part for each 16 cores", paper, paper_rows()),
        ],
    )


def draw(path: Path) -> None:
    """CPU time against size, each in parts of its largest size."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.3, 3.8), layout="constrained")
    for one, marker in zip(GROWTHS, "osD^vP*", strict=True):
        found = fits()[one.what]
        label = f"{one.unit}: {found.exponent:.2f} ± {found.uncertainty:.2f}"
        axes.loglog(one.sizes, found.spent, marker=marker, markersize=4, linewidth=1, label=label)
    axes.set(xlabel="size", ylabel="CPU time, s")
    axes.grid(visible=True, which="major", linewidth=0.3)
    axes.legend(title="grows with: exponent", fontsize=7, title_fontsize=7)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    if "--picture" in sys.argv:
        at = sys.argv.index("--picture")
        draw(Path(sys.argv[at + 1]))
        del sys.argv[at : at + 2]
    reported(measure)
