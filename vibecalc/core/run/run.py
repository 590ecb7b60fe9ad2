"""One run: the planned stages in their order, each timed; what need not run again is kept."""

import hashlib
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from vibecalc.core.case.load import validate
from vibecalc.core.case.number_range import present, range_problems
from vibecalc.core.case.raw import case_at
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Record
from vibecalc.core.results.steps import step
from vibecalc.core.results.tolerance import tolerance_warning
from vibecalc.core.run.machine_checks import check_machine, checks_of, machine_warnings
from vibecalc.core.run.plan import needed_stages
from vibecalc.core.run.reads import Reads, TracedEntries, traced, walked, written
from vibecalc.core.run.stage import Scene, Stage
from vibecalc.errors import CaseError, NumericalFailure, Problem, dotted
from vibecalc.parts.machine import PARTS, MachineParts, build_machine
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Stages that need not run again, because nothing they read has changed.
#
# What a stage reads is recorded as it runs (`reads.py`). Its key is the content of what an earlier
# run of it has read: exact to the last bit, with the keys of what was handed on to it. Where that
# is the same, each step of the stage would be the same, and so is the result that is taken from
# here.
# ----------------------------------------------------------------------------

MOST_BYTES = 256_000_000
#: of an outcome next to its arrays
OVERHEAD = 4096
#: sets of reads of one stage that are looked up; what the oldest have made is made again
MOST_READS = 8

#: in place of what has been asked for once, and may never be again
_MET = "met"

RunStage = Callable[[Stage, Scene], None]


class Outcome(NamedTuple):
    """What one stage leaves: results, warnings, methods, what it hands on; or why it failed."""

    record: Record
    handed_on: dict[str, Any]
    failure: str | None = None


@dataclass(repr=False, eq=False)
class StageCache:
    """Outcomes of stages by the content of what they read; the oldest ones go first.

    What a stage reads may hang on what it finds: each set of reads that was met is stored.

    `ran` and `reused` count, by the module of a stage, how often it ran and how often it did not
    have to. One cache serves any number of cases.
    """

    most_bytes: int = MOST_BYTES
    ran: dict[str, int] = field(default_factory=dict)
    reused: dict[str, int] = field(default_factory=dict)
    _stored: "OrderedDict[bytes, tuple[Any, int]]" = field(default_factory=OrderedDict)
    _read_sets: dict[Any, dict[bytes, Reads]] = field(default_factory=dict)
    _size: int = 0
    _last: tuple[Case, dict[int, Any]] | None = None

    def at(self, case: Case, wanted: frozenset[str] | None) -> "CachedRun":
        """One run of `case` in which stages are looked up before they run."""
        if self._last is None or self._last[0] is not case:
            self._last = (case, {})
        return CachedRun(self, case, wanted, self._last[1])

    def find(self, key: bytes) -> Any:
        """What is kept under a key, or None; it counts as the youngest then."""
        stored = self._stored.get(key)
        if stored is None:
            return None
        self._stored.move_to_end(key)
        return stored[0]

    def keep(self, key: bytes, value: Any) -> None:
        """Keep a value, its arrays closed to writing; forget the oldest beyond `most_bytes`."""
        size = OVERHEAD
        for one in walked(value):
            if isinstance(one, np.ndarray):
                one.flags.writeable = False
                size += one.nbytes
        self._size += size - self._stored.pop(key, (None, 0))[1]
        self._stored[key] = (value, size)
        while self._size > self.most_bytes and len(self._stored) > 1:
            self._size -= self._stored.popitem(last=False)[1][1]

    def read_sets(self, what: Any) -> dict[bytes, Reads]:
        """The sets of reads known of something that is made, the latest last."""
        return self._read_sets.setdefault(what, {})


