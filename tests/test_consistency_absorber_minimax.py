"""Claim: the tuning is the true minimax, to 1e-12 of the peak above its floor and 1e-6 in k and z2,
and what is said of it (balanced, set, no help, unbounded) is so. With spring or damper given, or
within limits, it is the best that is left; its derivatives and losses are those of differences.
"""

import numpy as np
import pytest
from absorber_cases import peaks_of
from exact_tree import optimum
from long_but import long_but
from mpmath import mp, mpf

from vibecalc.absorber.modal import one_mode
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.band import band_tuning
from vibecalc.absorber.tuning.closed_forms import METHODS, closed_form
from vibecalc.absorber.tuning.levels import BandProblem
from vibecalc.absorber.tuning.minimax import BALANCED, NO_HELP, SET, minimax
from vibecalc.absorber.tuning.minimax_steps import (
    BOUNDARY,
    ISOLATED,
    NOT_OPTIMAL,
    VERDICTS,
    certify,
)
from vibecalc.absorber.tuning.minimax_steps import SET as CERTIFIED_SET
from vibecalc.absorber.tuning.restricted import (
    given_damping,
    given_stiffness,
    pure_viscous,
    stock_choice,
    undamped_spring,
)

KINDS = (
    ("force", "displacement"), ("force", "velocity"), ("force", "acceleration"),
    ("force", "transmitted_force"), ("base", "displacement"), ("base", "velocity"),
    ("base", "transmitted_force"), ("unbalance", "displacement"),
)  # fmt: skip
#: responses whose optimum is balanced for every primary damping
ALWAYS = (("force", "velocity"), ("base", "displacement"), ("force", "transmitted_force"))
BOUNDED = [kind for kind in KINDS if kind != ("base", "transmitted_force")]
#: one of every sort in CI: always balanced, with a set of optima, of the ground
QUICK = (("force", "velocity"), ("force", "acceleration"), ("base", "velocity"))
THRESHOLD = 2**-0.5


def sample(count, seed=20):
    """Pairs (z1, m): log-uniform m in 1e-4..10, z1 in 0..1/sqrt 2, some of them by its ends."""
    rng = np.random.default_rng(seed)
    z1 = rng.uniform(0.0, THRESHOLD, count)
    z1[::10], z1[1::10] = 0.0, THRESHOLD - 10.0 ** rng.uniform(-8, -2, len(z1[1::10]))
    return z1, 10.0 ** rng.uniform(-4.0, 1.0, count)


def exact_floor(kind, z1, floor):
    return 2 * mpf(float(z1)) if kind == ("base", "velocity") else mpf(float(floor))


def held_against_many_digits(kind, z1, m):
    """Compare every balanced tuning; returns how many there were."""
    mp.dps = 100
    found = minimax(z1, m, *kind)
    rows = np.flatnonzero(found.outcome == BALANCED)
    for i in rows:
        near = found.stiffness_ratio[i], found.secondary_damping[i]
        floor = exact_floor(kind, z1[i], found.floor[i])
        k, z2, above = optimum(
            kind, z1[i], m[i], near, found.frequency[i], found.weight[i], floor
        )  # fmt: skip
        assert abs(found.above_floor[i] / above - 1) < 1e-12
        assert abs(found.stiffness_ratio[i] / k - 1) < 1e-9
        assert abs(found.secondary_damping[i] / z2 - 1) < 1e-9
        assert abs(found.stiffness_ratio[i] - k) <= found.stiffness_error[i]
        assert abs(found.secondary_damping[i] - z2) <= found.damping_error[i]
        relative = found.excess_error[i] / found.excess[i]
        assert abs(found.above_floor[i] / above - 1) <= relative + 2e-16
        assert relative < 1e-11 and found.stiffness_error[i] < 1e-7 * k
    return len(rows)


def test_force_and_displacement_holds_against_forty_digits():
    assert held_against_many_digits(("force", "displacement"), *sample(3)) == 3


