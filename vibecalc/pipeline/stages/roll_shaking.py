"""Adapter: what the textbook says of the body's shaking, beside the roll that it leaves out.

At constant speed, in a shell that does not turn, masses shake the body by a force and a couple,
and gas and motor are inner forces. Both can be balanced to nothing, and the shell rolls still.
"""

import numpy as np

from vibecalc.excitation.adapter import train_excitation
from vibecalc.excitation.inertia_forces import size_of_terms
from vibecalc.kinematics.adapter import exact_motion
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.pipeline.entries.roll import SHAKING
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.roll_observed import Seen

DIRECTIONS = ("x", "y", "z")


def emit_shaking(scene: Scene, seen: Seen, finer: Seen, orders: int) -> None:
    """Force and couple of the masses at the mean speed found, orders 1 .. `orders`, and peaks.

    The peaks are of all orders.
    """
    train = scene.parts.crank_train
    motion = exact_motion(scene.case, train, orders)
    driven = train_excitation(train, scene.parts.rotating_masses, motion, scene.case.machine)
    speed, other = (2.0 * np.pi / float(look.turn.period[0]) for look in (seen, finer))
    square, doubt = speed**2, abs(speed**2 - other**2)
    numbers, kept = np.arange(1, motion.kept + 1), motion.kept
    for name, value, error in (
        ("force", driven.force, driven.force_error),
        ("couple", driven.couple, driven.couple_error),
    ):
        off = square * error + doubt * np.abs(value)
        axes = {"order": numbers[:orders], "direction": DIRECTIONS}
        rounding = square * error
        scene.emit(
            f"{SHAKING}/{name}",
            square * value[:orders],
            off[:orders],
            axes,
            terms=size_of_terms(rounding[:orders]),
        )
        peak = cycle_peak(square * value[:kept].T, numbers)
        spread = off[:kept].sum(0) + motion.tail * square * np.abs(value[kept:]).sum(0)
        axes = {"direction": DIRECTIONS}
        terms = size_of_terms(peak.error + rounding[:kept].sum(0))
        scene.emit(f"{SHAKING}/{name}_peak", peak.value, peak.error + spread, axes, terms=terms)
    scene.cite(
        "d'Alembert sums of the crank train at the mean speed found",
        "forces and couples that constant speed and a fixed shell leave",
        "Biezeno and Grammel, Technische Dynamik, 2nd ed. 1953, ch. XI",
    )
