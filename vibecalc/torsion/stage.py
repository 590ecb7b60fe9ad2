"""The stages that a case asks for its shaft line: reasons, results, harmonics, counted work."""

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
    counts_at_stations,
    coupling_limits,
    excited_orders,
    freedom_count,
    has_damped_rings,
    has_friction_damper,
    has_holzer,
    has_loops,
    has_loss,
    has_warm_couplings,
    leading,
    least_steps,
    modes_follow_speed,
    named_couplings,
    orders_words,
)
from vibecalc.torsion.results import ROOT, of_line, over_range
from vibecalc.torsion.study_results import (
    DESIGN,
    FRICTION,
    OBJECTIVES,
    OF_PASSAGES,
    OF_STEPS,
    PASSAGES,
    PUBLISHED,
    TRANSIENT,
    VARIABLE,
)

if TYPE_CHECKING:
    from vibecalc.torsion.shaft_line_tables import ShaftLine
    from vibecalc.torsion.tables import DamperDesign, Torsion

# ----------------------------------------------------------------------------
# One stage for each question. Its results are those below a root, but for what the case lacks.
# ----------------------------------------------------------------------------


def _without(*rows: tuple[object, str]) -> tuple[str, ...]:
    """Words in paths of what there is not: each row says whether it is there, and its words."""
    return tuple(word for there, words in rows if not there for word in words.split())


def _stage(case: "Case", name: str, adapter: str, topics: str = "", **more: Any) -> Stage:
    """A stage whose excitation is that of the line; it is a last one if nothing else is said."""
    usual: dict[str, Any] = {
        "parts": ("crank_train",) * has_crank_train(case.machine) + ("shaft_line",),
        "orders": orders_words(case),
        "harmonics": _half_orders,
        "is_last": True,
        "topics": (f"vibecalc.torsion.accuracy:{topics}",) if topics else (),
    }
    return Stage(name=name, adapter=f"vibecalc.torsion.adapters.{adapter}", **(usual | more))


def plan(case: "Case") -> Iterator[Stage]:
    """What [response.torsion] and [damper_design] ask of a shaft line."""
    torsion, line = asked(case), case.machine.shaft_line
    if line is not None and torsion is not None:
        yield from _line(case, line, torsion)
        yield from _curves(case, line, torsion)
        yield from _studies(case, line, torsion)
    if line is not None and case.damper_design is not None:
        yield _damper(case, torsion, case.damper_design)


def _line(case: "Case", line: "ShaftLine", torsion: "Torsion") -> Iterator[Stage]:
    """Modes, excitation and vibration at the operating speed; curves where speeds are given."""
    orders, freedoms, speeds = len(excited_orders(case)), freedom_count(case), torsion.speeds
    yield _stage(
        case,
        "torsion",
        "steady:run_torsion",
        "torsion_topics",
        why="[response.torsion] is in the case",
        cost=f"modes of {len(line.stations)} stations; {orders} solves, one per order, at "
        f"{30.0 / math.pi * case.machine.speed:.5g} rpm",
        quantities=_picked(case, line, torsion, ranged=False),
        is_last=False,
        work=lambda _, kept: ((1, "line"), (kept, "line_order"), (freedoms**3, "shape_weight")),
        leading=leading(case),
    )
    if speeds is None:
        return
    solved, bare = orders * speeds.points, bool(line.dampers)
    twice = f", and {solved} without dampers" * bare
    twice += f", and {solved} without misfire" * bool(torsion.misfire)

    def work(case: "Case", _: int) -> Work:
        lines = 1 + bare + bool(torsion.misfire)
        couplings = lines * len(named_couplings(case))
        counted = (1 + bare, "line"), (solved * freedoms * lines, "line_solve")
        return (*counted, (len(torsion.limits), "limit"), (couplings, "coupling_range"))

    yield _stage(
        case,
        "torsion_speeds",
        "speeds:run_torsion_speeds",
        "torsion_speeds_topics",
        why="[response.torsion] speeds are in the case",
        cost=f"{solved} solves, one per order at {speeds.points} speeds from "
        f"{30.0 / math.pi * speeds.start:.5g} to {30.0 / math.pi * speeds.stop:.5g} rpm{twice}",
        quantities=_picked(case, line, torsion, ranged=True),
        work=work,
        leading=leading(case),
    )


