"""The chunks of a sweep, or the files of its parts, put together in one file."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.files import fresh_output
from vibecalc.core.results.layout import NOT_RUN, SAMPLE, STATUS_WORDS
from vibecalc.core.results.record import Result
from vibecalc.core.results.sweep_file import (
    Failures,
    StackedQuantity,
    SweepHead,
    SweepResult,
    SweptAxis,
    SweptKey,
    open_sweep,
)
from vibecalc.core.study.sweep.blocks import Block, BlockQuantity, ChunkFolder, laid_out
from vibecalc.core.study.sweep.design import Design, SweepAxis
from vibecalc.core.study.sweep.prepare import Identity
from vibecalc.core.study.sweep.stacked_file import Stacking, look_through, write_stacked
from vibecalc.errors import UsageError

# ----------------------------------------------------------------------------
# Two blocks of the same points, from two parts of a sweep, as one.
# ----------------------------------------------------------------------------


def join(block: Block, other: Block, path: Path) -> Block:
    """Take from `other` the points that `block` does not have.

    UsageError for a point that both have, unless they say the same of it; `path` is the file that
    `other` is from.
    """
    ours, theirs = block.status != NOT_RUN, other.status != NOT_RUN
    both = np.flatnonzero(ours & theirs)
    new = np.flatnonzero(theirs & ~ours)
    for row in both:
        if block.status[row] != other.status[row] or block.message[row] != other.message[row]:
            said = [
                f"{STATUS_WORDS.get(int(one.status[row]), '?')} {one.message[row]}".rstrip()
                for one in (block, other)
            ]
            raise _differ(int(block.indices[row]), path, f"{said[0]!r} and {said[1]!r}")
    quantities: dict[str, BlockQuantity] = {}
    left_out = {**other.left_out, **block.left_out}
    for name in {**block.quantities, **other.quantities}:
        mine, yours = block.quantities.get(name), other.quantities.get(name)
        if mine is None or yours is None:
            # an absent quantity is one that no point of that part has
            there = mine if mine is not None else yours
            assert there is not None
            mine, yours = mine or _nowhere(there), yours or _nowhere(there)
        whole = _laid(mine, yours, np.flatnonzero(ours), new, block.indices)
        theirs_first = _laid(
            mine, yours, np.flatnonzero(ours), np.flatnonzero(theirs), block.indices
        )
        if isinstance(whole, str) or isinstance(theirs_first, str):
            left_out.setdefault(name, str(theirs_first))
            continue
        wrong = _different(whole, theirs_first)
        if wrong.size:
            raise _differ(int(block.indices[wrong[0]]), path, f"different values of {name}")
        quantities[name] = whole
    message = list(block.message)
    for row in new:
        message[row] = other.message[row]
    return Block(
        indices=block.indices,
        status=np.where(ours, block.status, other.status),
        message=tuple(message),
        quantities=quantities,
        left_out=left_out,
    )


def _differ(point: int, path: Path, what: str) -> UsageError:
    return UsageError(
        f"two parts have point {point} and do not agree on it, {path} and one before it: {what}"
    )


def _nowhere(quantity: BlockQuantity) -> BlockQuantity:
    """The same quantity at points that do not have it."""
    spread = quantity.standard_errors
    return quantity._replace(
        values=np.full_like(quantity.values, np.nan),
        errors=np.full_like(quantity.errors, np.nan),
        standard_errors=None if spread is None else np.full_like(spread, np.nan),
    )


def _laid(
    mine: BlockQuantity,
    yours: BlockQuantity,
    ours: np.ndarray,
    theirs: np.ndarray,
    numbers: np.ndarray,
) -> BlockQuantity | str:
    """Rows `ours` of the one, and then rows `theirs` of the other."""
    pieces = [(rows, _rows(one, rows)) for one, rows in ((mine, ours), (yours, theirs))]
    return laid_out([piece for piece in pieces if piece[0].size], numbers)


def _rows(quantity: BlockQuantity, rows: np.ndarray) -> BlockQuantity:
    spread = quantity.standard_errors
    return quantity._replace(
        values=quantity.values[rows],
        errors=quantity.errors[rows],
        standard_errors=None if spread is None else spread[rows],
    )


def _different(one: BlockQuantity, other: BlockQuantity) -> np.ndarray:
    """Rows that are not the same in both."""
    same = np.ones(one.errors.size, dtype=bool)
    for a, b in (
        (one.values, other.values),
        (one.errors, other.errors),
        (one.standard_errors, other.standard_errors),
    ):
        if a is not None and b is not None:
            equal = (a == b) | (np.isnan(a) & np.isnan(b))
            same &= equal.reshape(same.size, -1).all(axis=1)
    return np.flatnonzero(~same)


# ----------------------------------------------------------------------------
# The chunks of a sweep put together in one file.
# ----------------------------------------------------------------------------


class Assembled(NamedTuple):
    """A file that was written, and what is in it.

    `counts` says how many points have which status, `missing` which were not run (first and last
    of each gap), `left_out` which quantities could not be stacked and why.
    """

    path: Path
    counts: Mapping[int, int]
    missing: tuple[tuple[int, int], ...]
    left_out: Mapping[str, str]


def assemble(
    output: Path | str,
    head: SweepHead,
    chunks: ChunkFolder,
    numbers: Iterable[int] | None = None,
    between: Callable[[], None] = lambda: None,
) -> Assembled:
    """Write the file of a sweep from some of its chunks, by default all that are valid.

    The chunks are read twice, one at a time; `between` is called before each. Points of other
    chunks are "not run". UsageError, with the reason, if the file cannot be written, and
    ResultError for a chunk that is damaged; an old file is then as it was.
    """
    target = fresh_output(output)
    wanted = sorted(chunks.finished() if numbers is None else set(numbers))

    def blocks() -> Iterator[Block]:
        for block in chunks.blocks(wanted):
            between()
            yield block

    stacking = look_through(blocks(), head.stored, chunks.count)
    write_stacked(target, head, stacking, blocks())
    return assembled(target, stacking)


def assembled(path: Path, stacking: Stacking) -> Assembled:
    """What is in a file."""
    return Assembled(path, stacking.counts, tuple(stacking.missing), stacking.left_out)


def sweep_head(
    result: Result, design: Design, identity: Identity, stored: Sequence[str]
) -> SweepHead:
    """What a file says of a sweep; `result` has case, plan and provenance, and no quantities."""
    if design.sampling == "grid":
        axes = tuple(_along(axis) for axis in design.axes)
    else:
        axes = (_sampled(design),)
    return SweepHead(
        result=result,
        axes=axes,
        sampling=design.sampling,
        design=design.description(),
        stored=tuple(stored),
        identity=identity.sweep,
        base=identity.base,
    )


def _along(axis: SweepAxis) -> SweptAxis:
    whole = _whole(axis)

    def read(first: int, last: int) -> list[np.ndarray]:
        values = axis.at(np.arange(first, last))
        return [
            column.astype(np.int64) if is_whole else column
            for column, is_whole in zip(values.T, whole, strict=True)
        ]

    return SweptAxis(name=axis.name, count=axis.count or 0, keys=_keys(axis), read=read)


def _sampled(design: Design) -> SweptAxis:
    whole = [one for axis in design.axes for one in _whole(axis)]

    def read(first: int, last: int) -> list[np.ndarray]:
        values = design.value_of(np.arange(first, last))
        return [
            column.astype(np.int64) if is_whole else column
            for column, is_whole in zip(values.T, whole, strict=True)
        ]

    keys = tuple(key for axis in design.axes for key in _keys(axis))
    return SweptAxis(name=SAMPLE, count=design.count, keys=keys, read=read)


def _keys(axis: SweepAxis) -> tuple[SweptKey, ...]:
    rows = zip(axis.keys, axis.labels, axis.units, axis.written_units, axis.choices, strict=True)
    return tuple(
        SweptKey(key=key, label=label, unit=unit, written_unit=written, choices=choices)
        for key, label, unit, written, choices in rows
    )


def _whole(axis: SweepAxis) -> list[bool]:
    """Which keys are whole numbers, or positions of choices."""
    return [
        bool(choices) or shape.kind == "whole"
        for choices, shape in zip(axis.choices, axis.shapes, strict=True)
    ]


# ----------------------------------------------------------------------------
# Files of parts of one sweep put together in one file.
# ----------------------------------------------------------------------------

_AT_ONCE = 1 << 13  # points
_ENTRIES = 1 << 20  # of all quantities of these points


def merge(
    parts: Sequence[Path | str],
    output: Path | str,
    provenance: Mapping[str, str | int | float] | None = None,
) -> Assembled:
    """Write one file with the points of all parts, and say which points none of them has.

    `provenance` replaces that of the first part. Raises UsageError for parts of different sweeps
    and for a point that two parts have with different results, ResultError for a file that cannot
    be read; an old output is then as it was.
    """
    if not parts:
        raise UsageError("there are no parts to merge")
    target = fresh_output(output)
    with ExitStack() as stack:
        opened = [stack.enter_context(open_sweep(part)) for part in parts]
        for other in opened[1:]:
            _check_same_sweep(opened[0], other)
        head = opened[0].head
        if provenance is not None:
            result = replace(head.result, provenance=dict(provenance), timings={})
            head = replace(head, result=result)
        whole = _Parts(opened)
        stacking = look_through(whole.blocks(), head.stored, opened[0].count)
        write_stacked(target, head, stacking, whole.blocks())
    return assembled(target, stacking)


def _check_same_sweep(first: SweepResult, other: SweepResult) -> None:
    one, two = first.head, other.head
    if one.identity == two.identity and one.shape == two.shape:
        return
    pair = f"{first.path} and {other.path} are not parts of one sweep"
    if one.result.version != two.result.version:
        why = f"vibecalc {one.result.version} wrote one, {two.result.version} the other"
    elif one.base != two.base:
        why = "their cases are not the same"
    elif one.design != two.design:
        why = "they have other points"
    elif set(one.stored) != set(two.stored):
        why = "they keep other quantities"
    else:
        why = "their cases are not the same"
    raise UsageError(f"{pair}: {why}")


class _Parts:
    """Open parts of one sweep, read together a few points at a time."""

    def __init__(self, parts: Sequence[SweepResult]) -> None:
        self.parts = parts
        self.failures: list[Failures] = [part.failures() for part in parts]
        self.left_out: dict[str, str] = {}
        for part in parts:
            self.left_out = {**part.left_out, **self.left_out}
        entries = max(
            sum(
                math.prod(len(axis.values) for axis in one.axes) for one in part.quantities.values()
            )
            for part in parts
        )
        self.step = max(1, min(_AT_ONCE, _ENTRIES // max(entries, 1)))

    def blocks(self) -> Iterator[Block]:
        """All points that a part has, ascending; UsageError where two parts do not agree."""
        count = self.parts[0].count
        for first in range(0, count, self.step):
            last = min(first + self.step, count)
            found = [
                (part, number)
                for number, part in enumerate(self.parts)
                if np.any(part.status_of(first, last) != NOT_RUN)
            ]
            if found:
                whole = self._block(*found[0], first, last)
                for part, number in found[1:]:
                    whole = join(whole, self._block(part, number, first, last), part.path)
                yield whole

    def _block(self, part: SweepResult, number: int, first: int, last: int) -> Block:
        failures = self.failures[number]
        message = [""] * (last - first)
        low, high = np.searchsorted(failures.points, [first, last])
        for row in range(low, high):
            message[failures.points[row] - first] = failures.texts[failures.causes[row]]
        return Block(
            indices=np.arange(first, last),
            status=part.status_of(first, last),
            message=tuple(message),
            quantities={
                path: _stacked(quantity, first, last)
                for path, quantity in part.quantities.items()
                if path not in self.left_out
            },
            left_out=self.left_out,
        )


def _stacked(quantity: StackedQuantity, first: int, last: int) -> BlockQuantity:
    return BlockQuantity(
        values=quantity.points(first, last),
        errors=quantity.errors_of(first, last),
        standard_errors=quantity.standard_errors_of(first, last),
        axes=quantity.axes,
        unit=quantity.unit,
        long_name=quantity.long_name,
        amplitude=quantity.amplitude,
    )
