"""Of all solutions along a key the one to name, and what has to be said beside it."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from vibecalc.errors import NumericalFailure
from vibecalc.study.find_along import Along
from vibecalc.study.find_course import Course, Sample, Solution
from vibecalc.study.find_extremes import extremes
from vibecalc.study.find_roots import Level, roots
from vibecalc.units import parse_quantity

_REASONS = 3


class Choice(NamedTuple):
    """The solution that is named, the others, and the course they stand on.

    `level` is what was wanted, None for an extreme.
    """

    solution: Solution
    others: list[Solution]
    course: Course
    level: Level | None
    notes: list[str]


def choose(along: Along, as_written: tuple[float, float], unit: str) -> Choice:
    """Search between the bounds; `as_written` is the result of the case and its error, in `unit`.

    A wanted value: the solution nearest to the key as written, by ratio where both are positive.
    An extreme: the lowest minimum or the highest maximum. NumericalFailure, with what was seen,
    where there is none.
    """
    search = along.search
    # around a turn and two steps on, so that what lies where its ends meet has neighbours
    step = along.turn / (search.points - 1)
    course = Course(along.evaluate, along.lower, along.upper + 2.0 * step)
    if math.isfinite(as_written[0]) and math.isfinite(along.written):
        course.know(along.written, *as_written)
    course.look(search.points + (2 if along.turn else 0))
    seen = [sample for stretch in course.stretches() for sample in stretch]
    if not seen:
        raise NumericalFailure(
            f"none of {len(course.samples)} points could be computed: {_reasons(course)}"
        )
    if _constant(seen):
        raise NumericalFailure(
            f"{search.quantity} does not change between the bounds of {search.key}: it is "
            f"{_shown(seen[0].value, unit)} at all of {len(seen)} points"
        )
    if search.seek is not None:
        sign = 1.0 if search.seek == "minimum" else -1.0
        found = _around(along, extremes(course, sign))
        notes = [] if along.turn else list(_beyond(along, course, found, sign, unit))
        level = None
    else:
        level = _level(along, as_written, unit)
        found, jumps = roots(course, level)
        found = _around(along, found)
        found.sort(key=lambda solution: _distance(along, solution.sample))
        notes = [
            f"{search.quantity} jumps past the wanted value at {_shown(one.key, along.unit)}: "
            "that is no solution"
            for one in jumps
        ]
    if not found:
        raise NumericalFailure(_nothing(along, course, level, unit, notes))
    return Choice(found[0], found[1:], course, level, [*notes, *_skipped(along, course)])


def _around(along: Along, found: list[Solution]) -> list[Solution]:
    """Solutions on a whole turn, from its lower end on; what was met on both turns counts once."""
    if not along.turn:
        return found
    once: list[Solution] = []
    for one in found:
        on = (one.sample.key - along.lower) % along.turn
        on -= along.turn if along.turn - on <= one.error else 0.0
        moved = Solution(one.sample._replace(key=along.lower + max(on, 0.0)), one.error)
        near = (abs(moved.sample.key - other.sample.key) - other.error for other in once)
        if all(gap > one.error for gap in near):
            once.append(moved)
    return once


def _level(along: Along, as_written: tuple[float, float], unit: str) -> Level:
    search = along.search
    if search.target is not None:
        return Level(parse_quantity(search.target, unit), 0.0)
    if search.change is None:
        raise ValueError("the search does not say what is wanted")
    value, error = as_written
    if not math.isfinite(value):
        raise NumericalFailure(f"{search.quantity} of the case as written is no finite number")
    return Level(value + parse_quantity(search.change, unit), error)


def _distance(along: Along, sample: Sample) -> float:
    if along.near > 0.0 and sample.key > 0.0:
        return abs(math.log(sample.key / along.near))
    return abs(sample.key - along.near)


def _constant(seen: list[Sample]) -> bool:
    """Whether all samples are the same within their errors: three at least, to mean something."""
    values = [sample.value for sample in seen]
    return len(seen) > 2 and max(values) - min(values) <= 2.0 * min(one.error for one in seen)


def _beyond(
    along: Along, course: Course, found: list[Solution], sign: float, unit: str
) -> Iterator[str]:
    """Say where a bound, or the end of what can be computed, is better than every extreme."""
    ends = [one for stretch in course.stretches() for one in (stretch[0], stretch[-1])]
    best = min(ends, key=lambda one: sign * one.value)
    if found and sign * (best.value - found[0].sample.value) < 0.0:
        yield (
            f"the {along.search.seek} is that between the bounds; {along.search.quantity} is "
            f"{'lower' if sign > 0.0 else 'higher'} still, {_shown(best.value, unit)}, "
            f"{_place(along, course, best)}"
        )


def _place(along: Along, course: Course, sample: Sample) -> str:
    at_bound = sample.place in (course.first, course.last)
    where = "at the bound" if at_bound else "beside what cannot be computed, at"
    return f"{where} {_shown(sample.key, along.unit)}"


def _nothing(along: Along, course: Course, level: Level | None, unit: str, notes: list[str]) -> str:
    search = along.search
    seen = [sample for stretch in course.stretches() for sample in stretch]
    low, high = (pick(seen, key=lambda one: one.value) for pick in (min, max))
    bounds = f"{_shown(along.lower, along.unit)} and {_shown(along.upper, along.unit)}"
    if level is None:
        best = low if search.seek == "minimum" else high
        words = (
            f"no {search.seek} of {search.quantity} for {search.key} between {bounds}: "
            f"its {'lowest' if best is low else 'highest'} value, {_shown(best.value, unit)}, is "
            f"{_place(along, course, best)}"
        )
    else:
        nearest = min(seen, key=lambda one: abs(level.off(one)))
        words = (
            f"no {search.key} between {bounds} brings {search.quantity} to "
            f"{_shown(level.wanted, unit)}: it goes from {_shown(low.value, unit)} at "
            f"{_shown(low.key, along.unit)} to {_shown(high.value, unit)} at "
            f"{_shown(high.key, along.unit)}, and is nearest at {_shown(nearest.key, along.unit)} "
            f"with {_shown(nearest.value, unit)}"
        )
    return "; ".join([words, *notes, *_skipped(along, course)])


def _skipped(along: Along, course: Course) -> Iterator[str]:
    failed = course.failed()
    if failed:
        first, last = (_shown(one.key, along.unit) for one in (failed[0], failed[-1]))
        between = f"at {first}" if first == last else f"between {first} and {last}"
        yield (
            f"{len(failed)} of {len(course.samples)} points could not be computed, {between}, "
            f"and no solution beside or between them is claimed: {_reasons(course)}"
        )


def _reasons(course: Course) -> str:
    reasons = list(dict.fromkeys(sample.failure for sample in course.failed()))
    more = f"; and {len(reasons) - _REASONS} more" if len(reasons) > _REASONS else ""
    return "; ".join(reasons[:_REASONS]) + more


def _shown(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}".rstrip()
