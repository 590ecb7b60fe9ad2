"""Claim: a switched or reversed machine moves as a general integrator and high precision say, and
transients converge where they should: quadrature, slow ramps, damping through critical.
"""

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
    compressor,
    compressor_loads,
    followed,
    integrate,
    one_mode,
)

from vibecalc.response.switching.follow import follow, slow_peaks
from vibecalc.response.switching.instant import instantaneous
from vibecalc.response.switching.motion import (
    ModalMotion,
    Run,
    Segment,
    driven_part,
    follow_profile,
    motion_at,
)
from vibecalc.response.switching.readings import columns, read
from vibecalc.response.switching.system import (
    Loads,
    ModalSystem,
    SpeedSegment,
    modal_loads,
    propagator,
)


def body_motion(
    system: ModalSystem, segments: list[Segment], loads: Loads, times: np.ndarray
) -> np.ndarray:
    """Displacement and velocity (times, 12) in coordinates."""
    modal, result = modal_loads(system, loads), np.empty((len(times), 2 * len(system.shape)))
    for segment in segments:
        begin = segment.run.start
        mine = (times >= begin) & (times <= begin + segment.run.duration)
        moved = motion_at(system, modal, segment, times[mine] - begin)
        parts = [moved.displacement @ system.shape.T, moved.velocity @ system.shape.T]
        result[mine] = np.concatenate(parts, axis=1)
    return result


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
    system, loads = compressor(ratio), compressor_loads(6, rotor=0.004)
    times = np.linspace(0.0, sum(ramp.duration for ramp in profile), 101)[:-1]
    truth = integrate(system, loads, profile, times, angle=0.7, before=BOTH)
    ours = body_motion(system, followed(system, loads, profile, 0.7, BOTH), loads, times)
    largest = np.max(np.abs(truth), axis=0)
    assert np.max(np.abs(ours - truth) / largest) < 1e-9


def test_instant_change_agrees_with_a_general_integrator() -> None:
    system, loads = compressor(), compressor_loads(6)
    profile = [SpeedSegment(0.15, SPEED, SPEED, ONLY_A)]
    times = np.linspace(0.0, 0.15, 151)
    truth = integrate(system, loads, profile, times, angle=2.0, before=BOTH)
    ours = body_motion(system, followed(system, loads, profile, 2.0, BOTH), loads, times)
    assert np.max(np.abs(ours - truth) / np.max(np.abs(truth), axis=0)) < 1e-9
    peaks = instantaneous(system, loads, BOTH, ONLY_A, SPEED, angle=2.0, duration=0.15).peaks
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
    segment = followed(system, train, [ramp], 0.3, 0)[-1]
    place, speed = exact_chirp(80.0, ratio, orders, loads, ramp, 0.3)
    off = np.hypot(80.0 * (segment.state[-1, 0, 0] - place), segment.state[-1, 0, 1] - speed)
    assert off <= segment.error[0]
    # and the error is no idle caution
    assert segment.error[0] < 1e-10 * segment.largest[0]


@pytest.mark.parametrize("ratio", [0.0, 1e-6, 0.4, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.5, 200.0])
def test_free_motion_agrees_with_the_matrix_exponential(ratio: float) -> None:
    system = ModalSystem(np.eye(1), np.array([7.0]), np.array([ratio]))
    for time in (0.0, 1e-3, 0.4, 3.0):
        with mpmath.workdps(40):
            matrix = mpmath.matrix([[0, 1], [-49, -14 * mpmath.mpf(ratio)]]) * mpmath.mpf(time)
            exact = np.array(mpmath.expm(matrix).tolist(), dtype=float)
        moved = [entry[0] for entry in propagator(system, np.asarray(time))]
        scale = np.array([1.0, 1.0 / 7.0, 7.0, 1.0])
        assert np.all(np.abs(np.array(moved) - exact.ravel()) <= 2e-14 * scale)


def test_load_at_varying_speed_is_minus_the_momentum_change_of_a_moving_part() -> None:
    """Finite differences of m x(theta(t)), with mpmath, for one part of three orders."""
    loads = np.array([0.4 + 0.1j, -0.2j, 0.03])
    orders = [1, 2, 4]
    ramp = SpeedSegment(0.5, 20.0, -35.0, 0)
    system, train = one_mode(30.0, 0.1, orders, loads[None])
    segment = followed(system, train, [ramp], 1.1, 0)[0]
    time = 0.05
    motion = motion_at(system, modal_loads(system, train), segment, np.array([time]))
    load = motion.acceleration + 6.0 * motion.velocity + 900.0 * motion.displacement
    with mpmath.workdps(40):

        def place(t: mpmath.mpf) -> mpmath.mpf:
            turned = mpmath.mpf(1.1) + 20 * t - 55 * t**2
            return sum(
                mpmath.re(mpmath.mpc(p) / n**2 * mpmath.expj(n * turned))
                for n, p in zip(orders, loads.tolist(), strict=True)
            )

        exact = float(-mpmath.diff(place, mpmath.mpf(time), 2))
    assert load[0, 0] == pytest.approx(exact, rel=1e-12)


def quadrature(segment: Segment, points: int = 8) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights (any,) over the panels of a segment."""
    place, weight = np.polynomial.legendre.leggauss(points)
    length = np.diff(segment.grid)[:, None]
    time = segment.grid[:-1, None] + 0.5 * length * (1.0 + place)
    return time.ravel(), (0.5 * length * weight).ravel()


def test_work_is_energy_gained_and_energy_lost() -> None:
    system, loads = compressor(), compressor_loads(16, rotor=0.004)
    modal = modal_loads(system, loads)
    segments = followed(system, loads, REVERSAL, 0.4, BOTH)
    damping = 2.0 * system.damping_ratio * system.frequency
    energy = columns().energy

    def stored(segment: Segment, time: float) -> float:
        motion = motion_at(system, modal, segment, np.array([time]))
        return float(read(system, motion).value[0, energy])

    work = lost = exchanged = 0.0
    for segment in segments:
        time, weight = quadrature(segment)
        motion: ModalMotion = motion_at(system, modal, segment, time)
        force = motion.acceleration + damping * motion.velocity
        force = force + system.frequency**2 * motion.displacement
        power = np.sum(force * motion.velocity, axis=1)
        work += weight @ power
        exchanged += weight @ np.abs(power)
        lost += weight @ np.sum(damping * motion.velocity**2, axis=1)
    last = segments[-1]
    gained = stored(last, last.run.duration) - stored(segments[0], 0.0)
    assert lost > 0.01 * exchanged
    assert abs(work - gained - lost) < 1e-12 * exchanged


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


@pytest.mark.long
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
