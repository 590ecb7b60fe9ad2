"""Claim: a ring on dry friction moves in time as an integration from one slip to the next says,
and its steady motion has the torque and heat of the first harmonic of the friction.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibecalc.torsion.line import Line
from vibecalc.torsion.transient.clutch import Clutch
from vibecalc.torsion.transient.friction_damper import Dragged, drag
from vibecalc.torsion.transient.motion import split, stretch

INERTIA = np.array([2.0, 0.8, 0.5])
SHAFT, LININGS, SPEED = 4e4, 3e6, 150.0
ORDER = np.array([0.0, 1.0, 2.0])


def line_of(damping: float, of_linings: float = 0.0) -> Line:
    """A flywheel, a shaft, a hub with a ring on linings."""
    none, ends = np.zeros(3), np.array([0, 1, 2])
    stiffness, dashpots = np.array([SHAFT, LININGS]), np.array([damping, of_linings])
    return Line(INERTIA, none, none, ends[:2], ends[1:], stiffness, dashpots, np.zeros(2))


def torque(time: np.ndarray | float, accelerated: float) -> np.ndarray:
    """On the hub, with the orders 1 and 2 of a speed that grows."""
    angle = SPEED * np.asarray(time) + 0.5 * accelerated * np.asarray(time) ** 2
    return 300.0 * np.cos(angle) + 200.0 * np.cos(2.0 * angle + 0.5)


def dragged(friction: float, duration: float, accelerated: float, of_linings: float) -> Dragged:
    gas = np.zeros((3, 3), dtype=complex)
    gas[1, 1:] = 300.0, 200.0 * np.exp(0.5j)
    clutch = Clutch(1, friction, 0.0, np.array([False, False, True]), 0.0)
    parts = [stretch(duration, accelerated, gas)]
    reaction = np.array([1.0, 0.0, 0.0])
    line = line_of(20.0, of_linings)
    return drag(line, ORDER, clutch, parts, SPEED, "rest", reaction, 1e-9)


def integrated(
    friction: float, duration: float, accelerated: float, of_linings: float
) -> tuple[np.ndarray, float, int]:
    """Twist of the shaft, velocities and twist of the linings at the end, heat, times it locked.

    Relative to the speed of the crank: the flywheel takes what accelerates all three.
    """
    pull = -INERTIA * accelerated
    pull[0] += INERTIA.sum() * accelerated

    def slope(time: float, x: np.ndarray, slip: int) -> np.ndarray:
        twist, one, two, ring, wound, _ = x
        shaft = SHAFT * twist + 20.0 * (one - two)
        if slip:
            rub = slip * friction
            winds = (rub - LININGS * wound) / of_linings if of_linings else 0.0
        else:
            winds = two - ring
            rub = LININGS * wound + of_linings * winds
        moved = np.array([-shaft, shaft - rub + torque(time, accelerated), rub]) + pull
        return np.array([one - two, *(moved / INERTIA), winds, rub * (two - ring - winds)])

    def holding(time: float, x: np.ndarray) -> float:
        return friction - abs(LININGS * x[4] + of_linings * (x[2] - x[3]))

    def ends(time: float, x: np.ndarray, slip: int) -> float:
        if not slip:
            return holding(time, x)
        return slip * (x[2] - x[3] - slope(time, x, slip)[4])

    time, x, slip, locked = 0.0, np.zeros(6), 0, 0
    while time < duration:
        event = lambda t, y, way=slip: ends(t, y, way)  # noqa: E731
        event.terminal, event.direction = True, -1.0
        found = solve_ivp(
            lambda t, y, way=slip: slope(t, y, way), (time, duration), x, "DOP853",
            events=event, rtol=1e-12, atol=1e-14, max_step=2e-4,
        )  # fmt: skip
        time, x = float(found.t[-1]), found.y[:, -1]
        if found.status == 1:
            if slip:
                slip, locked = 0, locked + 1
            else:
                slip = int(np.sign(LININGS * x[4] + of_linings * (x[2] - x[3])))
    return x, float(x[5]), locked


@pytest.mark.parametrize(
    ("friction", "accelerated", "of_linings"),
    [(60.0, 0.0, 0.0), (150.0, 200.0, 0.0), (150.0, 200.0, 150.0), (3000.0, 0.0, 0.0)],
)
def test_ring_moves_as_an_integration_from_slip_to_slip(
    friction: float, accelerated: float, of_linings: float
) -> None:
    found = dragged(friction, 0.15, accelerated, of_linings)
    x, heat, locked = integrated(friction, 0.15, accelerated, of_linings)
    state = found.run.states[-1][-1]
    roots = np.sqrt([SHAFT, LININGS, *INERTIA])
    seen = state[:5] / roots
    assert found.locks == locked
    assert np.allclose(seen[[0, 2, 3, 4]], x[:4], rtol=0.0, atol=1e-7 * np.abs(x[:4]).max())
    assert found.heat == pytest.approx(heat, rel=1e-7, abs=1e-9)
    assert (found.slip_time > 0.0) == (friction < 1000.0)


def test_a_stretch_goes_on_where_it_is_cut() -> None:
    gas = np.array([[0.0, 2.0 + 1.0j]])
    part = stretch(2.0, 3.0, gas, scale=(0.2, 1.0), acceleration_rate=-1.0, gas_end=3.0 * gas)
    first, rest = split(part, 10.0, 0.5)
    assert first.duration + rest.duration == part.duration
    assert rest.acceleration == 2.5 and rest.gas_end is part.gas_end
    assert first.scale_end == rest.scale_start == pytest.approx(0.4)
    # the speed goes from 10 to 14 rad/s, to 11.375 at the cut
    assert np.allclose(first.gas_end, gas * (1.0 + 2.0 * 1.375 / 4.0))
