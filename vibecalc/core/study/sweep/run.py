"""A sweep from its first chunk to its file; what is interrupted is taken up where it stopped."""

import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Protocol

import numpy as np

from vibecalc.core.results.files import fresh_output
from vibecalc.core.results.layout import DONE, NOT_RUN, UNLUCKY
from vibecalc.core.results.record import Record
from vibecalc.core.results.steps import step
from vibecalc.core.study.execute import as_result
from vibecalc.core.study.sweep.assemble import Assembled, assemble, sweep_head
from vibecalc.core.study.sweep.blocks import Block, BlockQuantity, ChunkFolder, laid_out
from vibecalc.core.study.sweep.output import (
    ASSEMBLED,
    check_output,
    complete,
    locked,
    take_up,
)
from vibecalc.core.study.sweep.pool import Batch, ChunkResult, LostPoint, Pool, SerialPool, Work
from vibecalc.core.study.sweep.prepare import (
    Options,
    Outcome,
    PreparedSweep,
    processors,
    shard_chunks,
)
from vibecalc.errors import Interrupted, UsageError
from vibecalc.interrupts import held_back

# ----------------------------------------------------------------------------
# The batches of a chunk, whoever computed them and in how many calls, as one block.
# ----------------------------------------------------------------------------


def block_of(done: ChunkResult, keep: Sequence[str]) -> Block:
    """One block of a finished chunk; the same for the same points, however they were cut up."""
    points = np.array(done.work.points, dtype=np.int64)
    status = np.full(points.size, NOT_RUN, dtype=np.int8)
    message = [""] * points.size
    parts: list[tuple[np.ndarray, Block]] = []
    for batch in sorted(done.batches, key=lambda batch: batch.points[0]):
        block: Block = batch.block
        rows = block.indices - points[0]
        parts.append((rows, block))
        status[rows] = block.status
        if any(block.message):
            for row, words in zip(rows, block.message, strict=True):
                message[row] = words
    for lost in done.lost:
        status[lost.point - points[0]] = lost.status
        message[lost.point - points[0]] = lost.message
    quantities: dict[str, BlockQuantity] = {}
    left_out: dict[str, str] = {}
    for path in keep:
        reasons = [block.left_out[path] for _, block in parts if path in block.left_out]
        present = [
            (rows, block.quantities[path]) for rows, block in parts if path in block.quantities
        ]
        whole = reasons[0] if reasons else laid_out(present, points) if present else None
        if isinstance(whole, str):
            left_out[path] = whole
        elif whole is not None:
            quantities[path] = whole
    return Block(points, status, tuple(message), quantities, left_out)


# ----------------------------------------------------------------------------
# How far a sweep is, on stderr and on a terminal only.
# ----------------------------------------------------------------------------

#: called with how many points were finished, and how many of them failed
Advance = Callable[[int, int], None]


@contextmanager
def shown(points: int, finished: int, wanted: bool) -> Iterator[Advance]:
    """A bar with rate, time left and failures so far, for `points` of which some are `finished`.

    Where nobody looks, what is yielded does nothing. Points that were finished before count for
    the length of the bar and not for the rate.
    """
    if not (wanted and sys.stderr.isatty()):
        yield lambda points, failures: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("sweep"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=points, completed=finished, rate="", failed="")
        failures = 0

        def advance(more: int, failed: int) -> None:
            nonlocal failures
            failures += failed
            speed = bar.tasks[0].speed
            bar.update(
                task,
                advance=more,
                rate=f"{speed:.3g}/s" if speed else "",
                failed=f"{failures} failed" if failures else "",
            )

        yield advance


# ----------------------------------------------------------------------------
# A sweep from its first chunk to its file; what is interrupted is taken up where it stopped.
# ----------------------------------------------------------------------------

_TOGETHER = 16  # points between two checks of the progress, where nothing guards single ones

Tell = Callable[[Batch | LostPoint], None]


class Workers(Protocol):
    """Whatever computes chunks: this process, others of this machine, or a cluster."""

    def run(self, works: Iterator[Work], tell: Tell) -> Iterator[ChunkResult]:
        """Yield chunks as they are finished."""


