"""Claim: transients converge where they should: panels, slow ramps, damping through critical."""

import numpy as np
import pytest
from long_but import long_but
from switching_machines import BOTH, ONLY_A, SPEED, compressor, compressor_loads, one_mode

from vibecalc.response.switching.follow import follow, slow_peaks
from vibecalc.response.switching.motion import Run, driven_part, follow_profile
from vibecalc.response.switching.system import SpeedSegment, modal_loads, propagator

RUN = Run(0.0, 0.3, 0.4, SPEED, -SPEED / 0.3, BOTH, 0)


@pytest.mark.parametrize("points", [2, 3, 4])
def test_quadrature_has_the_order_of_its_points(points: int) -> None:
    """A rule of m points on panels of length h adds up to an error of h^(2 m)."""
    system, loads = compressor(), modal_loads(compressor(), compressor_loads(4))
    run = RUN._replace(duration=0.064)

    def total(count: int, used: int) -> np.ndarray:
        grid = np.linspace(0.0, run.duration, count + 1)
        gained = driven_part(system, loads, run, grid[:-1], np.diff(grid), used)
        # each panel's share moves on freely, so that they simply add up
        return np.sum(propagator(system, run.duration - grid[1:])(gained), axis=0)[:, 1]

    exact = total(512, 10)
    coarse, fine = (np.max(np.abs(total(count, points) - exact)) for count in (64, 128))
    assert np.log2(coarse / fine) == pytest.approx(2 * points, abs=0.4)


def test_ever_slower_ramps_approach_the_steady_resonance() -> None:
    """One mode of 5 % damping: what the peak is off vanishes in proportion to haste."""
    system, loads = one_mode(60.0, 0.05, [1], np.array([[1.0]]))
    steady = slow_peaks(system, loads, [SpeedSegment(1.0, 0.0, 90.0, 0)])
    durations = np.array([1.0, 10.0, 100.0, 1000.0, 3000.0])
    value = [
        follow(system, loads, [SpeedSegment(duration, 0.0, 90.0, 0)]).peaks.value[0]
        for duration in durations.tolist()
    ]
    gap = np.array(value) / steady.value[0] - 1.0
    assert gap[0] < -0.3 and gap[1] < -0.03
    # The envelope a' = f - (zeta w + i (w - W)) a, to second order in the haste
    # h = W' / (zeta w)^2: the peak comes 2 h half-widths late, by when f, as W^2 / (w + W), has
    # grown by 3 zeta h; the lag costs half of that, and the width of the passage h^2 / 2.
    haste = 90.0 / durations[2:] / (0.05 * 60.0) ** 2
    assert gap[3:] == pytest.approx(1.5 * 0.05 * haste[1:] - 0.5 * haste[1:] ** 2, rel=0.02)
    assert 0.0 < gap[2] < 1.5 * 0.05 * haste[0]
    # the closed form of |H| w^2 at its peak, W = w / sqrt(1 - 2 zeta^2)
    assert steady.value[0] == pytest.approx(1.0 / (0.1 * np.sqrt(1.0 - 0.05**2)), rel=1e-11)
    assert steady.speed[0] == pytest.approx(60.0 / np.sqrt(1.0 - 2.0 * 0.05**2), rel=1e-4)


@pytest.mark.parametrize("step", long_but([1e-4, 1e-7, 1e-10, 1e-14], 1e-4, 1e-10))
def test_damping_passes_critical_smoothly(step: float) -> None:
    loads = compressor_loads(6)
    profile = [SpeedSegment(0.1, SPEED, 0.2 * SPEED, BOTH), SpeedSegment(0.1, 72.2, 72.2, ONLY_A)]
    profile[1] = profile[1]._replace(
        start_speed=profile[0].end_speed, end_speed=profile[0].end_speed
    )
    below, at, above = (follow(compressor(1.0 + s), loads, profile) for s in (-step, 0.0, step))
    for side in (below, above):
        off = np.abs(side.peaks.value / at.peaks.value - 1.0)
        assert np.all(off < 3.0 * step + 1e-11)
        assert side.settling.time == pytest.approx(at.settling.time, rel=3.0 * step + 1e-9)


def test_a_ramp_of_no_time_is_an_impulse_of_the_parts_momentum() -> None:
    """Stopping within microseconds: the body takes over m x' of the parts, nothing else."""
    system, loads = compressor(), compressor_loads(12)
    modal = modal_loads(system, loads)
    gap = []
    for duration in (1e-5, 1e-6, 1e-7):
        profile = [SpeedSegment(duration, SPEED, 0.0, BOTH)]
        segment = follow_profile(system, modal, profile, angle=1.0, before=BOTH, longest=1.0)[0]
        wave = np.exp(1j * modal.orders)[:, None] * modal.amplitude[BOTH]
        momentum = np.sum(1j * wave / modal.orders[:, None], axis=0).real * SPEED
        jump = segment.state[-1, :, 1] - segment.state[0, :, 1]
        gap.append(np.max(np.abs(jump - momentum)) / np.max(np.abs(momentum)))
    assert gap[2] < 1e-4
    assert gap[0] / gap[1] == pytest.approx(10.0, rel=0.1)
    assert gap[1] / gap[2] == pytest.approx(10.0, rel=0.1)
