"""The gas forces of a turn as one polynomial for each cylinder between neighbouring kinks."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.gas_tables import TURN
from vibecalc.kinematics.slider_crank import bottom_dead_centre, piston_path, top_dead_centre
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.torques import gas_forces, smooth_angles


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
    """Slots of one machine, split at table nodes and, where pistons rub, dead centres."""
    edge = smooth_angles(machine, drive)
    radius, length, offset = machine.crank_radius, machine.rod_length, machine.wrist_pin_offset
    phase = machine.crank_angle_offset
    if np.any(machine.piston_friction):
        top = float(top_dead_centre(radius, length, offset).angle)
        bottom = float(bottom_dead_centre(radius, length, offset).angle)
        centres = np.mod(np.concatenate([top - phase, bottom - phase]), TURN)
        near = np.min(np.abs(centres[:, None] - edge), axis=1) < 1e-9
        edge = np.sort(np.concatenate([edge, centres[~near]]))
        edge = edge[np.concatenate([[True], np.diff(edge) > 1e-9])]
        edge[-1] = TURN
    middle = 0.5 * (edge[1:] + edge[:-1])
    count, cylinders = len(middle), len(drive.gas)
    degree = max([1, *(gas.coefficient.shape[1] for gas in drive.gas if gas is not None)])
    base, coefficient = np.zeros((cylinders, count)), np.zeros((cylinders, count, degree))
    for place, gas in enumerate(drive.gas):
        if gas is None or not len(gas.node):
            continue
        own = np.mod(middle + phase[place], TURN)
        row = np.searchsorted(gas.node, own, side="right") - 1
        away = own - gas.node[row] + np.where(row < 0, TURN, 0.0)
        base[place] = middle - away
        scaled = machine.gas_scale[place] * gas.coefficient[row]
        coefficient[place, :, : scaled.shape[1]] = scaled
    moved = piston_path(middle[:, None] + phase, radius, length, offset)
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


def edges_around(slots: Slots, number: IntArray) -> tuple[FloatArray, FloatArray]:
    """Crank angles (b,) between which the slots `number` (b,) lie."""
    turn, slot = np.divmod(number, len(slots.edge) - 1)
    return TURN * turn + slots.edge[slot], TURN * turn + slots.edge[slot + 1]


def slot_at(slots: Slots, angle: FloatArray) -> IntArray:
    """The slots in which the crank angles (b,) lie; an edge belongs to the slot above it."""
    turn = np.floor(angle / TURN)
    slot = np.searchsorted(slots.edge, angle - TURN * turn, side="right") - 1
    count = len(slots.edge) - 1
    return (turn.astype(np.int64) * count + np.clip(slot, 0, count - 1)).astype(np.int64)
