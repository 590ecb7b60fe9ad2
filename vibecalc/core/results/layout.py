"""Names and versions in the files of runs, sweeps and accuracy tables: of writers and readers."""

import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from vibecalc.core.results.record import Result
from vibecalc.errors import ResultError

# ----------------------------------------------------------------------------
# Names and versions in a result file, shared by its writer and its reader.
#
#     /                       attributes: vibecalc_version, schema_version, name, case_sha256,
#                             case_toml (as written), case_toml_sha256, case_toml_resolved, and
#                             as JSON texts:
#                             quantities (paths in the order they were made), plan, warnings,
#                             methods, verdicts (each limit as it was judged, an object with the
#                             fields of `vibecalc.core.results.record.Verdict`)
#     /<stage>/...            one dataset for each quantity, under its path; attributes units,
#                             long_name, error_estimate, and amplitude, standard_error,
#                             terms and errors (of each entry, where they differ) if any
#     /<stage>/.../<axis>     dimension scales (`order`, `order_2`, ...) in each group where they
#                             stand: one for equal axes of a stage, under several links
#     /provenance             attributes that change from run to run (among them `libraries`,
#                             what its process had imported), left out of comparisons,
#                             and text_checksum, a CRC-32 of all texts in the file
#     /provenance/timings     attributes: seconds per stage
#
# All texts are variable-length UTF-8, which HDF5 keeps outside the object header, so that a case of
# more than 64 kB fits into an attribute. Complex numbers are compounds of `r` and `i`.
#
# Behind the HDF5 data `run` writes what it made the file from, core/case/inputs.py.
# ----------------------------------------------------------------------------

#: version of the layout of result files
RESULT_SCHEMA_VERSION = 1

TEXT_ATTRIBUTES = (
    "vibecalc_version",
    "name",
    "case_sha256",
    "case_toml",
    "case_toml_resolved",
)

PROVENANCE = "provenance"
TIMINGS = "timings"
TEXT_CHECKSUM = "text_checksum"
#: attribute of a dataset: absolute errors of its entries
ENTRY_ERRORS = "errors"

# ----------------------------------------------------------------------------
# Text heaps of a result file: their checksum, and whether HDF5 can walk them.
#
# Variable-length texts lie in global heap collections, the one part of a result file that HDF5
# keeps without a checksum. On damaged ones the library has been seen to loop for ever and to crash
# (HDF5 2.0). So a result file carries a checksum of its heaps, and in a file that does not match
# it, edited since or damaged, each collection is walked here before HDF5 does.
# ----------------------------------------------------------------------------

#: signature and version of a global heap collection (HDF5 file format specification, III.E)
_COLLECTION = b"GCOL\x01"
#: bytes of the header of a collection, and of an object in it
_HEADER = 16
#: bytes read at once
_PIECE = 1 << 16


def heap_checksum(stream: BinaryIO) -> int:
    """CRC-32 of all global heap collections of an HDF5 file, in file order.

    Read piece by piece: the file of a sweep may be larger than memory. Never through a memory map,
    where a full file system ends the process with a bus error.
    """
    checksum = 0
    for _, collection in _collections(stream):
        checksum = zlib.crc32(collection, checksum)
    return checksum


def text_checksum(path: Path) -> int:
    """What `heap_checksum` gives for a file on disk; raises OSError."""
    with open(path, "rb") as stream:
        return heap_checksum(stream)


def check_heaps(path: Path) -> None:
    """ResultError unless the objects of each collection fill it, one after another."""
    with open(path, "rb") as stream:
        for size, collection in _collections(stream):
            if not _is_whole(collection, size):
                raise ResultError(f"{path} is damaged: its texts are not where they should be")


