"""Adapter, continued: the tuning that keeps the bounds of a case, which is then the answer."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.absorber.bounded import (
    HELD_BY,
    BoundedTuning,
    bounded_tuning,
    keeps,
)
from vibecalc.pipeline.entries.tuning import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber_optimum import Best
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: a peak this close to the one without an absorber is no lower
_NO_LOWER = 1e-9
_TRAVEL = "relative_displacement"


class Limits(NamedTuple):
    """Lower and upper bounds of stiffness and damping ratio, largest travel; infinite for none."""

    stiffness: tuple[float, float]
    damping: tuple[float, float]
    travel: float


def limits_of(options: Tuning) -> Limits:
    """The bounds of a case; a spring or a damper that its kind leaves out is bounded to zero."""
    none, bounds = (0.0, np.inf), options.bounds
    if bounds is None:
        return Limits(none, none, np.inf)
    stiffness, damping = bounds.stiffness_ratio or none, bounds.damping_ratio or none
    if options.kind == "viscous":
        stiffness = (0.0, 0.0)
    if options.kind == "undamped_spring":
        damping = (0.0, 0.0)
    return Limits(stiffness, damping, np.inf if bounds.travel is None else bounds.travel)


def within_bounds(options: Tuning, z1: float, m: float, best: Best) -> BoundedTuning | None:
    """The best tuning within the bounds of the case; None where the best one of all keeps them.

    Raises NumericalFailure where nothing keeps them.
    """
    limits = limits_of(options)
    one = Absorber(z1, m, best.stiffness_ratio, best.secondary_damping)
    travel = float(peaks(one, options.excitation, _TRAVEL).largest)
    there = (best.stiffness_ratio, best.secondary_damping)
    if keeps(there, limits.stiffness, limits.damping) and travel <= limits.travel:
        return None
    return bounded_tuning(
        z1, m, options.excitation, options.response,
        stiffness=limits.stiffness, damping=limits.damping, travel=limits.travel,
    )  # fmt: skip


def as_best(options: Tuning, found: BoundedTuning, z1: float, m: float) -> Best:
    """The tuning within bounds as the answer to the case."""
    tuning = found.tuning
    alone = peaks(Absorber(z1, m, 0.0, 0.0), options.excitation, options.response)
    helps = bool(tuning.peak < float(alone.largest) * (1.0 - _NO_LOWER))
    remarks: tuple[str, ...] = ()
    if not helps:
        remarks = (
            f"no absorber within the bounds does better than none: with the best of them the "
            f"largest response is {tuning.peak:.6g}, without an absorber "
            f"{float(alone.largest):.6g}",
        )
    stiff_error, damp_error = (float(error) for error in tuning.ratio_error[:2])
    return Best(
        float(tuning.stiffness_ratio[0]), float(tuning.secondary_damping[0]),
        stiff_error, damp_error, tuning.peak, tuning.peak_error, np.nan, tuning.peak_error,
        helps, tuning.evaluations, remarks, False,
    )  # fmt: skip


def emit_comparison(
    scene: Scene, options: Tuning, free: Absorber, best: Best, found: BoundedTuning | None
) -> None:
    """Which bounds hold the tuning, and beside it the one that there would be without them."""
    pair = options.excitation, options.response
    top, travel = peaks(free, *pair), peaks(free, pair[0], _TRAVEL)
    k, z2 = float(np.asarray(free.stiffness_ratio)), float(np.asarray(free.secondary_damping))
    scene.emit(f"{ROOT}/unbounded/stiffness_ratio", k, best.stiffness_error)
    scene.emit(f"{ROOT}/unbounded/secondary_damping", z2, best.damping_error)
    for name, one in (("peak", top), ("travel", travel)):
        value = float(one.largest)
        error = float(one.largest_error) + best.peak_error * (name == "peak")
        scene.emit(f"{ROOT}/unbounded/{name}", value, error if np.isfinite(value) else 0.0)
    active = np.array([int(found is not None and name in found.active) for name in HELD_BY])
    scene.emit(f"{ROOT}/bounds/active", active, 0.0, {"tuning_bound": HELD_BY})
    least, cost = float(top.largest), 0.0
    error = 0.0
    if found is not None:
        cost = found.tuning.peak / least - 1.0
        error = (2.0 * found.tuning.peak_error + float(top.largest_error)) / least + 4.0 * EPSILON
    scene.emit(f"{ROOT}/bounds/penalty", cost, error if np.isfinite(cost) else 0.0)
    scene.cite(
        "sequential quadratic programming on the levels of all peaks, then Newton's method",
        "tuning within bounds",
        "docs/theory_absorber.md",
    )


def emit_bounded_proof(scene: Scene, options: Tuning, found: BoundedTuning) -> None:
    """The peaks that hold a tuning within bounds, their weights, and what is left of slopes."""
    tuning = found.tuning
    axes = {"active": np.arange(1, len(tuning.frequency) + 1)}
    relative = float(np.max(tuning.ratio_error / np.maximum(_sizes(found), EPSILON)))
    height = np.full(len(tuning.frequency), tuning.peak)
    scene.emit(f"{ROOT}/active/magnitude", height, tuning.peak_error, axes)
    off = 16.0 * (EPSILON + relative)
    scene.emit(f"{ROOT}/active/frequency_ratio", tuning.frequency, off * tuning.frequency, axes)
    scene.emit(f"{ROOT}/active/weight", tuning.weight, 16.0 * EPSILON + tuning.residual, axes)
    if options.kind == "free":
        # zero at the exact optimum, so that all of it is error
        scene.emit(f"{ROOT}/certificate", tuning.residual, tuning.residual + 16.0 * EPSILON)


def _sizes(found: BoundedTuning) -> np.ndarray:
    both = np.append(found.tuning.stiffness_ratio, found.tuning.secondary_damping)
    return np.where(both > 0.0, both, 1.0)
