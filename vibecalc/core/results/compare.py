"""Golden comparison of two results, aware of what the numbers mean."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.compare_matched import (
    ModeMatch,
    by_curve,
    by_mode_shape,
    by_spectrum,
    match_folder,
)
from vibecalc.core.results.compare_rules import (
    Entries,
    Rule,
    Rules,
    align,
    by_phase,
    by_value,
    by_vector,
    completed,
    is_number,
    last_digits,
    match_labels,
)
from vibecalc.core.results.files import SUFFIXES
from vibecalc.core.results.layout import STATUS, STATUS_WORDS
from vibecalc.core.results.record import CYCLE, UNDECIDED, Axis, Quantity, Record, Result, Verdict
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.results.text_files import HDF5_BEGINS
from vibecalc.core.results.tolerance import circle_of, is_diagnostic
from vibecalc.core.results.verdicts import VERDICTS, name_of, verdicts_of
from vibecalc.errors import (
    EXIT_DIFFERS,
    EXIT_FINE,
    EXIT_USAGE,
    ResultError,
    UsageError,
    dotted,
    leaves,
)

_PLAIN = {"value": by_value, "vector": by_vector}
#: points of sweeps named where they ended otherwise
_MOST_POINTS = 5
_OVER_MODES = {"spectrum": by_spectrum, "mode_shape": by_mode_shape}


@dataclass(frozen=True, kw_only=True)
class ComparedRow:
    """The comparison of one quantity, shown by its worst entry.

    `ratio` is difference over allowed, at most 1 where the entry is the same; `failed` of
    `entries` entries are not. `problems` are differences without a number: a missing quantity,
    another unit, another label on an axis. Any of them makes the quantity differ.
    """

    path: str
    kind: str
    unit: str = ""
    entry: str = ""
    reference: float | complex | str | None = None
    value: float | complex | str | None = None
    difference: float = 0.0
    allowed: float = 0.0
    ratio: float = 0.0
    failed: int = 0
    entries: int = 0
    problems: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether everything is within its tolerance."""
        return not self.failed and not self.problems


@dataclass(frozen=True, kw_only=True)
class Change:
    """Something that is not a result and differs: shown, not counted."""

    what: str
    reference: str
    value: str


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """All rows, in the order of the reference; quantities left out; changes of the case."""

    rows: tuple[ComparedRow, ...]
    ignored: tuple[str, ...] = ()
    changes: tuple[Change, ...] = ()

    @property
    def same(self) -> bool:
        """Whether every compared quantity is the same."""
        return all(row.same for row in self.rows)

    def __repr__(self) -> str:
        differ = sum(not row.same for row in self.rows)
        verdict = f"{differ} of {len(self.rows)} quantities differ" if differ else "same"
        return f"<vibecalc comparison: {verdict}>"

    def worst(self, count: int = 10) -> tuple[ComparedRow, ...]:
        """The rows that differ most: those with problems first, then by ratio."""
        ordered = sorted(self.rows, key=lambda row: (not row.problems, -row.ratio))
        return tuple(ordered[:count])


