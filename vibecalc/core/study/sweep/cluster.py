"""Chunks of points handed to the workers of a dask cluster.

Each thread of a worker has a process of its own under it, in a pool of one: points time out and
processes die there as they do on one machine. A worker that is lost gives its chunk to another.
"""

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from vibecalc import __version__
from vibecalc.core.study.sweep.pool import Batch, ChunkResult, LostPoint, Pool, Work
from vibecalc.errors import UsageError

_ANSWER_WITHIN = 30  # seconds
_AHEAD = 2  # chunks for each thread, so that none waits for the next one
_LOST_WORKERS = 3  # times that a chunk is handed out again

_pools: dict[int, tuple[object, Pool]] = {}
_lock = threading.Lock()


class Cluster:
    """The workers of a cluster, as a `Pool` of one machine is used.

    Parameters
    ----------
    start : picklable function that returns the function from point numbers to a block.
    address : of the scheduler, `tcp://host:8786`, or its scheduler file.
    timeout, step : as for `Pool`.

    Raises UsageError if dask is not installed or no scheduler answers.
    """

    def __init__(
        self,
        start: Callable[[], Callable[[Any], Any]],
        *,
        address: str,
        timeout: float | None = None,
        step: int = 1,
    ):
        self._start, self._timeout, self._step = start, timeout, step
        self._key = os.urandom(16)
        self._client = _connect(address)

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the processes of this sweep and leave the cluster to others."""
        with suppress(Exception):  # whatever it is, the cluster is not there any more
            self._client.run(_close_pools, self._key, on_error="ignore")
        with suppress(Exception):
            self._client.close()

    def workers(self) -> int:
        """How many threads the cluster offers now."""
        return int(sum(self._client.nthreads().values()))

    def run(
        self, works: Iterable[Work], tell: Callable[[Batch | LostPoint], None] = lambda _: None
    ) -> Iterator[ChunkResult]:
        """Hand out chunks in their order and yield each as it is finished.

        Waits while the cluster has no workers. UsageError if the workers cannot be used;
        RuntimeError, with the traceback, for a mistake of ours in one of them.
        """
        waiting = iter(works)
        queue = _distributed().as_completed(loop=self._client.loop)
        running: dict[Any, tuple[Any, Work, int]] = {}
        try:
            while True:
                missing = max(1, _AHEAD * self.workers()) - len(running)
                for work in islice(waiting, max(missing, 0)):
                    self._submit(work, 0, running, queue)
                if not running:
                    return
                future = next(queue)
                _, work, losses = running.pop(future.key)
                done = _result(
                    future, losses if self._client.status == "running" else _LOST_WORKERS
                )
                if done is None:
                    self._submit(work, losses + 1, running, queue)
                    continue
                for batch in done.batches:
                    tell(batch)
                for lost in done.lost:
                    tell(lost)
                yield done
        except OSError as error:
            raise UsageError(f"the connection to the cluster is lost: {error}") from error
        finally:
            with suppress(Exception):
                self._client.cancel([future for future, _, _ in running.values()])

    def _submit(self, work: Work, losses: int, running: dict[Any, Any], queue: Any) -> None:
        future = self._client.submit(
            compute, self._key, self._start, work, self._timeout, self._step, __version__,
            pure=False, priority=-work.number,
        )  # fmt: skip
        running[future.key] = future, work, losses
        queue.add(future)


def compute(
    key: bytes,
    start: Callable[[], Callable[[Any], Any]],
    work: Work,
    timeout: float | None,
    step: int,
    version: str,
) -> ChunkResult:
    """Evaluate one chunk on a worker of the cluster, in the process of this thread."""
    if version != __version__:
        raise UsageError(f"a worker has vibecalc {__version__}, the sweep is of {version}")
    thread = threading.get_ident()
    with _lock:
        known, pool = _pools.get(thread, (None, None))
        if pool is None or known != key:
            if pool is not None:
                pool.close()
            pool = Pool(start, jobs=1, timeout=timeout, step=step)
            _pools[thread] = key, pool
    try:
        (done,) = pool.run([work])
    except BaseException:
        pool.close()
        with _lock:
            if _pools.get(thread) == (key, pool):
                del _pools[thread]
        raise
    return done


def _close_pools(key: bytes) -> None:
    with _lock:
        for thread, (known, pool) in list(_pools.items()):
            if known == key:
                pool.close()
                del _pools[thread]


def _result(future: Any, losses: int) -> ChunkResult | None:
    """What came out; None if the chunk has to be handed out again."""
    dask = _distributed()
    try:
        done: ChunkResult = future.result()
    except (dask.KilledWorker, dask.CancelledError) as error:
        if losses >= _LOST_WORKERS:
            raise UsageError(
                f"the cluster, or too many of its workers, is lost: {error}"
            ) from error
        return None
    return done


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
