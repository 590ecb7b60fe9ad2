"""Can the dampings and loads of a shaft line that follow the speed be what the case says?"""

from collections.abc import Iterator, Sequence

from vibecalc.errors import KeyPath, Problem
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine, what_follows
from vibecalc.torsion.transient_checks import LINE

# ----------------------------------------------------------------------------
# One damping for each station, torques that a propeller takes, tables that reach far enough.
# ----------------------------------------------------------------------------

#: what a speed may lie beyond the ends of a table, rounding of units
_SLIP = 1e-12
#: at constant speed
_STEPS = ("load_step", "misfire_onset")


def damping_problems(
    case: Case,
    line: ShaftLine,
    layout: Layout,
    speeds: Sequence[tuple[KeyPath, float]],
    modes: int,
) -> Iterator[Problem]:
    """Problems of dampings, and of what follows the speed by a table; `modes` of the line."""
    yield from _twice(line)
    yield from _loads(line)
    yield from _tables(line, layout, speeds)
    yield from _answers(case, line, modes)


def _twice(line: ShaftLine) -> Iterator[Problem]:
    """A station has one absolute damping: its own, that of the engine, or that of a propeller."""
    seen: dict[str, KeyPath] = {}
    of_engine: KeyPath = (*LINE, "engine_damping")
    for place, station in enumerate(line.stations):
        key: KeyPath = (*LINE, "stations", place, "absolute_damping")
        if station.absolute_damping:
            seen[station.name] = key
        if line.engine_damping is not None and station.turned_by:
            if station.absolute_damping:
                yield Problem(
                    path=key,
                    message=f"station {station.name[:60]!r} has a damping of its own and that of "
                    "the engine",
                    allowed="one of them",
                    also=of_engine,
                )
            seen[station.name] = of_engine
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


def _tables(
    line: ShaftLine, layout: Layout, speeds: Sequence[tuple[KeyPath, float]]
) -> Iterator[Problem]:
    """Between its entries a table is interpolated, beyond them nobody knows it."""
    for path, entries, per_crank in _spans(line, layout):
        low, high = entries[0] / per_crank, entries[-1] / per_crank
        for key, speed in speeds:
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


def _spans(line: ShaftLine, layout: Layout) -> Iterator[tuple[KeyPath, Sequence[float], float]]:
    """Key and speeds of each table over the speed, and these over the crank speed."""
    follow = [("stations", n, one.over_speed, n) for n, one in enumerate(line.stations)]
    follow += [
        ("shafts", n, one.over_speed, layout.at.get(first, 0))
        for n, (one, (first, _)) in enumerate(zip(line.shafts, layout.ends, strict=True))
    ]
    for key, n, over, station in follow:
        if over is not None and over.table is not None:
            own = abs(layout.ratio[station]) if over.of == "own" else 1.0
            yield (*LINE, key, n, "over_speed", "table"), over.table.speed, own
    engine = None if line.engine_damping is None else line.engine_damping.over_speed
    if engine is not None and engine.table is not None:
        yield (*LINE, "engine_damping", "over_speed", "table"), engine.table.speed, 1.0
    for n, load in enumerate(line.loads):
        if load.curve is not None:
            yield (*LINE, "loads", n, "curve"), load.curve.speed, 1.0
    for n, one in enumerate(line.excitations):
        if one.over_speed is not None:
            yield (*LINE, "excitations", n, "over_speed"), one.over_speed.speed, 1.0


def _answers(case: Case, line: ShaftLine, modes: int) -> Iterator[Problem]:
    """What cannot follow a speed, and a mode that the line does not have."""
    engine = line.engine_damping
    if engine is not None and (engine.mode or 0) > modes:
        yield Problem(
            path=(*LINE, "engine_damping", "mode"),
            message=f"the line has no mode {engine.mode}",
            allowed=f"2 to {modes}",
        )
    torsion = None if case.response is None else case.response.torsion
    if torsion is None:
        return
    change = torsion.transient
    moves = change is not None and change.kind not in _STEPS
    for place, load in enumerate(line.loads):
        if moves and load.curve is not None:
            yield Problem(
                path=(*LINE, "loads", place, "curve"),
                message=f"the load on {load.on[:60]!r} is a table, which a change of speed in time "
                "does not follow",
                allowed="torque and exponent, or a load_step or misfire_onset, which keep the "
                "speed",
                also=("response", "torsion", "transient"),
            )
    if torsion.damping_model is not None or not any(what_follows(line).values()):
        return
    words = "dampings of the line follow the speed, which "
    if torsion.method == "modal":
        yield Problem(
            path=("response", "torsion", "method"),
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
