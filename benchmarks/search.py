"""The crankshaft search of Ong (2000), table 8.2, two ways: evaluations and CPU time.

All ways make the same function small: the source's objective, one point at a time, except for the
literal search, which is timed on a sample of its 9300 starts as one batch (in its favour) and
scaled. The objective is homogeneous in force and torque, so that one evaluation and a square root
already give a zero.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "published"))

import numpy as np
from rows import Report, Row, reported, seconds
from test_published_ong_search import TARGET, corrective_energy, grid, objective, search
from timing import best_of, cpu_of

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem

FIRST = (3.0, 72.0, 80.0)
LOWER, UPPER = (0.1, 0.0, 0.0), (6.2, 150.0, 150.0)
SAMPLE = 300


class Found(NamedTuple):
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
    found = minimise(Problem(evaluate, LOWER, UPPER, first=FIRST), starts=0)
    return found.evaluations, found.objective


def timed(way: str, work: Callable[[], tuple[int, float]]) -> Found:
    """Least CPU seconds of five repeats."""
    return Found(way, work()[0], best_of(work), work()[1])


def literal() -> Found:
    """The listing from all starts, scaled up from a sample spread over them."""
    starts = grid()
    chosen = np.linspace(0, starts.shape[1] - 1, SAMPLE).astype(int)
    share = starts.shape[1] / SAMPLE
    ends = []
    spent = cpu_of(lambda: ends.append(search(starts[:, chosen])))
    count = round(share * ends[0].evaluations)
    return Found("listing, 9300 starts", count, share * spent, float(ends[0].objective.min()))


def measure() -> Report:
    """One row for each way against the listing."""
    found = [
        timed("one evaluation and a root", by_scaling),
        timed("own search, refined", by_refined_search),
    ]
    last = literal()
    rows = [
        Row(
            "balance masses of table 8.2",
            one.way,
            f"the source's {last.way} ({last.evaluations} evaluations)",
            last.seconds / one.seconds,
            error=f"objective {one.objective:.0e} (listing {last.objective:.0e})",
            note=f"{seconds(one.seconds)} against {seconds(last.seconds)}, "
            f"{one.evaluations} evaluations",
        )
        for one in found
    ]
    return Report(
        "Search for balance masses",
        f"The search of Ong (2000); {SAMPLE} starts of the listing were timed as one batch, in "
        "its favour, and scaled up.",
        rows,
    )


if __name__ == "__main__":
    reported(measure)
