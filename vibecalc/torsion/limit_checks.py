"""Can the limits of a shaft line be held, and are they for what they are held against?"""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.core.case.raw import strangers
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.limit_tables import TorsionLimit
from vibecalc.torsion.shaft_line_tables import Layout, Shaft, ShaftLine, stressed

# ----------------------------------------------------------------------------
# Can a limit of stress or torque be held: names, diameters, strengths, proportions of a throw?
# ----------------------------------------------------------------------------

LIMITS: KeyPath = ("response", "torsion", "limits")
SHAFTS: KeyPath = ("machine", "shaft_line", "shafts")


def limit_problems(
    case: Case, line: ShaftLine, layout: Layout, limits: Sequence[TorsionLimit]
) -> Iterator[Problem]:
    """Problems of the limits of [response.torsion] against the machine."""
    for place, limit in enumerate(limits):
        path: KeyPath = (*LIMITS, place)
        gears = [gear.label for gear in line.gears]
        yield from strangers((*path, "sections"), "shaft", limit.sections, layout.sections)
        yield from strangers((*path, "gears"), "gear", limit.gears, gears)
        if limit.alternating_share is not None and not gears:
            yield Problem(
                path=(*path, "alternating_share"),
                message="the line has no gear whose alternating torque could be a share of its "
                "mean",
                allowed="machine.shaft_line.gears, or a limit of another kind",
            )
        if limit.rule == "iacs_m53" and not has_crank_train(case.machine):
            yield Problem(
                path=(*path, "rule"),
                message="UR M53 is for crankshafts, and a drive train has none",
                allowed="'iacs_m68' for propulsion shafts, or a curve",
                also=("machine", "kind"),
            )
        elif limit.rule is not None or limit.curve is not None:
            yield from _shafts(
                path, case, limit, dict(zip(layout.sections, line.shafts, strict=True))
            )


def _shafts(
    path: KeyPath, case: Case, limit: TorsionLimit, shafts: dict[str, Shaft]
) -> Iterator[Problem]:
    """What a limit of the stress, or the rule for crankshafts, wants of the shafts it is for."""
    of_cranks = limit.rule == "iacs_m53"
    usable = [
        name
        for name, one in shafts.items()
        if (one.throw is not None and one.throw.pin_fillet if of_cranks else one.has_stress)
    ]
    if not limit.sections and not usable:
        yield Problem(
            path=path,
            message="no shaft has a throw with fillets, and the rule for crankshafts holds nothing"
            if of_cranks
            else "no shaft has a section modulus, and a limit of the stress holds nothing",
            allowed="sections and crank here, or pin_fillet and journal_fillet on throws"
            if of_cranks
            else "diameter, section_modulus or section on the shafts that it is for",
        )
    for place, (name, shaft) in enumerate(shafts.items()):
        if name in (limit.sections or usable):
            there: KeyPath = (*SHAFTS, place)
            check = _throw if of_cranks else _stress
            yield from check(path, case, limit, there, shaft, f"shaft {name[:60]!r}")


def _stress(
    path: KeyPath, case: Case, limit: TorsionLimit, there: KeyPath, shaft: Shaft, words: str
) -> Iterator[Problem]:
    """The stress of a shaft can be told, and what the rule for propulsion shafts wants."""
    if not shaft.has_stress:
        yield Problem(
            path=path,
            message=f"{words} has no section modulus for a stress",
            allowed="diameter, section_modulus or section on this shaft",
            also=there,
        )
    elif limit.rule is not None and not (limit.tensile_strength or shaft.tensile_strength):
        yield _no_strength(path, there, words)
    elif limit.rule is not None and shaft.section_modulus is not None:
        yield Problem(
            path=path,
            message=f"the rule needs the diameter of {words}",
            allowed="diameter or section instead of section_modulus",
            also=(*there, "section_modulus"),
        )


def _no_strength(path: KeyPath, there: KeyPath, words: str) -> Problem:
    return Problem(
        path=path,
        message=f"the rule needs the tensile strength of {words}",
        allowed="tensile_strength here, or on the shaft",
        also=there,
    )