#: what only a line with cylinders has
_OF_CYLINDERS = (
    "/excitation/pressure /excitation/gas /excitation/inertia /excitation/total /excitation/power "
    "/excitation/engine_torque /excitation/mean_torque /excitation/firing_angle /excitation/rank "
    "/excitation/vector_sum /excitation/major /speeds/mean_torque /power_balance/source"
)


def _picked(case: "Case", line: "ShaftLine", torsion: "Torsion", ranged: bool) -> tuple[str, ...]:
    """Paths that the case has something for, at the operating speed or over the range."""
    from vibecalc.torsion.shaft_line_tables import has_laws, what_follows

    train = case.machine.crank_train if has_crank_train(case.machine) else None
    bored, own = train is not None and train.bore, torsion.damping_model is None
    modal = torsion.damping_model is not None and torsion.damping_model.kind == "modal"
    lacking = _without(
        (
            line.dampers,
            "ring_shape /damper/ /without_dampers/ /reduction /speeds/heat /speeds/travel",
        ),
        (line.dampers, "/largest/heat /largest/travel"),
        (line.gears, "gear /hammering/"),
        (torsion.campbell and modes_follow_speed(case), "/campbell/"),
        (not has_loops(case), "transfer_matrix"),
        (has_holzer(case), "holzer"),
        (has_damped_rings(case), "undamped_frequency"),
        (torsion.separation, "/sufficient"),
        (train, _OF_CYLINDERS),
        (line.absorbed_torques, "/power_balance/load"),
        (train or line.absorbed_torques, "/power_balance/rest"),
        (line.absorbed_torques and case.machine.kind == "engine", "total_load_power load_share"),
        (train and len({one.bank_angle for one in train.cylinders}) > 1, "bank_factor"),
        (modal, "modal_heat"),
        (any(shaft.has_stress for shaft in line.shafts), "stress"),
        (train and train.tangential_effort is None, "/excitation/pressure"),
        (bored, "tangential_pressure mean_indicated_pressure"),
        (named_couplings(case), "/coupling/"),
        (has_warm_couplings(case), "/temperature"),
        (
            coupling_limits(case),
            "/coupling/largest_utilisation /coupling/utilisation /coupling/speeds/utilisation",
        ),
        (torsion.misfire, "/healthy/"),
        (torsion.limits, "/barred/ /exceeded/ healthy/limit/"),
        (own and has_laws(line), "/damping/"),
        *((own and does, f"/speeds/{name}") for name, does in what_follows(line).items()),
    )
    held, there = f"{ROOT}/limit/", {*below(f"{ROOT}/", lacking + _not_allowed(torsion))}
    return tuple(
        path
        for path in of_line(ranged)
        if (_of_limits(torsion, path) if path.startswith(held) else path in there)
    )


def _not_allowed(torsion: "Torsion") -> tuple[str, ...]:
    """What limits of stress or of torque allow in conditions, of the kind that the case has not."""
    of_torque = [bool(one.torque or one.alternating_share) for one in torsion.limits]
    return _without(
        (any(of_torque), "limit/torque_allowed limit/operating_torque_allowed"),
        (not all(of_torque), "limit/allowed limit/operating_allowed"),
    )


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


