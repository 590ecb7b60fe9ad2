"""Claim: orders of records are those of the signals behind them, as uncertain as blocks scatter."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from record_cases import AHEAD, CASE, GAIN, MOTION, RATE, START, text_of_record
from refused import refused
from scipy.io import wavfile

from vibecalc.core.report.text import render_report
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.results.record import Record
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import CaseError
from vibecalc.measurement.export import export_orders
from vibecalc.measurement.pictures import draw_record_orders
from vibecalc.measurement.signals import (
    Pulses,
    Recording,
    Shaft,
    pulses_of,
    shaft_of_pulses,
    shaft_of_speed,
    uneven_pulse,
)

TURN = 2.0 * np.pi
#: orders of a sweep: amplitude, phase
LINES = {1.0: (1.0, 0.4), 2.0: (0.5, -1.0), 2.5: (0.2, 2.0)}


def sweep(first: float, gain: float) -> tuple[np.ndarray, np.ndarray, Shaft]:
    """Times, signal (1, n) of `LINES`, shaft of 8 pulses per turn; turns/s and turns/s^2."""
    times = np.arange(0.0, 4.0, 1.0 / 4000.0)
    angle = TURN * (first * times + 0.5 * gain * times**2)
    signal = sum(size * np.cos(n * angle + lead) for n, (size, lead) in LINES.items())
    turns = np.arange(8.0 * angle[-1] / TURN) / 8.0
    at = (np.sqrt(first**2 + 2.0 * gain * turns) - first) / gain
    return times, np.asarray(signal)[None], shaft_of_pulses(Pulses(at, at, at, False), 8)


@pytest.mark.parametrize("window", ["none", "hann"])
def test_orders_of_a_sweep_are_those_it_is_made_of(window: str) -> None:
    times, signal, shaft = sweep(20.0, 3.0)
    found = Recording(times, signal, 4, 20, window).blocks(shaft)
    neighbours = 0.5 if window == "hann" else 0.0  # what its lines have of those beside them
    for line in range(21):
        wanted = 0.0j
        for order, (size, lead) in LINES.items():
            share = {0: 1.0, 1: -neighbours}.get(abs(line - round(4 * order)), 0.0)
            wanted += share * size * np.exp(1j * lead)
        off = np.abs(found.amplitudes[0, :, line] - wanted)
        assert np.all(off <= 1e-8)
        assert np.all(off <= found.error[0, :, line] + 1e-11)
    turns = 4.0 * np.arange(found.speeds.size + 1)
    ends = (np.sqrt(20.0**2 + 6.0 * turns) - 20.0) / 3.0
    assert found.speeds == pytest.approx(TURN * 4.0 / np.diff(ends), rel=1e-9)


def test_a_speed_over_time_and_a_constant_one_give_the_same_angle() -> None:
    times, signal, shaft = sweep(20.0, 3.0)
    by_speed = shaft_of_speed(times, TURN * (20.0 + 3.0 * times))
    one = Recording(times, signal, 4, 20).blocks(by_speed).amplitudes
    other = Recording(times, signal, 4, 20).blocks(shaft).amplitudes
    assert one[:, : other.shape[1]] == pytest.approx(other, abs=1e-8)
    times, signal, _ = sweep(20.0, 1e-9)
    steady = Shaft(TURN * 20.0 * times, times)
    found = Recording(times, signal, 4, 20).blocks(steady).amplitudes[0, :, 8]
    assert found == pytest.approx(0.5 * np.exp(-1.0j), abs=1e-7)


def test_pulses_rise_through_the_threshold_and_noise_makes_none() -> None:
    times = np.linspace(0.0, 3.0, 31)
    ramps = 4.0 * (times % 1.0)  # from 0 to 3.6, then down at once
    assert pulses_of(times, ramps, 2.0, 0.5).times == pytest.approx([0.5, 1.5, 2.5], abs=1e-12)
    noisy = np.array([0.0, 1.9, 2.1, 1.8, 2.2, 1.4, 2.4, 3.0, 0.0, 3.0])
    found = pulses_of(np.arange(10.0), noisy, 2.0, 0.5).times
    assert found == pytest.approx([1.5, 5.6, 8.0 + 2.0 / 3.0])
    assert uneven_pulse(np.array([0.0, 1.0, 1.9, 3.9, 4.8])) == 2
    assert uneven_pulse(np.array([0.0, 1.0, 1.9, 2.7])) is None
    times = np.linspace(0.0, 1.0, 4001)
    assert pulses_of(times, -np.cos(TURN * 20.0 * times), 0.0, 0.5).times == pytest.approx(
        (np.arange(20) + 0.25) / 20.0, abs=1e-9
    )


def test_the_edge_of_a_square_wave_lies_halfway_between_its_samples() -> None:
    """24.7 turns per second at 2 kHz: the threshold moves no phase, +- covers what is left."""
    times = np.arange(0.0, 6.0, 5e-4)
    turned = TURN * 24.7 * times
    square = 5.0 * (np.mod(turned, TURN) < 0.3)
    low, high = (shaft_of_pulses(pulses_of(times, square, at, 1.0), 1) for at in (1.5, 4.5))
    assert np.array_equal(low.times, high.times)
    # the record begins on an edge, which is not seen: the first pulse is a turn later
    lag = TURN * 24.7 * low.times - (low.angles + TURN)
    assert abs(np.mean(lag)) < low.zero < np.radians(0.15)


# ----------------------------------------------------------------------------
# From files to the motion of a plate.
# ----------------------------------------------------------------------------


def test_the_shipped_record_gives_the_motion_it_was_made_from() -> None:
    assert CASE.with_suffix(".csv").read_text(encoding="utf-8") == text_of_record()
    result = read_result(Path(__file__).with_name("golden") / "roll_records.h5")
    _made_from(result.record)
    text = render_report(result, full=True)
    assert "Orders of the records" in text
    assert draw_record_orders(result) is not None


def _made_from(record: Record, most: float = 3.5) -> None:
    for name, place in (("translation", 0), ("roll", 1), ("pitch", 2)):
        for column, motion in enumerate(MOTION.values()):
            phase = np.angle(motion[place]) - _reference_phase(column)
            level = 20.0 * np.log10(abs(motion[place]) / (1e-5 if place == 0 else 1.0))
            for path, unit, wanted in (("level", "_level", level), ("phase", "_phase", phase)):
                key = f"{name}_level" if path == "level" else f"phase/{name}"
                found = float(record[f"measurement/{key}"].values[column])
                off = found - wanted
                off = off if path == "level" else np.remainder(off + np.pi, TURN) - np.pi
                deviation = record[f"measurement/uncertainty/{name}{unit}"].values[column]
                assert abs(off) <= most * float(deviation), (name, column, path)


def _reference_phase(column: int) -> float:
    lift, roll, pitch = [*MOTION.values()][column]
    return float(np.angle(lift - 0.27 * roll - 0.55 * pitch))  # position 1


def folder_with(folder: Path, text: str) -> Path:
    """The shipped case with another text, next to its record."""
    (folder / "roll_records.csv").write_text(text_of_record(), encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def run(folder: Path, text: str) -> Record:
    return execute(load_checked([folder_with(folder, text)])[0]).record


TEXT = CASE.read_text(encoding="utf-8")
BEGIN = TEXT.index("[[measurement.record]]")


def columns() -> np.ndarray:
    """Tachometer and accelerations (5, n) of the shipped record."""
    rows = [line.split(", ") for line in text_of_record().splitlines()[2:]]
    return np.array(rows, dtype=float)[:, 1:].T


def orders_of(folder: Path, text: str = TEXT) -> np.ndarray:
    """Orders of the accelerations that a case reads from its record."""
    return run(folder, text)["measurement/record/acceleration"].values


def test_a_wav_is_read_as_the_csv_is(tmp_path: Path) -> None:
    record = TEXT[BEGIN:].replace(".csv", ".wav").replace('"tachometer"', '"1"')
    for place in range(4):
        record = record.replace(f'"a{place + 1}"', f'"{place + 2}", scale = "8 m/s^2"')
    wanted = orders_of(tmp_path)
    for kind, size, step in ((np.float32, 1.0, 1e-6), (np.int16, 32768.0, 3e-4)):
        samples = columns().T / [1.25, 8.0, 8.0, 8.0, 8.0] * size
        wavfile.write(tmp_path / "roll_records.wav", int(RATE), samples.astype(kind))
        found = orders_of(tmp_path, TEXT[:BEGIN] + record.replace("0.5\n", "0.4\n"))
        assert np.max(np.abs(found - wanted)) <= step


def test_spectra_give_the_motion_that_readings_give(tmp_path: Path) -> None:
    steps = 'amplitude_step = 0.001\nphase_step = "1 deg"\nbase_frequency = "15 Hz"\norders'
    text = TEXT[:BEGIN].replace("orders", steps, 1)
    spectra, readings = "", "\n[measurement]\n"
    rows = []
    positions = {"1": (0.55, -0.27), "2": (0.55, 0.27), "3": (-0.55, -0.27), "4": (-0.55, 0.27)}
    for name, (x, y) in positions.items():
        values = np.array([one[0] + y * one[1] - x * one[2] for one in MOTION.values()])
        kind = int(name) % 2
        head = (
            "frequency [Hz], real, imaginary" if kind else "order, amplitude [m/s^2], phase [deg]"
        )
        lines = [head]
        for order, one in enumerate(values, start=1):
            parts = (one.real, one.imag) if kind else (abs(one), np.degrees(np.angle(one)))
            lines.append(f"{15.0 * order if kind else order}, {parts[0]:.16g}, {parts[1]:.16g}")
            lines.append(f"{15.0 * (order + 0.5) if kind else order + 0.5}, 0, 0")
        (tmp_path / f"s{name}.csv").write_text(
            "\n".join(lines).replace("np.float64(", "").replace(")", "")
        )
        spectra += f'[[measurement.spectrum]]\nfile = "s{name}.csv"\nat = "{name}"\n'
        rows.append((name, np.abs(values).tolist(), np.angle(values).tolist()))
    found = run(tmp_path, f"{text}\n{spectra}")
    readings = ",\n".join(f'{{ at = "{n}", amplitude = {a}, phase = {p} }}' for n, a, p in rows)
    plate = text.index("plate = {")
    wanted = run(tmp_path, f"{text[:plate]}readings = [\n{readings}\n]\n{text[plate:]}")
    for path, quantity in wanted.items():
        if "residual" in path or "misfit" in path:
            continue  # which are rounding here
        assert found[path].values == pytest.approx(quantity.values, rel=1e-9, abs=1e-12), path
    for place, name in enumerate(("translation", "roll", "pitch")):
        sizes = [abs(one[place]) for one in MOTION.values()]
        assert np.abs(found[f"measurement/{name}"].values) == pytest.approx(sizes, rel=1e-9)


def test_a_result_needs_its_record_no_more(tmp_path: Path) -> None:
    (loaded,) = load_checked([folder_with(tmp_path, TEXT)])
    (tmp_path / "roll_records.csv").unlink()
    path = tmp_path / "resolved.toml"
    path.write_text(loaded.resolved_toml, encoding="utf-8")
    (again,) = load_checked([path])
    assert again.sha256 == loaded.sha256
    path.write_text(loaded.resolved_toml.replace("speeds = [", "speeds = [ 1.0, "))
    assert "no orders of so many channels" in refused(path)
    path.write_text(loaded.resolved_toml.replace("orders = [", "orders = [ 4, ", 1))
    assert "orders of other harmonics" in refused(path)


def test_exported_orders_are_read_as_references(tmp_path: Path) -> None:
    (loaded,) = load_checked([folder_with(tmp_path, TEXT)])
    orders, speeds = export_orders(execute(loaded), tmp_path, loaded.name)
    more = ""
    for path, axis, entries, column, quantity in (
        (orders, "order", 'channel = "1"', "1", "record/acceleration"),
        (orders, "order", 'position = "middle"', "plate at middle", "acceleration"),
    ):
        more += f'[[reference_table]]\nquantity = "measurement/{quantity}"\naxis = "{axis}"\n'
        more += f'where = {{ {entries} }}\nfile = "{path.name}"\ncolumn = "{column}"\n'
        more += f'uncertainty_column = "{column} uncertainty"\nsource = "x"\nkind = "measured"\n'
    (again,) = load_checked([folder_with(tmp_path, f"{TEXT}\n{more}")])
    result = execute(again)
    rows = judge_references(result)
    assert len(rows) == 6
    assert all(abs(row.difference) <= 1e-7 * row.value for row in rows)
    stated = result.record["measurement/record/uncertainty"].values[0]
    written = [float(str(one.uncertainty).split()[0]) for one in again.case.reference[:3]]
    assert written == pytest.approx(stated, rel=1e-7)
    lines = speeds.read_text(encoding="utf-8").splitlines()
    assert lines[1].startswith("speed,1 order 1 [m/s^2],1 order 2")
    first = START + 0.5 * GAIN * 4.0 / START  # turns/s in the middle of four turns
    assert float(lines[2].split(" rpm")[0]) == pytest.approx(60.0 * first, rel=0.01)
    assert 0.0 < AHEAD < TURN / 4  # the first pulse comes soon


def second_record(folder: Path, per_turn: int = 1) -> str:
    """A second record of one channel, of the same plate while its shaft runs faster."""
    times = np.arange(1200) / RATE
    angle = TURN * (20.0 * times + 0.3 * times**2) + 0.3
    lift, roll, pitch = (np.array([one[place] for one in MOTION.values()]) for place in range(3))
    wave = np.exp(1j * np.outer(np.arange(1, 4), angle - np.pi / 2))
    at_1 = np.real((lift - 0.27 * roll - 0.55 * pitch) @ wave)
    rows = np.stack([times, -np.cos(per_turn * angle), at_1], axis=1)
    head = "time [s], tachometer, a1 [m/s^2]"
    np.savetxt(folder / "second.csv", rows, "%.8g", ",", header=head, comments="")
    return (
        '\n[[measurement.record]]\nfile = "second.csv"\npulses = "tachometer"\n'
        'channels = [{ column = "a1", at = "1", use = "compare" }]\n'
    )


def test_each_of_several_records_is_exported_over_its_own_speed(tmp_path: Path) -> None:
    (loaded,) = load_checked([folder_with(tmp_path, TEXT + second_record(tmp_path))])
    result = execute(loaded)
    size = result.record["measurement/record/acceleration"].values
    assert size[4] == pytest.approx(size[0], abs=0.05)  # phases, too, as one pulse is one place
    _, first, second = export_orders(result, tmp_path, result.name)
    assert (first.name, second.name) == ("case_speeds_1.csv", "case_speeds_2.csv")
    for path, start, channels in ((first, 900.0, 4), (second, 1200.0, 1)):
        _, names, *lines = path.read_text(encoding="utf-8").splitlines()
        assert names.count("order 1") == channels
        speeds = [float(line.split(" rpm")[0]) for line in lines]
        assert speeds[0] == pytest.approx(start, rel=0.01)
        assert np.all(np.diff(speeds) > 0.0)
    blocks = result.record["measurement/record/block_acceleration"].values[4, :, 0]
    written = [float(line.split(",")[1]) for line in second.read_text().splitlines()[2:]]
    assert written == pytest.approx(np.abs(blocks), rel=1e-7)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("turns", "2"), ("window", '"hann"'), ("threshold", "0.1"), ("interpolation", "3"),
        ("file", '"roll.csv"'), ("pulses_per_turn", "2"), ("channels[0].column", '"a2"'),
        ("channels[0].scale", "2.0"),
    ],
)  # fmt: skip
def test_orders_that_stand_for_a_file_keep_their_keys(key: str, value: str, tmp_path: Path) -> None:
    (loaded,) = load_checked([folder_with(tmp_path, TEXT)])
    path = tmp_path / "resolved.toml"
    path.write_text(loaded.resolved_toml, encoding="utf-8")
    key = f"measurement.record[0].{key}"
    assert key.rpartition(".")[2] in loaded.resolved_toml or "scale" in key
    with pytest.raises(CaseError) as refusal:
        load_checked([path], [f"{key}={value}"])
    assert "it would change nothing" in str(refusal.value)
    compared = 'measurement.record[0].channels[0].use="compare"'
    assert load_checked([path], [compared])


def test_lines_of_a_spectrum_keep_their_frequency(tmp_path: Path) -> None:
    rows = [f"{15.0 * n}, {0.1 * n}, 0.2" for n in (1, 2, 3)]
    text = TEXT[:BEGIN].replace("orders", "amplitude_step = 0.001\nphase_step = 0.01\norders", 1)
    text = text.replace("orders", 'base_frequency = "15 Hz"\norders', 1)
    for name in "1234":
        (tmp_path / f"s{name}.csv").write_text("\n".join(["frequency, real, imaginary", *rows]))
        text += f'[[measurement.spectrum]]\nfile = "s{name}.csv"\nat = "{name}"\n'
    (loaded,) = load_checked([folder_with(tmp_path, text)])
    path = tmp_path / "resolved.toml"
    path.write_text(loaded.resolved_toml, encoding="utf-8")
    assert load_checked([path])[0].sha256 == loaded.sha256
    for setting, words in (
        ("measurement.base_frequency='16 Hz'", "another frequency of order 1"),
        ("measurement.orders=[1, 2]", "orders of other harmonics"),
        ("measurement.spectrum[0].file='other.csv'", "it would change nothing"),
        ("measurement.spectrum[0].found.phase=[0.1]", "phase"),
        ("measurement.spectrum[0].amplitude=[0.1]", "amplitude"),
    ):
        with pytest.raises(CaseError) as refusal:
            load_checked([path], [setting])
        assert words in str(refusal.value)
    axes = '[sweep]\naxes = [{ key = "measurement.base_frequency", values = ["14 Hz", "15 Hz"] }]\n'
    for one in (text, loaded.resolved_toml):
        assert "stands behind numbers" in refused(folder_with(tmp_path, f"{one}\n{axes}"))


def test_a_record_too_long_for_a_table_is_sent_to_other_files(tmp_path: Path) -> None:
    rows = ["tachometer, a1", *["0, 1"] * 20_001]
    (tmp_path / "long.csv").write_text("\n".join(rows), encoding="utf-8")
    text = TEXT.replace("roll_records.csv", "long.csv")
    assert "as WAV (file.wav) or universal file" in refused(folder_with(tmp_path, text))
    (tmp_path / "long.csv").write_text("x" * 2_000_001, encoding="utf-8")
    assert "as WAV (file.wav) or universal file" in refused(folder_with(tmp_path, text))


def set_58(
    values: np.ndarray, unit: str, rate: float = RATE, direction: int = 3, start: float = 0.0
) -> str:
    """A function of time as a data set 58 in text, by the layout of the universal file format."""
    nothing = f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}"
    lines = [
        "    -1", "    58", "record", *["NONE"] * 4,
        f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{1:10d}{direction:4d} {'NONE':<10}{0:10d}{0:4d}",
        f"{4:10d}{values.size:10d}{1:10d}{start:13.5e}{1.0 / rate:13.5e}{0.0:13.5e}",
        f"{17:10d}{0:5d}{0:5d}{0:5d} {'Time':<20} {'s':<20}",
        f"{12:10d}{0:5d}{0:5d}{0:5d} {'Acceleration':<20} {unit:<20}",
        nothing, nothing,
    ]  # fmt: skip
    rows = ["".join(f"{one:20.12e}" for one in row) for row in values.reshape(-1, 4)]
    return "\n".join([*lines, *rows, "    -1\n"])


def in_sets() -> str:
    """The shipped case with its record in data sets 58."""
    record = TEXT[BEGIN:].replace(".csv", ".uff").replace('"tachometer"', '"1"')
    for place in range(4):
        record = record.replace(f'"a{place + 1}"', f'"{place + 2}"')
    return TEXT[:BEGIN] + record


def test_a_universal_file_is_read_as_the_csv_is_with_its_directions_and_starts(
    tmp_path: Path,
) -> None:
    pytest.importorskip("pyuff")
    tachometer, *signals = columns()

    def write(direction: int, start: float = 0.0) -> Path:
        sets = [set_58(tachometer, "V", direction=1)]
        sets += [set_58(one, "m/s^2") for one in signals[1:]]
        first = signals[0] if direction > 0 else -signals[0]
        sets.insert(1, set_58(first, "m/s^2", direction=direction, start=start))
        (tmp_path / "roll_records.uff").write_text("".join(sets))
        return folder_with(tmp_path, in_sets())

    for direction in (3, -3):
        write(direction)
        assert orders_of(tmp_path, in_sets()) == pytest.approx(orders_of(tmp_path), abs=1e-11)
    assert "data set 2 is an acceleration in direction -1" in refused(write(-1))
    assert "data set 2 begins at 0.5 s" in refused(write(3, 0.5))
    (tmp_path / "roll_records.uff").write_text("no universal file\n")
    assert "no data set 58" in refused(folder_with(tmp_path, in_sets()))


@pytest.mark.parametrize("ending", ["csv", "wav", "uff"])
def test_a_column_of_speed_counts_in_its_unit(ending: str, tmp_path: Path) -> None:
    if ending == "uff":
        pytest.importorskip("pyuff")
    times, signal, _ = sweep(START, GAIN)
    rpm = 60.0 * (START + GAIN * times)
    if ending == "csv":
        table, head = np.stack([times, rpm, signal[0]], axis=1), "time [s], n [rpm], a [m/s^2]"
        np.savetxt(tmp_path / "run.csv", table, "%.8f", ",", header=head, comments="")
    elif ending == "wav":
        both = np.stack([rpm / 2000.0, signal[0] / 4.0], axis=1)
        wavfile.write(tmp_path / "run.wav", 4000, both.astype(np.float32))
    else:
        sets = set_58(rpm, "RPM", 4000.0) + set_58(signal[0], "m/s^2", 4000.0)
        (tmp_path / "run.uff").write_text(sets)
    speed, column = ("n", "a") if ending == "csv" else ("1", "2")
    scales = ('speed_scale = "2000 rpm"\n', ', scale = "4 m/s^2"') if ending == "wav" else ("", "")
    channel = f'{{ column = "{column}", at = "{{}}"{scales[1]} }}'
    channels = [channel.replace("{}", name) for name in "123"]
    text = TEXT[:BEGIN] + (
        f'[[measurement.record]]\nfile = "run.{ending}"\nspeed = "{speed}"\n{scales[0]}'
        f"channels = [{', '.join(channels)}]\n"
    )
    found = orders_of(tmp_path, text.replace("orders = [1, 2, 3]", "orders = [1, 2]"))[0]
    wanted = [size * np.exp(1j * lead) for size, lead in (LINES[1.0], LINES[2.0])]
    assert found == pytest.approx(wanted, abs=1e-4)


def test_without_its_reader_a_universal_file_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyuff", None)
    (tmp_path / "roll_records.uff").write_text(set_58(np.zeros(4), "m/s^2"))
    assert "pip install 'vibecalc[uff]'" in refused(folder_with(tmp_path, in_sets()))


@pytest.mark.parametrize("ending", ["csv", "wav", "uff"])
def test_what_is_no_record_is_refused_before_it_is_read(ending: str, tmp_path: Path) -> None:
    case = folder_with(tmp_path, TEXT.replace(".csv", f".{ending}"))
    record = tmp_path / f"roll_records.{ending}"
    record.write_text("time, a1\n", encoding="utf-16")
    assert "the file is encoded in UTF-16" in refused(case)
    record.unlink()
    os.mkfifo(record)  # to read it would wait for ever
    assert "the file is no ordinary file" in refused(case)
    record.unlink()
    record.mkdir()
    assert "the file is a folder" in refused(case)
