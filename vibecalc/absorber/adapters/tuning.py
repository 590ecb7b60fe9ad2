"""Adapter: the optimum of one absorber with its proof, other methods, mistuning, sensitivity."""

from collections.abc import Callable

import numpy as np

from vibecalc.absorber.adapters.optimum import (
    BestTuning,
    as_best,
    best_tuning,
    emit_bounded_proof,
    emit_chart,
    emit_comparison,
    emit_map,
    is_endless,
    level_of,
    within_bounds,
)
from vibecalc.absorber.adapters.response import TuningError, moved, tuning_error
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.stage import is_over_one
from vibecalc.absorber.transfer import Absorber, own_damping_ratio
from vibecalc.absorber.tuning import mean_square as least_squares
from vibecalc.absorber.tuning.closed_forms import METHODS, closed_form, threshold
from vibecalc.absorber.tuning.minimax_steps import VERDICTS, certify
from vibecalc.absorber.tuning.mistuning import mistuning, sensitivity
from vibecalc.absorber.tuning.warburton import WARBURTON
from vibecalc.core.run.stage import Scene, below
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Adapter, continued: what a case may ask for next to a tuning of one absorber.
# ----------------------------------------------------------------------------

#: name of a method in the case -> name of its closed form, for the largest amplitude
_FORMS = {
    "den_hartog": "den_hartog_brock",
    "nishihara_asami": "nishihara_asami",
    "warburton": "warburton_acceleration",
}
#: relative step of slopes by the given ratios
_STEP = 1e-4


def emit_methods(scene: Scene, options: Tuning, tuned: Absorber, best: BestTuning) -> None:
    """Tunings by other methods, the peaks that they promise and those that they give."""
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    pair = options.excitation, options.response
    optimum, least = float(peaks(tuned, *pair).largest), float(level_of(options, tuned).value)
    names = options.compare
    rows = []
    for name in names:
        if name == "numerical":
            k, z2, promise = best.stiffness_ratio, best.secondary_damping, optimum
        elif options.norm == "h2":
            form = least_squares.closed_form(m, *pair)
            k, z2, promise = (float(x) for x in (form[0], form[1], np.inf))
        else:
            closed = closed_form(_form(name, pair), m, z1, *pair)
            k, z2 = float(closed.stiffness_ratio), float(closed.secondary_damping)
            promise = float(closed.promised)
            _cite_form(scene, name, pair)
        one = Absorber(z1, m, k, z2)
        there, level = peaks(one, *pair), level_of(options, one)
        rows.append((
            k, z2, promise, float(there.largest), float(there.largest_error),
            float(level.value), float(level.error),
        ))  # fmt: skip
    table = np.array(rows).T
    axes = {"method": names}
    slack, uncertainty = (np.where(np.isfinite(part), part, 0.0) for part in (table[4], table[6]))
    stiffness, damping = table[0], table[1]
    scene.emit(
        f"{TUNING_ROOT}/method/stiffness_ratio",
        stiffness,
        8.0 * EPSILON * stiffness + best.stiffness_error,
        axes,
    )
    scene.emit(
        f"{TUNING_ROOT}/method/secondary_damping",
        damping,
        8.0 * EPSILON * damping + best.damping_error,
        axes,
    )
    scene.emit(f"{TUNING_ROOT}/method/promised", table[2], 16.0 * EPSILON, axes)
    scene.emit(f"{TUNING_ROOT}/method/peak", table[3], slack, axes)
    scene.emit(
        f"{TUNING_ROOT}/method/loss",
        table[5] / least - 1.0,
        2.0 * uncertainty / least + 4.0 * EPSILON,
        axes,
    )


def _form(name: str, pair: tuple[str, str]) -> str:
    """Warburton's form is that of the excitation and response, where there is one."""
    if name == "warburton":
        return next((key for key, one in METHODS.items() if one is WARBURTON.get(pair)),
                    _FORMS[name])  # fmt: skip
    return _FORMS[name]


