"""Errors told by moved data: never below the truth in 40 digits, and not far above it."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors


class Motion(NamedTuple):
    response: Any
    names: tuple[str, ...]


def driven(mass: Any, stiffness: Any, damping: Any, force: Any, speed: Any) -> Motion:
    dynamic = stiffness + 1j * speed * damping - speed**2 * mass
    return Motion(np.linalg.solve(dynamic, force), ("first", "second", "third"))


def test_response_near_and_off_resonance() -> None:
    source = np.random.default_rng(4)
    ratios = []
    with mpmath.workdps(40):
        for _ in range(60):
            mass = np.diag(source.uniform(1.0, 50.0, 3))
            root = source.normal(size=(3, 3))
            stiffness = 1e5 * root @ root.T
            damping = stiffness * source.choice([1e-9, 1e-6, 1e-3])
            force = source.normal(size=3) + 1j * source.normal(size=3)
            natural = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
            near = 1.0 + source.choice([1e-7, 1e-4, 0.3])
            data = mass, stiffness, damping, force, float(source.choice(natural) * near)
            found = with_errors(driven, *data).response
            m, k, c, f = (mpmath.matrix(part.tolist()) for part in data[:4])
            w = mpmath.mpf(data[4])
            true = mpmath.lu_solve(k + mpmath.mpc(0, 1) * w * c - w**2 * m, f)
            off = [abs(complex(true[i] - mpmath.mpc(found.value[i]))) for i in range(3)]
            ratios.append(max(off / found.error))
    assert max(ratios) < 1.0
    assert np.median(ratios) > 1e-3


def test_error_of_the_data_and_of_the_method_enter() -> None:
    def area(radius: Any, sides: int) -> Any:
        return 0.5 * sides * np.sin(2.0 * np.pi / sides) * radius**2

    data = Bounded(np.array([2.0, 3.0]), np.array([0.0, 0.01]))
    found = with_errors(area, data, 1000, coarser=lambda radius, sides: area(radius, sides // 2))
    truth = np.pi * np.square([2.0, 3.0])
    assert np.all(np.abs(found.value - truth) < found.error)
    assert found.error[0] < 5.0 * abs(found.value[0] - truth[0])
    assert found.error[1] == pytest.approx(2.0 * 3.0 * 0.01 * np.pi, rel=0.01)


@dataclass(frozen=True)
class Line:
    length: float
    count: int
    loads: dict[str, Any]


def test_structures_go_in_and_come_out() -> None:
    def total(line: Line) -> dict[str, Any]:
        ahead, back = line.loads["ahead"], line.loads["back"]
        return {"sum": ahead + back, "far": np.array([np.inf, line.length]), "count": line.count}

    ahead = np.array([0.1, 1.0])
    found = with_errors(total, Line(2.0, 3, {"ahead": ahead, "back": -ahead}))
    assert found["count"] == 3
    assert np.all(found["sum"].value == 0.0)
    assert np.all((found["sum"].error > 0.0) & (found["sum"].error < 2e-15))
    assert found["far"].error[0] == 0.0
    assert found["far"].error[1] < 2e-15
