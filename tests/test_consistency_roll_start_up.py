"""Claim: start-ups agree with closed forms, the energy balance, and another integrator."""

import numpy as np
import pytest
from roll_machines import constant_torque, source_machine, straight_drive
from scipy.integrate import solve_ivp

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import gas_force
from vibecalc.excitation.slip_torque import linear_motor, slip_curve
from vibecalc.roll.between_kinks import running
from vibecalc.roll.mechanism import RollDrive, RollMachine, gas_forces, inertia
from vibecalc.roll.start_up import StartUp, start_angles, start_up
from vibecalc.roll.start_up_readings import QUANTITIES
from vibecalc.roll.start_up_system import LoadSteps

ROTOR, HOUSING = 2.0, 150.0
#: of rotor against shell
REDUCED = ROTOR * HOUSING / (ROTOR + HOUSING)


def bare(**changes: object) -> RollMachine:
    """A machine whose pistons weigh next to nothing: a rotor in a shell."""
    return source_machine(
        reciprocating_mass=[1e-15, 1e-15],
        rotor_inertia=ROTOR,
        shell_inertia=HOUSING,
        **changes,
    )


def without_gas(torque: float = 300.0) -> RollDrive:
    return RollDrive((None, None), constant_torque(torque), np.array(100.0))


def final(found: StartUp) -> tuple[float, float, float, float]:
    return tuple(found.final[:4].tolist())


def test_constant_torque_turns_rotor_and_shell_apart_evenly() -> None:
    found = start_up(bare(), without_gas(), duration=0.3, crank_angle=0.4)
    angle, speed, shell_angle, shell_speed = final(found)
    assert speed == pytest.approx(300.0 * 0.3 / REDUCED, rel=1e-10)
    assert angle == pytest.approx(0.4 + 300.0 * 0.3**2 / 2.0 / REDUCED, rel=1e-10)
    share = ROTOR / (ROTOR + HOUSING)
    assert shell_speed == pytest.approx(-share * speed, rel=1e-9)
    assert shell_angle == pytest.approx(-share * (angle - 0.4), rel=1e-9)
    peak = dict(zip(QUANTITIES, found.peaks.value, strict=True))
    assert peak["shell_acceleration"] == pytest.approx(300.0 / HOUSING, rel=1e-9)
    assert found.energies.motor == pytest.approx(300.0 * (angle - 0.4), rel=1e-9)


def test_a_linear_motor_approaches_its_speed_exponentially() -> None:
    drive = without_gas()._replace(motor=linear_motor(10.0))
    found = start_up(bare(), drive, duration=0.4, running_speed=80.0)
    late = np.exp(-10.0 * 0.4 / REDUCED)
    assert found.final[1] == pytest.approx(100.0 * (1.0 - late), abs=found.final_error[1] + 1e-9)
    reached = -np.log(0.2) * REDUCED / 10.0
    assert found.time_to_speed is not None
    assert found.time_to_speed == pytest.approx(reached, abs=found.error["time_to_speed"])
    assert found.error["time_to_speed"] < 1e-6


def test_the_shell_on_mounts_swings_about_its_new_place() -> None:
    """A torque of the motor that is constant: on the shell it is a step load."""
    stiffness = 4e5
    machine = bare(shell_stiffness=stiffness)
    found = start_up(machine, without_gas(), duration=0.25)
    rate = np.sqrt(stiffness / HOUSING)
    assert found.final[2] == pytest.approx(
        -300.0 / stiffness * (1.0 - np.cos(rate * 0.25)), abs=found.final_error[2]
    )
    assert found.final_error[2] < 1e-5 * 300.0 / stiffness
    peak = dict(zip(QUANTITIES, found.peaks.value, strict=True))
    error = dict(zip(QUANTITIES, found.peaks.error, strict=True))
    assert peak["mount_torque"] == pytest.approx(600.0, abs=error["mount_torque"])
    assert error["mount_torque"] < 0.1


