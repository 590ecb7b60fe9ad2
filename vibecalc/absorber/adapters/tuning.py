"""Adapter: the optimum of one absorber with its proof, other methods, mistuning, sensitivity."""

from collections.abc import Callable
from typing import Any

import numpy as np

from vibecalc.absorber.adapters.optimum import (
    BestTuning,
    as_best,
    best_tuning,
    emit_active,
    emit_chart,
    emit_comparison,
    emit_map,
    emit_methods,
    emit_mistuning,
    is_endless,
    level_of,
    tunings,
    within_bounds,
)
from vibecalc.absorber.adapters.response import TRAVEL, TuningError, moved, tuning_error
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.stage import is_over_one, white_ground
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.band import BandTuning
from vibecalc.absorber.tuning.closed_forms import threshold
from vibecalc.absorber.tuning.minimax_steps import VERDICTS, certify
from vibecalc.core.run.stage import Scene, below
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# Adapter, continued: slopes of a tuning by differences of it, all points of them at once.
# ----------------------------------------------------------------------------

#: step over the ratio, and of the primary's damping over the distance to a threshold
_STEP, _NEARER = 2e-3, 0.05
#: a distance to the threshold that leaves too little of the peaks above an end of the range
_TOO_NEAR = 1e-4


def emit_sensitivity(
    scene: Scene, options: Tuning, z1: float, m: float, bounded: object = None
) -> None:
    """Slopes of the optimum by the given ratios, of eighth order; on one side of no damping."""
    pair = options.excitation, options.response
    if bounded is not None:
        raise NumericalFailure("bounds hold the tuning, and slopes are those of a free one")
    if is_endless(pair, max(z1, EPSILON)):
        raise NumericalFailure(
            f"no slopes of this tuning: with damping of the primary the {pair[1]} under excitation "
            f"by {pair[0]} has no bound at high frequency"
        )
    away = np.inf
    if options.norm == "h_infinity":
        away = abs(threshold(*pair).primary_damping - z1)
    if away < _TOO_NEAR:
        raise NumericalFailure(
            "sensitivity: its peaks stand too little above an end of the frequency range to tell"
        )
    steps = np.array([min(_STEP * max(z1, np.sqrt(m)), _NEARER * away), _STEP * m])
    offsets = np.stack([np.arange(9.0) - 4.0 * (z1 > 5.0 * steps[0]), np.arange(-4.0, 5.0)])
    point = np.array([z1, m])[:, None] + np.eye(2)[..., None] * (steps[:, None] * offsets)[:, None]
    found = tunings(options, point[:, 0], point[:, 1])
    if np.any(found.is_set):
        raise NumericalFailure("sensitivity: the optimum is one of a set and has no derivative")
    k, z2 = found.stiffness_ratio, found.secondary_damping
    top = peaks(Absorber(point[:, 0], point[:, 1], k, z2), *pair).largest
    for name, values in (
        ("stiffness_ratio", k),
        ("damping_over_primary_critical", z2),
        ("peak", top),
    ):
        both = [
            [_slope(row[:count], at[:count]) for count in (9, 7)] if at[0] == 0.0 else
            [_slope(row, at), _slope(row[1:-1], at[1:-1])]
            for row, at in zip(values, offsets, strict=True)
        ]  # fmt: skip
        slope, coarser = np.array(both).T / steps
        error = np.abs(slope - coarser) + 1e-14 * np.max(np.abs(values), axis=1) / steps
        scene.emit(f"{TUNING_ROOT}/sensitivity/{name}", slope, error, {"ratio": NAMES["ratio"]})


def _slope(values: FloatArray, offsets: FloatArray) -> float:
    """Slope at zero of the polynomial through values (n,) at offsets (n,)."""
    weights = np.linalg.solve(offsets ** np.arange(len(offsets))[:, None], np.eye(len(offsets))[1])
    return float(weights @ values)


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
    assert options is not None
    assert parts.absorber is not None
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    free = best = best_tuning(options, z1, m)
    bounded = None if options.bounds is None else within_bounds(options, z1, m, free)
    if bounded is not None:
        best = as_best(options, bounded, z1, m)
    tuned = Absorber(z1, m, best.stiffness_ratio, best.secondary_damping)
    scene.handed_on["tuned"], scene.handed_on["tuned_uncertainty"] = tuned, _uncertainty(best)
    _emit_best(scene, options, best, tuned)
    emit_tuned(scene, options, parts, best)
    if bounded is not None:
        emit_active(scene, bounded)
        if options.kind == "free":
            # zero at the exact optimum, so that all of it is error
            residual = bounded.residual
            scene.emit(f"{TUNING_ROOT}/certificate", residual, residual + _PLACE)
    elif options.norm == "h_infinity":
        _emit_proof(scene, options, tuned, _uncertainty(best))
    alone = Absorber(z1, m, free.stiffness_ratio, free.secondary_damping)
    if options.compare and scene.wants(*paths_below("method")):
        _emit_methods(scene, options, alone, free)
    if options.mistuning and scene.wants(*paths_below("mistuning")):

        def off(stiff: FloatArray, damped: FloatArray) -> Bounded:
            k, z2 = best.stiffness_ratio, best.secondary_damping
            there = Absorber(z1, m, k * (1.0 + stiff), z2 * (1.0 + damped))
            return level_of(options, there)

        nearby(scene, "mistuning", lambda: emit_mistuning(scene, options, off))
    if options.sensitivity and scene.wants(*paths_below("sensitivity")):
        nearby(scene, "sensitivity", lambda: emit_sensitivity(scene, options, z1, m, bounded))
    if options.bounds is not None:
        emit_comparison(scene, options, alone, free, bounded)
    if options.chart is not None and scene.wants(*paths_below("chart")):
        emit_chart(scene, options)
    if options.kind == "free" and options.norm == "h_infinity" and scene.wants(*paths_below("map")):
        emit_map(scene, options, tuned)
    _cite(scene, options)