def _cite_form(scene: Scene, name: str, pair: tuple[str, str]) -> None:
    method = METHODS[_form(name, pair)]
    scene.cite(f"closed form {name!r}: {method.validity}", "comparison", method.source)


def emit_mistuning(scene: Scene, options: Tuning, tuned: Absorber) -> None:
    """What relative errors of spring and damper cost, each alone and both at worst."""
    shares = tuple(sorted(set(options.mistuning)))
    if options.norm == "h2":
        _emit_mistuned_mean(scene, options, tuned, shares)
        return
    found = mistuning(tuned, options.excitation, options.response, shares)
    signed = np.concatenate([-np.array(shares)[::-1], shares])
    rows, errors = [], []
    for part in (found.stiffness, found.damping):
        rows.append(np.concatenate([part.value[::-1, 0], part.value[:, 1]]))
        errors.append(float(np.max(part.error)))
    axes = {"mistuned": NAMES["mistuned"], "deviation": signed}
    scene.emit(f"{TUNING_ROOT}/mistuning/loss", np.array(rows), max(errors), axes)
    scene.emit(
        f"{TUNING_ROOT}/mistuning/worst", found.corner.value, found.corner.error, {"share": shares}
    )


def _emit_mistuned_mean(
    scene: Scene, options: Tuning, tuned: Absorber, shares: tuple[float, ...]
) -> None:
    """The same for a mean square."""
    size = np.array(shares)
    signed, both = np.concatenate([-size[::-1], size]), np.stack([-size, size])
    k, z2 = tuned.stiffness_ratio, tuned.secondary_damping
    least = float(level_of(options, tuned).value)

    def loss(stiff: np.ndarray, damped: np.ndarray) -> Bounded:
        off = tuned._replace(
            stiffness_ratio=np.multiply(k, 1.0 + stiff),
            secondary_damping=np.multiply(z2, 1.0 + damped),
        )
        found = level_of(options, off)
        return Bounded(found.value / least - 1.0, 2.0 * found.error / least + 4.0 * EPSILON)

    zero = np.zeros_like(signed)
    each = stack([loss(signed, zero), loss(zero, signed)], axis=0)
    axes = {"mistuned": NAMES["mistuned"], "deviation": signed}
    scene.emit(f"{TUNING_ROOT}/mistuning/loss", each, axes=axes)
    corner = loss(both[:, None, :], both[None, :, :])
    worst = np.max(corner.value, axis=(0, 1))
    scene.emit(f"{TUNING_ROOT}/mistuning/worst", worst, np.max(corner.error), {"share": shares})


def emit_sensitivity(
    scene: Scene, options: Tuning, z1: float, m: float, bounded: object = None
) -> None:
    """Slopes of the optimum by the given ratios: of its own conditions, else from differences."""
    names = NAMES["ratio"]
    if bounded is not None:
        raise NumericalFailure("bounds hold the tuning, and slopes are those of a free one")
    best = best_tuning(options, z1, m)
    if options.kind == "free" and options.norm == "h_infinity" and best.is_held:
        exact = sensitivity(
            z1, m, best.stiffness_ratio, best.secondary_damping,
            excitation=options.excitation, response=options.response,
        )  # fmt: skip
        for name, slopes, errors in (
            ("stiffness_ratio", exact.stiffness_ratio[0], exact.stiffness_error[0]),
            ("secondary_damping", exact.secondary_damping[0], exact.damping_error[0]),
            ("peak", exact.peak, exact.peak_error),
        ):
            scene.emit(f"{TUNING_ROOT}/sensitivity/{name}", slopes, errors, {"ratio": names})
        return
    pair = options.excitation, options.response
    if is_endless(pair, max(z1, EPSILON)):
        raise NumericalFailure(
            f"no slopes of this tuning: with damping of the primary the {pair[1]} under excitation "
            f"by {pair[0]} has no bound at high frequency"
        )
    derivatives: dict[str, list[tuple[float, float]]] = {"k": [], "z2": [], "peak": []}
    for place, value in enumerate((z1, m)):
        width = _STEP * max(value, 0.01 if place == 0 else 0.0)
        each = [_slopes(options, z1, m, place, step) for step in (width, 0.5 * width)]
        sharper = (4.0 * each[1] - each[0]) / 3.0
        uncertainty = np.abs(each[1] - each[0]) + 1e-13 / width
        for name, slope, error in zip(derivatives, sharper, uncertainty, strict=True):
            derivatives[name].append((float(slope), float(error)))
    axes = {"ratio": names}
    for name, key in (("stiffness_ratio", "k"), ("secondary_damping", "z2"), ("peak", "peak")):
        values, errors = np.array(derivatives[key]).T
        scene.emit(f"{TUNING_ROOT}/sensitivity/{name}", values, errors, axes)


