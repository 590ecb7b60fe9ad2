"""Can the limits of a shaft line be held, and are they for what they are held against?"""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.core.case.raw import unknown
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.limit_tables import Crank, TorsionLimit
from vibecalc.torsion.shaft_line_tables import (
    Shaft,
    ShaftLine,
    StationJoint,
    Throw,
    crank_station,
    has_stress,
    joints,
    section_names,
    shaft_ends,
    speed_ratios,
)

# ----------------------------------------------------------------------------
# Can a limit of stress or torque be held: names, diameters, strengths, proportions of a throw?
# ----------------------------------------------------------------------------

LIMITS: KeyPath = ("response", "torsion", "limits")
SHAFTS: KeyPath = ("machine", "shaft_line", "shafts")
_FILLETS = ("pin_fillet", "journal_fillet")


def limit_problems(
    case: Case, line: ShaftLine, limits: Sequence[TorsionLimit]
) -> Iterator[Problem]:
    """Problems of the limits of [response.torsion] against the machine."""
    for place, limit in enumerate(limits):
        path = (*LIMITS, place)
        yield from _names(path, line, limit)
        if limit.rule == "iacs_m53" and not has_crank_train(case.machine):
            yield Problem(
                path=(*path, "rule"),
                message="UR M53 is for crankshafts, and a drive train has none",
                allowed="'iacs_m68' for propulsion shafts, or a curve",
                also=("machine", "kind"),
            )
        elif limit.rule == "iacs_m53":
            yield from _crank(path, case, line, limit)
        elif limit.rule is not None or limit.curve is not None:
            yield from _stress(path, line, limit)


def _names(path: KeyPath, line: ShaftLine, limit: TorsionLimit) -> Iterator[Problem]:
    """Sections and gears are there."""
    gears = [one.name or " - ".join(one.between) for one in line.gears]
    for key, what, known in (
        ("sections", "shaft", section_names(line)),
        ("gears", "gear", gears),
    ):
        for place, name in enumerate(getattr(limit, key)):
            if name not in known:
                yield unknown((*path, key, place), what, name, known)
    if limit.alternating_share is not None and not line.gears:
        yield Problem(
            path=(*path, "alternating_share"),
            message="the line has no gear whose alternating torque could be a share of its mean",
            allowed="machine.shaft_line.gears, or a limit of another kind",
        )


def _stress(path: KeyPath, line: ShaftLine, limit: TorsionLimit) -> Iterator[Problem]:
    """Stresses of the shafts can be told, and what the rule for propulsion shafts wants."""
    known = section_names(line)
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
                also=(*SHAFTS, place),
            )
        elif (
            limit.rule is not None and limit.tensile_strength is None and not shaft.tensile_strength
        ):
            yield Problem(
                path=path,
                message=f"the rule needs the tensile strength of shaft {name[:60]!r}",
                allowed="tensile_strength here, or on the shaft",
                also=(*SHAFTS, place),
            )
        elif limit.rule is not None and shaft.section_modulus is not None:
            yield Problem(
                path=path,
                message=f"the rule needs the diameter of shaft {name[:60]!r}",
                allowed="diameter or section instead of section_modulus",
                also=(*SHAFTS, place, "section_modulus"),
            )


# ----------------------------------------------------------------------------
# Can the rule for crankshafts be held?
# ----------------------------------------------------------------------------


def _crank(path: KeyPath, case: Case, line: ShaftLine, limit: TorsionLimit) -> Iterator[Problem]:
    known = section_names(line)
    asked = [name for name in limit.sections if name in known]
    if not limit.sections:
        asked = [
            name
            for name, shaft in zip(known, line.shafts, strict=True)
            if shaft.throw is not None and shaft.throw.pin_fillet is not None
        ]
        if not asked:
            yield Problem(
                path=path,
                message="no shaft has a throw with fillets, and the rule for crankshafts holds "
                "nothing",
                allowed="sections and crank here, or pin_fillet and journal_fillet on throws",
            )
    for name in asked:
        yield from _throw(path, case, limit, known.index(name), line.shafts[known.index(name)])


