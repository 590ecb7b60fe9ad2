"""A sweep from its first chunk to its file; what is interrupted is taken up where it stopped."""

import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from vibecalc.core.results.files import fresh_output
from vibecalc.core.results.layout import DONE, NOT_RUN, UNLUCKY
from vibecalc.core.results.record import Record
from vibecalc.core.results.steps import step
from vibecalc.core.study.execute import as_result
from vibecalc.core.study.sweep.assemble import Assembled, assemble, sweep_head
from vibecalc.core.study.sweep.blocks import Block, combined
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.core.study.sweep.output import locked, points_in, take_up
from vibecalc.core.study.sweep.prepare import (
    Options,
    Outcome,
    PreparedSweep,
    processors,
    shard_chunks,
)
from vibecalc.core.study.sweep.workers import Workers, here
from vibecalc.core.study.variables import counted
from vibecalc.errors import Interrupted, UsageError
from vibecalc.interrupts import held_back


def sweep(prepared: PreparedSweep, options: Options) -> Outcome:
    """Compute what is missing of a sweep and write its file.

    UsageError if the output is another sweep's, in use or cannot be written, or if there are
    chunks from before and nobody said what to do with them; Interrupted after Ctrl-C. Whatever
    happens, chunks that are finished stay.
    """
    started = time.perf_counter()
    output = fresh_output(options.output)
    with locked(output):
        journal = prepared.journal(output)
        mine = shard_chunks(journal.chunks, options.shard)
        there = points_in(output, prepared, options.fresh)
        if options.resume and not options.again and there.size:
            parts = (there[journal.points(number)] for number in mine)
            there = np.concatenate([there[:0], *parts])
            if not np.isin(there, (NOT_RUN, *UNLUCKY)).any():
                options.note(f"{output} is complete, nothing is left to do")
                journal.clear()
                return Outcome(counts=Counter(there.tolist()), taken_up=there.size)
        finished = take_up(journal, options.resume, options.fresh, options.note)
        before = _points(journal, finished.intersection(mine))
        try:
            _compute(prepared, options, journal, mine, finished)
            made = _assemble(prepared, options, output, journal, {*mine, *finished}, started)
        except KeyboardInterrupt:
            raise Interrupted(_stopped_words("interrupted", journal, mine)) from None
        except UsageError as error:
            raise UsageError(_stopped_words(str(error), journal, mine)) from error
    return Outcome(
        counts={status: many for status, many in made.counts.items() if status >= DONE},
        taken_up=before,
        seconds=time.perf_counter() - started,
    )


def _compute(
    prepared: PreparedSweep,
    options: Options,
    journal: Journal,
    mine: Sequence[int],
    finished: frozenset[int],
) -> None:
    missing = [number for number in mine if number not in finished]
    step(f"{prepared.strategy.kind}: {len(missing)} chunks of {journal.count} points to compute")
    journal.start()
    if not missing:
        return
    works = (range(points[0], points[-1] + 1) for points in map(journal.points, missing))
    failures = 0
    with (
        counted("sweep", options.progress, _points(journal, missing)) as advance,
        _computed(prepared, options, works, len(missing)) as computed,
    ):
        for work, found in computed:
            block = combined(found, np.array(work), prepared.keep)
            journal.write(work.start // journal.size, block)
            failures += int(np.count_nonzero(block.status != DONE))
            advance(f", {failures} failed" if failures else "", len(work))
            step(f"chunk {work.start // journal.size}: {len(work)} points")


@contextmanager
def _computed(
    prepared: PreparedSweep, options: Options, works: Iterator[range], missing: int
) -> Iterator[Iterator[tuple[range, list[Block]]]]:
    """Chunks as they come, from whatever computes them."""
    alone = options.timeout is None and options.jobs in (None, 1) and prepared.is_short
    if alone and options.cluster is None:
        yield here(prepared.start(), works)
        return
    with Workers(
        prepared.start(),
        jobs=min(options.jobs or processors(), missing),
        cluster=options.cluster,
        timeout=options.timeout,
        step=prepared.step,
    ) as workers:
        yield workers.run(works)


def _assemble(
    prepared: PreparedSweep,
    options: Options,
    output: Path,
    journal: Journal,
    numbers: Iterable[int],
    started: float,
) -> Assembled:
    """Put the chunks together, and take them away unless some are worth another try."""
    timings = {"sweep": time.perf_counter() - started}
    result = as_result(prepared.loaded, Record(), timings)
    head = sweep_head(result, prepared.design, prepared.identity, prepared.keep)
    with held_back() as stop:
        made = assemble(output, head, journal, numbers, between=stop)
    if any(made.counts.get(status, 0) for status in UNLUCKY):
        options.note(
            f"the chunks stay in {journal.path}: with --resume and a longer --timeout "
            "only those with a point that attached or died are computed again"
        )
    else:
        journal.clear()
    return made


def _points(journal: Journal, numbers: Iterable[int]) -> int:
    return sum(len(journal.points(number)) for number in numbers)


def _stopped_words(why: str, journal: Journal, mine: Sequence[int]) -> str:
    """Why a sweep stops, and how to go on."""
    finished = len(journal.places.keys() & set(mine))
    if not journal.places:
        with suppress(UsageError):
            journal.clear()
    if not finished:
        return f"{why}; no chunk of {len(mine)} was finished, nothing is kept"
    return (
        f"{why}; {finished} of {len(mine)} chunks are finished and stay in {journal.path}: "
        "the same command with --resume goes on with them"
    )
