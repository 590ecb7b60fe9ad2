"""Results of the piston motion."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, q
from vibecalc.core.results.record import ORDERS, PEAK, PLACE, TURN


class OfPiston(Group):
    """Motion of a piston whose rod stands on the crank pin."""

    ROOT: ClassVar[str] = "kinematics"
    position_harmonics: Any = q("order", "m", "harmonics of piston position", PEAK)
    acceleration_harmonics: Any = q(
        "order",
        "m/s^2",
        "harmonics of piston acceleration at operating speed",
        PEAK,
        name="harmonic of the piston acceleration",
    )
    dropped_acceleration: Any = q(
        "", "m/s^2", "acceleration neglected by the chosen series or order", PEAK
    )
    position: Any = q("crank_angle", "m", "piston position from the crank axis")
    velocity: Any = q("crank_angle", "m/s", "piston velocity")
    acceleration: Any = q("crank_angle", "m/s^2", "piston acceleration")


class OfCylinders(Group):
    """Motion of each piston of a train with slave rods."""

    ROOT: ClassVar[str] = "kinematics/cylinder"
    stroke: Any = q("cylinder", "m", "stroke of the piston")
    top_dead_centre: Any = q("cylinder", "rad", "its crank angle", exempt=PLACE, circle=TURN)
    bottom_dead_centre: Any = q("cylinder", "rad", "its crank angle", exempt=PLACE, circle=TURN)
    position_harmonics: Any = q(
        "cylinder order", "m", "harmonics of the piston's position over the crank angle", PEAK
    )
    acceleration_harmonics: Any = q(
        "cylinder order", "m/s^2",
        "harmonics of the piston's acceleration over the crank angle", PEAK,
    )  # fmt: skip


ENTRIES = tuple(entries_of(OfPiston, OfCylinders))
HELPS = {"kinematics/": (ORDERS,)}
