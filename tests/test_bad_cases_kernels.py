"""Claim: what has no solution, no meaning or no digits is refused in words, by each kernel."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from absorber_cases import peaks_of
from induction_motors import GIVEN, ONE_CAGE, TABLE_SLIP, TABLE_TORQUE
from periodic_problems import TURN, linear_rhs

from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    Walther,
    kinematic_viscosity,
    oil_damping,
)
from vibecalc.absorber.mean_square import mean_square, weights
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.pendulum_order import (
    Pendulum,
    detuning_coefficient,
    largest_swing,
    order_of_swing,
    path_exponent,
    radius_for_order_with_rollers,
    tuning_order,
)
from vibecalc.absorber.pendulum_steady import as_secondary, jump, small_motion, steady_motion
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.closed_forms import threshold
from vibecalc.absorber.tuning.mean_square import mean_square_tuning
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import given_damping, stock_choice, undamped_spring
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor_fit import fit_induction_motor
from vibecalc.excitation.induction_motor_flux import torque_answer
from vibecalc.excitation.induction_motor_identify import transient_inductance, with_stator_leakage
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import PeriodicProblem

Refused = list[tuple[Callable[[], Any], str]]
SOME = Absorber(0.05, 0.1, 0.08, 0.02)
POINT = Pendulum(1.3, 0.12, 0.02)
EPICYCLOID = POINT._replace(path_exponent=float(path_exponent("epicycloidal", POINT)))
ARM = POINT._replace(swing_inertia=1e-4)
LINE = Walther((313.15, 373.15), (86e-6, 13.8e-6))
OIL = Oil("10W-40", LINE, 870.0)
GAP = RingGap(0.148, 0.1, 0.007, 0.0005, 0.0005)
TWINS = ONE_CAGE._replace(
    rotor_resistance=np.array([0.2, 0.2]), rotor_leakage=np.array([2e-3, 2e-3])
)


NO_MEAN_SQUARE = {
    ("force", "acceleration", ""): "highest frequencies",
    ("base", "displacement", ""): "at zero frequency",
    ("base", "velocity", ""): "at zero frequency",
    ("base", "acceleration", "velocity"): "with damping in the primary system",
    ("base", "transmitted_force", "velocity"): "with damping in the primary system",
    ("base", "acceleration", "displacement"): "highest frequencies",
    ("unbalance", "displacement", ""): "highest frequencies",
    ("unbalance", "relative_displacement", ""): "highest frequencies",
}
OF_TUNINGS: Refused = [
    *((lambda what=what: minimax(0.1, 0.1, "force", what), "vanishes with the absorber")
      for what in ("secondary_displacement", "relative_displacement")),
    (lambda: given_damping(0.1, 0.1, 0.1, "force", "relative_displacement"), "vanishes with the"),
    (lambda: undamped_spring([0.0, 0.1], 0.1), "infinite whatever the spring"),
    (lambda: peaks(Absorber(1e-20, 0.1, 0.1, 0.0)), "beyond double precision"),
    *((lambda kind=kind: mean_square(SOME, *kind), words)
      for kind, words in NO_MEAN_SQUARE.items()),
    *((lambda kind=kind: mean_square_tuning(0.05, 0.1, *kind), r"\w") for kind in NO_MEAN_SQUARE),
    (lambda: mean_square(Absorber(0.1, 0.1, 0.0, 0.0), "force", "relative_displacement"),
     "nothing holds"),
    (lambda: mean_square_tuning(0.1, 0.1, "force", "relative_displacement"), "nothing to tune"),
    (lambda: threshold("force", "relative_displacement"), "no response of the primary"),
    (lambda: stock_choice(np.array([0.07, 0.08]), np.array([0.01, 0.02]), 3.9,
                          peaks_of(0.02, 0.1), travel=2.0), "least travel is"),
    (lambda: stock_choice(np.array([0.08]), np.zeros(1), 3.9, peaks_of(0.0, 0.1)),
     "none of the 1 pairs"),
]  # fmt: skip
OF_PENDULUMS: Refused = [
    *((lambda near=near: tuning_order(POINT._replace(path_radius=near)),
       "nothing pulls the pendulum outwards") for near in (0.12, 0.2)),
    (lambda: path_exponent("epicycloidal", ARM), "runs on a circle"),
    (lambda: detuning_coefficient(ARM._replace(path_exponent=0.5)), "runs on a circle"),
    (lambda: radius_for_order_with_rollers(POINT._replace(swing_inertia=0.1), 4.0),
     "no arm tunes it"),
    *((lambda share=share: order_of_swing(EPICYCLOID, share * largest_swing(EPICYCLOID)),
       r"leaves the path, which ends at 1\.7207") for share in (1.0, 1.2)),
    (lambda: order_of_swing(POINT, np.pi), "leaves the path"),
    (lambda: order_of_swing(POINT, np.pi - 1e-6), "too near to the end of the path"),
    (lambda: steady_motion(EPICYCLOID, 0.1, np.sqrt(5.0), 1.75),
     r"no steady motion|leaves the path|stops the rotor"),
    (lambda: jump(EPICYCLOID, 0.1, float(np.sqrt(5.0))), "no jump: the torque grows"),
]  # fmt: skip
OF_HARDWARE: Refused = [
    *((lambda at=at: kinematic_viscosity(LINE, at), "viscosity line ends at -70 and 370 C")
      for at in (200.0, 643.2, [300.0, 700.0])),
    (lambda: kinematic_viscosity(LINE, 553.15), r"mm\^2/s at 280 C is outside the range"),
    (lambda: oil_damping(OIL, GAP, 553.15), "outside the range"),
]  # fmt: skip
OF_MOTORS: Refused = [
    (lambda: fit_induction_motor(TABLE_SLIP[:4], TABLE_TORQUE[:4], **GIVEN),
     "3 rows to fit and the motor 4 parameters"),
    (lambda: fit_induction_motor([1.0, 2.0, 3.0], [5.0, 4.0, 3.0], **GIVEN, cages=1),
     "1 rows to fit and the motor 2 parameters"),
    *((lambda torque=torque: fit_induction_motor([0.0, 1.0, 2.0], torque, **GIVEN, cages=1),
       "torques above 0") for torque in ([0.0, 0.0, 5.0], [0.0, -1.0, 5.0])),
    (lambda: fit_induction_motor([0.0], [0.0], **GIVEN, cages=1), "torques above 0"),
    (lambda: with_stator_leakage(ONE_CAGE, transient_inductance(ONE_CAGE)),
     "below its transient inductance"),
    (lambda: with_stator_leakage(TWINS, 0.0), "are one cage"),
    (lambda: torque_answer(ONE_CAGE._replace(stator_resistance=0.0), 0.9, ONE_CAGE.line_frequency),
     "without damping"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("call", "words"),
    [
        pytest.param(*row, id=row[1])
        for row in (*OF_TUNINGS, *OF_PENDULUMS, *OF_HARDWARE, *OF_MOTORS)
    ],
)
def test_words(call: Callable[[], Any], words: str) -> None:
    with pytest.raises(NumericalFailure, match=words):
        call()


def test_what_only_an_undamped_primary_has() -> None:
    undamped = SOME._replace(primary_damping=0.0)
    assert weights("base", "acceleration", "velocity").undamped_only
    same = mean_square(undamped, "force", "velocity").value
    assert mean_square(undamped, "base", "acceleration", "velocity").value == pytest.approx(same)
    drifting = mean_square(Absorber(0.1, 0.1, 0.0, 0.1), "base", "relative_displacement")
    assert drifting.value == np.inf


def test_next_to_what_is_refused_there_is_an_answer() -> None:
    end = float(largest_swing(EPICYCLOID))
    assert end == pytest.approx(np.pi / (2.0 * EPICYCLOID.path_exponent))
    assert order_of_swing(EPICYCLOID, 0.99 * end).value == pytest.approx(np.sqrt(5.0), rel=1e-12)
    assert detuning_coefficient(ARM).value == -1.0 / 16.0
    free = ONE_CAGE._replace(stator_resistance=0.0)
    assert np.isfinite(torque_answer(free, 0.9, 94.0)[0].value)
    # a free rotor with a pendulum resonates above the order, where n^2 W^2 (1 + J2/J1) = w^2
    system = as_secondary(POINT, 4.0 * 1.3 * 0.12**2, 2.0)
    ratio = system.inertia / system.primary_inertia
    found = small_motion(system, 2.0 * np.sqrt(5.0 * (1.0 + ratio)), 1.0)
    assert np.isinf(found.rotor) or found.rotor_error >= 0.05 * abs(found.rotor)


EDGES = np.linspace(0.0, TURN, 37)


def saddle_rhs(level):
    """y' = level + sin(x) / 2 - (y - 1)^2: two periodic solutions, or none for a low level."""

    def rhs(x, y, piece):
        v = y[..., 0] - 1.0
        return (level + 0.5 * np.sin(x) - v**2)[..., None], (-2.0 * v)[..., None, None]

    return rhs


