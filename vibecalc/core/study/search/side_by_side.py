"""Searches side by side: what each is about to evaluate is computed for all of them at once."""

import threading
from collections.abc import Callable, Sequence
from contextvars import copy_context
from typing import Generic, TypeVar

import numpy as np

# ----------------------------------------------------------------------------
# Many points computed at once take little longer than one, and a search asks for few at a time. So
# each runs until it asks, and when all have asked what they ask for is computed together. Each has
# a thread, of which only one runs at any time: a library that calls for values from within its own
# loop can be left waiting, and nothing depends on which thread is faster.
# ----------------------------------------------------------------------------

Found = TypeVar("Found")
#: said by a search which points it is about to evaluate; returns when they have been computed
Ask = Callable[[Sequence[np.ndarray]], None]


class Abandoned(BaseException):
    """A search that nobody waits for any more is to end."""


class _Turn(Generic[Found]):
    """One search, which runs from each `advance` to where it asks for points or ends."""

    def __init__(self, search: Callable[[Ask], Found]):
        self._search = search
        self._go, self._pause = threading.Semaphore(0), threading.Semaphore(0)
        self.asked: Sequence[np.ndarray] = ()
        self.found: list[Found] = []
        self.ended, self._abandoned = False, False
        self._error: BaseException | None = None
        # numpy's treatment of overflows is that of the thread that began
        threading.Thread(target=copy_context().run, args=(self._run,), daemon=True).start()

    def advance(self) -> None:
        """Let it run on; raises what it raises."""
        self.asked = ()
        self._go.release()
        self._pause.acquire()
        if self._error is not None:
            raise self._error

    def abandon(self) -> None:
        """Let it end where it waits, if it does."""
        self._abandoned = True
        self._go.release()

    def _run(self) -> None:
        self._go.acquire()
        try:
            if not self._abandoned:
                self.found.append(self._search(self._ask))
        except BaseException as error:
            self._error = error
        self.ended = True
        self._pause.release()

    def _ask(self, points: Sequence[np.ndarray]) -> None:
        self.asked = points
        self._pause.release()
        self._go.acquire()
        if self._abandoned:
            raise Abandoned


def side_by_side(searches: Sequence[Callable[[Ask], Found]], ahead: Ask) -> list[Found]:
    """What each search finds; `ahead` computes what all of them ask for.

    Raises what the first of them raises; the others end then.
    """
    turns = [_Turn(search) for search in searches]
    running = turns
    try:
        while running:
            for one in running:
                one.advance()
            running = [one for one in running if not one.ended]
            ahead([point for one in running for point in one.asked])
    finally:
        for one in running:
            one.abandon()
    return [one.found[0] for one in turns]
