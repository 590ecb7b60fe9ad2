"""A result on disk: one HDF5 file, laid out as `vibecalc.results.layout` says."""

from pathlib import Path

from vibecalc.results.files import fresh_output, write_atomically
from vibecalc.results.record import Result
from vibecalc.results.store_write import file_image


def write_result(result: Result, path: Path | str) -> Path:
    """Write `result` to `path` and return where it is.

    The same result gives the same file, byte for byte; with other provenance, everything outside
    `/provenance` is the same. A reader sees the old file or the whole new one. Raises UsageError
    with the reason where the file cannot be written; an old result is then untouched.
    """
    target = fresh_output(path)
    return write_atomically(target, file_image(result))


def read_result(path: Path | str) -> Result:
    """Read a result file.

    Raises ResultError, in words, for a file that is missing, not a file, not HDF5, HDF5 of
    another program, of a later layout, or damaged. The structure of the file is guarded by the
    checksums of HDF5; the numbers themselves are not, comparing them is what `diff` is for.
    """
    from vibecalc.results.store_read import read_file  # a run only writes

    return read_file(Path(path))
