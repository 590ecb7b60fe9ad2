"""Claim: curves of orders, irregularity and the worst condition are those of full matrices."""

import re
from typing import Any

import numpy as np
import pytest
from dense_curve_line import (
    HIGH,
    LOW,
    OPERATING,
    ORDER,
    RPM,
    SPEED,
    dense,
    half_range,
    ratio,
    response,
    run,
    text,
    values,
)
from engine_cases import ran
from long_but import long_but

EVERY = f"orders = {[*ORDER.tolist()]}"
CURVES = f"""
irregularity = [{{ on = "generator", pole_pairs = 3 }}, {{ on = "flywheel" }}, {{ on = "wheel" }}]
[[response.torsion.curves]]
on = "tail"
quantities = ["torque", "stress", "twist"]
{EVERY}
measured = {{ speed = ["600 rpm", "731 rpm"], order = [0, 1.5], torque = ["2 kN*m", "1.1 kN*m"] }}
[[response.torsion.curves]]
on = "rubber"
[[response.torsion.curves]]
on = "teeth"
[[response.torsion.curves]]
on = "generator"
quantities = ["angle", "angular_speed", "angular_acceleration"]
{EVERY}
[[response.torsion.curves]]
on = "wheel"
quantities = ["angular_acceleration", "angle", "angular_speed"]
{EVERY}
[[response.torsion.limits]]
curve = {{ speed = ["500 rpm", "1300 rpm"], stress = ["40 MPa", "60 MPa"] }}
sections = ["tail"]
[[response.torsion.limits]]
curve = {{ speed = ["500 rpm", "900 rpm"], stress = ["45 MPa", "45 MPa"] }}
sections = ["tail", "quill"]
"""
CONDITIONS = """
[response.torsion.conditions]
imbalance = 0.15
pressure_scale = [1.05, 0.9, 1]
[[response.torsion.limits]]
curve = { speed = ["500 rpm", "1300 rpm"], stress = ["40 MPa", "60 MPa"] }
sections = ["tail", "quill"]
"""
#: factors on the gas pressure in the conditions, in their order
SCALES: list[dict[str, float]] = [
    {}, {"1": 0.0}, {"2": 0.0}, {"3": 0.0}, {"1": 0.85}, {"2": 0.85}, {"3": 0.85},
    {"1": 1.05, "2": 0.9},
]  # fmt: skip
SOME = [0, 7, 23, 41, 60]


def near(found: Any, expected: Any, size: float = 0.0) -> None:
    expected = np.asarray(expected)
    np.testing.assert_allclose(
        found, expected, rtol=1e-9, atol=1e-9 * max(size, float(np.max(np.abs(expected))))
    )


@pytest.mark.parametrize("at", SOME)
def test_orders_of_sections_are_those_of_full_matrices(at: int) -> None:
    result, (_, torque) = run(CURVES), response(SPEED[at])
    names = list(result.record["response/torsion/curves/torque/order"].axes[0].values)
    tail = next(one for one in dense().line["shafts"] if one["name"] == "tail")
    assert names == ["tail", "rubber", "teeth"]
    wanted = torque[[dense().sections.index(name) for name in names]]
    # the sense of a torque behind a gear is that of its own shaft
    near(values(result, "curves/torque/order")[..., at], wanted)
    near(values(result, "curves/stress/order")[0, :, at], wanted[0] / tail["section_modulus"])
    whole = tail["stiffness"] + 1j * ORDER * SPEED[at] * tail["damping"]
    near(values(result, "curves/twist/order")[0, :, at], wanted[0] / whole)
    for name, row in zip(names, wanted, strict=True):
        place = names.index(name)
        near(values(result, "curves/torque/half_range")[place, at], half_range(row))
        near(values(result, "curves/torque/sum")[place, at], np.abs(row).sum())


