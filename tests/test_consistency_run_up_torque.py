"""A run-up under the torques of a shaft line against plain runs at single speeds inside it.

Gas and rotors without a line are in `test_consistency_random_machines.py`.
"""

import numpy as np
import pytest
from engine_cases import replaced
from engine_mounted import COUNTER, ON_BODY, mounted
from long_but import long_but

from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

RUN_UP = ('model = "rigid_body"\n', 'model = "rigid_body"\nrun_up = { from = 40.0, to = 180.0 }\n')
CURVE = "isolation/support_force/run_up"
PEAK = "isolation/support_force/steady_peak"
TEXTS = {
    "damped line on the body": replaced(ON_BODY, ("orders = 12", "orders = 4"), RUN_UP),
    "geared line, no momentum": replaced(COUNTER, RUN_UP),
}


def at_speed(case: Case, speed: float) -> Case:
    return case.model_copy(
        update={
            "machine": case.machine.model_copy(update={"speed": speed}),
            "isolation": case.isolation.model_copy(update={"run_up": None}),
        }
    )


@pytest.mark.parametrize("name", long_but(TEXTS, "geared line, no momentum"))
def test_plain_runs_at_speeds_of_the_run_up_agree(name: str) -> None:
    case = mounted(TEXTS[name])
    record = run_case(case)
    curve, top = record[CURVE], record[f"{CURVE}_peak"]
    where = record[f"{CURVE}_peak_speed"]
    speeds = curve.axes[1].values
    forces = np.asarray(curve.values)
    assert forces.max() > 0.0
    chosen = [0, len(speeds) // 4, int(np.argmax(forces[0])), 3 * len(speeds) // 4, -1]
    for place in chosen:
        plain = run_case(at_speed(case, float(speeds[place])), wanted=frozenset([PEAK]))[PEAK]
        away = np.abs(forces[:, place] - plain.values)
        # the same orders: what these leave out is no part of the difference
        assert np.all(away <= 1e-9 * np.abs(forces).max())
        assert away.max() <= curve.error_estimate
    # no speed is higher than the maximum, and it is that of a plain run there
    assert np.all(forces <= top.values[:, None] * (1.0 + 1e-9) + np.asarray(top.error_estimate))
    for mount, speed in enumerate(where.values[:2]):
        plain = run_case(at_speed(case, float(speed)), wanted=frozenset([PEAK]))[PEAK]
        assert float(top.values[mount]) == pytest.approx(float(plain.values[mount]), rel=1e-9)
