"""Can what a case asks of its shaft line be answered, and is it what it looks like?"""

from collections.abc import Iterator, Sequence

import numpy as np

from vibecalc.core.case.fields import RunUp
from vibecalc.core.case.raw import strangers, unknown
from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.excitation.gas_tables import within_cards
from vibecalc.kinds import has_crank_train
from vibecalc.parts.firing import TURN, cycle_angle, is_separate, with_torque
from vibecalc.parts.tangential_effort import TangentialEffort
from vibecalc.schema import Case
from vibecalc.torsion.asked import asked, asked_orders
from vibecalc.torsion.line_checks import (
    LINE,
    damping_problems,
    excitation_problems,
    shaft_line_problems,
)
from vibecalc.torsion.question_checks import (
    change_problems,
    curve_problems,
    friction_problems,
    steps_problems,
)
from vibecalc.torsion.shaft_line_tables import Layout, ShaftLine, stressed
from vibecalc.torsion.tables import AsPublished, LineSpeeds, Torsion

# ----------------------------------------------------------------------------
# Can what is asked of a shaft line be answered: speeds, orders, cylinders, sections?
# ----------------------------------------------------------------------------

TORSION: KeyPath = ("response", "torsion")
DESIGN: KeyPath = ("damper_design",)
#: the largest order of the excitation
HIGHEST = 400.0
#: an order or a speed that is given, with its key
At = tuple[KeyPath, float]


@listing
def line_problems(case: Case) -> Iterator[Problem]:
    """Problems of the shaft line, of [response.torsion] and [damper_design] against the machine."""
    line, torsion, speeds = case.machine.shaft_line, asked(case), asked_speeds(case)
    if line is None:
        turned = bool(with_torque(case))
        if turned or case.bearing_loads is not None:
            yield from _cards(case, speeds)
        if turned:
            yield from _effort(case, speeds)
        return
    layout = Layout(line)
    yield from shaft_line_problems(case, line, layout)
    if torsion is not None and torsion.transient is not None:
        yield from steps_problems(case, torsion.transient)
    yield from _cards(case, speeds)
    yield from _effort(case, speeds)
    yield from _run_up(case, line)
    yield from excitation_problems(case, line, layout, torsion)
    if torsion is not None:
        yield from _orders(case, torsion)
        yield from change_problems(line, layout, torsion)
        yield from friction_problems(case, line, torsion)
        yield from _damping(line, torsion)
        yield from _published(line, torsion)
        if torsion.limits:
            from vibecalc.torsion.question_checks import limit_problems

            yield from limit_problems(case, line, layout, torsion.limits)
    if any(shaft.coupling is not None for shaft in line.shafts):
        from vibecalc.torsion.line_checks import coupling_problems

        yield from coupling_problems(case, line, layout)
    yield from design_problems(case, line, layout)
    if torsion is not None:
        yield from curve_problems(case, torsion)
    yield from damping_problems(case, line, layout, speeds, most_modes(line))


def modal_problems(case: Case) -> list[Problem]:
    """The problem of a sum over modes which the damping couples, at the operating speed."""
    torsion = asked(case)
    if torsion is None or torsion.method != "modal" or torsion.damping_model is not None:
        return []
    from vibecalc.torsion.adapters.setup import Model, undamped_modes
    from vibecalc.torsion.forced import UNCOUPLED, modal_damping
    from vibecalc.torsion.model import build_shaft_line

    shaft, speed = build_shaft_line(case), case.machine.speed
    stations = len(shaft.freedom_names) - len(shaft.dampers)
    model = Model(shaft.line, shaft.speed_stiffness, torsion.method, None, stations)
    coupling = modal_damping(model.at(speed), undamped_modes(model, speed).shape).coupling
    if coupling <= UNCOUPLED:
        return []
    return [
        Problem(
            path=(*TORSION, "method"),
            message="damping couples the undamped modes, so that a sum over modes is not the "
            "response",
            found=f"by {coupling:.2g} of their own damping",
            allowed="method = 'elimination' or 'dense', or a damping_model",
        )
    ]


def asked_speeds(case: Case) -> list[At]:
    """Crank speeds in rad/s at which a case asks for its engine, each with its key."""
    torsion = asked(case)
    ranges: list[tuple[KeyPath, LineSpeeds | RunUp | None]] = []
    found: list[tuple[KeyPath, float | None]] = [(("machine", "speed"), case.machine.speed)]
    if torsion is not None:
        ranges.append(((*TORSION, "speeds"), torsion.speeds))
        if torsion.transient is not None:
            path: KeyPath = (*TORSION, "transient")
            change = torsion.transient
            found += [((*path, "from"), change.start), ((*path, "to"), change.stop)]
    ranges += run_ups_with_torque(case)
    if case.damper_design is not None:
        ranges.append(((*DESIGN, "speeds"), case.damper_design.speeds))
    for path, given in ranges:
        if given is not None:
            found += [((*path, "from"), given.start), ((*path, "to"), given.stop)]
    return [(path, speed) for path, speed in found if speed is not None]


