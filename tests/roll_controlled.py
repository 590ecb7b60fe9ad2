"""A controlled roll machine marched in the crank angle, by equations written out here."""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from vibecalc.excitation.gas_tables import force_at
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.roll.control.full_model import Law
from vibecalc.roll.mechanism import RollDrive, RollMachine


def rates(
    machine: RollMachine, drive: RollDrive, law: Law
) -> Callable[[float, np.ndarray], np.ndarray]:
    """d(w, theta, s, u)/db of one machine (B = 1) without friction or wrist pin offset.

    Newton's law for the two coordinates as a linear system, with the lag of the actuator.
    """
    one = RollMachine(*(np.asarray(field)[0] for field in machine))

    def found(angle: float, state: np.ndarray) -> np.ndarray:
        w, theta, s, u = state
        own = angle + one.crank_angle_offset
        r, slope, bend, _ = piston_path(own, one.crank_radius, one.rod_length, 0.0)
        mass = one.reciprocating_mass
        force = np.array([float(force_at(g, np.array([a]))[0]) for g, a in zip(
            drive.gas, np.mod(own, 2.0 * np.pi), strict=True)])  # fmt: skip
        motor = float(slip_torque(drive.motor, np.array([u - w])).value[0])
        rotor = one.rotor_inertia
        whole = one.shell_inertia + rotor + np.sum(mass * r * r)
        crank = rotor + np.sum(mass * slope * slope)
        # momentum of mass and its rate; energy by r alone
        left = np.array([[whole, rotor], [rotor, crank]])
        right = np.array([
            -one.shell_stiffness * theta - one.shell_damping * s
            - 2.0 * np.sum(mass * r * slope) * w * s,
            motor - np.sum(force * slope) + np.sum(mass * r * slope) * s * s
            - np.sum(mass * slope * bend) * w * w,
        ])  # fmt: skip
        shell, spin = np.linalg.solve(left, right)
        asked = law.gain * (
            law.reference - law.speed_feedback * w - law.acceleration_feedback * shell
        )
        return np.array([spin, s, shell, (asked - u) / law.lag]) / w

    return found


def marched(
    machine: RollMachine, drive: RollDrive, law: Law, start: np.ndarray, turns: int
) -> np.ndarray:
    """The state after whole turns; steps end at every node of the gas tables."""
    step, state = rates(machine, drive, law), np.asarray(start, dtype=float)
    for _ in range(turns):
        for low in np.arange(36) * np.pi / 18.0:
            found = solve_ivp(
                step, (low, low + np.pi / 18.0), state, method="LSODA", rtol=1e-9, atol=1e-11
            )
            state = found.y[:, -1]
    return state
