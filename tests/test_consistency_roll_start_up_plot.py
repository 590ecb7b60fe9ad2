"""Claim: the picture of a start-up shows the numbers of the result."""

from typing import Any

import numpy as np
import pytest
from report_samples import quantity
from roll_samples import RPM, roll
from roll_start_up_samples import STEM, start_up

pytest.importorskip("matplotlib")

from drawn import assert_apart, figure, lines, words

from vibecalc.core.report.plots import make
from vibecalc.core.results.record import Result
from vibecalc.roll.pictures.start_up import arcs

NAME = "roll_start_up"


def replaced(result: Result, path: str, values: Any) -> Result:
    old = result.record.quantities[path]
    result.record.quantities[path] = quantity(path, values, old.unit, *old.axes)
    return result


def test_a_picture_needs_its_own_numbers_only() -> None:
    assert make(roll(start_up()), NAME) is not None
    assert make(roll(), NAME) is None


def test_each_result_alone_is_no_reason_to_fail() -> None:
    drawn = [made for item in start_up() if (made := make(roll([item]), NAME)) is not None]
    for made in drawn:
        made.canvas.draw()
    assert len(drawn) < len(start_up())


@pytest.mark.parametrize("started", [True, pytest.param(False, marks=pytest.mark.long)])
def test_letters_and_axes_stay_apart(started: bool) -> None:
    assert_apart(figure(roll(start_up(started)), NAME))


def test_a_start_is_drawn_with_its_envelopes_peaks_and_moments() -> None:
    result = roll(start_up())
    made = figure(result, NAME)
    panels = made.axes
    assert [axes.get_ylabel().split("\n")[0] for axes in panels[:-1]] == [
        "crank speed", "shell angle", "shell accel.", "motor torque", "mount torque"
    ]  # fmt: skip
    assert made.get_suptitle().endswith("it runs and settles")
    for axes, name, factor in (
        (panels[0], "crank_speed", 1.0 / RPM),
        (panels[1], "shell_angle", 1e3),
        (panels[3], "motor_torque", 1.0),
    ):
        outline = axes.collections[0].get_paths()[0].vertices[:, 1]
        ends = [result.record[f"{STEM}history/{name}_{end}"].values for end in ("low", "high")]
        assert outline.min() == pytest.approx(factor * np.min(ends[0]))
        assert outline.max() == pytest.approx(factor * np.max(ends[1]))
    dots = [line for line in panels[1].get_lines() if line.get_marker() == "o"]
    top = 1e3 * float(result.record[STEM + "shell_angle_peak"].values)
    assert abs(dots[0].get_ydata()[0]) == pytest.approx(top)
    assert f"largest {top:.3f} mrad at" in panels[1].get_title(loc="right")
    assert "at speed 0.2960 s" in words(panels[0]) and "settled 1.715 s" in words(panels[0])
    assert "load x 0" in words(panels[0]) and "load x 1" in words(panels[0])
    mean = lines(panels[0])["mean of a turn"]
    assert mean.get_ydata()[0] == pytest.approx(92.97 / RPM)
    assert mean.get_xdata()[0] == pytest.approx(0.2876 + np.pi / 92.97)
    assert panels[4].get_xlabel() == "time in s"


def test_what_does_not_start_is_reported_and_has_no_moments() -> None:
    made = figure(roll(start_up(False)), NAME)
    assert made.get_suptitle().endswith("it does not start")
    assert "at speed" not in words(made.axes[0]) and "settled" not in words(made.axes[0])


def test_a_history_of_nothing_has_no_panel() -> None:
    result = roll(start_up())
    for end in ("low", "high"):
        replaced(result, f"{STEM}history/mount_torque_{end}", np.zeros(400))
    names = [axes.get_ylabel().split("\n")[0] for axes in figure(result, NAME).axes]
    assert "mount torque" not in names and len(names) == 5


def test_angles_of_a_start_go_around() -> None:
    axes = figure(roll(start_up()), NAME).axes[-1]
    spans = sorted((round(p.get_x(), 6), round(p.get_x() + p.get_width(), 6)) for p in axes.patches)
    assert spans == [(0.0, 2.0), (0.0, 360.0), (170.0, 262.0), (340.0, 360.0)]
    assert "31.67 % of all angles" in axes.get_title(loc="left")
    assert arcs(10.0, 370.0) == [(0.0, 360.0)]
    assert arcs(-20.0, 30.0) == [(340.0, 360.0), (0.0, 30.0)]
    assert arcs(365.0, 380.0) == [(5.0, 20.0)]
