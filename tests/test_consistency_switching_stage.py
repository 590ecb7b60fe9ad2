"""Claim: a change between operations in a case is what a general integrator makes of the machine.

The whole body in its six coordinates, from the matrices of the case and forces that are formed
here from the piston's exact acceleration, against the stage's peaks and readings.
"""

import copy
from functools import cache
from typing import Any

import numpy as np
import pytest
from random_machines import Table
from response_machines import run, shipped, si_matrix
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities

STEM = "response/switching"
#: profile of the way: duration, speeds at its ends, cylinders at work
Course = list[tuple[float, float, float, list[str]]]


def switching(**options: Any) -> Table:
    """The shipped change, shortened; options of the table alongside."""
    table = shipped("compressor_switching")
    table["accuracy"] = {"rtol": 1e-9}
    table["response"]["energies"] = False
    times = {"run_down": "0.3 s", "stand": "0.05 s", "run_up": "0.2 s", "after": "0.5 s"}
    table["response"]["switching"] |= times | options
    return table


@cache
def found(reverses: bool = True, angle: float = 0.0, unbalanced: bool = False) -> Record:
    """All of the stage but the slow passage, which takes longest."""
    table = case_of(reverses, angle, unbalanced)
    planned = planned_quantities(validate(copy.deepcopy(table)))
    return run(table, *(path for path in planned if "slow" not in path))


TOP = f"{STEM}/instant/kinetic_energy_peak"


def case_of(reverses: bool, angle: float, unbalanced: bool) -> Table:
    table = switching(reverses=reverses, crank_angle=angle)
    table["accuracy"]["rtol"] = 1e-6
    if unbalanced:
        del table["excitation"]["balanced_for"]
    return table


class Machine:
    """Matrices (6, 6) and the load on the body at a crank angle, speed and acceleration."""

    def __init__(self, table: Table) -> None:
        self.mass = si_matrix(table, "body", "mass_matrix")
        self.stiffness = si_matrix(table, "mounts", "stiffness_matrix")
        square, shape = eigh(self.stiffness, self.mass)
        rate = 2.0 * 0.03 * np.sqrt(square)
        self.damping = self.mass @ shape @ np.diag(rate) @ shape.T @ self.mass
        self.inverse = np.linalg.inv(self.mass)
        self.balanced = table["excitation"].get("balanced_for", [])
        self.radius, self.length = 0.5 * 0.0254, 2.375 * 0.0254
        pound, share = 0.45359237, 0.625 / 2.375
        self.piston = (0.659 + 0.075 + 0.131 * share) * pound
        self.throw = 0.131 * (1.0 - share) * pound
        self.places = {"A": (-3.835 * 0.0254, 0.0), "B": (-5.710 * 0.0254, np.pi)}

    def load(self, working: list[str], angle: float, speed: float, gain: float) -> np.ndarray:
        total = np.zeros(6)
        for name, (place, phase) in self.places.items():
            a = angle + phase
            # stroke y, across x, axis z: the crank turns from y towards minus x
            force = np.zeros(3)
            if name in working:
                sine, cosine = np.sin(a), np.cos(a)
                lean = self.radius * sine / self.length
                root = np.sqrt(1.0 - lean**2)
                tilt = self.radius * cosine / (self.length * root)
                slope = -self.radius * sine - self.length * lean * tilt
                bend = -self.radius * cosine - self.length * (root * tilt**2 + lean * (
                    -self.radius * sine / self.length + lean * tilt**2) / root)  # fmt: skip
                force[1] -= self.piston * (bend * speed**2 + slope * gain)
            weigh = self.throw * self.radius * ((name in working) - (name in self.balanced))
            radial, ahead = np.array([-np.sin(a), np.cos(a)]), np.array([-np.cos(a), -np.sin(a)])
            force[:2] += weigh * (radial * speed**2 - ahead * gain)
            total += np.concatenate([force, [-place * force[1], place * force[0], 0.0]])
        return total


