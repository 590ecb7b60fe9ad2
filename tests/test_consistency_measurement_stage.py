"""Claim: a run gives what its kernels give, from levels, phases, scans and rms values."""

from pathlib import Path

import mpmath
import numpy as np
import pytest
from long_but import long_but
from plate_cases import PLATE, entry, load, replaced, run

from vibecalc.core.report.text import render_report
from vibecalc.core.results.store import read_result, write_result
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.targets import check_targets
from vibecalc.core.study.execute import execute
from vibecalc.measurement.model import build_harmonics, mismatch
from vibecalc.measurement.plate import PARTS, difference_row, point_row

MOTION = np.array([0.8 + 0.1j, 3.0 - 2.0j, -0.7 + 1.1j])
POINTS = [(0.5, -0.3), (0.5, 0.3), (-0.5, -0.3), (-0.5, 0.3), (0.1, 0.2), (-0.2, 0.0)]
HEAD = """schema = 1
title = "scan"
[machine]
kind = "plate"
[measurement]
orders = [2]
amplitude = "zero_to_peak"
amplitude_step = 1e-6
phase_step = 1e-6
plate = { x = [-1.0, 1.0], y = [-0.5, 0.5], points = 11 }
scan = "scan.csv"
"""


def scan(factor: float = 1.0, unit: str = "") -> str:
    """A CSV of amplitudes and phases of MOTION at POINTS."""
    lines = [f"order, x, y, amplitude{unit}, phase [deg]"]
    for x, y in POINTS:
        signal = complex(point_row(x, y) @ MOTION)
        size, phase = float(abs(signal) * factor), np.degrees(np.angle(signal))
        lines.append(f"2, {x}, {y}, {size!r}, {float(phase)!r}")
    return "\n".join(lines) + "\n"


def test_amplitude_and_phase_are_off_each_by_what_is_said_of_it(tmp_path: Path) -> None:
    """From half of a last digit, and by what is stated next to it, in squares."""
    text = PLATE[: PLATE.index("readings")].replace("orders = [1, 2]", "orders = [1]")
    text += """level_uncertainty = 0.2
phase_step = "1 deg"
phase_uncertainty = "2 deg"
amplitude_step = "0.01 m/s^2"
amplitude_uncertainty = "0.02 m/s^2"
readings = [
  { at = "a", level = [100.0], phase = [0.3] },
  { at = "b", amplitude = [0.5], phase = [0.0] },
  { at = "c", amplitude = [0.0], phase = [0.0] },
]
"""
    table = load(tmp_path, text).case.measurement
    assert table is not None
    [harmonic] = build_harmonics(table)
    step = table.level_step
    decibel, turn = 20.0 / np.log(10.0), np.hypot(np.radians(1.0) / np.sqrt(12.0), np.radians(2.0))
    plain = np.hypot(0.01 / np.sqrt(12.0), 0.02)
    along = [np.hypot(step / np.sqrt(12.0), 0.2) / decibel, plain, plain]
    np.testing.assert_allclose(harmonic.phasors.deviations, [along, [turn, 0.5 * turn, plain]])
    half = [(0.5 * step + 0.4) / decibel, 0.045, 0.045]
    turn = np.radians(0.5 + 4.0)
    np.testing.assert_allclose(harmonic.phasors.half_widths, [half, [turn, 0.5 * turn, 0.045]])


def named_levels(rows: dict[str, np.ndarray], use: dict[str, str] | None = None) -> str:
    """PLATE with readings of MOTION in dB re 1 m/s^2, for one harmonic."""
    text = PLATE[: PLATE.index("readings")].replace("orders = [1, 2]", "orders = [1]")
    text = text.replace("1e-5 m/s^2", "1 m/s^2") + "readings = [\n"
    for where, row in rows.items():
        level = 20.0 * np.log10(abs(row @ MOTION))
        how = f', use = "{use[where]}"' if use and where in use else ""
        text += f"  {{ {where}{how}, level = [{float(level)!r}] }},\n"
    return text + "]\n"


