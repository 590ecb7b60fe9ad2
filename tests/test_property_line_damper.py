"""Claim: a tuned damper carries its own proof and does not depend on what guided the search."""

import numpy as np
import pytest
from line_damper_samples import branched, direct, torque_of_parts

from vibecalc.torsion.damper_design.design import (
    Design,
    design,
    design_from,
    first_of_the_highest,
    mistuning,
    performance,
)
from vibecalc.torsion.damper_design.peaks import survey
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits
from vibecalc.torsion.line import chain

FREE = Limits((0.5, 0.5), (50.0, 2e4), (0.3, 300.0))
QUICK = {"map_points": 5, "speeds": 25, "starts": 1}


@pytest.fixture(scope="module")
def tuned() -> Design:
    return design(branched(), FREE, **QUICK)


def proves(found: Design, sections: int) -> None:
    """Weights, balance and equal levels of the certificate."""
    section = found.peaks.row < sections
    assert np.all(found.weight.value > 0.0)
    assert abs(found.weight.value[section].sum() - 1.0) < 1e-12
    assert found.residual < 1e-11 and found.curvature.value > 0.0
    np.testing.assert_allclose(found.peaks.value[section], found.worst.value, rtol=1e-11)


@pytest.mark.long
def test_the_speeds_that_guide_the_search_do_not_show_in_the_answer(tuned: Design) -> None:
    other = design(branched(), FREE, map_points=8, speeds=67, starts=1)
    proves(tuned, 3)
    assert abs(other.worst.value - tuned.worst.value) <= other.worst.error + tuned.worst.error
    off = np.abs(other.damper.value - tuned.damper.value)
    assert np.all(off <= other.damper.error + tuned.damper.error)
    assert tuned.worst.error < 1e-11 * tuned.worst.value
    assert np.all(tuned.damper.error < 1e-8 * tuned.damper.value)


@pytest.mark.long
def test_limits_on_heat_and_travel_are_met_and_priced(tuned: Design) -> None:
    near = Limits((0.5, 0.5), (4e3, 1.2e4), (20.0, 90.0))
    quick = {"map_points": 3, "speeds": 21, "starts": 1}
    heat = design(branched(), near._replace(heat=22.0), **quick)
    travel = design(branched(), near._replace(travel=0.0075), **quick)
    for found, limit, numbers in ((heat, 22.0, (3,)), (travel, 0.0075, (4, 5))):
        proves(found, 3)
        held = np.isin(found.peaks.row, numbers)
        assert np.any(held) and found.worst.value > tuned.worst.value
        np.testing.assert_allclose(found.peaks.value[held], limit, rtol=1e-11)
    # a little more of the limit is worth its weight
    more = design(branched(), near._replace(travel=0.0075 * 1.001), **quick)
    worth = (travel.worst.value - more.worst.value) / (0.001 * travel.worst.value)
    assert abs(worth / travel.weight.value[travel.peaks.row > 3].sum() - 1.0) < 0.02


@pytest.mark.long
def test_a_limit_that_only_stiff_rings_keep_is_met_from_a_valley_that_breaks_it() -> None:
    # from here heat only falls towards a ring that is all but free, and never to the limit
    limit = 4.0
    bounds = Limits((0.5, 0.5), (1e3, 3e6), (5.0, 300.0), heat=limit)
    prepared = survey(branched(), bounds, 41)
    found = design_from(prepared, np.log([[3e3, 6.0]]))
    proves(found, 3)
    assert performance(branched(), found.values).reading.value[1] <= limit * (1.0 + 1e-11)
    kept = 0
    for stiffness in np.geomspace(2e4, 2e6, 5):
        for damping in (30.0, 300.0):
            seen = performance(branched(), Damper(0.5, float(stiffness), damping), 41)
            kept += seen.reading.value[1] <= limit
            assert seen.reading.value[1] > limit or seen.reading.value[0] > found.worst.value
    assert kept > 3


@pytest.mark.long
def test_viscous_damper_is_worse_and_mistuning_is_that_of_direct_solves(
    tuned: Design,
) -> None:
    viscous = design(branched(), FREE._replace(stiffness=(0.0, 0.0)), **QUICK)
    proves(viscous, 3)
    assert viscous.worst.value > tuned.worst.value
    seen = mistuning(branched(), tuned)
    increase = seen.increase.value
    assert np.all(increase >= 1.0) and increase[1, 1] == 1.0 and increase.max() > 1.01
    speed = np.linspace(30.0, 200.0, 801)
    off = Damper(0.5, tuned.values.stiffness * 0.9, tuned.values.damping * 1.1)
    dense = direct(branched(), off, speed, 200)[:, :-2].max()
    np.testing.assert_allclose(increase[0, 2] * tuned.worst.value, dense, rtol=1e-3)


def test_narrow_resonances_between_the_speeds_of_the_grid_are_found() -> None:
    line = chain(np.array([1.0, 1.0, 1.0]), np.array([1e4, 1e4]))
    source = torque_of_parts(np.array([[1.0, 0.0, 0.0]]), 0.0)
    problem = DamperProblem(
        line, 0, np.array([1.0]), 2.0 * np.pi, source, (50.0, 210.0), np.ones(2)
    )
    damper = Damper(0.01, 1.0, 0.01)
    seen = performance(problem, damper, speeds=15)
    close = seen.speed.value[0] + np.linspace(-0.02, 0.02, 401)
    dense = direct(problem, damper, close, 720)[:, :2].max()
    np.testing.assert_allclose(seen.reading.value[0], dense, rtol=2e-4)
    wide = direct(problem, damper, np.linspace(50.0, 210.0, 4001), 72)[:, :2].max()
    assert seen.reading.value[0] >= wide


ROW = np.array([3, 1, 1, 0])
SPEED = np.array([80.0, 120.0, 90.0, 60.0])


def test_of_equal_heights_the_first_section_at_its_lowest_speed_is_named() -> None:
    for bits in ((0, 0, 0), (1, 0, -1), (-1, 1, 0), (0, -1, 1)):
        height = 565.0 * (1.0 + 1e-14 * np.array([*bits, 0]))
        height[3] = 300.0
        assert first_of_the_highest(ROW, SPEED, height) == 2
