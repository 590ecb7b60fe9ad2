"""A run-up under the torque of the cylinders against plain runs at single speeds inside it."""

import numpy as np
import pytest
from engine_cases import replaced
from engine_mounted import COUNTER, ON_BODY, SEPARATE, mounted
from long_but import long_but

from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

RUN_UP = ('model = "rigid_body"\n', 'model = "rigid_body"\nrun_up = { from = 40.0, to = 180.0 }\n')
#: gas tables at three speeds, whose torque is linear in the speed between them
CARDS = (
    'gas_cycle = { kind = "spark", peak_pressure = "60 bar" }\n',
    "gas_cards = ["
    + ", ".join(
        f"{{ speed = {speed}, gas_pressure = {{ crank_angle = ["
        + ", ".join(f'"{angle} deg"' for angle in range(0, 721, 40))
        + "], pressure = ["
        + ", ".join(
            f"{peak * np.exp(-np.square((angle if angle < 360 else angle - 720) / 70.0)):.6g}"
            for angle in range(0, 721, 40)
        )
        + "] } }"
        for speed, peak in ((35.0, 3e6), (95.0, 6.5e6), (200.0, 4e6))
    )
    + "]\n",
)
FEW = ('driven_machine = "separate"\n', 'driven_machine = "separate"\norders = 4\n')
STILL = ('driven_machine = "separate"\n', "orders = 4\n")
ROTOR = ("[machine.body]", '[machine.rotor]\ninertia = "0.3 kg*m^2"\n[machine.body]')
CURVE = "isolation/support_force/run_up"
PEAK = "isolation/support_force/steady_peak"
TEXTS = {
    "cards": replaced(SEPARATE, FEW, RUN_UP, CARDS),
    "on the body, small rotor": replaced(SEPARATE, STILL, ROTOR, RUN_UP),
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


@pytest.mark.parametrize("name", long_but(TEXTS, "on the body, small rotor"))
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
