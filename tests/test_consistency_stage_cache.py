"""Claim: a stage is run again if, and only if, what it reads has changed; results are the same.

What a stage reads is recorded when it runs. Truth: runs without a cache, to the last digit.
"""

import random
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import NOT_COMPUTED, case_at
from vibecalc.core.case.walk import Shape, keys_of, shape_at
from vibecalc.core.results.record import Record
from vibecalc.core.run import machine_checks
from vibecalc.core.run.machine_checks import OF_PARTS, check_machine
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import StageCache, check_again, run_case
from vibecalc.core.run.stage import subjects
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, KeyPath, NumericalFailure, dotted
from vibecalc.schema import Case

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
        "response.switching.time_after='0.1 s'",
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


def equal(one: Record, other: Record) -> bool:
    """Whether two records have the same numbers to the last digit, in order, and the same words."""
    return list(one) == list(other) and one == other


#: a key, its values, and the stages that run again when it changes
CHANGES: tuple[tuple[str, str, tuple[Any, Any], set[str]], ...] = (
    ("generator", "machine.mounts.each.stiffness", (2e4, 3e4), {"isolation", "run_up"}),
    ("generator", "isolation.run_up.to", (500.0, 600.0), {"run_up"}),
    ("generator", "isolation.gravity", (9.8, 0.0), {"isolation", "run_up"}),
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
        assert equal(run_case(case), run_case(case, cache=cache))
    stages = {stage.name for stage in plan_case(cases[0])}
    assert cache.ran == {module: 1 + (module in again) for module in stages}


#: tables in which a key changes nothing that is computed at a point
NO_INPUT = (*NOT_COMPUTED, "schema", "title", "source")


def others(shape: Shape, value: Any, names: list[str]) -> list[Any]:
    """Values to try at a place; `value` is the one that it has, None of a key left out."""
    if shape.kind in ("number", "whole") and isinstance(value, list):
        return [[one * 1.001 for one in value]]
    if shape.kind == "number":
        tried = (0.5, 1.0, 0.02, 30.0) if value is None else (1.001 * value, 0.9 * value, 1e-4)
        return [float(one) for one in tried if one != value]
    if shape.kind == "whole":
        return [1, 2] if value is None else [value + 1, value - 1]
    if shape.kind == "flag":
        return [not value]
    if shape.kind == "choice":
        return [one for one in shape.choices if one != value]
    if shape.kind == "text":
        return names if value is None else []
    if shape.kind == "table":
        return [{}] if value is None else []
    if shape.kind == "list" and shape.item is not None and value is None:
        return [[one] for one in others(shape.item, None, names)]
    return []


def changes(place: Any, path: KeyPath, names: list[str]) -> Iterator[tuple[KeyPath, list[Any]]]:
    """Keys below a place of a case, written or left out, each with other values to try.

    Of a list the first and the last entry.
    """
    shape = shape_at(path) if path else Shape(kind="table", table=Case)
    if shape is None:
        return
    if shape.table is not None and isinstance(place, dict):
        for key in keys_of(shape.table):
            if path or key not in NO_INPUT:
                yield from changes(place.get(key), (*path, key), names)
    elif isinstance(place, list) and place and shape.item is not None:
        for entry in sorted({0, len(place) - 1}):
            yield from changes(place[entry], (*path, entry), names)
    elif path:
        yield path, others(shape, place, names)


def overlooked(name: str, count: int) -> tuple[int, int]:
    """Change keys of a shipped case, one after another: so many drawn ones, or for 0 all of them.

    Returns how many changes were runs, and in how many of these stages were used again. Each is
    held against a run without a cache.
    """
    tables = {k: v for k, v in resolved(name).items() if k not in NOT_COMPUTED}
    cylinders = tables["machine"].get("crank_train", {}).get("cylinders", [])
    every = list(changes(tables, (), [one["name"] for one in cylinders if "name" in one]))
    random.Random(name).shuffle(every)
    cache, ran, used = StageCache(), 0, 0
    outcome(validate(tables), cache)
    for path, values in every:
        for value in values:
            try:
                case = validate(case_at(tables, {dotted(path): value}))
            except CaseError:
                continue
            if check_again(case, cache):
                continue
            before = sum(cache.reused.values())
            found = outcome(case, cache)
            ran += 1
            if sum(cache.reused.values()) > before:
                used += 1
                assert check_machine(case) == []
                assert same(found, outcome(case, None)), (path, value)
            break
        if count and ran == count:
            break
    return ran, used


def outcome(case: Case, cache: StageCache | None) -> Record | str:
    """The record of a run, or why there is none."""
    try:
        return run_case(case, cache=cache)
    except NumericalFailure as failure:
        return str(failure)


def same(one: Record | str, other: Record | str) -> bool:
    """Whether two runs ended alike, to the last digit."""
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return equal(one, other)


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("name", sorted(CASES))
def test_no_change_of_any_key_is_overlooked(name: str) -> None:
    """Every change of the quick cases; of the others 40 at most, drawn by the name of the case."""
    ran, used = overlooked(name, 0 if name in QUICK else 40)
    assert ran > 5
    # a case of one stage can use it again only where a key changes nothing
    assert used > 0 or len(plan_case(case_of(name))) == 1


@pytest.mark.parametrize("name", ["generator", "compressor_motor"])
def test_no_change_of_some_keys_is_overlooked(name: str) -> None:
    ran, used = overlooked(name, 10)
    assert ran == 10 and used > 2


def test_a_negative_zero_is_another_number() -> None:
    cache = StageCache()
    for offset in (0.0, -0.0):
        run_case(
            case_of("generator_180", machine__crank_train__wrist_pin_offset=offset), cache=cache
        )
    assert cache.ran["excitation"] == 2


def test_a_failure_is_reported_again_in_the_same_words() -> None:
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
    assert cache.ran["isolation"] == cache.reused["isolation"] == 1


def test_what_is_wanted_is_part_of_the_key() -> None:
    case, cache = case_of("generator"), StageCache()
    few = frozenset({"isolation/pitch/inertia"})
    assert set(run_case(case, wanted=few, cache=cache)) == few
    assert equal(run_case(case), run_case(case, cache=cache))
    assert set(run_case(case, wanted=few, cache=cache)) == few


def test_memory_is_bounded_and_results_cannot_be_overwritten() -> None:
    cache = StageCache(most_bytes=50_000)
    cases = [case_of("generator_180", machine__speed=200.0 + n) for n in range(6)]
    for case in cases:
        record = run_case(case, cache=cache)
    assert cache._size <= 50_000 and cache._size == sum(size for _, size in cache._stored.values())
    run_case(cases[0], cache=cache)
    assert cache.ran["isolation"] == 7  # the oldest one was forgotten
    with pytest.raises(ValueError, match="read-only"):
        record["excitation/force"].values[0, 0] = 1.0


# ----------------------------------------------------------------------------
# Every check belongs to the parts or to a subject, which a study runs or skips.
# ----------------------------------------------------------------------------

#: these are called by others of them
WITHIN = {
    *("matrix_problems", "planar_problems", "study_problems"),
    *("mount_problems", "articulated_problems", "fit_problems"),
}


def test_all_checks_take_part() -> None:
    """Every function of a case that gives problems is a check of the parts or of a subject."""
    named = {check.__name__ for check in OF_PARTS} - {"matrices", "mounts", "slave_rods"}
    for subject in subjects().values():
        named |= {one.partition(":")[2] for one in (*subject.checks, *subject.last_checks)}
    pattern = r"^def (\w+_problems)\(case: \"?Case\"?\) -> (?:list|Iterator)\["
    package = Path(machine_checks.__file__).parents[2]
    offers = {
        name
        for path in package.rglob("*.py")
        for name in re.findall(pattern, path.read_text(encoding="utf-8"), re.M)
    }
    assert offers - WITHIN == named
    assert offers >= WITHIN
