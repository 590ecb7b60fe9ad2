"""Claim: a stage is run again if, and only if, what it reads has changed; results are the same.

What a stage reads is declared in `pipeline/reads.py`. Here every stage of every shipped case runs
on a case that remembers what was read of it.
"""

import importlib
from functools import cache
from typing import Any

import numpy as np
import pytest
from shipped_cases import CASES, SLOW
from watched_case import Watched, WatchedEntries, WatchedParts, undeclared

from vibecalc.case.load import validate
from vibecalc.case.schema import Case
from vibecalc.errors import NumericalFailure
from vibecalc.machine.build import build_machine
from vibecalc.pipeline.plan import plan_case
from vibecalc.pipeline.reads import PARTS, READS, SHARED, Reads
from vibecalc.pipeline.run import run_case
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_cache import StageCache
from vibecalc.results.record import Record
from vibecalc.study.load import load_checked
from vibecalc.study.sweep.place import case_at

#: long studies made short: what they read stays the same
SHORTER = {
    "compressor_impact": (
        "response.impact.members=2",
        "response.impact.revolutions=2",
        "response.impact.discard=0",
        "response.impact.clearances=['0.1 mm']",
        "response.impact.orders=4",
        "reference=[]",
    ),
    "roll_startup": (
        "response.start_up.duration='0.1 s'",
        "response.start_up.load={time=[0.0, 0.05], factor=[0.0, 1.0]}",
        "response.start_up.angles=2",
        "response.start_up.start_within='20 ms'",
    ),
    "roll_mounted": ("response.start_up.duration='0.1 s'", "reference=[]", "find=[]"),
    "compressor_switching": (
        "response.switching.run_down='0.1 s'",
        "response.switching.run_up='0.1 s'",
        "response.switching.after='0.1 s'",
    ),
}
QUICK = ("generator", "compressor_a", "compressor_motor", "generator_180")


@cache
def resolved(name: str) -> dict[str, Any]:
    (loaded,) = load_checked([CASES[name]], SHORTER.get(name, ()))
    return loaded.resolved


def case_of(name: str, **settings: Any) -> Case:
    """A shipped case with some keys set; `__` stands for a dot."""
    return validate(case_at(resolved(name), {k.replace("__", "."): v for k, v in settings.items()}))


def equal_bits(one: Record, other: Record) -> bool:
    """Whether two records are the same to the last bit, warnings and methods too."""
    if list(one) != list(other) or one.warnings != other.warnings or one.methods != other.methods:
        return False
    for path, quantity in one.items():
        again = other[path]
        if quantity.values.tobytes() != again.values.tobytes():
            return False
        if (quantity.error_estimate, quantity.standard_error) != (
            again.error_estimate,
            again.standard_error,
        ):
            return False
        for axis, same in zip(quantity.axes, again.axes, strict=True):
            if axis.name != same.name or not np.array_equal(axis.values, same.values):
                return False
    return True


def undeclared_reads(case: Case, reads: dict[str, Reads]) -> list[str]:
    """What the stages of a case read without saying so."""
    writers: dict[str, str] = {}
    handed_on: dict[str, Any] = {}
    record, found = Record(), []
    parts = build_machine(case.machine, case.excitation)
    for stage in plan_case(case):
        seen: set[str] = set()
        # an entry that any stage may build is built by each, so that its reading is seen
        entries = WatchedEntries({k: v for k, v in handed_on.items() if k not in SHARED})
        scene = Scene(
            case=Watched(case, "", seen),  # type: ignore[arg-type]
            parts=WatchedParts(parts, seen),  # type: ignore[arg-type]
            record=record,
            handed_on=entries,
        )
        importlib.import_module(f"vibecalc.pipeline.stages.{stage.module}").run(scene)
        declared = reads[stage.module]
        found += [f"{stage.module}: {place}" for place in undeclared(seen, declared.case)]
        for name in entries.read & writers.keys():
            if writers[name] not in declared.after:
                found.append(f"{stage.module}: {name} of {writers[name]}")
        for name in entries.keys() - handed_on.keys() - SHARED.keys():
            writers[name] = stage.stage
        handed_on = dict(entries)
    return found


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in SLOW else name
        for name in sorted(CASES)
    ],
)
def test_stages_read_what_is_declared(name: str) -> None:
    assert undeclared_reads(case_of(name), READS) == []


def test_an_undeclared_read_is_found() -> None:
    case = case_of("generator")
    short = READS | {"run_up": READS["run_up"]._replace(case=("machine.mounts",))}
    assert "run_up: isolation.run_up" in undeclared_reads(case, short)
    alone = READS | {"excitation": READS["excitation"]._replace(after=())}
    assert undeclared_reads(case, alone) == ["excitation: motion of kinematics"]


@pytest.mark.parametrize("name", sorted(CASES))
def test_parts_are_built_from_what_is_declared(name: str) -> None:
    case, seen = case_of(name), set[str]()
    watched = Watched(case, "", seen)
    build_machine(watched.machine, watched.excitation)
    assert undeclared(seen, PARTS) == []


