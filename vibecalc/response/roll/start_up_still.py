"""What rounding leaves of a machine that stands still: zero in its peaks."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.start_up_system import StartUpSystem
from vibecalc.response.roll.start_up_view import QUANTITIES, Peak

#: share of what a machine reaches in size that rounding may leave in one that stands still
_STILL = 1e-12


def rounding_of(system: StartUpSystem) -> FloatArray:
    """What rounding may leave in each of QUANTITIES of a machine that stands still (q,)."""
    turn, fast, angle, rate = (float(size) for size in system.scale[:4])
    torque, shell = system.torque_scale, float(np.min(system.machine.shell_inertia))
    size = {
        "crank_angle": turn,
        "shell_angle": angle,
        "shell_speed": rate,
        "shell_acceleration": torque / shell,
        "rotor_acceleration": fast * fast,
    }
    speeds = dict.fromkeys(("crank_speed", "slip"), fast)
    return _STILL * np.array([(size | speeds).get(name, torque) for name in QUANTITIES])


def without_rounding(peak: Peak, floor: FloatArray) -> Peak:
    """Peaks (..., q) with zero, at time zero, for what is no more than rounding."""
    there = peak.value > floor
    return peak._replace(
        value=np.where(there, peak.value, 0.0),
        time=np.where(there, peak.time, 0.0),
        error=np.where(there, peak.error, np.maximum(peak.error, floor)),
    )
