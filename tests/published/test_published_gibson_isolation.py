"""Every isolation number of Gibson (2008): right ones come out; slips applied give the others.

The slips are applied here, in a few lines, to vibecalc's own building blocks.
"""

import numpy as np
import pytest
from isolation_machines import (
    COUPLE,
    INERTIA,
    LEVER,
    ORDERS,
    RADIUS_TO_ROD,
    SPEED,
    gibson,
    gibson_couple,
    gibson_supports,
    pitch_of,
    rows_of,
)

from vibecalc.isolation.adapters.pitch import transmissibility
from vibecalc.isolation.at_mounts import AtMounts, deflected, weight_load
from vibecalc.isolation.run_up import Range, run_up
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.linear import response


def test_natural_frequency_and_damping_ratio() -> None:
    pitch, _ = gibson()
    assert round(float(pitch.shapes.natural_frequency[0]), 2) == 31.74
    assert round(float(pitch.damping_ratio().value[0]), 3) == 0.079


def test_text_stiffness_of_2500_each_gives_half_the_printed_frequency() -> None:
    x, k, c, h = gibson_supports()
    overall = pitch_of(INERTIA, x, k / 4.0, c, h)
    assert float(overall.shapes.natural_frequency[0]) == pytest.approx(31.7366 / 2.0, abs=5e-5)


def test_forces_over_the_lever_with_the_body_held_still() -> None:
    force = gibson_couple().value * SPEED**2 / LEVER
    assert np.abs(force) == pytest.approx([8209.0, 2463.0], abs=0.5)
    assert float(cycle_peak(force, ORDERS).value) == pytest.approx(9329.0, abs=0.5)


def steady_peak() -> float:
    pitch, _ = gibson()
    passing = transmissibility(pitch.matrices, ORDERS * SPEED).value
    return float(cycle_peak(passing * gibson_couple().value * SPEED**2 / LEVER, ORDERS).value)


def test_steady_peak_with_phase_is_98_newtons() -> None:
    assert round(steady_peak(), 1) == 98.0


def test_93_newtons() -> None:
    """Two slips: second-order transmissibility at sqrt(2) times the speed, phases dropped."""
    pitch, _ = gibson()
    ratio = np.abs(transmissibility(pitch.matrices, np.array([1.0, np.sqrt(2.0)]) * SPEED).value)
    slipped = ratio * gibson_couple().value * SPEED**2 / LEVER
    instants = np.exp(1j * np.outer(ORDERS, 2.0 * np.pi * np.arange(201) / 200.0))
    assert round(float(np.max((slipped @ instants).real)), 3) == 92.988


def test_174_newtons() -> None:
    """Script 2 takes each speed W at the instant t = 2 W / w, with both slips of script 1."""
    pitch, _ = gibson()
    speed = SPEED * np.arange(10001) / 10000.0
    factor = np.array([1.0, np.sqrt(2.0)])
    ratio = np.abs(transmissibility(pitch.matrices, speed[:, None] * factor).value)
    instant = 2.0 * speed / SPEED
    wave = np.sin(speed[:, None] * ORDERS * instant[:, None]) * np.array([1.0, -RADIUS_TO_ROD])
    force = np.sum(ratio * wave, axis=1) * COUPLE * speed**2 / LEVER
    top = int(np.argmax(np.abs(force)))
    assert round(float(np.abs(force[top])), 3) == 174.152
    assert round(float(speed[top]), 3) == 32.943


def test_run_up_maximum_over_the_cycle_is_202_newtons() -> None:
    pitch, readout = gibson()
    couple = gibson_couple()
    rows, met = rows_of(pitch, readout, ORDERS, couple), pitch.resonances(couple[:, None])
    passed = run_up(Range(rows, ORDERS, met, 0.0, SPEED, np.ones((1, 5), dtype=bool)))
    assert round(float(passed.peak.value[0]), 1) == 202.1
    assert float(passed.peak.speed[0]) == pytest.approx(32.02, abs=5e-3)
    # four equal supports share the couple, so that one carries a quarter of the lever force
    assert passed.peak.value[1:] == pytest.approx(np.full(4, passed.peak.value[0] / 4.0))


def test_21_ten_thousandths() -> None:
    """Script 1 puts L * (M / L) into x_0: the lever cancels, what is left is a sum of angles."""
    pitch, _ = gibson()
    couple = gibson_couple()[:, None] * SPEED**2
    dynamic = pitch.dynamics(ORDERS * SPEED, pitch.resonances(couple))
    angle = response(dynamic, couple.value, couple.error).value[:, 0]
    added = float(np.sum(np.abs(angle)))
    assert round(added, 8) == 0.00211739
    # the motion of a support is the lever times as large, and with its phase smaller still
    assert LEVER * added == pytest.approx(0.000847, abs=5e-7)
    assert LEVER * float(cycle_peak(angle, ORDERS).value) == pytest.approx(7.974e-4, abs=5e-8)


def at_rest(quarter: float) -> AtMounts:
    """Deflections under the weight, of mounts with this share of the stiffness."""
    x, k, c, h = gibson_supports()
    load = weight_load(100.0, np.zeros(3), 9.81, np.array([0.0, 0.0, 1.0]))
    return deflected(pitch_of(INERTIA, x, quarter * k, c, h).resting, load)


def test_static_sag_of_the_two_readings_of_the_stiffness() -> None:
    each = at_rest(1.0)
    assert -each.displacement.value[:, 0] == pytest.approx(np.full(4, 0.0245), abs=5e-5)
    assert -each.force.value[:, 0] == pytest.approx(np.full(4, 981.0 / 4.0), rel=1e-14)
    overall = at_rest(0.25)
    assert -overall.displacement.value[:, 0] == pytest.approx(np.full(4, 0.098), abs=5e-4)
