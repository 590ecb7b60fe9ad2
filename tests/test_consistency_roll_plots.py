"""Claim: pictures of the shell's roll show the numbers of the result and of its case."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from roll_samples import (
    RPM,
    SLIP,
    SLOPES,
    SPEED,
    TORQUE,
    roll,
    symmetrical,
)

pytest.importorskip("matplotlib")

from drawn import figure, lines, words

from vibecalc.roll.pictures.motor import motor_curve


@cache
def own(name: str) -> Any:
    """A picture of the sample, for tests that look and change nothing."""
    return figure(roll(), name)


def test_a_level_of_nothing_stands_at_the_foot() -> None:
    (axes,) = figure(symmetrical(1e-15), "roll_levels").axes
    orders, levels = (np.asarray(one) for one in lines(axes)["computed"].get_data())
    np.testing.assert_array_equal(orders[np.isfinite(levels)], [2, 4, 6, 8, 10])
    assert words(axes) == "zero zero zero zero zero"
    assert axes.get_ylim()[0] > -40.0


def test_one_turn_is_drawn_over_the_angle_and_on_the_curve() -> None:
    result = roll()
    torque, curve, speed, part, slip = own("roll_cycle").axes
    cycle = {
        name: np.asarray(result.record[f"response/roll/cycle/{name}"].values)
        for name in ("motor_torque", "gas_torque", "crank_speed", "slip")
    }
    np.testing.assert_allclose(lines(torque)["motor"].get_ydata(), cycle["motor_torque"])
    np.testing.assert_allclose(lines(torque)["demand of the gas"].get_ydata(), -cycle["gas_torque"])
    drawn = lines(speed)
    np.testing.assert_allclose(
        drawn["crank against shell"].get_ydata(), cycle["crank_speed"] / RPM, rtol=1e-12
    )
    assert drawn["mean 887.00 rpm"].get_ydata()[0] == pytest.approx(SPEED / RPM)
    assert drawn["synchronous 900.00 rpm"].get_ydata()[0] == pytest.approx(900.0)
    assert slip.get_xlabel() == "crank angle in deg" and slip.get_xlim() == (0.0, 360.0)
    for axes in (curve, part):
        orbit = lines(axes)["one turn"]
        np.testing.assert_allclose(orbit.get_xdata(), cycle["slip"] / RPM, rtol=1e-12)
        np.testing.assert_allclose(orbit.get_ydata(), cycle["motor_torque"])
        assert axes.get_xlim()[0] < min(orbit.get_xdata())
    nodes = lines(curve)["rows of its table"]
    kept = np.asarray(nodes.get_xdata()) > -1e-9
    np.testing.assert_allclose(np.asarray(nodes.get_xdata())[kept], SLIP / RPM, atol=1e-9)
    np.testing.assert_allclose(np.asarray(nodes.get_ydata())[kept], TORQUE, atol=1e-9)
    assert "breakdown 1009 N m\nat 108.0 rpm" in words(curve)
    assert curve.get_xlim()[1] >= 900.0 > part.get_xlim()[1]


@pytest.mark.parametrize("interpolation", [None, "linear", "parabola", "monotone"])
def test_the_curve_of_the_motor_goes_through_its_table(interpolation: str | None) -> None:
    table = {"slip": SLIP.tolist(), "torque": TORQUE.tolist()}
    motor = {"slip_table": table, "interpolation": interpolation}
    curve = motor_curve(motor, np.array([-8.0, 40.0]))
    assert curve is not None and curve.breakdown is not None
    at = np.interp(SLIP / RPM, curve.slip, curve.torque)
    np.testing.assert_allclose(at, TORQUE, atol=1e-6)
    np.testing.assert_allclose(np.interp([-6.0], curve.slip, curve.torque), [-239.0], atol=1e-6)
    assert -15.0 < curve.slip[0] < -8.0 and curve.slip[-1] == pytest.approx(900.0)
    assert curve.node_slip[0] == pytest.approx(-11.0)
    assert curve.breakdown[1] >= 1009.0 - 1e-9


def test_a_linear_motor_has_a_curve_without_peak_and_another_has_none() -> None:
    curve = motor_curve({"gain": 203.4}, np.array([0.0, 40.0]))
    assert curve is not None and curve.breakdown is None and not curve.node_slip.size
    np.testing.assert_allclose(curve.torque, 203.4 * RPM * curve.slip, rtol=1e-12, atol=1e-9)
    assert motor_curve({}, np.array([0.0, 1.0])) is None
    motor = {"kind": "linear", "gain": 203.4, "synchronous_speed": 900.0 * RPM}
    for given in (motor, {}):
        made = figure(roll(machine={"motor": given}), "roll_cycle")
        assert "breakdown" not in words(made.axes[1])


def test_slopes_are_a_map_with_what_does_most_on_top() -> None:
    axes = own("roll_sensitivity").axes[0]
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names[:2] == ["crank radius", "shell inertia"] and names[-1] == "motor torque"
    (image,) = axes.get_images()
    values = np.asarray(image.get_array())
    np.testing.assert_allclose(values[0], 10.0 * SLOPES[2])
    np.testing.assert_array_equal(values[-1], np.zeros(10))
    low, high = image.get_clim()
    assert low == -high == -np.abs(values).max()
    assert [label.get_text() for label in axes.get_xticklabels()] == [str(n) for n in range(1, 11)]
    assert "+1.70" in words(axes) and "-0.86" in words(axes)