@pytest.mark.parametrize("at", SOME)
def test_derivatives_of_the_angles_are_those_of_full_matrices(at: int) -> None:
    result, (angle, _) = run(CURVES), response(SPEED[at])
    w = ORDER * SPEED[at]
    for name, factor in (
        ("angle", np.ones_like(w)),
        ("angular_speed", 1j * w),
        ("angular_acceleration", -(w**2)),
    ):
        stations = list(result.record[f"response/torsion/curves/{name}/order"].axes[0].values)
        assert stations == ["generator", "wheel"]
        for place, one in enumerate(stations):
            wanted = factor * angle[one]
            near(values(result, f"curves/{name}/order")[place, :, at], wanted)
            near(values(result, f"curves/{name}/half_range")[place, at], half_range(wanted))
            near(values(result, f"curves/{name}/sum")[place, at], np.abs(wanted).sum())
            peak = values(result, f"curves/{name}/peak")[place, at]
            assert half_range(wanted) * (1 - 1e-12) <= peak <= np.abs(wanted).sum() * (1 + 1e-12)


@pytest.mark.long
def test_the_largest_amplitude_of_an_order_is_found_between_the_speeds() -> None:
    result = run(CURVES)
    top, at = (values(result, f"curves/torque/{one}") for one in ("largest", "largest_speed"))
    assert dense().sections[-3] == "tail"
    coarse = np.array([np.abs(response(one)[1][-3]) for one in np.linspace(LOW, HIGH, 240)])
    assert (top[0] >= coarse.max(axis=0) * (1 - 1e-12)).all()
    for order in np.flatnonzero(np.isin(ORDER, [0.5, 1.5, 3.0, 4.5])):
        near_it = np.clip(at[0, order] * (1.0 + 1e-4 * np.arange(-2, 3)), LOW, HIGH)
        own = np.array([np.abs(response(one)[1][-3][order]) for one in near_it])
        assert own[2] == pytest.approx(top[0, order], rel=1e-9)
        assert own.max() <= own[2] * (1 + 1e-12)


def test_orders_of_some_share_are_kept_and_all_of_them_stand_in_the_sums() -> None:
    result = run(
        CURVES.replace(EVERY, "share = 0.2").split("measured")[0]
        + "[[response.torsion.curves]]\non = 'c1'\nshare = 0.2\n"
    )
    kept = result.record["response/torsion/curves/torque/order"].axes[1].values
    whole = np.abs(values(run(CURVES), "curves/torque/order")[0]).max(axis=1)
    assert set(kept) == set(ORDER[whole >= 0.2 * whole.max()])
    near(values(result, "curves/torque/half_range"),
         values(run(CURVES), "curves/torque/half_range")[:1])  # fmt: skip
    assert values(result, "curves/angle/half_range").shape == (1, len(SPEED))


def test_measured_points_stand_next_to_what_is_computed_at_their_speeds() -> None:
    result = run(CURVES)
    value, computed, order, section, speed = (
        values(result, f"curves/torque/measured/{one}")
        for one in ("value", "computed", "order", "section", "speed")
    )
    assert (value == [2000.0, 1100.0]).all() and (section == 1).all()
    assert (order == [0.0, 1.5]).all()
    near(speed, np.array([600.0, 731.0]) * RPM)
    first, second = (response(one)[1][-3] for one in speed)
    near(computed, [half_range(first), abs(second[ORDER == 1.5][0])])


def test_the_strictest_limit_of_a_section_stands_next_to_its_curve() -> None:
    allowed = values(run(CURVES), "curves/stress/allowed")
    expected = np.interp(SPEED, np.array([500, 1300]) * RPM, [40e6, 60e6])
    lower = np.where(SPEED <= 900 * RPM * (1 + 1e-12), 45e6, np.inf)
    near(allowed, [np.minimum(expected, lower)])
    assert np.isinf(values(run(CURVES), "curves/stress/transient")).all()


# ----------------------------------------------------------------------------
# Cyclic irregularity.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("at", SOME)
def test_irregularity_is_the_range_of_the_own_speed_over_its_mean(at: int) -> None:
    result, (angle, _) = run(CURVES), response(SPEED[at])
    for row, name in enumerate(("generator", "flywheel", "wheel")):
        own = 1j * ORDER * SPEED[at] * angle[name]
        degree = 2.0 * half_range(own) / abs(ratio(name) * SPEED[at])
        near(values(result, "irregularity/speeds/degree")[row, at], degree)
    electrical = values(result, "irregularity/speeds/electrical_angle")
    assert electrical.shape == (1, len(SPEED))
    near(electrical[0, at], 3.0 * half_range(angle["generator"]))


