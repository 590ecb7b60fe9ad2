"""The marine propulsion line against full matrices and cards by quadrature."""

import numpy as np
import pytest
from dense_line import half_range
from marine_line import LINE, ORDER, SPEED, halves
from shipped_cases import result_of

from vibecalc.core.results.record import Quantity

ROOT = "response/torsion/"
RTOL = 1e-9
#: the two with a limit, and their places in the line
SHAFTS = (("intermediate shaft", 6), ("propeller shaft", 7))


def quantity(path: str) -> Quantity:
    return result_of("marine_propulsion").record.quantities[ROOT + path]


def test_natural_frequencies() -> None:
    found = quantity("modes/natural_frequency").values
    np.testing.assert_allclose(found[1:], LINE.undamped(SPEED)[1:], rtol=RTOL)


def test_torques_and_angles_at_the_operating_speed() -> None:
    wanted = LINE.at(SPEED)
    for path, expected in (("torque", wanted.torque), ("angle", wanted.angle)):
        largest = np.abs(expected).max()
        np.testing.assert_allclose(quantity(path).values, expected, rtol=RTOL, atol=RTOL * largest)
        half = quantity(f"{path}_half_range").values
        np.testing.assert_allclose(half, half_range(ORDER, expected), rtol=RTOL)


def test_half_ranges_over_the_speeds() -> None:
    curve = quantity("speeds/torque_half_range")
    speed = np.asarray(curve.axes[-1].values, dtype=float)
    for place in range(0, len(speed), 7):
        np.testing.assert_allclose(curve.values[:, place], halves(float(speed[place])), rtol=RTOL)


def test_orders_of_the_curves() -> None:
    """Complex orders, half ranges and sums of magnitudes of both shafts over the speed."""
    order, sums = quantity("curves/torque/order"), quantity("curves/torque/sum")
    half = quantity("curves/torque/half_range")
    assert list(order.axes[0].values) == [name for name, _ in SHAFTS]
    kept = [list(ORDER).index(one) for one in order.axes[1].values]
    assert 4.0 in order.axes[1].values  # of the blades
    for place, speed in list(enumerate(order.axes[2].values))[::24]:
        torque = LINE.at(float(speed)).torque[[row for _, row in SHAFTS]]
        tiny = RTOL * np.abs(torque).max()
        expected = torque[:, kept]
        np.testing.assert_allclose(order.values[..., place], expected, rtol=RTOL, atol=tiny)
        np.testing.assert_allclose(sums.values[:, place], np.abs(torque).sum(axis=1), rtol=RTOL)
        np.testing.assert_allclose(half.values[:, place], half_range(ORDER, torque), rtol=RTOL)


@pytest.mark.long
def test_conditions_of_the_cylinders() -> None:
    """All of them at the operating speed, and the worst of all over the speed."""
    found = quantity("conditions/torque_half_range")
    names = ["", *(one["name"] for one in LINE.train["cylinders"])]
    expected = np.array([halves(SPEED, one) for one in names])
    np.testing.assert_allclose(found.values, expected, rtol=RTOL)
    worst = quantity("conditions/speeds/torque_half_range")
    for place in (31, 124):
        at = float(worst.axes[-1].values[place])
        every = np.array([halves(at, one) for one in names])
        np.testing.assert_allclose(worst.values[:, place], every.max(axis=0), rtol=RTOL)


def stress(row: int, speed: float) -> float:
    """Half range of the stress of a shaft at one speed, Pa."""
    return float(halves(speed)[row] / (np.pi * diameter(row) ** 3 / 16.0))


def diameter(row: int) -> float:
    return float(LINE.line["shafts"][row]["section"]["outer_diameter"])


@pytest.mark.parametrize(("name", "row"), SHAFTS)
def test_largest_stress_is_that_of_its_speed_and_none_near_it_is_larger(
    name: str, row: int
) -> None:
    found, speeds = quantity("largest/stress_half_range"), quantity("largest/speed")
    top = float(found.values[list(found.axes[0].values).index(name)])
    at = float(speeds.values[row])
    assert stress(row, at) == pytest.approx(top, rel=RTOL)
    assert all(stress(row, at * (1.0 + off)) < top for off in (-1e-2, -1e-4, 1e-4, 1e-2))


def allowed(row: int, speed: float) -> float:
    """Of UR M68 for continuous operation below 0.9 of the rated speed, Pa."""
    shaft = LINE.line["shafts"][row]
    size = 0.35 + 0.93 * (1e3 * diameter(row)) ** -0.2
    factor = {"intermediate shaft": 1.0, "propeller shaft": 0.55}[shaft["name"]]  # flange, keyless
    ratio = speed / SPEED
    strength = shaft["tensile_strength"] / 1e6
    return 1e6 * (strength + 160.0) / 18.0 * factor * size * (3.0 - 2.0 * ratio**2)


def test_use_of_the_limits_and_ends_of_the_barred_range() -> None:
    """Each shaft passes its limit about one speed n_c; barred from the lower to the upper of
    16 n_c / (18 - lambda) and (18 - lambda) n_c / 16 of both."""
    ends = []
    for place, (_, row) in enumerate(SHAFTS):
        assert int(quantity("exceeded/limit").values[place]) == place + 1
        peak = float(quantity("exceeded/peak_speed").values[place])
        use = float(quantity("limit/largest_utilisation").values[place])
        assert stress(row, peak) / allowed(row, peak) == pytest.approx(use, rel=RTOL)
        for name in ("from", "to"):
            at = float(quantity(f"exceeded/{name}").values[place])
            assert stress(row, at) == pytest.approx(allowed(row, at), rel=1e-8)
        ratio = peak / SPEED
        ends.append((16.0 * peak / (18.0 - ratio), (18.0 - ratio) * peak / 16.0))
    low, high = np.transpose(ends)
    assert float(quantity("barred/from").values[0]) == pytest.approx(low.min(), rel=RTOL)
    assert float(quantity("barred/to").values[0]) == pytest.approx(high.max(), rel=RTOL)


def test_dampings_at_the_operating_speed_and_over_speeds() -> None:
    found = quantity("damping/station").values
    np.testing.assert_allclose(found, LINE.absolute(SPEED), rtol=1e-12)
    wanted = [
        1.0 / one["magnifier"] if "magnifier" in one else 2.0 * one["lehr_ratio"]
        for one in LINE.line["shafts"]
    ]
    np.testing.assert_allclose(quantity("damping/loss_factor").values, wanted, rtol=1e-14)
    curve = quantity("speeds/station_damping")
    names = [one["name"] for one in LINE.line["stations"]]
    rows = [names.index(name) for name in curve.axes[0].values]
    assert names[rows[-1]] == "propeller" and "flywheel" not in curve.axes[0].values
    expected = np.array([LINE.absolute(one)[rows] for one in curve.axes[1].values])
    np.testing.assert_allclose(curve.values, expected.T, rtol=1e-12)
