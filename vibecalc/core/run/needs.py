"""What a run of a case will take: stages, harmonics, counted work, time and memory."""

from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.stage import StagePlan
from vibecalc.work import Harmonics, Work, harmonics_of, work_of

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What a piece of work costs: seconds of one thread of a common machine, counted once by running.
#
# The figures come from runs of the shipped cases on a 2.1 GHz server core with BLAS on one thread;
# on another machine all of them change together. They are meant to be right within a factor of 3,
# which `benchmarks/needs.py` measures.
# ----------------------------------------------------------------------------


class Unit(NamedTuple):
    """Seconds of one piece of work, its name when there are many, the heavy library it takes."""

    seconds: float
    words: str
    library: str = ""


UNITS: dict[str, Unit] = {
    "stage": Unit(1.5e-3, "stages set up"),
    "motion": Unit(1.0e-3, "passes over the motion of the pistons"),
    "order": Unit(1.0e-4, "orders summed"),
    "body_solve": Unit(2.5e-5, "solves of 6 x 6"),
    "pitch_solve": Unit(1.0e-5, "solves of the pitch model"),
    "modes": Unit(3.0e-3, "sets of modes"),
    "ways": Unit(3.0e-3, "ways of running, each a range over the angle of the weights"),
    "way_order": Unit(2.5e-5, "orders combined"),
    "turn_of_change": Unit(9.0e-3, "turns during the change"),
    "contact_step": Unit(1.0e-3, "batched steps from contact to contact"),
    "line": Unit(4.0e-2, "shaft lines set up with their modes"),
    "line_order": Unit(6.0e-4, "orders of a shaft line summed"),
    "line_solve": Unit(4.8e-7, "solves times freedoms"),
    "limit": Unit(1.0e-1, "limits followed over the range"),
    "time_step": Unit(6.0e-4, "steps in time", "scipy.sparse"),
    "variable_solve": Unit(1.5e-2, "solves of all orders at once", "scipy.linalg"),
    "damper_map": Unit(1.0, "maps of dampers with descents"),
    "damper_solve": Unit(1.0e-4, "solves times freedoms of the map"),
    "closed_forms": Unit(1.2e-2, "sets of closed forms"),
    "periodic": Unit(5.0e-2, "periodic problems"),
    "periodic_motor": Unit(
        2.5e-1, "periodic problems with a motor's currents", "scipy.interpolate"
    ),
    "march": Unit(1.0e-1, "marches until the turns repeat"),
    "turn_of_start": Unit(8.0e-2, "turns followed"),
    "start_angle": Unit(1.0e-1, "starts from other angles"),
    "loop": Unit(1.0e-3, "loops closed"),
    "tuning_loops": Unit(2.0e-1, "searches over loops", "scipy.optimize"),
    "least_squares": Unit(1.0e-2, "harmonics by least squares"),
    "level_motions": Unit(1.5e-2, "harmonics by all motions that levels allow"),
    "peak_search": Unit(1.0e-1, "searches for the lowest peak", "scipy.optimize"),
    "chart_point": Unit(3.0e-4, "points of the chart"),
    "several": Unit(3.0e-1, "searches over several absorbers", "scipy.optimize"),
    "curve_point": Unit(1.5e-6, "points of the curves"),
    "peaks": Unit(2.5e-2, "sets of peaks, poles and limits"),
    "parts": Unit(1.0e-1, "sets of stock parts held against the tuning"),
    "swing": Unit(4.5e-2, "swings of a pendulum"),
}

#: library -> (seconds of its import, MB that it holds); shared parts are loaded once
LIBRARIES: dict[str, tuple[float, float]] = {
    "scipy.integrate": (0.37, 50.0),
    "scipy.interpolate": (0.32, 50.0),
    "scipy.optimize": (0.29, 47.0),
    "scipy.sparse": (0.20, 31.0),
    "scipy.special": (0.17, 23.0),
    "scipy.linalg": (0.16, 26.0),
    "matplotlib": (0.46, 40.0),
}
#: seconds of a stage before it computes: its imports, its arrays
SETTING_UP = 1.0e-2
#: seconds and MB of a command before its first stage and after its last: interpreter, arrays,
#: the case with its checks, the result file, the report
COMMAND = (0.45, 65.0)
#: what a further run in a search costs: a share of the work of the stages that bring what is wanted
#: (parts that others need are left out, stages that nothing has changed are kept), and seconds
FURTHER_RUN = (0.33, 3.0e-3)

# ----------------------------------------------------------------------------
# What a run of a case will take: stages, harmonics, counted work, time and memory.
#
# Everything is read from the case; nothing is computed and no solver imported.
# ----------------------------------------------------------------------------

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
