"""Can the dampings and loads of a shaft line that follow the speed be what the case says?"""

from collections.abc import Iterator

from vibecalc.errors import KeyPath, Problem
from vibecalc.schema import Case
from vibecalc.torsion.checks import LINE, TORSION, asked_speeds, most_modes
from vibecalc.torsion.shaft_line_tables import (
    Load,
    ShaftLine,
    crank_station,
    joints,
    shaft_ends,
    speed_ratios,
    what_follows,
)

# ----------------------------------------------------------------------------
# One damping for each station, torques that a propeller takes, tables that reach far enough.
# ----------------------------------------------------------------------------

#: what a speed may lie beyond the ends of a table, rounding of units
_SLIP = 1e-12
#: at constant speed
_STEPS = ("load_step", "misfire_onset")


def damping_problems(case: Case) -> list[Problem]:
    """Problems of dampings, and of what follows the speed by a table."""
    line = case.machine.shaft_line
    if line is None:
        return []
    return [*_twice(line), *_loads(line), *_tables(case, line), *_answers(case, line)]


def _twice(line: ShaftLine) -> Iterator[Problem]:
    """A station has one absolute damping: its own, that of the engine, or that of a propeller."""
    seen: dict[str, KeyPath] = {}
    for place, station in enumerate(line.stations):
        key: KeyPath = (*LINE, "stations", place, "absolute_damping")
        if station.absolute_damping:
            seen[station.name] = key
        if line.engine_damping is not None and (station.cylinder or station.cylinders):
            if station.absolute_damping:
                yield Problem(
                    path=key,
                    message=f"station {station.name[:60]!r} has a damping of its own and that of "
                    "the engine",
                    allowed="one of them",
                    also=(*LINE, "engine_damping"),
                )
            seen[station.name] = (*LINE, "engine_damping")
    for place, load in enumerate(line.loads):
        if load.propeller_damping is None:
            continue
        path: KeyPath = (*LINE, "loads", place, "propeller_damping")
        if load.on in seen:
            yield Problem(
                path=path,
                message=f"station {load.on[:60]!r} has another absolute damping",
                allowed="one of them",
                also=seen[load.on],
            )
        seen.setdefault(load.on, path)


def _loads(line: ShaftLine) -> Iterator[Problem]:
    """A propeller damps by the torque that it takes."""
    for place, load in enumerate(line.loads):
        given = load.propeller_damping
        if given is None:
            continue
        path: KeyPath = (*LINE, "loads", place)
        least = load.torque if load.curve is None else min(load.curve.torque)
        if least is not None and least <= 0.0:
            yield Problem(
                path=(*path, "torque" if load.curve is None else "curve"),
                message="a propeller damps by the torque that it takes, which is above zero",
                found=f"{least:.6g} N*m",
                allowed="a torque that brakes, or no propeller_damping",
                also=(*path, "propeller_damping"),
            )
        if given.method == "slope" and (load.curve is not None or load.exponent == 0.0):
            yield Problem(
                path=(*path, "propeller_damping", "method"),
                message="the slope of this load is not known: "
                + ("a table has corners" if load.curve is not None else "its torque is constant"),
                allowed="a load with an exponent, as 2 of a propeller, or method = 'factor'",
                also=(*path, "curve") if load.curve is not None else path,
            )


def _tables(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """Between its entries a table is interpolated, beyond them nobody knows it."""
    asked = asked_speeds(case)
    for path, low, high in _spans(line):
        for key, speed in asked:
            if not low * (1.0 - _SLIP) <= speed <= high * (1.0 + _SLIP):
                yield Problem(
                    path=path,
                    message="the table does not reach a speed that is asked for",
                    found=f"{speed:.6g} rad/s of the crankshaft",
                    allowed=f"{low:.6g} to {high:.6g} rad/s, as the table goes",
                    hint="an entry at this speed, or a range that the table covers",
                    also=key,
                )
                break


def _spans(line: ShaftLine) -> Iterator[tuple[KeyPath, float, float]]:
    """Key, lowest and highest crank speed of each table over the speed."""
    names = [station.name for station in line.stations]
    at = {name: place for place, name in enumerate(names)}
    ratio = speed_ratios(len(names), joints(line), crank_station(line)).ratio
    given = [
        ((*LINE, "stations", place, "over_speed"), one.over_speed, ratio[place])
        for place, one in enumerate(line.stations)
    ]
    given += [
        ((*LINE, "shafts", place, "over_speed"), one.over_speed, ratio[at.get(first, 0)])
        for place, (one, (first, _)) in enumerate(zip(line.shafts, shaft_ends(line), strict=True))
    ]
    if line.engine_damping is not None:
        engine = line.engine_damping.over_speed
        given.append(((*LINE, "engine_damping", "over_speed"), engine, 1.0))
    for path, over, own in given:
        if over is not None and over.table is not None:
            per_crank = abs(own) if over.of == "own" else 1.0
            low, high = over.table.speed[0], over.table.speed[-1]
            yield (*path, "table"), low / per_crank, high / per_crank
    for place, load in enumerate(line.loads):
        if load.curve is not None:
            yield (*LINE, "loads", place, "curve"), load.curve.speed[0], load.curve.speed[-1]
    for place, one in enumerate(line.excitations):
        if one.over_speed is not None:
            low, high = one.over_speed.speed[0], one.over_speed.speed[-1]
            yield (*LINE, "excitations", place, "over_speed"), low, high


def _answers(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """What cannot follow a speed, and a mode that the line does not have."""
    engine = line.engine_damping
    if engine is not None and (engine.mode or 0) > most_modes(line):
        yield Problem(
            path=(*LINE, "engine_damping", "mode"),
            message=f"the line has no mode {engine.mode}",
            allowed=f"2 to {most_modes(line)}",
        )
    torsion = None if case.response is None else case.response.torsion
    if torsion is None:
        return
    change = torsion.transient
    if change is not None and change.kind not in _STEPS:
        for place, load in enumerate(line.loads):
            if load.curve is not None:
                yield _table_in_time(place, load)
    if torsion.damping_model is not None or not any(what_follows(line).values()):
        return
    words = "dampings of the line follow the speed, which "
    if torsion.method == "modal":
        yield Problem(
            path=(*TORSION, "method"),
            message=words + "a sum over modes with one damping each does not",
            found="method = 'modal'",
            allowed="method = 'elimination' or 'dense', or a damping_model",
        )
    if case.damper_design is not None:
        yield Problem(
            path=("damper_design",),
            message=words + "the search for a damper does not",
            allowed="dampings without over_speed and propeller_damping",
        )


def _table_in_time(place: int, load: Load) -> Problem:
    return Problem(
        path=(*LINE, "loads", place, "curve"),
        message=f"the load on {load.on[:60]!r} is a table, which a change of speed in time does "
        "not follow",
        allowed="torque and exponent, or a load_step or misfire_onset, which keep the speed",
        also=(*TORSION, "transient"),
    )
