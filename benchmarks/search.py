"""The crankshaft search of Ong (2000), table 8.2, three ways: evaluations and CPU time.

All ways make the same function small: the source's objective, one point at a time, except for the
literal search, which is timed on a sample of its 9300 starts as one batch (in its favour) and
scaled. The objective is homogeneous in force and torque, so that one evaluation and a square root
already give a zero.
"""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import numpy as np
from ong_search import TARGET, corrective_energy, grid, objective, search

from vibecalc.optimisation.constrained import minimise
from vibecalc.optimisation.methods import find

FIRST = (3.0, 72.0, 80.0)
LOWER, UPPER = (0.1, 0.0, 0.0), (6.2, 150.0, 150.0)
SAMPLE = 300


class Row(NamedTuple):
    """One way: what it is, evaluations, CPU seconds and the objective it ends at."""

    way: str
    evaluations: int
    seconds: float
    objective: float


def evaluate(variables: np.ndarray) -> tuple[float, list[float]]:
    """The source's objective at one point, without limits."""
    return float(objective(variables[:, None])[0]), []


def by_scaling() -> tuple[int, float]:
    """Force and torque stretched so that the energy is what it should be: the zero itself."""
    first = np.array(FIRST)[:, None]
    stretch = np.sqrt(TARGET / corrective_energy(first))
    return 1, float(objective(first * np.array([[1.0], stretch, stretch], dtype=float))[0])


def by_refined_search() -> tuple[int, float]:
    """One start of the project's own search, refined, with an error bound."""
    found = minimise(evaluate, LOWER, UPPER, first=FIRST, starts=0)
    return found.evaluations, found.objective


def by_pattern_search() -> tuple[int, float]:
    """Hooke and Jeeves' search as published, from one start."""
    found = find("hooke_jeeves", evaluate, LOWER, UPPER, first=FIRST)
    return found.evaluations, found.objective


def timed(way: str, work: Callable[[], tuple[int, float]]) -> Row:
    """Least CPU seconds of five repeats."""
    seconds = []
    for _ in range(5):
        started = time.process_time()
        evaluations, lowest = work()
        seconds.append(time.process_time() - started)
    return Row(way, evaluations, min(seconds), lowest)


def literal() -> Row:
    """The listing from all starts, scaled up from a sample spread over them."""
    starts = grid()
    chosen = np.linspace(0, starts.shape[1] - 1, SAMPLE).astype(int)
    started = time.process_time()
    ends = search(starts[:, chosen])
    seconds = time.process_time() - started
    share = starts.shape[1] / SAMPLE
    count = round(share * ends.evaluations)
    return Row(
        f"listing, 9300 starts (x {share:.0f})", count, share * seconds, ends.objective.min()
    )


def main() -> None:
    """Print one line for each way, and how many times the listing costs."""
    rows = [
        timed("one evaluation and a root", by_scaling),
        timed("own search, refined", by_refined_search),
        timed("Hooke and Jeeves, one start", by_pattern_search),
        literal(),
    ]
    last = rows[-1]
    print(f"CPU time, one thread, numpy {np.__version__}")
    print(
        f"{'way':<30} {'evaluations':>12} {'ms':>11} {'objective':>10} "
        f"{'fewer':>10} {'times faster':>13}"
    )
    for row in rows:
        print(
            f"{row.way:<30} {row.evaluations:12d} {1e3 * row.seconds:11.2f} {row.objective:10.1e} "
            f"{last.evaluations / row.evaluations:10.0f} {last.seconds / row.seconds:13.0f}"
        )


if __name__ == "__main__":
    main()
