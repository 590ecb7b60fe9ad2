"""An HDF5 file as a result again, or one sentence on what is wrong with it."""

import json
import stat
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.case_hash import WRITTEN, case_hash, text_hash
from vibecalc.core.results.layout import (
    ENTRY_ERRORS,
    PROVENANCE,
    RESULT_SCHEMA_VERSION,
    TEXT_ATTRIBUTES,
    TEXT_CHECKSUM,
    TIMINGS,
    VERSION_ATTRIBUTE,
    check_heaps,
    text_checksum,
)
from vibecalc.core.results.record import AMPLITUDES, Axis, Method, Quantity, Record, Result
from vibecalc.core.results.renamed import (
    ENTRIES,
    current_axis,
    current_case,
    current_entry,
    current_path,
)
from vibecalc.core.results.steps import step
from vibecalc.core.results.text_files import HDF5_BEGINS
from vibecalc.core.results.verdicts import VERDICTS, from_objects
from vibecalc.core.results.visible import visible
from vibecalc.errors import ResultError

#: deflate, which a repacked file may use, packs a thousand to one at best
_LARGEST_RATIO = 1100


def read_file(path: Path) -> Result:
    """Read a result file; everything that can be wrong with it becomes a ResultError."""
    import h5py

    size = _checked_size(path)
    try:
        with h5py.File(path, "r", locking=False) as file:
            if not _is_as_written(file, path):
                check_heaps(path)
            result = _result(file, path, size)
    except ResultError:
        raise
    except Exception as error:
        raise _damaged(path, error) from error
    step(f"read {path}: {len(result)} quantities")
    return result


def _is_as_written(file: Any, path: Path) -> bool:
    """Whether the texts are those that vibecalc wrote; raises ResultError for foreign files."""
    if not {"vibecalc_version", "schema_version"} & set(file.attrs):
        raise ResultError(f"{path} is an HDF5 file, but not a result of vibecalc")
    attributes = getattr(file.get(PROVENANCE), "attrs", {})
    return TEXT_CHECKSUM in attributes and (
        _integer(file[PROVENANCE], path, TEXT_CHECKSUM) == text_checksum(path)
    )


