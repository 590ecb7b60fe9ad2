"""Faults of this program met while words and pictures are made of a result that stands already."""

import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TypeVar

from vibecalc.errors import Defect, VibecalcError

Made = TypeVar("Made")

#: what has failed so far, while somebody listens
_met: ContextVar[list[str] | None] = ContextVar("_met", default=None)


def described(error: Exception) -> str:
    """An exception in one line, with the place that raised it."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    file = "/".join(Path(frame.filename).parts[-3:])
    return f"{type(error).__name__}: {error} ({file}, line {frame.lineno})"


def survived(part: str, make: Callable[[], Made]) -> Made | None:
    """What `make` gives of one part; None where it fails and `defects` listens, which tells it."""
    met = _met.get()
    if met is None:
        return make()
    try:
        return make()
    except VibecalcError:
        raise
    except Exception as error:
        met.append(f"{part}: {described(error)}")
        return None


def failed_parts() -> list[str]:
    """What has failed so far, in words, for the end of the report that lacks it."""
    return list(_met.get() or ())


@contextmanager
def defects(whole: str) -> Iterator[list[str]]:
    """Collect what fails of a report or of pictures, part by part, instead of raising it.

    What is wrong with the request itself is raised as ever.
    """
    met: list[str] = []
    before = _met.set(met)
    try:
        yield met
    except VibecalcError:
        if not met:  # else it follows from what is missing
            raise
    except Exception as error:
        met.append(f"{whole}: {described(error)}")
    finally:
        _met.reset(before)


def as_defect(met: Sequence[str], result: Path | str) -> Defect:
    """The error that names what failed, and the result, which is none the worse."""
    failed = "\n".join(f"  {one}" for one in dict.fromkeys(met))
    return Defect(
        f"{result}: the result is whole, but its report or pictures are not. This failed:\n"
        f"{failed}\nThis is a bug in vibecalc, please report it with these lines and the case file."
    )


@contextmanager
def reporting(whole: str, result: Path | str) -> Iterator[None]:
    """The same, and a `Defect` of the result in the end where anything has failed."""
    with defects(whole) as met:
        yield
    if met:
        raise as_defect(met, result)