def _slopes(options: Tuning, z1: float, m: float, place: int, step: float) -> np.ndarray:
    """Slope of k, z2 and peak; at an undamped primary by points on one side, of second order."""
    at = np.array([z1, m])
    shifts = np.array([-1.0, 0.0, 1.0])
    weights = np.array([-0.5, 0.0, 0.5])
    if at[place] - step < 0.0:
        shifts, weights = np.array([0.0, 1.0, 2.0]), np.array([-1.5, 2.0, -0.5])
    rows = []
    for shift in shifts:
        one = at.copy()
        one[place] += shift * step
        best = best_tuning(options, float(one[0]), float(one[1]))
        there = Absorber(one[0], one[1], best.stiffness_ratio, best.secondary_damping)
        top = float(peaks(there, options.excitation, options.response).largest)
        rows.append((best.stiffness_ratio, best.secondary_damping, top))
    return np.asarray(weights @ np.array(rows) / step)


# ----------------------------------------------------------------------------
# Adapter: the spring and the damper that make the response of the primary smallest.
# ----------------------------------------------------------------------------

#: peaks this close, relative to their height, hold an optimum together
_EQUAL = 1e-9
#: roundings of a place or a weight
_PLACE = 16.0 * EPSILON
#: peaks that a millionth more of a ratio leaves among those that hold it
_NEARLY = 1e-3
#: table of results -> words for it where it is left out
_LEFT_OUT = {
    "mistuning": "losses of a mistuned absorber",
    "sensitivity": "slopes of the tuning",
    "optimum": "the best tuning for the band",
}


def run_absorber_tuning(scene: Scene) -> None:
    """Emit the optimum and what the case asks for next to it; hand on the tuned absorber."""
    case = scene.case
    options, parts = case.tuning, build_absorber(case)
    if options is None:
        raise ValueError("the case has no [tuning]")
    if parts.absorber is None:
        raise ValueError("the case has no absorber to tune")
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    free = best = best_tuning(options, z1, m)
    bounded = None if options.bounds is None else within_bounds(options, z1, m, free)
    if bounded is not None:
        best = as_best(options, bounded, z1, m)
    tuned = Absorber(z1, m, best.stiffness_ratio, best.secondary_damping)
    scene.handed_on["tuned"], scene.handed_on["tuned_uncertainty"] = tuned, _uncertainty(best)
    _emit_best(scene, options, best, tuned)
    emit_units(scene, options, parts, best)
    if bounded is not None:
        emit_bounded_proof(scene, options, bounded)
    elif options.norm == "h_infinity":
        _emit_proof(scene, options, tuned, _uncertainty(best))
    alone = Absorber(z1, m, free.stiffness_ratio, free.secondary_damping)
    if options.compare and scene.wants(*paths_below("method")):
        emit_methods(scene, options, alone, free)
    if options.mistuning and scene.wants(*paths_below("mistuning")):
        nearby(scene, "mistuning", lambda: emit_mistuning(scene, options, tuned))
    if options.sensitivity and scene.wants(*paths_below("sensitivity")):
        nearby(scene, "sensitivity", lambda: emit_sensitivity(scene, options, z1, m, bounded))
    if options.bounds is not None:
        emit_comparison(scene, options, alone, free, bounded)
    if options.chart is not None and scene.wants(*paths_below("chart")):
        emit_chart(scene, options)
    if options.kind == "free" and options.norm == "h_infinity" and scene.wants(*paths_below("map")):
        emit_map(scene, options, tuned)
    _cite(scene, options)


