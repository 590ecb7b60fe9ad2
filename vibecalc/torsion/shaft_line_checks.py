"""Is the shaft line of a case possible: its network, its dimensions, what is said to be on it?"""

from collections.abc import Iterator, Sequence

from vibecalc.core.case.raw import listed
from vibecalc.errors import KeyPath, NumericalFailure, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.parts.crank_train import turns
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import (
    ShaftLine,
    StationJoint,
    crank_station,
    joints,
    merged,
    shaft_ends,
    speed_ratios,
)

# ----------------------------------------------------------------------------
# Does a shaft line hang together, turn, and carry what is said to be on it?
# ----------------------------------------------------------------------------

LINE: KeyPath = ("machine", "shaft_line")


def shaft_line_problems(case: Case) -> list[Problem]:
    """Problems of names, of the network, of ratios and of the parts of a shaft line."""
    line = case.machine.shaft_line
    if line is None:
        return []
    train = has_crank_train(case.machine)
    cylinders = [one.name for one in case.machine.crank_train.cylinders] if train else []
    problems = [*_count(line), *_places(line), *_cylinders(line, cylinders), *_section_names(line)]
    return problems or [*_network(line)] or [*_inertias(case, line)]


def _count(line: ShaftLine) -> Iterator[Problem]:
    """Without `between` the shafts are those of a chain."""
    if any(shaft.between is not None for shaft in line.shafts):
        return
    shafts, wanted = len(line.shafts), len(line.stations) - 1
    if shafts > wanted or (shafts < wanted and not line.gears):
        yield Problem(
            path=(*LINE, "shafts") if line.shafts else LINE,
            message="a chain has one shaft less than stations",
            found=f"{shafts} shafts and {wanted + 1} stations",
            allowed=f"{wanted} shafts, or `between` with the names of two stations for each",
        )
    elif line.gears and line.shafts:
        yield Problem(
            path=(*LINE, "shafts", 0),
            message="with gears a shaft has to say between which stations it is",
            allowed="between = ['first', 'second'] for every shaft",
            also=(*LINE, "gears", 0),
        )


def _places(line: ShaftLine) -> Iterator[Problem]:
    """What stands on a station: loads, the rings of dampers."""
    names = [station.name for station in line.stations]
    taking = line.load or names[-1]
    for place, load in enumerate(line.loads):
        if load.on == taking:
            yield Problem(
                path=(*LINE, "loads", place, "on"),
                message=f"station {taking[:60]!r} takes up the mean torque that is left, and has a "
                "load of its own",
                allowed="no load of its own, or another station as `load`",
                also=(*LINE, "load") if line.load is not None else None,
            )
    for place, damper in enumerate(line.dampers):
        if damper.name in names:
            yield Problem(
                path=(*LINE, "dampers", place, "name"),
                message=f"a station is named {damper.name[:60]!r}, too",
                allowed="a name of its own: the ring of a damper is a station in the results",
                also=(*LINE, "stations", names.index(damper.name), "name"),
            )


def _section_names(line: ShaftLine) -> Iterator[Problem]:
    """Shafts, gears and dampers are the sections of the results: one name each."""
    seen: dict[str, KeyPath] = {}
    shafts = [
        (one.name or " - ".join(ends), ("shafts", place))
        for place, (one, ends) in enumerate(zip(line.shafts, shaft_ends(line), strict=True))
        if ends != ("", "")
    ]
    gears = [
        (one.name or " - ".join(one.between), ("gears", place))
        for place, one in enumerate(line.gears)
    ]
    dampers = [(one.name, ("dampers", place)) for place, one in enumerate(line.dampers)]
    for name, where in (*shafts, *gears, *dampers):
        path: KeyPath = (*LINE, *where)
        if name in seen and (seen[name][2] != where[0] or " - " in name):
            yield Problem(
                path=path,
                message=f"two sections of the line are named {name[:80]!r}",
                allowed="a name of its own for each shaft, gear and damper",
                also=seen[name],
            )
        seen.setdefault(name, path)


def _cylinders(line: ShaftLine, names: Sequence[str]) -> Iterator[Problem]:
    """Each cylinder turns one station."""
    seen: dict[str, KeyPath] = {}
    twice = 0
    for place, station in enumerate(line.stations):
        path: KeyPath = (*LINE, "stations", place)
        given: list[tuple[KeyPath, str]] = [
            ((*path, "cylinders", at), name) for at, name in enumerate(station.cylinders)
        ]
        if station.cylinder is not None:
            given.append(((*path, "cylinder"), station.cylinder))
        for key, name in given:
            if name in seen:
                twice += 1
                yield Problem(
                    path=key,
                    message=f"cylinder {name[:60]!r} turns two stations",
                    allowed="each cylinder on one station",
                    also=seen[name],
                )
            seen.setdefault(name, key)
    left = [name for name in names if name not in seen]
    if len(left) > twice:  # a name typed twice leaves one out
        yield Problem(
            path=(*LINE, "stations"),
            message="these cylinders turn no station"
            if len(left) > 1
            else "a cylinder has no station",
            found=listed(left),
            allowed="cylinder = '...' on one station for each, or cylinders of a shared pin",
            also=("machine", "crank_train", "cylinders"),
        )


