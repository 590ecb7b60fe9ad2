"""Claim: the running state is right where it is awkward, and its multipliers are those in time.

Truth: an independent integration in the crank angle, one turn in time by DOP853, long marches, and
symmetry.
"""

import numpy as np
import pytest
from long_but import long_but
from roll_machines import SHELL, SYNCHRONOUS, source_drive, source_machine
from scipy.integrate import solve_ivp

from vibecalc.roll.between_kinks import running
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch, inertia
from vibecalc.roll.running import Running, running_state
from vibecalc.roll.steady import started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, level, mean, readings

ORDERS = np.arange(1, 11)
TURN = 2.0 * np.pi
DRIVE = source_drive()


def found(machine: RollMachine, drive: RollDrive = DRIVE, rtol: float = 1e-10, **more) -> Running:
    return running_state(as_batch(machine), drive, rtol=rtol, orders=10, **more)


def levels(machine: RollMachine, turn: Turn, drive: RollDrive = DRIVE) -> np.ndarray:
    read = readings(as_batch(machine), drive, turn, pistons=False)
    return level(harmonics(turn, read.shell_acceleration, ORDERS))[0]


READ = [
    (gas, motor)
    for gas in ("linear", "parabola", "cubic", "trigonometric")
    for motor in ("linear", "parabola", "monotone")
]
QUICK = (("parabola", "monotone"), ("trigonometric", "parabola"))


@pytest.mark.parametrize(
    ("gas", "motor"),
    [one if one in QUICK else pytest.param(*one, marks=pytest.mark.long) for one in READ],
)
def test_every_way_to_read_the_tables_has_its_state(gas: str, motor: str) -> None:
    drive = source_drive(gas, motor)
    state = found(source_machine(), drive, started_at=SYNCHRONOUS).state
    assert one_turn(source_machine(), drive, state) < 1e-8


HARD = {
    "rod of 1.001 radii": {"rod_length": 0.0635 / 0.999},
    "rotor of 20": {"rotor_inertia": 20.0},
    "rotor of 0.1": {"rotor_inertia": 0.1},
    "shell of 0.5": {"shell_inertia": 0.5},
    "throws at right angles": {"crank_angle_offset": [0.0, 0.5 * np.pi]},
    "offset and sticking pistons": {"wrist_pin_offset": 0.01, "piston_friction": 150.0},
    "friction torque": {"friction_torque": 30.0, "friction_damping": 0.3},
    "heavy rods": {"rod_inertia_difference": [-0.02, 0.03]},
    "three times the gas": {"gas_scale": [3.1, 3.1]},
}


@pytest.mark.parametrize(
    "name",
    long_but(HARD, "offset and sticking pistons"),
)
def test_a_turn_in_time_comes_back_to_where_it_began(name: str) -> None:
    machine = source_machine(**HARD[name])
    drive = DRIVE._replace(holds=True)
    state = found(machine, drive, started_at=SYNCHRONOUS).state
    assert one_turn(machine, drive, state) < 1e-7


MOUNTS = {
    "soft": (1e3, 10.0),
    "firm": (1e5, 10.0),
    "on order 1": (SHELL * 93.0**2, 10.0),
    "on order 2": (4.0 * SHELL * 93.0**2, 10.0),
    "on order 1, undamped": (SHELL * 93.0**2, 0.0),
    "between, undamped": (3e5, 0.0),
    "stiff": (1e8, 100.0),
}


@pytest.mark.parametrize("name", long_but(MOUNTS, "between, undamped"))
def test_on_mounts_too_however_near_its_multipliers_are_to_one(name: str) -> None:
    stiffness, damping = MOUNTS[name]
    machine = source_machine(shell_stiffness=stiffness, shell_damping=damping)
    running_ = found(machine)
    assert one_turn(machine, DRIVE, running_.state) < 1e-7
    assert 0.7 < np.max(np.abs(running_.multiplier)) < 1.0
    if not damping:
        # the motor alone damps the roll, a little
        assert np.max(np.abs(running_.multiplier)) > 0.97


def one_turn(machine: RollMachine, drive: RollDrive, state) -> float:
    """By how much a turn in time misses its start: period, speeds, shell's angle; relative."""
    start, period, mounted = at_zero(machine, state)
    end, time = integrated(machine, drive, start, until=TURN)
    size = np.array([start[1], 1e-2, 1e-2 * start[1]])
    missed = np.abs(end[1:] - start[1:]) / size
    return float(max(abs(time / period - 1.0), *(missed if mounted else missed[[0, 2]])))


