"""The machine in plain floats, with gas forces that are polynomials between their kinks."""

from bisect import bisect_right
from collections.abc import Callable
from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.roll.mechanism import RollDrive, RollMachine, gas_forces, smooth_angles

# ----------------------------------------------------------------------------
# The gas forces of a turn as one polynomial for each cylinder between neighbouring kinks.
# ----------------------------------------------------------------------------


class Slots(NamedTuple):
    """m slots of a turn, from `edge`[j] to `edge`[j + 1] (m + 1,) of the crank angle, 0 to 2 pi.

    In slot j the gas pushes piston i with sum_k coefficient[i, j, k] (angle - base[i, j])^k in N;
    `tabled` is False where harmonics make that impossible. `heading` (m, c) is the sign of d r/d b.
    """

    edge: FloatArray
    base: FloatArray
    coefficient: FloatArray
    heading: FloatArray
    tabled: bool


def slots_of(machine: RollMachine, drive: RollDrive) -> Slots:
    """Slots of one machine, between its smooth angles."""
    edge = smooth_angles(machine, drive)
    phase = machine.crank_angle_offset
    middle = 0.5 * (edge[1:] + edge[:-1])
    count, cylinders = len(middle), len(drive.gas)
    degree = max([1, *(gas.coefficient.shape[1] for gas in drive.gas if gas is not None)])
    base, coefficient = np.zeros((cylinders, count)), np.zeros((cylinders, count, degree))
    for place, gas in enumerate(drive.gas):
        if gas is None or not len(gas.node):
            continue
        angle = np.mod(middle + phase[place], TURN)
        row = np.searchsorted(gas.node, angle, side="right") - 1
        away = angle - gas.node[row] + np.where(row < 0, TURN, 0.0)
        base[place] = middle - away
        scaled = machine.gas_scale[place] * gas.coefficient[row]
        coefficient[place, :, : scaled.shape[1]] = scaled
    train = (machine.crank_radius, machine.rod_length, machine.wrist_pin_offset)
    moved = piston_path(middle[:, None] + phase, *train)
    tabled = all(gas is None or len(gas.node) > 0 for gas in drive.gas)
    return Slots(edge, base, coefficient, np.sign(moved.velocity), tabled)


def forces_in(
    machine: RollMachine, drive: RollDrive, slots: Slots, angle: FloatArray, number: IntArray
) -> FloatArray:
    """Gas forces (b, c) in N at the crank angles (b,) by the form of slot `number` (b,).

    `number` counts on from turn to turn; the form is continued beyond its slot.
    """
    if not slots.tabled:
        return gas_forces(machine, drive, angle)
    turn, slot = np.divmod(number, len(slots.edge) - 1)
    away = (angle - TURN * turn)[:, None] - slots.base[:, slot].T
    rows = slots.coefficient[:, slot]
    value = rows[..., -1].T
    for power in range(rows.shape[-1] - 2, -1, -1):
        value = value * away + rows[..., power].T
    return np.asarray(value)


def slot_at(slots: Slots, angle: FloatArray) -> IntArray:
    """The slots in which the crank angles (b,) lie; an edge belongs to the slot above it."""
    turn = np.floor(angle / TURN)
    slot = np.searchsorted(slots.edge, angle - TURN * turn, side="right") - 1
    count = len(slots.edge) - 1
    return (turn.astype(np.int64) * count + np.clip(slot, 0, count - 1)).astype(np.int64)


# ----------------------------------------------------------------------------
# The machine in plain floats, for methods that take one step of one machine at a time.
# ----------------------------------------------------------------------------


class ActingTorques(NamedTuple):
    """Accelerations in rad/s^2 (crank against shell, shell) and torques in N m; floats.

    `motor`, `gas`, `viscous` and `dry` act on the crankshaft, `mounts` on the shell. `dry` is the
    full size of dry friction; `holding` the torque that would hold the crank still on the shell.
    """

    crank: float
    shell: float
    motor: float
    gas: float
    viscous: float
    dry: float
    mounts: float
    shell_inertia: float
    holding: float


#: (angle, crank speed, shell angle, shell speed, slot, interval of the motor's curve, direction,
#: load)
ActingAt = Callable[[float, float, float, float, int, int, int, float], ActingTorques]


