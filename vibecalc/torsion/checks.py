"""Can what a case asks of its shaft line be answered, and is it what it looks like?"""

from collections.abc import Iterator

from vibecalc.core.case.fields import RunUp
from vibecalc.core.case.raw import unknown
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.firing import is_separate, torque_reaches_mounts
from vibecalc.schema import Case
from vibecalc.torsion.shaft_line_tables import (
    ShaftLine,
    StationJoint,
    crank_station,
    has_stress,
    joints,
    section_names,
    shaft_ends,
    speed_ratios,
)
from vibecalc.torsion.tables import AsPublished, LineSpeeds, Torsion, TorsionLimit
from vibecalc.torsion.transient_checks import change_problems

# ----------------------------------------------------------------------------
# Can what is asked of a shaft line be answered: speeds, orders, cylinders, sections?
# ----------------------------------------------------------------------------

TORSION: KeyPath = ("response", "torsion")
DESIGN: KeyPath = ("damper_design",)
LINE: KeyPath = ("machine", "shaft_line")
#: the largest order of the excitation
HIGHEST = 400.0


def torsion_problems(case: Case) -> list[Problem]:
    """Problems of [response.torsion] and [damper_design] against the machine."""
    line = case.machine.shaft_line
    if line is None:
        return list(_speeds(case)) if torque_reaches_mounts(case) else []
    torsion = None if case.response is None else case.response.torsion
    problems = [*_speeds(case), *_run_up(case, line)]
    if torsion is not None:
        problems += [*_orders(case, torsion), *change_problems(line, torsion)]
        problems += [*_damping(line, torsion), *_published(line, torsion)]
        for place, limit in enumerate(torsion.limits):
            problems += _limit((*TORSION, "limits", place), line, limit)
    return [*problems, *design_problems(case, line)]


def _speeds(case: Case) -> Iterator[Problem]:
    """Between cards pressure is interpolated, beyond them nobody has measured it."""
    cards = case.machine.crank_train.gas_cards
    if len(cards) < 2:
        return
    low, high = min(c.speed for c in cards), max(c.speed for c in cards)
    torsion = None if case.response is None else case.response.torsion
    asked: list[tuple[KeyPath, float | None]] = [(("machine", "speed"), case.machine.speed)]
    ranges: list[tuple[KeyPath, LineSpeeds | RunUp | None]] = []
    if torsion is not None:
        ranges.append(((*TORSION, "speeds"), torsion.speeds))
        if torsion.transient is not None:
            path: KeyPath = (*TORSION, "transient")
            change = torsion.transient
            asked += [((*path, "from"), change.start), ((*path, "to"), change.stop)]
    if case.isolation is not None and case.isolation.run_up and torque_reaches_mounts(case):
        ranges.append((("isolation", "run_up"), case.isolation.run_up))
    if case.damper_design is not None:
        ranges.append(((*DESIGN, "speeds"), case.damper_design.speeds))
    for path, speeds in ranges:
        if speeds is not None:
            asked += [((*path, "from"), speeds.start), ((*path, "to"), speeds.stop)]
    for path, speed in asked if low < high else ():
        if speed is not None and not low * (1 - 1e-12) <= speed <= high * (1 + 1e-12):
            yield Problem(
                path=path,
                message="this speed is outside the range of the gas cards",
                found=f"{speed:.6g} rad/s",
                allowed=f"{low:.6g} to {high:.6g} rad/s",
                hint="a card at this speed, or a range that the cards cover",
                also=("machine", "crank_train", "gas_cards"),
            )


