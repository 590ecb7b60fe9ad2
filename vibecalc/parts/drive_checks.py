"""Physical checks of what drives a machine: gas over a turn as closed curves, motor torque."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.kinds import TRAIN, gas_turns, has_crank_train
from vibecalc.parts.firing import cycle_angle
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.parts.gas_tables import GasForce, GasPressure

# ----------------------------------------------------------------------------
# Is a table over one turn of a cylinder a curve that closes?
# ----------------------------------------------------------------------------

TURN = 2.0 * math.pi
#: rad; angles in degrees are a turn apart to rounding only
CLOSED = 1e-9


def turn_problems(
    path: KeyPath, what: str, table: "GasPressure | GasForce", period: float
) -> Iterator[Problem]:
    """Problems of a table at `path` of `what` ("gas pressure"), over `period`, rad.

    That is one turn, or the two of a four-stroke cycle. One problem at most: what follows from the
    first is not reported.
    """
    column, unit = ("pressure", "Pa") if hasattr(table, "pressure") else ("force", "N")
    angle, values = table.crank_angle, getattr(table, column)
    turns, cycle = (
        ("two revolutions", "the cycle") if period > TURN else ("one revolution", "the revolution")
    )
    back = [n for n in range(1, len(angle)) if not angle[n] > angle[n - 1]]
    if back:
        last = back[0]
        yield Problem(
            path=(*path, "crank_angle", last),
            message=f"the crank angles of the {what} must be ascending",
            found=f"{degrees(angle[last - 1])}, then {degrees(angle[last])}, in rows "
            f"{last} and {last + 1}",
            allowed="each larger than the one before it",
        )
    elif abs(angle[-1] - angle[0] - period) > CLOSED:
        yield Problem(
            path=(*path, "crank_angle"),
            message=f"the crank angles of the {what} must span {turns}",
            found=f"from {degrees(angle[0])} to {degrees(angle[-1])}",
            allowed=f"a last angle of {degrees(angle[0] + period)}",
            hint=f"the last row repeats the {column} of the first one",
        )
    elif abs(values[-1] - values[0]) > 1e-9 * max(map(abs, values)):
        yield Problem(
            path=(*path, column),
            message=f"the {what} must be the same at both ends of {cycle}",
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


# ----------------------------------------------------------------------------
# Are the tables of the gas curves over a turn that can be read between their rows?
# ----------------------------------------------------------------------------

PRESSURE: KeyPath = ("machine", "crank_train", "gas_pressure")
#: rows that a way to read a table between its rows needs, the repeated last one counted
FEWEST = {"linear": 3, "parabola": 4, "cubic": 4, "trigonometric": 3}


def suits(interpolation: str, angle: Sequence[float]) -> bool:
    """Whether a table with rows at these angles, rad, can be read in this way."""
    even = interpolation != "trigonometric" or evenly_spaced(angle)
    return even and len(angle) >= FEWEST[interpolation]


@listing
def gas_problems(case: Case) -> Iterator[Problem]:
    """Problems of the gas pressure, of the gas force of each cylinder, and of how they are read."""
    if not has_crank_train(case.machine):
        return
    train = case.machine.crank_train
    interpolation, pressure = train.gas_interpolation or "linear", train.gas_pressure
    if pressure is not None:
        yield from turn_problems(PRESSURE, "gas pressure", pressure, cycle_angle(case.machine))
    for place, cylinder in enumerate(train.cylinders):
        table = cylinder.gas_force
        if table is None:
            continue
        path: KeyPath = (*TRAIN, "cylinders", place, "gas_force")
        what = f"gas force of cylinder {cylinder.name!r}"
        if len(table.crank_angle) < FEWEST["linear"]:
            yield _short(path, what, len(table.crank_angle), FEWEST["linear"])
            continue
        problems = list(turn_problems(path, what, table, TURN))
        yield from problems or _readable(path, what, interpolation, table.crank_angle)
    # the others are refused for an engine
    ours = not gas_turns(case.machine) or interpolation == "cubic"
    if pressure is not None and interpolation != "linear" and ours:
        yield from _readable(PRESSURE, "gas pressure", interpolation, pressure.crank_angle)


def _readable(
    path: KeyPath, what: str, interpolation: str, angle: Sequence[float]
) -> Iterator[Problem]:
    if len(angle) < FEWEST[interpolation]:
        yield _short(path, what, len(angle), FEWEST[interpolation], interpolation)
    elif not suits(interpolation, angle):
        yield Problem(
            path=(*path, "crank_angle"),
            message=f"trigonometric interpolation needs the crank angles of the {what} evenly "
            "spaced",
            found=f"{len(angle)} rows at uneven distances",
            allowed="rows at equal distances, or gas_interpolation = 'cubic'",
            also=(*TRAIN, "gas_interpolation"),
        )


def _short(path: KeyPath, what: str, rows: int, fewest: int, interpolation: str = "") -> Problem:
    means = f", with gas_interpolation = {interpolation!r}" if interpolation else ""
    one = "one row" if rows == 1 else f"{rows} rows"
    return Problem(
        path=path,
        message=f"the {what} has too few rows for a curve over a revolution",
        found=f"{one}{means}",
        allowed=f"{fewest} rows or more, the last one revolution after the first",
    )
