"""Points of a sweep in many processes: what hands them out, and what works on them."""

import contextlib
import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from queue import SimpleQueue
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.results.layout import DIED, TIMED_OUT
from vibecalc.errors import UsageError

# ----------------------------------------------------------------------------
# The handle on one working process: start it, give it points, hear it, end it.
# ----------------------------------------------------------------------------

#: one thread in each process: numpy reads these when it is imported
SINGLE_THREAD = dict.fromkeys(
    (
        "OPENBLAS_NUM_THREADS",
        "OMP_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
    ),
    "1",
)


class Process:
    """A process of `vibecalc.core.study.sweep.pool` and the line to it.

    It has a session of its own, so that Ctrl-C reaches the sweep alone, and ends when the sweep
    does. What it prints goes to stderr. UsageError if the system gives no process.
    """

    def __init__(self, start: bytes):
        self.line, theirs = Pipe()
        # -P and the path of this process: a file in the current folder is never taken for a module
        code = f"import sys; sys.path[:] = {sys.path!r}\n"
        code += f"from vibecalc.core.study.sweep.pool import main; main({theirs.fileno()})"
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", code],
                stdin=subprocess.DEVNULL,
                stdout=2,
                env={**os.environ, **SINGLE_THREAD},
                start_new_session=True,
                pass_fds=[theirs.fileno()],
            )
        except OSError as error:
            raise UsageError(f"cannot start a process for the sweep: {error}") from error
        finally:
            theirs.close()
        with contextlib.suppress(OSError):  # one that has ended says so by itself
            self.line.send_bytes(start)

    def hear(self) -> tuple[Any, ...]:
        """What it says next; `("gone", words)` after all that it said, whatever ended it."""
        try:
            message: tuple[Any, ...] = self.line.recv()
        except (EOFError, OSError):
            return ("gone", _ending(self._process.wait()))
        return message

    def give(self, points: list[int], step: int) -> None:
        """Hand over points, `step` to a call."""
        with contextlib.suppress(OSError):
            self.line.send((points, step))

    def end(self) -> None:
        """Stop it at once, whatever it does."""
        self._process.kill()
        self._process.wait()


def _ending(code: int) -> str:
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


# ----------------------------------------------------------------------------
# Chunks of points handed to processes of this machine; attached and dead ones are replaced.
#
# A point is given up as timed out when it takes longer than it may, and as fatal when two
# processes in a row died of it. Everything else of its chunk is still computed.
# ----------------------------------------------------------------------------

_DEATHS = 2
_STARTS = 3
_LONG = 3600.0


class Work(NamedTuple):
    """One chunk: its number and the numbers of its points."""

    number: int
    points: range


class Batch(NamedTuple):
    """Points that were evaluated in one call, and what came out."""

    points: list[int]
    block: Any


class LostPoint(NamedTuple):
    """A point without any result: why, and in words."""

    point: int
    status: int
    message: str


class ChunkResult(NamedTuple):
    """All that became of one chunk, in no particular order."""

    work: Work
    batches: list[Batch]
    lost: list[LostPoint]


@dataclass
class _Task:
    """A chunk under way: what is left of it, and what is known so far."""

    work: Work
    step: int
    left: list[int]
    batches: list[Batch] = field(default_factory=list)
    lost: list[LostPoint] = field(default_factory=list)
    deaths: Counter[int] = field(default_factory=Counter)

    def give_up(self, lost: LostPoint) -> None:
        self.lost.append(lost)
        self.left.remove(lost.point)


@dataclass
class _Desk:
    """A process and what it is doing: a call for the points `at`, under way since then."""

    process: Process
    ready: bool = False
    task: _Task | None = None
    at: list[int] = field(default_factory=list)
    since: float = 0.0


