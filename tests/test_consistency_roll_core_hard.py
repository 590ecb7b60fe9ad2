"""Claim: running states of awkward machines are those of an independent integration, to 1e-9 dB."""

import numpy as np
import pytest
from exact_roll import exact_levels, exact_turn
from exact_roll_model import Model, Stall
from long_but import long_but
from roll_machines import LENGTH, RADIUS, ROTOR, SYNCHRONOUS, source_drive, source_machine

from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.roll.mechanism import RollDrive, RollMachine, smooth_angles
from vibecalc.roll.steady import multipliers, steady_state
from vibecalc.roll.turn import harmonics, level, readings

ORDERS = np.arange(1, 11)
SMOOTH = {"gas": "cubic", "motor": "monotone"}
OFFSET = {"wrist_pin_offset": 0.012, "rod_inertia_difference": [-0.02, -0.01]}
#: fields of the machine, curves, Gauss points on a panel
CASES = {
    "rod of 1.01 radii": ({"rod_length": RADIUS / 0.99}, {}, 16),
    "shell of 5": ({"shell_inertia": 5.0}, {}, 10),
    "shell of 0.001": ({"shell_inertia": 0.001}, {}, 10),
    "half as much gas again": ({"gas_scale": [1.5, 1.5]}, {}, 10),
    "offset": (OFFSET | {"crank_angle_offset": [0.3, 2.7]}, SMOOTH, 10),
    "friction": (OFFSET | {"piston_friction": 120.0, "friction_damping": 0.2}, {}, 10),
    "rotor of 0.05": ({"rotor_inertia": 0.05}, {}, 14),
    "rotor of 0.3": ({"rotor_inertia": 0.3}, {}, 10),
    "rotor of 200": ({"rotor_inertia": 200.0}, {}, 10),
    "rod of 1.1 radii": ({"rod_length": RADIUS / 0.9}, {}, 14),
    "trigonometric": ({}, {"gas": "trigonometric", "motor": "monotone"}, 10),
}
MARKED = long_but(CASES, "friction")


def boxed(fields: dict[str, object], curves: dict[str, str]) -> tuple[RollMachine, RollDrive]:
    """The machine as a batch of one."""
    arrays = {k: v if np.ndim(v) else [v] for k, v in ({"rotor_inertia": ROTOR} | fields).items()}
    return source_machine(**arrays), source_drive(
        **curves, synchronous_speed=np.full(1, SYNCHRONOUS)
    )


@pytest.mark.long
@pytest.mark.parametrize("name", MARKED)
def test_levels_are_those_of_an_independent_integration(name: str) -> None:
    fields, curves, points = CASES[name]
    machine, drive = boxed(fields, curves)
    found = steady_state(machine, drive, points, started_at=SYNCHRONOUS)
    assert found.solved.all()
    exact = exact_turn(source_machine(**fields), source_drive(**curves), started_at=SYNCHRONOUS)
    read = readings(machine, drive, found.turn)
    ours = level(harmonics(found.turn, read.shell_acceleration, ORDERS))[0]
    assert np.max(np.abs(ours - exact_levels(exact, ORDERS))) < 1e-9
    assert float(found.turn.period[0]) == pytest.approx(exact.period, rel=1e-12)
    value, error = multipliers(found)
    assert abs(value[0, 0] - exact.multiplier) <= float(error[0, 0]) + 1e-9 * exact.multiplier


@pytest.mark.long
def test_no_running_state_under_three_and_a_half_times_the_gas() -> None:
    fields = {"gas_scale": [3.5, 3.5]}
    assert not steady_state(*boxed(fields, {}), 8, started_at=SYNCHRONOUS).solved[0]
    with pytest.raises(Stall):
        exact_turn(source_machine(**fields), source_drive(), started_at=SYNCHRONOUS)


@pytest.mark.parametrize("offset", [0.0, 0.012, -0.03])
def test_friction_splits_the_turn_where_the_pistons_stop(offset: float) -> None:
    """Dead centres of a cylinder next to the crank axis are not at 0 and 180 degrees."""
    machine = source_machine(wrist_pin_offset=offset, piston_friction=50.0)
    edges = smooth_angles(machine, source_drive())
    stopped = []
    for phase in machine.crank_angle_offset:
        stroke = piston_path(edges + phase, RADIUS, LENGTH, offset).velocity
        stopped.append(int(np.sum(np.abs(stroke) < 1e-12 * RADIUS)))
    # the second cylinder stops at zero, which is an edge twice, where there is no offset
    assert min(stopped) >= 2
    exact = Model(machine, source_drive()).edges
    assert all(np.min(np.abs(edges - edge)) < 1e-9 for edge in exact)
