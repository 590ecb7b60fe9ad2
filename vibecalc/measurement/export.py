"""Measured orders of a result as CSV files that [[reference_table]] reads."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vibecalc.core.results.files import write_together
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.core.results.visible import text_cell, visible
from vibecalc.errors import ResultError
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import FloatArray
from vibecalc.units import convert

_STEM = "measurement/"
_COMMENT = (
    "# %s: amplitudes are zero to peak, uncertainties are standard uncertainties, phases lead\n"
)

Columns = list[tuple[str, Sequence[float] | FloatArray]]


def export_orders(result: Result, folder: Path, stem: str) -> list[Path]:
    """Write the measured orders of a result into `folder`, and over the speed of the blocks.

    `STEM_orders.csv` has a line for each order, with amplitude, phase and their uncertainties of
    each channel of the records and of the motion of the plate at each named position;
    `STEM_speeds.csv` a line for each block with the amplitudes of each channel and order; records
    whose blocks have other speeds have `STEM_speeds_1.csv`, `STEM_speeds_2.csv`, ... Of a name in a
    file `column` and `uncertainty_column` of [[reference_table]] take one each.

    Raises
    ------
    ResultError
        The result has no measured orders.
    UsageError
        The files cannot be written.
    """
    record = result.record
    orders = [*_channels(record), *_positions(record)]
    if not orders:
        raise ResultError("the result has no measured orders to export: [measurement] finds them")
    axis = next(one for one in record["measurement/translation"].axes if one.name == "order")
    entries = [str(int(order)) for order in axis.values]
    files = [_file(folder / f"{stem}_orders.csv", "order", entries, orders)]
    if f"{_STEM}record/block_acceleration" in record:
        runs = _runs(record)
        for number, (rows, columns) in enumerate(runs, start=1):
            if len(dict.fromkeys(rows)) == len(rows):  # entries of an axis differ
                which = "" if len(runs) == 1 else f"_{number}"
                path = folder / f"{stem}_speeds{which}.csv"
                files.append(_file(path, "speed", rows, columns))
    write_together(files)
    return [path for path, _ in files]


def _channels(record: Record) -> Columns:
    if f"{_STEM}record/acceleration" not in record:
        return []
    size, off, phase, turn = (
        record[f"{_STEM}record/{name}"].values
        for name in ("acceleration", "uncertainty", "phase", "phase_uncertainty")
    )
    found: Columns = []
    for place, name in enumerate(record[f"{_STEM}record/acceleration"].axes[0].values):
        found += [
            (f"{name} [m/s^2]", np.abs(size[place])),
            (f"{name} uncertainty [m/s^2]", off[place]),
            (f"{name} phase [deg]", np.degrees(phase[place])),
            (f"{name} phase uncertainty [deg]", np.degrees(turn[place])),
        ]
    return found


def _positions(record: Record) -> Columns:
    """The motion of the plate at named positions."""
    size: Quantity | None = record.quantities.get(f"{_STEM}acceleration")
    level = record.quantities.get(f"{_STEM}uncertainty/level")
    if size is None or level is None:
        return []
    found: Columns = []
    for place, name in enumerate(size.axes[0].values):
        amplitude = np.abs(size.values[place])
        off = amplitude * np.asarray(level.values[place]) / DECIBEL
        found.append((f"plate at {name} [m/s^2]", amplitude))
        if np.all(np.isfinite(off)):
            found.append((f"plate at {name} uncertainty [m/s^2]", off))
        found.append((f"plate at {name} phase [deg]", np.degrees(np.angle(size.values[place]))))
    return found


def _runs(record: Record) -> list[tuple[list[str], Columns]]:
    """Speeds of the blocks, and columns of the channels that have these, record by record."""
    size = record[f"{_STEM}record/block_acceleration"]
    speeds = np.asarray(record[f"{_STEM}record/block_speed"].values)
    found: dict[tuple[float, ...], Columns] = {}
    for place, name in enumerate(map(str, size.axes[0].values)):
        found.setdefault(tuple(speeds[place].tolist()), []).extend(
            (f"{name} order {int(order)} [m/s^2]", np.abs(size.values[place, :, column]))
            for column, order in enumerate(size.axes[2].values)
        )
    return [
        ([f"{convert(one, 'rad/s', 'rpm'):.10g} rpm" for one in row], columns)
        for row, columns in found.items()
    ]


def _file(path: Path, axis: str, entries: list[str], columns: Columns) -> tuple[Path, bytes]:
    text = io.StringIO()
    text.write(_COMMENT % path.stem)
    write = csv.writer(text, lineterminator="\n").writerow
    write([axis, *(text_cell(name) for name, _ in columns)])
    for place, entry in enumerate(entries):
        write([entry, *(f"{float(values[place]):.8g}" for _, values in columns)])
    return path, visible(text.getvalue()).encode()
