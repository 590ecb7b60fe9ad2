"""The file of a sweep, written block by block in little memory."""

import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, fields, replace
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
    VALUES,
    VERSION_ATTRIBUTE,
    text_checksum,
)
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.results.store import _Writer
from vibecalc.core.results.sweep_file import (
    SweepHead,
    SweptAxis,
    SweptKey,
    check_sweep,
    chunk_shape,
    write_points,
)
from vibecalc.core.study.sweep.blocks import Block, joined_axes, padded

# ----------------------------------------------------------------------------
# First look at the blocks of a sweep: which quantities can be stacked, and how many points failed.
# ----------------------------------------------------------------------------


@dataclass(kw_only=True)
class Stacking:
    """What all blocks together have: quantities without their values, what is left out and why.

    Errors of a quantity are the largest of all points.
    """

    quantities: dict[str, Quantity] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    failed: int = 0


def look_through(blocks: Iterable[Block], stored: Iterable[str]) -> Stacking:
    """Go through all blocks of a sweep, ascending, one at a time.

    Quantities come in the order of `stored`; those that no point has are not among them.
    """
    stacking = Stacking()
    found: dict[str, Quantity] = {}
    for block in blocks:
        stacking.left_out = {**block.left_out, **stacking.left_out}
        stacking.failed += failures(block).size
        for path, one in block.quantities.items():
            if path not in found:
                found[path] = Quantity(
                    path=path,
                    values=np.empty(0),
                    unit=one.unit,
                    long_name=one.long_name,
                    axes=one.axes,
                    amplitude=one.amplitude,
                )
            known, spread = found[path], one.standard_errors
            axes = joined_axes(known.axes, one.axes)
            if isinstance(axes, str):
                stacking.left_out.setdefault(path, axes)
                continue
            found[path] = replace(
                known,
                values=np.empty(0, np.result_type(known.values, one.values)),
                axes=axes,
                error_estimate=_largest(known.error_estimate, one.errors),
                standard_error=known.standard_error
                if spread is None
                else _largest(known.standard_error or 0.0, spread),
            )
    kept = [path for path in stored if path in found and path not in stacking.left_out]
    stacking.quantities = {path: found[path] for path in kept}
    return stacking


def failures(block: Block) -> np.ndarray:
    """Rows of a block that were run and have no result."""
    return np.flatnonzero((block.status != DONE) & (block.status != NOT_RUN))


def _largest(known: float, errors: np.ndarray) -> float:
    """Largest error; points without the quantity are NaN."""
    return float(np.max(errors, initial=known, where=~np.isnan(errors)))


# ----------------------------------------------------------------------------
# The file of a sweep, written block by block in little memory.
# ----------------------------------------------------------------------------

_CACHE = 1 << 19  # bytes for each open dataset: two chunks of complex numbers
_WHOLE, _REAL, _COMPLEX = np.dtype("<i8"), np.dtype("<f8"), np.dtype("<c16")
_MOST_CAUSES = 10_000
_LONGEST_CAUSE = 4_000  # characters
_OTHER_CAUSE = "another cause: a file keeps the words of the first ten thousand only"


def write_stacked(target: Path, head: SweepHead, blocks: Callable[[], Iterator[Block]]) -> None:
    """Write blocks, ascending, to `target` in one step; `blocks` is called twice, and equal.

    Equal input gives equal bytes; with other provenance, everything outside `/provenance` is
    equal. Points of no block are "not run". UsageError with the reason if it cannot be written;
    an old file is then as it was.
    """
    stacking = look_through(blocks(), head.stored)
    with (
        written_aside(target, check_sweep) as temporary,
        new_hdf5(temporary, _CACHE) as (file, stream),
    ):
        stacked = _StackedWriter(file, head, stacking)
        for block in blocks():
            stacked.block(block)
            stream.check()
        writer = stacked.writer
        words = np.array(list(stacked.texts), dtype=object)
        writer.dataset(writer.group(MESSAGE), "text", words)
        writer.finish(file, head.result, lambda: text_checksum(temporary))


