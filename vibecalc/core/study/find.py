"""Solve for the changes that bring wanted results: what [[find]] in a case asks for."""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.case.raw import get_key, number_at
from vibecalc.core.results.record import Method, Record
from vibecalc.core.results.select import worst
from vibecalc.core.run.run import StageCache
from vibecalc.core.study.binding import Varied
from vibecalc.core.study.find_solutions import (
    Level,
    Sample,
    SampledCurve,
    Solution,
    extremes,
    roots,
)
from vibecalc.core.study.planned import FIND, MACHINE, find_entries, machine_paths
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure, ResultError
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.case.study_tables import Find

# ----------------------------------------------------------------------------
# A case along one of its keys, as a function that a search can call.
# ----------------------------------------------------------------------------


class Along:
    """One [[find]] on its case: the result for a value of the key, in SI.

    Keys of `also` keep their ratio to it. `written` is the value of the key in the case. `turn` is
    the whole turn in rad that the bounds of an angle hold, whose ends are then one; else 0.
    """

    def __init__(
        self, search: "Find", loaded: "LoadedCase", cache: StageCache, count: Callable[[str], None]
    ):
        # nan of a key that the case leaves out; solutions are then ordered from the middle
        self.written = number_at(loaded.resolved, search.key, math.nan)
        ties = [
            (key, float(get_key(loaded.resolved, key)) / self.written, 0.0) for key in search.also
        ]
        row = (search.key, search.lower, search.upper, tuple(ties))
        self.search, self.at = search, Varied(loaded, [row], cache)
        self.unit = self.at.units[0]
        self.lower, self.upper = float(self.at.lower[0]), float(self.at.upper[0])
        self.near, period = float(self.at.first[0]), float(self.at.period[0])
        whole = abs(self.upper - self.lower - period) <= 1e-9 * period and not search.also
        self.turn = period if whole else 0.0
        self._count = count

    def evaluate(self, value: float) -> tuple[float, float]:
        """The result and its absolute error; NumericalFailure where there is none."""
        self._count("")
        record = self.results(value, frozenset({self.search.quantity}))
        try:
            return self.read(record)
        except ResultError as error:  # an order that this point does not keep, say
            raise NumericalFailure(str(error)) from error

    def results(self, value: float, wanted: frozenset[str]) -> "Record":
        """Some results of the case with its keys changed; NumericalFailure as in a run."""
        return self.at.results(np.array([value]), wanted)

    def read(self, record: "Record") -> tuple[float, float]:
        """The result and its error from a run; of several entries the largest counts."""
        quantity = record[self.search.quantity]
        value, _ = worst(quantity, self.search.where, "max")
        return value, quantity.error_estimate


# ----------------------------------------------------------------------------
# Of all solutions along a key the one to name, and what has to be said next to it.
# ----------------------------------------------------------------------------

_REASONS = 3


class ChosenSolution(NamedTuple):
    """The solution that is named, the others, and the curve they stand on.

    `level` is what was wanted, None for an extreme.
    """

    solution: Solution
    others: list[Solution]
    curve: SampledCurve
    level: Level | None
    notes: list[str]


def choose(along: Along, as_written: tuple[float, float], unit: str) -> ChosenSolution:
    """Search between the bounds; `as_written` is the result of the case and its error, in `unit`.

    A wanted value: the solution nearest to the key as written, by ratio where both are positive.
    An extreme: the lowest minimum or the highest maximum. NumericalFailure, with what was computed,
    where there is none.
    """
    search = along.search
    # around a turn and two steps on, so that what lies where its ends meet has neighbours
    step = along.turn / (search.points - 1)
    curve = SampledCurve(along.evaluate, along.lower, along.upper + 2.0 * step)
    if math.isfinite(as_written[0]) and math.isfinite(along.written):
        curve.know(along.written, *as_written)
    curve.sample(search.points + (2 if along.turn else 0))
    computed = curve.computed()
    if not computed:
        raise NumericalFailure(
            f"none of {len(curve.samples)} points could be computed: {_reasons(curve)}"
        )
    # three at least mean something; an error by what is left out of a result may hide a change
    values = [one.value for one in computed]
    rounding = min(_SAME * max(map(abs, values)), *(one.error for one in computed))
    if len(computed) > 2 and max(values) - min(values) <= 2.0 * rounding:
        raise NumericalFailure(
            f"{search.quantity} does not change between the bounds of {search.key}: it is "
            f"{_shown(computed[0].value, unit)} at all of {len(computed)} points"
        )
    if search.seek is not None:
        sign = 1.0 if search.seek == "minimum" else -1.0
        solutions = _around(along, extremes(curve, sign))
        notes = [] if along.turn else list(_beyond(along, curve, solutions, sign, unit))
        level = None
    else:
        level = _level(along, as_written, unit)
        solutions, jumps = roots(curve, level)
        solutions = _around(along, solutions)
        solutions.sort(key=lambda solution: _distance(along, solution.sample))
        notes = [
            f"{search.quantity} jumps past the wanted value at {_shown(one.key, along.unit)}: "
            "that is no solution"
            for one in jumps
        ]
    if not solutions:
        raise NumericalFailure(_nothing(along, curve, level, unit, notes))
    return ChosenSolution(
        solutions[0], solutions[1:], curve, level, [*notes, *_skipped(along, curve)]
    )


