"""What a tuning of absorbers on modes makes small: largest responses over a band and states."""

import itertools
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.modal import Fitted, Modes, driven, fitted, highest, response_at, tops_within
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# What is tuned: absorbers on modes, the band, and the states in which they have to do well.
# ----------------------------------------------------------------------------

#: the state of all parts as they should be
NOMINAL = np.zeros((1, 4))


class BandProblem(NamedTuple):
    """Find k and z (a,) that make the largest |H| from `low` to `high` least over all `states`.

    `mass` (a,) and `carrier` as in `Fitted`. `states` (s, 4): relative deviations of natural
    frequencies of the primary at constant mass, masses of the absorbers, their stiffness, their
    damping; the first row zeros. `stiffness` and `damping` bound the nominal ratios, `travel` the
    largest motion of each absorber against what carries it within the band, in every state.
    Absorbers that are marked in `locked` (a,) are fastened rigidly.
    """

    modes: Modes
    mass: FloatArray
    excitation: str
    response: str
    low: float = 0.0
    high: float = np.inf
    states: FloatArray = NOMINAL
    stiffness: tuple[float, float] = (0.0, np.inf)
    damping: tuple[float, float] = (0.0, np.inf)
    travel: float = np.inf
    carrier: tuple[int, ...] = ()
    locked: tuple[bool, ...] = ()

    @property
    def readings(self) -> list[tuple[str, int, float]]:
        """What is read, of which absorber and over what: the response, each travel with a limit."""
        bounded = range(len(self.mass)) if np.isfinite(self.travel) else ()
        return [(self.response, 0, 1.0), *(("travel", place, self.travel) for place in bounded)]

    def systems(
        self, stiffness: FloatArray, damping: FloatArray, states: FloatArray | None = None
    ) -> Fitted:
        """The absorbers with nominal ratios (a,), or (s, a), in every state (s, 4): a row each."""
        off = 1.0 + (self.states if states is None else states)
        modes = self.modes._replace(frequency=off[:, :1] * self.modes.frequency)
        if any(self.locked):
            stiffness = np.where(self.locked, np.inf, stiffness)
        ratios = (self.mass * off[:, 1:2], stiffness * off[:, 2:3], damping * off[:, 3:])
        return fitted(modes, *ratios, self.carrier)

    @property
    def span(self) -> tuple[float, float]:
        """The band; where all frequencies count, those about the modes with absorbers."""
        if np.isfinite(self.high):
            return max(self.low, 0.2 * self.high), self.high
        whole = 1.0 + float(np.sum(self.mass))
        frequency = self.modes.frequency
        return 0.6 * float(np.min(frequency)) / whole, 1.2 * float(np.max(frequency))

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and most of all k, then all z (2 a,): as given, and what no optimum reaches."""
        low, high = self.span
        top = max(high, float(np.max(self.modes.frequency)))
        softest = 0.0 if np.isinf(self.high) else np.square(0.002 * low) * self.mass
        free = ~np.array(self.locked or (False,) * len(self.mass))
        lower = [np.maximum(softest, self.stiffness[0]) * free, self.damping[0] * free]
        upper = [
            np.minimum(_STIFFEST * np.square(top) * self.mass, self.stiffness[1]) * free,
            np.minimum(40.0 * top * self.mass, self.damping[1]) * free,
        ]
        if np.any(lower[0] > upper[0]) or np.any(lower[1] > upper[1]):
            raise NumericalFailure("no spring within the bounds acts within the band")
        return np.concatenate(lower), np.concatenate(upper)

    def usual(self) -> FloatArray:
        """Usual size of all k, then all z (2 a,), within the bounds."""
        middle = np.clip(np.sqrt(np.prod(self.span)), *np.sort(self.modes.frequency)[[0, -1]])
        whole = float(np.sum(self.mass) / self.modes.mass[0])
        # an absorber far heavier than the primary system is stopped by stiffness of order one
        soft = np.square(middle / (1.0 + whole)) * self.mass
        drag = middle * np.sqrt(whole / (1.0 + whole) ** 3) * self.mass
        lower, upper = self.bounds()
        upper = np.where(upper > 0.0, upper, np.inf)
        return np.asarray(np.minimum(np.maximum(np.concatenate([soft, drag]), lower), upper))


#: largest k over mass and the square of the highest frequency
_STIFFEST = 64.0


def states_of(tolerances: tuple[float, float, float, float]) -> FloatArray:
    """Lowest, nominal and highest of all four in every combination (s, 4), nominal ones first."""
    each = [(0.0, -share, share) if share else (0.0,) for share in tolerances]
    return np.array(list(itertools.product(*each)))


# ----------------------------------------------------------------------------
# Levels: all maxima within the band over all states, with derivatives by k and z.
# ----------------------------------------------------------------------------

#: maxima lower than the largest by this share of it are left out
_LOW = 1e-3


class Levels(NamedTuple):
    """Maxima (p,): state, place, log |H|^2 with its error, derivatives by k, then z (2 a).

    `slope` (p, 2 a), `bend` (p, 2 a, 2 a) of a maximum whose place follows, `drift` (p, 2 a) of the
    place. Rest and infinite frequency stay. `limit` is 0 for the response, j for a travel of
    absorber j, whose level is over its limit.
    """

    state: IntArray
    place: FloatArray
    level: FloatArray
    error: FloatArray
    slope: FloatArray
    bend: FloatArray
    drift: FloatArray
    limit: IntArray

    def some(self, which: BoolArray | IntArray) -> "Levels":
        """The maxima that an index names."""
        state, place, level, error, slope, bend, drift, limit = self
        return Levels(
            state[which], place[which], level[which], error[which], slope[which], bend[which],
            drift[which], limit[which],
        )  # fmt: skip

    @property
    def top(self) -> float:
        """The highest response."""
        return float(np.max(self.level[self.limit == 0]))

    @property
    def over(self) -> float:
        """By how much the worst travel exceeds its limit; zero where all are kept."""
        return max(0.0, float(np.max(self.level[self.limit > 0], initial=0.0)))

    @property
    def depth(self) -> FloatArray:
        """How far each lies below the highest response, or below its limit."""
        return np.where(self.limit == 0, self.top, 0.0) - self.level

    @property
    def still(self) -> BoolArray:
        """At rest and at infinite frequency, where no absorber changes anything."""
        return np.asarray((self.place == 0.0) | np.isinf(self.place))


def levels_at(problem: BandProblem, point: FloatArray) -> Levels:
    """All maxima at k, then z (2 a,). Raises NumericalFailure where one is infinite."""
    stiffness, damping = np.split(point, 2)
    system, found = problem.systems(stiffness, damping), []
    for limit, (what, absorber, size) in enumerate(problem.readings):
        asked = problem.excitation, what
        tops = tops_within(system, *asked, problem.low, problem.high, absorber)
        high = tops.height.value > _LOW * np.max(tops.height.value)
        state, place, height = tops.row[high], tops.place.value[high], tops.height[high]
        inside = (place > problem.low) & (place < problem.high)
        at = np.where(np.isinf(place), 1.0, place)
        here, by = driven(system, *asked, absorber).with_gradient(state, at)
        off = np.repeat(1.0 + problem.states[state, 2:], len(problem.mass), axis=1)
        share = off / here.value[:, None]
        with np.errstate(invalid="ignore"):
            along = here.first / here.value
            first = by.first * share
            across = by.by_place * share - along[:, None] * first
            second = by.second * share[:, None, :] * off[:, :, None]
            second = second - first[:, :, None] * first[:, None, :]
            width = 2.0 * np.real(here.second / here.value - along * along)
        moves = (inside & (width < 0.0))[:, None]
        drift = np.where(moves, -2.0 * np.real(across) / np.where(moves[:, 0], width, 1.0)[:, None],
                         0.0)  # fmt: skip
        mixed = 2.0 * np.real(across)
        bend = 2.0 * np.real(second) + mixed[:, :, None] * drift[:, None, :]
        stays = (place == 0.0) | np.isinf(place)
        found.append(Levels(
            state, place, 2.0 * np.log(height.value / size),
            2.0 * height.error / height.value + 2.0 * EPSILON,
            np.where(stays[:, None], 0.0, 2.0 * np.real(first)),
            np.where(stays[:, None, None], 0.0, bend), drift, np.full(len(place), limit),
        ))  # fmt: skip
    return Levels(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


# ----------------------------------------------------------------------------
# Next to a tuning: without absorbers, in other states, with a part off.
# ----------------------------------------------------------------------------


def largest_in(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray,
    states: FloatArray | None = None, response: str | None = None, absorber: int = 0,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Largest |H| (s,) in each state, and its error; infinite on an undamped resonance."""
    chosen = problem.states if states is None else states
    system, what = problem.systems(stiffness, damping, chosen), response or problem.response
    return highest(system, problem.excitation, what, problem.low, problem.high, absorber)[:2]