def sweep(prepared: PreparedSweep, options: Options) -> Outcome:
    """Compute what is missing of a sweep and write its file.

    UsageError if the output is another sweep's, in use or cannot be written, or if there are
    chunks from before and nobody said what to do with them; Interrupted after Ctrl-C. Whatever
    happens, chunks that are finished stay.
    """
    started = time.perf_counter()
    output = fresh_output(options.output)
    with locked(output):
        chunks = prepared.chunks(output)
        mine = shard_chunks(chunks.chunks, options.shard)
        if not options.fresh:
            check_output(output, prepared.identity, prepared.loaded.resolved)
        if options.resume and not options.again:
            counts = complete(output, prepared.identity, chunks, mine)
            if counts is not None:
                options.note(f"{output} is complete, nothing is left to do")
                chunks.clear()
                points = sum(counts.values())
                return Outcome(
                    output=options.output, counts=counts, taken_up=points, left_out={}, seconds=0.0
                )
        finished = take_up(chunks, options.resume, options.fresh, options.note)
        before = _points(chunks, finished.intersection(mine))
        try:
            _compute(prepared, options, chunks, mine, finished)
            made = _assemble(prepared, options, output, chunks, {*mine, *finished}, started)
        except KeyboardInterrupt:
            raise Interrupted(_stopped_words("interrupted", chunks, mine, options)) from None
        except UsageError as error:
            raise UsageError(_stopped_words(str(error), chunks, mine, options)) from error
    return Outcome(
        output=options.output,
        counts={status: many for status, many in made.counts.items() if status >= DONE},
        taken_up=before,
        left_out=made.left_out,
        seconds=time.perf_counter() - started,
    )


def _compute(
    prepared: PreparedSweep,
    options: Options,
    chunks: ChunkFolder,
    mine: Sequence[int],
    finished: frozenset[int],
) -> None:
    missing = [number for number in mine if number not in finished]
    step(f"{prepared.strategy.kind}: {len(missing)} chunks of {chunks.count} points to compute")
    chunks.make()
    if not missing:
        return
    with (
        shown(
            _points(chunks, mine), _points(chunks, finished.intersection(mine)), options.progress
        ) as advance,
        _workers(prepared, options, len(missing)) as workers,
    ):

        def tell(heard: Batch | LostPoint) -> None:
            if isinstance(heard, LostPoint):
                advance(1, 1)
            else:
                advance(len(heard.points), int(np.count_nonzero(heard.block.status != DONE)))

        for done in workers.run(_works(chunks, missing), tell):
            chunks.write(done.work.number, block_of(done, prepared.keep))
            step(f"chunk {done.work.number}: {len(done.work.points)} points")


def _workers(
    prepared: PreparedSweep, options: Options, missing: int
) -> AbstractContextManager[Workers]:
    start, step = prepared.start(), prepared.step
    if options.cluster is not None:
        from vibecalc.core.study.sweep.cluster import Cluster

        return Cluster(start, address=options.cluster, timeout=options.timeout, step=step)
    if options.timeout is None and options.jobs in (None, 1) and prepared.is_short:
        return SerialPool(start, step=max(step, _TOGETHER))
    jobs = min(options.jobs or processors(), missing)
    return Pool(start, jobs=jobs, timeout=options.timeout, step=step)


def _works(chunks: ChunkFolder, numbers: Sequence[int]) -> Iterator[Work]:
    for number in numbers:
        points = chunks.points(number)
        yield Work(number, range(int(points[0]), int(points[-1]) + 1))


def _assemble(
    prepared: PreparedSweep,
    options: Options,
    output: Path,
    chunks: ChunkFolder,
    numbers: Iterable[int],
    started: float,
) -> Assembled:
    timings = {"sweep": time.perf_counter() - started}
    result = as_result(prepared.loaded, Record(), timings)
    head = sweep_head(result, prepared.design, prepared.identity, prepared.keep)
    # among the chunks, so that what a killed process leaves behind is found and thrown away
    aside = chunks.folder / ASSEMBLED
    with held_back() as stop:
        made = assemble(aside, head, chunks, numbers, between=stop)
        stop()
        try:
            os.replace(aside, output)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise UsageError(f"cannot write {output}: {reason}") from error
        _tidy(chunks, made, options)
    return made


def _tidy(chunks: ChunkFolder, made: Assembled, options: Options) -> None:
    """Take the chunks away, unless some points of them are worth another try."""
    if any(made.counts.get(status, 0) for status in UNLUCKY):
        options.note(
            f"the chunks stay in {chunks.folder}: with --resume and a longer --timeout "
            "only those with a point that attached or died are computed again"
        )
    else:
        chunks.clear()


def _points(chunks: ChunkFolder, numbers: Iterable[int]) -> int:
    size = chunks.size
    return sum(min(size, chunks.count - number * size) for number in numbers)


def _stopped_words(why: str, chunks: ChunkFolder, mine: Sequence[int], options: Options) -> str:
    """Why a sweep stops, and how to go on."""
    finished = sum(chunks.path(number).is_file() for number in mine)
    if not finished:
        with suppress(OSError):
            chunks.folder.rmdir()
        return f"{why}; no chunk of {len(mine)} was finished, nothing is kept"
    return (
        f"{why}; {finished} of {len(mine)} chunks are finished and stay in {chunks.folder}: "
        "the same command with --resume goes on with them"
    )
