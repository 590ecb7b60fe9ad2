"""What each stage of a case will take, read from the case alone: harmonics and counted work."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.run.stage import StagePlan
from vibecalc.parts.firing import TURN, cycle_angle, shakes_with_torque, torque_reaches_mounts
from vibecalc.torsion.stage import asked_orders, solves

if TYPE_CHECKING:
    from vibecalc.schema import Case
    from vibecalc.torsion.tables import Torsion

# ----------------------------------------------------------------------------
# How many harmonics each stage will compute and what fixes that number: nothing is solved.
#
# The series of a slider-crank falls off geometrically, so that its length follows from R/L and the
# tolerance alone; all else stands in the case.
# ----------------------------------------------------------------------------

#: highest order of a torque reaction where the case says none
_REACTION = 24


class Harmonics(NamedTuple):
    """Orders lowest, lowest + step .. highest, `number` of them, and the rule that fixed them.

    `is_least`: the stage goes on to more where the tolerance is not met with these.
    """

    number: int
    lowest: float
    highest: float
    rule: str
    is_least: bool = False

    def words(self) -> str:
        """`12: 0.5 to 6 by 0.5 (the case asks)`."""
        if self.number <= 1:
            return f"{self.number}: {self.highest:g} ({self.rule})"
        step = (self.highest - self.lowest) / (self.number - 1)
        by = "" if step == 1.0 else f" by {step:.6g}"
        at_least = "at least " if self.is_least else ""
        return f"{at_least}{self.number}: {self.lowest:g} to {self.highest:g}{by} ({self.rule})"


def harmonics_of(case: "Case", stage: StagePlan) -> Harmonics | None:
    """Harmonics that a stage of `case` will compute; None for a stage without any.

    Raises NumericalFailure where no number of harmonics meets the tolerance, as the run will.
    """
    rule = _HARMONICS.get(stage.stage)
    return None if rule is None else rule(case)


def _series(case: "Case") -> Harmonics:
    """Orders of the piston motion, and so of all forces that come from it."""
    train, options = case.machine.crank_train, case.excitation
    if options is not None and options.orders is not None:
        return _first(options.orders, "[excitation] orders")
    if case.kinematics is not None and case.kinematics.series == "truncated":
        terms = case.kinematics.terms or 1
        enough = (4 if shakes_with_torque(case) else 2) * terms
        rule = "all of the truncated series"
    else:
        from vibecalc.kinematics.harmonics import order_for_tolerance

        ratio = train.crank_radius / train.rod_length
        offset = (train.wrist_pin_offset or 0.0) / train.crank_radius
        enough = order_for_tolerance(ratio, case.accuracy.rtol, offset)
        rule = f"R/L = {ratio:.4g}, the rest below rtol = {case.accuracy.rtol:g}"
    turning = max((abs(shaft.speed_ratio) for shaft in train.balance_shafts), default=1)
    if turning > enough:
        return _first(turning, "the fastest balance shaft")
    return _first(max(enough, 1), rule)


def _half_orders(case: "Case") -> Harmonics:
    highest, step = asked_orders(case)
    given = (
        None
        if case.response is None or case.response.torsion is None
        else (case.response.torsion.orders)
    )
    rule = "the usual ones" if given is None else "[response.torsion] orders"
    return Harmonics(round(highest / step), step, highest, rule)


def _orders_of_reaction(case: "Case") -> Harmonics:
    """Half orders of a torque reaction; as many again are solved for the error."""
    step = TURN / cycle_angle(case.machine)
    torsion = None if case.response is None else case.response.torsion
    given = None if torsion is None else torsion.orders
    said = 0.0
    if given is not None:
        said = given.highest or (given.count or 0) * (given.step or step)
    own = None if case.excitation is None else case.excitation.orders
    usual = _REACTION if own is None and not said else 0
    shaking = _series(case).number
    highest = max(said, shaking, usual)
    rule = "[response.torsion] orders" if highest == said else "of the shaking"
    count = math.ceil(highest / step)
    rule = "the usual ones" if highest == usual else rule
    return Harmonics(count, step, count * step, f"{rule}; as many again for the error")


def _pump(case: "Case") -> Harmonics:
    """Orders of the torque of a liquid."""
    own = None if case.excitation is None else case.excitation.orders
    return _first(own or _REACTION, "[excitation] orders" if own else "the usual ones")


def _motor(case: "Case") -> Harmonics:
    motor = case.machine.motor
    assert motor is not None
    orders = [order for order in motor.torque.order if order]  # the mean is no harmonic
    return Harmonics(len(orders), min(orders), max(orders), "those of its torque")


def _orders_of_impact(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.impact is not None
    return _first(case.response.impact.orders, "[response.impact] orders, of the joint force")


def _orders_of_roll(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.roll is not None
    return _first(case.response.roll.orders, "[response.roll] orders, of the steady motion")


def _orders_of_control(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.control is not None
    return _first(case.response.control.orders, "[response.control] orders")


def _measured(case: "Case") -> Harmonics:
    assert case.measurement is not None
    orders = case.measurement.orders
    return Harmonics(len(orders), min(orders), max(orders), "[measurement] orders")


def _orders_of_pendulum(case: "Case") -> Harmonics:
    assert case.machine.pendulum is not None
    order = case.machine.pendulum.order
    return Harmonics(1, order, order, "of the speed of the rotor")


def _orders_of_variable(case: "Case") -> Harmonics:
    """The motion has more orders than its excitation; so many are tried first."""
    found = _half_orders(case)
    return found._replace(is_least=True, rule="of the excitation; more of the motion")


def _first(number: int, rule: str) -> Harmonics:
    return Harmonics(number, 1, number, rule)


_HARMONICS: dict[str, Callable[["Case"], Harmonics]] = {
    **dict.fromkeys(("kinematics", "excitation", "isolation"), _series),
    "run_up": lambda case: (_orders_of_reaction if torque_reaches_mounts(case) else _series)(case),
    **dict.fromkeys(("response", "operations", "speeds", "switching"), _series),
    **dict.fromkeys(("torsion", "torsion_speeds", "transient", "damper design"), _half_orders),
    "modal route as published": _half_orders,
    "variable inertia": _orders_of_variable,
    "torque reaction": _orders_of_reaction,
    "motor": _motor,
    "pump": _pump,
    "impact": _orders_of_impact,
    "roll": _orders_of_roll,
    "control": _orders_of_control,
    "measurement": _measured,
    "pendulum": _orders_of_pendulum,
}

# ----------------------------------------------------------------------------
# Counted work of each stage, read from the case: solves, orders, turns, searches.
# ----------------------------------------------------------------------------

#: (how many, name of the unit of work)
Work = tuple[tuple[float, str], ...]
#: speeds that a run-up takes, refined where its curves bend
_RUN_UP = 300
_TURN = 2.0 * math.pi


def work_of(case: "Case", stage: StagePlan) -> Work:
    """The work of one stage; entries of zero are left out."""
    found = harmonics_of(case, stage)
    rule = _WORK.get(stage.stage)
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


_WORK: dict[str, Callable[["Case", int], Work]] = {
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
