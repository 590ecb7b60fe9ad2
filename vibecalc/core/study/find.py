"""Solve for the changes that bring wanted results: what [[find]] in a case asks for."""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import get_key, number_at
from vibecalc.core.case.study_tables import Find, TiedKey, Variable
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.record import Method, Record
from vibecalc.core.results.select import worst
from vibecalc.core.run.run import StageCache
from vibecalc.core.study.binding import Foreseen, Varied
from vibecalc.core.study.find_solutions import (
    Level,
    Sample,
    SampledCurve,
    Solution,
    extremes,
    roots,
)
from vibecalc.core.study.planned import FIND, MACHINE, find_entries, machine_paths
from vibecalc.core.study.search.side_by_side import Ask, side_by_side
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure, ResultError
from vibecalc.units import parse_quantity

# ----------------------------------------------------------------------------
# A case along one of its keys; of all solutions the one to name, and what has to be said with it.
# ----------------------------------------------------------------------------

#: relative change of a result along a key that is none where its error does not tell it, either
_SAME = 1e-8
_REASONS = 3


class Together(Varied):
    """Searches of one case, by their numbers, whose points are computed at once where arrays can.

    A point (2,) is the number of a search and its key; keys of the others are as the case has them.
    """

    def __init__(self, loaded: "LoadedCase", searches: "Mapping[int, Along]", cache: StageCache):
        super().__init__(loaded, [one.moving for one in searches.values()], cache)
        self.searches, self._foreseen = searches, Foreseen()
        keys = [key for one in searches.values() for key in one.at.settings(one.at.first)]
        self._others = {key: number_at(loaded.resolved, key, math.nan) for key in keys}
        number, one = next(iter(searches.items()))
        self.first = np.array([number, *one.at.first])
        self.wanted = frozenset({one.search.quantity for one in searches.values()})

    def settings(self, variables: np.ndarray) -> dict[str, Any]:
        """Keys of the case and what they are set to."""
        return self._others | self.searches[int(variables[0])].at.settings(variables[1:])

    @property
    def by_arrays(self) -> bool:
        """Whether arrays can vary the keys of all of them."""
        return self._foreseen.takes(self, self.wanted)

    def ahead(self, points: Sequence[np.ndarray]) -> None:
        """Compute points that are about to be asked for, those of other searches left out."""
        own = [one for one in points if int(one[0]) in self.searches]
        if own:
            self._foreseen.add(self, np.array(own), self.wanted)

    def find(self, point: np.ndarray) -> Record | None:
        """The results at a point; None where it needs a run of its own."""
        found = self._foreseen.find(self, point, self.wanted)
        return found if isinstance(found, Record) else None


