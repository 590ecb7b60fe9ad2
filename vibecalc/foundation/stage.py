"""The stage of a machine on a foundation that moves."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Leading, Stage, Subject, Unit, Work, below
from vibecalc.errors import Problem
from vibecalc.kinematics.stage import orders_of_motion, orders_words
from vibecalc.parts.array_keys import MOUNT_KEYS
from vibecalc.parts.mount_needs import why_alone

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_foundation(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [foundation]; the checks have seen to the rest."""
    if case.foundation is None:
        return
    yield Stage(
        name="foundation",
        adapter="vibecalc.foundation.adapter:run_foundation",
        why="[foundation] is in the case",
        parts=("body", "mounts"),
        orders=orders_words(case),
        cost=f"one solve of two masses per order at {case.machine.speed:.6g} rad/s",
        quantities=below("foundation/"),
        is_last=True,
        harmonics=orders_of_motion,
        work=_work,
        topics=("vibecalc.foundation.accuracy:foundation_topics",),
        leading=Leading(
            MOUNT_KEYS
            | {f"foundation.{name}" for name in ("mass", "stiffness", "damping", "loss_factor")},
            why_not=why_alone(case),
        ),
    )


def _work(case: "Case", orders: int) -> Work:
    return ((orders, "two_masses"),)


def foundation_problems(case: "Case") -> list[Problem]:
    """Problems of what [foundation] needs."""
    if case.isolation is None:
        return [
            Problem(
                path=("foundation",),
                message="[foundation] is what the mounts stand on: it needs [isolation]",
                allowed='[isolation] with model = "pitch", "rigid_body" or "planar"',
            )
        ]
    body, mounts = case.machine.body, case.machine.mounts
    built = body is not None and body.mass_matrix is None
    if built and mounts is not None and mounts.stiffness_matrix is None:
        return []
    return [
        Problem(
            path=("foundation",),
            message="[foundation] needs the mass of the body and its mounts one by one",
            allowed="mass of [machine.body] and stiffness of [machine.mounts], no matrices",
        )
    ]


SUBJECT = Subject(
    stages=(plan_foundation,),
    concerns=lambda case: case.foundation is not None,
    units={"two_masses": Unit(1.0e-5, "solves of two masses")},
    checks=("vibecalc.foundation.stage:foundation_problems",),
    sections=("vibecalc.foundation.report:foundation",),
)
