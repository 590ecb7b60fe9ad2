"""Claim: a run of a shaft line says what its matrices, built by hand here, say of it.

The truth: dense solves of matrices in own speeds, torques of a cylinder by a fine sum over its
cycle, balances of power and of torque, and the same line asked in another way.
"""

import tomllib
from functools import cache
from typing import Any

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, replaced
from long_but import long_but

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure

ROOT = "response/torsion"
POINTS = "speeds = { from = '800 rpm', to = '6000 rpm', points = 21 }"
ENGINE = replaced(ENGINE, ('speeds = { from = "800 rpm", to = "2000 rpm" }', POINTS))
SPEED = 1500.0 * np.pi / 30.0
ORDER = np.arange(1, 13) / 2.0


@cache
def record(text: str) -> Record:
    case = validate(tomllib.loads(text))
    made = run_case(case)
    assert set(made) == set(planned_quantities(case))
    return made


def value(text: str, path: str) -> np.ndarray:
    return np.asarray(record(text)[f"{ROOT}/{path}"].values)


def cylinder(order: np.ndarray, speed: float, cycle: float) -> tuple[np.ndarray, float]:
    """Torque of one cylinder at some orders, and its mean, by a sum over 2^15 angles."""
    r, length, mass, area = 0.06, 0.2, 2.0, 0.25 * np.pi * 0.1**2
    t = np.linspace(0.0, cycle, 1 << 15, endpoint=False)
    rod = np.sqrt(length**2 - (r * np.sin(t)) ** 2)
    rise = -r * np.sin(t) - r**2 * np.sin(t) * np.cos(t) / rod
    top = r**2 * (np.cos(2 * t) * rod**2 + (r * np.sin(t) * np.cos(t)) ** 2) / rod**3
    bend = -r * np.cos(t) - top
    pressure = np.interp(t, [0.0, np.pi / 2.0, cycle], [6e6, 0.0, 6e6])
    torque = -(pressure * area + mass * speed**2 * bend) * rise
    harmonics = 2.0 * np.mean(torque * np.exp(-1j * order[:, None] * t), axis=1)
    return harmonics, float(np.mean(torque))


