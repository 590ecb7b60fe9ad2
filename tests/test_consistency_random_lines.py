"""Claim: what random shaft lines do is what their equations of motion say, with everything at once.

Gears rigid and elastic, branches, loops, equal branches, dampers, couplings over torque and
frequency, propellers, misfires and dampings that follow the speed, against the full matrices of
`dense_line.py`.
"""

import copy
from collections.abc import Iterator

import numpy as np
import pytest
from dense_line import DenseLine, cylinder_of, ends, half_range
from long_but import long_but
from random_lines import random_line

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

ROOT = "response/torsion/"
#: of the size of a result
TOLERANCE = 1e-8
#: of them those that have all kinds of parts, dampings and loads together; the rest are long
USUAL = (0, 2, 4, 5)


class Results:
    """Arrays of a run, without its prefix."""

    def __init__(self, case):
        checked = validate(copy.deepcopy(case))
        assert not check_machine(checked)
        self.record = run_case(checked)

    def __contains__(self, path):
        return ROOT + path in self.record

    def __getitem__(self, path):
        return np.asarray(self.record[ROOT + path].values)

    def labels(self, path):
        return [str(one) for one in self.record[ROOT + path].axes[0].values]


def pairs(found: Results, case) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Path, what the program has, what the equations say."""
    given = cylinder_of(found.record, case)
    line, order = DenseLine(case, lambda speed: given), given.order
    silent = dict.fromkeys(case["response"]["torsion"].get("misfire", ()), 0.0)
    speed, stations = case["machine"]["speed"], len(line.names)
    now = line.at(speed, silent)
    sections, held = line.heat(now, speed)
    rings = slice(len(line.sections) - len(line.dampers), None)
    yield "angle", found["angle"], now.angle[:stations]
    yield "torque", found["torque"], now.torque
    yield "torque_mean", found["torque_mean"], now.torque_mean
    yield "torque_half_range", found["torque_half_range"], half_range(order, now.torque)
    yield "angle_half_range", found["angle_half_range"], half_range(order, now.angle[:stations])
    yield "section_heat", found["section_heat"], sections
    yield "station_heat", found["station_heat"], held
    if line.dampers:
        travel = np.max(np.abs(ends(order, (line.network @ now.angle)[rings])), axis=0)
        # a point mass of order n hangs on R / n^2, and swings by 1 + n^2 of the twist
        for place, one in enumerate(case["machine"]["shaft_line"]["dampers"]):
            travel[place] *= 1.0 + one["order"] ** 2 if one["kind"] == "pendulum" else 1.0
        yield "damper/heat", found["damper/heat"], sections[rings]
        yield "damper/travel", found["damper/travel"], travel
    if line.gears:
        low, high = (now.gear_mean + one for one in ends(order, now.gear))
        yield "gear/mean_torque", found["gear/mean_torque"], now.gear_mean
        yield "gear/alternating_torque", found["gear/alternating_torque"], 0.5 * (high - low)
        least = np.where(now.gear_mean < 0.0, -high, low)
        carries = np.abs(now.gear_mean) > 1e-9 * np.abs(now.gear_mean).max(initial=0.0)
        has = np.where(carries, found["gear/minimum_torque"], 0.0)
        yield "gear/minimum_torque", has, np.where(carries, least, 0.0)
    if "modes/undamped_frequency" in found and not _varies(case):
        undamped = found["modes/undamped_frequency"]
        yield "modes/undamped_frequency", undamped**2, line.undamped(speed) ** 2
    asked = case["response"]["torsion"]["speeds"]
    every = [line.at(at, silent) for at in np.linspace(asked["from"], asked["to"], 7)]
    seen = np.array([half_range(order, one.torque) for one in every]).T
    yield "speeds/torque_half_range", found["speeds/torque_half_range"], seen
    if "conditions/torque_half_range" in found:
        out = [{}, *({one["name"]: 0.0} for one in line.train["cylinders"])]
        worst = np.array([half_range(order, line.at(speed, one).torque) for one in out])
        yield "conditions/torque_half_range", found["conditions/torque_half_range"], worst


def _varies(case) -> bool:
    """Whether a coupling has another stiffness at each frequency or torque."""
    return any(
        {"over_frequency", "over_mean_torque"} & set(one.get("coupling", ()))
        for one in case["machine"]["shaft_line"]["shafts"]
    )


@pytest.mark.parametrize("seed", long_but(range(200), *USUAL))
def test_random_lines_do_what_their_equations_of_motion_say(seed: int) -> None:
    case = random_line(seed)
    off = []
    for path, has, says in pairs(Results(case), case):
        assert has.shape == says.shape, path
        size = np.max(np.abs(says), initial=0.0)
        worst = np.max(np.abs(has - says), initial=0.0)
        if not worst <= TOLERANCE * size:
            off.append(f"{path}: off by {worst:.3g} of {size:.6g}")
    assert off == []