def compare(reference: Result, value: Result, rules: Rules | None = None) -> Comparison:
    """Compare `value` with the golden `reference`, quantity by quantity.

    The tolerance of an entry is atol + rtol * max(|reference entry|, scale of the quantity, for
    each mode, order, condition and point of a sweep its own), plus both error estimates (that of
    `value` as far as `compare_rules.uncertainty` lets it count) and of what cancels the last digits
    of its `terms`, as the reference has them; see `compare_rules.KINDS` for what is compared.
    Quantities that only one result has, and units, amplitude kinds or axes that differ, are
    differences, and so are an estimate that has grown beyond the tolerance and a limit whose
    verdict has changed (as if at the path `verdicts`). Diagnostics of rounding
    and of searches are ignored unless a rule says how to compare them. Provenance is left out, and
    changes of the case or version are listed without counting. Raises UsageError where a rule does
    not fit a quantity.
    """
    chosen = rules or Rules()
    rows: list[ComparedRow] = []
    ignored: list[str] = []
    lost = last_digits(reference.record)
    match = cache(partial(match_folder, reference.record, value.record))
    extra = [path for path in value.record if path not in reference.record]
    for path in [*reference.record, *extra]:
        rule = chosen.given(path)
        if rule.compare == "ignore" or (rule.compare is None and is_diagnostic(path)):
            ignored.append(path)
        elif path not in value.record:
            rows.append(ComparedRow(path=path, kind="missing", problems=("is missing",)))
        elif path not in reference.record:
            rows.append(ComparedRow(path=path, kind="extra", problems=("is not in the reference",)))
        else:
            # what is left of terms that cancel has no scale of its own
            one = reference.record[path]
            one = replace(one, error_estimate=one.error_estimate + lost * one.terms)
            other = _at_samples_of(one, value.record[path])
            rows.append(_compared(one, other, rule, match, _turns(reference)))
    rows += _status(reference, value)
    if chosen.given(VERDICTS).compare != "ignore":
        rows += _verdicts(reference, value)
    return Comparison(rows=tuple(rows), ignored=tuple(ignored), changes=_changes(reference, value))


def _compared(
    one: Quantity,
    other: Quantity,
    rule: Rule,
    match: Callable[[str, float], ModeMatch | None],
    turns: float,
) -> ComparedRow:
    kind = rule.compare or _natural_kind(one)
    if problems := _structure(one, other):
        return ComparedRow(path=one.path, kind=kind, unit=one.unit, problems=problems)
    full = completed(rule, kind)
    modes = None
    if kind in _OVER_MODES:
        names = [axis.name for axis in one.axes]
        if "mode" not in names or (kind == "mode_shape" and len(names) < 2):
            raise UsageError(f"compare = {kind!r} does not fit {one.path}: it needs an axis `mode`")
        modes = match(one.path.rpartition("/")[0], full.repeated or 0.0)
        kind = kind if modes else "value"
    axis = _curve_axis(one) if kind == "curve" else "mode" if modes else ""
    pair = align(one, other, full, free=axis)
    more: tuple[str, ...] = ()
    if modes is not None:
        entries, more = _OVER_MODES[kind](pair, modes), modes.problems(one, other)
    elif kind == "curve":
        entries, more = by_curve(pair, axis)
    elif kind == "phase":
        entries = by_phase(pair, 2.0 * math.pi * (turns if circle_of(one) == CYCLE else 1.0))
    else:
        entries = _PLAIN[kind](pair)
    return _row(one, kind, entries, pair.grown() + pair.problems + more)


def _turns(result: Result) -> float:
    """Turns of the crank in a cycle of the machine of a result; four strokes are usual."""
    machine: Any = result.case.get("machine", {})
    usual = "four_stroke" if machine.get("kind") == "engine" else ""
    return 2.0 if machine.get("cycle", usual) == "four_stroke" else 1.0


def _status(reference: Result, value: Result) -> list[ComparedRow]:
    """What became of the points, where both results are files of sweeps of as many points."""
    if reference.swept is None or value.swept is None:
        return []
    from vibecalc.core.results.sweep_file import open_sweep

    with open_sweep(reference.swept) as one, open_sweep(value.swept) as other:
        left, right = (np.ravel(sweep.status()).tolist() for sweep in (one, other))
    if len(left) != len(right):
        return []
    problems = [
        f"point {number}: {STATUS_WORDS[was]!r} became {STATUS_WORDS[now]!r}"
        for number, (was, now) in enumerate(zip(left, right, strict=True), start=1)
        if was != now
    ]
    if len(problems) > _MOST_POINTS:
        problems[_MOST_POINTS:] = [f"and {len(problems) - _MOST_POINTS} points more"]
    return [ComparedRow(path=STATUS, kind="value", problems=tuple(problems))]


