"""Claim: a machine that cannot be is refused, at the key that says it, in words with numbers.

Unlikely machines get a sentence in the report instead.
"""

import tomllib
from typing import Any

import numpy as np
import pytest
from crank_trains import GENERATOR, generator
from pydantic import ValidationError
from refused import problems_of

from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.machine import build_machine
from vibecalc.schema import Case

TRAIN = ("machine", "crank_train")
MOUNTS = ("machine", "mounts")
FLAT = [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.4, -0.2, 0.0], [0.4, 0.2, 0.0]]
RIGID: dict[str, Any] = {"isolation": {"model": "rigid_body"}}


def only(case: Case) -> Problem:
    problems = check_machine(case)
    assert len(problems) == 1, problems
    return problems[0]


def words(problem: Problem) -> str:
    return " | ".join((problem.message, problem.found, problem.allowed, problem.hint))


def test_the_generator_has_neither_problems_nor_warnings() -> None:
    for case in (generator(), generator(**RIGID)):
        assert check_machine(case) == []
        assert machine_warnings(case) == []


REFUSED: list[tuple[str, dict[str, Any], KeyPath, list[str]]] = [
    (
        "rod shorter than crank",
        {"machine__crank_train__rod_length": 0.055},
        (*TRAIN, "rod_length"),
        ["connecting rod must be longer than the crank radius |", "0.055 m", "> 0.06 m", "0.17 to"],
    ),
    (
        "rod shorter with offset",
        {
            "machine__crank_train__rod_length": 0.065,
            "machine__crank_train__wrist_pin_offset": -0.006,
        },
        (*TRAIN, "rod_length"),
        ["crank radius plus the wrist-pin offset", "0.065 m", "> 0.066 m"],
    ),
    (
        "rod as long as crank",
        {"machine__crank_train__rod_length": 0.06},
        (*TRAIN, "rod_length"),
        ["must be longer", "0.06 m | > 0.06 m"],
    ),
    (
        "stroke along the shaft",
        {"machine__crank_train__stroke": "x", "isolation": None},
        (*TRAIN, "stroke"),
        ["pistons cannot move along the crankshaft", "stroke = 'x', and axis = 'x'", "'y' or 'z'"],
    ),
    (
        "truncated with offset",
        {
            "machine__crank_train__wrist_pin_offset": 0.004,
            "kinematics": {"series": "truncated", "terms": 1},
        },
        ("kinematics", "series"),
        ["no term for a wrist-pin offset", "0.004 m", "series = 'exact'"],
    ),
    (
        "nothing moves",
        {"machine__crank_train__reciprocating_mass": 0.0},
        (*TRAIN, "reciprocating_mass"),
        ["nothing in the crank train has a mass", "a mass above zero"],
    ),
    (
        "rod's mass centre outside",
        {
            "machine__crank_train__reciprocating_mass": None,
            "machine__crank_train__piston_mass": 0.3,
            "machine__crank_train__rod": {"mass": 0.5, "crank_pin_to_mass_centre": 0.25},
        },
        (*TRAIN, "rod", "crank_pin_to_mass_centre"),
        ["beyond its wrist pin", "0.25 m", "0.2 m"],
    ),
    (
        "grams as kilograms",
        {"machine__crank_train__reciprocating_mass": 400.0},
        ("machine", "body", "mass"),
        ["weigh more than the whole machine", "100 kg, with 1200 kg", "'400 g'"],
    ),
    (
        "too heavy to compute",
        {"machine__crank_train__reciprocating_mass": 1e300},
        (*TRAIN, "reciprocating_mass"),
        ["too large to compute with", "1e+300", "1e+20"],
    ),
    (
        "too light to compute",
        {"machine__body__mass": 1e-300},
        ("machine", "body", "mass"),
        ["too small to compute with", "1e-300"],
    ),
    (
        "far mount",
        {"machine__mounts__positions": [[1e200, 0.0, 0.0]]},
        (*MOUNTS, "positions", 0, 0),
        ["too large to compute with", "1e+200"],
    ),
    (
        "angle without meaning",
        {"machine__crank_train__cylinders": [{"name": "1", "crank_phase": 1e18}]},
        (*TRAIN, "cylinders", 0, "crank_phase"),
        ["angle is too large", "1e+18 rad", "'120 deg'"],
    ),
    (
        "triangle inequality",
        {"machine__body__box": None, "machine__body__inertia": [1.0, 2.0, 6.5]},
        ("machine", "body", "inertia"),
        ["no body has these moments", "1, 2, 6.5 kg*m^2", "at most 3 kg*m^2"],
    ),
    (
        "products too large",
        {
            "machine__body__box": None,
            "machine__body__inertia": [2.0, 3.0, 4.0],
            "machine__body__inertia_products": [2.6, 0.0, 0.0],
        },
        ("machine", "body", "inertia_products"),
        ["too large for its moments", "all principal moments > 0"],
    ),
    (
        "up is not the stroke",
        {"isolation__up": "y"},
        ("isolation", "up"),
        ["up must be the direction of the stroke", "up = 'y', and stroke = 'z'", "'rigid_body'"],
    ),
    (
        "free to pitch: mounts under the centre",
        {
            "machine__mounts__positions": [[0.0, -0.2, 0.0], [0.0, 0.2, 0.0]],
            "isolation__lever": 0.4,
        },
        MOUNTS,
        ["leave the body free to pitch", "nothing resists turning about y"],
    ),
    (
        "free to pitch: sideways stiffness only",
        {"machine__mounts__each": {"stiffness": [1e4, 1e4, 0.0]}},
        MOUNTS,
        ["leave the body free to pitch", "stiffness along the stroke"],
    ),
    (
        "ambiguous lever",
        {"machine__mounts__positions": [[-0.4, 0.0, 0.0], [0.3, 0.0, 0.0]]},
        ("isolation", "lever"),
        ["the lever of lever_force has to be given", "from 0.3 to 0.4 m"],
    ),
    (
        "block moves the centre and the levers with it",
        {
            "machine__body__inertia_block": {
                "mass": 10.0,
                "box": {"length": 0.2, "width": 0.2, "height": 0.1},
                "position": [0.2, 0.0, 0.0],
            }
        },
        ("isolation", "lever"),
        ["different distances from the mass centre", "0.381818 to 0.418182 m"],
    ),
]


