"""The chunks of a sweep, or the files of its parts, put together in one file."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.files import fresh_output
from vibecalc.core.results.layout import NOT_RUN, SAMPLE, STATUS_WORDS
from vibecalc.core.results.record import Result
from vibecalc.core.results.sweep_file import SweepHead, SweepResult, SweptAxis, open_sweep
from vibecalc.core.study.sweep.blocks import Block, combined
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.core.study.sweep.output import otherwise
from vibecalc.core.study.sweep.stacked_file import write_stacked
from vibecalc.errors import UsageError

# ----------------------------------------------------------------------------
# The chunks of a sweep put together in one file.
# ----------------------------------------------------------------------------


class Assembled(NamedTuple):
    """A file that was written, and what is in it.

    `counts` says how many points have which status, `missing` which were not run (first and last
    of each gap).
    """

    path: Path
    counts: Mapping[int, int]
    missing: tuple[tuple[int, int], ...]


def assemble(
    output: Path | str,
    head: SweepHead,
    journal: Journal,
    numbers: Iterable[int] | None = None,
    between: Callable[[], None] = lambda: None,
) -> Assembled:
    """Write the file of a sweep from some of its chunks, by default all that are there.

    The chunks are read twice, one at a time; `between` is called before each. Points of other
    chunks are "not run". UsageError, with the reason, if the file cannot be written, and
    ResultError for a chunk that is damaged; an old file is then as it was.
    """
    wanted = sorted(journal.places if numbers is None else set(numbers))

    def blocks() -> Iterator[Block]:
        for number in wanted:
            between()
            yield journal.read(number)
        between()

    return _written(fresh_output(output), head, blocks)


def _written(target: Path, head: SweepHead, blocks: Callable[[], Iterator[Block]]) -> Assembled:
    write_stacked(target, head, blocks)
    with open_sweep(target) as sweep:
        counts, missing = sweep.counts(), sweep.status().ravel() == NOT_RUN
    edges = np.flatnonzero(np.diff(missing, prepend=False, append=False))
    gaps = tuple((int(first), int(after) - 1) for first, after in edges.reshape(-1, 2))
    return Assembled(target, counts, gaps)


def sweep_head(result: Result, design: Design, identity: str, stored: Sequence[str]) -> SweepHead:
    """What a file says of a sweep; `result` has case, plan and provenance, and no quantities."""
    along = [(SAMPLE, design.every, design.count)]
    if design.sampling == "grid":
        along = [(one.name, one.keys, one.count or 0) for one in design.axes]
    axes = []
    for place, (name, keys, count) in enumerate(along):
        values_at = design.axes[place].at if design.sampling == "grid" else design.value_of
        pairs = zip(keys, values_at(np.arange(count)).T, strict=True)
        columns = tuple(column.astype(np.int64 if key.whole else float) for key, column in pairs)
        axes.append(SweptAxis(name=name, keys=keys, columns=columns))
    return SweepHead(
        result=result,
        axes=tuple(axes),
        sampling=design.sampling,
        design=design.description(),
        stored=tuple(stored),
        identity=identity,
    )


# ----------------------------------------------------------------------------
# Files of parts of one sweep put together in one file.
# ----------------------------------------------------------------------------

_AT_ONCE = 1 << 13  # points
_ENTRIES = 1 << 20  # of all quantities of these points


def merge(
    parts: Sequence[Path | str],
    output: Path | str,
    provenance: Mapping[str, str | int | float] | None = None,
) -> Assembled:
    """Write one file with the points of all parts, and say which points none of them has.

    `provenance` replaces that of the first part. Raises UsageError for parts of different sweeps
    and for a point that two parts have with different results, ResultError for a file that cannot
    be read; an old output is then as it was.
    """
    if not parts:
        raise UsageError("there are no parts to merge")
    target = fresh_output(output)
    with ExitStack() as stack:
        opened = [stack.enter_context(open_sweep(part)) for part in parts]
        head = opened[0].head
        for other in opened[1:]:
            if (head.identity, head.shape) != (other.head.identity, other.shape):
                pair = f"{opened[0].path} and {other.path}"
                why = otherwise(other.head, head.result.version, head.design, head.stored)
                raise UsageError(f"{pair} are not parts of one sweep: the second is {why}")
        if provenance is not None:
            result = replace(head.result, provenance=dict(provenance), timings={})
            head = replace(head, result=result)
        return _written(target, head, lambda: _together(opened))


def _together(parts: Sequence[SweepResult]) -> Iterator[Block]:
    """All points that a part has, ascending; UsageError where two parts do not agree."""
    count, keep = parts[0].count, parts[0].head.stored
    left_out = {path: why for part in reversed(parts) for path, why in part.left_out.items()}
    sizes = [[len(axis.values) for axis in q.axes] for p in parts for q in p.quantities.values()]
    entries = sum(map(math.prod, sizes))
    step = max(1, min(_AT_ONCE, _ENTRIES // max(entries, 1)))
    words = [part.reasons() for part in parts]
    for first in range(0, count, step):
        numbers = np.arange(first, min(first + step, count))
        blocks = [_block(part, told, numbers) for part, told in zip(parts, words, strict=True)]
        # of points that several parts have those of the first count
        whole = combined(blocks[::-1], numbers, keep)
        if sum(len(one.indices) for one in blocks) > np.count_nonzero(whole.status != NOT_RUN):
            for part, block in zip(parts, blocks, strict=True):
                _check_agreed(combined([*blocks[::-1], block], numbers, keep), whole, part.path)
        if any(len(one.indices) for one in blocks):
            yield whole._replace(left_out=left_out | dict(whole.left_out))


def _block(part: SweepResult, words: Mapping[int, str], numbers: np.ndarray) -> Block:
    """The points that a part has among some consecutive ones."""
    ends = int(numbers[0]), int(numbers[-1]) + 1
    status = part.status(*ends)
    run = status != NOT_RUN
    columns = {
        name: part.read(name, *ends)[run] for path in part.quantities for name in part.stored(path)
    }
    message = tuple(words.get(point, "") for point in numbers[run].tolist())
    return Block(numbers[run], status[run], message, columns, part.quantities)


def _check_agreed(mine: Block, others: Block, path: Path) -> None:
    """UsageError unless a part, from `path`, says the same as those before it."""

    def refuse(row: int, what: str) -> None:
        raise UsageError(
            f"two parts have point {mine.indices[row]} and do not agree on it, {path} and one "
            f"before it: {what}"
        )

    for row, (ours, theirs) in enumerate(zip(_said(mine), _said(others), strict=True)):
        if ours != theirs:
            refuse(row, f"{theirs!r} and {ours!r}")
    for name, values in mine.columns.items():
        same = np.isclose(values, others.columns[name], rtol=0.0, atol=0.0, equal_nan=True)
        wrong = np.flatnonzero(~same.reshape(len(values), -1).all(axis=1))
        if wrong.size:
            refuse(int(wrong[0]), f"different values of {name}")


def _said(block: Block) -> list[str]:
    return [
        f"{STATUS_WORDS.get(int(status), '?')} {words}".rstrip()
        for status, words in zip(block.status, block.message, strict=True)
    ]
