"""What a hard case is, and how the digits that a method loses on it are counted.

A method is right to round-off if its relative error is 2^-53. It has lost d digits if the error is
10^d times that, and all of them (`ALL`) where not one decimal digit is left. Every case gives its
truth in long arithmetic or in closed form; nothing here is compared with a rounded truth.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from typing import NamedTuple

import mpmath
import numpy as np

from vibecalc.errors import VibecalcError
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

#: digits of a double
WHOLE = -math.log10(UNIT_ROUNDOFF)
#: the place of a number of digits, where it is no number
ALL = "all"
REFUSES, NOT_FINITE, BREAKS_DOWN = "refuses", "not finite", "breaks down"
#: where a value has no bound, and that is said
INFINITE = "infinite"
#: a finite number where there is none
A_NUMBER = "gives a number"
#: what a method may raise when it fails loudly
FAILURES = (ArithmeticError, ValueError, np.linalg.LinAlgError, RuntimeError)

Lost = float | str
Numbers = Sequence[object] | np.ndarray


class Way(NamedTuple):
    """A method with its values. `loose`: what it loses hangs on LAPACK or on the luck of rounding,
    so that another machine may show one and a half digits more or less."""

    name: str
    values: Callable[[], object]
    loose: bool = False


class HardCase(NamedTuple):
    """A case with its truth, vibecalc's answer and the other ways to it.

    `condition` gives the relative condition of what is asked: by how much a relative change of the
    data is multiplied, at worst; infinite at a singular point and for what is exactly zero. `truth`
    is None where no number exists: then vibecalc refuses or says infinite. `scale` is what errors
    are relative to, each value's own size by default. `long` cases run in `make test-long` alone.
    What each way loses is stated in `stated.toml`.
    """

    name: str
    condition: Callable[[], float]
    truth: Callable[[], Numbers] | None
    own: Callable[[], Bounded]
    ways: tuple[Way, ...]
    scale: float | None = None
    long: bool = False


def singular() -> float:
    """The condition of what has no value, or is exactly zero."""
    return math.inf


def errors(values: object, truth: Numbers) -> list[mpmath.mpf]:
    """|value - truth| of each value, in long arithmetic."""
    with mpmath.workdps(60):
        return [
            abs(mpmath.mpmathify(complex(one)) - mpmath.mpmathify(exact))
            for one, exact in zip(np.ravel(values), truth, strict=True)  # type: ignore[call-overload]
        ]


def digits_lost(values: object, truth: Numbers, scale: float | None = None) -> Lost:
    """Digits that the worst of the values has lost, at least 0; `ALL` where none is left."""
    if not np.all(np.isfinite(np.ravel(values))):  # type: ignore[arg-type]
        return NOT_FINITE
    worst = 0.0
    for wrong, exact in zip(errors(values, truth), truth, strict=True):
        size = abs(mpmath.mpmathify(exact)) if scale is None else mpmath.mpf(scale)
        if wrong:
            worst = max(worst, float(wrong / size) if size else math.inf)
    if worst >= 0.1:
        return ALL
    return max(0.0, math.log10(worst / UNIT_ROUNDOFF)) if worst else 0.0


def outcome(values: Callable[[], object], case: HardCase) -> Lost:
    """Digits that a way loses now, or what it does instead of answering."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            found = values()
        except VibecalcError:
            return REFUSES
        except FAILURES:
            return BREAKS_DOWN
    if case.truth is None:
        return A_NUMBER if np.all(np.isfinite(np.ravel(found))) else NOT_FINITE  # type: ignore[arg-type]
    return digits_lost(found, case.truth(), case.scale)


def as_number(lost: Lost) -> float:
    """Digits as a number; what gives none has lost all."""
    return WHOLE if isinstance(lost, str) else lost


def condition_of(
    exact: Callable[..., Sequence[mpmath.mpf]], *data: float, part: float = 1e-20
) -> float:
    """Relative condition of `exact(*data)`: sum over the data of |x dy/dx| / |y|, at worst.

    By differences in long arithmetic; `exact` takes and gives mpmath numbers.
    """
    with mpmath.workdps(80):
        places = [mpmath.mpf(float(one)) for one in data]
        middle = exact(*places)
        total = [mpmath.mpf(0)] * len(middle)
        for i, one in enumerate(places):
            moved = exact(*places[:i], one * (1 + mpmath.mpf(part)), *places[i + 1 :])
            total = [
                so_far + abs((b - a) / a) / mpmath.mpf(part)
                for so_far, a, b in zip(total, middle, moved, strict=True)
            ]
        return float(max(total))
