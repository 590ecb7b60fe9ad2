"""The checks of physics for studies that change a case thousands of times, a little each time.

A check that found nothing finds nothing again where all that it reads is the same. As soon as one
finds something, all of them run, so that the problems are those of `machine.checks`, every time.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.errors import Problem
from vibecalc.machine.checks import ABSORBER, CHECKS, HARDWARE, check_machine
from vibecalc.machine.range_checks import ANGLES, LARGEST, LARGEST_ANGLE, SMALLEST
from vibecalc.pipeline.stage_cache import StageCache

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


#: places whose numbers have a range, each looked at by itself
_RANGES = (
    *(f"machine.{part}" for part in ("speed", "crank_train", "body", "mounts", "motor", "joints")),
    *(f"machine.{part}" for part in ("rotor", "shell", "friction", "pendulum")),
    "machine.shaft_line",
    *(place for place in ABSORBER if place != "tuning"),
    *HARDWARE,
    "excitation",
    "isolation",
    "response",
    "damper_design",
)


def check_again(case: "Case", cache: StageCache) -> list[Problem]:
    """`machine.checks.check_machine` with what `cache` knows of earlier cases."""
    now = cache.at(case, None)
    for place in _RANGES:
        key = now.key("range", (place,))
        if cache.find(key) is None:
            name, content = place.rpartition(".")[2], now.content(place)
            if any(_out_of_range(*number) for number in _numbers(content, name)):
                return check_machine(case)
            cache.keep(key, True)
    for check, places in CHECKS.items():
        key = now.key(check.__name__, places)
        if cache.find(key) is None:
            if check(case):
                return check_machine(case)
            cache.keep(key, True)
    return []


def _numbers(content: Any, name: str) -> Iterator[tuple[str, float]]:
    if isinstance(content, float):
        yield name, content
    elif isinstance(content, dict):
        for key, entry in content.items():
            yield from _numbers(entry, key)
    elif isinstance(content, tuple | list):
        for entry in content:
            yield from _numbers(entry, name)


def _out_of_range(name: str, value: float) -> bool:
    """Whether a number may be refused: one that may vanish counts here, too."""
    size = abs(value)
    return size > (LARGEST_ANGLE if name in ANGLES else LARGEST) or 0.0 < size < SMALLEST
