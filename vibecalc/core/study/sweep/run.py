"""A sweep from its first chunk to its file; what is interrupted is taken up where it stopped."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from vibecalc.core.results.files import fresh_output
from vibecalc.core.results.layout import DONE, NOT_RUN, UNLUCKY
from vibecalc.core.results.record import Record
from vibecalc.core.results.steps import step
from vibecalc.core.study.execute import as_result
from vibecalc.core.study.sweep.assemble import assemble, sweep_head
from vibecalc.core.study.sweep.blocks import Block, combined
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.core.study.sweep.output import locked, points_in
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
    output = fresh_output(options.output)
    with locked(output):
        journal = prepared.journal(output)
        run = _Run(prepared, options, journal, shard_chunks(journal.chunks, options.shard))
        there = points_in(output, prepared, options.fresh)
        if options.resume and not options.again and there.size:
            there = np.concatenate([there[:0], *(there[journal.points(n)] for n in run.mine)])
            if not np.isin(there, (NOT_RUN, *UNLUCKY)).any():
                options.note(f"{output} is complete")
                journal.clear()
                return Outcome(counts=Counter(there.tolist()), taken_up=there.size)
        run.take_up()
        try:
            return run.finish(output)
        except KeyboardInterrupt:
            raise Interrupted(run.stopped("interrupted")) from None
        except UsageError as error:
            raise UsageError(run.stopped(str(error))) from error


class _Run:
    """The chunks `mine` of a sweep, and its journal."""

    def __init__(
        self, prepared: PreparedSweep, options: Options, journal: Journal, mine: Sequence[int]
    ):
        self.prepared, self.options, self.journal, self.mine = prepared, options, journal, mine
        self.started, self.finished = time.perf_counter(), frozenset[int]()

    def take_up(self) -> None:
        """Find the chunks that need not be computed again, and make the journal ready.

        Chunks with a point that timed out or died are computed again. UsageError if there are
        chunks and neither `resume` nor `fresh`, or chunks of another sweep and not `fresh`.
        """
        journal, resume, fresh = self.journal, self.options.resume, self.options.fresh
        damage = journal.look()
        if journal.foreign() and not fresh:
            raise UsageError(
                f"{journal.path} holds chunks of another sweep; "
                "--fresh throws them away, -o names another file"
            )
        if journal.places and not (resume or fresh):
            raise UsageError(
                f"{len(journal.places)} of {journal.chunks} chunks of this sweep exist in "
                f"{journal.path}; --resume continues with them, --fresh starts again"
            )
        if not resume:
            journal.clear()
        elif damage:
            self.options.note(damage)
        self.finished = frozenset(
            number
            for number in journal.places
            if not np.isin(journal.read(number).status, UNLUCKY).any()
        )

    def points(self, chunks: Sequence[int]) -> int:
        """How many points some chunks have."""
        return sum(len(self.journal.points(number)) for number in chunks)

    def finish(self, output: Path) -> Outcome:
        """Compute what is missing, put the chunks together, and take them away unless some are
        worth another try."""
        before = [number for number in self.mine if number in self.finished]
        self.compute([number for number in self.mine if number not in self.finished])
        prepared, journal = self.prepared, self.journal
        timings = {"sweep": time.perf_counter() - self.started}
        result = as_result(prepared.loaded, Record(), timings)
        head = sweep_head(result, prepared.design, prepared.identity, prepared.keep)
        with held_back() as stop:
            made = assemble(output, head, journal, {*self.mine, *self.finished}, between=stop)
        if made.counts.keys() & {*UNLUCKY}:
            self.options.note(
                f"the chunks stay in {journal.path}: with --resume and a longer --timeout "
                "only those with a point that timed out or died are computed again"
            )
        else:
            journal.clear()
        return Outcome(
            counts={status: many for status, many in made.counts.items() if status >= DONE},
            taken_up=self.points(before),
            seconds=time.perf_counter() - self.started,
        )

    def compute(self, missing: Sequence[int]) -> None:
        """Compute chunks, and write each to the journal when it comes."""
        journal, prepared = self.journal, self.prepared
        kind = prepared.strategy.kind
        step(f"{kind}: {len(missing)} chunks of {journal.count} points to compute")
        journal.start()
        if not missing:
            return
        works = (range(points[0], points[-1] + 1) for points in map(journal.points, missing))
        failures = 0
        with (
            counted("sweep", self.options.progress, self.points(missing)) as advance,
            self.computed(works, len(missing)) as computed,
        ):
            for work, found in computed:
                block = combined(found, np.array(work), prepared.keep)
                journal.write(work.start // journal.size, block)
                failures += int(np.count_nonzero(block.status != DONE))
                advance(f", {failures} failed" if failures else "", len(work))
                step(f"chunk {work.start // journal.size}: {len(work)} points")

    @contextmanager
    def computed(
        self, works: Iterator[range], missing: int
    ) -> Iterator[Iterator[tuple[range, list[Block]]]]:
        """Chunks as they come, from whatever computes them."""
        prepared, options = self.prepared, self.options
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

    def stopped(self, why: str) -> str:
        """Why a sweep stops, and how to go on."""
        journal, total = self.journal, len(self.mine)
        finished = len(journal.places.keys() & set(self.mine))
        if not journal.places:
            with suppress(UsageError):
                journal.clear()
        if not finished:
            return f"{why}; no chunk of {total} was finished, nothing is stored"
        return (
            f"{why}; {finished} of {total} chunks are finished and stay in {journal.path}: "
            "the same command with --resume continues with them"
        )
