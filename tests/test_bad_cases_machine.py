"""Claim: a machine that cannot be is refused, at the key that says it, in words with numbers.

Unlikely machines get a sentence in the report instead.
"""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from crank_trains import GENERATOR, generator
from refused import hold, rows_with_messages, told, with_keys

from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.schema import Case

FLAT = [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.4, -0.2, 0.0], [0.4, 0.2, 0.0]]
RIGID: dict[str, Any] = {"isolation": {"model": "rigid_body"}}


def of_row(change: str) -> Case:
    """The generator with the keys of a row."""
    return Case.model_validate(with_keys(tomllib.loads(GENERATOR), change))


def _refused(change: str) -> str:
    return told(check_machine(of_row(change)))


def _free(stiffness: Any, positions: list[list[float]]) -> str:
    mounts = {"each": {"stiffness": stiffness}, "positions": positions}
    return told(check_machine(generator(machine__mounts=mounts, **RIGID)))


def _warned(change: str) -> str:
    case = of_row(change)
    assert check_machine(case) == []
    return "\n".join(machine_warnings(case))


FREE: dict[str, tuple[Any, list[list[float]]]] = {
    "vertical springs only": ([0.0, 0.0, 1e4], FLAT),
    "no sideways stiffness": ([1e4, 0.0, 1e4], FLAT),
    "all on a line under the centre": (1e4, [[-0.4, 0.0, -0.2], [0.4, 0.0, -0.2]]),
    "one ball joint": ([1e4, 2e4, 3e4], [[0.1, 0.0, -0.3]]),
    "zero stiffness": (0.0, FLAT),
    "line askew": (1e4, [[0.3, 0.3, 0.0], [-0.3, -0.3, 0.0]]),
}


def test_pitch_asks_for_no_other_stiffness() -> None:
    case = generator(machine__mounts__each={"stiffness": [0.0, 0.0, 1e4]})
    assert check_machine(case) == []


def test_stiffness_many_decades_apart_is_not_free() -> None:
    case = generator(machine__mounts__each={"stiffness": [1.0, 1e12, 1e4]}, **RIGID)
    assert check_machine(case) == []


MESSAGES = {
    **{
        name: lambda _, row=row: _refused(row)
        for name, (_, row) in rows_with_messages("machine", "refused").items()
    },
    **{name: lambda _, row=row: _free(*row) for name, row in FREE.items()},
    **{
        f"warned: {name}": lambda _, row=row: _warned(row)
        for name, (_, row) in rows_with_messages("machine", "warned").items()
    },
}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_key(name: str, tmp_path: Path) -> None:
    hold("bad_cases_machine", name, MESSAGES[name], tmp_path)


def test_exact_models_are_not_warned_about() -> None:
    below = [[x, y, -0.2] for x, y, _ in FLAT]
    assert machine_warnings(generator(machine__mounts__positions=below, **RIGID)) == []