def acting_at(machine: RollMachine, drive: RollDrive, slots: Slots) -> ActingAt:
    """What acts on the machine in given smooth intervals, as `start_up_system` has them.

    Without direction (0) the speed of the crank is taken as zero and `dry` is not applied.
    """
    radius, length, offset = _numbers(machine, "crank_radius", "rod_length", "wrist_pin_offset")
    rotor, housing = _numbers(machine, "rotor_inertia", "shell_inertia")
    stiffness, damping = _numbers(machine, "shell_stiffness", "shell_damping")
    dry_torque, viscous_torque = _numbers(machine, "friction_torque", "friction_damping")
    piston, scale = _numbers(machine, "piston_friction", "motor_scale")
    synchronous = float(drive.synchronous_speed)
    curve = _polynomials(drive.motor.base, drive.motor.coefficient)
    count = len(slots.edge) - 1
    heading = slots.heading.tolist()
    bent = bool(np.any(machine.wrist_pin_offset) or np.any(machine.rod_inertia_difference))
    rubbed = bool(np.any(machine.piston_friction))
    cylinders = [
        (
            float(machine.crank_angle_offset[i]),
            float(machine.reciprocating_mass[i]),
            float(machine.rod_inertia_difference[i]),
            _polynomials(slots.base[i], slots.coefficient[i]),
            i,
        )
        for i in range(len(drive.gas))
    ]

    def acting(
        b: float,
        w: float,
        theta: float,
        s: float,
        number: int,
        part: int,
        direction: int,
        load: float,
    ) -> ActingTorques:
        turn, slot = divmod(number, count)
        local = b - TURN * turn
        # half of the slopes of J and Q, as the sums leave them
        j = j_b = n = n_b = q = q_b = gas = strokes = 0.0
        pushes = None if slots.tabled else forces_in(machine, drive, slots, np.array([b]), _NONE)[0]
        for phase, mass, extra, force, i in cylinders:
            a = local + phase
            high, lever = radius * sin(a), radius * cos(a)
            across = high - offset
            square = (length - across) * (length + across)
            rod = sqrt(square)
            pull = across / rod
            r, r_b = lever + rod, -high - lever * pull
            swing = lever * length
            r_bb = high * pull - lever - swing * swing / (square * rod)
            moving = mass * r_b
            j += mass * r * r
            j_b += moving * r
            q += moving * r_b
            q_b += moving * r_bb
            if bent:
                j += mass * offset * offset + extra
                bend, bends = -lever / rod, high / rod - across * lever * lever / (square * rod)
                n += extra * bend - offset * moving
                n_b += extra * bends - mass * offset * r_bb
                q += extra * bend * bend
                q_b += extra * bend * bends
            if rubbed:
                strokes += heading[slot][i] * r_b
            if pushes is None:
                base, rows = force[slot]
                away, push = local - base, 0.0
                for entry in rows:
                    push = push * away + entry
            else:
                push = pushes[i]
            gas -= push * r_b
        gas *= load
        motor = scale * _value(curve[part], synchronous - w)
        viscous = -viscous_torque * w
        dry = dry_torque + piston * strokes
        mounts = -stiffness * theta - damping * s
        j += housing
        total = rotor * (j + q - 2.0 * n) + j * q - n * n
        j, n, q = j + rotor, n + rotor, q + rotor
        outer = mounts - 2.0 * j_b * w * s - n_b * w * w
        inner = motor + gas + viscous - direction * dry + j_b * s * s - q_b * w * w
        return ActingTorques(
            (j * inner - n * outer) / total,
            (q * outer - n * inner) / total,
            motor,
            gas,
            viscous,
            dry,
            mounts,
            j,
            n * mounts / j - j_b * s * s - motor - gas,
        )

    return acting


def running(
    machine: RollMachine, drive: RollDrive
) -> Callable[[float, float, float, float], tuple[float, float]]:
    """Accelerations (crank against shell, shell) from angle, speed, shell's angle and speed.

    For a crank that turns forward; where it does not, or the slip leaves a table that is not
    continued, NumericalFailure.
    """
    slots = slots_of(machine, drive)
    acting = acting_at(machine, drive, slots)
    edge = slots.edge.tolist()[1:-1]
    threshold = drive.motor.threshold.tolist()
    synchronous = float(drive.synchronous_speed)
    last = len(threshold)

    def interval(w: float) -> int:
        slip = synchronous - w
        part = bisect_right(threshold, slip)
        if w <= 0.0:
            raise NumericalFailure("the crank comes to a standstill: the motor cannot turn it over")
        if last and not drive.holds and (part == 0 or part == last) and slip != threshold[-1]:
            raise NumericalFailure(
                f"slip {slip:.6g} rad/s is beyond the last of the motor's table, "
                f"{drive.motor.largest:.6g} rad/s"
            )
        return part

    def rates(b: float, w: float, theta: float, s: float) -> tuple[float, float]:
        turn, local = divmod(b, TURN)
        number = int(turn) * (len(edge) + 1) + bisect_right(edge, local)
        forces = acting(b, w, theta, s, number, interval(w), 1, 1.0)
        return forces.crank, forces.shell

    return rates


_NONE = np.zeros(1, dtype=np.int64)


def _numbers(machine: RollMachine, *names: str) -> list[float]:
    return [float(getattr(machine, name)) for name in names]


def _polynomials(base: np.ndarray, rows: np.ndarray) -> list[tuple[float, list[float]]]:
    """Base and coefficients of each piece, the highest power first and zeros left out."""
    while rows.shape[1] > 1 and not np.any(rows[:, -1]):
        rows = rows[:, :-1]
    return list(zip(base.tolist(), rows[:, ::-1].tolist(), strict=True))


def _value(polynomial: tuple[float, list[float]], where: float) -> float:
    base, rows = polynomial
    away, value = where - base, 0.0
    for entry in rows:
        value = value * away + entry
    return value
