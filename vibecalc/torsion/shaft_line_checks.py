"""Is the shaft line of a case possible: its network, its dimensions, what is said to be on it?"""

from collections.abc import Iterator

from vibecalc.core.case.raw import listed
from vibecalc.errors import KeyPath, NumericalFailure, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.parts.crank_train import turns
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine

# ----------------------------------------------------------------------------
# Does a shaft line hang together, turn, and carry what is said to be on it?
# ----------------------------------------------------------------------------

LINE: KeyPath = ("machine", "shaft_line")


def shaft_line_problems(case: Case, line: ShaftLine, layout: Layout) -> list[Problem]:
    """Problems of names, of the network, of ratios and of the parts of a shaft line."""
    problems = [*_count(line), *_places(line, layout), *_cylinders(case, line)]
    problems += _section_names(line, layout)
    return problems or [*_network(line, layout)] or [*_inertias(case, line, layout)]


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


def _places(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """What stands on a station: loads, the rings of dampers."""
    taking = layout.names[layout.load]
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
        if damper.name in layout.at:
            yield Problem(
                path=(*LINE, "dampers", place, "name"),
                message=f"a station is named {damper.name[:60]!r}, too",
                allowed="a name of its own: the ring of a damper is a station in the results",
                also=(*LINE, "stations", layout.at[damper.name], "name"),
            )


def _section_names(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Shafts, gears and dampers are the sections of the results: one name each."""
    seen: dict[str, KeyPath] = {}
    for key, names in (
        ("shafts", layout.sections),
        ("gears", [gear.label for gear in line.gears]),
        ("dampers", [damper.name for damper in line.dampers]),
    ):
        for place, name in enumerate(names):
            path: KeyPath = (*LINE, key, place)
            if name in seen and (seen[name][2] != key or " - " in name):
                yield Problem(
                    path=path,
                    message=f"two sections of the line are named {name[:80]!r}",
                    allowed="a name of its own for each shaft, gear and damper",
                    also=seen[name],
                )
            seen.setdefault(name, path)


def _cylinders(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """Each cylinder turns one station."""
    train = case.machine.crank_train
    names = [one.name for one in train.cylinders] if has_crank_train(case.machine) else []
    seen: dict[str, KeyPath] = {}
    twice = 0
    for place, station in enumerate(line.stations):
        for at, name in enumerate(station.turned_by):
            path: KeyPath = (*LINE, "stations", place)
            path = (*path, "cylinder") if station.cylinder else (*path, "cylinders", at)
            if name in seen:
                twice += 1
                yield Problem(
                    path=path,
                    message=f"cylinder {name[:60]!r} turns two stations",
                    allowed="each cylinder on one station",
                    also=seen[name],
                )
            seen.setdefault(name, path)
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


def _network(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """One connected part, ratios that agree, cylinders at the speed of the crankshaft."""
    names, ratios = layout.names, layout.ratios
    if ratios.contradiction is not None:
        place, others, stated_ratio = ratios.contradiction
        gear, one = place - len(line.shafts), layout.joints[place]
        yield Problem(
            path=(*LINE, "shafts", place) if gear < 0 else (*LINE, "gears", gear),
            message="the ratios around a loop contradict each other: the line cannot turn",
            found=f"{names[one.second]!r} turns {others:.9g} times as fast as "
            f"{names[one.first]!r} by the others, {stated_ratio:.9g} times by this one",
            allowed="one ratio between two stations, whichever way it is reckoned",
            hint="gear wheels turn opposite ways unless reverses = false",
        )
        return
    strays = [n for n, part in enumerate(ratios.part) if part != ratios.part[layout.crank]]
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
    for place, joint in enumerate(layout.joints[: len(line.shafts)]):
        if layout.freedom[joint.first] == layout.freedom[joint.second]:
            yield Problem(
                path=(*LINE, "shafts", place),
                message="rigid gears hold both ends of this shaft: it can never twist",
                found=f"{names[joint.first]!r} and {names[joint.second]!r}",
                allowed="a mesh_stiffness for one of the gears, or no such shaft",
            )
    for place, (fires, ratio) in enumerate(zip(layout.fires, ratios.ratio, strict=True)):
        if fires and abs(ratio - 1.0) > 1e-9:
            yield Problem(
                path=(*LINE, "stations", place),
                message="this station has a cylinder and does not turn as the crankshaft does",
                found=f"{ratio:.9g} times the speed of {names[layout.crank]!r}",
                allowed="all cylinders on one crankshaft, or on shafts of its speed and sense",
            )


def _inertias(case: Case, line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    from vibecalc.torsion.model import station_inertia, stiffness_of

    if has_crank_train(case.machine) and not turns(case.machine.crank_train):
        return
    inertia = station_inertia(case, line)
    if not any(inertia):
        yield Problem(
            path=(*LINE, "stations"),
            message="the line has no inertia at all",
            allowed="an inertia above zero for one station or more",
        )
    for place, (shaft, ends) in enumerate(zip(line.shafts, layout.ends, strict=True)):
        one, other = (inertia[layout.at[end]] for end in ends)
        if shaft.damping_ratio and not (one > 0.0 and other > 0.0):
            yield Problem(
                path=(*LINE, "shafts", place, "damping_ratio"),
                message="a damping ratio of two neighbours needs an inertia at both ends",
                found=f"{one:g} kg*m^2 at {ends[0]!r} and {other:g} kg*m^2 at {ends[1]!r}",
                allowed="damping in N*m*s/rad instead",
            )
    radius = case.machine.crank_train.crank_radius if has_crank_train(case.machine) else 0.0
    for place, shaft in enumerate(line.shafts):
        try:
            stiffness_of(shaft, radius)
        except NumericalFailure as error:
            key, better = "throw", "another formula"
            if shaft.section is not None:
                key, better = "section", "a thicker wall"
            yield Problem(
                path=(*LINE, "shafts", place, key),
                message=f"no stiffness follows from the dimensions: {error}",
                allowed=f"{better}, or stiffness",
            )
            return
