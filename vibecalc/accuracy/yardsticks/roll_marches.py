"""Marches of the roll machine that a user would write, each analysed over its last turn."""

from math import cos, pi, sin

import numpy as np

from vibecalc.accuracy.topic import Answer
from vibecalc.accuracy.yardsticks.integrators import march_scipy
from vibecalc.accuracy.yardsticks.roll_setup import RollSetup, spectrum
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.march import march_to_repeat
from vibecalc.response.roll.march_scalar import running
from vibecalc.response.roll.torques import smooth_angles
from vibecalc.response.roll.turn import Turn

_TURN = 2.0 * pi
#: turns of the published program
_PUBLISHED_TURNS = 3
#: Gauss points between the nodes of the gas tables at which an adaptive march is read
_READ = 6
_READ_PANEL = pi / 36.0


def fixed_steps(setup: RollSetup, method: str, step: float) -> Answer:
    """ "euler" or "rk4" at a step in s until all has faded, its last turn analysed once."""
    found = march_to_repeat(
        setup.alone, setup.drive, method, started_at=setup.speed,
        shell_speed=setup.shell_speed, step=step, turns=setup.turns,
    )  # fmt: skip
    fields = found.turn._asdict().items()
    turn = Turn(**{name: np.asarray(part)[None] for name, part in fields if part is not None})
    values = spectrum(setup, turn, found.shell_acceleration[None])
    return Answer(values, float(found.evaluations))


def as_published(setup: RollSetup, step: float) -> Answer:
    """Euler's rule for three turns, two integrals for each order in step with it.

    Window and phase are those of Herold (1977), appendix A: the integrals of the last turn begin
    and end with whole steps, and their phase counts with the period of the turn before.
    """
    rates = running(setup.alone, setup.drive)
    b, w, theta, s, clock = 0.0, setup.speed, 0.0, setup.shell_speed, 0.0
    begun, period, turns, steps = 0.0, 1.0, 0, 0
    orders = setup.orders.astype(int).tolist()
    cosines, sines = [0.0] * len(orders), [0.0] * len(orders)
    while True:
        if b >= _TURN * (turns + 1):
            turns += 1
            period, begun = clock - begun, clock
            if turns == _PUBLISHED_TURNS:
                break
            cosines, sines = [0.0] * len(orders), [0.0] * len(orders)
        crank, shell = rates(b, w, theta, s)
        phase = _TURN * (clock - begun) / period
        for place, order in enumerate(orders):
            cosines[place] += step * shell * cos(order * phase)
            sines[place] += step * shell * sin(order * phase)
        b += step * w
        theta += step * s
        w += step * crank
        s += step * shell
        clock += step
        steps += 1
    values = (np.array(cosines) - 1j * np.array(sines)) * (2.0 / period)
    return Answer(values, float(steps))


def adaptive(setup: RollSetup, method: str, rtol: float) -> Answer:
    """An integrator of scipy over the crank angle until all has faded, read at Gauss points.

    The step is the integrator's own; it knows of no kink.
    """
    rates = running(setup.alone, setup.drive)

    def by_angle(angle: float, state: FloatArray) -> FloatArray:
        _, w, theta, s = state.tolist()
        if not w > 0.0:
            raise NumericalFailure("the crank comes to a standstill on the way")
        crank, shell = rates(angle, w, theta, s)
        return np.asarray(np.array([1.0, crank, s, shell]) / w)

    edges, rule = smooth_angles(setup.machine, setup.drive, _READ_PANEL), gauss_rule(_READ)
    widths = np.diff(edges)[:, None]
    own = (edges[:-1, None] + widths * rule.nodes).ravel()
    weight = (widths * rule.weights).ravel()
    last = _TURN * (setup.turns - 1)
    size = np.array([_TURN / setup.speed, setup.speed, 1e-2, 1.0])
    start = np.array([0.0, setup.speed, 0.0, setup.shell_speed])
    times = np.concatenate([[0.0, last], last + own, [last + _TURN]])
    found = march_scipy(by_angle, start, times, rtol, rtol * size, method)
    first, inner, end = found.states[1], found.states[2:-1], found.states[-1]
    turn = Turn(
        own[None], weight[None], (inner[:, 0] - first[0])[None], inner[None, :, 1],
        inner[None, :, 3], inner[None, :, 2], np.array([end[0] - first[0]]),
    )  # fmt: skip
    # by the speed, which is smoother where the motor's curve has a kink than the acceleration
    values = spectrum(setup, turn, turn.shell_speed)
    rate = 1j * setup.orders * _TURN / turn.period
    return Answer(rate * values, float(found.evaluations))