def _verdicts(reference: Result, value: Result) -> list[ComparedRow]:
    """Limits that both results have, and that were kept, barred or broken and now are not.

    What is undecided in one of them is no difference: that may hang on a rounding.
    """
    found = []
    try:
        pairs = [_apart(verdicts_of(one)) for one in (reference, value)]
    except ResultError:  # a part of a result, without what its limits are on
        return []
    for key, row in pairs[0].items():
        states = row.state, pairs[1].get(key, row).state
        if states[0] != states[1] and UNDECIDED not in states:
            words = f"{row.element} {row.limit}".strip() or "limit"
            path = f"{VERDICTS}/{name_of(row.quantity, row.where)}"
            problems = (f"{words}: {states[0]} became {states[1]}",)
            found.append(ComparedRow(path=path, kind="verdict", problems=problems))
    return found


def _apart(rows: Sequence[Verdict]) -> dict[tuple[object, ...], Verdict]:
    """Rows by what tells them apart, those that are alike in that by their number."""
    keys = [(row.quantity, str(row.where), row.element, row.limit, row.at) for row in rows]
    met: Counter[tuple[object, ...]] = Counter()
    apart: dict[tuple[object, ...], Verdict] = {}
    for key, row in zip(keys, rows, strict=True):
        apart[*key, met[key]] = row
        met[key] += 1
    return apart


def _at_samples_of(reference: Quantity, value: Quantity) -> Quantity:
    """`value` at the samples that a thinned reference has kept, where it had them all."""
    for position, (one, other) in enumerate(zip(reference.axes, value.axes, strict=False)):
        whole = not one.run_samples or one.run_samples != len(other.values)
        if whole or one.name != other.name:
            continue
        _, there = match_labels(np.asarray(one.values), np.asarray(other.values))
        if len(there) == len(one.values):
            value = _at(value, position, np.array(there), run_samples=one.run_samples)
    return value


def _at(quantity: Quantity, position: int, places: np.ndarray, run_samples: int) -> Quantity:
    """A quantity at some of the samples of one axis."""
    axis = quantity.axes[position]
    axis = replace(axis, values=np.asarray(axis.values)[places], run_samples=run_samples)
    return replace(
        quantity,
        values=np.take(quantity.values, places, axis=position),
        axes=(*quantity.axes[:position], axis, *quantity.axes[position + 1 :]),
    )


def _natural_kind(quantity: Quantity) -> str:
    """How a quantity is compared if no rule says so."""
    names = [axis.name for axis in quantity.axes]
    if not is_number(quantity):
        return "value"
    if quantity.unit == "rad" and circle_of(quantity):
        return "phase"
    if "mode" in names:
        shape = quantity.path.rpartition("/")[2] == "shape" and len(names) > 1
        return "mode_shape" if shape else "spectrum"
    return "curve" if "speed" in names else "value"


def _curve_axis(quantity: Quantity) -> str:
    numeric = [axis.name for axis in quantity.axes if axis.values.dtype.kind in "biuf"]
    if not numeric or not is_number(quantity):
        raise UsageError(f"compare = 'curve' does not fit {quantity.path}: it needs a numeric axis")
    return "speed" if "speed" in numeric else numeric[-1]


def _structure(one: Quantity, other: Quantity) -> tuple[str, ...]:
    sides = (one, other)
    pairs: dict[str, list[Any]] = {
        "unit": [side.unit for side in sides],
        "amplitude": [side.amplitude for side in sides],
        "axes": [[axis.name for axis in side.axes] for side in sides],
        "values": ["numbers" if is_number(side) else "names" for side in sides],
    }
    for axes in zip(one.axes, other.axes, strict=False):
        if axes[0].name == axes[1].name:
            pairs[f"unit of axis {axes[0].name}"] = [axis.unit for axis in axes]
    return tuple(
        f"{name}: {was!r} became {now!r}" for name, (was, now) in pairs.items() if was != now
    )


