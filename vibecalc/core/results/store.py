"""A result on disk: one HDF5 file, written here and read by `store_read`."""

import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.case_hash import WRITTEN, text_hash
from vibecalc.core.results.dimensions import dimension_names, stage_of
from vibecalc.core.results.files import fresh_output, write_atomically
from vibecalc.core.results.layout import (
    PROVENANCE,
    RESULT_SCHEMA_VERSION,
    TEXT_CHECKSUM,
    TIMINGS,
    heap_checksum,
)
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.core.results.verdicts import VERDICTS, as_objects
from vibecalc.errors import UsageError

# ----------------------------------------------------------------------------
# A result as the bytes of an HDF5 file.
#
# The file is built in memory, so that a full disk or an interruption meets one plain write of
# finished bytes. The low-level interface of h5py is used throughout: it is three times as fast on
# files of many small datasets, and it lets creation times be left out, which makes equal results
# equal files.
# ----------------------------------------------------------------------------


def file_image(result: Result) -> bytes:
    """Bytes of the HDF5 file that holds `result`.

    Raises UsageError for texts that HDF5 cannot hold, ValueError for a quantity whose axes do not
    fit its values (a mistake of ours).
    """
    import h5py

    stream = io.BytesIO()
    with h5py.File(_new_file(stream)) as file:
        writer = _Writer(file.id)
        writer.identity(result)
        writer.name_axes({path: quantity.axes for path, quantity in result.items()})
        for quantity in result.record.values():
            writer.quantity(quantity)
        writer.finish(file, result, lambda: heap_checksum(stream))
    return stream.getvalue()


def _new_file(stream: io.BytesIO) -> Any:
    """Identifier of a new HDF5 file in `stream`.

    Not the image that HDF5 gives of an open file: 1.14.2 clears a flag in the first block of that
    image and leaves the checksum of the block as it was, so nobody can open it.
    """
    from h5py import h5f, h5fd, h5p

    created = h5p.create(h5p.FILE_CREATE)
    created.set_obj_track_times(False)  # HDF5 1.14 keeps times of the root group otherwise
    access = h5p.create(h5p.FILE_ACCESS)
    access.set_fclose_degree(h5f.CLOSE_STRONG)
    # Format of HDF5 1.8: every reader has it, and its headers carry checksums.
    access.set_libver_bounds(h5f.LIBVER_V18, h5f.LIBVER_V18)
    access.set_fileobj_driver(h5fd.fileobj_driver, stream)
    return h5f.create(b"result", h5f.ACC_TRUNC, fcpl=created, fapl=access)


