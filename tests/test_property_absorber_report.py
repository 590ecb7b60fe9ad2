"""Claim: reports and pictures of absorbers show computed numbers, and end in what to buy."""

from pathlib import Path

import matplotlib
import numpy as np
import pytest
from absorber_cases import TUNED
from long_but import long_but
from shipped_cases import CASES, result_of

from vibecalc.core.report.plots import STYLE, every_picture, make
from vibecalc.core.report.text import render_report
from vibecalc.core.report.writing import show
from vibecalc.core.study.execute import execute, load_checked

NAMES = sorted(name for name in CASES if name.startswith("absorber"))
KEPT = ("absorber", "absorber_mass", "absorber_pendulum", "absorber_rig_a")
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


@pytest.mark.parametrize(
    "name", long_but(NAMES, "absorber", "absorber_mass", "absorber_pendulum", "absorber_rig_a")
)
def test_nothing_is_left_to_the_generic_section(name: str) -> None:
    text = render_report(result_of(name), full=True)
    assert "Further results" not in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.parametrize(
    "name", long_but(NAMES, "absorber", "absorber_mass", "absorber_pendulum", "absorber_rig_a")
)
def test_pictures_for_what_a_result_has(name: str) -> None:
    with matplotlib.rc_context(STYLE):
        drawn = {
            picture for picture in every_picture() if make(result_of(name), picture) is not None
        }
    assert drawn == DRAWN[name]


@pytest.mark.parametrize("name", ["absorber_rig_a", "absorber_rig_b"])
def test_what_to_buy_from_computed_quantities(name: str) -> None:
    record, text = result_of(name).record, render_report(result_of(name), full=True)
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


def _text(tmp_path: Path, text: str, *settings: str) -> str:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path], settings)
    return " ".join(render_report(execute(loaded), full=True).split())


def _tuned(tmp_path: Path, table: str, damping: str = "0.02") -> str:
    text = TUNED.replace('compare = ["den_hartog"]', table)
    return _text(tmp_path, text, f"machine.primary.damping_ratio={damping}")


def test_mean_squares_are_not_called_peaks(tmp_path: Path) -> None:
    table = 'norm = "h2"\nmistuning = [0.01]\ncompare = ["warburton", "numerical"]'
    text = _tuned(tmp_path, table)
    assert "higher mean square, %" in text and "higher peak" not in text
    assert "true peak mean square" in text and "above the" not in text
    row = text.split("warburton ")[1].split()
    assert row[2] == "-" and float(row[3]) > 4.0


def test_a_threshold_of_zero_is_no_threshold(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'excitation = "base"\nresponse = "acceleration"', "0.0")
    assert "With any damping of the primary it grows without bound." in text
    assert "damping of the primary of 0 on" not in text


def test_a_spring_alone_that_does_not_help(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'kind = "undamped_spring"')
    assert "No spring without a damper lowers the largest amplitude" in text
    assert "force; spring and damper do." in text
    assert "No absorber" not in text and "peak that holds it" not in text


def test_promised_peaks_are_those_of_an_undamped_primary(tmp_path: Path) -> None:
    words = "promised by a closed form: the peak on an undamped primary"
    table = 'compare = ["den_hartog", "numerical"]'
    assert words in _tuned(tmp_path, table)
    assert words not in _tuned(tmp_path, table, "0.0")


def test_where_none_helps_nothing_is_bought() -> None:
    text = render_report(
        result_of(
            "absorber_rig_a",
            "machine.primary.damping_ratio=0.9",
            "tuning.temperatures.points=2",
            "response.absorber.frequencies.points=11",
        )
    )
    part = text.split("What to buy:")[1].split("\n\n")[0]
    assert part.split() == ["-", "Buy", "nothing:", "no", "absorber", "lowers", "the", "peak."]
    for absent in ("higher peak", "slope by", "the best pairs", "antiresonance"):
        assert absent not in text


def test_two_absorbers_above_the_threshold() -> None:
    text = render_report(result_of("absorber_two", "machine.primary.damping_ratio=0.8"))
    assert "None of these absorbers helps" in text
    assert "a factor" not in text and "higher peak" not in text
    assert "None of these absorbers" not in render_report(result_of("absorber_two"))


def test_without_a_spring_there_is_no_error_of_it() -> None:
    text = render_report(result_of("absorber_rig_b"), full=True)
    table = text.split("higher peak, %")[1].split("\n\n")[0]
    assert (
        "damping" in table
        and "stiffness" not in table
        and "antiresonance" not in text.split("Accuracy:")[0]
    )


def test_viscosities_of_stock_and_of_the_wanted_oil_compare() -> None:
    record, text = (
        result_of("absorber_rig_a").record,
        render_report(result_of("absorber_rig_a"), full=True),
    )
    # 386 and 155 cSt at 40 and 100 degC, density 975 kg/m^3 at 15: 970.4 at 20
    thick = record["hardware/oil/kinematic_viscosity"]
    place = list(thick.axes[0].values).index("silicone 500")
    row = text.split("\n  silicone 500")[1].split("\n")[0].split()
    assert row[0] == show(1e6 * float(thick.values[place]))
    assert float(row[1]) / float(row[0]) == pytest.approx(0.975 * (1.0 - 5.0 * 0.00094), rel=1e-3)
    assert f"({row[1]} mPa s, {row[0]} cSt)" in " ".join(text.split())
    assert "As the oil 'silicone 500' from stock warms, with the springs '2.8 N/mm':" in text


def test_the_surface_names_its_colours_and_both_axes() -> None:
    with matplotlib.rc_context(STYLE):
        figure = make(result_of("absorber_mass"), "absorber_surface")
    assert figure is not None
    left, right, bar = figure.axes
    assert bar.get_xlabel() == "amplitude ratio"
    assert left.get_ylabel() == right.get_ylabel() == "mass ratio"
    assert any(mark.label1.get_visible() for mark in right.yaxis.get_major_ticks())