@pytest.mark.long
def test_dry_friction_brings_a_coasting_rotor_to_rest_and_holds_it() -> None:
    machine = bare(friction_torque=40.0)
    found = start_up(machine, without_gas(0.0), duration=2.6, speed=50.0, crank_angle=1.0)
    way = REDUCED * 50.0**2 / (2.0 * 40.0)
    assert found.verdict == "stalled" and "held by friction" in found.reason
    assert found.final[0] == pytest.approx(1.0 + way, rel=1e-9)
    assert found.final[1] == 0.0
    assert found.energies.friction == pytest.approx(-40.0 * way, rel=1e-9)
    # momentum: rotor and shell go on as one body
    assert found.final[3] == pytest.approx(ROTOR * 50.0 / (ROTOR + HOUSING), rel=1e-9)


@pytest.mark.parametrize(
    ("tolerance", "friction", "speed"),
    [
        (1e-5, 13.37262, 17.67186),
        (1e-7, 43.50424, 24.88664),
        pytest.param(1e-7, 35.19916, 51.39924, marks=pytest.mark.long),
    ],
)
def test_what_comes_to_rest_leaves_its_momentum_to_the_shell(
    tolerance: float, friction: float, speed: float
) -> None:
    """The error that is stated covers where the shell ends, where a step ends just before rest."""
    found = start_up(
        bare(friction_torque=friction), without_gas(0.0), speed=speed, tolerance=tolerance,
        duration=1.3 * REDUCED * speed / friction, crank_angle=1.0,
    )  # fmt: skip
    exact = ROTOR * speed / (ROTOR + HOUSING)
    assert found.final[3] == pytest.approx(exact, abs=found.final_error[3])


@pytest.mark.parametrize(("torque", "moves"), [(39.9, False), (40.1, True)])
def test_friction_holds_up_to_its_size(torque: float, moves: bool) -> None:
    found = start_up(bare(friction_torque=40.0), without_gas(torque), duration=1.0)
    expected = (torque - 40.0) / REDUCED if moves else 0.0
    assert found.final[1] == pytest.approx(expected, abs=1e-9)


def test_a_load_that_comes_off_lets_friction_go() -> None:
    """Gas that holds the crank at 90 degrees until it is relieved at half a second."""
    gas = gas_force(np.radians([0.0, 360.0]), [4000.0, 4000.0], "linear")
    drive = RollDrive((gas, None), constant_torque(300.0), np.array(100.0))
    machine = bare(friction_torque=100.0)
    load = LoadSteps(np.array([0.0, 0.5]), np.array([1.0, 0.0]))
    stroke = float(inertia(machine, np.array([np.radians(270.0)])).stroke[0, 0])
    assert abs(300.0 - 4000.0 * stroke) < 100.0
    found = start_up(machine, drive, duration=1.0, crank_angle=np.radians(270.0), load=load)
    assert found.final[1] == pytest.approx(0.5 * 200.0 / REDUCED, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param({}, id="free", marks=pytest.mark.long),
        pytest.param(
            {"shell_stiffness": 3e5, "shell_damping": 500.0, "piston_friction": 60.0}, id="mounted"
        ),
    ],
)
def test_the_source_machine_keeps_its_energy(changes: dict[str, float]) -> None:
    machine = source_machine(friction_torque=3.0, friction_damping=0.05, **changes)
    found = start_up(machine, straight_drive(), duration=1.0, crank_angle=3.5)
    energies = found.energies
    assert found.verdict in ("running", "settled")
    assert energies.motor > 2e4 and energies.gas < 0.0 and energies.friction < -100.0
    assert (energies.mounts < 0.0) == bool(changes)
    assert abs(energies.residual) < 1e-7 * energies.motor
    assert abs(energies.residual) < found.error["residual"]


