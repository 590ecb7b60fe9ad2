"""Quantities of a result for other programs: CSV files, a MATLAB file, a netCDF file."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.results.files import write_together
from vibecalc.core.results.plain import comma_separated
from vibecalc.core.results.record import Quantity, Result


def export_result(
    result: Result, form: str, folder: Path, stem: str, wanted: Sequence[str] = ()
) -> list[Path]:
    """Write quantities as files into `folder`, their names beginning with `stem`.

    Parameters
    ----------
    form : `csv`: single numbers in one file, a file for each array; `mat`: a struct of the paths,
        each quantity with `value`, `unit`, `error` and its axes; `netcdf`: groups of the paths,
        complex quantities as pairs of a real and an imaginary part.
    wanted : paths, or groups of them; all without any.

    Raises
    ------
    ResultError
        There is no such quantity.
    UsageError
        A library is missing, or files cannot be written.
    """
    chosen = _chosen(result, wanted)
    write = {"csv": _csv, "mat": _mat, "netcdf": _netcdf}[form]
    return write_together(write(chosen, folder, stem))


def _chosen(result: Result, wanted: Sequence[str]) -> dict[str, Quantity]:
    if not wanted:
        return dict(result)
    chosen: dict[str, Quantity] = {}
    for given in wanted:
        name = given.strip("/")
        group = {path: one for path, one in result.items() if path.startswith(f"{name}/")}
        chosen |= group or {name: result[name]}
    return chosen


Files = list[tuple[Path | str, bytes]]


def _csv(chosen: Mapping[str, Quantity], folder: Path, stem: str) -> Files:
    files: Files = []
    stream = io.StringIO()
    numbers = csv.writer(stream, lineterminator="\n")
    numbers.writerow(["quantity", "value", "unit", "error"])
    for path, quantity in chosen.items():
        text = comma_separated(quantity)
        if quantity.axes or np.iscomplexobj(quantity.values):
            name = f"{stem}_{_plain(path.replace('/', '__'))}.csv"
            files.append((folder / name, text.encode()))
        else:
            error = repr(float(quantity.error_estimate))
            numbers.writerow([path, text.strip(), quantity.unit, error])
    if len(files) < len(chosen):
        files.insert(0, (folder / f"{stem}.csv", stream.getvalue().encode()))
    return files


def _mat(chosen: Mapping[str, Quantity], folder: Path, stem: str) -> Files:
    from scipy.io import savemat

    tree: dict[str, Any] = {}
    for path, quantity in chosen.items():
        *groups, name = (_plain(part)[:63] for part in path.split("/"))
        place = tree
        for group in groups:
            place = place.setdefault(group, {})
        place[name] = {
            "value": quantity.values,
            "unit": quantity.unit,
            "error": float(quantity.error_estimate),
            "axes": [axis.name for axis in quantity.axes],
            **{_plain(axis.name): _labels(axis.values) for axis in quantity.axes},
        }
    stream = io.BytesIO()
    # texts of the header tell neither time nor machine, so that equal results are equal files
    savemat(stream, tree, long_field_names=True, oned_as="column")
    content = stream.getvalue()
    return [(folder / f"{stem}.mat", b"MATLAB 5.0 MAT-file, vibecalc".ljust(116) + content[116:])]


def _netcdf(chosen: Mapping[str, Quantity], folder: Path, stem: str) -> Files:
    from vibecalc.core.results.labelled import data_tree, library

    parts: dict[str, Quantity] = {}
    for path, quantity in chosen.items():
        parts |= _pair(path, quantity)
    library("h5netcdf")
    content = data_tree(parts).to_netcdf(engine="h5netcdf")
    return [(folder / f"{stem}.nc", bytes(content))]


def _pair(path: str, quantity: Quantity) -> dict[str, Quantity]:
    """A complex quantity as two real ones; any other as it is."""
    from dataclasses import replace

    if not np.iscomplexobj(quantity.values):
        return {path: quantity}
    halves = {"real": quantity.values.real, "imaginary": quantity.values.imag}
    return {
        f"{path}_{name}": replace(quantity, path=f"{path}_{name}", values=values)
        for name, values in halves.items()
    }


def _labels(values: np.ndarray) -> np.ndarray:
    return values if values.dtype.kind in "biufc" else np.array(values, dtype=object)


def _plain(name: str) -> str:
    """A name of letters, digits and _ that begins with a letter."""
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", name)
    return plain if plain[:1].isalpha() else f"x{plain}"
