"""Adapter: what the orders that a case leaves out would add to the torques of its shafts."""

import numpy as np

from vibecalc.numerics.typing import BoolArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.curves import solved
from vibecalc.pipeline.stages.torsion.drive import build_drive
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.synthesis import synthesis

#: a share of the half range that is worth a sentence
NOTICEABLE = 0.01


def warn_of_orders(scene: Scene, setup: Setup) -> None:
    """Look at the operating speed at twice as many orders, by the smallest step of the cycle."""
    own = setup.drive.order
    base = 2.0 * np.pi / setup.drive.firing.cycle
    drive = build_drive(scene.case, setup.shaft, orders=(2.0 * float(own[-1]), float(base)))
    found = solved(setup.model, drive, np.array([setup.speed]))
    order, torque = drive.order, found.torque[0].T / setup.shaft.section_ratio[:, None]
    kept = np.min(np.abs(order[:, None] - own), axis=1) < 0.25 * base
    half = synthesis(order[kept], torque[:, kept]).half_range
    seen = half > NOTICEABLE * half.max(initial=0.0)
    if not np.any(seen):
        return
    safe = np.where(seen, half, np.inf)

    def tell(chosen: BoolArray, what: str) -> None:
        met = order[chosen & found.masked[0]]
        if len(met):
            scene.warn(
                f"{what} are left out; order {met[0]:g} of them is on an undamped natural "
                "frequency at the operating speed, where its response has no bound"
            )
            return
        added = synthesis(order[chosen], torque[:, chosen]).half_range
        most = int(np.argmax(added / safe))
        if added[most] > NOTICEABLE * safe[most]:
            scene.warn(
                f"{what} are left out and in no error estimate: at the operating speed they have "
                f"a half range of {added[most]:.3g} N*m in '{setup.shaft.section_names[most]}', "
                f"{100.0 * added[most] / half[most]:.3g} % of that of the orders of the case"
            )

    between = ~kept & (order < own[-1])
    if np.any(between):
        step = float(own[0])
        half_orders = "half orders" if step == 1.0 and base < 1.0 else "orders between"
        tell(between, f"the {half_orders}, since the step of the orders is {step:g},")
    tell(order > own[-1] + 0.25 * base, f"the orders above {own[-1]:g}, up to {order[-1]:g},")
