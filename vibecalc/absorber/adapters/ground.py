"""Adapter: the least mean square of a primary on a ground whose acceleration is white."""

import numpy as np

from vibecalc.absorber.adapters.optimum import best_tuning, level_of
from vibecalc.absorber.adapters.response import tuning_error
from vibecalc.absorber.adapters.tuning import emit_mistuning, emit_units
from vibecalc.absorber.model import build_absorber
from vibecalc.absorber.results import TUNING_ROOT
from vibecalc.absorber.transfer import Absorber, own_damping_ratio
from vibecalc.absorber.tuning.mean_square import closed_form
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import EPSILON


def run_ground_tuning(scene: Scene) -> None:
    """Emit spring and damper of least mean square; hand on the tuned absorber."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    if options is None or parts.absorber is None:
        raise ValueError("the case has no absorber to tune")
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    best = best_tuning(options, z1, m)
    k, z2 = best.stiffness_ratio, best.secondary_damping
    tuned = Absorber(z1, m, k, z2)
    scene.handed_on["tuned"] = tuned
    scene.handed_on["tuned_uncertainty"] = tuning_error(best.stiffness_error, best.damping_error)
    own = float(own_damping_ratio(tuned)) if k > 0.0 else 0.0
    relative = best.stiffness_error / (k or 1.0) + best.damping_error / (z2 or 1.0)
    for name, value, error in (
        ("primary_damping", z1, 0.0),
        ("mass_ratio", m, 2.0 * EPSILON * m),
        ("stiffness_ratio", k, best.stiffness_error),
        ("secondary_damping", z2, best.damping_error),
        ("own_damping", own, own * (relative + 4.0 * EPSILON)),
        ("helps", float(best.helps), 0.0),
        ("without_spring", float(k == 0.0 and best.helps), 0.0),
        ("mean_square", best.value, best.value_error),
        ("mean_square_alone", best.alone, 8.0 * EPSILON * best.value),
    ):
        scene.emit(f"{TUNING_ROOT}/{name}", value, error)
    emit_units(scene, options, parts, best)
    if options.compare:
        rows = []
        for name in options.compare:
            form = closed_form(m, options.excitation, options.response)
            rows.append((k, z2) if name == "numerical" else (float(form[0]), float(form[1])))
        stiffness, damping = np.array(rows).T
        level = level_of(options, Absorber(z1, m, stiffness, damping))
        axes = {"method": options.compare}
        off = 8.0 * EPSILON + relative
        scene.emit(f"{TUNING_ROOT}/method/stiffness_ratio", stiffness, off * stiffness, axes)
        scene.emit(f"{TUNING_ROOT}/method/secondary_damping", damping, off * damping, axes)
        loss = level.value / best.value - 1.0
        slack = (level.error + best.value_error) / best.value + 4.0 * EPSILON
        scene.emit(f"{TUNING_ROOT}/method/loss", loss, slack, axes)
    if options.mistuning:
        emit_mistuning(scene, options, tuned)
    for words in best.remarks:
        scene.warn(words)
    scene.cite(
        "closed form of the mean square, Newton's method",
        "tuning for a white acceleration of the ground",
        "Warburton, Earthq. Eng. Struct. Dyn. 10 (1982), undamped; docs/theory_absorber_tuning.md",
    )
