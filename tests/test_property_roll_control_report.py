"""Claim: the report of the control says how each loop stands before its levels, never praises one
that diverges, and its tables and pictures keep to the page and to the numbers.
"""

import re

import numpy as np
import pytest
from roll_control_cases import PATH, record_of, shipped, value_of

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record, Result
from vibecalc.roll.control import margins as count
from vibecalc.roll.report.control import STATUS, in_decibels, in_phase, in_time

TITLE = "Control of the motor"


def result_of(record: Record) -> Result:
    like = shipped()
    case = {**like.case, "reference": [], "limit": []}
    return Result(
        **{name: getattr(like, name) for name in Result.__dataclass_fields__}
        | {"record": record, "case": case}
    )


def section(result: Result) -> str:
    lines = render_report(result, full=True).splitlines()
    start = lines.index(TITLE)
    rest = lines[start + 2 :]
    length = next((i for i, line in enumerate(rest) if re.match(r"-{4,}$", line)), len(rest) + 2)
    return "\n".join(rest[: length - 2])


def test_every_status_has_words_of_its_own() -> None:
    assert len(STATUS) == len(count.STATUS)
    for loud, plain in zip(STATUS, count.STATUS, strict=True):
        assert loud.lower().split()[0] == plain.split()[0]


def test_the_page_is_kept_and_every_part_is_there() -> None:
    text = section(shipped())
    assert max(len(line) for line in text.splitlines()) <= 100
    for part in (
        "stability        stable", "full model: stable", "held by          delay margin",
        "without control the reduced model is within 0.5 dB of the full one in orders 1, 2, 4",
        "* more than the 1009 N m that the motor has", "other motors without control",
    ):  # fmt: skip
        assert part in " ".join(text.split()) or part in text
    assert (
        PATH
        not in render_report(shipped(), full=True).split(TITLE)[1].split("\nReference numbers\n")[0]
    )


def test_rows_of_unstable_pairs_have_no_levels() -> None:
    text = section(shipped())
    status = value_of(shipped().record, "grid/status")
    rows = [
        line for line in text.splitlines() if re.match(r"\s+[\d.]+\s+-?[\d.]+ (UNST|stable)", line)
    ]
    assert len(rows) == status.size
    lost = [line for line in rows if "UNSTABLE" in line]
    assert len(lost) == np.sum(status >= 2) > 0
    for line in lost:
        assert re.search(r"UNSTABLE\s+-\s+-\s+-\s+-\s+0.00 dB\s+0.0 deg\s+none$", line)


def test_an_unstable_loop_is_not_praised() -> None:
    text = section(result_of(record_of(gain=10.0, acceleration_feedback=10.0)))
    assert "UNSTABLE: its amplitudes have no bound" in " ".join(text.split())
    assert "unbounded" in text and "grows" in text


def test_levels_on_paper_only_are_called_so() -> None:
    record = record_of(gain=10.0, acceleration_feedback=-10.0, actuator_lag=0.0)
    text = " ".join(section(result_of(record)).split())
    assert "STABLE ONLY WITHOUT ANY DELAY: its levels are valid for zero delay only" in text
    assert "delay none" in text and "MORE THAN THE 1009 N m THAT IT HAS" in text


def test_words_of_margins() -> None:
    assert in_time(0.0) == "none" and in_time(np.inf) == "any"
    assert in_time(2.355e-6) == "2.355 us" and in_time(5e-4) == "0.5000 ms"
    assert in_decibels(np.inf) == "any" and in_phase(np.pi / 4.0) == "45.0 deg"


def test_pictures_show_the_numbers() -> None:
    pytest.importorskip("matplotlib")
    import matplotlib

    from vibecalc.core.report.plots import STYLE, make

    with matplotlib.rc_context(STYLE):
        grid, motors, locus = (
            make(shipped(), name) for name in ("roll_control", "roll_motor_gain", "roll_locus")
        )
        bare = result_of(record_of())
        assert make(bare, "roll_control") is None and make(bare, "roll_motor_gain") is None
        alone = make(bare, "roll_locus")
    assert grid is not None and motors is not None and locus is not None and alone is not None
    record = shipped().record
    level, status = value_of(record, "grid/level"), value_of(record, "grid/status")
    first = grid.axes[0]
    drawn = [
        value
        for line in first.get_lines()
        if line.get_marker() not in ("None", "x", "")
        for value in np.asarray(line.get_ydata(), dtype=float)
    ]
    np.testing.assert_allclose(np.sort(drawn), np.sort(level[status < 2][:, 0]), rtol=1e-12)
    crosses = sum(len(line.get_xdata()) for line in first.get_lines() if line.get_marker() == "x")
    hatched = [patch for patch in grid.axes[2].patches if patch.get_hatch()]
    assert crosses == len(hatched) == np.sum(status >= 2)
    lines = {line.get_label(): line for line in motors.axes[0].get_lines()}
    np.testing.assert_allclose(
        lines["primary (order 1)"].get_ydata(), value_of(record, "motor_gains/level")[:, 0]
    )
    poles = next(
        line for line in locus.axes[0].get_lines() if line.get_label() == "gain of the case"
    )
    # all real: over the gain
    np.testing.assert_allclose(poles.get_ydata(), value_of(record, "pole").real)
