"""Adapter, continued: what a case may ask for beside a tuning of one absorber."""

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.optimisation.absorber import mean_square as least_squares
from vibecalc.optimisation.absorber.closed_forms import METHODS, closed_form
from vibecalc.optimisation.absorber.mistuning import mistuning
from vibecalc.optimisation.absorber.mistuning_sensitivity import sensitivity
from vibecalc.pipeline.entries.tuning import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber_optimum import Best, best_tuning, is_endless, level_of
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: name of a method in the case -> name of its closed form, for the largest amplitude
_FORMS = {
    "den_hartog": "den_hartog_brock",
    "nishihara_asami": "nishihara_asami",
    "warburton": "warburton_acceleration",
}
#: relative step of slopes by the given ratios
_STEP = 1e-4


def emit_methods(scene: Scene, options: Tuning, tuned: Absorber, best: Best) -> None:
    """Tunings by other methods, the peaks that they promise and those that they give."""
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    pair = options.excitation, options.response
    own, least = float(peaks(tuned, *pair).largest), float(level_of(options, tuned).value)
    names = options.compare
    rows = []
    for name in names:
        if name == "numerical":
            k, z2, promise = best.stiffness_ratio, best.secondary_damping, own
        elif options.norm == "h2":
            form = least_squares.closed_form(m, *pair)
            k, z2, promise = (float(x) for x in (form[0], form[1], np.inf))
        else:
            found = closed_form(_FORMS[name], m, z1, *pair)
            k, z2 = float(found.stiffness_ratio), float(found.secondary_damping)
            promise = float(found.promised)
            _cite_form(scene, name)
        one = Absorber(z1, m, k, z2)
        there, level = peaks(one, *pair), level_of(options, one)
        rows.append((
            k, z2, promise, float(there.largest), float(there.largest_error),
            float(level.value), float(level.error),
        ))  # fmt: skip
    table = np.array(rows).T
    axes = {"method": names}
    slack, doubt = (np.where(np.isfinite(part), part, 0.0) for part in (table[4], table[6]))
    stiffness, damping = table[0], table[1]
    scene.emit(
        f"{ROOT}/method/stiffness_ratio",
        stiffness,
        8.0 * EPSILON * stiffness + best.stiffness_error,
        axes,
    )
    scene.emit(
        f"{ROOT}/method/secondary_damping",
        damping,
        8.0 * EPSILON * damping + best.damping_error,
        axes,
    )
    scene.emit(f"{ROOT}/method/promised", table[2], 16.0 * EPSILON, axes)
    scene.emit(f"{ROOT}/method/peak", table[3], slack, axes)
    scene.emit(
        f"{ROOT}/method/loss", table[5] / least - 1.0, 2.0 * doubt / least + 4.0 * EPSILON, axes
    )


def _cite_form(scene: Scene, name: str) -> None:
    method = METHODS[_FORMS[name]]
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
    axes = {"mistuned": ("stiffness", "damping"), "deviation": signed}
    scene.emit(f"{ROOT}/mistuning/loss", np.array(rows), max(errors), axes)
    scene.emit(f"{ROOT}/mistuning/worst", found.corner.value, found.corner.error, {"share": shares})


def _emit_mistuned_mean(
    scene: Scene, options: Tuning, tuned: Absorber, shares: tuple[float, ...]
) -> None:
    """The same for a mean square."""
    size = np.array(shares)
    signed, both = np.concatenate([-size[::-1], size]), np.stack([-size, size])
    k, z2 = tuned.stiffness_ratio, tuned.secondary_damping
    least = float(level_of(options, tuned).value)

    def loss(stiff: np.ndarray, damped: np.ndarray) -> WithError:
        off = tuned._replace(
            stiffness_ratio=np.multiply(k, 1.0 + stiff),
            secondary_damping=np.multiply(z2, 1.0 + damped),
        )
        found = level_of(options, off)
        return WithError(found.value / least - 1.0, 2.0 * found.error / least + 4.0 * EPSILON)

    zero = np.zeros_like(signed)
    each = [loss(signed, zero), loss(zero, signed)]
    values, errors = (np.stack([one[i] for one in each]) for i in range(2))
    axes = {"mistuned": ("stiffness", "damping"), "deviation": signed}
    scene.emit(f"{ROOT}/mistuning/loss", values, errors, axes)
    corner = loss(both[:, None, :], both[None, :, :])
    worst = np.max(corner.value, axis=(0, 1))
    scene.emit(f"{ROOT}/mistuning/worst", worst, np.max(corner.error), {"share": shares})


def emit_sensitivity(
    scene: Scene, options: Tuning, z1: float, m: float, bounded: object = None
) -> None:
    """Slopes of the optimum by the given ratios: of its own conditions, else from differences."""
    names = ("primary_damping", "mass_ratio")
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
            scene.emit(f"{ROOT}/sensitivity/{name}", slopes, errors, {"ratio": names})
        return
    pair = options.excitation, options.response
    if is_endless(pair, max(z1, EPSILON)):
        raise NumericalFailure(
            f"no slopes of this tuning: with damping of the primary the {pair[1]} under excitation "
            f"by {pair[0]} has no bound at high frequency"
        )
    found: dict[str, list[tuple[float, float]]] = {"k": [], "z2": [], "peak": []}
    for place, value in enumerate((z1, m)):
        width = _STEP * max(value, 0.01 if place == 0 else 0.0)
        each = [_slopes(options, z1, m, place, step) for step in (width, 0.5 * width)]
        sharper = (4.0 * each[1] - each[0]) / 3.0
        doubt = np.abs(each[1] - each[0]) + 1e-13 / width
        for name, slope, error in zip(found, sharper, doubt, strict=True):
            found[name].append((float(slope), float(error)))
    axes = {"ratio": names}
    for name, key in (("stiffness_ratio", "k"), ("secondary_damping", "z2"), ("peak", "peak")):
        values, errors = np.array(found[key]).T
        scene.emit(f"{ROOT}/sensitivity/{name}", values, errors, axes)


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
