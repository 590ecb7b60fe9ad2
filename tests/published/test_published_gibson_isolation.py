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
)

from vibecalc.isolation.pitch import (
    angle_harmonics,
    pitch_model,
    pitch_resonances,
    pitch_static,
    transmissibility,
)
from vibecalc.isolation.rows import pitch_rows
from vibecalc.isolation.run_up import run_up
from vibecalc.numerics.cycle_peak import cycle_peak


def test_natural_frequency_and_damping_ratio() -> None:
    pitch, _ = gibson()
    assert round(float(pitch.natural_frequency), 2) == 31.74
    assert round(float(pitch.damping_ratio), 3) == 0.079


def test_text_stiffness_of_2500_each_gives_half_the_printed_frequency() -> None:
    x, k, c, h = gibson_supports()
    overall = pitch_model(INERTIA, x, k / 4.0, c, h)
    assert float(overall.natural_frequency) == pytest.approx(31.7366 / 2.0, abs=5e-5)


def test_forces_over_the_lever_with_the_body_held_still() -> None:
    force = gibson_couple().value * SPEED**2 / LEVER
    assert np.abs(force) == pytest.approx([8209.0, 2463.0], abs=0.5)
    assert float(cycle_peak(force, ORDERS).value) == pytest.approx(9329.0, abs=0.5)


def steady_peak() -> float:
    pitch, _ = gibson()
    passing = transmissibility(pitch, ORDERS * SPEED).value
    return float(cycle_peak(passing * gibson_couple().value * SPEED**2 / LEVER, ORDERS).value)


def test_steady_peak_with_phase_is_98_newtons() -> None:
    assert round(steady_peak(), 1) == 98.0


def test_93_newtons() -> None:
    """Two slips: second-order transmissibility at sqrt(2) times the speed, phases dropped."""
    pitch, _ = gibson()
    ratio = np.abs(transmissibility(pitch, np.array([1.0, np.sqrt(2.0)]) * SPEED).value)
    slipped = ratio * gibson_couple().value * SPEED**2 / LEVER
    instants = np.exp(1j * np.outer(ORDERS, 2.0 * np.pi * np.arange(201) / 200.0))
    assert round(float(np.max((slipped @ instants).real)), 3) == 92.988


def test_174_newtons() -> None:
    """Script 2 takes each speed W at the instant t = 2 W / w, with both slips of script 1."""
    pitch, _ = gibson()
    speed = SPEED * np.arange(10001) / 10000.0
    factor = np.array([1.0, np.sqrt(2.0)])
    ratio = np.abs(transmissibility(pitch, speed[:, None] * factor).value)
    instant = 2.0 * speed / SPEED
    wave = np.sin(speed[:, None] * ORDERS * instant[:, None]) * np.array([1.0, -RADIUS_TO_ROD])
    force = np.sum(ratio * wave, axis=1) * COUPLE * speed**2 / LEVER
    top = int(np.argmax(np.abs(force)))
    assert round(float(np.abs(force[top])), 3) == 174.152
    assert round(float(speed[top]), 3) == 32.943


def test_run_up_maximum_over_the_cycle_is_202_newtons() -> None:
    pitch, readout = gibson()
    couple = gibson_couple()
    passed = run_up(
        pitch_rows(pitch, readout, ORDERS, couple), ORDERS, pitch_resonances(pitch, couple),
        0.0, SPEED, np.ones((1, 5), dtype=bool),
    )  # fmt: skip
    assert round(float(passed.peak.value[0]), 1) == 202.1
    assert float(passed.peak.speed[0]) == pytest.approx(32.02, abs=5e-3)
    # four equal supports share the couple, so that one carries a quarter of the lever force
    assert passed.peak.value[1:] == pytest.approx(np.full(4, passed.peak.value[0] / 4.0))


def test_21_ten_thousandths() -> None:
    """Script 1 puts L * (M / L) into x_0: the lever cancels, what is left is a sum of angles."""
    pitch, _ = gibson()
    couple = gibson_couple()
    angle = angle_harmonics(pitch, couple * SPEED**2, ORDERS * SPEED)
    added = float(np.sum(np.abs(angle.value)))
    assert round(added, 8) == 0.00211739
    # the motion of a support is the lever times as large, and with its phase smaller still
    assert LEVER * added == pytest.approx(0.000847, abs=5e-7)
    assert LEVER * float(cycle_peak(angle.value, ORDERS).value) == pytest.approx(7.974e-4, abs=5e-8)


def test_static_sag_of_the_two_readings_of_the_stiffness() -> None:
    x, k, _, _ = gibson_supports()
    each = pitch_static(100.0 * 9.81, 0.0, x, k)
    assert each.sag == pytest.approx(np.full(4, 0.0245), abs=5e-5)
    assert each.share == pytest.approx(np.full(4, 981.0 / 4.0), rel=1e-14)
    overall = pitch_static(100.0 * 9.81, 0.0, x, k / 4.0)
    assert overall.sag == pytest.approx(np.full(4, 0.098), abs=5e-4)
