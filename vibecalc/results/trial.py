"""Text heaps of a result file: their checksum, and whether HDF5 can walk them.

Variable-length texts lie in global heap collections, the one part of a result file that HDF5
keeps without a checksum. On damaged ones the library has been seen to loop for ever and to crash
(HDF5 2.0). So a result file carries a checksum of its heaps, and in a file that does not match it,
edited since or damaged, each collection is walked here before HDF5 does.
"""

import zlib
from collections.abc import Iterator
from pathlib import Path

from vibecalc.errors import ResultError

#: signature and version of a global heap collection (HDF5 file format specification, III.E)
_COLLECTION = b"GCOL\x01"
#: bytes of the header of a collection, and of an object in it
_HEADER = 16


def heap_checksum(content: bytes) -> int:
    """CRC-32 of all global heap collections in the bytes of an HDF5 file, in file order."""
    checksum = 0
    for start, size in _collections(content):
        checksum = zlib.crc32(content[start : start + size], checksum)
    return checksum


def check_heaps(content: bytes, path: Path) -> None:
    """ResultError unless the objects of each collection fill it, one after another."""
    for start, size in _collections(content):
        if not _is_whole(content[start : start + size], size):
            raise ResultError(f"{path} is damaged: its texts are not where they should be")


def _collections(content: bytes) -> Iterator[tuple[int, int]]:
    """Where each collection begins, and the size that it says it has."""
    start = content.find(_COLLECTION)
    while start >= 0:
        size = max(int.from_bytes(content[start + 8 : start + 16], "little"), len(_COLLECTION))
        yield start, size
        start = content.find(_COLLECTION, min(start + size, len(content)))


def _is_whole(collection: bytes, size: int) -> bool:
    if size < _HEADER or len(collection) < size:
        return False
    place, seen = _HEADER, set()
    while size - place >= _HEADER:
        index = int.from_bytes(collection[place : place + 2], "little")
        length = int.from_bytes(collection[place + 8 : place + 16], "little")
        if index == 0:  # free space, which counts its own header, up to the end
            return length == size - place
        if index in seen:
            return False
        seen.add(index)
        place += _HEADER + -(-length // 8) * 8
    return place <= size
