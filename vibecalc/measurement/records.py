"""Files of records and spectra next to a case: read, tracked by order, put into the case.

What a file holds becomes orders when the case is read, so that hash, resolved case and result hold
numbers and no later step needs the file.
"""

import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.csv_files import (
    Columns,
    TooLong,
    Unreadable,
    check_unit,
    content_beside,
    numbers_of,
    read_columns,
)
from vibecalc.core.case.raw import Data, listed, nearest, read_number, table_at, tables_at
from vibecalc.errors import Problem, UnitError
from vibecalc.measurement.record_checks import base_frequency_of
from vibecalc.measurement.record_tables import RecordFile
from vibecalc.measurement.signals import (
    Recording,
    Shaft,
    pulses_of,
    rate_of,
    shaft_of_pulses,
    shaft_of_speed,
    uneven_pulse,
)
from vibecalc.measurement.uff_files import uff_samples
from vibecalc.numerics.rounding import FloatArray
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The files of a case.
# ----------------------------------------------------------------------------

#: of the samples per second, up to which orders are taken for true
_HIGHEST = 0.4
#: lines of order that are kept of a record, and blocks
_MOST_LINES, _MOST_BLOCKS = 400, 4000
_LARGEST = 400_000_000
#: of an order, what a line of a spectrum may be away from it, over the step of its lines
_OFF_LINE = 0.5


def attach_records(data: Data, folder: Path) -> list[Problem]:
    """Read the files of [[measurement.record]] and [[measurement.spectrum]] of a case as written.

    Returns what is wrong with them; what the schema refuses is left to it.
    """
    table, problems = table_at(data, "measurement"), list[Problem]()
    given = table.get("orders")
    orders = [one for one in given if type(one) is int] if isinstance(given, list) else []
    if not orders or min(orders) < 1:
        return []  # which the schema says
    for name, attach in (("record", _record), ("spectrum", _spectrum)):
        for place, row in tables_at(table, name):
            if "found" in row or not isinstance(row.get("file"), str):
                continue
            try:
                attach(row, folder, orders, data)
            except Unreadable as error:
                key = error.key or "file"
                problems.append(
                    Problem(
                        path=("measurement", name, place, key),
                        message=f"{key}: {error}",
                        found=repr(str(row.get(key, ""))[:80]),
                        allowed=error.allowed,
                        hint=error.hint,
                    )
                )
    return problems


#: key -> unit, and an example of it
_SCALES = {"scale": ("m/s^2", "1 m/s^2"), "speed_scale": ("rad/s", "1 rpm")}


class _Samples(NamedTuple):
    """Samples of a file: columns by name, over time; `names` has all that the file has."""

    times: FloatArray
    columns: dict[str, FloatArray]
    units: dict[str, str]
    names: list[str]

    @property
    def rate(self) -> float:
        """Samples per second."""
        return float((self.times.size - 1) / (self.times[-1] - self.times[0]))

    def column(self, name: str, key: str) -> FloatArray:
        """The samples of a column that `key` of the record names."""
        if name not in self.columns:
            near = nearest(name, self.names)
            raise Unreadable(f"the file has no {name[:40]!r}", listed(self.names), near, key=key)
        return self.columns[name]

    def scaled(self, name: str, key: str, scale: str, row: Data) -> FloatArray:
        """The same in m/s^2 or rad/s: by its unit, or by the key `scale` of `row`."""
        samples, (wanted, example) = self.column(name, key), _SCALES[scale]
        unit, given = self.units.get(name, ""), read_number(row.get(scale), wanted)
        if unit and scale in row:
            raise Unreadable(f"column {name} has a unit and a {scale}", "one of the two", key=key)
        if not unit and given is None:
            raise Unreadable(
                f"what is 1 of {name!r}?",
                f'{scale} = "{example}", or a unit in the line of names of a CSV file',
                key=key,
            )
        try:
            return samples * (convert(1.0, unit, wanted) if unit else float(given or 0.0))
        except UnitError:
            allowed = f"a unit that converts to {wanted}"
            raise Unreadable(f"{name!r} is in {unit}", allowed, key=key) from None


