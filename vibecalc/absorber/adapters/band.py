"""Adapter: the tuning of absorbers by one search: several, or within a band, with tolerances."""

from typing import Any

import numpy as np

from vibecalc.absorber.adapters.optimum import (
    emit_active,
    emit_methods,
    emit_mistuning,
    limits_of,
    of_one,
)
from vibecalc.absorber.adapters.response import TuningError, moved_by_ratios, tuning_error
from vibecalc.absorber.adapters.tuning import emit_tuned, named, nearby, paths_below
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.model import AbsorberParts, build_absorber, modes_of
from vibecalc.absorber.motion_results import BAND_ROOT, OPTIMUM_ROOT, TOLERANCES_ROOT
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.stage import is_banded
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.band import BandTuning, band_tuning, spread, tuned_to
from vibecalc.absorber.tuning.levels import (
    NOMINAL,
    BandProblem,
    largest_alone,
    largest_in,
    states_of,
)
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.schema import Machine

#: a peak this close to the one without an absorber is no lower
_NO_LOWER = 1e-9
#: parts drawn between their tolerances
_DRAWN = 256


def run_band_tuning(scene: Scene) -> None:
    """Emit the best springs and dampers of several absorbers or for a band; hand them on."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    assert options is not None
    problem, scale = problem_of(options, parts, scene.case.machine), parts.scale
    as_given, banded = options.frequency is not None, is_banded(scene.case)
    if options.frequency is not None and scale is not None:
        found = tuned_to(problem, options.frequency / scale.frequency)
    else:
        found = band_tuning(problem)
    alone, slack = largest_alone(problem)
    helps = found.largest < alone * (1.0 - _NO_LOWER)
    scene.emit(f"{TUNING_ROOT}/primary_damping", parts.primary_damping)
    scene.emit(f"{TUNING_ROOT}/peak", found.largest, found.largest_error)
    scene.emit(f"{TUNING_ROOT}/peak_alone", alone, slack if np.isfinite(alone) else 0.0)
    _hand_on(scene, parts, found)
    emit_tuned(scene, options, parts, found if parts.branches else of_one(found))
    if as_given and scene.wants(*paths_below("optimum")):
        nearby(scene, "optimum", lambda: _emit_optimum(scene, problem))
    if banded:
        if not as_given:
            scene.emit(f"{TUNING_ROOT}/helps", int(helps))
            # zero at the exact optimum, so that all of it is error
            scene.emit(f"{BAND_ROOT}/residual", found.residual, found.residual + EPSILON, terms=1.0)
        scene.emit(f"{BAND_ROOT}/from", problem.low, 4.0 * EPSILON * problem.low)
        scene.emit(f"{BAND_ROOT}/to", problem.high, 4.0 * EPSILON * problem.high)
    else:
        scene.emit(
            f"{TUNING_ROOT}/certificate", found.residual, found.residual + EPSILON, terms=1.0
        )
    scene.emit(f"{TUNING_ROOT}/evaluations", found.evaluations)
    _emit_travel(scene, parts, problem, found)
    emit_active(scene, found, as_given)
    if options.tolerances is not None:
        _emit_tolerances(scene, problem, found)
    _emit_next_to(scene, options, problem, found, banded)
    if found.unsprung:
        scene.warn("the optimum absorber for this band is practically a damper without a spring")
    if found.is_set and not helps and options.bounds is None:
        scene.warn("many tunings are equally good: the largest response is at one end")
    elif not (helps or as_given):
        scene.warn(
            f"no absorber of this mass does better than none within the band: the largest response "
            f"is {found.largest:.6g} with the best of them, {alone:.6g} without"
            if banded else
            f"no absorbers within the bounds do better than none: with the best of them the "
            f"largest response is {found.largest:.6g}, without absorbers {alone:.6g}"
        )  # fmt: skip
    elif not as_given and len(problem.mass) > 1 and found.agreeing < 2:
        scene.warn("only one of the best starts ends at this tuning; another may be better")
    _warn_of_bounds(scene, options, parts, problem, found)
    scene.cite(
        "sequential quadratic programming on the levels of all peaks, then Newton's method",
        "tuning within a band" if banded else "tuning of several absorbers, from a dozen starts",
        "docs/theory_absorber.md",
    )


def _hand_on(scene: Scene, parts: AbsorberParts, found: BandTuning) -> None:
    """Hand the tuned absorbers on, or the single one."""
    off = tuning_error(found.stiffness_error, found.damping_error)
    if parts.branches:
        scene.handed_on["several"] = found.stiffness_ratio, found.secondary_damping
        scene.handed_on["several_uncertainty"] = off
    elif parts.absorber is not None:
        k, z, *_ = of_one(found)
        m = float(np.asarray(parts.absorber.mass_ratio))
        scene.handed_on["tuned"] = Absorber(parts.primary_damping, m, k, z)
        scene.handed_on["band_active"] = found.state, found.frequency
        scene.handed_on["tuned_uncertainty"] = TuningError(*(part[0] for part in off))


def _emit_optimum(scene: Scene, problem: BandProblem) -> None:
    """What is best for the band, next to an absorber that swings at a frequency as given."""
    best = band_tuning(problem)
    _emit_ratios(scene, OPTIMUM_ROOT, best)
    scene.emit(f"{OPTIMUM_ROOT}/peak", best.largest, best.largest_error)


def _emit_ratios(scene: Scene, root: str, one: BandTuning) -> None:
    """Spring and damper of a single absorber."""
    k, z = one.stiffness_ratio[0], one.secondary_damping[0]
    scene.emit(f"{root}/stiffness_ratio", k, one.stiffness_error[0])
    scene.emit(f"{root}/damping_over_primary_critical", z, one.damping_error[0])


def problem_of(options: Tuning, parts: AbsorberParts, machine: Machine) -> BandProblem:
    """The band over the first natural frequency, all frequencies without one, states, bounds."""
    several = parts.branches
    if machine.primary is None or (parts.absorber is None and not several):
        raise ValueError("the case has no absorber to tune")
    masses = [branch.mass_ratio for branch in several]
    if parts.absorber is not None:
        masses = [float(np.asarray(parts.absorber.mass_ratio))]
    low, high = 0.0, np.inf
    if options.band_ratios is not None:
        low, high = options.band_ratios.start, options.band_ratios.stop
    elif options.band is not None and parts.scale is not None:
        natural = parts.scale.frequency
        low, high = options.band.start / natural, options.band.stop / natural
    off, limits = options.tolerances, limits_of(options)
    shares = (
        (0.0,) * 4 if off is None else tuple(getattr(off, name) for name in NAMES["toleranced"])
    )
    return BandProblem(
        modes_of(machine.primary, parts.scale, several), np.array(masses),
        options.excitation, options.response, low, high,
        states_of((shares[0], shares[1], shares[2], shares[3])), *limits,
        carrier=tuple(branch.carrier for branch in several),
    )  # fmt: skip


def _emit_travel(
    scene: Scene, parts: AbsorberParts, problem: BandProblem, found: BandTuning
) -> None:
    each = (
        _read(problem, found, response="travel", absorber=place)
        for place in range(len(problem.mass))
    )
    value, error = np.array([(np.max(one.value), np.max(one.error)) for one in each]).T
    if parts.branches:
        scene.emit(f"{TUNING_ROOT}/each/travel", value, error, named(parts))
    else:
        scene.emit(f"{TUNING_ROOT}/travel", value[0], error[0])


def _emit_tolerances(scene: Scene, problem: BandProblem, found: BandTuning) -> None:
    """What the tolerances cost, next to a tuning that knows none; parts drawn between them."""
    scene.emit(f"{TOLERANCES_ROOT}/nominal_peak", _read(problem, found, NOMINAL)[0])
    scene.emit(f"{TOLERANCES_ROOT}/worst_peak", found.largest, found.largest_error)
    held = found.state[found.limit == 0]
    axes = {"active": np.arange(1, len(held) + 1), "toleranced": NAMES["toleranced"]}
    scene.emit(f"{TOLERANCES_ROOT}/deviation", problem.states[held], 0.0, axes)
    shares = np.max(np.abs(problem.states), axis=0)
    drawn = (2.0 * spread(_DRAWN, len(shares)) - 1.0) * shares
    inside, _ = largest_in(problem, found.stiffness_ratio, found.secondary_damping, drawn)
    place = int(np.argmax(inside))
    most = float(inside[place])
    scene.emit(f"{TOLERANCES_ROOT}/inside_peak", _read(problem, found, drawn[place : place + 1])[0])
    if most > found.largest * (1.0 + _NO_LOWER):
        scene.warn(
            f"the worst case lies between the tolerances: {most:.6g} there, "
            f"{found.largest:.6g} at their ends and the nominal values, which were examined"
        )
    exact = band_tuning(problem._replace(states=NOMINAL))
    root = f"{TOLERANCES_ROOT}/exact"
    if len(problem.mass) == 1:
        _emit_ratios(scene, root, exact)
    scene.emit(f"{root}/nominal_peak", exact.largest, exact.largest_error)
    worst = _read(problem, exact)
    scene.emit(f"{root}/worst_peak", np.max(worst.value), np.max(worst.error))


def _read(
    problem: BandProblem, found: BandTuning, states: FloatArray | None = None, **what: Any
) -> Bounded:
    """Largest response (s,) of a tuning in states, or other readings; with errors of the tuning."""

    def read(both: FloatArray) -> tuple[FloatArray, FloatArray]:
        stiffness, damping = np.split(both, 2)
        return largest_in(problem, stiffness, damping, states, **what)

    ratios = np.concatenate([found.stiffness_ratio, found.secondary_damping])
    errors = np.concatenate([found.stiffness_error, found.damping_error])
    value, error = read(ratios)
    moved = moved_by_ratios(lambda both: read(both)[0], ratios, errors)
    return Bounded(value, error + np.max(moved))


def _emit_next_to(
    scene: Scene, options: Tuning, problem: BandProblem, found: BandTuning, banded: bool
) -> None:
    """Closed forms by their true peak in the worst state; losses by errors of the nominal parts."""
    if options.compare:

        def worst(stiff: FloatArray, damped: FloatArray) -> Bounded:
            tops = [largest_in(problem, k, z) for k, z in np.array([stiff, damped]).T[..., None]]
            return Bounded(*np.array([np.max(one, axis=1) for one in tops]).T)

        best = of_one(found)
        emit_methods(scene, options, float(problem.mass[0]), best, found.largest, worst, worst)
    if options.mistuning:

        def off(stiff: FloatArray, damped: FloatArray) -> Bounded:
            none = np.zeros(len(stiff))
            return _read(problem, found, np.stack([none, none, stiff, damped], axis=1))

        emit_mistuning(scene, options, off, banded)


def _warn_of_bounds(
    scene: Scene, options: Tuning, parts: AbsorberParts, problem: BandProblem, found: BandTuning
) -> None:
    """Words on bounds that hold the tuning."""
    if options.bounds is None:
        return
    names = [f" of {branch.name!r}" for branch in parts.branches] or [""]
    for what, values, ends in (
        ("stiffness", found.stiffness_ratio, problem.stiffness),
        ("damping", found.secondary_damping, problem.damping),
    ):
        for name, value in zip(names, values, strict=True):
            for end in ends:
                if 0.0 < end < np.inf and abs(value - end) <= 1e-9 * end:
                    scene.warn(
                        f"the tuning{name} is limited by the bound on its {what} ratio, {end:.6g}"
                    )
    for place in sorted({*found.limit[found.limit > 0]}):
        scene.warn(
            f"the tuning{names[place - 1]} is limited by the bound on its travel, "
            f"{problem.travel:.6g}"
        )
