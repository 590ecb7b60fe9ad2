"""Claim: what no damper can do, and problems without meaning, are refused with a reason."""

import numpy as np
import pytest
from line_damper_samples import branched, torque_of_parts

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.damper_design.design import design, performance
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, SpeedTorque
from vibecalc.torsion.line import Line, chain

GOOD = Limits((0.5, 0.5), (50.0, 2e4), (0.3, 300.0))
TABLE = SpeedTorque(np.array([50.0, 150.0]), np.ones((1, 1, 3, 4), dtype=complex))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"torque": TABLE}, "torque is known from 50 to 150"),
        ({"order": np.array([1.0, 1.5, 2.0])}, "repeat with the cycle"),
    ],
)
def test_problems_without_meaning(change: dict[str, object], words: str) -> None:
    with pytest.raises(NumericalFailure, match=words):
        design(branched()._replace(**change), GOOD)


@pytest.mark.long
def test_limits_that_no_damper_keeps_name_the_nearest_miss() -> None:
    with pytest.raises(NumericalFailure, match=r"found no damper within.*no proof.*travel of"):
        design(
            branched(),
            GOOD._replace(travel=1e-5, stiffness=(1e3, 1e3), damping=(50.0, 150.0)),
            map_points=2,
            speeds=15,
            starts=1,
        )


def test_a_line_in_two_pieces_and_a_mode_out_of_reach() -> None:
    two = Line(
        np.ones(4), np.zeros(4), np.zeros(4), np.array([0, 2]), np.array([1, 3]),
        np.full(2, 1e4), np.zeros(2), np.zeros(2),
    )  # fmt: skip
    order, weight = np.array([1.0]), np.ones(2)
    push = torque_of_parts(np.array([[1.0, 0.0, 0.0, 0.0]]), 0.0)
    pieces = DamperProblem(two, 0, order, 2.0 * np.pi, push, (10.0, 200.0), weight)
    with pytest.raises(NumericalFailure, match="several pieces"):
        design(pieces, GOOD)
    # the damper sits on the node of the first mode, at 100 rad/s
    end = push._replace(coefficient=push.coefficient[..., :3])
    even = chain(np.ones(3), np.full(2, 1e4))
    node = DamperProblem(even, 1, order, 2.0 * np.pi, end, (10.0, 150.0), weight)
    with pytest.raises(NumericalFailure, match="does not reach is excited without damping at 100"):
        performance(node, Damper(0.5, 1e3, 3.0))
