"""The isolation models agree with each other, with exact algebra and with time integration."""

import mpmath
import numpy as np
import pytest
from isolation_machines import (
    LEVER,
    ORDERS,
    SPEED,
    Body,
    couple_readout,
    gibson,
    gibson_body,
    gibson_couple,
    gibson_supports,
    join,
    random_body,
    shows,
)
from scipy.integrate import solve_ivp

from vibecalc.isolation.pitch import (
    angle_harmonics,
    lever_force,
    pitch_resonances,
    pitch_static,
    support_displacement,
    support_force,
    support_share,
    transmissibility,
    transmitted_couple,
)
from vibecalc.isolation.rigid_body import (
    displacement,
    mount_force,
    mount_readout,
    static_deflection,
)
from vibecalc.isolation.rows import HarmonicsAt, body_rows, pitch_rows
from vibecalc.isolation.run_up import RunUpPeak, cycle_peaks, run_up, run_up_peak
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.parts.matrices import displacement_at
from vibecalc.response.forced import dynamics, response
from vibecalc.response.modal_damping import body_resonances
from vibecalc.response.modes import modes

ALL_ROWS = np.ones((1, 5), dtype=bool)


def six(couple: Bounded) -> Bounded:
    """A couple about y as forces (orders, 6)."""
    value = np.zeros((len(couple.value), 6), dtype=complex)
    error = np.zeros(value.shape)
    value[:, 4], error[:, 4] = couple.value, couple.error
    return Bounded(value, error)


def gibson_rows(damping: float = 50.0) -> HarmonicsAt:
    return pitch_rows(*gibson(damping), ORDERS, gibson_couple())


def gibson_run_up(damping: float, start: float = 0.0, stop: float = SPEED) -> RunUpPeak:
    resonances = pitch_resonances(gibson(damping)[0], gibson_couple())
    return run_up(gibson_rows(damping), ORDERS, resonances, start, stop, ALL_ROWS).peak


def body_run_up(body: Body, load: Bounded, orders: np.ndarray, stop: float) -> RunUpPeak:
    readout = mount_readout(*body.mounts)
    shapes = modes(body.matrices)
    seen = shows(readout, shapes.shape, shapes.natural_frequency)
    rows = body_rows(body.matrices, readout, orders, load)
    resonances = body_resonances(body.matrices, shapes, load)
    whole = run_up(rows, orders, resonances, 0.0, stop, seen)
    alone = run_up_peak(rows, orders, resonances, 0.0, stop, seen)
    assert whole.unresolved == 0
    assert alone.value == pytest.approx(whole.peak.value, rel=1e-11)
    assert alone.speed == pytest.approx(whole.peak.speed, rel=1e-9)
    return whole.peak


def test_transmitted_couple_is_transmissibility_times_couple() -> None:
    pitch, _ = gibson()
    couple, rate = gibson_couple(), ORDERS * SPEED
    angle = angle_harmonics(pitch, couple, rate)
    through = transmitted_couple(pitch, angle, rate)
    expected = transmissibility(pitch, rate).value * couple.value
    assert through.value == pytest.approx(expected, rel=1e-14)


def test_supports_of_the_pitch_model_hold_the_transmitted_couple() -> None:
    pitch, _ = gibson()
    x, k, c, h = gibson_supports()
    couple, rate = gibson_couple(), ORDERS * SPEED
    angle = angle_harmonics(pitch, couple, rate)
    force = support_force(support_displacement(angle, x), rate, k, c, h)
    through = transmitted_couple(pitch, angle, rate)
    # a force f along z at x has the couple -x f about y
    assert -x @ force.value == pytest.approx(through.value, rel=1e-14)
    assert float(-x @ support_share(x, k)) == pytest.approx(1.0, rel=1e-15)
    over_lever = lever_force(through, LEVER)
    assert np.abs(over_lever.value) == pytest.approx(4.0 * np.abs(force.value[0]), rel=1e-14)