def _checked_size(path: Path) -> int:
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise ResultError(f"{path} is a folder, not a result file")
        if not stat.S_ISREG(status.st_mode):
            raise ResultError(f"{path} is not a regular file")
        with open(path, "rb") as stream:
            start = stream.read(len(HDF5_BEGINS))
    except FileNotFoundError:
        raise ResultError(f"there is no result file {path}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ResultError(f"cannot read {path}: {reason.lower()}") from error
    if not start:
        raise ResultError(f"{path} is empty")
    if start != HDF5_BEGINS:
        if path.suffix == ".toml":
            raise ResultError(f"{path} is a case; run it first: vibecalc run {path}")
        raise ResultError(f"{path} is not an HDF5 file (it begins with {start!r})")
    return status.st_size


def _result(file: Any, path: Path, size: int) -> Result:
    version = _integer(file, path, "schema_version")
    if version > RESULT_SCHEMA_VERSION:
        raise ResultError(
            f"{path} has layout {version}, this vibecalc reads up to {RESULT_SCHEMA_VERSION}: "
            f"it was written by vibecalc {_text(file, path, 'vibecalc_version')}"
        )
    if version < 1:
        raise ResultError(f"{path} is damaged: schema_version is {version}")
    result = bare_result(file, path)
    axes: dict[Any, Axis] = {}
    for quantity_path in _json_list(file, path, "quantities"):
        result.record.add(_quantity(file, path, size, str(quantity_path), axes))
    return result


def bare_result(file: Any, path: Path) -> Result:
    """What a file says of its run, without the quantities.

    ResultError where the case, resolved or as written, is not the one that was run by its hash.
    """
    text = {name: raw_text(file, path, name) for name in TEXT_ATTRIBUTES}
    case = tomllib.loads(text["case_toml_resolved"])
    same = case_hash(case, text["vibecalc_version"]) == text["case_sha256"]
    if WRITTEN in file.attrs:
        same = same and text_hash(text["case_toml"]) == raw_text(file, path, WRITTEN)
    if not same:
        raise ResultError(
            f"{path} was changed since it was written: the case in it is not the one that was run"
        )
    record = Record(warnings=[str(warning) for warning in _json_list(file, path, "warnings")])
    record.methods.extend(Method(**method) for method in _json_list(file, path, "methods"))
    provenance, timings = _provenance(file)
    return Result(
        name=visible(text["name"]),
        case=shown(current_case(case)),
        case_toml=text["case_toml"],
        case_toml_resolved=text["case_toml_resolved"],
        case_sha256=visible(text["case_sha256"]),
        record=record,
        version=visible(text["vibecalc_version"]),
        plan=tuple(
            {str(key): str(value) for key, value in stage.items()}
            for stage in _json_list(file, path, "plan")
        ),
        provenance=provenance,
        timings=timings,
        swept=path.absolute() if VERSION_ATTRIBUTE in file.attrs else None,
        verdicts=(
            from_objects(_json_list(file, path, VERDICTS)) if VERDICTS in file.attrs else None
        ),
    )


def _quantity(
    file: Any, path: Path, size: int, quantity_path: str, known: dict[Any, Axis], over: int = 0
) -> Quantity:
    """A quantity; of a sweep over so many axes only what it is at each point, without values."""
    import h5py

    dataset = file.get(quantity_path)
    if not isinstance(dataset, h5py.Dataset):
        raise ResultError(f"{path} is damaged: it lists {quantity_path} but does not have it")
    there = set(dataset.attrs)
    amplitude = _text(dataset, path, "amplitude") if "amplitude" in there else None
    if amplitude not in (None, *AMPLITUDES):
        raise ResultError(f"{path} is damaged: {quantity_path} has amplitude {amplitude!r}")
    sizes = {"error_estimate": _real(dataset, path, "error_estimate")}
    optional = {"standard_error", "terms"} & there
    sizes |= {name: _real(dataset, path, name) for name in optional}
    if not sizes["error_estimate"] >= 0.0:
        raise ResultError(f"{path} is damaged: {quantity_path} has error {sizes['error_estimate']}")
    return Quantity(
        path=quantity_path if over else current_path(quantity_path),
        values=np.empty(0) if over else _values(dataset, path, size),
        unit=_text(dataset, path, "units"),
        long_name=_text(dataset, path, "long_name"),
        axes=tuple(
            _axis(dataset, path, size, position, known) for position in range(over, dataset.ndim)
        ),
        amplitude=amplitude,
        errors=_errors(dataset, path) if ENTRY_ERRORS in there else None,
        **sizes,
    )


def _errors(dataset: Any, path: Path) -> np.ndarray:
    """The errors of single entries."""
    errors = np.asarray(dataset.attrs[ENTRY_ERRORS])
    if errors.dtype.kind != "f" or errors.shape != dataset.shape or not np.all(errors >= 0.0):
        raise ResultError(f"{path} is damaged: {dataset.name[1:]} has errors of other entries")
    return errors


def _axis(dataset: Any, path: Path, size: int, position: int, known: dict[Any, Axis]) -> Axis:
    dimension = dataset.dims[position]
    name = current_axis(dimension.label)
    if len(dimension) != 1:
        raise ResultError(
            f"{path} is damaged: {dataset.name[1:]} has {len(dimension)} scales on axis {position}"
        )
    scale = dimension[0]
    if scale.id not in known:
        values = _values(scale, path, size)
        if name in ENTRIES and values.dtype.kind == "U":
            values = np.array([current_entry(name, entry) for entry in values.tolist()])
        known[scale.id] = Axis(
            name=name,
            values=values,
            unit=_text(scale, path, "units"),
            long_name=_text(scale, path, "long_name"),
            run_samples=_integer(scale, path, "run_samples") if "run_samples" in scale.attrs else 0,
        )
    axis = known[scale.id]
    if axis.values.shape != (dataset.shape[position],) or axis.name != name:
        raise ResultError(
            f"{path} is damaged: {dataset.name[1:]} and its axis {axis.name} do not fit together"
        )
    return axis


def _values(dataset: Any, path: Path, size: int) -> np.ndarray:
    import h5py

    kind = dataset.dtype.kind
    if dataset.size is None or dataset.size * 2 > _LARGEST_RATIO * size:
        raise ResultError(
            f"{path} is damaged: {dataset.name[1:]} says it has {dataset.size} entries"
        )
    if h5py.check_string_dtype(dataset.dtype) is not None:
        texts = np.asarray(dataset.asstr()[()])
        if not texts.size:
            return np.empty(texts.shape, dtype=np.str_)
        shown = [visible(one) for one in texts.ravel().tolist()]
        return np.array(shown, dtype=np.str_).reshape(texts.shape)
    if kind not in "fciu":
        raise ResultError(
            f"{path} is damaged: {dataset.name[1:]} holds values of type {dataset.dtype}"
        )
    plain = {"f": np.float64, "c": np.complex128, "i": np.int64, "u": np.int64}[kind]
    return np.asarray(dataset[()], dtype=plain)


def _provenance(file: Any) -> tuple[dict[str, str | int | float], dict[str, float]]:
    if PROVENANCE not in file:
        return {}, {}
    group = file[PROVENANCE]
    words: dict[str, str | int | float] = {
        name: visible(value) if isinstance(value, str) else value.item()
        for name, value in group.attrs.items()
        if name != TEXT_CHECKSUM
    }
    times = group[TIMINGS].attrs if TIMINGS in group else {}
    return words, {name: float(value) for name, value in times.items()}


def _attribute(place: Any, path: Path, name: str) -> Any:
    if name not in place.attrs:
        where = "" if place.name == "/" else f" of {place.name[1:]}"
        raise ResultError(f"{path} is damaged or foreign: the attribute {name}{where} is missing")
    return place.attrs[name]


def _text(place: Any, path: Path, name: str) -> str:
    """A text as it may be printed."""
    return visible(raw_text(place, path, name))


def raw_text(place: Any, path: Path, name: str) -> str:
    """A text as it stands: JSON, TOML."""
    value = _attribute(place, path, name)
    if not isinstance(value, str):
        raise ResultError(f"{path} is damaged: {name} of {place.name} is not a text")
    value.encode()  # text that is not UTF-8 arrives with lone surrogates
    return value


def _real(place: Any, path: Path, name: str) -> float:
    return float(_number(place, path, name, "fiu", "a number"))


def _integer(place: Any, path: Path, name: str) -> int:
    return int(_number(place, path, name, "iu", "a whole number"))


def _number(place: Any, path: Path, name: str, kinds: str, what: str) -> Any:
    value = _attribute(place, path, name)
    if np.ndim(value) or np.asarray(value).dtype.kind not in kinds:
        raise ResultError(f"{path} is damaged: {name} of {place.name} is not {what}")
    return value


def shown(content: Any) -> Any:
    """The same with all texts, those of keys too, as they may be printed."""
    if isinstance(content, dict):
        return {visible(key): shown(value) for key, value in content.items()}
    if isinstance(content, list):
        return [shown(value) for value in content]
    return visible(content) if isinstance(content, str) else content


def _json_list(file: Any, path: Path, name: str) -> list[Any]:
    content = json.loads(raw_text(file, path, name))
    if not isinstance(content, list):
        raise ResultError(f"{path} is damaged: {name} is not a list")
    return list(shown(content))


def _damaged(path: Path, error: Exception) -> ResultError:
    """HDF5 reports damage as any of OSError, RuntimeError, KeyError, ValueError, TypeError ..."""
    lines = str(error).strip().strip("'\"").splitlines()
    reason = f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
    return ResultError(f"{path} is damaged: {reason}")