def _curves(case: "Case", line: "ShaftLine", torsion: "Torsion") -> Iterator[Stage]:
    """Orders of named shafts and stations, cyclic irregularity, conditions of the cylinders."""
    if not (torsion.curves or torsion.irregularity or torsion.conditions):
        return
    from vibecalc.torsion.question_tables import curves_of

    points = 1 if torsion.speeds is None else torsion.speeds.points
    solved = len(excited_orders(case)) * points
    of = curves_of(line, torsion.curves)
    known = {path.split("/")[3] for path in below(f"{ROOT}/curves/")}
    measured = {one for c in torsion.curves for one in known if getattr(c.measured, one, ())}
    lacking = _without(
        *((one in of, f"/curves/{one}/") for one in known),
        *((one in measured, f"/curves/{one}/measured/") for one in known),
        (torsion.limits, "/stress/allowed /stress/transient /limit/ /exceeded/ /barred/"),
        (any(one.pole_pairs for one in torsion.irregularity), "/electrical_angle"),
        (any(shaft.has_stress for shaft in line.shafts), "/stress"),
        (torsion.irregularity, "/conditions/irregularity"),
        (line.gears, "/conditions/gear_minimum_torque"),
        (coupling_limits(case), "/coupling/"),
    )

    def work(case: "Case", _: int) -> Work:
        each = solved * freedom_count(case)
        return ((1, "line"), (each * max(2, len(of)), "line_solve"))

    def work_of_conditions(case: "Case", _: int) -> Work:
        # samples and maxima; couplings are solved for by themselves
        times = (1 + (torsion.speeds is not None)) * (1 + bool(coupling_limits(case)))
        each = solved * freedom_count(case) * len(condition_names(case))
        ranges = len(torsion.limits) * len(condition_names(case)) * (torsion.speeds is not None)
        return ((2, "line"), (times * each, "line_solve"), (ranges, "limit"))

    for name, adapter, there, why in (
        ("curves", "order_curves", torsion.curves and torsion.speeds, "are"),
        ("irregularity", "order_curves", torsion.irregularity, "is"),
        ("conditions", "conditions", torsion.conditions, "is"),
    ):
        at_once = f", for {len(condition_names(case))} conditions at once"
        paths = below(f"{ROOT}/{name}/", lacking + _not_allowed(torsion))
        if there:
            yield _stage(
                case,
                f"torsion {name}",
                f"{adapter}:run_torsion_{name}",
                why=f"[response.torsion] {name} {why} in the case",
                cost=f"{solved} solves, one per order and speed{at_once * (name == 'conditions')}",
                quantities=tuple(one for one in paths if torsion.speeds or not over_range(one)),
                work=work_of_conditions if name == "conditions" else work,
            )


def _studies(case: "Case", line: "ShaftLine", torsion: "Torsion") -> Iterator[Stage]:
    """The modal route as published, the variable inertia and the transient, where asked for."""
    speeds, points = torsion.speeds, torsion.speeds.points if torsion.speeds else 0
    published, change = torsion.as_published, torsion.transient
    if published is not None:
        lacking = _without(
            (speeds, f"{PUBLISHED}twist_magnitude"),
            (published.magnifier != "undamped", "critical largest_twist"),
            (has_holzer(case), "residual"),
        )
        paths = below(PUBLISHED, lacking)
        yield _stage(
            case,
            "modal route as published",
            "as_published:run_torsion_as_published",
            why="[response.torsion.as_published] is in the case",
            cost=f"closed forms for {published.modes} modes, each order"
            + f" and each of {points} speeds" * bool(speeds),
            quantities=tuple(one for one in paths if speeds or one != f"{PUBLISHED}twist"),
            work=lambda _, orders: ((1, "closed_forms"),),
        )
    if has_friction_damper(case):
        yield _stage(
            case,
            "friction damper of the line",
            "friction_damper:run_torsion_friction_damper",
            why="a damper of machine.shaft_line is of the kind friction",
            cost=f"one order at {1 + points} speeds",
            quantities=below(FRICTION, _without((speeds, "/speeds/"))),
            work=lambda case, _: ((1 + points, "line_solve"),),
        )
    if torsion.variable_inertia is not None:
        lacking = _without(
            (speeds, "/speeds/ /wedge/ /unstable/ /largest_"),
            (not has_loss(case), f"{VARIABLE}growth /unstable/"),
        )
        over = f"{points} solves of all orders at once, and " * bool(speeds)
        yield _stage(
            case,
            "variable inertia",
            "variable_inertia:run_torsion_variable_inertia",
            "torsion_variable_topics",
            why="[response.torsion.variable_inertia] is in the case",
            orders=orders_words(case) + ", more orders of the motion",
            cost=over + "Newton's method with all orders at the operating speed",
            quantities=below(VARIABLE, lacking),
            # the motion has more orders than its excitation; so many are tried first
            harmonics=lambda case: _half_orders(case)._replace(
                is_least=True, rule="of the excitation; the motion has more"
            ),
            work=lambda _, orders: ((5 + points, "variable_solve"),),
        )
    if change is not None:
        stressed = any(shaft.has_stress for shaft in line.shafts)
        lacking = _without(
            (change.kind == "clutch_in", "/clutch/"),
            (change.kind != "clutch_in", "steady_before"),
            (has_friction_damper(case), "transient/friction_damper/"),
            (line.gears, "gear_minimum_torque"),
            (stressed, "peak_stress counted/largest_stress_range"),
            (has_loss(case) and torsion.damping_model is None, "/equivalent/"),
            (change.counting, "/counted/"),
            (any(shaft.fatigue is not None for shaft in line.shafts), "counted/damage"),
        )
        lacking += OF_STEPS if change.kind in PASSAGES else OF_PASSAGES
        steps = least_steps(case)
        yield _stage(
            case,
            "transient",
            "transient:run_torsion_transient",
            "torsion_transient_topics",
            why=f'[response.torsion.transient] is in the case, kind = "{change.kind}"',
            cost=f"matrix exponentials over at least {round(steps)} steps of a third of the period "
            "of the highest order",
            quantities=below(TRANSIENT, lacking),
            work=lambda _, orders: ((math.ceil(steps), "time_step"), (6, "line")),
        )


