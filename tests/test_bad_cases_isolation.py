"""Singular points: the words shown, the warnings, the intervals masked; never a NaN."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from isolation_machines import (
    LEVER,
    ORDERS,
    SPEED,
    gibson,
    gibson_body,
    gibson_couple,
    rows_of,
    shows,
)
from random_machines import Table
from refused import problems_of
from response_machines import run

from vibecalc.cli.starters import starter
from vibecalc.core.report.text import render_report
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.isolation.adapters.pitch import transmissibility
from vibecalc.isolation.at_mounts import mount_readout
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.rows import body_rows
from vibecalc.isolation.run_up import Range, RunUp, run_up
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import UndrivenModes, response
from vibecalc.numerics.rounding import SINGULAR
from vibecalc.parts.matrices import assemble, displacement_at
from vibecalc.response.modes import modes
from vibecalc.response.resonances import (
    Resonances,
    check_operating_point,
    idle_warnings,
    left_out,
    outside,
)
from vibecalc.response.system import MountedBody

ALL_ROWS = np.ones((1, 5), dtype=bool)


def undamped() -> tuple[Resonances, float]:
    """Resonances of the source's machine without its dampers, and the pitch frequency."""
    pitch, _ = gibson(0.0)
    return met(pitch, gibson_couple()), float(pitch.shapes.natural_frequency[0])


def met(pitch: OnMounts, couple: Bounded) -> Resonances:
    return pitch.resonances(couple[:, None])


def undamped_run_up(start: float = 0.0, stop: float = SPEED) -> RunUp:
    resonances, _ = undamped()
    rows = rows_of(*gibson(0.0), ORDERS, gibson_couple())
    return run_up(Range(rows, ORDERS, resonances, start, stop, ALL_ROWS))


def load_on(coordinate: int) -> Bounded:
    value = np.zeros((2, 6), dtype=complex)
    value[:, coordinate] = [1.0, 0.3j]
    return Bounded(value, 1e-16 * np.abs(value))


def test_second_order_on_an_undamped_frequency_is_refused_in_words() -> None:
    resonances, frequency = undamped()
    with pytest.raises(NumericalFailure) as failure:
        check_operating_point(resonances, ORDERS, frequency / 2.0, print)
    words = str(failure.value)
    parts = ("order 2", "mode 1", "undamped natural frequency", "5.05104 Hz", "relative distance")
    for part in (*parts, "damping or a loss factor", "move the speed"):
        assert part in words


def test_an_order_that_does_not_drive_the_mode_is_a_warning_and_left_out() -> None:
    pitch, readout = gibson(0.0)
    couple = gibson_couple()
    quiet = Bounded(couple.value * np.array([1.0, 1e-18]), couple.error)
    resonances = met(pitch, quiet)
    frequency = float(pitch.shapes.natural_frequency[0])
    warnings: list[str] = []
    check_operating_point(resonances, ORDERS, frequency / 2.0, warnings.append)
    assert len(warnings) == 1
    assert "order 2" in warnings[0]
    assert "does not drive it" in warnings[0]
    out = left_out(resonances)[:, 0]
    assert out.tolist() == [False, True]
    dynamic = pitch.dynamics(ORDERS * frequency / 2.0, resonances)
    angle = response(dynamic, quiet.value[:, None], quiet.error[:, None])
    assert abs(angle.value[1, 0]) <= angle.error[1, 0] < 1e-15 * abs(angle.value[0, 0])
    assert np.isfinite(angle.value[0, 0])
    texts = idle_warnings(resonances, ORDERS, 0.0, 20.0)
    assert len(texts) == 1
    assert "order 2" in texts[0]
    rows = rows_of(pitch, readout, ORDERS, quiet, left_out=True)
    passed = run_up(Range(rows, ORDERS, resonances, 0.0, 25.0, ALL_ROWS))
    assert not len(passed.masked.low)
    assert np.all(np.isfinite(passed.peak.value))
    first = np.abs(quiet.value[0]) * 625.0 / LEVER / abs(1.0 - (25.0 / frequency) ** 2)
    assert passed.peak.value[0] == pytest.approx(first, rel=1e-12)
    assert passed.peak.speed[0] == 25.0


def test_transmissibility_is_infinite_on_the_undamped_frequency_and_never_undefined() -> None:
    pitch, _ = gibson(0.0)
    value = transmissibility(
        pitch.matrices, np.array([1.0, 2.0]) * pitch.shapes.natural_frequency
    ).value
    assert np.isinf(value[0])
    assert np.isfinite(value[1])


def test_run_up_masks_undamped_resonances_and_calls_the_peak_infinite() -> None:
    passed = undamped_run_up()
    frequency = float(gibson(0.0)[0].shapes.natural_frequency[0])
    assert passed.masked.centre == pytest.approx([frequency / 2.0, frequency], rel=1e-14)
    assert passed.masked.order.tolist() == [2, 1]
    assert passed.masked.mode.tolist() == [1, 1]
    assert np.all(passed.masked.high - passed.masked.low < 1e-8 * frequency)
    assert np.all(np.isinf(passed.peak.value))
    assert passed.peak.speed == pytest.approx(np.full(5, frequency / 2.0))
    assert np.all(outside(passed.masked, passed.speed))
    assert np.all(np.isfinite(passed.curve.value))
    assert np.all(passed.curve.error <= 3.0 * SINGULAR * passed.curve.value)
    assert passed.unresolved == 0
    assert np.max(passed.curve.value) > 1e8


