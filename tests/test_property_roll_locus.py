"""Claim: the picture of the poles shows both of each pair, and something where all are real."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from roll_control_cases import record_of, value_of

pytest.importorskip("matplotlib")

import matplotlib
from test_property_roll_control_report import result_of

from vibecalc.core.report.plots import STYLE, make


def drawn(result: Any) -> Any:
    with matplotlib.rc_context(STYLE):
        figure = make(result, "roll_locus")
    assert figure is not None
    return figure


@cache
def delayed() -> Any:
    return record_of(delay=2e-3, gain=4.0, acceleration_feedback=-0.05)


@pytest.mark.long
def test_both_of_each_pair_are_drawn() -> None:
    record = delayed()
    pole = value_of(record, "pole")
    assert np.any(pole.imag > 0.0)
    figure = drawn(result_of(record))
    plane = figure.axes[0]
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
