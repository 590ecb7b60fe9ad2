"""Which rungs nothing beats: the Pareto front between error and cost."""

from collections.abc import Callable, Sequence

from vibecalc.accuracy.rung import Rung
from vibecalc.accuracy.topic import Topic


def front(rungs: Sequence[Rung], cost: Callable[[Rung], float]) -> tuple[bool, ...]:
    """Whether each rung is on the front: none is cheaper and as accurate, or as cheap and better.

    Errors within the noise of the topic count as equal, so that of several rungs at round-off
    only the cheapest stays. Rungs that were not measured are never on it.
    """
    return tuple(
        one.done and not any(_beats(other, one, cost) for other in rungs if other.done)
        for one in rungs
    )


def front_in_work(rungs: Sequence[Rung]) -> tuple[bool, ...]:
    """The front in counted work, the same on every machine."""
    return front(rungs, lambda rung: rung.work)


def front_in_seconds(rungs: Sequence[Rung]) -> tuple[bool, ...]:
    """The front in seconds, of this machine and this day."""
    return front(rungs, lambda rung: rung.seconds)


def extra_work(topic: Topic, rungs: Sequence[Rung]) -> float:
    """Work of the default over the least work of any rung that is as accurate; 1 on the front.

    Of several defaults (a topic may have more than one) the worst counts; infinite where a default
    failed or was not run, 1 where the topic has none. To be held against `topic.default_extra`.
    """
    return _extra(topic, rungs, lambda rung: rung.work)


def extra_seconds(topic: Topic, rungs: Sequence[Rung]) -> float:
    """The same in seconds."""
    return _extra(topic, rungs, lambda rung: rung.seconds)


def _extra(topic: Topic, rungs: Sequence[Rung], cost: Callable[[Rung], float]) -> float:
    asked = any(ladder.default is not None for ladder in topic.ladders)
    defaults = [rung for rung in rungs if rung.is_default]
    if asked and not defaults:
        raise ValueError(f"{topic.name}: the rungs are not of this topic, no default among them")
    worst = 1.0
    for default in defaults:
        if not default.done:
            return float("inf")
        equals = (cost(rung) for rung in rungs if rung.done and rung.error <= default.error)
        worst = max(worst, cost(default) / min(equals))
    return worst


def _beats(other: Rung, one: Rung, cost: Callable[[Rung], float]) -> bool:
    no_worse = cost(other) <= cost(one) and other.error <= one.error
    return no_worse and (cost(other) < cost(one) or other.error < one.error)
