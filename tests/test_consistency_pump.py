"""Claim: a pump on two mounts moves as a body with six dof would, and its report tells it.

The planar model is held against the rigid body on four mounts that are even about the plane of the
crank, the torque against that of an engine with the same pressure in a table.
"""

from typing import Any, get_args

import numpy as np
from pump_cases import FOUR, pump_with

from vibecalc.core.results.record import Quantity
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.core.run.plan import plan_case, planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.kinds import KINDS
from vibecalc.schema import KindName


def agree(one: Quantity, other: Quantity, values: np.ndarray) -> None:
    """Within both error estimates."""
    uncertainty = one.error_estimate + other.error_estimate
    assert np.max(np.abs(one.values - values)) <= uncertainty, one.path


def test_every_kind_has_its_row_and_no_other() -> None:
    assert set(get_args(KindName)) == set(KINDS)
    for parts in KINDS.values():
        assert len(parts.exclusive) == len(set(parts.exclusive))
        assert not set(parts.exclusive) & set(parts.foreign)


def test_planar_motion_is_that_of_the_whole_body() -> None:
    settings: dict[str, Any] = {"machine__mounts__positions": FOUR, "excitation__orders": 8}
    planar = run_case(pump_with(**settings))
    whole = run_case(pump_with(**settings, isolation__model="rigid_body"))
    assert set(planar) == set(whole) and len(planar) > 40
    for path, quantity in whole.items():
        if "/modes/" in path or path.endswith(("/margin", "/nearest_order", "/run_up")):
            continue
        agree(planar[path], quantity, quantity.values)
    own = planar["isolation/modes/natural_frequency"].values
    every = whole["isolation/modes/natural_frequency"].values
    assert len(own) == 3 and len(every) == 6
    assert all(np.min(np.abs(every - one)) < 1e-10 * one for one in own)
    shape = planar["isolation/modes/shape"].values
    assert shape.shape == (3, 6) and not shape[:, [0, 4, 5]].any()


def test_stages_follow_the_tables() -> None:
    def stages(**settings: Any) -> list[str]:
        return [stage.name for stage in plan_case(pump_with(**settings))]

    assert stages() == ["kinematics", "excitation", "pump", "isolation", "run_up"]
    still = pump_with(excitation__driven_machine="cancels_torque")
    couple = "isolation/torque_reaction/couple"
    assert couple in planned_quantities(pump_with()) and couple not in planned_quantities(still)
    assert any("the gas has no effect" in words for words in machine_warnings(still))
    assert not any("no effect" in words for words in machine_warnings(pump_with()))
    table = pump_with().model_copy(update={"isolation": None, "excitation": None})
    assert [stage.name for stage in plan_case(table)] == ["pump"]
