"""A page as a script: its blocks run in order in a folder, and what it shows is what comes out.

- `toml` begins or goes on with a file, which has to be TOML: `# NAME.toml` in its first line
  names it.
- `sh` is run line by line. `# exit code 1` behind a command says how it ends, if not with 0.
- `python` is run; names last to the end of the page.
- A block without a language below one of these shows lines that it prints, in their order; `...`
  alone in a line leaves lines out, at the end of a line the rest of it.

The folder has the cases of the checkout as `cases/`. Other blocks (`text`, `yaml`) are not run.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.S | re.M)
_FILE = re.compile(r"# ([\w.-]+\.toml)\b")
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?")
_CODE = re.compile(r"# .*\bexit code (\d+)")


class Block(NamedTuple):
    """A fenced block: its language, its text."""

    language: str
    text: str


class PageError(Exception):
    """A page says what is not so."""


def blocks_of(text: str) -> list[Block]:
    """The fenced blocks of a page."""
    return [Block(*found) for found in _BLOCK.findall(text)]


def run_page(path: Path, folder: Path, change: Callable[[str], str] = str) -> None:
    """Run a page in an empty folder, which keeps what it writes; PageError where it is wrong.

    `change` leaves out of its text what a test does not run, or makes it shorter.
    """
    script = _Script(folder)
    (folder / "cases").symlink_to(ROOT / "cases")
    with contextlib.chdir(folder):
        for block in blocks_of(change(path.read_text(encoding="utf-8"))):
            try:
                script.take(block)
            except PageError as error:
                raise PageError(f"{path.name}: {error}") from None


class _Script:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.names: dict[str, Any] = {}
        self.file = ""
        self.printed: str | None = None

    def take(self, block: Block) -> None:
        if block.language == "":
            if self.printed is not None:
                compare(block.text, self.printed)
            return
        self.printed = None
        if block.language == "toml":
            self.write(block.text)
        elif block.language == "sh":
            self.printed = "".join(self.type_in(line) for line in _lines(block.text))
        elif block.language == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(block.text, self.names)
            self.printed = out.getvalue()

    def write(self, text: str) -> None:
        named = _FILE.match(text)
        self.file = named[1] if named else self.file
        if not self.file:
            raise PageError(f"no file is named for the block {text[:40]!r}")
        with (self.folder / self.file).open("a", encoding="utf-8") as stream:
            stream.write(text + "\n")
        try:
            tomllib.loads((self.folder / self.file).read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise PageError(f"{self.file} is no TOML: {error}") from None

    def type_in(self, line: str) -> str:
        said = _CODE.search(line)
        wanted = int(said[1]) if said else 0
        if re.match(r"vibecalc [^|;&$#]*(#|$)", line):
            code, out = _vibecalc(line)
        else:
            done = subprocess.run(
                ["sh", "-c", line], capture_output=True, text=True, timeout=60, check=False
            )
            code, out = done.returncode, done.stdout + done.stderr
        if code != wanted:
            raise PageError(f"{line}\nends with exit code {code}, not {wanted}:\n{out}")
        return out


def _lines(text: str) -> Iterator[str]:
    joined = text.replace("\\\n", " ")
    return (line for line in joined.splitlines() if line.strip() and not line.startswith("#"))


def _vibecalc(line: str) -> tuple[int, str]:
    """Exit code and output of a command in this process, with `< file` and `> file`."""
    from vibecalc.__main__ import main

    words = shlex.split(line, comments=True)
    given = target = ""
    for sign in ("<", ">"):
        if sign in words:
            at = words.index(sign)
            given, target = (words[at + 1], target) if sign == "<" else (given, words[at + 1])
            del words[at : at + 2]
    out, code = io.StringIO(), 0
    before = sys.argv, sys.stdin
    sys.argv = words
    if given:
        sys.stdin = io.TextIOWrapper(io.BytesIO(Path(given).read_bytes()), encoding="utf-8")
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            main()
    except SystemExit as stop:
        code = int(stop.code or 0)
    finally:
        sys.argv, sys.stdin = before
    if target:
        Path(target).write_text(out.getvalue(), encoding="utf-8")
        return code, ""
    return code, out.getvalue()


def compare(shown: str, printed: str) -> None:
    """PageError unless the lines shown are among those printed, in their order."""
    left = iter(printed.splitlines())
    for line in shown.splitlines():
        if line.strip() not in ("", "...") and not any(same(line, one) for one in left):
            raise PageError(f"this is shown and not printed: {line.strip()}\nprinted:\n{printed}")


def same(shown: str, printed: str) -> bool:
    """Equal words, and numbers equal to nine digits; errors (1e-14) to their size."""
    words, others = shown.split(), printed.split()
    if words and words[-1] == "...":
        words = words[:-1]
        others = others[: len(words)]
    one, other = " ".join(words), " ".join(others)
    if _NUMBER.sub("#", one) != _NUMBER.sub("#", other):
        return False
    pairs = zip(_NUMBER.findall(one), _NUMBER.findall(other), strict=True)
    return all(
        a == b or abs(float(a) - float(b)) <= (5.0 if "e-" in a else 1e-9) * abs(float(a))
        for a, b in pairs
    )


def run_to_draw(path: Path, target: Path) -> None:
    """Run a page and keep the pictures that it links to in `target`."""
    import shutil
    import tempfile

    wanted = pictures_of(path, target)
    with tempfile.TemporaryDirectory() as folder:
        run_page(path, Path(folder))
        for picture in wanted:
            made = [*Path(folder).rglob(picture.name)]
            if not made:
                raise PageError(f"{path.name} links to {picture.name} and does not draw it")
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(made[0], picture)


def pictures_of(path: Path, target: Path) -> list[Path]:
    """The pictures in `target` that a page links to."""
    links = re.findall(r"!\[[^\]]*\]\(([^)]+\.png)\)", path.read_text(encoding="utf-8"))
    files = (Path(os.path.normpath(path.parent / link)) for link in links)
    return [file for file in files if file.parent == target]
