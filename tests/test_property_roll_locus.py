"""Claim: the picture of the poles shows both of each pair, and something where all are real."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from roll_control_cases import record_of, shipped, value_of

pytest.importorskip("matplotlib")

import matplotlib
from test_property_roll_control_report import result_of

from vibecalc.core.report.plots import STYLE, make
from vibecalc.roll.report.control import roll_control


def drawn(result: Any) -> Any:
    with matplotlib.rc_context(STYLE):
        figure = make(result, "roll_locus")
    assert figure is not None
    return figure


@cache
def delayed() -> Any:
    return record_of(delay=2e-3, gain=4.0, acceleration_feedback=-0.05)


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


def test_poles_that_are_all_real_are_shown_over_the_gain() -> None:
    """They would lie on one line of an empty plane."""
    assert np.all(value_of(shipped().record, "locus/pole").imag == 0.0)
    figure = drawn(shipped())
    (axes,) = figure.axes
    assert axes.get_xlabel() == "gain K"
    low, high = axes.get_ylim()
    transform = axes.transData.transform
    shares = []
    for branch in value_of(shipped().record, "locus/pole").real.T:
        line = next(
            one for one in axes.get_lines() if np.array_equal(np.asarray(one.get_ydata()), branch)
        )
        assert low < np.min(line.get_ydata()) and np.max(line.get_ydata()) < high
        heights = transform(np.column_stack([line.get_xdata(), line.get_ydata()]))[:, 1]
        shares.append(np.mean(heights))
    assert abs(shares[0] - shares[1]) > 0.2 * axes.bbox.height


def test_the_straight_curve_is_reported_in_the_order_that_was_named() -> None:
    section = roll_control(shipped())
    assert section is not None
    text = " ".join(" ".join(section.lines).split())
    assert "10.97 dB above the reduced one (order 7). Were the curve of the motor straight" in text
    assert "0.16 dB above it in order 7, and over all orders at most 3.24 dB below" in text
