"""Adapter: a mass that dry friction drags along: response, its largest, the best friction."""

import numpy as np

from vibecalc.absorber.friction_damper import DryFriction, best_friction, largest, response
from vibecalc.absorber.model import primary_damping, primary_scale, rubbed_mass
from vibecalc.absorber.results import FrictionDamped
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON

#: frequency ratios of the curve
_RATIOS = (0.0, 2.0, 401)


def run_friction_damper(scene: Scene) -> None:
    """Emit the response with the friction of the case, or with the best, and what is best."""
    machine = scene.case.machine
    assert machine.primary is not None and machine.friction_damper is not None
    scale = primary_scale(machine)
    z1 = primary_damping(machine.primary, scale)
    m, given, force = rubbed_mass(machine.friction_damper, scale)
    best = None
    try:
        best = best_friction(z1, m)
    except NumericalFailure as failure:
        if given is None or scene.wanted is not None:
            raise
        scene.warn(f"best_friction_ratio and best_largest left out: {failure}")
    size = np.asarray(0.0 if given is None else given)
    ratio = best[0] if best is not None and given is None else Bounded(size, 2.0 * EPSILON * size)
    one, x = DryFriction(z1, m, float(ratio.value)), np.linspace(*_RATIOS)
    (top, place), curve = largest(one), response(one, x)
    slack = 64.0 * EPSILON * np.where(np.isfinite(curve), curve, 0.0)
    found = FrictionDamped(
        mass_ratio=Bounded(np.asarray(m), np.asarray(2.0 * EPSILON * m)),
        friction_ratio=ratio,
        largest=top,
        largest_frequency_ratio=Bounded(np.asarray(place), np.asarray(1e-7 * place)),
        best_friction_ratio=None if best is None else best[0],
        best_largest=None if best is None else best[1],
        curve=Bounded(curve, slack),
    )
    scene.emit_all(found, {"frequency_ratio": x})
    if force is not None and scale is not None:
        rub, moved = ratio * force, top * (force / scale.stiffness)
        scene.emit_all(
            FrictionDamped(friction_torque=rub, largest_angle=moved)
            if scale.torsion
            else FrictionDamped(friction_force=rub, largest_displacement=moved)
        )
    if np.isinf(float(top.value)):
        scene.warn(
            "the friction takes less than the force brings in at resonance, however far the "
            "primary moves: it needs pi / 4 of the force or more"
        )
    scene.cite(
        "first harmonic of the friction on a mass that slips, slips and sticks, or sticks",
        "friction damper",
        "J. P. Den Hartog, Mechanical Vibrations (1956); docs/theory_absorber.md",
    )