def test_pitch_model_equals_rigid_body_on_the_source_machine() -> None:
    body, couple = gibson_body(), gibson_couple()
    readout = join(couple_readout(body.matrices, 4, LEVER), mount_readout(*body.mounts))
    speed = np.array([3.0, 15.9, 31.7, 200.0, SPEED])
    six_freedoms = body_rows(body.matrices, readout, ORDERS, six(couple))(speed, True, True)
    one_freedom = gibson_rows()(speed, True, True)
    assert six_freedoms.value[:, 0, 0] == pytest.approx(one_freedom.value[:, 0, 0], rel=1e-12)
    for name in ("value", "slope", "curvature"):
        whole, pitch = getattr(six_freedoms, name), getattr(one_freedom, name)
        assert whole[:, 1:, 2] == pytest.approx(pitch[:, 1:, 0], rel=1e-11)
    sideways = np.abs(six_freedoms.value[:, 1:, :2])
    assert np.all(sideways <= six_freedoms.error[:, 1:, :2])


def test_run_up_of_the_rigid_body_equals_that_of_the_pitch_model() -> None:
    peak = body_run_up(gibson_body(), six(gibson_couple()), ORDERS, SPEED)
    pitch = gibson_run_up(50.0)
    assert peak.value == pytest.approx(pitch.value[1:], rel=1e-12)
    assert peak.speed == pytest.approx(pitch.speed[1:], rel=1e-11)


def test_blocks_of_speeds_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    body, load = random_body(5), six(gibson_couple())
    whole = body_run_up(body, load, ORDERS, SPEED)
    curve = cycle_peaks(gibson_rows(), ORDERS, np.linspace(1.0, SPEED, 500))
    monkeypatch.setattr("vibecalc.isolation.run_up.MOST_AT_ONCE", 40)
    parts = body_run_up(body, load, ORDERS, SPEED)
    assert parts.value == pytest.approx(whole.value, rel=1e-12)
    assert parts.speed == pytest.approx(whole.speed, rel=1e-11)
    pieces = cycle_peaks(gibson_rows(), ORDERS, np.linspace(1.0, SPEED, 500))
    assert pieces.value == pytest.approx(curve.value, rel=1e-13)
    assert pieces.error.shape == curve.error.shape


def test_steady_state_equals_the_run_up_at_operating_speed() -> None:
    pitch, _ = gibson()
    couple, rate = gibson_couple(), ORDERS * SPEED
    passing = transmissibility(pitch, rate).value * couple.value * SPEED**2 / LEVER
    here = cycle_peaks(gibson_rows(), ORDERS, np.array([SPEED]))
    assert here.value[0, 0] == pytest.approx(float(cycle_peak(passing, ORDERS).value), rel=1e-13)
    body = random_body(3)
    load = Bounded(np.array([[1.0, 2j, 3.0, -1j, 0.5, 1.0]]), np.zeros((1, 6)))
    speed, order = 50.0, np.array([2])
    system = dynamics(body.matrices, order * speed)
    motion = response(system, load.value * speed**2, load.error)
    force = mount_force(displacement(motion, body.mounts.position), order * speed, *body.mounts[1:])
    rows = body_rows(body.matrices, mount_readout(*body.mounts), order, load)
    assert rows(np.array([speed])).value[0] == pytest.approx(force.value, rel=1e-11)


@pytest.mark.parametrize("seed", range(6))
def test_modal_superposition_equals_direct_solution(seed: int) -> None:
    """With C = a K and H = b K each mode is an oscillator of its own."""
    body = random_body(seed, proportional=True)
    shapes = modes(body.matrices)
    frequency = shapes.natural_frequency[:, None] * np.array([0.3, 1.0, 2.5])
    frequency = frequency.ravel()
    force = np.random.default_rng(seed).normal(size=(len(frequency), 6)) + 0j
    direct = response(dynamics(body.matrices, frequency), force, 0.0 * np.abs(force))
    stiffness = shapes.eigenvalue * (1.0 + 1j * (0.05 + 1e-3 * frequency[:, None]))
    modal = (force @ shapes.shape) / (stiffness - np.square(frequency)[:, None])
    superposed = modal @ shapes.shape.T
    scale = np.sqrt(np.diagonal(body.mass_matrix))
    off = np.max(np.abs(direct.value - superposed) * scale, axis=1)
    assert np.all(off <= 1e-10 * np.max(np.abs(direct.value) * scale, axis=1))


