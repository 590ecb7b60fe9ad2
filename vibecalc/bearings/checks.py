"""What bearing loads cannot be computed of."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.excitation.gas_tables import within_cards
from vibecalc.kinds import TRAIN
from vibecalc.parts import tables as parts
from vibecalc.parts.body import DIRECTIONS, build_frame
from vibecalc.parts.firing import TURN, cycle_angle, has_gas
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.bearings.tables import BearingLoads


def bearing_problems(case: Case) -> Iterator[Problem]:
    """Problems of [bearing_loads]: of gas, firing, forces along the shaft, speeds of cards."""
    table = case.bearing_loads
    if table is not None:
        yield from _gas(case)
        if case.machine.crank_train.axis != case.machine.crank_train.stroke:
            yield from _shaft_loads(table, case.machine.crank_train)
            yield from _weights(case, table)
        yield from _speeds(case, table)


def _gas(case: Case) -> Iterator[Problem]:
    train, machine = case.machine.crank_train, case.machine
    fires = (
        bool(train.firing_order)
        or all(cylinder.firing_angle is not None for cylinder in train.cylinders)
        or len(train.cylinders) == 1
        or cycle_angle(machine) == TURN
    )
    if train.tangential_effort is not None:
        yield Problem(
            path=("bearing_loads",),
            message="bearings bear the whole force of the rod, and tangential_effort has only "
            "its torque",
            allowed="gas_pressure, gas_cards or gas_cycle in [machine.crank_train]",
            also=(*TRAIN, "tangential_effort"),
        )
    elif train.gas_pressure is not None and train.bore is None:
        yield Problem(
            path=(*TRAIN, "gas_pressure"),
            message="[bearing_loads] cannot use gas_pressure without bore: the gas force is "
            "pressure times area",
            allowed="bore with it, or neither for the loads of inertia alone",
        )
    elif has_gas(case) and not fires:
        yield Problem(
            path=TRAIN,
            message="[machine.crank_train] does not say when its cylinders fire",
            allowed="firing_order = ['1', '3', '4', '2'], or a firing_angle for every cylinder",
            hint="[bearing_loads] puts the gas pressure of each cylinder where it fires",
            also=("bearing_loads",),
        )


def _shaft_loads(table: "BearingLoads", train: parts.CrankTrain) -> Iterator[Problem]:
    axis = build_frame(train.axis, train.stroke).axis
    for place, load in enumerate(table.shaft_loads):
        along = 0.0 if load.force is None else float(np.asarray(load.force) @ axis)
        if along != 0.0:
            yield Problem(
                path=("bearing_loads", "shaft_loads", place, "force"),
                message="a force along the shaft is borne by no main bearing",
                found=f"{along:.6g} N along {train.axis}",
                allowed=f"none along {train.axis}, the axis of the crankshaft",
            )


def _weights(case: Case, table: "BearingLoads") -> Iterator[Problem]:
    """Weights act as those of the body on its mounts do, and not along the shaft."""
    isolation, axis = case.isolation, case.machine.crank_train.axis
    if isolation is not None and table.up is not None and table.up != isolation.up:
        yield Problem(
            path=("bearing_loads", "up"),
            message="weights act against one direction, and [isolation] has another one",
            found=f"up = {table.up!r}, and up = {isolation.up!r} in [isolation]",
            allowed=f"{isolation.up!r}, or no such key",
            also=("isolation", "up") if "up" in isolation.model_fields_set else ("isolation",),
        )
        return
    weights = any(load.mass is not None for load in table.shaft_loads)
    up = isolation.up if isolation is not None and weights else table.up
    if up is not None and up.strip("-") == axis:
        others = ", ".join(repr(name) for name in DIRECTIONS if name != axis)
        yield Problem(
            path=("isolation" if table.up is None else "bearing_loads", "up"),
            message="weights along the shaft are borne by no main bearing",
            found=f"up = {up!r}",
            allowed=others + (", or one of these with a minus" if isolation is None else ""),
            also=("bearing_loads", "shaft_loads") if table.up is None else None,
        )


def _speeds(case: Case, table: "BearingLoads") -> Iterator[Problem]:
    known = [card.speed for card in case.machine.crank_train.gas_cards]
    asked: dict[KeyPath, float] = {}
    if table.speeds is not None:
        asked = {
            ("bearing_loads", "speeds", "from"): table.speeds.start,
            ("bearing_loads", "speeds", "to"): table.speeds.stop,
        }
    asked["machine", "speed"] = case.machine.speed
    for path, speed in asked.items():
        if len(known) > 1 and not within_cards((min(known), max(known)), speed):
            low, high = (one * 30.0 / np.pi for one in (min(known), max(known)))
            yield Problem(
                path=path,
                message="a speed beyond those of the gas cards: nothing is extrapolated",
                found=f"{speed * 30.0 / np.pi:.6g} rpm",
                allowed=f"{low:.6g} to {high:.6g} rpm",
                also=(*TRAIN, "gas_cards"),
            )


def bearing_cautions(case: Case) -> list[str]:
    """What other tables of the case have and bearing loads leave out."""
    if case.bearing_loads is None:
        return []
    response = case.response
    texts = {
        "[bearing_loads] follow joints without play: the impacts of [machine.joints] are not in "
        "them": case.machine.joints is not None,
        "[bearing_loads] hold for the cylinders that work in [excitation] at a steady speed: other "
        "operations and the changes between them are not in them": (
            response is not None and bool(response.operations)
        ),
    }
    return [text for text, holds in texts.items() if holds]
