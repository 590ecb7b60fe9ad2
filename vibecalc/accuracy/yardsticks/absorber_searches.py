"""The tuning of absorbers as a user would search it: plain peaks, a search of scipy, a grid."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.absorber_truths import System
from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.closed_forms import METHODS
from vibecalc.response.absorber.amplitude import amplitude
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks
from vibecalc.response.absorber.several import Several, several_amplitude
from vibecalc.response.absorber.several_peaks import several_peaks

#: frequency ratios looked at for the peaks of one tuning, and the finer ones about each of them
_COARSE = np.linspace(0.0, 2.0, 401)
_FINE = np.linspace(-1.0, 1.0, 41) * (_COARSE[1] - _COARSE[0])
#: shares about the closed form that the grid covers: of the stiffness, of the damping
_SPRING, _DAMPER = 0.2, 0.4


class Question(NamedTuple):
    """What is tuned: `system` with any spring and damper, or only the damper without `spring`.

    Places of a search are logarithms of all k (with `spring`), then of all z2.
    """

    system: System
    spring: bool

    def at(self, place: np.ndarray) -> System:
        """The system with the tuning of a place."""
        count = len(self.system.mass_ratio)
        values = np.exp(np.asarray(place, dtype=float))
        if self.spring:
            return self.system._replace(
                stiffness_ratio=values[:count], secondary_damping=values[count:]
            )
        return self.system._replace(secondary_damping=values)


def first_place(question: Question) -> np.ndarray:
    """Where a user would begin: the closed form for the mass of all, springs spread apart."""
    m = np.asarray(question.system.mass_ratio, dtype=float)
    whole = np.asarray(np.sum(m))
    if not question.spring:
        return np.asarray(np.log(METHODS["lanchester"].formula(whole)[1] * m / whole))
    k, z2, _ = METHODS["den_hartog_brock"].formula(whole)
    apart = np.linspace(0.9, 1.1, len(m)) if len(m) > 1 else np.ones(1)
    soft = 1.0 / np.sqrt(len(m))
    return np.asarray(np.log(np.concatenate([k * m / whole * apart, z2 * m / whole * soft])))


def magnitude(system: System, x: np.ndarray) -> np.ndarray:
    """|H| at frequency ratios (points,)."""
    pair = system.excitation, system.response
    if len(system.mass_ratio) == 1:
        return np.asarray(np.abs(amplitude(single(system), x, *pair)))
    return np.asarray(np.abs(several_amplitude(several(system), x, *pair)))


def highest(question: Question, count: int) -> Callable[[np.ndarray], np.ndarray]:
    """The `count` highest peaks of a place, from 401 frequencies and a parabola in finer ones.

    Good to about 1e-10; the highest repeated where there are fewer.
    """

    def levels(place: np.ndarray) -> np.ndarray:
        system = question.at(place)
        curve = magnitude(system, _COARSE)
        if not np.all(np.isfinite(curve)):
            raise NumericalFailure("the search came to a response that is infinite")
        tops = np.flatnonzero((curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:])) + 1
        if not len(tops):
            return np.full(count, np.max(curve))
        chosen = _COARSE[tops[np.argsort(curve[tops])[::-1][:count]]]
        heights = [_refined(system, float(x)) for x in chosen]
        return np.array(heights + [heights[0]] * (count - len(heights)), dtype=float)

    return levels


def _refined(system: System, x: float) -> float:
    near = magnitude(system, np.maximum(x + _FINE, 0.0))
    middle = min(max(int(np.argmax(near)), 1), len(near) - 2)
    low, mid, high = near[middle - 1 : middle + 2]
    bend = 2.0 * mid - low - high
    return float(mid + (high - low) ** 2 / (8.0 * bend)) if bend > 0.0 else float(mid)


def true_peak(system: System) -> float:
    """The largest |H| of a tuning, from the project's own polynomials."""
    pair = system.excitation, system.response
    if len(system.mass_ratio) == 1:
        return float(peaks(single(system), *pair).largest)
    return several_peaks(several(system), *pair).largest


def grid_of(question: Question, step: float) -> tuple[np.ndarray, int]:
    """Place of least peak on a grid of one absorber, as in Baca's Appendix I, and tunings tried.

    Multiples of `step` in k, in the own damping eps2 (in z2 / m without a spring) and in the
    frequency ratio, the latter from .5 to 1.5; of the former the part about the closed form.
    """
    start = np.exp(first_place(question))
    m = float(question.system.mass_ratio[0])
    pair = question.system.excitation, question.system.response
    x = step * np.arange(np.ceil(0.5 / step), np.floor(1.5 / step) + 1.0)
    own = start[-1] / np.sqrt(m * start[0]) if question.spring else start[-1] / m
    ratios = _multiples(own, _DAMPER, step)
    springs = _multiples(start[0], _SPRING, step) if question.spring else np.zeros(1)
    best, place = np.inf, start
    for k in springs:
        z2 = ratios * (np.sqrt(m * k) if question.spring else m)
        system = Absorber(question.system.primary_damping, m, k, z2[:, None])
        tops = np.max(np.abs(amplitude(system, x, *pair)), axis=1)
        least = int(np.argmin(tops))
        if tops[least] < best:
            best = float(tops[least])
            place = np.array([k, z2[least]] if question.spring else [z2[least]])
    return np.log(place), len(springs) * len(ratios)


def _multiples(middle: float, share: float, step: float) -> np.ndarray:
    low, high = (1.0 - share) * middle, (1.0 + share) * middle
    values = step * np.arange(max(np.ceil(low / step), 1.0), np.floor(high / step) + 1.0)
    if not len(values):
        raise NumericalFailure(f"a grid of {step:g} has no point near {middle:.3g}")
    return values


def single(system: System) -> Absorber:
    """The system as `response.absorber` takes one absorber."""
    return Absorber(
        system.primary_damping, float(system.mass_ratio[0]),
        float(system.stiffness_ratio[0]), float(system.secondary_damping[0]),
    )  # fmt: skip


def several(system: System) -> Several:
    """The system as `response.absorber` takes several."""
    m, k, z2 = (np.asarray(part, dtype=float) for part in system[1:4])
    return Several(system.primary_damping, m, k, z2, system.parent)
