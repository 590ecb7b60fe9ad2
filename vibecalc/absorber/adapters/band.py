"""Adapter: the tuning of an absorber within a band of frequencies, with tolerances of its parts."""

from collections.abc import Callable

import numpy as np

from vibecalc.absorber.adapters.optimum import BestTuning
from vibecalc.absorber.adapters.response import moved_by_ratios, tuning_error
from vibecalc.absorber.adapters.several import hand_on, named
from vibecalc.absorber.adapters.tuning import emit_units, nearby, paths_below
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.model import AbsorberParts, build_absorber, modes_of
from vibecalc.absorber.motion_results import BAND_ROOT, OPTIMUM_ROOT, TOLERANCES_ROOT
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.transfer import Absorber, own_damping_ratio
from vibecalc.absorber.tuning.band import (
    BandProblem,
    BandTuning,
    band_tuning,
    largest_alone,
    largest_in,
    spread,
    states_of,
    tuned_to,
)
from vibecalc.absorber.tuning.closed_forms import METHODS
from vibecalc.absorber.tuning.warburton import WARBURTON
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.schema import Machine

#: a peak this close to the one without an absorber is no lower
_NO_LOWER = 1e-9
#: parts drawn between their tolerances
_DRAWN = 256


def run_band_tuning(scene: Scene) -> None:
    """Emit the best springs and dampers for the band; hand on the tuned absorbers."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    if options is None:
        raise ValueError("the case has no absorber to tune")
    problem, scale = problem_of(options, parts, scene.case.machine), parts.scale
    as_given = options.frequency is not None
    if options.frequency is not None and scale is not None:
        found = tuned_to(problem, options.frequency / scale.frequency)
    else:
        found = band_tuning(problem)
    alone, slack = largest_alone(problem)
    helps = found.largest < alone * (1.0 - _NO_LOWER)
    scene.emit(f"{TUNING_ROOT}/primary_damping", parts.primary_damping)
    scene.emit(f"{TUNING_ROOT}/peak", found.largest, found.largest_error)
    scene.emit(f"{TUNING_ROOT}/peak_alone", alone, slack if np.isfinite(alone) else 0.0)
    if parts.branches:
        hand_on(
            scene, parts, found.stiffness_ratio, found.secondary_damping, found.stiffness_error,
            found.damping_error,
        )  # fmt: skip
    else:
        _emit_one(scene, options, parts, found)
    if as_given and scene.wants(*paths_below("optimum")):
        nearby(scene, "optimum", lambda: _emit_optimum(scene, problem))
    if not as_given:
        scene.emit(f"{TUNING_ROOT}/helps", int(helps))
    scene.emit(f"{TUNING_ROOT}/evaluations", found.evaluations)
    _emit_travel(scene, parts, problem, found)
    scene.emit(f"{BAND_ROOT}/from", problem.low, 4.0 * EPSILON * problem.low)
    scene.emit(f"{BAND_ROOT}/to", problem.high, 4.0 * EPSILON * problem.high)
    if not as_given:
        # zero at the exact optimum, so that all of it is error
        scene.emit(f"{BAND_ROOT}/residual", found.residual, found.residual + EPSILON, terms=1.0)
    _emit_active(scene, found, as_given)
    if options.tolerances is not None:
        _emit_tolerances(scene, problem, found)
    if options.compare:
        _emit_methods(scene, options, problem, found)
    if "free" in found.edge:
        scene.warn("the best absorber for this band hardly has a spring: its damper does it alone")
    if options.mistuning:
        _emit_mistuning(scene, options, problem, found)
    if not (helps or as_given):
        scene.warn(
            f"no absorber of this mass does better than none within the band: the largest response "
            f"is {found.largest:.6g} with the best of them, {alone:.6g} without"
        )
    _warn_of_bounds(scene, options, parts, problem, found)
    scene.cite(
        "quadratic models of all maxima within the band, then Newton's method on equal maxima "
        "whose slopes cancel",
        "tuning within a band",
        "docs/theory_absorber_band.md",
    )


def _relative(found: BandTuning) -> float:
    """Relative error of spring and damper together, the largest of all absorbers."""
    drag = np.where(found.secondary_damping > 0.0, found.secondary_damping, 1.0)
    return float(np.max(
        found.damping_error / drag + found.stiffness_error / found.stiffness_ratio))  # fmt: skip


def _emit_one(scene: Scene, options: Tuning, parts: AbsorberParts, found: BandTuning) -> None:
    """Spring and damper of a single absorber, handed on."""
    k, z, m = (float(part) for part in (
        found.stiffness_ratio[0], found.secondary_damping[0],
        np.asarray(parts.absorber and parts.absorber.mass_ratio)))  # fmt: skip
    off = float(found.stiffness_error[0]), float(found.damping_error[0])
    tuned = Absorber(parts.primary_damping, m, k, z)
    scene.handed_on["tuned"] = tuned
    scene.handed_on["band_active"] = found.state, found.frequency
    scene.handed_on["tuned_uncertainty"] = tuning_error(*off)
    scene.emit(f"{TUNING_ROOT}/mass_ratio", m, 2.0 * EPSILON * m)
    scene.emit(f"{TUNING_ROOT}/stiffness_ratio", k, off[0])
    scene.emit(f"{TUNING_ROOT}/secondary_damping", z, off[1])
    own = float(own_damping_ratio(tuned))
    scene.emit(f"{TUNING_ROOT}/own_damping", own, own * (_relative(found) + 4.0 * EPSILON))
    best = BestTuning(k, z, *off, found.largest, found.largest_error, 0.0, 0.0, True, 0)
    emit_units(scene, options, parts, best)


def _emit_active(scene: Scene, found: BandTuning, as_given: bool) -> None:
    """Maxima of the response that hold the tuning."""
    held = found.limit == 0
    axes = {"active": np.arange(1, int(np.sum(held)) + 1)}
    near = 16.0 * EPSILON + _relative(found)
    place = found.frequency[held]
    scene.emit(f"{TUNING_ROOT}/active/magnitude", found.height[held], found.largest_error, axes)
    scene.emit(f"{TUNING_ROOT}/active/frequency_ratio", place, near * place, axes)
    if not as_given:
        off = found.residual + 1e3 * near
        scene.emit(f"{TUNING_ROOT}/active/weight", found.weight[held], off, axes)


def _emit_optimum(scene: Scene, problem: BandProblem) -> None:
    """What is best for the band, next to an absorber that swings at a frequency as given."""
    best = band_tuning(problem)
    for name, value, error in (
        ("stiffness_ratio", best.stiffness_ratio[0], best.stiffness_error[0]),
        ("secondary_damping", best.secondary_damping[0], best.damping_error[0]),
        ("peak", best.largest, best.largest_error),
    ):
        scene.emit(f"{OPTIMUM_ROOT}/{name}", value, error)


def problem_of(options: Tuning, parts: AbsorberParts, machine: Machine) -> BandProblem:
    """The band over the first natural frequency, the states, and the bounds of a case."""
    several = parts.branches
    if machine.primary is None or (parts.absorber is None and not several):
        raise ValueError("the case has no absorber to tune")
    masses = [branch.mass_ratio for branch in several]
    if parts.absorber is not None:
        masses = [float(np.asarray(parts.absorber.mass_ratio))]
    if options.band_ratios is not None:
        low, high = options.band_ratios.start, options.band_ratios.stop
    elif options.band is not None and parts.scale is not None:
        natural = parts.scale.frequency
        low, high = options.band.start / natural, options.band.stop / natural
    else:
        raise ValueError("a band in Hz needs a primary with units")
    off, bounds = options.tolerances, options.bounds
    shares = (
        (0.0,) * 4 if off is None else tuple(getattr(off, name) for name in NAMES["toleranced"])
    )
    none = (0.0, np.inf)
    return BandProblem(
        modes_of(machine.primary, parts.scale, several), np.array(masses),
        options.excitation, options.response, low, high,
        states_of((shares[0], shares[1], shares[2], shares[3])),
        none if bounds is None else bounds.stiffness_ratio or none,
        none if bounds is None else bounds.damping_ratio or none,
        np.inf if bounds is None or bounds.travel is None else bounds.travel,
        tuple(branch.carrier for branch in several),
    )  # fmt: skip


def _emit_travel(
    scene: Scene, parts: AbsorberParts, problem: BandProblem, found: BandTuning
) -> None:
    rows = []
    for place in range(len(problem.mass)):

        def travel(
            k: FloatArray, z: FloatArray, place: int = place
        ) -> tuple[FloatArray, FloatArray]:
            return largest_in(problem, k, z, response="travel", absorber=place)

        value, error = travel(found.stiffness_ratio, found.secondary_damping)
        rows.append((np.max(value), np.max(error) + _moved(found, travel)))
    value, error = np.array(rows).T
    if parts.branches:
        scene.emit(f"{TUNING_ROOT}/each/travel", value, error, named(parts))
    else:
        scene.emit(f"{TUNING_ROOT}/travel", value[0], error[0])


def _emit_tolerances(scene: Scene, problem: BandProblem, found: BandTuning) -> None:
    """What the tolerances cost, next to a tuning that knows none; parts drawn between them."""
    k, z = found.stiffness_ratio, found.secondary_damping
    nominal = np.zeros((1, len(NAMES["toleranced"])))

    def as_they_should(k: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return largest_in(problem, k, z, nominal)

    value, error = as_they_should(k, z)
    off = error[0] + _moved(found, as_they_should)
    scene.emit(f"{TOLERANCES_ROOT}/nominal_peak", value[0], off)
    scene.emit(f"{TOLERANCES_ROOT}/worst_peak", found.largest, found.largest_error)
    held = found.state[found.limit == 0]
    axes = {"active": np.arange(1, len(held) + 1), "toleranced": NAMES["toleranced"]}
    scene.emit(f"{TOLERANCES_ROOT}/deviation", problem.states[held], 0.0, axes)
    shares = np.max(np.abs(problem.states), axis=0)
    drawn = (2.0 * spread(_DRAWN, len(shares)) - 1.0) * shares

    inside, error = largest_in(problem, k, z, drawn)
    place = int(np.argmax(inside))
    most = float(inside[place])

    def there(k: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return largest_in(problem, k, z, drawn[place : place + 1])

    off = float(error[place]) + _moved(found, there)
    scene.emit(f"{TOLERANCES_ROOT}/inside_peak", most, off)
    if most > found.largest * (1.0 + _NO_LOWER):
        scene.warn(
            f"the worst case lies between the tolerances: {most:.6g} there, "
            f"{found.largest:.6g} at their ends and the nominal values, which were examined"
        )
    exact = band_tuning(problem._replace(states=nominal))
    root = f"{TOLERANCES_ROOT}/exact"
    if len(problem.mass) == 1:
        scene.emit(f"{root}/stiffness_ratio", exact.stiffness_ratio[0], exact.stiffness_error[0])
        scene.emit(f"{root}/secondary_damping", exact.secondary_damping[0], exact.damping_error[0])
    scene.emit(f"{root}/nominal_peak", exact.largest, exact.largest_error)

    def worst(k: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        return largest_in(problem, k, z)

    value, error = worst(exact.stiffness_ratio, exact.secondary_damping)
    scene.emit(f"{root}/worst_peak", np.max(value), np.max(error) + _moved(exact, worst))


def _moved(
    found: BandTuning, read: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
) -> float:
    """What the errors of a tuning do to peaks at it, at most."""
    ratios = np.concatenate([found.stiffness_ratio, found.secondary_damping])
    errors = np.concatenate([found.stiffness_error, found.damping_error])
    moved = moved_by_ratios(lambda both: read(*np.split(both, 2))[0], ratios, errors)
    return float(np.max(moved))


_NAMED = {"den_hartog": "den_hartog_brock", "nishihara_asami": "nishihara_asami"}


def _emit_methods(
    scene: Scene, options: Tuning, problem: BandProblem, found: BandTuning
) -> None:  # fmt: skip
    """Closed forms next to the tuning: their true peak in the band, in the worst state."""
    pair, m = (options.excitation, options.response), problem.mass[0]
    rows = []
    for name in options.compare:
        if name == "numerical":
            k, z = float(found.stiffness_ratio[0]), float(found.secondary_damping[0])
            promise = found.largest
        else:
            method = WARBURTON[pair] if name == "warburton" else METHODS[_NAMED[name]]
            with np.errstate(invalid="ignore"):
                k, z, promise = (float(part) for part in method.formula(m))
            scene.cite(f"closed form {name!r}: {method.validity}", "comparison", method.source)
        if not np.isfinite(z) or k < 0.0:
            raise NumericalFailure(
                f"closed form {name!r}: no tuning for a mass ratio of {float(m):g}"
            )
        value, error = largest_in(problem, np.array([k]), np.array([z]))
        rows.append((k, z, promise, float(np.max(value)), float(np.max(error))))
    k, z, promise, peak, slack = np.array(rows).T
    axes = {"method": options.compare}
    root, least = f"{TUNING_ROOT}/method", found.largest
    scene.emit(f"{root}/stiffness_ratio", k, 8.0 * EPSILON * k + found.stiffness_error[0], axes)
    scene.emit(f"{root}/secondary_damping", z, 8.0 * EPSILON * z + found.damping_error[0], axes)
    scene.emit(f"{root}/promised", promise, 16.0 * EPSILON * promise, axes)
    scene.emit(f"{root}/peak", peak, slack + found.largest_error, axes)
    off = 2.0 * (slack + found.largest_error) / least + 4.0 * EPSILON
    scene.emit(f"{root}/loss", peak / least - 1.0, off, axes)


def _emit_mistuning(
    scene: Scene, options: Tuning, problem: BandProblem, found: BandTuning
) -> None:  # fmt: skip
    """Loss by errors of spring and damper, each alone and both at worst, of the nominal system."""
    shares = np.array(sorted(set(options.mistuning)))
    signed = np.concatenate([-shares[::-1], shares])
    zero = np.zeros(len(signed))
    corners = [(a * shares, b * shares) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    pairs = [(zero[:1], zero[:1]), (signed, zero), (zero, signed), *corners]
    stiff, damped = (np.concatenate(part) for part in zip(*pairs, strict=True))
    none = np.zeros(len(stiff))
    states = np.stack([none, none, stiff, damped], axis=1)

    def losses(k: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, error = largest_in(problem, k, z, states)
        return value[1:] / value[0] - 1.0, 2.0 * np.max(error) / value[0] + EPSILON + 0.0 * value

    loss, error = losses(found.stiffness_ratio, found.secondary_damping)
    off = np.max(error) + _moved(found, losses)
    n = len(signed)
    axes = {"mistuned": NAMES["mistuned"], "deviation": signed}
    scene.emit(f"{TUNING_ROOT}/mistuning/loss", loss[: 2 * n].reshape(2, n), off, axes)
    worst = np.max(loss[2 * n :].reshape(4, len(shares)), axis=0)
    scene.emit(f"{TUNING_ROOT}/mistuning/worst", worst, off, {"share": shares})


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
                        f"the tuning{name} is held by the bound of its {what} ratio, {end:.6g}"
                    )
    for place in sorted({*found.limit[found.limit > 0]}):
        scene.warn(
            f"the tuning{names[place - 1]} is held by the bound of its travel, {problem.travel:.6g}"
        )
