"""Checks of form of what is asked of the roll of a machine."""

from collections.abc import Iterator

from vibecalc.core.case.raw import Data, table_at, tables_at
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import FINDING_MOTORS, ROLL, motor_kind

RESPONSE: KeyPath = ("response",)
MACHINE: KeyPath = ("machine",)
TRAIN: KeyPath = ("machine", "crank_train")
#: key of [response.roll] -> methods that it belongs to
_OF_METHODS = {"points": ("collocation", "fourier")}
#: methods that need `step`; for the others it is without effect, which is a caution
STEPPING = ("euler", "rk4")


def check_roll(data: Data) -> Iterator[Problem]:
    """Yield the problems of [response.roll], [response.start_up] and [response.control]."""
    response = table_at(data, "response")
    asked = [name for name in ROLL if isinstance(response.get(name), dict)]
    if not asked:
        return
    if isinstance(data.get("machine"), dict):
        yield from _parts(data, asked)
        yield from _gas(data, (*RESPONSE, asked[0]))
    if "roll" in asked:
        yield from _methods(response["roll"])
    if "start_up" in asked:
        yield from _start_up(response["start_up"])
    if "control" in asked:
        yield from _control(response["control"])


def _parts(data: Data, asked: list[str]) -> Iterator[Problem]:
    machine, path = data["machine"], (*RESPONSE, asked[0])
    listed = " and ".join(f"[response.{name}]" for name in asked)
    needs = "needs" if len(asked) == 1 else "need"
    for part, what in (
        ("rotor", "the inertia of all that turns with the crankshaft"),
        ("shell", "the inertia of what the motor's stator and the cylinders are fixed to"),
    ):
        if part not in machine:
            yield Problem(
                path=path, message=f"{listed} {needs} [machine.{part}]", allowed=f"inertia: {what}"
            )
    motor, kinds = motor_kind(machine), ", ".join(map(repr, FINDING_MOTORS))
    if motor not in FINDING_MOTORS:
        yield Problem(
            path=path,
            message=f"{listed} {needs} a motor that finds the speed",
            found=f"a motor of kind {motor!r}" if motor else "no motor",
            allowed=f"[machine.motor] of kind {kinds}",
            also=(*MACHINE, "motor") if motor else None,
        )
    placed = [part for part in ("body", "mounts") if part in machine]
    if placed:
        yield Problem(
            path=(*MACHINE, placed[0]),
            message=f"{listed} {needs} no [machine.{placed[0]}]: there the shell turns about the "
            "crank axis, as one body",
            allowed="[machine.shell], with stiffness and damping of its mounts",
            hint="the body on its mounts moves in six freedoms at a given speed: a case of its own",
            also=path,
        )


def _gas(data: Data, path: KeyPath) -> Iterator[Problem]:
    """Pressure is a force with a bore only; cylinders with forces of their own need neither."""
    train = table_at(data, *TRAIN)
    cylinders = tables_at(data, "machine", "crank_train", "cylinders")
    if all("gas_force" in cylinder for _, cylinder in cylinders):
        return
    for one, other in (("bore", "gas_pressure"), ("gas_pressure", "bore")):
        if one in train and other not in train:
            yield Problem(
                path=(*TRAIN, one),
                message=f"[{'.'.join(map(str, path))}] cannot use {one} without {other}: the gas "
                "force is pressure times area",
                allowed=f"{other} beside it, or a gas_force for each cylinder",
            )


def _methods(roll: Data) -> Iterator[Problem]:
    """Points go with some methods only, and some methods need a step."""
    path: KeyPath = (*RESPONSE, "roll")
    compared = roll.get("compare")
    others = [one for one in compared if isinstance(one, str)] if isinstance(compared, list) else []
    method = roll.get("method", "collocation")
    for place, name in enumerate(others):
        if name in others[:place]:
            yield Problem(
                path=(*path, "compare", place),
                message=f"method {name!r} stands twice",
                allowed="each method once",
                also=(*path, "compare", others.index(name)),
            )
    methods = [method, *others]
    for key, fitting in _OF_METHODS.items():
        if key in roll and not any(name in fitting for name in methods):
            yield Problem(
                path=(*path, key),
                message=f"{key} is for the methods {' and '.join(fitting)}",
                found=f"method = {method!r}",
                allowed=f"no {key}, or one of these methods",
                also=(*path, "method") if "method" in roll else None,
            )
    fixed = next((name for name in methods if name in STEPPING), None)
    if fixed is not None and "step" not in roll:
        yield Problem(
            path=path,
            message=f"the method {fixed!r} needs its step",
            allowed="step = '0.1 ms', for example",
        )


def _start_up(start_up: Data) -> Iterator[Problem]:
    if "start_within" in start_up and "angles" not in start_up:
        yield Problem(
            path=(*RESPONSE, "start_up", "start_within"),
            message="start_within is for starts from many angles, and no angles are asked for",
            allowed="angles = 24, for example, or no start_within",
        )


def _control(control: Data) -> Iterator[Problem]:
    path: KeyPath = (*RESPONSE, "control")
    if "speed_feedback" in control and "target_speed" in control:
        yield Problem(
            path=(*path, "target_speed"),
            message="target_speed and speed_feedback exclude each other: one follows from the "
            "other",
            allowed="one of the two, or neither",
            also=(*path, "speed_feedback"),
        )
