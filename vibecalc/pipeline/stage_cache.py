"""Stages that need not run again, because nothing they read has changed.

The key of a stage is the content of what `reads.py` says that it reads: exact to the last bit, and
the keys of the stages that hand something on to it. So a result that is taken from the cache is the
one that the stage would make again.
"""

import hashlib
import marshal
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.machine.build import MachineParts, build_machine
from vibecalc.pipeline.reads import PARTS, READS, SHARED
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_plan import StagePlan
from vibecalc.results.record import Record

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

MOST_BYTES = 256_000_000
#: of an outcome beside its arrays
OVERHEAD = 4096

RunStage = Callable[[StagePlan, Scene], None]


@dataclass(frozen=True)
class Outcome:
    """What one stage leaves: results, warnings, methods, what it hands on; or why it failed."""

    record: Record
    handed_on: dict[str, Any]
    failure: str | None = None


@dataclass
class StageCache:
    """Outcomes of stages by the content of what they read; the oldest ones go first.

    `ran` and `reused` count, by the module of a stage, how often it ran and how often it did not
    have to. One cache serves any number of cases.
    """

    most_bytes: int = MOST_BYTES
    ran: dict[str, int] = field(default_factory=dict)
    reused: dict[str, int] = field(default_factory=dict)
    _kept: "OrderedDict[bytes, tuple[Any, int]]" = field(default_factory=OrderedDict)
    _size: int = 0
    _last: "tuple[Case, dict[str, Any]] | None" = None

    def at(self, case: "Case", wanted: frozenset[str] | None) -> "CachedRun":
        """One run of `case` in which stages are looked up before they run."""
        if self._last is None or self._last[0] is not case:
            self._last = (case, {})
        return CachedRun(self, case, wanted, self._last[1])

    def find(self, key: bytes) -> Any:
        """What is kept under a key, or None; it counts as the youngest then."""
        found = self._kept.get(key)
        if found is None:
            return None
        self._kept.move_to_end(key)
        return found[0]

    def keep(self, key: bytes, value: Any) -> None:
        """Keep a value, its arrays closed to writing; forget the oldest beyond `most_bytes`."""
        size = OVERHEAD
        for array in _arrays(value):
            array.flags.writeable = False
            size += array.nbytes
        self._size += size - self._kept.pop(key, (None, 0))[1]
        self._kept[key] = (value, size)
        while self._size > self.most_bytes and len(self._kept) > 1:
            self._size -= self._kept.popitem(last=False)[1][1]


class CachedRun:
    """The keys of one run, made as its stages come.

    `contents` is what has been looked up of the case, by place.
    """

    def __init__(
        self,
        cache: StageCache,
        case: "Case",
        wanted: frozenset[str] | None,
        contents: dict[str, Any],
    ):
        self._cache = cache
        self._case = case
        self._contents = contents
        self._wanted = None if wanted is None else tuple(sorted(wanted))
        self._keys: dict[str, bytes] = {}

    def parts(self) -> MachineParts:
        """The parts of the machine."""
        key = self.key("parts", PARTS)
        parts = self._cache.find(key)
        if parts is None:
            parts = build_machine(self._case.machine, self._case.excitation)
            self._cache.keep(key, parts)
        found: MachineParts = parts
        return found

    def run(self, stage: StagePlan, scene: Scene, run_stage: RunStage) -> None:
        """Add the outcome of a stage to `scene`; `run_stage` makes it where it is not known.

        Raises NumericalFailure as the stage does.
        """
        reads = READS[stage.module]
        after = tuple(self._keys.get(name, b"") for name in reads.after)
        key = self.key(stage.module, reads.case, self._wanted, after)
        self._keys[stage.stage] = key
        outcome, counts = self._cache.find(key), self._cache.reused
        if outcome is None:
            outcome, counts = self._made(stage, scene, run_stage), self._cache.ran
            self._cache.keep(key, outcome)
        counts[stage.module] = counts.get(stage.module, 0) + 1
        if outcome.failure is not None:
            raise NumericalFailure(outcome.failure)
        scene.handed_on.update(outcome.handed_on)
        for quantity in outcome.record.values():
            scene.record.add(quantity)
        for warning in outcome.record.warnings:
            scene.warn(warning)
        for method in outcome.record.methods:
            scene.cite(method.name, method.purpose, method.citation)

    def _made(self, stage: StagePlan, scene: Scene, run_stage: RunStage) -> Outcome:
        """Run a stage with a record of its own, so that what it leaves stands apart."""
        shared = {name: self.key(name, reads) for name, reads in SHARED.items()}
        known = {name: self._cache.find(key) for name, key in shared.items()}
        before = scene.handed_on | {name: one for name, one in known.items() if one is not None}
        own = Scene(case=scene.case, parts=scene.parts, wanted=scene.wanted, handed_on=dict(before))
        try:
            run_stage(stage, own)
        except NumericalFailure as failure:
            return Outcome(Record(), {}, str(failure))
        left = {name: one for name, one in own.handed_on.items() if before.get(name) is not one}
        for name in SHARED.keys() & left.keys():
            self._cache.keep(shared[name], left.pop(name))
        return Outcome(own.record, left)

    def key(self, what: str, places: tuple[str, ...], *more: Any) -> bytes:
        """Key of something that is made from what stands at some places of the case."""
        contents = [self.content(place) for place in places]
        # version 2 writes every double in full and knows no references between equal objects
        written = marshal.dumps((what, contents, more), 2)
        return hashlib.blake2b(written, digest_size=20).digest()

    def content(self, place: str) -> Any:
        """What stands at a place of the case as plain values; `...` where a table is absent."""
        if place not in self._contents:
            found: Any = self._case
            for name in place.split("."):
                found = ... if found is None or found is ... else getattr(found, name)
            self._contents[place] = _plain(found)
        return self._contents[place]


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump"):
        return value.model_dump()
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return value


def _arrays(value: Any) -> list[np.ndarray]:
    """All arrays in tuples, lists, dicts and dataclasses."""
    found, left = [], [value]
    while left:
        one = left.pop()
        if isinstance(one, np.ndarray):
            found.append(one)
        elif isinstance(one, tuple | list):
            left += one
        elif isinstance(one, dict):
            left += one.values()
        elif is_dataclass(one):
            left += vars(one).values()
    return found
