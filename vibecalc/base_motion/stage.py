"""The stage of a machine whose base moves."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Stage, Subject, Unit, below

if TYPE_CHECKING:
    from vibecalc.schema import Case

#: frequencies of a transmissibility; of the integrals over a spectrum
_CURVE, _INTEGRAL = 380, 6000


def plan_base_motion(case: "Case") -> Iterator[Stage]:
    """Planned where the case has [base_motion]."""
    given = case.base_motion
    if given is None:
        return
    without = ("/harmonic/",) * (not given.harmonics) + ("/spectrum/",) * (not given.spectra)
    if case.foundation is None:
        without += ("/foundation_",)
    if not case.point:
        without += ("/point_",)
    work = 6 * _CURVE + len(given.harmonics) + _INTEGRAL * bool(given.spectra)
    yield Stage(
        name="base motion",
        adapter="vibecalc.base_motion.adapter:run_base_motion",
        why="[base_motion] is in the case",
        parts=("body", "mounts"),
        orders="",
        cost=f"harmonics of the base: {len(given.harmonics)}, spectra: {len(given.spectra)}",
        quantities=below("base_motion/", without=without),
        is_last=True,
        work=lambda _, orders: ((work, "base_solve"),),
        topics=("vibecalc.base_motion.accuracy:base_topics",),
    )


def _names(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
    given = case.base_motion
    return {} if given is None else {"base_harmonic": tuple(one.name for one in given.harmonics)}


SUBJECT = Subject(
    stages=(plan_base_motion,),
    concerns=lambda case: case.base_motion is not None,
    units={"base_solve": Unit(2.5e-5, "solves of a machine on a base that moves")},
    names=_names,
    last_checks=("vibecalc.base_motion.model:base_motion_problems",),
    sections=("vibecalc.base_motion.report:base_motion",),
    pictures={
        "base_transmissibility": "vibecalc.base_motion.report:TRANSMISSIBILITY",
        "base_spectrum": "vibecalc.base_motion.report:DENSITY",
    },
    assumes=(
        "The base moves as a rigid body; random spectra of different directions are uncorrelated.",
    ),
)