@pytest.mark.parametrize("mounted", [pytest.param(False, marks=pytest.mark.long), True])
def test_a_running_machine_agrees_with_scipy_between_the_kinks(mounted: bool) -> None:
    changes = {"shell_stiffness": 3e5, "shell_damping": 500.0} if mounted else {}
    machine, drive = source_machine(**changes), straight_drive("parabola")
    found = start_up(machine, drive, duration=0.05, speed=90.0, tolerance=1e-9)
    rates = running(machine, drive)

    def equations(time: float, y: np.ndarray) -> list[float]:
        crank, shell = rates(*y.tolist())
        return [y[1], crank, y[3], shell]

    truth = solve_ivp(
        equations, (0.0, 0.05), [0.0, 90.0, 0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-14,
        max_step=2e-5,
    ).y[:, -1]  # fmt: skip
    assert np.all(np.abs(found.final[:4] - truth) < found.final_error[:4] + 1e-9)
    assert np.all(found.final_error[:4] < 1e-6)


@pytest.mark.long
def test_the_errors_bound_what_a_tight_run_finds() -> None:
    machine = source_machine(shell_stiffness=3e5, shell_damping=500.0)
    drive = straight_drive()
    right = start_up(machine, drive, duration=0.5, crank_angle=3.2, tolerance=1e-10)
    for tolerance in (1e-5, 1e-6, 1e-7):
        found = start_up(machine, drive, duration=0.5, crank_angle=3.2, tolerance=tolerance)
        off = np.abs(found.final - right.final)
        assert np.all(off <= found.final_error + right.final_error)
        assert np.all(
            np.abs(found.peaks.value - right.peaks.value) <= found.peaks.error + right.peaks.error
        )
        assert found.final_error[0] < 100.0 * tolerance


def test_verdicts_in_words() -> None:
    machine, drive = source_machine(), straight_drive()
    assert start_up(machine, drive, duration=0.6, crank_angle=1.0).verdict == "rocking"
    slow = straight_drive()._replace(
        motor=slip_curve([0.0, 2.0, 40.0, 94.3], [0.0, 900.0, 40.0, 400.0], "linear")
    )
    crawls = start_up(
        source_machine(gas_scale=[0.3, 0.3]),
        slow,
        duration=1.0,
        crank_angle=3.2,
        speed=30.0,
        tolerance=1e-6,
    )
    assert crawls.verdict == "crawling" and crawls.time_to_speed is None
    assert "does not pass the breakdown torque at 92.2" in crawls.reason
    with pytest.raises(NumericalFailure, match="the gas turns it backward"):
        start_up(machine, straight_drive(holds=False), duration=0.6, crank_angle=1.0)


def potential(
    machine: RollMachine, drive: RollDrive, torque: float, angle: np.ndarray
) -> np.ndarray:
    """Gas less motor, J: the work against both from angle 0 on, by Gauss-Legendre panels."""
    edges = np.linspace(0.0, 4.0 * np.pi, 145)
    place, weight = np.polynomial.legendre.leggauss(6)

    def work(low: np.ndarray, high: np.ndarray) -> np.ndarray:
        x = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * place
        flat = x.ravel()
        demand = np.sum(gas_forces(machine, drive, flat) * inertia(machine, flat).stroke, axis=-1)
        return np.sum((demand - torque).reshape(x.shape) * weight, axis=1) * 0.5 * (high - low)

    whole = np.concatenate([[0.0], np.cumsum(work(edges[:-1], edges[1:]))])
    cell = np.clip(np.searchsorted(edges, angle, side="right") - 1, 0, len(edges) - 2)
    return whole[cell] + work(edges[cell], angle)


@pytest.mark.long
def test_start_angles_are_those_above_every_later_hump_of_the_potential() -> None:
    """With one torque at every slip energy is kept: a closed form of the angles that start."""
    torque = 500.0
    machine = source_machine()
    drive = straight_drive()._replace(
        motor=constant_torque(torque), synchronous_speed=np.array(40.0)
    )
    found = start_angles(
        machine, drive, duration=3.0, angles=16, started_speed=15.0, width=1e-4, tolerance=1e-6
    )
    fine = np.linspace(0.0, 4.0 * np.pi, 200001)
    value = potential(machine, drive, torque, fine)
    later = np.maximum.accumulate(value[::-1])[::-1]
    starts = (value >= later - 1e-9)[:100000]
    fraction = np.mean(starts)
    assert 0.05 < fraction < 0.95
    assert found.fraction == pytest.approx(fraction, abs=found.fraction_error + 3e-5)
    rises = fine[1:100000][np.diff(starts.astype(int)) == 1]
    falls = fine[1:100000][np.diff(starts.astype(int)) == -1]
    ends = np.sort(np.mod(found.interval[:, 1], 2.0 * np.pi))
    begins = np.sort(np.mod(found.interval[:, 0], 2.0 * np.pi))
    assert begins == pytest.approx(rises, abs=found.error + 7e-5)
    assert ends == pytest.approx(falls, abs=found.error + 7e-5)
