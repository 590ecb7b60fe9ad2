"""The marine propulsion line against a dense solve that is formed from the text of its case."""

import marine_line as dense
import numpy as np
import pytest
from shipped_cases import result_of

from vibecalc.core.results.record import Quantity

ROOT = "response/torsion/"
RTOL = 1e-9


def quantity(path: str) -> Quantity:
    return result_of("marine_propulsion").record.quantities[ROOT + path]


def test_natural_frequencies() -> None:
    found = quantity("modes/natural_frequency").values
    np.testing.assert_allclose(found[1:], dense.natural_frequencies()[1:], rtol=RTOL)


def test_torques_and_angles_at_the_operating_speed() -> None:
    wanted = dense.solved(dense.operating_speed())
    for path, expected in (("torque", wanted.torque), ("angle", wanted.angle)):
        largest = np.abs(expected).max()
        np.testing.assert_allclose(quantity(path).values, expected, rtol=RTOL, atol=RTOL * largest)
        half = quantity(f"{path}_half_range").values
        np.testing.assert_allclose(half, dense.half_ranges(expected), rtol=RTOL)


def test_half_ranges_over_the_speeds() -> None:
    curve = quantity("speeds/torque_half_range")
    speed = np.asarray(curve.axes[-1].values, dtype=float)
    for place in range(0, len(speed), 7):
        expected = dense.half_ranges(dense.solved(float(speed[place])).torque)
        np.testing.assert_allclose(curve.values[:, place], expected, rtol=RTOL)


def test_largest_stress_is_that_of_its_speed_and_none_near_it_is_larger() -> None:
    shafts = dense.line()["shafts"]
    place = next(n for n, one in enumerate(shafts) if one["name"] == "intermediate shaft")
    modulus = np.pi * dense.diameter(shafts[place]) ** 3 / 16.0
    stress, speeds = quantity("largest/stress_half_range"), quantity("largest/speed")
    top = float(stress.values[list(stress.axes[0].values).index("intermediate shaft")])
    at = float(speeds.values[place])

    def stress_at(speed: float) -> float:
        return float(dense.half_ranges(dense.solved(speed).torque[[place]])[0] / modulus)

    assert stress_at(at) == pytest.approx(top, rel=RTOL)
    assert all(stress_at(at * (1.0 + off)) < top for off in (-1e-2, -1e-4, 1e-4, 1e-2))


def test_ends_of_the_barred_range() -> None:
    """16 n_c / (18 - lambda) and (18 - lambda) n_c / 16, or where the stress passes the limit."""
    shafts = dense.line()["shafts"]
    place = next(n for n, one in enumerate(shafts) if one["name"] == "intermediate shaft")
    wide, strength = dense.diameter(shafts[place]), dense.number(shafts[place]["tensile_strength"])
    peak = float(quantity("exceeded/peak_speed").values[0])
    ratio = peak / dense.operating_speed()
    low, high = 16.0 * peak / (18.0 - ratio), (18.0 - ratio) * peak / 16.0
    assert float(quantity("barred/from").values[0]) == pytest.approx(low, rel=RTOL)
    assert float(quantity("barred/to").values[0]) == pytest.approx(high, rel=RTOL)
    size = 0.35 + 0.93 * (1e3 * wide) ** -0.2
    for name in ("from", "to"):
        at = float(quantity(f"exceeded/{name}").values[0])
        allowed = (
            (strength / 1e6 + 160.0)
            / 18.0
            * size
            * (3.0 - 2.0 * (at / dense.operating_speed()) ** 2)
        )
        torque = dense.half_ranges(dense.solved(at).torque[[place]])[0]
        assert torque / (np.pi * wide**3 / 16.0) == pytest.approx(1e6 * allowed, rel=1e-8)


def test_dampings_at_the_operating_speed_and_over_speeds() -> None:
    found = quantity("damping/station").values
    np.testing.assert_allclose(found, dense.station_dampings(dense.operating_speed()), rtol=1e-12)
    wanted = [dense.loss(one) for one in dense.line()["shafts"]]
    np.testing.assert_allclose(quantity("damping/loss_factor").values, wanted, rtol=1e-14)
    curve = quantity("speeds/station_damping")
    names = [one["name"] for one in dense.line()["stations"]]
    rows = [names.index(name) for name in curve.axes[0].values]
    assert names[rows[-1]] == "propeller" and "flywheel" not in curve.axes[0].values
    expected = np.array([dense.station_dampings(one)[rows] for one in curve.axes[1].values])
    np.testing.assert_allclose(curve.values, expected.T, rtol=1e-12)
