"""What is said of cases that are refused: whole messages as accepted, or a table with words.

    python tests/refused.py

writes `snapshots/refused/` anew, a file for each module of `SUBJECTS`: messages by the name of the
case, its folder left out. A module names its cases in `MESSAGES`, name -> what makes the message in
a folder.

A row of `refusals/NAME.txt` is `case :: change :: place :: words`. Parts of a change and of the
words are joined by `&&`. Changes of a text: `old -> new` of what stands there once, `old => new`
wherever it stands, `+ line` at the end, `old ...` leaves out everything from there on; `-` is none.
Changes of tables are a JSON object of keys and values, null for a key that is taken away. A row of
`refusals/messages_NAME.txt` is `name :: case :: change`, its message one of those accepted.
"""

import copy
import importlib
import json
import re
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import get_key, parse_key, set_key
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.targets import check_targets
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, Problem

HERE = Path(__file__).resolve().parent / "snapshots" / "refused"
TABLES = Path(__file__).resolve().parent / "refusals"
SUBJECTS = (
    "bad_cases",
    "bad_cases_compressor",
    "bad_cases_engine",
    "bad_cases_files",
    "bad_cases_machine",
)
MARK = "\n== "

Message = Callable[[Path], str]


def problems_of(data: dict[str, Any]) -> list[Problem]:
    """All problems of a case as plain tables: those of its form, or else of its physics."""
    try:
        case = validate(data)
        return check_machine(case) + check_targets(case)
    except CaseError as error:
        return list(error.problems)


def told(problems: Iterable[Problem]) -> str:
    """Problems as text, each with its key and the other one that it points to."""
    rows = []
    for one in problems:
        also = f", see {_key(one.also)}" if one.also else ""
        rows += [f"{_key(one.path)}{also}", f"  {one.message}", f"  found {one.found}"]
        rows += [f"  allowed: {one.allowed}", *([f"  help: {one.hint}"] if one.hint else [])]
    return "\n".join(rows)


def _key(path: Iterable[str | int]) -> str:
    return ".".join(map(str, path))


def refusal(folder: Path, stem: str, text: str, **files: str) -> str:
    """The message for a case that is refused, "" if it is taken; `files` are CSV next to it.

    Without the folder, whose name may hold the very words that are looked for.
    """
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / f"{stem}.toml"
    path.write_text(text, encoding="utf-8")
    return _without(folder, refused(path))


def refused(path: Path) -> str:
    """The message for a case file that is refused, "" if it is taken."""
    try:
        load_checked([path])
    except CaseError as error:
        return str(error)
    return ""


def hold(subject: str, name: str, message: Message, folder: Path) -> None:
    """The message is the accepted one, letter for letter, and no accident of the program."""
    said = _without(folder, message(folder))
    assert said, "nothing found wrong"
    assert "Traceback" not in said and "pydantic" not in said
    assert said == kept(subject).get(name, "")


@cache
def kept(subject: str) -> dict[str, str]:
    """Accepted messages of a subject by name."""
    text = (HERE / f"{subject}.txt").read_text(encoding="utf-8")
    blocks = (block.partition("\n") for block in f"\n{text}".split(MARK)[1:])
    return {name: said.rstrip("\n") for name, _, said in blocks}


def _without(folder: Path, said: str) -> str:
    return said.replace(f"{folder}/", "").rstrip("\n")


def main() -> None:
    for subject in SUBJECTS:
        messages: dict[str, Message] = importlib.import_module(f"test_{subject}").MESSAGES
        said = []
        for name, message in messages.items():
            with tempfile.TemporaryDirectory() as folder:
                said.append(f"{MARK}{name}\n{_without(Path(folder), message(Path(folder)))}")
        (HERE / f"{subject}.txt").write_text("\n".join(said)[1:] + "\n", encoding="utf-8")


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


def rows_with_messages(subject: str, *cases: str) -> dict[str, tuple[str, str]]:
    """Case and change by the name of the row, all or those of some cases; `hold` has the words."""
    lines = (TABLES / f"messages_{subject}.txt").read_text(encoding="utf-8").splitlines()
    rows = (line.split(" :: ") for line in lines if not line.startswith("#"))
    return {name: (case, change) for name, case, change in rows if not cases or case in cases}


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


if __name__ == "__main__":
    sys.exit(main())
