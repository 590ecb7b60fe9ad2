"""What is said of cases that are refused, and what was accepted of that: `snapshots/refused/`.

    python tests/refused.py

writes these files anew, one for each module of `SUBJECTS`: messages by the name of the case, its
folder left out. A module names its cases in `MESSAGES`, name -> what makes the message in a folder.
"""

import importlib
import sys
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, Problem

HERE = Path(__file__).resolve().parent / "snapshots" / "refused"
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
        return check_machine(validate(data))
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
    """The message for a case that is refused, "" if it is taken; `files` are CSV next to it."""
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / f"{stem}.toml"
    path.write_text(text, encoding="utf-8")
    return refused(path)


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


if __name__ == "__main__":
    sys.exit(main())
