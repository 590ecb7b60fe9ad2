"""The file of a sweep, written block by block in little memory."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.dimensions import free_name
from vibecalc.core.results.files import new_hdf5, written_aside
from vibecalc.core.results.layout import (
    DONE,
    ERRORS,
    MESSAGE,
    NOT_RUN,
    PROVENANCE,
    SAMPLE,
    STANDARD_ERRORS,
    STATUS,
    STATUS_WORDS,
    SWEEP,
    SWEEP_SCHEMA_VERSION,
    TEXT_CHECKSUM,
    VALUES,
    VERSION_ATTRIBUTE,
    text_checksum,
)
from vibecalc.core.results.record import Axis, Quantity, Record
from vibecalc.core.results.store import _Writer
from vibecalc.core.results.sweep_file import (
    SweepHead,
    SweptAxis,
    SweptKey,
    check_sweep,
    chunk_shape,
    write_points,
)
from vibecalc.core.study.sweep.blocks import Block, BlockQuantity, joined_axes, padded

# ----------------------------------------------------------------------------
# First look at the blocks of a sweep: which quantities can be stacked, and what went wrong.
# ----------------------------------------------------------------------------

MOST_CAUSES = 10_000
_LONGEST_CAUSE = 4_000  # characters
_OTHER_CAUSE = "another cause: a file keeps the words of the first ten thousand only"


@dataclass(kw_only=True)
class Stack:
    """What all blocks together say of one quantity; errors are the largest of all points."""

    axes: tuple[Axis, ...]
    unit: str
    long_name: str
    amplitude: str | None
    is_complex: bool = False
    error: float = 0.0
    standard_error: float | None = None


@dataclass(kw_only=True)
class Stacking:
    """How a sweep is stacked.

    `causes` number the words about points without a result, `counts` says how many points have
    which status, `missing` the points (first, last) that were not run.
    """

    stacks: dict[str, Stack] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    causes: dict[str, int] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    missing: list[tuple[int, int]] = field(default_factory=list)
    counted: int = 0

    @property
    def failed(self) -> int:
        """Points that were run and have no result."""
        return sum(many for status, many in self.counts.items() if status not in (NOT_RUN, DONE))

    def cause(self, message: str) -> int:
        """Number of the words about a point."""
        return self.causes.get(_cause_words(message), self.causes.get(_OTHER_CAUSE, 0))


def look_through(blocks: Iterable[Block], stored: Iterable[str], count: int) -> Stacking:
    """Go through all blocks of a sweep of `count` points, ascending, one at a time.

    Quantities come in the order of `stored`; those that no point has are not among them.
    """
    stacking = Stacking()
    stacks: dict[str, Stack] = {}
    for block in blocks:
        stacking.left_out = {**block.left_out, **stacking.left_out}
        for path, quantity in block.quantities.items():
            if path in stacking.left_out:
                continue
            reason = _take(stacks, path, quantity)
            if reason:
                stacking.left_out[path] = reason
        _count(stacking, block)
    _miss(stacking, stacking.counted, count)
    stacking.stacks = {
        path: stacks[path] for path in stored if path in stacks and path not in stacking.left_out
    }
    return stacking


def failures(block: Block) -> np.ndarray:
    """Rows of a block that were run and have no result."""
    return np.flatnonzero((block.status != DONE) & (block.status != NOT_RUN))


def _count(stacking: Stacking, block: Block) -> None:
    first = int(block.indices[0])
    _miss(stacking, stacking.counted, first)
    for row in np.flatnonzero(block.status == NOT_RUN):
        _miss(stacking, first + int(row), first + int(row) + 1)
    stacking.counted = int(block.indices[-1]) + 1
    for status in np.unique(block.status[block.status != NOT_RUN]):
        many = int(np.count_nonzero(block.status == status))
        stacking.counts[int(status)] = stacking.counts.get(int(status), 0) + many
    for row in failures(block):
        words = _cause_words(block.message[row])
        if words not in stacking.causes:
            words = words if len(stacking.causes) < MOST_CAUSES else _OTHER_CAUSE
            stacking.causes.setdefault(words, len(stacking.causes))


def _miss(stacking: Stacking, first: int, after: int) -> None:
    """Note that the points from `first` up to `after` were not run."""
    if first >= after:
        return
    stacking.counts[NOT_RUN] = stacking.counts.get(NOT_RUN, 0) + after - first
    if stacking.missing and stacking.missing[-1][1] == first - 1:
        first, _ = stacking.missing.pop()
    stacking.missing.append((first, after - 1))


def _take(stacks: dict[str, Stack], path: str, quantity: BlockQuantity) -> str:
    """Join what a block has of a quantity to what is known; the reason if that cannot be."""
    if path not in stacks:
        stacks[path] = Stack(
            axes=quantity.axes,
            unit=quantity.unit,
            long_name=quantity.long_name,
            amplitude=quantity.amplitude,
        )
    known = stacks[path]
    axes = joined_axes(known.axes, quantity.axes)
    if isinstance(axes, str):
        return axes
    if (known.unit, known.amplitude) != (quantity.unit, quantity.amplitude):
        return "its unit or kind of amplitude is not the same at all points"
    known.axes = axes
    known.is_complex |= np.iscomplexobj(quantity.values)
    known.error = _largest(known.error, quantity.errors)
    if quantity.standard_errors is not None:
        known.standard_error = _largest(known.standard_error or 0.0, quantity.standard_errors)
    return ""


def _largest(known: float, errors: np.ndarray) -> float:
    """Largest error; points without the quantity are NaN."""
    return float(np.max(errors, initial=known, where=~np.isnan(errors)))


def _cause_words(message: str) -> str:
    """What a file can hold of a message."""
    plain = message.replace("\0", "").encode("utf-8", "replace").decode()
    cut = len(plain) > _LONGEST_CAUSE
    return f"{plain[:_LONGEST_CAUSE]} ..." if cut else plain or "no reason is known"


# ----------------------------------------------------------------------------
# The file of a sweep, written block by block in little memory.
# ----------------------------------------------------------------------------

_CACHE = 1 << 19  # bytes for each open dataset: two chunks of complex numbers
_AT_ONCE = 1 << 16  # values of an axis
_WHOLE, _REAL, _COMPLEX = np.dtype("<i8"), np.dtype("<f8"), np.dtype("<c16")


def write_stacked(
    target: Path, head: SweepHead, stacking: Stacking, blocks: Iterable[Block]
) -> None:
    """Write the blocks (ascending, the same that `stacking` has counted) to `target` in one step.

    Equal input gives equal bytes; with other provenance, everything outside `/provenance` is
    equal. Points of no block are "not run". UsageError with the reason if it cannot be written.
    """
    from h5py import h5a

    with (
        written_aside(target, check_sweep) as temporary,
        new_hdf5(temporary, _CACHE) as (file, stream),
    ):
        stacked = _StackedWriter(file, head, stacking)
        for block in blocks:
            stacked.block(block)
            stream.check()
        writer = stacked.writer
        writer.provenance(head.result.provenance, head.result.timings)
        # texts have no checksum of HDF5, so they get one of ours, as in every result
        place = writer.group(PROVENANCE)
        writer.number(place, TEXT_CHECKSUM, 0)
        file.flush()
        checksum = np.array(text_checksum(temporary))
        h5a.open(place, TEXT_CHECKSUM.encode()).write(checksum)


class _StackedWriter:
    """The open file and its datasets."""

    def __init__(self, file: Any, head: SweepHead, stacking: Stacking) -> None:
        self.writer = _Writer(file.id)
        self.head, self.stacking, self.shape = head, stacking, head.shape
        self.failed = 0
        self.attributes()
        self.scales = [
            self.axis(axis, name) for axis, name in zip(head.axes, self.outer, strict=True)
        ]
        self.status = self.over_points(STATUS, np.dtype("i1"), NOT_RUN)
        meaning = {str(status): words for status, words in STATUS_WORDS.items()}
        self.writer.text(self.status.id, "meaning", json.dumps(meaning))
        self.values: dict[str, Any] = {}
        self.errors: dict[str, Any] = {}
        self.standard_errors: dict[str, Any] = {}
        for path, stack in stacking.stacks.items():
            self.quantity(path, stack)
        self.points = self.dataset(f"{MESSAGE}/point", (stacking.failed,), _WHOLE, 0)
        self.causes = self.dataset(f"{MESSAGE}/cause", (stacking.failed,), _WHOLE, 0)
        words = np.array(list(stacking.causes), dtype=object)
        self.writer.dataset(self.writer.group(MESSAGE), "text", words)

    def block(self, block: Block) -> None:
        """Write what a block has."""
        first = int(block.indices[0])
        if not np.array_equal(block.indices, np.arange(first, first + len(block.status))):
            raise ValueError("the points of a block are not consecutive")
        write_points(self.status, block.status, first, self.shape)
        for path, stack in self.stacking.stacks.items():
            quantity = block.quantities.get(path)
            if quantity is None:
                continue
            lengths = tuple(len(axis.values) for axis in stack.axes)
            values = padded(quantity.values, (len(quantity.values), *lengths))
            if values is not quantity.values:
                values[np.isnan(quantity.errors)] = np.nan
            write_points(self.values[path], values, first, self.shape)
            write_points(self.errors[path], quantity.errors, first, self.shape)
            if quantity.standard_errors is not None:
                write_points(
                    self.standard_errors[path], quantity.standard_errors, first, self.shape
                )
        rows = failures(block)
        if rows.size:
            place = slice(self.failed, self.failed + rows.size)
            self.points[place] = block.indices[rows]
            self.causes[place] = [self.stacking.cause(block.message[row]) for row in rows]
            self.failed += rows.size

    def attributes(self) -> None:
        """What the file says of the case and the sweep."""
        head = self.head
        record = Record(warnings=head.result.record.warnings, methods=head.result.record.methods)
        for path in self.stacking.stacks:
            record.add(Quantity(path=path, values=np.empty(0), unit="", long_name=""))
        self.writer.identity(replace(head.result, record=record))
        self.writer.number(self.writer.root, VERSION_ATTRIBUTE, SWEEP_SCHEMA_VERSION)
        inside = {name for path in self.stacking.stacks for name in path.split("/")}
        self.outer: list[str] = []
        for axis in head.axes:
            self.outer.append(free_name(axis.name, {*inside, *self.outer, SWEEP, PROVENANCE}))
        own = {path: stack.axes for path, stack in self.stacking.stacks.items()}
        self.writer.name_axes(own, (SWEEP, *self.outer))
        axes = [{"name": axis.name, "keys": [vars(key) for key in axis.keys]} for axis in head.axes]
        place = self.writer.group(SWEEP)
        for name, text in (
            ("identity", head.identity),
            ("base", head.base),
            ("sampling", head.sampling),
            ("design", json.dumps(head.design)),
            ("axes", json.dumps(axes)),
            ("kept", json.dumps(list(head.stored))),
            ("left_out", json.dumps(self.stacking.left_out)),
        ):
            self.writer.text(place, name, text)

    def axis(self, axis: SweptAxis, name: str) -> Any:
        """The scale of an axis, and the values of its keys along it."""
        from h5py import h5ds

        writer, first, sampled = self.writer, axis.keys[0], axis.name == SAMPLE
        kinds = [_WHOLE if one.dtype.kind in "iu" else _REAL for one in axis.read(0, 1)]
        named = bool(first.choices) and not sampled
        if named:
            # a grid has few of them, and who opens the file wants names
            scale = writer.dataset(writer.root, name, axis.values()[0])
            filled = []
        else:
            made = self.dataset(name, (axis.count,), _WHOLE if sampled else kinds[0], 0)
            scale, filled = made.id, [made]
        h5ds.set_scale(scale, axis.name.encode())
        number = SweptKey(key="", label="number of the point", unit="", written_unit="")
        self.describe(scale, number if sampled else first)
        columns = []
        for key, kind in zip(axis.keys, kinds, strict=True):
            column = self.dataset(f"{VALUES}/{key.key}", (axis.count,), kind, 0)
            h5ds.attach_scale(column.id, scale, 0)
            h5ds.set_label(column.id, 0, axis.name.encode())
            self.describe(column.id, key)
            columns.append(column)
        for start in range(0, axis.count, _AT_ONCE):
            stop = min(start + _AT_ONCE, axis.count)
            read_columns = axis.read(start, stop)
            along = np.arange(start, stop) if sampled else read_columns[0]
            for column, values in zip(columns + filled, [*read_columns, along], strict=not named):
                column[start:stop] = values
        return scale

    def describe(self, place: Any, key: SweptKey) -> None:
        """Unit and name, as on every axis."""
        self.writer.text(place, "units", key.unit)
        self.writer.text(place, "long_name", key.label)

    def quantity(self, path: str, stack: Stack) -> None:
        """The datasets of one quantity and of its errors."""
        lengths = tuple(len(axis.values) for axis in stack.axes)
        values = self.over_points(path, _COMPLEX if stack.is_complex else _REAL, np.nan, lengths)
        self.writer.axes(values.id, path, stack.axes, first=len(self.shape))
        self.writer.text(values.id, "units", stack.unit)
        self.writer.text(values.id, "long_name", stack.long_name)
        if stack.amplitude is not None:
            self.writer.text(values.id, "amplitude", stack.amplitude)
        self.writer.number(values.id, "error_estimate", stack.error)
        self.values[path] = values
        self.errors[path] = self.over_points(f"{ERRORS}/{path}", _REAL, np.nan)
        self.writer.text(self.errors[path].id, "units", stack.unit)
        if stack.standard_error is not None:
            self.writer.number(values.id, "standard_error", stack.standard_error)
            made = self.over_points(f"{STANDARD_ERRORS}/{path}", _REAL, np.nan)
            self.writer.text(made.id, "units", stack.unit)
            self.standard_errors[path] = made

    def over_points(
        self, path: str, kind: np.dtype, fill: float, lengths: tuple[int, ...] = ()
    ) -> Any:
        """A dataset with the axes of the sweep, and its own after them."""
        from h5py import h5ds

        made = self.dataset(path, (*self.shape, *lengths), kind, fill)
        for position, axis in enumerate(self.head.axes):
            h5ds.attach_scale(made.id, self.scales[position], position)
            h5ds.set_label(made.id, position, axis.name.encode())
        return made

    def dataset(self, path: str, shape: tuple[int, ...], kind: np.dtype, fill: float) -> Any:
        """An empty dataset in chunks, each with a checksum; what is not written is `fill`."""
        import h5py
        from h5py import h5d, h5p, h5s, h5t

        options = h5p.create(h5p.DATASET_CREATE)
        options.set_obj_track_times(False)
        options.set_fill_value(np.array(fill, dtype=kind))
        if math.prod(shape):
            options.set_chunk(chunk_shape(shape))
            options.set_fletcher32()
        folder, _, name = path.rpartition("/")
        in_file = h5t.py_create(kind, logical=True)
        space = h5s.create_simple(shape)
        group = self.writer.group(folder)
        return h5py.Dataset(h5d.create(group, name.encode(), in_file, space, options))
