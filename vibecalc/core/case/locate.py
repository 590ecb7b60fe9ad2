"""Problems of a case in its text: from a key path to line and column, and shown with a mark."""

import contextlib
import re
from collections.abc import Sequence
from typing import NamedTuple

from vibecalc.errors import CaseError, KeyPath, Problem

# ----------------------------------------------------------------------------
# From a key path to its place in the text of a TOML file: line, column, length.
#
# tomllib keeps no positions. Text that tomllib has accepted is read here once more, in one pass,
# for the places of keys, table headers and list entries; only the error path does so.
# ----------------------------------------------------------------------------

_BLANK = re.compile(r"(?:[ \t\n]|#[^\n]*)*+")
_KEY = re.compile(r"""[A-Za-z0-9_-]+|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'""")
_SCALAR = re.compile(
    r'''"""(?:[^"\\]|\\[\s\S]|"{1,2}(?!"))*+"{3,5}|\'\'\'(?:[^']|'{1,2}(?!'))*+'{3,5}'''
    r"""|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|\d{4}-\d\d-\d\d \d[^\s,\]}#]*|[^\s,\]}#]+"""
)


class Span(NamedTuple):
    """Where a key (or a list entry) stands: offsets of its name and of its value."""

    start: int
    stop: int
    value_start: int
    value_stop: int


class Location(NamedTuple):
    """A place to show: line and column count from 1; `length` is that of the marked piece."""

    line: int
    column: int
    length: int
    excerpt: str
    override: str = ""


class Overridden(NamedTuple):
    """A key path that a `--set` changed, and the text of it."""

    path: KeyPath
    text: str


def locate(
    path: KeyPath,
    text: str,
    overrides: Sequence[Overridden] = (),
    spans: dict[KeyPath, Span] | None = None,
) -> Location:
    """Place of a key path; of its nearest table when it is not written; else the first line.

    A key that was set from the command line is located there: `override` is then its text.
    """
    written = source(path, overrides, find_spans(text) if spans is None else spans)
    if isinstance(written, Overridden):
        return Location(0, 0, 0, written.text, written.text)
    return at_offset(text, written.start, written.stop - written.start)


def source(
    path: KeyPath, overrides: Sequence[Overridden], spans: dict[KeyPath, Span]
) -> Overridden | Span:
    """What wrote a key path, its nearest table, or the first character of the file."""
    for override in reversed(overrides):
        if path[: len(override.path)] == override.path:
            return override
    for size in range(len(path), 0, -1):
        span = spans.get(path[:size])
        if span is not None:
            return span
        for override in overrides:
            if override.path[:size] == path[:size]:
                return override
    return Span(0, 1, 0, 1)


def at_offset(text: str, offset: int, length: int = 1) -> Location:
    """Line, column and excerpt of an offset into a text (newlines as tomllib sees them)."""
    before = text.replace("\r\n", "\n")[:offset]
    column = offset - (before.rfind("\n") + 1)
    place = at_line(text, before.count("\n") + 1, column + 1)
    return place._replace(length=max(1, min(length, len(place.excerpt) - column)))


def at_line(text: str, line: int, column: int) -> Location:
    """Return the place with a line and a column, moved inside the text if it lies behind it."""
    lines = text.replace("\r\n", "\n").split("\n")
    line = max(1, min(line, len(lines)))
    excerpt = lines[line - 1]
    return Location(line, max(1, min(column, len(excerpt) + 1)), 1, excerpt)


class Written(NamedTuple):
    """A name of a key, of a table in a header too, as often as it stands: offsets into the text."""

    path: KeyPath
    start: int
    stop: int


def find_spans(text: str) -> dict[KeyPath, Span]:
    """Places of every key, table and list entry of a TOML text; what cannot be read is left out."""
    return scan(text)[0]


