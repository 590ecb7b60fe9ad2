"""How a sweep is asked for, and what is said of it in the end."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vibecalc.results.sweep_layout import DONE


@dataclass(frozen=True, kw_only=True)
class Options:
    """How a sweep is computed; none of it changes a number of the result.

    jobs
        Processes; None leaves it to the strategy.
    timeout
        Seconds that one point may take.
    resume, fresh
        Take up the chunks that are there; throw away what is there and does not fit.
    shard
        (i, n): only the i-th of n parts, from 1.
    cluster
        Scheduler of a dask cluster, address or file.
    note
        Told what a person should know on the way.
    """

    output: Path
    jobs: int | None = None
    timeout: float | None = None
    resume: bool = False
    fresh: bool = False
    shard: tuple[int, int] = (1, 1)
    cluster: str | None = None
    progress: bool = False
    note: Callable[[str], None] = field(default=lambda _: None)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What came of a sweep: points by status, and how many of them were there from before."""

    output: Path
    counts: Mapping[int, int]
    taken_up: int
    left_out: Mapping[str, str]
    seconds: float

    @property
    def failed(self) -> int:
        """Points that were run and have no result."""
        return sum(many for status, many in self.counts.items() if status > DONE)


def shard_chunks(chunks: int, shard: tuple[int, int]) -> range:
    """Numbers of the chunks of one part: every n-th, so that no part has all the slow ones."""
    part, parts = shard
    return range(part - 1, chunks, parts)


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
