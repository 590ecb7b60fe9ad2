"""Claim: a switched or reversed machine moves as a general integrator and high precision say, and
transients converge where they should: quadrature, slow ramps, damping through critical.
"""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from long_but import long_but
from switching_machines import (
    BOTH,
    ONLY_A,
    REVERSAL,
    SPEED,
    THROUGH_ZERO,
    at_once,
    compressor,
    compressor_loads,
    followed,
    integrate,
    modal_loads,
    motion,
    one_mode,
    transient,
)

from vibecalc.response.switching.follow import slow_energy
from vibecalc.response.switching.motion import Followed, Panels, course_of, march
from vibecalc.response.switching.readings import ENERGY, course_peaks, read
from vibecalc.response.switching.system import (
    ModalSystem,
    SpeedSegment,
    free_motion,
    modal_size,
)


def body_motion(system: ModalSystem, found: Followed, times: np.ndarray) -> np.ndarray:
    """Displacement and velocity (times, 12) in coordinates."""
    place, velocity, *_ = motion(found, times)
    return np.concatenate([place @ system.shape.T, velocity @ system.shape.T], axis=1)


#: damping ratios of the six modes
UNLIKE = np.array([0.3, 1.0, 1.3, 0.05, 5.0, 0.999])


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "profile"),
    [
        pytest.param(0.03, REVERSAL, id="0.03-stand"),
        pytest.param(UNLIKE, THROUGH_ZERO, id="unlike-through zero"),
        pytest.param(0.03, THROUGH_ZERO, id="0.03-through zero"),
        pytest.param(UNLIKE, REVERSAL, id="unlike-stand"),
    ],
)
def test_reversal_agrees_with_a_general_integrator(
    profile: list[SpeedSegment], ratio: float | np.ndarray
) -> None:
    system, loads = compressor(ratio), compressor_loads(6)
    times = np.linspace(0.0, sum(ramp.duration for ramp in profile), 101)[:-1]
    truth = integrate(system, loads, profile, times, angle=0.7, before=BOTH)
    ours = body_motion(system, followed(system, loads, profile, 0.7, BOTH), times)
    largest = np.max(np.abs(truth), axis=0)
    assert np.max(np.abs(ours - truth) / largest) < 1e-9


def test_instant_change_agrees_with_a_general_integrator() -> None:
    system, loads = compressor(), compressor_loads(6)
    profile = [SpeedSegment(0.15, SPEED, SPEED, ONLY_A)]
    times = np.linspace(0.0, 0.15, 151)
    truth = integrate(system, loads, profile, times, angle=2.0, before=BOTH)
    ours = body_motion(system, followed(system, loads, profile, 2.0, BOTH), times)
    assert np.max(np.abs(ours - truth) / np.max(np.abs(truth), axis=0)) < 1e-9
    peaks = at_once(system, loads, BOTH, ONLY_A, 0.15, angle=2.0).peaks.height
    sampled = np.max(np.abs(truth[:, :6]), axis=0)
    assert np.all(peaks.value[:6] >= sampled * (1.0 - 1e-9))
    # samples a thousandth of a second apart miss at most an eighth of (order 2 times .36)^2
    assert np.all(peaks.value[:6] <= 1.07 * sampled)


def exact_chirp(
    frequency: float,
    ratio: float,
    orders: list[int],
    loads: np.ndarray,
    ramp: SpeedSegment,
    angle: float,
) -> tuple[float, float]:
    """State of one mode at the end of a ramp from standstill, by quadrature with 25 digits."""
    with mpmath.workdps(25):
        w, z, end = (mpmath.mpf(x) for x in (frequency, ratio, ramp.duration))
        rate = (mpmath.mpf(ramp.end_speed) - ramp.start_speed) / end
        wave = w * mpmath.sqrt(1 - z**2)

        def force(t: mpmath.mpf) -> mpmath.mpf:
            turned = angle + ramp.start_speed * t + rate * t**2 / 2
            speed = ramp.start_speed + rate * t
            return sum(
                mpmath.re(mpmath.mpc(p) * (speed**2 - 1j * rate / n) * mpmath.expj(n * turned))
                for n, p in zip(orders, loads.tolist(), strict=True)
            )

        def swung(t: mpmath.mpf) -> mpmath.mpc:
            return mpmath.exp(mpmath.mpc(-z * w, wave) * (end - t)) * force(t)

        total = mpmath.quad(swung, mpmath.linspace(0, end, 13))
        place = total.imag / wave
        return float(place), float(total.real - z * w * place)