class Pool:
    """Processes on this machine, kept from one run to the next; close it in the end.

    Parameters
    ----------
    start : picklable function that returns the function from point numbers to a block.
    jobs : how many processes at most.
    timeout : seconds that one point may take; None is no bound.
    step : points in one call, where several in one are faster; 1 where each stands alone.
    """

    def __init__(
        self,
        start: Callable[[], Callable[[Any], Any]],
        *,
        jobs: int,
        timeout: float | None = None,
        step: int = 1,
    ):
        self._start = pickle.dumps(start, protocol=pickle.HIGHEST_PROTOCOL)
        self._jobs, self._timeout, self._step = jobs, timeout, step
        self._desks: dict[Process, _Desk] = {}
        self._failed_starts = 0
        self._closed = False

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes at once; a run under way, in another thread, ends with RuntimeError."""
        self._closed = True
        for process in list(self._desks):
            process.end()

    def run(
        self, works: Iterable[Work], tell: Callable[[Batch | LostPoint], None] = lambda _: None
    ) -> Iterator[ChunkResult]:
        """Hand out chunks in their order and yield each as it is finished.

        `tell` hears of every result at once. UsageError if processes die as they start;
        RuntimeError, with the traceback, for a mistake of ours in one of them. After an
        exception the pool can only be closed.
        """
        waiting = iter(works)
        backlog: deque[_Task] = deque()
        while True:
            self._hand_out(waiting, backlog)
            if all(desk.task is None for desk in self._desks.values()):
                return
            for desk in self._listen():
                done = self._take(desk, desk.process.hear(), backlog, tell)
                if done is not None:
                    self._hand_out(waiting, backlog)  # before somebody writes files
                    yield done
            self._end_attached(backlog, tell)

    def _hand_out(self, waiting: Iterator[Work], backlog: deque[_Task]) -> None:
        """Give a chunk to each process that is free; start processes while there is work."""
        free = [desk for desk in self._desks.values() if desk.task is None]
        while free or len(self._desks) < self._jobs:
            if not backlog:
                work = next(waiting, None)
                if work is None:
                    break
                backlog.append(_Task(work, self._step, list(work.points)))
            if not free:
                process = Process(self._start)
                self._desks[process] = _Desk(process)
                free.append(self._desks[process])
            desk = free.pop()
            desk.task = backlog.popleft()
            if desk.ready:
                desk.process.give(desk.task.left, desk.task.step)

    def _listen(self) -> list[_Desk]:
        """Wait until somebody has something to say, or for the first deadline."""
        ends = [desk.since + self._timeout * len(desk.at) for desk in self._desks.values()
                if self._timeout is not None and desk.at]  # fmt: skip
        patience = min(ends, default=time.monotonic() + _LONG) - time.monotonic()
        desks: dict[Any, _Desk] = {desk.process.line: desk for desk in self._desks.values()}
        found = wait(list(desks), max(patience, 0.0) + 1e-3)
        if self._closed:
            raise RuntimeError("the pool of processes was closed in the middle of its work")
        return [desks[line] for line in found]

    def _take(
        self,
        desk: _Desk,
        message: tuple[Any, ...],
        backlog: deque[_Task],
        tell: Callable[[Batch | LostPoint], None],
    ) -> ChunkResult | None:
        kind, *content = message
        task = desk.task
        if kind == "ready":
            desk.ready = True
            if task is not None:
                desk.process.give(task.left, task.step)
        elif kind == "broken":
            raise RuntimeError(f"in a process of the sweep:\n{content[0]}")
        elif kind == "gone":
            self._bury(desk, content[0], backlog, tell)
        elif task is not None:
            if kind == "at":
                desk.at, desk.since = content[0], time.monotonic()
                self._failed_starts = 0
            elif kind == "have":
                for points, block in content[0]:
                    task.batches.append(Batch(points, block))
                    tell(task.batches[-1])
                known = {point for points, _ in content[0] for point in points}
                task.left = [point for point in task.left if point not in known]
                desk.at = []
            elif kind == "done":
                desk.task, desk.at = None, []
                return ChunkResult(task.work, task.batches, task.lost)
        return None

    def _bury(
        self,
        desk: _Desk,
        words: str,
        backlog: deque[_Task],
        tell: Callable[[Batch | LostPoint], None],
    ) -> None:
        """Another process takes over what a dead one had; a point that kills twice is left out."""
        del self._desks[desk.process]
        desk.process.end()
        task = desk.task
        if task is None:
            return
        if not desk.at:
            self._failed_starts += 1
            if self._failed_starts >= _STARTS:
                raise UsageError(
                    f"{_STARTS} processes in a row ended ({words}) before their first point: "
                    "is there memory for them? -j 1 needs the least"
                )
        elif len(desk.at) > 1:
            task.step = 1
        else:
            (point,) = desk.at
            task.deaths[point] += 1
            if task.deaths[point] >= _DEATHS:
                task.give_up(
                    LostPoint(point, DIED, f"the process died twice at this point ({words})")
                )
                tell(task.lost[-1])
        backlog.appendleft(task)

    def _end_attached(
        self, backlog: deque[_Task], tell: Callable[[Batch | LostPoint], None]
    ) -> None:
        if self._timeout is None:
            return
        now = time.monotonic()
        for desk in list(self._desks.values()):
            task = desk.task
            if task is None or not desk.at or now < desk.since + self._timeout * len(desk.at):
                continue
            desk.process.end()
            del self._desks[desk.process]
            if len(desk.at) > 1:
                task.step = 1
            else:
                words = f"took longer than {self._timeout:g} s"
                task.give_up(LostPoint(desk.at[0], TIMED_OUT, words))
                tell(task.lost[-1])
            backlog.appendleft(task)


# ----------------------------------------------------------------------------
# Chunks computed in this process: for array calls that are over before a process has started.
# ----------------------------------------------------------------------------


class SerialPool:
    """This process, as a `Pool` is used; nothing guards it against points that hang or kill."""

    def __init__(self, start: Callable[[], Callable[[Any], Any]], *, step: int = 1):
        self._start, self._step = start, step

    def __enter__(self) -> "SerialPool":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def run(
        self, works: Iterable[Work], tell: Callable[[Batch | LostPoint], None] = lambda _: None
    ) -> Iterator[ChunkResult]:
        """Compute chunks in their order and yield each as it is finished."""
        evaluate = self._start()
        for work in works:
            batches = []
            for first in range(work.points.start, work.points.stop, self._step):
                points = list(range(first, min(first + self._step, work.points.stop)))
                batches.append(Batch(points, evaluate(np.array(points, dtype=np.int64))))
                tell(batches[-1])
            yield ChunkResult(work, batches, [])


# ----------------------------------------------------------------------------
# One process that works for a sweep, at the other end of its line.
#
# Messages that come in: what to start with (a picklable function without arguments that returns
# the function from point numbers to a block), then lists of point numbers, each with how many
# points to evaluate in one call. Messages that go out: `("ready",)`, `("at", points)` before each
# call, `("have", [(points, block), ...])` at the latest half a second after, `("done",)`, and
# `("broken", traceback)` for an exception that nothing caught.
# ----------------------------------------------------------------------------

_AT_LEAST_EVERY = 0.5  # seconds between two messages with results; what a death can cost


def main(descriptor: int) -> None:
    """Work until the line ends, also when that is in the middle of a point."""
    gc.set_threshold(100_000, 20, 20)  # as the command line does, and for the same reason
    line: Connection = Connection(descriptor)
    tasks: SimpleQueue[tuple[list[int], int]] = SimpleQueue()
    try:
        start = line.recv()
        threading.Thread(target=_read, args=(line, tasks), daemon=True).start()
        evaluate = start()
        line.send(("ready",))
        while True:
            _work(evaluate, *tasks.get(), line)
    except (EOFError, ConnectionError):  # nobody listens any more
        os._exit(1)
    except Exception:
        line.send(("broken", traceback.format_exc()))
        os._exit(1)


def _work(evaluate: Any, points: list[int], step: int, line: Connection) -> None:
    have: list[tuple[list[int], Any]] = []
    last = time.monotonic()
    for first in range(0, len(points), step):
        some = points[first : first + step]
        line.send(("at", some))
        have.append((some, evaluate(np.array(some, dtype=np.int64))))
        if time.monotonic() - last > _AT_LEAST_EVERY:
            line.send(("have", have))
            have, last = [], time.monotonic()
    if have:
        line.send(("have", have))
    line.send(("done",))


def _read(line: Connection, tasks: "SimpleQueue[tuple[list[int], int]]") -> None:
    """Pass messages on; without the sweep at the other end there is nothing to work for."""
    while True:
        try:
            tasks.put(line.recv())
        except (EOFError, OSError):
            os._exit(0)
