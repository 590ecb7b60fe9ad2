"""The file of a sweep, written block by block in little memory."""

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.dimensions import free_name
from vibecalc.core.results.files import new_hdf5, written_aside
from vibecalc.core.results.layout import (
    DONE,
    MESSAGE,
    NOT_RUN,
    PROVENANCE,
    SAMPLE,
    STATUS,
    STATUS_WORDS,
    SWEEP,
    SWEEP_SCHEMA_VERSION,
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
from vibecalc.core.study.sweep.blocks import Block, columns_of, joined, stacked

_CACHE = 1 << 19  # bytes for each open dataset: two chunks of complex numbers
_WHOLE, _REAL = np.dtype("<i8"), np.dtype("<f8")
_MOST_CAUSES = 10_000
_LONGEST_CAUSE = 4_000  # characters
_OTHER_CAUSE = "another cause: a file keeps the words of the first ten thousand only"


def write_stacked(target: Path, head: SweepHead, blocks: Callable[[], Iterator[Block]]) -> None:
    """Write blocks, ascending, to `target` in one step; `blocks` is called twice, and equal.

    Equal input gives equal bytes; with other provenance, everything outside `/provenance` is
    equal. Points of no block are "not run". UsageError with the reason if it cannot be written;
    an old file is then as it was.
    """
    largest, failed = dict[str, float](), 0

    def looked_through() -> Iterator[Block]:
        nonlocal failed
        for block in blocks():
            failed += _failures(block).size
            for path in block.described:
                for name in columns_of(path)[1:]:
                    if name in block.columns:
                        seen = largest.get(name, 0.0)
                        largest[name] = float(np.fmax.reduce(block.columns[name], initial=seen))
            yield block

    described, left_out = joined(looked_through(), head.stored)
    for path, one in described.items():
        _, errors, spread = columns_of(path)
        described[path] = replace(
            one, error_estimate=largest[errors], standard_error=largest.get(spread), errors=None
        )
    with (
        written_aside(target, check_sweep) as temporary,
        new_hdf5(temporary, _CACHE) as (file, stream),
    ):
        whole = _StackedWriter(file, head, described, left_out, failed)
        for block in blocks():
            whole.block(block)
            stream.check()
        words = np.array(list(whole.texts), dtype=object)
        whole.writer.dataset(whole.writer.group(MESSAGE), "text", words)
        whole.writer.finish(file, head.result, lambda: text_checksum(temporary))


def _failures(block: Block) -> np.ndarray:
    """Rows of a block that were run and have no result."""
    return np.flatnonzero((block.status != DONE) & (block.status != NOT_RUN))


class _StackedWriter:
    """The open file and its datasets; `texts` numbers the words about points without a result."""

    def __init__(
        self,
        file: Any,
        head: SweepHead,
        described: dict[str, Quantity],
        left_out: dict[str, str],
        failed: int,
    ) -> None:
        self.writer = _Writer(file.id)
        self.head, self.described, self.failed = head, described, 0
        self.texts: dict[str, int] = {}
        self.datasets: dict[str, Any] = {}
        self.scales = self.attributes(left_out)
        status = self.over_points(STATUS, np.dtype("i1"), NOT_RUN)
        meaning = {str(status): words for status, words in STATUS_WORDS.items()}
        self.writer.text(status, "meaning", json.dumps(meaning))
        for path, one in described.items():
            kind = one.values.dtype.newbyteorder("<")
            values = self.over_points(
                path, kind, np.nan, tuple(len(axis.values) for axis in one.axes)
            )
            self.writer.describe(values, one, first=len(head.axes))
            for name in columns_of(path)[1 : 2 + (one.standard_error is not None)]:
                self.writer.text(self.over_points(name, _REAL, np.nan), "units", one.unit)
        for name in ("point", "cause"):
            self.dataset(f"{MESSAGE}/{name}", (failed,), _WHOLE, 0)

    def block(self, block: Block) -> None:
        """Write what a block has."""
        first, rows = int(block.indices[0]), _failures(block)
        if not np.array_equal(block.indices, np.arange(first, first + len(block.status))):
            raise ValueError("the points of a block are not consecutive")
        for name, values in {STATUS: block.status, **stacked(block, self.described)}.items():
            write_points(self.datasets[name], values, first, self.head.shape)
        if rows.size:
            place = slice(self.failed, self.failed + rows.size)
            self.datasets[f"{MESSAGE}/point"][place] = block.indices[rows]
            causes = [self.cause(block.message[row]) for row in rows]
            self.datasets[f"{MESSAGE}/cause"][place] = causes
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
        head, described, place = self.head, self.described, self.writer.group(SWEEP)
        record = Record(warnings=head.result.record.warnings, methods=head.result.record.methods)
        for quantity in described.values():
            record.add(quantity)
        self.writer.identity(replace(head.result, record=record))
        self.writer.number(self.writer.root, VERSION_ATTRIBUTE, SWEEP_SCHEMA_VERSION)
        taken = {SWEEP, PROVENANCE, *(name for path in described for name in path.split("/"))}
        outer: list[str] = []
        for axis in head.axes:
            outer.append(free_name(axis.name, {*taken, *outer}))
        self.writer.name_axes({path: one.axes for path, one in described.items()}, (SWEEP, *outer))
        names = [one.name for one in fields(SweptKey)]
        axes = [
            {
                "name": axis.name,
                "keys": [{name: getattr(key, name) for name in names} for key in axis.keys],
            }
            for axis in head.axes
        ]
        for name, text in (
            ("identity", head.identity),
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

        first = axis.keys[0]  # a grid has few choices, and who opens the file wants their names
        own = Axis(name=axis.name, values=axis.values()[0], unit=first.unit, long_name=first.label)
        if axis.name == SAMPLE:
            own = Axis(name=SAMPLE, values=np.arange(axis.count), long_name="number of the point")
        scale = self.writer.scale("", own, name)
        for key, values in zip(axis.keys, axis.columns, strict=True):
            column = self.writer.dataset(self.writer.group(VALUES), key.key, values)
            self.writer.text(column, "units", key.unit)
            self.writer.text(column, "long_name", key.label)
            h5ds.attach_scale(column, scale, 0)
            h5ds.set_label(column, 0, axis.name.encode())
        return scale

    def over_points(
        self, path: str, kind: np.dtype, fill: float, lengths: tuple[int, ...] = ()
    ) -> Any:
        """A dataset with the axes of the sweep, and its own after them; its identifier."""
        from h5py import h5ds

        made = self.dataset(path, (*self.head.shape, *lengths), kind, fill)
        for position, axis in enumerate(self.head.axes):
            h5ds.attach_scale(made.id, self.scales[position], position)
            h5ds.set_label(made.id, position, axis.name.encode())
        return made.id

    def dataset(self, path: str, shape: tuple[int, ...], kind: np.dtype, fill: float) -> Any:
        """An empty dataset in chunks, each with a checksum; what is not written is `fill`."""
        import h5py

        folder, _, name = path.rpartition("/")
        chunks = {"chunks": chunk_shape(shape), "fletcher32": True} if math.prod(shape) else {}
        self.datasets[path] = h5py.Group(self.writer.group(folder)).create_dataset(
            name, shape, kind, fillvalue=np.array(fill, kind)[()], track_times=False, **chunks
        )
        return self.datasets[path]
