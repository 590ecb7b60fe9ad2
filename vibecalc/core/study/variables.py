"""Keys that a search changes, and what is wrong with an [optimisation] as a whole."""

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from vibecalc.core.case.load import resolve
from vibecalc.core.case.raw import field_unit, number_at
from vibecalc.core.run.targets import check_targets
from vibecalc.core.study.choices import ends_of, ties_of
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.firing import cycle_angle
from vibecalc.units import convert, split_number

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Objective
    from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# Keys that a search changes: after how much they repeat, and values of them in words.
# ----------------------------------------------------------------------------


def shown_as(value: float, unit: str, written: float | str) -> str:
    """A value of the SI unit `unit` as a text in the unit that `written` carries, if it does."""
    written_unit = split_number(written)[1] if isinstance(written, str) else ""
    return (
        f"{convert(value, unit, written_unit):.6g} {written_unit}"
        if written_unit
        else f"{value:.6g} {unit}".rstrip()
    )


def period_of(key: str, machine: "Machine") -> float:
    """After how much in rad a key repeats itself: an angle of the crank train; 0 for all others.

    The throw of a cylinder stands for its firing, too, and that repeats itself with the cycle.
    """
    name = key.rpartition(".")[2]
    if not key.startswith("machine.crank_train."):
        return 0.0
    if name in ("crank_phase", "bank_angle", "firing_angle"):
        return cycle_angle(machine)
    return 2.0 * math.pi if name == "phase" else 0.0


# ----------------------------------------------------------------------------
# What a long run is busy with, on stderr while it lasts, on a terminal only.
# ----------------------------------------------------------------------------

#: seconds before anything is said, and between two changes of it
_QUIET, _STEP = 2.0, 0.5
_WIDTH = 78


@contextmanager
def telling(wanted: bool) -> Iterator[Callable[..., None]]:
    """Give a function that takes the name of what begins, or words and when it began.

    A run of less than two seconds says nothing; of a longer one a line shows the words and counts
    the seconds, and is wiped out at the end. It needs no library, so that a short run is no slower.
    """
    if not (wanted and sys.stderr.isatty()):
        yield lambda words, since=0.0: None
        return
    busy, done = [("", time.monotonic())], threading.Event()

    def begin(words: str, since: float | None = None) -> None:
        busy[0] = (f"computing: {words}", time.monotonic()) if since is None else (words, since)

    def tell() -> None:
        wait = _QUIET
        while not done.wait(wait):
            words, since = busy[0]
            words += f", {time.monotonic() - since:.0f} s"
            sys.stderr.write(f"\r{words[:_WIDTH]:<{_WIDTH}}")
            sys.stderr.flush()
            wait = _STEP
        if wait == _STEP:
            sys.stderr.write(f"\r{'':<{_WIDTH}}\r")
            sys.stderr.flush()

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield begin
    finally:
        done.set()
        teller.join()


@contextmanager
def counted(what: str, wanted: bool, likely: int = 0) -> Iterator[Callable[..., None]]:
    """What is to be called after each run of a search, with words to show, or after several.

    With the `likely` number of runs the time left is shown, too, as long as no more are spent.
    """
    done, began = 0, time.monotonic()
    with telling(wanted) as tell:

        def advance(words: str, runs: int = 1) -> None:
            nonlocal done
            done += runs
            tell(f"{what}: {done} {left_words(done, likely, began, words)}", began)

        yield advance


def left_words(done: int, likely: int, began: float, words: str) -> str:
    """Runs that are likely to come and the time that they take, with other words between."""
    if not 0 < done < likely:
        return f"runs{words}"
    left = (time.monotonic() - began) * (likely - done) / done
    shown = f"{left:.0f} s" if left < 90.0 else f"{left / 60.0:.0f} min"
    return f"of some {likely} runs{words}, about {shown} left"


# ----------------------------------------------------------------------------
# What is wrong with an [optimisation] as a whole: where it starts, and its objectives.
# ----------------------------------------------------------------------------

#: of the distance between bounds, what rounding of units may miss one by
_ROUNDING = 1e-9


def study_problems(case: "Case") -> Iterator[Problem]:
    """Problems of where it starts, of its further objectives and of what is asked of variables."""
    study = case.optimisation
    if study is None:
        return
    yield from start_problems(case, "optimisation")
    second: KeyPath = ("second_objective",)
    for place, one in enumerate(study.goals[1:]):
        key = ("further_objectives", place - 1) if place else second
        yield from _further(case, key, one, study.goals[: place + 1])
    if study.sensitivity and not study.moving:
        yield Problem(
            path=("optimisation", "sensitivity"),
            message="sensitivity is about variables between bounds, and all of these are picked",
            allowed="a variable with min and max",
        )


def _further(
    case: "Case", key: KeyPath, goal: "Objective", before: tuple["Objective", ...]
) -> Iterator[Problem]:
    """Problems of a further objective, which is held to the checks of the first one."""
    if goal in before:
        order = ("first", "second", "third", "fourth")[before.index(goal)]
        which = "second" if len(before) == 1 else "further"
        yield Problem(
            path=("optimisation", *key),
            message=f"the {which} objective is the same as the {order} one",
            hint="a front shows what one costs in the other",
        )
    assert case.optimisation is not None
    swapped = case.optimisation.model_copy(update={"objective": goal})
    alone = case.model_copy(update={"optimisation": swapped, "reference": (), "limit": ()})
    for problem in check_targets(alone):
        if problem.path[:2] == ("optimisation", "objective"):
            yield problem._replace(path=("optimisation", *key, *problem.path[2:]))


def start_problems(case: "Case", table: str) -> Iterator[Problem]:
    """Variables that the case writes outside their bounds, and keys off what they follow."""
    study, resolved = getattr(case, table), resolve(case)
    for position, variable in enumerate(study.variables):
        if not variable.moves:
            continue
        path = (table, "variables", position)
        unit, highest = field_unit(variable.key), variable.upper or 0.0
        lower, upper = ends_of(variable)
        written = number_at(resolved, variable.key, 0.5 * (lower + upper))
        period = period_of(variable.key, case.machine)
        around = 0.0 < period <= (upper - lower) * (1.0 + _ROUNDING)
        slack = _ROUNDING * (upper - lower)
        if not (around or lower - slack <= written <= upper + slack):
            yield Problem(
                path=path,
                message=f"the search starts outside the bounds of {variable.key}",
                found=shown_as(written, unit, highest),
                allowed=f"{variable.lower} to {variable.upper}",
                hint="widen the bounds, or write a value between them into the case",
            )
        for place, (key, factor, offset) in enumerate(ties_of(variable)):
            wanted = factor * written + offset
            tied = number_at(resolved, key, wanted)
            off = tied - wanted
            period = period_of(key, case.machine)
            off -= period * round(off / period) if period else 0.0
            if abs(off) > 1e-6 * max(abs(wanted), abs(tied), abs(offset), upper - lower):
                yield Problem(
                    path=(*path, "followed_by", place),
                    message=f"{key} as written is not what it is to follow {variable.key} by",
                    found=shown_as(tied, unit, highest),
                    allowed=shown_as(wanted, unit, highest),
                    hint="write that into the case: the search starts from it",
                )