def swing(order: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Half range of signals (..., m) by looking at many angles."""
    t = np.linspace(0.0, 4.0 * np.pi, 20000)
    course = (amplitude @ np.exp(1j * order[:, None] * t)).real
    return 0.5 * (course.max(-1) - course.min(-1))


def by_hand(speed: float) -> np.ndarray:
    """Torques (3 shafts, orders) of the three cylinders in line with their viscous ring."""
    inertia = np.diag([0.1, 0.1, 0.1, 2.0, 0.2])
    stiffness, damping = np.zeros((5, 5)), np.zeros((5, 5))
    for a, b, k, c in ((0, 1, 1e6, 0), (1, 2, 1e6, 0), (2, 3, 2e6, 5.0), (0, 4, 0.0, 30.0)):
        cell = np.ix_([a, b], [a, b])
        stiffness[cell] += k * np.array([[1, -1], [-1, 1]])
        damping[cell] += c * np.array([[1, -1], [-1, 1]])
    one, _ = cylinder(ORDER, speed, 4.0 * np.pi)
    firing = np.radians([0.0, 480.0, 240.0])  # 1, 3, 2
    found = []
    for q, torque in zip(ORDER, one, strict=True):
        load = np.zeros(5, dtype=complex)
        load[:3] = torque * np.exp(-1j * q * firing)
        w = q * speed
        phi = np.linalg.solve(stiffness + 1j * w * damping - w**2 * inertia, load)
        twist = phi[:3] - phi[1:4]
        found.append(np.array([1e6, 1e6, 2e6 + 5j * w]) * twist)
    return np.array(found).T


def test_torques_in_the_shafts_are_those_of_a_dense_solve() -> None:
    expected = by_hand(SPEED)
    got = value(ENGINE, "torque")[:3]
    assert np.abs(got - expected).max() < 1e-6 * np.abs(expected).max()
    half = swing(ORDER, expected)
    assert value(ENGINE, "torque_half_range")[:3] == pytest.approx(half, rel=1e-6)
    _, mean = cylinder(ORDER, SPEED, 4.0 * np.pi)
    # each cylinder adds its own to what the shaft behind it carries
    assert np.abs(value(ENGINE, "torque_mean")) == pytest.approx(
        np.abs(mean) * np.array([1, 2, 3, 0]), rel=1e-6, abs=1e-9
    )
    modulus = np.pi * 0.07**3 / 16.0
    assert value(ENGINE, "stress_half_range")[0] == pytest.approx(half[0] / modulus, rel=1e-6)


def test_curves_are_those_of_a_dense_solve_at_each_speed() -> None:
    speeds = record(ENGINE)[f"{ROOT}/speeds/torque_half_range"].axes[1].values
    for place in (0, 7, 20):
        half = swing(ORDER, by_hand(float(speeds[place])))
        got = value(ENGINE, "speeds/torque_half_range")[:3, place]
        assert got == pytest.approx(half, rel=1e-6)


def test_power_of_the_torques_is_the_heat() -> None:
    load, angle = value(ENGINE, "excitation/station_torque"), value(ENGINE, "angle")
    power = 0.5 * SPEED * np.sum(ORDER * np.imag(load * np.conj(angle)))
    heat = value(ENGINE, "section_heat").sum() + value(ENGINE, "station_heat").sum()
    assert heat == pytest.approx(power, rel=1e-10)
    assert value(ENGINE, "damper/heat")[0] == value(ENGINE, "section_heat")[-1] > 0.0


def at_speed(text: str, speed: float) -> str:
    """The line at another speed and nowhere else."""
    return replaced(text, (POINTS, ""), ('speed = "1500 rpm"', f"speed = {float(speed)!r}"))


def test_a_maximum_is_what_the_line_does_at_that_speed() -> None:
    grid = value(ENGINE, "speeds/torque_half_range")
    top, at = value(ENGINE, "largest/torque_half_range"), value(ENGINE, "largest/speed")
    assert np.all(top >= grid.max(axis=1))
    assert at.min() > 0.999 * SPEED * 800.0 / 1500.0 and at.max() < 1.001 * SPEED * 6000.0 / 1500.0
    peak = float(value(ENGINE, "peak/speed")[0])
    section = int(value(ENGINE, "peak/section")[0]) - 1
    there = value(at_speed(ENGINE, peak), "torque_half_range")[section]
    assert there == pytest.approx(value(ENGINE, "peak/torque_half_range")[0], rel=1e-11)
    for nearby in (0.9999, 1.0001):
        assert value(at_speed(ENGINE, peak * nearby), "torque_half_range")[section] < there


@pytest.mark.parametrize("method", long_but(["dense", "modal"], "modal"))
def test_methods_agree(method: str) -> None:
    model = 'damping_model = { kind = "rayleigh", modes = [3, 4], ratios = [0.01, 0.02] }'
    one = ENGINE + model
    other = one + f'\nmethod = "{method}"'
    for path in ("torque", "speeds/torque_half_range", "largest/torque_half_range"):
        size = np.abs(value(one, path)).max()
        assert np.abs(value(other, path) - value(one, path)).max() < 1e-9 * size, path
    # two rigid modes come first: of the line, and of the ring in oil
    ratios = value(one, "modes/damping_ratio")
    assert ratios[2:4] == pytest.approx([0.01, 0.02], rel=1e-12)


def test_a_line_without_its_damper_is_the_bare_one() -> None:
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    alone = ENGINE.replace(ring, "")
    for path in ("speeds/torque_half_range", "largest/torque_half_range"):
        expected = value(alone, path)
        size = np.abs(expected).max()
        assert np.abs(value(ENGINE, f"bare/{path}") - expected).max() < 1e-10 * size
    gain = (
        value(alone, "largest/torque_half_range") / value(ENGINE, "largest/torque_half_range")[:3]
    )
    assert value(ENGINE, "reduction") == pytest.approx(gain, rel=1e-10)


def test_gears_carry_what_their_wheels_need() -> None:
    """Newton's law of the wheel with the shaft behind it, and of the elastic take-off, own speeds.

    The wheel turns a third as fast as the pinion and the other way round.
    """
    order = np.arange(1, 13, dtype=float)
    w = order * 600.0 * np.pi / 30.0
    angle, torque = value(GEARED, "angle"), value(GEARED, "torque")
    pinion, wheel = angle[2], angle[3]
    assert wheel == pytest.approx(-pinion / 3.0, rel=1e-12)
    # sections: a-b, b-pinion, wheel-propeller, take-off-generator, mesh of wheel and take-off
    on_wheel = -(w**2) * 3.0 * wheel + torque[2] + torque[4]
    on_pinion = -on_wheel / 3.0
    assert -(w**2) * 0.05 * pinion == pytest.approx(torque[1] - on_pinion, rel=1e-7, abs=1e-9)
    half = value(GEARED, "gear/alternating_torque")
    assert half[0] == pytest.approx(swing(order, on_pinion), rel=1e-6)
    mesh = -(w**2) * 0.02 * angle[5] + torque[3]  # on the take-off, four times as fast
    assert half[1] == pytest.approx(swing(order, 4.0 * mesh), rel=1e-5)
    _, mean = cylinder(order, 1.0, 2.0 * np.pi)
    steady = value(GEARED, "gear/mean_torque")
    assert abs(steady[0]) == pytest.approx(2.0 * abs(mean), rel=1e-6)
    assert steady[1] == pytest.approx(0.0, abs=1e-9)  # the propeller takes all


@pytest.mark.parametrize("speed", [180.0, pytest.param(95.0, marks=pytest.mark.long)])
def test_pendulums_hold_their_station_still_at_any_speed(speed: float) -> None:
    pendulum = (
        'dampers = [{ name = "ring", on = "a", kind = "pendulum", order = 1.5, mass = "0.6 kg", '
        'arm_radius = "90 mm", count = 4 }]'
    )
    braked = pendulum.replace("count = 4", 'count = 4, damping = "0.4 N*m*s/rad"')
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    attached = replaced(ENGINE, (ring, pendulum))
    text = at_speed(attached, speed)
    critical = value(text, "critical/speed")
    natural = value(at_speed(attached, float(critical[2, 7])), "modes/natural_frequency")
    assert natural[2] == pytest.approx(4.0 * critical[2, 7], rel=1e-9)
    if speed == 95.0:  # a pole that follows the speed meets the order in its magnitude
        damped = replaced(ENGINE, (ring, braked))
        met = value(at_speed(damped, speed), "critical/speed")[2, 7]
        there = value(at_speed(damped, float(met)), "modes/natural_frequency")
        assert there[2] == pytest.approx(4.0 * met, rel=1e-12)
        assert met == pytest.approx(critical[2, 7], rel=0.01) and met != critical[2, 7]
    angle = np.abs(value(text, "angle"))
    assert angle[0, 2] < 1e-9 * angle[1, 2]
    assert angle[0, 3] > 1e-3 * angle[1, 3]


def undamped() -> str:
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    return replaced(ENGINE, (ring, ""), (', damping = "5 N*m*s/rad"', ""))


def test_an_undamped_critical_is_listed_in_a_range_and_refused_at_the_operating_speed() -> None:
    natural = value(undamped(), "modes/natural_frequency")
    critical = natural[1] / 6.0
    ends = f"speeds = {{ from = {float(critical) - 1.0!r}, to = {float(critical) + 9.3!r} }}"
    text = replaced(undamped(), (POINTS, ends))
    met = value(text, "masked/from"), value(text, "masked/to")
    assert met[0][0] < critical < met[1][0] and met[1][0] - met[0][0] < 1e-6
    assert value(text, "masked/mode")[0] == 2 and value(text, "masked/half_order")[0] == 6.0
    assert np.all(np.isinf(value(text, "largest/torque_half_range")))
    assert np.all(np.isfinite(value(text, "speeds/torque_half_range")))
    with pytest.raises(NumericalFailure, match=r"order 6 at .* frequency of mode 2"):
        record(at_speed(undamped(), critical))


def test_a_cylinder_that_misfires_has_no_gas_or_that_of_a_driven_one() -> None:
    healthy = replaced(ENGINE, (POINTS, ""))
    silent = healthy + 'misfire = ["2"]'
    driven = silent + '\nmisfire_kind = "motored"'
    own = [value(text, "excitation/station_torque")[1] for text in (silent, driven)]
    inertia = value(healthy, "excitation/inertia")
    firing = value(healthy, "excitation/firing_angle")[1]
    turned = inertia * np.exp(-1j * ORDER * firing)
    assert own[0] == pytest.approx(turned, abs=1e-9 * np.abs(inertia).max())
    assert np.abs(own[1] - turned).max() > 1.0
    mean = [float(value(t, "excitation/mean_torque")) for t in (healthy, silent, driven)]
    assert mean[1] == pytest.approx(mean[0] * 2.0 / 3.0, rel=1e-12)
    # the lowest order is balanced in a healthy engine
    whole, two = (np.abs(value(t, "excitation/vector_sum"))[0, 0] for t in (healthy, silent))
    assert whole < 1e-12 and two < 1e-12  # of equal cylinders; the torques tell
    assert np.abs(value(silent, "excitation/intensity")[0, 0]) > 10.0


def limits(stress: str) -> str:
    curve = f'{{ speed = ["700 rpm", "6100 rpm"], stress = ["{stress}", "{stress}"] }}'
    return ENGINE + f"limits = [{{ curve = {curve} }}]"


def test_a_barred_range_ends_where_the_stress_is_what_is_allowed() -> None:
    top = float(value(ENGINE, "largest/stress_half_range")[0])
    text = limits(f"{0.9 * top!r} Pa")
    assert value(text, "limit/largest_use")[0] == pytest.approx(1.0 / 0.9, rel=1e-9)
    ends = [*value(text, "exceeded/from"), *value(text, "exceeded/to")]
    assert ends
    inner = [end for end in ends if SPEED * 800 / 1500 < end * (1 - 1e-9) < SPEED * 5999 / 1500]
    for end in inner[:1]:
        at = at_speed(text, end)
        assert value(at, "stress_half_range")[0] == pytest.approx(0.9 * top, rel=1e-9)
        assert value(at, "limit/operating_use")[0] == pytest.approx(1.0, rel=1e-9)
    assert len(value(limits(f"{1.1 * top!r} Pa"), "exceeded/from")) == 0


def test_a_class_rule_is_that_of_the_rated_speed() -> None:
    text = ENGINE + 'limits = [{ rule = "iacs_m68", tensile_strength = "500 MPa" }]'
    speed = record(text)[f"{ROOT}/limit/allowed"].axes[1].values
    ratio = speed / SPEED
    course = np.where(ratio < 0.9, 3.0 - 2.0 * ratio**2, 1.38)
    tau = (500.0 + 160.0) / 18.0 * (0.35 + 0.93 * 70.0**-0.2) * course * 1e6
    got = value(text, "limit/allowed")[0]
    inside = ratio <= 1.05
    assert got[inside] == pytest.approx(tau[inside], rel=1e-12)
    assert np.all(np.isinf(got[~inside]))


def test_blocks_of_speeds_do_not_matter(monkeypatch: Any) -> None:
    from vibecalc.torsion.adapters import curves

    plain = value(ENGINE, "speeds/torque_half_range")
    monkeypatch.setattr(curves, "ROWS", 7)
    again = run_case(validate(tomllib.loads(ENGINE)))
    found = again[f"{ROOT}/speeds/torque_half_range"].values
    assert np.abs(found - plain).max() < 1e-12 * plain.max()