def _row(quantity: Quantity, kind: str, entries: Entries, problems: tuple[str, ...]) -> ComparedRow:
    if not entries.difference.size:
        return ComparedRow(path=quantity.path, kind=kind, unit=quantity.unit, problems=problems)
    difference, allowed = entries.difference, entries.allowed
    within = (difference <= allowed) & (difference < math.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(difference == 0, 0.0, difference / allowed)
    ratio = np.where(np.isnan(ratio), math.inf, ratio)
    # Where numbers are equally far off, the one that is further apart is shown.
    worst = int(np.lexsort((difference, ratio))[-1])
    return ComparedRow(
        path=quantity.path,
        kind=kind,
        unit=quantity.unit,
        entry=entries.label(worst),
        reference=_plain(entries.reference[worst]),
        value=_plain(entries.value[worst]),
        difference=float(difference[worst]),
        allowed=float(allowed[worst]),
        ratio=float(ratio[worst]),
        failed=int(np.count_nonzero(~within)),
        entries=entries.difference.size,
        problems=problems,
    )


def _plain(entry: object) -> float | complex | str:
    if isinstance(entry, np.complexfloating):
        return complex(entry)
    return float(entry) if isinstance(entry, np.number | np.bool_) else str(entry)


def _changes(reference: Result, value: Result) -> tuple[Change, ...]:
    before, after = _flat(reference.case), _flat(value.case)
    keys = [*before, *(key for key in after if key not in before)]
    changes = [
        Change(what=key, reference=before.get(key, "absent"), value=after.get(key, "absent"))
        for key in keys
        if before.get(key) != after.get(key)
    ]
    if reference.version != value.version:
        changes.insert(0, Change(what="vibecalc", reference=reference.version, value=value.version))
    return tuple(changes)


def _flat(content: object) -> dict[str, str]:
    return {dotted(path): repr(value) for path, value in leaves(content)}


# ----------------------------------------------------------------------------
# Files and folders of results held against golden files: each for itself, whatever the others are.
# ----------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class FilePair:
    """A golden file and the result of its name, None where there is none, and how they compare.

    `problem` says in words why they could not be compared.
    """

    name: str
    golden: Path
    result: Path | None
    comparison: Comparison | None = None
    problem: str = ""

    @property
    def paths(self) -> tuple[str, ...]:
        """Quantities that either has, and the verdicts."""
        one = self.comparison
        return () if one is None else (VERDICTS, *(row.path for row in one.rows), *one.ignored)

    @property
    def exit_code(self) -> int:
        """That of `diff` for this pair alone."""
        if self.comparison is None:
            return EXIT_USAGE
        return EXIT_FINE if self.comparison.same else EXIT_DIFFERS

    def refused(self, problem: str) -> "FilePair":
        """The same, not compared for that reason."""
        return replace(self, problem=problem)

    def compared(self, rules: Rules) -> "FilePair":
        """The same, compared; what is missing or cannot be read says so.

        Raises UsageError where a rule does not fit a quantity.
        """
        if self.result is None:
            return self.refused(
                f"the golden file {self.golden} has no result; --partial leaves it out"
            )
        if not self.golden.exists():
            return self.refused(
                f"there is no golden file {self.golden}; --accept makes one of {self.result}"
            )
        try:
            golden, result = read_result(self.golden), read_result(self.result)
            return replace(self, comparison=compare(golden, result, rules))
        except ResultError as error:
            return self.refused(str(error))


def file_pairs(
    reference: Path, candidates: Sequence[Path], *, partial: bool = False
) -> list[FilePair]:
    """Each result with the golden file that it is held against, by name.

    `reference` is a golden file, for one result, or a folder of them; a folder among the
    `candidates` stands for the result files in it. Golden files of a folder that have no result
    come last, unless `partial`. UsageError where there is nothing to compare, or two results have
    one name.
    """
    found = [
        file for given in candidates for file in (_results_in(given) if given.is_dir() else [given])
    ]
    results = {file.name: file for file in found}
    if len(found) > (len(results) if reference.is_dir() else 1):
        raise UsageError("several results need a folder of golden files, and a name for each")
    if not reference.is_dir():
        return [FilePair(name=candidates[0].name, golden=reference, result=candidates[0])]
    pairs = [
        FilePair(name=name, golden=reference / name, result=file) for name, file in results.items()
    ]
    if not partial:
        left = [file for file in _results_in(reference) if file.name not in results]
        pairs += [FilePair(name=file.name, golden=file, result=None) for file in left]
    if not pairs:
        raise UsageError(
            f"there are no result files in {reference}, nor in what is held against it"
        )
    return pairs


def _results_in(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in SUFFIXES)


# ----------------------------------------------------------------------------
# Making a result the golden one.
# ----------------------------------------------------------------------------


def accept(path: Path | str, golden: Path | str) -> Path:
    """Write the result at `path` over `golden`, and return where that is.

    Provenance (time, host, timings) is left out, so that a golden file changes only when the
    case, the version or a result does. Raises ResultError where `path` is not a result, and
    UsageError where `golden` cannot be written or holds something else than HDF5 (arguments the
    wrong way round must not cost a case file); it is then as it was.

    Long curves are thinned where the case says how they are sampled: `diff` takes the same samples
    of a run.
    """
    result = read_result(path)
    accepted = replace(result, record=_thinned(result.record), provenance={}, timings={})
    if _holds_something_else(Path(golden)):
        raise UsageError(
            f"{golden} is not a result file, so it is not overwritten; the golden file comes "
            "first: vibecalc diff GOLDEN.h5 NEW.h5 --accept (or remove it)"
        )
    return write_result(accepted, golden)


#: samples of an evenly sampled axis that a golden file keeps at least, besides those at maxima
_KEPT_SAMPLES = 100


def _thinned(record: Record) -> Record:
    """All results, long even axes with every so-manyth sample, the last one and those at maxima."""
    kept: dict[tuple[str, bytes], set[int]] = {}
    for quantity in record.values():
        for position, axis in enumerate(quantity.axes):
            if _may_be_thinned(axis) and quantity.values.dtype.kind in "fc":
                count = len(axis.values)
                places = kept.setdefault(
                    _key(axis), {*range(0, count, count // _KEPT_SAMPLES), count - 1}
                )
                places |= set(np.ravel(np.argmax(np.abs(quantity.values), axis=position)).tolist())
    thinned = replace(record, quantities={})
    for quantity in record.values():
        for position, axis in enumerate(quantity.axes):
            if quantity.values.dtype.kind in "fc" and _key(axis) in kept:
                chosen = np.array(sorted(kept[_key(axis)]))
                quantity = _at(quantity, position, chosen, run_samples=len(axis.values))
        thinned.add(quantity)
    return thinned


def _key(axis: Axis) -> tuple[str, bytes]:
    return axis.name, np.asarray(axis.values).tobytes()


def _may_be_thinned(axis: Axis) -> bool:
    """Whether samples stand where the case says, not where a run chose them, nor over a cycle.

    Over a cycle, reports and pictures take sums and differences of curves with others.
    """
    values = np.asarray(axis.values)
    if values.dtype.kind != "f" or axis.unit == "rad" or len(values) < 2 * _KEPT_SAMPLES:
        return False
    even = np.linspace(values[0], values[-1], len(values))
    return bool(np.allclose(values, even, rtol=0.0, atol=1e-9 * np.abs(values).max()))


def _holds_something_else(path: Path) -> bool:
    try:
        with open(path, "rb") as stream:
            return stream.read(len(HDF5_BEGINS)) != HDF5_BEGINS
    except OSError:  # missing, a folder, unreadable: writing says what is wrong
        return False