def test_range_that_misses_the_undamped_resonance_has_a_finite_peak() -> None:
    passed = undamped_run_up(40.0, 60.0)
    assert not len(passed.masked.low)
    assert np.all(np.isfinite(passed.peak.value))
    assert passed.peak.speed == pytest.approx(np.full(5, 40.0))


def test_range_that_starts_on_the_undamped_resonance_is_masked_there() -> None:
    frequency = float(gibson(0.0)[0].shapes.natural_frequency[0])
    passed = undamped_run_up(frequency, 60.0)
    assert passed.masked.order.tolist() == [1]
    assert passed.speed[0] >= passed.masked.high[0]
    assert np.all(np.isinf(passed.peak.value))


def test_mounts_at_a_node_of_the_unbounded_mode_keep_a_finite_peak() -> None:
    """A mount on the pitch axis, soft enough sideways, does not feel an undamped pitch mode."""
    position = np.array([[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, -0.3, 0.0]])
    stiffness = np.broadcast_to(1e4 * np.eye(3), (4, 3, 3))
    none = 0.0 * stiffness
    matrices = assemble(gibson_body().mass_matrix, position, stiffness, none, none)
    shapes, load = modes(matrices), load_on(4)
    readout = mount_readout(displacement_at(position), stiffness, none, none)
    seen = shows(readout, shapes.shape, shapes.natural_frequency)
    resonances = MountedBody(matrices=matrices, shapes=shapes).resonances(load)
    undriven = UndrivenModes(left_out(resonances), shapes.shape, shapes.eigenvalue)
    rows = body_rows(matrices, readout, ORDERS, load, undriven)
    passed = run_up(Range(rows, ORDERS, resonances, 0.0, 60.0, seen))
    assert len(passed.masked.low) == 2
    assert np.isinf(passed.peak.value).tolist() == [True, True, False, False]
    assert np.all(passed.peak.value[2:] <= passed.peak.error[2:])


def test_a_run_up_of_a_balanced_machine_is_zero_not_undefined() -> None:
    quiet = Bounded(np.zeros(2, dtype=complex), np.zeros(2))
    pitch, readout = gibson()
    rows = rows_of(pitch, readout, ORDERS, quiet)
    passed = run_up(Range(rows, ORDERS, met(pitch, quiet), 0.0, SPEED, ALL_ROWS))
    assert np.all(passed.curve.value == 0.0)
    assert np.all(passed.peak.value == 0.0)


CASES = Path(__file__).resolve().parents[1] / "cases"
HARD = "60 N/mm"


def on_mounts(scene: str, *stiffness: object) -> Table:
    table = tomllib.loads(starter(scene))
    table["machine"]["mounts"]["each"]["stiffness"] = list(stiffness)
    return table


@pytest.mark.parametrize(("free", "none"), [(1, 0.0), (3, 1e-14)])
def test_a_direction_without_stiffness_is_a_free_mode(free: int, none: float) -> None:
    # held along x alone it also turns about x as it likes
    stiffness = (HARD, none, HARD if free == 1 else none)
    record = run(on_mounts("compressor", *stiffness))
    natural = record["response/modes/natural_frequency"]
    loose = natural.values <= natural.error_estimate
    assert np.flatnonzero(loose).tolist() == list(range(free))
    assert np.all(natural.values[~loose] > 10.0)
    assert natural.error_estimate < 1e-6
    assert "response/modes/damping_ratio" not in record
    assert "response/modes/distance" not in record
    assert not any("natural_frequency" in words for words in record.warnings)


@pytest.mark.parametrize("soft", ["1 N/m", "60 N/mm"])
def test_a_soft_mode_is_held_and_keeps_its_digits(soft: str) -> None:
    table = on_mounts("compressor", HARD, soft, HARD)
    record = run(table)
    natural = record["response/modes/natural_frequency"]
    assert np.all(natural.values > 1e6 * natural.error_estimate)
    assert "response/modes/damping_ratio" in record


def test_a_change_of_a_body_that_is_free_is_refused_in_these_words() -> None:
    (problem,) = problems_of(on_mounts("switching", HARD, 0.0, HARD))
    assert problem.message.startswith("a change between operations needs a body that its mounts")
    assert problem.found == "nothing resists moving along y"


def test_a_run_up_through_an_undamped_resonance_has_no_largest_energy(tmp_path: Path) -> None:
    path = tmp_path / "undamped.toml"
    text = (CASES / "compressor_a.toml").read_text(encoding="utf-8").split("[[reference")[0]
    path.write_text(text, encoding="utf-8")
    asked = "response.run_up={from=20.0, to=40.0}"
    (loaded,) = load_checked([path], [asked])
    words = " ".join(render_report(execute(loaded), full=True).split())
    assert "kinetic, mean over a turn unbounded" in words
    assert "speeds left out: an order on an undamped natural frequency" in words
