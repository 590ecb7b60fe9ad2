"""A start-up followed by scipy from kink to kink: the reference of the march in steps of order 5.

DOP853 integrates each smooth piece; events of its own stop it at nodes of the gas tables, at those
of the motor's curve and where the load changes. Equations are those in plain floats.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.march_scalar import Acting, in_pieces
from vibecalc.response.roll.start_up_slots import edges_around, slot_at, slots_of
from vibecalc.response.roll.start_up_states import Load

#: of DOP853; pieces after which the march counts as lost
_RTOL, _MOST_PIECES = 1e-13, 5000
#: speed over the synchronous one at which a crank with dry friction is at rest
_REST = 1e-10
#: looks at the shell's acceleration within each piece
_LOOKS = 24


class StartPlan(NamedTuple):
    """One machine from `start` (crank angle, crank speed, shell angle, shell speed) for `end` s."""

    machine: RollMachine
    drive: RollDrive
    load: Load
    start: FloatArray
    end: float


class Followed(NamedTuple):
    """State (4,) at the end; largest shell acceleration with its time; evaluations."""

    state: FloatArray
    peak: float
    peak_time: float
    evaluations: int


def follow(plan: StartPlan) -> Followed:
    """March of a crank that turns forward, or without dry friction either way.

    Raises NumericalFailure where a crank with dry friction comes to rest, which is not followed.
    """
    from scipy.integrate import solve_ivp

    slots = slots_of(plan.machine, plan.drive)
    acting = in_pieces(plan.machine, plan.drive, slots)
    nodes = np.concatenate([[-np.inf], plan.drive.motor.threshold, [np.inf]])
    synchronous = float(plan.drive.synchronous_speed)
    stops = [float(t) for t in plan.load.time[1:] if t < plan.end] + [plan.end]
    time, state, evaluations = 0.0, plan.start.astype(float), 0
    slot = int(slot_at(slots, state[:1])[0])
    part = int(np.searchsorted(nodes[1:-1], synchronous - state[1], side="right"))
    best = (-np.inf, 0.0)
    dry = _is_dry(plan.machine)
    for row, stop in enumerate(stops):
        factor = float(plan.load.factor[row])
        for _ in range(_MOST_PIECES):
            low, high = (float(edge[0]) for edge in edges_around(slots, np.array([slot])))

            def rates(_: float, y: FloatArray, slot=slot, part=part, factor=factor) -> FloatArray:  # type: ignore[no-untyped-def]
                b, w, theta, s = y.tolist()
                found = acting(b, w, theta, s, slot, part, 1, factor)
                return np.array([y[1], found.crank, y[3], found.shell])

            # the crank angle between nodes of the gas, the slip between those of the motor's curve
            events = [
                _event(0, 1.0, low, -1.0),
                _event(0, 1.0, high, 1.0),
                _event(1, -1.0, float(nodes[part]) - synchronous, -1.0),
                _event(1, -1.0, float(nodes[part + 1]) - synchronous, 1.0),
            ]
            if dry:
                events.append(_event(1, 1.0, 0.0, -1.0))
            size = np.array([1.0, synchronous, 1e-3, 1.0])
            found = solve_ivp(
                rates, (time, stop), state, "DOP853", rtol=_RTOL, atol=_RTOL * size,
                events=events, dense_output=True,
            )  # fmt: skip
            if found.status < 0:
                raise NumericalFailure(f"DOP853 gives up from kink to kink: {found.message}")
            evaluations += int(found.nfev)
            last = float(found.t[-1])
            best = max(best, _highest(found.sol, rates, time, last))
            time, state = last, found.y[:, -1]
            if found.status == 0:
                break
            which = next(k for k, times in enumerate(found.t_events) if len(times))
            # tables of motors end at standstill, so that both stops may come at once
            if dry and state[1] <= _REST * synchronous:
                raise NumericalFailure("a crank with dry friction comes to rest on the way")
            slot += (-1, 1, 0, 0)[which]
            part += (0, 0, -1, 1)[which]
        else:
            raise NumericalFailure("from kink to kink DOP853 does not come to the end")
    return Followed(state, best[0], best[1], evaluations)


def plain_rates(plan: StartPlan) -> Callable[[float, FloatArray], FloatArray]:
    """The same equations as a user writes them: every table looked up at every evaluation."""
    slots = slots_of(plan.machine, plan.drive)
    acting = in_pieces(plan.machine, plan.drive, slots)
    threshold, synchronous = plan.drive.motor.threshold, float(plan.drive.synchronous_speed)
    times, factors = plan.load.time, plan.load.factor
    edge, turn = slots.edge[1:-1], 2.0 * np.pi

    def at(time: float, y: FloatArray) -> Acting:
        b, w, theta, s = y.tolist()
        whole, local = divmod(b, turn)
        slot = int(whole) * (len(edge) + 1) + int(np.searchsorted(edge, local, side="right"))
        part = int(np.searchsorted(threshold, synchronous - w, side="right"))
        row = int(np.searchsorted(times, time, side="right")) - 1
        way = 1 if w >= 0.0 else -1
        return acting(b, w, theta, s, slot, part, way, float(factors[row]))

    def rates(time: float, y: FloatArray) -> FloatArray:
        found = at(time, y)
        return np.array([y[1], found.crank, y[3], found.shell])

    return rates


def _is_dry(machine: RollMachine) -> bool:
    return bool(machine.friction_torque > 0.0 or machine.piston_friction > 0.0)


def _event(column: int, sign: float, border: float, direction: float) -> Any:
    """Stops where `sign` times a state passes a border, rising (+1) or falling (-1)."""

    def watched(time: float, y: FloatArray) -> float:
        found = sign * float(y[column]) - border
        # a border at infinity is far away, and no root search shall multiply with it
        return float(np.clip(found, -1e9, 1e9))

    watched.terminal = True  # type: ignore[attr-defined]
    watched.direction = direction  # type: ignore[attr-defined]
    return watched


def _highest(sol: Any, rates: Any, begin: float, end: float) -> tuple[float, float]:
    """Largest shell acceleration of a piece and its time: looks, then Brent's method."""
    from scipy.optimize import minimize_scalar

    times = np.linspace(begin, end, _LOOKS)

    def shaking(time: float) -> float:
        return abs(float(rates(time, sol(time))[3]))

    values = [shaking(time) for time in times.tolist()]
    best = int(np.argmax(values))
    if best in (0, len(times) - 1) or end <= begin:
        return values[best], float(times[best])
    found = minimize_scalar(
        lambda time: -shaking(time), bounds=(times[best - 1], times[best + 1]), method="bounded",
        options={"xatol": 1e-9 * (end - begin)},
    )  # fmt: skip
    return max((values[best], float(times[best])), (-float(found.fun), float(found.x)))