@pytest.mark.parametrize("kind", QUICK, ids="-".join)
def test_other_responses_hold_against_forty_digits(kind):
    z1, m = sample(3, seed=len(kind[1]))
    m = np.minimum(m, 0.05) if kind not in ALWAYS else m  # heavy ones reach the floor
    assert held_against_many_digits(kind, z1, m) >= 2


def test_base_and_transmitted_force_holds_for_an_undamped_primary():
    m = 10.0 ** np.array([-4.0, -1.0, 1.0])
    assert held_against_many_digits(("base", "transmitted_force"), 0.0 * m, m) == 3


@pytest.mark.long
@pytest.mark.parametrize("kind", BOUNDED, ids="-".join)
def test_two_hundred_pairs_hold_against_forty_digits(kind):
    z1, m = sample(200, seed=31)
    assert held_against_many_digits(kind, z1, m) >= 80


def test_an_undamped_primary_gives_the_closed_form_of_nishihara_and_asami():
    m = np.array([1e-4, 1e-2, 0.1, 1.0, 10.0])
    found, exact = minimax(0.0, m), closed_form("nishihara_asami", m)
    np.testing.assert_allclose(found.stiffness_ratio, exact.stiffness_ratio, rtol=1e-12)
    np.testing.assert_allclose(found.secondary_damping, exact.secondary_damping, rtol=1e-12)
    assert np.all(np.abs(found.largest - exact.promised) <= found.largest_error + 1e-15 * m**-0.5)
    assert found.largest[2] == pytest.approx(4.58917, abs=5e-6)
    assert np.all(np.abs(exact.largest - exact.promised) <= exact.largest_error)


@pytest.mark.parametrize("name", METHODS)
def test_closed_forms_are_as_good_as_they_say(name):
    m = np.array([0.003, 0.03, 0.3])
    method = METHODS[name]
    form = closed_form(name, m)
    best = minimax(0.0, m, method.excitation, method.response)
    if name == "lanchester":
        best = pure_viscous(0.0, m)
        np.testing.assert_allclose(best.value, form.secondary_damping, rtol=1e-13)
        wrong = np.abs(best.largest - form.largest)
        assert np.all(wrong <= best.largest_error + form.largest_error)
    else:
        assert np.all(form.largest >= best.largest * (1.0 - 1e-12))
        assert np.all(form.largest < best.largest * (1.0 + 0.1 * m))
    loss = np.max(np.abs(form.largest / form.promised - 1.0))
    assert loss < 1e-11 if method.exact else 1e-4 < loss < 0.1


def test_the_threshold_of_force_and_displacement_is_met_from_both_sides():
    """4 z1^2 = 2: below it there is something to gain, above nothing is left."""
    below, above = np.nextafter(THRESHOLD, 0.0), THRESHOLD  # the double is above 1 / sqrt 2
    said = [int(minimax(z, 0.1).outcome) for z in (below, above, 2.0)]
    assert said == [BALANCED, NO_HELP, NO_HELP]
    assert minimax(above, 0.1).largest == 1.0 and minimax(above, 0.1).stiffness_ratio == 0.0
    # the source has no spring and no damper left at .7: there is still something to gain
    assert minimax(0.7, 0.1).stiffness_ratio > 0.0


def test_a_set_reaches_the_floor_and_a_smaller_mass_does_not():
    kind = ("force", "acceleration")
    found = minimax(0.3, [0.05, 1.0], *kind)
    assert found.outcome.tolist() == [BALANCED, SET]
    tuned = Absorber(0.3, [0.05, 1.0], found.stiffness_ratio, found.secondary_damping)
    said = certify(tuned, *kind)
    assert list(said.verdict) == [ISOLATED, CERTIFIED_SET]
    assert said.largest[1] == 1.0 and found.largest[1] == 1.0
    # the neighbourhood of the one returned reaches it too, or it stands on the edge of the set
    around = peaks(Absorber(0.3, 1.0, 0.062, 2.01), *kind)
    assert around.largest == 1.0