def test_no_periodic_solution_is_said():
    problem = PeriodicProblem(saddle_rhs(-0.5), EDGES)
    assert not solve_periodic(problem, 4, [2.0]).converged[0]
    march = march_turns(problem.rhs, EDGES, [5.0], floor=-2.0)
    assert march.stalled[0] and not march.converged[0]
    assert 0.0 <= march.stalled_at[0] < TURN


def test_marching_tells_which_members_have_a_solution():
    level = np.array([0.3, -0.3, 0.02, 1.0, -0.02])[:, None, None]
    rhs = saddle_rhs(level)
    march = march_turns(rhs, EDGES, np.full(5, 8.0), floor=-3.0, tolerance=1e-9)
    # exactly: a solution exists above a level near 0.06 (mean of the square of the ripple)
    assert march.converged.tolist() == [True, False, False, True, False]
    assert march.stalled.tolist() == [False, True, True, False, True]
    assert np.isnan(march.stalled_at[[0, 3]]).all() and not np.isnan(march.stalled_at[1])
    both = [0, 3]
    start = march.path[both, :1]
    finer = solve_periodic(PeriodicProblem(saddle_rhs(level[both]), EDGES), 6, start)
    assert finer.converged.all()
    assert np.abs(finer.left[:, 0, 0] - march.path[both, -1]).max() < 1e-5
    # the upper one of the two solutions: stable, above 1 on average
    assert np.all(finer.left.mean(axis=(1, 2)) > 1.0)


def test_a_multiplier_of_one_has_no_single_solution():
    flat = linear_rhs(lambda x: np.cos(x) + 1.0, np.zeros_like)
    for guess in ([0.0], [1.0]):
        assert not solve_periodic(PeriodicProblem(flat, EDGES), 3, guess).converged[0]

    def still(x, y, piece):
        return np.ones_like(y), np.zeros((*y.shape, y.shape[-1]))

    assert not solve_periodic(PeriodicProblem(still, EDGES), 2, [1.0, 2.0]).converged[0]