def _damper(case: "Case", torsion: "Torsion | None", options: "DamperDesign") -> Stage:
    """The search for the damper of a shaft line."""
    others = [name for name in OBJECTIVES if name != options.objective]
    lacking = _without(
        *((False, f"worst_{one} chart/{one} ring/{one} curve/{one}") for one in others),
        (options.compare, f"{DESIGN}table/"),
        ({"stiffness", "damping"} <= set(options.find), f"{DESIGN}chart/"),
        (options.rings, f"{DESIGN}ring/"),
    )
    rings = 1 + len(options.rings)
    searches = f"{rings} searches, one for each ring: " * bool(options.rings)
    speeds = options.speeds or (torsion and torsion.speeds)
    solved = rings * (speeds.points if speeds else 100) * freedom_count(case)
    return _stage(
        case,
        "damper design",
        "damper_design:run_damper_design",
        "damper_design_topics",
        why="[damper_design] is in the case",
        cost=f"{searches}a damper map by rank-one updates, then local searches and Newton's method",
        quantities=below(DESIGN, lacking),
        work=lambda _, orders: ((rings, "damper_map"), (orders * solved, "damper_solve")),
    )


# ----------------------------------------------------------------------------
# Harmonics, and the entries of axes that the case knows.
# ----------------------------------------------------------------------------


def _half_orders(case: "Case") -> Harmonics:
    if counts_at_stations(case):
        orders = excited_orders(case)
        rule = "[[machine.shaft_line.excitations]]"
        if has_crank_train(case.machine):
            rule = "of the cylinders and of " + rule
        return Harmonics(len(orders), orders[0], orders[-1], rule)
    (highest, step), torsion = asked_orders(case), asked(case)
    usual = torsion is None or torsion.orders is None
    rule = "the usual ones" if usual else "[response.torsion] orders"
    return Harmonics(round(highest / step), step, highest, rule)


