"""Claim: arrays give the running states that single runs give, within both error estimates.

Points without a running state get the words of a single run. Every key that arrays can vary is
varied, alone and all at once.
"""

from copy import deepcopy
from functools import cache

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import CASES
from sweep_blocks import quantities

from vibecalc.core.case.load import LoadedCase, load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, get_key, parse_key, set_key
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import DONE, FAILED
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.study.sweep.at_once import pattern, unsupported
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.evaluate import ArrayEvaluator, Evaluator
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


@cache
def machine(name: str) -> LoadedCase:
    """One of the cases, as if read from a file; what arrays do not give is left away."""
    loaded = load_case(CASES["roll"])
    tables = deepcopy({k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED})
    for option in ("interpolations", "sensitivity", "classical"):
        tables["response"]["roll"][option] = False
    for option in ("compare", "step"):
        tables["response"]["roll"].pop(option, None)
    for key, value in CHANGES[name].items():
        path = parse_key(key)
        if value is None:
            above = get_key(tables, path[:-1])
            above.pop(path[-1], None)
        else:
            set_key(tables, key, value)
    if name == "short table":
        table = tables["machine"]["motor"]["slip_table"]
        tables["machine"]["motor"]["slip_table"] = {k: v[:5] for k, v in table.items()}
    case = validate(tables)
    return LoadedCase(
        case=case, name=name, path=loaded.path, text="", overrides=(), resolved=resolve(case),
        resolved_toml="", sha256="",
    )  # fmt: skip


def numbers(table: object, above: tuple = ()) -> list[tuple]:
    if isinstance(table, float):
        return [above]
    if not isinstance(table, dict | list):
        return []
    entries = table.items() if isinstance(table, dict) else enumerate(table)
    return [path for key, entry in entries for path in numbers(entry, (*above, key))]


@cache
def known_paths(name: str) -> tuple[str, ...]:
    case = machine(name).case
    return tuple(p for p in planned_quantities(case) if unsupported(case, [], [p]) is None)


@cache
def known_keys(name: str) -> list[tuple]:
    case = machine(name).case
    every = numbers(machine(name).resolved)
    return [key for key in every if unsupported(case, [key], known_paths(name)) is None]


def design(name: str, axes: list[dict], **more: object) -> Design:
    return make_design(Sweep.model_validate({"axes": axes, **more}), machine(name).resolved)


class Counting(ArrayEvaluator):
    """Counts the points that a single run has done."""

    alone = 0

    def run_point(self, settings):
        self.alone += 1
        return super().run_point(settings)


def same(name: str, points: Design, paths: tuple[str, ...], alone: int = 0) -> Block:
    """Hold arrays against single runs; at most `alone` points of the first are run alone."""
    every = np.arange(points.count)
    counting = Counting(machine(name), points, paths)
    arrays, single = counting(every), Evaluator(machine(name), points, paths)(every)
    assert arrays.status.tolist() == single.status.tolist()
    assert arrays.message == single.message
    assert counting.alone <= alone
    done = single.status == DONE
    for path, other in quantities(single).items():
        found = quantities(arrays)[path]
        assert (found.unit, found.long_name) == (other.unit, other.long_name)
        assert [axis.name for axis in found.axes] == [axis.name for axis in other.axes]
        both = np.isfinite(found.values) & np.isfinite(other.values)
        one, two = (np.where(both, part.values, 0.0) for part in (found, other))
        apart = np.abs(one - two)
        uncertainty = (found.errors + other.errors)[done]
        assert np.all(apart[done].reshape(len(uncertainty), -1) <= uncertainty[:, None]), path
        if path == LEVEL:
            assert both[done].all() and np.max(uncertainty) < 1e-6
    return arrays


def test_the_cases_have_every_key_and_every_result() -> None:
    keys = {pattern(key) for name in FULL for key in known_keys(name)}
    missing = ROLL_KEYS - keys
    # other ways to write the same masses
    assert missing <= {
        *(f"{TRAIN}.{part}_mass" for part in ("reciprocating", "piston", "pin")),
        f"{TRAIN}.rod.crank_pin_to_mass_centre",
        f"{TRAIN}.cylinders[].rotating_mass",
    }
    assert set(known_paths("free")) == set(TOGETHER)


@pytest.mark.parametrize(
    ("name", "step"),
    [("free", 4), *(pytest.param(name, 1, marks=pytest.mark.long) for name in FULL)],
)
def test_each_key_alone(name: str, step: int) -> None:
    before = [] if name == "free" else known_keys("free")
    for key in known_keys(name)[::step]:
        if key in before and key[-1] != "rod_length":
            continue
        value = get_key(machine(name).resolved, key)
        axis = {"key": dotted(key), "values": [value, value * 1.03 if value else 1e-3]}
        # where mounts come and go, and where friction turns at moving dead centres, points are
        # left to single runs
        held = key[-2] == "shell" and not value
        turns = name == "dressed" and key[-1] in GEOMETRY
        same(name, design(name, [axis]), KEEP, alone=2 if held or turns else 0)


@pytest.mark.parametrize("name", long_but(FULL, "dressed"))
def test_all_keys_at_once_and_every_result(name: str) -> None:
    axes = []
    for key in known_keys(name):
        value = get_key(machine(name).resolved, key)
        if value and (name == "free" or key[-1] not in GEOMETRY):
            axes.append({"key": dotted(key), "from": 0.98 * value, "to": 1.02 * value})
    points = design(name, axes, sampling="latin_hypercube", points=3)
    same(name, points, known_paths(name))


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