class _StackedWriter:
    """The open file and its datasets; `texts` numbers the words about points without a result."""

    def __init__(self, file: Any, head: SweepHead, stacking: Stacking) -> None:
        self.writer = _Writer(file.id)
        self.head, self.quantities, self.shape = head, stacking.quantities, head.shape
        self.texts: dict[str, int] = {}
        self.failed = 0
        self.scales = self.attributes(stacking.left_out)
        self.datasets: dict[str, Any] = {}
        self.over_points(STATUS, np.dtype("i1"), NOT_RUN)
        meaning = {str(status): words for status, words in STATUS_WORDS.items()}
        self.writer.text(self.datasets[STATUS].id, "meaning", json.dumps(meaning))
        for quantity in self.quantities.values():
            self.quantity(quantity)
        for name in ("point", "cause"):
            path = f"{MESSAGE}/{name}"
            self.datasets[path] = self.dataset(path, (stacking.failed,), _WHOLE, 0)

    def block(self, block: Block) -> None:
        """Write what a block has."""
        first = int(block.indices[0])
        if not np.array_equal(block.indices, np.arange(first, first + len(block.status))):
            raise ValueError("the points of a block are not consecutive")
        columns = {STATUS: block.status}
        for path, whole in self.quantities.items():
            quantity = block.quantities.get(path)
            if quantity is None:
                continue
            columns[path] = padded(quantity, tuple(len(axis.values) for axis in whole.axes))
            columns[f"{ERRORS}/{path}"] = quantity.errors
            if quantity.standard_errors is not None:
                columns[f"{STANDARD_ERRORS}/{path}"] = quantity.standard_errors
        for path, values in columns.items():
            write_points(self.datasets[path], values, first, self.shape)
        rows = failures(block)
        if rows.size:
            place = slice(self.failed, self.failed + rows.size)
            self.datasets[f"{MESSAGE}/point"][place] = block.indices[rows]
            self.datasets[f"{MESSAGE}/cause"][place] = [
                self.cause(block.message[row]) for row in rows
            ]
            self.failed += rows.size

    def cause(self, message: str) -> int:
        """The number of the words about a point, as far as a file can hold them."""
        words = message.replace("\0", "").encode("utf-8", "replace").decode()
        if len(words) > _LONGEST_CAUSE:
            words = f"{words[:_LONGEST_CAUSE]} ..."
        words = words or "no reason is known"
        if words not in self.texts and len(self.texts) >= _MOST_CAUSES:
            words = _OTHER_CAUSE
        return self.texts.setdefault(words, len(self.texts))

    def attributes(self, left_out: dict[str, str]) -> list[Any]:
        """What the file says of the case and the sweep; returns the scales of its axes."""
        head = self.head
        record = Record(warnings=head.result.record.warnings, methods=head.result.record.methods)
        for quantity in self.quantities.values():
            record.add(quantity)
        self.writer.identity(replace(head.result, record=record))
        self.writer.number(self.writer.root, VERSION_ATTRIBUTE, SWEEP_SCHEMA_VERSION)
        inside = {name for path in self.quantities for name in path.split("/")}
        outer: list[str] = []
        for axis in head.axes:
            outer.append(free_name(axis.name, {*inside, *outer, SWEEP, PROVENANCE}))
        own = {path: quantity.axes for path, quantity in self.quantities.items()}
        self.writer.name_axes(own, (SWEEP, *outer))
        names = [one.name for one in fields(SweptKey)]
        axes = [
            {
                "name": axis.name,
                "keys": [{name: getattr(key, name) for name in names} for key in axis.keys],
            }
            for axis in head.axes
        ]
        place = self.writer.group(SWEEP)
        for name, text in (
            ("identity", head.identity),
            ("base", head.base),
            ("sampling", head.sampling),
            ("design", json.dumps(head.design)),
            ("axes", json.dumps(axes)),
            ("kept", json.dumps(list(head.stored))),
            ("left_out", json.dumps(left_out)),
        ):
            self.writer.text(place, name, text)
        return [self.axis(axis, name) for axis, name in zip(head.axes, outer, strict=True)]

    def axis(self, axis: SweptAxis, name: str) -> Any:
        """The scale of an axis, and the values of its keys along it."""
        from h5py import h5ds

        first, columns = axis.keys[0], axis.read(0, axis.count)
        number = SweptKey(key="", label="number of the point", unit="", written_unit="")
        if axis.name == SAMPLE:
            scale = self.column(name, np.arange(axis.count), number)
        elif first.choices:  # a grid has few of them, and who opens the file wants names
            scale = self.writer.dataset(self.writer.root, name, axis.values()[0])
            self.describe(scale, first)
        else:
            scale = self.column(name, columns[0], first)
        h5ds.set_scale(scale, axis.name.encode())
        for key, values in zip(axis.keys, columns, strict=True):
            column = self.column(f"{VALUES}/{key.key}", values, key)
            h5ds.attach_scale(column, scale, 0)
            h5ds.set_label(column, 0, axis.name.encode())
        return scale

    def column(self, path: str, values: np.ndarray, key: SweptKey) -> Any:
        """A dataset of numbers along an axis; its identifier."""
        made = self.dataset(path, values.shape, _WHOLE if values.dtype.kind in "iu" else _REAL, 0)
        made[...] = values
        self.describe(made.id, key)
        return made.id

    def describe(self, place: Any, key: SweptKey) -> None:
        """Unit and name, as on every axis."""
        self.writer.text(place, "units", key.unit)
        self.writer.text(place, "long_name", key.label)

    def quantity(self, quantity: Quantity) -> None:
        """The datasets of one quantity and of its errors."""
        lengths = tuple(len(axis.values) for axis in quantity.axes)
        kind = _COMPLEX if np.iscomplexobj(quantity.values) else _REAL
        values = self.over_points(quantity.path, kind, np.nan, lengths)
        self.writer.describe(values, quantity, first=len(self.shape))
        for folder in [ERRORS] if quantity.standard_error is None else [ERRORS, STANDARD_ERRORS]:
            errors = self.over_points(f"{folder}/{quantity.path}", _REAL, np.nan)
            self.writer.text(errors, "units", quantity.unit)

    def over_points(
        self, path: str, kind: np.dtype, fill: float, lengths: tuple[int, ...] = ()
    ) -> Any:
        """A dataset with the axes of the sweep, and its own after them; its identifier."""
        from h5py import h5ds

        made = self.datasets[path] = self.dataset(path, (*self.shape, *lengths), kind, fill)
        for position, axis in enumerate(self.head.axes):
            h5ds.attach_scale(made.id, self.scales[position], position)
            h5ds.set_label(made.id, position, axis.name.encode())
        return made.id

    def dataset(self, path: str, shape: tuple[int, ...], kind: np.dtype, fill: float) -> Any:
        """An empty dataset in chunks, each with a checksum; what is not written is `fill`."""
        import h5py

        folder, _, name = path.rpartition("/")
        chunks = {"chunks": chunk_shape(shape), "fletcher32": True} if math.prod(shape) else {}
        return h5py.Group(self.writer.group(folder)).create_dataset(
            name, shape, kind, fillvalue=np.array(fill, kind)[()], track_times=False, **chunks
        )
