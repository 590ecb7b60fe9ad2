"""Claim: a switched or reversed machine moves as quadrature and high precision say, through
critical damping too; its peaks and settling are those of a plain search.
"""

import mpmath
import numpy as np
import pytest
from switching_machines import (
    BOTH,
    ONLY_A,
    REVERSAL,
    SPEED,
    at_once,
    compressor,
    compressor_loads,
    followed,
    modal_loads,
    motion,
    one_mode,
)

from vibecalc.response.switching.follow import passages
from vibecalc.response.switching.readings import ENERGY, read, steady_peaks
from vibecalc.response.switching.system import ModalSystem, SpeedSegment, free_motion, modal_size


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


# ----------------------------------------------------------------------------
# Peaks, settling and passages are those that a plain search finds.
# ----------------------------------------------------------------------------


def test_final_peaks_and_settling_are_those_of_the_motion_itself() -> None:
    system, loads = compressor(), compressor_loads(16)
    done = at_once(system, loads, BOTH, ONLY_A, 1.5, angle=1.0)
    profile = [SpeedSegment(1.5, SPEED, SPEED, ONLY_A)]
    time = np.linspace(0.0, 1.5, 30001)
    moved, final = (
        motion(followed(system, loads, profile, 1.0, first), time) for first in (BOTH, ONLY_A)
    )
    deviation = np.sqrt(read(system, moved - final)[0, :, ENERGY])
    top = np.sqrt(np.max(read(system, final)[0, :, ENERGY]))
    steady = steady_peaks(system, modal_loads(system, loads), ONLY_A, SPEED)
    assert top**2 == pytest.approx(steady.value[ENERGY], rel=1e-5)
    below = time[np.argmax(deviation <= 0.05 * top)]
    assert 0.0 <= below - done.settled.value + 1e-12 <= 1.5 / 30000
    assert np.all(np.diff(deviation) <= 1e-12 * top)


def test_passages_are_where_an_order_turns_as_fast_as_a_mode() -> None:
    system, loads = compressor(), compressor_loads(12)
    found = passages(system, modal_loads(system, loads), REVERSAL)
    starts = np.cumsum([0.0, *(piece.duration for piece in REVERSAL)])
    segment = np.searchsorted(starts, found.time, side="right") - 1
    gain = np.array([(p.end_speed - p.start_speed) / p.duration for p in REVERSAL])[segment]
    first = np.array([piece.start_speed for piece in REVERSAL])[segment]
    assert first + gain * (found.time - starts[segment]) == pytest.approx(found.speed, rel=1e-12)
    met = system.frequency[found.mode - 1]
    assert found.order * np.abs(found.speed) == pytest.approx(met)
    # six modes, order 1 and the even ones, down with two pistons and up with one
    assert sorted(set(zip(found.order.tolist(), segment.tolist(), strict=True))) == sorted(
        (n, segment) for n in (1, 2, 4, 6, 8, 10, 12) for segment in (0, 2)
    )
    top = int(np.argmax(found.energy))
    shape, frequency = system.shape[:, found.mode[top] - 1], met[top]
    force = np.asarray(loads.per_speed_squared)[ONLY_A, found.order[top] - 1] @ shape
    amplitude = abs(force) * found.speed[top] ** 2 / (0.06 * frequency**2)
    assert found.energy[top] == pytest.approx(0.5 * (frequency * amplitude) ** 2, rel=1e-9)
