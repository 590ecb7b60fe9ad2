"""Points of a sweep by array calls, and the few that need it by single runs."""

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import key_text, parse_key
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import DONE
from vibecalc.core.results.named import named
from vibecalc.core.run.columns import Column, Varied, case_at_points, out_of_range, run_points
from vibecalc.core.run.plan import needed_stages, plan_case
from vibecalc.core.study.sweep.blocks import (
    Block,
    BlockQuantity,
    at_one_point,
    laid_out,
    make_block,
)
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.evaluate import Evaluator, Quantities
from vibecalc.errors import KeyPath, NumericalFailure, PointsApart
from vibecalc.numerics.rounding import BoolArray, IntArray

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Which results over which keys arrays give: as the stages of the case say it.
# ----------------------------------------------------------------------------


def unsupported(case: "Case", keys: Collection[KeyPath], keep: Collection[str]) -> str | None:
    """Why arrays cannot compute the results `keep` of `case` over `keys`, or None if they can."""
    if case.optimisation is not None:
        return "each point is optimised"
    plan = plan_case(case)
    leading = [stage.leading for stage in plan if stage.leading is not None]
    known = frozenset().union(*(one.keys for one in leading))
    for path in keep:
        made = [stage.leading for stage in plan if path in stage.quantities]
        if not made:
            return f"no table of the case asks for {path}"
        if made[0] is None or (made[0].only and path not in made[0].only):
            return f"{path} is computed point by point"
    for key in keys:
        if pattern(key) not in known:
            return f"{key_text(key)} is not among the numbers that arrays can vary"
        if not _is_number(case, key):
            return f"{key_text(key)} is not a number in the case as written"
    return next((one.why_not for one in leading if one.why_not), None)


def pattern(key: KeyPath) -> str:
    """A key as stages name it: positions in lists left out."""
    return key_text(key).translate({ord(digit): None for digit in "0123456789"})


def _is_number(case: "Case", key: KeyPath) -> bool:
    """Whether the case has a number there, so that setting it changes no other choice."""
    found: Any = case
    for part in key:
        if isinstance(part, int):
            found = found[part] if isinstance(found, tuple) and part < len(found) else None
        else:
            found = getattr(found, part, None)
    return isinstance(found, float)


# ----------------------------------------------------------------------------
# Results of one case at many points, in blocks that bound the memory.
# ----------------------------------------------------------------------------

#: a block this small that fails is left to single runs
_SMALLEST = 8


class Part(NamedTuple):
    """Some of the points (n,), by their places, with what was found."""

    places: IntArray
    columns: Mapping[str, Column]


def compute(
    case: "Case", varied: Varied, count: int, keep: frozenset[str]
) -> tuple[list[Part], IntArray]:
    """Results `keep` at `count` points, and the places of the points that need a single run.

    `varied` maps key paths to values (count,). `unsupported` has to have nothing against it. A
    point needs a single run if a check may refuse it, if an order may stand on an undamped
    resonance, or if something in its arithmetic goes wrong: the single run then says what.
    """
    stages = needed_stages(case, keep)
    size = min(stage.leading.most for stage in stages if stage.leading is not None)
    uncertain = suspects(case, varied, count)
    clear, left = np.flatnonzero(~uncertain), [np.flatnonzero(uncertain)]
    parts: list[Part] = []
    waiting = [clear[start : start + size] for start in range(0, len(clear), size)][::-1]
    while waiting:
        places = waiting.pop()
        try:
            some = {key: values[places] for key, values in varied.items()}
            scene = run_points(case, stages, some, len(places), keep)
        except PointsApart as apart:
            alone = np.broadcast_to(apart.alone, len(places))
            left.append(places[alone])
            waiting += [
                places[(apart.kinds == kind) & ~alone] for kind in np.unique(apart.kinds[~alone])
            ]
        except NumericalFailure:
            if len(places) <= _SMALLEST:
                left.append(places)
            else:
                half = len(places) // 2
                waiting += [places[half:], places[:half]]
        else:
            left.append(places[scene.alone])
            parts.append(_part(places, scene.columns, ~scene.alone))
    return parts, np.sort(np.concatenate(left))


def _part(places: IntArray, columns: Mapping[str, Column], kept: BoolArray) -> Part:
    if kept.all():
        return Part(places, columns)
    chosen = {
        path: column._replace(values=column.values[kept], errors=column.errors[kept])
        for path, column in columns.items()
    }
    return Part(places[kept], chosen)


def suspects(case: "Case", varied: Varied, count: int) -> BoolArray:
    """Points (points,) that a check may refuse, as the stages of the case tell."""
    found = out_of_range(varied, count)
    at_points = case_at_points(case, varied)
    checks = [where for s in plan_case(case) if s.leading for where in s.leading.suspects]
    with np.errstate(all="ignore"):
        for where in dict.fromkeys(checks):
            found |= named(where)(at_points)
    return found


# ----------------------------------------------------------------------------
# Points of a sweep: their numbers from the design, their results as a block.
# ----------------------------------------------------------------------------


class ArrayEvaluator(Evaluator):
    """From point numbers to results, where `unsupported` has nothing against it.

    A point that fails, or may fail, is run alone: its status and message are those of that run.
    """

    def __init__(self, loaded: LoadedCase, design: Design, keep: Sequence[str]):
        super().__init__(loaded, design, keep)
        self._paths = {key: parse_key(key) for key in design.keys}

    def run_points(self, indices: np.ndarray) -> Block:
        """As `Evaluator.run_points`."""
        numbers = np.asarray(indices, dtype=np.int64)
        settings = self._design.columns(numbers)
        varied = {self._paths[key]: np.asarray(v, dtype=float) for key, v in settings.items()}
        count, keep = len(numbers), frozenset(self._keep)
        parts, left = compute(self._loaded.case, varied, count, keep)
        alone = [
            self.run_point({key: values[place].item() for key, values in settings.items()})
            for place in left
        ]
        status = np.full(count, DONE, dtype=np.int8)
        message = [""] * count
        for place, (code, text, _) in zip(left, alone, strict=True):
            status[place], message[place] = code, text
        if not parts:
            return make_block(numbers, status, message, [one[2] for one in alone], self._keep)
        single = [one[2] for one in alone]
        results = {path: _joined(path, parts, left, single, numbers) for path in self._keep}
        return Block(numbers, status, tuple(message), results)


def _joined(
    path: str,
    parts: Sequence[Part],
    left: IntArray,
    alone: Sequence[Quantities],
    numbers: np.ndarray,
) -> BlockQuantity:
    """One quantity of all parts and single runs; a point without it is NaN."""
    entry = CATALOGUE[path]
    told = (entry.unit, entry.long_name, entry.amplitude)
    columns = [(part.places, part.columns[path]) for part in parts]
    pieces = [(places, BlockQuantity(one.values, one.errors, None, one.axes, *told))
              for places, one in columns]  # fmt: skip
    pieces += [
        (np.array([place]), at_one_point(results[path]))
        for place, results in zip(left, alone, strict=True)
        if path in results
    ]
    whole = laid_out(pieces, numbers)
    if isinstance(whole, str):
        raise ValueError(f"{path}: {whole}")
    return whole