class _Writer:
    """The open file with its types, groups and the dimension scales written so far."""

    def __init__(self, root: Any) -> None:
        import h5py
        from h5py import h5d, h5p, h5s, h5t

        self.root = root
        self.scalar = h5s.create(h5s.SCALAR)
        self.text_dtype = h5py.string_dtype()
        self.text_in_file = h5t.py_create(self.text_dtype, logical=True)
        self.text_in_memory = h5t.py_create(self.text_dtype)
        self.number_types = {
            name: h5t.py_create(np.dtype(name), logical=True) for name in set(_STORED.values())
        }
        self.contiguous = h5p.create(h5p.DATASET_CREATE)
        self.contiguous.set_obj_track_times(False)
        self.compact = h5p.create(h5p.DATASET_CREATE)
        self.compact.set_obj_track_times(False)
        self.compact.set_layout(h5d.COMPACT)
        self.groups: dict[str, Any] = {"": root}
        self.dimensions: dict[str, tuple[str, ...]] = {}
        self.scales: dict[tuple[str, str], Any] = {}
        self.linked: set[str] = set()

    def identity(self, result: Result) -> None:
        """Root attributes: who wrote the file, for which case, what was done."""
        self.attributes(
            self.root,
            {
                "schema_version": RESULT_SCHEMA_VERSION,
                "vibecalc_version": result.version,
                "name": result.name,
                "case_sha256": result.case_sha256,
                "case_toml": result.case_toml,
                WRITTEN: text_hash(result.case_toml),
                "case_toml_resolved": result.case_toml_resolved,
                "quantities": _json(list(result.record)),
                "plan": _json([dict(stage) for stage in result.plan]),
                "warnings": _json(result.record.warnings),
                "methods": _json([method._asdict() for method in result.record.methods]),
            },
        )
        if result.verdicts is not None:
            self.attribute(self.root, VERDICTS, _json(as_objects(result.verdicts)))

    def name_axes(self, axes: Mapping[str, Sequence[Axis]], outer: Sequence[str] = ()) -> None:
        """Choose names for the axes of all quantities; `outer` are those of groups and sweeps."""
        self.dimensions = dimension_names(axes, (PROVENANCE, *outer))

    def quantity(self, quantity: Quantity) -> None:
        """One dataset with its attributes and axes."""

        values = np.asarray(quantity.values)
        _check(quantity, values)
        folder, _, name = quantity.path.rpartition("/")
        self.describe(self.dataset(self.group(folder), name, values), quantity)

    def describe(self, dataset: Any, quantity: Quantity, first: int = 0) -> None:
        """The attributes of a quantity and its axes, from position `first` on."""
        from h5py import h5ds

        self.attributes(dataset, quantity.attributes)
        names = self.dimensions[quantity.path]
        for position, (axis, name) in enumerate(zip(quantity.axes, names, strict=True), first):
            h5ds.attach_scale(dataset, self.scale(quantity.path, axis, name), position)
            h5ds.set_label(dataset, position, _encoded(axis.name))

    def finish(self, file: Any, result: Result, checksum: Callable[[], int]) -> None:
        """What changes from run to run, and last the checksum of all texts in the file.

        HDF5 keeps none of them, so we do, once their bytes are final.
        """
        from h5py import h5a

        group = self.group(PROVENANCE)
        self.attributes(group, result.provenance)
        if result.timings:
            self.attributes(self.group(f"{PROVENANCE}/{TIMINGS}"), result.timings)
        self.attribute(group, TEXT_CHECKSUM, 0)
        file.flush()
        h5a.open(group, TEXT_CHECKSUM.encode()).write(np.array(checksum()))

    def group(self, path: str) -> Any:
        """The group at `path`, made with its parents when first asked for."""
        from h5py import h5g, h5p

        if path not in self.groups:
            folder, _, name = path.rpartition("/")
            options = h5p.create(h5p.GROUP_CREATE)
            options.set_obj_track_times(False)
            options.set_attr_creation_order(h5p.CRT_ORDER_TRACKED | h5p.CRT_ORDER_INDEXED)
            self.groups[path] = h5g.create(self.group(folder), _encoded(name), gcpl=options)
        return self.groups[path]

    def scale(self, path: str, axis: Axis, name: str) -> Any:
        """The dimension scale for an axis, in the group of a quantity; a stage has it once.

        Where it stands in several groups these have links to it: readers of one look there.
        """
        from h5py import h5ds, h5i

        folder, key = path.rpartition("/")[0], (stage_of(path), name)
        place = f"{folder}/{name}"
        if key not in self.scales:
            dataset = self.dataset(self.group(folder), name, np.asarray(axis.values))
            h5ds.set_scale(dataset, _encoded(axis.name))
            self.attributes(dataset, {"units": axis.unit, "long_name": axis.long_name})
            if axis.run_samples:
                self.attribute(dataset, "run_samples", axis.run_samples)
            self.scales[key] = dataset
        elif place not in self.linked:
            shared = h5i.get_name(self.scales[key])
            self.group(folder).links.create_hard(_encoded(name), self.root, shared)
        self.linked.add(place)
        return self.scales[key]

    def dataset(self, group: Any, name: str, values: np.ndarray) -> Any:
        """A dataset of float64, complex128, int64 (flags are 0 and 1) or texts.

        Small ones live in their object header, which has a checksum.
        """
        from h5py import h5d, h5s

        stored, in_file, in_memory = self.typed(values)
        space = h5s.create_simple(stored.shape) if stored.ndim else self.scalar
        options = self.compact if 0 < stored.size <= _COMPACT_ENTRIES else self.contiguous
        dataset = h5d.create(group, _encoded(name), in_file, space, options)
        if stored.size:
            dataset.write(h5s.ALL, h5s.ALL, stored, mtype=in_memory)
        return dataset

    def typed(self, values: np.ndarray) -> tuple[np.ndarray, Any, Any]:
        """Values as they are stored, with their type in the file and in memory."""
        if _is_text(values):
            texts = [_plain(str(text)) for text in values.ravel()]
            stored = np.array(texts, dtype=self.text_dtype).reshape(values.shape)
            return stored, self.text_in_file, self.text_in_memory
        name = _STORED[values.dtype.kind]
        kind = self.number_types[name]
        return np.array(values, dtype=name, order="C"), kind, kind

    def attributes(self, place: Any, given: Mapping[str, Any]) -> None:
        """Attributes by their names."""
        for name, value in given.items():
            self.attribute(place, name, value)

    def attribute(self, place: Any, name: str, value: str | int | float | np.ndarray) -> None:
        """A text, a number or an array of numbers as an attribute."""
        from h5py import h5a, h5s

        # a text as it is: an array of texts loses zero characters at their end
        values = np.array(value, dtype=object) if isinstance(value, str) else np.asarray(value)
        stored, in_file, in_memory = self.typed(values)
        space = h5s.create_simple(stored.shape) if stored.ndim else self.scalar
        h5a.create(place, _encoded(name), in_file, space).write(stored, mtype=in_memory)


