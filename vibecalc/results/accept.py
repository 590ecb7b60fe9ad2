"""Making a result the golden one."""

from dataclasses import replace
from pathlib import Path

from vibecalc.errors import UsageError
from vibecalc.results.store import read_result, write_result

_HDF5_BEGINS = b"\x89HDF\r\n\x1a\n"


def accept(path: Path | str, golden: Path | str) -> Path:
    """Write the result at `path` over `golden`, and return where that is.

    Provenance (time, host, timings) is left out, so that a golden file changes only when the
    case, the version or a result does. Raises ResultError where `path` is not a result, and
    UsageError where `golden` cannot be written or holds something else than HDF5 (arguments the
    wrong way round must not cost a case file); it is then as it was.
    """
    accepted = replace(read_result(path), provenance={}, timings={})
    if _holds_something_else(Path(golden)):
        raise UsageError(
            f"{golden} is not a result file, so it is not overwritten; the golden file comes "
            "first: vibecalc diff GOLDEN.h5 NEW.h5 --accept (or remove it)"
        )
    return write_result(accepted, golden)


def _holds_something_else(path: Path) -> bool:
    try:
        with open(path, "rb") as stream:
            return stream.read(len(_HDF5_BEGINS)) != _HDF5_BEGINS
    except OSError:  # missing, a folder, unreadable: writing says what is wrong
        return False
