"""Results of one case at many points by arrays: whether they can be had so, and which cannot."""

from collections.abc import Collection, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.fields import Table
from vibecalc.core.run.columns import (
    Column,
    Varied,
    case_at_points,
    case_untouchable,
    out_of_range,
    reads,
    run_points,
)
from vibecalc.core.run.machine_checks import Check, checks_of, suspects_of
from vibecalc.core.run.plan import needed_stages, plan_case
from vibecalc.core.run.run import StageCache
from vibecalc.core.run.stage import Stage
from vibecalc.errors import KeyPath, NumericalFailure, PointsApart, dotted
from vibecalc.numerics.rounding import BoolArray, IntArray
from vibecalc.parts.machine import PARTS
from vibecalc.parts.mount_needs import why_alone
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Which results over which keys arrays give: as the stages of the case say it.
# ----------------------------------------------------------------------------


def unsupported(case: Case, keys: Collection[KeyPath], keep: Collection[str]) -> str | None:
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
            return f"{dotted(key)} is not among the numbers that arrays can vary"
        if not _is_number(case, key):
            return f"{dotted(key)} is not a number in the case as written"
    alone = why_alone(case)
    if alone and reads(PARTS["mounts"], case_untouchable(case, keys)):
        return alone
    for stage in needed_stages(case, frozenset(keep)):
        own = frozenset() if stage.leading is None else stage.leading.keys
        takes = known if stage.leading is not None and stage.leading.takes_all else own
        if any(_may_read(stage, key) for key in keys if pattern(key) not in takes):
            return f"{stage.name} is computed point by point"
        if stage.leading is not None and stage.leading.why_not:
            return stage.leading.why_not
    return None


def _may_read(stage: Stage, key: KeyPath) -> bool:
    """Whether a stage may depend on a key: not on other parts of the machine than its own."""
    return key[0] != "machine" or len(key) < 3 or key[1] in stage.parts


def pattern(key: KeyPath) -> str:
    """A key as stages name it: positions in lists left out."""
    return dotted(key).translate({ord(digit): None for digit in "0123456789"})


def _is_number(case: Case, key: KeyPath) -> bool:
    """Whether the case has a number there, so that setting it changes no other choice.

    A default is none in a table with rules, which may not let the key be written there.
    """
    found: Any = case
    written = True
    for part in key:
        if isinstance(part, int):
            found = found[part] if isinstance(found, tuple) and part < len(found) else None
        else:
            ruled = isinstance(found, Table) and bool(found.RULES)
            written = not ruled or part in found.model_fields_set
            found = getattr(found, part, None)
    return isinstance(found, float) and written


# ----------------------------------------------------------------------------
# Results of one case at many points, in blocks that bound the memory.
# ----------------------------------------------------------------------------

#: a block this small that fails is left to single runs
_SMALLEST = 8


class Part(NamedTuple):
    """Some of the points (n,), by their places, with what was found."""

    places: IntArray
    columns: Mapping[str, Column]

    def some(self, kept: BoolArray) -> "Part":
        """Those of the points that are `kept` (n,)."""
        if kept.all():
            return self
        chosen = {
            path: column._replace(values=column.values[kept], errors=column.errors[kept])
            for path, column in self.columns.items()
        }
        return Part(self.places[kept], chosen)


class Plan(NamedTuple):
    """What computing at points asks of a case alone, for who does so again and again.

    `checks`, first ones and last ones, are those which read a number that varies.
    """

    stages: tuple[Stage, ...]
    checks: tuple[list[Check], ...]


def planned(case: Case, keep: frozenset[str], keys: Collection[KeyPath]) -> Plan:
    """The plan of a case over `keys`."""
    untouchable = case_untouchable(case, keys)
    checks = [[one for one in ones if reads(one, untouchable)] for ones in checks_of(case)]
    return Plan(needed_stages(case, keep), tuple(checks))


def compute(
    case: Case,
    varied: Varied,
    count: int,
    keep: frozenset[str],
    plan: Plan | None = None,
    cache: StageCache | None = None,
) -> tuple[list[Part], IntArray]:
    """Results `keep` at `count` points, and the places of the points that need a single run.

    `varied` maps key paths to values (count,). `unsupported` has to have nothing against it. A
    point needs a single run if a check may refuse it, if an order may stand on an undamped
    resonance, or if something in its arithmetic goes wrong: the single run then says what.
    """
    stages, checks = plan or planned(case, keep, varied)
    size = min(stage.leading.most for stage in stages if stage.leading is not None)
    uncertain = suspects(case, varied, count, checks)
    clear, left = np.flatnonzero(~uncertain), [np.flatnonzero(uncertain)]
    parts: list[Part] = []
    waiting = [clear[start : start + size] for start in range(0, len(clear), size)][::-1]
    while waiting:
        places = waiting.pop()
        try:
            some = {key: values[places] for key, values in varied.items()}
            scene = run_points(case, stages, some, len(places), keep, cache)
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
            parts.append(Part(places, scene.columns).some(~scene.alone))
    return parts, np.sort(np.concatenate(left))


def suspects(
    case: Case, varied: Varied, count: int, checks: Iterable[Collection[Check]]
) -> BoolArray:
    """Points (points,) that one of the checks, first ones and last ones, may refuse.

    Also those of what is not computed count, since a run of one point makes them as well.
    """
    found = out_of_range(varied, count)
    at_points, told = case_at_points(case, varied), suspects_of(case)
    for some in checks:
        one_by_one: list[Check] = []
        for check in some:
            with np.errstate(all="ignore"):
                refused = told[check](at_points) if check in told else None
            if refused is None:
                one_by_one.append(check)
            else:
                found |= refused
        for place in np.flatnonzero(~found) if one_by_one else ():
            point = case_at_points(case, {key: v[place].item() for key, v in varied.items()})
            found[place] = any(check(point) for check in one_by_one)
    return found
