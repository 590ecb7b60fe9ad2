"""Counted work of each stage, read from the case: solves, orders, turns, searches."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from vibecalc.pipeline.needs_orders import harmonics_of
from vibecalc.pipeline.stage_plan import StagePlan
from vibecalc.torsion.stage import solves

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.torsion.tables import Torsion

#: (how many, name of the unit of work)
Work = tuple[tuple[float, str], ...]
#: speeds that a run-up takes, refined where its curves bend
_RUN_UP = 300
_TURN = 2.0 * math.pi


def work_of(case: "Case", stage: StagePlan) -> Work:
    """The work of one stage; entries of zero are left out."""
    found = harmonics_of(case, stage)
    rule = _RULES.get(stage.stage)
    counted = () if rule is None else rule(case, 0 if found is None else found.number)
    return (*((number, unit) for number, unit in counted if number), (1, "stage"))


def _forces(case: "Case", orders: int) -> Work:
    return ((orders, "order"),)


def _isolation(case: "Case", orders: int) -> Work:
    assert case.isolation is not None
    if case.isolation.model == "pitch":
        return ((orders, "pitch_solve"), (1, "modes"))
    return ((orders, "body_solve"), (1, "modes"))


def _run_up(case: "Case", orders: int) -> Work:
    assert case.isolation is not None
    pitch = case.isolation.model == "pitch"
    return ((orders * _RUN_UP, "pitch_solve" if pitch else "body_solve"),)


def _response(case: "Case", orders: int) -> Work:
    return ((2 * orders, "body_solve"), (1, "modes"))


def _speeds(case: "Case", orders: int) -> Work:
    return ((orders * _RUN_UP, "body_solve"), (1, "modes"))


def _operations(case: "Case", orders: int) -> Work:
    assert case.response is not None
    ways = len(case.response.operations) * max(len(case.response.balances), 1)
    return ((10, "modes"), (orders * ways, "way_order"))


def _switching(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.switching is not None
    change = case.response.switching
    seconds = change.run_down + change.stand + change.run_up + change.after
    return ((math.ceil(seconds * (case.machine.speed or 0.0) / _TURN), "turn_of_change"),)


def _impact(case: "Case", orders: int) -> Work:
    from vibecalc.impact.checks import impact_work  # loads what follows the contacts

    work = impact_work(case)
    return ((0 if work is None else math.ceil(work.total), "contact_step"),)


def _torsion(case: "Case", orders: int) -> Work:
    return ((1, "line"), (orders, "line_order"))


def _torsion_speeds(case: "Case", orders: int) -> Work:
    torsion, freedoms = _line(case)
    assert torsion.speeds is not None and case.machine.shaft_line is not None
    bare = bool(case.machine.shaft_line.dampers)
    lines = 1 + bare + bool(torsion.misfire)
    solved = solves(case, torsion.speeds.points) * freedoms * lines
    return ((1 + bare, "line"), (solved, "line_solve"), (len(torsion.limits), "limit"))


def _closed_forms(case: "Case", orders: int) -> Work:
    return ((1, "closed_forms"),)


def _variable(case: "Case", orders: int) -> Work:
    torsion, _ = _line(case)
    speeds = 0 if torsion.speeds is None else torsion.speeds.points
    return ((5 + speeds, "variable_solve"),)


def _transient(case: "Case", orders: int) -> Work:
    from vibecalc.torsion.stage import least_steps

    return ((math.ceil(least_steps(case)), "time_step"), (6, "line"))


def _reaction(case: "Case", orders: int) -> Work:
    return ((4 * orders, "body_solve"), (2, "modes"), (2 * orders, "order"))


def _damper(case: "Case", orders: int) -> Work:
    options = case.damper_design
    line = case.machine.shaft_line
    assert options is not None and line is not None
    freedoms = len(line.stations) + len(line.dampers)
    rings = 1 + len(options.rings)
    torsion = None if case.response is None else case.response.torsion
    speeds = options.speeds or (None if torsion is None else torsion.speeds)
    points = 100 if speeds is None else speeds.points
    return ((rings, "damper_map"), (rings * orders * points * freedoms, "damper_solve"))


def _roll(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.roll is not None
    options, motor = case.response.roll, case.machine.motor
    dynamic = motor is not None and motor.kind == "dynamic"
    problems = 2 + 1 + 4 * options.interpolations + 2 * options.sensitivity + 2 * dynamic
    marches = len(options.compare) + (options.method not in ("collocation", "fourier"))
    return (
        (problems, "periodic_motor" if dynamic else "periodic"),
        (marches, "march"),
    )


def _start_up(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.start_up is not None
    options, motor = case.response.start_up, case.machine.motor
    speed = (motor.synchronous_speed if motor is not None else None) or 100.0
    turns = math.ceil(options.duration * speed / _TURN)
    return ((turns, "turn_of_start"), (options.angles or 0, "start_angle"))


def _control(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.control is not None
    options = case.response.control
    loops = (len(options.gains) or 1) * (len(options.feedbacks) or 1) + len(options.motor_gains)
    return (
        (2 + options.full_model, "periodic"),
        (loops, "loop"),
        (options.tune is not None, "tuning_loops"),
    )


def _measurement(case: "Case", orders: int) -> Work:
    table = case.measurement
    assert table is not None
    phases = any(reading.phase for reading in table.readings)
    phases = phases or (table.scan is not None and bool(table.scan.phase))
    return ((orders, "least_squares" if phases else "level_motions"),)


def _tuning(case: "Case", orders: int) -> Work:
    options = case.tuning
    assert options is not None
    if case.machine.secondaries:
        return ((1, "several"), (len(options.mistuning) / 3.0, "peak_search"))
    chart = options.chart
    points = 0 if chart is None else len(chart.primary_damping) * chart.mass_ratio.points
    searches = 1.0 + 0.8 * len(options.compare) + len(options.mistuning) / 3.0
    searches += bool(options.sensitivity) + (options.bounds is not None)
    return ((round(searches, 1), "peak_search"), (points, "chart_point"))


def _absorber(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.absorber is not None
    options = case.response.absorber
    swept = options.frequency_ratios or options.frequencies
    vary = options.vary
    curves = 1 if vary is None else 1 + max(len(values) for _, values in vary)
    points = 400 if swept is None else swept.points
    return ((curves * points, "curve_point"), (1 + options.limits, "peaks"))


def _hardware(case: "Case", orders: int) -> Work:
    machine = case.machine
    springs = bool(machine.stock_springs or machine.spring_catalogue)
    oils = bool(machine.stock_oils or machine.oil_catalogue)
    return ((1 + springs if oils else 0, "parts"),)


def _pendulum(case: "Case", orders: int) -> Work:
    given = case.machine.pendulum
    assert given is not None
    return ((1 if given.swings is None else given.swings.points, "swing"),)


def _line(case: "Case") -> tuple["Torsion", int]:
    line = case.machine.shaft_line
    assert line is not None and case.response is not None and case.response.torsion is not None
    return case.response.torsion, len(line.stations) + len(line.dampers)


_RULES: dict[str, Callable[["Case", int], Work]] = {
    "kinematics": lambda case, orders: ((1, "motion"),),
    "excitation": _forces,
    "motor": lambda case, orders: (),
    "pump": _closed_forms,
    "isolation": _isolation,
    "run_up": _run_up,
    "response": _response,
    "speeds": _speeds,
    "operations": _operations,
    "switching": _switching,
    "impact": _impact,
    "torsion": _torsion,
    "torsion_speeds": _torsion_speeds,
    "modal route as published": _closed_forms,
    "variable inertia": _variable,
    "transient": _transient,
    "torque reaction": _reaction,
    "damper design": _damper,
    "roll": _roll,
    "start-up": _start_up,
    "control": _control,
    "measurement": _measurement,
    "tuning": _tuning,
    "absorber": _absorber,
    "hardware": _hardware,
    "pendulum": _pendulum,
}
