"""Claim: what cannot be asked of the control of a motor is refused in words, at its line."""

import re
from pathlib import Path

import numpy as np
import pytest
from roll_control_cases import PATH, case_of, record_of, value_of

from vibecalc.cli.starters import starter
from vibecalc.core.results.record import Record
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import CaseError
from vibecalc.roll.motor_checks import control_problems

STARTER = starter("roll_control")


def refused(tmp_path: Path, text: str) -> str:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_checked([path])
    message = str(caught.value)
    assert "Traceback" not in message and message.count("error: ") == 1
    line = int(message.splitlines()[1].rsplit(":", 2)[1])
    return text.splitlines()[line - 1] + "\n" + message


def with_key(key: str, value: str, text: str = STARTER) -> str:
    """The starter case with one key of [response.control] set, wherever it stands."""
    lines = text.splitlines()
    top = next(i for i, line in enumerate(lines) if line.startswith("[response.control]"))
    end = next(i for i in range(top + 1, len(lines)) if re.match(r"(# )?\[", lines[i]))
    kept = [line for line in lines[top + 1 : end] if not re.match(rf"(# )?{key} =", line)]
    return "\n".join([*lines[: top + 1], f"{key} = {value}", *kept, *lines[end:]]) + "\n"


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        (
            "full_model",
            "true",
            ("has no delay", "0.001 s", "full_model = false (stability and levels of the"),
        ),
        ("gain", "0.0", ("gain", "0")),
        ("gains", "[1.0, -2.0]", ("gains[1] is out of range", "found -2")),
        ("gains", "[0.0]", ("gains[0] is out of range",)),
        ("motor_gains", "[0.0, 100.0]", ("motor_gains[0] is out of range",)),
        ("motor_gain", "-5.0", ("motor_gain",)),
        ("actuator_lag", "-1e-3", ("actuator_lag",)),
        ("delay", "'-1 ms'", ("delay",)),
        ("orders", "0", ("orders",)),
        ("orders", "2.5", ("orders",)),
        ("reduction", "'none'", ("reduction", "momentum", "rotor")),
    ],
)
def test_what_cannot_be_asked(tmp_path: Path, key: str, value: str, words: tuple[str, ...]) -> None:
    found = refused(tmp_path, with_key(key, value))
    for one in words:
        assert one in found


def test_an_order_that_the_control_lacks_is_refused(tmp_path: Path) -> None:
    row = '\n[[reference]]\nquantity = "response/control/level"\nwhere = { order = 11 }\n'
    row += 'value = "1 dB"\nsource = "nowhere"\n'
    found = refused(tmp_path, STARTER + row)
    assert "orders of [response.control] is the highest" in found


def test_the_starter_runs(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(STARTER, encoding="utf-8")
    (loaded,) = load_checked([path])
    record = execute(loaded).record
    assert record["response/control/status"].values == 0
    assert record["response/control/pole"].values.shape == (6,)
    assert record["response/control/gain_margin"].values > 6.0
    assert not record.warnings


def test_a_full_model_with_transients_of_the_motor_is_refused() -> None:
    case = case_of(full_model=True)
    motor = case.machine.motor
    assert motor is not None and control_problems(case) == []
    machine = case.machine.model_copy(
        update={"motor": motor.model_copy(update={"kind": "dynamic"})}
    )
    (problem,) = control_problems(case.model_copy(update={"machine": machine}))
    assert problem.path == ("response", "control", "full_model")
    assert "transients of the motor's fluxes" in problem.message


def unstable(full_model: bool) -> Record:
    record = record_of(gain=10.0, acceleration_feedback=1.0, full_model=full_model)
    assert value_of(record, "status") == 3 and np.all(np.isposinf(value_of(record, "level")))
    assert any("the loop is unstable" in text for text in record.warnings)
    return record


def test_an_unstable_loop_is_called_so() -> None:
    assert PATH + "range/level" in unstable(full_model=False)


@pytest.mark.long
def test_an_unstable_loop_is_called_so_with_the_full_model_too() -> None:
    """The full model has no motion to look at there; the reduced results stand all the same."""
    found, alone = unstable(full_model=True), unstable(full_model=False)
    (words,) = [text for text in found.warnings if "full model under control is left out" in text]
    assert "the loop is unstable in the reduced model" in words
    assert PATH + "full/level" not in found and PATH + "range/level" in found
    np.testing.assert_array_equal(value_of(found, "pole"), value_of(alone, "pole"))
