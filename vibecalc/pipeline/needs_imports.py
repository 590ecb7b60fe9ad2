"""Which modules a module brings in, read from the sources: nothing is imported to find out.

What stands at the start of a line is imported with the module. What is indented is imported when
a function runs; `needs_lazy.py` says for which cases that is. Imports for type checkers alone do
not count, nor do packages, which hold a docstring only.
"""

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

PACKAGE = "vibecalc"
#: libraries whose import costs something; the others come with every command
LIBRARIES = ("numpy", "scipy", "matplotlib", "mpmath", "h5py", "pint", "rich")
_ROOT = Path(__file__).resolve().parents[1]
_FOR_CHECKERS = re.compile(r"^if TYPE_CHECKING:\n(?:[ \t]+.*\n|\n)+", re.MULTILINE)
_IMPORT = re.compile(
    rf"^([ \t]*)(?:from ((?:{'|'.join((PACKAGE, *LIBRARIES))})\b[\w.]*) import "
    rf"(\([^)]*\)|[^\n(]+)|import ((?:{'|'.join(LIBRARIES)})\b[\w.]*))",
    re.MULTILINE,
)
_NAME = re.compile(r"\w+")
#: remarks and own names in a list of names
_REMARK = re.compile(r"#[^\n]*| as \w+")


class Imports(NamedTuple):
    """Names of modules: `at_once` with the module itself, `later` when a function needs them."""

    at_once: frozenset[str]
    later: frozenset[str]


@cache
def imports_of(module: str) -> Imports:
    """What the source of a module of this package says; a library imports nothing here."""
    path = source_of(module)
    if path is None:
        return Imports(frozenset(), frozenset())
    text = _FOR_CHECKERS.sub("", path.read_text(encoding="utf-8"))
    at_once: set[str] = set()
    later: set[str] = set()
    for indent, origin, names, plain in _IMPORT.findall(text):
        found = (plain,) if plain else _modules(origin, names)
        (later if indent else at_once).update(found)
    return Imports(frozenset(at_once), frozenset(later - at_once))


@cache
def brought_in(module: str) -> frozenset[str]:
    """`module` with all that is imported at once with it, and with those in turn."""
    found = {module}
    waiting = [module]
    while waiting:
        fresh = imports_of(waiting.pop()).at_once - found
        found |= fresh
        waiting += fresh
    return frozenset(found)


@cache
def source_of(module: str) -> Path | None:
    """The file of a module of this package; None for a library or a package."""
    first, _, rest = module.partition(".")
    path = _ROOT.joinpath(*rest.split(".")).with_suffix(".py") if rest else None
    return path if first == PACKAGE and path is not None and path.is_file() else None


def _modules(origin: str, names: str) -> set[str]:
    """The modules that `from origin import names` loads."""
    if origin.split(".")[0] != PACKAGE or source_of(origin) is not None:
        return {origin}
    inside = (f"{origin}.{name}" for name in _NAME.findall(_REMARK.sub("", names)))
    return {name for name in inside if source_of(name) is not None}
