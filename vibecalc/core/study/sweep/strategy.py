"""How a sweep is computed: by arrays, in one process, or by many."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import parse_key
from vibecalc.core.run.plan import needed_stages, work_seconds
from vibecalc.core.run.stage import work_of
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.design import Design

if TYPE_CHECKING:
    from vibecalc.schema import Case

Kind = Literal["array", "reuse", "pool"]

_SEARCH = 1000.0  # runs of an optimisation
_CHECKS = 0.5
#: milliseconds of work that are not worth starting processes for
_SHORT = 2000.0
_CHUNK = 5000.0
_MOST_POINTS = 256
_ARRAY_POINTS = 4096
_MOST_CHUNKS = 10_000
_FEWEST_CHUNKS = 16


class Strategy(NamedTuple):
    """The kind of evaluation, in words why, and how many points one chunk has.

    `chunk_size` depends on the case, the design and what is kept, never on the number of processes.
    `milliseconds` is roughly what a point takes, None for arrays.
    """

    kind: Kind
    reason: str
    chunk_size: int
    milliseconds: float | None = None


def choose(case: "Case", design: Design, keep: Sequence[str], jobs: int = 2) -> Strategy:
    """The fastest way that gives the results `keep` at all points; `jobs` processes are allowed.

    Arrays where all results are closed forms over the keys that vary. Else one process, in which
    stages run again only where something that they read has changed, if there may be no more or
    all points take less time than processes take to start; else processes that each do the same.
    """
    from vibecalc.array_path import unsupported

    why_not = unsupported(case, [parse_key(key) for key in design.keys], keep)
    if why_not is None:
        size = _spread(design.count, _ARRAY_POINTS)
        return Strategy("array", "all that is kept is a closed form over what varies", size)
    cost = milliseconds(case, keep)
    size = min(_MOST_POINTS, max(1, round(_CHUNK / cost)), -(-design.count // _FEWEST_CHUNKS))
    size = _spread(design.count, size)
    if jobs == 1:
        return Strategy("reuse", f"one process; no arrays: {why_not}", size, cost)
    if cost * design.count < _SHORT:
        words = "all points take less time than processes to start"
        return Strategy("reuse", f"{words}; no arrays: {why_not}", size, cost)
    return Strategy("pool", f"{jobs} processes; no arrays: {why_not}", size, cost)


def milliseconds(case: "Case", keep: Sequence[str]) -> float:
    """Roughly what one point takes, of the stages that have to run for what is kept."""
    stages = needed_stages(case, frozenset(keep))
    seconds = sum(work_seconds(work_of(case, stage)) for stage in stages)
    return _CHECKS + 1e3 * seconds * (1.0 if case.optimisation is None else _SEARCH)


def start(
    loaded: LoadedCase, design: Design, keep: Sequence[str], kind: Kind
) -> Callable[[np.ndarray], Block]:
    """What evaluates points; to be bound to its arguments and called in the process that works."""
    if kind == "array":
        from vibecalc.core.study.sweep.arrays import ArrayEvaluator

        return ArrayEvaluator(loaded, design, keep)
    from vibecalc.core.study.sweep.evaluate import Evaluator

    return Evaluator(loaded, design, keep)


def _spread(count: int, size: int) -> int:
    """A chunk size of at least `size`, larger where there would be too many chunks."""
    return max(size, -(-count // _MOST_CHUNKS))