PLACES = dict(zip("abcd", POINTS, strict=False))
FIVE = {f'at = "{name}"': point_row(*PLACES[name]) for name in "abc"} | {
    f'between = ["a", "{name}"]': difference_row(PLACES["a"], PLACES[name]) for name in "bc"
}
SIXTH = {'at = "d"': point_row(*PLACES["d"])}


@pytest.mark.parametrize("seed", range(3))
def test_a_pair_that_is_not_alike_misses_its_difference_by_the_mean_of_both(seed: int) -> None:
    """The closed form of three amplitudes, against phasors that are a little off."""
    parts = np.random.default_rng(seed).normal(size=(2, 2))
    first, second = parts[:, 0] + 1j * parts[:, 1]
    little, difference = 1e-7, second - first
    for shares in ((little, 0.0), (0.0, little)):
        off = 0.5 * complex(*shares)
        moved = second * (1.0 + off) - first * (1.0 - off) - difference
        missed = moved * np.conj(difference) / abs(difference)
        stated = mismatch(abs(difference), abs(first), abs(second), *shares)
        np.testing.assert_allclose(stated, np.abs([missed.real, missed.imag]), rtol=1e-6)


def test_a_mismatch_of_the_pair_enters_what_is_stated(tmp_path: Path) -> None:
    """Runs with each difference as a pair reads it that is off by one deviation, in squares."""
    share, turn = 2e-4, np.radians(0.01)
    text = replaced(
        "orders =",
        f"level_step = 1e-5\nsensitivity_mismatch = {share}\nphase_mismatch = {turn}\norders =",
        named_levels(FIVE | SIXTH, {'at = "d"': "choose"}),
    )
    paths = [f"measurement/{name}_level" for name in ("translation", "roll", "pitch")]
    whole = run(tmp_path, text)
    stated = [whole[path.replace("/", "/uncertainty/", 1)].values[0] for path in paths]
    squares = np.zeros(3)
    for name in "bc":
        where = f'between = ["a", "{name}"]'
        first, second = (point_row(*PLACES[at]) @ MOTION for at in ("a", name))
        for off in (0.5 * share, 0.5j * turn):
            read = abs(second * (1.0 + off) - first * (1.0 - off))
            old = float(20.0 * np.log10(abs(second - first)))
            new = float(20.0 * np.log10(read))
            moved = run(tmp_path, replaced(f"{where}, level = [{old!r}]",
                                           f"{where}, level = [{new!r}]", text))  # fmt: skip
            squares += [(moved[path].values[0] - whole[path].values[0]) ** 2 for path in paths]
    np.testing.assert_allclose(stated, np.sqrt(squares), rtol=0.02)
    d = {"position": "d", "order": 1}
    bound, level = (entry(whole, f"measurement/uncertainty/{name}", **d)
                    for name in ("level_bound", "level"))  # fmt: skip
    assert bound > 1.9 * level


def relative(motion: np.ndarray) -> np.ndarray:
    """The motion with phase zero at the first point and a roll that leads it."""
    turned = motion * np.exp(-1j * np.angle(point_row(*POINTS[0]) @ motion))
    return np.conj(turned) if turned[1].imag < 0.0 else turned


def test_a_scan_of_amplitudes_and_phases(tmp_path: Path) -> None:
    record = run(tmp_path, HEAD, scan=scan())
    found = [record[f"measurement/{name}"].values[0] for name in ("translation", "roll", "pitch")]
    np.testing.assert_allclose(found, MOTION, rtol=1e-12)
    for place, name in enumerate(("translation", "roll", "pitch")):
        error = record[f"measurement/{name}"].error_estimate
        assert abs(found[place] - MOTION[place]) <= error < 1e-10
    # phases refer to the first point
    against = np.angle(MOTION / (point_row(*POINTS[0]) @ MOTION))
    phases = [record[f"measurement/phase/{n}"].values[0] for n in ("translation", "roll", "pitch")]
    np.testing.assert_allclose(phases, against, atol=1e-11)
    assert np.max(record["measurement/signal/residual"].values) < 1e-5
    assert not record.warnings
    x = record["measurement/map/amplitude"].axes[2].values
    y = record["measurement/map/amplitude"].axes[1].values
    direct = np.abs(point_row(x[None, :], y[:, None]) @ MOTION)
    np.testing.assert_allclose(record["measurement/map/amplitude"].values[0], direct, atol=1e-12)
    np.testing.assert_allclose(record["measurement/map/all_orders"].values, direct, atol=1e-12)


