"""Points of a sweep in processes: of this machine, or under the workers of a dask cluster.

Chunks go to the threads of an executor, here or of dask. Each thread has a process of its own,
which is replaced where a point hangs or kills it.
"""

import contextlib
import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from importlib import import_module
from itertools import islice
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

import numpy as np

from vibecalc import __version__
from vibecalc.core.results.layout import DIED, TIMED_OUT
from vibecalc.core.study.sweep.blocks import one_point
from vibecalc.errors import UsageError

#: picklable; gives, in the process that works, the function from point numbers to a block
Start = Callable[[], Callable[[np.ndarray], Any]]


class How(NamedTuple):
    """A pickled `Start`, the seconds that one point may take (None is no bound), and the points in
    one call; `key` is of one sweep alone."""

    start: bytes
    timeout: float | None
    step: int
    key: bytes


# ----------------------------------------------------------------------------
# A process that works for a sweep.
#
# It hears how, then lists of point numbers, each with how many points to evaluate in one call. It
# says `("ready", None)`, `("have", block)` after each call, and `("broken", traceback)` for an
# exception that nothing caught. An alarm of the system ends it where a call takes too long.
# ----------------------------------------------------------------------------


def main(descriptor: int) -> None:
    """Work until the line ends, also when that is in the middle of a point."""
    gc.set_threshold(100_000, 20, 20)  # as the command line does, and for the same reason
    line: Connection = Connection(descriptor)
    tasks: SimpleQueue[tuple[list[int], int]] = SimpleQueue()

    def read() -> None:
        """Pass messages on; without the sweep at the other end there is nothing to work for."""
        with contextlib.suppress(EOFError, OSError):
            while True:
                tasks.put(line.recv())
        os._exit(0)

    try:
        how = line.recv()
        threading.Thread(target=read, daemon=True).start()
        evaluate = pickle.loads(how.start)()
        line.send(("ready", None))
        while True:
            points, step = tasks.get()
            for first in range(0, len(points), step):
                some = np.array(points[first : first + step])
                signal.setitimer(signal.ITIMER_REAL, (how.timeout or 0.0) * len(some))
                found = evaluate(some)
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                line.send(("have", found))
    except (EOFError, ConnectionError):  # nobody listens any more
        os._exit(1)
    except Exception:
        line.send(("broken", traceback.format_exc()))
        os._exit(1)


# ----------------------------------------------------------------------------
# The points of one chunk after another in one such process.
#
# A point is given up as timed out when it takes longer than it may, and as fatal when two
# processes in a row died of it. Everything else of its chunk is still computed.
# ----------------------------------------------------------------------------

#: one thread in each process: numpy reads these when it is imported
_COUNTED = ("OPENBLAS_NUM", "OMP_NUM", "MKL_NUM", "BLIS_NUM", "VECLIB_MAXIMUM", "NUMEXPR_NUM")
SINGLE_THREAD = {f"{name}_THREADS": "1" for name in _COUNTED}
_DEATHS = 2
_STARTS = 3


class Guard:
    """A process for one thread, kept from one chunk to the next, and replaced when it has ended.

    It has a session of its own, so that Ctrl-C reaches the sweep alone, and ends when the sweep
    does. What it prints goes to stderr.
    """

    def __init__(self, how: How):
        self.how = how
        self._process: subprocess.Popen[bytes] | None = None
        self._line: Connection
        self._closed = False

    def compute(self, points: range) -> list[Any]:
        """What the points gave, call by call, and a `Block` for each point that gave nothing.

        UsageError if processes die as they start, or the system gives none; RuntimeError, with the
        traceback, for a mistake of ours in one of them, and after `close`.
        """
        left, step, found = list(points), self.how.step, []
        deaths, given = 0, False
        while left:
            if not given:
                self._start()
                self._say((left, step))
            said, what = self._hear()
            given = said == "have"
            if given:
                found.append(what)
                del left[:step]
                deaths = 0
            elif min(step, len(left)) > 1:  # which of them it was, each alone will tell
                step = 1
            elif what == "SIGALRM":
                words = f"took longer than {self.how.timeout:g} s"
                found.append(one_point(left.pop(0), TIMED_OUT, words))
                deaths = 0
            elif deaths + 1 < _DEATHS:
                deaths += 1
            else:
                words = f"the process died twice at this point ({what})"
                found.append(one_point(left.pop(0), DIED, words))
                deaths = 0
        return found

    def _start(self) -> None:
        """Have a process that is ready."""
        words = ""
        for _ in range(_STARTS):
            if self._process is not None:
                return
            self._line, theirs = Pipe()
            # -P and the path of this process: a file in the current folder is no module
            code = f"import sys; sys.path[:] = {sys.path!r}\n"
            code += f"from vibecalc.core.study.sweep.workers import main; main({theirs.fileno()})"
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
            if self._closed:
                self.close()
            self._say(self.how)
            _, words = self._hear()
        if self._process is None:
            raise UsageError(
                f"{_STARTS} processes in a row ended ({words}) before their first point: "
                "is there memory for them? -j 1 needs the least"
            )

    def _say(self, what: Any) -> None:
        with contextlib.suppress(OSError):  # one that has ended is heard
            self._line.send(what)

    def _hear(self) -> tuple[str, Any]:
        """What the process says next: `("gone", words)` at its end."""
        process = self._process
        try:
            said, what = self._line.recv()
        except (EOFError, OSError):
            code = 0 if process is None else process.wait()
            known = -code in set(signal.Signals)
            said, what = "gone", signal.Signals(-code).name if known else f"exit code {code}"
            self._process = None
        if self._closed:
            raise RuntimeError("the sweep has ended")
        if said == "broken":
            raise RuntimeError(f"in a process of the sweep:\n{what}")
        return said, what

    def close(self) -> None:
        """End the process at once; `compute`, in another thread, ends with RuntimeError."""
        self._closed, process = True, self._process
        if process is not None:
            process.kill()
            process.wait()


