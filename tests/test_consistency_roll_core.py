"""Claim: inertia, accelerations and forces of the roll machine are those of its moving parts.

Truth is geometry in mpmath: places of rotor, rods and pistons as functions of two angles, with
offset, banks, phases and rods with a moment of their own, differentiated numerically at 50 digits.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest

from vibecalc.roll.mechanism import RollMachine, accelerations, inertia, roll_machine
from vibecalc.roll.turn import Turn, piston_forces

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


def moving(theta, beta):
    """(mass, coordinate) of everything that has kinetic energy; angles count with a moment."""
    parts = [(SHELL, theta), (SHAFT, theta + beta)]
    rods = zip(places(theta, beta), PISTON, RODS, strict=True)
    for (crank, wrist, rod), piston, (m, near, moment) in rods:
        centre = [
            a + (b - a) * mp.mpf(near) / mp.mpf(LENGTH) for a, b in zip(crank, wrist, strict=True)
        ]
        parts += [(piston, x) for x in wrist] + [(m, x) for x in centre] + [(moment, rod)]
    return parts


@cache
def masses(beta: str):
    """J, N, Q at a crank angle, from the velocities of all parts."""
    at = mp.mpf(beta)
    by_shell = [mp.diff(lambda x, i=i: moving(x, at)[i][1], 0) for i in range(len(moving(0, at)))]
    by_crank = [
        mp.diff(lambda x, i=i: moving(mp.mpf(0), x)[i][1], at) for i in range(len(by_shell))
    ]
    weight = [mp.mpf(m) for m, _ in moving(0, at)]
    j = mp.fsum(m * a * a for m, a in zip(weight, by_shell, strict=True))
    n = mp.fsum(m * a * b for m, a, b in zip(weight, by_shell, by_crank, strict=True))
    q = mp.fsum(m * b * b for m, b in zip(weight, by_crank, strict=True))
    return j, n, q


def slopes(beta: float):
    with mp.workdps(60):
        step = mp.mpf(10) ** -15
        up, down = (masses(mp.nstr(beta + k * step, 50)) for k in (1, -1))
        return [(a - b) / (2 * step) for a, b in zip(up, down, strict=True)]


@pytest.mark.parametrize("beta", [0.7, 3.3])
def test_inertia_is_that_of_the_parts(beta: float) -> None:
    found = inertia(machine(), np.array([beta]))
    with mp.workdps(60):
        j, n, q = masses(mp.nstr(mp.mpf(beta), 50))
        determinant = j * q - n * n
    assert found.shell[0] == pytest.approx(float(j), rel=1e-14)
    assert found.coupling[0] == pytest.approx(float(n), rel=1e-14)
    assert found.crank[0] == pytest.approx(float(q), rel=1e-14)
    assert found.determinant[0] == pytest.approx(float(determinant), rel=1e-13)
    j1, n1, q1 = (float(x) for x in slopes(beta))
    scale = float(mp.mpf(PISTON[0])) * LENGTH * RADIUS
    assert found.shell_slope[0] == pytest.approx(j1, abs=1e-13 * scale)
    assert found.coupling_slope[0] == pytest.approx(n1, abs=1e-13 * scale)
    assert found.crank_slope[0] == pytest.approx(q1, abs=1e-13 * scale)


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
