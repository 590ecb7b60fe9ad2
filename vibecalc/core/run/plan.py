"""Which stages a case asks for and why, and what they will take: read from the case alone."""

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Entry
from vibecalc.core.run.stage import Harmonics, Stage, Unit, Work, harmonics_of, subjects, work_of

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Which stages a case asks for, and why: read from the case alone, nothing is computed.
#
# A table that is absent from the case is a stage that is not planned, not imported, not run and
# not reported.
# ----------------------------------------------------------------------------


def plan_case(case: "Case") -> tuple[Stage, ...]:
    """The stages of `case` in the order in which they run."""
    return tuple(
        stage for subject in subjects().values() for make in subject.stages for stage in make(case)
    )


def needed_stages(case: "Case", wanted: frozenset[str] | None) -> tuple[Stage, ...]:
    """Of the stages of `case` those that bring what is wanted, None being all, in their order.

    A stage that others read from is there with any later one, since it may be read by that.
    """
    needed: list[Stage] = []
    for stage in reversed(plan_case(case)):
        brings = wanted is None or not wanted.isdisjoint(stage.quantities)
        if brings or (needed and not stage.is_last):
            needed.append(stage)
    return tuple(reversed(needed))


def planned_quantities(case: "Case") -> dict[str, Entry]:
    """Every result path that a run of `case` will hold, with its catalogue entry."""
    return {path: CATALOGUE[path] for stage in plan_case(case) for path in stage.quantities}


# ----------------------------------------------------------------------------
# What a piece of work costs: seconds of one thread of a common machine, counted once by running.
#
# The figures come from runs of the shipped cases on a 2.1 GHz server core with BLAS on one thread;
# on another machine all of them change together. Only their order of magnitude is said, and
# `benchmarks/needs.py` measures it.
# ----------------------------------------------------------------------------


@lru_cache(maxsize=1)
def units() -> dict[str, Unit]:
    """Pieces of work of all subjects, and what every stage takes to set up."""
    found = {"stage": Unit(1.5e-3, "stages set up")}
    for subject in subjects().values():
        found |= subject.units
    return found


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
FURTHER_RUN = (0.2, 1.5e-3)

# ----------------------------------------------------------------------------
# What a run of a case will take: stages, harmonics, counted work, time and memory.
#
# Everything is read from the case; nothing is computed and no solver imported.
# ----------------------------------------------------------------------------


class StageNeeds(NamedTuple):
    """What one stage takes.

    `seconds` is the estimate for one thread, imports included; `megabytes` what the stage holds.
    """

    plan: Stage
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
        known = [(number, units()[unit]) for number, unit in work]
        held = 1.0 + sum(number * unit.megabytes + unit.holds for number, unit in known)
        fresh = {unit.library for _, unit in known} - {"", *loaded}
        loaded |= fresh
        importing = max((LIBRARIES[name][0] for name in fresh), default=0.0)
        seconds = SETTING_UP + importing + work_seconds(work)
        stages.append(StageNeeds(plan, harmonics_of(case, plan), work, seconds, held))
    held = max((LIBRARIES[name][1] for name in loaded), default=0.0)
    held += max((stage.megabytes for stage in stages), default=0.0)
    return Needs(
        stages=tuple(stages),
        seconds=COMMAND[0] + sum(stage.seconds for stage in stages),
        megabytes=COMMAND[1] + held,
    )


def work_seconds(work: Work) -> float:
    """Seconds of counted work."""
    return sum(number * units()[unit].seconds for number, unit in work)
