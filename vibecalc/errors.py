"""The tree of errors, each with the exit code the command line returns for it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import wraps
from math import pi
from typing import Any, NamedTuple

EXIT_FINE = 0
EXIT_DIFFERS = 1
EXIT_USAGE = 2
EXIT_NUMERICAL = 3
EXIT_POINTS_FAILED = 4
EXIT_BUG = 70
EXIT_INTERRUPTED = 130

#: what each means, for people
EXIT_CODES = {
    EXIT_FINE: "success",
    EXIT_DIFFERS: "differs, a reference or limit is missed, or a limit undecided",
    EXIT_USAGE: "usage or case file",
    EXIT_NUMERICAL: "no trustworthy number exists",
    EXIT_POINTS_FAILED: "some points of a sweep failed",
    EXIT_INTERRUPTED: "interrupted, or broken pipe",
    EXIT_BUG: "a bug",
}

KeyPath = tuple[str | int, ...]


class Problem(NamedTuple):
    """One thing wrong with a case, found on any floor, to be shown with its line in the file.

    `path` is the key path inside the case (`("machine", "crank_train", "rod_length")`, list
    positions as integers); `found` and `allowed` are short texts with units; `also` points to a
    second place that takes part in a contradiction. `place` is where that is once it is known:
    `file:line:column`, or the `--set` that wrote it. `file` is the case's, and `line` counts from
    1; 0 where none is known.
    """

    path: KeyPath
    message: str
    found: str = ""
    allowed: str = ""
    hint: str = ""
    also: KeyPath | None = None
    place: str = ""
    file: str = ""
    line: int = 0


def listing(check: Callable[[Any], Iterator[Problem]]) -> Callable[[Any], list[Problem]]:
    """A check of a case that yields its problems, as one that gives them all."""
    return wraps(check)(lambda case: list(check(case)))


def dotted(path: KeyPath) -> str:
    """`machine.crank_train.cylinders[0].position`, as `--set` takes it."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")


def leaves(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Everything in nested tables and lists that is neither, with its place."""
    if not isinstance(value, Mapping | list | tuple):
        yield path, value
        return
    for key, below in value.items() if isinstance(value, Mapping) else enumerate(value):
        yield from leaves(below, (*path, key))


class VibecalcError(Exception):
    """Base of everything vibecalc raises on purpose."""

    exit_code = EXIT_BUG

    @property
    def problems(self) -> tuple[Problem, ...]:
        """All that is wrong: what the text says, where no list of it is known."""
        return (Problem(path=(), message=str(self)),)

    def as_object(self) -> dict[str, object]:
        """What `--json` prints of it: message, exit code, and each problem of a case."""
        shown = ("place", "message", "found", "allowed", "hint")
        problems = [
            {
                "key": dotted(problem.path),
                "file": problem.file or None,
                "line": problem.line or None,
                **{name: getattr(problem, name) for name in shown},
            }
            for problem in self.problems
        ]
        return {"message": str(self), "exit_code": self.exit_code, "problems": problems}


class UsageError(VibecalcError):
    """The command line, a file or a folder cannot be used as asked."""

    exit_code = EXIT_USAGE


class UnitError(UsageError, ValueError):
    """A value with a unit cannot be read or has another dimension than the field.

    `found`, `allowed` and `hint` are the parts of a `Problem`; the text of the error has them all.
    """

    def __init__(self, message: str, *, found: str = "", allowed: str = "", hint: str = ""):
        self.message, self.found, self.allowed, self.hint = message, found, allowed, hint
        parts = [f"found {found}" if found else "", f"allowed: {allowed}" if allowed else "", hint]
        detail = "; ".join(part for part in parts if part)
        super().__init__(f"{message}: {detail}" if detail else message)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """The same in parts."""
        return (Problem((), self.message, self.found, self.allowed, self.hint),)


class CaseError(UsageError):
    """A case file with problems; `problems` holds all of them, `text` the rendered message."""

    def __init__(self, problems: Sequence[Problem], text: str = ""):
        self._problems = tuple(problems)
        self.text = text
        super().__init__(text or "; ".join(problem.message for problem in problems))

    @property
    def problems(self) -> tuple[Problem, ...]:
        """All problems of the case."""
        return self._problems


class ResultError(UsageError):
    """A result file that is damaged, foreign or lacks what is asked of it."""


class MissingQuantity(ResultError, KeyError):
    """No quantity of this path in a result."""

    __str__ = Exception.__str__  # a KeyError puts its words in quotes


class OutputError(UsageError):
    """Standard output takes no more: its device is full, or nobody reads on (`| head`)."""

    def __init__(self, error: OSError):
        closed = isinstance(error, BrokenPipeError)
        self.exit_code = EXIT_INTERRUPTED if closed else EXIT_USAGE
        why = "it was closed by its reader" if closed else (error.strerror or str(error)).lower()
        super().__init__(f"cannot write to standard output: {why}")


class Interrupted(VibecalcError):
    """Ctrl-C or the end of a job; the words say what is kept and how to go on."""

    exit_code = EXIT_INTERRUPTED

    def __init__(self, words: str = "interrupted: no half-written file is left behind"):
        super().__init__(words)


class NumericalFailure(VibecalcError):
    """No trustworthy number exists: singular, not converged, unstable, no steady state."""

    exit_code = EXIT_NUMERICAL
    #: what comes nearest, where a search has found no more
    result: Any = None


class Defect(VibecalcError):
    """A fault of vibecalc itself, as one met after the result was written."""

    #: what could be made of a report or of pictures all the same
    made: Any = None


class PointsApart(Exception):
    """Points of a sweep that cannot be computed in one array call: `kinds` (points,) tells which
    can, `alone` (points,) those that need a run of their own. Caught by the frame, never shown.
    """

    def __init__(self, kinds: Any, alone: Any = False):
        self.kinds, self.alone = kinds, alone
        super().__init__("points of one array call differ in kind")


def in_rpm(speed: float) -> str:
    """A speed in rad/s as a message says it."""
    return f"{speed * 30.0 / pi:.6g} rpm"


def in_hertz(frequency: float) -> str:
    """A frequency in rad/s as a message says it."""
    return f"{frequency / (2.0 * pi):.6g} Hz"
