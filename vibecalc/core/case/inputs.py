"""What a result is made from, as one line in its file, and whether that is still so.

The line is JSON: version of vibecalc, name and hash of the case, hashes of the files that it names,
settings of the command line. Whether a result is up to date costs an import of h5py to ask, none of
a schema.
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from vibecalc import __version__
from vibecalc.core.results.layout import PROVENANCE

#: name of the line in the provenance of a result, and how it begins
INPUTS = "inputs"
_BEGIN = '{"made from": '

#: hashes of the files next to a case that have been read, by their names
_seen: ContextVar[dict[str, str] | None] = ContextVar("_seen", default=None)


@contextmanager
def files_seen() -> Iterator[dict[str, str]]:
    """Collect name and hash of every file next to a case that is read meanwhile."""
    seen: dict[str, str] = {}
    before = _seen.set(seen)
    try:
        yield seen
    finally:
        _seen.reset(before)


def see(name: str, content: bytes | Path) -> None:
    """Note that a file of a name next to the case, here its content or place, has been read."""
    seen = _seen.get()
    if seen is not None:
        seen[name] = _hash(content if isinstance(content, bytes) else content.read_bytes())


def inputs(
    case: Path, text: str, files: dict[str, str], settings: Sequence[Any], unset: Sequence[str]
) -> str:
    """The line of a case of this name and text, with the hashes of its files.

    None of a case that is no file, or was changed from Python.
    """
    if not case.is_file() or not all(isinstance(one, str) for one in settings):
        return ""
    made = {
        "vibecalc": __version__,
        "name": case.stem,
        "case": _hash(text.encode()),
        "files": files,
        "set": list(settings),
        "unset": list(unset),
    }
    return f"{_BEGIN}{json.dumps(made, sort_keys=True)}}}"  # in ASCII


def is_up_to_date(result: Path, case: Path, settings: Sequence[Any], unset: Sequence[str]) -> bool:
    """Whether a result file is whole, has its report, and was made from what is there now."""
    with suppress(OSError, ValueError, KeyError, AttributeError):
        line = _line_in(result)
        if not line or not result.with_suffix(".txt").is_file():
            return False
        names = json.loads(line)["made from"]["files"]
        files = {name: _hash((case.parent / name).read_bytes()) for name in names}
        text = case.read_bytes().decode("utf-8-sig")
        return inputs(case, text, files, settings, unset) == line
    return False


def _line_in(path: Path) -> str:
    """The line in a result file. Raises OSError where it is none, or cut short."""
    import h5py

    with h5py.File(path) as file:
        return str(file[PROVENANCE].attrs[INPUTS])


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
