"""Adapter, continued: what a tuned absorber becomes while its oil warms."""

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.hardware.oils import oil_damping
from vibecalc.hardware.warming import warming
from vibecalc.machine.absorber import AbsorberParts
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.absorber.minimax_restricted import given_damping
from vibecalc.pipeline.entries.absorber_parts import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber_stock import Held
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks


def emit_warming(scene: Scene, options: Tuning, parts: AbsorberParts, held: Held) -> None:
    """Damping and peak at each temperature, springs kept; and the springs that would be best."""
    asked, filled, scale = options.temperatures, parts.filling, parts.scale
    if asked is None or filled is None or scale is None or parts.absorber is None:
        return
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    pair = options.excitation, options.response

    def peak_of(damping: FloatArray) -> WithError:
        found = peaks(Absorber(z1, m, held.stiffness_ratio, damping), *pair)
        return WithError(found.largest, found.largest_error)

    def damping_at(warm: FloatArray) -> WithError:
        return oil_damping(held.oil, filled.gap, warm)

    warm = np.linspace(asked.start, asked.stop, asked.points)
    course = warming(warm, damping_at, scale.stiffness, scale.inertia, peak_of, held.least)
    axes = {"temperature": warm}
    scene.emit(f"{ROOT}/warming/damping", *course.damping, axes)
    scene.emit(f"{ROOT}/warming/secondary_damping", *course.secondary_damping, axes)
    scene.emit(f"{ROOT}/warming/peak", *course.peak, axes)
    if options.kind in ("viscous", "lanchester"):
        return
    best = given_damping(z1, m, course.secondary_damping.value, *pair)
    value = np.where(np.isfinite(best.value), best.value, 0.0)
    error = np.where(np.isfinite(best.value), best.value_error, 0.0)
    # the spring follows the damping that the oil gives
    spread = course.secondary_damping.error / course.secondary_damping.value
    scene.emit(f"{ROOT}/warming/best_stiffness_ratio", value, error + 4.0 * value * spread, axes)
    doubt = best.largest_error + 4.0 * best.largest * spread
    scene.emit(f"{ROOT}/warming/best_peak", best.largest, doubt, axes)
