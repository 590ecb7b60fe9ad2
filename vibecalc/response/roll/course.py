"""A turn at any crank angle: from collocation polynomials exactly, from samples by cubics."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.periodic.panels import evaluate, running_integral
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.roll.dynamic_rates import driving_torque
from vibecalc.response.roll.inertia import inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine, is_mounted
from vibecalc.response.roll.steady import Steady
from vibecalc.response.roll.turn import Turn

#: the motion of one machine (B = 1) at crank angles (k,) that ascend within one turn
Course = Callable[[FloatArray], Turn]
_FULL = 2.0 * np.pi
#: points that are nearer to each other, over their mean distance, count as one
_NEAR = 0.05


def course_of_state(machine: RollMachine, drive: RollDrive, state: Steady) -> Course:
    """The motion between the collocation points; its error is that of the points or little more.

    The angle of a free shell is interpolated from the points.
    """
    found = state.solution
    passed, ends = running_integral(found.edges, 1.0 / found.stages[..., 0])
    clock = found._replace(left=ends[:, :-1, None], stages=passed[..., None])

    def at(angles: FloatArray) -> Turn:
        values = evaluate(state.solution, angles)
        torque = driving_torque(machine, drive, values)
        time = evaluate(clock, angles)[..., 0]
        loose = _sampled(state.turn, angles)._replace(motor_torque=torque, time=time)
        if is_mounted(machine):
            return loose._replace(
                crank_speed=values[..., 0], shell_angle=values[..., 1], shell_speed=values[..., 2]
            )
        moved = inertia(machine, angles[None])
        speed = values[..., 0]
        shell = (state.momentum[:, None] - moved.coupling * speed) / moved.shell
        return loose._replace(crank_speed=speed, shell_speed=shell)

    return at


def speed_of_state(state: Steady) -> Callable[[FloatArray], FloatArray]:
    """Crank speed (k,) of one machine (B = 1) at crank angles (k,), without all the rest."""
    return lambda angles: np.asarray(evaluate(state.solution, angles)[0, :, 0])


def course_of_turn(turn: Turn) -> Course:
    """The motion between samples, by the cubic through four neighbours."""
    return lambda angles: _sampled(turn, angles)


def _sampled(turn: Turn, angles: FloatArray) -> Turn:
    own = turn.crank_angle[0]
    keep = _apart(own)
    grown = float(np.sum(turn.weight * turn.shell_speed / turn.crank_speed))
    found = {
        name: _cubic(own[keep], getattr(turn, name)[0][keep], per_turn, angles)[None]
        for name, per_turn in (
            ("time", float(turn.period[0])),
            ("crank_speed", 0.0),
            ("shell_speed", 0.0),
            ("shell_angle", grown),
        )
    }
    step = np.diff(angles)
    weight = np.zeros(len(angles))
    weight[:-1] += 0.5 * step
    weight[1:] += 0.5 * step
    return Turn(angles[None], weight[None], period=turn.period, **found)


def _apart(angles: FloatArray) -> BoolArray:
    """Which of the ascending angles (k,) to keep, so that no two of the turn nearly coincide.

    A march has the end of its turn beside its start, and steps may fall next to both. Differences
    of such values are nothing but errors, which a cubic would blow up.
    """
    least = _NEAR * _FULL / len(angles)
    keep = np.zeros(len(angles), dtype=bool)
    last, end = -np.inf, float(angles[0]) + _FULL - least
    for place, angle in enumerate(angles.tolist()):
        if angle - last > least and angle <= end:
            keep[place], last = True, angle
    return keep


def _cubic(known: FloatArray, values: FloatArray, per_turn: float, at: FloatArray) -> FloatArray:
    """Cubic through the four nearest points; values grow by `per_turn` from turn to turn."""
    reach = 3
    x = np.concatenate([known[-reach:] - _FULL, known, known[:reach] + _FULL])
    y = np.concatenate([values[-reach:] - per_turn, values, values[:reach] + per_turn])
    place = np.clip(np.searchsorted(x, at, side="right") - 2, 0, len(x) - 4)
    index = place[:, None] + np.arange(4)
    nodes, data = x[index], y[index]
    basis = np.ones_like(nodes)
    for i in range(4):
        for j in range(4):
            if i != j:
                basis[:, i] *= (at - nodes[:, j]) / (nodes[:, i] - nodes[:, j])
    return np.asarray(np.sum(basis * data, axis=1))
