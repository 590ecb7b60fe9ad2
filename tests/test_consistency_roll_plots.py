"""Claim: pictures of the shell's roll show the numbers of the result and of its case."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_samples import quantity
from roll_samples import (
    LEVELS,
    ORDERS,
    RPM,
    SLIP,
    SLOPES,
    SPEED,
    TORQUE,
    forces,
    roll,
    sensitivities,
    spectra,
    spreads,
    symmetrical,
    with_changes,
)

pytest.importorskip("matplotlib")

from drawn import assert_apart, figure, lines, words

from vibecalc.core.report.plots import draw, every_picture, make
from vibecalc.core.results.record import Axis
from vibecalc.roll.pictures.motor import motor_curve

OWN = {"roll_levels": spectra, "roll_cycle": spectra, "roll_sensitivity": sensitivities}


@cache
def own(name: str) -> Any:
    """A picture of the sample, for tests that look and change nothing."""
    return figure(roll(), name)


def points(axes: Any, label: str) -> Any:
    """Where references of a kind are drawn."""
    found = [one.get_offsets() for one in axes.collections if one.get_label() == label]
    return np.concatenate(found) if found else np.zeros((0, 2))


@pytest.mark.parametrize("name", OWN)
def test_a_picture_needs_its_own_numbers_only(name: str) -> None:
    assert make(roll(OWN[name]()), name) is not None
    others = {spectra, sensitivities, forces, spreads} - {OWN[name]}
    assert make(roll(*(part() for part in others)), name) is None


@pytest.mark.parametrize("name", OWN)
def test_letters_and_axes_stay_apart(name: str) -> None:
    assert_apart(own(name))


@pytest.mark.long
@pytest.mark.parametrize("name", OWN)
def test_so_they_do_where_odd_orders_are_zero(name: str) -> None:
    assert_apart(figure(symmetrical(), name))


def test_levels_stand_nearby_published_and_measured_ones() -> None:
    result = roll()
    (axes,) = own("roll_levels").axes
    drawn = lines(axes)
    np.testing.assert_array_equal(drawn["computed"].get_xdata(), ORDERS.values)
    np.testing.assert_allclose(drawn["computed"].get_ydata(), LEVELS)
    assert points(axes, "published")[6, 1] == pytest.approx(LEVELS[6] + 0.4)
    measured = points(axes, "measured")
    np.testing.assert_array_equal(measured[:, 1], [7.4, 11.6, -0.6])
    np.testing.assert_allclose(np.round(measured[:, 0]), [1, 2, 3])
    (bars,) = axes.containers
    found = result.record["response/roll/interpolation/level"].values
    ends = np.array([segment[:, 1] for segment in bars.lines[2][0].get_segments()])
    np.testing.assert_allclose(ends, np.stack([found.min(axis=0), found.max(axis=0)], axis=1))
    assert axes.get_ylabel().startswith("level in dB re 1 rad/s")


def test_a_level_of_nothing_stands_at_the_foot() -> None:
    (axes,) = figure(symmetrical(1e-15), "roll_levels").axes
    orders, levels = (np.asarray(one) for one in lines(axes)["computed"].get_data())
    np.testing.assert_array_equal(orders[np.isfinite(levels)], [2, 4, 6, 8, 10])
    assert words(axes) == "zero zero zero zero zero"
    assert axes.get_ylim()[0] > -40.0


def test_a_published_level_known_to_differ_is_drawn_too() -> None:
    row = {"quantity": "response/roll/level/shell_acceleration", "source": "s", "value": 8.9}
    result = roll(reference=[{**row, "where": {"order": 2}, "known_difference": "noise"}])
    (axes,) = figure(result, "roll_levels").axes
    assert points(axes, "published")[0, 1] == 8.9
    assert not points(figure(roll(reference=[]), "roll_levels").axes[0], "published").size


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


def test_large_changes_do_not_pale_the_others() -> None:
    axes = figure(with_changes(roll(), 4.0 * SLOPES), "roll_sensitivity").axes[0]
    assert axes.get_images()[0].get_clim() == (-3.0, 3.0)
    assert "+6.80" in words(axes)


def test_less_stands_nearby_more_in_the_map() -> None:
    more, less = own("roll_sensitivity").axes[:2]
    assert (more.get_title(), less.get_title()) == ("10 % more", "10 % less")
    arrays = [np.asarray(axes.get_images()[0].get_array()) for axes in (more, less)]
    np.testing.assert_allclose(arrays[0], -arrays[1])


def test_orders_that_are_zero_are_hatched_in_the_map() -> None:
    axes = figure(symmetrical(), "roll_sensitivity").axes[0]
    hatched = [patch.get_x() for patch in axes.patches if patch.get_hatch()]
    np.testing.assert_allclose(hatched, [-0.5, 1.5, 3.5, 5.5, 7.5])
    assert [label.get_text() for label in axes.get_xticklabels()] == [str(n) for n in range(1, 11)]


def test_many_orders_are_no_reason_to_fail() -> None:
    orders = Axis(name="order", values=np.arange(1, 61))
    names = Axis(name="parameter", values=np.array(["rotor_inertia"], object))
    slopes = quantity(
        "response/roll/sensitivity/ten_percent_more", np.ones((1, 60)), "dB", names, orders
    )
    level = quantity("response/roll/level/shell_acceleration", -np.arange(60.0), "dB", orders)
    result = roll([slopes, level], reference=[])
    assert words(figure(result, "roll_sensitivity").axes[0]) == ""
    figure(result, "roll_levels").canvas.draw()


@pytest.mark.long
def test_equal_results_give_equal_bytes(tmp_path: Path) -> None:
    first = draw(roll(), tmp_path / "a")
    second = draw(roll(), tmp_path / "b")
    assert len(first) == len(OWN)
    assert all(a.read_bytes() == b.read_bytes() for a, b in zip(first, second, strict=True))
    assert set(OWN) <= set(every_picture())


def test_a_motor_with_fluxes_has_the_peak_of_its_fit() -> None:
    result = roll()
    for name, value, unit in (("slip", 100.0 * RPM, "rad/s"), ("torque", 990.0, "N*m")):
        path = f"response/roll/motor/breakdown_{name}"
        result.record.quantities[path] = quantity(path, value, unit)
    made = figure(result, "roll_cycle")
    assert any("breakdown 990.0 N m\nat 100.0 rpm" in words(axes) for axes in made.axes)
