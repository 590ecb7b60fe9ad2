"""Claim: the pictures of a shaft line show the numbers of the result, and words do not collide."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from report_samples import golden

pytest.importorskip("matplotlib")

from drawn import figure, lines

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Result
from vibecalc.core.results.verdicts import judged
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.pictures.modes import _chosen, strands

ROOT = "response/torsion/"
RPM = 30.0 / np.pi


def values(result: Result, path: str) -> Any:
    return np.asarray(result.record[ROOT + path].values)


def at(line: Any, grid: Any) -> Any:
    """What a curve shows at the speeds of the sweep; maxima stand between them."""
    x, y = (np.asarray(one) for one in line.get_data())
    near = np.argmin(np.abs(x[:, None] - grid), axis=0)
    np.testing.assert_allclose(x[near], grid, rtol=1e-12)
    return y[near]


def test_shapes_run_along_the_line_and_branches_apart() -> None:
    result = golden("engine_v8")
    shapes = figure(result, "torsion_shapes")
    names = ["rubber ring", "pulley", *(f"throw {i}" for i in range(1, 5)), "flywheel", "brake"]
    assert shapes.axes[-1].xaxis.ticks()[1] == names
    # the first mode about 0 and to a scale of its own, which its ticks say
    axes = shapes.axes[0]
    heights = np.concatenate(
        [line.get_ydata() for line in axes.get_lines() if line.get_marker() == "o"]
    )
    shape = [*values(result, "modes/shape")[1], *values(result, "modes/ring_shape")[1]]
    below, zero, above = axes.get_yticks()[:3]
    size = float(axes.yaxis.ticks()[1][2])
    assert (below, zero) == (-above, 0.0)
    shown = sorted(size / above * heights[: len(shape)])
    assert shown == pytest.approx(sorted(np.real(shape)))
    other = golden("engine_geared")
    line = build_shaft_line(validate(dict(other.case)))
    first, second = (
        [line.station_names[i] for i in path] for path in strands(line, len(line.station_names))
    )
    assert first == [*(f"throw {i}" for i in range(1, 7)), "flywheel", "coupling", "pinion",
                     "wheel", "propeller"]  # fmt: skip
    assert second == ["pinion", "take-off", "generator"]
    assert figure(other, "torsion_shapes").axes[1].get_title(loc="right") == "from pinion"


def test_campbell_crossings_lie_on_order_lines() -> None:
    result = golden("engine_v8")
    axes = figure(result, "torsion_campbell").axes[0]
    dots = [line for line in axes.get_lines() if line.get_marker() == "o" and line.get_xdata().size]
    count = 0
    for line in dots:
        speed, hertz = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        order = hertz * 60.0 / speed
        np.testing.assert_allclose(order, np.round(2.0 * order) / 2.0, rtol=1e-9)
        if line.get_markerfacecolor() != "white":
            assert set(np.round(order)) <= {4.0, 8.0, 12.0, 16.0, 20.0, 24.0}
        count += speed.size
    inside = RPM * values(result, "critical/speed")[1:7]
    inside = (inside >= 700.0 * (1 - 1e-12)) & (inside <= 5500.0 * (1 + 1e-12))
    major = values(result, "excitation/major") > 0
    # all that the report names: of each mode the five that excite it most
    work = np.where(inside, np.abs(values(result, "excitation/intensity")[1:7]), -1.0)
    named = inside & (work >= np.sort(work, axis=1)[:, -5:-4])
    assert count == int(np.sum(inside & (major | named)))


def test_campbell_draws_few_orders_also_beyond_the_range() -> None:
    result = golden("engine_v8")
    speed = result.record[ROOT + "critical/speed"].values
    work = result.record[ROOT + "excitation/intensity"]
    few = np.zeros_like(work.values)
    few[:, :2] = 1.0
    quantities = {**result.record.quantities, work.path: replace(work, values=few)}
    record = replace(result.record, quantities=quantities)
    _, _, drawn = _chosen(replace(result, record=record), [6])
    assert np.all(speed[6, :2] > 5500.0 / RPM)
    assert np.all(drawn[:2])


def test_load_against_speed_has_limit_and_the_line_without_damper() -> None:
    result = golden("engine_v8")
    above, middle = figure(result, "torsion_speeds").axes
    curves = lines(above)
    quantity = result.record[ROOT + "speeds/stress_half_range"]
    section = list(quantity.axes[0].values).index("crank 3-4")
    assert above.get_title(loc="left") == "section crank 3-4"
    grid, stress = RPM * np.asarray(quantity.axes[1].values), 1e-6 * quantity.values[section]
    np.testing.assert_allclose(at(curves["with dampers"], grid), stress)
    ratio = at(curves["without dampers"], grid) / stress
    bare = values(result, "without_dampers/speeds/torque_half_range")[section]
    with_it = values(result, "speeds/torque_half_range")[section]
    np.testing.assert_allclose(ratio, bare / with_it, rtol=1e-9)
    np.testing.assert_allclose(
        curves["limit (table of the case)"].get_ydata(), 1e-6 * values(result, "limit/allowed")[0]
    )
    # the twist of each section has a panel in another picture; that of a damper is a travel
    twists = figure(result, "torsion_twists").axes
    titles = [one.get_title(loc="left").split("\n")[0] for one in twists]
    assert sorted(titles) == sorted({*lines(middle)} - {"rubber ring"})
    np.testing.assert_allclose(at(lines(middle)["crank 3-4"], grid), with_it)


def test_a_barred_range_is_shaded_from_end_to_end() -> None:
    result = golden("marine_propulsion")
    axes = figure(result, "torsion_speeds").axes[1]
    spans = [patch.get_extents() for patch in axes.patches]
    ends = axes.transData.inverted().transform([(one.x0, one.x1) for one in spans])[:, 0]
    assert ends[0] == pytest.approx(RPM * float(values(result, "barred/from")[0]), rel=1e-6)


def test_a_range_that_may_not_be_barred_has_a_shade_and_words_of_its_own() -> None:
    """Also one that holds the operating speed, 105 rpm, though an old file permits to bar it."""
    result = golden("marine_propulsion")
    ranges = {"from": [4.5, 7.2, 10.8], "to": [5.4, 8.1, 11.4], "permitted": [1, 0, 1]}
    for name, of in ranges.items():
        quantity = result.record[f"{ROOT}barred/{name}"]
        axis = replace(quantity.axes[0], values=np.arange(1, 4))
        result.record.quantities[quantity.path] = replace(
            quantity, values=np.array(of), axes=(axis,)
        )
    axes = figure(result, "torsion_speeds").axes[0]
    shown = [(one.get_label(), one.get_facecolor()) for one in axes.patches]
    for patch, *ends in zip(axes.patches, ranges["from"], ranges["to"], strict=True):
        at = patch.get_x(), patch.get_x() + patch.get_width()
        assert at == pytest.approx(RPM * np.array(ends))
    assert shown[0][0] == "barred for continuous operation"
    assert shown[1][0] == "not acceptable: may not be barred"
    assert shown[0][1] != shown[1][1] == shown[2][1]


@pytest.mark.parametrize("of", ["speeds", "largest"])
def test_a_limit_of_the_case_stands_in_every_panel_of_its_quantity(of: str) -> None:
    """On all sections, on one of them alone, on what is scaled; one on another speed nowhere."""
    torque, stress = (f"{ROOT}{of}/{name}_half_range" for name in ("torque", "stress"))
    one = {"where": {"section": "crank 3-4"}}
    limits = [
        {"quantity": torque, "max": "2.1 kN*m"},
        {"quantity": stress, "max": "33 N/mm^2", **one},
        {"quantity": torque, "max": "2.2 kN*m", **one},
    ]
    result = golden("engine_v8")
    limits += [{**limits[0], "max": "2.3 kN*m", "where": {"speed": "900 rpm"}}] * (of == "speeds")
    result = replace(result, case={**result.case, "limit": limits})
    panels = figure(replace(result, verdicts=judged(result)), "torsion_speeds").axes
    told = [{text.get_text(): text.xy[1] for text in axes.texts if "limit" in text.get_text()}
            for axes in panels]  # fmt: skip
    assert told == [
        {"limit 33 N/mm^2, crank 3-4": pytest.approx(33.0)},
        {
            "limit 2.1 kN m": pytest.approx(2100.0),
            "limit 2.2 kN m, crank 3-4": pytest.approx(2200.0),
        },
    ]
    for axes, heights in zip(panels, told, strict=True):
        assert max(heights.values()) < axes.get_ylim()[1]
