"""Adapter: curves and peaks of several absorbers on one primary system, as given or tuned."""

from collections.abc import Callable

import numpy as np

from vibecalc.absorber.adapters.motion import absorbers_of
from vibecalc.absorber.adapters.response import (
    OWN,
    courses,
    emit_frequencies,
    frequency_ratios,
    moved_by_ratios,
)
from vibecalc.absorber.adapters.tuning import named
from vibecalc.absorber.modal import Fitted, fitted, highest, one_mode, tops_within
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import SAME_HEIGHT, peaks
from vibecalc.absorber.results import RESPONSE_ROOT
from vibecalc.absorber.stage import asked_of, curve_names
from vibecalc.absorber.transfer import Absorber
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray


def run_several_response(scene: Scene) -> None:
    """Emit the curves of several absorbers: as given or tuned, and over the primary damping."""
    case, parts = scene.case, build_absorber(scene.case)
    assert case.response is not None and case.response.absorber is not None
    options, (excitation, response) = case.response.absorber, asked_of(case)
    asked = excitation, OWN.get(response, response)
    mass, given, errors = absorbers_of(scene, parts)
    count = len(mass)
    first = system_of(parts, mass, given)
    systems = [first]
    if options.limits:
        systems += [
            system_of(parts, mass, np.repeat(ends, count)) for ends in ([np.inf, 0.0], [0.0, 0.0])
        ]
    for value in options.vary.primary_damping if options.vary is not None else ():
        systems.append(first._replace(modes=first.modes._replace(damping=np.array([[value]]))))

    def moved(read: Callable[[Fitted], np.ndarray]) -> FloatArray:
        return moved_by_ratios(lambda ratios: read(system_of(parts, mass, ratios)), given, errors)

    ratios = frequency_ratios(options, parts)
    emit_frequencies(scene, parts, ratios)
    names, absorbers = {"curve": curve_names(case)}, named(parts)
    axes = {"frequency_ratio": ratios}

    def curves(what: str, absorber: int) -> tuple[np.ndarray, FloatArray]:
        """One response of all systems over the frequency, with errors; the first may be tuned."""
        values, error = courses(systems, ratios, excitation, what, absorber)
        error[0] += moved(lambda one: courses([one], ratios, excitation, what, absorber)[0][0])
        return values, error

    scene.emit(f"{RESPONSE_ROOT}/curve", *curves(asked[1], 0), names | axes)
    each = zip(*(curves("travel", place) for place in range(count)), strict=True)
    values, error = (np.stack(part, axis=1) for part in each)
    scene.emit(f"{RESPONSE_ROOT}/each/relative_curve", values, error, names | absorbers | axes)

    tops = [_peaks(one, *asked) for one in systems]
    if options.limits:
        tops[1:3] = [_limit(parts, mass, stiff, excitation, response) for stiff in (np.inf, 0.0)]
    most = max(1, *(len(place) for place, _, _ in tops))
    place, height, off = np.zeros((3, len(tops), most))
    for row, (at, top, _) in enumerate(tops):
        place[row, : len(at)] = at
        height[row, : len(at)], off[row, : len(at)] = top
    apart = float(np.max(moved(lambda one: _peaks(one, *asked)[0]), initial=0.0))
    apart += 32.0 * EPSILON * float(np.max(place))
    far = float(np.max(moved(lambda one: _peaks(one, *asked)[1].value), initial=0.0))
    by_peak = names | {"peak": np.arange(1, most + 1)}
    scene.emit(f"{RESPONSE_ROOT}/peak/magnitude", height, np.max(off) + far, by_peak)
    scene.emit(f"{RESPONSE_ROOT}/peak/frequency_ratio", place, apart, by_peak)
    largest, error, where = np.array([one for _, _, one in tops]).T
    scene.emit(f"{RESPONSE_ROOT}/largest", largest, np.max(error) + far, names)
    scene.emit(f"{RESPONSE_ROOT}/largest_frequency_ratio", where, apart, names)

    def reach(one: Fitted) -> np.ndarray:
        """Largest travel of each absorber, and its error (2, a)."""
        found = (highest(one, excitation, "travel", absorber=place) for place in range(count))
        return np.array([(top[0], slack[0]) for top, slack, _ in found]).T

    travels, off = np.stack([reach(one) for one in systems], axis=1)
    error = np.max(off) + float(np.max(moved(lambda one: reach(one)[0])))
    scene.emit(f"{RESPONSE_ROOT}/each/largest_travel", travels, error, names | absorbers)
    scene.cite(
        "complex response of a tree of masses, exact peaks between seeds about all poles",
        "curves, peaks, travel",
        "docs/theory_absorber_parts.md",
    )


def system_of(parts: AbsorberParts, mass: FloatArray, ratios: FloatArray) -> Fitted:
    """Absorbers with k, then z (2 a,), on the primary of one mode."""
    carrier = tuple(branch.carrier for branch in parts.branches)
    modes = one_mode(parts.primary_damping, len(mass))
    stiffness, damping = np.split(ratios, 2)
    return fitted(modes, mass, stiffness, damping, carrier)


_Tops = tuple[FloatArray, Bounded, tuple[float, float, float]]


def _peaks(system: Fitted, excitation: str, what: str) -> _Tops:
    """Places and heights of all peaks, then the largest |H|, its error and the lowest place.

    On an undamped natural frequency the largest is infinite.
    """
    try:
        tops = tops_within(system, excitation, what)
    except NumericalFailure:
        return np.zeros(0), Bounded(np.zeros(0), np.zeros(0)), (np.inf, 0.0, np.inf)
    value, error, _ = (float(part[0]) for part in tops.largest(1))
    first = int(np.argmax(tops.height.value >= value * (1.0 - SAME_HEIGHT)))
    inside = (tops.place.value > 0.0) & np.isfinite(tops.place.value)
    where = float(tops.place.value[first])
    return tops.place.value[inside], tops.height[inside], (value, error, where)


def _limit(
    parts: AbsorberParts, mass: FloatArray, stiff: float, excitation: str, response: str
) -> _Tops:
    """The same of all masses fastened rigidly, or of none: the primary, a system of one mass."""
    one = Absorber(parts.primary_damping, float(np.sum(mass)), stiff, 0.0)
    tops = peaks(one, excitation, response)
    there = tops.present & np.isfinite(tops.magnitude)  # an infinite one is shown by the largest
    return tops.frequency[there], Bounded(tops.magnitude[there], tops.error[there]), (
        float(tops.largest), float(tops.largest_error), float(tops.where),
    )  # fmt: skip
