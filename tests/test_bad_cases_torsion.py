"""Claim: where a shaft line or its gas has no answer, or none to be trusted, the words say why."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from engine_cases import GENSET, refusal
from line_damper_samples import branched, torque_of_parts
from refused import changed, refusals
from torsion_lines import network
from variable_inertia_lines import one_freedom, ship_engine, ship_torque

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import card_weights, pressure_at
from vibecalc.excitation.pressure_cycle import (
    card_of_mean_pressure,
    card_of_peak,
    motored_cycle,
    usual_cycle,
)
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.torsion.damped_modes import damped_line_modes
from vibecalc.torsion.damper_design.design import design, performance
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, SpeedTorque
from vibecalc.torsion.forced import forced, modal_line
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.modes_of_tree import holzer_table, riccati_frequencies
from vibecalc.torsion.transient.march import transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.trace import samples, window_amplitudes
from vibecalc.torsion.variable_inertia.motion import feed, steady_response, variable_line
from vibecalc.torsion.variable_inertia.stability import refuse_unstable, stability

# ----------------------------------------------------------------------------
# Steady response: with an estimate of the error and without.
# ----------------------------------------------------------------------------

TWO = chain(np.ones(2), np.array([2.0]))
#: the middle station has no inertia
LIGHT = chain(np.array([1.0, 0.0, 1.0]), np.array([4.0, 4.0]))
NEXT = 2.0 * (1.0 + 1e-13)
#: its last station has no inertia either, and nothing holds it
LOOSE = chain(np.array([1.0, 0.0]), np.zeros(1))


@pytest.mark.parametrize("estimate", [True, False])
@pytest.mark.parametrize(
    ("line", "frequency", "torque", "words"),
    [
        (TWO, 2.0, [1.0, 0.0], "at 2 rad/s: it is a natural frequency"),
        (TWO, 0.0, [1.0, 0.0], "free to turn do not balance"),
        # next to singular, however small the torque
        (TWO, NEXT, [1e-25, 0.0], "natural frequency of the line"),
        (LIGHT, NEXT, [1.0, 0.0, 0.0], "natural frequency"),
        (LIGHT, NEXT, [0.1, 1.0, 0.2], "natural frequency"),
        (LOOSE, 1.0, [0.0, 1.0], "natural frequency"),
    ],
)
def test_no_steady_response(line, frequency, torque, words, estimate):
    with pytest.raises(NumericalFailure, match=words):
        forced(line, frequency, np.array(torque), estimate=estimate)
    assert forced(LOOSE, 1.0, np.array([1.0, 0.0])).angle.tolist() == [-1.0, 0.0]


def test_unbalanced_loops_at_rest_are_refused_and_balanced_ones_twist():
    ring = network([1, 1, 1], [(0, 1, 1.0), (1, 2, 1.0), (2, 0, 1.0)])
    with pytest.raises(NumericalFailure, match="do not balance"):
        forced(ring, 0.0, np.array([1.0, 0.0, 0.0]))
    assert forced(ring, 0.0, [1.0, -1.0, 0.0]).angle == pytest.approx([1 / 3, -1 / 3, 0.0])


# ----------------------------------------------------------------------------
# One message each.
# ----------------------------------------------------------------------------

LOOP = network([1, 1, 1], [(0, 1, 1.0), (1, 2, 1.0), (2, 0, 1.0)])
TWINS = network([1, 1, 1, 1], [(0, 1, 1.0), (1, 2, 1.0), (1, 3, 1.0)])
EMPTY = chain(np.array([1.0, 0.0, 0.0]), np.array([0.0, 2.0]))
STEEP = chain(np.ones(400), np.full(399, 1e-3))
BRAKED = TWO._replace(absolute_damping=np.array([1.0, 0.0]))

PAIR = chain(np.array([2.0, 3.0]), np.array([4000.0]))
GAS = np.array([[10.0 + 0j], [0.0]])
CRITICAL = float(np.sqrt(4000.0 / 1.2))

SHIP = ship_engine()
LOSSY = SHIP._replace(line=SHIP.line._replace(loss_factor=np.full(3, 0.01)))
MASSLESS = SHIP._replace(line=SHIP.line._replace(inertia=np.array([10.0, 10.0, 10.0, 0.0])))

GOOD = Limits((0.5, 0.5), (50.0, 2e4), (0.3, 300.0))
TABLE = SpeedTorque(np.array([50.0, 150.0]), np.ones((1, 1, 3, 4), dtype=complex))
PIECES = Line(
    np.ones(4), np.zeros(4), np.zeros(4), np.array([0, 2]), np.array([1, 3]),
    np.full(2, 1e4), np.zeros(2), np.zeros(2),
)  # fmt: skip

CAR = CrankGeometry(0.035, 0.123, 0.076)
SPARK = usual_cycle("spark")
NOT_ABOVE = "not above what the compression alone reaches"


def run(
    line: Line = PAIR, order: float = 1.0, acceleration: float = 1.0, speed: float = 5.0, **more
):
    return transient(line, np.array([order]), [stretch(2.0, acceleration, GAS)], speed, **more)


def beyond_its_course():
    seen = samples(run(), 0.0, 2.0)
    return window_amplitudes(seen.time, seen.value[:, 0], np.array([9.0]), 0.1, 1.0)


def pushed(line: Line, station: int, ends: tuple[float, float]) -> DamperProblem:
    """A damper at a station of a line that one order excites at the first one."""
    push = torque_of_parts(np.eye(len(line.inertia))[:1], 0.0)
    return DamperProblem(line, station, np.array([1.0]), 2.0 * np.pi, push, ends, np.ones(2))


def while_it_burns():
    """The charge is still being compressed as it begins to burn."""
    reached = float(pressure_at(motored_cycle(SPARK, CAR), SPARK.combustion_starts))
    return card_of_peak(SPARK, CAR, 1.001 * reached + SPARK.crankcase_pressure)


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: modal_line(natural_modes(TWO), line=BRAKED), "couples the undamped modes"),
        (lambda: natural_modes(EMPTY), "without any inertia"),
        (lambda: damped_line_modes(EMPTY, 0), "without any inertia"),
        (lambda: riccati_frequencies(LOOP), "closed loop"),
        (lambda: holzer_table(LOOP, np.array(1.0)), "closed loops"),
        (lambda: holzer_table(EMPTY, np.array(1.0)), "without any inertia"),
        # each branch on its own spring, the middle still: two branches of one frequency
        (lambda: holzer_table(TWINS, np.array(1.0)), "stands still"),
        (lambda: holzer_table(STEEP, np.array(1e3)), "range of numbers"),
        # in time
        (lambda: run(PAIR._replace(loss_factor=np.array([0.1]))), "loss factor has no time domain"),
        (lambda: run(PAIR._replace(inertia=np.array([2.0, 0.0]))), "inertia at every freedom"),
        (lambda: run(acceleration=-4.0), "turn backwards in stretch 1"),
        (lambda: run(order=-1.0), "go from 0 on"),
        (
            lambda: run(speed=CRITICAL, start="steady"),
            "order 1 meets an undamped natural frequency",
        ),
        (lambda: run(reaction=np.zeros(2)), "no station which takes the mean torque"),
        (lambda: run(rtol=1e-18), "does not reach the tolerance 1e-18 \\(section 1"),
        (
            lambda: transient(
                PAIR, np.ones(1), [stretch(1.0, 0.0, GAS), stretch(0.0, 0.0, GAS)], 5.0
            ),
            "stretch 2 of the transient has no duration",
        ),
        (
            lambda: transient(PAIR, np.array([50.0]), [stretch(1e6, 0.0, GAS)], 500.0),
            "more than 4000000 steps",
        ),
        (beyond_its_course, "reaches beyond the course"),
        # with variable inertias
        (
            lambda: steady_response(one_freedom(0.0), 1.0, np.array([[0.0], [1.0]]), 3),
            "undamped critical",
        ),
        (
            lambda: feed(one_freedom(0.1), 0.5, np.ones((4, 1), dtype=complex)),
            "order 2 meets an undamped natural frequency",
        ),
        (lambda: steady_response(SHIP, 90.0, ship_torque(), 3), "orders above 3 change"),
        (lambda: variable_line(TWO, [[0.0, 0.0], [0.0, 1.2]]), "freedom 2 falls to -"),
        (lambda: stability(LOSSY, 60.0), "loss factor"),
        (lambda: stability(MASSLESS, 60.0), "no inertia"),
        # tuning of a damper; the last one sits on the node of the first mode, at 100 rad/s
        (lambda: design(branched()._replace(torque=TABLE), GOOD), "torque is known from 50 to 150"),
        (
            lambda: design(branched()._replace(order=np.array([1.0, 1.5, 2.0])), GOOD),
            "repeat with the cycle",
        ),
        (lambda: design(pushed(PIECES, 0, (10.0, 200.0)), GOOD), "several pieces"),
        (
            lambda: performance(
                pushed(chain(np.ones(3), np.full(2, 1e4)), 1, (10.0, 150.0)),
                Damper(0.5, 1e3, 3.0),
            ),
            "does not reach is excited without damping at 100",
        ),
        # pressure of the gas
        *(
            (
                lambda at=at: card_weights([100.0, 500.0], [300.0, at]),
                "outside the cards' range, 954.93 to 4774.65 rpm",
            )
            for at in (99.0, 501.0, np.nan)
        ),
        (lambda: card_of_peak(SPARK, CAR, 8e5), NOT_ABOVE),
        (while_it_burns, NOT_ABOVE),
        (
            lambda: card_of_mean_pressure(SPARK, CAR, -1e6),
            "mean indicated pressure of -1e\\+06 Pa is below",
        ),
    ],
)
def test_refused(ask: Callable[[], object], words: str) -> None:
    with pytest.raises(NumericalFailure, match=words):
        ask()


@pytest.mark.long
def test_limits_that_no_damper_keeps_name_the_nearest_miss() -> None:
    tight = GOOD._replace(travel=1e-5, stiffness=(1e3, 1e3), damping=(50.0, 150.0))
    with pytest.raises(NumericalFailure, match=r"found no damper within.*no proof.*travel of"):
        design(branched(), tight, map_points=2, speeds=15, starts=1)


def test_unstable_operating_point_is_refused_and_damping_mends_it() -> None:
    torque = ship_torque(0.1)
    for damping, stable in ((0.01, False), (5.0, True)):
        engine = ship_engine(0.5, damping=damping)
        motion = steady_response(engine, 540.0, torque, 24, exact=True)
        found = stability(engine, 540.0, angle=motion.angle[0], angle_error=motion.error[0])
        assert found.unstable != stable
        if not stable:
            with pytest.raises(NumericalFailure, match=r"rpm: no steady motion; .*grows by"):
                refuse_unstable(found, 540.0)


def test_standstill_is_held_by_its_static_torque() -> None:
    # crank at 60 degrees: the static torque 10 cos(60) is passed on to the far end, at rest
    still = transient(
        PAIR, np.array([1.0]), [stretch(3.0, 0.0, GAS)], 0.0, angle=np.pi / 3,
        start="steady", reaction=np.array([0.0, 1.0]),
    )  # fmt: skip
    torque = still.states[-1] @ still.system.torque.T
    assert np.abs(torque - 5.0).max() <= still.torque_error[0] + 1e-13
    assert np.abs(still.states[-1][:, 1:]).max() < 1e-12


# ----------------------------------------------------------------------------
# Changes in time as a case asks for them.
# ----------------------------------------------------------------------------

TERMS = '[{ amplitude = "3 kN*m", frequency = "50 Hz", time_constant = "0.1 s" }]'
HISTORY = '{ time = ["0 s", "0.1 s"], torque = ["0 N*m", "5 N*m"] }'
CHANGES = {
    "short": f'kind = "short_circuit", on = "generator", terms = {TERMS}',
    "table": f'kind = "torque_history", on = "generator", history = {HISTORY}',
    "clutch": 'kind = "clutch_in", clutch = "coupling", driven_speed = "100 rpm", '
    'friction_torque = "6 kN*m"',
    "stop": 'kind = "stop", from = "900 rpm", duration = "3 s", counting = {}',
}


@pytest.mark.parametrize(("case", "change", "line", "words"), refusals("transient"))
def test_words_and_line(
    case: str, change: str, line: str, words: list[str], tmp_path: Path
) -> None:
    text = f"{GENSET}transient = {{ {CHANGES[case]} }}\n"
    message = refusal(tmp_path, changed(text, change))
    for expected in words:
        assert expected in message
    assert message.count("error: ") == 1, message
    assert line == "-" or f"engine.toml:{line}:" in message.splitlines()[1]
