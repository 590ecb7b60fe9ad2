"""The stages that a case asks for its shaft line, and the steps that a change in time takes."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from vibecalc.core.run.stage import (
    Entries,
    Harmonics,
    Stage,
    Subject,
    Unit,
    Work,
    below,
    harmonics_of,
)
from vibecalc.kinds import has_crank_train
from vibecalc.schema import Case
from vibecalc.torsion.asked import (
    asked,
    asked_orders,
    condition_names,
    coupling_limits,
    excited_orders,
    freedom_count,
    has_damped_rings,
    has_holzer,
    has_loops,
    has_loss,
    has_modal_damping,
    leading,
    least_steps,
    line_orders,
    modes_follow_speed,
    named_couplings,
    orders_words,
    parts_of,
    shaft_line_of,
    solves,
    torsion_of,
)
from vibecalc.torsion.results import ROOT, of_line, over_range
from vibecalc.torsion.study_results import (
    DESIGN,
    OBJECTIVES,
    OF_PASSAGES,
    OF_STEPS,
    PASSAGES,
    PUBLISHED,
    TRANSIENT,
    VARIABLE,
)

if TYPE_CHECKING:
    from vibecalc.torsion.tables import LineSpeeds, Torsion
    from vibecalc.torsion.transient_tables import Transient

# ----------------------------------------------------------------------------
# The stages that [response.torsion] asks for: the shaft line at one speed and over a range.
# ----------------------------------------------------------------------------

#: what only a line with cylinders has
_OF_CYLINDERS = (
    *("/excitation/pressure", "/excitation/gas", "/excitation/inertia", "/excitation/total"),
    *("/excitation/engine_torque", "/excitation/power", "/excitation/mean_torque"),
    *("/excitation/firing_angle", "/excitation/vector_sum", "/excitation/rank"),
    *("/excitation/major", "/speeds/mean_torque", "/power_balance/source"),
)


def _stage(case: "Case", name: str, adapter: str, topics: str = "", **more: Any) -> Stage:
    """A stage whose excitation is that of the line; it is a last one if nothing else is said."""
    usual: dict[str, Any] = {
        "parts": parts_of(case),
        "orders": orders_words(case),
        "harmonics": _half_orders,
        "is_last": True,
        "topics": (f"vibecalc.torsion.accuracy:{topics}",) if topics else (),
    }
    return Stage(name=name, adapter=f"vibecalc.torsion.adapters.{adapter}", **(usual | more))


def plan_torsion(case: "Case") -> Iterator[Stage]:
    """Modes, excitation and vibration at the operating speed; curves where speeds are given."""
    torsion = asked(case)
    if torsion is None or case.machine.shaft_line is None:
        return
    line = case.machine.shaft_line
    stations = len(line.stations)
    yield _stage(
        case,
        "torsion",
        "steady:run_torsion",
        "torsion_topics",
        why="[response.torsion] is in the case",
        cost=f"modes of {stations} stations; {solves(case)} solves, one per order, at "
        f"{case.machine.speed:.6g} rad/s",
        quantities=_picked(case, ranged=False),
        is_last=False,
        work=_work_of_torsion,
        leading=leading(case),
    )
    if torsion.speeds is None:
        return
    speeds = torsion.speeds
    yield _stage(
        case,
        "torsion_speeds",
        "speeds:run_torsion_speeds",
        "torsion_speeds_topics",
        why="[response.torsion] speeds are in the case",
        cost=_range_cost(case, speeds),
        quantities=_picked(case, ranged=True),
        work=_work_of_speeds,
        leading=leading(case),
    )


def _picked(case: "Case", ranged: bool) -> tuple[str, ...]:
    """Paths that the case has something for, at the operating speed or over the range."""
    from vibecalc.torsion.shaft_line_tables import has_laws, what_follows

    line, torsion = shaft_line_of(case), torsion_of(case)
    train = case.machine.crank_train if has_crank_train(case.machine) else None
    bored, loads = train is not None and bool(train.bore), bool(line.loads)
    of_loads = loads and case.machine.kind == "engine"
    there = {
        **dict.fromkeys(("ring_shape", "/damper/", "/bare/", "/reduction"), bool(line.dampers)),
        **dict.fromkeys(("speeds/heat", "speeds/travel"), bool(line.dampers)),
        **dict.fromkeys(("largest/heat", "largest/travel"), bool(line.dampers)),
        **dict.fromkeys(("gear", "/hammering/"), bool(line.gears)),
        "/campbell/": torsion.campbell and modes_follow_speed(case),
        "transfer_matrix": not has_loops(case),
        "holzer": has_holzer(case),
        "undamped_frequency": has_damped_rings(case),
        "/sufficient": torsion.separation is not None,
        **dict.fromkeys(_OF_CYLINDERS, train is not None),
        "/power_balance/load": loads,
        "/power_balance/rest": train is not None or loads,
        **dict.fromkeys(("total_load_power", "load_share"), of_loads),
        "bank_factor": train is not None and len({c.bank_angle for c in train.cylinders}) > 1,
        "modal_heat": has_modal_damping(case),
        "stress": any(shaft.has_stress for shaft in line.shafts),
        "/excitation/pressure": train is not None and train.tangential_effort is None,
        **dict.fromkeys(("tangential_pressure", "mean_indicated_pressure"), bored),
        "/coupling/": bool(named_couplings(case)),
        **dict.fromkeys(
            ("/coupling/largest_use", "/coupling/use", "/coupling/speeds/use"),
            bool(coupling_limits(case)),
        ),
        "/healthy/": bool(torsion.misfire),
        **dict.fromkeys(("/barred/", "/exceeded/", "healthy/limit/"), bool(torsion.limits)),
        "/damping/": torsion.damping_model is None and has_laws(line),
        **dict.fromkeys(_not_allowed(torsion), False),
    }
    for name, does in what_follows(line).items():
        there[f"/speeds/{name}"] = torsion.damping_model is None and does
    held = f"{ROOT}/limit/"
    there_are = {*below(f"{ROOT}/", without=tuple(word for word, has in there.items() if not has))}
    return tuple(
        path
        for path in of_line(ranged)
        if (_of_limits(torsion, path) if path.startswith(held) else path in there_are)
    )


def _not_allowed(torsion: "Torsion") -> list[str]:
    """What limits of stress or of torque allow in conditions, of the kind that the case has not."""
    of_torque = [bool(one.torque or one.alternating_share) for one in torsion.limits]
    kinds = {"torque_": any(of_torque), "": not all(of_torque)}
    return [
        f"limit/{start}{kind}allowed"
        for kind, there in kinds.items()
        if not there
        for start in ("", "operating_")
    ]


def _of_limits(torsion: "Torsion", path: str) -> bool:
    """Whether the case has a limit that gives a result."""
    folder, last = path.split("/")[-2:]
    limits = list(torsion.limits)
    if folder == "crank":
        limits = [one for one in limits if one.rule == "iacs_m53"]
    elif last.startswith("torque"):
        limits = [one for one in limits if one.torque or one.alternating_share]
    elif last == "gear":
        limits = [one for one in limits if one.gears or one.alternating_share]
    elif last in ("stress", "allowed", "transient") or folder == "basis":
        limits = [one for one in limits if one.rule or one.curve]
    return bool(limits)


def _range_cost(case: "Case", speeds: "LineSpeeds") -> str:
    """Solves over the range in words; maxima between the points take some more."""
    line, torsion = shaft_line_of(case), torsion_of(case)
    number = solves(case, speeds.points)
    twice = f", and {number} without dampers" if line.dampers else ""
    twice += f", and {number} without misfire" if torsion.misfire else ""
    return (
        f"{number} solves, one per order at {speeds.points} speeds from {speeds.start:.6g} to "
        f"{speeds.stop:.6g} rad/s{twice}"
    )


def plan_torsion_curves(case: "Case") -> Iterator[Stage]:
    """Orders of named shafts and stations, cyclic irregularity, conditions of the cylinders."""
    torsion, line = asked(case), case.machine.shaft_line
    if torsion is None or line is None:
        return
    points = 0 if torsion.speeds is None else torsion.speeds.points
    asks = {
        "curves": bool(torsion.curves) and torsion.speeds is not None,
        "irregularity": bool(torsion.irregularity),
        "conditions": torsion.conditions is not None,
    }
    for name in (name for name, is_asked in asks.items() if is_asked):
        module, are = ("order_curves", "are") if name == "curves" else (name, "is")
        cost = f"{solves(case, points or 1)} solves, one per order and speed"
        if name == "conditions":
            cost += f", for {len(condition_names(case))} conditions at once"
        yield _stage(
            case,
            f"torsion {name}",
            f"{module}:run_torsion_{name}",
            why=f"[response.torsion] {name} {are} in the case",
            cost=cost,
            quantities=_of_curves(case, name),
            work=_work_of_conditions if name == "conditions" else _work_of_curves,
        )


def _of_curves(case: "Case", name: str) -> tuple[str, ...]:
    """Paths of curves, irregularity or conditions that the case has something for."""
    from vibecalc.torsion.curve_tables import curves_of

    torsion, line = torsion_of(case), shaft_line_of(case)
    left_out = _not_allowed(torsion)
    if torsion.speeds is None:
        left_out += [one for one in below(f"{ROOT}/{name}/") if over_range(one)]
    if name == "curves":
        of = curves_of(line, torsion.curves)
        every = {path.split("/")[3] for path in below(f"{ROOT}/curves/")}
        points = {one for c in torsion.curves for one in every if getattr(c.measured, one, ())}
        left_out += [f"/{one}/" for one in every - set(of)]
        left_out += [f"/{one}/measured/" for one in every - points]
        left_out += [] if torsion.limits else ["/allowed", "/transient"]
    if not any(one.pole_pairs for one in torsion.irregularity):
        left_out.append("/electrical_angle")
    if not any(shaft.has_stress for shaft in line.shafts):
        left_out.append("/stress")
    if name == "conditions" and not torsion.irregularity:
        left_out.append("/irregularity")
    if not torsion.limits:
        left_out.append("/limit/")
    if not coupling_limits(case):
        left_out.append("/coupling/")
    return below(f"{ROOT}/{name}/", without=tuple(left_out))


# ----------------------------------------------------------------------------
# What a case asks of a shaft line next to its steady response: one stage for each question.
# ----------------------------------------------------------------------------


def plan_torsion_studies(case: "Case") -> Iterator[Stage]:
    """The modal route as published, the variable inertia and the transient, where asked for."""
    torsion = asked(case)
    if torsion is None or case.machine.shaft_line is None:
        return
    if torsion.as_published is not None:
        yield _published(case)
    if torsion.variable_inertia is not None:
        yield _variable(case)
    if torsion.transient is not None:
        yield _transient(case)


def _published(case: "Case") -> Stage:
    torsion = torsion_of(case)
    options = torsion.as_published
    assert options is not None
    without = ("/twist", "/largest_twist") if torsion.speeds is None else ()
    paths = below(PUBLISHED, without=without)
    if torsion.speeds is None:
        paths += (f"{PUBLISHED}twist_at_critical", f"{PUBLISHED}largest_twist")
        paths += (f"{PUBLISHED}largest_twist_order",)
    if options.magnifier == "undamped":
        paths = tuple(p for p in paths if "critical" not in p and "largest_twist" not in p)
    return _stage(
        case,
        "modal route as published",
        "as_published:run_torsion_as_published",
        why="[response.torsion.as_published] is in the case",
        orders=line_orders(case),
        cost=f"closed forms for {options.modes} modes, each order"
        + ("" if torsion.speeds is None else f" and each of {torsion.speeds.points} speeds"),
        quantities=paths,
        work=lambda case, orders: ((1, "closed_forms"),),
    )


def _variable(case: "Case") -> Stage:
    torsion = torsion_of(case)
    there = list(below(VARIABLE))
    if torsion.speeds is None:
        of_range = (f"{VARIABLE}{name}" for name in ("speeds/", "wedge/", "unstable/", "largest_"))
        there = [path for path in there if not path.startswith(tuple(of_range))]
    if has_loss(case):
        timed = (f"{VARIABLE}growth", f"{VARIABLE}unstable/")
        there = [path for path in there if not path.startswith(timed)]
    over = f"{torsion.speeds.points} solves of all orders at once, and " if torsion.speeds else ""
    return _stage(
        case,
        "variable inertia",
        "variable_inertia:run_torsion_variable_inertia",
        "torsion_variable_topics",
        why="[response.torsion.variable_inertia] is in the case",
        orders=line_orders(case) + ", and further ones of the motion",
        cost=over + "Newton's method with all orders at the operating speed",
        quantities=tuple(there),
        # the motion has more orders than its excitation; so many are tried first
        harmonics=lambda case: _half_orders(case)._replace(
            is_least=True, rule="of the excitation; more of the motion"
        ),
        work=_work_of_variable,
    )


def _transient(case: "Case") -> Stage:
    change = torsion_of(case).transient
    assert change is not None
    return _stage(
        case,
        "transient",
        "transient:run_torsion_transient",
        "torsion_transient_topics",
        why=f'[response.torsion.transient] is in the case, kind = "{change.kind}"',
        orders=line_orders(case),
        cost=f"matrix exponentials over {round(least_steps(case))} steps of a third of the highest "
        "order's period, or more",
        quantities=below(TRANSIENT, without=_not_of_change(case, change)),
        work=_work_of_transient,
    )


def _not_of_change(case: "Case", change: "Transient") -> tuple[str, ...]:
    """Beginnings of what there is not of a change."""
    shafts = shaft_line_of(case).shafts
    stressed = any(shaft.has_stress for shaft in shafts)
    left_out = [*(OF_STEPS if change.kind in PASSAGES else OF_PASSAGES)]
    there = {
        "clutch/": change.kind == "clutch_in",
        "steady_before": change.kind != "clutch_in",
        "peak_stress": stressed,
        "equivalent/": has_loss(case) and torsion_of(case).damping_model is None,
        "counted/": change.counting is not None,
        "counted/largest_stress_range": stressed,
        "counted/damage": any(shaft.fatigue is not None for shaft in shafts),
    }
    return (*left_out, *(TRANSIENT + name for name, has in there.items() if not has))


# ----------------------------------------------------------------------------
# The stage that finds the damper of a shaft line.
# ----------------------------------------------------------------------------


def plan_damper(case: "Case") -> Iterator[Stage]:
    """Planned where [damper_design] is in the case."""
    options = case.damper_design
    if options is None or case.machine.shaft_line is None:
        return
    others = [name for name in OBJECTIVES if name != options.objective]
    there = {
        "table/": options.compare is not None,
        "chart/": {"stiffness", "damping"} <= set(options.find),
        "ring/": bool(options.rings),
    }
    left_out = [
        *(f"{stem}{name}" for stem in ("worst_", "chart/", "ring/", "curve/") for name in others),
        *(DESIGN + name for name, has in there.items() if not has),
    ]
    searches = f"{1 + len(options.rings)} searches, one for each ring: " if options.rings else ""
    yield _stage(
        case,
        "damper design",
        "damper_design:run_damper_design",
        "damper_design_topics",
        why="[damper_design] is in the case",
        orders=line_orders(case),
        cost=f"{searches}a map of dampers by changes of rank one, then descents and Newton's "
        "method",
        quantities=below(DESIGN, without=tuple(left_out)),
        work=_work_of_damper,
    )


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def _half_orders(case: "Case") -> Harmonics:
    if shaft_line_of(case).excitations:
        orders = excited_orders(case)
        rule = "[[machine.shaft_line.excitations]]"
        if has_crank_train(case.machine):
            rule = "of the cylinders and of " + rule
        return Harmonics(len(orders), orders[0], orders[-1], rule)
    (highest, step), torsion = asked_orders(case), asked(case)
    usual = torsion is None or torsion.orders is None
    rule = "the usual ones" if usual else "[response.torsion] orders"
    return Harmonics(round(highest / step), step, highest, rule)


def _work_of_torsion(case: "Case", orders: int) -> Work:
    return ((1, "line"), (orders, "line_order"), (freedom_count(case) ** 3, "shape_weight"))


def _work_of_speeds(case: "Case", orders: int) -> Work:
    torsion, freedoms = torsion_of(case), freedom_count(case)
    assert torsion.speeds is not None
    bare = bool(shaft_line_of(case).dampers)
    lines = 1 + bare + bool(torsion.misfire)
    solved = solves(case, torsion.speeds.points) * freedoms * lines
    couplings = lines * len(named_couplings(case))
    return (
        *((1 + bare, "line"), (solved, "line_solve"), (len(torsion.limits), "limit")),
        *(((couplings, "coupling_range"),) if couplings else ()),
    )


def _work_of_curves(case: "Case", orders: int) -> Work:
    from vibecalc.torsion.curve_tables import curves_of

    torsion, line = torsion_of(case), shaft_line_of(case)
    points = 1 if torsion.speeds is None else torsion.speeds.points
    solved = solves(case, points) * freedom_count(case)
    return ((1, "line"), (solved * max(2, len(curves_of(line, torsion.curves))), "line_solve"))


def _work_of_conditions(case: "Case", orders: int) -> Work:
    range_ = torsion_of(case).speeds
    solved = solves(case, 1 if range_ is None else 2 * range_.points) * freedom_count(case)
    ranges = 1 + bool(coupling_limits(case))  # couplings are solved for by themselves
    return ((2, "line"), (solved * len(condition_names(case)) * ranges, "line_solve"))


def _work_of_variable(case: "Case", orders: int) -> Work:
    range_ = torsion_of(case).speeds
    speeds = 0 if range_ is None else range_.points
    return ((5 + speeds, "variable_solve"),)


def _work_of_transient(case: "Case", orders: int) -> Work:
    return ((math.ceil(least_steps(case)), "time_step"), (6, "line"))


def _work_of_damper(case: "Case", orders: int) -> Work:
    options, freedoms = case.damper_design, freedom_count(case)
    assert options is not None
    rings = 1 + len(options.rings)
    torsion = asked(case)
    speeds = options.speeds or (None if torsion is None else torsion.speeds)
    points = 100 if speeds is None else speeds.points
    return ((rings, "damper_map"), (rings * orders * points * freedoms, "damper_solve"))


def names_of(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    line = case.machine.shaft_line
    if line is None:
        return {}
    from vibecalc.torsion.shaft_line_tables import Layout

    gears = tuple(gear.label for gear in line.gears)
    elastic = [gear.label for gear in line.gears if gear.mesh_stiffness is not None]
    dampers = tuple(one.name for one in line.dampers)
    return {
        "station": tuple(one.name for one in line.stations),
        "section": (*Layout(line).sections, *elastic, *dampers),
        "damper": dampers,
        "gear": gears,
        "condition": condition_names(case),
        "coupling": tuple(named_couplings(case)),
        "coupling_limit": coupling_limits(case),
    }


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    torsion = asked(case)
    design, line = case.damper_design, case.machine.shaft_line
    if axis == "speed":
        own = design and design.speeds if path.startswith(DESIGN) else None
        where = "damper_design.speeds" if own else "response.torsion.speeds"
        return Entries.of_speeds(own or (torsion and torsion.speeds), where)
    if axis == "half_order" and path.startswith(ROOT):
        return _planned_orders(case, path)
    if axis == "mode" and line is not None and path.startswith(ROOT):
        because = "a shaft line has at most one mode for each station and each damper"
        return Entries.up_to(len(line.stations) + len(line.dampers), because)
    return None


def _planned_orders(case: "Case", path: str) -> Entries | None:
    stages = (one for plan in SUBJECT.stages for one in plan(case))
    stage = next((one for one in stages if path in one.quantities), None)
    found = None if stage is None else harmonics_of(case, stage)
    if found is None:
        return None
    if case.machine.shaft_line is not None and case.machine.shaft_line.excitations:
        return Entries(excited_orders(case), "orders of cylinders and of torques at stations")
    orders = tuple(found.lowest * number for number in range(1, found.number + 1))
    return Entries(orders, "orders of [response.torsion] says their step and the highest")


SUBJECT = Subject(
    entries=_entries,
    names=names_of,
    stages=(
        plan_torsion,
        plan_torsion_curves,
        plan_torsion_studies,
        plan_damper,
    ),
    concerns=lambda case: (
        case.machine.kind in ("engine", "drive_train")
        or case.machine.shaft_line is not None
        or case.damper_design is not None
        or (case.response is not None and case.response.torsion is not None)
    ),
    units={
        "line": Unit(4.0e-2, "shaft lines set up with their modes"),
        "line_order": Unit(6.0e-4, "orders of a shaft line summed"),
        "line_solve": Unit(4.8e-7, "solves times freedoms", megabytes=3.0e-5),
        "shape_weight": Unit(2.0e-8, "modes times elements times freedoms"),
        "coupling_range": Unit(1.0, "ranges of speeds with the states of a coupling"),
        "limit": Unit(1.0e-1, "limits followed over the range"),
        "time_step": Unit(6.0e-4, "steps in time", "scipy.sparse"),
        "variable_solve": Unit(1.5e-2, "solves of all orders at once", "scipy.linalg"),
        "damper_map": Unit(1.0, "maps of dampers with descents", holds=50.0),
        "damper_solve": Unit(1.0e-4, "solves times freedoms of the map"),
    },
    checks=("vibecalc.torsion.checks:line_problems",),
    last_checks=("vibecalc.torsion.checks:modal_problems",),
    cautions=(
        "vibecalc.torsion.model:throw_cautions",
        "vibecalc.torsion.checks:torsion_cautions",
    ),
    sections=(
        "vibecalc.torsion.report.first_page:torsion",
        "vibecalc.torsion.report.line:torsion_line",
        "vibecalc.torsion.report.damping:torsion_damping",
        "vibecalc.torsion.report.modes:torsion_modes",
        "vibecalc.torsion.report.excitation:torsion_excitation",
        "vibecalc.torsion.report.vibration:torsion_steady",
        "vibecalc.torsion.report.vibration:torsion_speeds",
        "vibecalc.torsion.report.curves:torsion_curves",
        "vibecalc.torsion.report.curves:torsion_irregularity",
        "vibecalc.torsion.report.curves:torsion_conditions",
        "vibecalc.torsion.report.limits:torsion_limits",
        "vibecalc.torsion.report.couplings:torsion_couplings",
        "vibecalc.torsion.report.studies:torsion_variable",
        "vibecalc.torsion.report.studies:torsion_transient",
        "vibecalc.torsion.report.studies:torsion_published",
        "vibecalc.torsion.report.damper_design:damper_design",
    ),
    pictures={
        "torsion_excitation": "vibecalc.torsion.pictures.excitation:TORSION_EXCITATION",
        "torsion_shapes": "vibecalc.torsion.pictures.modes:draw_torsion_shapes",
        "torsion_campbell": "vibecalc.torsion.pictures.modes:draw_torsion_campbell",
        "torsion_speeds": "vibecalc.torsion.pictures.speeds:TORSION_SPEEDS",
        "torsion_limits": "vibecalc.torsion.pictures.limits:TORSION_LIMITS",
        "torsion_curves": "vibecalc.torsion.pictures.curves:TORSION_CURVES",
        "torsion_station_curves": "vibecalc.torsion.pictures.curves:TORSION_STATION_CURVES",
        "torsion_orders": "vibecalc.torsion.pictures.excitation:TORSION_ORDERS",
        "torsion_vectors": "vibecalc.torsion.pictures.excitation:draw_torsion_vectors",
        "torsion_transient": "vibecalc.torsion.pictures.studies:TORSION_TRANSIENT",
        "torsion_waterfall": "vibecalc.torsion.pictures.studies:draw_torsion_waterfall",
        "torsion_couplings": "vibecalc.torsion.pictures.couplings:TORSION_COUPLINGS",
        "torsion_dampers": "vibecalc.torsion.pictures.speeds:TORSION_DAMPERS",
        "torsion_variable_inertia": "vibecalc.torsion.pictures.studies:VARIABLE_INERTIA",
        "torsion_as_published": "vibecalc.torsion.pictures.as_published:AS_PUBLISHED",
        "damper_map": "vibecalc.torsion.pictures.damper_design:draw_damper_map",
        "damper_response": "vibecalc.torsion.pictures.damper_design:DAMPER_RESPONSE",
    },
    leads=True,
    calculation="vibecalc.torsion.report.calculation:CALCULATION",
    assumes=(
        "Inertias are lumped and shafts linear; bending and axial vibration are left "
        "out. The mean crank speed is given.",
        "Gear meshes are rigid or elastic without backlash; a reversal of torque is "
        "reported. Orders that the case does not name are left out.",
    ),
)
