"""The handle on one working process: start it, give it points, hear it, end it."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from queue import SimpleQueue
from typing import Any

from vibecalc.errors import UsageError
from vibecalc.study.sweep.frames import receive, send

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
    """A process of `vibecalc.study.sweep.worker`; what it says goes into a queue.

    After all that it said comes `("gone", words)`, whatever ended it. It has a session of its
    own, so that Ctrl-C reaches the sweep alone, and ends when the sweep does. UsageError if the
    system gives no process.
    """

    def __init__(self, start: bytes, heard: Heard):
        # -P and the path of this process: a file in the current folder is never taken for a module
        code = f"import sys; sys.path[:] = {sys.path!r}\n"
        code += "from vibecalc.study.sweep.worker import main; main()"
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