@pytest.mark.long
@pytest.mark.parametrize(
    "ratio",
    [0.02, 1e-6, 0.7],
)
def test_one_mode_under_a_chirp_agrees_to_its_error(ratio: float) -> None:
    orders, loads = [1, 2, 5], np.array([1.0 + 0.5j, 0.3 - 0.2j, 0.05j])
    system, train = one_mode(80.0, ratio, orders, loads[None])
    ramp = SpeedSegment(0.2, 0.0, 150.0, 0)
    found = followed(system, train, [ramp], 0.3, 0)
    place, speed = exact_chirp(80.0, ratio, orders, loads, ramp, 0.3)
    off = np.hypot(80.0 * (found.state[-1, 0, 0] - place), found.state[-1, 0, 1] - speed)
    assert off <= found.error[0]
    # and the error is no idle caution
    assert found.error[0] < 1e-10 * np.max(modal_size(system, found.state))


@pytest.mark.parametrize("ratio", [0.0, 1e-6, 0.4, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 200.0])
def test_free_motion_agrees_with_the_matrix_exponential(ratio: float) -> None:
    system = ModalSystem(np.eye(1), np.array([7.0]), np.array([ratio]))
    for time in (0.0, 1e-3, 0.4, 3.0):
        with mpmath.workdps(40):
            matrix = mpmath.matrix([[0, 1], [-49, -14 * mpmath.mpf(ratio)]]) * mpmath.mpf(time)
            exact = np.array(mpmath.expm(matrix).tolist(), dtype=float)
        moved = free_motion(system, np.full(2, time), np.eye(2)[:, None])[:, 0].T
        scale = np.array([[1.0, 1.0 / 7.0], [7.0, 1.0]])
        assert np.all(np.abs(moved - exact) <= 2e-14 * scale)


def test_load_at_varying_speed_is_minus_the_momentum_change_of_a_moving_part() -> None:
    """Finite differences of m x(theta(t)), with mpmath, for one part of three orders."""
    loads = np.array([0.4 + 0.1j, -0.2j, 0.03])
    orders = [1, 2, 4]
    ramp = SpeedSegment(0.5, 75.0, 20.0, 0)
    system, train = one_mode(30.0, 0.1, orders, loads[None])
    time = 0.05
    place_, velocity, acceleration, _ = motion(
        followed(system, train, [ramp], 1.1, 0), np.array([time])
    )
    load = acceleration + 6.0 * velocity + 900.0 * place_
    with mpmath.workdps(40):

        def place(t: mpmath.mpf) -> mpmath.mpf:
            turned = mpmath.mpf(1.1) + 75 * t - 55 * t**2
            return sum(
                mpmath.re(mpmath.mpc(p) / n**2 * mpmath.expj(n * turned))
                for n, p in zip(orders, loads.tolist(), strict=True)
            )

        exact = float(-mpmath.diff(place, mpmath.mpf(time), 2))
    assert load[0, 0] == pytest.approx(exact, rel=1e-12)


def test_work_is_energy_gained_and_energy_lost() -> None:
    system, loads = compressor(), compressor_loads(16)
    found = followed(system, loads, REVERSAL, 0.4, BOTH)
    damping = 2.0 * system.damping_ratio * system.frequency
    node, panel = found.panels.node, np.arange(len(found.panels.run))
    place, weight = np.polynomial.legendre.leggauss(8)
    length = np.diff(node)[:, None]
    time = (node[:-1, None] + 0.5 * length * (1.0 + place)).ravel()
    weight = (0.5 * length * weight).ravel()
    moved = found.motion_at(np.repeat(panel, 8), time)
    force = moved[2] + damping * moved[1] + system.frequency**2 * moved[0]
    power = np.sum(force * moved[1], axis=1)
    lost = weight @ np.sum(damping * moved[1] ** 2, axis=1)
    stored = read(system, motion(found, node[[0, -1]]))[0, :, ENERGY]
    exchanged = weight @ np.abs(power)
    assert lost > 0.01 * exchanged
    assert abs(weight @ power - np.diff(stored)[0] - lost) < 1e-12 * exchanged


@pytest.mark.parametrize("points", [2, 3, 4])
def test_quadrature_has_the_order_of_its_points(points: int) -> None:
    """A rule of m points on panels of length h adds up to an error of h^(2 m)."""
    system, modal = compressor(), modal_loads(compressor(), compressor_loads(4))
    ramp = SpeedSegment(0.064, SPEED, SPEED * (1.0 - 0.064 / 0.3), BOTH)
    course = course_of(system, modal, [ramp], 0.4, BOTH)
    course = replace(course, amplitude=modal.amplitude.value)

    def total(count: int, used: int) -> np.ndarray:
        node = np.linspace(0.0, 0.064, count + 1)
        panels = Panels(node, np.zeros(count, dtype=int))
        return march(course, panels, used)[-1, :, 1]

    exact = total(512, 10)
    coarse, fine = (np.max(np.abs(total(count, points) - exact)) for count in (72, 144))
    assert np.log2(coarse / fine) == pytest.approx(2 * points, abs=0.4)


