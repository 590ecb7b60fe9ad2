"""Claim: the pictures of a shaft line show the numbers of the result, and words do not collide."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from torsion_samples import ROOT, geared, six

pytest.importorskip("matplotlib")

from vibecalc.core.report.plots import STYLE, make
from vibecalc.core.results.record import Result
from vibecalc.core.results.verdicts import judged
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.pictures.modes import strands

RPM = 30.0 / np.pi


def values(result: Result, path: str) -> Any:
    return np.asarray(result.record[ROOT + path].values)


def place(result: Result, path: str, name: str) -> int:
    return list(result.record[ROOT + path].axes[0].values).index(name)


def drawn(axes: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in axes.get_lines()}


def at(line: Any, grid: Any) -> Any:
    """What a curve shows at the speeds of the sweep; maxima stand between them."""
    x, y = (np.asarray(one) for one in line.get_data())
    near = np.argmin(np.abs(x[:, None] - grid), axis=0)
    np.testing.assert_allclose(x[near], grid, rtol=1e-12)
    return y[near]


@pytest.fixture(scope="module")
def made() -> dict[str, Any]:
    """Pictures of the six cylinders, each made once, when it is asked for."""
    import matplotlib

    class Made(dict[str, Any]):
        def __missing__(self, name: str) -> Any:
            with matplotlib.rc_context(dict[Any, Any](STYLE)):
                self[name] = make(six(), name)
            assert self[name] is not None
            return self[name]

    return Made()


def test_shapes_run_along_the_line_and_branches_apart(made: dict[str, Any]) -> None:
    figure = made["torsion_shapes"]
    names = figure.axes[-1].xaxis.ticks()[1]
    assert names == ["front ring", *(f"cyl {i}" for i in range(1, 7)), "flywheel"]
    # the first mode about 0 and to a scale of its own, which its ticks say
    axes = figure.axes[0]
    heights = np.concatenate(
        [line.get_ydata() for line in axes.get_lines() if line.get_marker() == "o"]
    )
    shape = [*values(six(), "modes/shape")[1], *values(six(), "modes/ring_shape")[1]]
    below, zero, above = axes.get_yticks()[:3]
    size = float(axes.yaxis.ticks()[1][2])
    assert (below, zero) == (-above, 0.0)
    shown = sorted(size / above * heights[: len(shape)])
    assert shown == pytest.approx(sorted(np.real(shape)))
    other = geared()
    from vibecalc.core.case.load import validate

    line = build_shaft_line(validate(dict(other.case)))
    paths = [[line.station_names[i] for i in path] for path in strands(line, 7)]
    assert paths == [["a", "b", "pinion", "wheel", "take-off", "generator"],
                     ["wheel", "propeller"]]  # fmt: skip
    picture = make(other, "torsion_shapes")
    assert picture is not None
    assert picture.axes[1].get_title(loc="right") == "from wheel"


def test_campbell_crossings_lie_on_order_lines(made: dict[str, Any]) -> None:
    axes = made["torsion_campbell"].axes[0]
    dots = [line for line in axes.get_lines() if line.get_marker() == "o" and line.get_xdata().size]
    count = 0
    for line in dots:
        speed, hertz = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        order = hertz * 60.0 / speed
        np.testing.assert_allclose(order, np.round(2.0 * order) / 2.0, rtol=1e-9)
        if line.get_markerfacecolor() != "white":
            assert set(np.round(order)) <= {3.0, 6.0, 9.0, 12.0}
        count += speed.size
    inside = RPM * values(six(), "critical/speed")[1:5]
    inside = (inside >= 300.0) & (inside <= 1000.0)
    major = values(six(), "excitation/major") > 0
    assert count == int(np.sum(inside & major)) + 6  # and of each mode at most three strong ones
    size = np.where(inside & ~major, np.abs(values(six(), "excitation/intensity")[1:5]), 0.0)
    for row, line in zip(size[:3], dots[:3], strict=True):
        order = np.round(2.0 * np.asarray(line.get_ydata()) * 60.0 / np.asarray(line.get_xdata()))
        strong = set(np.asarray(order, dtype=int) - 1)
        assert strong <= set(np.argsort(-row)[:3])
    words = {text.get_text() for text in axes.texts}
    assert {"1.5", "3", "12"} <= words
    assert make(geared(), "torsion_speeds") is None  # without a range of speeds


def test_load_against_speed_has_limit_barred_range_and_the_line_without_damper(
    made: dict[str, Any],
) -> None:
    result, (above, middle) = six(), made["torsion_speeds"].axes
    curves = drawn(above)
    section = place(result, "torque_half_range", "rear")
    assert above.get_title(loc="left") == "section rear"
    stress = 1e-6 * values(result, "speeds/stress_half_range")[section]
    grid = RPM * np.asarray(result.record[ROOT + "speeds/stress_half_range"].axes[1].values)
    np.testing.assert_allclose(at(curves["with dampers"], grid), stress)
    ratio = at(curves["without dampers"], grid) / stress
    bare = values(result, "without_dampers/speeds/torque_half_range")[section]
    with_it = values(result, "speeds/torque_half_range")[section]
    np.testing.assert_allclose(ratio, bare / with_it, rtol=1e-9)
    np.testing.assert_allclose(
        curves["limit (table of the case)"].get_ydata(), 1e-6 * values(result, "limit/allowed")[0]
    )
    spans = [patch.get_extents() for patch in middle.patches]
    ends = middle.transData.inverted().transform([(one.x0, one.x1) for one in spans])[:, 0]
    assert ends[0] == pytest.approx(RPM * float(values(result, "barred/from")[0]), rel=1e-6)
    # the twist of each section has a panel in another picture; that of a damper is a travel
    titles = [one.get_title(loc="left").split("\n")[0] for one in made["torsion_twists"].axes]
    assert sorted(titles) == sorted({*drawn(middle)} - {"front ring"})
    np.testing.assert_allclose(at(drawn(middle)["rear"], grid), 1e-3 * with_it)


@pytest.mark.parametrize("of", ["speeds", "largest"])
def test_a_limit_of_the_case_stands_in_every_panel_of_its_quantity(of: str) -> None:
    """On all sections, on one of them alone, on what is scaled; one on another speed nowhere."""
    import matplotlib

    torque, stress = (f"{ROOT}{of}/{name}_half_range" for name in ("torque", "stress"))
    limits = [
        {"quantity": torque, "max": "21 kN*m"},
        {"quantity": stress, "max": "33 N/mm^2", "where": {"section": "rear"}},
        {"quantity": torque, "max": "22 kN*m", "where": {"section": "rear"}},
    ]
    result = six()
    limits += [{**limits[0], "max": "23 kN*m", "where": {"speed": "900 rpm"}}] * (of == "speeds")
    result = replace(result, case={**result.case, "limit": limits})
    result = replace(result, verdicts=judged(result))
    with matplotlib.rc_context(dict[Any, Any](STYLE)):
        figure = make(result, "torsion_speeds")
    assert figure is not None
    told = [{text.get_text(): text.xy[1] for text in axes.texts if "limit" in text.get_text()}
            for axes in figure.axes]  # fmt: skip
    assert told == [
        {"limit 33 N/mm^2, rear": pytest.approx(33.0)},
        {"limit 21 kN m": pytest.approx(21.0), "limit 22 kN m, rear": pytest.approx(22.0)},
    ]
    for axes, heights in zip(figure.axes, told, strict=True):
        assert max(heights.values()) < axes.get_ylim()[1]