def _around(along: Along, solutions: list[Solution]) -> list[Solution]:
    """Solutions on a whole turn, from its lower end on; what was met on both turns counts once."""
    if not along.turn:
        return solutions
    once: list[Solution] = []
    for one in solutions:
        on = (one.sample.key - along.lower) % along.turn
        on -= along.turn if along.turn - on <= one.error else 0.0
        moved = Solution(one.sample._replace(key=along.lower + max(on, 0.0)), one.error)
        near = (abs(moved.sample.key - other.sample.key) - other.error for other in once)
        if all(gap > one.error for gap in near):
            once.append(moved)
    return once


def _level(along: Along, as_written: tuple[float, float], unit: str) -> Level:
    search, (value, error) = along.search, as_written
    if search.target is not None:
        return Level(parse_quantity(search.target, unit), 0.0)
    if not math.isfinite(value):
        raise NumericalFailure(f"{search.quantity} of the case as written is no finite number")
    return Level(value + parse_quantity(str(search.change), unit), error)


def _distance(along: Along, sample: Sample) -> float:
    if along.near > 0.0 and sample.key > 0.0:
        return abs(math.log(sample.key / along.near))
    return abs(sample.key - along.near)


#: relative change of a result along a key that is none where its error does not tell it, either
_SAME = 1e-8


def _beyond(
    along: Along, curve: SampledCurve, solutions: list[Solution], sign: float, unit: str
) -> Iterator[str]:
    """Say where a bound, or the end of what can be computed, is better than every extreme."""
    ends = [one for stretch in curve.stretches() for one in (stretch[0], stretch[-1])]
    best = min(ends, key=lambda one: sign * one.value)
    if solutions and sign * (best.value - solutions[0].sample.value) < 0.0:
        yield (
            f"the {along.search.seek} is that between the bounds; {along.search.quantity} is "
            f"{'lower' if sign > 0.0 else 'higher'} still, {_shown(best.value, unit)}, "
            f"{_place(along, curve, best)}"
        )


def _place(along: Along, curve: SampledCurve, sample: Sample) -> str:
    at_bound = sample.place in (curve.first, curve.last)
    where = "at the bound" if at_bound else "next to what cannot be computed, at"
    return f"{where} {_shown(sample.key, along.unit)}"


def _nothing(
    along: Along, curve: SampledCurve, level: Level | None, unit: str, notes: list[str]
) -> str:
    search, computed = along.search, curve.computed()
    low, high = (pick(computed, key=lambda one: one.value) for pick in (min, max))
    bounds = f"{_shown(along.lower, along.unit)} and {_shown(along.upper, along.unit)}"
    if level is None:
        best, how = (low, "lowest") if search.seek == "minimum" else (high, "highest")
        words = (
            f"no {search.seek} of {search.quantity} for {search.key} between {bounds}: "
            f"its {how} value, {_shown(best.value, unit)}, is {_place(along, curve, best)}"
        )
    else:
        nearest = min(computed, key=level.off)
        from_low, to_high, near = (
            (_shown(one.value, unit), _shown(one.key, along.unit)) for one in (low, high, nearest)
        )
        words = (
            f"no {search.key} between {bounds} brings {search.quantity} to "
            f"{_shown(level.wanted, unit)}: it goes from {from_low[0]} at {from_low[1]} to "
            f"{to_high[0]} at {to_high[1]}, and is nearest at {near[1]} with {near[0]}"
        )
    return "; ".join([words, *notes, *_skipped(along, curve)])


def _skipped(along: Along, curve: SampledCurve) -> Iterator[str]:
    failed = curve.failed()
    if failed:
        first, last = (_shown(one.key, along.unit) for one in (failed[0], failed[-1]))
        between = f"at {first}" if first == last else f"between {first} and {last}"
        yield (
            f"{len(failed)} of {len(curve.samples)} points could not be computed, {between}, "
            f"and no solution next to or between them is claimed: {_reasons(curve)}"
        )


