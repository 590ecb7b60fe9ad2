"""What is asked of a shaft line and is possible, but may not be what it looks like."""

from vibecalc.case.schema import Case
from vibecalc.case.shaft_parts import ShaftLine
from vibecalc.case.torsion_tables import TorsionLimit
from vibecalc.machine.shaft_line_graph import (
    Joined,
    crank_station,
    joints,
    shaft_ends,
    speed_ratios,
)
from vibecalc.machine.shaft_sections import has_stress, section_names

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
    found = []
    for name in asked:
        place = names.index(name)
        first, second = (at[end] for end in ends[place])
        others = [one for number, one in enumerate(joined) if number != place]
        if line.shafts[place].throw is not None or (fires[first] and fires[second]):
            found.append(f"'{name}' (of the crankshaft)")
        elif _reaches(others, [n for n, one in enumerate(fires) if one], load):
            found.append(f"'{name}' (not between the engine and '{stations[load]}')")
        elif abs(abs(speed[first] / speed[load]) - 1.0) > 1e-6:
            found.append(f"'{name}' (before a gear)")
    return found


def _reaches(joined: list[Joined], start: list[int], goal: int) -> bool:
    """Whether joints lead from one of some stations to another."""
    seen, due = set(start), list(start)
    while due:
        here = due.pop()
        for one in joined:
            if here in (one.first, one.second):
                there = one.second if here == one.first else one.first
                if there not in seen:
                    seen.add(there)
                    due.append(there)
    return goal in seen
