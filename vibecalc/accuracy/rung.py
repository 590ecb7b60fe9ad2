"""What measuring one topic gives: a rung for each setting of each method."""

from typing import NamedTuple

from vibecalc.accuracy.topic import Reference, Topic
from vibecalc.numerics.rounding import EPSILON
from vibecalc.results.accuracy_layout import DONE

#: errors below so many roundings are not told apart, however well the reference is known
_LEAST_ROUNDINGS = 64


class Rung(NamedTuple):
    """One method at one setting.

    `worst_relative`, `worst_level` [dB] and `position_error` [unit of the position] as `errors.py`
    says; infinite for a rung that was not measured. `position_error` is None where the topic asks
    no position or the method gives none. `noise` is the relative error below which this topic does
    not tell methods apart. `seconds` is the least of the repeats.
    """

    ladder: str
    setting: float
    is_default: bool
    noise: float
    status: int = DONE
    cause: str = ""
    work: float = 0.0
    seconds: float = 0.0
    worst_relative: float = float("inf")
    worst_level: float = float("inf")
    position_error: float | None = None

    @property
    def done(self) -> bool:
        """Whether there is an error to speak of."""
        return self.status == DONE

    @property
    def error(self) -> float:
        """Worst relative error, not below the noise of the topic."""
        return max(self.worst_relative, self.noise)


class Measured(NamedTuple):
    """A topic with its truth and its rungs, method by method, each from coarse to fine."""

    topic: Topic
    reference: Reference
    rungs: tuple[Rung, ...]
    seconds: float = 0.0


def noise_of(reference: Reference) -> float:
    """Relative error below which rungs count as equally accurate."""
    return max(reference.agreement, _LEAST_ROUNDINGS * EPSILON)
