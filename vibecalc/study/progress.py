"""What a long run is busy with, on stderr while it lasts, on a terminal only."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: seconds before anything is said, and between two changes of it
_QUIET, _STEP = 2.0, 0.5
_WIDTH = 78


@contextmanager
def telling(wanted: bool) -> Iterator[Callable[[str], None]]:
    """Give a function that takes the name of each stage as it begins.

    A run of less than two seconds says nothing; of a longer one the line names the stage and
    counts its seconds, and is wiped out at the end. It needs no library, so that a short run is no
    slower for it.
    """
    if not (wanted and sys.stderr.isatty()):
        yield lambda stage: None
        return
    busy, done = [("", time.monotonic())], threading.Event()

    def begin(stage: str) -> None:
        busy[0] = (stage, time.monotonic())

    def tell() -> None:
        wait = _QUIET
        while not done.wait(wait):
            stage, since = busy[0]
            words = f"computing: {stage}, {time.monotonic() - since:.0f} s"
            sys.stderr.write(f"\r{words[:_WIDTH]:<{_WIDTH}}")
            sys.stderr.flush()
            wait = _STEP
        if wait == _STEP:
            sys.stderr.write(f"\r{'':<{_WIDTH}}\r")
            sys.stderr.flush()

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield begin
    finally:
        done.set()
        teller.join()
