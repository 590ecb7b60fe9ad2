"""Main kernels against the best possible: their operations and bytes at the machine's own rates.

For each kernel the operations of its method are counted by hand (or by what it reports) and each
is charged what numpy needs for one of that kind, in the cache, without fresh memory; bytes that
must come from or go to memory are charged at the rate of copying, and the larger of the two
counts. So 1 would be a kernel without any other cost: no error estimate, no test, no copy. Where
one array operation is all there is (solutions, eigenvalues), the library's is the best possible.
"""

import dis
import math
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from machine_peaks import peaks
from roll_machines import FIRST_MASS, SECOND_MASS, SYNCHRONOUS, source_drive, source_machine
from rows import Report, Table, digits, reported, seconds
from timing import Work, each_of, in_turns
from torsion import ORDERS, SPEEDS, engine, hard_line, long_line

from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.kinematics.harmonics import motion_harmonics, series_terms
from vibecalc.numerics import cycle_peak as cycle
from vibecalc.numerics.linear import dynamics, response
from vibecalc.numerics.synthesis import cycle_of, synthesis
from vibecalc.parts.matrices import assemble
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.steady import steady_state
from vibecalc.torsion.forced import forced
from vibecalc.torsion.modes import natural_modes

#: the best possible times this is what calls for a reason
ENOUGH = 2.0


class Kernel(NamedTuple):
    """A kernel: its call, operations by kind, bytes to and from memory, why it is slower.

    With `library` the best possible is that call, over `per`, instead of counted operations.
    """

    name: str
    work: Work
    counts: Mapping[str, float]
    moved: float
    why: str
    library: Work | None = None
    per: int = 1


def torsion_kernels() -> list[Kernel]:
    """Forced response with and without its error estimate, modes, half ranges."""
    from scipy.linalg import eigh_tridiagonal

    line, w, made = engine(), SPEEDS[:, None] * ORDERS, []
    n, shafts = 7, 6
    for driven in (6, 1):
        torque = np.ones((*w.shape, driven), dtype=complex)
        stations = list(range(driven))
        # of each shaft: one sum and reciprocal, two products for its own and one on the way back;
        # a torque that is passed on takes two products and two sums more
        passed = driven - 1
        counts = {
            "complex reciprocal": (shafts + 1.0) * w.size,
            "complex product": (3.0 * shafts + 1.0 + 2.0 * passed) * w.size,
            "complex sum": (2.0 * shafts + 2.0 * passed) * w.size,
            "real product": (2.0 * n + 2.0 * shafts) * w.size,
        }
        moved = 16.0 * (n + driven) * w.size
        for estimate, why in (
            (False, "passes over blocks that are too long for the first cache, and the sizes that "
             "tell whether the elimination may be trusted"),
            (True, "the estimate is formed station by station next to the solution and takes as "
             "many passes as it; it is what the price buys"),
        ):  # fmt: skip
            made.append(
                Kernel(
                    f"forced response, 7 inertias, {driven} driven, {w.size} solves, "
                    f"{'with' if estimate else 'without'} estimate",
                    lambda t=torque, s=stations, e=estimate: forced(  # type: ignore[misc]
                        line, w, t, stations=s, estimate=e
                    ),
                    counts, moved, why,
                )
            )  # fmt: skip
    # a tenth of 1000 speeds: all of them are a gigabyte of angles
    endless, at = long_line(2000), SPEEDS[::25, None] * ORDERS
    push = np.ones((*at.shape, 6), dtype=complex)
    angles = np.ones((2000, at.size), dtype=complex)
    copied = np.zeros_like(angles)
    for estimate in (False, True):
        made.append(
            Kernel(
                f"forced response, 2000 inertias, 6 driven, {at.size} solves, "
                f"{'with' if estimate else 'without'} estimate, against a copy of the angles",
                lambda e=estimate: forced(  # type: ignore[misc]
                    endless, at, push, stations=range(6), estimate=e
                ),
                {}, 0.0,
                "the operations of a station alone take four times a copy of 16 bytes; numbers "
                "leave the first cache from call to call"
                + ("; the estimate takes as much again, and frequencies next to resonances of the "
                   "eliminated part are solved once more with a sharper one" if estimate else ""),
                lambda: np.copyto(copied, angles),
            )
        )  # fmt: skip
    chain = hard_line("graded stiffness")
    scale = 1.0 / np.sqrt(chain.inertia)
    diagonal = np.append(chain.stiffness, 0.0) + np.append(0.0, chain.stiffness)
    nearby = -chain.stiffness * scale[1:] * scale[:-1]
    made.append(
        Kernel(
            "modes of 200 inertias, graded stiffness, against LAPACK's eigh_tridiagonal",
            lambda: natural_modes(chain), {}, 0.0,
            "it keeps every digit of every mode, which LAPACK's way loses (1e-10 on this row)",
            lambda: eigh_tridiagonal(diagonal * scale**2, nearby),
        )
    )  # fmt: skip
    rows, orders = _signals(2000, 24), np.arange(1, 25)
    samples = cycle_of(tuple(orders.tolist())).samples
    each = float(len(rows))
    made.append(
        Kernel(
            "half ranges of 2000 signals of 24 orders",
            lambda: synthesis(orders, rows),
            {
                "transform of m, over m log2 m": each * samples * math.log2(samples),
                "comparison": 2.0 * each * samples,
                # a Taylor polynomial of degree 14 about each of two places, four times Newton
                "complex product": 2.0 * each * 24.0,
                "flop of matrices": 2.0 * each * 2.0 * 48.0 * 15.0,
                "real product": 2.0 * each * 4.0 * 2.0 * 15.0,
                "real sum": 2.0 * each * 4.0 * 2.0 * 15.0,
            },
            0.0,
            "several samples of a signal can be next to its maximum, and each is followed until "
            "it is certain which is the highest",
        )
    )
    return made


