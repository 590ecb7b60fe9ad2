"""Are the gas forces of the cylinders curves over one turn?"""

from collections.abc import Iterator, Sequence

from vibecalc.case.kinds import gas_turns, has_crank_train
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.drive_checks import PRESSURE
from vibecalc.machine.turn_checks import evenly_spaced, turn_problems

TRAIN: KeyPath = ("machine", "crank_train")
#: rows that a way to read a table between its rows needs, the repeated last one counted
FEWEST = {"linear": 3, "parabola": 4, "cubic": 4, "trigonometric": 3}


def gas_problems(case: Case) -> list[Problem]:
    """Problems of the gas force of each cylinder, and of how the gas tables are read."""
    return list(_gas(case)) if has_crank_train(case.machine) else []


def suits(interpolation: str, angle: Sequence[float]) -> bool:
    """Whether a table with rows at these angles, rad, can be read in this way."""
    even = interpolation != "trigonometric" or evenly_spaced(angle)
    return even and len(angle) >= FEWEST[interpolation]


def _gas(case: Case) -> Iterator[Problem]:
    train = case.machine.crank_train
    way = train.gas_interpolation or "linear"
    for place, cylinder in enumerate(train.cylinders):
        table = cylinder.gas_force
        if table is None:
            continue
        path: KeyPath = (*TRAIN, "cylinders", place, "gas_force")
        what = f"gas force of cylinder {cylinder.name!r}"
        if len(table.crank_angle) < FEWEST["linear"]:
            yield _short(path, what, len(table.crank_angle), FEWEST["linear"])
            continue
        found = [
            *turn_problems(path, what, table.crank_angle, "force", table.force, "N"),
        ]
        yield from found or _readable(path, what, way, table.crank_angle)
    pressure = train.gas_pressure
    ours = not gas_turns(case.machine) or way == "cubic"  # the others are refused for an engine
    if pressure is not None and way != "linear" and ours:
        yield from _readable(PRESSURE, "gas pressure", way, pressure.crank_angle)


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
        message=f"the {what} has too few rows for a curve over a turn",
        found=f"{one}{means}",
        allowed=f"{fewest} rows or more, the last one turn after the first",
    )