def _run_up(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """A geared line without damping passes resonances of no bound, which nothing would bridge."""
    options = case.isolation
    if options is None or options.run_up is None or not torque_reaches_mounts(case):
        return
    if is_separate(case) or not line.gears or not line.shafts:
        return
    damped = bool(line.dampers) or any(
        s.damping or s.damping_ratio or s.loss_factor for s in line.shafts
    )
    if not damped and not any(station.absolute_damping for station in line.stations):
        yield Problem(
            path=("isolation", "run_up"),
            message="on its way up the torque passes the resonances of a geared line that nothing "
            "damps: it has no bound there",
            allowed="damping or loss_factor of the shafts, absolute_damping of a station, or "
            "driven_machine = 'separate'",
            also=LINE,
        )


def _orders(case: Case, torsion: Torsion) -> Iterator[Problem]:
    orders = torsion.orders
    if orders is None:
        return
    path: KeyPath = (*TORSION, "orders")
    least = 1.0 if case.machine.cycle == "two_stroke" else 0.5
    if orders.step is not None and orders.step < least:
        yield Problem(
            path=(*path, "step"),
            message="a two-stroke engine repeats itself every turn and has no half orders",
            found=f"step = {orders.step:g}",
            allowed="1, or cycle = 'four_stroke'",
            also=("machine", "cycle"),
        )
    step = orders.step or least
    top = step * orders.count if orders.count is not None else orders.highest or 0.0
    if top > HIGHEST:
        yield Problem(
            path=(*path, "count"),
            message="the orders go too far",
            found=f"up to {top:g}",
            allowed=f"up to {HIGHEST:g}",
        )
    elif orders.highest is not None and orders.highest < step:
        yield Problem(
            path=(*path, "highest"),
            message="there is no order up to the highest one",
            found=f"highest = {orders.highest:g}, the first order is {step:g}",
            allowed=f">= {step:g}",
        )


def _damping(line: ShaftLine, torsion: Torsion) -> Iterator[Problem]:
    model, modes = torsion.damping_model, _modes(line)
    if model is not None:
        path: KeyPath = (*TORSION, "damping_model")
        if model.kind == "modal" and len(model.ratios) > modes:
            yield Problem(
                path=(*path, "ratios"),
                message="there are more ratios than modes",
                found=f"{len(model.ratios)} ratios",
                allowed=f"up to {modes}, the first one of the rigid mode, or one for all",
            )
        for place, mode in enumerate(model.modes):
            if mode > modes:
                yield Problem(
                    path=(*path, "modes", place),
                    message=f"the line has no mode {mode}",
                    allowed=f"2 to {modes}",
                )


def _modes(line: ShaftLine) -> int:
    """Modes of a line, rigid ones too."""
    rigid = sum(1 for gear in line.gears if gear.mesh_stiffness is None)
    return max(len(line.stations) + len(line.dampers) - rigid, 1)


def _published(line: ShaftLine, torsion: Torsion) -> Iterator[Problem]:
    options = torsion.as_published
    held = any(station.ground_stiffness for station in line.stations)
    rings = sum(1 for damper in line.dampers if damper.kind == "viscous")
    elastic = max(_modes(line) - rings - (0 if held else 1), 0)
    if options is None or options.modes <= max(elastic, AsPublished().modes):
        return
    yield Problem(
        path=(*TORSION, "as_published", "modes"),
        message="more modes are asked for than the line has",
        found=f"modes = {options.modes}",
        allowed=f"up to {elastic}, its elastic modes",
    )


def _limit(path: KeyPath, line: ShaftLine, limit: TorsionLimit) -> Iterator[Problem]:
    known = section_names(line)
    for place, name in enumerate(limit.sections):
        if name not in known:
            yield unknown((*path, "sections", place), "shaft", name, known)
    stressed = [name for name, shaft in zip(known, line.shafts, strict=True) if has_stress(shaft)]
    asked = [name for name in limit.sections if name in known] or (
        [] if limit.sections else stressed
    )
    if not asked and not limit.sections:
        yield Problem(
            path=path,
            message="no shaft has a section modulus, and a limit of the stress holds nothing",
            allowed="diameter, section_modulus or section on the shafts that it is for",
        )
    for name in asked:
        place = known.index(name)
        shaft = line.shafts[place]
        if name not in stressed:
            yield Problem(
                path=path,
                message=f"shaft {name[:60]!r} has no section modulus for a stress",
                allowed="diameter, section_modulus or section on this shaft",
                also=(*LINE, "shafts", place),
            )
        elif (
            limit.rule is not None and limit.tensile_strength is None and not shaft.tensile_strength
        ):
            yield Problem(
                path=path,
                message=f"the rule needs the tensile strength of shaft {name[:60]!r}",
                allowed="tensile_strength here, or on the shaft",
                also=(*LINE, "shafts", place),
            )
        elif limit.rule is not None and shaft.section_modulus is not None:
            yield Problem(
                path=path,
                message=f"the rule needs the diameter of shaft {name[:60]!r}",
                allowed="diameter or section instead of section_modulus",
                also=(*LINE, "shafts", place, "section_modulus"),
            )


# ----------------------------------------------------------------------------
# Can a damper be designed for this place of the line, with these numbers?
# ----------------------------------------------------------------------------


def design_problems(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """Problems of where the damper hangs, of what is looked for, and of its bounds."""
    design = case.damper_design
    if design is None:
        return
    dampers = {damper.name: damper for damper in line.dampers}
    stations = [station.name for station in line.stations]
    replaced = dampers.get(design.on)
    if replaced is None and design.on not in stations:
        yield unknown((*DESIGN, "on"), "station or damper", design.on, [*stations, *dampers])
    if replaced is not None and replaced.kind == "pendulum":
        yield Problem(
            path=(*DESIGN, "on"),
            message="pendulums are tuned by their order, not by a spring and a damper",
            found=repr(design.on[:60]),
            allowed="a station, or a damper of kind 'viscous' or 'spring'",
        )
    bounds = design.bounds
    for key in ("inertia", "stiffness", "damping"):
        bound = None if bounds is None else getattr(bounds, key)
        sought = key in design.find
        given = getattr(design, key)
        path: KeyPath = (*DESIGN, key)
        if sought and key == "inertia" and bound is None:
            yield Problem(
                path=DESIGN,
                message="an inertia that is looked for needs bounds: more is always better",
                allowed="bounds = { inertia = ['2 kg*m^2', '9 kg*m^2'] }, for example",
            )
        if sought and given is not None:
            yield Problem(
                path=path,
                message=f"{key} is given and looked for",
                allowed=f"no {key}, or find without it",
                also=(*DESIGN, "find") if "find" in design.model_fields_set else None,
            )
        elif not sought and given is None and replaced is None and design.on in stations:
            yield Problem(
                path=DESIGN,
                message=f"the new damper has no {key}, and it is not looked for",
                allowed=f"{key} here, or in find",
            )
        if bound is not None and not sought:
            yield Problem(
                path=(*DESIGN, "bounds", key),
                message=f"{key} is not looked for, and bounds hold nothing",
                allowed=f"{key} in find, or no such bounds",
            )
    known = section_names(line)
    for place, name in enumerate(design.sections):
        if name not in known:
            yield unknown((*DESIGN, "sections", place), "shaft", name, known)
    shafts = zip(known, line.shafts, strict=True)
    if design.objective == "stress" and not any(
        has_stress(shaft)
        for name, shaft in shafts
        if not design.sections or name in design.sections
    ):
        yield Problem(
            path=(*DESIGN, "objective"),
            message="no shaft that counts has a section modulus for a stress",
            allowed="diameter, section_modulus or section on the shafts, or objective = 'torque'",
        )


# ----------------------------------------------------------------------------
# What is asked of a shaft line and is possible, but may not be what it looks like.
# ----------------------------------------------------------------------------

#: names in one sentence
MOST = 6


def torsion_cautions(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    line, response = case.machine.shaft_line, case.response
    if line is None or response is None or response.torsion is None:
        return []
    torsion, texts = response.torsion, []
    if len(torsion.misfire) == len(case.machine.crank_train.cylinders):
        texts.append(
            "no cylinder fires: all of them are in misfire, and the engine is turned from outside"
        )
    for number, limit in enumerate(torsion.limits, start=1):
        if limit.rule is None:
            continue
        beyond = _beyond(line, limit)
        if beyond:
            more = f" and {len(beyond) - MOST} more" if len(beyond) > MOST else ""
            texts.append(
                f"limit {number} of the stress is IACS UR M68, for intermediate, thrust and "
                "propeller shafts; it is held against what does not look like one: "
                + "; ".join(beyond[:MOST])
                + more
            )
    return texts


def _beyond(line: ShaftLine, limit: TorsionLimit) -> list[str]:
    """Shafts of a limit that M68 is not for, with the reason."""
    names = section_names(line)
    asked = limit.sections or [
        name for name, shaft in zip(names, line.shafts, strict=True) if has_stress(shaft)
    ]
    stations = [station.name for station in line.stations]
    at = {name: place for place, name in enumerate(stations)}
    joined, ends = joints(line), shaft_ends(line)
    fires = [bool(station.cylinder or station.cylinders) for station in line.stations]
    load = at[line.load] if line.load is not None else len(stations) - 1
    speed = speed_ratios(len(stations), joined, crank_station(line)).ratio
    unreached = []
    for name in asked:
        place = names.index(name)
        first, second = (at[end] for end in ends[place])
        others = [one for number, one in enumerate(joined) if number != place]
        if line.shafts[place].throw is not None or (fires[first] and fires[second]):
            unreached.append(f"'{name}' (of the crankshaft)")
        elif _reaches(others, [n for n, one in enumerate(fires) if one], load):
            unreached.append(f"'{name}' (not between the engine and '{stations[load]}')")
        elif abs(abs(speed[first] / speed[load]) - 1.0) > 1e-6:
            unreached.append(f"'{name}' (before a gear)")
    return unreached


def _reaches(joined: list[StationJoint], start: list[int], goal: int) -> bool:
    """Whether joints lead from one of some stations to another."""
    visited, due = set(start), list(start)
    while due:
        here = due.pop()
        for one in joined:
            if here in (one.first, one.second):
                there = one.second if here == one.first else one.first
                if there not in visited:
                    visited.add(there)
                    due.append(there)
    return goal in visited