@pytest.mark.parametrize(
    ("changes", "path", "expected"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED]
)
def test_refused(changes: dict[str, Any], path: KeyPath, expected: list[str]) -> None:
    problem = only(generator(**changes))
    assert problem.path == path
    for word in expected:
        assert word in words(problem)


def test_a_negative_moment_of_inertia() -> None:
    data = tomllib.loads(GENERATOR)
    data["machine"]["body"] = {"mass": 400.0, "inertia": [1.0, -2.0, 2.0]}
    (problem,) = problems_of(data)
    assert problem.path == ("machine", "body", "inertia", 1)
    assert "out of range" in problem.message and problem.found == "-2 kg*m^2"


FREE: list[tuple[str, Any, list[list[float]], str]] = [
    (
        "vertical springs only",
        [0.0, 0.0, 1e4],
        FLAT,
        "turning about z, moving along x, moving along y",
    ),
    ("no sideways stiffness", [1e4, 0.0, 1e4], FLAT, "moving along y"),
    (
        "all on a line under the centre",
        1e4,
        [[-0.4, 0.0, -0.2], [0.4, 0.0, -0.2]],
        "turning about x through (0, 0, -0.2) m",
    ),
    (
        "one ball joint",
        [1e4, 2e4, 3e4],
        [[0.1, 0.0, -0.3]],
        "turning about x through (0, 0, -0.3) m, turning about y through (0.1, 0, -0.3) m, "
        "turning about z through (0.1, 0, 0) m",
    ),
    ("zero stiffness", 0.0, FLAT, "moving along z"),
    ("line askew", 1e4, [[0.3, 0.3, 0.0], [-0.3, -0.3, 0.0]], "turning about (0.707, 0.707, 0)"),
]


@pytest.mark.parametrize(
    ("stiffness", "positions", "expected"), [row[1:] for row in FREE], ids=[row[0] for row in FREE]
)
def test_free_motions_have_names(stiffness: Any, positions: Any, expected: str) -> None:
    case = generator(
        machine__mounts={"each": {"stiffness": stiffness}, "positions": positions}, **RIGID
    )
    problem = only(case)
    assert problem.path == MOUNTS
    assert problem.message == "the mounts leave the body free"
    assert expected in problem.found


def test_pitch_asks_for_no_other_stiffness() -> None:
    case = generator(machine__mounts__each={"stiffness": [0.0, 0.0, 1e4]})
    assert check_machine(case) == []


def test_stiffness_many_decades_apart_is_not_free() -> None:
    case = generator(machine__mounts__each={"stiffness": [1.0, 1e12, 1e4]}, **RIGID)
    assert check_machine(case) == []


def test_all_problems_come_at_once() -> None:
    case = generator(
        machine__crank_train__rod_length=0.05,
        machine__crank_train__stroke="x",
        machine__body__box=None,
        machine__body__inertia=[1.0, 1.0, 9.0],
    )
    assert [problem.path[1:] for problem in check_machine(case)] == [
        ("crank_train", "stroke"),
        ("crank_train", "rod_length"),
        ("body", "inertia"),
    ]


