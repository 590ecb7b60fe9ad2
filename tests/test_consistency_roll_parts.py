"""Claim: the arrays of the roll say what the case says, each checked by another way to it."""

import copy
import math
import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import set_key
from vibecalc.excitation.gas_tables import force_at
from vibecalc.excitation.rod_inertia import split_inertia
from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.kinematics.slider_crank import piston_motion
from vibecalc.parts.crank_train import build_crank_train
from vibecalc.roll.mechanism import inertia, is_mounted
from vibecalc.roll.model import RollParts, build_roll, mean_demand, motor_curve, roll_drive

ROLL = tomllib.loads(starter("roll"))

TRAIN = """
crank_radius = 0.05
rod_length = 0.23
wrist_pin_offset = 0.004
piston_mass = 5.0
rotating_mass = 0.8
rod = { mass = 3.0, crank_pin_to_mass_centre = 0.07, inertia = 0.025 }
bore = 0.1
gas_pressure = { crank_angle = [0.0, 1.0, 4.0, "360 deg"], pressure = [5e5, 0.0, 1e5, 5e5] }
cylinders = [
  { name = "1", bank_angle = "-45 deg" },
  { name = "2", bank_angle = "45 deg", crank_phase = "10 deg", reciprocating_mass = 4.0 },
  { name = "3", crank_phase = "120 deg" },
]
"""
OWN = {"crank_angle": [f"{a} deg" for a in (0, 90, 180, 270, 360)], "force": [9e3, 0, 0, 2e3, 9e3]}


def parts(**changes: Any) -> RollParts:
    return build_roll(case_of(**changes))


def case_of(**changes: Any) -> Any:
    data = copy.deepcopy(ROLL)
    data["machine"]["crank_train"] = tomllib.loads(TRAIN)
    for key, value in changes.items():
        set_key(data, key.replace("__", ".").replace("cylinders.2", "cylinders[2]"), value)
    return validate(data)


def test_angles_masses_and_inertia() -> None:
    found = parts()
    machine, rod = found.machine, 3.0 * 0.07 / 0.23
    assert found.names == ("1", "2", "3")
    wanted = np.radians([45.0, 10.0 - 45.0, 120.0])
    np.testing.assert_allclose(machine.crank_angle_offset, wanted, rtol=1e-15)
    np.testing.assert_allclose(machine.reciprocating_mass, [5.0 + rod, 4.0, 5.0 + rod], rtol=1e-14)
    pins = 3 * (0.8 + 3.0 - rod) * 0.05**2
    assert float(machine.rotor_inertia) == pytest.approx(1.6 + pins, rel=1e-14)
    difference = 0.025 - float(split_inertia(3.0, 0.07, 0.23).value)
    np.testing.assert_allclose(machine.rod_inertia_difference, difference, rtol=1e-12)
    assert is_mounted(machine)
    assert float(machine.shell_stiffness) == 90e3 and float(machine.piston_friction) == 60.0
    assert not is_mounted(parts(machine__shell={"inertia": 5.0}).machine)


def test_kinetic_energy_is_that_of_the_bodies() -> None:
    """Of rotor, shell, pistons, pins and rods in the plane, from their own motion."""
    case = case_of()
    machine, train = build_roll(case).machine, build_crank_train(case.machine.crank_train)
    w, s, step = 90.0, 3.0, 1e-5

    def places(time: float) -> list[tuple[float, np.ndarray]]:
        """Mass and place (3, 2) of every point: pistons with the rod's share, and crank pins."""
        shell, crank = s * time, 0.7 + w * time
        along = train.bank_angle + shell
        turned = crank + train.crank_phase + shell
        axis = np.stack([np.cos(along), np.sin(along)], -1)
        side = np.stack([-np.sin(along), np.cos(along)], -1)
        pin = 0.05 * np.stack([np.cos(turned), np.sin(turned)], -1)
        away = piston_motion(crank + train.crank_phase - train.bank_angle, 0.05, 0.23, 0.004)
        wrist = away.position[:, None] * axis + 0.004 * side
        return [(m, place) for m, place in ((train.reciprocating_mass, wrist),
                                            (train.rotating_mass, pin))]  # fmt: skip

    energy = 0.5 * 1.6 * (w + s) ** 2 + 0.5 * 85.0 * s**2
    for (mass, later), (_, sooner) in zip(places(step), places(-step), strict=True):
        velocity = (later - sooner) / (2.0 * step)
        energy += 0.5 * float(np.sum(mass * np.sum(velocity**2, axis=1)))
    angles = []
    for time in (step, -step):
        (_, wrist), (_, pin) = places(time)
        rod = wrist - pin
        angles.append(np.arctan2(rod[:, 1], rod[:, 0]))
    rate = (np.mod(angles[0] - angles[1] + np.pi, 2.0 * np.pi) - np.pi) / (2.0 * step)
    energy += 0.5 * float(np.sum(machine.rod_inertia_difference * rate**2))
    moved = inertia(machine, np.array([0.7]))
    ours = 0.5 * (moved.shell * s**2 + 2.0 * moved.coupling * s * w + moved.crank * w**2)
    assert float(ours[0]) == pytest.approx(energy, rel=1e-8)


