"""Cases to begin with: starters, printed as they are, and the examples, copied with their files."""

import tomllib
from pathlib import Path

from vibecalc.core.case.raw import nearest
from vibecalc.errors import UsageError, leaves

PACKAGE = Path(__file__).parent.parent
FOLDER = PACKAGE / "starters"


def carried(name: str) -> Path:
    """A folder that goes with the package: inside it once installed, next to it in a checkout."""
    inside = PACKAGE / name
    return inside if inside.is_dir() else PACKAGE.parent / name


# ----------------------------------------------------------------------------
# Starters
# ----------------------------------------------------------------------------


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
        known = f"no starter {scene[:60]!r}; there are {', '.join(names)}"
        raise UsageError("; ".join(filter(None, (known, nearest(scene, names)))))
    return (FOLDER / f"{scene}.toml").read_text(encoding="utf-8")


# ----------------------------------------------------------------------------
# Examples: the cases of `cases/`
# ----------------------------------------------------------------------------


def examples() -> dict[str, str]:
    """Titles of the examples by name; those of a folder below are named `gallery/v8`."""
    folder = carried("cases")
    found = {}
    for path in (*sorted(folder.glob("*.toml")), *sorted(folder.glob("gallery/*.toml"))):
        lines = path.read_text(encoding="utf-8").splitlines()
        title = next(line for line in lines if line.startswith("title = "))
        name = path.relative_to(folder).with_suffix("").as_posix()
        found[name] = tomllib.loads(title)["title"]
    return found


def example_table() -> str:
    """Name and title of each example, a line for each."""
    listed = examples()
    wide = max(map(len, listed))
    return "\n".join(f"{name:<{wide}}  {title}" for name, title in listed.items())


def files_of_example(name: str) -> dict[str, bytes]:
    """A case and all files that it names, by their places in a folder of its own.

    UsageError with the list for an unknown name.
    """
    listed = examples()
    if name not in listed:
        known = f"no example {name[:60]!r}, there is\n{example_table()}"
        raise UsageError("\n".join(filter(None, (known, nearest(name, list(listed))))))
    case = carried("cases") / f"{name}.toml"
    there = {path.relative_to(case.parent).as_posix() for path in case.parent.rglob("*.*")}
    texts = (text for _, text in leaves(tomllib.loads(case.read_text(encoding="utf-8"))))
    named = dict.fromkeys([case.name, *(text for text in texts if text in there)])
    return {one: (case.parent / one).read_bytes() for one in named}