def _emit_methods(scene: Scene, options: Tuning, tuned: Absorber, best: BestTuning) -> None:
    z1, m, pair = tuned.primary_damping, tuned.mass_ratio, (options.excitation, options.response)
    level = level_of(options, tuned)
    white = white_ground(scene.case)
    promise = np.inf if white else float(peaks(tuned, *pair).largest)

    def top(k: FloatArray, z2: FloatArray) -> Bounded:
        return peaks(Absorber(z1, m, k, z2), *pair).top

    best = best._replace(value=float(level.value), value_error=float(level.error))
    emit_methods(scene, options, float(np.asarray(m)), best, promise, None if white else top,
                 lambda k, z2: level_of(options, Absorber(z1, m, k, z2)))  # fmt: skip


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
    pair, least = (options.excitation, options.response), options.norm == "h2"
    z1, m, free = tuned.primary_damping, tuned.mass_ratio, options.kind == "free"

    def peak() -> Bounded:
        top = peaks(tuned, *pair)
        return Bounded(top.largest, top.largest_error + (0.0 if least else best.value_error))

    def travel() -> Bounded:
        def reach(one: Absorber) -> np.ndarray:
            return peaks(one, pair[0], TRAVEL).largest

        off = moved(reach, tuned, _uncertainty(best))
        top = peaks(tuned, pair[0], TRAVEL)
        return Bounded(top.largest, top.largest_error + off)

    # near a threshold the peak is 1 and a little, of which the peak itself tells few digits
    above = Bounded(best.above_floor, best.above_floor_error)
    if np.isnan(best.above_floor):
        above = Bounded(best.value - 1.0, best.value_error + EPSILON)
    found: dict[str, Any] = {"primary_damping": z1, "helps": int(best.helps)}
    if not white_ground(scene.case):
        found |= {"peak": peak, "travel": travel}
        found["peak_alone"] = lambda: peaks(Absorber(z1, m, 0.0, 0.0), *pair).top
    if is_over_one(options):
        found["peak_less_one"] = above
    if free:
        found["without_spring"] = int(best.stiffness_ratio == 0.0 and best.helps)
    if least:
        found["mean_square"] = Bounded(best.value, best.value_error)
        found["mean_square_alone"] = Bounded(best.alone, np.asarray(8.0 * EPSILON))
    else:
        limit = np.asarray(threshold(*pair).primary_damping)
        found["threshold"] = Bounded(limit, np.asarray(EPSILON))
        found["evaluations"] = best.evaluations
    scene.emit_all({f"{TUNING_ROOT}/{name}": value for name, value in found.items()})
    for words in best.remarks:
        scene.warn(words)


def emit_tuned(
    scene: Scene, options: Tuning, parts: AbsorberParts, best: BestTuning | BandTuning
) -> None:
    """Mass, spring and damper of one absorber, or of each of several (a,).

    In units where the primary has them.
    """
    k, z2 = np.asarray(best.stiffness_ratio), np.asarray(best.secondary_damping)
    off, drag = np.asarray(best.stiffness_error), np.asarray(best.damping_error)
    root, axes, own_frequency = TUNING_ROOT, {}, "secondary_frequency"
    m = np.asarray(0.0 if parts.absorber is None else parts.absorber.mass_ratio, dtype=float)
    if parts.branches:
        root, axes, own_frequency = f"{TUNING_ROOT}/each", named(parts), "frequency"
        m = np.array([branch.mass_ratio for branch in parts.branches])
    scene.emit(f"{root}/mass_ratio", m, 2.0 * EPSILON * np.max(m), axes)
    scene.emit(f"{root}/stiffness_ratio", k, off, axes)
    scene.emit(f"{root}/damping_over_primary_critical", z2, drag, axes)
    sprung = (k > 0.0) & np.isfinite(k)
    share = np.where(sprung, off, 0.0) / np.where(sprung, k, 1.0)
    if options.kind == "free":
        usual = np.sqrt(m * np.where(sprung, k, 1.0))
        own = np.where(sprung, z2 / usual, 0.0)
        error = drag / usual + own * (0.5 * share + 4.0 * EPSILON)
        scene.emit(f"{root}/absorber_damping_ratio", own, np.where(sprung, error, 0.0), axes)
    scale = parts.scale
    if scale is None:
        return
    kind = "torsional" if scale.torsion else "linear"
    natural = scale.frequency * np.sqrt(k / m)
    rows = [(f"{kind}_damping", scale.damping * z2, scale.damping * drag)]
    if options.kind in ("free", "undamped_spring"):
        rows.append((f"{kind}_stiffness", scale.stiffness * k, scale.stiffness * off))
        rows.append((own_frequency, natural, np.where(sprung, natural, 0.0) * share))
    for name, value, error in rows:
        error = np.where(np.isfinite(value), error + 8.0 * EPSILON * value, 0.0)
        scene.emit(f"{root}/{name}", value, error, axes)


def named(parts: AbsorberParts) -> dict[str, tuple[str, ...]]:
    """The axis of all absorbers."""
    return {"absorber": tuple(branch.name for branch in parts.branches)}


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
    if white_ground(scene.case):
        scene.cite(
            "closed form of the mean square, Newton's method",
            "tuning for a white acceleration of the ground",
            "Warburton, Earthq. Eng. Struct. Dyn. 10 (1982), undamped; docs/theory_absorber.md",
        )
        return
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
