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
from vibecalc.core.results.layout import NOT_RUN, UNLUCKY
from vibecalc.core.results.sweep_file import SweepResult, is_sweep, open_sweep
from vibecalc.core.study.sweep.blocks import ChunkFolder, Survey
from vibecalc.core.study.sweep.prepare import Identity
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
    try:
        lock.acquire(timeout=0)
        path.write_text(f"process {os.getpid()} on {socket.gethostname()}", encoding="utf-8")
    except Timeout:
        raise UsageError(f"another sweep{_holder(path)} is writing {output}") from None
    except OSError as error:
        if lock.is_locked:
            with suppress(OSError):
                path.unlink()
        lock.release()
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot make the lock file {path}: {reason}") from error
    try:
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

#: name of the file that is put together from the chunks, before it is in its place
ASSEMBLED = "assembled.h5"

_AT_ONCE = 1 << 16


def check_output(output: Path, identity: Identity, resolved: Mapping[str, Any]) -> None:
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
    if head.identity == identity.sweep:
        return
    if head.result.version != __version__:
        why = f"of vibecalc {head.result.version}"
    elif _without_sweep(head.result.case) != _without_sweep(resolved):
        why = "of another case"
    else:
        why = "over other points, or of other quantities"
    raise UsageError(f"{output} is a sweep {why}; --fresh replaces it, -o names another file")


def complete(
    output: Path, identity: Identity, chunks: ChunkFolder, mine: Iterable[int]
) -> Counter[int] | None:
    """Points by status, if the output is this sweep and has all points of the chunks `mine`.

    None if it is not, or if some points attached or died, which another try may change.
    """
    if not is_sweep(output):
        return None
    counts: Counter[int] = Counter()
    try:
        with open_sweep(output) as sweep:
            if sweep.head.identity != identity.sweep or sweep.count != chunks.count:
                return None
            for number in mine:
                points = chunks.points(number)
                _count(sweep, int(points[0]), int(points[-1]) + 1, counts)
    except ResultError:
        return None
    return None if any(counts[status] for status in (NOT_RUN, *UNLUCKY)) else counts


def take_up(
    chunks: ChunkFolder, resume: bool, fresh: bool, note: Callable[[str], None]
) -> frozenset[int]:
    """Numbers of the chunks that need not be computed again, and the folder put in order.

    Chunks with a point that attached or died are computed again. UsageError if there are chunks
    and neither `resume` nor `fresh`, or chunks of another sweep and not `fresh`.
    """
    survey = chunks.survey()
    _remove(chunks.folder / ASSEMBLED)
    if not resume:
        if not fresh:
            _refuse(survey, chunks)
        chunks.clear()
        return frozenset()
    if survey.foreign and not fresh:
        raise UsageError(
            f"{len(survey.foreign)} chunks in {chunks.folder} are of another sweep; --resume "
            "--fresh takes up what fits and throws the rest away, -o names another file"
        )
    for path, reason in survey.damaged:
        note(f"{reason}; it is computed again")
        _remove(path)
    for path in (*survey.foreign, *survey.unfinished):
        _remove(path)
    return frozenset(number for number in survey.finished if not _unlucky(chunks, number))


def _without_sweep(case: Mapping[str, Any]) -> dict[str, Any]:
    return {name: table for name, table in case.items() if name != "sweep"}


def _refuse(survey: Survey, chunks: ChunkFolder) -> None:
    if survey.foreign:
        raise UsageError(
            f"{chunks.folder} holds {len(survey.foreign)} chunks of another sweep; "
            "--fresh throws them away, -o names another file"
        )
    if survey.finished or survey.damaged:
        raise UsageError(
            f"{len(survey.finished)} of {chunks.chunks} chunks of this sweep are there from "
            f"before, in {chunks.folder}; --resume goes on with them, --fresh starts anew"
        )


def _unlucky(chunks: ChunkFolder, number: int) -> bool:
    return bool(np.isin(chunks.read(number).status, UNLUCKY).any())


def _count(sweep: SweepResult, first: int, last: int, counts: Counter[int]) -> None:
    for start in range(first, last, _AT_ONCE):
        statuses = sweep.status_of(start, min(start + _AT_ONCE, last))
        for status, many in zip(*np.unique(statuses, return_counts=True), strict=True):
            counts[int(status)] += int(many)


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise UsageError(f"cannot remove {path}: {reason}") from error
