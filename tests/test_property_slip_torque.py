"""Claim: a motor's curve goes through its table, is odd, continuous, and keeps its peak; no power
is lost in a motor, and passivity holds, at any fluxes and speed.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from induction_motors import random_motor
from roll_machines import columns
from scipy.interpolate import CubicSpline

from vibecalc.excitation.gas_tables import FORCE_INTERPOLATIONS, force_at, gas_force
from vibecalc.excitation.induction_motor import steady_torque, torque_curve
from vibecalc.excitation.induction_motor_flux import flux_rates, flux_system, power_flow
from vibecalc.excitation.slip_torque import (
    SlipCurve,
    breakdown,
    interval_of,
    linear_motor,
    slip_curve,
    slip_torque,
)

SLIP, TORQUE = columns("roll_motor.csv")
#: tables of one and two rows beyond zero, one that falls at once, and one with uneven steps
KINDS = ("linear", "parabola", "monotone")
TABLES = {
    "source": (SLIP, TORQUE),
    "two": (np.array([0.0, 5.0]), np.array([0.0, 80.0])),
    "falling": (np.array([0.0, 1.0, 4.0]), np.array([0.0, 90.0, 30.0])),
    "uneven": (np.array([0.0, 0.1, 7.0, 7.5, 30.0]), np.array([0.0, 9.0, 80.0, 95.0, 94.0])),
}


def value(curve: SlipCurve, slip: np.ndarray) -> np.ndarray:
    return slip_torque(curve, np.asarray(slip)).value


@pytest.fixture(params=[(t, k) for t in TABLES for k in KINDS], ids="-".join)
def drawn(request: pytest.FixtureRequest) -> tuple[np.ndarray, np.ndarray, SlipCurve, str]:
    table, kind = request.param
    slip, torque = TABLES[table]
    return slip, torque, slip_curve(slip, torque, kind), kind


def test_through_the_nodes_on_both_sides(drawn) -> None:
    slip, torque, curve, _ = drawn
    largest = np.max(torque)
    np.testing.assert_allclose(value(curve, slip), torque, rtol=0, atol=1e-14 * largest)
    np.testing.assert_allclose(value(curve, -slip), -torque, rtol=0, atol=1e-14 * largest)
    assert curve.largest == slip[-1]


def test_continuous_at_every_threshold(drawn) -> None:
    _, torque, curve, kind = drawn
    above = interval_of(curve, curve.threshold)
    upper = slip_torque(curve, curve.threshold, above)
    lower = slip_torque(curve, curve.threshold, above - 1)
    np.testing.assert_allclose(upper.value, lower.value, rtol=0, atol=1e-13 * np.max(torque))
    if kind == "monotone":
        inner = slice(1, -1)
        size = np.max(np.abs(upper.slope))
        np.testing.assert_allclose(
            upper.slope[inner], lower.slope[inner], rtol=0, atol=1e-13 * size
        )


def test_slope_is_the_derivative(drawn) -> None:
    slip, _, curve, _ = drawn
    middles = np.concatenate([0.5 * (slip[1:] + slip[:-1]), -0.3 * slip[1:] - 0.7 * slip[:-1]])
    interval = interval_of(curve, middles)
    away = (middles - curve.base[interval]) + 1e-30j
    rows = curve.coefficient[interval]
    truth = np.imag(sum(rows[:, k] * away**k for k in range(rows.shape[1]))) / 1e-30
    np.testing.assert_allclose(slip_torque(curve, middles).slope, truth, rtol=1e-13)


def test_beyond_the_table_the_last_torque_is_kept(drawn) -> None:
    slip, torque, curve, _ = drawn
    for sign in (1.0, -1.0):
        found = slip_torque(curve, sign * np.array([slip[-1] * 1.01, slip[-1] * 50.0]))
        np.testing.assert_array_equal(found.value, sign * torque[-1])
        np.testing.assert_array_equal(found.slope, 0.0)


def test_monotone_between_nodes() -> None:
    for slip, torque in TABLES.values():
        curve = slip_curve(slip, torque, "monotone")
        for low, high, a, b in zip(slip, slip[1:], torque, torque[1:], strict=False):
            inside = value(curve, np.linspace(low, high, 201))
            step = np.diff(inside) * np.sign(b - a)
            assert np.min(step) > -1e-12 * np.max(torque)


@pytest.mark.parametrize("kind", KINDS)
def test_breakdown_is_the_peak(kind: str) -> None:
    for slip, torque in TABLES.values():
        curve = slip_curve(slip, torque, kind)
        at, peak = breakdown(curve)
        assert value(curve, np.array([at]))[0] == pytest.approx(peak, rel=1e-13)
        every = value(curve, np.linspace(0.0, slip[-1], 200001))
        assert peak >= np.max(every) * (1.0 - 1e-14)
        assert peak == pytest.approx(np.max(every), rel=1e-6)
        if kind != "parabola":
            assert (at, peak) == (pytest.approx(slip[np.argmax(torque)]), torque.max())


def test_linear_motor_has_no_peak() -> None:
    curve = linear_motor(203.4)
    found = slip_torque(curve, np.array([-5.0, 0.0, 1e3]))
    np.testing.assert_allclose(found.value, [-1017.0, 0.0, 203400.0], rtol=1e-15)
    np.testing.assert_array_equal(found.slope, 203.4)
    assert breakdown(curve) == (np.inf, np.inf)


# ----------------------------------------------------------------------------
# A gas force goes through its table, turn after turn.
# ----------------------------------------------------------------------------


TURN = 2.0 * np.pi
DEGREES, GAS_FORCE = columns("roll_first_stage.csv")
ANGLE = np.radians(DEGREES)
POINTS = np.random.default_rng(3).uniform(-3.0 * TURN, 3.0 * TURN, 400)
UNEVEN = np.array([0.0, 0.3, 0.35, 2.0, 3.1, 5.0, TURN])
UNEVEN_FORCE = np.array([5.0, 9.0, -2.0, 4.0, 4.5, 1.0, 5.0])


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, GAS_FORCE), (UNEVEN, UNEVEN_FORCE)])
def test_linear_is_interpolation_by_numpy(angle: np.ndarray, force: np.ndarray) -> None:
    truth = np.interp(POINTS, angle[:-1], force[:-1], period=TURN)
    found = force_at(gas_force(angle, force, "linear"), POINTS)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-12 * np.max(force))


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, GAS_FORCE), (UNEVEN, UNEVEN_FORCE)])
def test_cubic_is_the_periodic_spline(angle: np.ndarray, force: np.ndarray) -> None:
    truth = CubicSpline(angle, force, bc_type="periodic")(np.mod(POINTS, TURN))
    found = force_at(gas_force(angle, force, "cubic"), POINTS)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-12 * np.max(np.abs(truth)))


@pytest.mark.parametrize(("angle", "force"), [(ANGLE, GAS_FORCE), (UNEVEN, UNEVEN_FORCE)])
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
        gas = gas_force(ANGLE, GAS_FORCE, kind)
        for tiny in (-1e-17, -1e-300, 0.0):
            found = float(force_at(gas, np.asarray(tiny)))
            assert found == pytest.approx(GAS_FORCE[0], rel=1e-12)


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=50, deadline=None)
@given(seeds, st.integers(1, 3))
def test_power_in_is_heat_work_and_field(seed, cages):
    rng = np.random.default_rng(seed)
    motor = random_motor(rng, cages)
    speed = float(motor.synchronous_speed) * rng.uniform(-2.0, 2.0)
    rated = motor.phase_voltage / motor.line_frequency
    flux = rated * rng.normal(size=(5, 2 + 2 * cages))
    flow = power_flow(motor, flux, speed)
    left = (
        flow.electrical - flow.stator_copper - flow.rotor_copper
        - flow.mechanical - flow.magnetic_rate
    )  # fmt: skip
    assert np.all(np.abs(left) <= flow.error)
    scale = np.abs(flow.electrical) + flow.stator_copper + flow.rotor_copper
    assert np.all(flow.error <= 1e-9 * scale.max())
    # the rate of the energy is its derivative along the motion: exact for a quadratic
    rates = flux_rates(flux_system(motor), flux, speed).rates
    step = rated / np.linalg.norm(rates)
    ahead = power_flow(motor, flux + step * rates, speed).magnetic_energy
    behind = power_flow(motor, flux - step * rates, speed).magnetic_energy
    slope = (ahead - behind) / (2.0 * step)
    allowed = 1e-12 * (ahead + behind) / step + flow.error
    assert np.all(np.abs(slope - flow.magnetic_rate) <= allowed)
    assert np.all(flow.magnetic_energy > 0.0) and np.all(flow.rotor_copper > 0.0)


@settings(max_examples=15, deadline=None)
@given(seeds, st.integers(1, 3))
def test_curve_has_no_higher_point_than_its_breakdown(seed, cages):
    rng = np.random.default_rng(seed)
    motor = random_motor(rng, cages)
    curve = torque_curve(motor)
    unit = motor.rotor_resistance / motor.rotor_leakage / motor.pole_pairs
    slips = np.geomspace(1e-4 * unit.min(), 1e4 * unit.max(), 4001)
    torque = steady_torque(motor, slips).value
    top = curve.breakdown_torque.value
    assert np.all(torque <= top * (1.0 + 1e-12))
    assert torque.max() > 0.9999 * top
