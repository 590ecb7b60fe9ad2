"""Points of a sweep in many processes: what hands them out, and what works on them."""

import contextlib
import gc
import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import IO, Any, BinaryIO, NamedTuple

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

Heard = SimpleQueue[tuple["Process", tuple[Any, ...]]]


class Process:
    """A process of `vibecalc.core.study.sweep.pool`; what it says goes into a queue.

    After all that it said comes `("gone", words)`, whatever ended it. It has a session of its
    own, so that Ctrl-C reaches the sweep alone, and ends when the sweep does. UsageError if the
    system gives no process.
    """

    def __init__(self, start: bytes, heard: Heard):
        # -P and the path of this process: a file in the current folder is never taken for a module
        code = f"import sys; sys.path[:] = {sys.path!r}\n"
        code += "from vibecalc.core.study.sweep.pool import main; main()"
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", code],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env={**os.environ, **SINGLE_THREAD},
                start_new_session=True,
            )
        except OSError as error:
            raise UsageError(f"cannot start a process for the sweep: {error}") from error
        threading.Thread(target=self._listen, args=(start, heard), daemon=True).start()

    def _listen(self, start: bytes, heard: Heard) -> None:
        assert self._process.stdin is not None and self._process.stdout is not None
        with contextlib.suppress(EOFError, OSError):
            send(self._process.stdin, start)
            while True:
                heard.put((self, receive(self._process.stdout)))
        self._process.stdout.close()
        heard.put((self, ("gone", _ending(self._process.wait()))))

    def give(self, points: list[int], step: int) -> None:
        """Hand over points, `step` to a call; a process that has ended says so by itself."""
        assert self._process.stdin is not None
        with contextlib.suppress(OSError, ValueError):
            send(self._process.stdin, (points, step))

    def end(self) -> None:
        """Stop it at once, whatever it does."""
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()


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
        self._start = packed(start)
        self._jobs, self._timeout, self._step = jobs, timeout, step
        self._heard: Heard = SimpleQueue()
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
            for process, message in self._listen():
                desk = self._desks.get(process)
                if desk is None:  # ended already, and so nobody's word
                    continue
                done = self._take(desk, message, backlog, tell)
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
                process = Process(self._start, self._heard)
                self._desks[process] = _Desk(process)
                free.append(self._desks[process])
            desk = free.pop()
            desk.task = backlog.popleft()
            if desk.ready:
                desk.process.give(desk.task.left, desk.task.step)

    def _listen(self) -> list[tuple[Process, tuple[Any, ...]]]:
        """Wait for a message, or for the first deadline; then all that is there."""
        ends = [desk.since + self._timeout * len(desk.at) for desk in self._desks.values()
                if self._timeout is not None and desk.at]  # fmt: skip
        patience = min(ends, default=time.monotonic() + _LONG) - time.monotonic()
        found = []
        try:
            found.append(self._heard.get(timeout=max(patience, 0.0) + 1e-3))
            while True:
                found.append(self._heard.get_nowait())
        except Empty:
            pass
        if self._closed:
            raise RuntimeError("the pool of processes was closed in the middle of its work")
        return found

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
# Messages between a sweep and the processes that work for it: pickles, each with its length.
# ----------------------------------------------------------------------------

_LENGTH = struct.Struct(">Q")


def send(stream: IO[bytes], message: Any) -> None:
    """Write one message; OSError if nobody reads any more."""
    content = message if isinstance(message, bytes) else packed(message)
    stream.write(_LENGTH.pack(len(content)))
    stream.write(content)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read one message; EOFError at the end, also in the middle of a message."""
    (length,) = _LENGTH.unpack(_exactly(stream, _LENGTH.size))
    return pickle.loads(_exactly(stream, length))


def packed(message: Any) -> bytes:
    """A message as bytes, for one that is sent several times."""
    return pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)


def _exactly(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content


# ----------------------------------------------------------------------------
# One process that works for a sweep: points come in on stdin, blocks of results go out on stdout.
#
# Messages that come in: what to start with (a picklable function without arguments that returns
# the function from point numbers to a block), then lists of point numbers, each with how many
# points to evaluate in one call. Messages that go out: `("ready",)`, `("at", points)` before each
# call, `("have", [(points, block), ...])` at the latest half a second after, `("done",)`, and
# `("broken", traceback)` for an exception that nothing caught.
# ----------------------------------------------------------------------------

_AT_LEAST_EVERY = 0.5  # seconds between two messages with results; what a death can cost


def main() -> None:
    """Work until stdin ends, also when that is in the middle of a point."""
    gc.set_threshold(100_000, 20, 20)  # as the command line does, and for the same reason
    incoming, outgoing = _process_streams()
    tasks: SimpleQueue[Any] = SimpleQueue()
    threading.Thread(target=_read, args=(incoming, tasks), daemon=True).start()
    try:
        evaluate = tasks.get()()
        send(outgoing, ("ready",))
        while True:
            points, step = tasks.get()
            _work(evaluate, points, step, outgoing)
    except BrokenPipeError:
        os._exit(1)
    except Exception:
        send(outgoing, ("broken", traceback.format_exc()))
        os._exit(1)


def _work(evaluate: Any, points: list[int], step: int, outgoing: BinaryIO) -> None:
    import numpy as np

    have: list[tuple[list[int], Any]] = []
    last = time.monotonic()
    for first in range(0, len(points), step):
        some = points[first : first + step]
        send(outgoing, ("at", some))
        have.append((some, evaluate(np.array(some, dtype=np.int64))))
        if time.monotonic() - last > _AT_LEAST_EVERY:
            send(outgoing, ("have", have))
            have, last = [], time.monotonic()
    if have:
        send(outgoing, ("have", have))
    send(outgoing, ("done",))


def _process_streams() -> tuple[BinaryIO, BinaryIO]:
    """The two pipes to the sweep, out of reach of whatever prints or reads in this process."""
    sys.stdout.flush()
    incoming, outgoing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    return incoming, outgoing


def _read(incoming: BinaryIO, tasks: "SimpleQueue[Any]") -> None:
    """Pass messages on; without the sweep at the other end there is nothing to work for."""
    try:
        while True:
            tasks.put(receive(incoming))
    except EOFError:
        os._exit(0)
    except Exception:  # the function to start with cannot be imported here
        text = traceback.format_exc()

        def broken() -> None:
            raise ImportError(text)

        tasks.put(broken)
