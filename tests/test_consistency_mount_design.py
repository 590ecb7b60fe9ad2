"""Claim: the mount designs of the shipped cases are found again without the optimiser.

With the block at its largest mass both forces are at their limits, which are two equations in
stiffness and damping. A formula for the pitching machine and nested bisection solve them; the
objective rises when the block is taken lighter. Nothing of the package computes here but the cases.
"""

import math
import re
from functools import cache

import mount_study
import numpy as np
import pytest
from long_but import long_but
from mount_study import LEVER, MACHINE_MASS, OPERATING_SPEED, MountStudy, exact_series
from scipy.optimize import brentq
from shipped_cases import ROOT, table_of

GRAVITY = 9.81
PLATE_LENGTH, PLATE_HEIGHT, PLATE_DEPTH = 0.8, 0.0032, 0.1766
#: case -> share of the couple, upper end for the bisection of the stiffness
READINGS = {
    "generator_mount_design": (1.0, 1.1e5),
    "generator_mount_design_lever": (4.0, 1.9e4),
}


class Shipped(MountStudy):
    """The generator of the shipped cases: exact motion, a steel plate under the machine."""

    def rotation_and_force(self, stiffness, damping, block, speed):
        stiffness, damping, block, speed = (
            np.asarray(value)[..., None] for value in (stiffness, damping, block, speed)
        )
        own = MACHINE_MASS * (0.35**2 + 0.8**2) + block * (PLATE_LENGTH**2 + PLATE_HEIGHT**2)
        about = block * MACHINE_MASS / (MACHINE_MASS + block) * PLATE_DEPTH**2
        rate, arm = 1j * self.orders * speed, 4 * LEVER**2
        resisting = arm * (stiffness + damping * rate) + (own / 12 + about) * rate**2
        angle = self.couple * speed**2 / resisting
        return angle, LEVER * (stiffness + damping * rate) * angle

    def objective(self, stiffness, damping, block):
        angle, _ = self.rotation_and_force(stiffness, damping, block, OPERATING_SPEED)
        sag = (MACHINE_MASS + block) * GRAVITY / (4 * stiffness)
        return float(sag + LEVER * self.peak(angle))


@cache
def bisected(name: str, block: float = 10.0) -> tuple[float, float, float]:
    """Stiffness, damping and objective where both forces are at their limits."""
    share, stiffest = READINGS[name]
    study = Shipped(exact_series(10), share)

    def damping(stiffness: float) -> float:
        def steady(log: float) -> float:
            force = study.force_at(stiffness, np.exp(log), block, OPERATING_SPEED)
            return float(force / mount_study.STEADY_LIMIT - 1.0)

        return math.exp(brentq(steady, -3, 8, xtol=1e-13))

    def run_up(log: float) -> float:
        force = study.run_up(math.exp(log), damping(math.exp(log)), block)
        return float(force / mount_study.RUN_UP_LIMIT - 1.0)

    stiffness = math.exp(brentq(run_up, math.log(stiffest / 1.5), math.log(stiffest), xtol=1e-13))
    return stiffness, damping(stiffness), study.objective(stiffness, damping(stiffness), block)


def documented(name: str) -> dict[str, str]:
    """The optimum of a case as docs/validation.md has it: row -> number as printed."""
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    header = re.search(r"^\| mount design \|(.*)\|$", text, flags=re.MULTILINE)
    assert header is not None
    column = [cell.strip(" `") for cell in header[1].split("|")].index(name)
    rows = text[header.end() :].split("\n\n")[0].strip().split("\n")[1:]
    cells = ([cell.strip() for cell in row.strip("|").split("|")] for row in rows)
    return {name_of_row: values[column] for name_of_row, *values in cells}


@pytest.mark.parametrize("name", READINGS)
def test_documented_optimum_is_where_both_forces_are_at_their_limits(name: str) -> None:
    optimum = documented(name)
    found = bisected(name)
    for row, value in zip(("stiffness, N/m", "damping, N s/m", "objective, m"), found, strict=True):
        digits = len(re.sub(r"^0\.0*|\D", "", optimum[row]))
        assert float(optimum[row]) == pytest.approx(value, rel=0.5 * 10.0 ** (1 - digits))
    assert float(optimum["block, kg"]) == 10.0


@pytest.mark.parametrize("name", long_but(READINGS, "generator_mount_design_lever"))
def test_a_lighter_block_is_worse(name: str) -> None:
    assert bisected(name, 9.0)[2] > bisected(name, 9.9)[2] > bisected(name)[2]


@pytest.mark.parametrize("name", long_but(READINGS, "generator_mount_design_lever"))
def test_documented_multipliers_are_the_price_of_the_limits(name: str) -> None:
    """A limit of 1 % more lowers the objective by a hundredth of its multiplier."""
    optimum, here = documented(name), bisected(name)[2]
    for row, limit in (("steady", "STEADY_LIMIT"), ("run-up", "RUN_UP_LIMIT")):
        prices = []
        for change in (1e-4, -1e-4):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(mount_study, limit, getattr(mount_study, limit) * (1.0 + change))
                bisected.cache_clear()
                prices.append((here - bisected(name)[2]) / change)
        assert float(optimum[f"multiplier, {row}, m"]) == pytest.approx(np.mean(prices), rel=1e-5)
    bisected.cache_clear()


def test_the_cases_hold_what_this_file_takes_from_them() -> None:
    for name in READINGS:
        table = table_of(name)
        block = table["machine"]["body"]["inertia_block"]
        assert block["box"]["height"] == f"{PLATE_HEIGHT * 1e3:g} mm"
        assert block["position"] == [0.0, 0.0, f"{-PLATE_DEPTH} m"]
        assert table["isolation"]["gravity"] == f"{GRAVITY} m/s^2"
        assert "kinematics" not in table
