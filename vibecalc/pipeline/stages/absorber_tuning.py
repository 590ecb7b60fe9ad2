"""Adapter: the spring and the damper that make the response of the primary smallest."""

from collections.abc import Callable

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.errors import NumericalFailure
from vibecalc.machine.absorber import AbsorberParts, build_absorber
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.absorber.certificate import VERDICTS, certify
from vibecalc.optimisation.absorber.threshold import threshold
from vibecalc.pipeline.entries.tuning import ROOT
from vibecalc.pipeline.plan_absorber import is_over_one
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_plan import below
from vibecalc.pipeline.stages.absorber_bounds import (
    as_best,
    emit_bounded_proof,
    emit_comparison,
    within_bounds,
)
from vibecalc.pipeline.stages.absorber_chart import emit_chart, emit_map
from vibecalc.pipeline.stages.absorber_doubt import Doubt, doubt_of, moved
from vibecalc.pipeline.stages.absorber_optimum import Best, best_tuning
from vibecalc.pipeline.stages.absorber_studies import (
    emit_methods,
    emit_mistuning,
    emit_sensitivity,
)
from vibecalc.response.absorber.model import Absorber, own_damping_ratio
from vibecalc.response.absorber.peaks import peaks

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
}


def run(scene: Scene) -> None:
    """Emit the optimum and what the case asks for beside it; hand on the tuned absorber."""
    case = scene.case
    options, parts = case.tuning, build_absorber(case)
    if options is None:
        raise ValueError("the case has no [tuning]")
    if parts.branches:
        from vibecalc.pipeline.stages.absorber_several import run_tuning

        run_tuning(scene, options, parts)
        return
    if parts.absorber is None:
        raise ValueError("the case has no absorber to tune")
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    free = best = best_tuning(options, z1, m)
    found = None if options.bounds is None else within_bounds(options, z1, m, free)
    if found is not None:
        best = as_best(options, found, z1, m)
    tuned = Absorber(z1, m, best.stiffness_ratio, best.secondary_damping)
    scene.handed_on["tuned"], scene.handed_on["tuned_doubt"] = tuned, _doubt(best)
    _emit_best(scene, options, best, tuned)
    _emit_units(scene, options, parts, best)
    if found is not None:
        emit_bounded_proof(scene, options, found)
    elif options.norm == "h_infinity":
        _emit_proof(scene, options, tuned, _doubt(best))
    alone = Absorber(z1, m, free.stiffness_ratio, free.secondary_damping)
    if options.compare and scene.wants(*_of("method")):
        emit_methods(scene, options, alone, free)
    if options.mistuning and scene.wants(*_of("mistuning")):
        _beside(scene, "mistuning", lambda: emit_mistuning(scene, options, tuned))
    if options.sensitivity and scene.wants(*_of("sensitivity")):
        _beside(scene, "sensitivity", lambda: emit_sensitivity(scene, options, z1, m, found))
    if options.bounds is not None:
        emit_comparison(scene, options, alone, free, found)
    if options.chart is not None and scene.wants(*_of("chart")):
        emit_chart(scene, options)
    if options.kind == "free" and options.norm == "h_infinity" and scene.wants(*_of("map")):
        emit_map(scene, options, tuned)
    _cite(scene, options)


def _of(table: str) -> tuple[str, ...]:
    return below(f"{ROOT}/{table}/")


def _beside(scene: Scene, name: str, study: Callable[[], None]) -> None:
    """Run what stands beside a tuning; where it fails, warn and leave it out.

    A sweep or search that asks for its results by name fails: nothing stands in their place.
    """
    try:
        study()
    except NumericalFailure as failure:
        if any(path.startswith(f"{ROOT}/{name}/") for path in scene.wanted or ()):
            raise
        scene.warn(f"{_LEFT_OUT[name]} left out: {failure}")


