"""Adapter: the tuning of one absorber by norm and kind, within bounds, over a design chart."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.absorber.asked_tables import MassRatios, Tuning
from vibecalc.absorber.mean_square import mean_square
from vibecalc.absorber.modal import one_mode
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import NAMES, TUNING_ROOT
from vibecalc.absorber.transfer import Absorber, own_damping_ratio, transfer_of
from vibecalc.absorber.tuning import mean_square as least_squares
from vibecalc.absorber.tuning.band import BandTuning, band_tuning
from vibecalc.absorber.tuning.closed_forms import METHODS, lanchester, threshold
from vibecalc.absorber.tuning.levels import BandProblem
from vibecalc.absorber.tuning.mean_square import mean_square_tuning
from vibecalc.absorber.tuning.minimax import NO_HELP, SET, minimax
from vibecalc.absorber.tuning.restricted import pure_viscous, undamped_spring
from vibecalc.absorber.tuning.warburton import WARBURTON
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray

# ----------------------------------------------------------------------------
# One tuning by the norm and kind that a case asks for.
# ----------------------------------------------------------------------------


class BestTuning(NamedTuple):
    """Stiffness and damping found (...), what they make small (`value`; `alone` without an
    absorber), with absolute errors.

    `is_set`: the optimum is not unique. `above_floor`: the peak less what no absorber changes at
    rest or at high frequency, to its own digits. NaN is what is not known. `remarks`: words for the
    report on a single one.
    """

    stiffness_ratio: Any
    secondary_damping: Any
    stiffness_error: Any
    damping_error: Any
    value: Any
    value_error: Any
    helps: Any = True
    evaluations: Any = 1
    alone: Any = np.nan
    is_set: Any = False
    above_floor: Any = np.nan
    above_floor_error: Any = 0.0
    remarks: tuple[str, ...] = ()


def tunings(options: Tuning, z1: FloatArray, m: FloatArray) -> BestTuning:
    """The optima by the norm and kind of the case, for arrays that broadcast.

    Raises NumericalFailure where there is none: a response that grows without bound, or has no
    mean square, or is never finite.
    """
    pair, zero = (options.excitation, options.response), np.zeros(np.broadcast(z1, m).shape)
    if options.norm == "h2":
        if options.kind != "free":
            raise NumericalFailure(
                f"a mean square is tuned with both spring and damper, not of kind {options.kind!r}"
            )
        least = mean_square_tuning(z1, m, *pair)
        if np.any(least.locked):
            raise NumericalFailure(
                "a mass fastened rigidly to the primary has a lower mean square than any absorber"
            )
        return BestTuning(
            least.stiffness_ratio, least.secondary_damping, least.stiffness_error,
            least.damping_error, least.value, least.value_error, ~least.no_help, least.steps,
            least.alone,
        )  # fmt: skip
    if options.kind == "lanchester":
        z2 = zero + lanchester(m)[1]
        return BestTuning(zero, z2, zero, 8.0 * EPSILON * z2, np.nan, zero)
    if is_endless(pair, float(np.max(z1))):
        raise NumericalFailure(
            f"no tuning makes the {pair[1]} under excitation by {pair[0]} small: "
            f"{threshold(*pair).why}"
        )
    if options.kind == "free":
        best = minimax(z1, m, *pair)
        slack = best.excess_error / (best.largest + best.floor) + 4.0 * EPSILON * best.above_floor
        return BestTuning(
            best.stiffness_ratio, best.secondary_damping, best.stiffness_error, best.damping_error,
            best.largest, best.largest_error, best.outcome != NO_HELP, best.evaluations,
            is_set=best.outcome == SET, above_floor=best.above_floor, above_floor_error=slack,
        )  # fmt: skip
    viscous = options.kind == "viscous"
    one = pure_viscous(z1, m, *pair) if viscous else undamped_spring(z1, m, *pair)
    k, z2, k_error, z2_error = zero, one.value, zero, one.value_error
    if not viscous:
        k, z2, k_error, z2_error = z2, k, z2_error, k_error
    return BestTuning(
        k, z2, k_error, z2_error, one.largest, one.largest_error, one.held_by > 0, one.evaluations
    )


def best_tuning(options: Tuning, z1: float, m: float) -> BestTuning:
    """The optimum for one primary damping and mass ratio, with words on it."""
    found = tunings(options, np.asarray(z1), np.asarray(m))
    best = BestTuning(*(np.asarray(part).item() for part in found[:-1]))
    if not np.isfinite(best.stiffness_ratio + best.secondary_damping):
        raise NumericalFailure(
            "the best such absorber is locked to the primary: a mass fastened rigidly does more"
        )
    words = ""
    if options.norm == "h2":
        words = "" if best.helps else "no absorber of this mass lowers the mean square"
    elif options.kind == "free":
        limit = threshold(options.excitation, options.response)
        if best.is_set:
            words = f"many tunings are equally good: {limit.why}; the one given is one of them"
        elif not best.helps:
            words = (
                f"no absorber helps: the primary's damping {z1:.6g} is not below the threshold "
                f"{limit.exact} ({limit.primary_damping:.6g}); {limit.why}"
            )
    return best._replace(remarks=(words,) if words else ())


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
    return peaks(absorber, *pair).top


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
    stiffness, damping = (
        bounds.stiffness_ratio or none,
        bounds.damping_over_primary_critical or none,
    )
    if options.kind == "viscous":
        stiffness = (0.0, 0.0)
    if options.kind == "undamped_spring":
        damping = (0.0, 0.0)
    return Limits(stiffness, damping, np.inf if bounds.travel is None else bounds.travel)


#: what may hold an optimum
HELD_BY = (
    "least stiffness", "least damping", "largest stiffness", "largest damping", "spring travel",
)  # fmt: skip


def within_bounds(options: Tuning, z1: float, m: float, best: BestTuning) -> BandTuning | None:
    """The best tuning within the bounds of the case; None where the best one of all keeps them.

    Raises NumericalFailure where nothing keeps them.
    """
    limits = limits_of(options)
    k, z2 = best.stiffness_ratio, best.secondary_damping
    travel = peaks(Absorber(z1, m, k, z2), options.excitation, _TRAVEL).largest
    both = ((k, limits.stiffness), (z2, limits.damping))
    inside = all(low <= ratio <= high for ratio, (low, high) in both)
    if inside and travel <= limits.travel:
        return None
    return band_tuning(BandProblem(
        one_mode(z1), np.array([m]), options.excitation, options.response,
        stiffness=limits.stiffness, damping=limits.damping, travel=limits.travel,
    ))  # fmt: skip


def as_best(options: Tuning, bounded: BandTuning, z1: float, m: float) -> BestTuning:
    """The tuning within bounds as the answer to the case."""
    alone = float(peaks(Absorber(z1, m, 0.0, 0.0), options.excitation, options.response).largest)
    helps = bool(bounded.largest < alone * (1.0 - _NO_LOWER))
    remarks: tuple[str, ...] = ()
    if not helps:
        remarks = (
            f"no absorber within the bounds does better than none: with the best of them the "
            f"largest response is {bounded.largest:.6g}, without an absorber {alone:.6g}",
        )
    return of_one(bounded)._replace(helps=helps, evaluations=bounded.evaluations, remarks=remarks)


def of_one(found: BandTuning) -> BestTuning:
    """The tuning of a single absorber."""
    k, z2, value, k_error, z2_error, error = found[:6]
    return BestTuning(
        float(k[0]), float(z2[0]), float(k_error[0]), float(z2_error[0]), value, error
    )


def emit_comparison(
    scene: Scene, options: Tuning, free: Absorber, best: BestTuning, bounded: BandTuning | None
) -> None:
    """Which bounds hold the tuning, and next to it the one that there would be without them."""
    pair = options.excitation, options.response
    top, travel = peaks(free, *pair), peaks(free, pair[0], _TRAVEL)
    k, z2 = free.stiffness_ratio, free.secondary_damping
    scene.emit(f"{TUNING_ROOT}/unbounded/stiffness_ratio", k, best.stiffness_error)
    scene.emit(f"{TUNING_ROOT}/unbounded/damping_over_primary_critical", z2, best.damping_error)
    peak = Bounded(top.largest, top.largest_error + best.value_error)
    scene.emit(f"{TUNING_ROOT}/unbounded/peak", peak)
    scene.emit(f"{TUNING_ROOT}/unbounded/travel", travel.top)
    active = np.zeros(len(HELD_BY), dtype=int)
    if bounded is not None:
        active[:] = *bounded.lower, *bounded.upper, np.any(bounded.limit > 0)
    scene.emit(f"{TUNING_ROOT}/bounds/active", active, 0.0, {"tuning_bound": HELD_BY})
    cost = Bounded(np.zeros(()), np.zeros(()))
    if bounded is not None:
        error = (2.0 * bounded.largest_error + top.largest_error) / top.largest + 4.0 * EPSILON
        cost = Bounded(bounded.largest / top.largest - 1.0, error)
    scene.emit(f"{TUNING_ROOT}/bounds/penalty", cost)
    scene.cite(
        "sequential quadratic programming on the levels of all peaks, then Newton's method",
        "tuning within bounds",
        "docs/theory_absorber.md",
    )


def emit_active(scene: Scene, found: BandTuning, as_given: bool = False) -> None:
    """Maxima of the response that hold the tuning."""
    held = found.limit == 0
    axes = {"active": np.arange(1, int(np.sum(held)) + 1)}
    place, error = found.frequency[held], found.frequency_error[held]
    scene.emit(f"{TUNING_ROOT}/active/magnitude", found.height[held], found.largest_error, axes)
    scene.emit(f"{TUNING_ROOT}/active/frequency_ratio", place, error, axes)
    if not as_given:
        weight, error = found.weight[held], found.weight_error[held]
        scene.emit(f"{TUNING_ROOT}/active/weight", weight, error, axes)


# ----------------------------------------------------------------------------
# Adapter, continued: other methods, and what parts cost that are off.
# ----------------------------------------------------------------------------

#: name of a method in the case -> name of its closed form, for the largest amplitude
_FORMS = {"den_hartog": "den_hartog_brock", "nishihara_asami": "nishihara_asami"}
#: levels of k and z2 (n,), or of relative errors of both
Read = Callable[[FloatArray, FloatArray], Bounded]


def emit_methods(
    scene: Scene, options: Tuning, m: float, best: BestTuning, promise: float, top: Read | None,
    level: Read,
) -> None:  # fmt: skip
    """Tunings by other methods, the peaks that they promise and those that they give."""
    pair, rows = (options.excitation, options.response), []
    for name in options.compare:
        row = (best.stiffness_ratio, best.secondary_damping, promise)
        if name != "numerical" and options.norm == "h2":
            form = least_squares.closed_form(m, *pair)
            row = (float(form[0]), float(form[1]), np.inf)
        elif name != "numerical":
            method = METHODS["warburton_acceleration"]
            method = WARBURTON.get(pair, method) if name == "warburton" else METHODS[_FORMS[name]]
            with np.errstate(invalid="ignore"):
                k, z2, promised = (float(part) for part in method.formula(np.asarray(m)))
            if not np.isfinite(z2) or k < 0.0:
                raise NumericalFailure(f"closed form {name!r}: no tuning for a mass ratio of {m:g}")
            row = (k, z2, promised)
            scene.cite(f"closed form {name!r}: {method.validity}", "comparison", method.source)
        rows.append(row)
    k, z2, promised = np.array(rows).T
    root, axes = f"{TUNING_ROOT}/method", {"method": options.compare}
    scene.emit(f"{root}/stiffness_ratio", k, 8.0 * EPSILON * k + best.stiffness_error, axes)
    scene.emit(
        f"{root}/damping_over_primary_critical", z2, 8.0 * EPSILON * z2 + best.damping_error, axes
    )
    if top is not None:
        scene.emit(f"{root}/promised", promised, 16.0 * EPSILON, axes)
        scene.emit(f"{root}/peak", top(k, z2), axes=axes)
    found, least = level(k, z2), best.value
    slack = np.where(np.isfinite(found.error), found.error, 0.0) + best.value_error
    scene.emit(f"{root}/loss", found.value / least - 1.0, 2.0 * slack / least + 4.0 * EPSILON, axes)


def emit_mistuning(scene: Scene, options: Tuning, read: Read, both: bool = True) -> None:
    """What relative errors of spring and damper cost, each alone and, if wanted, both at worst.

    Raises NumericalFailure where the tuned level is not finite.
    """
    shares = np.array(sorted(set(options.mistuning)))
    signed = np.concatenate([-shares[::-1], shares])
    zero = np.zeros(len(signed))
    corners = [(a * shares, b * shares) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    pairs = [(zero[:1], zero[:1]), (signed, zero), (zero, signed), *(corners if both else ())]
    level = read(*(np.concatenate(part) for part in zip(*pairs, strict=True)))
    tuned, slack = level.value[0], level.error[0]
    if not np.isfinite(tuned):
        raise NumericalFailure(
            f"the largest {options.response} under {options.excitation!r} of the tuned absorber is "
            "not finite: no loss can be determined"
        )
    ratio = level.value[1:] / tuned
    error = (level.error[1:] + ratio * slack) / tuned + 4.0 * EPSILON
    n, axes = len(signed), {"mistuned": NAMES["mistuned"], "deviation": signed}
    each, off = (part[: 2 * n].reshape(2, n) for part in (ratio - 1.0, error))
    scene.emit(f"{TUNING_ROOT}/mistuning/loss", each, off, axes)
    if both:
        worst, off = (part[2 * n :].reshape(4, -1) for part in (ratio - 1.0, error))
        worst, off = np.max(worst, axis=0), np.max(off, axis=0)
        scene.emit(f"{TUNING_ROOT}/mistuning/worst", worst, off, {"share": shares})


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
    best = tunings(options, z1, m)
    k, z2 = best.stiffness_ratio, best.secondary_damping
    there = Absorber(z1, m, k, z2)
    top = peaks(there, *pair)
    on_secondary = np.where(k > 0.0, own_damping_ratio(there), 0.0)
    axes = {"primary_damping": damping, "mass_ratio": ratio}
    scene.emit(f"{TUNING_ROOT}/chart/stiffness_ratio", k, best.stiffness_error, axes)
    scene.emit(f"{TUNING_ROOT}/chart/damping_over_primary_critical", z2, best.damping_error, axes)
    safe = [np.where(part > 0.0, part, 1.0) for part in (k, z2)]
    relative = best.stiffness_error / safe[0] + best.damping_error / safe[1] + 8.0 * EPSILON
    scene.emit(
        f"{TUNING_ROOT}/chart/absorber_damping_ratio", on_secondary, on_secondary * relative, axes
    )
    off = best.value_error if options.norm == "h_infinity" else 0.0
    scene.emit(
        f"{TUNING_ROOT}/chart/peak", Bounded(top.largest, top.largest_error + off), axes=axes
    )


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
    axes = {"stiffness_ratio": stiffness, "damping_over_primary_critical": damping}
    scene.emit(f"{TUNING_ROOT}/map/peak", found.top, axes=axes)