def paths_below(table: str) -> tuple[str, ...]:
    """Results of one table of a tuning."""
    return below(f"{TUNING_ROOT}/{table}/")


def nearby(scene: Scene, name: str, study: Callable[[], None]) -> None:
    """Run what stands next to a tuning; where it fails, warn and leave it out.

    A sweep or search that asks for its results by name fails: nothing stands in their place.
    """
    try:
        study()
    except NumericalFailure as failure:
        if any(path.startswith(f"{TUNING_ROOT}/{name}/") for path in scene.wanted or ()):
            raise
        scene.warn(f"{_LEFT_OUT[name]} left out: {failure}")


def _emit_best(scene: Scene, options: Tuning, best: BestTuning, tuned: Absorber) -> None:
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    pair = options.excitation, options.response
    scene.emit(f"{TUNING_ROOT}/primary_damping", z1)
    scene.emit(f"{TUNING_ROOT}/mass_ratio", m, 2.0 * EPSILON * m)
    scene.emit(f"{TUNING_ROOT}/stiffness_ratio", best.stiffness_ratio, best.stiffness_error)
    scene.emit(f"{TUNING_ROOT}/secondary_damping", best.secondary_damping, best.damping_error)
    k, z2 = best.stiffness_ratio, best.secondary_damping
    relative = best.damping_error / (z2 or 1.0) + best.stiffness_error / (k or 1.0)
    if options.kind == "free":
        on_secondary = float(own_damping_ratio(tuned)) if k > 0.0 else 0.0
        scene.emit(
            f"{TUNING_ROOT}/own_damping", on_secondary, on_secondary * (relative + 4.0 * EPSILON)
        )
    both = (("peak", tuned), ("peak_alone", Absorber(z1, m, 0.0, 0.0)))
    for name, absorber in both:
        if not scene.wants(f"{TUNING_ROOT}/{name}"):
            continue
        top = peaks(absorber, *pair)
        error = float(top.largest_error)
        value = float(top.largest)
        uncertainty = best.peak_error if name == "peak" else 0.0
        scene.emit(
            f"{TUNING_ROOT}/{name}", value, error + uncertainty if np.isfinite(value) else 0.0
        )
    if scene.wants(f"{TUNING_ROOT}/travel"):
        travel = peaks(tuned, pair[0], "relative_displacement")
        reach = float(travel.largest)
        off = moved(
            lambda one: peaks(one, pair[0], "relative_displacement").largest,
            tuned,
            _uncertainty(best),
        )
        uncertainty = float(travel.largest_error) + float(off)
        scene.emit(f"{TUNING_ROOT}/travel", reach, uncertainty if np.isfinite(reach) else 0.0)
    if is_over_one(options):
        # near a threshold the peak is 1 and a little, of which the peak itself tells few digits
        above, slack = best.above_floor, best.above_floor_error
        if np.isnan(above):
            above, slack = best.value - 1.0, best.value_error + EPSILON
        scene.emit(f"{TUNING_ROOT}/peak_less_one", above, slack)
    scene.emit(f"{TUNING_ROOT}/helps", int(best.helps))
    if options.kind == "free":
        scene.emit(f"{TUNING_ROOT}/without_spring", int(k == 0.0 and best.helps))
    if options.norm == "h2":
        scene.emit(f"{TUNING_ROOT}/mean_square", best.value, best.value_error)
        scene.emit(f"{TUNING_ROOT}/mean_square_alone", best.alone, 8.0 * EPSILON)
    else:
        scene.emit(f"{TUNING_ROOT}/threshold", threshold(*pair).primary_damping, EPSILON)
        scene.emit(f"{TUNING_ROOT}/evaluations", best.evaluations)
    for words in best.remarks:
        scene.warn(words)


