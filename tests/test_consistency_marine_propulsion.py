"""The marine propulsion line against full matrices and cards by quadrature."""

import numpy as np
import pytest
from marine_line import halves, line, speed_of_crank
from shipped_cases import result_of

from vibecalc.core.results.record import Quantity

ROOT = "response/torsion/"
RTOL = 1e-9
#: the two with a limit, and their places in the line
SHAFTS = (("intermediate shaft", 6), ("propeller shaft", 7))


def quantity(path: str) -> Quantity:
    return result_of("marine_propulsion").record.quantities[ROOT + path]


def test_half_ranges_over_the_speeds() -> None:
    curve = quantity("speeds/torque_half_range")
    speed = np.asarray(curve.axes[-1].values, dtype=float)
    for place in range(0, len(speed), 7):
        np.testing.assert_allclose(curve.values[:, place], halves(float(speed[place])), rtol=RTOL)


def stress(row: int, speed: float) -> float:
    """Half range of the stress of a shaft at one speed, Pa."""
    return float(halves(speed)[row] / (np.pi * diameter(row) ** 3 / 16.0))


def diameter(row: int) -> float:
    return float(line().line["shafts"][row]["section"]["outer_diameter"])


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
    shaft = line().line["shafts"][row]
    size = 0.35 + 0.93 * (1e3 * diameter(row)) ** -0.2
    factor = {"intermediate shaft": 1.0, "propeller shaft": 0.55}[shaft["name"]]  # flange, keyless
    ratio = speed / speed_of_crank()
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
        ratio = peak / speed_of_crank()
        ends.append((16.0 * peak / (18.0 - ratio), (18.0 - ratio) * peak / 16.0))
    low, high = np.transpose(ends)
    assert float(quantity("barred/from").values[0]) == pytest.approx(low.min(), rel=RTOL)
    assert float(quantity("barred/to").values[0]) == pytest.approx(high.max(), rel=RTOL)


def test_dampings_at_the_operating_speed_and_over_speeds() -> None:
    found = quantity("damping/station").values
    np.testing.assert_allclose(found, line().absolute(speed_of_crank()), rtol=1e-12)
    wanted = [
        1.0 / one["magnifier"] if "magnifier" in one else 2.0 * one["lehr_ratio"]
        for one in line().line["shafts"]
    ]
    np.testing.assert_allclose(quantity("damping/loss_factor").values, wanted, rtol=1e-14)
    curve = quantity("speeds/station_damping")
    names = [one["name"] for one in line().line["stations"]]
    rows = [names.index(name) for name in curve.axes[0].values]
    assert names[rows[-1]] == "propeller" and "flywheel" not in curve.axes[0].values
    expected = np.array([line().absolute(one)[rows] for one in curve.axes[1].values])
    np.testing.assert_allclose(curve.values, expected.T, rtol=1e-12)
