"""A block of points as the bytes of a file, and back."""

import hashlib
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.results.record import Axis
from vibecalc.study.sweep.block import Block, BlockQuantity

_FORMAT = 1
_DIGITS = 64  # of a SHA-256


def chunk_image(block: Block, identity: str) -> bytes:
    """Bytes of an npz file that ends with the SHA-256 of the rest; equal for equal blocks."""
    arrays: dict[str, np.ndarray] = {
        "indices": block.indices,
        "status": block.status,
        # many points tell the same, and an array of texts takes the room of the longest for each
        "cause": np.zeros(len(block.message), dtype=np.int32),
    }
    causes: dict[str, int] = {}
    for row, message in enumerate(block.message):
        arrays["cause"][row] = causes.setdefault(message, len(causes))
    rows = []
    for number, (path, one) in enumerate(block.quantities.items()):
        arrays[f"values_{number}"] = one.values
        arrays[f"errors_{number}"] = one.errors
        if one.standard_errors is not None:
            arrays[f"standard_errors_{number}"] = one.standard_errors
        for place, axis in enumerate(one.axes):
            # never as Python objects, which numpy would pickle
            is_text = axis.values.dtype.kind in "UOT"
            arrays[f"axis_{number}_{place}"] = axis.values.astype(np.str_ if is_text else None)
        rows.append(
            {
                "path": path,
                "unit": one.unit,
                "long_name": one.long_name,
                "amplitude": one.amplitude,
                "axes": [[axis.name, axis.unit, axis.long_name] for axis in one.axes],
            }
        )
    about = {
        "format": _FORMAT,
        "identity": identity,
        "causes": list(causes),
        "quantities": rows,
        "left_out": dict(block.left_out),
    }
    # lone surrogates in a message are no reason to lose a chunk
    arrays["about"] = np.frombuffer(json.dumps(about).encode("ascii"), dtype=np.uint8)
    stream = io.BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    with zipfile.ZipFile(stream, "a") as archive:
        archive.comment = b"0" * _DIGITS
    content = stream.getvalue()[:-_DIGITS]
    return content + hashlib.sha256(content).hexdigest().encode()


def chunk_block(content: bytes, path: Path, identity: str) -> Block:
    """The block in the bytes of a file; ResultError if they are not those once written."""
    kept, checksum = content[:-_DIGITS], content[-_DIGITS:]
    if hashlib.sha256(kept).hexdigest().encode() != checksum:
        raise ResultError(f"{path} is damaged: its checksum does not fit")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return _block(arrays, path, identity)
    except ResultError:
        raise
    except Exception as error:  # the checksum fits, so somebody else made this file
        raise ResultError(f"{path} is not a chunk of a sweep: {error}") from error


def _block(arrays: Any, path: Path, identity: str) -> Block:
    about = json.loads(arrays["about"].tobytes())
    if about["format"] != _FORMAT:
        raise ResultError(f"{path} was written by another version of vibecalc")
    if about["identity"] != identity:
        raise ResultError(f"{path} belongs to another sweep")
    causes = about["causes"]
    return Block(
        indices=arrays["indices"],
        status=arrays["status"],
        message=tuple(causes[cause] for cause in arrays["cause"]),
        quantities={
            row["path"]: _quantity(arrays, number, row)
            for number, row in enumerate(about["quantities"])
        },
        left_out=about["left_out"],
    )


def _quantity(arrays: Any, number: int, row: dict[str, Any]) -> BlockQuantity:
    return BlockQuantity(
        values=arrays[f"values_{number}"],
        errors=arrays[f"errors_{number}"],
        standard_errors=arrays.get(f"standard_errors_{number}"),
        axes=tuple(
            Axis(name=name, unit=unit, long_name=long_name, values=arrays[f"axis_{number}_{place}"])
            for place, (name, unit, long_name) in enumerate(row["axes"])
        ),
        unit=row["unit"],
        long_name=row["long_name"],
        amplitude=row["amplitude"],
    )
