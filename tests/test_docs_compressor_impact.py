"""Claim: the impact forces in docs/validation_compressor.md are those of the case."""

import numpy as np
import pytest
from compressor_page import (
    BLOCKS,
    RANGE,
    computed,
    is_printed,
    published,
    record,
    rows,
)

from vibecalc.units import convert

#: column of the page -> result, unit, factor to what is shown
IMPACT_COLUMNS = {
    "mean force, lbf": ("mean_force", "lbf", 1.0),
    "standard error, lbf": ("mean_force_standard_error", "lbf", 1.0),
    "peak of a turn, lbf": ("peak_force", "lbf", 1.0),
    "mean amplitude, lbf": ("average_amplitude", "lbf", 1.0),
    "contacts in a turn": ("impacts", "", 1.0),
    "contact, %": ("contact_share", "", 100.0),
    "lost in a turn, mJ": ("dissipated", "J", 1000.0),
    "parted after, turns": ("parting", "", 1.0),
    "dominant from order": ("dominant_from", "", 1.0),
}


def test_impact_statistics() -> None:
    """Within four standard errors, or to the digits shown where those are finer."""
    (block,) = (one for one in BLOCKS if one.startswith("| clearance, in | mean force"))
    head, _, *cells = rows(block)
    assert set(head[1:]) == set(IMPACT_COLUMNS)
    assert len(cells) == 5
    for clearance, *numbers in cells:
        for name, number in zip(head[1:], numbers, strict=True):
            path, unit, factor = IMPACT_COLUMNS[name]
            path = f"response/impact/{path}"
            where = {"clearance": f"{clearance} in"}
            value = factor * computed("compressor_impact", path, where, unit)
            quantity = record("compressor_impact")[path]
            scatter = 4.0 * factor * (quantity.standard_error or 0.0)
            scatter = convert(scatter, quantity.unit, unit) if unit else scatter
            decimals = len(number.partition(".")[2])
            close = max(scatter, 0.5000001 * 10.0**-decimals)
            assert float(number) == pytest.approx(value, abs=close), (clearance, name)
    # 2 is the motor
    dominant = [
        computed("compressor_impact", "response/impact/dominant", {"clearance": c, "order": 4}, "")
        for c in ("1e-4 in", "5e-4 in")
    ]
    assert dominant == [2, 2]


@pytest.mark.long
@pytest.mark.parametrize("row", range(3))
def test_averages_with_the_options_of_the_source(row: int) -> None:
    """Within four standard errors; the quantiles within what the printed digits say."""
    (block,) = (one for one in BLOCKS if one.startswith("| clearance, in | printed"))
    clearance, printed, mean, error, turns = rows(block)[2 + row]
    part = published("impact_motion")
    values = part["ensemble"](float(clearance))
    scatter = np.std(values.mean(axis=1), ddof=1) / np.sqrt(len(values))
    assert float(mean) == pytest.approx(values.mean(), abs=4.0 * scatter)
    assert float(error) == pytest.approx(scatter, rel=0.4)
    ends = RANGE.match(turns)
    assert ends is not None
    for text, share in zip(ends.groups(), (0.01, 0.99), strict=True):
        spread = 0.5 * (values.max() - values.min())
        assert float(text) == pytest.approx(np.quantile(values, share), abs=spread)
    assert (float(ends[1]) < float(printed) < float(ends[2])) == (row < 2)
    assert is_printed(
        printed,
        "compressor_impact",
        "response/impact/average_amplitude",
        {"clearance": f"{clearance} in"},
    )