def test_time_integration_returns_to_the_steady_state_after_a_cycle() -> None:
    body = random_body(11)
    matrices = body.matrices
    shapes = modes(matrices)
    speed = 0.8 * float(shapes.natural_frequency[2])
    force = np.random.default_rng(5).normal(size=(2, 6)) + 0.5j
    still = matrices._replace(structural=0.0 * matrices.structural)
    motion = response(dynamics(still, ORDERS * speed), force, 0.0 * np.abs(force))
    # in unit-mass coordinates, so that metres and radians weigh alike in the step control
    inverse = np.linalg.inv(matrices.mass)

    def at(time: float, amplitude: np.ndarray) -> np.ndarray:
        wave = np.exp(1j * ORDERS * speed * time)[:, None]
        return np.asarray((amplitude * wave).sum(axis=0).real)

    def rate(time: float, state: np.ndarray) -> np.ndarray:
        place, velocity = state[:6], state[6:]
        push = at(time, force) - matrices.stiffness @ place - matrices.damping @ velocity
        return np.concatenate([velocity, inverse @ push])

    velocity = 1j * (ORDERS * speed)[:, None] * motion.value
    begin = np.concatenate([at(0.0, motion.value), at(0.0, velocity)])
    cycle = 2.0 * np.pi / speed
    times = np.linspace(0.0, cycle, 9)
    scale = float(np.max(np.abs(begin)))
    solved = solve_ivp(rate, (0.0, cycle), begin, "DOP853", times, rtol=1e-11, atol=1e-13 * scale)
    expected = np.array([at(time, motion.value) for time in times]).T
    assert solved.y[:6] == pytest.approx(expected, abs=1e-8 * float(np.max(np.abs(expected))))


def test_static_deflection_of_both_models_agrees() -> None:
    body = gibson_body()
    x, k, _, _ = gibson_supports()
    weight = body.mass * 9.80665
    for shift in (0.0, 0.07):
        centre, up = np.array([shift, 0.0, 0.1]), np.array([0.0, 0.0, 1.0])
        whole = static_deflection(
            body.matrices, body.mounts.position, body.mounts.stiffness, body.mass, centre, 9.80665,
            up,
        )  # fmt: skip
        pitch = pitch_static(weight, shift, x, k)
        assert whole.sag == pytest.approx(pitch.sag, rel=1e-12)
        assert whole.share == pytest.approx(pitch.share, rel=1e-12)


@pytest.mark.parametrize(
    ("damping", "count"),
    [
        (50.0 * 1.26e-3, 20_000),
        (2.0, 20_000),
        *(pytest.param(damping, 60_000, marks=pytest.mark.long) for damping in (50.0, 400.0)),
    ],
)
def test_run_up_maximum_holds_against_a_dense_sweep(damping: float, count: int) -> None:
    """The sweep never lies above the maximum, nor farther below than its own spacing allows."""
    peak = gibson_run_up(damping)
    around = peak.speed[0] * (1.0 + np.linspace(-1e-3, 1e-3, 20_001))
    sweep = np.concatenate([np.linspace(0.0, SPEED, count), around])
    sweep = sweep[sweep <= SPEED]
    rows = gibson_rows(damping)
    blocks = [cycle_peak(rows(part).value[:, 0, 0], ORDERS) for part in np.array_split(sweep, 20)]
    value = np.concatenate([block.value for block in blocks])
    best = int(np.argmax(value))
    assert value[best] <= peak.value[0] * (1.0 + 1e-13) + peak.error[0]
    assert value[best] == pytest.approx(peak.value[0], rel=3e-6)
    assert sweep[best] == pytest.approx(peak.speed[0], rel=1e-3)


def test_second_order_resonance_at_half_speed_is_found_without_the_first() -> None:
    """With a range that ends below w0 the maximum is the second order at w0 / 2, however narrow."""
    couple = gibson_couple()
    for damping in (10.0, 0.063, 1e-5):
        pitch, _ = gibson(damping)
        peak = gibson_run_up(damping, stop=20.0)
        assert peak.speed[0] == pytest.approx(float(pitch.natural_frequency) / 2.0, rel=0.02)
        resonant = np.abs(couple.value[1]) * (pitch.natural_frequency / 2.0) ** 2 / LEVER
        resonant = resonant / (2.0 * pitch.damping_ratio)
        assert peak.value[0] == pytest.approx(
            float(resonant), rel=0.5 * float(damping > 1.0) + 1e-3
        )