def test_scatter_beyond_the_rounding_is_said(tmp_path: Path) -> None:
    bent = scan().splitlines()
    cells = bent[2].split(", ")
    bent[2] = ", ".join([*cells[:3], repr(1.01 * float(cells[3])), cells[4]])
    record = run(tmp_path, HEAD, scan="\n".join(bent))
    assert any("the readings scatter" in one and "plate bends" in one for one in record.warnings)
    assert np.max(record["measurement/signal/residual"].values) > 100.0


def test_levels_give_both_motions_and_the_sixth_chooses(tmp_path: Path) -> None:
    record = run(tmp_path, named_levels(FIVE | SIXTH, {'at = "d"': "choose"}))
    found = [record[f"measurement/{name}"].values[0] for name in ("translation", "roll", "pitch")]
    np.testing.assert_allclose(found, relative(MOTION), rtol=1e-10)
    assert record["measurement/fit/motions"].values.tolist() == [2]
    assert record["measurement/fit/decided"].values.tolist() == [1]
    assert record["measurement/candidate/chosen"].values.tolist() == [1, 0]
    assert not record.warnings
    for part, kept in PARTS.items():
        for name, place in PLACES.items():
            level = entry(record, f"measurement/level/{part}", position=name, order=1)
            wanted = 20.0 * np.log10(abs((point_row(*place) * np.array(kept)) @ MOTION))
            error = record[f"measurement/level/{part}"].error_estimate
            assert abs(level - wanted) <= error < 1e-9


@pytest.mark.parametrize("gap", long_but([1e-2, 1e-5, 1e-8], 1e-8))
def test_error_estimates_against_many_digits(tmp_path: Path, gap: float) -> None:
    """Three signals nearly in line, where rounding enters a phase by its square root."""
    levels = [0.0, float(20.0 * np.log10(1.4 * (1.0 - gap))), -1.0, 20.0 * np.log10(0.4), -3.0]
    text = PLATE[: PLATE.index("readings")].replace("orders = [1, 2]", "orders = [1]")
    rows = zip(FIVE, levels, strict=True)
    text += "readings = [\n"
    text += "".join(f"  {{ {where}, level = [{float(one)!r}] }},\n" for where, one in rows)
    record = run(tmp_path, text + "]\n")
    with mpmath.workdps(50):
        first, second, third, across, along = (
            mpmath.mpf(10) ** (mpmath.mpf(x) / 20) for x in levels
        )
        turn_x = mpmath.acos((second**2 - first**2 - across**2) / (2 * first * across))
        turn_y = mpmath.acos((third**2 - first**2 - along**2) / (2 * first * along))
        names = [str(name) for name in record["measurement/candidate/chosen"].axes[0].values]
        taken = names[int(np.argmax(record["measurement/candidate/chosen"].values))]
        sign = 1 if taken == "1 +/+" else -1
        fourth = first + across * mpmath.expj(turn_x) + along * mpmath.expj(sign * turn_y)
        wanted = {
            "measurement/phase/roll": float(turn_x),
            "measurement/phase/pitch": float(sign * turn_y),
            "measurement/level/standard": float(20 * mpmath.log10(abs(fourth))),
        }
    for path, value in wanted.items():
        where: dict[str, object] = {"position": "d"} if path.endswith("standard") else {}
        found, error = entry(record, path, order=1, **where), record[path].error_estimate
        assert abs(found - value) <= error, path
        assert error < 1e-11 / gap**0.5, path


