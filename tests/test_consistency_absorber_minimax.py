"""Claim: the tuning is the true minimax, to 1e-12 of the peak above its floor and 1e-6 in k and z2,
by tens of evaluations, and what is said of it (balanced, set, no help, unbounded) is so."""

import numpy as np
import pytest
from exact_absorber import KINDS, optimum
from long_but import long_but
from mpmath import mp, mpf

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber, own_damping_ratio
from vibecalc.absorber.tuning.closed_forms import METHODS, closed_form
from vibecalc.absorber.tuning.minimax import BALANCED, NO_HELP, SET, minimax
from vibecalc.absorber.tuning.minimax_steps import (
    BOUNDARY,
    ISOLATED,
    NOT_OPTIMAL,
    VERDICTS,
    certify,
)
from vibecalc.absorber.tuning.minimax_steps import SET as CERTIFIED_SET
from vibecalc.absorber.tuning.restricted import pure_viscous

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
    mp.dps = 60
    found = minimax(z1, m, *kind)
    rows = np.flatnonzero(found.outcome == BALANCED)
    for i in rows:
        near = (found.stiffness_ratio[i], found.secondary_damping[i], *found.frequency[i])
        k, z2, above = optimum(kind, z1[i], m[i], near, exact_floor(kind, z1[i], found.floor[i]))
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


def test_the_exact_case_of_one_half():
    found = minimax(0.5, 0.5)
    assert found.stiffness_ratio == pytest.approx(1 / 27, rel=1e-14)
    tuned = Absorber(0.5, 0.5, found.stiffness_ratio, found.secondary_damping)
    # the ratio on the secondary's own frequency, eq. 2.7
    assert own_damping_ratio(tuned) == pytest.approx(6**-0.5, rel=1e-14)
    assert found.largest == pytest.approx(3 / (2 * 2**0.5), rel=1e-15)
    np.testing.assert_allclose(found.weight, 0.5, rtol=1e-12)


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
    """4 z1^2 = 2: below it the excess falls with the square of the distance, above none is left."""
    away = 10.0 ** -np.arange(2.0, 16.0)
    for m in (1e-4, 10.0):
        found = minimax(THRESHOLD - away, m)
        assert np.all(found.outcome == BALANCED)
        shrink = found.above_floor[4:10] / found.above_floor[5:11]
        np.testing.assert_allclose(shrink, 100.0, rtol=1e-2 if m > 1e-3 else 0.5)
        bare = peaks(Absorber(THRESHOLD - away[:4], m, 0.0, 0.0))
        assert np.all(found.above_floor[:4] < bare.largest - 1.0)
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


@pytest.mark.parametrize("pair", [(0.1, 0.01), (0.35, 3.0)])
def test_a_grid_around_finds_nothing_lower(pair):
    z1, m = pair
    found = minimax(z1, m)
    centre = np.log([float(found.stiffness_ratio), float(found.secondary_damping)])
    for width in (2.0, 0.1, 0.005, 2e-4):
        k, z2 = np.exp(centre[:, None] + np.linspace(-width, width, 15))
        grid = peaks(Absorber(z1, m, k[:, None], z2)).largest
        assert np.min(grid) >= found.largest * (1.0 - 1e-13)
        assert np.min(grid) < found.largest * (1.0 + 0.2 * width * m**-0.5)


@pytest.mark.long
@pytest.mark.parametrize("kind", [*BOUNDED, ("base", "transmitted_force")], ids="-".join)
def test_a_global_search_finds_nothing_lower_for_any_response(kind):
    from scipy.optimize import differential_evolution

    for z1, m in ((0.02, 0.3), (0.1, 0.002), (0.35, 3.0), (0.5, 0.05), (0.65, 9.0)):
        z1 = 0.0 if kind == ("base", "transmitted_force") else z1
        found = minimax(z1, m, *kind)
        searched = differential_evolution(
            lambda place, at=(z1, m): peaks(Absorber(*at, *np.exp(place)), *kind).largest,
            [(np.log(m) - 14.0, np.log(m) + 4.0)] * 2, seed=2, vectorized=True,
            updating="deferred", popsize=20, maxiter=150, tol=0.0, polish=False,
        )  # fmt: skip
        assert found.largest * (1.0 - 1e-13) <= searched.fun < found.largest * (1.0 + 1e-8)