class Along:
    """One [[find]] on its case: the result for a value of the key, in SI.

    `together` are the searches that its points are computed with, `ask` says which are about to be
    evaluated. Keys of `scaled_with` keep their ratio to it. `written` is the value of the key in
    the case, nan where it leaves the key out. `turn` is the whole turn in rad that the bounds of an
    angle hold, whose ends are then one; else 0. `choose` finds `solutions`, of which the first is
    named, and `notes`; `level` is what was wanted, None for an extreme. `count` is called with each
    evaluation.
    """

    def __init__(
        self,
        search: Find,
        loaded: LoadedCase,
        cache: StageCache,
        count: Callable[[str], None],
        number: int = 0,
    ):
        self.search, self._count, resolved = search, count, loaded.resolved
        self.written = number_at(resolved, search.key, math.nan)
        ratios = {key: float(get_key(resolved, key)) / self.written for key in search.also}
        ties = [TiedKey.model_construct(key=key, factor=ratio) for key, ratio in ratios.items()]
        self.moving = Variable.model_construct(
            key=search.key, lower=search.lower, upper=search.upper, follow=tuple(ties)
        )
        self.at = Varied(loaded, [self.moving], cache)
        self.lower, self.upper = float(self.at.lower[0]), float(self.at.upper[0])
        self._near, period = float(self.at.first[0]), float(self.at.period[0])
        whole = abs(self.upper - self.lower - period) <= 1e-9 * period and not search.also
        self.turn = period if whole else 0.0
        # around a turn and two steps on, so that what lies where its ends meet has neighbours
        step = self.turn / (search.points - 1)
        self.number, self._wanted = number, frozenset({search.quantity})
        self.together = Together(loaded, {number: self}, cache)
        self.ask: Ask = self.together.ahead
        self.curve = SampledCurve(self.evaluate, self.lower, self.upper + 2.0 * step, self.ahead)
        self.level: Level | None = None
        self.solutions: list[Solution] = []
        self.notes: list[str] = []

    def evaluate(self, value: float) -> tuple[float, float]:
        """The result and its absolute error; NumericalFailure where there is none."""
        self._count("")
        self.ahead([value])
        record = self.together.find(np.array([self.number, value]))
        if record is None:
            record = self.at.results(np.array([value]), self._wanted)
        try:
            return self.read(record)
        except ResultError as error:  # an order that this point does not keep, say
            raise NumericalFailure(str(error)) from error

    def ahead(self, values: list[float]) -> None:
        """Say at which values the result is about to be asked for."""
        self.ask([np.array([self.number, value]) for value in values])

    def read(self, record: Record) -> tuple[float, float]:
        """The result and its error from a run; of several entries the largest counts."""
        quantity = record[self.search.quantity]
        value, _ = worst(quantity, self.search.where, "max")
        return value, quantity.error_estimate

    def choose(self, as_written: tuple[float, float]) -> None:
        """Search between the bounds; `as_written` is the result of the case and its error.

        A wanted value: the solution nearest to the key as written, by ratio where both are
        positive. An extreme: the lowest minimum or the highest maximum. NumericalFailure, with what
        was computed, where there is none.
        """
        search, curve = self.search, self.curve
        if math.isfinite(as_written[0]) and math.isfinite(self.written):
            curve.know(self.written, *as_written)
        curve.sample(search.points + (2 if self.turn else 0))
        computed = curve.computed()
        if not computed:
            raise NumericalFailure(
                f"none of {len(curve.samples)} points could be computed: {self._reasons()}"
            )
        # three at least mean something; an error by what is left out of a result may hide a change
        values = [one.value for one in computed]
        rounding = min(_SAME * max(map(abs, values)), *(one.error for one in computed))
        if len(computed) > 2 and max(values) - min(values) <= 2.0 * rounding:
            raise NumericalFailure(
                f"{search.quantity} does not change between the bounds of {search.key}: it is "
                f"{self._result(values[0])} at all of {len(computed)} points"
            )
        if search.sense is not None:
            self.solutions = self._around(extremes(curve, _sign(search)))
            self.notes = list(self._beyond())
        else:
            self.level = self._level(*as_written)
            solutions, jumps = roots(curve, self.level)
            self.solutions = sorted(self._around(solutions), key=self._distance)
            self.notes = [
                f"{search.quantity} jumps across the target at {self._key(one.key)}: "
                "no solution there"
                for one in jumps
            ]
        failed = curve.failed()
        if failed:
            first, last = (self._key(one.key) for one in (failed[0], failed[-1]))
            between = f"at {first}" if first == last else f"between {first} and {last}"
            self.notes.append(
                f"{len(failed)} of {len(curve.samples)} points could not be computed, "
                f"{between}; solutions near them may be missed: {self._reasons()}"
            )
        if not self.solutions:
            raise NumericalFailure("; ".join([self._nothing(), *self.notes]))

    def _around(self, solutions: list[Solution]) -> list[Solution]:
        """Solutions on a whole turn, from its lower end on; what both turns have counts once."""
        if not self.turn:
            return solutions
        once: list[Solution] = []
        for one in solutions:
            on = (one.sample.key - self.lower) % self.turn
            on -= self.turn if self.turn - on <= one.error else 0.0
            moved = Solution(one.sample._replace(key=self.lower + max(on, 0.0)), one.error)
            near = (abs(moved.sample.key - other.sample.key) - other.error for other in once)
            if all(gap > one.error for gap in near):
                once.append(moved)
        return once

    def _level(self, value: float, error: float) -> Level:
        unit = CATALOGUE[self.search.quantity].unit
        if self.search.target is not None:
            return Level(parse_quantity(self.search.target, unit), 0.0)
        if not math.isfinite(value):
            raise NumericalFailure(f"{self.search.quantity} of the case as written is not finite")
        return Level(value + parse_quantity(str(self.search.change), unit), error)

    def _distance(self, solution: Solution) -> float:
        """From the key as written, or from the middle of the bounds."""
        key = solution.sample.key
        if self._near > 0.0 and key > 0.0:
            return abs(math.log(key / self._near))
        return abs(key - self._near)

    def _beyond(self) -> Iterator[str]:
        """Say where a bound, or the end of what can be computed, is better than every extreme."""
        search, sign = self.search, _sign(self.search)
        ends = [one for stretch in self.curve.stretches() for one in (stretch[0], stretch[-1])]
        best = min(ends, key=lambda one: sign * one.value)
        better = self.solutions and sign * (best.value - self.solutions[0].sample.value) < 0.0
        if better and not self.turn:
            yield (
                f"the {search.sense}imum inside the bounds is reported; {search.quantity} is even "
                f"{'lower' if sign > 0.0 else 'higher'}, {self._result(best.value)}, "
                f"{self._place(best)}"
            )

    def _place(self, sample: Sample) -> str:
        at_bound = sample.place in (self.curve.first, self.curve.last)
        where = "at the bound" if at_bound else "at the edge of the computable range,"
        return f"{where} {self._key(sample.key)}"

    def _nothing(self) -> str:
        search, computed = self.search, self.curve.computed()
        low, high = (pick(computed, key=lambda one: one.value) for pick in (min, max))
        bounds = f"{self._key(self.lower)} and {self._key(self.upper)}"
        if self.level is None:
            best, how = (low, "lowest") if search.sense == "min" else (high, "highest")
            return (
                f"no {search.sense}imum of {search.quantity} for {search.key} between {bounds}: "
                f"its {how} value, {self._result(best.value)}, is {self._place(best)}"
            )
        near = min(computed, key=self.level.off)
        return (
            f"no {search.key} between {bounds} gives {search.quantity} = "
            f"{self._result(self.level.wanted)}: minimum {self._result(low.value)} at "
            f"{self._key(low.key)}, maximum {self._result(high.value)} at {self._key(high.key)}, "
            f"nearest at {self._key(near.key)} with {self._result(near.value)}"
        )

    def _reasons(self) -> str:
        reasons = list(dict.fromkeys(sample.failure for sample in self.curve.failed()))
        left = len(reasons) - _REASONS
        return "; ".join(reasons[:_REASONS] + [f"and {left} more"] * (left > 0))

    def _key(self, value: float) -> str:
        return f"{value:.6g} {self.at.units[0]}".rstrip()

    def _result(self, value: float) -> str:
        return f"{value:.6g} {CATALOGUE[self.search.quantity].unit}".rstrip()