def test_irregularity_at_the_operating_speed_and_its_largest_one() -> None:
    result = run(CURVES)
    angle = response(OPERATING)[0]["flywheel"]
    near(values(result, "irregularity/degree")[1], 2.0 * half_range(1j * ORDER * angle))
    top, at = (values(result, f"irregularity/largest/{one}") for one in ("degree", "speed"))
    seen = values(result, "irregularity/speeds/degree").max(axis=1)
    assert (top >= seen * (1 - 1e-13)).all()
    for row, name in enumerate(("generator", "flywheel", "wheel")):
        own = 2.0 * half_range(1j * ORDER * response(at[row])[0][name] / ratio(name))
        assert own == pytest.approx(top[row], rel=1e-9)


# ----------------------------------------------------------------------------
# Conditions of the cylinders.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("at", long_but([0, 7, 41], 7))
def test_the_worst_of_all_conditions_is_that_of_full_matrices(at: int) -> None:
    result = run(CONDITIONS)
    each = [response(SPEED[at], scale) for scale in SCALES]
    torque = np.max([[half_range(row) for row in one] for _, one in each], axis=0)
    angle = np.max([[half_range(row) for row in one.values()] for one, _ in each], axis=0)
    near(values(result, "conditions/speeds/torque_half_range")[:, at], torque)
    near(values(result, "conditions/speeds/angle_half_range")[:, at], angle)
    assert len(angle) == len(dense().names)


def test_conditions_and_irregularity_need_no_range_of_speeds() -> None:
    speeds = 'speeds = { from = "500.0 rpm", to = "1300.0 rpm", points = 61 }'
    asked = 'irregularity = [{ on = "flywheel" }]' + CONDITIONS
    assert speeds in text(asked)
    alone = ran(text(asked).replace(speeds, ""))
    assert not [path for path in alone.record if "/speeds/" in path or "/largest" in path]
    for path in (
        "torque_half_range",
        "angle_half_range",
        "limit/operating_utilisation",
        "mean_torque",
    ):
        near(values(alone, f"conditions/{path}"), values(run(CONDITIONS), f"conditions/{path}"))
    near(values(alone, "irregularity/degree"), values(run(CURVES), "irregularity/degree")[1:2])


@pytest.mark.long
def test_irregularity_of_every_condition_is_that_of_full_matrices() -> None:
    result = run('irregularity = [{ on = "generator" }, { on = "c1" }]' + CONDITIONS)
    found = result.record["response/torsion/conditions/irregularity"]
    assert list(found.axes[1].values) == ["generator", "c1"]
    for row, scale in enumerate(SCALES):
        angle = response(OPERATING, scale)[0]
        near(found.values[row], [
            2.0 * half_range(1j * ORDER * angle[name]) / abs(ratio(name))
            for name in ("generator", "c1")
        ])  # fmt: skip
    near(found.values[0], values(result, "irregularity/degree"))


@pytest.mark.long
def test_an_undamped_line_has_orders_without_bound_at_its_criticals() -> None:
    asked = 'curves = [{ on = "s1" }]\nconditions = {}\nirregularity = [{ on = "c1" }]'
    bare = text(asked).replace("loss_factor = 0.17", "loss_factor = 0.0")
    for name in ("damping = ", "absolute_damping = "):
        bare = re.sub(rf"\b{name}[0-9.]+", f"{name}0.0", bare)
    result = ran(bare)
    masked = values(result, "resonances_skipped/from")
    assert len(masked)
    top = values(result, "curves/torque/largest")[0]
    order = result.record["response/torsion/curves/torque/order"].axes[1].values
    at = values(result, "curves/torque/largest_speed")[0]
    met = set(values(result, "resonances_skipped/order"))
    natural = values(result, "modes/natural_frequency")
    assert {one for one, height in zip(order, top, strict=True) if np.isinf(height)} <= met
    for number in np.flatnonzero(np.isinf(top)):
        assert np.min(np.abs(natural - order[number] * at[number])) < 1e-6 * natural.max()
    assert np.isinf(top).any()
    assert np.isinf(values(result, "conditions/largest/torque_half_range")).any()
    assert np.isinf(values(result, "irregularity/largest/degree")).all()