def _throw(
    path: KeyPath, case: Case, limit: TorsionLimit, place: int, shaft: Shaft
) -> Iterator[Problem]:
    """One throw: everything there, its proportions those of the formulas, torsion left."""
    words = f"shaft {(shaft.name or str(place + 1))[:60]!r}"
    there: KeyPath = (*SHAFTS, place)
    if limit.tensile_strength is None and not shaft.tensile_strength:
        yield Problem(
            path=path,
            message=f"the rule needs the tensile strength of {words}",
            allowed="tensile_strength here, or on the shaft",
            also=there,
        )
    given = limit.crank or shaft.throw
    if given is None:
        yield Problem(
            path=path,
            message=f"the rule needs the dimensions of the throw of {words}",
            allowed="crank here, or throw on the shaft, with fillets",
            also=there,
        )
        return
    where = (*path, "crank") if limit.crank is not None else (*there, "throw")
    if isinstance(given, Throw) and given.pin_fillet is None:
        yield Problem(
            path=where,
            message=f"the rule needs the fillet radii of {words}",
            allowed=" and ".join(_FILLETS),
            also=path,
        )
        return
    if given.oil_bore is not None and limit.bending is not None and limit.bending.oil_bore is None:
        yield Problem(
            path=(*path, "bending"),
            message="the pin has an oil bore, and no bending stress is given there",
            allowed="oil_bore = '20 MPa', for example, in bending",
            also=(*where, "oil_bore"),
        )
    found = list(_proportions(where, case, given))
    yield from found
    strength = shaft.tensile_strength or limit.tensile_strength
    if strength and not found:
        yield from _left(path, case, limit, given, strength, words)


def _proportions(where: KeyPath, case: Case, given: Crank | Throw) -> Iterator[Problem]:
    from vibecalc.torsion.crank_model import crank_throws
    from vibecalc.torsion.crank_strength import RANGES, proportions

    one = proportions(crank_throws([given], case.machine.crank_train.crank_radius))
    for key, (name, low, high) in RANGES.items():
        ratio = float(getattr(one, key)[0])
        if not low - 1e-12 <= ratio <= high + 1e-12:
            yield Problem(
                path=where,
                message=f"the {name} is outside of what the rule for crankshafts has formulas for",
                found=f"{ratio:.4g} of the pin diameter",
                allowed=f"{low:g} to {high:g} of it",
            )


def _left(
    path: KeyPath,
    case: Case,
    limit: TorsionLimit,
    given: Crank | Throw,
    strength: float,
    words: str,
) -> Iterator[Problem]:
    """Bending alone does not use up what the rule allows."""
    from vibecalc.torsion.crank_model import crank_throws, nominal_bending
    from vibecalc.torsion.crank_strength import (
        ACCEPTABILITY,
        CRANKSHAFT_KINDS,
        PLACES,
        bending_stresses,
        fatigue_strength,
        stress_concentration,
    )

    throw = crank_throws([given], case.machine.crank_train.crank_radius)
    factor = CRANKSHAFT_KINDS[limit.crankshaft_kind or "free_form"]
    bending = bending_stresses(stress_concentration(throw), nominal_bending(limit))[0]
    most = fatigue_strength(throw, np.array([strength]), factor)[0] / ACCEPTABILITY
    for name, stress, allowed in zip(PLACES, bending, most, strict=True):
        if stress >= allowed and (name != PLACES[2] or given.oil_bore):
            yield Problem(
                path=(*path, "bending"),
                message=f"bending alone uses up what the rule allows {words} at the {name}",
                found=f"{stress / 1e6:.4g} N/mm2 with its stress concentration",
                allowed=f"< {allowed / 1e6:.4g} N/mm2, the fatigue strength over 1.15",
            )


# ----------------------------------------------------------------------------
# Is a limit for what it is held against?
# ----------------------------------------------------------------------------

#: names in one sentence
MOST = 6


def limit_cautions(line: ShaftLine, limits: Sequence[TorsionLimit]) -> list[str]:
    """Sentences for the report."""
    texts = []
    for number, limit in enumerate(limits, start=1):
        if limit.rule == "iacs_m68":
            beyond, words = _beyond(line, limit), "UR M68, for intermediate, thrust and propeller "
        elif limit.rule == "iacs_m53":
            beyond, words = _no_crank(line, limit), "UR M53, for crank"
        else:
            continue
        if beyond:
            more = f" and {len(beyond) - MOST} more" if len(beyond) > MOST else ""
            texts.append(
                f"limit {number} of the stress is IACS {words}shafts; it is held against what does "
                "not look like one: " + "; ".join(beyond[:MOST]) + more
            )
    return texts


def _no_crank(line: ShaftLine, limit: TorsionLimit) -> list[str]:
    """Shafts of a limit that have no throw and no station with a cylinder at either end."""
    names, ends = section_names(line), shaft_ends(line)
    fires = {one.name for one in line.stations if one.cylinder or one.cylinders}
    return [
        f"'{name}' (no cylinder at its ends)"
        for name in limit.sections
        if line.shafts[names.index(name)].throw is None
        and fires.isdisjoint(ends[names.index(name)])
    ]


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
    load = next((at[one.on] for one in line.loads if one.propeller_damping is not None), load)
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
