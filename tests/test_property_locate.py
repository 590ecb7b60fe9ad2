"""Claim: every key, table and list entry of any TOML text is found where it stands.

The oracle is tomllib: the piece of text that is said to be the value at a path is, read alone, the
value that tomllib has at that path. Texts are random nested tables, written by tomli_w and by a
writer of our own that uses inline tables, dotted keys, comments and odd spacing.
"""

import random
import time
import tomllib
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.core.case.locate import Overridden, find_spans, locate
from vibecalc.errors import KeyPath

keys = st.sampled_from(
    ["a", "b", "rod", "x-1", "2", "with space", "dot.ted", 'quo"te', "#", "=", ""]
)
scalars = (
    st.integers(-(10**6), 10**6)
    | st.floats(allow_nan=False)
    | st.booleans()
    | st.text(max_size=8)
    | st.sampled_from(["[a]", "# no", "x = 1", '"""', "'", "\\", "}", "two\nlines", "a,b"])
)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3),
    max_leaves=12,
)
tables = st.dictionaries(keys, values, max_size=5)


def leaves(value: Any, path: KeyPath = ()) -> list[tuple[KeyPath, Any]]:
    """All paths of a document with their values."""
    found: list[tuple[KeyPath, Any]] = [(path, value)] if path else []
    if isinstance(value, dict):
        for key, entry in value.items():
            found += leaves(entry, (*path, key))
    elif isinstance(value, list):
        for position, entry in enumerate(value):
            found += leaves(entry, (*path, position))
    return found


def name(key: str) -> str:
    """Write a key, bare where it may be."""
    return tomli_w.dumps({key: 0}).removesuffix(" = 0\n")


def write(value: Any, dice: random.Random) -> str:
    """Write a value inline, with odd spacing and comments where they may stand."""
    gap = dice.choice(["", " ", "  "])
    if isinstance(value, dict):
        pairs = (f"{name(key)}{gap}={gap}{write(entry, dice)}" for key, entry in value.items())
        return "{" + gap + ", ".join(pairs) + gap + "}"
    if isinstance(value, list):
        loose = dice.choice(["", " ", "\n", " # [x] = '''\n\t"])
        return "[" + "".join(f"{loose}{write(entry, dice)}{gap},{loose}" for entry in value) + "]"
    if isinstance(value, str) and "\\" not in value and "'" not in value and value.isprintable():
        return dice.choice([f"'{value}'", f"'''{value}'''"])
    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")


def check(text: str) -> None:
    """Hold all places of a text against tomllib."""
    text = text.replace("\r\n", "\n")
    spans = find_spans(text)
    for path, value in leaves(tomllib.loads(text)):
        span = spans[path]
        place = locate(path, text)
        assert place.excerpt == text.split("\n")[place.line - 1]
        assert text[span.start :].startswith(place.excerpt[place.column - 1 :][: place.length])
        if (
            span.value_stop > span.value_start
            and text[span.start] != "["
            and not isinstance(value, dict)
        ):
            assert tomllib.loads(f"x = {text[span.value_start : span.value_stop]}")["x"] == value


@settings(max_examples=25, deadline=None)
@given(tables, st.integers(0, 10**6))
def test_inline_texts(document: dict[str, Any], seed: int) -> None:
    dice = random.Random(seed)
    lines = [f"{name(key)} = {write(value, dice)} # end\n" for key, value in document.items()]
    check(dice.choice(["", "\n", "# = [\n"]).join(lines))


WRITTEN = '''# comment = 1
title = """multi
line = 3 [x] "quoted" \\""" ""
end"""
literal = \'\'\'a 'b' "c" # no comment\'\'\'
date = 1979-05-27 07:32:00
a.b . c = 1
a.b.d = 2
[ table . "sub table" ]   # [not]
key = { one = 1, two.three = [1, { four = "]" }] }
list = [ [1, 2], # ]
  [ 3,
    4 ] ]
[[many]]
name = "first"
[many.inner]
x = 1
[[many.deep]]
y = 1
[[many]]
name = "second"
[[many.deep]]
y = 2
[[many.deep]]
y = 3
'''


@pytest.mark.parametrize(
    ("path", "line", "column", "piece"),
    [
        (("title",), 2, 1, "title"),
        (("date",), 6, 1, "date"),
        (("a",), 7, 1, "a"),
        (("a", "b", "c"), 7, 7, "c"),
        (("a", "b", "d"), 8, 5, "d"),
        (("table", "sub table"), 9, 1, '[ table . "sub table" ]'),
        (("table", "sub table", "key", "two", "three"), 10, 22, "three"),
        (("table", "sub table", "key", "two", "three", 1, "four"), 10, 36, "four"),
        (("table", "sub table", "list", 1, 1), 13, 5, "4"),
        (("many", 1, "name"), 21, 1, "name"),
        (("many", 0, "inner", "x"), 17, 1, "x"),
        (("many", 1, "deep", 1, "y"), 25, 1, "y"),
        (("many", 1, "absent"), 20, 1, "[[many]]"),
        (("table", "sub table", "absent", "below"), 9, 1, '[ table . "sub table" ]'),
        (("nowhere",), 1, 1, "#"),
    ],
)
def test_places_in_a_written_text(path: KeyPath, line: int, column: int, piece: str) -> None:
    check(WRITTEN)
    place = locate(path, WRITTEN)
    assert (place.line, place.column) == (line, column)
    assert place.excerpt[column - 1 : column - 1 + place.length] == piece
    windows = locate(path, WRITTEN.replace("\n", "\r\n"))
    assert windows == place


def test_overridden_keys_are_on_the_command_line() -> None:
    overrides = [
        Overridden(("machine", "speed"), "--set machine.speed=1"),
        Overridden(("new", "table", "key"), "--set new.table.key=2"),
        Overridden(("machine", "speed"), "--set machine.speed=3"),
    ]
    text = "[machine]\nspeed = 5\nkind = 'x'\n"
    assert locate(("machine", "speed"), text, overrides).override == "--set machine.speed=3"
    assert locate(("new", "table", "absent"), text, overrides).override == "--set new.table.key=2"
    assert locate(("machine", "kind"), text, overrides)[:2] == (3, 1)


@settings(max_examples=100, deadline=None)
@given(st.text(alphabet="ab.=[]{}\"'#, \n\\1", max_size=60))
def test_no_text_raises(text: str) -> None:
    place = locate(("a", "b", 0), text)
    assert place.line >= 1
    assert place.column >= 1


@pytest.mark.parametrize(
    "text",
    [
        "[" * 300_000,
        "a = [" + "1, " * 100_000 + "]",
        'a = "' + "\\n" * 400_000 + '"',
        'a = """' + '"' * 900_000,
        "a = [" + "\n# comment" * 90_000 + "\n]",
        " " * 900_000 + "=",
    ],
)
def test_a_megabyte_of_nonsense_takes_no_time(text: str) -> None:
    start = time.process_time()
    assert locate(("a", 5, "b"), text).line >= 1
    assert time.process_time() - start < 30.0  # a guard against quadratic work, no measurement
