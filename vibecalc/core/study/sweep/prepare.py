"""What a sweep will do: points, how they are computed, what is kept, and its identity."""

import difflib
import hashlib
import json
import math
import os
import re
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from vibecalc import __version__
from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.raw import parse_key
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import DONE
from vibecalc.core.results.visible import fits_a_line
from vibecalc.core.run.plan import needed_stages, work_seconds
from vibecalc.core.run.stage import work_of
from vibecalc.core.study.sweep.blocks import Block, combined
from vibecalc.core.study.sweep.checks import stored_paths
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.errors import UnitError, UsageError, dotted
from vibecalc.schema import SCHEMA_VERSION, Case
from vibecalc.units import split_number

# ----------------------------------------------------------------------------
# How a sweep is computed: by arrays, in one process, or by many.
# ----------------------------------------------------------------------------

Kind = Literal["array", "reuse", "pool"]

_SEARCH = 1000.0  # runs of an optimisation
_CHECKS = 0.5
#: milliseconds of work that are not worth starting processes for
_SHORT = 2000.0
_CHUNK = 5000.0
_MOST_POINTS = 256
_ARRAY_POINTS = 4096
_MOST_CHUNKS = 10_000
_FEWEST_CHUNKS = 16


class Strategy(NamedTuple):
    """The kind of evaluation, in words why, and how many points one chunk has.

    `chunk_size` depends on the case, the design and what is kept, never on the number of processes.
    `milliseconds` is roughly what a point takes, 0 for arrays that take next to nothing.
    """

    kind: Kind
    reason: str
    chunk_size: int
    milliseconds: float = 0.0


