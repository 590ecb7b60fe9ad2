"""Claim: a mass that dry friction drags along takes what the closed form says, its best friction is
the closed one, and motions in time agree with the first harmonic.

Truth: the motion of the mass step by step, and of both masses in time from one slip to the next.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from shipped_cases import result_of

from vibecalc import check, run
from vibecalc.absorber.friction_damper import DryFriction, best_friction, largest, response
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.parts.dry_friction import ALWAYS_SLIPS, MOST_WORK, shares

CASE = Path(__file__).parents[1] / "cases" / "absorber_friction.toml"


def dragged(t: float, steps: int = 20000) -> tuple[float, float]:
    """Inertia and damping of a mass below a motion sin(a), whose speed follows by t at most."""
    angle = np.arange(steps) * (2.0 * np.pi / steps)
    speed, rates = 0.0, np.zeros(steps)
    for _ in range(5):
        for place, goal in enumerate(np.cos(angle + angle[1]).tolist()):
            change = min(max(goal - speed, -t * angle[1]), t * angle[1])
            rates[place], speed = change / angle[1], speed + change
    middle = angle + 0.5 * angle[1]
    return -2.0 * float(np.mean(rates * np.sin(middle))), 2.0 * float(
        np.mean(rates * np.cos(middle))
    )


@pytest.mark.parametrize("t", [0.1, 0.45, 0.53, 0.545, 0.8, 1.3])
def test_first_harmonic_is_that_of_the_motion_step_by_step(t: float) -> None:
    assert shares(t) == pytest.approx(dragged(t), abs=3e-4)


def test_work_is_that_of_den_hartog_and_greatest_where_he_says() -> None:
    t = np.linspace(0.0, ALWAYS_SLIPS, 2001)
    found = shares(t)
    # 4 F Y sqrt(1 - (pi t / 2)^2) over pi J2 w^2 Y^2
    assert np.allclose(found.damping, 4.0 / np.pi * t * np.sqrt(1.0 - (0.5 * np.pi * t) ** 2))
    every = np.linspace(0.0, 1.2, 12001)
    assert every[np.argmax(shares(every).damping)] == pytest.approx(MOST_WORK, abs=1e-4)
    assert shares(MOST_WORK).damping == pytest.approx(4.0 / np.pi**2, rel=1e-14)
    edge = shares(ALWAYS_SLIPS * np.array([1.0 - 1e-9, 1.0 + 1e-9]))
    assert np.ptp(edge.inertia) < 1e-7 and np.ptp(edge.damping) < 1e-7
    assert shares(1.0) == (1.0, 0.0)


@pytest.mark.parametrize("m", [0.01, 0.1, 0.5])
def test_all_frictions_pass_one_point_which_the_best_makes_the_peak(m: float) -> None:
    place, height = 1.0 / np.sqrt(1.0 + 4.0 * m / np.pi**2), 1.0 + np.pi**2 / (4.0 * m)
    friction, least = best_friction(0.0, m)
    best = float(friction.value)
    assert best == pytest.approx(np.pi / np.sqrt(8.0 * (1.0 + 4.0 * m / np.pi**2)), rel=1e-14)
    assert float(least.value) == pytest.approx(height, rel=1e-14)
    for factor in (0.8, 1.0, 1.1):
        found = response(DryFriction(0.0, m, factor * best), np.array([place]))
        assert found[0] == pytest.approx(height, rel=1e-9)
    top, at = largest(DryFriction(0.0, m, best))
    assert float(top.value) == pytest.approx(height, rel=1e-10) and at == pytest.approx(
        place, rel=1e-6
    )
    for factor in (0.97, 1.03):
        assert float(largest(DryFriction(0.0, m, factor * best))[0].value) > height


def test_a_damped_primary_has_less_and_no_other_friction_does_better() -> None:
    friction, least = best_friction(0.02, 0.1)
    assert 0.0 < float(least.value) < float(best_friction(0.0, 0.1)[1].value)
    tried = float(friction.value) * np.array([0.5, 0.99, 1.01, 2.0])
    every = [float(largest(DryFriction(0.02, 0.1, one))[0].value) for one in tried.tolist()]
    assert min(every) > float(least.value)


def test_limits() -> None:
    x = np.array([0.2, 0.7, 1.3])
    stuck = 1.0 / np.hypot(1.0 - 1.2 * x * x, 2.0 * 0.05 * x)
    assert response(DryFriction(0.05, 0.2, 1e3), x) == pytest.approx(stuck, rel=1e-14)
    free = 1.0 / np.hypot(1.0 - x * x, 2.0 * 0.05 * x)
    assert response(DryFriction(0.05, 0.2, 0.0), x) == pytest.approx(free, rel=1e-14)
    # below pi / 4 of the force friction takes less than comes in
    assert np.isinf(float(largest(DryFriction(0.0, 0.1, 0.78))[0].value))
    assert np.isfinite(float(largest(DryFriction(0.0, 0.1, 0.79))[0].value))
    with pytest.raises(NumericalFailure, match="sticks where the response is largest"):
        best_friction(0.0, 3.0)


def in_time(damper: DryFriction, x: float, cycles: int) -> float:
    """Amplitude of the primary after some cycles in time, friction rising steeply with the slip."""
    z1, m, f = damper
    steep = 1e-4

    def rates(time: float, state: np.ndarray) -> list[float]:
        y, v, w = state
        rub = f * np.tanh((v - w) / steep)
        return [v, np.cos(x * time) - 2.0 * z1 * v - y - rub, rub / m]

    end = 2.0 * np.pi / x * cycles
    time = np.linspace(end - 2.0 * np.pi / x, end, 400)
    start = float(response(damper, np.array([x]))[0])
    found = solve_ivp(rates, (0.0, end), [0.0, start * x, 0.0], "LSODA", time, rtol=1e-7, atol=1e-9)
    return 0.5 * float(np.ptp(found.y[0]))


@pytest.mark.parametrize(("f", "x", "cycles"), [(0.9, 0.975, 25), (1.09, 0.98, 25), (2.0, 0.9, 60)])
def test_motions_in_time_have_the_amplitudes_of_the_first_harmonic(
    f: float, x: float, cycles: int
) -> None:
    """Below the best friction, next to it, and far above, where the two masses nearly stick."""
    damper = DryFriction(0.02, 0.1, f)
    expected = float(response(damper, np.array([x]))[0])
    assert in_time(damper, x, cycles) == pytest.approx(expected, rel=0.02)


def changed(**changes: Any) -> str:
    text = CASE.read_text()
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(("old", "new", "words"), [
    ('torque = "10 N*m"', 'friction_torque = "9 N*m"', "friction counts against the torque"),
    ('torque = "10 N*m"', 'force = "10 N"', "force belongs to translation"),
    ('torque = "10 N*m"', 'torque = "10 N*m"\n[tuning]', "spring or a viscous damper"),
    ('torque = "10 N*m"', '[machine.secondary]\nmass_ratio = 0.1', "friction_damper"),
    ('inertia = "0.02 kg*m^2"', 'mass_ratio = 1e-12', "the ratio of this mass"),
])  # fmt: skip
def test_what_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    (tmp_path / "case.toml").write_text(changed(a=(old, new)))
    with pytest.raises(CaseError, match=words):
        check(tmp_path / "case.toml")


def test_a_run_has_the_best_friction_and_that_of_the_case(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(
        changed(a=('torque = "10 N*m"', 'torque = "10 N*m"\nfriction_torque = "9 N*m"'))
    )
    best, own = result_of("absorber_friction"), run(tmp_path / "case.toml")
    friction, least = best_friction(0.01, 0.1)
    assert best["friction_damper/friction_torque"].values == pytest.approx(10.0 * friction.value)
    assert best["friction_damper/largest"].values == pytest.approx(least.value, rel=1e-8)
    assert own["friction_damper/friction_ratio"].values == pytest.approx(0.9)
    assert own["friction_damper/best_largest"].values < own["friction_damper/largest"].values
    angle = own["friction_damper/largest"].values * 10.0 / 5000.0
    assert own["friction_damper/largest_angle"].values == pytest.approx(angle)