def _sign(search: Find) -> float:
    """1 where a minimum is sought, -1 for a maximum."""
    return 1.0 if search.sense == "min" else -1.0


# ----------------------------------------------------------------------------
# Solve for the changes that bring wanted results: what [[find]] in a case asks for.
# ----------------------------------------------------------------------------

#: of the way to the farther bound, for slopes at the key found
_STEP = 1e-4
_METHODS = [
    Method(
        name=f"Brent's {what} on brackets between samples along a key",
        purpose=purpose,
        citation=f"Brent, Algorithms for Minimization without Derivatives, 1973, ch. {chapter}",
    )
    for what, purpose, chapter in (
        ("root finding", "values that bring a wanted result", 4),
        ("minimisation", "extremes along a key", 5),
    )
]


def add_solutions(
    record: Record, loaded: LoadedCase, *, timings: dict[str, float], progress: bool = False
) -> None:
    """Add `find/...` of all searches to the record of the case as written.

    A search that fails, where nothing between the bounds brings what is wanted or no point can be
    computed, leaves a warning, and what the others found stands. Raises NumericalFailure, with all
    of them, where none found anything.
    """
    started = time.perf_counter()
    cache = StageCache()  # searches along different keys share the stages that these do not touch
    with counted("finding", progress) as advance:
        every = [
            Along(search, loaded, cache, advance, number)
            for number, search in enumerate(loaded.case.find)
        ]
        groups = _gathered(loaded, every, cache)

        def ahead(points: Sequence[np.ndarray]) -> None:
            for group in groups:
                group.ahead(points)

        said = side_by_side([partial(_chosen, along, record) for along in every], ahead)
    chosen = [along for along, failure in zip(every, said, strict=True) if not failure]
    failures = [failure for failure in said if failure]
    if not chosen:
        raise NumericalFailure("; ".join(failures))
    record.warnings += failures
    entries = find_entries(loaded.case)
    for along in chosen:
        name = along.search.name
        axes = {"solution": np.arange(1, len(along.solutions))}
        for path, (value, error) in _numbers(along).items():
            if entry := entries.get(f"{FIND}/{name}/{path}"):
                record.add(entry.quantity(value, error, axes))
        _add_machine(record, along, frozenset(machine_paths(loaded.case, along.search)))
        record.warnings += [f"find {name!r}: {note}" for note in along.notes]
    seeks = {along.search.sense is not None for along in chosen}
    record.methods += [_METHODS[seek] for seek in sorted(seeks)]
    timings[FIND] = time.perf_counter() - started


