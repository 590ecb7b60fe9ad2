"""What a run made a result from, as a line behind it in its file, and whether that is still so.

The line is JSON: versions of vibecalc, Python and the libraries, name and hash of the case, hashes
of the files that it names, settings of the command line. The last line is the hash of the report.
Both stand behind the end that the file states for its HDF5 data, where readers of HDF5 do not look,
and plain reading finds them without one; who changes the file with HDF5 cuts them off.
"""

import json
import os
import platform
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from vibecalc import __version__
from vibecalc.core.results.case_hash import text_hash
from vibecalc.errors import UsageError

#: bytes at the end of a result file in which the lines are looked for
_LONGEST = 1_000_000
_VERSION = re.compile(r"^Version: *(\S+)", re.MULTILINE)

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


def see(name: str, content: bytes) -> None:
    """Note that a file of a name next to the case has been read."""
    seen = _seen.get()
    if seen is not None:
        seen[name] = text_hash(content)


def inputs(
    case: Path, text: str, files: dict[str, str], settings: Sequence[Any], unset: Sequence[str]
) -> str:
    """The line of a case of this name and text, with the hashes of its files.

    None of a case that is no file, or was changed from Python.
    """
    if not case.is_file() or not all(isinstance(one, str) for one in settings):
        return ""
    made = {
        "versions": versions(),
        "name": case.stem,
        "case": text_hash(text),
        "files": files,
        "set": list(settings),
        "unset": list(unset),
    }
    return json.dumps(made, sort_keys=True)  # in ASCII


def versions() -> dict[str, str]:
    """Versions of all that numbers and files hang on, without importing it."""
    libraries = {name: _version(name) for name in ("numpy", "scipy", "h5py")}
    return {"vibecalc": __version__, "python": platform.python_version(), **libraries}


def _version(name: str) -> str:
    """The line of a package that says it; `importlib.metadata.version` parses all its words."""
    from importlib.metadata import distribution

    package = distribution(name)
    said = package.read_text("METADATA") or package.read_text("PKG-INFO") or ""
    found = _VERSION.search(said)
    assert found is not None, f"{name} is installed without its version"
    return found[1]


def dependencies(target: Path, case: Path, line: str) -> str:
    """A rule of make: `target` has to be made again where the case or a file that it reads changes.

    `line` is what `inputs` says of the case. Each file is a target without a recipe, too, so that
    make asks for none that has been renamed since. UsageError for names that make cannot take.
    """
    files = [case, *(case.parent / name for name in json.loads(line)["files"])]
    names = " \\\n  ".join(_for_make(str(file)) for file in files)
    first, *others = (_for_make(str(one)) for one in (target, *files[1:]))
    return f"{first}: {names}\n" + "".join(f"\n{name}:\n" for name in others)


def _for_make(name: str) -> str:
    """A file name as make reads it back; GNU make 4 has no way to write the characters refused."""
    if set(name) & set("\n\r;|=%\\*?[]~"):
        raise UsageError(
            f"make cannot take the file name {name!r}: rename it, or leave out --depfile"
        )
    return re.sub(r"([\s#:])", r"\\\1", name).replace("$", "$$")


def last_lines(line: str, report: bytes) -> bytes:
    """What stands at the end of the file of a result with this line and report; b"" without one."""
    return f"\n{line}\n{text_hash(report)}".encode() if line else b""


def mark(result: Path, line: str, report: bytes) -> None:
    """Put the lines behind a result file in its place; one without them would be made again."""
    with suppress(OSError), open(result, "ab") as stream:
        stream.write(last_lines(line, report))


def is_up_to_date(result: Path, case: Path, settings: Sequence[Any], unset: Sequence[str]) -> bool:
    """Whether a result file is whole, has its report, and was made from what is there now."""
    with suppress(OSError, ValueError, LookupError, TypeError):
        if not case.is_file():  # what a pipe gives can be read once
            return False
        with open(result, "rb") as stream:
            stream.seek(-min(_LONGEST, stream.seek(0, os.SEEK_END)), os.SEEK_END)
            end = stream.read()
        report = result.with_suffix(".txt").read_bytes()
        names = json.loads(end.rsplit(b"\n", 2)[-2])["files"]
        files = {name: text_hash((case.parent / name).read_bytes()) for name in names}
        text = case.read_bytes().decode("utf-8-sig")
        made = inputs(case, text, files, settings, unset)
        return bool(made) and end.endswith(last_lines(made, report))
    return False
