"""Claim: reports and pictures of absorbers show computed numbers, and end in what to buy."""

import matplotlib
import numpy as np
import pytest
from shipped_cases import CASES, result_of

from vibecalc.report.numbers import show
from vibecalc.report.plots import PICTURES, STYLE, make
from vibecalc.report.text import render_report

NAMES = sorted(name for name in CASES if name.startswith("absorber"))
DRAWN = {
    "absorber": {"absorber_curves", "absorber_map"},
    "absorber_curves": {"absorber_curves"},
    "absorber_damped": {"absorber_curves"},
    "absorber_design_chart": {"absorber_chart", "absorber_map"},
    "absorber_mass": {"absorber_curves", "absorber_surface"},
    "absorber_pendulum": {"pendulum"},
    "absorber_rig_a": {"absorber_curves", "absorber_map", "absorber_warming"},
    "absorber_rig_b": {"absorber_curves", "absorber_warming"},
    "absorber_two": {"absorber_curves"},
}


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_left_to_the_generic_section(name: str) -> None:
    text = render_report(result_of(name))
    assert "Further results" not in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize("name", NAMES)
def test_pictures_for_what_a_result_has(name: str) -> None:
    with matplotlib.rc_context(STYLE):
        drawn = {picture for picture in PICTURES if make(result_of(name), picture) is not None}
    assert drawn == DRAWN[name]


@pytest.mark.parametrize("name", ["absorber_rig_a", "absorber_rig_b"])
def test_what_to_buy_from_computed_quantities(name: str) -> None:
    record, text = result_of(name).record, render_report(result_of(name))
    part = text.split("What to buy:")[1].split("\n\n")[0]
    for path, factor in (
        ("hardware/dynamic_viscosity", 1e3), ("tuning/peak", 1.0), ("hardware/buy/peak", 1.0),
        ("hardware/built/peak", 1.0), ("tuning/torsional_damping", 1.0),
    ):  # fmt: skip
        assert show(factor * float(record[path].values)) in part, path
    assert "0.5200 mm" in part
    penalty = 100.0 * float(record["hardware/buy/penalty"].values)
    assert f"{show(penalty, digits=3)} % above the best" in " ".join(part.split())
    if name.endswith("a"):
        assert show(1e-3 * float(record["hardware/spring_rate"].values)) in part
        best = record["hardware/pair/peak"]
        i, j = np.unravel_index(int(np.argmin(best.values)), best.values.shape)
        assert str(best.axes[0].values[i]) in part and str(best.axes[1].values[j]) in part


def test_curves_in_the_picture_are_the_result() -> None:
    result = result_of("absorber_curves")
    with matplotlib.rc_context(STYLE):
        figure = make(result, "absorber_curves")
    assert figure is not None
    line = figure.axes[0].get_lines()[0]
    size = np.abs(result.record["response/absorber/curve"].values[0])
    np.testing.assert_array_equal(np.asarray(line.get_ydata()), size)
