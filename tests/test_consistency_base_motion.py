"""Claim: a machine on a base that moves does not move without end.

How it moves `test_consistency_random_machines.py` holds against dense solves and quadrature.
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


def test_no_steady_motion_is_refused() -> None:
    table = block(harmonics=[{"name": "a", "frequency": 2.0 * np.pi * FREQUENCY,
                              "displacement": [0.0, 0.0, 1e-3]}])  # fmt: skip
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    with pytest.raises(NumericalFailure, match=r"undamped|singular"):
        run_case(validate(table))
    table["base_motion"] = {"spectra": [spectrum("z", 5.0, 20.0, 1.0)]}
    with pytest.raises(NumericalFailure, match=r"mode 3 .* has no damping"):
        run_case(validate(table))