class CachedRun:
    """The keys of one run, made as its stages come.

    `known` is what has been looked up of the case, see `Reads.contents`.
    """

    def __init__(
        self,
        cache: StageCache,
        case: Case,
        wanted: frozenset[str] | None,
        known: dict[int, Any],
    ):
        self._cache = cache
        self._case = case
        self._known = known
        self._wanted = None if wanted is None else tuple(sorted(wanted))
        #: what stages have handed on in this run -> key of the stage that did
        self._handed: dict[str, bytes] = {}
        #: what was made once in this run -> its key
        self._once: dict[str, bytes] = {}

    def parts(self) -> MachineParts:
        """The parts of the machine, each built when it is asked for."""
        return self._parts(Reads())

    def run(self, stage: Stage, scene: Scene, run_stage: RunStage) -> None:
        """Add the outcome of a stage to `scene`; `run_stage` makes it where it is not known.

        Raises NumericalFailure as the stage does.
        """
        what = (stage.adapter, self._wanted)
        key, counts = self._find(what), self._cache.reused
        if key is None:
            counts = self._cache.ran
            reads = Reads()
            outcome = self._made(stage, scene, run_stage, reads)
            key = self._keep(what, reads, outcome, outcome.handed_on)
        outcome = self._cache.find(key)
        counts[stage.name] = counts.get(stage.name, 0) + 1
        if outcome.failure is not None:
            raise NumericalFailure(outcome.failure)
        scene.handed_on.update(outcome.handed_on)
        self._handed |= dict.fromkeys(outcome.handed_on, key)
        for quantity in outcome.record.values():
            scene.record.add(quantity)
        for warning in outcome.record.warnings:
            scene.warn(warning)
        for method in outcome.record.methods:
            scene.cite(method.name, method.purpose, method.citation)

    def once(self, name: str, make: Callable[[Case], Any]) -> Any:
        """What `make` makes of the case, or has made of one that is the same to it."""
        key = self._find(name)
        if key is None:
            reads = Reads()
            made = make(traced(self._case, reads))
            key = self._keep(name, reads, made, made)
        self._once[name] = key
        return self._cache.find(key)

    def again(self, name: str, inputs: Sequence[Any], make: Callable[[], Any]) -> Any:
        """What `make` makes of `inputs`, as `Scene.again` says."""
        content = hashlib.blake2b(name.encode(), digest_size=20)
        for one in inputs:
            array = np.ascontiguousarray(one)
            content.update(repr((array.dtype.str, array.shape)).encode())
            content.update(array.tobytes())
        key = content.digest()
        if self._cache.find(key) is None:
            self._cache.keep(key, _MET)
            return None
        if self._cache.find(key) is _MET:
            self._cache.keep(key, make())
        return self._cache.find(key)

    def _made(self, stage: Stage, scene: Scene, run_stage: RunStage, reads: Reads) -> Outcome:
        """Run a stage with a record of its own, so that what it leaves stands apart."""

        def once(name: str, make: Callable[[Case], Any]) -> Any:
            reads.made.add(name)
            return self.once(name, make)

        entries = TracedEntries(scene.handed_on, reads)
        stage_scene = Scene(
            case=traced(scene.case, reads),
            parts=self._parts(reads),
            wanted=scene.wanted,
            handed_on=entries,
            maker=once,
            keeper=self.again,
        )
        try:
            run_stage(stage, stage_scene)
        except NumericalFailure as failure:
            return Outcome(Record(), {}, str(failure))
        return Outcome(stage_scene.record, entries.left)

    def _parts(self, reads: Reads) -> MachineParts:
        return cast(MachineParts, _Parts(self, reads))

    def _find(self, what: Any) -> bytes | None:
        """Key of what is known to be the same, None where nothing is."""
        read_sets = self._cache.read_sets(what)
        for digest in reversed(read_sets):
            key = self._key(what, digest, read_sets[digest])
            if key is not None and self._cache.find(key) is not None:
                read_sets[digest] = read_sets.pop(digest)
                return key
        return None

    def _keep(self, what: Any, reads: Reads, value: Any, handed_on: Any) -> bytes:
        digest = reads.close(handed_on)
        read_sets = self._cache.read_sets(what)
        read_sets[digest] = read_sets.pop(digest, reads)
        if len(read_sets) > MOST_READS:
            del read_sets[next(iter(read_sets))]
        key = self._key(what, digest, reads)
        assert key is not None  # all that was read is there
        self._cache.keep(key, value)
        return key

    def _key(self, what: Any, digest: bytes, reads: Reads) -> bytes | None:
        """Key of what is made by reading that; None where a part of that is not made yet."""
        contents = reads.contents(self._case, self._known)
        if contents is None:
            return None
        # what was made in this run counts, even if it is forgotten by now
        made = [self._once.get(name) or self._find(name) for name in sorted(reads.made)]
        if None in made:
            return None
        handed = [self._handed.get(name) for name in sorted(reads.handed)]
        content = written((what, digest, contents, handed, made))
        return hashlib.blake2b(content, digest_size=20).digest()


