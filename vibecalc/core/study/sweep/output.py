"""The output of a sweep before it starts: held by one sweep alone, taken up or thrown away."""

import os
import socket
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc import __version__
from vibecalc.core.results.files import in_words
from vibecalc.core.results.layout import NOT_RUN, UNLUCKY
from vibecalc.core.results.sweep_file import is_sweep, open_sweep
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.errors import ResultError, UsageError

# ----------------------------------------------------------------------------
# One sweep for each output: a lock of the operating system, which falls with its process.
# ----------------------------------------------------------------------------


def lock_path(output: Path) -> Path:
    """The lock file of an output."""
    return output.with_name(f"{output.name}.lock")


@contextmanager
def locked(output: Path) -> Iterator[None]:
    """Hold the lock of `output`, whose folder is there; its file says who holds it, and goes.

    UsageError if another sweep holds it, or if it cannot be made.
    """
    from filelock import FileLock, Timeout

    path = lock_path(output)
    lock = FileLock(path)
    with in_words("cannot make the lock file", path):
        try:
            lock.acquire(timeout=0)
        except Timeout:
            raise UsageError(f"another sweep{_holder(path)} is writing {output}") from None
    try:
        with in_words("cannot make the lock file", path):
            path.write_text(f"process {os.getpid()} on {socket.gethostname()}", encoding="utf-8")
        yield
    finally:
        with suppress(OSError):  # while it is held: who has opened it meanwhile tries again
            path.unlink()
        lock.release()


def _holder(path: Path) -> str:
    """Who holds a lock, as far as its file says it."""
    with suppress(OSError):
        holder = path.read_text(encoding="utf-8")
        return f", {holder}," if holder else ""
    return ""


# ----------------------------------------------------------------------------
# What is there from before: whether it may be used, thrown away, or has to be asked about.
# ----------------------------------------------------------------------------


def check_output(output: Path, identity: str, resolved: Mapping[str, Any]) -> None:
    """Refuse, as a UsageError, to replace a file that this sweep did not make.

    `resolved` is the case in SI, for words on what is different.
    """
    if not output.exists():
        return
    if not is_sweep(output):
        raise UsageError(f"{output} is no sweep; --fresh replaces it, -o names another file")
    try:
        with open_sweep(output) as sweep:
            head = sweep.head
    except ResultError as error:
        raise UsageError(f"{error}; --fresh replaces it") from error
    if head.identity == identity:
        return
    if head.result.version != __version__:
        why = f"of vibecalc {head.result.version}"
    elif _without_sweep(head.result.case) != _without_sweep(resolved):
        why = "of another case"
    else:
        why = "over other points, or of other quantities"
    raise UsageError(f"{output} is a sweep {why}; --fresh replaces it, -o names another file")


def complete(
    output: Path, identity: str, journal: Journal, mine: Iterable[int]
) -> Counter[int] | None:
    """Points by status, if the output is this sweep and has all points of the chunks `mine`.

    None if it is not, or if some points attached or died, which another try may change.
    """
    if not is_sweep(output):
        return None
    counts: Counter[int] = Counter()
    try:
        with open_sweep(output) as sweep:
            if sweep.head.identity != identity or sweep.count != journal.count:
                return None
            for number in mine:
                points = journal.points(number)
                counts.update(sweep.counts(int(points[0]), int(points[-1]) + 1))
    except ResultError:
        return None
    return None if any(counts[status] for status in (NOT_RUN, *UNLUCKY)) else counts


def take_up(
    journal: Journal, resume: bool, fresh: bool, note: Callable[[str], None]
) -> frozenset[int]:
    """Numbers of the chunks that need not be computed again, and the journal made ready.

    Chunks with a point that attached or died are computed again. UsageError if there are chunks
    and neither `resume` nor `fresh`, or chunks of another sweep and not `fresh`.
    """
    foreign, damage = journal.foreign(), journal.look()
    if foreign and not fresh:
        raise UsageError(
            f"{journal.path} holds {foreign} chunks of another sweep; "
            "--fresh throws them away, -o names another file"
        )
    if journal.places and not (resume or fresh):
        raise UsageError(
            f"{len(journal.places)} of {journal.chunks} chunks of this sweep are there from "
            f"before, in {journal.path}; --resume goes on with them, --fresh starts anew"
        )
    if not resume:
        journal.clear()
    elif damage:
        note(damage)
    return frozenset(
        number
        for number in journal.places
        if not np.isin(journal.read(number).status, UNLUCKY).any()
    )


def _without_sweep(case: Mapping[str, Any]) -> dict[str, Any]:
    return {name: table for name, table in case.items() if name != "sweep"}
