"""Chunks computed in this process: for array calls that are over before a process has started."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from vibecalc.study.sweep.pool import Done, Lost, Piece, Work


class Here:
    """This process, as a `Pool` is used; nothing guards it against points that hang or kill."""

    def __init__(self, start: Callable[[], Callable[[Any], Any]], *, step: int = 1):
        self._start, self._step = start, step

    def __enter__(self) -> "Here":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def run(
        self, works: Iterable[Work], tell: Callable[[Piece | Lost], None] = lambda _: None
    ) -> Iterator[Done]:
        """Compute chunks in their order and yield each as it is finished."""
        evaluate = self._start()
        for work in works:
            pieces = []
            for first in range(work.points.start, work.points.stop, self._step):
                points = list(range(first, min(first + self._step, work.points.stop)))
                pieces.append(Piece(points, evaluate(np.array(points, dtype=np.int64))))
                tell(pieces[-1])
            yield Done(work, pieces, [])
