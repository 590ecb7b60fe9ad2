"""Claim: `--set` changes exactly the key it names, to what TOML reads, and nothing else."""

import copy
import math
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from fuzzing import leaves
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.case.raw import (
    apply_overrides,
    field_unit,
    get_key,
    parse_key,
    parse_override,
    set_key,
)
from vibecalc.errors import KeyPath, UsageError, dotted

GENERATOR = Path(__file__).parent.parent / "cases" / "generator.toml"
words = st.from_regex(r"[A-Za-z0-9_-]{1,8}", fullmatch=True)
paths = st.builds(
    lambda first, rest: (first, *rest), words, st.lists(words | st.integers(0, 99), max_size=5)
)


@settings(max_examples=30)
@given(paths)
def test_keys_are_read_as_they_are_written(path: KeyPath) -> None:
    assert parse_key(dotted(path)) == path


@given(st.text(max_size=40))
def test_any_key_is_a_path_or_a_usage_error(text: str) -> None:
    try:
        path = parse_key(text)
    except UsageError:
        return
    assert dotted(path) == text


@given(
    st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False)
    | st.booleans()
    | st.lists(st.integers(0, 9), max_size=3)
    | st.from_regex(r"[ -~]{0,20}", fullmatch=True)
)
def test_values_are_toml(value: Any) -> None:
    written = tomli_w.dumps({"x": value}).removeprefix("x = ").replace("\n", " ")
    _, read = parse_override(f"a.b={written}")
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("machine.speed=4900 rpm", "4900 rpm"),
        ("machine.speed = 4900 rpm", "4900 rpm"),
        ('machine.speed="4900 rpm"', "4900 rpm"),
        ("isolation.model=pitch", "pitch"),
        ("machine.speed=-300 mm", "-300 mm"),
        ("a=1_000", 1000),
        ("a={ x = 1 }", {"x": 1}),
        ("a=1979", 1979),
        ("a=x == y", None),
        ("a=1\nb=2", None),
        ("a=", None),
        ("a='x", None),
        ("a=f(x)[0]", None),
        ("a=\udcff", None),
    ],
)
def test_what_a_shell_leaves(text: str, value: Any) -> None:
    if value is None:
        with pytest.raises(UsageError):
            parse_override(text)
    else:
        assert parse_override(text)[1] == value


RESOLVED = load_case(GENERATOR).resolved
SPOTS = leaves(RESOLVED)


@settings(max_examples=50, deadline=None)
@given(st.sampled_from(SPOTS), st.floats(0.001, 1000.0))
def test_only_the_named_key_changes(path: KeyPath, value: float) -> None:
    changed = copy.deepcopy(RESOLVED)
    apply_overrides(changed, [f"{dotted(path)}={value!r}"])
    assert get_key(changed, dotted(path)) == value
    set_key(changed, path, get_key(RESOLVED, path))
    assert changed == RESOLVED


def test_an_override_is_the_same_as_writing_it() -> None:
    text = "machine.crank_train.cylinders[1].position=12 mm"
    loaded = load_case(GENERATOR, [text, "isolation.run_up.to=3000 rpm"])
    assert loaded.resolved["machine"]["crank_train"]["cylinders"][1]["position"] == 12e-3
    assert math.isclose(loaded.resolved["isolation"]["run_up"]["to"], 100 * math.pi, rel_tol=1e-15)
    again = load_case(GENERATOR, [text, "isolation.run_up.to=50 Hz"])
    assert again.resolved == loaded.resolved
    assert again.sha256 == loaded.sha256 != load_case(GENERATOR).sha256


def test_a_missing_table_is_made_and_a_missing_entry_is_not() -> None:
    data: dict[str, Any] = {"a": [{"b": 1}]}
    set_key(data, "c.d.e", 3)
    assert data == {"a": [{"b": 1}], "c": {"d": {"e": 3}}}
    for key in ("a[1].b", "a.b", "a[0].b.c", "c[0]"):
        with pytest.raises(UsageError):
            set_key(data, key, 1)
    with pytest.raises(UsageError, match="did you mean 'd'"):
        get_key(data, "c.dd")


def test_every_number_of_a_case_has_a_unit() -> None:
    changed = copy.deepcopy(RESOLVED)
    for path in SPOTS:
        if path[0] not in ("reference", "limit"):
            set_key(changed, path, f"{get_key(RESOLVED, path)!r} {field_unit(path)}")
    assert changed != RESOLVED and resolve(validate(changed)) == RESOLVED