def choose(case: Case, design: Design, keep: Sequence[str], jobs: int = 2) -> Strategy:
    """The fastest way that gives the results `keep` at all points; `jobs` processes are allowed.

    Arrays where all results are closed forms over the keys that vary. Else one process, in which
    stages run again only where something that they read has changed, if there may be no more or
    all points take less time than processes take to start; else processes that each do the same.
    """
    from vibecalc.core.study.sweep.at_once import unsupported

    why_not = unsupported(case, [parse_key(key) for key in design.keys], keep)
    if any(key.values.contents for key in design.every):
        why_not = "lists, tables and switches are set point by point"
    stages = needed_stages(case, frozenset(keep))
    share, fewest = -(-design.count // _FEWEST_CHUNKS), -(-design.count // _MOST_CHUNKS)
    if why_not is None:
        words = "all that is kept is computed for many points at once"
        leading = [stage.leading for stage in stages if stage.leading]
        cost, size = sum(one.milliseconds for one in leading), _ARRAY_POINTS
        if cost:
            size = min(size, max(min(one.most for one in leading), share))
        return Strategy("array", words, max(size, fewest), cost)
    # roughly what the stages take that have to run for what is kept
    seconds = sum(work_seconds(work_of(case, stage)) for stage in stages)
    cost = _CHECKS + 1e3 * seconds * (1.0 if case.optimisation is None else _SEARCH)
    size = max(fewest, min(_MOST_POINTS, max(1, round(_CHUNK / cost)), share))
    kind: Kind = "reuse"
    words = "one process"
    if jobs > 1 and cost * design.count < _SHORT:
        words = "all points take less time than processes to start"
    elif jobs > 1:
        kind, words = "pool", f"{jobs} processes"
    return Strategy(kind, f"{words}; no arrays: {why_not}", size, cost)


# ----------------------------------------------------------------------------
# How a sweep is asked for, and what is said of it in the end.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Options:
    """How a sweep is computed; none of it changes a number of the result.

    jobs
        Processes; None leaves it to the strategy.
    timeout
        Seconds that one point may take.
    resume, fresh
        Take up the chunks that are there; throw away what is there and does not fit.
    again
        Compute the points also where the output has them all.
    shard
        (i, n): only the i-th of n parts, from 1.
    cluster
        Scheduler of a dask cluster, address or file.
    note
        Called with what a person should know on the way.
    """

    output: Path
    jobs: int | None = None
    timeout: float | None = None
    resume: bool = False
    fresh: bool = False
    again: bool = False
    shard: tuple[int, int] = (1, 1)
    cluster: str | None = None
    progress: bool = False
    note: Callable[[str], None] = field(default=lambda _: None)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What came of a sweep: points by status, and how many of them were there from before."""

    counts: Mapping[int, int]
    taken_up: int
    seconds: float = 0.0

    @property
    def failed(self) -> int:
        """Points that were run and have no result."""
        return sum(many for status, many in self.counts.items() if status > DONE)


def shard_chunks(chunks: int, shard: tuple[int, int]) -> range:
    """Numbers of the chunks of one part: every n-th, so that no part has all the slow ones."""
    part, parts = shard
    return range(part - 1, chunks, parts)


def parse_shard(text: str | None) -> tuple[int, int]:
    """Read `I/N`; UsageError if it is not that."""
    if text is None:
        return 1, 1
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise UsageError(f"--shard needs I/N with I from 1 to N, as in 2/8; found {text[:40]!r}")
    return int(match[1]), int(match[2])


def seconds_allowed(timeout: float) -> float:
    """The seconds that a point may take; UsageError for a number that is none."""
    if not (math.isfinite(timeout) and timeout > 0.0):
        raise UsageError(f"--timeout needs a number of seconds above 0, found {timeout:g}")
    return timeout


def processors() -> int:
    """How many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# ----------------------------------------------------------------------------
# Axes and samplings written on the command line, turned into the tables of `[sweep]`.
#
# machine.speed=2000 rpm:4000 rpm:21        21 values in equal steps
# machine.mounts.each.stiffness=5 N/mm:50 N/mm:21log   in equal ratios
# machine.mounts.each.stiffness=5 N/mm:50 N/mm         a range to draw from
# response.method=modal,direct              these values
# machine.crank_train.firing_order=[1,3,2],[1,2,3]     these lists, each as one value
# machine.mounts.each.name="a, b","c"       texts in quotes; with quotes, [ or { all values are TOML
# ----------------------------------------------------------------------------

#: what only values in TOML have
_TOML = re.compile("""["'\\[{]""")
_RANGE = re.compile(r"([^:]+):([^:]+)(?::\s*(?=\S)(\d{1,18})?\s*(log|linear)?\s*)?")
#: two ends of a range in one value, as other programs write them: 20 N/mm-120 N/mm, 0.1..0.2
_TWO_ENDS = re.compile(r"\.\.|[-\u2013]\s*[0-9.]+\s*[A-Za-z]\S*$")
_LONGEST = 20_000
_EXAMPLES = (
    "key=5 N/mm:50 N/mm:21, key=5 N/mm:50 N/mm:21log, key=2 kg,3 kg,5 kg or key=[1,3,2],[1,2,3]"
)


def axis_table(text: str, option: str = "--grid") -> dict[str, Any]:
    """Read `key=SPEC` as one table of `sweep.axes`; UsageError if it is not of that form."""
    key, _, spec = text.partition("=")
    if not spec.strip() or len(text) > _LONGEST or not fits_a_line(text):
        raise UsageError(f"{option} needs {_EXAMPLES}; found {text[:80]!r}")
    table: dict[str, Any] = {"key": dotted(parse_key(key.strip()))}
    said = f"{option} {text[:80]}"
    if _TOML.search(spec):
        try:
            values = tomllib.loads(f"x = [{spec}]")["x"]
        except (ValueError, RecursionError):
            raise UsageError(f"{said}: this is not TOML, expected {_EXAMPLES}") from None
        if len(values) == 1 and isinstance(values[0], list):
            values = values[0]
    elif ":" not in spec:
        values = [value.strip() for value in spec.split(",")]
    elif match := _RANGE.fullmatch(spec):
        values = [match[1].strip(), match[2].strip()]
        names = ("from", "to", "points", "spacing")
        given = (*values, match[3] and int(match[3]), match[4])
        table |= {name: one for name, one in zip(names, given, strict=True) if one is not None}
    else:
        raise UsageError(f"{said}: expected start:stop:points, as in {_EXAMPLES}")
    if any(_TWO_ENDS.search(str(one)) for one in values):
        raise UsageError(f"{said}: expected start:stop:points, as in {_EXAMPLES}")
    if "" in values:
        raise UsageError(f"{said}: a value is missing, expected {_EXAMPLES}")
    _refuse_mixed_units(values, said)
    return table if "from" in table else {**table, "values": values}


def _refuse_mixed_units(values: Sequence[Any], said: str) -> None:
    """A bare number is in SI; next to one with a unit it was hardly meant so."""
    try:
        written = [split_number(str(one)) for one in values]
    except UnitError:
        return
    units = {bool(unit) for number, unit in written if unit or re.search("[1-9]", number)}
    if len(units) > 1:
        example = next(one for one, (_, unit) in zip(values, written, strict=True) if unit)
        raise UsageError(f"{said}: give every value its unit, as in {example!r}")


def axis_tables(
    grid: Sequence[dict[str, Any]], zipped: Sequence[dict[str, Any]] = ()
) -> list[dict[str, Any]]:
    """Tables of `sweep.axes`: those of `grid`, then one with all of `zipped`."""
    if not zipped:
        return [*grid]
    first, *others = zipped
    return [*grid, {**first, "in_step": others} if others else first]


def sampling_table(text: str) -> dict[str, Any]:
    """Read `METHOD:N` or `METHOD:N:SEED` as keys of `[sweep]`; UsageError if it is not that."""
    method, *numbers = (part.strip() for part in text.split(":"))
    known = [name for name in get_args(Sweep.model_fields["sampling"].annotation) if name != "grid"]
    if method not in known:
        near = difflib.get_close_matches(method, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise UsageError(f"--sample {text[:80]}: no sampling {method[:40]!r}{hint} "
                         f"(there are {', '.join(known)})")  # fmt: skip
    if len(numbers) not in (1, 2) or not all(re.fullmatch(r"[0-9]{1,18}", n) for n in numbers):
        raise UsageError(f"--sample {text[:80]}: expected METHOD:POINTS or METHOD:POINTS:SEED")
    table: dict[str, Any] = {"sampling": method, "points": int(numbers[0])}
    if len(numbers) == 2:
        table["seed"] = int(numbers[1])
    return table


# ----------------------------------------------------------------------------
# What the command line says of a sweep, as overrides of the table `[sweep]` of a case.
# ----------------------------------------------------------------------------


def sweep_settings(
    grid: Sequence[str], zipped: Sequence[str], sample: str | None, keep: Sequence[str]
) -> list[str]:
    """Texts `key=value`, as `--set` takes them; UsageError for one that cannot be read.

    Axes on the command line take the place of those of the case, and so do kept quantities.
    """
    settings = []
    together = [axis_table(text, "--zip") for text in zipped]
    tables = axis_tables([axis_table(text) for text in grid], together)
    if tables:
        # one by one, since each text of an override has its longest length
        settings.append(f"sweep.axes=[{', '.join(['{}'] * len(tables))}]")
        settings += [f"sweep.axes[{i}]={_toml(table)}" for i, table in enumerate(tables)]
    if sample is not None:
        settings += [f"sweep.{key}={_toml(value)}" for key, value in sampling_table(sample).items()]
    if keep:
        settings.append(f"sweep.keep={_toml(list(keep))}")
    return settings


#: a value as TOML, which has `=` where JSON has a colon
_toml = partial(json.dumps, ensure_ascii=False, separators=(", ", " = "))


# ----------------------------------------------------------------------------
# Hashes that name a sweep: the same input, the same hash, on every machine.
# ----------------------------------------------------------------------------


def identify(resolved: Mapping[str, Any], design: Design, keep: Sequence[str]) -> str:
    """SHA-256 of a sweep over a case in SI with its defaults, its design, what is kept, and the
    versions of schema and program; the order of `keep` is no matter."""
    content = {
        "case": {name: table for name, table in resolved.items() if name != "sweep"},
        "design": design.description(),
        "keep": sorted(set(keep)),
        "schema": SCHEMA_VERSION,
        "vibecalc": __version__,
    }
    # a double is its shortest decimal form
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


# ----------------------------------------------------------------------------
# A case with `[sweep]` made ready: its points, what is kept, how it is computed, what it is.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class PreparedSweep:
    """A sweep that can start."""

    loaded: LoadedCase
    design: Design
    keep: tuple[str, ...]
    identity: str
    strategy: Strategy

    def journal(self, output: Path) -> Journal:
        """The journal of the sweep that becomes `output`."""
        return Journal(
            path=output.with_name(f"{output.name}.chunks"),
            identity=self.identity,
            count=self.design.count,
            size=self.strategy.chunk_size,
        )

    def start(self) -> Callable[[], Callable[[Any], Any]]:
        """What a process starts with."""
        from vibecalc.core.study.sweep.evaluate import ArrayEvaluator, Evaluator

        kind = ArrayEvaluator if self.strategy.kind == "array" else Evaluator
        return partial(kind, self.loaded, self.design, self.keep)

    @property
    def is_short(self) -> bool:
        """Whether it is over before processes have started."""
        return self.strategy.milliseconds * self.design.count < _SHORT

    @property
    def step(self) -> int:
        """Points in one call."""
        return self.strategy.chunk_size if self.strategy.kind == "array" else 1


def prepare(loaded: LoadedCase, jobs: int) -> PreparedSweep:
    """The sweep of a checked case that may use so many processes."""
    case, resolved = loaded.case, loaded.resolved
    if case.sweep is None or not case.sweep.axes:
        raise UsageError(
            f"{loaded.path} does not say what to vary: it needs a table [sweep] with axes, or give "
            "them here, as in --grid 'machine.speed=2000 rpm:4000 rpm:21'"
        )
    design = make_design(case.sweep, resolved)
    keep = stored_paths(case.sweep.keep, case, design, loaded.base(design.keys))
    return PreparedSweep(
        loaded=loaded,
        design=design,
        keep=keep,
        identity=identify(resolved, design, keep),
        strategy=choose(case, design, keep, jobs),
    )


# ----------------------------------------------------------------------------
# What a sweep will be, before it is: points tried, shapes, time and size.
# ----------------------------------------------------------------------------

_PATIENCE = 2.0  # seconds for points that are only tried
_TRIED = 5


def forecast(prepared: PreparedSweep, options: Options) -> dict[str, Any]:
    """Compute a few points, spread over the sweep, and multiply: what `--dry-run --json` prints.

    `failures` are the words of those of the `tried` points that came to nothing; `axes` of what is
    kept have a length each, and are None where no point has it. Seconds and bytes are estimates.
    """
    design, strategy = prepared.design, prepared.strategy
    evaluate = prepared.start()()
    spread = np.unique(np.linspace(0, design.count - 1, _TRIED).astype(np.int64))
    evaluate(spread[:1])  # imports, and what all points share
    pieces = np.split(spread, len(spread))
    if strategy.kind == "array":
        pieces = [np.arange(min(design.count, strategy.chunk_size))]
    started = time.perf_counter()
    blocks: list[Block] = []
    while pieces and time.perf_counter() - started <= _PATIENCE:
        blocks.append(evaluate(pieces.pop(0)))
    tried = combined(blocks, np.concatenate([one.indices for one in blocks]), prepared.keep)
    number = len(tried.indices)
    seconds = (time.perf_counter() - started) / number * design.count
    jobs = options.jobs or (1 if prepared.is_short else processors())
    kept: list[dict[str, Any]] = []
    for path in prepared.keep:
        row: dict[str, Any] = {"quantity": path, "unit": "", "axes": None, "reason": None}
        if (one := tried.described.get(path)) is not None:
            row |= {"unit": one.unit, "axes": {a.name: len(a.values) for a in one.axes}}
        else:
            row["reason"] = tried.left_out.get(path, "no point that was tried has it")
        kept.append(row)
    failures = [tried.message[row] for row in np.flatnonzero(tried.status != DONE)]
    bytes_tried = number + sum(one.nbytes for one in tried.columns.values())
    return {
        "case": prepared.loaded.name,
        "points": design.count,
        "shape": list(design.shape),
        "sampling": design.sampling,
        "axes": [
            {"name": axis.name, "keys": [key.key for key in axis.keys]} for axis in design.axes
        ],
        "strategy": strategy.kind,
        "reason": strategy.reason,
        "chunks": len(shard_chunks(prepared.journal(options.output).chunks, options.shard)),
        "chunk_size": strategy.chunk_size,
        "kept": kept,
        "tried": number,
        "failed": len(failures),
        "failures": failures,
        "processes": jobs,
        "seconds": seconds / jobs,
        "bytes": bytes_tried * design.count // number,
        "identity": prepared.identity,
    }
