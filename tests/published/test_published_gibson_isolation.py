"""Every isolation number of Gibson (2008): right ones come out; slips applied give the others.

The slips are applied here, in a few lines, to vibecalc's own building blocks.
"""

import numpy as np
import pytest
from isolation_machines import COUPLE, LEVER, ORDERS, RADIUS_TO_ROD, SPEED, gibson, gibson_couple

from vibecalc.isolation.adapters.pitch import transmissibility
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.linear import response


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
