"""A search that tries to make two ways to one number disagree by more than they say.

    PYTHONPATH=tests python -m stability.search --seed 1 --evaluations 4000

Each contest maps a point of the unit cube to a machine, over many decades, and measures by how
much two independent ways differ, in units of the errors that they report. Random points come
first, then steps from the worst of them that shrink as they fail. More than 1 breaks a promise; so
does anything that is not finite. A refusal in words counts as 0. The same seed gives the same walk.
"""

import argparse
import time
import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import VibecalcError


class Contest(NamedTuple):
    """Two ways to one number: words for them, how many numbers make a machine, and the ratio."""

    name: str
    words: str
    size: int
    ratio: Callable[[np.ndarray], float]


class Find(NamedTuple):
    """The worst point of a contest, its ratio, how many machines were tried, and refused."""

    name: str
    ratio: float
    point: tuple[float, ...]
    tried: int
    refused: int


def measured(contest: Contest, point: np.ndarray) -> tuple[float, bool]:
    """Ratio at a point, infinite where a way breaks down or is not a number; was it refused?"""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            value = float(contest.ratio(point))
    except VibecalcError:
        return 0.0, True
    except (ArithmeticError, np.linalg.LinAlgError):
        return np.inf, False
    return (np.inf if np.isnan(value) else value), False


def search(contest: Contest, seed: int, evaluations: int, starts: int = 4) -> Find:
    """Half of the evaluations at random points, half in climbs from the worst `starts` of them."""
    random = np.random.default_rng([seed, *contest.name.encode()])
    refused, seen = 0, []
    for _ in range(evaluations // 2):
        # rounded, so that the point can be written down
        point = np.round(random.random(contest.size), 6)
        value, loud = measured(contest, point)
        refused += loud
        seen.append((value, tuple(point.tolist())))
    seen.sort(reverse=True)
    best = seen[0]
    tried = len(seen)
    each = max(1, (evaluations - tried) // starts)
    for now in seen[:starts]:
        width = 0.1
        for _ in range(each):
            away = (
                width * random.standard_normal(contest.size) * (random.random(contest.size) < 0.5)
            )
            point = np.round(np.clip(np.array(now[1]) + away, 0.0, 1.0), 6)
            value, loud = measured(contest, point)
            tried, refused = tried + 1, refused + loud
            better = value > now[0]
            now = (value, tuple(point.tolist())) if better else now
            width = min(0.3, 1.5 * width) if better else max(1e-4, 0.93 * width)
        best = max(best, now)
    return Find(contest.name, best[0], best[1], tried, refused)


def main() -> None:
    """Run the contests and print their worst points as rows of `search_finds.py`."""
    from stability.search_contests import CONTESTS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--evaluations", type=int, default=400, help="of each contest")
    parser.add_argument("--seconds", type=float, default=np.inf, help="of CPU, of each contest")
    parser.add_argument("names", nargs="*", help="contests; all without any")
    asked = parser.parse_args()
    for contest in CONTESTS:
        if asked.names and contest.name not in asked.names:
            continue
        start = time.process_time()
        search(contest, asked.seed, 20)
        pace = (time.process_time() - start) / 20.0
        count = int(min(asked.evaluations, asked.seconds / max(pace, 1e-6)))
        found = search(contest, asked.seed, max(count, 20))
        print(f'    Find("{found.name}", {found.ratio:.3g}, {found.point}, {found.tried}, '
              f"{found.refused}),  # {time.process_time() - start:.0f} s", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
