"""What has become of a start: does it run, crawl, rock or stand?"""

import numpy as np

from vibecalc.excitation.slip_torque import breakdown
from vibecalc.numerics.runge_kutta_march import Marched
from vibecalc.response.roll.machine import RollDrive
from vibecalc.response.roll.start_up_states import WAY
from vibecalc.response.roll.start_up_system import StartUpSystem
from vibecalc.response.roll.start_up_view import QUANTITIES, Seen, Turns, mean_speed

_MOTOR, _GAS = QUANTITIES.index("motor_torque"), QUANTITIES.index("gas_torque")
#: share of the torques of a running machine, and rad, that are nothing but rounding
_SMALL, _STANDS = 1e-12, 1e-9


def running_branch(drive: RollDrive) -> float:
    """Crank speed above which the motor runs short of its breakdown torque, rad/s.

    For a motor without breakdown torque, half the synchronous speed.
    """
    synchronous = float(drive.synchronous_speed)
    slip, _ = breakdown(drive.motor)
    return synchronous - slip if np.isfinite(slip) else 0.5 * synchronous


def _rounded(torque: float, system: StartUpSystem) -> float:
    """A torque without what is only rounding."""
    return torque if abs(torque) > _SMALL * system.torque_scale else 0.0


def _lacking(system: StartUpSystem, shown: Seen) -> str:
    """What the motor lacks in torque at a start from rest; empty where it moves the crank."""
    motor, gas = (_rounded(float(shown.value[row, 0]), system) for row in (_MOTOR, _GAS))
    if shown.value[1, 0] != 0.0:
        return ""
    if motor <= 0.0:
        return "; the motor gives no torque at standstill" if motor == 0.0 else (
            f"; at standstill the motor turns backward, with {-motor:.4g} N*m"
        )  # fmt: skip
    if motor + gas <= 0.0:
        return (
            f"; the motor's {motor:.4g} N*m at standstill are no more than the {-gas:.4g} N*m with "
            "which the gas pushes back at the start angle"
        )
    return ""


def verdict_of(
    system: StartUpSystem, ended: Marched, shown: Seen, found: Turns, settles: bool
) -> tuple[str, str]:
    """The verdict of `StartUp` and its reason; `settles` is whether the shaking has settled."""
    angle, speed = shown.value[0], shown.value[1]
    here, time = float(angle[-1]), float(shown.time[-1])
    degrees = round(float(np.degrees(np.mod(here, 2.0 * np.pi))), 9)
    if system.dry and ended.piece[0, WAY] == 0:
        motor, gas = (float(shown.value[row, -1]) for row in (_MOTOR, _GAS))
        return "stalled", (
            f"held by friction at crank angle {degrees:.4g} degrees, where the motor gives "
            f"{_rounded(motor, system):.4g} N*m at standstill and the gas "
            f"{_rounded(gas, system):.4g} N*m"
        )
    recent = shown.time >= 0.5 * time
    low, high = float(np.min(angle[recent])), float(np.max(angle[recent]))
    if not len(found.period) or found.begin[-1] + 2.5 * found.period[-1] < time:
        if high - low <= _STANDS:
            words = f"it stands still at crank angle {degrees:.4g} degrees"
            return "stalled", words + _lacking(system, shown)
        if np.min(speed[recent]) < 0.0:
            return "rocking", (
                f"the motor does not turn it over the compression: it rocks between crank angles "
                f"of {np.degrees(low):.4g} and {np.degrees(high):.4g} degrees"
                + _lacking(system, shown)
            )
        return "stalled", (
            f"no turn is completed; it has come to {degrees:.4g} degrees{_lacking(system, shown)}"
        )
    mean, branch = float(mean_speed(found)[-1]), running_branch(system.drive)
    if mean < branch:
        return "crawling", (
            f"it turns at {mean:.4g} rad/s and does not pass the breakdown torque at "
            f"{branch:.4g} rad/s"
        )
    words = f"it runs at {mean:.6g} rad/s"
    return ("settled", words) if settles else ("running", words + ", not yet settled")
