"""Files that HDF5 may crash on are read in a process of their own.

Variable-length texts lie in global heap collections, the one part of a result file that HDF5
keeps without a checksum. On damaged ones the library has been seen to loop for ever and to crash
(HDF5 2.0). So a result file carries a checksum of its heaps, and a file that does not match it,
edited since or damaged, is read in a child process with a time limit.
"""

import os
import sys
import zlib
from pathlib import Path

from vibecalc.errors import ResultError
from vibecalc.results.record import Result

#: signature and version of a global heap collection (HDF5 file format specification, III.E)
_COLLECTION = b"GCOL\x01"

_PROGRAM = "import sys; from vibecalc.results.store_read import send; send(sys.argv[1])"


def heap_checksum(content: bytes) -> int:
    """CRC-32 of all global heap collections in the bytes of an HDF5 file, in file order."""
    checksum = 0
    address = content.find(_COLLECTION)
    while address >= 0:
        size = int.from_bytes(content[address + 8 : address + 16], "little")
        end = min(address + max(size, len(_COLLECTION)), len(content))
        checksum = zlib.crc32(content[address:end], checksum)
        address = content.find(_COLLECTION, end)
    return checksum


def read_in_child(path: Path, time_limit: float = 10.0) -> Result:
    """Read `path` in a child process; a crash or `time_limit` seconds make it a damaged file."""
    import pickle
    import subprocess

    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(entry or "." for entry in sys.path)}
    try:
        child = subprocess.run(
            [sys.executable, "-c", _PROGRAM, str(path)],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=time_limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise ResultError(f"{path} is damaged: HDF5 does not come to an end with it") from None
    if child.returncode != 0:
        raise ResultError(f"{path} is damaged: HDF5 crashes on it")
    answer = pickle.loads(child.stdout)  # written by our own child
    if isinstance(answer, Result):
        return answer
    raise ResultError(str(answer))
