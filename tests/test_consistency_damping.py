"""Claim: damping that does not follow the stiffness is seen for what it is.

A strong damper in one place makes the body swing about it, at frequencies that no undamped mode
has; a damper along one direction leaves the direction across it undamped, also where both have one
frequency, or nearly so. Neither hides a resonance nor makes one up.
"""

import math
from typing import Any

import numpy as np
import pytest
from random_machines import Table

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure

STIFFNESS, MASS, DAMPING = 1e5, 100.0, 50.0
RESONANCE = math.sqrt(4.0 * STIFFNESS / MASS)
PEAK = "isolation/support_force/run_up_peak"
SPEED = "isolation/support_force/run_up_peak_speed"


def square_machine(speed: float, bank: float) -> Table:
    """One cylinder in the plane of four mounts that are equally stiff in all directions of it."""
    corners = [(0.4, 0.4), (-0.4, 0.4), (0.4, -0.4), (-0.4, -0.4)]
    return {
        "schema": 1,
        "title": "a machine that moves along x and y at one frequency",
        "machine": {
            "kind": "machine",
            "speed": speed,
            "crank_train": {
                "axis": "z",
                "stroke_axis": "x",
                "crank_radius": 0.05,
                "rod_length": 0.2,
                "reciprocating_mass": 1.0,
                "cylinders": [{"name": "1", "bank_angle": bank}],
            },
            "body": {"mass": MASS, "box": {"length": 1.0, "width": 1.0, "height": 0.5}},
            "mounts": {
                "each": {"stiffness": STIFFNESS},
                "individual": [
                    {"name": str(n), "position": [x, y, 0.0]} for n, (x, y) in enumerate(corners)
                ],
            },
        },
        "excitation": {"orders": 2, "driven_machine": "cancels_torque"},
        "isolation": {"model": "rigid_body", "run_up": {"from": 1.0, "to": 100.0}},
    }


def with_diagonal_dampers(case: Table) -> Table:
    """Viscous damping along (1, 1, 0) only."""
    for mount in case["machine"]["mounts"]["individual"]:
        mount["damping"] = [DAMPING, 0.0, 0.0]
        mount["orientation"] = [0.0, 0.0, 0.25 * math.pi]
    return case


def run(case: Table, **keys: Any) -> Any:
    return run_case(validate(case), **keys)


def test_repeated_modes_are_reported_apart_by_their_damping() -> None:
    record = run(with_diagonal_dampers(square_machine(1.3 * RESONANCE, 0.25 * math.pi)))
    ratio = record["isolation/modes/damping_ratio"]
    frequency = record["isolation/modes/natural_frequency"].values
    repeated = np.sort(ratio.values[np.isclose(frequency, RESONANCE, rtol=1e-9)])
    full = 4.0 * DAMPING / (2.0 * RESONANCE * MASS)
    assert repeated == pytest.approx([0.0, 0.0, full], abs=1e-14)


def test_driven_along_the_dampers_the_resonance_is_damped() -> None:
    """At the resonance spring and inertia cancel: X = F / (i w C), and each mount has a quarter."""
    record = run(with_diagonal_dampers(square_machine(RESONANCE, 0.25 * math.pi)))
    force = np.linalg.norm(record["excitation/force"].values[0])
    rate = RESONANCE * DAMPING
    expected = force * math.hypot(STIFFNESS, rate) / (4.0 * rate)
    harmonics = record["isolation/support_force/steady_harmonics"].values[:, :, 0]
    assert np.linalg.norm(harmonics, axis=1) == pytest.approx(np.full(4, expected), rel=1e-9)
    assert np.isfinite(record[PEAK].values).all()
    assert record[SPEED].values == pytest.approx(np.full(4, RESONANCE), rel=1e-3)


def test_driven_across_the_dampers_it_has_no_bound() -> None:
    with pytest.raises(NumericalFailure, match="on the undamped natural frequency of mode"):
        run(with_diagonal_dampers(square_machine(RESONANCE, 0.75 * math.pi)))
    record = run(with_diagonal_dampers(square_machine(1.3 * RESONANCE, 0.75 * math.pi)))
    assert np.isinf(record[PEAK].values).all()
    assert np.isin([1, 2], record["isolation/resonances_skipped/order"].values).all()


@pytest.mark.parametrize("apart", [1e-13, 1e-11, 1e-9])
def test_nearly_coinciding_modes_damped_in_one_direction(apart: float) -> None:
    """x and y differ a little; between them stands a resonance that the damper does not reach."""

    def nearly(speed: float) -> Table:
        case = square_machine(speed, 0.75 * math.pi)
        mounts = case["machine"]["mounts"]
        mounts["each"]["stiffness"] = [STIFFNESS, STIFFNESS * (1.0 + apart), STIFFNESS]
        damper = {"name": "damper", "position": [0.0, 0.0, 0.0], "stiffness": 0.0}
        damper |= {"damping": [200.0, 0.0, 0.0], "orientation": [0.0, 0.0, 0.25 * math.pi]}
        mounts["individual"].append(damper)
        return case

    with pytest.raises(NumericalFailure, match="undamped"):
        run(nearly(RESONANCE * (1.0 + 0.25 * apart)))
    peak = run(nearly(1.3 * RESONANCE), wanted=frozenset({PEAK}))[PEAK].values
    assert np.isinf(peak[:4]).all()
