"""What `check` says of a case written as a text, or of one as plain tables."""

from pathlib import Path
from typing import Any

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError, Problem


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
