"""What a run of a case will take: stages, harmonics, modules, work, time and memory.

Everything is read from the case and from the sources; nothing is computed and no solver imported.
"""

from typing import TYPE_CHECKING, NamedTuple

from vibecalc.pipeline.needs_imports import PACKAGE
from vibecalc.pipeline.needs_lazy import modules_needed
from vibecalc.pipeline.needs_orders import Harmonics, harmonics_of
from vibecalc.pipeline.needs_units import COMMAND, LIBRARIES, MODULE, UNITS
from vibecalc.pipeline.needs_work import Work, work_of
from vibecalc.pipeline.plan import plan_case
from vibecalc.pipeline.stage_plan import StagePlan

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: what every run begins with
FRAME = (f"{PACKAGE}.study.execute", f"{PACKAGE}.study.load", f"{PACKAGE}.pipeline.run")
#: rooms that read and write, the same for every case
OUTSIDE = (
    "case",
    "results",
    "report",
    "accuracy",
    "units",
    "unit_table",
    "errors",
    "cli",
    "cli_sweep",
    "cli_accuracy",
)
#: MB for each solve times freedom kept as a curve; of a damper's map and a motor's currents
_CURVE_MB, _MAP_MB, _MOTOR_MB = 3.0e-5, 50.0, 80.0


class StageNeeds(NamedTuple):
    """What one stage takes: modules of this package and libraries, surely and perhaps.

    `fresh` counts the modules that no earlier stage of the run has brought in. `seconds` is the
    estimate for one thread, imports included; `megabytes` what the stage holds.
    """

    plan: StagePlan
    harmonics: Harmonics | None
    modules: tuple[str, ...]
    perhaps: tuple[str, ...]
    libraries: tuple[str, ...]
    libraries_perhaps: tuple[str, ...]
    fresh: int
    work: Work
    seconds: float
    megabytes: float


class Needs(NamedTuple):
    """What a run takes: before and after the stages `frame`, then each stage, then together."""

    frame: tuple[str, ...]
    stages: tuple[StageNeeds, ...]
    seconds: float
    megabytes: float


def needs_of(case: "Case") -> Needs:
    """What a run of `case` takes, without the searches of a study."""
    frame, later = modules_needed(case, FRAME)
    seen = set(frame | later)
    stages = []
    for plan in plan_case(case):
        sure, perhaps = modules_needed(case, (f"{PACKAGE}.pipeline.stages.{plan.module}",))
        fresh = (sure | perhaps) - seen
        seen |= fresh
        stages.append(_stage(case, plan, sure, perhaps, fresh))
    seconds = COMMAND[0] + sum(stage.seconds for stage in stages)
    libraries = (_library(name) for name in seen)
    held = max((LIBRARIES[name][1] for name in libraries if name in LIBRARIES), default=0.0)
    megabytes = COMMAND[1] + held + max((stage.megabytes for stage in stages), default=0.0)
    return Needs(own(frame), tuple(stages), seconds, megabytes)


def own(modules: frozenset[str]) -> tuple[str, ...]:
    """Modules of this package that compute, without its name."""
    inside = (name.partition(".") for name in modules if name.startswith(f"{PACKAGE}."))
    return tuple(sorted(rest for *_, rest in inside if rest.split(".")[0] not in OUTSIDE))


def foreign(modules: frozenset[str]) -> tuple[str, ...]:
    """Libraries, each to its second level: numpy, scipy.optimize."""
    names = (name for name in modules if not name.startswith(f"{PACKAGE}."))
    return tuple(sorted({_library(name) for name in names}))


def work_seconds(work: Work) -> float:
    """Seconds of counted work."""
    return sum(number * UNITS[unit].seconds for number, unit in work)


def _stage(
    case: "Case",
    plan: StagePlan,
    sure: frozenset[str],
    perhaps: frozenset[str],
    fresh: frozenset[str],
) -> StageNeeds:
    work = work_of(case, plan)
    mine = [name for name in fresh if name.startswith(f"{PACKAGE}.")]
    loaded = [LIBRARIES[name][0] for name in foreign(fresh) if name in LIBRARIES]
    # what is asked for last finds most of the others' parts there already
    importing = MODULE * len(mine) + max(loaded, default=0.0)
    return StageNeeds(
        plan=plan,
        harmonics=harmonics_of(case, plan),
        modules=own(sure),
        perhaps=own(perhaps),
        libraries=foreign(sure),
        libraries_perhaps=foreign(perhaps - sure),
        fresh=len(own(fresh)),
        work=work,
        seconds=importing + work_seconds(work),
        megabytes=_held(work),
    )


def _held(work: Work) -> float:
    counted = {unit: number for number, unit in work}
    held = _CURVE_MB * counted.get("line_solve", 0.0)
    held += _MAP_MB * ("damper_map" in counted) + _MOTOR_MB * ("periodic_motor" in counted)
    return 1.0 + held


def _library(name: str) -> str:
    parts = name.split(".")
    return ".".join(parts[:2]) if parts[0] == "scipy" else parts[0]