@pytest.mark.parametrize("kind", long_but([*BOUNDED, ("base", "transmitted_force")], *QUICK))
def test_every_optimum_is_certified(kind):
    rng = np.random.default_rng(7)
    z1 = rng.uniform(0.0, 2.0 if kind in ALWAYS else 0.7, 40)
    m = 10.0 ** rng.uniform(-4.0, 1.0, 40)
    z1 = 0.0 * z1 if kind[1] == "transmitted_force" and kind[0] == "base" else z1
    found = minimax(z1, m, *kind)
    said = certify(Absorber(z1, m, found.stiffness_ratio, found.secondary_damping), *kind)
    held = found.outcome == BALANCED
    assert np.sum(held) > 15 and (np.all(held) or kind not in ALWAYS)
    assert np.all(said.verdict[held] == ISOLATED)
    assert np.all(said.verdict[found.outcome == SET] == CERTIFIED_SET)
    assert np.all(np.sum(said.active[held], axis=1) == 2)
    assert np.max(said.residual[held]) < 1e-8 and np.min(said.curvature[held]) > 0.0
    assert np.all(np.abs(said.largest - found.largest) <= 1e-13 * m**-0.5 * found.largest)
    np.testing.assert_allclose(
        np.max(said.weight[held], axis=1), np.max(found.weight[held], axis=1), rtol=1e-6
    )
    # every direction raises the largest peak
    step = 1e-4
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)[:, None]
    moved = Absorber(
        z1, m, found.stiffness_ratio * np.exp(step * np.cos(turn)),
        found.secondary_damping * np.exp(step * np.sin(turn)),
    )  # fmt: skip
    around = peaks(moved, *kind)
    assert np.all(around.largest[:, held] > found.largest[held])


def test_the_certificate_refuses_what_is_not_optimal():
    good = minimax(0.1, 0.1)
    k, z2 = good.stiffness_ratio, good.secondary_damping
    for wrong in ((k * 1.001, z2), (k, z2 * 1.001), (0.0, z2), (k, 0.0), (np.inf, z2)):
        assert certify(Absorber(0.1, 0.1, *wrong)).verdict == NOT_OPTIMAL
    half = closed_form("den_hartog_brock", 0.1)
    nearly = certify(Absorber(0.0, 0.1, half.stiffness_ratio, half.secondary_damping))
    assert VERDICTS[nearly.verdict] == "not_optimal"
    # nothing but the boundary keeps a viscous damper optimal where a spring would only do harm
    assert BOUNDARY not in certify(Absorber(0.1, 0.1, 0.0, [0.01, 0.1, 1.0])).verdict


Z1, MASS = np.array([0.0, 0.05, 0.3, 0.6]), np.array([0.1, 1e-3, 0.5, 5.0])


def test_a_viscous_damper_is_worse_than_the_optimum_and_better_than_its_neighbours():
    found = pure_viscous(Z1, MASS)
    assert np.all(found.held_by == 1) and np.all(found.largest > minimax(Z1, MASS).largest)
    for factor in (0.99, 1.01):
        assert np.all(peaks(Absorber(Z1, MASS, 0.0, found.value * factor)).largest > found.largest)


def test_each_of_both_given_the_others_optimum_finds_its_own():
    best = minimax(Z1, MASS)
    damper = given_stiffness(Z1, MASS, best.stiffness_ratio)
    spring = given_damping(Z1, MASS, best.secondary_damping)
    np.testing.assert_allclose(damper.value, best.secondary_damping, rtol=1e-9)
    np.testing.assert_allclose(spring.value, best.stiffness_ratio, rtol=1e-9)
    assert np.all(spring.held_by == 2)
    assert np.all(np.abs(spring.largest - best.largest) <= spring.largest_error)


def test_without_a_damper_no_spring_helps_against_a_force():
    """Each undamped mode meets |H| = 1 / (2 z1 x): the lower one is above the bare system."""
    found = undamped_spring([0.01, 0.1, 0.5], 0.1)
    assert np.all(found.value == 0.0) and np.all(found.held_by == 0)
    bare = 1.0 / (2.0 * np.array([0.01, 0.1, 0.5]) * np.sqrt(1.0 - np.array([0.01, 0.1, 0.5]) ** 2))
    np.testing.assert_allclose(found.largest, bare, rtol=1e-14)


