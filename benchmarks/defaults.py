"""Defaults in seconds: what vibecalc takes against the fastest method that is as accurate.

One shipped case for each stage and study, every question that it has, as `vibecalc accuracy` asks
them: the levels of all methods against a reference, in CPU seconds. The same in counted work is
held by the tests.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rows import Report, Table, digits, reported, seconds

from vibecalc.core.accuracy.run import collect
from vibecalc.core.accuracy.topic import Measured, Topic
from vibecalc.core.accuracy.topic import measure as measure_topic
from vibecalc.core.results.trials import Trial, cheapest, extra
from vibecalc.core.study.execute import load_checked

CASES = Path(__file__).resolve().parents[1] / "cases"
#: every stage and study once; one that takes long as part of a case is asked for alone
STAGES: dict[str, tuple[str, ...]] = {
    "generator": ("kinematics", "excitation", "isolation", "run_up"),
    "engine_v8": ("response", "torsion", "torsion_speeds"),
    "absorber_rig_a": ("tuning", "absorber"),
    "absorber_pendulum": ("pendulum",),
    "compressor": ("operations",),
    "compressor_motor": ("motor",),
    "compressor_switching": ("switching",),
    "compressor_impact": ("impact",),
    "engine_two_stroke": ("transient",),
    "engine_variable_inertia": ("variable inertia",),
    "engine_damper_design": ("damper design",),
    "four_cylinder": ("optimisation",),
    "pump": ("pump",),
    "roll": ("roll",),
    "roll_control": ("control",),
    "roll_startup": ("start-up",),
    "roll_design": ("find",),
}
#: seconds for the trials of a question
LONGEST = 5.0
#: more than so many times slower wants a reason
SLOW = 2.0
PLAIN = "as much counted work; the rest is calls of numpy and bounds of the error"
_HEAD = ("stage", "question", "ours", "error", "fastest as accurate", "error", "in seconds",
         "in work")  # fmt: skip


class Compared(NamedTuple):
    """A default next to the level that is as accurate in the least time."""

    topic: Topic
    ours: Trial
    best: Trial
    slower: float
    work: float


def compared(measured: Measured) -> Compared | None:
    """None for a question without a default of ours."""
    defaults = [trial for trial in measured.trials if trial.is_default and trial.done]
    if not defaults:
        return None
    ours, noise = max(defaults, key=lambda trial: trial.seconds), measured.reference.noise
    best = cheapest(measured.trials, max(ours.worst_relative, noise), "seconds") or ours
    slower, work = (extra(measured.trials, noise, cost) for cost in ("seconds", "work"))
    return Compared(measured.topic, ours, best, slower, work)


def every() -> Iterator[Compared]:
    """All questions of all cases."""
    for name, stages in STAGES.items():
        (loaded,) = load_checked([CASES / f"{name}.toml"])
        for topic in collect(loaded, stages).topics:
            found = compared(measure_topic(topic, LONGEST))
            if found is not None:
                yield found


def _named(trial: Trial) -> str:
    return f"{trial.method}, {trial.shown}" if trial.shown else trial.method


def _cells(one: Compared) -> tuple[str, ...]:
    return (
        one.topic.stage, one.topic.ask.name,
        f"{_named(one.ours)}: {seconds(one.ours.seconds)}", f"{one.ours.worst_relative:.0e}",
        f"{_named(one.best)}: {seconds(one.best.seconds)}", f"{one.best.worst_relative:.0e}",
        digits(one.slower), digits(one.work),
    )  # fmt: skip


def measure() -> Report:
    """The table, how many are on the front, and why the others are not; the slowest first."""
    found = sorted(every(), key=lambda one: -one.slower)
    slow = [one for one in found if one.slower > SLOW]
    why = [
        f"{one.topic.stage}, {one.topic.ask.name}, {digits(one.slower)} times: "
        f"{one.topic.ask.why or PLAIN}"
        for one in slow
    ]
    first = sum(one.slower <= 1.0 for one in found)
    middle = math.exp(sum(math.log(max(one.slower, 1.0)) for one in found) / len(found))
    counts = (
        f"{len(found)} questions: of {first} nothing as accurate is faster, of "
        f"{len(found) - len(slow)} nothing is more than twice as fast; geometric mean "
        f"{digits(middle)}."
    )
    return Report(
        title="Defaults against the fastest as accurate",
        words="What vibecalc takes, next to the fastest level of any method of `vibecalc accuracy` "
        "that is as accurate, one case for each stage. Errors are relative. In seconds and in "
        "counted work: ours over the least; 1 is on the front.",
        tables=[Table(counts, _HEAD, [_cells(one) for one in found])],
        remarks=why,
    )


if __name__ == "__main__":
    reported(measure)
