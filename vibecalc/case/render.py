"""Problems as text: file, line and column, the line itself with a mark below, and a hint."""

from collections.abc import Sequence
from dataclasses import replace

from vibecalc.case.locate import Location, Overridden, Span, find_spans, locate, source
from vibecalc.errors import CaseError, KeyPath, Problem

_MOST_SHOWN = 100
_WIDEST = 100


def render_problems(
    problems: Sequence[Problem],
    text: str,
    file_name: str,
    overrides: Sequence[Overridden] = (),
) -> str:
    """Say all problems of one case in the order of its lines, and that nothing was run.

    `text` is the TOML as read; places that come from `--set` are shown as such.
    """
    spans = find_spans(text) if text else {}

    def offset(problem: Problem) -> int:
        written = source(problem.path, overrides, spans)
        return -1 if isinstance(written, Overridden) else written.start

    shown = [
        render_problem(
            problem,
            locate(problem.path, text, overrides, spans),
            file_name,
            _second(problem.also, text, overrides, spans),
        )
        for problem in sorted(problems, key=offset)[:_MOST_SHOWN]
    ]
    if len(problems) > _MOST_SHOWN:
        shown.append(f"... and {len(problems) - _MOST_SHOWN} more")
    return "\n".join([*shown, closing_line(len(problems), file_name)])


def refused(
    problems: Sequence[Problem],
    text: str,
    file_name: str,
    overrides: Sequence[Overridden] = (),
) -> CaseError:
    """The error that says all problems of one case; those that can be shown have their place."""
    spans = find_spans(text) if text else {}
    placed = []
    for number, problem in enumerate(problems):
        if number < _MOST_SHOWN:  # each takes a look at the whole text
            place = locate(problem.path, text, overrides, spans)
            words = place.override or f"{file_name}:{place.line}:{place.column}"
            problem = replace(problem, place=words)
        placed.append(problem)
    return CaseError(placed, render_problems(problems, text, file_name, overrides))


def closing_line(count: int, file_name: str) -> str:
    """Return the last line of a message about a case."""
    return f"{count} error{'' if count == 1 else 's'} in {file_name}, nothing was run"


def render_problem(
    problem: Problem, place: Location, file_name: str, also: Location | None = None
) -> str:
    """Say one problem at its place."""
    label = "; ".join(
        part
        for part in (
            f"found {problem.found}" if problem.found else "",
            f"allowed: {problem.allowed}" if problem.allowed else "",
        )
        if part
    )
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


def _second(
    path: KeyPath | None,
    text: str,
    overrides: Sequence[Overridden],
    spans: dict[KeyPath, Span],
) -> Location | None:
    return None if path is None else locate(path, text, overrides, spans)


def _excerpt(place: Location, label: str | None = None) -> list[str]:
    if place.override:
        return [f"     | {_printable(place.override)}"]
    # A long line is cut around the mark, so that the mark stays on the screen.
    first = max(0, place.column - 1 - _WIDEST // 2) if len(place.excerpt) > _WIDEST else 0
    piece = place.excerpt[first : first + _WIDEST]
    column = place.column - 1 - first
    lines = [f"{place.line:4d} | {_printable(piece)}"]
    if label is not None:
        mark = "^" * max(1, min(place.length, len(piece) - column))
        lines.append(f"     | {' ' * column}{mark} {_printable(label)}".rstrip())
    return lines


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)