def _record(row: Data, folder: Path, orders: list[int], data: Data) -> None:
    name = str(row["file"])
    ending = Path(name).suffix.lower()
    if ending in (".uff", ".unv"):
        _content(folder, name)
        times, columns, units = uff_samples(folder / name)
        samples = _Samples(times, columns, units, list(columns))
    else:
        samples = _wav(folder, name) if ending == ".wav" else _csv(row, folder, name)
    if samples.times.size < 16:
        raise Unreadable(f"the record has {samples.times.size} samples", "a record of many turns")
    shaft = _shaft(row, samples)
    turns, degree, window = (row.get(key) for key in ("turns", "interpolation", "window"))
    turns, degree, window = turns or 4, degree or 5, window or "none"
    known = degree in (1, 3, 5) and window in ("none", "hann")
    if not isinstance(turns, int) or turns < 1 or not known:
        return  # which the schema says
    blocks = shaft.turns // turns
    if not 2 <= blocks <= _MOST_BLOCKS:
        raise Unreadable(
            f"the record has {shaft.turns} whole turns, {blocks} block"
            f"{'' if blocks == 1 else 's'} of {turns}",
            f"2 to {_MOST_BLOCKS} blocks, whose scatter tells the uncertainty",
            key="turns" if "turns" in row else "",
        )
    fastest = float(np.max(np.diff(shaft.angles) / np.diff(shaft.times))) / (2.0 * np.pi)
    highest = _HIGHEST * samples.rate / fastest
    if max(orders) > highest:
        raise Unreadable(
            f"{samples.rate:.6g} samples per second show orders up to {highest:.3g} at "
            f"{60.0 * fastest:.4g} rpm",
            f"orders up to {highest:.3g}, or more samples: {max(orders)} was asked for",
        )
    lines = int(min(highest * turns, max(_MOST_LINES, max(orders) * turns)))
    signals = np.stack([_channel(one, samples) for one in _channels(row)])
    recording = Recording(samples.times, signals, turns, lines, window, degree)
    # torsion of the shaft that the pattern of a disc may be if nobody says
    pattern = 0.0 if row.get("disc") else float(np.sqrt(np.mean(shaft.late**2)))
    torsion = float(np.hypot(read_number(row.get("torsion"), "rad") or 0.0, pattern))
    tracked = recording.tracked(shaft, np.array(orders, float), not row.get("pulses"), torsion)
    if tracked.unsteady and not tracked.runs:
        raise Unreadable(
            f"{tracked.unsteady}: its angle is not that of the signals",
            "signals and pulses, or a speed, of one shaft that turns steadily or runs up",
            "pulses_per_turn, the column of the pulses, the speed",
        )
    found, settled = tracked.blocks, tracked.shaft
    at = np.array(orders) * turns
    lists = {
        "speeds": found.speeds,
        "real": found.amplitudes[..., at].real,
        "imaginary": found.amplitudes[..., at].imag,
        "error": np.max(found.error[..., at], axis=1),
        "by_angle": tracked.by_angle,
        "disc_pattern": settled.late,
        "lines": np.sqrt(np.mean(np.abs(found.amplitudes) ** 2, axis=1)),
    }
    row["found"] = {
        "made_with": {key: value for key, value in row.items() if key in RecordFile.model_fields},
        "orders": list(orders),
        "zero": settled.zero,
        "pulse_scatter": settled.scatter,
        "speed_correction": rate_of(settled) / rate_of(shaft) - 1.0,
        "unsteady": tracked.unsteady,
        **{key: values.ravel().tolist() for key, values in lists.items()},
    }


def _channels(row: Data) -> list[Data]:
    channels = [one for _, one in tables_at(row, "channels") if isinstance(one.get("column"), str)]
    if not channels:
        raise Unreadable("a record without channels", "channels = [{ column, at }]", key="channels")
    return channels


def _channel(one: Data, samples: _Samples) -> FloatArray:
    """A signal in m/s^2."""
    name = str(one["column"])
    signal = samples.scaled(name, "channels", "scale", one)
    if not np.any(samples.columns[name] != samples.columns[name][0]):
        raise Unreadable(f"{name!r} is the same in every sample", "a signal", key="channels")
    return signal


# ----------------------------------------------------------------------------
# The shaft of a record.
# ----------------------------------------------------------------------------


def _shaft(row: Data, samples: _Samples) -> Shaft:
    times = samples.times
    if row.get("pulses"):
        return _of_pulses(row, samples)
    if row.get("speed"):
        speed = samples.scaled(str(row["speed"]), "speed", "speed_scale", row)
        if np.min(speed) <= 0.0:
            raise Unreadable("the speed is zero or negative in places", "> 0", key="speed")
        return shaft_of_speed(times, speed)
    constant = read_number(row.get("constant_speed"), "rad/s")
    if constant is None or constant <= 0.0:
        raise Unreadable(
            "phases and orders need the angle of the shaft",
            'pulses = "column", speed = "column" or constant_speed = "1500 rpm"',
        )
    return Shaft(constant * (times - times[0]), times)


