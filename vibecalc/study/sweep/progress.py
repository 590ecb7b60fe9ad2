"""How far a sweep is, on stderr and on a terminal only."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: called with how many points were finished, and how many of them failed
Advance = Callable[[int, int], None]


@contextmanager
def shown(points: int, finished: int, wanted: bool) -> Iterator[Advance]:
    """A bar with rate, time left and failures so far, for `points` of which some are `finished`.

    Where nobody looks, what is yielded does nothing. Points that were finished before count for
    the length of the bar and not for the rate.
    """
    if not (wanted and sys.stderr.isatty()):
        yield lambda points, failures: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("sweep"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[failed]}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=points, completed=finished, rate="", failed="")
        failures = 0

        def advance(more: int, failed: int) -> None:
            nonlocal failures
            failures += failed
            speed = bar.tasks[0].speed
            bar.update(
                task,
                advance=more,
                rate=f"{speed:.3g}/s" if speed else "",
                failed=f"{failures} failed" if failures else "",
            )

        yield advance
