"""One process that works for a sweep: points come in on stdin, blocks of results go out on stdout.

Messages that come in: what to start with (a picklable function without arguments that returns
the function from point numbers to a block), then lists of point numbers, each with how many
points to evaluate in one call. Messages that go out: `("ready",)`, `("at", points)` before each
call, `("have", [(points, block), ...])` at the latest half a second after, `("done",)`, and
`("broken", traceback)` for an exception that nothing caught.
"""

import gc
import os
import sys
import threading
import time
import traceback
from queue import SimpleQueue
from typing import Any, BinaryIO

from vibecalc.study.sweep.frames import receive, send

_AT_LEAST_EVERY = 0.5  # seconds between two messages with results; what a death can cost


def main() -> None:
    """Work until stdin ends, also when that is in the middle of a point."""
    gc.set_threshold(100_000, 20, 20)  # as the command line does, and for the same reason
    incoming, outgoing = _own_streams()
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


def _own_streams() -> tuple[BinaryIO, BinaryIO]:
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
