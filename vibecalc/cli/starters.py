"""Starter cases: the files of `vibecalc/starters/`, printed as they are."""

import difflib
from pathlib import Path

from vibecalc.errors import UsageError

FOLDER = Path(__file__).parent.parent / "starters"


def scenes() -> dict[str, str]:
    """What the starter cases are, by name: the first line of each, below that of the editors."""
    return {
        path.stem: path.read_text(encoding="utf-8").splitlines()[1].removeprefix("# ")
        for path in sorted(FOLDER.glob("*.toml"))
    }


def starter(scene: str) -> str:
    """Return a commented starter case as TOML; UsageError with the list for an unknown scene."""
    names = list(scenes())
    if scene not in names:
        near = difflib.get_close_matches(scene[:60], names, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise UsageError(f"no scene {scene[:60]!r}, there is {', '.join(names)}{hint}")
    return (FOLDER / f"{scene}.toml").read_text(encoding="utf-8")
