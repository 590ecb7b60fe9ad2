"""The torque of the masses on the body, with a rotor of finite inertia: against motion in time."""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case

RADIUS, LENGTH, MASS, ROTOR = 0.05, 0.2, 2.0, 0.05
ROLL, HALF, STIFFNESS, DAMPING = 5.0, 0.4, 12_500.0, 187.5


def machine(speed: float, **excitation: Any) -> dict[str, Any]:
    """One cylinder in the middle of a symmetric body: its roll is coupled with nothing."""
    corners = [(x, y, 0.0) for x in (-0.3, 0.3) for y in (-HALF, HALF)]
    return {
        "schema": 1,
        "title": "one cylinder and its rotor",
        "machine": {
            "kind": "machine",
            "speed": speed,
            "crank_train": {
                "crank_radius": RADIUS,
                "rod_length": LENGTH,
                "reciprocating_mass": MASS,
                "cylinders": [{"name": "1"}],
            },
            "rotor": {"inertia": ROTOR},
            "body": {"mass": 100.0, "inertia": [ROLL, 8.0, 8.0]},
            "mounts": {
                "each": {"stiffness": STIFFNESS, "damping": DAMPING},
                "positions": corners,
            },
        },
        "excitation": excitation,
        "isolation": {"model": "rigid_body"},
    }


def inertia(angle: float) -> tuple[float, float]:
    """What the piston adds to the inertia at the crank, m s'^2, and half its slope."""
    sine, cosine = np.sin(angle), np.cos(angle)
    rod = np.sqrt(LENGTH**2 - (RADIUS * sine) ** 2)
    rate = -RADIUS * sine * (1.0 + RADIUS * cosine / rod)
    bend = -RADIUS * (cosine + RADIUS * (cosine**2 - sine**2) / rod)
    bend -= (RADIUS**2 * sine * cosine) ** 2 / rod**3
    return MASS * rate**2, MASS * rate * bend


def in_time() -> tuple[float, complex]:
    """Mean speed, and the second order of the roll, of crank, rotor and body let go.

    The rotor's angle is absolute, the crank turns against the body: the torque between them turns
    both, the body on its mounts.
    """
    stiffness, damping = 4.0 * STIFFNESS * HALF**2, 4.0 * DAMPING * HALF**2

    def motion(_: float, state: np.ndarray) -> list[float]:
        rotor, body, rotor_rate, body_rate = state
        moving, half_slope = inertia(rotor - body)
        rate = rotor_rate - body_rate
        held = -stiffness * body - damping * body_rate
        # torque = -(moving (a - b) + half_slope rate^2), ROTOR a = torque, ROLL b = held - torque
        away = (-half_slope * rate**2 * (1.0 / ROTOR + 1.0 / ROLL) - held / ROLL) / (
            1.0 + moving * (1.0 / ROTOR + 1.0 / ROLL)
        )
        torque = -(moving * away + half_slope * rate**2)
        return [rotor_rate, body_rate, torque / ROTOR, (held - torque) / ROLL]

    def top(_: float, state: np.ndarray) -> float:
        return float(np.sin(0.5 * (state[0] - state[1])))

    found = solve_ivp(
        motion, (0.0, 3.2), [0.0, 0.0, 100.0, 0.0], "DOP853", events=top, dense_output=True,
        rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    first, last = found.t_events[0][-11], found.t_events[0][-1]
    time = np.linspace(first, last, 20_001)[:-1]
    roll = found.sol(time)[1]
    speed = 20.0 * np.pi / (last - first)
    return speed, complex(2.0 * np.mean(roll * np.exp(-2j * speed * (time - first))))


def test_roll_of_crank_rotor_and_body_in_time() -> None:
    speed, roll = in_time()

    def second(case: dict[str, Any]) -> complex:
        record = run_case(validate(case))
        return complex(record["isolation/body/rotation_harmonics"].values[1, 0])

    found = second(machine(speed))
    # a twentieth of the torque turns the piston's own inertia; the body's motion takes 1e-3
    steady = machine(speed)
    del steady["machine"]["rotor"]
    assert abs(found / roll - 1.0) < 3e-3
    assert 0.04 < abs(second(steady) / roll - 1.0) < 0.06
    assert second(machine(speed, driven_machine="separate")) == found
    assert second(machine(speed, driven_machine="cancels_torque")) == 0.0
