"""Can what is asked of a shaft line be answered: curves, conditions, limits, changes in time?"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.case.raw import listed, strangers, unknown
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.asked import excited_orders, least_steps, orders_words, turned_angles
from vibecalc.torsion.line_checks import LINE
from vibecalc.torsion.question_tables import (
    OF_SECTIONS,
    OF_STATIONS,
    READINGS,
    LineCurve,
    TorsionLimit,
    curves_of,
)
from vibecalc.torsion.shaft_line_tables import Layout, Shaft, ShaftLine, stressed
from vibecalc.torsion.stage import names_of
from vibecalc.torsion.tables import LineSpeeds, Torsion

if TYPE_CHECKING:
    from vibecalc.torsion.question_tables import Transient

TORSION: KeyPath = ("response", "torsion")
#: of an end of the speeds, how far beyond it a measured one still counts as at it
_AT_END = 1e-9


def curve_problems(case: Case, torsion: Torsion) -> Iterator[Problem]:
    """Problems of curves, measured points and conditions against the machine."""
    for place, curve in enumerate(torsion.curves):
        path: KeyPath = (*TORSION, "curves", place)
        yield from _names(path, case, curve)
        yield from _orders((*path, "orders"), case, curve.orders)
        if curve.measured is not None and torsion.speeds is not None:
            yield from _measured((*path, "measured"), case, curve, torsion.speeds)
    yield from _conditions(case, torsion)


def _names(path: KeyPath, case: Case, curve: LineCurve) -> Iterator[Problem]:
    """Is there such a shaft or station, and does it have what is asked of it?"""
    known, line = names_of(case), case.machine.shaft_line
    assert line is not None
    every = list(dict.fromkeys([*known["section"], *known["station"]]))
    if curve.on not in every:
        yield unknown((*path, "on"), "shaft or station", curve.on, every)
        return
    columns = {name for name in READINGS if getattr(curve.measured, name, ())}
    of_it = [name for kind, names in (("section", OF_SECTIONS), ("station", OF_STATIONS))
             if curve.on in known[kind] for name in names]  # fmt: skip
    what = "a station" if curve.on in known["station"] else "a shaft"
    for place, name in enumerate(curve.of):
        if name not in of_it:
            yield Problem(
                path=(*path, "quantities", place),
                message=f"{curve.on[:60]!r} is {what}, which has no {name}",
                found=repr(name),
                allowed=listed(of_it),
            )
        elif name == "stress" and curve.on not in stressed(line, Layout(line)):
            yield Problem(
                path=(*path, "quantities", place),
                message=f"section {curve.on[:60]!r} has no section modulus for a stress",
                found="'stress'",
                allowed="diameter, section_modulus or section on this shaft",
                hint="torque and twist need none",
            )
    drawn = list(curves_of(line, [curve]))
    for column in sorted(columns.difference(drawn)):
        yield Problem(
            path=(*path, "measured", column),
            message=f"{column} was measured, and there is no curve of it",
            found=f"curves of {listed(drawn)}",
            allowed=f"quantities = ['{column}', ...] with it",
            also=(*path, "quantities"),
        )


def _orders(
    path: KeyPath, case: Case, orders: Sequence[float], or_all: str = ""
) -> Iterator[Problem]:
    """Is each of some orders excited? With `or_all` 0 stands for all of them."""
    excited = excited_orders(case)
    for place, order in enumerate(orders):
        # an order behind a gear is typed with the digits that a report shows
        if min(abs(order - one) / one for one in excited) > 1e-3 and (order or not or_all):
            yield Problem(
                path=(*path, place),
                message=f"the case has no order {order:g}",
                found=f"{order:g}",
                allowed=orders_words(case) + or_all,
                hint="orders of [response.torsion] says their step and the highest",
            )


def _measured(path: KeyPath, case: Case, curve: LineCurve, speeds: LineSpeeds) -> Iterator[Problem]:
    """Does each measured point stand on a curve?"""
    points = curve.measured
    assert points is not None
    low, high = speeds.start * (1.0 - _AT_END), speeds.stop * (1.0 + _AT_END)
    for place, speed in enumerate(points.speed):
        if not low <= speed <= high:
            yield Problem(
                path=(*path, "speed", place),
                message="this point was measured outside of the range of speeds",
                found=f"{speed:.6g} rad/s",
                allowed=f"{speeds.start:.6g} to {speeds.stop:.6g} rad/s",
                hint="rad/s, or a text with its unit: '480 rpm'",
                also=(*TORSION, "speeds"),
            )
    yield from _orders((*path, "order"), case, points.order, "; 0 for all orders together")


def _conditions(case: Case, torsion: Torsion) -> Iterator[Problem]:
    """Are there cylinders enough for conditions that differ?"""
    options = torsion.conditions
    if options is None or not has_crank_train(case.machine):
        return
    cylinders = case.machine.crank_train.cylinders
    path: KeyPath = (*TORSION, "conditions")
    scales = options.pressure_scale
    if len(cylinders) < 2 and (options.misfire == "each" or options.imbalance is not None):
        yield Problem(
            path=path,
            message="conditions in which one cylinder differs from the others need two or more",
            found=f"{len(cylinders)} cylinder{'s' * (len(cylinders) != 1)}",
            allowed="no [response.torsion.conditions]; or misfire = 'none' and a pressure_scale",
            also=("machine", "crank_train", "cylinders"),
        )
    if scales and len(scales) != len(cylinders):
        yield Problem(
            path=(*path, "pressure_scale"),
            message="pressure_scale has a factor for each cylinder",
            found=f"{len(scales)} factors",
            allowed=f"{len(cylinders)}, in the order of the cylinders",
            also=("machine", "crank_train", "cylinders"),
        )
    elif scales and all(one == 1.0 for one in scales):
        yield Problem(
            path=(*path, "pressure_scale"),
            message="these factors are all 1",
            found="1 for each",
            allowed="a factor other than 1",
        )


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
                message="the line has no gear for alternating_share",
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
            message="no shaft has a throw with fillets for the rule for crankshafts"
            if of_cranks
            else "no shaft has a section modulus for a stress limit",
            allowed="sections and crank here, or pin_fillet and journal_fillet on throws"
            if of_cranks
            else "diameter, section_modulus or section on the shafts to be limited",
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
    from vibecalc.torsion import stress_limits as rule

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
                found=f"{stress / 1e6:.4g} N/mm^2 with its stress concentration",
                allowed=f"< {allowed / 1e6:.4g} N/mm^2, the fatigue strength over 1.15",
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
                f"stress limit {number} is IACS {words}shafts, but is applied to other "
                "shafts: " + "; ".join(beyond[:MOST]) + more
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
    driven = (
        layout.at[one.on] for one in line.absorbed_torques if one.propeller_damping is not None
    )
    load, speed = next(driven, layout.load), layout.ratio
    for name in names:
        place = layout.sections.index(name)
        first, second, _ = layout.joints[place]
        part = layout.parts_without(place)
        reached = {number for number, fires in zip(part, layout.fires, strict=True) if fires}
        if line.shafts[place].throw is not None or (layout.fires[first] and layout.fires[second]):
            yield f"'{name}' (crankshaft)"
        elif part[load] in reached:
            yield f"'{name}' (not between the engine and '{layout.names[load]}')"
        elif abs(abs(speed[first] / speed[load]) - 1.0) > 1e-6:
            yield f"'{name}' (before a gear)"


# ----------------------------------------------------------------------------
# A change in time against the shaft line that it happens to.
# ----------------------------------------------------------------------------

TRANSIENT_TABLE: KeyPath = ("response", "torsion", "transient")


def change_problems(line: ShaftLine, layout: Layout, torsion: Torsion) -> Iterator[Problem]:
    """Problems of [response.torsion.transient] against the line."""
    change = torsion.transient
    if change is None:
        return
    if change.cylinder is not None and change.cylinder in torsion.misfire:
        yield Problem(
            path=(*TRANSIENT_TABLE, "cylinder"),
            message=f"cylinder {change.cylinder[:60]!r} misfires from the start",
            allowed="a cylinder that is not in misfire",
            also=("response", "torsion", "misfire"),
        )
    if change.clutch is not None:
        yield from _clutch(line, layout, change.clutch)
    yield from _form(line, torsion, change)
    yield from _massless(line, layout)
    yield from _counting(line, layout, change)


def _form(line: ShaftLine, torsion: Torsion, change: "Transient") -> Iterator[Problem]:
    """What does not damp, or turn, in time as it does at a steady speed."""
    from vibecalc.torsion.question_tables import AT_CONSTANT_SPEED

    if torsion.damping_model is not None and torsion.damping_model.kind == "modal":
        yield Problem(
            path=("response", "torsion", "damping_model", "kind"),
            message="damping ratios by mode have no dashpots for the time domain",
            allowed="kind = 'rayleigh', or no damping_model and dampings of shafts, stations or "
            "dampers",
            also=TRANSIENT_TABLE,
        )
    hung = [n for n, one in enumerate(line.dampers) if one.kind == "pendulum"]
    if hung and change.kind not in AT_CONSTANT_SPEED:
        yield Problem(
            path=(*LINE, "dampers", hung[0]),
            message="pendulums cannot be part of a transient with changing speed",
            allowed=f"a change at constant speed: {', '.join(AT_CONSTANT_SPEED)}",
            also=(*TRANSIENT_TABLE, "kind"),
        )


def friction_problems(case: Case, line: ShaftLine, torsion: Torsion) -> Iterator[Problem]:
    """A ring on dry friction: one of a line, on linings, at an order that there is."""
    rubbed = [(n, one) for n, one in enumerate(line.dampers) if one.kind == "friction"]
    if not rubbed:
        return
    (place, damper), *others = rubbed
    path: KeyPath = (*LINE, "dampers", place)
    if others:
        yield Problem(
            path=(*LINE, "dampers", others[0][0], "kind"),
            message="a shaft line has one damper with dry friction at most",
            allowed="a damper of another kind",
            also=(*path, "kind"),
        )
    if damper.stiffness == 0.0:
        yield Problem(
            path=(*path, "stiffness"),
            message="a ring on dry friction needs the stiffness of its linings",
            found="0",
            allowed="> 0; stiff linings leave the ring all but fixed while it does not slip",
        )
    orders = np.array(excited_orders(case))
    if not np.any(np.abs(orders - (damper.order or 0.0)) <= 1e-9 * orders):
        yield Problem(
            path=(*path, "order"),
            message="the order of a friction damper is none that excites the line",
            found=f"{damper.order:g}",
            allowed=f"one of the orders {orders_words(case)}",
        )
    if torsion.damping_model is not None or torsion.method == "modal":
        key = "damping_model" if torsion.damping_model is not None else "method"
        yield Problem(
            path=("response", "torsion", key),
            message="dry friction has no damping ratio of a mode",
            allowed="method = 'direct', dampings of shafts, stations or dampers",
            also=(*path, "kind"),
        )
    if torsion.transient is not None and torsion.transient.clutch is not None:
        yield Problem(
            path=(*TRANSIENT_TABLE, "kind"),
            message="a transient has a clutch or a damper with dry friction, not both",
            allowed="another change, or a damper of another kind",
            also=(*path, "kind"),
        )


def _massless(line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Stations without inertia, but those that rigid gears join to an inertia."""
    named = [*zip(layout.freedom, line.stations, strict=True)]
    heavy = {freedom for freedom, one in named if one.inertia != 0.0}
    for n, (freedom, one) in enumerate(named):
        if freedom not in heavy:
            yield Problem(
                path=(*LINE, "stations", n, "inertia"),
                message=f"station {one.name[:60]!r} has no inertia: a transient needs one at "
                "every station",
                found="0",
                allowed="an inertia above 0, or its two shafts as one of their common stiffness",
                also=TRANSIENT_TABLE,
            )