def _collections(stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """The size that each collection says it has, and what is there of it."""
    end, start = stream.seek(0, os.SEEK_END), 0
    while start < end:
        stream.seek(start)
        piece = stream.read(_PIECE)
        found = piece.find(_COLLECTION)
        if found < 0:  # a signature may lie across the end of a piece
            start += max(1, len(piece) - len(_COLLECTION) + 1)
            continue
        start += found
        stream.seek(start)
        size = max(int.from_bytes(stream.read(_HEADER)[8:], "little"), len(_COLLECTION))
        stream.seek(start)
        yield size, stream.read(min(size, end - start))
        start += size


def _is_whole(collection: bytes, size: int) -> bool:
    if size < _HEADER or len(collection) < size:
        return False
    place, visited = _HEADER, set()
    while size - place >= _HEADER:
        index = int.from_bytes(collection[place : place + 2], "little")
        length = int.from_bytes(collection[place + 8 : place + 16], "little")
        if index == 0:  # free space, which counts its own header, up to the end
            return length == size - place
        if index in visited:
            return False
        visited.add(index)
        place += _HEADER + -(-length // 8) * 8
    return place <= size


# ----------------------------------------------------------------------------
# Names in the file of a sweep, shared by its writer and its reader.
#
# A sweep is stored as a result whose quantities have the axes of the sweep first and their own axes
# after them. What it has on top of that:
#
#     /                       attribute sweep_schema_version; dimension scales of the axes of the
#                             sweep: values of the first key of each, or numbers of samples
#     /sweep                  attributes identity, sampling, and as JSON texts: design, axes
#                             (name, keys, labels, written units), kept (paths asked for) and
#                             left_out (path to the reason why it could not be stacked)
#     /sweep/status           what became of each point (`STATUS_WORDS`)
#     /sweep/values/<key>     values of each key along its axis
#     /sweep/message          for points without a result: point (numbers, in C order), cause (rows
#                             of text) and text
#     /sweep/error_estimate/<path>, /sweep/standard_error/<path>
#                             errors of each point; the attributes of a quantity are the largest
#
# Points without a quantity are NaN. Orders that a point does not have, where others do, are zero.
# ----------------------------------------------------------------------------

SWEEP_SCHEMA_VERSION = 1

SWEEP = "sweep"
VERSION_ATTRIBUTE = "sweep_schema_version"
STATUS = "sweep/status"
VALUES = "sweep/values"
MESSAGE = "sweep/message"
ERRORS = "sweep/error_estimate"
STANDARD_ERRORS = "sweep/standard_error"

NOT_RUN, DONE, REFUSED, FAILED, TIMED_OUT, DIED, BUG = range(-1, 6)

#: what another try, with more time or on another machine, may change
UNLUCKY = (TIMED_OUT, DIED)

#: what became of a point, in words
STATUS_WORDS = {
    NOT_RUN: "not run",
    DONE: "done",
    REFUSED: "input refused",
    FAILED: "numerical failure",
    TIMED_OUT: "timed out",
    DIED: "process died",
    BUG: "error in the program",
}

#: key of the crank speed, and the last words of natural frequencies and of what damps them
SPEED, NATURAL, DAMPING = "machine.speed", "/natural_frequency", "/damping_ratio"

#: name of the one axis of a sampling
SAMPLE = "sample"

# ----------------------------------------------------------------------------
# What a result of `vibecalc accuracy` holds, shared by its writer and its readers.
#
#     accuracy/<stage>/<topic>/worst_relative, worst_level, position_error, work, status, cause,
#         setting, is_default, on_front         (level)     one entry for each method and setting
#     .../order, order_kind                     (method)   fitted order of convergence
#     .../agreement, extra_work                            of the reference; of the default
#
# All of these are the same from run to run on one machine. What is not is a JSON text in the
# attribute `accuracy` of /provenance: seconds of each level (null: not run), by the folder of the
# topic. The words of topics and methods are rows of `plan`, distinguished by the key `method`.
# ----------------------------------------------------------------------------

ACCURACY = "accuracy"

#: how a level ended
TRIAL_DONE, TRIAL_FAILED, TRIAL_NOT_RUN = 0, 1, 2
TRIAL_STATUS_WORDS = {TRIAL_DONE: "done", TRIAL_FAILED: "failed", TRIAL_NOT_RUN: "not run"}

#: worst relative errors that users ask for
TARGETS = (1e-3, 1e-6, 1e-9)

#: kinds of a fitted order
ALGEBRAIC, GEOMETRIC, NOT_FITTED = "order", "digits", "none"

#: between the method and the setting in the name of a level
BETWEEN = " | "

#: name in /provenance
MEASURED = "accuracy"


def is_accuracy(result: Result) -> bool:
    """Whether a result is one of `vibecalc accuracy`."""
    return any(path.startswith(f"{ACCURACY}/") for path in result.record)
