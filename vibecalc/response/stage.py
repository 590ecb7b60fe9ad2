"""The stages that [response] asks for."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Entries, Harmonics, Leading, Stage, Subject, Unit, below
from vibecalc.errors import in_rpm
from vibecalc.excitation.stage import USUAL_ORDERS
from vibecalc.kinematics.stage import orders_given, orders_of_motion, orders_words
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.firing import TURN, cycle_angle, is_separate, moves_body, with_torque
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

# ----------------------------------------------------------------------------
# What acts on a body: how many orders, and what is read for them.
# ----------------------------------------------------------------------------


class Loads(NamedTuple):
    """Of the stages of a table: parts read, orders in words and as a count, more for the reason."""

    parts: tuple[str, ...]
    words: str
    harmonics: Callable[["Case"], Harmonics]
    why: str


def loads_on(case: "Case", table: str) -> Loads:
    """What acts on the body of a table, [isolation] or [response]."""
    if table not in with_torque(case):
        return Loads(("body", "mounts"), orders_words(case), orders_of_motion, "")
    line = case.machine.shaft_line is not None and not is_separate(case)
    return Loads(
        ("body", "mounts", "crank_train", *(("shaft_line",) * line)),
        "half ones of four strokes, else whole ones, and as many again for the error",
        orders_of_reaction,
        ", with the torque of the cylinders",
    )


def entries_of_loads(case: "Case", axis: str, table: str) -> Entries | None:
    """Speeds of a run-up; these orders, where the case and not the tolerance says how many."""
    if axis == "speed":
        options = getattr(case, table)
        return Entries.of_speeds(options and options.run_up, f"{table}.run_up")
    if axis != "order" or table not in with_torque(case):
        return orders_given(case, axis)
    found = orders_of_reaction(case)
    return Entries(tuple(found.lowest * i for i in range(1, found.number + 1)), found.rule)


def orders_of_reaction(case: "Case") -> Harmonics:
    """Half orders of a torque reaction; as many again are solved for the error."""
    step = TURN / cycle_angle(case.machine)
    torsion = None if case.response is None else case.response.torsion
    given = None if torsion is None else torsion.orders
    said = 0.0
    if given is not None:
        said = given.highest or (given.count or 0) * (given.step or step)
    orders = None if case.excitation is None else case.excitation.orders
    usual = USUAL_ORDERS if orders is None and not said else 0
    shaking = orders_of_motion(case).number
    highest = max(said, shaking, usual)
    rule = "[response.torsion] orders" if highest == said else "of the shaking"
    count = math.ceil(highest / step)
    rule = "the usual ones" if highest == usual else rule
    return Harmonics(count, step, count * step, f"{rule}; as many again for the error")


# ----------------------------------------------------------------------------
# The stages.
# ----------------------------------------------------------------------------

#: what compares the modes of one machine with each other and with its orders
_OF_ONE_MACHINE = paths_of(ModesOfBody, "nearest_order", "distance", "assurance")
#: speeds that a run-up takes, refined where its curves bend
_RUN_UP = 300


def plan_response(case: "Case") -> Iterator[Stage]:
    """Motion of the body, then what is made from it: operations, run-up, switching."""
    options = case.response
    if options is None or not moves_body(case):
        return
    loads, torque = loads_on(case, "response"), "response" in with_torque(case)
    parts = ("body", "mounts")
    stage = partial(Stage, orders=orders_words(case), is_last=True, harmonics=orders_of_motion)
    of_all = partial(stage, orders=loads.words, parts=loads.parts, harmonics=loads.harmonics)
    energies = (*paths_of(KineticEnergy), *paths_of(PotentialEnergy)) * options.energies
    quantities = (*paths_of(ModesOfBody), *paths_of(MotionOfBody), *energies)
    yield of_all(
        name="response",
        adapter="vibecalc.response.adapters.response:run_response",
        why=f'[response] is in the case, method = "{options.method}"' + loads.why,
        cost=f"one solve per order at {in_rpm(case.machine.speed)}",
        quantities=quantities,
        is_last=not case.point or case.isolation is not None,
        work=lambda _, number: ((2 * number, "body_solve"), (1, "modes")),
        topics=("vibecalc.response.accuracy:response_topics",),
        leading=Leading(
            keys=MOUNT_KEYS,
            takes_all=not torque,
            only=tuple(path for path in quantities if path not in _OF_ONE_MACHINE),
            why_not=why_alone(case),
            most=1024,
        ),
    )
    if options.operations:
        count, balances = len(options.operations), max(len(options.balances), 1)
        yield stage(
            name="operations",
            adapter="vibecalc.response.adapters.operations:run_operations",
            why="[response] operations are in the case",
            parts=("crank_train", *parts),
            cost=f"{count} operations x {balances} balances in one batch",
            quantities=below("response/operations/"),
            work=lambda _, number: ((10, "modes"), (number * count * balances, "way_order")),
            topics=("vibecalc.response.accuracy:operations_topics",),
            leading=Leading(
                only=below("response/operations/", without=("/peak_low", "/peak_high")),
                why_not=why_alone(case),
                most=256,
            ),
        )
    if options.run_up is not None:
        first, last = options.run_up.start, options.run_up.stop
        yield of_all(
            name="speeds",
            adapter="vibecalc.response.adapters.response:run_speeds",
            why="[response] run_up is in the case" + loads.why,
            cost="one solve per order at some hundred speeds from "
            f"{in_rpm(first)} to {in_rpm(last)}",
            quantities=paths_of(OverSpeed) + paths_of(LeftOut),
            work=lambda _, number: ((number * _RUN_UP, "body_solve"), (1, "modes")),
        )
    if options.switching is not None:
        change = options.switching
        there, back = change.between
        seconds = change.run_down + change.stand + change.run_up + change.after
        turns = math.ceil(seconds * (case.machine.speed or 0.0) / (2.0 * math.pi))
        yield stage(
            name="switching",
            adapter="vibecalc.response.adapters.switching:run_switching",
            why="[response.switching] is in the case",
            parts=("crank_train", *parts),
            cost=f"exact modal motion from {there} to {back} and back, at once and by reversal",
            quantities=below("response/switching/"),
            work=lambda _, number: ((turns, "turn_of_change"),),
            topics=("vibecalc.response.accuracy:switching_topics",),
        )


def names_of(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
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
    if axis in ("mode", "other_mode") and path.startswith("response/modes/"):
        return Entries.up_to(6, "a rigid body has 6 degrees of freedom")
    return entries_of_loads(case, axis, "response")


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
    assumes=(
        "The body moves linearly in six degrees of freedom; a change of operation "
        "follows a given course of speed.",
    ),
)