@pytest.mark.long
def test_ever_slower_ramps_approach_the_steady_resonance() -> None:
    """One mode of 5 % damping: what the peak is off vanishes in proportion to haste."""
    system, loads = one_mode(60.0, 0.05, [1], np.array([[1.0]]))
    steady = slow_energy(system, modal_loads(system, loads), 0, 90.0)
    durations = np.array([1.0, 10.0, 100.0, 300.0, 1000.0])
    ratio = 0.05
    # the closed form of |H| w^2 at its peak, W = w / sqrt(1 - 2 zeta^2)
    highest = 1.0 / (2.0 * ratio * np.sqrt(1.0 - ratio**2))
    value = [
        course_peaks(
            followed(system, loads, [SpeedSegment(duration, 0.0, 90.0, 0)], 0.0, 0)
        ).height.value[0]
        for duration in durations.tolist()
    ]
    gap = np.array(value) / highest - 1.0
    assert gap[0] < -0.3 and gap[1] < -0.03
    # The envelope a' = f - (zeta w + i (w - W)) a, to second order in the haste
    # h = W' / (zeta w)^2: the peak comes 2 h half-widths late, by when f, as W^2 / (w + W), has
    # grown by 3 zeta h; the lag costs half of that, and the width of the passage h^2 / 2.
    haste = 90.0 / durations[2:] / (0.05 * 60.0) ** 2
    assert gap[3:] == pytest.approx(1.5 * 0.05 * haste[1:] - 0.5 * haste[1:] ** 2, rel=0.02)
    assert 0.0 < gap[2] < 1.5 * 0.05 * haste[0]
    # with r = W / w: the energy is (r^3 / |1 - r^2 + 2 i zeta r|)^2 w^2 / 2, here by its maximum
    r2 = np.max(np.roots([1.0, -4.0 * (1.0 - 2.0 * ratio**2), 3.0])[-1:].real)
    size = r2**3 / ((1.0 - r2) ** 2 + 4.0 * ratio**2 * r2)
    assert steady.value == pytest.approx(0.5 * size * 60.0**2, rel=1e-11)


@pytest.mark.parametrize("step", long_but([1e-4, 1e-7, 1e-10, 1e-14], 1e-4, 1e-10))
def test_damping_passes_critical_smoothly(step: float) -> None:
    loads = compressor_loads(6)
    profile = [SpeedSegment(0.1, SPEED, 0.2 * SPEED, BOTH), SpeedSegment(0.1, 72.2, 72.2, ONLY_A)]
    profile[1] = profile[1]._replace(
        start_speed=profile[0].end_speed, end_speed=profile[0].end_speed
    )
    below, at, above = (transient(compressor(1.0 + s), loads, profile) for s in (-step, 0.0, step))
    for side in (below, above):
        off = np.abs(side.peaks.height.value / at.peaks.height.value - 1.0)
        assert np.all(off < 3.0 * step + 1e-11)
        assert side.settled.value == pytest.approx(at.settled.value, rel=3.0 * step + 1e-9)


def test_a_ramp_of_no_time_is_an_impulse_of_the_parts_momentum() -> None:
    """Stopping within microseconds: the body takes over m x' of the parts, nothing else."""
    system, loads = compressor(), compressor_loads(12)
    modal = modal_loads(system, loads)
    gap = []
    for duration in (1e-5, 1e-6, 1e-7):
        profile = [SpeedSegment(duration, SPEED, 0.0, BOTH)]
        state = followed(system, loads, profile, 1.0, BOTH).state
        wave = np.exp(1j * modal.orders)[:, None] * modal.amplitude.value[BOTH]
        momentum = np.sum(1j * wave / modal.orders[:, None], axis=0).real * SPEED
        jump = state[-1, :, 1] - state[0, :, 1]
        gap.append(np.max(np.abs(jump - momentum)) / np.max(np.abs(momentum)))
    assert gap[2] < 1e-4
    assert gap[0] / gap[1] == pytest.approx(10.0, rel=0.1)
    assert gap[1] / gap[2] == pytest.approx(10.0, rel=0.1)
