"""Adapter: the tuning of one absorber by norm and kind, within bounds, over a design chart."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.asked_tables import MassRatios, Tuning
from vibecalc.absorber.mean_square import mean_square
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import TUNING_ROOT
from vibecalc.absorber.transfer import Absorber, own_damping_ratio, transfer_of
from vibecalc.absorber.tuning import mean_square as least_squares
from vibecalc.absorber.tuning.closed_forms import METHODS, lanchester, threshold
from vibecalc.absorber.tuning.mean_square import mean_square_tuning
from vibecalc.absorber.tuning.minimax import BALANCED, NO_HELP, SET, UNBOUNDED, minimax
from vibecalc.absorber.tuning.restricted import pure_viscous, undamped_spring
from vibecalc.absorber.tuning.several import HELD_BY, BoundedTuning, bounded_tuning, keeps
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# One tuning by the norm and kind that a case asks for.
# ----------------------------------------------------------------------------


class BestTuning(NamedTuple):
    """Stiffness and damping found, what they make small (`value`; `alone` without an absorber).

    `is_held`: one tuning, held by its peaks, and no set of them. `remarks`: words for the report.
    `above_floor`: the peak less what no absorber changes at rest or at high frequency, to its own
    digits; NaN where it is not known so.
    """

    stiffness_ratio: float
    secondary_damping: float
    stiffness_error: float
    damping_error: float
    value: float
    value_error: float
    alone: float
    peak_error: float
    helps: bool
    evaluations: int
    remarks: tuple[str, ...] = ()
    is_held: bool = True
    above_floor: float = np.nan
    above_floor_error: float = 0.0


def best_tuning(options: Tuning, z1: float, m: float) -> BestTuning:
    """The optimum for one primary damping and mass ratio.

    Raises NumericalFailure where there is none: a response that grows without bound, or has no
    mean square, or is never finite.
    """
    pair = options.excitation, options.response
    if options.norm == "h2":
        return _least_squares(options, z1, m)
    if options.kind == "free":
        return _free(z1, m, pair)
    if options.kind == "lanchester":
        _, z2, _ = lanchester(np.asarray(m))
        damping = float(z2)
        return BestTuning(
            0.0, damping, 0.0, 8.0 * EPSILON * damping, np.nan, 0.0, np.nan, 0.0, True, 1,
        )  # fmt: skip
    if is_endless(pair, z1):
        raise NumericalFailure(_endless(pair, threshold(*pair).why))
    viscous = options.kind == "viscous"
    restricted = pure_viscous(z1, m, *pair) if viscous else undamped_spring(z1, m, *pair)
    value, error = float(restricted.value), float(restricted.value_error)
    if not np.isfinite(value):
        raise NumericalFailure(
            "the best such absorber is locked to the primary: a mass fastened rigidly does more"
        )
    place = (0.0, value, 0.0, error) if viscous else (value, 0.0, error, 0.0)
    return BestTuning(
        *place, float(restricted.largest), float(restricted.largest_error), np.nan,
        float(restricted.largest_error), bool(restricted.held_by),
        int(np.max(restricted.evaluations)),
    )  # fmt: skip


def is_endless(pair: tuple[str, str], z1: float) -> bool:
    """Whether the response grows with frequency without bound, whatever the absorber."""
    transfer = transfer_of(*pair)
    # the motion of the primary falls with the square of the frequency
    return transfer.power + transfer.ground * (z1 > 0.0) > 2


def level_of(options: Tuning, absorber: Absorber) -> Bounded:
    """What is made small: the largest amplitude, or the mean square."""
    pair = options.excitation, options.response
    if options.norm == "h2":
        return mean_square(absorber, *pair)
    found = peaks(absorber, *pair)
    return Bounded(found.largest, found.largest_error)


def _free(z1: float, m: float, pair: tuple[str, str]) -> BestTuning:
    tuning = minimax(z1, m, *pair)
    outcome, limit = int(tuning.outcome), threshold(*pair)
    if outcome == UNBOUNDED:
        raise NumericalFailure(_endless(pair, limit.why))
    remarks: tuple[str, ...] = ()
    if outcome == NO_HELP:
        remarks = (
            f"no absorber helps: the primary's damping {z1:.6g} is not below the threshold "
            f"{limit.exact} ({limit.primary_damping:.6g}); {limit.why}",
        )
    elif outcome == SET:
        remarks = (f"many tunings are as good: {limit.why}; the one given is one of them",)
    return BestTuning(
        float(tuning.stiffness_ratio), float(tuning.secondary_damping),
        float(tuning.stiffness_error), float(tuning.damping_error), float(tuning.largest),
        float(tuning.largest_error), np.nan, float(tuning.largest_error), outcome != NO_HELP,
        int(tuning.evaluations), remarks, outcome == BALANCED,
        float(tuning.above_floor),
        float(tuning.excess_error / (tuning.largest + tuning.floor)) + 4.0 * EPSILON * float(
            tuning.above_floor
        ),
    )  # fmt: skip


def _least_squares(options: Tuning, z1: float, m: float) -> BestTuning:
    if options.kind != "free":
        raise NumericalFailure(
            f"a mean square is tuned with both spring and damper, not of kind {options.kind!r}"
        )
    found = mean_square_tuning(z1, m, options.excitation, options.response)
    if bool(found.locked):
        raise NumericalFailure(
            "a mass fastened rigidly to the primary has a lower mean square than any absorber"
        )
    helps = not bool(found.no_help)
    remarks = () if helps else ("no absorber of this mass lowers the mean square",)
    return BestTuning(
        float(found.stiffness_ratio), float(found.secondary_damping),
        float(found.stiffness_error), float(found.damping_error), float(found.value),
        float(found.value_error), float(found.alone), 0.0, helps, found.steps, remarks,
    )  # fmt: skip


def _endless(pair: tuple[str, str], why: str) -> str:
    return f"no tuning makes the {pair[1]} under excitation by {pair[0]} small: {why}"


# ----------------------------------------------------------------------------
# Adapter, continued: the tuning that keeps the bounds of a case, which is then the answer.
# ----------------------------------------------------------------------------

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


def within_bounds(options: Tuning, z1: float, m: float, best: BestTuning) -> BoundedTuning | None:
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


def as_best(options: Tuning, bounded: BoundedTuning, z1: float, m: float) -> BestTuning:
    """The tuning within bounds as the answer to the case."""
    tuning = bounded.tuning
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
    return BestTuning(
        float(tuning.stiffness_ratio[0]), float(tuning.secondary_damping[0]),
        stiff_error, damp_error, tuning.peak, tuning.peak_error, np.nan, tuning.peak_error,
        helps, tuning.evaluations, remarks, False,
    )  # fmt: skip


def emit_comparison(
    scene: Scene, options: Tuning, free: Absorber, best: BestTuning, bounded: BoundedTuning | None
) -> None:
    """Which bounds hold the tuning, and next to it the one that there would be without them."""
    pair = options.excitation, options.response
    top, travel = peaks(free, *pair), peaks(free, pair[0], _TRAVEL)
    k, z2 = float(np.asarray(free.stiffness_ratio)), float(np.asarray(free.secondary_damping))
    scene.emit(f"{TUNING_ROOT}/unbounded/stiffness_ratio", k, best.stiffness_error)
    scene.emit(f"{TUNING_ROOT}/unbounded/secondary_damping", z2, best.damping_error)
    for name, one in (("peak", top), ("travel", travel)):
        value = float(one.largest)
        error = float(one.largest_error) + best.peak_error * (name == "peak")
        scene.emit(f"{TUNING_ROOT}/unbounded/{name}", value, error if np.isfinite(value) else 0.0)
    active = np.array([int(bounded is not None and name in bounded.active) for name in HELD_BY])
    scene.emit(f"{TUNING_ROOT}/bounds/active", active, 0.0, {"tuning_bound": HELD_BY})
    least, cost = float(top.largest), 0.0
    error = 0.0
    if bounded is not None:
        cost = bounded.tuning.peak / least - 1.0
        error = (2.0 * bounded.tuning.peak_error + float(top.largest_error)) / least + 4.0 * EPSILON
    scene.emit(f"{TUNING_ROOT}/bounds/penalty", cost, error if np.isfinite(cost) else 0.0)
    scene.cite(
        "sequential quadratic programming on the levels of all peaks, then Newton's method",
        "tuning within bounds",
        "docs/theory_absorber.md",
    )


def emit_bounded_proof(scene: Scene, options: Tuning, bounded: BoundedTuning) -> None:
    """The peaks that hold a tuning within bounds, their weights, and what is left of slopes."""
    tuning = bounded.tuning
    axes = {"active": np.arange(1, len(tuning.frequency) + 1)}
    relative = float(np.max(tuning.ratio_error / np.maximum(_sizes(bounded), EPSILON)))
    height = np.full(len(tuning.frequency), tuning.peak)
    scene.emit(f"{TUNING_ROOT}/active/magnitude", height, tuning.peak_error, axes)
    off = 16.0 * (EPSILON + relative)
    scene.emit(
        f"{TUNING_ROOT}/active/frequency_ratio", tuning.frequency, off * tuning.frequency, axes
    )
    scene.emit(
        f"{TUNING_ROOT}/active/weight", tuning.weight, 16.0 * EPSILON + tuning.residual, axes
    )
    if options.kind == "free":
        # zero at the exact optimum, so that all of it is error
        scene.emit(f"{TUNING_ROOT}/certificate", tuning.residual, tuning.residual + 16.0 * EPSILON)


def _sizes(bounded: BoundedTuning) -> np.ndarray:
    both = np.append(bounded.tuning.stiffness_ratio, bounded.tuning.secondary_damping)
    return np.where(both > 0.0, both, 1.0)


# ----------------------------------------------------------------------------
# Adapter, continued: tunings over a chart, and the largest response around one tuning.
# ----------------------------------------------------------------------------

#: points of the map, and how far it reaches: shares of the optimum
_MAP = 41
_ALONG_K, _ALONG_Z = (0.5, 1.7), (0.2, 2.6)


def mass_ratios(asked: MassRatios) -> np.ndarray:
    """Mass ratios of a chart."""
    if asked.spacing == "logarithmic":
        return np.geomspace(asked.start, asked.stop, asked.points)
    return np.linspace(asked.start, asked.stop, asked.points)


def emit_chart(scene: Scene, options: Tuning) -> None:
    """Tunings over mass ratio and primary damping, all solved together."""
    asked = options.chart
    if asked is None:
        return
    damping, ratio = np.array(asked.primary_damping), mass_ratios(asked.mass_ratio)
    z1, m = damping[:, None], ratio[None, :]
    pair = options.excitation, options.response
    k, z2, errors = _tunings(options, z1, m)
    there = Absorber(z1, m, k, z2)
    top = peaks(there, *pair)
    on_secondary = np.where(k > 0.0, own_damping_ratio(there), 0.0)
    axes = {"primary_damping": damping, "mass_ratio": ratio}
    scene.emit(f"{TUNING_ROOT}/chart/stiffness_ratio", k, errors[0], axes)
    scene.emit(f"{TUNING_ROOT}/chart/secondary_damping", z2, errors[1], axes)
    safe = [np.where(part > 0.0, part, 1.0) for part in (k, z2)]
    relative = errors[0] / safe[0] + errors[1] / safe[1] + 8.0 * EPSILON
    scene.emit(f"{TUNING_ROOT}/chart/own_damping", on_secondary, on_secondary * relative, axes)
    uncertainty = np.where(np.isfinite(top.largest), top.largest_error, 0.0)
    scene.emit(f"{TUNING_ROOT}/chart/peak", top.largest, uncertainty + errors[2], axes)


def _tunings(
    options: Tuning, z1: np.ndarray, m: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """k, z2 and their errors with that of the peak, by the norm and kind of the case."""
    pair = options.excitation, options.response
    zero = np.zeros(np.broadcast_shapes(z1.shape, m.shape))
    if options.norm == "h2":
        least = least_squares.mean_square_tuning(z1, m, *pair)
        if np.any(least.locked):
            raise NumericalFailure("somewhere on the chart a locked mass is best: no tuning there")
        return least.stiffness_ratio, least.secondary_damping, (
            least.stiffness_error, least.damping_error, zero,
        )  # fmt: skip
    if options.kind == "viscous":
        restricted = pure_viscous(z1, m, *pair)
        return zero, restricted.value, (zero, restricted.value_error, restricted.largest_error)
    if options.kind == "undamped_spring":
        restricted = undamped_spring(z1, m, *pair)
        return restricted.value, zero, (restricted.value_error, zero, restricted.largest_error)
    if options.kind == "lanchester":
        z2 = zero + METHODS["lanchester"].formula(m)[1]
        return zero, z2, (zero, 8.0 * EPSILON * z2, zero)
    best = minimax(z1, m, *pair)
    if np.any(best.outcome == UNBOUNDED):
        raise NumericalFailure("somewhere on the chart the response grows without bound")
    return best.stiffness_ratio, best.secondary_damping, (
        best.stiffness_error, best.damping_error, best.largest_error,
    )  # fmt: skip


def emit_map(scene: Scene, options: Tuning, tuned: Absorber) -> None:
    """Largest response over stiffness and damping around the optimum."""
    z1, m, k, z2 = (float(np.asarray(part)) for part in tuned)
    if k == 0.0 or z2 == 0.0:  # no help: a range as wide as a tuning of such a mass would be
        k, z2 = m / (1.0 + m) ** 2, 0.5 * m**1.5 / (1.0 + m) ** 1.5
    stiffness = np.union1d(np.linspace(_ALONG_K[0] * k, _ALONG_K[1] * k, _MAP), [k])
    damping = np.union1d(np.geomspace(_ALONG_Z[0] * z2, _ALONG_Z[1] * z2, _MAP), [z2])
    found = peaks(
        Absorber(z1, m, stiffness[:, None], damping[None, :]), options.excitation, options.response
    )
    axes = {"stiffness_ratio": stiffness, "secondary_damping": damping}
    scene.emit(f"{TUNING_ROOT}/map/peak", found.largest, found.largest_error, axes)
