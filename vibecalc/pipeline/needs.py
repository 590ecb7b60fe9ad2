"""What a run of a case will take: stages, harmonics, counted work, time and memory.

Everything is read from the case; nothing is computed and no solver imported.
"""

from typing import TYPE_CHECKING, NamedTuple

from vibecalc.pipeline.needs_orders import Harmonics, harmonics_of
from vibecalc.pipeline.needs_units import COMMAND, LIBRARIES, SETTING_UP, UNITS
from vibecalc.pipeline.needs_work import Work, work_of
from vibecalc.pipeline.plan import plan_case
from vibecalc.pipeline.stage_plan import StagePlan

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: MB for each solve times freedom kept as a curve; of a damper's map and a motor's currents
_CURVE_MB, _MAP_MB, _MOTOR_MB = 3.0e-5, 50.0, 80.0


class StageNeeds(NamedTuple):
    """What one stage takes.

    `seconds` is the estimate for one thread, imports included; `megabytes` what the stage holds.
    """

    plan: StagePlan
    harmonics: Harmonics | None
    work: Work
    seconds: float
    megabytes: float


class Needs(NamedTuple):
    """What a run takes: each stage, then all of it."""

    stages: tuple[StageNeeds, ...]
    seconds: float
    megabytes: float


def needs_of(case: "Case") -> Needs:
    """What a run of `case` takes, without the searches of a study."""
    loaded: set[str] = set()
    stages = []
    for plan in plan_case(case):
        work = work_of(case, plan)
        fresh = libraries_of(work) - loaded
        loaded |= fresh
        importing = max((LIBRARIES[name][0] for name in fresh), default=0.0)
        seconds = SETTING_UP + importing + work_seconds(work)
        stages.append(StageNeeds(plan, harmonics_of(case, plan), work, seconds, _held(work)))
    held = max((LIBRARIES[name][1] for name in loaded), default=0.0)
    held += max((stage.megabytes for stage in stages), default=0.0)
    return Needs(
        stages=tuple(stages),
        seconds=COMMAND[0] + sum(stage.seconds for stage in stages),
        megabytes=COMMAND[1] + held,
    )


def work_seconds(work: Work) -> float:
    """Seconds of counted work."""
    return sum(number * UNITS[unit].seconds for number, unit in work)


def libraries_of(work: Work) -> set[str]:
    """Heavy libraries that some work is done with."""
    return {UNITS[unit].library for _, unit in work} - {""}


def _held(work: Work) -> float:
    counted = {unit: number for number, unit in work}
    held = _CURVE_MB * counted.get("line_solve", 0.0)
    held += _MAP_MB * ("damper_map" in counted) + _MOTOR_MB * ("periodic_motor" in counted)
    return 1.0 + held
