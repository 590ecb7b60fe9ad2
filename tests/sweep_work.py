"""Work for pools of processes: points that take their time, hang, die or fail, by their number."""

import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Squares(NamedTuple):
    """A block of results, as small as can be."""

    points: np.ndarray
    squares: np.ndarray
    process: int
    threads: str


@dataclass(frozen=True)
class Start:
    """Points in the given sets kill their process, hang, or raise; `once` die a single time."""

    killing: frozenset[int] = frozenset()
    leaving: frozenset[int] = frozenset()
    hanging: frozenset[int] = frozenset()
    raising: frozenset[int] = frozenset()
    once: frozenset[int] = frozenset()
    folder: str = ""
    seconds: float = 0.0

    def __call__(self) -> Callable[[np.ndarray], Squares]:
        return self.evaluate

    def evaluate(self, points: np.ndarray) -> Squares:
        found = set(points.tolist())
        time.sleep(self.seconds * len(found))
        if self.folder:
            with open(Path(self.folder) / "calls", "a", encoding="ascii") as log:
                log.write("".join(f"{point}\n" for point in points))
        if found & self.raising:
            raise ValueError(f"a mistake at {sorted(found & self.raising)}")
        for point in sorted(found & self.once):
            mark = Path(self.folder) / f"died-{point}"
            if not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)
        if found & self.killing:
            os.kill(os.getpid(), signal.SIGKILL)
        if found & self.leaving:
            os._exit(7)
        if found & self.hanging:
            time.sleep(3600.0)
        print("noise on stdout")
        return Squares(points, points**2, os.getpid(), os.environ["OPENBLAS_NUM_THREADS"])


def dies_at_once() -> Callable[[np.ndarray], Squares]:
    """A start that no process survives."""
    os._exit(9)
