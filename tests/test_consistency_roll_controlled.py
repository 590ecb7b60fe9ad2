"""Claim: the closed loop in the full model is what its equations of motion give when they are
marched, with and without mounts; it is the running state where nothing is fed back; it comes down
to the reduced model where the motor is straight and the load small; its stability is that of the
motion.
"""

from collections.abc import Callable

import numpy as np
import pytest
from roll_machines import FIRST_MASS, SECOND_MASS, SYNCHRONOUS, source_drive, source_machine
from scipy.integrate import solve_ivp

from vibecalc.excitation.gas_tables import force_at
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.roll.control.full_model import Law, closed_loop
from vibecalc.roll.control.gains import LoopLoad, evaluate_at_speed
from vibecalc.roll.control.loop import Controller, disturbance, model_from_full, straight
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.running import running_state
from vibecalc.roll.turn import harmonics as spectrum
from vibecalc.roll.turn import readings


def rates(
    machine: RollMachine, drive: RollDrive, law: Law
) -> Callable[[float, np.ndarray], np.ndarray]:
    """d(w, theta, s, u)/db of one machine (B = 1) without friction or wrist pin offset.

    Newton's law for the two coordinates as a linear system, with the lag of the actuator.
    """
    one = RollMachine(*(np.asarray(field)[0] for field in machine))

    def found(angle: float, state: np.ndarray) -> np.ndarray:
        w, theta, s, u = state
        own = angle + one.crank_angle_offset
        r, slope, bend, _ = piston_path(own, one.crank_radius, one.rod_length, 0.0)
        mass = one.reciprocating_mass
        force = np.array([float(force_at(g, np.array([a]))[0]) for g, a in zip(
            drive.gas, np.mod(own, 2.0 * np.pi), strict=True)])  # fmt: skip
        motor = float(slip_torque(drive.motor, np.array([u - w])).value[0])
        rotor = one.rotor_inertia
        whole = one.shell_inertia + rotor + np.sum(mass * r * r)
        crank = rotor + np.sum(mass * slope * slope)
        # momentum of mass and its rate; energy by r alone
        left = np.array([[whole, rotor], [rotor, crank]])
        right = np.array([
            -one.shell_stiffness * theta - one.shell_damping * s
            - 2.0 * np.sum(mass * r * slope) * w * s,
            motor - np.sum(force * slope) + np.sum(mass * r * slope) * s * s
            - np.sum(mass * slope * bend) * w * w,
        ])  # fmt: skip
        shell, spin = np.linalg.solve(left, right)
        asked = law.gain * (
            law.reference - law.speed_feedback * w - law.acceleration_feedback * shell
        )
        return np.array([spin, s, shell, (asked - u) / law.lag]) / w

    return found


def marched(
    machine: RollMachine, drive: RollDrive, law: Law, start: np.ndarray, turns: int
) -> np.ndarray:
    """The state after whole turns; steps end at every node of the gas tables."""
    step, state = rates(machine, drive, law), np.asarray(start, dtype=float)
    for _ in range(turns):
        for low in np.arange(36) * np.pi / 18.0:
            found = solve_ivp(
                step, (low, low + np.pi / 18.0), state, method="LSODA", rtol=1e-9, atol=1e-11
            )
            state = found.y[:, -1]
    return state


FREE = as_batch(source_machine())
MOUNTED = as_batch(source_machine(shell_stiffness=3e4, shell_damping=60.0))
TABLE, LINE = source_drive(), source_drive()._replace(motor=straight(203.4))
ORDERS = np.arange(1.0, 11.0)


def levels(amplitudes):
    return 20.0 * np.log10(np.abs(amplitudes))


@pytest.mark.parametrize("lag", [0.0, 1e-3])
def test_without_feedback_it_is_the_running_state(lag):
    running = running_state(FREE, TABLE, rtol=1e-9, orders=10).state
    read = readings(FREE, TABLE, running.turn, pistons=False).shell_acceleration
    known = spectrum(running.turn, read, ORDERS)[0]
    found = closed_loop(FREE, TABLE, Law(1.0, 0.0, 0.0, SYNCHRONOUS, lag), rtol=1e-9, orders=10)
    np.testing.assert_allclose(levels(found.harmonics.value), levels(known), rtol=0, atol=1e-9)
    assert found.speed.value == pytest.approx(2.0 * np.pi / float(running.turn.period[0]), 1e-12)


