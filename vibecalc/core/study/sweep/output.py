"""The output of a sweep before it starts: held by one sweep alone, taken up or thrown away."""

import os
import socket
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc import __version__
from vibecalc.core.results.files import in_words
from vibecalc.core.results.sweep_file import SweepHead, open_sweep
from vibecalc.core.study.sweep.prepare import PreparedSweep
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
        path.write_text(f"process {os.getpid()} on {socket.gethostname()}", encoding="utf-8")
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


def points_in(output: Path, prepared: PreparedSweep, fresh: bool) -> np.ndarray:
    """What became of each point (n,), as the output has it; none where it is not there.

    UsageError for a file that this sweep did not make; if `fresh`, it has no points of this sweep.
    """
    nothing = np.empty(0, dtype=np.int8)
    if not output.exists():
        return nothing
    try:
        with open_sweep(output) as sweep:
            head, status = sweep.head, sweep.status().ravel()
    except ResultError as error:
        why = str(error)
    else:
        if head.identity == prepared.identity:
            return status
        other = otherwise(head, __version__, prepared.design.description(), prepared.keep)
        why = f"{output} is a sweep {other}"
    if fresh:
        return nothing
    raise UsageError(f"{why}; --fresh replaces it, -o names another file")


def otherwise(head: SweepHead, version: str, design: Mapping[str, Any], kept: Sequence[str]) -> str:
    """In what another sweep differs from one of this version, design and kept quantities."""
    if head.result.version != version:
        return f"of vibecalc {head.result.version}"
    if head.design != design:
        return "over other points"
    return "of other quantities" if set(head.stored) != set(kept) else "of another case"
