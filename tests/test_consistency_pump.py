"""Claim: a pump on two mounts moves as a body with all six freedoms would, and its report tells it.

The planar model is held against the rigid body on four mounts that are even about the plane of the
crank, the torque against that of an engine with the same pressure in a table.
"""

from typing import Any, get_args

import numpy as np
import pytest
from pump_cases import FOUR, pump_with
from shipped_cases import CASES, result_of

from vibecalc.core.report.text import render_report
from vibecalc.core.report.verdicts import judge_limits, judge_references
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_case
from vibecalc.isolation.pictures import ENGINE_MOUNTS
from vibecalc.kinds import KINDS, PARTS_OF_KIND
from vibecalc.schema import KindName

REACTION = "isolation/torque_reaction/"


def agree(one: Quantity, other: Quantity, values: np.ndarray) -> None:
    """Within both error estimates."""
    uncertainty = one.error_estimate + other.error_estimate
    assert np.max(np.abs(one.values - values)) <= uncertainty, one.path


def test_every_kind_has_its_row_and_no_other() -> None:
    assert set(get_args(KindName)) == set(KINDS)
    assert set(PARTS_OF_KIND) <= set(KINDS)
    owned = [place for parts in PARTS_OF_KIND.values() for place in parts.exclusive]
    assert len(owned) == len(set(owned))
    for parts in PARTS_OF_KIND.values():
        assert not set(parts.exclusive) & set(parts.foreign)


def test_hand_calculations_come_out() -> None:
    result = result_of("pump")
    judged = judge_references(result)
    assert len(judged) == 14
    assert {row.verdict for row in judged} == {"within"}
    assert all(limit.kept for limit in judge_limits(result))


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


@pytest.mark.long
def test_crank_planes_of_other_axes_move_alike() -> None:
    def turned(axis: str, stroke: str) -> Record:
        place = {axis: 0, stroke: 2}
        across = next(name for name in "xyz" if name not in place)
        # across = stroke x axis points along or against the third direction
        sign = 1.0 if (stroke + axis) in "xyzxy" else -1.0
        to = ["xyz".index(axis), "xyz".index(across), "xyz".index(stroke)]

        def point(x: float, y: float, z: float) -> list[float]:
            found = [0.0, 0.0, 0.0]
            for at, value in zip(to, (x, sign * y, z), strict=True):
                found[at] = value
            return found

        case = pump_with(
            machine__crank_train__axis=axis,
            machine__crank_train__stroke=stroke,
            machine__crank_train__origin=point(0.0, 0.0, -0.02),
            machine__body__inertia=[abs(one) for one in point(7.5, 8.0, 6.0)],
            machine__mounts__each={
                "stiffness": [abs(one) for one in point(6e4, 6e4, 9e4)],
                "damping": [abs(one) for one in point(400.0, 400.0, 600.0)],
            },
            machine__mounts__positions=[point(0.0, -0.35, -0.2), point(0.0, 0.35, -0.2)],
            isolation__up=stroke,
        )
        assert check_machine(case) == []
        return run_case(case)

    plain = turned("x", "z")
    for axis, stroke in (("z", "y"), ("y", "z")):
        other = turned(axis, stroke)
        for path in (
            "isolation/modes/natural_frequency",
            "isolation/support_force/steady_peak",
            "isolation/support_force/run_up_peak",
            f"{REACTION}support_force_peak",
            f"{REACTION}largest_load",
        ):
            agree(plain[path], other[path], other[path].values)


def test_the_mounts_take_the_mean_torque_and_its_work() -> None:
    record = result_of("pump").record
    couple, mean = record[f"{REACTION}mean_couple"], record["excitation/pump/mean_torque"]
    agree(couple, mean, -mean.values)
    held = record[f"{REACTION}mean_support_force"].values
    arm = np.array([[0.0, -0.35, -0.2], [0.0, 0.35, -0.2]])
    assert np.cross(arm, held).sum(axis=0)[0] == pytest.approx(float(couple.values), rel=1e-12)
    speed = 450.0 * 2.0 * np.pi / 60.0
    assert -mean.values * speed == pytest.approx(record["excitation/pump/power"].values, rel=1e-12)
    reaction, torque = record[f"{REACTION}couple"], record["excitation/pump/torque"]
    inertia = reaction.values + torque.values  # what is left is of the masses, with no gas in it
    assert np.max(np.abs(inertia[6:])) < 1e-3 < np.max(np.abs(inertia[:4]))


def test_three_cylinders_smooth_the_torque_and_idle_ones_do_nothing() -> None:
    throws = [{"name": str(number), "crank_phase": f"{120 * number} deg"} for number in range(3)]
    three = run_case(pump_with(machine__crank_train__cylinders=throws))
    one = run_case(pump_with())
    path = "excitation/pump/torque"
    left = np.abs(three[path].values)
    assert np.max(left[np.arange(24) % 3 != 2]) <= three[path].error_estimate
    agree(three[path], one[path], np.where(np.arange(24) % 3 == 2, 3.0 * one[path].values, 0.0))
    power = "excitation/pump/power"
    agree(three[power], one[power], 3.0 * one[power].values)
    single = run_case(pump_with(machine__crank_train__cylinders=throws, excitation__working=["0"]))
    agree(single[path], one[path], one[path].values)
    for name in ("flow", "power", "mean_torque"):
        place = f"excitation/pump/{name}"
        agree(single[place], one[place], one[place].values)


def test_stages_follow_the_tables() -> None:
    def stages(**settings: Any) -> list[str]:
        return [stage.name for stage in plan_case(pump_with(**settings))]

    reaction = "torque reaction"
    all_of_it = ["kinematics", "excitation", "pump", "isolation", "run_up", reaction]
    assert stages() == all_of_it
    still = pump_with(excitation__driven_machine="cancels_torque")
    assert [stage.name for stage in plan_case(still)] == all_of_it[:-1]
    assert any("the gas has no effect" in words for words in machine_warnings(still))
    assert not any("no effect" in words for words in machine_warnings(pump_with()))
    table = pump_with().model_copy(update={"isolation": None, "excitation": None})
    assert [stage.name for stage in plan_case(table)] == ["pump"]


def test_report_and_picture_tell_all_of_it() -> None:
    result = result_of("pump")
    report = render_report(result)
    assert "Pump: valves, volumes and torque" in report
    assert "Torque reaction: pump on its mounts" in report
    assert "engine" not in report
    figure = ENGINE_MOUNTS(result)
    assert figure is not None and figure.axes[1].get_xlim() == (0.0, 360.0)
    assert CASES["pump"].is_file()
