"""Claim: inertia and forces of the roll machine are those of its moving parts, and readings,
balances and harmonics of a turn those of an independent integration.

Truth of the parts is geometry in mpmath: places of rotor, rods and pistons as functions of two
angles, with offset, banks, phases and rods with a moment of their own, differentiated numerically
at 50 digits. Truth of a turn is `exact_roll`: energy over the crank angle by scipy, with formulas
of its own.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
from exact_roll import ExactTurn, as_turn, exact_harmonics, exact_levels, exact_turn
from long_but import long_but
from roll_machines import SYNCHRONOUS, source_drive, source_machine

from vibecalc.roll.mechanism import RollDrive, RollMachine, accelerations, inertia, roll_machine
from vibecalc.roll.turn import (
    Turn,
    balance,
    classical,
    constant_speed,
    harmonics,
    level,
    mean,
    piston_forces,
    readings,
)

ORDERS = np.arange(1, 11)
ODD = {
    "wrist_pin_offset": 0.012,
    "crank_angle_offset": [0.4, 2.9],
    "rod_inertia_difference": [-0.02, -0.01],
}
RUBBING = {"friction_torque": 11.0, "friction_damping": 0.3, "piston_friction": 120.0}
MACHINES = {
    "source": ({}, {}),
    "offset, rods": (ODD, {"gas": "cubic", "motor": "monotone"}),
    "friction": (ODD | RUBBING, {"motor": "parabola"}),
    "trigonometric": ({}, {"gas": "trigonometric", "motor": "monotone"}),
}
#: each machine costs a reference of its own
SOME = long_but(MACHINES, "offset, rods")


@cache
def found(name: str) -> tuple[RollMachine, RollDrive, ExactTurn]:
    fields, curves = MACHINES[name]
    machine, drive = source_machine(**fields), source_drive(**curves)
    return machine, drive, exact_turn(machine, drive, started_at=SYNCHRONOUS)


@pytest.mark.long
@pytest.mark.parametrize("name", SOME)
def test_readings_are_those_of_the_energy_equation(name: str) -> None:
    machine, drive, exact = found(name)
    read = readings(machine, drive, as_turn(exact))
    size = np.max(np.abs(exact.crank_acceleration))
    pairs = {
        "shell_acceleration": exact.shell_acceleration,
        "rotor_acceleration": exact.shell_acceleration + exact.crank_acceleration,
        "crank_speed": exact.crank_speed,
        "slip": SYNCHRONOUS - exact.crank_speed,
        "motor_torque": exact.motor_torque,
        "gas_torque": exact.gas_torque,
    }
    for field, truth in pairs.items():
        scale = size if "acceleration" in field else np.max(np.abs(truth))
        np.testing.assert_allclose(getattr(read, field), truth, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("name", SOME)
def test_energy_and_momentum_balance(name: str) -> None:
    machine, drive, exact = found(name)
    turn = as_turn(exact)
    checked = balance(machine, turn, readings(machine, drive, turn))
    assert checked.motor > 1800.0
    assert abs(checked.residual) < 1e-10 * checked.motor
    assert checked.mounts == 0.0
    assert checked.momentum == pytest.approx(exact.momentum, rel=1e-12)
    assert checked.momentum_residual < 1e-12 * exact.momentum
    assert checked.motor == pytest.approx(
        float(np.sum(exact.weight * exact.motor_torque)), rel=1e-12
    )
    fields = MACHINES[name][0]
    if "friction_torque" in fields:
        stroke = np.abs(inertia(machine, exact.crank_angle).stroke).sum(axis=-1)
        speeds = 2.0 * np.pi * 0.3 * np.average(exact.crank_speed, weights=exact.weight)
        slid = 120.0 * np.sum(exact.weight * stroke)
        assert checked.friction == pytest.approx(2.0 * np.pi * 11.0 + speeds + slid, rel=1e-12)
    else:
        assert checked.friction == 0.0


def test_harmonics_of_any_function_of_time() -> None:
    _, _, exact = found("offset, rods")
    turn = as_turn(exact)
    values = exact.shell_acceleration
    truth = exact_harmonics(exact, values, ORDERS)
    np.testing.assert_allclose(harmonics(turn, values, ORDERS), truth, rtol=1e-13)
    np.testing.assert_allclose(level(truth), exact_levels(exact, ORDERS), rtol=1e-13)
    phase = 2.0 * np.pi / exact.period * exact.time
    signal = 0.7 + 2.0 * np.cos(3.0 * phase - 0.4) - 5.0 * np.sin(8.0 * phase)
    amplitudes = harmonics(turn, signal, np.arange(11))
    expected = np.zeros(11, dtype=complex)
    expected[0], expected[3], expected[8] = 0.7, 2.0 * np.exp(-0.4j), 5.0j
    np.testing.assert_allclose(amplitudes, expected, atol=1e-12)
    assert mean(turn, signal) == pytest.approx(0.7, abs=1e-13)


def test_classical_forces_are_those_of_a_constant_speed() -> None:
    """Along its cylinder the piston needs gas and its own acceleration; of rods as two points."""
    machine, drive, exact = found("offset, rods")
    machine, turn = machine._replace(rod_inertia_difference=np.zeros(2)), as_turn(exact)
    held = constant_speed(turn)
    speed = 2.0 * np.pi / exact.period
    np.testing.assert_allclose(held.crank_speed, speed)
    assert np.max(np.abs(held.shell_speed)) == 0.0
    moved, read = inertia(machine, turn.crank_angle), readings(machine, drive, turn)
    angle = turn.crank_angle[:, None] + machine.crank_angle_offset
    sine = (machine.crank_radius * np.sin(angle) - machine.wrist_pin_offset) / machine.rod_length
    along = classical(machine, drive, turn)["rod_force"] * np.sqrt(1.0 - sine * sine)
    pull = machine.reciprocating_mass * moved.curvature * speed**2
    np.testing.assert_allclose(along, pull + read.gas_force, rtol=1e-11, atol=1e-9)


RADIUS, LENGTH, OFFSET = 0.0635, 0.2921, 0.011
PHASE, BANK = (0.0, 2.1, -1.3), (0.3, -0.5, 0.9)
PISTON = (9.0, 7.5, 4.0)
#: rods as bodies: mass, distance of the mass centre from the crank pin, moment about that centre
RODS = ((2.0, 0.09, 0.011), (1.5, 0.12, 0.004), (0.0, 0.1, 0.0))
SHAFT, SHELL = 1.3, 150.0
STATES = [
    (0.0, 90.0, 0.0),
    (1.1, 93.0, -2.0),
    (2.9, -40.0, 5.0),
    (4.4, 1.0, 60.0),
    (6.1, 94.2, 1.4),
]


def machine(**changes: object) -> RollMachine:
    """The machine as vibecalc has it: each rod as two point masses and what they leave out."""
    share = [m * near / LENGTH for m, near, _ in RODS]
    pins = sum((m - own) * RADIUS**2 for (m, _, _), own in zip(RODS, share, strict=True))
    fields: dict[str, object] = {
        "crank_radius": RADIUS,
        "rod_length": LENGTH,
        "wrist_pin_offset": OFFSET,
        "crank_angle_offset": np.subtract(PHASE, BANK),
        "reciprocating_mass": np.add(PISTON, share),
        "rod_inertia_difference": [j - m * a * (LENGTH - a) for m, a, j in RODS],
        "rotor_inertia": SHAFT + pins,
        "shell_inertia": SHELL,
    }
    return roll_machine(**(fields | changes))


def turned(x, y, angle):
    c, s = mp.cos(angle), mp.sin(angle)
    return c * x - s * y, s * x + c * y


def places(theta, beta):
    """Crank pin, wrist pin and rod angle of each cylinder on the ground, the shell at theta."""
    found = []
    for phase, bank in zip(PHASE, BANK, strict=True):
        angle = beta + mp.mpf(phase) - mp.mpf(bank)
        pin = RADIUS * mp.cos(angle), RADIUS * mp.sin(angle)
        height = mp.mpf(OFFSET)
        along = pin[0] + mp.sqrt(mp.mpf(LENGTH) ** 2 - (pin[1] - height) ** 2)
        rod = mp.atan2(height - pin[1], along - pin[0])
        tilt = theta + mp.mpf(bank)
        found.append((turned(*pin, tilt), turned(along, height, tilt), rod + tilt))
    return found


def moment_of(place: np.ndarray, force: np.ndarray) -> float:
    return float(place[0] * force[1] - place[1] * force[0])


@pytest.mark.parametrize(("beta", "w", "s"), STATES)
def test_forces_satisfy_each_body_alone(beta: float, w: float, s: float) -> None:
    """Newton for every piston, Euler for the crankshaft and for the shell, force by force."""
    friction, motor, mounts = 85.0, 420.0, -55.0
    gas = np.array([21000.0, 3300.0, -900.0])
    found = machine(piston_friction=friction)
    angle = np.array([beta])
    moved = inertia(found, angle)
    rubbing = -friction * np.sum(np.abs(moved.stroke)) * np.sign(w)
    inner = motor - float(np.sum(gas * moved.stroke)) + rubbing
    rate = accelerations(moved, *(np.array([x]) for x in (w, s, mounts, inner)))
    shell, crank = float(rate.shell[0]), float(rate.crank[0])
    turn = Turn(
        angle, np.ones(1), np.zeros(1), np.array([w]), np.array([s]), np.zeros(1), np.ones(1)
    )
    compression, wall = piston_forces(
        found, turn, moved, gas[None], shell_acceleration=rate.shell, acceleration=rate.crank
    )

    def course(t):
        return places(s * t + shell * t * t / 2, beta + w * t + crank * t * t / 2)

    on_shaft, on_shell = motor, mounts - motor
    with mp.workdps(50):
        for c, (pin, wrist, _) in enumerate(course(mp.mpf(0))):
            crank_pin, place = (np.array([float(x) for x in v]) for v in (pin, wrist))
            axis = np.array([np.cos(BANK[c]), np.sin(BANK[c])])
            side = np.array([-axis[1], axis[0]])
            pull = np.array([
                float(mp.diff(lambda t, c=c, k=k: course(t)[c][1][k], 0, 2)) for k in (0, 1)
            ])  # fmt: skip
            bend = float(mp.diff(lambda t, c=c: course(t)[c][2], 0, 2))
            rod = (place - crank_pin) / LENGTH
            across = np.array([-rod[1], rod[0]])
            moment = float(found.rod_inertia_difference[c])
            on_piston = compression[0, c] * rod - moment * bend / LENGTH * across
            sliding = np.sign(moved.stroke[0, c] * w) * friction
            force = on_piston - (gas[c] + sliding) * axis - wall[0, c] * side
            mass = float(found.reciprocating_mass[c])
            size = mass * np.linalg.norm(pull) + abs(gas[c]) + np.linalg.norm(on_piston)
            assert np.max(np.abs(force - mass * pull)) < 1e-13 * size
            on_shaft += moment_of(crank_pin, -on_piston)
            on_shell += moment_of(place, wall[0, c] * side)
            on_shell += moment_of(OFFSET * side, (gas[c] + sliding) * axis)
    size = float(np.sum(np.abs(gas))) * RADIUS
    rotor = float(found.rotor_inertia)
    assert on_shaft == pytest.approx(rotor * (shell + crank), abs=1e-12 * size)
    assert on_shell == pytest.approx(SHELL * shell, abs=1e-11 * size)


@pytest.mark.parametrize("share", [1.0, 1e-9])
@pytest.mark.parametrize("ratio", [0.2, 0.99])
def test_determinant_keeps_its_digits(share: float, ratio: float) -> None:
    """J Q - N^2 would lose nine digits where shell and pistons weigh 1e-9 of the rotor."""
    angles = np.array([0.0, 0.4, 1.5, 1.57, 3.0, 4.712])
    light = roll_machine(
        crank_radius=ratio * LENGTH,
        rod_length=LENGTH,
        crank_angle_offset=[0.0, 1.0],
        reciprocating_mass=[9.0 * share, 7.0 * share],
        rotor_inertia=2.0,
        shell_inertia=2.0 * share,
    )
    found = inertia(light, angles)
    with mp.workdps(60):
        length = mp.mpf(LENGTH)
        radius = mp.mpf(float(light.crank_radius))
        for place, angle in enumerate(angles):
            j, q = mp.mpf(float(light.shell_inertia)) + 2, mp.mpf(2)
            for m, phase in zip(light.reciprocating_mass, (0.0, 1.0), strict=True):
                x, y = (radius * f(mp.mpf(float(angle + phase))) for f in (mp.cos, mp.sin))
                c = mp.sqrt(length**2 - y**2)
                j += mp.mpf(float(m)) * (x + c) ** 2
                q += mp.mpf(float(m)) * (y + y * x / c) ** 2
            truth = float(j * q - 4)
            assert found.determinant[place] == pytest.approx(truth, rel=5e-14)