def test_pressure_times_area_and_own_tables() -> None:
    found = parts(machine__crank_train__cylinders__2__gas_force=OWN)
    first, second, third = found.gas
    assert first is not None and second is not None and third is not None
    np.testing.assert_allclose(first.force, [5e5 * math.pi / 400, 0, 1e5 * math.pi / 400,
                                             5e5 * math.pi / 400], rtol=1e-14)  # fmt: skip
    np.testing.assert_array_equal(third.force, OWN["force"])
    assert found.interpolations == ("linear", "parabola", "cubic")  # the pressure is not even
    even = parts(machine__crank_train__gas_pressure={
        "crank_angle": OWN["crank_angle"], "pressure": [1e5, 0, 0, 0, 1e5]})  # fmt: skip
    assert even.interpolations[-1] == "trigonometric"
    drive = roll_drive(found, "linear")
    assert drive.gas[2] is not None and not drive.holds
    assert float(force_at(drive.gas[2], np.array([0.25 * math.pi]))[0]) == pytest.approx(4500.0)
    assert roll_drive(parts(machine__motor__extrapolation="hold")).holds


def test_cylinders_that_do_not_work() -> None:
    stopped = parts(excitation={"working": ["1", "3"]})
    unloaded = parts(excitation={"working": ["1", "3"], "idle": "unloaded"})
    for found in (stopped, unloaded):
        assert [gas is None for gas in found.gas] == [False, True, False]
    assert stopped.machine.reciprocating_mass[1] == 0.0 == stopped.machine.rod_inertia_difference[1]
    assert unloaded.machine.reciprocating_mass[1] == 4.0
    assert unloaded.machine.rod_inertia_difference[1] == unloaded.machine.rod_inertia_difference[0]
    assert unloaded.machine.rotor_inertia > stopped.machine.rotor_inertia


def test_mean_demand_is_the_work_of_a_turn() -> None:
    case = case_of()
    built = build_roll(case)
    drive, work = roll_drive(built), 0.0
    for gas, offset in zip(drive.gas, built.machine.crank_angle_offset, strict=True):
        assert gas is not None

        def push(b: float, gas: Any = gas, offset: float = float(offset)) -> float:
            slope = float(piston_motion(b + offset, 0.05, 0.23, 0.004).velocity)
            return float(force_at(gas, np.array([b + offset]))[0]) * slope + 60.0 * abs(slope)

        kinks = sorted(float(np.mod(node - offset, 2 * np.pi)) for node in gas.node)
        work += quad(push, 0.0, 2.0 * np.pi, points=kinks, limit=400)[0]
    viscous = 0.15 * float(drive.synchronous_speed)
    assert mean_demand(case) == pytest.approx(work / (2.0 * np.pi) + viscous, rel=1e-4)


def test_motors() -> None:
    case = case_of()
    curve = motor_curve(case.machine.motor)
    rows = case.machine.motor.slip_table
    np.testing.assert_allclose(
        slip_torque(curve, np.array(rows.slip)).value, rows.torque, atol=1e-9
    )
    linear = case_of(
        machine__motor={"kind": "linear", "synchronous_speed": "900 rpm", "gain": 20.0}
    )
    assert float(slip_torque(motor_curve(linear.machine.motor), np.array([-3.0])).value[0]) == -60.0
