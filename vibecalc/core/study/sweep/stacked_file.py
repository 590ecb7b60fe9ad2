"""The file of a sweep, written block by block in little memory."""

import json
import math
from array import array
from collections.abc import Callable, Iterator, Mapping
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
    columns_of,
    write_points,
)
from vibecalc.core.study.sweep.blocks import Block, joined, stacked

_CACHE = 1 << 19  # bytes for each open dataset: two chunks of complex numbers
_MOST_CAUSES = 10_000
_OTHER_CAUSE = "another cause: a file keeps the words of the first ten thousand only"


def write_stacked(target: Path, head: SweepHead, blocks: Callable[[], Iterator[Block]]) -> None:
    """Write blocks, ascending, to `target` in one step; `blocks` is called twice, and equal.

    Equal input gives equal bytes; with other provenance, everything outside `/provenance` is
    equal. Points of no block are "not run". UsageError with the reason if it cannot be written;
    an old file is then as it was.
    """
    largest = dict[str, float]()

    def looked_through() -> Iterator[Block]:
        for block in blocks():
            for name in (name for path in block.described for name in columns_of(path)[1:]):
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
        whole = _StackedWriter(file.id, head, described, left_out)
        for block in blocks():
            whole.block(block)
            stream.check()
        whole.messages()
        whole.finish(file, head.result, lambda: text_checksum(temporary))


class _StackedWriter(_Writer):
    """The open file and its datasets over the points; `texts` numbers the words about those
    without a result."""

    def __init__(
        self,
        root: Any,
        head: SweepHead,
        described: Mapping[str, Quantity],
        left_out: Mapping[str, str],
    ) -> None:
        super().__init__(root)
        self.head, self.described = head, described
        self.datasets: dict[str, Any] = {}
        self.failed, self.causes, self.texts = array("q"), array("q"), dict[str, int]()
        names = self.about(left_out)
        self.outer = [self.swept(axis, name) for axis, name in zip(head.axes, names, strict=True)]
        status = self.over_points(STATUS, "i1", NOT_RUN)
        meaning = {str(status): words for status, words in STATUS_WORDS.items()}
        self.attribute(status, "meaning", json.dumps(meaning))
        for path, one in described.items():
            lengths = tuple(len(axis.values) for axis in one.axes)
            kind = one.values.dtype.newbyteorder("<")
            values = self.over_points(path, kind, np.nan, lengths)
            self.describe(values, one, first=len(head.axes))
            for name in columns_of(path)[1 : 2 + (one.standard_error is not None)]:
                self.attribute(self.over_points(name, "<f8", np.nan), "units", one.unit)

    def about(self, left_out: Mapping[str, str]) -> list[str]:
        """What the file says of the case and the sweep; the names of the axes of the sweep."""
        head, described = self.head, self.described
        record = Record(warnings=head.result.record.warnings, methods=head.result.record.methods)
        for quantity in described.values():
            record.add(quantity)
        self.identity(replace(head.result, record=record))
        self.attribute(self.root, VERSION_ATTRIBUTE, SWEEP_SCHEMA_VERSION)
        taken = {SWEEP, PROVENANCE, *(name for path in described for name in path.split("/"))}
        outer: list[str] = []
        for axis in head.axes:
            outer.append(free_name(axis.name, {*taken, *outer}))
        self.name_axes({path: one.axes for path, one in described.items()}, (SWEEP, *outer))
        names = [one.name for one in fields(SweptKey)]
        axes = [
            {
                "name": axis.name,
                "keys": [{name: getattr(key, name) for name in names} for key in axis.keys],
            }
            for axis in head.axes
        ]
        texts = {"identity": head.identity, "sampling": head.sampling}
        tables = {
            "design": head.design,
            "axes": axes,
            "kept": list(head.stored),
            "left_out": dict(left_out),
        }
        texts |= {name: json.dumps(table) for name, table in tables.items()}
        self.attributes(self.group(SWEEP), texts)
        return outer

    def swept(self, axis: SweptAxis, name: str) -> Any:
        """The scale of an axis of the sweep, and the values of its keys along it."""
        first = axis.keys[0]  # a grid has few choices, and who opens the file wants their names
        own = Axis(name=axis.name, values=axis.values()[0], unit=first.unit, long_name=first.label)
        if axis.name == SAMPLE:
            own = Axis(name=SAMPLE, values=np.arange(axis.count), long_name="number of the point")
        scale = self.scale("", own, name)
        for key, values in zip(axis.keys, axis.columns, strict=True):
            column = self.dataset(self.group(VALUES), key.key, values)
            self.attributes(column, {"units": key.unit, "long_name": key.label})
            self.along(column, 0, axis, scale)
        return scale

    def along(self, dataset: Any, position: int, axis: SweptAxis, scale: Any) -> None:
        """Give a dataset an axis of the sweep."""
        from h5py import h5ds

        h5ds.attach_scale(dataset, scale, position)
        h5ds.set_label(dataset, position, axis.name.encode())

    def over_points(self, path: str, kind: Any, fill: float, lengths: tuple[int, ...] = ()) -> Any:
        """A dataset with the axes of the sweep, and its own after them; its identifier."""
        made = self.chunked(path, (*self.head.shape, *lengths), kind, fill).id
        for position, axis in enumerate(self.head.axes):
            self.along(made, position, axis, self.outer[position])
        return made

    def chunked(self, path: str, shape: tuple[int, ...], kind: Any, fill: float) -> Any:
        """An empty dataset in chunks, each with a checksum; what is not written is `fill`."""
        import h5py

        folder, _, name = path.rpartition("/")
        chunks = {"chunks": chunk_shape(shape), "fletcher32": True} if math.prod(shape) else {}
        self.datasets[path] = h5py.Group(self.group(folder)).create_dataset(
            name, shape, kind, fillvalue=np.array(fill, kind)[()], track_times=False, **chunks
        )
        return self.datasets[path]

    def block(self, block: Block) -> None:
        """Write what a block of consecutive points has."""
        columns = {STATUS: block.status, **stacked(block, self.described)}
        for name, values in columns.items():
            write_points(self.datasets[name], values, int(block.indices[0]), self.head.shape)
        for row in np.flatnonzero((block.status != DONE) & (block.status != NOT_RUN)).tolist():
            words = block.message[row].replace("\0", "").encode("utf-8", "replace").decode()
            words = words or "no reason is known"
            if words not in self.texts and len(self.texts) >= _MOST_CAUSES:
                words = _OTHER_CAUSE
            self.failed.append(int(block.indices[row]))
            self.causes.append(self.texts.setdefault(words, len(self.texts)))

    def messages(self) -> None:
        """Write why points have no result."""
        for name, numbers in (("point", self.failed), ("cause", self.causes)):
            self.chunked(f"{MESSAGE}/{name}", (len(numbers),), "<i8", 0)[...] = numbers
        self.dataset(self.group(MESSAGE), "text", np.array(list(self.texts), dtype=object))
