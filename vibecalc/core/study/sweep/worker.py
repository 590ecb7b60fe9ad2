"""One process that works for a sweep, and the messages between both."""

import gc
import os
import pickle
import struct
import sys
import threading
import time
import traceback
from queue import SimpleQueue
from typing import IO, Any, BinaryIO

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
