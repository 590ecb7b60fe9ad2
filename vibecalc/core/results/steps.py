"""What is being done, for whoever asks to hear of it: files read and written, stages, points."""

from collections.abc import Callable

from vibecalc.interrupts import check

_listener: Callable[[str], None] | None = None


def listen(listener: Callable[[str], None] | None) -> None:
    """Have every step told to `listener` from now on; None ends it."""
    global _listener
    _listener = listener


def step(words: str) -> None:
    """Tell that something is done, or begun; here an interrupt comes up that got lost before."""
    check()
    if _listener is not None:
        _listener(words)
