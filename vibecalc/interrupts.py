"""Ctrl-C, and the end of a job or of a terminal: one exception that reaches whoever cleans up."""

import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

#: from the keyboard, from a batch system, from a terminal that closes
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

_came = False


@contextmanager
def listening() -> Iterator[None]:
    """Have each of these signals raise KeyboardInterrupt, but for those that are ignored.

    `nohup`, and a shell that starts a command in the background, have some of them ignored.
    """
    global _came
    _came = False
    heard = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    with _handled(heard, _interrupt):
        yield


def _interrupt(_number: int, _frame: Any) -> None:
    global _came
    _came = True
    raise KeyboardInterrupt


def check() -> None:
    """Raise KeyboardInterrupt again where a library has swallowed it.

    pydantic takes it for a member of a union that does not fit, and tries the next one.
    """
    global _came
    if _came and sys.exc_info()[0] is None:
        _came = False
        raise KeyboardInterrupt


def came() -> bool:
    """Whether an interrupt came whose exception may have become another."""
    return _came


def met() -> None:
    """Have the exit code end the process, and not a signal.

    Where KeyboardInterrupt came inside an `exec` of a text, as dataclasses use it, Python would end
    itself by SIGINT whatever the exit code, unless another text is evaluated after it.
    """
    eval("None")


@contextmanager
def held_back() -> Iterator[Callable[[], None]]:
    """Signals wait until what this gives is called, since HDF5 does not survive them half-way."""
    came: list[int] = []

    def stop() -> None:
        if came:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield stop  # signals come to the main thread alone
        return
    with _handled(_SIGNALS, lambda number, _frame: came.append(number)):
        yield stop


@contextmanager
def _handled(numbers: Sequence[int], handler: Callable[[int, Any], None]) -> Iterator[None]:
    before = [signal.signal(number, handler) for number in numbers]
    try:
        yield
    finally:
        for number, old in zip(numbers, before, strict=True):
            signal.signal(number, signal.SIG_DFL if old is None else old)