def _chosen(along: Along, record: Record, ask: Ask) -> str:
    """Search, side by side with others; why nothing was found, where that is so."""
    along.ask = ask
    try:
        along.choose(along.read(record))
    except NumericalFailure as failure:
        return f"find {along.search.name!r}: {failure}"
    return ""


def _gathered(loaded: "LoadedCase", every: list[Along], cache: StageCache) -> list[Together]:
    """Searches in groups that are computed together: those for the same result, along keys that
    the case has, where arrays can vary all of these at once; each other one alone."""
    by_result: dict[str, dict[int, Along]] = {}
    for along in every:
        if math.isfinite(along.written):
            by_result.setdefault(along.search.quantity, {})[along.number] = along
    for some in by_result.values():
        if len(some) > 1 and (group := Together(loaded, some, cache)).by_arrays:
            for along in some.values():
                along.together = group
    return list(dict.fromkeys(along.together for along in every))


def _add_machine(record: Record, along: Along, wanted: frozenset[str]) -> None:
    """Results of the machine that was found, next to those of the case as written.

    Their errors count that of the key, by the slope towards the farther bound.
    """
    root, key = f"{FIND}/{along.search.name}/{MACHINE}", along.solutions[0].sample.key
    far = along.upper if along.upper - key > key - along.lower else along.lower
    step = _STEP * (far - key)
    try:
        results, nearby = (along.at.results(np.array([at]), wanted) for at in (key, key + step))
    except NumericalFailure as failure:  # of what was not sought
        record.warnings.append(f"{root} is left out: {failure}")
        return
    for path, quantity in results.items():
        moved = abs(float(nearby.get(path, quantity).values) - float(quantity.values))
        off = moved * abs(along.solutions[0].error / step) if math.isfinite(moved) else 0.0
        uncertainty = quantity.error_estimate + off
        record.add(replace(quantity, path=f"{root}/{path}", error_estimate=uncertainty))


def _numbers(along: Along) -> dict[str, tuple[Any, float]]:
    """Names below `find/<name>/` with value and absolute error; NaN of what there is not."""
    (sample, error), *others = along.solutions
    written = along.written or math.nan
    settings = along.at.settings(np.array([sample.key]))
    keys = np.array([other.sample.key for other in others], dtype=float)
    values = np.array([other.sample.value for other in others], dtype=float)
    return {
        "value": (sample.key, error),
        "ratio": (sample.key / written, error / abs(written)),
        "reached": (sample.value, sample.error),
        "wanted": along.level[:2] if along.level else (math.nan, math.nan),
        "written": (along.written, 0.0),
        "others": (keys, max((other.error for other in others), default=0.0)),
        "others_reached": (values, max((other.sample.error for other in others), default=0.0)),
        **{
            f"scaled_with/{key}": (settings[key], error * abs(settings[key] / sample.key))
            for key in along.search.also
        },
        "evaluations": (along.curve.evaluations, 0.0),
        "failures": (len(along.curve.failed()), 0.0),
    }