def test_five_levels_alone_leave_two_motions_and_say_what_would_help(tmp_path: Path) -> None:
    record = run(tmp_path, named_levels(FIVE))
    assert record["measurement/fit/decided"].values.tolist() == [0]
    (warning,) = record.warnings
    assert "the levels leave 2 motions" in warning and "no reading can distinguish them" in warning
    names = record["measurement/further/difference"].axes[0].values
    assert str(names[0]).removeprefix("1: ") in warning
    level = record["measurement/candidate/level"]
    apart = np.abs(np.subtract(*np.asarray(level.values)))
    best = abs(record["measurement/further/difference"].values[0])
    # where nothing was read yet, no named position tells more
    fresh = [place for place, name in enumerate(level.axes[1].values) if name == "d"]
    assert best >= np.max(apart[fresh]) - 1e-9


@pytest.mark.long
def test_levels_that_no_motion_has_within_reason_are_said(tmp_path: Path) -> None:
    rows = FIVE | SIXTH
    text = named_levels(rows)
    level = repr(float(20.0 * np.log10(abs(SIXTH['at = "d"'] @ MOTION))))
    record = run(tmp_path, replaced(level, repr(float(level) + 3.0), text))
    assert any("no motion lies within the rounding" in one for one in record.warnings)
    assert 1.0 < record["measurement/fit/misfit"].values[0] < 3.0 / 0.05
    sure = replaced("orders =", "level_uncertainty = 0.5\norders =", text)
    record = run(tmp_path, replaced(level, repr(float(level) + 3.0), sure))
    assert not any("no motion lies" in one for one in record.warnings)


def test_a_missing_harmonic_of_one_instrument(tmp_path: Path) -> None:
    """An instrument may cover some harmonics only."""
    text = replaced("]\n", '  { at = "d", orders = [2], use = "choose", level = [93.0] },\n]\n',
                    PLATE[PLATE.index("readings"):])  # fmt: skip
    record = run(tmp_path, PLATE[: PLATE.index("readings")] + text)
    names = list(record["measurement/reading/read"].axes[0].values)
    assert "2: d" in names and "1: d" not in names
    assert record["measurement/fit/decided"].values.tolist() == [0, 1]


def test_what_would_help_is_planned_and_empty_where_one_motion_is_left(tmp_path: Path) -> None:
    """A sixth level leaves one motion; its next reading is a list without entries."""
    loaded = load(tmp_path, named_levels(FIVE | SIXTH))
    result = execute(loaded)
    assert set(planned_quantities(loaded.case)) == set(result.record)
    path = tmp_path / "plate.h5"
    write_result(result, path)
    assert render_report(read_result(path)) == render_report(result)


@pytest.mark.parametrize(("name", "fine"), [('"d"', True), ('"e"', False), ("3", False)])
def test_positions_of_references_are_checked_before_the_run(
    tmp_path: Path, name: str, fine: bool
) -> None:
    reference = (
        f'[[reference]]\nquantity = "measurement/level/standard"\nvalue = "100 dB"\n'
        f'where = {{ position = {name}, order = 1 }}\nsource = "a test"\n'
    )
    found = check_targets(load(tmp_path, PLATE + reference).case)
    assert [one.message for one in found] == (
        [] if fine else [f"there is no position named {name.replace(chr(34), chr(39))}"]
    )


def test_a_node_has_no_level(tmp_path: Path) -> None:
    """A position on the roll axis: roll alone gives nothing there, and the report says zero."""
    text = replaced('{ name = "d", x = -0.5, y = 0.3 }', '{ name = "d", x = -0.5, y = 0.0 }')
    record = run(tmp_path, text)
    assert entry(record, "measurement/level/only_roll", position="d", order=1) == -np.inf
    assert np.isfinite(record["measurement/level/only_roll"].error_estimate)
