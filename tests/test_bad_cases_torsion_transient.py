"""Claim: what has no transient is refused in words."""

import re
from pathlib import Path

import numpy as np
import pytest
from engine_cases import GENSET, refusal
from refused import changed, refusals

from vibecalc.errors import NumericalFailure
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.transient.march import transient
from vibecalc.torsion.transient.motion import stretch
from vibecalc.torsion.transient.trace import samples, window_amplitudes

PAIR = chain(np.array([2.0, 3.0]), np.array([4000.0]))
GAS = np.array([[10.0 + 0j], [0.0]])
CRITICAL = float(np.sqrt(4000.0 / 1.2))

TERMS = '[{ amplitude = "3 kN*m", frequency = "50 Hz", time_constant = "0.1 s" }]'
TABLE = '{ time = ["0 s", "0.1 s"], torque = ["0 N*m", "5 N*m"] }'
CHANGES = {
    "short": f'kind = "short_circuit", on = "generator", terms = {TERMS}',
    "table": f'kind = "torque_history", on = "generator", history = {TABLE}',
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


def run(
    line: Line = PAIR, order: float = 1.0, acceleration: float = 1.0, speed: float = 5.0, **more
):
    return transient(line, np.array([order]), [stretch(2.0, acceleration, GAS)], speed, **more)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"line": PAIR._replace(loss_factor=np.array([0.1]))}, "loss factor has no time domain"),
        ({"line": PAIR._replace(inertia=np.array([2.0, 0.0]))}, "inertia at every freedom"),
        ({"acceleration": -4.0}, "turn backwards in stretch 1"),
        ({"order": -1.0}, "go from 0 on"),
        ({"speed": CRITICAL, "start": "steady"}, "order 1 meets an undamped natural frequency"),
        ({"reaction": np.zeros(2)}, "no station which takes the mean torque"),
        ({"rtol": 1e-18}, "does not reach the tolerance 1e-18 (section 1"),
    ],
)
def test_refused(change: dict, words: str) -> None:
    with pytest.raises(NumericalFailure, match=re.escape(words)):
        run(**change)


def test_a_stretch_that_does_not_last() -> None:
    with pytest.raises(NumericalFailure, match="stretch 2 of the transient has no duration"):
        transient(PAIR, np.array([1.0]), [stretch(1.0, 0.0, GAS), stretch(0.0, 0.0, GAS)], 5.0)


def test_too_long_for_its_orders() -> None:
    with pytest.raises(NumericalFailure, match="more than 4000000 steps"):
        transient(PAIR, np.array([50.0]), [stretch(1e6, 0.0, GAS)], 500.0)


def test_windows_outside_what_is_known() -> None:
    seen = samples(run(), 0.0, 2.0)
    with pytest.raises(NumericalFailure, match="reaches beyond the course"):
        window_amplitudes(seen.time, seen.value[:, 0], np.array([9.0]), 0.1, 1.0)


def test_standstill_is_held_by_its_static_torque() -> None:
    # crank at 60 degrees: the static torque 10 cos(60) is passed on to the far end, at rest
    still = transient(
        PAIR, np.array([1.0]), [stretch(3.0, 0.0, GAS)], 0.0, angle=np.pi / 3,
        start="steady", reaction=np.array([0.0, 1.0]),
    )  # fmt: skip
    torque = still.states[-1] @ still.system.torque.T
    assert np.abs(torque - 5.0).max() <= still.torque_error[0] + 1e-13
    assert np.abs(still.states[-1][:, 1:]).max() < 1e-12