def largest_alone(problem: BandProblem) -> tuple[float, float]:
    """Largest |H| in any state without the absorbers, and its error."""
    none = np.zeros_like(problem.mass)
    value, error = largest_in(problem._replace(mass=none), none + np.inf, none)
    return float(np.max(value)), float(np.max(error))


def at_least(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray, state: IntArray,
    place: FloatArray,
) -> FloatArray:  # fmt: skip
    """What the largest |H| of pairs (n,) of k and z is not below: |H| at places (p,) in states."""
    least = np.zeros(len(stiffness))
    for which, x in zip(state, place, strict=True):
        rows = np.tile(problem.states[which], (len(stiffness), 1))
        system = problem.systems(stiffness[:, None], damping[:, None], rows)
        found = response_at(
            system, np.full(len(stiffness), x), problem.excitation, problem.response
        )
        least = np.maximum(least, np.abs(found.value))
    return least


#: systems, pairs times states, of which all maxima are computed at once, and at most
_AT_ONCE, _MOST = 2000, 150_000


def largest_of_pairs(
    problem: BandProblem, stiffness: FloatArray, damping: FloatArray, response: str
) -> tuple[FloatArray, FloatArray]:
    """Largest |H| of each pair of k and z2 (they broadcast) in its worst state, and its error.

    Raises NumericalFailure where there are more pairs and states than can be computed.
    """
    k, z = np.broadcast_arrays(stiffness, damping)
    states = len(problem.states)
    if k.size * states > _MOST:
        raise NumericalFailure(
            f"{k.size} pairs of stock parts in {states} states of tolerances are too many, at most "
            f"{_MOST} together"
        )
    value, error = np.zeros(k.size), np.zeros(k.size)
    step = max(1, _AT_ONCE // states)
    for start in range(0, k.size, step):
        some = slice(start, start + step)
        count = len(k.ravel()[some])
        spring, drag = (np.repeat(part.ravel()[some], states)[:, None] for part in (k, z))
        system = problem.systems(spring, drag, np.tile(problem.states, (count, 1)))
        top, slack, _ = highest(system, problem.excitation, response, problem.low, problem.high)
        value[some] = np.max(top.reshape(count, states), axis=1)
        error[some] = np.max(slack.reshape(count, states), axis=1)
    return value.reshape(k.shape), error.reshape(k.shape)