@pytest.mark.parametrize("name", QUICK)
def test_results_are_the_same_to_the_last_bit(name: str) -> None:
    case, cache = case_of(name), StageCache()
    plain = run_case(case)
    assert equal_bits(plain, run_case(case, cache=cache))
    assert equal_bits(plain, run_case(case, cache=cache))
    stages = {stage.module for stage in plan_case(case)}
    assert cache.ran == cache.reused == dict.fromkeys(stages, 1)


#: a key, its values, and the stages that run again when it changes
CHANGES: tuple[tuple[str, str, tuple[Any, Any], set[str]], ...] = (
    ("generator", "machine.mounts.each.stiffness", (2e4, 3e4), {"isolation_pitch", "run_up"}),
    ("generator", "isolation.run_up.to", (500.0, 600.0), {"run_up"}),
    ("generator", "isolation.gravity", (9.8, 0.0), {"isolation_pitch", "run_up"}),
    ("generator", "title", ("one", "two"), set()),
    ("compressor_motor", "machine.motor.skew_angle", (0.1, 0.2), {"motor"}),
    ("compressor_a", "response.method", ("direct", "modal"), {"response"}),
    (
        "compressor_a",
        "machine.speed",
        (100.0, 101.0),
        {"kinematics", "excitation", "response"},
    ),
)


@pytest.mark.parametrize(("name", "key", "values", "again"), CHANGES)
def test_only_stages_with_changed_input_run_again(
    name: str, key: str, values: tuple[Any, Any], again: set[str]
) -> None:
    cases = [validate(case_at(resolved(name), {key: value})) for value in values]
    cache = StageCache()
    for case in (*cases, *cases):
        assert equal_bits(run_case(case), run_case(case, cache=cache))
    stages = {stage.module for stage in plan_case(cases[0])}
    assert cache.ran == {module: 1 + (module in again) for module in stages}


def leaves(table: Any, above: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Key paths of all doubles of a case."""
    if isinstance(table, float):
        return [above]
    if not isinstance(table, dict | list):
        return []
    entries = table.items() if isinstance(table, dict) else enumerate(table)
    return [path for name, entry in entries for path in leaves(entry, (*above, name))]


@pytest.mark.parametrize("name", ["generator", "compressor_a"])
def test_no_change_of_any_number_is_overlooked(name: str) -> None:
    from vibecalc.case.overrides import get_key, key_text
    from vibecalc.machine.checks import check_machine

    tables = {k: v for k, v in resolved(name).items() if k not in ("limit", "reference")}
    cache, tried = StageCache(), 0
    run_case(case_of(name), cache=cache)
    for path in leaves(tables):
        value = get_key(tables, path)
        settings = {key_text(path): value * 1.001 if value else 1e-4}
        try:
            case = validate(case_at(tables, settings))
        except Exception:
            continue
        if check_machine(case):
            continue
        tried += 1
        assert equal_bits(run_case(case), run_case(case, cache=cache)), path
    assert tried > 20


def test_a_negative_zero_is_another_number() -> None:
    cache = StageCache()
    for offset in (0.0, -0.0):
        run_case(
            case_of("generator_180", machine__crank_train__wrist_pin_offset=offset), cache=cache
        )
    assert cache.ran["excitation"] == 2


def test_a_failure_is_told_again_in_the_same_words() -> None:
    case = case_of("generator", machine__mounts__each__damping=0.0)
    frequency = run_case(case)["isolation/pitch/natural_frequency"].values
    singular = case_of(
        "generator", machine__mounts__each__damping=0.0, machine__speed=float(frequency)
    )
    cache, messages = StageCache(), []
    for _ in range(2):
        with pytest.raises(NumericalFailure) as failure:
            run_case(singular, cache=cache)
        messages.append(str(failure.value))
    assert messages[0] == messages[1] and "order 1" in messages[0]
    assert cache.ran["isolation_pitch"] == cache.reused["isolation_pitch"] == 1


def test_what_is_wanted_is_part_of_the_key() -> None:
    case, cache = case_of("generator"), StageCache()
    few = frozenset({"isolation/pitch/inertia"})
    assert set(run_case(case, wanted=few, cache=cache)) == few
    assert equal_bits(run_case(case), run_case(case, cache=cache))
    assert set(run_case(case, wanted=few, cache=cache)) == few


def test_memory_is_bounded_and_results_cannot_be_overwritten() -> None:
    cache = StageCache(most_bytes=50_000)
    cases = [case_of("generator_180", machine__speed=200.0 + n) for n in range(6)]
    for case in cases:
        record = run_case(case, cache=cache)
    assert cache._size <= 50_000 and cache._size == sum(size for _, size in cache._kept.values())
    run_case(cases[0], cache=cache)
    assert cache.ran["isolation_rigid_body"] == 7  # the oldest one was forgotten
    with pytest.raises(ValueError, match="read-only"):
        record["excitation/force"].values[0, 0] = 1.0
