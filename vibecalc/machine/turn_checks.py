"""Is a table over one turn of a cylinder a curve that closes?"""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from vibecalc.errors import KeyPath, Problem

TURN = 2.0 * math.pi
#: rad; angles in degrees are a turn apart to rounding only
CLOSED = 1e-9


def turn_problems(
    path: KeyPath,
    what: str,
    angle: Sequence[float],
    column: str,
    values: Sequence[float],
    unit: str,
    period: float = TURN,
) -> Iterator[Problem]:
    """Problems of a table at `path` of `what` ("gas pressure"): angles in rad, `column` in `unit`.

    It has to span `period`, one turn or the two of a four-stroke cycle. One problem at most: what
    follows from the first is not told.
    """
    turns, cycle = ("two turns", "a cycle") if period > TURN else ("one turn", "a turn")
    back = [n for n in range(1, len(angle)) if not angle[n] > angle[n - 1]]
    if back:
        last = back[0]
        yield Problem(
            path=(*path, "crank_angle", last),
            message=f"the crank angles of the {what} have to ascend",
            found=f"{degrees(angle[last - 1])}, then {degrees(angle[last])}, in rows "
            f"{last} and {last + 1}",
            allowed="each larger than the one before it",
        )
    elif abs(angle[-1] - angle[0] - period) > CLOSED:
        yield Problem(
            path=(*path, "crank_angle"),
            message=f"the crank angles of the {what} have to span {turns}",
            found=f"from {degrees(angle[0])} to {degrees(angle[-1])}",
            allowed=f"a last angle of {degrees(angle[0] + period)}",
            hint=f"the last row repeats the {column} of the first one",
        )
    elif abs(values[-1] - values[0]) > 1e-9 * max(map(abs, values)):
        yield Problem(
            path=(*path, column),
            message=f"the {what} after {cycle} has to be that before it",
            found=f"{quoted(values[0], unit)} in the first row, {quoted(values[-1], unit)} in the "
            "last",
            allowed=f"the same {column} in the first and the last row",
        )


def evenly_spaced(angle: Sequence[float]) -> bool:
    """Whether all rows are the same angle apart, as trigonometric interpolation needs them."""
    step = TURN / max(len(angle) - 1, 1)
    return all(abs(later - sooner - step) <= CLOSED for sooner, later in pairwise(angle))


def quoted(value: float, unit: str) -> str:
    """A value in its SI unit, a pressure in bar, too, in which cards are written."""
    in_bar = f" ({value / 1e5:.9g} bar)" if unit == "Pa" else ""
    return f"{value:.9g} {unit}{in_bar}"


def degrees(angle: float) -> str:
    """An angle in rad as a text in degrees."""
    return f"{math.degrees(angle):.9g} deg"
