"""The simulation of Herold (1977), appendix A, in our words: what its numbers were made with.

Euler's rule at half a millisecond from crank angle zero with the crank at synchronous speed and the
shell at rest. Position of the pistons, lean of the rods and the way in which forces act are exact,
but velocity and acceleration of the pistons keep the first two orders alone (equations 54 and 60).
The motor's table is joined by straight lines; the gas tables by the parabola through the node
before, at and after each ten degrees. As soon as two periods differ by less than one per cent, the
next turn is analysed, with sums over the steps and with the period of the turn before it.

Two things stand in none of its words, and the printed digits tell them: the tables of the gas do
not close, so that the first ten degrees get the parabola through the first three nodes; and the
computer's single precision cuts numbers off at six digits of base 16.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import force_at
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.roll.mechanism import RollDrive, RollMachine

TURN = 2.0 * np.pi
STEP = 0.0005


class Simulation(NamedTuple):
    """What the program prints, and the steps of each turn that it has counted.

    `level` in dB against 1 rad/s^2, `lag` in rad from 0 to 2 pi, `frequency` in Hz, `drift` of the
    angular momentum in per cent; speed and torques (N m, on the crankshaft) over the analysed turn.
    """

    level: np.ndarray
    lag: np.ndarray
    frequency: float
    drift: float
    steps: list[int]
    crank_speed: np.ndarray
    motor_torque: np.ndarray
    gas_torque: np.ndarray


def whole(value: float) -> float:
    """No rounding beyond that of double precision."""
    return value


def hexadecimal(value: float) -> float:
    """Cut to six digits of base 16, the single precision of the source's computer."""
    if value == 0.0:
        return 0.0
    _, exponent = np.frexp(value)
    scale = 16.0 ** (6 - -(-int(exponent) // 4))
    return float(np.trunc(value * scale) / scale)


def open_tables(drive: RollDrive, first: tuple[float, ...] = (0.0, np.pi)) -> RollDrive:
    """The parabolas as the program takes them from tables that do not close.

    `first` is the own angle of each cylinder at which its table of the source begins.
    """
    curves = []
    for gas, begin in zip(drive.gas, first, strict=True):
        assert gas is not None
        node, rows = gas.node, gas.coefficient.copy()
        place = int(np.argmin(np.abs(np.angle(np.exp(1j * (node - begin))))))
        low, middle, high = (rows[(place + k) % len(node), 0] for k in range(3))
        width = TURN / len(node)
        bend = (high - 2.0 * middle + low) / (2.0 * width * width)
        rows[place] = low, (middle - low) / width - bend * width, bend
        curves.append(gas._replace(coefficient=rows))
    return drive._replace(gas=tuple(curves))


def simulate(
    machine: RollMachine,
    drive: RollDrive,
    *,
    step: float = STEP,
    orders: int = 10,
    truncated: bool = True,
    equation_64: bool = False,
    rounded: Callable[[float], float] = whole,
    started_at: float | None = None,
    duration: float = 0.5,
    tolerance: float = 0.01,
) -> Simulation:
    """Run the program on a machine without offset, friction and mounts.

    `equation_64` gives the second piston the acceleration that is printed there, which is that of
    the first one; the program has it right.
    """
    radius, length = float(machine.crank_radius), float(machine.rod_length)
    mass, offset = machine.reciprocating_mass, machine.crank_angle_offset
    rotor, shell_alone = float(machine.rotor_inertia), float(machine.shell_inertia)
    synchronous = float(drive.synchronous_speed)

    def rates(angle: float, w: float, s: float) -> tuple[float, ...]:
        """Accelerations of shell and rotor, torques of motor and gas, inertia of the shell."""
        own = angle + offset
        r, r1, r2, rod = piston_path(own, radius, length)
        lean = radius * np.sin(own) / rod
        exact = r1
        if truncated:
            ratio = radius / length
            r1 = -radius * (np.sin(own) + 0.5 * ratio * np.sin(2.0 * own))
            r2 = -radius * (np.cos(own) + ratio * np.cos(2.0 * own))
        velocity = r1
        if equation_64:
            r1, r2 = r1[[0, 0]], r2[[0, 0]]
        gas = np.array(
            [
                scale * float(force_at(curve, np.asarray(a)))
                for curve, a, scale in zip(drive.gas, own, machine.gas_scale, strict=True)
            ]
        )
        torque = float(machine.motor_scale * slip_torque(drive.motor, np.asarray(
            synchronous - w)).value)  # fmt: skip
        shell = shell_alone + float(mass @ (r * r))
        # along the cylinder: force of the rod without what the crank's acceleration adds
        push = mass * (r2 * w * w - r * s * s) + gas
        matrix = np.array(
            [
                [shell - (mass * r * lean) @ r1, (mass * r * lean) @ r1],
                [-(mass * exact) @ r1, rotor + (mass * exact) @ r1],
            ]
        )
        known = np.array(
            [
                -torque - 2.0 * s * w * (mass @ (r * velocity)) - (r * lean) @ push,
                torque - exact @ push,
            ]
        )
        found = np.linalg.solve(matrix, known)
        return float(found[0]), float(found[1]), torque, -float(exact @ gas), shell

    angle = [0.0, 0.0]
    speed = [0.0, rounded(synchronous if started_at is None else started_at)]
    crossings: list[int] = []
    rows: list[tuple[float, ...]] = []
    analysed, momentum = None, 0.0
    for count in range(round(duration / step) + 1):
        between, w = angle[1] - angle[0], speed[1] - speed[0]
        a_shell, a_rotor, torque, gas, inertia = rates(between % TURN, w, speed[0])
        now = speed[0] * inertia + speed[1] * rotor
        momentum = momentum if count else now
        if between > TURN * (len(crossings) + 1):
            crossings.append(count)
            if analysed is not None:
                break
            if len(crossings) > 1:
                last, before = np.diff([0, *crossings])[:-3:-1]
                analysed = count if abs(last / before - 1.0) <= tolerance else None
        if analysed is not None:
            rows.append((a_shell, w, torque, gas))
        angle = [rounded(x + rounded(step * v)) for x, v in zip(angle, speed, strict=True)]
        speed = [
            rounded(v + rounded(step * rounded(a)))
            for v, a in zip(speed, (a_shell, a_rotor), strict=True)
        ]
    else:
        raise ArithmeticError("not stable within the time of the program")
    steps = np.diff([0, *crossings]).tolist()
    values, w, torque, gas = np.array(rows).T
    order = np.arange(1, orders + 1)
    phase = TURN * order[:, None] * np.arange(len(values)) / steps[-2]
    cosine = np.cos(phase) @ values * 2.0 / steps[-1]
    sine = np.sin(phase) @ values * 2.0 / steps[-1]
    return Simulation(
        20.0 * np.log10(np.hypot(cosine, sine)),
        np.arctan2(sine, cosine) % TURN,
        1.0 / (steps[-1] * step),
        100.0 * (momentum - now) / momentum,
        steps,
        w,
        torque,
        gas,
    )