def scan(text: str) -> tuple[dict[KeyPath, Span], list[Written]]:
    """The same, with every name of a key in the order of the text."""
    scanner = _Scanner(text.replace("\r\n", "\n"))
    # A text that is no TOML, or nested beyond reason: what was found up to there serves.
    with contextlib.suppress(ValueError, RecursionError):
        scanner.document()
    return scanner.spans, scanner.written


class _Unreadable(ValueError):
    pass


class _Scanner:
    """One pass over a text that tomllib accepts."""

    def __init__(self, text: str):
        self.text = text
        self.place = 0
        self.spans: dict[KeyPath, Span] = {}
        self.written: list[Written] = []
        self.list_sizes: dict[KeyPath, int] = {}

    def document(self) -> None:
        table: KeyPath = ()
        while self.skip_blank() < len(self.text):
            if self.text[self.place] == "[":
                table = self.header()
            else:
                self.pair(table)

    def header(self) -> KeyPath:
        start = self.place
        is_list = self.text.startswith("[[", start)
        self.place += 2 if is_list else 1
        parts = self.key()
        stop = self.text.find("\n", start)
        close = self.text.find("]]" if is_list else "]", self.place)
        if close < 0 or (stop >= 0 and close > stop):
            raise _Unreadable
        self.place = close + (2 if is_list else 1)
        path: KeyPath = ()
        span = Span(start, self.place, start, self.place)
        for position, (name, first, end) in enumerate(parts):
            path = (*path, name)
            self.spans.setdefault(path, span)
            self.written.append(Written(path, first, end))
            last = position == len(parts) - 1
            if last and is_list:
                self.list_sizes[path] = self.list_sizes.get(path, 0) + 1
            if path in self.list_sizes:
                path = (*path, self.list_sizes[path] - 1)
                self.spans.setdefault(path, span)
        if not is_list:
            self.spans[path] = span  # rather the table's own header than that of a table below it
        return path

    def pair(self, table: KeyPath) -> None:
        parts = self.key()
        self.expect("=")
        first = self.skip_blank()
        path = table
        for name, start, stop in parts:
            path = (*path, name)
            self.spans.setdefault(path, Span(start, stop, first, first))
            self.written.append(Written(path, start, stop))
        _, start, stop = parts[-1]
        self.value(path)
        self.spans[path] = Span(start, stop, first, self.place)

    def key(self) -> list[tuple[str, int, int]]:
        parts: list[tuple[str, int, int]] = []
        while True:
            self.skip_blank()
            match = _KEY.match(self.text, self.place)
            if match is None:
                raise _Unreadable
            parts.append((_key_name(match[0]), match.start(), match.end()))
            self.place = match.end()
            self.skip_blank()
            if not self.text.startswith(".", self.place):
                return parts
            self.place += 1

    def value(self, path: KeyPath) -> None:
        opening = self.text[self.place : self.place + 1]
        if opening not in ("[", "{"):
            match = _SCALAR.match(self.text, self.place)
            if match is None:
                raise _Unreadable
            self.place = match.end()
            return
        closing = "]" if opening == "[" else "}"
        self.place += 1
        position = 0
        while True:
            start = self.skip_blank()
            if self.text.startswith(closing, start):
                self.place += 1
                return
            if opening == "{":
                self.pair(path)
            else:
                entry = (*path, position)
                self.value(entry)
                self.spans[entry] = Span(start, self.place, start, self.place)
                position += 1
            self.skip_blank()
            if self.text.startswith(",", self.place):
                self.place += 1
            elif not self.text.startswith(closing, self.place):
                raise _Unreadable

    def expect(self, sign: str) -> None:
        self.skip_blank()
        if not self.text.startswith(sign, self.place):
            raise _Unreadable
        self.place += 1

    def skip_blank(self) -> int:
        match = _BLANK.match(self.text, self.place)
        self.place = match.end() if match else self.place
        return self.place


def _key_name(written: str) -> str:
    if written[0] == "'":
        return written[1:-1]
    if written[0] == '"':
        import tomllib

        return next(iter(tomllib.loads(f"{written} = 0")))
    return written


