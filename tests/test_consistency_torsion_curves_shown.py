"""Claim: report and pictures show curves, irregularity and the worst condition as computed."""

from typing import Any

import numpy as np
import pytest
from dense_curve_line import RPM, SPEED, run, values
from test_consistency_torsion_curves import CONDITIONS, CURVES

from vibecalc.core.report.text import render_report


@pytest.fixture(scope="module")
def page() -> str:
    return render_report(run(CURVES), full=True)


def rows(page: str, title: str) -> list[list[str]]:
    """Cells of the lines from a title to the next one."""
    section = page[page.index(f"\n{title}") + 1 :].split("\n---")[1]
    return [line.split() for line in section.splitlines()]


def test_the_largest_of_each_order_stands_with_its_speed(page: str) -> None:
    found = rows(page, "Curves of orders, 500 to 1300 rpm")
    top, at = (values(run(CURVES), f"curves/torque/{one}") for one in ("largest", "largest_speed"))
    orders = run(CURVES).record["response/torsion/curves/torque/order"].axes[1].values
    best = int(np.argmax(top[0]))
    unit = 1e-3 if ["kN", "m", "rpm"] in found else 1.0
    shown = next(row for row in found if row and row[0] == f"{orders[best]:g}")
    assert float(shown[1]) == pytest.approx(unit * top[0, best], rel=1e-3)
    assert float(shown[2]) == pytest.approx(at[0, best] / RPM, rel=1e-3)
    measured = next(row for row in found if row[:1] == ["tail"] and "sum" in row[3:])
    assert float(measured[-1]) == pytest.approx(
        2000.0 / values(run(CURVES), "curves/torque/measured/computed")[0], rel=1e-2
    )


def test_irregularity_is_told_as_one_to_x(page: str) -> None:
    found = rows(page, "Cyclic irregularity")
    degree = values(run(CURVES), "irregularity/degree")
    for name, one in zip(("generator", "flywheel", "wheel"), degree, strict=True):
        row = next(row for row in found if row[:1] == [name])
        assert float(row[1]) == pytest.approx(one, rel=1e-3)
        assert float(row[2]) == pytest.approx(1.0 / one, rel=1e-3)


def test_the_worst_condition_of_each_section_is_named() -> None:
    page, result = render_report(run(CONDITIONS), full=True), run(CONDITIONS)
    found = rows(page, "Misfire and imbalance: the worst condition of each section")
    here = result.record["response/torsion/conditions/torque_half_range"]
    names = list(here.axes[0].values)
    for i, section in enumerate(here.axes[1].values):
        row = " ".join(next(row for row in found if row[:1] == [section]))
        worst = values(result, "conditions/largest/section_condition")[i] - 1
        assert row.endswith(names[worst])
        assert names[int(np.argmax(here.values[:, i]))] in row
    assert "given pressures" in page and "1 out of balance" in page


def test_pictures_show_orders_with_their_numbers_and_the_sums() -> None:
    matplotlib = pytest.importorskip("matplotlib")
    from vibecalc.core.report.plots import STYLE, make

    with matplotlib.rc_context(dict[Any, Any](STYLE)):
        figure = make(run(CURVES), "torsion_curves")
        stations = make(run(CURVES), "torsion_station_curves")
    assert figure is not None and stations is not None
    panels = [one.get_title(loc="left") for one in figure.axes if one.get_visible()]
    assert panels == [
        "tail: torque", "rubber: torque", "teeth: torque", "tail: stress", "tail: twist"
    ]  # fmt: skip
    axes = figure.axes[3]
    lines = {line.get_label(): line for line in axes.get_lines()}
    np.testing.assert_allclose(
        lines["half range of all orders"].get_ydata(),
        1e-6 * values(run(CURVES), "curves/stress/half_range")[0],
    )
    np.testing.assert_allclose(
        lines["sum of magnitudes"].get_ydata(),
        1e-6 * values(run(CURVES), "curves/stress/sum")[0],
    )
    assert lines["sum of magnitudes"].get_linestyle() == "--"
    order = np.abs(values(run(CURVES), "curves/stress/order")[0])
    drawn = [line for line in axes.get_lines() if line.get_linewidth() == 0.8]
    told = {text.get_text() for text in axes.texts}
    orders = run(CURVES).record["response/torsion/curves/stress/order"].axes[1].values
    strongest = np.argsort(-order.max(axis=1))[: len(drawn)]
    assert {f"{orders[i]:g}" for i in strongest} <= told
    np.testing.assert_allclose(
        sorted(np.max(line.get_ydata()) for line in drawn),
        1e-6 * np.sort(order.max(axis=1)[strongest]),
    )
    assert len(drawn[0].get_xdata()) == len(SPEED)
    assert len([one for one in stations.axes if one.get_visible()]) == 6
