"""Mutations of case files, and a run of the command line inside this process."""

import io
import random
import re
import signal
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import tomli_w

from vibecalc.errors import KeyPath

CASES = Path(__file__).resolve().parents[1] / "cases"
ALLOWED = {0, 1, 2, 3}

NUMBERS = ("nan", "inf", "-inf", "0", "-1", "1e300", "1e-300", "-0.0", "9999999999999999999",
           "1e9", "0.5", "3", "true", '""', '"abc"', '"3 kg"', '"1e400 m"', '"5 furlong"', "[]",
           "{}", "[1, 2, 3]", '"5 %"', '"0 m"', "1979-05-27", '"\\u0000"', "'nan m'")  # fmt: skip
VALUES: tuple[Any, ...] = (
    float("nan"), float("inf"), 0, -1, 1e300, 1e-300, 10**20, True, "", "abc", "3 kg", "1 mm", [],
    {}, [1.0, 2.0, 3.0], "1e-320 m", 0.5, 2, "120 deg", "-5 N/m", 1e-12, 1e6,
)  # fmt: skip


class Outcome(NamedTuple):
    """What a command did: exit code and what it printed."""

    code: int
    out: str
    err: str


class TooSlow(Exception):
    """A command that took longer than its cap."""


def mutations(seed: int, count: int) -> Iterator[str]:
    """`count` broken or odd cases, the same for the same seed."""
    rng = random.Random(seed)
    sources = [path.read_text(encoding="utf-8") for path in sorted(CASES.glob("*.toml"))]
    sources = [_without_references(text) for text in sources] + sources[:1]
    for _ in range(count):
        text = rng.choice(sources)
        for _ in range(rng.choice((1, 1, 1, 2, 4))):
            text = rng.choice(MUTATORS)(rng, text)
        yield text


def _without_references(text: str) -> str:
    return text.split("[[reference", 1)[0]


def _change_number(rng: random.Random, text: str) -> str:
    found = list(re.finditer(r'"?-?\d[\d.]*[^",\]}\n]*"?', text))
    if not found:
        return text
    spot = rng.choice(found)
    return text[: spot.start()] + rng.choice(NUMBERS) + text[spot.end() :]


def _edit_lines(rng: random.Random, text: str) -> str:
    lines = text.splitlines(keepends=True) or [""]
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    what = rng.randrange(4)
    if what == 0:
        del lines[i]
    elif what == 1:
        lines.insert(j, lines[i])
    elif what == 2:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        lines = lines[: max(i, 1)]
    return "".join(lines)


def _edit_characters(rng: random.Random, text: str) -> str:
    if not text:
        return text
    i = rng.randrange(len(text))
    new = rng.choice(["", rng.choice('"[]{}=#.,-\n\\\x00\x7fé😀 aZ09'), text[i] * 2])
    return text[:i] + new + text[i + 1 :]


def _misspell(rng: random.Random, text: str) -> str:
    words = list(re.finditer(r"[a-z_]{4,}", text))
    if not words:
        return text
    word = rng.choice(words)
    i = rng.randrange(word.start(), word.end())
    return text[:i] + text[i + 1 :]


def _change_leaf(rng: random.Random, text: str) -> str:
    """Put something else at one place of the parsed case, or take the place away."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return text
    holders: list[tuple[Any, Any]] = []

    def walk(node: Any) -> None:
        keys = list(node) if isinstance(node, dict) else range(len(node))
        for key in keys:
            holders.append((node, key))
            if isinstance(node[key], dict | list):
                walk(node[key])

    walk(data)
    if not holders:
        return text
    holder, key = rng.choice(holders)
    if rng.random() < 0.3:
        del holder[key]
    else:
        holder[key] = rng.choice(VALUES)
    return tomli_w.dumps(data)


MUTATORS = (_change_number, _change_number, _change_leaf, _change_leaf, _edit_lines,
            _edit_characters, _misspell)  # fmt: skip


def leaves(value: Any, path: KeyPath = (), kind: type = float) -> list[KeyPath]:
    """Key paths of all values of a case that are of a kind: without another, its numbers."""
    if isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else enumerate(value)
        return [leaf for key, entry in entries for leaf in leaves(entry, (*path, key), kind)]
    return [path] if isinstance(value, kind) else []


@contextmanager
def _capped(seconds: int) -> Iterator[None]:
    def stop(_signal: int, _frame: FrameType | None) -> None:
        raise TooSlow

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def command(*arguments: str, cap: int = 20) -> Outcome:
    """Run `vibecalc` in this process. Exit code 70 and a traceback stand for a bug."""
    from vibecalc.__main__ import main

    out, err = io.StringIO(), io.StringIO()
    argv = sys.argv
    sys.argv = ["vibecalc", *arguments]
    try:
        with redirect_stdout(out), redirect_stderr(err), _capped(cap):
            main()
    except SystemExit as stop:
        return Outcome(int(stop.code or 0), out.getvalue(), err.getvalue())
    finally:
        sys.argv = argv
    raise AssertionError("main() came back")