def at_zero(machine: RollMachine, state) -> tuple[np.ndarray, float, bool]:
    """Crank angle and speed, shell angle and speed where the turn begins; its period."""
    y = state.solution.left[0, 0]
    mounted = len(y) == 3
    if mounted:
        return np.array([0.0, *y]), float(state.turn.period[0]), True
    moved = inertia(as_batch(machine), np.zeros((1, 1)))
    shell = (state.momentum - moved.coupling[:, 0] * y) / moved.shell[:, 0]
    return np.array([0.0, y[0], 0.0, shell[0]]), float(state.turn.period[0]), False


def integrated(
    machine: RollMachine, drive: RollDrive, start: np.ndarray, until: float, span: float = 0.0
) -> tuple[np.ndarray, float]:
    """State after a time, or else at a crank angle, and when that is; DOP853."""
    rates = running(machine, drive)

    def equations(time: float, y: np.ndarray) -> list[float]:
        crank, shell = rates(*y.tolist())
        return [y[1], crank, y[3], shell]

    def event(time: float, y: np.ndarray) -> float:
        return y[0] - until

    event.terminal = not span  # type: ignore[attr-defined]
    run = solve_ivp(
        equations, (0.0, span or 1.0), start, method="DOP853", events=event,
        rtol=1e-11, atol=1e-13, max_step=1e-3,
    )  # fmt: skip
    if span:
        return run.y[:, -1], span
    return run.y_events[0][0], float(run.t_events[0][0])


@pytest.mark.parametrize(
    ("fields", "trivial"),
    [
        ({"rotor_inertia": 20.0}, 3),
        pytest.param(
            {"shell_stiffness": 2e5, "shell_damping": 2e3, "rotor_inertia": 10.0},
            1,
            marks=pytest.mark.long,
        ),
        pytest.param(
            {"shell_stiffness": 2e5, "shell_damping": 60.0, "rotor_inertia": 10.0},
            1,
            marks=pytest.mark.long,
        ),
    ],
)
def test_multipliers_are_those_of_all_four_states_in_time(fields: dict, trivial: int) -> None:
    """The trivial ones are 1 (of a free machine three in one Jordan block, so by coefficients)."""
    machine = source_machine(**fields)
    drive = source_drive("cubic", "monotone")
    running_ = found(machine, drive)
    start, period, _ = at_zero(machine, running_.state)
    columns, steps = [], np.array([1e-4, 1e-2, 1e-4, 1e-2])
    for place, step in enumerate(steps):
        ends = []
        for way in (step, -step):
            moved = start.copy()
            moved[place] += way
            ends.append(integrated(machine, drive, moved, TURN, span=period)[0])
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    scale = np.array([1.0, start[1], 1.0, start[1]])
    monodromy = np.array(columns).T / scale[:, None] * scale
    expected = np.poly(np.concatenate([np.ones(trivial), running_.multiplier[0]]))
    assert np.abs(np.poly(monodromy) - expected).max() < 5e-5
    assert len(running_.multiplier[0]) == 4 - trivial


def test_a_shell_at_rest_on_average_and_a_start_at_rest() -> None:
    """Without a start the drift is zero; the start with that momentum gives the same motion."""
    machine = as_batch(source_machine(shell_inertia=[20.0]))
    still = steady_state(machine, DRIVE, 8)
    assert abs(float(mean(still.turn, still.turn.shell_speed)[0])) < 1e-12
    unit = float(started_momentum(machine, 1.0)[0])
    again = steady_state(machine, DRIVE, 8, started_at=float(still.momentum[0]) / unit)
    np.testing.assert_allclose(again.turn.crank_speed, still.turn.crank_speed, rtol=1e-12)
    # another momentum gives another motion: the shell drifts, and its levels move
    other = steady_state(machine, DRIVE, 8, started_at=SYNCHRONOUS)
    assert abs(float(mean(other.turn, other.turn.shell_speed)[0])) > 0.01
    apart = levels(machine, other.turn) - levels(machine, still.turn)
    assert 1e-3 < np.max(np.abs(apart)) < 1.0
