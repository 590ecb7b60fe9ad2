"""The cheapest method and setting that reaches an error."""

from collections.abc import Callable, Sequence

from vibecalc.accuracy.rung import Rung
from vibecalc.results.accuracy_layout import TARGETS


def cheapest(rungs: Sequence[Rung], target: float, cost: Callable[[Rung], float]) -> int | None:
    """Place of the cheapest rung whose worst relative error is at most `target`, None without one.

    Of equally cheap ones the more accurate is taken, then the first.
    """
    reaching = [
        (cost(rung), rung.error, place)
        for place, rung in enumerate(rungs)
        if rung.done and rung.worst_relative <= target
    ]
    return min(reaching)[2] if reaching else None


def cheapest_in_work(rungs: Sequence[Rung]) -> tuple[int | None, ...]:
    """For each of `TARGETS`, by counted work."""
    return tuple(cheapest(rungs, target, lambda rung: rung.work) for target in TARGETS)


def cheapest_in_seconds(rungs: Sequence[Rung]) -> tuple[int | None, ...]:
    """For each of `TARGETS`, by seconds."""
    return tuple(cheapest(rungs, target, lambda rung: rung.seconds) for target in TARGETS)
