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
from scipy.linalg import eigh
from switching_machines import Body, Course, marched

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities

STEM = "response/switching"


def switching(**options: Any) -> Table:
    """The shipped change, shortened; options of the table alongside."""
    table = shipped("compressor_switching")
    table["accuracy"] = {"rtol": 1e-9}
    table["response"]["energies"] = False
    times = {"run_down": "0.3 s", "dwell": "0.05 s", "run_up": "0.2 s", "time_after": "0.5 s"}
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
        mass = si_matrix(table, "body", "mass_matrix")
        stiffness = si_matrix(table, "mounts", "stiffness_matrix")
        square, shape = eigh(stiffness, mass)
        rate = 2.0 * 0.03 * np.sqrt(square)
        self.body = Body(mass, stiffness, mass @ shape @ np.diag(rate) @ shape.T @ mass)
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
        float(options[key].removesuffix(" s"))
        for key in ("run_down", "dwell", "run_up", "time_after")
    )
    speed = 361.0
    back = speed * (-1.0 if options["reverses"] else 1.0)
    return [
        (down, speed, 0.0, before),
        (stand, 0.0, 0.0, after),
        (up, 0.0, back, after),
        (end, back, back, after),
    ]


def integrated(
    machine: Machine, course: Course, angle: float, before: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Times, 32 and more in each turn of the second order, and states (times, 12) on the way."""
    end = sum(piece[0] for piece in course)
    times = np.linspace(0.0, end, int(end * 361.0 / (2.0 * np.pi) * 64) + 2)
    states = marched(
        machine.body, machine.load, course, times, before=before, angle=angle, rtol=1e-7
    )
    return times, states


def readings(body: Body, states: np.ndarray) -> dict[str, np.ndarray]:
    """Largest magnitude of each reading."""
    place, pace = states[:, :6], states[:, 6:]
    ground = np.abs(place @ body.stiffness + pace @ body.damping).max(axis=0)
    moved = np.abs(place).max(axis=0)
    return {
        "translation_peak": moved[:3],
        "rotation_peak": moved[3:],
        "ground_force_peak": ground[:3],
        "ground_couple_peak": ground[3:],
        "kinetic_energy_peak": 0.5 * np.einsum("ti,ij,tj->t", pace, body.mass, pace).max(),
        "potential_energy_peak": 0.5 * np.einsum("ti,ij,tj->t", place, body.stiffness, place).max(),
    }


def same_peaks(record: Record, way: str, change: int, want: dict[str, np.ndarray]) -> None:
    """Samples stay below the true peaks and come close to them."""
    for name, seen in want.items():
        ours = record[f"{STEM}/{way}/{name}"].values[change]
        size = np.max(np.abs(ours))
        assert np.all(seen <= ours + 1e-5 * size), name
        assert np.abs(ours - seen).max() <= 4e-3 * size, name


WAYS = {"A+B": ["A", "B"], "A": ["A"]}


@pytest.mark.long
@pytest.mark.parametrize(
    ("reverses", "angle", "unbalanced", "changes"),
    [
        (True, 0.0, False, (1,)),
        (True, 0.0, False, (0,)),
        (False, 2.3, True, (0, 1)),
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
        same_peaks(record, "reversal", change, readings(machine.body, states))
        energy = 0.5 * np.einsum("ti,ij,tj->t", states[:, 6:], machine.body.mass, states[:, 6:])
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
        same_peaks(record, "instant", change, readings(machine.body, states))
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
