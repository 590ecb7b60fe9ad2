"""A turn at any crank angle: from collocation polynomials exactly, from samples by cubics."""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.periodic_panels import evaluate, running_integral
from vibecalc.numerics.rounding import EPSILON
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


def summit(values_at: Callable[[FloatArray], FloatArray]) -> tuple[float, float]:
    """Largest value of a function of the crank angle over a turn, and what looking leaves open.

    `values_at` takes ascending angles (k,). A coarse look, then ever closer ones around its
    highest summits: beside a jump, as of friction at a dead centre, or with summits of nearly one
    height, the coarse look may take the wrong one. The error is the gain of the last look.
    """
    angles = np.linspace(0.0, _FULL, _COARSE + 1)
    values = values_at(angles)
    best, step, gain = float(np.max(values)), _FULL / _COARSE, np.inf
    places = angles[_highest(values)]
    for _ in range(_ROUNDS):
        near = np.clip(places[:, None] + step * np.linspace(-1.0, 1.0, _CLOSE), 0.0, _FULL)
        order = np.argsort(near, axis=None, kind="stable")
        found = np.empty(near.size)
        found[order] = values_at(near.ravel()[order])
        looked = found.reshape(near.shape)
        top = float(np.max(looked))
        gain, best = top - best, max(best, top)
        places = near[np.arange(len(places)), np.argmax(looked, axis=1)]
        step *= 2.0 / (_CLOSE - 1)
        # a look centred on the place found before gains nothing and proves nothing
        if abs(gain) <= EPSILON * abs(best) and step < _FULL * EPSILON**0.5:
            break
    return best, abs(gain)


def _highest(values: FloatArray) -> np.ndarray:
    """Places of the highest local maxima of samples (k,) of a turn, a few of them."""
    before, after = np.roll(values[:-1], 1), np.roll(values[:-1], -1)
    tops = np.flatnonzero((values[:-1] >= before) & (values[:-1] >= after))
    if not len(tops):
        return np.array([int(np.argmax(values))])
    return tops[np.argsort(-values[tops], kind="stable")][:_SUMMITS]


_COARSE, _CLOSE, _ROUNDS, _SUMMITS = 720, 33, 8, 4
