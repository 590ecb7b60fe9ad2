"""Results of mounts that depend on what they carry, on the frequency, or that have stops."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, lead, paths_of, q
from vibecalc.core.results.record import DIFFERENCE, PEAK

#: of what is left of a difference, the least stands in the first table
LEAST = {"pick": "least", "exempt": DIFFERENCE}


class OfMounts(Group):
    """Along the axis of each: at rest, over the frequency, and how near it comes to its stops.

    A clearance is negative where the mount stands on a stop or meets it, and infinite without one;
    in the run-up it is that under weight and mean torque less the largest motion.
    """

    ROOT: ClassVar[str] = "isolation/mounts"
    load: Any = q("mount", "N", "compression load of a mount at rest along its axis")
    deflection: Any = q("mount", "m", "compression of a mount at rest along its axis")
    static_stiffness: Any = q("mount", "N/m", "static tangent stiffness at rest")
    stiffness: Any = q("mount", "N/m", "dynamic stiffness along its axis at rest, nominal")
    load_curve: Any = q("mount deflection", "N", "static load of a mount against compression")
    clearance_at_rest: Any = q("mount", "m", "distance to the nearer stop", exempt=DIFFERENCE)
    travel: Any = q("mount", "m", "largest motion of a mount along its axis", PEAK)
    clearance: Any = lead("mount", "m", "clearance to a stop at speed", **LEAST)
    run_up_travel: Any = q("mount", "m", "largest motion along its axis in the run-up", PEAK)
    run_up_travel_speed: Any = q("mount", "rad/s", "crank speed at that motion")
    run_up_clearance: Any = lead("mount", "m", "clearance to a stop in the run-up", **LEAST)
    order_stiffness: Any = q("mount order", "N/m", "stiffness along its axis at an order")
    order_loss_factor: Any = q("mount order", "", "loss factor at the frequency of an order")


#: of mounts with static or over_load
AT_REST = paths_of(OfMounts, "load", "deflection", "static_stiffness", "stiffness", "load_curve")
#: of mounts with stops
OF_STOPS = paths_of(OfMounts, "clearance_at_rest")
MOVING = paths_of(OfMounts, "travel", "clearance")
OF_RUN_UP = paths_of(OfMounts, "run_up_travel", "run_up_travel_speed", "run_up_clearance")
#: of mounts with over_frequency
BY_ORDER = paths_of(OfMounts, "order_stiffness", "order_loss_factor")
