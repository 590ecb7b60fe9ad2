"""Claim: over the speeds a line says what resonates, which gear hammers, how far its modes are.

The truth: the same line run at single speeds, order by order, and distances by the rule, which
`test_property_shaft_limits.py` holds by hand.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from engine_cases import ENGINE, ROOT, at_speed, record, replaced, value

from vibecalc.torsion.stress_limits import separation

RPM = np.pi / 30.0
RANGE = 'speeds = { from = "800 rpm", to = "2000 rpm" }'
WIDE = replaced(ENGINE, (RANGE, 'speeds = { from = "1500 rpm", to = "9000 rpm", points = 101 }'))


@pytest.mark.long
def test_the_order_of_a_maximum_is_highest_near_there_and_its_mode_is_met() -> None:
    order = record(WIDE)[f"{ROOT}/torque"].axes[1].values
    critical = value(WIDE, "critical/speed")
    top = value(WIDE, "peak/torque_half_range")
    strong = np.flatnonzero(top > 0.3 * top.max())[:4]
    assert len(strong) >= 3
    misled = 0
    for i in strong:
        speed, section = float(value(WIDE, "peak/speed")[i]), value(WIDE, "peak/section")[i] - 1
        mode, named = value(WIDE, "peak/mode")[i], value(WIDE, "peak/order")[i]
        place = int(np.flatnonzero(order == named)[0])
        assert critical[mode - 1, place] == pytest.approx(speed, rel=0.04)
        low, there, high = (
            np.abs(value(at_speed(WIDE, speed * share), "torque")[section])
            for share in (0.96, 1.0, 1.04)
        )
        gain = there - 0.5 * (low + high)
        assert gain[place] > 0.5 * gain.max()
        misled += int(np.argmax(there) != place)
    assert misled > 0  # the largest order alone would not do


def test_an_end_of_the_range_is_no_critical() -> None:
    text = replaced(ENGINE, (RANGE, 'speeds = { from = "6100 rpm", to = "6150 rpm", points = 5 }'))
    at = value(text, "largest/speed")
    end = np.isclose(at, 6100 * RPM, rtol=1e-12) | np.isclose(at, 6150 * RPM, rtol=1e-12)
    assert np.any(end)
    assert np.all(value(text, "largest/mode")[end] == 0)
    assert np.all(value(text, "largest/order")[end] == 0.0)


def test_maxima_are_reported_of_the_most_torqued_and_the_most_stressed_section() -> None:
    torque = int(np.argmax(value(WIDE, "largest/torque_half_range"))) + 1
    assert value(WIDE, "peak/section")[0] == torque
    stressed = record(WIDE)[f"{ROOT}/largest/stress_half_range"].axes[0].values
    assert set(value(WIDE, "peak/section")) == {torque, 1} and len(stressed) == 1


def test_separation_is_the_least_distance_to_orders_of_each_class() -> None:
    plain = (Path(__file__).parent.parent / "cases" / "engine_v8.toml").read_text(encoding="utf-8")
    text = replaced(
        plain,
        ("[response.torsion]\n", '[response.torsion]\nseparation = "api_618"\n'),
        ("points = 241", "points = 21"),
    )
    speeds = record(text)[f"{ROOT}/speeds/mean_torque"].axes[0].values
    order = np.asarray(record(text)[f"{ROOT}/critical/speed"].axes[1].values)
    major = value(text, "excitation/major") == 1
    natural = value(text, "modes/natural_frequency")
    operating = tomllib.loads(text)["machine"]["speed"]
    here = float(operating.split()[0]) * RPM
    for where, low, high in (("operating", here, here), ("range", speeds[0], speeds[-1])):
        got, kept = (value(text, f"separation/{where}/{name}") for name in ("margin", "sufficient"))
        out_of_reach = (natural == 0.0) | (natural > (order[-1] + 0.25) * high)
        assert np.all(np.isinf(got[out_of_reach])) and np.all(kept[out_of_reach] == 1)
        for column, chosen in enumerate((major, ~major)):
            expected = separation(natural[~out_of_reach], order[chosen], low, high, "api_618")
            least = expected.margin.min(axis=1)
            assert got[~out_of_reach, column] == pytest.approx(least, rel=1e-9)
            assert np.array_equal(kept[~out_of_reach, column] == 1, expected.kept.all(axis=1))
    nearest, away = (value(text, f"margin/{name}") for name in ("nearest_order", "distance"))
    assert np.all((nearest == 0) == np.isinf(away)) and np.any(nearest == 0)
