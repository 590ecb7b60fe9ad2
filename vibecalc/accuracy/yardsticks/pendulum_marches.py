"""A pendulum on a rotor by time integration and by plain sums, as yardsticks of its kernels."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.integrators import march_scipy
from vibecalc.errors import NumericalFailure
from vibecalc.response.pendulum.model import Pendulum, terms
from vibecalc.response.pendulum.order import tuning_order

#: relative step of the slopes of the shooting, and change at which it has arrived
_ASIDE, _ARRIVED = 1e-6, 1e-12
_MOST_SHOTS = 12


class Shot(NamedTuple):
    """Torque over the square of the mean rotor speed (kg m^2), and right-hand sides evaluated."""

    torque: float
    evaluations: int


def free_swing(pendulum: Pendulum, largest: float, rtol: float) -> tuple[float, int]:
    """Order of free swings of +-`largest` (rad), by DOP853 from rest to the vertex.

    Constant rotor speed. Returns the order and the evaluations of the right-hand side.
    """
    from scipy.integrate import solve_ivp

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        at = terms(pendulum, state[0])
        pull = 0.5 * at.carried_slope - 0.5 * at.swing_slope * state[1] ** 2
        return np.array([state[1], pull / at.swing])

    def vertex(_: float, state: np.ndarray) -> float:
        return float(state[0])

    vertex.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        rates, (0.0, 1e3), np.array([largest, 0.0]), method="DOP853", rtol=rtol,
        atol=0.1 * rtol, events=vertex,
    )  # fmt: skip
    if found.status != 1:
        raise NumericalFailure("the pendulum does not come back to the vertex")
    return 0.5 * math.pi / float(found.t_events[0][0]), int(found.nfev)


def summed_swing(pendulum: Pendulum, largest: float, points: int, turned: bool) -> float:
    """The same from the integral of energy with equal steps: in u of p = P sin u, or in p itself.

    The fall A(p) - A(P) is taken as the difference it is. In p the integrand has no bound at P.
    """
    share = (np.arange(points) + 0.5) / points
    around = 0.5 * np.pi * share
    angle = largest * (np.sin(around) if turned else share)
    at, end = terms(pendulum, angle), terms(pendulum, np.asarray(largest))
    fall = at.carried - end.carried
    if np.any(fall <= 0.0):
        raise NumericalFailure("rounding of the difference leaves no fall near the end of a swing")
    slowness = np.sqrt(at.swing / fall)
    if turned:
        return 1.0 / float(np.mean(slowness * largest * np.cos(around)))
    return 0.5 * math.pi / (largest * float(np.mean(slowness)))


def small_torque(pendulum: Pendulum, rotor: float, order: float, first: float) -> float:
    """Torque over the square of the speed that small swings of amplitude `first` balance."""
    rest = terms(pendulum, np.zeros(()))
    carried = rotor + float(rest.carried)
    tuned = float(tuning_order(pendulum).value)
    stiff = float(rest.swing) * (tuned**2 - order**2)
    stiff += (order * float(rest.coupling)) ** 2 / carried
    return -first * stiff * carried / float(rest.coupling)


def shot(pendulum: Pendulum, rotor: float, order: float, first: float, rtol: float) -> Shot:
    """The steady motion with a first sine `first` (rad), by shooting over half a cycle with DOP853.

    Unknown are the swing speed at T = 0 and the torque; the swing ends at 0 with that first sine.
    Raises NumericalFailure where Newton's method does not arrive.
    """
    carried = rotor + float(terms(pendulum, np.zeros(())).carried)
    unknown = np.array(
        [order * first, small_torque(pendulum, rotor, order, first) / carried**2], dtype=float
    )
    evaluations = 0

    def miss(at: np.ndarray) -> tuple[np.ndarray, float]:
        nonlocal evaluations
        end, used = _half_cycle(pendulum, rotor, order, at, rtol)
        evaluations += used
        mean = math.pi / order / float(end[4])
        return np.array([end[0], 2.0 / math.pi * end[3] - first]), float(at[1]) / mean**2

    arrived = max(_ARRIVED, 0.1 * rtol)
    for _ in range(_MOST_SHOTS):
        gap, torque = miss(unknown)
        if float(np.max(np.abs(gap))) <= arrived * abs(first):
            return Shot(torque, evaluations)
        steps = _ASIDE * np.maximum(np.abs(unknown), 1e-9)
        moved = [miss(unknown + step * np.eye(2)[i])[0] for i, step in enumerate(steps)]
        slope = np.stack([(one - gap) / step for one, step in zip(moved, steps, strict=True)], -1)
        unknown = unknown - np.linalg.solve(slope, gap)
    raise NumericalFailure("the shooting for a steady motion of the pendulum does not arrive")


def _half_cycle(
    pendulum: Pendulum, rotor: float, order: float, unknown: np.ndarray, rtol: float
) -> tuple[np.ndarray, int]:
    """Swing, its slope by T, ln y, integral of p sin, time: at n T = pi, with y M^2 = 1 at 0."""
    speed, torque = unknown
    rest = terms(pendulum, np.zeros(()))
    start_moved = rotor + float(rest.carried) + float(rest.coupling) * speed

    def rates(place: float, state: np.ndarray) -> np.ndarray:
        swing, slope, level = state[0], state[1], state[2]
        at = terms(pendulum, swing)
        moved = rotor + at.carried + at.coupling * slope
        sine = math.sin(place)
        driven = torque * sine / (moved * math.exp(level))
        lost = (at.carried_slope + at.coupling_slope * slope) * slope / moved
        link = at.coupling + at.swing * slope
        pull = 0.5 * at.carried_slope - 0.5 * at.swing_slope * slope * slope
        bend = (pull - (driven - lost) * link) / (at.swing - at.coupling * link / moved)
        half_rate = driven - lost - at.coupling * bend / moved
        time = math.exp(-0.5 * level)
        return np.array([slope, bend, 2.0 * half_rate, swing * sine * order, time]) / order

    start = np.array([0.0, speed, -2.0 * math.log(start_moved), 0.0, 0.0])
    span = np.array([0.0, math.pi])
    found = march_scipy(rates, start, span, rtol, atol=0.1 * rtol)
    return found.states[-1], found.evaluations
