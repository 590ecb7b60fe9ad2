"""Claim: pictures show a run-up with what is left out, ranges by name, and limits only if any."""

from typing import Any

import numpy as np
import pytest
from report_samples import generator_case, optimised, quantity, result_of
from response_samples import compressor

pytest.importorskip("matplotlib")

from test_consistency_response_plots import figure, words

from vibecalc.core.results.record import Axis, Result

MODES = Axis(name="mode", values=np.array([1, 2]))
SPEEDS = np.linspace(0.0, 400.0, 801)


RPM = 30.0 / np.pi


def run_up(masked: list[tuple[float, float]]) -> Result:
    speed = Axis(name="speed", values=SPEEDS, unit="rad/s")
    left_out = Axis(name="masked", values=np.arange(1, len(masked) + 1))
    energy = SPEEDS**2 / (1e-3 + np.abs((SPEEDS / 120.0) ** 2 - 1.0)) ** 2
    low, high = (np.array([pair[end] for pair in masked]) for end in (0, 1))
    return compressor(
        [
            quantity("response/run_up/kinetic_energy", energy, "J", speed),
            quantity("response/run_up/potential_energy", 0.3 * energy, "J", speed),
            quantity("response/masked/low", low, "rad/s", left_out),
            quantity("response/masked/high", high, "rad/s", left_out),
            quantity("response/modes/natural_frequency", [60.25, 120.0], "rad/s", MODES),
        ]
    )


def curves(axes: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in axes.get_lines()}


def test_run_up_energies_on_a_logarithmic_axis() -> None:
    (axes,) = figure(run_up([]), "response_run_up").axes
    assert axes.get_yscale() == "log" and "in J" in axes.get_ylabel()
    drawn = curves(axes)
    kinetic, potential = (drawn[f"{kind} energy, mean"] for kind in ("kinetic", "potential"))
    ratio = np.asarray(kinetic.get_ydata()) / np.asarray(potential.get_ydata())
    assert np.nanmax(np.abs(ratio[1:] - 1.0 / 0.3)) < 1e-12  # at rest: no place on this axis
    assert "at 1146 rpm" in words(axes)
    assert list(drawn["operating speed"].get_xdata()) == pytest.approx([361.0 * RPM] * 2)


def test_ranges_stand_in_the_middle_of_their_bars() -> None:
    kinetic = figure(compressor(), "operations").axes[0]
    middles = [0.5 * (edges[:-1] + edges[1:])[::2]
               for edges in (one.get_data().edges for one in kinetic.patches)]  # fmt: skip
    ranges = [
        float(path.vertices[0, 0])
        for line in kinetic.collections
        for path in line.get_paths()
        if len(path.vertices) == 2
    ]
    assert ranges and all(np.min(np.abs(np.ravel(middles) - one)) < 1e-12 for one in ranges)


def red_lines(axes: Any) -> list[float]:
    return [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == "--"]


def test_a_limit_line_needs_a_limit() -> None:
    limited = optimised()
    case = dict(limited.case)
    free = result_of(limited.record, {**generator_case(), **case, "limit": []}, name="free")
    uses = figure(limited, "optimisation").axes[1]
    assert red_lines(uses) == [100.0]
    assert uses.get_xlabel() == "% of the limit; objective: % of its start"
    uses = figure(free, "optimisation").axes[1]
    assert red_lines(uses) == []
    assert uses.get_xlabel() == "objective: % of its start"