@pytest.mark.parametrize("damping", [50.0, 50.0 * 1.26e-3])
def test_run_up_maximum_agrees_with_fifty_digits(damping: float) -> None:
    """Stationarity in speed and angle solved by mpmath from the same data."""
    peak = gibson_run_up(damping)
    x, k, c, _ = gibson_supports(damping)
    couple = gibson_couple().value
    with mpmath.workdps(50):
        inertia = mpmath.mpf(float(gibson(damping)[0].inertia))
        total = [
            mpmath.fsum(mpmath.mpf(float(v)) * float(p) ** 2 for v, p in zip(w, x, strict=True))
            for w in (k, c)
        ]

        def force(speed: mpmath.mpf, angle: mpmath.mpf) -> mpmath.mpf:
            value = mpmath.mpf(0)
            for order, moment in zip((1, 2), couple, strict=True):
                rate = order * speed
                passing = total[0] + mpmath.mpc(0, 1) * rate * total[1]
                gain = passing / (passing - rate**2 * inertia)
                wave = mpmath.exp(mpmath.mpc(0, 1) * order * angle)
                value += mpmath.re(mpmath.mpc(moment) * speed**2 * gain * wave)
            return value / mpmath.mpf(LEVER)

        speed, harmonics = float(peak.speed[0]), gibson_rows(damping)(peak.speed[:1]).value[0, 0, 0]
        angle = float(cycle_peak(harmonics, ORDERS).angle)
        slopes = (
            lambda v, a: mpmath.diff(force, (v, a), (1, 0)),
            lambda v, a: mpmath.diff(force, (v, a), (0, 1)),
        )
        found = mpmath.findroot(slopes, (speed, angle), tol=1e-60, verify=False)
        value = abs(force(found[0], found[1]))
        assert abs(value - float(peak.value[0])) <= peak.error[0]
        assert abs(found[0] - speed) <= peak.speed_error[0]
        assert peak.error[0] <= 1e-9 * peak.value[0]


@pytest.mark.parametrize("seed", range(2))
def test_run_up_of_random_bodies_holds_against_dense_sweeps(seed: int) -> None:
    body = random_body(seed)
    orders = np.array([1, 2, 4])
    generator = np.random.default_rng(seed)
    value = generator.normal(size=(3, 6)) * np.array([[1.0], [0.3], [0.05]]) + 0j
    load = Bounded(value, ORDERS[0] * 1e-16 * np.abs(value))
    stop = 3.0 * float(modes(body.matrices).natural_frequency[-1])
    peak = body_run_up(body, load, orders, stop)
    rows = body_rows(body.matrices, mount_readout(*body.mounts), orders, load)
    near = [v * (1.0 + np.linspace(-0.01, 0.01, 101)) for v in peak.speed]
    sweep = np.concatenate([np.linspace(0.0, stop, 3000), *near])
    swept = cycle_peaks(rows, orders, sweep[sweep <= stop])
    top = np.max(swept.value, axis=0)
    assert np.all(top <= peak.value * (1.0 + 1e-12) + peak.error)
    assert top == pytest.approx(peak.value, rel=1e-5)


def test_curve_between_its_speeds_is_a_straight_line_to_the_tolerance() -> None:
    resonances = pitch_resonances(gibson()[0], gibson_couple())
    passed = run_up(gibson_rows(), ORDERS, resonances, 0.0, SPEED, ALL_ROWS, curve_tolerance=1e-3)
    between = 0.7 * passed.speed[1:] + 0.3 * passed.speed[:-1]
    line = 0.7 * passed.curve.value[1:, 0] + 0.3 * passed.curve.value[:-1, 0]
    true = cycle_peaks(gibson_rows(), ORDERS, between).value[:, 0]
    # the test of midpoints sees a grid of angles, which is good to some 4e-4
    assert np.max(np.abs(true - line)) <= 2e-3 * passed.peak.value[0]
    assert len(passed.speed) < 600


def test_displacement_of_a_point_is_translation_plus_rotation_cross_arm() -> None:
    place, turn = np.array([0.3, -0.7, 0.2]), np.array([0.01, -0.02, 0.03])
    moved = displacement_at(place) @ np.concatenate([np.zeros(3), turn])
    assert moved == pytest.approx(np.cross(turn, place), abs=1e-18)
