"""How many harmonics each stage will compute and what fixes that number: nothing is solved.

The series of a slider-crank falls off geometrically, so that its length follows from R/L and the
tolerance alone; all else stands in the case.
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.parts.firing import TURN, cycle_angle, shakes_with_torque, torque_reaches_mounts
from vibecalc.pipeline.stage_plan import StagePlan
from vibecalc.torsion.stage import asked_orders

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

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
    rule = _RULES.get(stage.stage)
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


def _reaction(case: "Case") -> Harmonics:
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


def _impact(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.impact is not None
    return _first(case.response.impact.orders, "[response.impact] orders, of the joint force")


def _roll(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.roll is not None
    return _first(case.response.roll.orders, "[response.roll] orders, of the steady motion")


def _control(case: "Case") -> Harmonics:
    assert case.response is not None and case.response.control is not None
    return _first(case.response.control.orders, "[response.control] orders")


def _measured(case: "Case") -> Harmonics:
    assert case.measurement is not None
    orders = case.measurement.orders
    return Harmonics(len(orders), min(orders), max(orders), "[measurement] orders")


def _pendulum(case: "Case") -> Harmonics:
    assert case.machine.pendulum is not None
    order = case.machine.pendulum.order
    return Harmonics(1, order, order, "of the speed of the rotor")


def _variable(case: "Case") -> Harmonics:
    """The motion has more orders than its excitation; so many are tried first."""
    found = _half_orders(case)
    return found._replace(is_least=True, rule="of the excitation; more of the motion")


def _first(number: int, rule: str) -> Harmonics:
    return Harmonics(number, 1, number, rule)


_RULES: dict[str, Callable[["Case"], Harmonics]] = {
    **dict.fromkeys(("kinematics", "excitation", "isolation"), _series),
    "run_up": lambda case: (_reaction if torque_reaches_mounts(case) else _series)(case),
    **dict.fromkeys(("response", "operations", "speeds", "switching"), _series),
    **dict.fromkeys(("torsion", "torsion_speeds", "transient", "damper design"), _half_orders),
    "modal route as published": _half_orders,
    "variable inertia": _variable,
    "torque reaction": _reaction,
    "motor": _motor,
    "pump": _pump,
    "impact": _impact,
    "roll": _roll,
    "control": _control,
    "measurement": _measured,
    "pendulum": _pendulum,
}