def _emit_best(scene: Scene, options: Tuning, best: Best, tuned: Absorber) -> None:
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    pair = options.excitation, options.response
    scene.emit(f"{ROOT}/primary_damping", z1)
    scene.emit(f"{ROOT}/mass_ratio", m, 2.0 * EPSILON * m)
    scene.emit(f"{ROOT}/stiffness_ratio", best.stiffness_ratio, best.stiffness_error)
    scene.emit(f"{ROOT}/secondary_damping", best.secondary_damping, best.damping_error)
    k, z2 = best.stiffness_ratio, best.secondary_damping
    relative = best.damping_error / (z2 or 1.0) + best.stiffness_error / (k or 1.0)
    if options.kind == "free":
        own = float(own_damping_ratio(tuned)) if k > 0.0 else 0.0
        scene.emit(f"{ROOT}/own_damping", own, own * (relative + 4.0 * EPSILON))
    both = (("peak", tuned), ("peak_alone", Absorber(z1, m, 0.0, 0.0)))
    for name, absorber in both:
        if not scene.wants(f"{ROOT}/{name}"):
            continue
        found = peaks(absorber, *pair)
        error = float(found.largest_error)
        value = float(found.largest)
        doubt = best.peak_error if name == "peak" else 0.0
        scene.emit(f"{ROOT}/{name}", value, error + doubt if np.isfinite(value) else 0.0)
    if scene.wants(f"{ROOT}/travel"):
        travel = peaks(tuned, pair[0], "relative_displacement")
        reach = float(travel.largest)
        off = moved(
            lambda one: peaks(one, pair[0], "relative_displacement").largest, tuned, _doubt(best)
        )
        doubt = float(travel.largest_error) + float(off)
        scene.emit(f"{ROOT}/travel", reach, doubt if np.isfinite(reach) else 0.0)
    if is_over_one(options):
        # near a threshold the peak is 1 and a little, of which the peak itself tells few digits
        above, slack = best.above_floor, best.above_floor_error
        if np.isnan(above):
            above, slack = best.value - 1.0, best.value_error + EPSILON
        scene.emit(f"{ROOT}/peak_less_one", above, slack)
    scene.emit(f"{ROOT}/helps", int(best.helps))
    if options.kind == "free":
        scene.emit(f"{ROOT}/without_spring", int(k == 0.0 and best.helps))
    if options.norm == "h2":
        scene.emit(f"{ROOT}/mean_square", best.value, best.value_error)
        scene.emit(f"{ROOT}/mean_square_alone", best.alone, 8.0 * EPSILON)
    else:
        scene.emit(f"{ROOT}/threshold", threshold(*pair).primary_damping, EPSILON)
        scene.emit(f"{ROOT}/evaluations", best.evaluations)
    for words in best.remarks:
        scene.warn(words)


def _emit_units(scene: Scene, options: Tuning, parts: AbsorberParts, best: Best) -> None:
    scale = parts.scale
    if scale is None:
        return
    kind = "torsional" if scale.torsion else "linear"
    size = scale.damping * best.secondary_damping
    error = scale.damping * best.damping_error + 8.0 * EPSILON * size
    scene.emit(f"{ROOT}/{kind}_damping", size, error)
    if options.kind not in ("free", "undamped_spring"):
        return
    stiff = scale.stiffness * best.stiffness_ratio
    error = scale.stiffness * best.stiffness_error + 8.0 * EPSILON * stiff
    scene.emit(f"{ROOT}/{kind}_stiffness", stiff, error)
    m = float(np.asarray(parts.absorber.mass_ratio)) if parts.absorber is not None else 1.0
    own = scale.frequency * np.sqrt(best.stiffness_ratio / m)
    error = best.stiffness_error / (best.stiffness_ratio or 1.0) + 8.0 * EPSILON
    scene.emit(f"{ROOT}/secondary_frequency", own, own * error)


def _doubt(best: Best) -> Doubt:
    return doubt_of(best.stiffness_error, best.damping_error)


def _emit_proof(scene: Scene, options: Tuning, tuned: Absorber, doubt: Doubt) -> None:
    """The peaks that hold the optimum, and that no change of spring and damper lowers them all."""
    pair = options.excitation, options.response
    proof = certify(tuned, *pair)
    if options.kind == "free":
        # zero at the exact optimum, so that all of it is error
        residual = float(proof.residual)
        scene.emit(f"{ROOT}/certificate", residual, residual + _PLACE, terms=1.0)
        verdict = VERDICTS[int(proof.verdict)]
        if verdict == "not_optimal":
            raise NumericalFailure(
                f"the tuning found is not optimal: slopes of its peaks leave {proof.residual:.2g}"
            )
    if not scene.wants(*_of("active")):
        return
    found = peaks(tuned, *pair)
    top = found.found & (found.magnitude >= found.largest * (1.0 - _EQUAL))
    axes = {"active": np.arange(1, int(np.sum(top)) + 1)}
    error = np.max(found.error[top], initial=0.0)
    scene.emit(f"{ROOT}/active/magnitude", found.magnitude[top], error, axes)
    places = found.frequency[top]
    off = moved(lambda one: peaks(one, *pair).frequency, tuned, doubt)[top]
    scene.emit(f"{ROOT}/active/frequency_ratio", places, off + _PLACE * places, axes)
    off = moved(lambda one: certify(one, *pair, equal=_NEARLY).weight, tuned, doubt)[top]
    scene.emit(f"{ROOT}/active/weight", proof.weight[top], off + _PLACE, axes)


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
