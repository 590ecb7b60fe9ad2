"""Claim: the report of the control says how each loop stands before its levels, never praises one
that diverges, and its tables and pictures keep to the page and to the numbers.
"""

import re

import numpy as np
import pytest
from roll_control_cases import record_of, shipped, value_of

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record, Result

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


def test_rows_of_unstable_pairs_have_no_levels() -> None:
    text = section(shipped())
    status = value_of(shipped().record, "grid/status")
    rows = [
        line
        for line in text.splitlines()
        if re.match(r"\s+[\d.]+\s+-?[\d.]+\s+(UNST|stable)", line)
    ]
    assert len(rows) == status.size
    lost = [line for line in rows if "UNSTABLE" in line]
    assert len(lost) == np.sum(status >= 2) > 0
    for line in lost:
        assert re.search(r"UNSTABLE\s+-\s+-\s+-\s+-\s+0.00 dB\s+0.0 deg\s+none$", line)


def test_an_unstable_loop_is_not_praised() -> None:
    text = section(result_of(record_of(gain=10.0, acceleration_feedback=10.0)))
    assert "UNSTABLE: amplitudes unbounded" in " ".join(text.split())
    assert "unbounded" in text and "grows" in text


def test_levels_on_paper_only_are_called_so() -> None:
    record = record_of(gain=10.0, acceleration_feedback=-10.0, actuator_lag=0.0)
    text = " ".join(section(result_of(record)).split())
    assert "STABLE ONLY WITHOUT ANY DELAY: its levels are valid for zero delay only" in text
    assert "delay none" in text and "EXCEEDS the breakdown torque of 1009 N m" in text


# ----------------------------------------------------------------------------
# The picture of the poles.
# ----------------------------------------------------------------------------


@pytest.mark.long
def test_both_of_each_pair_are_drawn() -> None:
    record = record_of(delay=2e-3, gain=4.0, acceleration_feedback=-0.05)
    pole = value_of(record, "pole")
    assert np.any(pole.imag > 0.0)
    pytest.importorskip("matplotlib")
    from drawn import figure

    plane = figure(result_of(record), "roll_locus").axes[0]
    marks = next(line for line in plane.get_lines() if line.get_label() == "gain of the case")
    at = np.asarray(marks.get_xdata()) + 1j * np.asarray(marks.get_ydata())
    for one in pole:
        for other in (one, np.conj(one)):
            assert np.min(np.abs(at - other)) <= 1e-12 * abs(one)
    ends = np.array([part[-1] for lines in plane.collections for part in lines.get_segments()])
    for branch in value_of(record, "locus/pole")[-1]:
        for sign in (1.0, -1.0):
            there = np.abs(ends - [branch.real, sign * branch.imag])
            assert np.min(np.max(there, axis=1)) <= 1e-9 * abs(branch)
