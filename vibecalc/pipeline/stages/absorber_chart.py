"""Adapter, continued: tunings over a chart, and the largest response around one tuning."""

import numpy as np

from vibecalc.case.absorber_tables import MassRatios, Tuning
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.absorber import mean_square as least_squares
from vibecalc.optimisation.absorber.closed_forms import METHODS
from vibecalc.optimisation.absorber.minimax import UNBOUNDED, minimax
from vibecalc.optimisation.absorber.minimax_restricted import pure_viscous, undamped_spring
from vibecalc.pipeline.entries.tuning import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.response.absorber.model import Absorber, own_damping_ratio
from vibecalc.response.absorber.peaks import peaks

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
    found = peaks(there, *pair)
    own = np.where(k > 0.0, own_damping_ratio(there), 0.0)
    axes = {"primary_damping": damping, "mass_ratio": ratio}
    scene.emit(f"{ROOT}/chart/stiffness_ratio", k, errors[0], axes)
    scene.emit(f"{ROOT}/chart/secondary_damping", z2, errors[1], axes)
    safe = [np.where(part > 0.0, part, 1.0) for part in (k, z2)]
    relative = errors[0] / safe[0] + errors[1] / safe[1] + 8.0 * EPSILON
    scene.emit(f"{ROOT}/chart/own_damping", own, own * relative, axes)
    doubt = np.where(np.isfinite(found.largest), found.largest_error, 0.0)
    scene.emit(f"{ROOT}/chart/peak", found.largest, doubt + errors[2], axes)


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
        found = pure_viscous(z1, m, *pair)
        return zero, found.value, (zero, found.value_error, found.largest_error)
    if options.kind == "undamped_spring":
        found = undamped_spring(z1, m, *pair)
        return found.value, zero, (found.value_error, zero, found.largest_error)
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
    scene.emit(f"{ROOT}/map/peak", found.largest, found.largest_error, axes)