# ----------------------------------------------------------------------------
# Problems as text: file, line and column, the line itself with a mark below, and a hint.
# ----------------------------------------------------------------------------

_MOST_SHOWN = 100
_WIDEST = 100


def refused(
    problems: Sequence[Problem],
    text: str,
    file_name: str,
    overrides: Sequence[Overridden] = (),
) -> CaseError:
    """The error that says all problems of one case in the order of its lines.

    `text` is the TOML as read; places that come from `--set` are shown as such. Each problem that
    is shown takes a look at the whole text; the others stay without a place.
    """
    spans = find_spans(text)

    def offset(problem: Problem) -> int:
        written = source(problem.path, overrides, spans)
        return -1 if isinstance(written, Overridden) else written.start

    placed, shown = list[Problem](), list[str]()
    for problem in sorted(problems, key=offset):
        if len(shown) < _MOST_SHOWN:
            place = locate(problem.path, text, overrides, spans)
            also = locate(problem.also, text, overrides, spans) if problem.also else None
            shown.append(_rendered(problem, file_name, place, also))
            words = place.override or f"{file_name}:{place.line}:{place.column}"
            problem = problem._replace(place=words, line=place.line)
        placed.append(problem._replace(file=file_name))
    if len(problems) > _MOST_SHOWN:
        shown.append(f"... and {len(problems) - _MOST_SHOWN} more")
    return CaseError(placed, "\n".join([*shown, _closing_line(len(problems), file_name)]))


def unreadable(file_name: str, message: str, hint: str, at: Location | None = None) -> CaseError:
    """The error of a file that cannot be read as a case, at a place or as a whole."""
    where = f"{file_name}:{at.line}:{at.column}" if at else file_name
    line = at.line if at else 0
    problem = Problem((), message, hint=hint, place=where, file=file_name, line=line)
    help_line = f"\n  help: {hint}" if hint else ""  # a name in another encoding is shown escaped
    rendered = _rendered(problem, file_name, at) if at else f"error: {message}{help_line}"
    return CaseError([problem], f"{rendered}\n{_closing_line(1, file_name)}")


def _closing_line(count: int, file_name: str) -> str:
    return f"{count} error{'' if count == 1 else 's'} in {file_name}, nothing was run"


def _rendered(
    problem: Problem, file_name: str, place: Location, also: Location | None = None
) -> str:
    """A problem with its place."""
    parts = {"found ": problem.found, "allowed: ": problem.allowed}
    label = "; ".join(word + said for word, said in parts.items() if said)
    lines = [f"error: {_printable(problem.message)}"]
    if place.override:
        lines.append(f"  --> {_printable(place.override)}")
        lines += [f"  {label}"] if label else []
        lines += ["     |", *_excerpt(also)] if also else []
    else:
        lines.append(f"  --> {file_name}:{place.line}:{place.column}")
        first = _excerpt(place, label)
        second = _excerpt(also) if also and also.line != place.line else []
        before = bool(also and also.line < place.line)
        lines += ["     |", *(second + first if before else first + second)]
    if problem.hint:
        lines.append(f"  help: {_printable(problem.hint)}")
    return "\n".join(lines)


def _excerpt(place: Location, label: str | None = None) -> list[str]:
    if place.override:
        return [f"     | {_printable(place.override)}"]
    # A long line is cut around the mark, so that the mark stays on the screen.
    first = max(0, place.column - 1 - _WIDEST // 2) if len(place.excerpt) > _WIDEST else 0
    shown = place.excerpt[first : first + _WIDEST]
    column = place.column - 1 - first
    lines = [f"{place.line:4d} | {_printable(shown)}"]
    if label is not None:
        mark = "^" * max(1, min(place.length, len(shown) - column))
        lines.append(f"     | {' ' * column}{mark} {_printable(label)}".rstrip())
    return lines


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)