class _Parts:
    """The parts of a machine, each made when it is read, and noted then."""

    def __init__(self, run: CachedRun, reads: Reads):
        self.__dict__["_run"] = (run, reads)

    def __getattr__(self, name: str) -> Any:
        run, reads = self.__dict__["_run"]
        part = f"parts.{name}"
        reads.made.add(part)
        self.__dict__[name] = run.once(part, PARTS[name])
        return self.__dict__[name]


# ----------------------------------------------------------------------------
# The checks of physics for studies that change a case thousands of times, a little each time.
#
# A check that found nothing finds nothing again where all that it read is the same. As soon as one
# finds something, all of them run, so that the problems are those of `check_machine`, every time.
# ----------------------------------------------------------------------------


def check_again(case: Case, cache: StageCache) -> list[Problem]:
    """`check_machine` with what `cache` knows of earlier cases."""
    now = cache.at(case, None)
    for place in present(case):
        if now.once(f"range of {dotted(place)}", partial(range_problems, places=(place,))):
            return check_machine(case)
    first, last = checks_of(case)
    for check in (*first, *last):
        if now.once(check.__name__, check):
            return check_machine(case)
    return []


def checked_case(
    resolved: Mapping[str, Any], settings: Mapping[str, Any], cache: StageCache
) -> Case:
    """A case in SI with some keys set, checked again; CaseError if it is not a case."""
    case = validate(case_at(resolved, settings))
    problems = check_again(case, cache)
    if problems:
        raise CaseError(problems)
    return case


# ----------------------------------------------------------------------------
# One run: the planned stages in their order, each timed, into one record.
# ----------------------------------------------------------------------------


def run_case(case: Case, **options: Any) -> Record:
    """Run the stages that `case` asks for and keep their results; see `run_scene`."""
    return run_scene(case, **options).record


def run_scene(
    case: Case,
    *,
    timings: dict[str, float] | None = None,
    wanted: frozenset[str] | None = None,
    cache: StageCache | None = None,
    tell: Callable[[str], None] | None = None,
) -> Scene:
    """Run the stages that `case` asks for, with what they handed on to each other.

    Parameters
    ----------
    case : a case whose form, physics and targets have been checked.
    timings : filled with seconds per stage.
    wanted : result paths to compute, for studies that run a case many times; None is all.
    cache : outcomes of stages of earlier runs, taken where nothing that a stage reads has changed;
        the results are the same to the last bit.
    tell : called with the name of each stage as it begins.

    Raises
    ------
    NumericalFailure : when a quantity has no trustworthy value.
    """
    started = time.perf_counter()
    cached = None if cache is None else cache.at(case, wanted)
    parts = cached.parts() if cached else build_machine(case)
    scene = Scene(case=case, parts=parts, wanted=wanted)
    clock = timings if timings is not None else {}
    if wanted is None:
        for warning in machine_warnings(case):
            scene.warn(warning)
    clock["machine"] = time.perf_counter() - started
    for stage in needed_stages(case, wanted):
        started = time.perf_counter()
        if tell is not None:
            tell(stage.name)
        if cached is None:
            run_stage(stage, scene)
        else:
            cached.run(stage, scene, run_stage)
        clock[stage.name] = time.perf_counter() - started
        if cached is None:  # studies run stages again and again
            step(f"stage {stage.name}: {clock[stage.name]:.3f} s")
    if wanted is None:
        missed = tolerance_warning(scene.record, case.accuracy.rtol)
        if missed is not None:
            scene.warn(missed)
    return scene


def run_stage(stage: Stage, scene: Scene) -> None:
    """Run one adapter; an overflow or an undefined operation on the way is a failure, not a NaN."""
    adapter = named(stage.adapter)
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
            adapter(scene)
    except (FloatingPointError, OverflowError) as error:
        raise NumericalFailure(
            f"the stage {stage.name!r} left the range of double precision ({error}): "
            "some masses, lengths, stiffnesses or speeds of the case are too far apart"
        ) from error
