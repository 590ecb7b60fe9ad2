"""Adapter: curves and peaks of several absorbers, as given or tuned."""

from functools import partial

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.machine.absorber import AbsorberParts
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.pipeline.entries.absorber import ROOT as RESPONSE
from vibecalc.pipeline.plan_absorber import asked_of
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber import TRAVEL, emit_frequencies, frequency_ratios
from vibecalc.pipeline.stages.absorber_doubt import Doubt, doubt_of, moved_several
from vibecalc.pipeline.stages.absorber_several import (
    Peaks,
    is_fastened,
    numbers,
    parents_of,
    peaks_of,
    places_near,
    reach,
)
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks
from vibecalc.response.absorber.several import Several
from vibecalc.response.absorber.several_error import several_with_error

#: curves of the primary with all masses fastened rigidly, and with none
_LIMITS = ("locked", "free")
#: roundings of a place
_PLACE = 16.0 * EPSILON


def run_response(scene: Scene, parts: AbsorberParts) -> None:
    """Emit the curves of several absorbers: as given or tuned, and over the primary damping."""
    case = scene.case
    assert case.response is not None and case.response.absorber is not None
    options, pair = case.response.absorber, asked_of(case)
    system, first = scene.handed_on.get("several"), "tuned"
    if system is None:
        system, first = _given(parts), "as given"
    names, systems = [first], [system]
    if options.limits:
        names += ["locked", "free"]
        hard = np.full(len(parts.branches), np.inf)
        systems += [system._replace(stiffness_ratio=hard), _free(system)]
    for value in options.vary.primary_damping if options.vary is not None else ():
        names.append(f"primary damping {value:g}")
        systems.append(system._replace(primary_damping=value))
    ratios = frequency_ratios(options, parts)
    emit_frequencies(scene, parts, ratios)
    axes = {"curve": tuple(names), "frequency_ratio": ratios}
    doubt = scene.handed_on.get("several_doubt", doubt_of(0.0, 0.0))
    values, error = _curves(systems, ratios, pair[0], pair[1], 1, doubt)
    scene.emit(f"{RESPONSE}/curve", values, error, axes)
    moves = [_curves(systems, ratios, pair[0], TRAVEL, n, doubt) for n in numbers(system)]
    values, error = (np.stack([one[i] for one in moves], axis=1) for i in range(2))
    absorbers = {"absorber": tuple(branch.name for branch in parts.branches)}
    scene.emit(
        f"{RESPONSE}/each/relative_curve", values, error,
        {"curve": tuple(names), **absorbers, "frequency_ratio": ratios},
    )  # fmt: skip
    _emit_peaks(scene, tuple(names), systems, pair, doubt, absorbers)
    scene.cite(
        "complex response of a tree of masses, exact peaks from the stationarity polynomial",
        "curves, peaks, travel",
        "docs/theory_absorber.md",
    )


def _curves(
    systems: list[Several], ratios: np.ndarray, excitation: str, response: str, absorber: int,
    doubt: Doubt,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """One response of all systems over the frequency, with errors; the first may be tuned."""
    none = np.zeros(len(ratios))
    each = [
        WithError(none.astype(complex), none)
        if response == TRAVEL and is_fastened(one, absorber)
        else several_with_error(one, ratios, excitation, response, absorber)
        for one in systems
    ]
    values, error = (np.stack([one[i] for one in each]) for i in range(2))
    read = partial(_shown, ratios, excitation, response, absorber=absorber)
    error[0] += moved_several(read, systems[0], doubt)
    return values, error


def _shown(
    ratios: np.ndarray, excitation: str, response: str, system: Several, absorber: int = 1
) -> np.ndarray:
    return several_with_error(system, ratios, excitation, response, absorber).value


def _free(system: Several) -> Several:
    nothing = np.zeros(len(system.parent))
    return system._replace(stiffness_ratio=nothing, secondary_damping=nothing)


def _given(parts: AbsorberParts) -> Several:
    rows = [(b.mass_ratio, b.stiffness_ratio, b.secondary_damping) for b in parts.branches]
    if any(value is None for row in rows for value in row):
        raise NumericalFailure("an absorber has no spring or no damper, and no tuning finds it")
    m, k, z2 = np.array(rows, dtype=float).T
    return Several(parts.primary_damping, m, k, z2, parents_of(parts))


def _emit_peaks(
    scene: Scene, names: tuple[str, ...], systems: list[Several], pair: tuple[str, str],
    doubt: Doubt, absorbers: dict[str, tuple[str, ...]],
) -> None:  # fmt: skip
    found = [
        _limit(name, one, pair[0], pair[1]) if name in _LIMITS else peaks_of(one, pair[0], pair[1])
        for name, one in zip(names, systems, strict=True)
    ]
    most = max(1, *(len(one.frequency) for one in found))
    place, height = np.zeros((len(found), most)), np.zeros((len(found), most))
    for row, one in enumerate(found):
        place[row, : len(one.frequency)] = one.frequency
        height[row, : len(one.frequency)] = one.magnitude
    error = max((float(np.max(one.error, initial=0.0)) for one in found), default=0.0)
    # of the first curve, which may be a tuned one
    own = found[0].frequency
    far = [
        float(np.max(moved_several(read, systems[0], doubt), initial=0.0))
        for read in (
            lambda one: peaks_of(one, *pair).magnitude,
            lambda one: places_near(one, pair, own),
            lambda one: reach(one, pair[0])[0],
        )
    ]
    near = far[1] + 2.0 * _PLACE * np.max(place)
    axes = {"curve": names}
    summits = axes | {"summit": np.arange(1, most + 1)}
    scene.emit(f"{RESPONSE}/summit/magnitude", height, error + far[0], summits)
    scene.emit(f"{RESPONSE}/summit/frequency_ratio", place, near, summits)
    largest = np.array([one.largest for one in found])
    where = np.array([one.where for one in found])
    error = max(one.largest_error for one in found) + far[0]
    scene.emit(f"{RESPONSE}/largest", largest, error, axes)
    scene.emit(f"{RESPONSE}/largest_frequency_ratio", where, near, axes)
    travels, off = (
        np.stack(rows) for rows in zip(*(reach(one, pair[0]) for one in systems), strict=True)
    )
    error = np.max(off) + far[2]
    scene.emit(f"{RESPONSE}/each/largest_travel", travels, error, axes | absorbers)


def _limit(name: str, system: Several, excitation: str, response: str) -> Peaks:
    """Of all masses fastened rigidly, or of none: the primary, a system of one mass."""
    mass = float(np.sum(system.mass_ratio))
    stiff = np.inf if name == "locked" else 0.0
    one = peaks(Absorber(system.primary_damping, mass, stiff, 0.0), excitation, response)
    there = one.found & np.isfinite(one.magnitude)  # an infinite one is told by the largest
    return Peaks(
        one.frequency[there], one.magnitude[there], one.error[there],
        float(one.largest), float(one.largest_error), float(one.where),
    )  # fmt: skip