#: 32 kB of complex numbers or texts; an object header takes 64 kB
_COMPACT_ENTRIES = 2000

_STORED = {"f": "<f8", "c": "<c16", "i": "<i8", "u": "<i8", "b": "<i8"}


def _check(quantity: Quantity, values: np.ndarray) -> None:
    shape = tuple(len(axis.values) for axis in quantity.axes)
    if values.shape != shape:
        raise ValueError(f"{quantity.path}: values {values.shape}, axes {shape}")
    if not _is_text(values) and values.dtype.kind not in _STORED:
        raise ValueError(
            f"{quantity.path}: values of type {values.dtype} have no place in a result"
        )
    if not quantity.error_estimate >= 0.0:
        raise ValueError(f"{quantity.path}: error estimate {quantity.error_estimate}")


def _is_text(values: np.ndarray) -> bool:
    return values.dtype.kind in "UOT"


def _json(content: object) -> str:
    return json.dumps(content, ensure_ascii=False, allow_nan=False)


def _plain(text: str) -> str:
    """A text as it is; UsageError where HDF5 would end it, or cannot hold it."""
    try:
        text.encode()  # a lone surrogate is found here, with its position
        if "\0" in text:
            raise ValueError(f"{text[:40]!r} contains a zero character")
    except ValueError as error:
        raise UsageError(f"a text of this result cannot be stored in HDF5: {error}") from error
    return text


def _encoded(name: str) -> bytes:
    return _plain(name).encode()


# ----------------------------------------------------------------------------
# A result on disk: one HDF5 file, laid out as `vibecalc.core.results.layout` says.
# ----------------------------------------------------------------------------


def write_result(result: Result, path: Path | str) -> Path:
    """Write `result` to `path` and return where it is.

    The same result gives the same file, byte for byte; with other provenance, everything outside
    `/provenance` is the same. A reader sees the old file or the whole new one. Raises UsageError
    with the reason where the file cannot be written; an old result is then untouched.
    """
    fresh_output(path)  # what is wrong with the place is said before any work
    return write_atomically(path, file_image(result))


def read_result(path: Path | str) -> Result:
    """Read a result file.

    Raises ResultError, in words, for a file that is missing, not a file, not HDF5, HDF5 of
    another program, of a later layout, or damaged. The structure of the file is guarded by the
    checksums of HDF5; the numbers themselves are not, comparing them is what `diff` is for.
    """
    from vibecalc.core.results.store_read import read_file  # a run only writes

    return read_file(Path(path))