def _reasons(curve: SampledCurve) -> str:
    reasons = list(dict.fromkeys(sample.failure for sample in curve.failed()))
    left = len(reasons) - _REASONS
    return "; ".join(reasons[:_REASONS] + [f"and {left} more"] * (left > 0))


def _shown(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}".rstrip()


# ----------------------------------------------------------------------------
# Solve for the changes that bring wanted results: what [[find]] in a case asks for.
# ----------------------------------------------------------------------------

#: of the way to the farther bound, for slopes at the key found
_STEP = 1e-4
_CITATION = "Brent, Algorithms for Minimization without Derivatives, 1973, ch. "


def add_solutions(
    record: Record, loaded: "LoadedCase", *, timings: dict[str, float], progress: bool = False
) -> None:
    """Add `find/...` of all searches to the record of the case as written.

    A search that fails, where nothing between the bounds brings what is wanted or no point can be
    computed, leaves a warning, and what the others found stands. Raises NumericalFailure, with all
    of them, where none found anything.
    """
    started = time.perf_counter()
    cache = StageCache()  # searches along different keys share the stages that these do not touch
    chosen: list[tuple[Along, ChosenSolution]] = []
    failures: list[str] = []
    with counted("finding", progress) as advance:
        for search in loaded.case.find:
            along = Along(search, loaded, cache, advance)
            try:
                choice = choose(along, along.read(record), record[search.quantity].unit)
            except NumericalFailure as failure:
                failures.append(f"find {search.name!r}: {failure}")
            else:
                chosen.append((along, choice))
    if not chosen:
        raise NumericalFailure("; ".join(failures))
    record.warnings += failures
    entries = find_entries(loaded.case)
    for along, choice in chosen:
        name = along.search.name
        axes = {"solution": np.arange(1, len(choice.others) + 1)}
        for path, (value, error) in _numbers(along, choice).items():
            if entry := entries.get(f"{FIND}/{name}/{path}"):
                record.add(entry.quantity(value, error, axes))
        _add_machine(record, along, choice, machine_paths(loaded.case, along.search))
        record.warnings += [f"find {name!r}: {note}" for note in choice.notes]
    seeks = [along.search.seek is not None for along, _ in chosen]
    if not all(seeks):
        record.methods.append(_method("root finding", "values that bring a wanted result", "4"))
    if any(seeks):
        record.methods.append(_method("minimisation", "extremes along a key", "5"))
    timings[FIND] = time.perf_counter() - started


def _add_machine(
    record: Record, along: Along, choice: ChosenSolution, paths: tuple[str, ...]
) -> None:
    """Results of the machine that was found, next to those of the case as written.

    Their errors count that of the key, by the slope towards the farther bound.
    """
    root, wanted = f"{FIND}/{along.search.name}/{MACHINE}", frozenset(paths)
    key, error = choice.solution.sample.key, choice.solution.error
    far = along.upper if along.upper - key > key - along.lower else along.lower
    step = _STEP * (far - key)
    try:
        results, nearby = along.results(key, wanted), along.results(key + step, wanted)
    except NumericalFailure as failure:  # of what was not sought
        record.warnings.append(f"{root} is left out: {failure}")
        return
    for path, quantity in results.items():
        moved = abs(float(nearby.get(path, quantity).values) - float(quantity.values))
        off = moved * abs(error / step) if math.isfinite(moved) else 0.0
        uncertainty = quantity.error_estimate + off
        record.add(replace(quantity, path=f"{root}/{path}", error_estimate=uncertainty))


def _numbers(along: Along, choice: ChosenSolution) -> dict[str, tuple[Any, float]]:
    """Names below `find/<name>/` with value and absolute error; NaN of what there is not."""
    (sample, error), others = choice.solution, choice.others
    written = along.written or math.nan
    level = choice.level or Level(math.nan, math.nan)
    off = max((other.error for other in others), default=0.0)
    reached_off = max((other.sample.error for other in others), default=0.0)
    settings = along.at.settings(np.array([sample.key]))
    return {
        "value": (sample.key, error),
        "ratio": (sample.key / written, error / abs(written)),
        "reached": (sample.value, sample.error),
        "wanted": level,
        "written": (along.written, 0.0),
        "others": (np.array([other.sample.key for other in others], dtype=float), off),
        "others_reached": (
            np.array([other.sample.value for other in others], dtype=float), reached_off
        ),
        **{f"also/{key}": (settings[key], error * abs(settings[key] / sample.key))
           for key in along.search.also},
        "evaluations": (choice.curve.evaluations, 0.0),
        "failures": (len(choice.curve.failed()), 0.0),
    }  # fmt: skip


def _method(what: str, purpose: str, chapter: str) -> Method:
    name = f"Brent's {what} on brackets between samples along a key"
    return Method(name=name, purpose=purpose, citation=_CITATION + chapter)
