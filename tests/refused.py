"""What `check` says of a case written as a text, or of one as plain tables; tables of refusals.

A row of `refusals/NAME.txt` is `case :: change :: place :: words`. Parts of a change and of the
words are joined by `&&`. Changes of a text: `old -> new` of what stands there once, `old => new`
wherever it stands, `+ line` at the end, `old ...` leaves out everything from there on; `-` is none.
Changes of tables are a JSON object of keys and values, null for a key that is taken away.
"""

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import get_key, parse_key, set_key
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, Problem

TABLES = Path(__file__).parent / "refusals"


def refusals(name: str, *cases: str) -> list[Any]:
    """Parameters (case, change, place, words) of rows of some cases, named by their first words."""
    found = []
    for line in (TABLES / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            case, change, place, words = line.split(" :: ")
            expected = words.split(" && ")
            if not cases or case in cases:
                found.append(pytest.param(case, change, place, expected, id=expected[0]))
    return found


def changed(text: str, change: str) -> str:
    """The text of a case with the changes of a row."""
    for part in change.replace("\\n", "\n").split(" && ") if change != "-" else ():
        if part.startswith("+ "):
            text += part.removeprefix("+ ") + "\n"
            continue
        old, sign, new = re.split(r" (->|=>|\.\.\.)(?: |$)", part, maxsplit=1)
        assert old in text and (sign != "->" or text.count(old) == 1), part
        text = text[: text.index(old)] if sign == "..." else text.replace(old, new)
    return text


def with_keys(data: dict[str, Any], change: str, **parts: Any) -> dict[str, Any]:
    """The tables with the keys of a row; a text that names one of `parts` stands for it."""
    found = copy.deepcopy(data)
    for key, value in json.loads(change).items():
        if value is None:
            *above, last = parse_key(key)
            get_key(found, above).pop(last)
        else:
            set_key(found, key, copy.deepcopy(parts.get(str(value), value)))
    return found


def said_of(problem: Problem) -> str:
    """All words of a problem."""
    return " | ".join((problem.message, problem.found, problem.allowed, problem.hint))


def problems_of(data: dict[str, Any]) -> list[Problem]:
    """All problems of a case as plain tables: those of its form, or else of its physics."""
    try:
        return check_machine(validate(data))
    except CaseError as error:
        return list(error.problems)


def refusal(folder: Path, stem: str, text: str, **files: str) -> str:
    """The message for a case that is refused, "" if it is taken; `files` are CSV next to it."""
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / f"{stem}.toml"
    path.write_text(text, encoding="utf-8")
    try:
        load_checked([path])
    except CaseError as error:
        return str(error)
    return ""
