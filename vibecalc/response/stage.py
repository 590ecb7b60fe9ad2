"""The stages that [response] asks for."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Entries, Leading, Stage, Subject, Unit, Work, below
from vibecalc.kinematics.stage import orders_given, orders_of_motion, orders_words
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.mount_needs import why_alone
from vibecalc.response.results import (
    KineticEnergy,
    LeftOut,
    ModesOfBody,
    MotionOfBody,
    OverSpeed,
    PotentialEnergy,
)

if TYPE_CHECKING:
    from vibecalc.schema import Case

#: what compares the modes of one machine with each other and with its orders
_OF_ONE_MACHINE = paths_of(ModesOfBody, "nearest_order", "distance", "assurance")


def plan_response(case: "Case") -> Iterator[Stage]:
    """Motion of the body, then what is made from it: operations, run-up, switching."""
    options = case.response
    if options is None:
        return
    if case.machine.body is not None and case.machine.mounts is not None:
        yield _motion(case)
        if options.operations:
            yield _operations(case)
        if options.run_up is not None:
            yield _run_up(case)
        if options.switching is not None:
            yield _switching(case)


def _motion(case: "Case") -> Stage:
    options = case.response
    assert options is not None
    energies = (*paths_of(KineticEnergy), *paths_of(PotentialEnergy)) * options.energies
    quantities = (*paths_of(ModesOfBody), *paths_of(MotionOfBody), *energies)
    return Stage(
        name="response",
        adapter="vibecalc.response.adapters.response:run_response",
        why=f'[response] is in the case, method = "{options.method}"',
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve per order at {case.machine.speed:.6g} rad/s",
        quantities=quantities,
        is_last=not case.point or case.isolation is not None,
        harmonics=orders_of_motion,
        work=_work_of_response,
        topics=("vibecalc.response.accuracy:response_topics",),
        leading=Leading(
            keys=MOUNT_KEYS,
            only=tuple(path for path in quantities if path not in _OF_ONE_MACHINE),
            why_not=why_alone(case),
            most=1024,
        ),
    )


def _operations(case: "Case") -> Stage:
    options = case.response
    assert options is not None
    balances = max(len(options.balances), 1)
    return Stage(
        name="operations",
        adapter="vibecalc.response.adapters.operations:run_operations",
        why="[response] operations are in the case",
        parts=("crank_train", "body", "mounts"),
        orders=orders_words(case),
        cost=f"{len(options.operations)} operations x {balances} balances in one batch",
        quantities=below("response/operations/"),
        is_last=True,
        harmonics=orders_of_motion,
        work=_work_of_operations,
        topics=("vibecalc.response.accuracy:operations_topics",),
        leading=Leading(
            only=below("response/operations/", without=("/peak_low", "/peak_high")),
            why_not=why_alone(case),
            most=256,
        ),
    )


def _run_up(case: "Case") -> Stage:
    options = case.response
    assert options is not None and options.run_up is not None
    first, last = options.run_up.start, options.run_up.stop
    return Stage(
        name="speeds",
        adapter="vibecalc.response.adapters.response:run_speeds",
        why="[response] run_up is in the case",
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve per order at some hundred speeds from {first:.6g} to {last:.6g} rad/s",
        quantities=paths_of(OverSpeed) + paths_of(LeftOut),
        is_last=True,
        harmonics=orders_of_motion,
        work=_work_of_speeds,
        topics=("vibecalc.response.accuracy:speeds_topics",),
    )


def _switching(case: "Case") -> Stage:
    options = case.response
    assert options is not None and options.switching is not None
    there, back = options.switching.between
    return Stage(
        name="switching",
        adapter="vibecalc.response.adapters.switching:run_switching",
        why="[response.switching] is in the case",
        parts=("crank_train", "body", "mounts"),
        orders=orders_words(case),
        cost=f"exact modal motion from {there} to {back} and back, at once and by reversal",
        quantities=below("response/switching/"),
        is_last=True,
        harmonics=orders_of_motion,
        work=_work_of_switching,
        topics=("vibecalc.response.accuracy:switching_topics",),
    )


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------

#: speeds that a run-up takes, refined where its curves bend
_RUN_UP = 300
_TURN = 2.0 * math.pi


def _work_of_response(case: "Case", orders: int) -> Work:
    return ((2 * orders, "body_solve"), (1, "modes"))


def _work_of_speeds(case: "Case", orders: int) -> Work:
    return ((orders * _RUN_UP, "body_solve"), (1, "modes"))


def _work_of_operations(case: "Case", orders: int) -> Work:
    assert case.response is not None
    combinations = len(case.response.operations) * max(len(case.response.balances), 1)
    return ((10, "modes"), (orders * combinations, "way_order"))


def _work_of_switching(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.switching is not None
    change = case.response.switching
    seconds = change.run_down + change.stand + change.run_up + change.after
    return ((math.ceil(seconds * (case.machine.speed or 0.0) / _TURN), "turn_of_change"),)


def names_of(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    response = case.response
    if response is None:
        return {}
    operations = tuple(operation.name for operation in response.operations)
    balances = tuple(balance.name for balance in response.balances)
    names = {"operation": operations, "balance": balances or ("as in the case",)}
    if response.switching is not None:
        there, back = response.switching.between
        names["change"] = (f"{there} to {back}", f"{back} to {there}")
    return names


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    if axis == "speed":
        asked = case.response and case.response.run_up
        return Entries.of_speeds(asked, "response.run_up")
    if axis in ("mode", "other_mode") and path.startswith("response/modes/"):
        return Entries.up_to(6, "a rigid body has 6 degrees of freedom")
    return orders_given(case, axis)


SUBJECT = Subject(
    stages=(plan_response,),
    entries=_entries,
    names=names_of,
    concerns=lambda case: case.response is not None or case.machine.mounts is not None,
    units={
        "ways": Unit(3.0e-3, "ways of running, each a range over the angle of the weights"),
        "way_order": Unit(2.5e-5, "orders combined"),
        "turn_of_change": Unit(9.0e-3, "turns during the change"),
    },
    checks=("vibecalc.response.checks:operation_problems",),
    sections=(
        "vibecalc.response.report:response",
        "vibecalc.response.report:operations",
        "vibecalc.response.report:switching",
    ),
    pictures={
        "energy_by_order": "vibecalc.response.pictures:ENERGY_BY_ORDER",
        "mode_shapes": "vibecalc.isolation.pictures:draw_mode_shapes",
        "operations": "vibecalc.response.pictures:OPERATIONS",
        "response_run_up": "vibecalc.response.pictures:RESPONSE_RUN_UP",
        "switching": "vibecalc.response.pictures:SWITCHING",
    },
)