def test_contradictions_point_to_both_lines() -> None:
    rod = only(generator(machine__crank_train__rod_length=0.05))
    assert rod.also == (*TRAIN, "crank_radius")
    assert only(generator(isolation__up="y")).also == (*TRAIN, "stroke")


def cylinders(**changes: Any) -> list[dict[str, Any]]:
    return [{"name": "1", "position": -0.3}, {"name": "2", "position": 0.3, **changes}]


WARNED: list[tuple[str, dict[str, Any], list[str]]] = [
    ("rpm as rad/s", {"machine__speed": 4900.0}, ["mean piston speed is 187 m/s", "'4900 rpm'"]),
    (
        "degrees as radians",
        {"machine__crank_train__cylinders": cylinders(crank_phase=120.0)},
        ["crank_phase of cylinder '2' is 120 rad", "'120 deg'"],
    ),
    (
        "same place",
        {"machine__crank_train__cylinders": cylinders(position=-0.3)},
        ["cylinders '1' and '2' stand in the same place, at position -0.3 m"],
    ),
    (
        "kN/m as N/m",
        {"machine__mounts__each__stiffness": 10.0},
        ["sinks by about 24.5 m", "'10 kN/m'"],
    ),
    (
        "shaft above the orders",
        {
            "excitation": {"orders": 1},
            "machine__crank_train__balance_shafts": [
                {"name": "left", "unbalance": 1e-3, "speed_ratio": -2}
            ],
        },
        ["balance shaft 'left' turns at 2 times the crank speed and is left out"],
    ),
    (
        "bounce coupled with pitch",
        {
            "isolation__lever": 0.4,
            "machine__mounts__positions": [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.3, 0.0, 0.0]],
        },
        ["pitch is coupled with motion along z:", "rigid_body is exact"],
    ),
    (
        "mounts below the centre",
        {"machine__mounts__positions": [[x, y, -0.2] for x, y, _ in FLAT]},
        ["leaves out 25 % of the pitch stiffness"],
    ),
    (
        "products of inertia",
        {
            "machine__body__box": None,
            "machine__body__inertia": [3.0, 6.0, 7.0],
            "machine__body__inertia_products": [0.5, 0.0, 0.0],
        },
        ["pitch is coupled with turning about x"],
    ),
]


@pytest.mark.parametrize(
    ("changes", "expected"), [row[1:] for row in WARNED], ids=[row[0] for row in WARNED]
)
def test_warned(changes: dict[str, Any], expected: list[str]) -> None:
    case = generator(**changes)
    assert check_machine(case) == []
    text = "\n".join(machine_warnings(case))
    for word in expected:
        assert word in text


def test_exact_models_are_not_warned_about() -> None:
    below = [[x, y, -0.2] for x, y, _ in FLAT]
    assert machine_warnings(generator(machine__mounts__positions=below, **RIGID)) == []


RICH = GENERATOR.replace('model = "pitch"', 'model = "MODEL"').replace(
    "box = {",
    "inertia_block = { mass = 5.0, box = { length = 1.0, width = 1.0, height = 0.1 }, "
    "position = [0.1, 0.2, -0.3] }\nbox = {",
)
EXTREMES = [0.0, -0.0, 5e-324, 1e-300, 1e-21, 1e-19, 1e-9, 1.0, -1.0, 1e9, 1e19, -1e19, 1e21, 1e308]


def leaves(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Key paths of all numbers of a case."""
    if isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else enumerate(value)
        return [leaf for key, entry in entries for leaf in leaves(entry, (*path, key))]
    return [path] if isinstance(value, float) else []


def test_extreme_numbers_are_refused_or_computed_with() -> None:
    """Five hundred seeded mutations: problems in words, or finite arrays; no overflow, no crash."""
    rng = np.random.default_rng(42)
    refused = built = 0
    for _ in range(500):
        data = tomllib.loads(RICH.replace("MODEL", str(rng.choice(["pitch", "rigid_body"]))))
        paths = leaves(data)
        for _ in range(int(rng.integers(1, 4))):
            *tables, last = paths[int(rng.integers(len(paths)))]
            table = data
            for key in tables:
                table = table[key]
            table[last] = float(rng.choice(EXTREMES))
        try:
            case = Case.model_validate(data)
        except ValidationError:
            continue
        problems = check_machine(case)
        refused += bool(problems)
        assert all(problem.message and problem.allowed for problem in problems)
        if problems:
            continue
        parts = build_machine(case)
        assert all(isinstance(text, str) for text in machine_warnings(case))
        assert parts.body is not None
        assert parts.mounts is not None
        for array in (parts.body.mass_matrix, parts.mounts.stiffness, parts.crank_train.position):
            assert np.isfinite(array).all()
        built += 1
    assert refused > 50
    assert built > 50
