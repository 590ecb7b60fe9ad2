"""Claim: a run of a shaft line says what its matrices, built by hand here, say of it.

The truth: dense solves of matrices in own speeds, torques of a cylinder by a fine sum over its
cycle, balances of power and of torque, and the same line asked in another way.
"""

import numpy as np
import pytest
from engine_cases import ENGINE, ROOT, at_speed, record, replaced, value

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure

POINTS = "speeds = { from = '800 rpm', to = '6000 rpm', points = 21 }"
ENGINE = replaced(ENGINE, ('speeds = { from = "800 rpm", to = "2000 rpm" }', POINTS))
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
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    attached = replaced(ENGINE, (ring, pendulum))
    text = at_speed(attached, speed)
    critical = value(text, "critical/speed")
    natural = value(at_speed(attached, float(critical[2, 7])), "modes/natural_frequency")
    assert natural[2] == pytest.approx(4.0 * critical[2, 7], rel=1e-9)
    if speed == 95.0:  # light damping moves no natural frequency, heavy damping locks the pendulums
        for damping, share in ((0.4, 0.0), (40.0, 0.05)):
            damped = replaced(ENGINE, (ring, braked.format(damping)))
            met = value(at_speed(damped, speed), "critical/speed")[2, 7]
            there = value(at_speed(damped, float(met)), "modes/natural_frequency")
            assert there[2] == pytest.approx(4.0 * met, rel=1e-12)
            assert 0.5 * share <= 1.0 - met / critical[2, 7] <= share
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
