"""Claim: one freedom on a base that moves does what closed forms say, and none moves without end.

All six `test_consistency_random_machines.py` holds against dense solves and quadrature.
"""

from typing import Any

import numpy as np
import pytest

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure

MASS, FREQUENCY, RATIO = 120.0, 9.0, 0.03


def block(**base_motion: Any) -> dict[str, Any]:
    """A plain block on four springs at the height of its centre: its freedoms are apart."""
    w = 2.0 * np.pi * FREQUENCY
    k, c = MASS * w**2 / 4.0, 2.0 * RATIO * w * MASS / 4.0
    places = [[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    return {
        "schema": 1, "title": "block",
        "machine": {
            "kind": "plate",
            "body": {"mass": MASS, "inertia": [8.0, 9.0, 12.0]},
            "mounts": {"each": {"stiffness": k, "damping": c}, "positions": places},
        },
        "base_motion": base_motion,
    }  # fmt: skip


def spectrum(direction: str, low: float, high: float, value: float) -> dict[str, Any]:
    """White between two frequencies in Hz."""
    ends = [2.0 * np.pi * low, 2.0 * np.pi * high]
    return {"direction": direction, "acceleration": {"frequency": ends, "density": [value] * 2}}


def test_one_freedom_is_the_closed_form_and_miles() -> None:
    level = 0.02
    record = run_case(validate(block(spectra=[spectrum("z", 0.01, 2.0e4, level)])))
    r = record["base_motion/transmissibility"].axes[1].values / FREQUENCY
    drag, away = (2.0 * RATIO * r) ** 2, (1.0 - r**2) ** 2
    found = record["base_motion/transmissibility"].values[2]
    assert found == pytest.approx(np.sqrt((1.0 + drag) / (away + drag)), rel=1e-11)
    relative = record["base_motion/relative_transmissibility"].values[2]
    # against the base from the difference with it, which at low frequency is one of equal numbers
    assert relative == pytest.approx(r**2 / np.sqrt(away + drag), rel=1e-11, abs=1e-13)
    w = 2.0 * np.pi * FREQUENCY
    rms = record["base_motion/spectrum/relative_translation_rms"].values[2]
    # white at all frequencies: what is above 2000 times the resonance and below a thousandth of it
    missing = level * (0.01 + 1.0e-15) / w**4
    assert rms**2 + missing == pytest.approx(level / (8.0 * RATIO * w**3), rel=1e-9)
    accel = record["base_motion/spectrum/acceleration_rms"].values[2]
    tail = level * (2.0 * RATIO * FREQUENCY) ** 2 / 2.0e4
    exact = np.pi * FREQUENCY * level * (1.0 + 4.0 * RATIO**2) / (4.0 * RATIO)
    assert accel**2 + tail + 0.01 * level == pytest.approx(exact, rel=1e-7)
    miles = np.sqrt(0.5 * np.pi * FREQUENCY * level / (2.0 * RATIO))
    assert accel == pytest.approx(miles, rel=5e-3)
    peak = record["base_motion/spectrum/acceleration_peak"].values[2]
    assert peak == pytest.approx(3.0 * accel, rel=1e-15)
    assert record["base_motion/spectrum/base_acceleration_rms"].values[2] == pytest.approx(
        np.sqrt(level * (2.0e4 - 0.01)), rel=1e-12
    )
    assert record["base_motion/spectrum/acceleration_rms"].values[0] == pytest.approx(0.0, abs=1e-9)


def test_no_steady_motion_is_refused() -> None:
    table = block(harmonics=[{"name": "a", "frequency": 2.0 * np.pi * FREQUENCY,
                              "displacement": [0.0, 0.0, 1e-3]}])  # fmt: skip
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    with pytest.raises(NumericalFailure, match=r"undamped|singular"):
        run_case(validate(table))
    table["base_motion"] = {"spectra": [spectrum("z", 5.0, 20.0, 1.0)]}
    with pytest.raises(NumericalFailure, match=r"mode 3 .* has no damping"):
        run_case(validate(table))
