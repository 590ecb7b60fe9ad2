"""What the file of a sweep says of itself: whose it is, for which case and which points."""

import json
import tomllib
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.results.layout import PROVENANCE, TEXT_ATTRIBUTES, TEXT_CHECKSUM
from vibecalc.results.record import Method, Record, Result
from vibecalc.results.store_read import _integer, _json_list, _provenance, _text
from vibecalc.results.sweep_layout import (
    SWEEP,
    SWEEP_SCHEMA_VERSION,
    VALUES,
    VERSION_ATTRIBUTE,
)
from vibecalc.results.sweep_record import SweepHead, SweptAxis, SweptKey
from vibecalc.results.trial import _COLLECTION

_PIECE = 1 << 20  # bytes


def check_origin(file: Any, path: Path) -> None:
    if VERSION_ATTRIBUTE not in file.attrs:
        what = "the result of a single run" if "schema_version" in file.attrs else "an HDF5 file"
        raise ResultError(f"{path} is {what}, not of a sweep")
    version = _integer(file, path, VERSION_ATTRIBUTE)
    if version > SWEEP_SCHEMA_VERSION:
        raise ResultError(
            f"{path} has layout {version} of a sweep, "
            f"this vibecalc reads up to {SWEEP_SCHEMA_VERSION}"
        )
    # HDF5 has been seen to crash on damaged texts, so they are looked at before it sees them
    if _integer(file[PROVENANCE], path, TEXT_CHECKSUM) != text_checksum(path):
        raise ResultError(f"{path} was changed since it was written, or is damaged")


def read_head(file: Any, path: Path) -> SweepHead:
    place = file[SWEEP]
    text = {name: _text(file, path, name) for name in TEXT_ATTRIBUTES}
    record = Record(warnings=[str(warning) for warning in _json_list(file, path, "warnings")])
    record.methods.extend(Method(**method) for method in _json_list(file, path, "methods"))
    provenance, timings = _provenance(file)
    result = Result(
        name=text["name"],
        case=tomllib.loads(text["case_toml_resolved"]),
        case_toml=text["case_toml"],
        case_toml_resolved=text["case_toml_resolved"],
        case_sha256=text["case_sha256"],
        record=record,
        version=text["vibecalc_version"],
        plan=tuple(_json_list(file, path, "plan")),
        provenance=provenance,
        timings=timings,
    )
    return SweepHead(
        result=result,
        axes=tuple(_swept(file, axis) for axis in _json_list(place, path, "axes")),
        sampling=_text(place, path, "sampling"),
        design=json_table(place, path, "design"),
        kept=tuple(str(name) for name in _json_list(place, path, "kept")),
        identity=_text(place, path, "identity"),
        base=_text(place, path, "base"),
    )


def _swept(file: Any, axis: dict[str, Any]) -> SweptAxis:
    keys = tuple(SweptKey(**{**key, "choices": tuple(key["choices"])}) for key in axis["keys"])
    columns = [file[VALUES][key.key] for key in keys]

    def read(first: int, last: int) -> list[np.ndarray]:
        return [np.asarray(column[first:last]) for column in columns]

    return SweptAxis(name=axis["name"], count=columns[0].shape[0], keys=keys, read=read)


def listed(file: Any, path: Path) -> list[Any]:
    return _json_list(file, path, "quantities")


def json_table(place: Any, path: Path, name: str) -> dict[str, Any]:
    content = json.loads(_text(place, path, name))
    if not isinstance(content, dict):
        raise ResultError(f"{path} is damaged: {name} is no table")
    return content


def text_checksum(path: Path) -> int:
    """What `heap_checksum` gives for the bytes of a file, in little memory."""
    checksum, address = 0, 0
    with open(path, "rb") as stream:
        while True:
            stream.seek(address)
            piece = stream.read(_PIECE)
            found = piece.find(_COLLECTION)
            if found >= 0:
                address += found
                stream.seek(address + 8)
                size = max(int.from_bytes(stream.read(8), "little"), len(_COLLECTION))
                stream.seek(address)
                address += size
                while size > 0 and (piece := stream.read(min(size, _PIECE))):
                    checksum = zlib.crc32(piece, checksum)
                    size -= len(piece)
            elif len(piece) < _PIECE:
                return checksum
            else:
                address += len(piece) - len(_COLLECTION) + 1
