"""Claim: a loop is called stable only if it is, and its margins are what they say: the count of
poles against the argument principle, margins by moving the loop to its limit, gain margins
against a dense sweep of the Nyquist curve.
"""

import numpy as np
import pytest
from mpmath import mp, mpc
from roll_control_loops import SOURCE, exact_terms, random_loops, winding

from vibecalc.roll.control.loop import Controller, Loop, feedthrough, loop_of
from vibecalc.roll.control.margins import margins, poles_right, rounding_of, status
from vibecalc.roll.control.poles import poles

COUNT = 60


def loops(seed: int, late: bool) -> Loop:
    return loop_of(*random_loops(seed, COUNT, late))


def one(loop: Loop, place: int) -> Loop:
    return Loop(*(a[place : place + 1] for a in loop))


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_count_is_that_of_the_argument_principle(seed, late):
    loop = loops(seed, late)
    right, kind = poles_right(loop), status(loop)
    checked, seen = 0, set()
    for place in range(COUNT):
        if loop.p2[place] == 0.0 and abs(loop.q1[place]) >= 0.9 * abs(loop.p1[place]):
            assert not late or np.isinf(right[place]) or abs(feedthrough(loop)[place]) < 1.0
            continue
        assert right[place] == winding(loop, place)
        assert (kind[place] <= 1) == (right[place] == 0)
        checked, seen = checked + 1, seen | {int(right[place])}
    assert checked > 40 and len(seen) > 2


@pytest.mark.parametrize("late", [False, True])
def test_at_the_delay_margin_a_pole_is_on_the_axis(late):
    loop = loops(5, late)
    found = margins(loop)
    chosen = found.stable & np.isfinite(found.delay.value) & (found.delay.value > 0.0)
    assert np.sum(chosen) > 10
    s = 1j * found.delay_frequency[chosen]
    moved = Loop(*(a[chosen] for a in loop))
    moved = moved._replace(delay=moved.delay + found.delay.value[chosen])
    rest = (moved.p2 * s + moved.p1) * s + moved.p0
    rest = rest + (moved.q1 * s + moved.q0) * np.exp(-s * moved.delay)
    size = rounding_of(moved, s[:, None])[:, 0]
    assert np.all(np.abs(rest) <= 1e4 * size)
    held = Loop(*(a[chosen] for a in loop))
    for factor, right in ((0.999, 0.0), (1.001, 2.0)):
        near = held._replace(delay=held.delay + factor * found.delay.value[chosen])
        np.testing.assert_array_equal(poles_right(near), right)


@pytest.mark.parametrize("late", [False, True])
def test_at_the_gain_margins_the_loop_reaches_its_limit(late):
    loop = loops(6, late)
    found = margins(loop)
    for value, inward, outward in (
        (found.gain.value, 0.999, 1.001), (found.gain_lower.value, 1.001, 0.999)
    ):  # fmt: skip
        chosen = found.stable & np.isfinite(value) & (value > 0.0)
        held = Loop(*(a[chosen] for a in loop))
        for factor, stable in ((inward, True), (outward, False)):
            scale = factor * value[chosen]
            near = held._replace(q1=scale * held.q1, q0=scale * held.q0)
            np.testing.assert_array_equal(status(near) <= 1, stable)
    free = found.stable & np.isinf(found.gain.value)
    many = Loop(*(a[free] for a in loop))
    for scale in (3.0, 1e3, 1e6):
        assert np.all(status(many._replace(q1=scale * many.q1, q0=scale * many.q0)) <= 1)


def test_errors_of_margins_hold_against_fifty_digits():
    loop = loops(8, late=True)
    found = margins(loop)
    mp.dps = 50
    checked = 0
    for place in np.flatnonzero(found.stable):
        if np.isfinite(found.gain_frequency[place]):
            start = mp.mpf(float(found.gain_frequency[place]))

            def imaginary(w, k=place):
                direct, back = exact_terms(loop, k, mpc(0, w))
                return mp.im(back / direct)

            w = mp.findroot(imaginary, start)
            direct, back = exact_terms(loop, place, mpc(0, w))
            miss = abs(float(abs(direct / back) - found.gain.value[place]))
            assert miss <= found.gain.error[place] <= 1e-6 * found.gain.value[place]
            checked += 1
        if np.isfinite(found.delay_frequency[place]):

            def unity(w, k=place):
                direct, back = exact_terms(loop, k, mpc(0, w))
                return abs(back) ** 2 - abs(direct) ** 2

            w = mp.findroot(unity, mp.mpf(float(found.delay_frequency[place])))
            direct, back = exact_terms(loop, place, mpc(0, w))
            lag = mp.arg(-back / direct)
            delay = (lag if lag >= 0 else lag + 2 * mp.pi) / w
            miss = abs(float(delay - found.delay.value[place]))
            assert miss <= found.delay.error[place] <= 1e-6 * (1e-3 + found.delay.value[place])
    assert checked > 10


def test_a_loop_on_its_limit_is_not_called_stable():
    """Poles exactly on the axis, with and without a delay, and one at zero."""
    plain = Controller(1.0, 0.0, 0.0)
    held = loop_of(SOURCE, plain._replace(speed_feedback=-1.0))
    assert status(held) == 2
    cut = float(SOURCE.inertia) / (10.0 * 203.4 * float(SOURCE.ratio))
    cancelled = loop_of(SOURCE, Controller(10.0, 0.9, cut))
    assert status(cancelled) == 2
    late = loop_of(SOURCE, Controller(10.0, 0.9, 0.0, 1e-3, 1e-4))
    further = late._replace(delay=late.delay + margins(late).delay.value)
    assert status(further) == 2 and not margins(further).stable


def test_a_pole_that_any_lag_throws_over_does_not_count_as_stable():
    """Rotor inertia and stiffness both turned negative: one pole on the left, on paper only."""
    odd = Controller(10.0, -0.5, 1.0)
    bare = loop_of(SOURCE, odd)
    assert poles(bare).value.real < 0.0
    assert status(bare) == 4
    assert poles_right(loop_of(SOURCE, odd._replace(lag=1e-9))) > 0
