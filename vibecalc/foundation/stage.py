"""The stage of a machine on a foundation that moves."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Leading, Stage, Subject, Unit, below
from vibecalc.isolation.stage import efficiency_stage, of_operating_speed, run_up_stage
from vibecalc.kinematics.stage import orders_of_motion, orders_words
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.mount_needs import (
    foundation_kind,
    moves_with_machine,
    run_up_on_foundation,
    why_alone,
)
from vibecalc.response.stage import loads_on

if TYPE_CHECKING:
    from vibecalc.schema import Case


#: frequencies of a transmissibility
_CURVE = 520


def plan_foundation(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [foundation]; the checks have seen to the rest."""
    if case.foundation is None:
        return
    if foundation_kind(case) == "mass":
        yield _of_two_masses(case)
    if moves_with_machine(case):
        yield _of_all_freedoms(case)
        if run_up_on_foundation(case):
            yield from run_up_stage(case)
        yield from efficiency_stage(case)


def _of_two_masses(case: "Case") -> Stage:
    """Machine and foundation as two masses that move up and down."""
    return Stage(
        name="foundation",
        adapter="vibecalc.foundation.adapter:run_foundation",
        why="[foundation] is in the case",
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve of two masses per order at {case.machine.speed:.6g} rad/s",
        quantities=below("foundation/", without=("foundation/coupled/",)),
        is_last=True,
        harmonics=orders_of_motion,
        work=lambda case, orders: ((orders, "two_masses"),),
        topics=("vibecalc.foundation.accuracy:foundation_topics",),
        leading=Leading(
            MOUNT_KEYS
            | {f"foundation.{name}" for name in ("mass", "stiffness", "damping", "loss_factor")},
            why_not=why_alone(case),
        ),
    )


def _of_all_freedoms(case: "Case") -> Stage:
    """The machine in all its motions on a mass, a second body, or a foundation of tables."""
    kind, options, given = foundation_kind(case), case.isolation, case.foundation
    assert given is not None and options is not None
    loads, last = loads_on(case, "isolation"), not (case.point or options.efficiency)
    if kind == "mass":
        return Stage(
            name="machine on foundation",
            adapter="vibecalc.foundation.adapter:run_machine",
            why="[foundation] has a mass",
            parts=loads.parts,
            orders="those that act on the body",
            cost="a solve of 7 x 7 per order",
            quantities=of_operating_speed(case),
            is_last=last and not options.run_up,
            harmonics=loads.harmonics,
            work=lambda case, orders: ((2 * orders, "coupled_solve"),),
            topics=("vibecalc.foundation.accuracy:coupled_topics",),
        )
    body = kind == "body"
    without: tuple[str, ...] = () if body else ("/modes/",)
    if not body and all(one.at != "whole" for one in given.flexibilities or ()):
        without += ("/body/",)
    return Stage(
        name="flexible foundation",
        adapter="vibecalc.foundation.coupled:run_coupled",
        why="[foundation] has a body" if body else "[foundation] has flexibilities",
        parts=loads.parts,
        orders="those that act on the body",
        cost=f"a solve of {'12 x 12' if body else 'the tables'} per order and frequency",
        quantities=below("foundation/coupled/", without=without) + of_operating_speed(case),
        is_last=last and not (body and options.run_up),
        harmonics=loads.harmonics,
        work=lambda case, orders: ((2 * orders + 6 * _CURVE, "coupled_solve"),),
        topics=("vibecalc.foundation.accuracy:coupled_topics",),
    )


SUBJECT = Subject(
    stages=(plan_foundation,),
    concerns=lambda case: case.foundation is not None,
    units={
        "two_masses": Unit(1.0e-5, "solves of two masses"),
        "coupled_solve": Unit(5.0e-5, "solves of machine and foundation"),
    },
    last_checks=("vibecalc.foundation.model:coupled_problems",),
    cautions=("vibecalc.foundation.model:foundation_cautions",),
    sections=(
        "vibecalc.foundation.report:foundation",
        "vibecalc.foundation.coupled_report:coupled",
    ),
    pictures={"foundation": "vibecalc.foundation.coupled_report:FOUNDATION"},
    assumes=(
        "The foundation is a mass, a rigid body or given by impedance tables; transfer "
        "between its feet is left out.",
    ),
)
