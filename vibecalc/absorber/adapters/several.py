"""Adapter: tuning and response of several absorbers on one primary system."""

from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.adapters.response import (
    TRAVEL,
    TuningError,
    emit_frequencies,
    frequency_ratios,
    moved_several,
    tuning_error,
    weight_error,
)
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.results import RESPONSE_ROOT as RESPONSE
from vibecalc.absorber.several import Several, several_with_error
from vibecalc.absorber.several_peaks import SeveralPeaks, several_peaks
from vibecalc.absorber.stage import LIMITS, asked_of, curve_names
from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.absorber.tuning.several import tuned as solved
from vibecalc.absorber.tuning.several_search import Travel, TuningProblem
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# Adapter: several absorbers on one primary, next to each other or one on another.
# ----------------------------------------------------------------------------

STARTS = 12
#: a peak this close to the one without absorbers is no lower
_NO_LOWER = 1e-9
#: roundings of a place or a weight
_PLACE = 16.0 * EPSILON


class SystemPeaks(NamedTuple):
    """Maxima (p,) of one system, and the largest response with its place."""

    frequency: np.ndarray
    magnitude: np.ndarray
    error: np.ndarray
    largest: float
    largest_error: float
    where: float


def run_several_tuning(scene: Scene) -> None:
    """Emit the tuning of all absorbers together; hand on the system."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    assert options is not None
    z1, pair = parts.primary_damping, (options.excitation, options.response)
    m = np.array([branch.mass_ratio for branch in parts.branches])
    best = solved(_problem(options, parts, m), STARTS)
    scene.emit(f"{TUNING_ROOT}/primary_damping", z1)
    system, uncertainty = hand_on(
        scene, parts, best.stiffness_ratio, best.secondary_damping, *np.split(best.ratio_error, 2)
    )
    names = named(parts)
    scene.emit(f"{TUNING_ROOT}/peak", best.peak, best.peak_error)
    alone = peaks(Absorber(z1, 1.0, 0.0, 0.0), *pair)
    least = float(alone.largest)
    scene.emit(
        f"{TUNING_ROOT}/peak_alone",
        least,
        float(alone.largest_error) if np.isfinite(least) else 0.0,
    )
    _emit_travels(scene, system, pair[0], uncertainty, names)
    axes = {"active": np.arange(1, len(best.frequency) + 1)}
    height = np.full(len(best.frequency), best.peak)
    far = moved_several(lambda one: places_near(one, pair, best.frequency), system, uncertainty)
    scene.emit(f"{TUNING_ROOT}/active/frequency_ratio", best.frequency, far + _PLACE, axes)
    scene.emit(f"{TUNING_ROOT}/active/magnitude", height, best.peak_error, axes)
    far = weight_error(system, transfer_of(*pair), best.frequency, best.weight, uncertainty)
    scene.emit(f"{TUNING_ROOT}/active/weight", best.weight, far + _PLACE, axes)
    # zero at the exact optimum, so that all of it is error
    scene.emit(f"{TUNING_ROOT}/certificate", best.residual, best.residual + _PLACE, terms=1.0)
    scene.emit(f"{TUNING_ROOT}/evaluations", best.evaluations)
    if options.mistuning:
        _emit_mistuning(scene, options, system, best.peak, uncertainty)
    if options.bounds is not None and best.peak >= least * (1.0 - _NO_LOWER):
        scene.warn(
            f"no absorbers within the bounds do better than none: with the best of them the "
            f"largest response is {best.peak:.6g}, without absorbers {least:.6g}"
        )
    elif best.no_help:
        scene.warn("many tunings are as good: the largest response stands at one end")
    elif best.agreeing < 2:
        scene.warn("only one of the best starts ends at this tuning; another may be better")
    scene.cite(
        "sequential quadratic programming on the levels of all peaks, then Newton's method",
        "tuning of several absorbers, from a dozen starts",
        "docs/theory_absorber_tuning.md",
    )


def _emit_travels(
    scene: Scene,
    system: Several,
    excitation: str,
    uncertainty: TuningError,
    names: dict[str, tuple[str, ...]],
) -> None:
    """Largest motion of each absorber against what carries it."""
    travels, error = reach(system, excitation)
    far = moved_several(lambda one: reach(one, excitation)[0], system, uncertainty)
    scene.emit(f"{TUNING_ROOT}/each/travel", travels, error + far, names)


def named(parts: AbsorberParts) -> dict[str, tuple[str, ...]]:
    """The axis of all absorbers."""
    return {"absorber": tuple(branch.name for branch in parts.branches)}


def hand_on(
    scene: Scene, parts: AbsorberParts, k: FloatArray, z2: FloatArray, stiffness_error: FloatArray,
    damping_error: FloatArray,
) -> tuple[Several, TuningError]:  # fmt: skip
    """Emit mass, spring and damper of each absorber, in units where the primary has them."""
    m = np.array([branch.mass_ratio for branch in parts.branches])
    system, names = Several(parts.primary_damping, m, k, z2, parents_of(parts)), named(parts)
    uncertainty = tuning_error(stiffness_error, damping_error)
    scene.handed_on["several"] = system
    scene.handed_on["several_uncertainty"] = uncertainty
    root = f"{TUNING_ROOT}/each"
    scene.emit(f"{root}/mass_ratio", m, 2.0 * EPSILON * np.max(m), names)
    scene.emit(f"{root}/stiffness_ratio", k, stiffness_error, names)
    scene.emit(f"{root}/secondary_damping", z2, damping_error, names)
    sprung = k > 0.0
    safe = np.where(sprung, k, 1.0)
    own = np.where(sprung, z2 / np.sqrt(m * safe), 0.0)
    off = uncertainty.damping / np.sqrt(m * safe) + 0.5 * own * uncertainty.stiffness / safe
    scene.emit(f"{root}/own_damping", own, np.where(sprung, off, 0.0) + 4.0 * EPSILON * own, names)
    scale = parts.scale
    if scale is None:
        return system, uncertainty
    kind = "torsional" if scale.torsion else "linear"
    for name, unit, ratio, error in (
        ("stiffness", scale.stiffness, k, uncertainty.stiffness),
        ("damping", scale.damping, z2, uncertainty.damping),
    ):
        finite, off = np.isfinite(ratio), unit * (error + 8.0 * EPSILON * ratio)
        scene.emit(f"{root}/{kind}_{name}", unit * ratio, np.where(finite, off, 0.0), names)
    frequency = scale.frequency * np.sqrt(k / m)
    share = uncertainty.stiffness / np.where(sprung & np.isfinite(k), k, 1.0) + 8.0 * EPSILON
    error = np.where(np.isfinite(frequency), frequency * share, 0.0)
    scene.emit(f"{root}/frequency", frequency, error, names)
    return system, uncertainty


def numbers(system: Several) -> range:
    """Of all absorbers, from 1."""
    return range(1, len(system.parent) + 1)


def places_near(system: Several, pair: tuple[str, str], near: np.ndarray) -> np.ndarray:
    """Frequencies of the peaks next to some."""
    found = several_peaks(system, *pair).frequency
    if not len(near) or not len(found):
        return near
    return np.asarray(found[np.argmin(np.abs(found - near[:, None]), axis=1)])


def _problem(options: Tuning, parts: AbsorberParts, m: np.ndarray) -> TuningProblem:
    bounds, count = options.bounds, len(m)
    lower, upper = np.zeros(2 * count), np.full(2 * count, np.inf)
    travel: tuple[Travel, ...] = ()
    if bounds is not None:
        for given, place in (
            (bounds.stiffness_ratio, slice(0, count)),
            (bounds.damping_ratio, slice(count, None)),
        ):
            if given is not None:
                lower[place], upper[place] = given
        if bounds.travel is not None:
            travel = tuple(Travel(number, bounds.travel) for number in range(1, count + 1))
    return TuningProblem(
        parts.primary_damping,
        m,
        parents_of(parts),
        options.excitation,
        options.response,
        lower,
        upper,
        travel,
    )


def parents_of(parts: AbsorberParts) -> tuple[int, ...]:
    """What each hangs on: 0 the primary, j the j-th absorber."""
    return tuple(branch.carrier + 1 for branch in parts.branches)


def _emit_mistuning(
    scene: Scene, options: Tuning, system: Several, best: float, uncertainty: TuningError
) -> None:
    """All springs, or all dampers, off by the same share."""
    pair = options.excitation, options.response
    sizes = np.array(sorted({sign * size for size in options.mistuning for sign in (-1.0, 1.0)}))
    keys = ("stiffness_ratio", "secondary_damping")

    def mistuned(absorbers: Several) -> list[list[SeveralPeaks]]:
        parts = [(key, np.asarray(getattr(absorbers, key))) for key in keys]
        return [
            [
                several_peaks(absorbers._replace(**{key: part * (1.0 + size)}), *pair)
                for size in sizes
            ]
            for key, part in parts
        ]

    def tops(absorbers: Several) -> np.ndarray:
        return np.array([[one.largest for one in row] for row in mistuned(absorbers)])

    responses = mistuned(system)
    loss = np.array([[one.largest for one in row] for row in responses]) / best - 1.0
    error = max(one.largest_error for row in responses for one in row) + moved_several(
        tops, system, uncertainty
    )
    axes = {"mistuned": NAMES["mistuned"], "deviation": sizes}
    scene.emit(f"{TUNING_ROOT}/mistuning/loss", loss, 2.0 * error / best, axes)


def reach(system: Several, excitation: str) -> tuple[np.ndarray, np.ndarray]:
    """Largest travel of each absorber, and its error."""
    none = np.zeros(0)
    each = [
        SystemPeaks(none, none, none, 0.0, 0.0, 0.0)
        if is_fastened(system, number)
        else peaks_of(system, excitation, TRAVEL, number)
        for number in numbers(system)
    ]
    return np.array([one.largest for one in each]), np.array([one.largest_error for one in each])


def is_fastened(system: Several, number: int) -> bool:
    """Whether an absorber, counted from 1, is fastened rigidly to what carries it."""
    return bool(np.isinf(np.asarray(system.stiffness_ratio)[number - 1]))


def peaks_of(system: Several, excitation: str, response: str, absorber: int = 1) -> SystemPeaks:
    """All peaks; on an undamped natural frequency the largest is infinite."""
    try:
        found = several_peaks(system, excitation, response, absorber)
    except NumericalFailure:
        none = np.zeros(0)
        return SystemPeaks(none, none, none, np.inf, 0.0, np.inf)
    return SystemPeaks(
        found.frequency,
        found.magnitude,
        found.error,
        found.largest,
        found.largest_error,
        found.where,
    )


# ----------------------------------------------------------------------------
# Adapter: curves and peaks of several absorbers, as given or tuned.
# ----------------------------------------------------------------------------


def run_several_response(scene: Scene) -> None:
    """Emit the curves of several absorbers: as given or tuned, and over the primary damping."""
    case, parts = scene.case, build_absorber(scene.case)
    assert case.response is not None and case.response.absorber is not None
    options, pair = case.response.absorber, asked_of(case)
    system = scene.handed_on.get("several") or given_system(parts)
    names, systems = curve_names(case), [system]
    if options.limits:
        hard = np.full(len(parts.branches), np.inf)
        systems += [system._replace(stiffness_ratio=hard), _free(system)]
    for value in options.vary.primary_damping if options.vary is not None else ():
        systems.append(system._replace(primary_damping=value))
    ratios = frequency_ratios(options, parts)
    emit_frequencies(scene, parts, ratios)
    axes = {"curve": names, "frequency_ratio": ratios}
    uncertainty = scene.handed_on.get("several_uncertainty", tuning_error(0.0, 0.0))
    values, error = _curves(systems, ratios, pair[0], pair[1], 1, uncertainty)
    scene.emit(f"{RESPONSE}/curve", values, error, axes)
    moves = [_curves(systems, ratios, pair[0], TRAVEL, n, uncertainty) for n in numbers(system)]
    values, error = (np.stack([one[i] for one in moves], axis=1) for i in range(2))
    absorbers = named(parts)
    scene.emit(
        f"{RESPONSE}/each/relative_curve",
        values,
        error,
        {"curve": names, **absorbers, "frequency_ratio": ratios},
    )
    _emit_peaks(scene, names, systems, pair, uncertainty, absorbers)
    scene.cite(
        "complex response of a tree of masses, exact peaks from the stationarity polynomial",
        "curves, peaks, travel",
        "docs/theory_absorber.md",
    )


def _curves(
    systems: list[Several],
    ratios: np.ndarray,
    excitation: str,
    response: str,
    absorber: int,
    uncertainty: TuningError,
) -> tuple[np.ndarray, np.ndarray]:
    """One response of all systems over the frequency, with errors; the first may be tuned."""
    none = np.zeros(len(ratios))
    each = [
        Bounded(none.astype(complex), none)
        if response == TRAVEL and is_fastened(one, absorber)
        else several_with_error(one, ratios, excitation, response, absorber)
        for one in systems
    ]
    values, error = stack(each, axis=0)
    read = partial(_shown, ratios, excitation, response, absorber=absorber)
    error[0] += moved_several(read, systems[0], uncertainty)
    return values, error


def _shown(
    ratios: np.ndarray, excitation: str, response: str, system: Several, absorber: int = 1
) -> np.ndarray:
    return several_with_error(system, ratios, excitation, response, absorber).value


def _free(system: Several) -> Several:
    nothing = np.zeros(len(system.parent))
    return system._replace(stiffness_ratio=nothing, secondary_damping=nothing)


def given_system(parts: AbsorberParts) -> Several:
    """The absorbers as the case gives them; raises NumericalFailure where something is missing."""
    rows = [(b.mass_ratio, b.stiffness_ratio, b.secondary_damping) for b in parts.branches]
    if any(value is None for row in rows for value in row):
        raise NumericalFailure("an absorber has no spring or no damper, and no tuning finds it")
    m, k, z2 = np.array(rows, dtype=float).T
    return Several(parts.primary_damping, m, k, z2, parents_of(parts))


def _emit_peaks(
    scene: Scene,
    names: tuple[str, ...],
    systems: list[Several],
    pair: tuple[str, str],
    uncertainty: TuningError,
    absorbers: dict[str, tuple[str, ...]],
) -> None:
    tops = [
        _limit(name, one, pair[0], pair[1]) if name in LIMITS else peaks_of(one, pair[0], pair[1])
        for name, one in zip(names, systems, strict=True)
    ]
    most = max(1, *(len(one.frequency) for one in tops))
    place, height = np.zeros((len(tops), most)), np.zeros((len(tops), most))
    for row, one in enumerate(tops):
        place[row, : len(one.frequency)] = one.frequency
        height[row, : len(one.frequency)] = one.magnitude
    error = max((float(np.max(one.error, initial=0.0)) for one in tops), default=0.0)
    # of the first curve, which may be a tuned one
    frequency = tops[0].frequency
    far = [
        float(np.max(moved_several(read, systems[0], uncertainty), initial=0.0))
        for read in (
            lambda one: peaks_of(one, *pair).magnitude,
            lambda one: places_near(one, pair, frequency),
            lambda one: reach(one, pair[0])[0],
        )
    ]
    near = far[1] + 2.0 * _PLACE * np.max(place)
    axes = {"curve": names}
    by_peak = axes | {"peak": np.arange(1, most + 1)}
    scene.emit(f"{RESPONSE}/peak/magnitude", height, error + far[0], by_peak)
    scene.emit(f"{RESPONSE}/peak/frequency_ratio", place, near, by_peak)
    largest = np.array([one.largest for one in tops])
    where = np.array([one.where for one in tops])
    error = max(one.largest_error for one in tops) + far[0]
    scene.emit(f"{RESPONSE}/largest", largest, error, axes)
    scene.emit(f"{RESPONSE}/largest_frequency_ratio", where, near, axes)
    travels, off = (
        np.stack(rows) for rows in zip(*(reach(one, pair[0]) for one in systems), strict=True)
    )
    error = np.max(off) + far[2]
    scene.emit(f"{RESPONSE}/each/largest_travel", travels, error, axes | absorbers)


def _limit(name: str, system: Several, excitation: str, response: str) -> SystemPeaks:
    """Of all masses fastened rigidly, or of none: the primary, a system of one mass."""
    mass = float(np.sum(system.mass_ratio))
    stiff = np.inf if name == "locked" else 0.0
    one = peaks(Absorber(system.primary_damping, mass, stiff, 0.0), excitation, response)
    there = one.present & np.isfinite(one.magnitude)  # an infinite one is shown by the largest
    return SystemPeaks(
        one.frequency[there],
        one.magnitude[there],
        one.error[there],
        float(one.largest),
        float(one.largest_error),
        float(one.where),
    )
