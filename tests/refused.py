"""What `check` says of a case written as a text."""

from pathlib import Path

from vibecalc.core.study.execute import load_checked
from vibecalc.errors import CaseError


def refusal(folder: Path, stem: str, text: str, **files: str) -> str:
    """The message for a case that is refused, "" if it is taken; `files` are CSV beside it."""
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    path = folder / f"{stem}.toml"
    path.write_text(text, encoding="utf-8")
    try:
        load_checked([path])
    except CaseError as error:
        return str(error)
    return ""