@pytest.mark.parametrize(
    ("drive", "machine"),
    [
        pytest.param(LINE, FREE, id="line-free", marks=pytest.mark.long),
        pytest.param(TABLE, MOUNTED, id="table-mounted"),
        pytest.param(TABLE, FREE, id="table-free", marks=pytest.mark.long),
        pytest.param(LINE, MOUNTED, id="line-mounted", marks=pytest.mark.long),
    ],
)
def test_marching_leads_to_it(machine, drive):
    """Three turns from its start displaced: what is left of that is what the multipliers say."""
    law = Law(2.0, 0.508, -0.1, SYNCHRONOUS, 3e-3)
    found = closed_loop(machine, drive, law, rtol=1e-10, orders=10)
    assert found.stable
    solution = found.closed.solution
    at = evaluate(solution, [0.0])[0, 0]
    start = at.copy()
    if machine is FREE:
        shell = (found.closed.problem.rhs.momentum - 2.110823323068138 * at[0])[0]
        whole = 151.73454612199947 + 2.110823323068138 + FIRST_MASS * 0.3556**2 + (
            SECOND_MASS * 0.2286**2
        )  # fmt: skip
        start = np.array([at[0], 0.0, shell / whole, at[1]])
    once = marched(machine, drive, law, start, 1)
    np.testing.assert_allclose(once[[0, 3]], start[[0, 3]], rtol=2e-8)
    if machine is MOUNTED:
        np.testing.assert_allclose(once[1:3], start[1:3], rtol=1e-5)
    else:
        away = start * np.array([1.0, 1.0, 1.0, 1.002])
        twice = marched(machine, drive, law, away, 2)
        left = abs(twice[0] / start[0] - 1.0)
        assert left < 2e-3 * 20.0 * np.max(np.abs(found.multiplier)) ** 2 + 2e-8


@pytest.mark.long
def test_multipliers_are_those_of_the_marched_turn_and_mounts_can_make_them_unstable():
    """Feedback that the reduced model calls stable excites the roll on the mounts."""
    law = Law(1.0, 0.0, -1.0, SYNCHRONOUS, 2e-3)
    found = closed_loop(MOUNTED, LINE, law, rtol=1e-9, orders=6)
    start = evaluate(found.closed.solution, [0.0])[0, 0]
    columns = []
    for place, step in enumerate((1e-3, 1e-6, 1e-5, 1e-3)):
        ends = []
        for sign in (1.0, -1.0):
            moved = start.copy()
            moved[place] += sign * step
            ends.append(marched(MOUNTED, LINE, law, moved, 1))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    known = np.linalg.eigvals(np.array(columns).T)
    known = known[np.argsort(-np.abs(known))]
    np.testing.assert_allclose(np.abs(found.multiplier[:2]), np.abs(known[:2]), rtol=1e-5)
    assert not found.stable and np.abs(known[0]) > 1.03
    model = reduced(MOUNTED, LINE)[0]
    reported = evaluate_at_speed(
        model, Controller(1.0, 0.0, -1.0, 2e-3), load(MOUNTED, LINE), 92.757
    )
    assert reported.margins.status == 0


def reduced(machine, drive):
    known = disturbance(machine, drive, 10)
    return model_from_full(known.whole, known.coupling, known.crank, 203.4), known


def load(machine, drive, speed=92.757):
    known = disturbance(machine, drive, 10)
    return LoopLoad(SYNCHRONOUS, known.mean.value, known.at(speed).value)


def test_small_loads_and_a_straight_motor_make_it_the_reduced_model():
    """The difference in order 2 shrinks with the load; a twentieth of it leaves next to nothing."""
    off = []
    for size in (1.0, 0.2, 0.05):
        machine = as_batch(
            source_machine(
                gas_scale=[size, size], reciprocating_mass=[size * FIRST_MASS, size * SECOND_MASS]
            )
        )
        model, known = reduced(machine, LINE)
        target = SYNCHRONOUS + float(known.mean.value) / 203.4
        reported = evaluate_at_speed(
            model, Controller(5.0, 0.0, -0.01, 1e-3), load(machine, LINE, target), target
        )
        law = Law(5.0, float(reported.speed_feedback.value), -0.01, SYNCHRONOUS, 1e-3)
        found = closed_loop(machine, LINE, law, rtol=1e-9, orders=10)
        off.append(np.abs(levels(found.harmonics.value) - reported.level.value))
    for order in (1, 3, 4):
        assert off[1][order - 1] < 0.4 * off[0][order - 1]
        assert off[2][order - 1] < 0.4 * off[1][order - 1]
    assert np.all(off[0][:2] < 0.06) and np.all(off[2][:4] < 0.01)


def test_the_error_bounds_what_more_points_change():
    law = Law(1.0, 0.0, -1.0, SYNCHRONOUS, 2e-4)
    rough, fine = (closed_loop(FREE, TABLE, law, rtol=r, orders=10) for r in (1e-4, 1e-12))
    change = np.abs(rough.harmonics.value - fine.harmonics.value)
    assert np.all(change <= 2.0 * (rough.harmonics.error + fine.harmonics.error))
    assert np.max(fine.harmonics.error) < 1e-9 * np.max(np.abs(fine.harmonics.value))
