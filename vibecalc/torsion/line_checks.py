"""Is the shaft line of a case possible: its network, what is on it, what follows speed or load?"""

from collections.abc import Iterator, Sequence

from vibecalc.core.case.raw import listed
from vibecalc.core.case.rules import both
from vibecalc.errors import KeyPath, NumericalFailure, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.parts.crank_train import turns
from vibecalc.parts.firing import is_separate, with_torque
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine, what_follows
from vibecalc.torsion.study_results import PASSAGES
from vibecalc.torsion.tables import Torsion

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
            message="a line in series has one shaft fewer than stations",
            found=f"{shafts} shafts and {wanted + 1} stations",
            allowed=f"{wanted} shafts, or `between` with the names of two stations for each",
        )
    elif line.gears and line.shafts:
        yield Problem(
            path=(*LINE, "shafts", 0),
            message="in a line with gears each shaft needs `between`",
            allowed="between = ['first', 'second'] for every shaft",
            also=(*LINE, "gears", 0),
        )


def _places(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """What stands on a station: loads, the rings of dampers."""
    taking = layout.names[layout.load]
    for place, load in enumerate(line.absorbed_torques):
        if load.on == taking:
            yield Problem(
                path=(*LINE, "absorbed_torques", place, "on"),
                message=f"station {taking[:60]!r} balances the mean torque, and has a load of its "
                "own",
                allowed="no load of its own, or another station as `balanced_by`",
                also=(*LINE, "balanced_by") if line.balanced_by is not None else None,
            )
    for place, damper in enumerate(line.dampers):
        if damper.name in layout.at:
            yield Problem(
                path=(*LINE, "dampers", place, "name"),
                message=f"a station is also named {damper.name[:60]!r}",
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
            message="these cylinders have no station"
            if len(left) > 1
            else "a cylinder has no station",
            found=listed(left),
            allowed="cylinder = '...' on one station per cylinder, or `cylinders` for a shared pin",
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
            f"{names[one.first]!r} through the other gears, {stated_ratio:.9g} times by this one",
            allowed="the same ratio along every path between two stations",
            hint="gear wheels turn opposite ways unless reverses = false",
        )
        return
    strays = [n for n, part in enumerate(ratios.part) if part != ratios.part[layout.crank]]
    if strays:
        yield Problem(
            path=(*LINE, "stations", strays[0]),
            message="the line is in two parts: no shaft or gear connects "
            + ("this station" if len(strays) == 1 else "these stations")
            + " to the crankshaft",
            found=listed([names[place] for place in strays]),
            allowed="a shaft or a gear to every station",
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
                message="this station has a cylinder and does not turn with the crankshaft",
                found=f"{ratio:.9g} times the speed of {names[layout.crank]!r}",
                allowed="all cylinders on one crankshaft, or on shafts with its speed and sense",
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


# ----------------------------------------------------------------------------
# Questions that take one line for all speeds and frequencies, and have none here.
# ----------------------------------------------------------------------------

TORSION: KeyPath = ("response", "torsion")
SHAFTS: KeyPath = ("machine", "shaft_line", "shafts")
#: questions that take one line, and why
_ONE_LINE = {
    "transient": "a march in time has no frequency and no steady state to take it at",
    "variable_inertia": "its motion couples all orders in one line",
    "as_published": "its closed forms are of one set of modes",
    "damping_model": "it damps one set of modes and leaves out what the coupling damps",
}


def coupling_problems(case: Case, line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Problems of couplings whose stiffness is not one number."""
    given = [(place, shaft.coupling) for place, shaft in enumerate(line.shafts) if shaft.coupling]
    varying = [(place, follows) for place, one in given if (follows := one.follows)]
    if not varying:
        return
    yield from _asked(case, *varying[0])
    # in a loop the mean torque of a coupling follows its stiffness, which follows that
    for place, one in given:
        part, joint = layout.parts_without(place), layout.joints[place]
        if one.over_mean_torque is not None and part[joint.first] == part[joint.second]:
            yield Problem(
                path=(*SHAFTS, place, "coupling", "over_mean_torque"),
                message=f"coupling {layout.sections[place][:60]!r} is in a closed loop, where its "
                "mean torque is statically indeterminate",
                allowed="the stiffness at its mean torque, as `stiffness`",
            )


def _asked(case: Case, place: int, follows: list[str]) -> Iterator[Problem]:
    """What a march in time, a sum over modes or a damper's map cannot take."""
    from vibecalc.torsion.line_part_tables import FOLLOWS

    torsion = None if case.response is None else case.response.torsion
    asked: list[tuple[KeyPath, str]] = [
        ((*TORSION, key), why)
        for key, why in _ONE_LINE.items()
        if getattr(torsion, key, None) is not None
    ]
    if torsion is not None and torsion.method == "modal":
        asked.append(((*TORSION, "method"), "a sum over modes takes one line for all orders"))
    if case.damper_design is not None:
        asked.append((("damper_design",), "its map takes one line for all dampers"))
    if not is_separate(case):
        why = "the couple on the mounts is that of one line"
        asked += [((table,), why) for table in with_torque(case)]
    for path, why in asked:
        words = both([FOLLOWS[key] for key in follows])
        yield Problem(
            path=path,
            message=f"a coupling of the line follows {words}: {why}",
            found=f"{path[-1]}, with {', '.join(follows)}",
            allowed="a coupling of constant stiffness and relative_damping, or the steady response",
            hint="a variant of the case with the values that hold there",
            also=(*SHAFTS, place, "coupling", follows[0]),
        )


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
    for place, load in enumerate(line.absorbed_torques):
        if load.propeller_damping is None:
            continue
        path: KeyPath = (*LINE, "absorbed_torques", place, "propeller_damping")
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
    for place, load in enumerate(line.absorbed_torques):
        given = load.propeller_damping
        if given is None:
            continue
        path: KeyPath = (*LINE, "absorbed_torques", place)
        least = load.torque if load.curve is None else min(load.curve.torque)
        if least is not None and least <= 0.0:
            yield Problem(
                path=(*path, "torque" if load.curve is None else "curve"),
                message="propeller damping needs a braking torque",
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
    for n, load in enumerate(line.absorbed_torques):
        if load.curve is not None:
            yield (*LINE, "absorbed_torques", n, "curve"), load.curve.speed, 1.0
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
    for place, load in enumerate(line.absorbed_torques):
        if moves and load.curve is not None:
            yield Problem(
                path=(*LINE, "absorbed_torques", place, "curve"),
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


DESIGN: KeyPath = ("damper_design",)

# ----------------------------------------------------------------------------
# Torques given at stations: do they have what they follow, and can every question count them?
# ----------------------------------------------------------------------------

#: questions that know the torques of cylinders alone
_OF_CYLINDERS_ALONE = ("as_published", "variable_inertia")


def excitation_problems(
    case: Case, line: ShaftLine, layout: Layout, torsion: Torsion | None
) -> Iterator[Problem]:
    """Problems of [[machine.shaft_line.excitations]], and of a line without cylinders."""
    change = None if torsion is None else torsion.transient
    step = change is not None and change.kind not in PASSAGES
    alone = step and torsion is not None and torsion.speeds is None
    if not has_crank_train(case.machine) and not line.excitations and torsion and not alone:
        yield Problem(
            path=LINE,
            message="nothing excites this line: it has no cylinders and no excitations",
            allowed="excitations = [{ on = 'pump', blades = 5, shares = [0.05] }], for example",
            hint="for natural and critical speeds or a run-up alone, torques = ['0 N*m'] with the "
            "orders that count; a load step without speeds needs none",
        )
    if not line.excitations:
        return
    asked = [key for key in _OF_CYLINDERS_ALONE if getattr(torsion, key, None)]
    refused: list[KeyPath] = [(*TORSION, key) for key in asked]
    for path in (*refused, DESIGN) if case.damper_design is not None else refused:
        yield Problem(
            path=path,
            message=f"{path[-1]} counts the torques of cylinders alone",
            allowed="no excitations in [machine.shaft_line] with it",
            also=(*LINE, "excitations", 0),
        )
    if change is not None and change.kind in PASSAGES:
        yield from _followed_in_passages(line, layout)
    elif change is not None and change.clutch is not None:
        yield from _not_behind_clutch(line, layout, change.clutch)
    for table in () if is_separate(case) else with_torque(case):
        yield Problem(
            path=(table,),
            message="the torque on the mounts counts the torques of cylinders alone",
            allowed="no excitations in [machine.shaft_line], or a driven machine that stands "
            "elsewhere: driven_machine = 'separate'",
            hint='loads = ["shaking"] leaves the torque out',
            also=(*LINE, "excitations", 0),
        )
    yield from _followed(case, line, layout)


def _followed(case: Case, line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Shares of a mean torque that there is, frequencies that are no orders."""
    loaded = {layout.names[layout.load], *(load.on for load in line.absorbed_torques)}
    for place, one in enumerate(line.excitations):
        path: KeyPath = (*LINE, "excitations", place)
        if one.shares and one.on not in loaded:
            yield Problem(
                path=(*path, "shares"),
                message=f"station {one.on[:60]!r} takes no mean torque to have a share of",
                allowed="a station of `absorbed_torques`, or `balanced_by`; or torques instead",
                also=(*LINE, "absorbed_torques") if line.absorbed_torques else None,
            )
        for number, frequency in enumerate(one.frequencies):
            half = 2.0 * frequency / case.machine.speed
            if abs(half - round(half)) <= 1e-9 * max(half, 1.0):
                yield Problem(
                    path=(*path, "frequencies", number),
                    message=f"this frequency is order {half / 2.0:g} at the operating speed",
                    allowed="orders instead, if it follows the speed; else a frequency that is no "
                    "multiple of half the speed",
                    also=("machine", "speed"),
                )


def _followed_in_passages(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """While the speed changes, torques stay as they are or go with its square."""
    taking = layout.names[layout.load]
    for place, one in enumerate(line.excitations):
        path: KeyPath = (*LINE, "excitations", place)
        loads = [load for load in line.absorbed_torques if load.on == one.on]
        exponents = [load.exponent for load in loads if load.curve is None]
        by_square = one.exponent in (0.0, 2.0)
        if one.shares:
            by_square = one.on != taking and len(loads) == 1 and exponents in ([0.0], [2.0])
        key = next((key for key in ("frequencies", "over_speed") if getattr(one, key)), "")
        if key or not by_square:
            yield Problem(
                path=(*path, key or ("shares" if one.shares else "exponent")),
                message="while the speed changes, a torque at a station is constant or goes with "
                "the square of the speed",
                allowed="exponent 0 or 2, shares of one load with such an exponent; or a change "
                "at constant speed",
                also=(*TORSION, "transient", "kind"),
            )


def _not_behind_clutch(line: ShaftLine, layout: Layout, clutch: str) -> Iterator[Problem]:
    """Orders behind a clutch would count turns of a shaft that slips."""
    if clutch not in layout.sections:
        return
    part = layout.parts_without(layout.sections.index(clutch))
    for place, one in enumerate(line.excitations):
        size = one.record or any(one.torques) or any(one.shares)
        if size and part[layout.at[one.on]] != part[layout.crank]:
            yield Problem(
                path=(*LINE, "excitations", place, "on"),
                message="this station slips before the clutch holds, and orders of its shaft are "
                "none of the crank",
                allowed="torques on the side of the clutch that turns with machine.speed",
                also=(*TORSION, "transient", "clutch"),
            )
