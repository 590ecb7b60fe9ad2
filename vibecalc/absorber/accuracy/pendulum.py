"""Accuracy of pendulums: order at a large swing, torque that holds a swing."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.absorber.pendulum_order import (
    Pendulum,
    PendulumParts,
    build_pendulum,
    detuning_coefficient,
    order_of_swing,
    terms,
    tuning_order,
)
from vibecalc.absorber.pendulum_steady import steady_motion
from vibecalc.core.accuracy.other_integrators import march_scipy
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# A pendulum on a rotor by time integration and by plain sums, as yardsticks of its kernels.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Topics of the stage "pendulum": its order while it swings far, the torque that holds a swing.
# ----------------------------------------------------------------------------

_STAGE = "pendulum"
#: swings of the case that take part, spread over it
_SWINGS = 4
#: points of the Gauss rule inside, and of the two sums that the order of a swing takes at least
_INNER, _SUMS = 20, (16, 32)
#: stages that lead up to a steady motion, and steps of Newton's method in each, as a rule
_STAGES, _STEPS = 6, 4
#: harmonics that a steady motion is computed with
_HARMONICS = 24
#: what a steady motion takes over shooting that is as accurate
_EXTRA_STEADY = 8.0
_WHY_ORDER = (
    "no difference of like numbers at the end of any path, and half the points for the error"
)
_WHY_STEADY = (
    "led up in six stages, since a motion may fold back, with slopes in all directions, and solved "
    "again with half as many harmonics more for the error; all points at once"
)


def absorber_pendulum_topics(scene: Scene) -> list[Topic]:
    """Order of swings for any path; torque of a steady swing for a rotor that is free."""
    parts = build_pendulum(scene.case)
    swings = parts.swings[parts.swings > 0.0]
    if not len(swings):
        return []
    made = [_order_topic(parts, _spread(swings))]
    steady = scene.record.quantities.get("pendulum/steady/torque")
    if steady is not None and steady.values.size > 1:
        held = np.asarray(steady.axes[0].values, dtype=float)
        made.append(_steady_topic(parts, float(held[len(held) // 2])))
    return made


def _spread(swings: np.ndarray) -> np.ndarray:
    chosen = np.linspace(0, len(swings) - 1, min(_SWINGS, len(swings))).round().astype(int)
    return np.asarray(swings[chosen], dtype=float)


def _order_topic(parts: PendulumParts, swings: np.ndarray) -> Topic:
    pendulum = parts.pendulum
    circle = float(np.asarray(pendulum.path_exponent)) == 0.0

    def each(one: Callable[[float, float], tuple[float, float]]) -> Callable[[float], Answer]:
        def solve(setting: float) -> Answer:
            found = [one(float(swing), setting) for swing in swings]
            return Answer(np.array([value for value, _ in found]), sum(work for _, work in found))

        return solve

    def own(_: float) -> Answer:
        value = order_of_swing(pendulum, swings).value
        # on a circle the order of small swings, and some square roots
        each_swing = 1 if circle else sum(_SUMS) * (_INNER + 1)
        return Answer(value, float(len(swings) * each_swing))

    def series(swing: float, _: float) -> tuple[float, float]:
        bend = float(detuning_coefficient(pendulum).value)
        return float(tuning_order(pendulum).value) * (1.0 + bend * swing**2), 1.0

    def summed(turned: bool) -> Callable[[float, float], tuple[float, float]]:
        return lambda swing, n: (summed_swing(pendulum, swing, int(n), turned), n + 1.0)

    solvers = [
        Solver("arithmetic-geometric mean", "n AGM(1, cos(P/2)), for circles", "",
               NOTHING_TO_SET, own, 1.0, "", "Gauss; docs/theory_absorber.md")
        if circle else
        Solver("midpoint rule, fall by a Gauss rule",
                   "p = P sin u, points doubled until settled", "", NOTHING_TO_SET, own, 1.0,
                   "geometric", "docs/theory_absorber.md"),
        Solver("midpoint rule in u, fall as a difference", "p = P sin u", "points",
               (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0), each(summed(True)), None, "geometric"),
        Solver("midpoint rule in the angle", "integrand without a bound at the end", "points",
               (10.0, 30.0, 100.0, 300.0, 1000.0, 10000.0), each(summed(False)), None, "order 0.5"),
        Solver("DOP853 of scipy", "from rest to the vertex", "rtol",
               (1e-3, 1e-5, 1e-7, 1e-9, 1e-11),
               each(lambda swing, rtol: free_swing(pendulum, swing, rtol))),
        Solver("small swings to second order", "n (1 + e P^2)", "", NOTHING_TO_SET,
                   each(series)),
    ]  # fmt: skip
    if circle:
        solvers.append(
            Solver("elliptic integral of scipy", "n pi / 2 K(sin(P/2)), circles only", "",
                   NOTHING_TO_SET, each(lambda swing, _: (_elliptic(pendulum, swing), 1.0)))
        )  # fmt: skip
    return Topic(
        stage=_STAGE,
        name="order of swing",
        words=f"order at {len(swings)} swings up to {np.degrees(swings[-1]):.4g} degrees",
        quantity="pendulum/order_of_swing",
        unit="",
        work="evaluations of the path and its kinetic energy",
        reference=lambda: _order_truth(pendulum, swings, circle),
        solvers=tuple(solvers),
        default_extra=1.0 if circle else 1.0 * sum(_SUMS) * (_INNER + 1),
        default_why="" if circle else _WHY_ORDER,
    )


def _elliptic(pendulum: Pendulum, swing: float) -> float:
    from scipy.special import ellipk

    whole = float(ellipk(np.sin(0.5 * swing) ** 2))
    return float(tuning_order(pendulum).value) * 0.5 * np.pi / whole


def _order_truth(pendulum: Pendulum, swings: np.ndarray, circle: bool) -> Reference:
    if not circle:
        marched = np.array([free_swing(pendulum, float(swing), 1e-13)[0] for swing in swings])
        summed = np.array([summed_swing(pendulum, float(swing), 48, True) for swing in swings])
        apart = float(np.max(np.abs(marched / summed - 1.0)))
        return Reference(summed, max(apart, UNIT_ROUNDOFF), "48 points in u; held against DOP853")
    from mpmath import mp

    with mp.workdps(34):
        values = [mp.mpf(float(np.asarray(part))) for part in pendulum]
        number = _tuned(values)
        whole = [mp.ellipk(mp.sin(mp.mpf(float(swing)) / 2) ** 2) for swing in swings]
        found = np.array([float(number * mp.pi / 2 / one) for one in whole])
    return Reference(found, UNIT_ROUNDOFF, "complete elliptic integral in 34 digits")


def _tuned(values: list[Any]) -> Any:
    """The order of small swings, as docstring of `response.pendulum.order` has it."""
    mass, far, near, _, own, rolling, across, diameter, roller_own = values
    pull = near * (mass * (far - near) + rolling * (across - near / 2) / 2)
    moved = (mass + rolling / 4 + roller_own / diameter**2) * near**2 + own
    return (pull / moved) ** 0.5


def _steady_topic(parts: PendulumParts, swing: float) -> Topic:
    pendulum, rotor, order = parts.pendulum, parts.rotor_inertia, parts.order
    square = parts.speed**2

    def own(harmonics: float) -> Answer:
        count = int(harmonics)
        found = steady_motion(pendulum, rotor, order, swing, count).torque.value
        sizes = (count, count + count // 2)
        work = sum(_STAGES * _STEPS * (1 + size) * (size + 2) for size in sizes)
        return Answer(np.atleast_1d(found) * square, float(work))

    def marched(rtol: float) -> Answer:
        found = shot(pendulum, rotor, order, swing, rtol)
        return Answer(np.array([found.torque * square]), float(found.evaluations))

    def small(_: float) -> Answer:
        return Answer(np.array([small_torque(pendulum, rotor, order, swing) * square]), 1.0)

    def reference() -> Reference:
        by_sines = steady_motion(pendulum, rotor, order, swing, 2 * _HARMONICS).torque.value
        by_time = shot(pendulum, rotor, order, swing, 1e-13).torque
        apart = abs(float(by_sines) / by_time - 1.0)
        if apart > 1e-9:
            raise NumericalFailure(f"sines and shooting are {apart:.1e} apart")
        words = f"{2 * _HARMONICS} sines; held against shooting with DOP853 at 1e-13"
        return Reference(np.atleast_1d(by_sines) * square, max(apart, UNIT_ROUNDOFF), words)

    return Topic(
        stage=_STAGE,
        name="torque of a steady swing",
        words=f"torque that holds a first sine of {np.degrees(swing):.4g} degrees, undamped",
        quantity="pendulum/steady/torque",
        unit="N*m",
        work="evaluations of the equations of motion at one angle",
        reference=reference,
        solvers=(
            Solver("sines by collocation", "Newton's method with slopes by complex steps",
                       "sines", (2.0, 4.0, 8.0, 12.0, 16.0, 24.0), own, float(_HARMONICS),
                       "geometric",
                   "docs/theory_absorber.md"),
            Solver("shooting with DOP853 of scipy", "over half a cycle", "rtol",
                   (1e-4, 1e-6, 1e-8, 1e-10), marched),
            Solver("small swings", "equations linear in the swing", "", NOTHING_TO_SET, small),
        ),
        default_extra=_EXTRA_STEADY,
        default_why=_WHY_STEADY,
    )  # fmt: skip
