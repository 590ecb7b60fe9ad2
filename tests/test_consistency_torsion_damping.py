"""Claim: heat and sentences of a shaft line stay true at the edges of what is damped.

The truth: the power of the torques, the same line with more orders.
"""

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, ROOT, record, replaced, value
from long_but import long_but

from vibecalc.errors import NumericalFailure

ENGINE = replaced(ENGINE, ('speeds = { from = "800 rpm", to = "2000 rpm" }', ""))
BRAKED = replaced(
    ENGINE, ('inertia = "2 kg*m^2"', 'inertia = "2 kg*m^2", absolute_damping = "1 N*m*s/rad"')
)
LOSSY = replaced(
    ENGINE, ('{ stiffness = "1e6 N*m/rad" }', '{ stiffness = "1e6 N*m/rad", loss_factor = 0.01 }')
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
    speed = 1500.0 if text.startswith(ENGINE[:40]) else 600.0
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
    ring = next(line for line in ENGINE.splitlines() if line.startswith("dampers"))
    slow = replaced(ENGINE, (ring, ""), ('"1500 rpm"', "1e-4"))
    with pytest.raises(NumericalFailure, match=r"turns as one rigid body \(mode 1"):
        record(slow)


def test_each_mode_has_its_own_error() -> None:
    own = value(ENGINE, "modes/frequency_error")
    assert own.max() == record(ENGINE)[f"{ROOT}/modes/natural_frequency"].error_estimate
    natural = value(ENGINE, "modes/natural_frequency")
    assert np.all(own[natural == 0.0] == 0.0) and np.all(own <= 1e-13 * natural)
