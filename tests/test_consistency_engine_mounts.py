"""Claim: kind engine shakes its mounts as any machine does, and its report tells the rest."""

import numpy as np
from engine_cases import replaced
from engine_mounted import SEPARATE, mounted, wanted_of

from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.core.run.run import run_case

PHASED = (
    ('crank_phase = "50 deg", ', ""),
    ('crank_phase = "170 deg", ', ""),
    ('crank_phase = "290 deg", ', ""),
)
GENERATOR = (
    ('kind = "engine"', 'kind = "machine"'),
    ('cycle = "four_stroke"\n', ""),
    ('gas_cycle = { kind = "spark", peak_pressure = "60 bar" }\n', ""),
    ('firing_order = ["2", "3", "1"]\n', ""),
    (", pressure_scale = 1.1", ""),
)


def test_integer_orders_are_those_of_a_machine_with_the_same_throws() -> None:
    shaken = ('model = "rigid_body"', 'model = "rigid_body"\nloads = ["shaking"]')
    engine = run_case(mounted(replaced(SEPARATE, shaken)))
    other = run_case(mounted(replaced(SEPARATE, *GENERATOR)))
    assert len(other) > 20
    for path, quantity in other.items():
        assert np.array_equal(engine[path].values, quantity.values), path
    assert set(engine.quantities) == set(other.quantities)


def test_throws_that_follow_from_the_firing_order_shake_alike() -> None:
    """The crank angle then counts from the first firing: a turn of the phases, no other change."""
    reported, found = mounted(SEPARATE), mounted(replaced(SEPARATE, *PHASED))
    assert {cylinder.crank_phase for cylinder in reported.machine.crank_train.cylinders} != {
        cylinder.crank_phase for cylinder in found.machine.crank_train.cylinders
    }
    for path in ("isolation/support_force/steady_harmonics", "isolation/torque_reaction/couple"):
        one = wanted_of(SEPARATE)[path]
        other = wanted_of(replaced(SEPARATE, *PHASED))[path]
        order = one.axes[-1].values
        turned = one.values * np.exp(1j * order * np.radians(210.0))
        size = np.abs(one.values).max()
        assert np.allclose(other.values, turned, rtol=0.0, atol=1e-11 * size)


def test_gas_that_reaches_nothing_is_said() -> None:
    words = "the gas has no effect"
    still = replaced(SEPARATE, ('"separate"', '"cancels_torque"'))
    assert any(words in one for one in machine_warnings(mounted(still)))
    assert not any(words in one for one in machine_warnings(mounted(SEPARATE)))
