"""Values of a sweep that the schema forbids: which, how many, at how many points."""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vibecalc.case.walk import Shape, bound_words
from vibecalc.errors import Problem
from vibecalc.study.sweep.axes import SweepAxis
from vibecalc.study.sweep.courses import Course, Drawn, Spread
from vibecalc.study.sweep.design import Design, size_words

_BLOCK = 1 << 18  # values looked through at a time
_SHOWN = 3
_COMPARE = {"gt": np.greater, "ge": np.greater_equal, "lt": np.less, "le": np.less_equal}


def forbidden_values(design: Design) -> Iterator[Problem]:
    """One problem for each key with values outside its bounds; no run is needed for it."""
    column = 0
    for axis in design.axes:
        for index, (shape, course) in enumerate(zip(axis.shapes, axis.courses, strict=True)):
            if not course.names and not np.all(allowed_by(shape, np.array(course.ends))):
                yield from _of_key(design, axis, index, column)
            column += 1


def allowed_by(shape: Shape, values: np.ndarray) -> np.ndarray:
    """Whether each value is finite and within the bounds of its place in a case."""
    allowed = np.isfinite(values)
    for name, bound in shape.bounds:
        allowed &= _COMPARE[name](values, bound)
    return np.asarray(allowed)


def _of_key(design: Design, axis: SweepAxis, index: int, column: int) -> Iterator[Problem]:
    course, shape = axis.courses[index], axis.shapes[index]
    total = course.count if course.count is not None else design.count
    if isinstance(course, Spread) and course.count is not None:
        count, values = _on_spread(course, shape)
    else:
        count, values = _looked_through(design, course, shape, column, total)
    if not count:
        return
    many = f"{count} of {size_words(total)} {'points' if course.count is None else 'values'}"
    if design.sampling == "grid" and len(design.axes) > 1:
        points = count * (design.count // total)
        many += f", {size_words(points)} of {size_words(design.count)} points"
    shown = ", ".join(f"{value:.6g}" for value in values) + (", ..." if count > _SHOWN else "")
    one_sided = isinstance(course, Drawn) and course.scatter.kind == "normal"
    yield Problem(
        path=axis.places[index],
        message=f"{axis.keys[index]} takes values that it must not have",
        found=f"{shown} {shape.unit or ''}".strip() + f" ({many})",
        allowed=bound_words(shape) or "a finite number",
        hint="lognormal and triangular distributions have an end" if one_sided else "",
    )


def _looked_through(
    design: Design, course: Course, shape: Shape, column: int, total: int
) -> tuple[int, np.ndarray]:
    """How many values are forbidden, and the first of them."""
    count, first = 0, np.empty(0)
    for start in range(0, total, _BLOCK):
        numbers = np.arange(start, min(start + _BLOCK, total))
        drawn = course.count is None
        values = design.value_of(numbers)[:, column] if drawn else course.at(numbers)
        wrong = values[~allowed_by(shape, values)]
        count += wrong.size
        first = np.concatenate([first, wrong[:_SHOWN]])[:_SHOWN]
    return count, first


def _on_spread(course: Spread, shape: Shape) -> tuple[int, np.ndarray]:
    """The same for values that only rise or only fall, without looking at all of them."""
    total = course.count or 0
    runs: list[range] = []
    for side in (("gt", "ge"), ("lt", "le")):
        bounds = tuple(bound for bound in shape.bounds if bound[0] in side)
        one_sided = replace(shape, bounds=bounds)

        def kept(position: int, one_sided: Shape = one_sided) -> bool:
            return bool(allowed_by(one_sided, course.at(np.array([position])))[0])

        if not kept(0):
            runs.append(range(bisect_left(range(total), True, key=kept)))
        elif not kept(total - 1):
            first = bisect_left(range(total), True, key=lambda position: not kept(position))
            runs.append(range(first, total))
    wrong = [position for run in runs for position in run[:_SHOWN]][:_SHOWN]
    return sum(len(run) for run in runs), course.at(np.array(wrong, dtype=np.int64))