def run_ups_with_torque(case: Case) -> list[tuple[KeyPath, RunUp | None]]:
    """Ranges of speed over which the torque of its cylinders moves a body, with their keys."""
    tables = {name: getattr(case, name) for name in with_torque(case)}
    return [((name, "run_up"), table.run_up) for name, table in tables.items() if table.run_up]


def _cards(case: Case, speeds: Sequence[At]) -> Iterator[Problem]:
    """Between cards pressure is interpolated, beyond them nobody has measured it."""
    cards = case.machine.crank_train.gas_cards if has_crank_train(case.machine) else ()
    ends = sorted(card.speed for card in cards)
    counted = [*speeds]
    if case.bearing_loads is not None and case.bearing_loads.speeds is not None:
        path, given = ("bearing_loads", "speeds"), case.bearing_loads.speeds
        counted += [((*path, "from"), given.start), ((*path, "to"), given.stop)]
    for key, speed in counted if len({*ends}) > 1 else ():
        if not within_cards(ends, speed):
            yield Problem(
                path=key,
                message="this speed is outside the range of the gas cards",
                found=f"{speed:.6g} rad/s",
                allowed=f"{ends[0]:.6g} to {ends[-1]:.6g} rad/s",
                hint="add a card at this speed, or stay within the range of the cards",
                also=("machine", "crank_train", "gas_cards"),
            )


def _effort(case: Case, speeds: Sequence[At]) -> Iterator[Problem]:
    if has_crank_train(case.machine) and case.machine.crank_train.tangential_effort is not None:
        yield from effort_problems(case, speeds)


