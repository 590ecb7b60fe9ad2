"""Claim: what the kernels get of an absorber says what the case says, each checked another way."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest
from absorber_cases import PENDULUM, RATIOS, RIG, SEVERAL
from exact_pendulum import rates

from vibecalc.absorber.hardware.oil_gap import oil_damping
from vibecalc.absorber.model import AbsorberParts, Branch, build_absorber
from vibecalc.absorber.pendulum_order import PendulumParts, build_pendulum, tuning_order
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import set_key
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.schema import Case

ROLLERS = {"mass": 0.08, "distance": 0.092, "diameter": 0.015}


def case_of(text: str, **changes: Any) -> Case:
    """A case with keys added or replaced; None takes one away."""
    data = tomllib.loads(text)
    for key, value in changes.items():
        *above, last = key.split("__")
        if value is None:
            table = data
            for part in above:
                table = table[part]
            del table[last]
        else:
            set_key(data, (*above, last), value)
    case = validate(data)
    assert check_machine(case) == []
    return case


def parts(text: str, **changes: Any) -> AbsorberParts:
    return build_absorber(case_of(text, **changes))


def pendulums(**changes: Any) -> PendulumParts:
    return build_pendulum(case_of(PENDULUM, **changes))


def test_the_own_ratio_is_referred_to_the_primary() -> None:
    own = parts(RATIOS, machine__secondary__damping_over_primary_critical=None,
                machine__secondary__absorber_damping_ratio=0.185)  # fmt: skip
    assert own.absorber is not None
    assert own.absorber.secondary_damping == pytest.approx(0.185 * math.sqrt(0.1 * 0.08), rel=1e-15)


def test_the_rule_gives_the_clearance_and_sides_may_differ() -> None:
    found = parts(RIG, machine__gap__clearance=None, machine__gap__side_clearance="1 mm",
                  machine__gap__bore_clearance="0.8 mm")  # fmt: skip
    assert found.filling is not None
    gap = found.filling.gap
    inches = 0.010 * (1.0 + math.sqrt(2.0 * 0.14 / 0.254))
    assert gap.rim_clearance == pytest.approx(inches * 0.0254, rel=1e-14)
    assert (gap.side_clearance, gap.bore_clearance) == (0.001, 0.0008)
    assert found.filling.temperature == pytest.approx(313.15, rel=1e-15)


def test_several_stand_behind_what_carries_them() -> None:
    data = tomllib.loads(SEVERAL)
    data["machine"]["secondaries"].reverse()
    data["machine"]["secondaries"].append(
        {"name": "leaf", "on": "far", "mass_ratio": 0.01, "stiffness_ratio": 0.02}
    )
    for one, k in zip(data["machine"]["secondaries"][:2], (0.04, 0.06), strict=True):
        one["stiffness_ratio"] = k
    for one in data["machine"]["secondaries"]:
        one["damping_over_primary_critical"] = 0.01
    del data["tuning"]
    case = validate(data)
    assert check_machine(case) == []
    found = build_absorber(case)
    assert found.absorber is None and not found.is_complete
    assert found.branches == (
        Branch("near", -1, 0.05, 0.06, 0.01),
        Branch("far", 0, 0.03, 0.04, 0.01),
        Branch("leaf", 1, 0.01, 0.02, 0.01),
    )
    assert build_absorber(case_of(SEVERAL)).branches[1] == Branch("far", 0, 0.03, None, None)


def test_stock_is_the_list_and_then_the_catalogue() -> None:
    found = parts(
        RIG,
        machine__spring_catalogue={"part": [7, 9], "rate": ["1 N/mm", "5 N/mm"]},
        machine__oil_catalogue={"part": [460], "viscosity_40": ["460 cSt"],
                                "viscosity_100": ["31 cSt"], "density": [902.0]},
    )  # fmt: skip
    assert found.stock.spring_names == ("soft", "7", "9")
    np.testing.assert_allclose(found.stock.spring_rates, [2000.0, 1000.0, 5000.0], rtol=1e-15)
    assert [oil.name for oil in found.stock.oils] == ["thin", "460"]
    assert found.filling is not None and found.filling.oil is not None
    one, other = (
        oil_damping(oil, found.filling.gap, 330.0).value
        for oil in (found.filling.oil, found.stock.oils[1])
    )
    assert one == pytest.approx(float(other), rel=1e-12)


def test_pendulums_swing_together() -> None:
    found = pendulums(machine__pendulum__rollers=ROLLERS, machine__pendulum__damping_ratio=0.02)
    assert found.pendulum.mass == pytest.approx(3.6)
    assert found.pendulum.roller_mass == pytest.approx(0.32)
    assert found.pendulum.roller_inertia == pytest.approx(0.32 * 0.015**2 / 8.0)
    one = pendulums(machine__pendulum__rollers=ROLLERS, machine__pendulum__count=1)
    assert tuning_order(found.pendulum).value == pytest.approx(
        float(tuning_order(one.pendulum).value), rel=1e-13
    )
    # a small swing at a heavy rotor's constant speed decays by exp(-2 pi z / sqrt(1 - z^2)) a turn
    heavy, speed, small = 1e9, found.speed, 1e-4
    force = rates(found.pendulum, heavy, np.array([0.0, small, speed, 0.0]), 0.0, found.damping)[3]
    drag = rates(found.pendulum, heavy, np.array([0.0, 0.0, speed, small]), 0.0, found.damping)[3]
    own = math.sqrt(-force / small)
    assert own == pytest.approx(float(tuning_order(found.pendulum).value) * speed, rel=1e-6)
    assert -drag / small == pytest.approx(2.0 * 0.02 * own, rel=1e-6)


@pytest.mark.parametrize("path", ["circular", "cycloidal", "epicycloidal"])
def test_a_path_that_is_not_given_is_tuned(path: str) -> None:
    tuned = pendulums(machine__pendulum__path_radius=None, machine__pendulum__path=path)
    assert tuned.is_tuned
    assert tuning_order(tuned.pendulum).value == pytest.approx(2.0, rel=1e-14)
    by_arm = pendulums(
        machine__pendulum__path_radius=None,
        machine__pendulum__vertex_distance=None,
        machine__pendulum__arm_radius="76 mm",
        machine__pendulum__path=path,
    )
    assert by_arm.pendulum.path_radius == pytest.approx(0.019, rel=1e-14)
    assert by_arm.pendulum.vertex_distance == pytest.approx(0.095, rel=1e-14)
    with_rollers = pendulums(
        machine__pendulum__path_radius=None,
        machine__pendulum__path=path,
        machine__pendulum__rollers=ROLLERS,
    )
    assert tuning_order(with_rollers.pendulum).value == pytest.approx(2.0, rel=1e-13)
    assert with_rollers.pendulum.path_radius != pytest.approx(0.019, rel=1e-3)