# ----------------------------------------------------------------------------
# Threads that each have such a guard: of this process, or of a worker of a cluster.
# ----------------------------------------------------------------------------

_guards: dict[int, Guard] = {}
_ended: set[bytes] = set()
_lock = threading.Lock()


def compute(how: How, points: range, version: str) -> list[Any]:
    """Evaluate one chunk in the process of this thread."""
    if version != __version__:
        raise UsageError(f"a worker has vibecalc {__version__}, the sweep is of {version}")
    thread = threading.get_ident()
    with _lock:
        if how.key in _ended:
            raise RuntimeError("the sweep has ended")
        guard = _guards.get(thread)
        if guard is None or guard.how.key != how.key:
            if guard is not None:
                guard.close()
            guard = _guards[thread] = Guard(how)
    try:
        return guard.compute(points)
    except BaseException:
        guard.close()
        with _lock:
            _guards.pop(thread, None)
        raise


def end(key: bytes) -> None:
    """End all processes of a sweep in the threads of this process, and start no more."""
    with _lock:
        _ended.add(key)
        for thread, guard in list(_guards.items()):
            if guard.how.key == key:
                guard.close()
                del _guards[thread]


# ----------------------------------------------------------------------------
# Chunks handed to an executor.
# ----------------------------------------------------------------------------

_ANSWER_WITHIN = 30  # seconds
_AHEAD = 2  # chunks for each thread, so that none waits for the next one


class Workers:
    """Processes for a sweep: `jobs` of this machine, or those of a cluster; close it in the end.

    `cluster` is the address of a scheduler of dask, `tcp://host:8786`, or its scheduler file.
    `timeout` is in seconds for one point, `step` the points in one call, 1 where each stands alone.
    UsageError if dask is not installed or no scheduler answers.
    """

    def __init__(
        self,
        start: Start,
        *,
        jobs: int = 1,
        cluster: str | None = None,
        timeout: float | None = None,
        step: int = 1,
    ):
        self._how = How(pickle.dumps(start), timeout, step, os.urandom(16))
        self._jobs = jobs
        self._client: Any = None if cluster is None else _connect(cluster)
        self._executor: Executor = (
            ThreadPoolExecutor(jobs)
            if self._client is None
            else self._client.get_executor(pure=False)
        )

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes of this sweep at once; leave a cluster to others."""
        if self._client is None:
            self._executor.shutdown(wait=False, cancel_futures=True)
            end(self._how.key)
            self._executor.shutdown()
            return
        with contextlib.suppress(Exception):  # whatever it is, the cluster is not there any more
            self._executor.shutdown(wait=False)
            self._client.run(end, self._how.key, on_error="ignore")
        with contextlib.suppress(Exception):
            self._client.close()

    def threads(self) -> int:
        """How many threads there are now."""
        client = self._client
        return self._jobs if client is None else int(sum(client.nthreads().values()))

    def run(self, works: Iterable[range]) -> Iterator[tuple[range, list[Any]]]:
        """Hand out chunks in their order and yield each, with what came of it, when it is finished.

        Waits while a cluster has no workers. UsageError if the workers cannot be used;
        RuntimeError, with the traceback, for a mistake of ours in one of them.
        """
        waiting = iter(works)
        running: dict[Future[list[Any]], range] = {}
        try:
            while True:
                room = max(_AHEAD * self.threads(), 1) - len(running)
                for points in islice(waiting, max(room, 0)):
                    future = self._executor.submit(compute, self._how, points, __version__)
                    running[future] = points
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), self._result(future)
        except OSError as error:
            raise UsageError(f"the connection to the cluster is lost: {error}") from error

    def _result(self, future: "Future[list[Any]]") -> list[Any]:
        """What a worker gave; a cluster hands out the chunks of one that is lost by itself."""
        lost = (CancelledError, _distributed().KilledWorker) if self._client else CancelledError
        try:
            return future.result()
        except lost as error:
            raise UsageError(
                f"the cluster, or too many of its workers, is lost: {error}"
            ) from error


def here(start: Start, works: Iterable[range]) -> Iterator[tuple[range, list[Any]]]:
    """The same in this process, for what is over before another has started."""
    evaluate = start()
    for points in works:
        yield points, [evaluate(np.array(points))]


def _connect(address: str) -> Any:
    dask = _distributed()
    is_file = "://" not in address and (address.endswith(".json") or Path(address).is_file())
    if is_file and not Path(address).is_file():
        raise UsageError(f"there is no scheduler file {address}")
    place = {"scheduler_file": address} if is_file else {"address": address}
    try:
        return dask.Client(**place, timeout=_ANSWER_WITHIN, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise UsageError(f"no dask scheduler answers at {address}: {error}") from error


def _distributed() -> Any:
    """The package, which says nothing of its types; UsageError if it is not installed."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise UsageError(
            "--cluster needs dask: pip install 'vibecalc[cluster]', here and on the workers"
        ) from error
