"""Claim: a run of a shaft line says what its matrices, built by hand, say of it, what resonates
over the speeds and how far its modes are; its heat stays true at the edges of what is damped.

The truth: dense solves of matrices in own speeds, torques of a cylinder by a fine sum over its
cycle, balances of power and of torque, the same line run at single speeds, order by order, and
distances by the rule, which `test_property_shaft_limits.py` holds by hand.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, ROOT, at_speed, record, replaced, value
from long_but import long_but

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.torsion.stress_limits import separation

RANGE = 'speeds = { from = "800 rpm", to = "2000 rpm" }'
POINTS = "speeds = { from = '800 rpm', to = '6000 rpm', points = 21 }"
SWEPT = replaced(ENGINE, (RANGE, POINTS))
ORDER = np.arange(1, 13) / 2.0


@pytest.mark.parametrize("speed", [180.0, pytest.param(95.0, marks=pytest.mark.long)])
def test_pendulums_hold_their_station_still_at_any_speed(speed: float) -> None:
    pendulum = (
        'dampers = [{ name = "ring", on = "a", kind = "pendulum", order = 1.5, mass = "0.6 kg", '
        'arm_radius = "90 mm", count = 4 }]'
    )
    braked = pendulum.replace("{", "{{").replace(
        "count = 4 }", 'count = 4, damping = "{} N*m*s/rad" }}'
    )
    ring = next(line for line in SWEPT.splitlines() if line.startswith("dampers"))
    attached = replaced(SWEPT, (ring, pendulum))
    text = at_speed(attached, speed)
    critical = value(text, "critical/speed")
    natural = value(at_speed(attached, float(critical[2, 7])), "modes/natural_frequency")
    assert natural[2] == pytest.approx(4.0 * critical[2, 7], rel=1e-9)
    if speed == 95.0:  # light damping moves no natural frequency, heavy damping locks the pendulums
        for damping, share in ((0.4, 0.0), (40.0, 0.05)):
            damped = replaced(SWEPT, (ring, braked.format(damping)))
            met = value(at_speed(damped, speed), "critical/speed")[2, 7]
            there = value(at_speed(damped, float(met)), "modes/natural_frequency")
            assert there[2] == pytest.approx(4.0 * met, rel=1e-12)
            assert 0.5 * share <= 1.0 - met / critical[2, 7] <= share
    angle = np.abs(value(text, "angle"))
    assert angle[0, 2] < 1e-9 * angle[1, 2]
    assert angle[0, 3] > 1e-3 * angle[1, 3]


def undamped() -> str:
    ring = next(line for line in SWEPT.splitlines() if line.startswith("dampers"))
    return replaced(SWEPT, (ring, ""), (', damping = "5 N*m*s/rad"', ""))


def test_an_undamped_critical_is_listed_in_a_range_and_refused_at_the_operating_speed() -> None:
    natural = value(undamped(), "modes/natural_frequency")
    critical = natural[1] / 6.0
    ends = f"speeds = {{ from = {float(critical) - 1.0!r}, to = {float(critical) + 9.3!r} }}"
    text = replaced(undamped(), (POINTS, ends))
    met = value(text, "resonances_skipped/from"), value(text, "resonances_skipped/to")
    assert met[0][0] < critical < met[1][0] and met[1][0] - met[0][0] < 1e-6
    assert (
        value(text, "resonances_skipped/mode")[0] == 2
        and value(text, "resonances_skipped/order")[0] == 6.0
    )
    assert np.all(np.isinf(value(text, "largest/torque_half_range")))
    assert np.all(np.isfinite(value(text, "speeds/torque_half_range")))
    with pytest.raises(NumericalFailure, match=r"order 6 at .* frequency of mode 2"):
        record(at_speed(undamped(), float(critical)))


def test_a_cylinder_that_misfires_has_no_gas_or_that_of_a_driven_one() -> None:
    healthy = replaced(SWEPT, (POINTS, ""))
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


def test_pendulums_show_their_own_swing_and_say_where_it_is_not_small() -> None:
    """Lagrange's equations of two rotors and pendulums on arms, small swings s, dense.

    A mass at R + r from the axis turns about it by theta + s r / (R + r), where damping acts.
    """
    speed, order, arm, mass, count, damping, torque = 100.0, 2.0, 0.08, 0.5, 3, 0.05, 400.0
    pendulums = {
        "name": "hung", "on": "b", "kind": "pendulum", "order": 1.9, "mass": mass, "count": count,
        "arm_radius": arm, "damping": damping,
    }  # fmt: skip
    line = {
        "stations": [{"name": "a", "inertia": 0.3}, {"name": "b", "inertia": 0.8}],
        "shafts": [{"name": "ab", "stiffness": 5e4, "loss_factor": 0.01}],
        "dampers": [pendulums],
        "excitations": [{"name": "push", "on": "a", "orders": [2], "torques": [torque]}],
        "balanced_by": "b",
    }
    case = {
        "schema": 1, "title": "pendulums on a shaft line",
        "machine": {"kind": "drive_train", "speed": speed, "shaft_line": line},
        "response": {"torsion": {}},
    }  # fmt: skip
    made = run_case(validate(case))
    short = arm / 1.9**2
    hung, whole = count * mass, arm + short
    inertia = np.array(
        [[0.3, 0.0, 0.0],
         [0.0, 0.8 + hung * whole**2, hung * whole * short],
         [0.0, hung * whole * short, hung * short**2]]
    )  # fmt: skip
    stiff = np.zeros((3, 3), dtype=complex)
    stiff[:2, :2] = 5e4 * (1.0 + 0.01j) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    w = order * speed
    stiff[2, 2] = hung * arm * short * speed**2 + 1j * w * damping * (short / whole) ** 2
    swing = abs(np.linalg.solve(stiff - w**2 * inertia, [torque, 0.0, 0.0])[2])
    assert swing > 0.2
    found = made[f"{ROOT}/damper/travel"].values
    assert found == pytest.approx([swing], rel=1e-9)
    (said,) = [one for one in made.warnings if "pendulums swing by" in one]
    assert f"{np.degrees(swing):.4g} degrees" in said


# ----------------------------------------------------------------------------
# Heat and sentences at the edges of what is damped.
# ----------------------------------------------------------------------------

STILL = replaced(ENGINE, (RANGE, ""))
BRAKED = replaced(
    STILL, ('inertia = "2 kg*m^2"', 'inertia = "2 kg*m^2", absolute_damping = "1 N*m*s/rad"')
)
LOSSY = replaced(
    STILL, ('{ stiffness = "1e6 N*m/rad" }', '{ stiffness = "1e6 N*m/rad", loss_factor = 0.01 }')
)
RAYLEIGH = 'damping_model = { kind = "rayleigh", modes = [3, 4], ratios = [0.01, 0.02] }'
MODAL = 'damping_model = { kind = "modal", ratios = [0.02] }'
OF_GEARED = RAYLEIGH.replace("3, 4", "2, 4")


@pytest.mark.parametrize(
    "text",
    long_but(
        [BRAKED, LOSSY, BRAKED + RAYLEIGH, BRAKED + MODAL, GEARED + OF_GEARED],
        LOSSY,
        BRAKED + MODAL,
        GEARED + OF_GEARED,
    ),
    ids=["dashpots", "loss", "rayleigh", "modal", "rayleigh_geared"],
)
def test_all_heat_is_the_power_of_the_torques(text: str) -> None:
    found = record(text)
    speed = 1500.0 if text.startswith(STILL[:40]) else 600.0
    load, angle = value(text, "excitation/station_torque"), value(text, "angle")
    order = found[f"{ROOT}/angle"].axes[1].values
    power = 0.5 * speed * np.pi / 30.0 * np.sum(order * np.imag(load * np.conj(angle)))
    names = [f"{ROOT}/{n}" for n in ("section_heat", "station_heat", "modal_heat")]
    heat = sum(float(np.sum(found[name].values)) for name in names if name in found)
    assert heat == pytest.approx(power, rel=1e-9) and power > 0.0


def test_ratios_by_mode_leave_nothing_of_the_dashpots() -> None:
    clean = BRAKED
    for damping in (', damping = "5 N*m*s/rad"', ', absolute_damping = "1 N*m*s/rad"'):
        clean = replaced(clean, (damping, ""))
    for path in ("torque", "torque_half_range", "section_heat", "station_heat"):
        assert np.array_equal(value(BRAKED + MODAL, path), value(clean + MODAL, path)), path
    assert not np.any(value(BRAKED + MODAL, "section_heat"))


def test_too_slow_is_not_called_a_resonance() -> None:
    ring = next(line for line in STILL.splitlines() if line.startswith("dampers"))
    slow = replaced(STILL, (ring, ""), ('"1500 rpm"', "1e-4"))
    with pytest.raises(NumericalFailure, match=r"turns as one rigid body \(mode 1"):
        record(slow)


def test_each_mode_has_its_own_error() -> None:
    own = value(STILL, "modes/frequency_error")
    assert own.max() == record(STILL)[f"{ROOT}/modes/natural_frequency"].error_estimate
    natural = value(STILL, "modes/natural_frequency")
    assert np.all(own[natural == 0.0] == 0.0) and np.all(own <= 1e-13 * natural)


# ----------------------------------------------------------------------------
# Over the speeds.
# ----------------------------------------------------------------------------

RPM = np.pi / 30.0
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