def names_of(case: "Case", path: str = "") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names; a gear with a limit stands among its sections."""
    line = case.machine.shaft_line
    if line is None:
        return {}
    from vibecalc.torsion.shaft_line_tables import Layout

    gears = tuple(gear.label for gear in line.gears)
    elastic = [gear.label for gear in line.gears if gear.mesh_stiffness is not None]
    limited = gears if path.startswith(f"{ROOT}/limit/") else elastic
    dampers = tuple(one.name for one in line.dampers)
    return {
        "station": tuple(one.name for one in line.stations),
        "section": (*Layout(line).sections, *limited, *dampers),
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
    if axis == "order" and path.startswith(ROOT):
        return _planned_orders(case, path)
    if axis == "mode" and line is not None and path.startswith(ROOT):
        because = "a shaft line has at most one mode for each station and each damper"
        return Entries.up_to(len(line.stations) + len(line.dampers), because)
    return None


def _planned_orders(case: "Case", path: str) -> Entries | None:
    stage = next((one for one in plan(case) if path in one.quantities), None)
    found = None if stage is None else harmonics_of(case, stage)
    if found is None:
        return None
    if counts_at_stations(case):
        return Entries(excited_orders(case), "orders of cylinders and of torques at stations")
    orders = tuple(found.lowest * number for number in range(1, found.number + 1))
    return Entries(orders, "orders of [response.torsion] says their step and the highest")


SUBJECT = Subject(
    entries=_entries,
    names=names_of,
    stages=(plan,),
    concerns=lambda case: (
        case.machine.kind in ("engine", "drive_train")
        or case.machine.shaft_line is not None
        or case.damper_design is not None
        or (case.response is not None and case.response.torsion is not None)
    ),
    units={
        "line": Unit(4.0e-2, "shaft lines with modes"),
        "line_order": Unit(6.0e-4, "orders of a shaft line"),
        "line_solve": Unit(4.8e-7, "solves x degrees of freedom", megabytes=3.0e-5),
        "shape_weight": Unit(2.0e-8, "modes x elements x degrees of freedom"),
        "coupling_range": Unit(1.0, "speed ranges with coupling states"),
        "limit": Unit(1.0e-1, "limits over the speed range"),
        "time_step": Unit(6.0e-4, "time steps", "scipy.sparse"),
        "variable_solve": Unit(1.5e-2, "solves of all orders at once", "scipy.linalg"),
        "damper_map": Unit(1.0, "damper maps with local searches", holds=50.0),
        "damper_solve": Unit(1.0e-4, "solves x degrees of freedom of the map"),
    },
    checks=("vibecalc.torsion.checks:line_problems",),
    last_checks=("vibecalc.torsion.checks:modal_problems",),
    cautions=(
        "vibecalc.torsion.model:throw_cautions",
        "vibecalc.torsion.checks:torsion_cautions",
    ),
    sections=(
        "vibecalc.torsion.report.first_page:torsion",
        "vibecalc.torsion.report.vibration:torsion_limits",
        "vibecalc.torsion.report.couplings:torsion_couplings",
        "vibecalc.torsion.report.studies:damper_design",
        "vibecalc.torsion.report.studies:torsion_friction_damper",
        "vibecalc.torsion.report.studies:torsion_transient",
        "vibecalc.torsion.report.modes:torsion_modes",
        "vibecalc.torsion.report.vibration:torsion_conditions",
        "vibecalc.torsion.report.vibration:torsion_irregularity",
        "vibecalc.torsion.report.vibration:torsion_steady",
        "vibecalc.torsion.report.vibration:torsion_speeds",
        "vibecalc.torsion.report.studies:torsion_variable",
        "vibecalc.torsion.report.studies:torsion_published",
        "vibecalc.torsion.report.line:torsion_line",
        "vibecalc.torsion.report.line:torsion_damping",
        "vibecalc.torsion.report.excitation:torsion_excitation",
        "vibecalc.torsion.report.vibration:torsion_curves",
    ),
    pictures={
        "torsion_excitation": "vibecalc.torsion.pictures.excitation:TORSION_EXCITATION",
        "torsion_shapes": "vibecalc.torsion.pictures.modes:draw_torsion_shapes",
        "torsion_campbell": "vibecalc.torsion.pictures.modes:draw_torsion_campbell",
        "torsion_speeds": "vibecalc.torsion.pictures.speeds:TORSION_SPEEDS",
        "counted_cycles": "vibecalc.torsion.pictures.studies:COUNTED_CYCLES",
        "torsion_limits": "vibecalc.torsion.pictures.speeds:TORSION_LIMITS",
        "torsion_curves": "vibecalc.torsion.pictures.excitation:TORSION_CURVES",
        "torsion_station_curves": "vibecalc.torsion.pictures.excitation:TORSION_STATION_CURVES",
        "torsion_orders": "vibecalc.torsion.pictures.excitation:TORSION_ORDERS",
        "torsion_vectors": "vibecalc.torsion.pictures.excitation:draw_torsion_vectors",
        "torsion_transient": "vibecalc.torsion.pictures.studies:TORSION_TRANSIENT",
        "torsion_waterfall": "vibecalc.torsion.pictures.studies:draw_torsion_waterfall",
        "torsion_couplings": "vibecalc.torsion.pictures.speeds:TORSION_COUPLINGS",
        "torsion_twists": "vibecalc.torsion.pictures.speeds:TORSION_TWISTS",
        "torsion_variable_inertia": "vibecalc.torsion.pictures.studies:VARIABLE_INERTIA",
        "torsion_as_published": "vibecalc.torsion.pictures.studies:AS_PUBLISHED",
        "damper_map": "vibecalc.torsion.pictures.studies:draw_damper_map",
        "damper_response": "vibecalc.torsion.pictures.studies:DAMPER_RESPONSE",
    },
    leads=True,
    calculation="vibecalc.torsion.report.first_page:CALCULATION",
    assumes=(
        "Inertias are lumped and shafts linear; couplings may follow load, heat and "
        "frequency. Bending and axial vibration are left out. The mean crank speed is "
        "given.",
        "Gear meshes are rigid or elastic without backlash; a reversal of torque is "
        "reported. Orders that the case does not name are left out.",
    ),
)
