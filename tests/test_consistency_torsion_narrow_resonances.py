"""Claim: resonances narrower than the steps of a sweep are found, whatever its steps are.

The truth: a sweep a hundred times as fine, and 40 digits for the errors of curves.
"""

import tomllib

import numpy as np
import pytest
from engine_cases import ENGINE, replaced
from test_consistency_torsion_stage import value

from vibecalc.core.case.load import validate
from vibecalc.torsion.adapters.motion import Motion, readings_of
from vibecalc.torsion.adapters.setup import Setup, build_setup

LOW, HIGH = 1000.0 * np.pi / 30.0, 9000.0 * np.pi / 30.0
RANGE = 'speeds = { from = "1000 rpm", to = "9000 rpm", points = %d }'
PLAIN = replaced(ENGINE, ('speeds = { from = "800 rpm", to = "2000 rpm" }', RANGE % 61))
# what is narrow without the ring is wide with it, and the other way round with one as hard as this
LIGHT = PLAIN.replace('damping = "5 N*m*s/rad"', 'damping = "1 N*m*s/rad"')
RING = next(line for line in PLAIN.splitlines() if line.startswith("dampers"))
HARD = LIGHT.replace('"1 N*m*s/rad"', '"0.3 N*m*s/rad"').replace(
    'damping = "30 N*m*s/rad"', 'damping = "2e5 N*m*s/rad"'
)
LOSSY = LIGHT.replace(RING, "").replace('damping = "1 N*m*s/rad"', "loss_factor = 0.002")


def at_points(text: str, points: int) -> str:
    return text.replace(RANGE % 61, RANGE % points)


def fine(setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    speed = np.linspace(LOW, HIGH, 4001)
    return speed, readings_of(setup)["torque_half_range"].of(Motion(setup, speed)).value


def built(text: str) -> Setup:
    return build_setup(validate(tomllib.loads(text)))


@pytest.mark.long
@pytest.mark.parametrize("text", [HARD, LOSSY])
def test_what_a_coarse_sweep_steps_over_is_found(text: str) -> None:
    setup = built(text)
    speed, torque = fine(setup)
    top = value(text, "largest/torque_half_range")
    on_grid = value(text, "speeds/torque_half_range").max(axis=1)
    assert np.any(top > 1.2 * on_grid)  # the sweep of 61 points does not see them
    assert np.all(top >= torque.max(axis=0) * (1.0 - 1e-9))
    assert np.all(top <= torque.max(axis=0) * 1.05)
    allowed = 0.9 * float(value(text, "largest/stress_half_range")[0])
    curve = f'speed = ["1000 rpm", "9000 rpm"], stress = ["{allowed!r} Pa", "{allowed / 15!r} Pa"]'
    limited = text + f"limits = [{{ curve = {{ {curve} }} }}]"
    coarse, other = at_points(limited, 23), limited
    for name in (
        "limit/largest_utilisation",
        "exceeded/from",
        "exceeded/to",
        "exceeded/peak_speed",
    ):
        assert value(coarse, name) == pytest.approx(value(other, name), rel=1e-7)
    start, end = value(coarse, "exceeded/from"), value(coarse, "exceeded/to")
    inside = np.any((speed[:, None] >= start) & (speed[:, None] <= end), axis=1)
    stress = torque[:, 0] / setup.shaft.section_modulus[0]
    assert np.array_equal(inside, stress > np.interp(speed, [LOW, HIGH], [allowed, allowed / 15]))
    assert len(start) > 1


@pytest.mark.long
def test_a_corner_of_a_limit_between_speeds_is_a_largest_use() -> None:
    curve = 'speed = ["1000 rpm", "3001 rpm", "9000 rpm"], stress = ["99 MPa", "1 Pa", "99 MPa"]'
    text = at_points(PLAIN, 21) + f"limits = [{{ curve = {{ {curve} }} }}]"
    assert value(text, "limit/speed")[0] == pytest.approx(3001.0 * np.pi / 30.0, rel=1e-12)