def emit_units(scene: Scene, options: Tuning, parts: AbsorberParts, best: BestTuning) -> None:
    """Spring, damper and own frequency of a tuning for a primary with units."""
    scale = parts.scale
    if scale is None:
        return
    kind = "torsional" if scale.torsion else "linear"
    size = scale.damping * best.secondary_damping
    error = scale.damping * best.damping_error + 8.0 * EPSILON * size
    scene.emit(f"{TUNING_ROOT}/{kind}_damping", size, error)
    if options.kind not in ("free", "undamped_spring"):
        return
    stiff = scale.stiffness * best.stiffness_ratio
    error = scale.stiffness * best.stiffness_error + 8.0 * EPSILON * stiff
    scene.emit(f"{TUNING_ROOT}/{kind}_stiffness", stiff, error)
    m = float(np.asarray(parts.absorber.mass_ratio)) if parts.absorber is not None else 1.0
    frequency = scale.frequency * np.sqrt(best.stiffness_ratio / m)
    error = best.stiffness_error / (best.stiffness_ratio or 1.0) + 8.0 * EPSILON
    scene.emit(f"{TUNING_ROOT}/secondary_frequency", frequency, frequency * error)


def _uncertainty(best: BestTuning) -> TuningError:
    return tuning_error(best.stiffness_error, best.damping_error)


def _emit_proof(scene: Scene, options: Tuning, tuned: Absorber, uncertainty: TuningError) -> None:
    """The peaks that hold the optimum, and that no change of spring and damper lowers them all."""
    pair = options.excitation, options.response
    proof = certify(tuned, *pair)
    if options.kind == "free":
        # zero at the exact optimum, so that all of it is error
        residual = float(proof.residual)
        scene.emit(f"{TUNING_ROOT}/certificate", residual, residual + _PLACE, terms=1.0)
        verdict = VERDICTS[int(proof.verdict)]
        if verdict == "not_optimal":
            raise NumericalFailure(
                f"the tuning found is not optimal: slopes of its peaks leave {proof.residual:.2g}"
            )
    if not scene.wants(*paths_below("active")):
        return
    tops = peaks(tuned, *pair)
    top = tops.present & (tops.magnitude >= tops.largest * (1.0 - _EQUAL))
    axes = {"active": np.arange(1, int(np.sum(top)) + 1)}
    error = np.max(tops.error[top], initial=0.0)
    scene.emit(f"{TUNING_ROOT}/active/magnitude", tops.magnitude[top], error, axes)
    places = tops.frequency[top]
    off = moved(lambda one: peaks(one, *pair).frequency, tuned, uncertainty)[top]
    scene.emit(f"{TUNING_ROOT}/active/frequency_ratio", places, off + _PLACE * places, axes)
    off = moved(lambda one: certify(one, *pair, equal=_NEARLY).weight, tuned, uncertainty)[top]
    scene.emit(f"{TUNING_ROOT}/active/weight", proof.weight[top], off + _PLACE, axes)


def _cite(scene: Scene, options: Tuning) -> None:
    if options.norm == "h2":
        scene.cite(
            "closed form of the mean square, Newton's method",
            "tuning",
            "Crandall and Mark (1963); Asami, Nishihara and Baz (2002); docs/theory_absorber.md",
        )
        return
    scene.cite(
        "Newton's method on two equal peaks whose slopes oppose each other",
        "tuning, certified by all peaks of the optimum",
        "docs/theory_absorber.md; Nishihara and Asami (2002) for an undamped primary",
    )