def _of_pulses(row: Data, samples: _Samples) -> Shaft:
    signal = samples.column(str(row["pulses"]), "pulses")
    low, high = float(np.min(signal)), float(np.max(signal))
    threshold = row.get("threshold", 0.5 * (low + high))
    hysteresis = row.get("hysteresis", 0.2 * (high - low))
    per_turn = row.get("pulses_per_turn", 1)
    numbers = all(isinstance(one, int | float) for one in (threshold, hysteresis, per_turn))
    if not numbers or per_turn < 1:
        raise Unreadable("pulses cannot be counted with these keys", key="pulses")
    if not low < threshold < high or threshold - hysteresis < low:
        raise Unreadable(
            f"no pulse rises through {threshold:.4g} after it was at {threshold - hysteresis:.4g}",
            f"between {low:.4g} and {high:.4g}, as the signal has them",
            key="threshold" if "threshold" in row else "pulses",
        )
    pulses = pulses_of(samples.times, signal, float(threshold), float(hysteresis))
    times = pulses.times
    if times.size < 2 * per_turn + 4:
        raise Unreadable(
            f"{times.size} pulses, {per_turn} per turn", "pulses of many turns", key="pulses"
        )
    odd = uneven_pulse(times, per_turn)
    if odd is not None:
        raise Unreadable(
            f"the interval between pulses jumps at {times[odd]:.6g} s, from "
            f"{times[odd] - times[odd - 1]:.4g} s to {times[odd + 1] - times[odd]:.4g} s",
            "each pulse once",
            "a pulse was missed, or noise made one: set threshold and hysteresis",
            key="pulses",
        )
    return shaft_of_pulses(pulses, int(per_turn), even=row.get("disc") == "even")


# ----------------------------------------------------------------------------
# Samples from files: CSV with a column of time or a rate, WAV.
# ----------------------------------------------------------------------------

#: of a step of time, what two steps may differ by
_EVEN = 0.02
#: keys that name a column, and its unit; pulses are in any
_OF_SHAFT = {"pulses": "", "speed": "rad/s"}


def _csv(row: Data, folder: Path, name: str) -> _Samples:
    try:
        columns = read_columns(folder, name)
    except TooLong as error:
        hint = "a longer record as WAV (file.wav) or universal file (file.uff)"
        raise Unreadable(str(error), error.allowed, hint) from None
    time, rate = str(row.get("time", "time")), read_number(row.get("sample_rate"), "rad/s")
    if isinstance(row.get("sample_rate"), int | float):
        raise Unreadable(
            "a sample rate without a unit would be in rad/s", '"5 kHz"', key="sample_rate"
        )
    wanted = [(str(one["column"]), "m/s^2") for one in _channels(row)]
    wanted += [(str(row[key]), unit) for key, unit in _OF_SHAFT.items() if row.get(key)]
    wanted = [(one, unit) for one, unit in wanted if one in columns]
    numbers = {one: _numbers(one, columns) for one in dict(wanted)}
    units = {one: columns[one].unit for one in numbers}
    for one, unit in wanted:
        if unit:
            check_unit(one, columns[one], unit)
    size = len(next(iter(columns.values())).cells)
    if time in columns:
        if rate is not None:
            raise Unreadable(
                f"the file has a column {time!r}, and sample_rate is given",
                "one of the two",
                key="sample_rate",
            )
        times = _in_unit(time, columns, "s")
        steps = np.diff(times)
        if size < 2 or np.min(steps) <= 0.0:
            raise Unreadable("the time is not ascending", key="time")
        if np.max(steps) > (1.0 + _EVEN) * np.min(steps) + 1e-9 * abs(times[-1]):
            raise Unreadable(
                f"samples are {np.min(steps):.6g} s to {np.max(steps):.6g} s apart",
                "samples at one rate",
                key="time",
            )
        return _Samples(times, numbers, units, list(columns))
    if rate is None:
        raise Unreadable(
            f"the file has no column {time!r}, and no sample_rate is given",
            'time = "name of the column", or sample_rate = "5 kHz"',
            nearest(time, list(columns)),
        )
    return _Samples(
        np.arange(size, dtype=np.float64) * (2.0 * np.pi / rate), numbers, units, list(columns)
    )


