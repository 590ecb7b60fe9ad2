"""Claim: where no steady motion exists or no number can be trusted, the words say why."""

import numpy as np
import pytest
from variable_inertia_lines import one_freedom, ship_engine, ship_torque

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.line import chain
from vibecalc.torsion.variable_inertia.motion import variable_line
from vibecalc.torsion.variable_inertia.stability import refuse_unstable, stability
from vibecalc.torsion.variable_inertia.steady import feed, steady_response


def test_unstable_operating_point_is_refused_and_damping_mends_it() -> None:
    torque = ship_torque(0.1)
    for damping, stable in ((0.01, False), (5.0, True)):
        engine = ship_engine(0.5, damping=damping)
        motion = steady_response(engine, 540.0, torque, 24, follows=True, exact=True)
        found = stability(
            engine,
            540.0,
            angle=motion.angle[0],
            angle_error=motion.error[0],
            torque=torque,
            follows=True,
        )
        assert found.unstable != stable
        if not stable:
            with pytest.raises(NumericalFailure, match=r"540 rad/s: no steady motion; .*grows by"):
                refuse_unstable(found, 540.0)


def test_order_on_an_undamped_critical_is_refused() -> None:
    torque = np.array([[0.0], [1.0]])
    with pytest.raises(NumericalFailure, match="undamped critical"):
        steady_response(one_freedom(0.0), 1.0, torque, 3)
    with pytest.raises(NumericalFailure, match="order 2 meets an undamped natural frequency"):
        feed(one_freedom(0.1), 0.5, np.ones((4, 1), dtype=complex))


def test_too_few_orders_are_refused() -> None:
    with pytest.raises(NumericalFailure, match="orders above 3 change"):
        steady_response(ship_engine(), 90.0, ship_torque(), 3)


def test_inertia_that_vanishes_over_the_turn_is_refused() -> None:
    with pytest.raises(NumericalFailure, match="freedom 2 falls to -"):
        variable_line(chain(np.ones(2), np.ones(1)), [[0.0, 0.0], [0.0, 1.2]])


def test_what_has_no_form_in_time_is_refused() -> None:
    system = ship_engine()
    lossy = system.line._replace(loss_factor=np.full(3, 0.01))
    with pytest.raises(NumericalFailure, match="loss factor"):
        stability(system._replace(line=lossy), 60.0)
    massless = system.line._replace(inertia=np.array([10.0, 10.0, 10.0, 0.0]))
    with pytest.raises(NumericalFailure, match="no inertia"):
        stability(system._replace(line=massless), 60.0)
