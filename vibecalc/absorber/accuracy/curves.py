"""Accuracy of the highest peak and its place, of all curves, and of natural frequencies."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.accuracy.by_other_means import (
    System,
    Truth,
    highest_peak,
    is_of_primary,
    magnitude,
    several,
    single,
)
from vibecalc.absorber.adapters.response import family, frequency_ratios
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import Peaks, near_poles, peaks, quick_maxima, tops
from vibecalc.absorber.several import several_polynomials
from vibecalc.absorber.several_peaks import SeveralPeaks, several_peaks
from vibecalc.absorber.squared_magnitude import (
    excess_polynomials,
    measure,
    positive_roots,
    stationarity,
)
from vibecalc.absorber.stage import asked_of
from vibecalc.absorber.transfer import Absorber, Coupling, coupling, transfer_of
from vibecalc.core.accuracy.other_searches import grid_maximum, parabola_maximum
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene

# ----------------------------------------------------------------------------
# What the peaks of absorbers take, counted in evaluations of |H| at one frequency.
# ----------------------------------------------------------------------------

#: value and two derivatives of |H|^2, in evaluations of |H|
_JET = 3.0
#: multiplications in an evaluation of |H|, and in polynomials with signs of Sturm's chain, and with
#: all poles, polished
_PRODUCTS, _CHAIN, _POLES = 20.0, 450.0, 1000.0
#: multiplications of an eigenproblem, over the cube of its size
_EIGENVALUES = 10.0


def own_work(system: System) -> float:
    """What all peaks take: evaluations of |H|, and the rest at its multiplications.

    Of one absorber both ways where the quick one fails.
    """
    pair = system.excitation, system.response
    if len(system.mass_ratio) > 1:
        above, below = several_polynomials(several(system), transfer_of(*pair))
        # |D|^2 has the degree of D in u, |N|^2 that of N
        degrees = len(below) - 1, len(above) + len(below) - 3
        solved = sum(_EIGENVALUES / _PRODUCTS * degree**3 for degree in degrees)
        return _JET * several_peaks(several(system), *pair).evaluations + solved
    flat, transfer = _flat(system), transfer_of(*pair)
    quick = quick_maxima(flat, transfer)
    work = _JET * float(quick.evaluations[0]) + _CHAIN / _PRODUCTS
    if quick.certain[0]:
        return work
    work += _POLES / _PRODUCTS
    weights = measure(flat, transfer)
    u = np.concatenate([stationary_places(system)[0], near_poles(flat)[1]])
    looks = float(np.sum(tops(flat, weights, np.zeros(len(u), dtype=int), u)[1]))
    # without the floor what lies below it is examined again, here that only
    rounds = 2 if np.any(weights.floor_squared) else 1
    return work + _JET * (looks + (rounds - 1) * len(u)) + rounds * stationary_places(system)[1]


def _flat(system: System) -> Coupling:
    parts = coupling(single(system))
    return Coupling(*(np.reshape(part, -1) for part in parts))


def stationary_places(system: System) -> tuple[np.ndarray, float]:
    """Roots u > 0 of the stationarity polynomial, and what its eigenvalues cost."""
    flat = _flat(system)
    weights = measure(flat, transfer_of(system.excitation, system.response))
    polynomial = stationarity(*excess_polynomials(flat, weights))
    there = np.flatnonzero(polynomial[0])
    degree = float(there[-1] - there[0]) if len(there) else 0.0
    return positive_roots(polynomial)[1], _EIGENVALUES / _PRODUCTS * degree**3


# ----------------------------------------------------------------------------
# Topics of the stage "absorber": highest peak and its place, all curves, natural frequencies.
# ----------------------------------------------------------------------------

_STAGE = "absorber"
#: heights closer than this, relatively, share the highest peak, so that it has no one place
_EQUAL = 1e-6
#: curves of a family that take part, so that a reference in many digits stays quick
_MOST_CURVES = 8
#: what the default takes over six points that have the highest peak between them, and why
_EXTRA, _EXTRA_SEVERAL = 6.0, 21.0
_WHY = (
    "every peak is found, however narrow, each with its error, and signs of a polynomial prove "
    "that there is no other; a grid of six points does where the highest peak is broad, which is "
    "not known before"
)
_WHY_SEVERAL = (
    "every peak is found, however narrow, each with its error, from all roots of a polynomial, "
    "whose eigenvalues are most of the work, and from all poles: of several absorbers its signs "
    "are beyond rounding; a grid of six points does where the highest peak is broad"
)


class _Peak(NamedTuple):
    """Height and place of the highest peak, and evaluations of |H|."""

    height: float
    place: float
    work: float


#: setting to the highest peak of one system between two frequency ratios
_Way = Callable[[System, float, float, float], _Peak]


def absorber_curves_topics(scene: Scene) -> list[Topic]:
    """Peaks by every way, for responses of the primary system."""
    case = scene.case
    pair = asked_of(case)
    if case.response is None or case.response.absorber is None or not is_of_primary(*pair):
        return []
    options, parts = case.response.absorber, build_absorber(case)
    ratios = frequency_ratios(options, parts)
    span = float(ratios[0]), float(ratios[-1])
    curves = [one for one in _systems(scene, parts, pair) if _inside(one, *span)]
    if not curves:
        return []
    made = [_peak_topic(curves[:1], span, "highest peak", "the highest peak of the first curve")]
    if len(curves) > 1:
        chosen = curves[:_MOST_CURVES]
        words = f"the highest peak of {len(chosen)} curves of the family that have a finite one"
        made.append(_peak_topic(chosen, span, "peaks of the family", words))
    return made


def _systems(scene: Scene, parts: AbsorberParts, pair: tuple[str, str]) -> list[System]:
    """The curves of the case, as the stage draws them; of several absorbers the first one."""
    options = scene.case.response.absorber if scene.case.response is not None else None
    if parts.branches:
        one = scene.handed_on.get("several")
        if one is None:
            return []
        return [System(one.primary_damping, one.mass_ratio, one.stiffness_ratio,
                       one.secondary_damping, one.parent, *pair)]  # fmt: skip
    assert options is not None
    found = family(scene.case, options, parts, scene.handed_on.get("tuned")).absorber
    rows = zip(*(np.asarray(part, dtype=float).tolist() for part in found), strict=True)
    return [System(z1, (m,), (k,), (z2,), (0,), *pair) for z1, m, k, z2 in rows]


def _inside(system: System, low: float, high: float) -> bool:
    """Whether the highest peak is finite and stands within the frequencies drawn."""
    if not np.all(np.isfinite(np.asarray(system.stiffness_ratio, dtype=float))):
        return False
    found = _all_peaks(system)
    return bool(np.isfinite(found.largest) and low < float(found.where) < high)


def _has_one_place(system: System) -> bool:
    """Whether one peak is higher than all others: those of a tuned absorber are equal."""
    found = _all_peaks(system)
    heights = np.asarray(found.magnitude)
    return int(np.sum(heights > float(found.largest) * (1.0 - _EQUAL))) == 1


def _all_peaks(system: System) -> Peaks | SeveralPeaks:
    pair = system.excitation, system.response
    if len(system.mass_ratio) == 1:
        return peaks(single(system), *pair)
    return several_peaks(several(system), *pair)


def _peak_topic(systems: list[System], span: tuple[float, float], name: str, words: str) -> Topic:
    placed = len(systems) == 1 and _has_one_place(systems[0])
    # the polynomial of several absorbers is solved within their own kernel only
    many = len(systems[0].mass_ratio) > 1
    rows = [row for row in _WAYS if not many or row[4] is not _unpolished]

    @cache
    def truths() -> tuple[Truth, ...]:
        return tuple(highest_peak(one, _grid_place(one, *span)) for one in systems)

    def reference() -> Reference:
        found = truths()
        return Reference(
            np.array([one.value for one in found]),
            max(one.agreement for one in found),
            "zero of the slope of |H| in 50 digits, next to the highest of a fine grid; held "
            "against 34",
            found[0].place[0] if placed else None,
        )

    return Topic(
        stage=_STAGE,
        name=name,
        words=f"{words}, {systems[0].excitation} to {systems[0].response}",
        quantity="response/absorber/largest",
        unit="",
        work="evaluations of |H| at one frequency",
        reference=reference,
        solvers=(
            _own_solver(systems, placed),
            *(_solver(systems, span, placed, *row) for row in rows),
        ),
        position="frequency ratio []" if placed else "",
        default_extra=_EXTRA_SEVERAL if many else _EXTRA,
        default_why=_WHY_SEVERAL if many else _WHY,
    )


def _own_solver(systems: list[System], placed: bool) -> Solver:
    work = cache(lambda: sum(own_work(one) for one in systems))

    def solve(_: float) -> Answer:
        found = _own(systems)
        place = found[0].place if placed else None
        return Answer(np.array([one.height for one in found]), work(), place)

    many = len(systems[0].mass_ratio) > 1
    words = "Newton's method on |H|^2 from roots and poles"
    if not many:
        words = "Newton's method on |H|^2 from the natural frequencies, and the number of peaks"
    return Solver("all peaks, as a run does", words, "", NOTHING_TO_SET, solve, NOTHING_TO_SET[0])


def _solver(
    systems: list[System], span: tuple[float, float], placed: bool, name: str, words: str,
    setting: str, settings: tuple[float, ...], way: _Way, theory: str,
) -> Solver:  # fmt: skip
    def solve(at: float) -> Answer:
        found = [way(one, *span, at) for one in systems]
        return Answer(
            np.array([one.height for one in found]),
            sum(one.work for one in found),
            found[0].place if placed else None,
        )

    citation = "Baca Vasquez (2007), Appendix I" if name == "grid" else ""
    return Solver(name, words, setting, settings, solve, None, theory, citation)


def _grid_place(system: System, low: float, high: float) -> float:
    """Place of the highest peak to about 1e-8, without any polynomial."""
    return _brent(system, low, high, 20001.0).place


def _own(systems: list[System]) -> list[_Peak]:
    """Of one absorber all curves in one call, as the stage does."""
    pair = systems[0].excitation, systems[0].response
    if len(systems[0].mass_ratio) > 1:
        found = [several_peaks(several(one), *pair) for one in systems]
        return [_Peak(one.largest, one.where, 0.0) for one in found]
    columns = zip(*(single(one) for one in systems), strict=True)
    wide = peaks(Absorber(*(np.array(column) for column in columns)), *pair)
    rows = zip(wide.largest.tolist(), wide.where.tolist(), strict=True)
    return [_Peak(height, place, 0.0) for height, place in rows]


def _unpolished(system: System, low: float, high: float, _: float) -> _Peak:
    u, work = stationary_places(system)
    x = np.sqrt(u[u > 0.0])
    values = magnitude(system, x)
    best = int(np.argmax(values))
    return _Peak(float(values[best]), float(x[best]), work + len(x))


def _grid(system: System, low: float, high: float, points: float) -> _Peak:
    found = grid_maximum(lambda x: magnitude(system, x), low, high, int(points))
    return _Peak(found.value, found.position, found.evaluations)


def _parabola(system: System, low: float, high: float, points: float) -> _Peak:
    found = parabola_maximum(lambda x: magnitude(system, x), low, high, int(points))
    return _Peak(found.value, found.position, found.evaluations)


def _brent(system: System, low: float, high: float, points: float) -> _Peak:
    from scipy.optimize import minimize_scalar

    first = grid_maximum(lambda x: magnitude(system, x), low, high, int(points))
    step = (high - low) / (points - 1.0)
    found = minimize_scalar(
        lambda x: -float(magnitude(system, np.array([x]))[0]),
        bounds=(first.position - step, first.position + step),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return _Peak(float(-found.fun), float(found.x), float(first.evaluations + found.nfev))


_WAYS: tuple[tuple[str, str, str, tuple[float, ...], _Way, str], ...] = (
    (
        "roots of the polynomial alone", "companion eigenvalues, |H| at them",
        "", NOTHING_TO_SET, _unpolished, "",
    ),
    (
        "grid", "largest of evenly spread frequencies", "frequencies",
        (101.0, 401.0, 801.0, 2001.0, 10001.0, 100001.0), _grid, "order 2",
    ),
    (
        "grid with a parabola", "through the highest frequency and its neighbours", "frequencies",
        (101.0, 201.0, 401.0, 801.0, 2001.0, 10001.0), _parabola, "order 3 or 4",
    ),
    (
        "grid, then Brent's method of scipy", "between the neighbours of the highest frequency",
        "frequencies", (6.0, 11.0, 21.0, 41.0, 101.0, 201.0, 401.0, 801.0), _brent, "",
    ),
)  # fmt: skip