def course_of(table: Table, before: list[str], after: list[str]) -> Course:
    options = table["response"]["switching"]
    down, stand, up, end = (
        float(options[key].removesuffix(" s")) for key in ("run_down", "stand", "run_up", "after")
    )
    speed = 361.0
    back = speed * (-1.0 if options["reverses"] else 1.0)
    return [
        (down, speed, 0.0, before),
        (stand, 0.0, 0.0, after),
        (up, 0.0, back, after),
        (end, back, back, after),
    ]


def steady_start(machine: Machine, working: list[str], angle: float) -> np.ndarray:
    """Place and velocity (12,) of the steady motion at a crank angle, by samples of the load."""
    speed, count = 361.0, 256
    turns = np.arange(count) * (2.0 * np.pi / count)
    waves = np.fft.fft([machine.load(working, a, speed, 0.0) for a in turns], axis=0) / count
    state = np.zeros(12)
    for n in range(1, 40):
        rate = n * speed
        dynamic = machine.stiffness + 1j * rate * machine.damping - rate**2 * machine.mass
        moved = np.linalg.solve(dynamic, 2.0 * waves[n]) * np.exp(1j * n * angle)
        state += np.concatenate([moved.real, (1j * rate * moved).real])
    return state


def integrated(
    machine: Machine, course: Course, angle: float, before: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Times and states (times, 12) on the way."""
    state, start = steady_start(machine, before, angle), 0.0
    times, states = [], []
    for duration, first, last, working in course:
        gain = (last - first) / duration

        def law(
            t: float, y: np.ndarray, first: float = first, gain: float = gain,
            angle: float = angle, working: list[str] = working,
        ) -> np.ndarray:  # fmt: skip
            turned = angle + first * t + 0.5 * gain * t * t
            load = machine.load(working, turned, first + gain * t, gain)
            pull = machine.stiffness @ y[:6] + machine.damping @ y[6:]
            return np.concatenate([y[6:], machine.inverse @ (load - pull)])

        # 32 points and more in each turn of the second order
        points = np.linspace(0.0, duration, int(duration * 361.0 / (2.0 * np.pi) * 64) + 2)
        done = solve_ivp(law, (0.0, duration), state, method="DOP853", t_eval=points, rtol=1e-7,
                         atol=1e-10 * np.max(np.abs(state)))  # fmt: skip
        assert done.success
        times.append(start + done.t), states.append(done.y.T)
        state, start = done.y[:, -1], start + duration
        angle += 0.5 * (first + last) * duration
    return np.concatenate(times), np.concatenate(states)


def readings(machine: Machine, states: np.ndarray) -> dict[str, np.ndarray]:
    """Largest magnitude of each reading."""
    place, pace = states[:, :6], states[:, 6:]
    ground = np.abs(place @ machine.stiffness + pace @ machine.damping).max(axis=0)
    moved = np.abs(place).max(axis=0)
    return {
        "translation_peak": moved[:3],
        "rotation_peak": moved[3:],
        "ground_force_peak": ground[:3],
        "ground_couple_peak": ground[3:],
        "kinetic_energy_peak": 0.5 * np.einsum("ti,ij,tj->t", pace, machine.mass, pace).max(),
        "potential_energy_peak": 0.5
        * np.einsum("ti,ij,tj->t", place, machine.stiffness, place).max(),
    }


def same_peaks(record: Record, way: str, change: int, want: dict[str, np.ndarray]) -> None:
    """Samples stay below the true peaks and come close to them."""
    for name, seen in want.items():
        ours = record[f"{STEM}/{way}/{name}"].values[change]
        size = np.max(np.abs(ours))
        assert np.all(seen <= ours + 1e-5 * size), name
        assert np.abs(ours - seen).max() <= 4e-3 * size, name


WAYS = {"A+B": ["A", "B"], "A": ["A"]}


@pytest.mark.parametrize(
    ("reverses", "angle", "unbalanced", "changes"),
    [
        (True, 0.0, False, (1,)),
        pytest.param(True, 0.0, False, (0,), marks=pytest.mark.long),
        pytest.param(False, 2.3, True, (0, 1), marks=pytest.mark.long),
    ],
)
def test_peaks_of_the_real_change(
    reverses: bool, angle: float, unbalanced: bool, changes: tuple[int, ...]
) -> None:
    table = case_of(reverses, angle, unbalanced)
    record, machine = found(reverses, angle, unbalanced), Machine(table)
    for change in changes:
        before, after = (("A+B", "A"), ("A", "A+B"))[change]
        course = course_of(table, WAYS[before], WAYS[after])
        times, states = integrated(machine, course, angle, WAYS[before])
        same_peaks(record, "reversal", change, readings(machine, states))
        energy = 0.5 * np.einsum("ti,ij,tj->t", states[:, 6:], machine.mass, states[:, 6:])
        top = record[f"{STEM}/reversal/peak_time"].values[change]
        assert times[np.argmax(energy)] == pytest.approx(top, abs=2e-3)
    last = record[f"{STEM}/reversal/speed"].values[:, -1]
    assert last == pytest.approx(-361.0 if reverses else 361.0, rel=1e-12)


@pytest.mark.parametrize(
    ("angle", "unbalanced"), [(0.0, False), pytest.param(2.3, True, marks=pytest.mark.long)]
)
def test_peaks_of_the_change_at_once(angle: float, unbalanced: bool) -> None:
    table = case_of(angle == 0.0, angle, unbalanced)
    record, machine = found(angle == 0.0, angle, unbalanced), Machine(table)
    for change, (before, after) in enumerate((("A+B", "A"), ("A", "A+B"))):
        course: Course = [(0.5, 361.0, 361.0, WAYS[after])]
        _, states = integrated(machine, course, angle, WAYS[before])
        same_peaks(record, "instant", change, readings(machine, states))
        worst = record[f"{STEM}/instant/worst_kinetic_energy_peak"].values[change]
        assert worst >= record[f"{STEM}/instant/kinetic_energy_peak"].values[change] * (1 - 1e-9)


@pytest.mark.long
def test_the_worst_angle_is_the_worst() -> None:
    record = found()
    for change in (0, 1):
        angle = float(record[f"{STEM}/instant/worst_angle"].values[change])
        there = run(case_of(True, angle, False), TOP)[TOP].values[change]
        assert there == pytest.approx(
            record[f"{STEM}/instant/worst_kinetic_energy_peak"].values[change], rel=1e-7
        )
        for turn in (-0.4, 0.4):
            assert run(case_of(True, angle + turn, False), TOP)[TOP].values[change] < there


def test_steady_energy_is_that_of_the_operations() -> None:
    table = switching()
    table["response"]["energies"] = True
    record = run(table, f"{STEM}/steady_energy", "response/operations/kinetic_energy/peak")
    ours = record[f"{STEM}/steady_energy"].values
    other = record["response/operations/kinetic_energy/peak"].values[:, 0]
    assert ours == pytest.approx(other, rel=1e-9)


def test_damping_that_couples_modes_is_said() -> None:
    table = switching()
    mounts = table["machine"]["mounts"]
    shown = (f"{STEM}/steady_energy", "response/modes/shape", "response/modes/natural_frequency")
    assert not any("couples" in text for text in run(table, *shown).warnings)
    damping = np.diag([40.0, 3.0, 40.0, 0.5, 0.5, 0.5])
    mounts["damping_matrix"] = {"values": damping.tolist()}
    record = run(table, *shown)
    (warning,) = [text for text in record.warnings if "couples the modes" in text]
    shapes, mass = record["response/modes/shape"].values, si_matrix(table, "body", "mass_matrix")
    natural = record["response/modes/natural_frequency"].values
    whole = damping + mass @ shapes.T @ np.diag(0.06 * natural) @ shapes @ mass
    between = np.abs(shapes @ whole @ shapes.T)
    own = np.diagonal(between).max()
    np.fill_diagonal(between, 0.0)
    assert f"{100.0 * between.max() / own:.2g} %" in warning
