"""Claim: pictures of motion, energies, switching and impacts show the numbers of the result."""

from dataclasses import replace

import numpy as np
import pytest
from long_but import long_but
from report_samples import golden

pytest.importorskip("matplotlib")

from drawn import assert_apart, figure, lines, words

#: picture -> the golden result that has it
OWN = {
    "piston_acceleration": "compressor",
    "mode_shapes": "compressor",
    "energy_by_order": "compressor",
    "operations": "compressor",
    "switching": "compressor_switching",
    "impact_clearance": "compressor_impact",
    "impact_time": "compressor_impact",
    "impact_spectrum": "compressor_impact",
    "dominance": "compressor_impact",
    # of which the numbers at the left are wider than at the size that is measured first
    "balance_orders": "balance_i4",
    "torsion_twists": "engine_two_stroke",
}


@pytest.mark.parametrize(
    "name", long_but(OWN, "energy_by_order", "operations", "impact_clearance", "impact_time")
)
def test_letters_and_axes_stay_apart(name: str) -> None:
    assert_apart(figure(golden(OWN[name]), name))


def test_acceleration_is_held_against_two_harmonics() -> None:
    result = golden("compressor")
    above, below = figure(result, "piston_acceleration").axes
    drawn = lines(above)
    whole, short = (
        np.asarray(drawn[name].get_ydata()) for name in ("all orders", "orders 1 and 2")
    )
    missed = np.asarray(below.get_lines()[0].get_ydata())
    np.testing.assert_allclose(missed, whole - short, rtol=0, atol=1e-9)
    # the first term left out is that of order 4
    fourth = abs(result.record["kinematics/acceleration_harmonics"].values[4])
    assert np.abs(missed).max() == pytest.approx(fourth, rel=0.03)
    assert f"{np.abs(missed).max():.3g} m/s$^2$" in below.get_title(loc="left")
    assert above.get_ylabel() == "acceleration in m/s$^2$"


def test_energies_have_dots_down_to_a_millionth_of_the_largest() -> None:
    result = golden("compressor")
    (axes,) = figure(result, "energy_by_order").axes
    kinds = [result.record[f"response/{x}_energy/peak_by_order"] for x in ("kinetic", "potential")]
    largest = max(float(kind.values.max()) for kind in kinds)
    values = kinds[0].values
    acting = values >= 1e-6 * largest
    tops = np.asarray(axes.get_lines()[0].get_ydata())
    assert 0 < acting.sum() < np.count_nonzero(values)
    np.testing.assert_allclose(tops[acting], values[acting], rtol=1e-12)
    assert axes.get_yscale() == "log"
    assert axes.get_ylim()[0] == pytest.approx(1e-6 * largest)
    last = max(int(np.flatnonzero(kind.values >= 1e-6 * largest)[-1]) + 1 for kind in kinds)
    assert f"orders {last + 1} to {len(values)}: below" in axes.get_title(loc="right")
    assert axes.get_ylabel() == "energy in J"


def test_switching_shows_envelope_energy_and_speed() -> None:
    result = golden("compressor_switching")
    made = figure(result, "switching")
    grid = np.array(made.axes).reshape(4, 2)
    assert [axes.get_title(loc="left") for axes in grid[0]] == [
        "change via standstill", "instantaneous change"
    ]  # fmt: skip
    assert grid[0, 0].get_ylabel() == "displacement\nin \u00b5m"
    stem = "response/switching/reversal"
    below, above = (result.record[f"{stem}/translation_{end}"] for end in ("low", "high"))
    most = int(np.argmax(result.record[f"{stem}/translation_peak"].values[0]))
    name = f"{above.axes[0].values[0]}, {'xyz'[most]}"
    assert name in [text.get_text() for text in made.legends[0].get_texts()]
    outline = grid[0, 0].collections[0].get_paths()[0].vertices[:, 1]
    assert outline.max() == pytest.approx(1e6 * above.values[0, most].max())
    assert outline.min() == pytest.approx(1e6 * below.values[0, most].min())
    low, high = grid[2, 0].get_ylim()
    for way, axes in zip(("reversal", "instant"), grid[2], strict=True):
        energy = result.record[f"response/switching/{way}/kinetic_energy_peak"].values
        assert axes.get_yscale() == "log"
        assert low < energy.max() < high
        dots = [line for line in axes.get_lines() if line.get_marker() == "o"]
        assert [float(dot.get_ydata()[0]) for dot in dots] == pytest.approx(list(energy))
    speed = np.asarray(grid[3, 0].get_lines()[0].get_ydata())
    assert (speed.max(), speed.min()) == pytest.approx((3447.3, -3447.3), rel=0.03)
    assert np.ptp(grid[3, 1].get_lines()[0].get_ydata()) == 0.0
    assert grid[3, 1].get_xlabel() == "time in s"


def test_force_against_clearance_has_error_bars() -> None:
    result = golden("compressor_impact")
    force = result.record["response/impact/mean_force"].values
    axes = figure(result, "impact_clearance").axes[0]
    (bars,) = axes.containers
    np.testing.assert_allclose(bars.lines[0].get_ydata(), force)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert axes.get_xlabel() == "clearance in mm" and axes.get_ylabel() == "force in N"
    assert "471 N" in words(axes)
    segments = bars.lines[2][0].get_segments()
    upper = [segment[1, 1] for segment in segments]
    scatter = result.record["response/impact/mean_force_standard_error"].values
    np.testing.assert_allclose(upper, force + scatter)
    assert min(segment[0, 1] for segment in segments) > 0.0


def test_dominance_marks_the_order_from_which_impacts_lead() -> None:
    result = golden("compressor_impact")
    leads = result.record["response/impact/dominant_from"]
    assert leads.values.tolist() == [9, 5, 3, 3, 3]
    nowhere = replace(leads, values=np.array([0, 5, 3, 3, 3]))
    result.record.quantities[leads.path] = nowhere
    (axes,) = figure(result, "dominance").axes
    drawn = lines(axes)
    assert {"inertia force of the piston", "axial force of the motor"} <= set(drawn)
    assert axes.get_yscale() == "log"
    assert "impacts nowhere dominant" in words(axes)
    assert "impacts dominant from order 5" in words(axes)
    added = result.record["response/impact/added_force"].values
    np.testing.assert_allclose(drawn["impacts add, clearance 0.0381 mm"].get_ydata(), added[2])
    marks = {round(float(path.vertices[0, 0]), 6) for line in axes.collections
             for path in line.get_paths()}  # fmt: skip
    assert marks == {3.0, 5.0}
    inertia = drawn["inertia force of the piston"]
    shaking = result.record["response/impact/shaking"].values
    assert inertia.get_ydata()[0] == pytest.approx(shaking[0])
    sizes = np.asarray(inertia.get_ydata())
    assert np.all(sizes[np.isfinite(sizes)] > 0.0)