def _numbers(name: str, columns: Columns) -> FloatArray:
    try:
        return np.array([float(cell) for cell in numbers_of(name, columns[name])])
    except ValueError:
        raise Unreadable(
            f"column {name} has units in its cells", "numbers, and the unit in the line of names"
        ) from None


def _content(folder: Path, name: str) -> bytes:
    return content_beside(folder, name, _LARGEST, "a name like run.wav", f"*{Path(name).suffix}")


def _wav(folder: Path, name: str) -> _Samples:
    """Channels `1`, `2`, ... of a WAV file, over full scale."""
    from scipy.io import wavfile

    try:
        rate, samples = wavfile.read(io.BytesIO(_content(folder, name)))
    except (ValueError, OSError, EOFError) as error:
        raise Unreadable(f"the WAV file cannot be read: {error}") from None
    full = 1.0
    if samples.dtype.kind == "u":
        samples, full = samples.astype(float) - 128.0, 128.0
    elif samples.dtype.kind == "i":
        full = float(2 ** (8 * samples.dtype.itemsize - 1))
    signals = np.asarray(samples, dtype=float).reshape(len(samples), -1).T / full
    if not np.all(np.isfinite(signals)):
        raise Unreadable("a sample of the file is not finite")
    columns = {str(place + 1): signal for place, signal in enumerate(signals)}
    return _Samples(np.arange(len(samples), dtype=np.float64) / rate, columns, {}, list(columns))


# ----------------------------------------------------------------------------
# Complex spectra: the lines of the harmonics.
# ----------------------------------------------------------------------------


def _spectrum(row: Data, folder: Path, orders: list[int], data: Data) -> None:
    columns = read_columns(folder, str(row["file"]))
    base = _base_frequency(columns, data)
    if base is None:
        lines = _numbers("order", columns)
    else:
        lines = _in_unit("frequency", columns, "rad/s", "Hz") / base
    values = _values(columns)
    step = float(np.min(np.diff(np.unique(lines)))) if np.unique(lines).size > 1 else 1.0
    picked = []
    for order in orders:
        place = int(np.argmin(np.abs(lines - order)))
        if abs(lines[place] - order) > _OFF_LINE * min(step, 1.0) + 1e-9:
            raise Unreadable(
                f"no line of the file is of harmonic {order}: the nearest is {lines[place]:.6g}",
                "lines of all orders of [measurement]",
            )
        picked.append(place)
    row["found"] = {
        "file": row["file"],
        "orders": list(orders),
        "amplitude": np.abs(values[picked]).tolist(),
        "phase": np.angle(values[picked]).tolist(),
    }
    if base is not None:
        row["found"]["base_frequency"] = base


def _base_frequency(columns: Columns, data: Data) -> float | None:
    """The frequency of order 1 in rad/s, where that of each line is in the file; else None."""
    if "order" in columns:
        return None
    if "frequency" not in columns:
        raise Unreadable(
            "the file has neither a column order nor a column frequency", listed(list(columns))
        )
    base = base_frequency_of(data)
    if not base:
        raise Unreadable(
            "frequencies of a spectrum tell no order without that of order 1",
            "base_frequency of [measurement]",
        )
    return base


def _values(columns: Columns) -> Any:
    """Complex amplitudes of the lines, in m/s^2."""
    if {"amplitude", "phase"} <= columns.keys():
        size = _in_unit("amplitude", columns, "m/s^2")
        if np.min(size) < 0.0:
            raise Unreadable("an amplitude is not negative", "its sign is a phase of 180 deg")
        return size * np.exp(1j * _in_unit("phase", columns, "rad"))
    if {"real", "imaginary"} <= columns.keys():
        return _in_unit("real", columns, "m/s^2") + 1j * _in_unit("imaginary", columns, "m/s^2")
    raise Unreadable(
        "the file lacks amplitude and phase, or real and imaginary", listed(list(columns))
    )


def _in_unit(name: str, columns: Columns, unit: str, default: str = "") -> FloatArray:
    """A column in a unit; without one of its own it is in that or in the `default`."""
    check_unit(name, columns[name], default or unit)
    return _numbers(name, columns) * convert(1.0, columns[name].unit or default or unit, unit)
