"""A topic: one question, its methods, the truth they are held to, and what measuring it gives."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.layout import RUNG_DONE
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# A topic: one question of a stage, the methods that answer it, and the truth they are held to.
# ----------------------------------------------------------------------------

#: the ladder of a method that has nothing to set
NOTHING_TO_SET = (1.0,)


class Answer(NamedTuple):
    """What one method gave at one setting.

    `values` : real or complex, the shape of the reference's values, same unit.
    `work` : what it took, counted in the unit of the topic (evaluations, solves, multiplications).
    `position` : where the peak sits, for topics that ask it; None without one.
    """

    values: np.ndarray
    work: float
    position: float | None = None


class Reference(NamedTuple):
    """The trusted values: mpmath, or two independent methods that agree.

    `agreement` : relative to the largest magnitude, how well the independent ways agree; errors
        below it are not told apart.
    `words` : how the values were found and what they were held against.
    """

    values: np.ndarray
    agreement: float
    words: str
    position: float | None = None


class Ladder(NamedTuple):
    """One method with its settings, from coarse to fine.

    `solve` : setting to answer; raises NumericalFailure where it cannot.
    `setting` : what the ladder steps ("panels", "time step [s]"); empty with nothing to set.
    `default` : the setting that vibecalc takes for this case; None for a method it does not take.
    `theory` : what the theory says of the convergence ("order 4", "geometric"), empty without.
    """

    name: str
    words: str
    setting: str
    settings: tuple[float, ...]
    solve: Callable[[float], Answer]
    default: float | None = None
    theory: str = ""
    citation: str = ""


class Topic(NamedTuple):
    """One question of a stage and everything that answers it.

    `quantity` : the result path (or the beginning of several) that the values stand for.
    `work` : the unit in which all its methods count their work, in the plural.
    `position` : what the position of the peak is and its unit ("crank angle [rad]"), empty without.
    `default_extra` : by how much more work the default may take than the cheapest method that is as
        accurate, and why (1.0 and no words: it is on the front itself).
    """

    stage: str
    name: str
    words: str
    quantity: str
    unit: str
    work: str
    reference: Callable[[], Reference]
    ladders: tuple[Ladder, ...]
    position: str = ""
    default_extra: float = 1.0
    default_why: str = ""


# ----------------------------------------------------------------------------
# What measuring one topic gives: a rung for each setting of each method.
# ----------------------------------------------------------------------------

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
    status: int = RUNG_DONE
    cause: str = ""
    work: float = 0.0
    seconds: float = 0.0
    worst_relative: float = float("inf")
    worst_level: float = float("inf")
    position_error: float | None = None

    @property
    def done(self) -> bool:
        """Whether there is an error to speak of."""
        return self.status == RUNG_DONE

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
