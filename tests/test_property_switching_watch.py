"""Claim: what a change between operations reports holds for what is kept and watched of it.

Fewer orders are fewer orders, and the errors say what that costs; a short watch is reported, and no
peak lies below the steady motion after it; samples stand where the machine puts them.
"""

from functools import cache

import numpy as np
import pytest
from response_machines import run
from switching_machines import ONLY_A, SPEED, compressor, compressor_loads
from test_consistency_switching_stage import STEM, switching

from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import tolerance_warning
from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.follow import follow
from vibecalc.response.switching.system import SpeedSegment

NAMES = ("kinetic_energy_peak", "translation_peak", "ground_force_peak", "settle_time",
         "kinetic_energy_high", "translation_high", "translation_low")  # fmt: skip
WANTED = (
    f"{STEM}/steady_energy",
    f"{STEM}/instant/worst_kinetic_energy_peak",
    *(f"{STEM}/{way}/{name}" for way in ("instant", "reversal") for name in NAMES),
)


@cache
def with_orders(orders: int | None) -> Record:
    table = switching(after="1 s")
    if orders is not None:
        table["excitation"]["orders"] = orders
    return run(table, *WANTED)


def test_too_few_orders_to_tell_when_it_has_settled() -> None:
    with pytest.raises(NumericalFailure, match=r"dropped orders may add.*keep more orders"):
        with_orders(1)


@pytest.mark.parametrize("orders", [2, pytest.param(3, marks=pytest.mark.long)])
def test_dropped_orders_are_dropped_and_within_the_errors(orders: int) -> None:
    few, all_of_them = with_orders(orders), with_orders(None)
    for path in WANTED:
        ours, truth = few[path], all_of_them[path]
        apart = np.abs(ours.values - truth.values).max()
        assert apart <= ours.error_estimate + truth.error_estimate, path
    energy, truth = (record[f"{STEM}/instant/kinetic_energy_peak"] for record in (few, all_of_them))
    apart = np.abs(energy.values - truth.values).max()
    assert apart > 1e4 * truth.error_estimate
    assert energy.error_estimate < 300.0 * apart
    assert "more help ([excitation] orders)" in (tolerance_warning(few, 1e-9) or "")
    assert "undamped" not in (tolerance_warning(few, 1e-9) or "")


def test_no_peak_is_below_the_steady_motion_after_it_and_a_short_watch_is_reported() -> None:
    paths = (f"{STEM}/steady_energy", *(f"{STEM}/instant/{name}" for name in (
        "kinetic_energy_peak", "peak_time", "peak_speed", "translation_peak")))  # fmt: skip
    short, long = (run(switching(after=after), *paths) for after in ("1 ms", "1 s"))
    peaks, steady = short[f"{STEM}/instant/kinetic_energy_peak"], short[f"{STEM}/steady_energy"]
    assert np.all(peaks.values >= steady.values[::-1])
    assert peaks.values[0] == steady.values[1] < long[peaks.path].values[0]
    assert short[f"{STEM}/instant/peak_time"].values[0] == pytest.approx(1e-3, rel=1e-12)
    (reported,) = [words for words in short.warnings if "before the body has settled" in words]
    assert (
        "A+B to A at once settles in 0.645 s" in reported
        and "kinetic energy (up to 1.8" in reported
    )
    assert not any("before the body has settled" in words for words in long.warnings)


def test_samples_do_not_move_with_the_steps_inside() -> None:
    """More orders make finer steps; the samples change by the orders alone."""
    system = compressor()
    profile = [SpeedSegment(0.2, SPEED, 0.0, 0), SpeedSegment(0.1, -0.0, -SPEED, ONLY_A)]
    few, many = (
        follow(system, compressor_loads(10)._replace(retained=kept), profile, buckets=40)
        if kept
        else follow(system, compressor_loads(24), profile, buckets=40)
        for kept in (6, None)
    )
    assert few.history.samples == many.history.samples > 1
    uncertainty = few.peaks.error + many.peaks.error
    for ours, other in zip(few.history[2:4], many.history[2:4], strict=True):
        assert np.all(np.abs(ours - other) <= uncertainty + 1e-12 * many.peaks.value)
