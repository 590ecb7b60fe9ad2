"""Can a controller of the motor do what is asked of it?"""

from collections.abc import Iterator

from vibecalc.case.control_tables import Control
from vibecalc.case.kinds import finds_speed
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem

CONTROL: KeyPath = ("response", "control")


def control_problems(case: Case) -> list[Problem]:
    """Problems of target speed, lists of gains, and bounds of the tuning."""
    control = None if case.response is None else case.response.control
    if control is None or not finds_speed(case.machine):
        return []
    found = [*_target(case, control), *_lists(control), *_tune(control)]
    return [*found, *_full_model(case, control)]


def _target(case: Case, control: Control) -> Iterator[Problem]:
    """The loop runs slower than gain times reference, unless speed were fed back positively."""
    motor, target = case.machine.motor, control.target_speed
    if target is None or motor is None:
        return
    reference = motor.synchronous_speed if control.reference is None else control.reference
    smallest = min((control.gain, *(gain for gain in control.gains if gain > 0.0)))
    if target >= smallest * reference:
        yield Problem(
            path=(*CONTROL, "target_speed"),
            message="the machine cannot reach the target speed: a loaded motor runs below gain "
            "times reference",
            found=f"{target:.6g} rad/s, with a gain of {smallest:.6g} and a reference of "
            f"{reference:.6g} rad/s",
            allowed=f"< {smallest * reference:.6g} rad/s",
            also=(*CONTROL, "reference") if control.reference is not None else None,
        )


def _full_model(case: Case, control: Control) -> Iterator[Problem]:
    """The full model has a state for the lag of the actuator, and none for a delay."""
    motor = case.machine.motor
    if not control.full_model or motor is None:
        return
    if control.delay > 0.0:
        yield Problem(
            path=(*CONTROL, "full_model"),
            message="the full model of the closed loop has no delay, only a lag of the actuator: "
            "leave a delay to the reduced model",
            found=f"delay = {control.delay:.6g} s",
            allowed="full_model = false (stability and levels of the reduced model count the "
            "delay), or delay = 0 with actuator_lag longer by as much",
            also=(*CONTROL, "delay"),
        )
    if motor.kind == "dynamic":
        yield Problem(
            path=(*CONTROL, "full_model"),
            message="the full model of the closed loop has no transients of the motor's fluxes",
            found="a motor of kind 'dynamic'",
            allowed="full_model = false, or machine.motor.kind = 'slip_table'",
            also=("machine", "motor", "kind"),
        )


def _lists(control: Control) -> Iterator[Problem]:
    for key, positive in (("motor_gains", True), ("gains", True), ("feedbacks", False)):
        values: tuple[float, ...] = getattr(control, key)
        for place, value in enumerate(values):
            if positive and value <= 0.0:
                yield Problem(
                    path=(*CONTROL, key, place),
                    message=f"{key}[{place}] has to be above zero",
                    found=f"{value:.6g}",
                    allowed="> 0: another sign drives the speed away from its reference",
                )
            elif value in values[:place]:
                yield Problem(
                    path=(*CONTROL, key, place),
                    message=f"a value of {key} stands twice",
                    found=f"{value:.6g}",
                    allowed="each once",
                    also=(*CONTROL, key, values.index(value)),
                )


def _tune(control: Control) -> Iterator[Problem]:
    tune = control.tune
    if tune is None:
        return
    for key, pair in (("gain", tune.gain), ("acceleration_feedback", tune.acceleration_feedback)):
        if not pair.lower < pair.upper:
            yield Problem(
                path=(*CONTROL, "tune", key, "lower"),
                message=f"the lower bound of {key} has to be below the upper one",
                found=f"{pair.lower:.6g} and {pair.upper:.6g}",
                allowed="lower < upper",
                also=(*CONTROL, "tune", key, "upper"),
            )
    for place, order in enumerate(tune.orders):
        if order in tune.orders[:place]:
            yield Problem(
                path=(*CONTROL, "tune", "orders", place),
                message=f"order {order} stands twice",
                allowed="each order once",
                also=(*CONTROL, "tune", "orders", tune.orders.index(order)),
            )
