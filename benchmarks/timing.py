"""How benchmarks take times: CPU seconds of one thread, the least of some repeats, in turns.

The ways that are compared take turns, so that a busy moment of the machine hits all of them.
"""

import os
import statistics
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

Work = Callable[[], object]


def in_turns(ways: Mapping[str, Work], repeats: int | Mapping[str, int]) -> dict[str, float]:
    """Least CPU seconds of each way, the ways taking turns; a way may have fewer repeats."""
    counts = {name: repeats if isinstance(repeats, int) else repeats[name] for name in ways}
    least = dict.fromkeys(ways, float("inf"))
    for turn in range(max(counts.values())):
        for name, work in ways.items():
            if turn < counts[name]:
                least[name] = min(least[name], cpu_of(work))
    return least


def cpu_of(work: Work) -> float:
    """CPU seconds of one call."""
    started = time.process_time()
    work()
    return time.process_time() - started


def best_of(work: Work, repeats: int = 5) -> float:
    """Least CPU seconds of some calls."""
    return min(cpu_of(work) for _ in range(repeats))


def each_of(work: Work, least: float = 0.01, repeats: int = 5) -> float:
    """Least CPU seconds of one call of something short, many of them in a row."""
    calls, spent = 1, cpu_of(work)
    while spent < least:
        calls = min(8 * calls, int(1.5 * calls * least / max(spent, 1e-6)) + 1)
        spent = _row(work, calls)
    return min([spent, *(_row(work, calls) for _ in range(repeats - 1))]) / calls


def _row(work: Work, calls: int) -> float:
    started = time.process_time()
    for _ in range(calls):
        work()
    return time.process_time() - started


def cpu_of_process(command: Sequence[str], **options: Any) -> float:
    """User and system seconds of a command in a fresh process."""
    before = os.times()
    subprocess.run(command, check=True, capture_output=True, **options)
    after = os.times()
    user = after.children_user - before.children_user
    return float(user + after.children_system - before.children_system)


def paired(
    first: Callable[[], float], second: Callable[[], float], pairs: int
) -> tuple[float, float, float]:
    """Medians of two times and of the ratio of each pair; a pair before them fills the caches."""
    found = [(first(), second()) for _ in range(pairs + 1)][1:]
    ratio = statistics.median(one / other for one, other in found)
    one, other = (statistics.median(column) for column in zip(*found, strict=True))
    return one, other, ratio


def memory_of_process(command: Sequence[str], **options: Any) -> float:
    """Largest resident memory of a command in a fresh process, MiB."""
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options
    ) as child:
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise subprocess.CalledProcessError(child.returncode, command)
    return used.ru_maxrss / 1024.0
