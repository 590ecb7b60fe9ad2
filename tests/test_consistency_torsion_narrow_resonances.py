"""Claim: resonances narrower than the steps of a sweep are found, whatever its steps are.

The truth: a sweep a hundred times as fine, and 40 digits for the errors of curves.
"""

import tomllib
from typing import Any

import numpy as np
import pytest
from engine_cases import ENGINE, replaced
from test_consistency_torsion_stage import ROOT, record, value

from vibecalc.core.case.load import validate
from vibecalc.torsion.adapters.curves import sweep
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.adapters.variants import bare_setup

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
    return speed, sweep(setup.model, setup.drive, speed, None, angles=False).torque


def built(text: str) -> Setup:
    return build_setup(validate(tomllib.loads(text)))


@pytest.mark.parametrize("text", [HARD, pytest.param(LOSSY, marks=pytest.mark.long)])
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
    for name in ("limit/largest_use", "exceeded/from", "exceeded/to", "exceeded/peak_speed"):
        assert value(coarse, name) == pytest.approx(value(other, name), rel=1e-7)
    start, end = value(coarse, "exceeded/from"), value(coarse, "exceeded/to")
    inside = np.any((speed[:, None] >= start) & (speed[:, None] <= end), axis=1)
    stress = torque[:, 0] / setup.shaft.section_modulus[0]
    assert np.array_equal(inside, stress > np.interp(speed, [LOW, HIGH], [allowed, allowed / 15]))
    assert len(start) > 1


@pytest.mark.long
def test_the_line_without_dampers_is_looked_at_as_closely() -> None:
    _, torque = fine(bare_setup(built(LIGHT)))
    top = value(LIGHT, "bare/largest/torque_half_range")
    assert np.all(top >= torque.max(axis=0) * (1.0 - 1e-9))
    assert top == pytest.approx(value(at_points(LIGHT, 1201), "bare/largest/torque_half_range"))
    assert np.any(value(LIGHT, "bare/speeds/torque_half_range").max(axis=1) < 0.8 * top)


def test_a_corner_of_a_limit_between_speeds_is_a_largest_use() -> None:
    curve = 'speed = ["1000 rpm", "3001 rpm", "9000 rpm"], stress = ["99 MPa", "1 Pa", "99 MPa"]'
    text = at_points(PLAIN, 21) + f"limits = [{{ curve = {{ {curve} }} }}]"
    assert value(text, "limit/speed")[0] == pytest.approx(3001.0 * np.pi / 30.0, rel=1e-12)


def test_travel_is_the_largest_magnitude_at_all_speeds() -> None:
    plain = at_points(PLAIN, 21)
    speed = np.asarray(record(plain)[f"{ROOT}/speeds/travel"].axes[1].values)
    place = 17
    at = replaced(plain, (RANGE % 21, "")).replace("1500 rpm", f"{float(speed[place])!r} rad/s")
    travel = value(plain, "speeds/travel")[0, place]
    assert travel == pytest.approx(value(at, "damper/travel")[0], rel=1e-12)
    assert travel > value(plain, "speeds/twist_half_range")[-1, place] * (1.0 + 1e-6)


def test_errors_of_curves_bound_what_forty_digits_say_nearby_no_end() -> None:
    import mpmath

    text = at_points(PLAIN.replace(RING, "").replace(', damping = "5 N*m*s/rad"', ""), 2001)
    found = record(text)[f"{ROOT}/speeds/torque_half_range"]
    values = np.where(np.isfinite(found.values), found.values, 0.0)
    setup = built(text)
    speeds = np.asarray(found.axes[1].values)
    line, order = setup.model.line, setup.drive.order
    for place in np.argsort(values.max(axis=0))[-3:]:
        at = float(speeds[place])
        load = setup.drive.torque(np.array([at])).value[0]
        torque: Any = np.empty((3, len(order)), dtype=complex)
        with mpmath.workdps(40):
            for q, (one, right) in enumerate(zip(order, load, strict=True)):
                w = mpmath.mpf(at) * mpmath.mpf(float(one))
                matrix = mpmath.diag([-(w**2) * mpmath.mpf(float(j)) for j in line.inertia])
                for e, k in enumerate(line.stiffness.tolist()):
                    matrix[e, e] += k
                    matrix[e + 1, e + 1] += k
                    matrix[e, e + 1] -= k
                    matrix[e + 1, e] -= k
                phi = mpmath.lu_solve(matrix, mpmath.matrix([*map(mpmath.mpc, right), 0]))
                for e, k in enumerate(line.stiffness.tolist()):
                    torque[e, q] = complex(k * (phi[e] - phi[e + 1]))
        from vibecalc.torsion.synthesis import synthesis

        exact = synthesis(order, torque).half_range
        assert np.all(np.abs(exact - values[:, place]) <= found.error_estimate)