def test_nor_does_one_where_that_bound_says_nothing():
    """z1^2 >= m / (1 + m): held against 100 springs for each pair, from 1e-4 to 1e4 times m."""
    z1, m = np.array([0.3, 0.45, 0.6, 0.7])[:, None], np.array([0.001, 0.01, 0.05, 0.09])
    assert np.all(z1**2 > m / (1.0 + m))
    assert np.all(undamped_spring(z1, m).value == 0.0)
    bare = 1.0 / (2.0 * z1 * np.sqrt(1.0 - z1**2))
    k = m * np.geomspace(1e-4, 1e4, 100)[:, None, None]
    assert np.all(peaks(Absorber(z1, m, k, 0.0)).largest >= bare * (1.0 - 1e-12))


HELD_BY = (
    "least stiffness", "least damping", "largest stiffness", "largest damping", "spring travel",
)  # fmt: skip
CASES = [
    ({"travel": 8.0}, ("spring travel",)),
    ({"travel": 1.0}, ("spring travel",)),
    ({"stiffness": (0.1, 0.2)}, ("least stiffness",)),
    ({"damping": (0.0, 0.01)}, ("largest damping",)),
    ({"damping": (0.03, 1.0)}, ("least damping",)),
    ({"stiffness": (0.02, 0.05), "travel": 10.0}, ("largest stiffness", "spring travel")),
    ({"damping": (0.0, 0.02), "travel": 3.0}, ("largest damping", "spring travel")),
    ({"stiffness": (0.0, 0.0)}, ("least stiffness", "largest stiffness")),
]


@pytest.mark.long
@pytest.mark.parametrize(
    ("limits", "active"),
    CASES,
)
def test_no_point_of_a_grid_within_the_limits_is_better(limits, active):
    found = band_tuning(
        BandProblem(one_mode(0.02), np.array([0.1]), "force", "displacement", **limits)
    )
    held = (*found.lower, *found.upper, np.any(found.limit > 0))
    assert tuple(name for name, one in zip(HELD_BY, held, strict=True) if one) == active
    low, high = limits.get("stiffness", (1e-3, 3.0))
    k = np.linspace(low, high, 40) if "stiffness" in limits else np.geomspace(low, high, 90)
    low, high = limits.get("damping", (1e-3, 3.0))
    z = np.linspace(low, high, 40) if "damping" in limits else np.geomspace(low, high, 90)
    grid = Absorber(0.02, 0.1, k[:, None], z)
    height = peaks(grid).largest
    allowed = peaks(grid, "force", "relative_displacement").largest <= limits.get("travel", np.inf)
    best = float(np.min(np.where(allowed, height, np.inf)))
    assert best * 0.9 <= found.largest <= best * (1.0 + 1e-12)
    chosen = Absorber(0.02, 0.1, found.stiffness_ratio[0], found.secondary_damping[0])
    assert peaks(chosen).largest == pytest.approx(found.largest, rel=1e-12)
    travel = peaks(chosen, "force", "relative_displacement").largest
    assert travel <= limits.get("travel", np.inf) * (1.0 + 1e-9)


def test_the_best_stock_pair():
    springs, oils = np.array([0.07, 0.08, 0.09]), np.array([0.01, 0.015, 0.02, 0.03])
    free = float(minimax(0.02, 0.1).largest)
    found = stock_choice(springs, oils, free, peaks_of(0.02, 0.1))
    one_by_one = np.array([[float(peaks(Absorber(0.02, 0.1, k, z)).largest) for z in oils]
                           for k in springs])  # fmt: skip
    assert found.peak == pytest.approx(one_by_one, rel=1e-13)
    assert (found.spring, found.oil) == np.unravel_index(np.argmin(one_by_one), (3, 4))
    assert np.all(np.diff(one_by_one[tuple(found.order.T)]) >= 0.0)
    assert np.all(found.penalty > 0.0)
    limited = stock_choice(springs, oils, free, peaks_of(0.02, 0.1), travel=9.0)
    assert not np.any(limited.travel[tuple(limited.order.T)] > 9.0)
    assert len(limited.order) == 3 and limited.oil == 3
