"""Claim: what no motor can do is refused in words."""

import numpy as np
import pytest
from induction_motors import GIVEN, ONE_CAGE, TABLE_SLIP, TABLE_TORQUE

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor_fit import fit_induction_motor
from vibecalc.excitation.induction_motor_flux import torque_answer
from vibecalc.excitation.induction_motor_identify import transient_inductance, with_stator_leakage


def test_more_parameters_than_rows_are_refused():
    with pytest.raises(NumericalFailure, match="3 rows to fit and the motor 4 parameters"):
        fit_induction_motor(TABLE_SLIP[:4], TABLE_TORQUE[:4], **GIVEN)
    with pytest.raises(NumericalFailure, match="1 rows to fit and the motor 2 parameters"):
        fit_induction_motor([1.0, 2.0, 3.0], [5.0, 4.0, 3.0], **GIVEN, cages=1)


@pytest.mark.parametrize("torque", [[0.0, 0.0, 5.0], [0.0, -1.0, 5.0]])
def test_torques_that_do_not_drive_are_refused(torque):
    with pytest.raises(NumericalFailure, match="torques above 0"):
        fit_induction_motor([0.0, 1.0, 2.0], torque, **GIVEN, cages=1)
    with pytest.raises(NumericalFailure, match="torques above 0"):
        fit_induction_motor([0.0], [0.0], **GIVEN, cages=1)


def test_more_leakage_in_the_stator_than_the_motor_has_is_refused():
    with pytest.raises(NumericalFailure, match="below its transient inductance"):
        with_stator_leakage(ONE_CAGE, transient_inductance(ONE_CAGE))


def test_cages_that_are_one_become_one_or_are_refused():
    twins = ONE_CAGE._replace(
        rotor_resistance=np.array([0.2, 0.2]), rotor_leakage=np.array([2e-3, 2e-3])
    )
    with pytest.raises(NumericalFailure, match="are one cage"):
        with_stator_leakage(twins, 0.0)


def test_undamped_transient_at_the_frequency_asked_for_is_refused():
    free = ONE_CAGE._replace(stator_resistance=0.0)
    with pytest.raises(NumericalFailure, match="without damping"):
        torque_answer(free, 0.9, free.line_frequency)
    assert np.isfinite(torque_answer(free, 0.9, 94.0)[0].value)