def _clutch(line: ShaftLine, layout: Layout, name: str) -> Iterator[Problem]:
    """A clutch parts the line in two, one of them with all cylinders, and nothing holds either."""
    path = (*TRANSIENT_TABLE, "clutch")
    if name not in layout.sections:
        yield unknown(path, "shaft", name, layout.sections)
        return
    place = layout.sections.index(name)
    part, joint = layout.parts_without(place), layout.joints[place]
    if part[joint.first] == part[joint.second]:
        yield Problem(
            path=path,
            message=f"stations {layout.names[joint.first][:60]!r} and "
            f"{layout.names[joint.second][:60]!r} are also joined by another path and cannot turn "
            "at two speeds",
            found=repr(name[:60]),
            allowed="a shaft that is the only way between the two parts of the line",
            also=(*LINE, "shafts", place),
        )
        return
    if len({number for number, fires in zip(part, layout.fires, strict=True) if fires}) > 1:
        yield Problem(
            path=path,
            message="there are cylinders on both sides of the clutch",
            found=repr(name[:60]),
            allowed="a clutch with all cylinders on one side of it",
            also=(*LINE, "shafts", place),
        )
    held = [n for n, one in enumerate(line.stations) if one.ground_stiffness]
    if held:
        yield Problem(
            path=path,
            message="a station with a stiffness to ground cannot change its speed",
            allowed="no ground_stiffness, or another change",
            also=(*LINE, "stations", held[0], "ground_stiffness"),
        )


