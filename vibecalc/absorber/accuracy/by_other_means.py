"""Peaks and tunings of absorbers by other means: in many digits, as a user would search."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.several import Several, several_amplitude
from vibecalc.absorber.several_peaks import several_peaks
from vibecalc.absorber.transfer import Absorber, amplitude, transfer_of
from vibecalc.absorber.tuning.closed_forms import METHODS
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

if TYPE_CHECKING:
    from mpmath.ctx_mp import MPContext

# ----------------------------------------------------------------------------
# Primary systems with absorbers in many digits: highest peaks and least highest peaks.
# ----------------------------------------------------------------------------

#: digits of the values, and those of the check that they are right
_DIGITS, _MORE = 34, 50
#: relative distance of the two places from which a peak is closed in
_NEAR = 1e-6


#: numbers of n absorbers
Ratios = Sequence[float] | np.ndarray
_Many = Sequence[Any] | np.ndarray


class System(NamedTuple):
    """Ratios as in `response.absorber.several.Several`, (n,) each; response of the primary system.

    Infinite stiffness fastens an absorber rigidly.
    """

    primary_damping: float
    mass_ratio: Ratios
    stiffness_ratio: Ratios
    secondary_damping: Ratios
    parent: tuple[int, ...]
    excitation: str = "force"
    response: str = "displacement"


class Truth(NamedTuple):
    """A value, where it stands, and how far two precisions agree, relatively."""

    value: float
    place: tuple[float, ...]
    agreement: float


def is_of_primary(excitation: str, response: str) -> bool:
    """Whether these functions know the response."""
    return transfer_of(excitation, response).motion == "primary"


def highest_peak(system: System, near: float) -> Truth:
    """The maximum of |H| whose frequency ratio is close to `near`, which stands in `place`.

    Raises NumericalFailure where the slope has no zero near that.
    """
    coarse, fine = (_peak(system, near, digits) for digits in (_DIGITS, _MORE))
    return Truth(float(fine[0]), (float(fine[1]),), _apart(coarse[0], fine[0]))


def _peak(system: System, near: float, digits: int) -> tuple[Any, Any]:
    from mpmath import mp

    with mp.workdps(digits):

        def level(x: Any) -> Any:
            return _level(mp, system, system.stiffness_ratio, system.secondary_damping, x)

        try:
            nearby = mp.mpf(near) * (1 - _NEAR), mp.mpf(near) * (1 + _NEAR)
            place = mp.findroot(lambda x: mp.diff(level, x), nearby, tol=mp.mpf(10) ** -30)
        except (ValueError, ZeroDivisionError) as error:
            raise NumericalFailure(f"no peak near the frequency ratio {near:.9g}") from error
        if abs(place - near) > 0.01 * near or mp.diff(level, place, 2) >= 0:
            raise NumericalFailure(f"no peak near the frequency ratio {near:.9g}")
        return mp.exp(level(place) / 2), place


def least_highest_peak(
    system: System, spring: bool, peaks: Sequence[float], weights: Sequence[float]
) -> Truth:
    """The stationary point of the largest of some peaks, near the tuning and `peaks` given.

    Unknowns are the logarithms of all k (with `spring`) and all z2, the frequency ratios of the
    peaks and their weights; equations: peaks stationary and level, weighted slopes zero, weights
    one together. `place` holds k (n,), then z2 (n,).
    Raises NumericalFailure where Newton's method ends nowhere.
    """
    coarse, fine = (_balance(system, spring, peaks, weights, d) for d in (_DIGITS, _MORE))
    place = tuple(float(value) for value in fine[1])
    return Truth(float(fine[0]), place, _apart(coarse[0], fine[0]))


def _balance(
    system: System, spring: bool, peaks: Sequence[float], weights: Sequence[float], digits: int
) -> tuple[Any, list[Any]]:
    from mpmath import mp

    count, active = len(system.mass_ratio), len(peaks)
    with mp.workdps(digits):
        stiff = [mp.mpf(k) for k in system.stiffness_ratio]

        def split(unknown: Sequence[Any]) -> tuple[list[Any], list[Any], list[Any], list[Any]]:
            values = list(unknown)
            k = [mp.exp(v) for v in values[:count]] if spring else stiff
            rest = values[count if spring else 0 :]
            z2 = [mp.exp(v) for v in rest[:count]]
            return k, z2, rest[count : count + active], rest[count + active :]

        def conditions(*unknown: Any) -> list[Any]:
            k, z2, places, shares = split(unknown)
            slopes = [_slopes(mp, system, k, z2, x) for x in places]
            levels = [_level(mp, system, k, z2, x) for x in places]
            left = [slope[0] for slope in slopes]
            left += [levels[i] - levels[0] for i in range(1, active)]
            for which in range(0 if spring else count, 2 * count):
                left.append(sum(w * s[1 + which] for w, s in zip(shares, slopes, strict=True)))
            return [*left, sum(shares) - 1]

        start = [mp.log(mp.mpf(k)) for k in system.stiffness_ratio] if spring else []
        start += [mp.log(mp.mpf(z)) for z in system.secondary_damping]
        start += [mp.mpf(float(v)) for v in (*peaks, *weights)]
        try:
            found = mp.findroot(conditions, start, tol=mp.mpf(10) ** (-2 * (digits - 6)))
        except (ValueError, ZeroDivisionError) as error:
            raise NumericalFailure("no balance of the peaks near the tuning given") from error
        k, z2, places, _ = split(found)
        return mp.exp(_level(mp, system, k, z2, places[0]) / 2), [*k, *z2]


def _level(mp: "MPContext", system: System, k: _Many, z2: _Many, x: Any) -> Any:
    """ln |H|^2."""
    z1, transfer = mp.mpf(system.primary_damping), transfer_of(system.excitation, system.response)
    s = mp.mpc(0, 1) * x
    below = 1 + 2 * z1 * s + s * s * (1 + _carried(mp, system, k, z2, s, 0))
    top = 2 * transfer.power * mp.log(x) + transfer.ground * mp.log(1 + 4 * z1 * z1 * x * x)
    return top - mp.log(below.real**2 + below.imag**2)


def _carried(mp: "MPContext", system: System, k: _Many, z2: _Many, s: Any, carrier: int) -> Any:
    """What hangs on one mass, as a mass that depends on frequency."""
    total = mp.mpf(0)
    for place, parent in enumerate(system.parent):
        if parent != carrier:
            continue
        mass = mp.mpf(system.mass_ratio[place]) + _carried(mp, system, k, z2, s, place + 1)
        link = mp.mpf(k[place]) + 2 * mp.mpf(z2[place]) * s
        total += mass if mp.isinf(k[place]) else mass * link / (link + s * s * mass)
    return total


def _slopes(mp: "MPContext", system: System, k: _Many, z2: _Many, x: Any) -> list[Any]:
    """Derivatives of ln |H|^2 by x, by all ln k, by all ln z2; absorbers on the primary only."""
    z1, transfer = mp.mpf(system.primary_damping), transfer_of(system.excitation, system.response)
    s = mp.mpc(0, 1) * x
    links = [a + 2 * b * s for a, b in zip(k, z2, strict=True)]
    masses = [mp.mpf(m) for m in system.mass_ratio]
    wholes = [link + m * s * s for link, m in zip(links, masses, strict=True)]
    carried = sum(m * g / n for m, g, n in zip(masses, links, wholes, strict=True))
    below = 1 + 2 * z1 * s + s * s * (1 + carried)
    # of m g / n by g; by s the link changes, too, and so does n
    by_link = [(m * s / n) ** 2 for m, n in zip(masses, wholes, strict=True)]
    turned = sum(
        d * 2 * z - 2 * m * m * s * g / (n * n)
        for d, z, m, g, n in zip(by_link, z2, masses, links, wholes, strict=True)
    )
    below_slope = 2 * z1 + 2 * s * (1 + carried) + s * s * turned
    first = 2 * transfer.power / x - 2 * (mp.mpc(0, 1) * below_slope / below).real
    if transfer.ground:
        first += transfer.ground * 8 * z1 * z1 * x / (1 + 4 * z1 * z1 * x * x)
    springs = [-2 * (s * s * d * a / below).real for d, a in zip(by_link, k, strict=True)]
    dampers = [-2 * (s * s * d * 2 * b * s / below).real for d, b in zip(by_link, z2, strict=True)]
    return [first, *springs, *dampers]


def _apart(one: Any, other: Any) -> float:
    """Relative distance, never below the rounding to double precision."""
    return max(float(abs(one / other - 1)), UNIT_ROUNDOFF)


def rounded(values: np.ndarray, digits: int = 4) -> list[float]:
    """A few digits of each: enough to start from, too few to hand errors on."""
    return [float(f"{value:.{digits - 1}e}") for value in np.atleast_1d(values)]


# ----------------------------------------------------------------------------
# The tuning of absorbers as a user would search it: plain peaks, a search of scipy, a grid.
# ----------------------------------------------------------------------------

#: frequency ratios examined for the peaks of one tuning, and the finer ones about each of them
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
