"""Claim: torques of gears and couplings and their limits are what the full matrices give.

Of `dense_line.py`; of the package only the torques of one cylinder by order are used.
"""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from dense_line import DenseLine, cylinder_of, half_range
from shipped_cases import CASES, fresh

from vibecalc.core.case.load import load_case, resolve

ORDER = 0.5 * np.arange(1, 25)
RPM = math.pi / 30.0


def values(path: str) -> np.ndarray:
    return np.asarray(fresh("engine_geared").record[f"response/torsion/{path}"].values)


def axis(path: str, place: int) -> list[Any]:
    found = fresh("engine_geared").record[f"response/torsion/{path}"].axes[place]
    return list(found.values)


@cache
def line() -> DenseLine:
    case = resolve(load_case(CASES["engine_geared"]).case)
    cylinder = cylinder_of(fresh("engine_geared").record, case)
    return DenseLine(case, lambda speed: cylinder)


@cache
def halves(speed: float) -> dict[str, float]:
    """Half ranges of the own torques, of gears on the first wheel."""
    found = line().at(speed)
    gears = [gear["name"] for gear in line().gears]
    torque = np.concatenate([found.torque, found.gear])
    return dict(zip([*line().sections, *gears], half_range(ORDER, torque), strict=True))


def half(name: str, speed: float) -> float:
    return halves(speed)[name]


#: limit -> load, torque allowed for lasting and for passing through at the operating speed, N m;
#: 0.3 of the mean torque of the reduction, which drives all but the take-off: 12906.4 - 3800 N m
ALLOWED = {
    4: ("reduction", 0.3 * 9106.38, math.inf),
    5: ("power take-off", 1100.0, 3800.0),
    6: ("rubber", 4000.0, 12000.0),
}


@pytest.mark.parametrize("limit", ALLOWED)
def test_limits_of_torques_at_the_operating_speed(limit: int) -> None:
    name, lasting, passing = ALLOWED[limit]
    column = axis("limit/operating/torque", 1).index(name)
    torque = half(name, 750.0 * RPM)
    assert values("limit/operating/torque")[limit - 1, column] == pytest.approx(torque, rel=1e-9)
    allowed = values("limit/operating/torque_allowed")[limit - 1, column]
    assert allowed == pytest.approx(lasting, rel=1e-6)
    assert values("limit/operating/torque_transient")[limit - 1, column] == passing
    assert values("limit/operating_utilisation")[limit - 1] == pytest.approx(
        torque / allowed, rel=1e-9
    )
    # others than the loads of a limit have nothing in its row
    others = np.delete(values("limit/operating/torque")[limit - 1], column)
    assert np.all(others == 0.0)


def table(limit: int, speed: float, column: int) -> float:
    """Of the CSV next to the case, by hand."""
    take_off = ([3800, 3800, 1100, 1100], [8500, 8500, 3800, 3800])[column]
    if limit == 5:
        return float(np.interp(speed / RPM, [300, 560, 600, 800], take_off))
    return {4: 0.3 * float(values("gear/mean_torque")[0]), 6: (4000.0, 12000.0)[column]}[limit]


def test_the_largest_uses_over_the_speeds() -> None:
    for limit in ALLOWED:
        name, at = ALLOWED[limit][0], float(values("limit/speed")[limit - 1])
        use = values("limit/largest_utilisation")[limit - 1]
        assert half(name, at) / table(limit, at, 0) == pytest.approx(use, rel=1e-9)
        # nothing between the speeds of the sweep is higher
        for speed in at * (1.0 + np.array([-3e-3, -1e-3, 1e-3, 3e-3])):
            if speed >= 300.0 * RPM:
                assert half(name, speed) / table(limit, speed, 0) < use
    sweep = values("speeds/gear_torque")[1] / [
        table(5, v, 1) for v in axis("speeds/gear_torque", 1)
    ]
    passing = values("limit/passage_utilisation")
    assert sweep.max() <= passing[4] <= 1.001 * sweep.max()
    assert passing[3] == 0.0  # a share of the mean is no limit for passing through


def test_the_range_in_which_the_take_off_exceeds_its_table() -> None:
    low, high = (float(values(f"exceeded/{name}")[0]) for name in ("from", "to"))
    assert values("exceeded/limit").tolist() == [5]
    for end in (low, high):
        assert half("power take-off", end) == pytest.approx(table(5, end, 0), rel=1e-8)
    assert half("power take-off", 0.5 * (low + high)) > table(5, 0.5 * (low + high), 0)
    assert [low, high] == pytest.approx([values(f"barred/{n}")[0] for n in ("from", "to")])


def test_the_crankshaft_by_its_torques() -> None:
    # nominal stress of the pin: torque over pi / 16 * 220^3 mm3, as it has no bore
    modulus = math.pi / 16.0 * 0.22**3
    named = axis("limit/crank/acceptability", 1)
    for name in ("crank 4-5", "crank 6"):
        column = named.index(name)
        stress = half(name, 750.0 * RPM) / modulus
        found = values("limit/operating/stress")[6, column]
        assert found == pytest.approx(stress, rel=1e-9)
        # pin fillet: alpha_B 1.8692137582 * 30 + 10 = 66.0764 N/mm2, alpha_T 1.9293427015,
        # sigma_DW = 1.05 * 259.4330610845 N/mm2; see test_property_shaft_limits.py
        equivalent = math.hypot(66.076412745989, math.sqrt(3.0) * 1.92934270152 * stress / 1e6)
        factor = values("limit/crank/operating_acceptability")[6, column, 0]
        assert factor == pytest.approx(1.05 * 259.43306108450 / equivalent, rel=1e-9)
        # oil bore: 2.758 * 20 = 55.16, gamma_T 3.7, K = 1: 262.5823066494
        bore = math.hypot(55.16, 1.5 * 3.7 * stress / 1e6)
        factor = values("limit/crank/operating_acceptability")[6, column, 2]
        by_hand = 262.58230664943 / ((55.16 + 2.0 * bore) / 3.0)
        assert factor == pytest.approx(by_hand, rel=1e-9)
        # the bore is the worst place: 228.3324405647 = 262.58 / 1.15; (3 * 228.33 - 55.16) / 2;
        # 2 / 3 of the root, over 3.7
        half_way = 0.5 * (3.0 * 228.33244056472 - 55.16)
        allowed = 2.0 / 3.0 * math.sqrt(half_way**2 - 55.16**2) / 3.7
        assert values("limit/operating/allowed")[6, column] == pytest.approx(
            1e6 * allowed, rel=1e-9
        )