# ----------------------------------------------------------------------------
# Can the rule for crankshafts be held?
# ----------------------------------------------------------------------------


def _throw(
    path: KeyPath, case: Case, limit: TorsionLimit, there: KeyPath, shaft: Shaft, words: str
) -> Iterator[Problem]:
    """One throw: everything there, its proportions those of the formulas, torsion left."""
    from vibecalc.torsion import crank_strength as rule

    strength = shaft.tensile_strength or limit.tensile_strength
    if not strength:
        yield _no_strength(path, there, words)
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
    if given.pin_fillet is None:
        yield Problem(
            path=where,
            message=f"the rule needs the fillet radii of {words}",
            allowed="pin_fillet and journal_fillet",
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
    throw, fits = rule.crank_throws([given], case.machine.crank_train.crank_radius), True
    proportions = rule.proportions(throw)
    for key, (name, low, high) in rule.RANGES.items():
        ratio = float(getattr(proportions, key)[0])
        if not low - 1e-12 <= ratio <= high + 1e-12:
            fits = False
            yield Problem(
                path=where,
                message=f"the {name} is outside of what the rule for crankshafts has formulas for",
                found=f"{ratio:.4g} of the pin diameter",
                allowed=f"{low:g} to {high:g} of it",
            )
    if not strength or not fits or limit.bending is None:
        return
    factor = rule.CRANKSHAFT_KINDS[limit.crankshaft_kind or "free_form"]
    concentration = rule.stress_concentration(throw)
    bending = rule.bending_stresses(concentration, limit.bending)[0]
    most = rule.fatigue_strength(throw, np.array([strength]), factor)[0] / rule.ACCEPTABILITY
    for name, stress, allowed in zip(rule.PLACES, bending, most, strict=True):
        if stress >= allowed and (name != rule.PLACES[2] or given.oil_bore):
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


def limit_cautions(line: ShaftLine, layout: Layout, limits: Sequence[TorsionLimit]) -> list[str]:
    """Sentences for the report."""
    texts = []
    for number, limit in enumerate(limits, start=1):
        if limit.rule == "iacs_m68":
            beyond = list(_beyond(line, layout, limit.sections or stressed(line, layout)))
            words = "UR M68, for intermediate, thrust and propeller "
        else:
            beyond, words = list(_no_crank(line, layout, limit)), "UR M53, for crank"
        if limit.rule is not None and beyond:
            more = f" and {len(beyond) - MOST} more" if len(beyond) > MOST else ""
            texts.append(
                f"limit {number} of the stress is IACS {words}shafts; it is held against what does "
                "not look like one: " + "; ".join(beyond[:MOST]) + more
            )
    return texts


def _no_crank(line: ShaftLine, layout: Layout, limit: TorsionLimit) -> Iterator[str]:
    """Shafts of a limit that have no throw and no station with a cylinder at either end."""
    for name in limit.sections:
        place = layout.sections.index(name)
        ends = [layout.fires[layout.at[end]] for end in layout.ends[place]]
        if line.shafts[place].throw is None and not any(ends):
            yield f"'{name}' (no cylinder at its ends)"


def _beyond(line: ShaftLine, layout: Layout, names: Sequence[str]) -> Iterator[str]:
    """Shafts that M68 is not for, with the reason."""
    driven = (layout.at[one.on] for one in line.loads if one.propeller_damping is not None)
    load, speed = next(driven, layout.load), layout.ratio
    for name in names:
        place = layout.sections.index(name)
        first, second, _ = layout.joints[place]
        part = layout.parts_without(place)
        reached = {number for number, fires in zip(part, layout.fires, strict=True) if fires}
        if line.shafts[place].throw is not None or (layout.fires[first] and layout.fires[second]):
            yield f"'{name}' (of the crankshaft)"
        elif part[load] in reached:
            yield f"'{name}' (not between the engine and '{layout.names[load]}')"
        elif abs(abs(speed[first] / speed[load]) - 1.0) > 1e-6:
            yield f"'{name}' (before a gear)"
