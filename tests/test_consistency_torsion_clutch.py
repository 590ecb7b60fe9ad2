"""Claim: a clutch takes a part of a line along as closed forms and another integrator say."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.line import Line, chain, damping_matrix, stiffness_matrix
from vibecalc.torsion.transient.clutch import OPEN, Clutch, Engagement, engage
from vibecalc.torsion.transient.motion import Stretch, stretch

CYCLE = 4.0 * np.pi
ORDER = np.array([0.0, 1.0, 3.0])


def still(n: int) -> Stretch:
    return stretch(1.0, 0.0, np.zeros((n, 3), dtype=complex))


def engaged(line: Line, clutch: Clutch, part: Stretch, after: float, speed: float = 100.0):
    return engage(line, ORDER, clutch, lambda _: part, speed, 0.05, after, CYCLE)


@pytest.mark.parametrize(
    ("driven_speed", "reversed_"), [(20.0, False), (150.0, False), (0.0, True)]
)
def test_two_rigid_parts(driven_speed: float, reversed_: bool) -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4e6]))
    if reversed_:
        line = line._replace(first=line.second, second=line.first)
    clutch = Clutch(0, 70.0, 0.0, np.array([False, True]), driven_speed)
    found = engaged(line, clutch, still(2), 3.0)
    gap, reduced = abs(100.0 - driven_speed), 6.0 / 5.0
    assert found.heat == pytest.approx(0.5 * reduced * gap**2, rel=1e-9)
    assert abs(found.heat - 0.5 * reduced * gap**2) <= found.heat_error
    assert found.slip_time == pytest.approx(gap * reduced / 70.0, rel=1e-9)
    assert found.common_speed == pytest.approx((200.0 + 3.0 * driven_speed) / 5.0, rel=1e-12)
    assert found.engagements == 1
    assert found.run.course.speed[-1] == pytest.approx(found.common_speed, rel=1e-12)
    # nothing is left that turns the line as a whole against the mean motion of the crank
    relative = found.run.states[-1][-1][1:3] / np.sqrt(line.inertia)
    assert abs(line.inertia @ relative) < 1e-7


def test_a_friction_torque_that_grows() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4e6]))
    # dw = growth t^2 / 2 / reduced before it is full
    clutch = Clutch(0, 700.0, 5.0, np.array([False, True]), 20.0)
    found = engaged(line, clutch, still(2), 3.0)
    expected = np.sqrt(2.0 * 80.0 * 1.2 / 140.0)
    assert found.slip_time == pytest.approx(expected, rel=1e-6)
    assert found.heat == pytest.approx(0.5 * 1.2 * 80.0**2, rel=1e-6)
    assert found.slip[0] == OPEN


def test_absolute_damping_is_against_the_own_mean_motion_of_each_part() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4e6]))
    line = line._replace(absolute_damping=np.array([0.0, 8.0]))
    clutch = Clutch(0, 700.0, 5.0, np.array([False, True]), 20.0)
    found = engaged(line, clutch, still(2), 3.0)
    assert found.slip_time == pytest.approx(np.sqrt(2.0 * 80.0 * 1.2 / 140.0), rel=1e-6)
    assert found.heat == pytest.approx(0.5 * 1.2 * 80.0**2, rel=1e-6)


def test_a_clutch_that_never_holds() -> None:
    line = chain(np.array([2.0, 3.0]), np.array([4e6]))
    found = engaged(line, Clutch(0, 7.0, 0.0, np.array([False, True]), 20.0), still(2), 0.5)
    assert not np.isfinite(found.held)
    assert found.slip_time == pytest.approx(0.5, rel=1e-12)
    assert found.engagements == 0


def test_a_clutch_that_judders_for_ever_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibecalc.torsion.transient.clutch.MOST_CHANGES", 20)
    part = still(2)
    gas = part.gas.copy()
    gas[0, 2] = 5000.0
    line = chain(np.array([2.0, 3.0]), np.array([1e5]))
    clutch = Clutch(0, 50.0, 0.0, np.array([False, True]), 100.0)
    with pytest.raises(NumericalFailure, match="changes between slipping and holding more than"):
        engaged(line, clutch, part._replace(gas=gas, gas_end=gas), 20.0)


def simulated(
    line: Line, clutch: Clutch, gas: np.ndarray, speed: float, found: Engagement, before: float
) -> tuple[float, list[float], np.ndarray, np.ndarray]:
    """Heat, times at which the plates change, last velocities and section torques.

    Absolute angles and velocities, the crank's motion as prescribed in the run, friction as a law
    with an event at each change; by an integrator of its own.
    """
    n, own = line.inertia.size, clutch.element
    a, b = int(line.first[own]), int(line.second[own])
    k, c = float(line.stiffness[own]), float(line.damping[own])
    rest = line._replace(
        stiffness=np.where(np.arange(n - 1) == own, 0.0, line.stiffness),
        damping=np.where(np.arange(n - 1) == own, 0.0, line.damping),
        absolute_damping=np.zeros(n),
    )
    stiffness, damping = stiffness_matrix(rest), damping_matrix(rest)
    borders, parts = found.run.course, found.run.course.parts

    def friction(t: float) -> float:
        share = 1.0 if clutch.engaging_time == 0.0 else (t - before) / clutch.engaging_time
        return clutch.friction_torque * float(np.clip(share, 0.0, 1.0))

    def crank(t: float) -> float:
        number = int(np.clip(np.searchsorted(borders.time, t, "right") - 1, 0, len(parts) - 1))
        since, part = t - float(borders.time[number]), parts[number]
        turned = (part.acceleration + part.acceleration_rate * since / 3.0) * since / 2.0
        return float(borders.angle[number]) + (float(borders.speed[number]) + turned) * since

    def spring_rate(t: float, y: np.ndarray, slip: int) -> float:
        relative = y[n + a] - y[n + b]
        if slip == 0:
            return relative
        if c > 0.0:
            return ((0.0 if slip == OPEN else slip * friction(t)) - k * y[2 * n]) / c
        grows = 0.0 < t - before < clutch.engaging_time
        return slip * clutch.friction_torque / clutch.engaging_time / k if grows else 0.0

    def rates(t: float, y: np.ndarray, slip: int) -> np.ndarray:
        spring = spring_rate(t, y, slip)
        torque = k * y[2 * n] + c * spring if slip == 0 else slip * friction(t)
        if slip == OPEN:
            torque = 0.0
        force = (gas * np.exp(1j * ORDER * crank(t))).real.sum(axis=1)
        force = force - stiffness @ y[:n] - damping @ y[n : 2 * n]
        force[a] -= torque
        force[b] += torque
        heat = torque * (y[n + a] - y[n + b] - spring) if slip in (1, -1) else 0.0
        return np.concatenate([y[n : 2 * n], force / line.inertia, [spring, heat]])

    # the steady vibration of both parts, each turning at its speed
    w = ORDER[1:] * speed
    angle = np.zeros(n, dtype=complex)
    velocity = np.where(clutch.driven, clutch.driven_speed, speed).astype(complex)
    for frequency, load in zip(w, gas.T[1:], strict=True):
        matrix = stiffness + 1j * frequency * damping - frequency**2 * np.diag(line.inertia)
        one = np.linalg.solve(matrix, load)
        angle, velocity = angle + one, velocity + 1j * frequency * one
    y = np.concatenate([angle.real, velocity.real, [0.0, 0.0]])
    heat, changes = 0.0, []
    time, end, slip = 0.0, float(borders.time[-1]), OPEN
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
    # where the prescribed motion has a corner, but for those where the plates change
    kept = np.flatnonzero(np.diff(found.slip) == 0) + 1
    marks = [before, before + clutch.engaging_time, *borders.time[kept].tolist(), end]
    while time < end - 1e-12:
        stop = min(one for one in marks if one > time + 1e-10)

        def event(t: float, y: np.ndarray, slip: int = slip) -> float:
            if slip in (1, -1):
                return slip * (y[n + a] - y[n + b] - spring_rate(t, y, slip))
            if slip == 0:
                return friction(t) - abs(k * y[2 * n] + c * (y[n + a] - y[n + b]))
            return 1.0

        event.terminal, event.direction = True, -1.0
        # an event at the begin is the last one again
        nudge = min(1e-7, 0.5 * (stop - time))
        first = solve_ivp(rates, (time, time + nudge), y, args=(slip,), **options)
        rest_of = solve_ivp(
            lambda t, y, slip=slip: rates(t, y, slip), (time + nudge, stop), first.y[:, -1],
            events=event, **options,
        )  # fmt: skip
        y, time = rest_of.y[:, -1], float(rest_of.t[-1])
        heat += y[-1]
        y[-1] = 0.0
        if rest_of.status == 1:
            changes.append(time)
            slip = 0 if slip else int(np.sign(k * y[2 * n] + c * (y[n + a] - y[n + b])))
        elif slip == OPEN and time >= before - 1e-12:
            slip = int(np.sign(y[n + a] - y[n + b]))
            if c == 0.0:
                y[2 * n] = slip * friction(time) / k
    torque = line.stiffness * (y[line.first] - y[line.second]) + line.damping * (
        y[n + line.first] - y[n + line.second]
    )
    spring = spring_rate(time, y, slip)
    torque[own] = k * y[2 * n] + c * spring
    return heat, changes, y[n : 2 * n], torque


@pytest.mark.long
@pytest.mark.parametrize(
    ("damping", "friction", "engaging", "after", "engagements"),
    [
        (2.0, 120.0, 0.0, 0.7, 4),
        (0.0, 120.0, 0.3, 0.7, 2),
        (3.0, 40.0, 0.1, 1.5, 3),
    ],
)
def test_a_line_with_vibration(
    damping: float, friction: float, engaging: float, after: float, engagements: int
) -> None:
    line = chain(np.array([1.0, 0.8, 2.0, 1.5]), np.array([9000.0, 5000.0, 7000.0]))._replace(
        damping=np.array([3.0, damping, 2.0])
    )
    gas = np.zeros((4, 3), dtype=complex)
    gas[0, 1:] = 60.0 - 20.0j, 90.0 + 30.0j
    part = stretch(1.0, 0.0, gas)
    speed, before = 40.0, 0.05
    clutch = Clutch(1, friction, engaging, np.array([False, False, True, True]), 5.0)
    found = engaged(line, clutch, part, after, speed)
    heat, changes, velocity, torque = simulated(line, clutch, gas, speed, found, before)
    assert found.heat == pytest.approx(heat, rel=1e-7)
    assert found.held == pytest.approx(changes[0], rel=1e-8)
    assert found.engagements == (len(changes) + 1) // 2
    assert found.engagements >= engagements
    last = found.run.states[-1][-1]
    seen = found.run.drive.systems[-1].torque @ last
    np.testing.assert_allclose(seen, torque, atol=1e-6 * np.abs(torque).max())
    own = last[-6:-2] / np.sqrt(line.inertia) + found.run.course.speed[-1]
    np.testing.assert_allclose(own, velocity, atol=1e-7 * speed)


def test_momentum_and_energy() -> None:
    # undamped parts at rest in themselves: the energy that goes is the heat of the plates
    line = chain(np.array([1.0, 0.8, 2.0, 1.5]), np.array([9000.0, 5000.0, 7000.0]))
    clutch = Clutch(1, 30.0, 0.0, np.array([False, False, True, True]), 5.0)
    found = engaged(line, clutch, still(4), 2.0, 40.0)
    last = found.run.states[-1][-1]
    velocity = last[-6:-2] / np.sqrt(line.inertia) + found.run.course.speed[-1]
    begin = np.array([40.0, 40.0, 5.0, 5.0])
    assert line.inertia @ velocity == pytest.approx(line.inertia @ begin, rel=1e-10)
    lost = 0.5 * line.inertia @ (begin**2 - velocity**2)
    # a spring that is wound up by the friction torque at once takes its energy from nowhere
    wound = 0.5 * 30.0**2 / 5000.0
    stored = 0.5 * float(last[:3] @ last[:3])
    assert found.heat == pytest.approx(lost + wound - stored, rel=1e-9)