def _signals(count: int, orders: int) -> np.ndarray:
    generator = np.random.default_rng(11)
    return generator.normal(size=(count, orders)) + 1j * generator.normal(size=(count, orders))


def closed_form_kernels() -> list[Kernel]:
    """Harmonics, peaks over the cycle, six freedoms."""
    ratios, highest = np.linspace(0.1, 0.6, 1000), 40
    kappa = ratios / (1.0 + np.sqrt(1.0 - ratios**2))
    entries = len(ratios) * (highest // 2 + 1.0)
    terms = float(series_terms(kappa**4, "harmonics"))
    rows, orders = _signals(1000, 12), np.arange(1, 13)
    samples, each = cycle.SAMPLES_PER_ORDER * 12.0, float(len(rows))
    generator = np.random.default_rng(7)
    position = generator.uniform(-0.4, 0.4, (4, 3))
    stiffness = np.array([np.diag(generator.uniform(1e4, 5e4, 3)) for _ in position])
    mass = np.diag([100.0, 100.0, 100.0, 3.0, 6.0, 7.0])
    matrices = assemble(mass, position, stiffness, 0.005 * stiffness, 0.0 * stiffness)
    frequency = np.linspace(5.0, 500.0, 2000)[:, None] * np.arange(1, 8)
    load = np.ones((2000, 7, 6), dtype=complex)
    uncertainty = np.zeros(load.shape)
    return [
        Kernel(
            "harmonics 1 to 40 of 1000 rods",
            lambda: motion_harmonics(ratios, highest),
            {"real product": 2.0 * terms * entries, "real sum": terms * entries,
             "power": 2.0 * entries, "real quotient": entries},
            16.0 * len(ratios) * (highest + 1.0),
            "the ratio of each term of the series is formed anew, and every coefficient has its "
            "error next to it",
        ),
        Kernel(
            "peak over the cycle, 1000 signals of 12 orders",
            lambda: cycle.cycle_peak(rows, orders),
            {"flop of matrices": 2.0 * 24.0 * samples * each, "real product": samples * each,
             "comparison": 2.0 * samples * each, "complex product": 2.0 * 12.0 * each,
             "real sum": 2.0 * 4.0 * 15.0 * each},
            0.0,
            "every sample that can be next to the maximum is followed as a polynomial with a "
            "bound, which proves that no higher peak was missed",
        ),
        Kernel(
            "6 x 6 at 14000 frequencies, with error estimates",
            lambda: response(dynamics(matrices, frequency), load, uncertainty),
            {"6 x 6 solution": 14000.0}, 0.0,
            "numpy's inverse alone, which the bound of the error needs, takes twice a solution; "
            "the rest are the bound and fresh memory, of which blocks of frequencies save half",
        ),
    ]  # fmt: skip


def many_machines() -> list[Kernel]:
    """Rolls and tunings, in batches and alone."""
    rods = np.linspace(0.2, 0.6, 128)
    masses = np.tile([FIRST_MASS, SECOND_MASS], (128, 1))
    batch, drive = source_machine(rod_length=rods, reciprocating_mass=masses), source_drive()
    single = as_batch(source_machine())

    def solved(machine: object) -> object:
        return steady_state(machine, drive, 6, started_at=SYNCHRONOUS, tolerance=1e-11)  # type: ignore[arg-type]

    evaluated = float(solved(batch).evaluations)  # type: ignore[attr-defined]
    many = np.geomspace(0.01, 1.0, 2000)
    return [
        Kernel(
            "running states of 128 rolls, 6 points",
            lambda: solved(batch),
            _in_roll(evaluated),
            0.0,
            "panels are split anew at the kinks of each machine's motor, which moves solutions "
            "from panels to panels; arrays of a batch do not fit the first cache",
        ),
        Kernel(
            "running state of one roll, 6 points",
            lambda: solved(single), _in_roll(float(solved(single).evaluations)), 0.0,  # type: ignore[attr-defined]
            f"some {_calls(lambda: solved(single)):.0f} operations and calls on arrays of 200 to "
            "600 entries, up to a microsecond each before they begin; a batch shares them",
        ),
        Kernel(
            "tuning of one absorber, against one of a batch of 2000",
            lambda: minimax(0.1, 0.1), {}, 0.0,
            f"some {_calls(lambda: minimax(0.1, 0.1)):.0f} operations and calls on arrays of a "
            "few entries; arithmetic is the least of it. Many tunings belong in one call",
            lambda: minimax(0.1, many), len(many),
        ),
    ]  # fmt: skip


def _in_roll(evaluated: float) -> dict[str, float]:
    """Operations at so many nodes: two cylinders with their angle, rod, its slopes and gas; motor;
    inertias; Newton's equations of a panel, six by six, eliminated."""
    return {
        "sine": 4.0 * evaluated, "root": 2.0 * evaluated, "look-up": 3.0 * evaluated,
        "real product": 110.0 * evaluated, "real sum": 90.0 * evaluated,
        "real quotient": 6.0 * evaluated,
    }  # fmt: skip


def _calls(work: Work) -> int:
    """Operations and calls in code of vibecalc, as Python counts them while it runs."""
    wanted = {dis.opmap[name] for name in ("BINARY_OP", "CALL", "COMPARE_OP", "BINARY_SUBSCR")
              if name in dis.opmap}  # fmt: skip
    count = 0

    def note(frame: FrameType, event: str, _argument: object) -> object:
        nonlocal count
        if event == "call":
            if "vibecalc" not in frame.f_code.co_filename:
                return None
            frame.f_trace_opcodes, frame.f_trace_lines = True, False
        elif event == "opcode":
            count += frame.f_code.co_code[frame.f_lasti] in wanted
        return note

    sys.settrace(note)
    try:
        work()
    finally:
        sys.settrace(None)
    return round(count, -2)


def line_of(kernel: Kernel, rates: Mapping[str, float]) -> list[str]:
    """Time, best possible, their ratio and the reason, as text."""
    if kernel.library is not None:
        took = in_turns({"ours": kernel.work, "best": kernel.library}, 12)
        spent, best = took["ours"], took["best"] / kernel.per
    else:
        spent = each_of(kernel.work, 0.05, 7)
        done = sum(count * rates[kind] for kind, count in kernel.counts.items())
        best = max(done, kernel.moved * rates["byte"])
    ratio = spent / best
    why = kernel.why if ratio > ENOUGH else ""
    return [kernel.name, seconds(spent), seconds(best), digits(ratio), why]


GROUPS: tuple[Callable[[], list[Kernel]], ...] = (
    torsion_kernels, closed_form_kernels, many_machines,
)  # fmt: skip


def measure() -> Report:
    """The machine's rates and all kernels."""
    rates = peaks()
    lines = [line_of(kernel, rates) for group in GROUPS for kernel in group()]
    columns = ["kernel", "time", "best possible", "ratio", f"why it is above {ENOUGH:g}"]
    return Report(
        "Against the best possible",
        "The best possible is what the operations of a method, counted, take at the machine's own "
        "rates in numpy, or its bytes at the rate of copying, whichever is longer.",
        tables=[
            Table("Kernels", columns, lines),
            Table("Rates of this machine, one operation", ["operation", "time"],
                  [[name, seconds(rate)] for name, rate in rates.items()]),
        ],
    )  # fmt: skip


if __name__ == "__main__":
    reported(measure)
