"""A piston with play in its wrist pin as a plain system of two states, for integrators."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.integrators import Rates
from vibecalc.errors import NumericalFailure
from vibecalc.response.impact.linkage import Linkage


class Play(NamedTuple):
    """One gap: rates of (gap, velocity), with the side given or found; lengths in m.

    `rates_on(side)` keeps the law of one side (-1 below, 0 free, 1 above the clearance), however
    far the gap goes; `rates` takes it from the gap.
    """

    clearance: float
    contact: float
    rates: Rates
    rates_on: Callable[[int], Rates]


def play_of(linkage: Linkage, clearance: float) -> Play:
    """The wrist pin of a linkage that has no other play.

    Raises NumericalFailure for a linkage with more than one gap.
    """
    if linkage.crank_pin is not None or linkage.bore is not None:
        raise NumericalFailure("this plain system has one gap only")
    drive, joint, mass = linkage.drive, linkage.wrist_pin, float(linkage.mass)
    stiffness = float(joint.stiffness)
    in_contact, in_film = float(joint.contact_damping), float(joint.film_damping)
    rest = clearance if joint.law == "continuous" else 0.0
    strength = -np.square(drive.orders * drive.speed) * drive.displacement
    turning = 1j * drive.orders * drive.speed
    angle, force = np.asarray(linkage.gas.angle), np.asarray(linkage.gas.force)

    def acceleration(time: float, gap: float, velocity: float, side: int) -> float:
        pin = float((strength @ np.exp(turning * time)).real)
        turned = (drive.speed * time) % (2.0 * math.pi)
        gas = float(np.interp(turned, angle, force, period=2.0 * math.pi)) if force.size else 0.0
        if side == 0:
            own = in_film * velocity
        else:
            own = stiffness * (gap - (rest if side > 0 else 0.0)) + in_contact * velocity
        return pin - (own + gas) / mass

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        gap, velocity = float(state[0]), float(state[1])
        side = (gap > clearance) - (gap < 0.0)
        return np.array([velocity, acceleration(time, gap, velocity, side)])

    def rates_on(side: int) -> Rates:
        def on_side(time: float, state: np.ndarray) -> np.ndarray:
            gap, velocity = float(state[0]), float(state[1])
            return np.array([velocity, acceleration(time, gap, velocity, side)])

        return on_side

    return Play(clearance, math.pi * math.sqrt(mass / stiffness), rates, rates_on)


def by_events(
    play: Play, start: np.ndarray, times: np.ndarray, rtol: float, kinks: np.ndarray
) -> tuple[np.ndarray, int]:
    """Gap (k,) at `times` (k,), from contact to contact with the events of scipy's DOP853.

    Steps end at the `kinks` (s) of the gas force and stay below a fifth of a contact, without
    which contacts are passed over. Also evaluations of the right-hand side.

    Raises
    ------
    NumericalFailure
        scipy gives up.
    """
    from scipy.integrate import solve_ivp

    stops = np.append(kinks[(kinks > 0.0) & (kinks < times[-1])], times[-1])
    now, state = 0.0, start.astype(float)
    side = int(state[0] > play.clearance) - int(state[0] < 0.0)
    found, evaluations = np.full(len(times), np.nan), 0
    while now < times[-1]:
        faces = {1: [(play.clearance, -1)], -1: [(0.0, 1)]}.get(
            side, [(play.clearance, 1), (0.0, -1)]
        )
        answer = solve_ivp(
            play.rates_on(side),
            (now, float(stops[stops > now][0])),
            state,
            method="DOP853",
            rtol=rtol,
            atol=rtol * np.array([1e-3 * play.clearance, 1e-3 * play.clearance / play.contact]),
            events=[_crossing(*face) for face in faces],
            max_step=play.contact / 5.0,
            dense_output=True,
        )
        if not answer.success:
            raise NumericalFailure(f"DOP853 with events gave up: {answer.message}")
        evaluations += int(answer.nfev)
        then = float(answer.t[-1])
        here = (times > now) & (times <= then)
        if np.any(here):
            found[here] = answer.sol(times[here])[0]
        now, state = then, answer.y[:, -1].copy()
        if answer.status == 1:
            hit = next(k for k, each in enumerate(answer.t_events) if len(each))
            state[0], way = faces[hit]
            side += way
    return found, evaluations


def _crossing(face: float, way: int) -> Callable[[float, np.ndarray], float]:
    def crosses(time: float, state: np.ndarray) -> float:
        return float(state[0] - face)

    crosses.terminal, crosses.direction = True, way  # type: ignore[attr-defined]
    return crosses