def _run_up(case: Case, line: ShaftLine) -> Iterator[Problem]:
    """A geared line without damping passes resonances of no bound, which nothing would bridge."""
    passed = run_ups_with_torque(case)
    if not passed or is_separate(case) or not line.gears or not line.shafts:
        return
    damped = (
        *(line.dampers, line.engine_damping),
        *(one.damping or one.damping_ratio or one.eta for one in line.shafts),
        *(one.propeller_damping for one in line.absorbed_torques),
        *(one.absolute_damping for one in line.stations),
    )
    if not any(damped):
        yield Problem(
            path=passed[0][0],
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
            message="a two-stroke engine has no half orders",
            found=f"step = {orders.step:g}",
            allowed="1, or cycle = 'four_stroke'",
            also=("machine", "cycle"),
        )
    step = orders.step or least
    top = step * orders.count if orders.count is not None else orders.highest or 0.0
    if top > HIGHEST:
        yield Problem(
            path=(*path, "count"),
            message="the highest order is too high",
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
    model, modes = torsion.damping_model, most_modes(line)
    if model is not None:
        path: KeyPath = (*TORSION, "damping_model")
        if model.kind == "modal" and len(model.ratios) > modes:
            yield Problem(
                path=(*path, "ratios"),
                message="there are more ratios than modes",
                found=f"{len(model.ratios)} ratios",
                allowed=f"up to {modes}, the first one of the rigid mode, or one for all",
            )
        if model.kind == "modal" and torsion.variable_inertia is not None:
            yield Problem(
                path=(*path, "kind"),
                message="damping ratios by mode do not go with a variable inertia, which couples "
                "the modes",
                allowed="kind = 'rayleigh', or no damping_model and dampings of shafts, stations "
                "or dampers",
                also=(*TORSION, "variable_inertia"),
            )
        for place, mode in enumerate(model.modes):
            if mode > modes:
                yield Problem(
                    path=(*path, "modes", place),
                    message=f"the line has no mode {mode}",
                    allowed=f"2 to {modes}",
                )


def most_modes(line: ShaftLine) -> int:
    """Modes of a line, rigid ones too."""
    rigid = sum(1 for gear in line.gears if gear.mesh_stiffness is None)
    return max(len(line.stations) + len(line.dampers) - rigid, 1)


def _published(line: ShaftLine, torsion: Torsion) -> Iterator[Problem]:
    options = torsion.as_published
    held = any(station.ground_stiffness for station in line.stations)
    rings = sum(1 for damper in line.dampers if damper.kind == "viscous")
    elastic = max(most_modes(line) - rings - (0 if held else 1), 0)
    if options is None or options.modes <= max(elastic, AsPublished().modes):
        return
    yield Problem(
        path=(*TORSION, "as_published", "modes"),
        message="more modes are requested than the line has",
        found=f"modes = {options.modes}",
        allowed=f"up to {elastic}, its elastic modes",
    )


# ----------------------------------------------------------------------------
# Can a damper be designed for this place of the line, with these numbers?
# ----------------------------------------------------------------------------


def design_problems(case: Case, line: ShaftLine, layout: Layout) -> Iterator[Problem]:
    """Problems of where the damper hangs, of what is looked for, and of its bounds."""
    design = case.damper_design
    if design is None:
        return
    dampers = {damper.name: damper for damper in line.dampers}
    replaced = dampers.get(design.on)
    if replaced is None and design.on not in layout.at:
        yield unknown((*DESIGN, "on"), "station or damper", design.on, [*layout.names, *dampers])
    if replaced is not None and replaced.kind == "pendulum":
        yield Problem(
            path=(*DESIGN, "on"),
            message="pendulums are tuned by their order, not by a spring and a damper",
            found=repr(design.on[:60]),
            allowed="a station, or a damper of kind 'viscous' or 'spring'",
        )
    if replaced is not None and replaced.kind == "friction":
        yield Problem(
            path=(*DESIGN, "on"),
            message="a ring on dry friction is not designed by a spring and a damper",
            found=repr(design.on[:60]),
            allowed="a station, or a damper of kind 'viscous' or 'spring'",
            also=(*LINE, "dampers"),
        )
    for key in ("inertia", "stiffness", "damping"):
        bound, given, sought = (
            getattr(design.bounds, key, None),
            getattr(design, key),
            key in design.find,
        )
        if sought and key == "inertia" and bound is None:
            yield Problem(
                path=DESIGN,
                message="an inertia in `find` needs bounds: a larger one is always better",
                allowed="bounds = { inertia = ['2 kg*m^2', '9 kg*m^2'] }, for example",
            )
        if sought and given is not None:
            yield Problem(
                path=(*DESIGN, key),
                message=f"{key} is given, but `find` names it too",
                allowed=f"no {key}, or find without it",
                also=(*DESIGN, "find") if "find" in design.model_fields_set else None,
            )
        elif not sought and given is None and replaced is None and design.on in layout.at:
            yield Problem(
                path=DESIGN,
                message=f"the new damper has no {key}, and `find` does not name it",
                allowed=f"{key} here, or in find",
            )
        if bound is not None and not sought:
            yield Problem(
                path=(*DESIGN, "bounds", key),
                message=f"{key} is not in `find`, so that its bounds have no effect",
                allowed=f"{key} in find, or no such bounds",
            )
    yield from strangers((*DESIGN, "sections"), "shaft", design.sections, layout.sections)
    counted = design.sections or layout.sections
    if design.objective == "stress" and not {*counted} & {*stressed(line, layout)}:
        yield Problem(
            path=(*DESIGN, "objective"),
            message="none of these shafts has a section modulus for a stress",
            allowed="diameter, section_modulus or section on the shafts, or objective = 'torque'",
        )


# ----------------------------------------------------------------------------
# What is asked of a shaft line and is possible, but may not be what it looks like.
# ----------------------------------------------------------------------------


def torsion_cautions(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    line, torsion, texts = case.machine.shaft_line, asked(case), list[str]()
    if line is None or torsion is None:
        return texts
    cylinders = case.machine.crank_train.cylinders if has_crank_train(case.machine) else ()
    if cylinders and len(torsion.misfire) == len(cylinders):
        texts.append("no cylinder fires: all are in misfire, and the engine is motored")
    if torsion.limits:
        from vibecalc.torsion.question_checks import limit_cautions

        texts += limit_cautions(line, Layout(line), torsion.limits)
    return texts


EFFORT: KeyPath = ("machine", "crank_train", "tangential_effort")
#: names that are listed of what is missing
_LISTED = 6


def effort_problems(case: Case, speeds: Sequence[tuple[KeyPath, float]]) -> Iterator[Problem]:
    """Problems of [machine.crank_train.tangential_effort] with the crank speeds that are asked."""
    given = case.machine.crank_train.tangential_effort
    assert given is not None
    yield from _loads(given)
    yield from _speeds(given, speeds)
    if case.machine.shaft_line is not None:
        yield from _effort_orders(case, given)
        yield from _motored(case)
    for table in with_torque(case):
        yield Problem(
            path=EFFORT,
            message="the torque on the mounts takes its error from as many orders again, which a "
            "table of tangential effort does not have",
            allowed="gas_pressure, gas_cards or gas_cycle, or driven_machine = 'cancels_torque' in "
            "[excitation]",
            hint='loads = ["shaking"] leaves the torque out',
            also=(table,),
        )


def _loads(given: TangentialEffort) -> Iterator[Problem]:
    """Between loads of the table harmonics are interpolated, beyond them nobody knows them."""
    rows = given.harmonics.mean_indicated_pressure
    low, high = min(rows), max(rows)
    over = given.over_speed
    asked: list[tuple[KeyPath, float]] = []
    key = "mean_indicated_pressure"
    if given.mean_indicated_pressure is not None:
        asked = [((*EFFORT, key), given.mean_indicated_pressure)]
    elif over is not None:
        listed = enumerate(over.mean_indicated_pressure)
        asked = [((*EFFORT, "over_speed", key, place), load) for place, load in listed]
    for path, load in asked:
        if not low <= load <= high:
            allowed = f"{1e-5 * low:.6g} to {1e-5 * high:.6g} bar"
            yield Problem(
                path=path,
                message="the harmonics have no row for this mean indicated pressure",
                found=f"{1e-5 * load:.6g} bar",
                allowed=allowed if low < high else f"{1e-5 * low:.6g} bar, the only load there is",
                hint="rows of harmonics at loads below and above it",
                also=(*EFFORT, "harmonics"),
            )
            return


def _speeds(given: TangentialEffort, speeds: Sequence[tuple[KeyPath, float]]) -> Iterator[Problem]:
    if given.over_speed is None:
        return
    low, high = given.over_speed.speed[0], given.over_speed.speed[-1]
    for path, speed in speeds:
        if not low * (1 - 1e-12) <= speed <= high * (1 + 1e-12):
            yield Problem(
                path=path,
                message="no mean indicated pressure is given for this speed",
                found=f"{speed:.6g} rad/s",
                allowed=f"{low:.6g} to {high:.6g} rad/s",
                hint="a row of over_speed at this speed, or a range that its rows cover",
                also=(*EFFORT, "over_speed"),
            )


def _effort_orders(case: Case, given: TangentialEffort) -> Iterator[Problem]:
    """Orders that the gas of such an engine has, and all of those that are asked."""
    rows = given.harmonics.order
    base = TURN / cycle_angle(case.machine)
    for place, order in enumerate(rows if base == 1.0 else ()):
        if order != round(order):
            yield Problem(
                path=(*EFFORT, "harmonics", "order", place),
                message="a two-stroke engine has no half orders",
                found=f"{order:g}",
                allowed="1, 2, 3, ..., or cycle = 'four_stroke'",
                also=("machine", "cycle"),
            )
            return
    highest, step = asked_orders(case)
    asked = np.arange(1, round(highest / step) + 1) * step
    missing = [f"{order:g}" for order in asked.tolist() if order not in {*rows}]
    if missing:
        more = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        torsion = None if case.response is None else case.response.torsion
        said = torsion is not None and torsion.orders is not None
        yield Problem(
            path=(*TORSION, "orders") if said else (*EFFORT, "harmonics", "order"),
            message="the table of tangential effort lacks requested orders",
            found=f"no order {', '.join(missing[:_LISTED])}{more}",
            allowed=f"orders that it has, up to {max(rows):g}",
            hint=_rather(rows, base),
            also=(*EFFORT, "harmonics", "order") if said else None,
        )


def _rather(orders: Sequence[float], base: float) -> str:
    """Orders of [response.torsion] that a table has all of, as a case says them."""
    there = {*orders}
    for step in (base, 1.0):
        count = 0
        while (count + 1) * step in there:
            count += 1
        if count:
            chosen = f"highest = {count * step:g}" + f", step = {step:g}" * (step != base)
            return f"orders = {{ {chosen} }} in [response.torsion]"
    return "the harmonics from the first order on"


def _motored(case: Case) -> Iterator[Problem]:
    torsion = None if case.response is None else case.response.torsion
    if torsion is None:
        return
    asked: dict[KeyPath, str] = {(*TORSION, "misfire_kind"): torsion.misfire_kind}
    if torsion.conditions is not None:
        asked[(*TORSION, "conditions", "misfire_kind")] = torsion.conditions.misfire_kind
    for path, kind in asked.items():
        if kind == "motored":
            yield Problem(
                path=path,
                message="harmonics of a firing cylinder do not define a motored one",
                found="'motored'",
                allowed="'no_gas', or gas_pressure, gas_cards or gas_cycle",
                also=EFFORT,
            )
