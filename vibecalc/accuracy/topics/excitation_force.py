"""Topics of the excitation: the largest force and couple on the body over a turn."""

import numpy as np

from vibecalc.accuracy.topic import Topic
from vibecalc.accuracy.yardsticks.cycle_peaks import peak_topic
from vibecalc.accuracy.yardsticks.cycle_signals import Signal
from vibecalc.excitation.sums import at_speed
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import DIRECTIONS, Forcing


def topics(scene: Scene) -> list[Topic]:
    """The peak of the largest component of force and of couple, each where there is one."""
    forcing: Forcing = scene.handed_on["forcing"]
    driven = at_speed(forcing.per_speed_squared, scene.case.machine.speed)
    orders = forcing.orders[: forcing.kept]
    found = []
    for name, unit, value, error in (
        ("force", "N", driven.force, driven.force_error),
        ("couple", "N*m", driven.couple, driven.couple_error),
    ):
        rows, doubt = value[: forcing.kept].T, error[: forcing.kept].T
        rows = np.where(np.abs(rows) > doubt, rows, 0.0)
        size = cycle_peak(rows, orders).value
        which = int(np.argmax(size))
        if not size[which] > 0.0:
            continue  # balanced: nothing has a peak
        found.append(
            peak_topic(
                "excitation",
                f"{name} peak",
                f"largest {name} on the body along {DIRECTIONS[which]} over a turn, "
                f"orders to {forcing.kept}",
                f"excitation/{name}_peak",
                unit,
                Signal(rows[which : which + 1], orders),
            )
        )
    return found
