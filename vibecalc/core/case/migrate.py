"""A case of an earlier version under the names of this one; comments and layout stay."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from vibecalc.core.case.csv_files import Unreadable, read_text
from vibecalc.core.case.load import parse_source, read_source
from vibecalc.core.case.locate import Span, at_offset, refused, scan
from vibecalc.core.case.raw import Data, table_at, tables_at
from vibecalc.core.results.renamed import current_key, current_name, current_text
from vibecalc.errors import KeyPath, Problem, dotted, leaves

#: in the line of names of a file: a unit in brackets, or a name
_COLUMN = re.compile(r"\[[^\]]*\]|\([^)]*\)|([^\W\d][\w .-]*\w)")
_FILE_NAME = re.compile(r"[^\n]+\.(csv|tsv|txt|dat)\Z", re.IGNORECASE)


class Renaming(NamedTuple):
    """A name that was replaced: file, line, what stood there, what stands there now."""

    file: str
    line: int
    old: str
    new: str


class Migrated(NamedTuple):
    """A case as it is now; `files` are those next to it that changed, by name."""

    path: Path
    text: str
    files: dict[str, str]
    renamings: list[Renaming]


class _Edit(NamedTuple):
    start: int
    stop: int
    text: str


def migrate(source: Path) -> Migrated:
    """Replace every earlier name in a case and in the tables in CSV that it names.

    A case need not be valid otherwise. CaseError where it is no TOML or has a key under both names.
    """
    path, text = read_source(source)
    data = parse_source(text, str(path))
    spans, written = scan(text)
    problems, edits = list[Problem](), list[_Edit]()
    for name in written:
        new = current_name(name.path)
        if new is None:
            continue
        place = (*name.path[:-1], new)
        if place in spans:
            message = f"{dotted(name.path)} is now {new}, and both stand here"
            problems.append(Problem(name.path, message, hint="leave one out", also=place))
        edits.append(_Edit(name.start, name.stop, new))
    if problems:
        raise refused(problems, text, str(path))
    flat = text.replace("\r\n", "\n")
    edits += [edit for edit in _texts(data, flat, spans) if edit not in edits]
    renamings = [_renaming(path.name, flat, edit) for edit in sorted(edits)]
    files: dict[str, str] = {}
    for table, file in leaves(data):
        if not isinstance(file, str) or not _FILE_NAME.match(file) or table[-1] == "source":
            continue
        try:
            content = read_text(path.parent, file)
        except Unreadable:  # `check` says so
            continue
        columns = _columns(files.get(file, content), table)
        if columns:
            files[file] = _edited(files.get(file, content), columns)
            renamings += [_renaming(file, content, edit) for edit in columns]
    return Migrated(path, _edited(text, edits), files, renamings)


def _renaming(file: str, text: str, edit: _Edit) -> Renaming:
    line = at_offset(text, edit.start).line
    return Renaming(file, line, text[edit.start : edit.stop].strip("\"'"), edit.text.strip("\"'"))


def _edited(text: str, edits: list[_Edit]) -> str:
    """A text with edits of the same text with plain line ends; its own line ends stay."""
    ends = re.findall(r"\r?\n", text)
    flat = text.replace("\r\n", "\n")
    for edit in sorted(edits, reverse=True):
        flat = flat[: edit.start] + edit.text + flat[edit.stop :]
    if "\r\n" not in ends:
        return flat
    lines = flat.split("\n")
    return "".join(line + end for line, end in zip(lines, [*ends, ""], strict=True))


def _texts(data: Data, text: str, spans: dict[KeyPath, Span]) -> Iterator[_Edit]:
    """Texts of a case that are names: choices, keys, paths of results, axes."""
    for path, value in leaves(data):
        new = current_text(path, value) if isinstance(value, str) else value
        span = spans.get(path)
        if new != value and span is not None:
            stands = text[span.value_start : span.value_stop]
            yield _Edit(span.value_start, span.value_stop, stands.replace(value, new))
    for place, stock in tables_at(data, "optimisation", "stock"):
        table = stock.get("table")
        for number, item in tables_at(stock, "items"):
            for key in table_at(item, "values"):
                at = ("optimisation", "stock", place, "items", number, "values", key)
                new = current_key(f"{table}.{key}").rpartition(".")[2]
                if new != key and at in spans:
                    yield _Edit(spans[at].start, spans[at].stop, new)


def _columns(text: str, table: KeyPath) -> list[_Edit]:
    """Edits of the line of names of a file that stands for the table."""
    flat, start = text.replace("\r\n", "\n"), 0
    for line in flat.split("\n"):
        if line.strip() and not line.lstrip().startswith(("#", '"#', "sep=")):
            break
        start += len(line) + 1
    else:
        return []
    edits = []
    for found in _COLUMN.finditer(line):
        column = re.sub(r"[\s-]+", "_", (found[1] or "").lower()).split(".")
        new = current_name((*table, *column))
        if new is not None:
            stop = start + found.end()
            edits.append(_Edit(stop - len(column[-1]), stop, new))
    return edits
