"""Claim: arrays give the running states that single runs give, within both error estimates.

Points without a running state get the words of a single run. Every key that arrays can vary is
varied, all at once.
"""

from functools import cache

import numpy as np
import pytest
from array_machines import as_read, changed, designed, hold, keys_of, paths_of
from shipped_cases import CASES
from sweep_blocks import quantities

from vibecalc.core.case.load import LoadedCase, load_case
from vibecalc.core.case.raw import get_key
from vibecalc.core.results.layout import DONE, FAILED
from vibecalc.core.study.sweep.at_once import pattern
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.design import Design
from vibecalc.errors import dotted
from vibecalc.roll.stage import ROLL_KEYS, TOGETHER

LEVEL = "response/roll/level/shell_acceleration"
KEEP = (LEVEL, "response/roll/speed", "response/roll/largest_multiplier")
TRAIN = "machine.crank_train"
GEOMETRY = ("crank_radius", "rod_length", "wrist_pin_offset")
#: tables put in place of those of the shipped machine
CHANGES: dict[str, dict[str, object]] = {
    "free": {},
    "dressed": {
        "response.roll.started_at": None,
        f"{TRAIN}.wrist_pin_offset": 0.004,
        f"{TRAIN}.rotating_mass": 2.0,
        f"{TRAIN}.rod": {"mass": 3.0, "reciprocating_fraction": 0.3, "inertia": 0.05},
        "machine.friction": {"torque": 5.0, "viscous": 0.2, "piston_force": 40.0},
        "machine.shell.stiffness": 3e5,
        "machine.shell.damping": 2e3,
        "machine.motor.interpolation": "monotone",
    },
    "short table": {},
}
FULL = ("free", "dressed")


#: what arrays do not give
LEFT_AWAY = {
    **dict.fromkeys(
        (f"response.roll.{n}" for n in ("interpolations", "sensitivity", "classical")), False
    ),
    **dict.fromkeys(f"response.roll.{n}" for n in ("compare", "step")),
}


@cache
def machine(name: str) -> LoadedCase:
    """One of the cases, as if read from a file."""
    loaded = load_case(CASES["roll"])
    tables = changed(loaded, {**LEFT_AWAY, **CHANGES[name]})
    if name == "short table":
        table = tables["machine"]["motor"]["slip_table"]
        tables["machine"]["motor"]["slip_table"] = {k: v[:5] for k, v in table.items()}
    return as_read(loaded, tables)


@cache
def known_keys(name: str) -> tuple:
    return keys_of(machine(name))


def design(name: str, axes: list[dict], **more: object) -> Design:
    return designed(machine(name), axes, **more)


def same(name: str, points: Design, paths: tuple[str, ...], alone: int = 0) -> Block:
    """Hold arrays against single runs; at most `alone` points are run alone."""
    found = hold(machine(name), points, paths, points.count - alone, generous=None)
    done = found.status == DONE
    if LEVEL in paths:
        level = quantities(found)[LEVEL]
        assert np.isfinite(level.values[done]).all() and np.max(level.errors[done]) < 1e-6
    return found


def test_the_cases_have_every_key_and_every_result() -> None:
    keys = {pattern(key) for name in FULL for key in known_keys(name)}
    missing = ROLL_KEYS - keys
    # other ways to write the same masses
    assert missing <= {
        *(f"{TRAIN}.{part}_mass" for part in ("reciprocating", "piston", "pin")),
        f"{TRAIN}.rod.crank_pin_to_mass_centre",
        f"{TRAIN}.cylinders[].rotating_mass",
    }
    assert set(paths_of(machine("free"))) == set(TOGETHER)


@pytest.mark.parametrize("name", FULL)
def test_all_keys_at_once_and_every_result(name: str) -> None:
    axes = []
    for key in known_keys(name):
        value = get_key(machine(name).resolved, key)
        # where mounts come and go, and where friction turns at moving dead centres, points are
        # left to single runs
        if name == "free" and key[-1] == "wrist_pin_offset":
            axes.append({"key": dotted(key), "from": 0.0, "to": 1e-3})
        elif value and (name == "free" or key[-1] not in GEOMETRY):
            axes.append({"key": dotted(key), "from": 0.98 * value, "to": 1.02 * value})
    points = design(name, axes, sampling="latin_hypercube", points=3)
    same(name, points, paths_of(machine(name)))


def test_points_without_a_running_state_get_the_words_of_a_single_run() -> None:
    axis = {"key": "machine.rotor.inertia", "values": [0.03, 2.0]}
    found = same("free", design("free", [axis]), KEEP, alone=2)
    assert found.status.tolist() == [FAILED, DONE]
    assert "comes to a standstill" in found.message[0]


def test_slip_beyond_the_table_is_said_at_its_point() -> None:
    axis = {"key": "machine.rotor.inertia", "values": [2.0, 3.0, 20.0]}
    found = same("short table", design("short table", [axis]), KEEP, alone=3)
    assert found.status[0] == FAILED and found.status[-1] == DONE
    assert "beyond the motor's table" in found.message[0]
