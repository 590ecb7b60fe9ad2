"""Claim: a gas force goes through its table, turn after turn, by the curve that was asked for."""

import numpy as np
import pytest
from roll_machines import columns
from scipy.interpolate import CubicSpline

from vibecalc.excitation.gas_tables import FORCE_INTERPOLATIONS, force_at, gas_force

TURN = 2.0 * np.pi
DEGREES, FORCE = columns("roll_first_stage.csv")
ANGLE = np.radians(DEGREES)
POINTS = np.random.default_rng(3).uniform(-3.0 * TURN, 3.0 * TURN, 400)
UNEVEN = np.array([0.0, 0.3, 0.35, 2.0, 3.1, 5.0, TURN])
UNEVEN_FORCE = np.array([5.0, 9.0, -2.0, 4.0, 4.5, 1.0, 5.0])


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, FORCE), (UNEVEN, UNEVEN_FORCE)])
def test_linear_is_interpolation_by_numpy(angle: np.ndarray, force: np.ndarray) -> None:
    truth = np.interp(POINTS, angle[:-1], force[:-1], period=TURN)
    found = force_at(gas_force(angle, force, "linear"), POINTS)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-12 * np.max(force))


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, FORCE), (UNEVEN, UNEVEN_FORCE)])
def test_cubic_is_the_periodic_spline(angle: np.ndarray, force: np.ndarray) -> None:
    truth = CubicSpline(angle, force, bc_type="periodic")(np.mod(POINTS, TURN))
    found = force_at(gas_force(angle, force, "cubic"), POINTS)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-12 * np.max(np.abs(truth)))


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, FORCE), (UNEVEN, UNEVEN_FORCE)])
def test_parabola_goes_through_the_node_before(angle: np.ndarray, force: np.ndarray) -> None:
    gas = gas_force(angle, force, "parabola")
    wide = np.concatenate([[angle[-2] - TURN], angle])
    tall = np.concatenate([[force[-2]], force])
    for place in range(1, len(wide) - 1):
        three = slice(place - 1, place + 2)
        middle = wide[place]
        parabola = np.polyfit(wide[three] - middle, tall[three], 2)
        inside = np.linspace(wide[place], wide[place + 1], 7)[:-1]
        truth = np.polyval(parabola, inside - middle)
        np.testing.assert_allclose(
            force_at(gas, inside), truth, rtol=0, atol=1e-11 * np.max(np.abs(tall))
        )


@pytest.mark.parametrize("count", [36, 35, 4])
def test_trigonometric_is_the_barycentric_formula(count: int) -> None:
    """Berrut's formula for even and odd numbers of nodes, which knows no harmonics."""
    nodes = TURN * np.arange(count) / count + 0.4
    heights = np.random.default_rng(count).normal(size=count)
    gas = gas_force(
        np.append(nodes, nodes[0] + TURN), np.append(heights, heights[0]), "trigonometric"
    )
    half = 0.5 * (POINTS[:, None] - nodes)
    kernel = (1.0 / np.sin(half) if count % 2 else 1.0 / np.tan(half)) * (-1.0) ** np.arange(count)
    truth = kernel @ heights / np.sum(kernel, axis=1)
    np.testing.assert_allclose(force_at(gas, POINTS), truth, rtol=0, atol=1e-10)


def test_trigonometric_refuses_uneven_nodes() -> None:
    with pytest.raises(ValueError, match="evenly spaced"):
        gas_force(UNEVEN, UNEVEN_FORCE, "trigonometric")


def test_a_negative_angle_of_one_rounding_is_the_end_of_the_turn() -> None:
    for kind in FORCE_INTERPOLATIONS:
        gas = gas_force(ANGLE, FORCE, kind)
        for tiny in (-1e-17, -1e-300, 0.0):
            found = float(force_at(gas, np.asarray(tiny)))
            assert found == pytest.approx(FORCE[0], rel=1e-12)
