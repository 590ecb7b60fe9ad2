"""What it costs to follow the impacts of a study from contact to contact."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.joint_gaps import JOINTS, Gap, gaps

IMPACT: KeyPath = ("response", "impact")
TURN = 2.0 * math.pi
#: Steps of one batch that a study may take, each about a millisecond: some 40 minutes.
MOST_WORK = 2e6
#: Runs that take as long as the step itself.
RUNS_OF_A_STEP = 150.0
#: A step of a fixed-step method, in steps from contact to contact.
FIXED_STEP = 0.25


class Work(NamedTuple):
    """What event-exact runs cost, as an estimate: about twice too much where contacts are few.

    `steps` of one run in a revolution, of a bound on the rates of the contacts; `total` steps of
    the batch over all revolutions, those of many runs counted as more, with those of a fixed-step
    method, which runs beside the event-exact one.
    """

    steps: float
    total: float


def impact_work(case: Case) -> Work | None:
    """What the impacts of a case without problems cost; None without a study or its joints."""
    if case.machine.joints is None or case.response is None or case.response.impact is None:
        return None
    return _work(case, gaps(case, []))


def cost_problems(case: Case, found: list[Gap]) -> Iterator[Problem]:
    """A problem where the runs of a study would take too long, or not end."""
    work = _work(case, found)
    if work is None:
        return
    from vibecalc.response.impact.setup import MOST_STEPS  # only a study loads what follows it

    if work.steps > MOST_STEPS:
        yield Problem(
            path=("machine", "speed"),
            message="at this speed the contacts are too stiff or too strongly damped to be "
            "followed over a whole revolution",
            found=f"{case.machine.speed:.6g} rad/s: about {work.steps:.2g} steps per revolution",
            allowed=f"<= {MOST_STEPS:.6g} steps per revolution",
            also=JOINTS,
            hint="steps per revolution go with sqrt(stiffness / mass) and damping / mass, over the "
            "speed",
        )
    elif work.total > MOST_WORK:
        yield Problem(
            path=IMPACT,
            message="the study would take too long",
            found=f"about {work.steps:.2g} steps per revolution of each run, {work.total:.2g} "
            "milliseconds or so in all",
            allowed=f"<= {MOST_WORK:.2g} milliseconds, as estimated",
            hint="fewer members, revolutions, clearances or fixed steps; steps per revolution go "
            "with sqrt(stiffness / mass) and damping / mass, over the speed",
        )


def _work(case: Case, found: list[Gap]) -> Work | None:
    study = None if case.response is None else case.response.impact
    if study is None or not found:
        return None
    from vibecalc.response.impact.series import REACH

    turn = TURN / case.machine.speed
    fastest = 0.0
    for gap in found:
        ring = math.sqrt(gap.play.stiffness * gap.mobility)
        fastest = max(
            fastest,
            ring + gap.play.contact_damping * gap.mobility,
            gap.play.film_damping * gap.mobility,
        )
    gas = case.machine.crank_train.gas_pressure
    nodes = 0 if gas is None else len(gas.crank_angle)
    # steps also end at the nodes of the gas, and follow the highest order of the spectrum
    steps = fastest * turn / REACH + nodes + study.orders
    runs = (study.members + min(study.members, 16)) * max(len(study.clearances), 1)
    turns = study.discard + study.revolutions
    each = steps + (0.0 if study.method == "event_exact" else FIXED_STEP * study.steps)
    return Work(steps, turns * each * (1.0 + runs / RUNS_OF_A_STEP))