def _counting(line: ShaftLine, layout: Layout, change: "Transient") -> Iterator[Problem]:
    counting = change.counting
    if counting is None:
        return
    others = [gear.label for gear in line.gears if gear.mesh_stiffness]
    known = [*layout.sections, *others, *(damper.name for damper in line.dampers)]
    path = (*TRANSIENT_TABLE, "counting")
    yield from strangers((*path, "sections"), "section", counting.sections, known)
    for place, (shaft, name) in enumerate(zip(line.shafts, layout.sections, strict=True)):
        asked = not counting.sections or name in counting.sections
        by_stress = shaft.fatigue is not None and shaft.fatigue.stress is not None
        if asked and by_stress and not shaft.has_stress:
            yield Problem(
                path=(*LINE, "shafts", place, "fatigue"),
                message=f"shaft {name[:60]!r} has no section modulus for a stress",
                allowed="diameter, section_modulus or section on this shaft, or fatigue with a "
                "torque",
                also=path,
            )


# ----------------------------------------------------------------------------
# Does a change in time end within the steps that a run may take?
# ----------------------------------------------------------------------------


def steps_problems(case: Case, change: "Transient") -> Iterator[Problem]:
    """The problem of a change that takes longer than the march in time goes."""
    from vibecalc.torsion.transient.march import MOST_STEPS

    steps = least_steps(case)
    if steps <= MOST_STEPS:
        return
    spans = turned_angles(case, change)
    key = max(spans, key=lambda key: spans[key])
    if key == "change":
        key = "duration" if change.acceleration is None else "acceleration"
    yield Problem(
        path=(*TRANSIENT_TABLE, key) if key in change.model_fields_set else TRANSIENT_TABLE,
        message="the change takes too many steps in time",
        found=f"{steps:.3g} steps or more, for {sum(spans.values()) / 6.283185307:.3g} revolutions "
        "of the crank",
        allowed=f"{MOST_STEPS:.3g} steps",
        hint="a faster change, less time before and after it, or fewer orders",
    )