def _network(line: ShaftLine) -> Iterator[Problem]:
    """One connected part, ratios that agree, cylinders at the speed of the crankshaft."""
    names = [station.name for station in line.stations]
    joined = joints(line)
    crank = crank_station(line)
    ratios = speed_ratios(len(names), joined, crank)
    if ratios.contradiction is not None:
        place, others, stated_ratio = ratios.contradiction
        gears = len(line.shafts)
        key = ("gears", place - gears) if place >= gears else ("shafts", place)
        one: StationJoint = joined[place]
        yield Problem(
            path=(*LINE, *key),
            message="the ratios around a loop contradict each other: the line cannot turn",
            found=f"{names[one.second]!r} turns {others:.9g} times as fast as "
            f"{names[one.first]!r} by the others, {stated_ratio:.9g} times by this one",
            allowed="one ratio between two stations, whichever way it is reckoned",
            hint="gear wheels turn opposite ways unless reverses = false",
        )
        return
    strays = [place for place, part in enumerate(ratios.part) if part != ratios.part[crank]]
    if strays:
        yield Problem(
            path=(*LINE, "stations", strays[0]),
            message="the line is in two pieces: nothing joins "
            + ("this station" if len(strays) == 1 else "these stations")
            + " to the crankshaft",
            found=listed([names[place] for place in strays]),
            allowed="a shaft or a gear to each station; what turns alone is a case of its own",
        )
        return
    at = {name: place for place, name in enumerate(names)}
    rigid = [g.between for g in line.gears if g.mesh_stiffness is None]
    freedom = merged(len(names), [(at[a], at[b]) for a, b in rigid])
    for place, (a, b) in enumerate(shaft_ends(line)):
        if freedom[at[a]] == freedom[at[b]]:
            yield Problem(
                path=(*LINE, "shafts", place),
                message="rigid gears hold both ends of this shaft: it can never twist",
                found=f"{a!r} and {b!r}",
                allowed="a mesh_stiffness for one of the gears, or no such shaft",
            )
    for place, station in enumerate(line.stations):
        ratio = ratios.ratio[place]
        if (station.cylinder or station.cylinders) and abs(ratio - 1.0) > 1e-9:
            yield Problem(
                path=(*LINE, "stations", place),
                message="this station has a cylinder and does not turn as the crankshaft does",
                found=f"{ratio:.9g} times the speed of {names[crank]!r}",
                allowed="all cylinders on one crankshaft, or on shafts of its speed and sense",
            )


def _inertias(case: Case, line: ShaftLine) -> Iterator[Problem]:
    from vibecalc.parts.crank_train import build_crank_train
    from vibecalc.torsion.model import shaft_elements, station_inertia

    train, built = case.machine.crank_train, None
    if has_crank_train(case.machine):
        if not turns(train):
            return
        built = build_crank_train(train)
    inertia = station_inertia(line, train, built)
    if not any(inertia):
        yield Problem(
            path=(*LINE, "stations"),
            message="the line has no inertia at all",
            allowed="an inertia above zero for one station or more",
        )
    at = {station.name: place for place, station in enumerate(line.stations)}
    for place, (a, b) in enumerate(shaft_ends(line)):
        if line.shafts[place].damping_ratio and not (inertia[at[a]] > 0.0 and inertia[at[b]] > 0.0):
            yield Problem(
                path=(*LINE, "shafts", place, "damping_ratio"),
                message="a damping ratio of two neighbours needs an inertia at both ends",
                found=f"{inertia[at[a]]:g} kg*m^2 at {a!r} and {inertia[at[b]]:g} kg*m^2 at {b!r}",
                allowed="damping in N*m*s/rad instead",
            )
    try:
        shaft_elements(line, train, at, inertia)
    except NumericalFailure as error:
        place = next(n for n, shaft in enumerate(line.shafts) if shaft.throw is not None)
        yield Problem(
            path=(*LINE, "shafts", place, "throw"),
            message=f"no stiffness follows from the dimensions: {error}",
            allowed="another formula, or stiffness",
        )
