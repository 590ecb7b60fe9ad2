"""The chunks of a sweep put together in one file."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vibecalc.results.files import fresh_output
from vibecalc.results.record import Result
from vibecalc.results.sweep_layout import SAMPLE
from vibecalc.results.sweep_record import SweepHead, SweptAxis, SweptKey
from vibecalc.study.sweep.axes import SweepAxis
from vibecalc.study.sweep.block import Block
from vibecalc.study.sweep.chunks import ChunkFolder
from vibecalc.study.sweep.design import Design
from vibecalc.study.sweep.identity import Identity
from vibecalc.study.sweep.stacked_file import write_stacked
from vibecalc.study.sweep.stacking import Stacking, look_through


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

    stacking = look_through(blocks(), head.kept, chunks.count)
    write_stacked(target, head, stacking, blocks())
    return assembled(target, stacking)


def assembled(path: Path, stacking: Stacking) -> Assembled:
    """What is in a file."""
    return Assembled(path, stacking.counts, tuple(stacking.missing), stacking.left_out)


def sweep_head(
    result: Result, design: Design, identity: Identity, kept: Sequence[str]
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
        kept=tuple(kept),
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
