"""Claim: the report says how much of the tolerance was reached, by what the record says of itself.

Counts are formed anew here; seconds stand below all that two runs have in common.
"""

from dataclasses import replace

import numpy as np
import pytest
from report_samples import quantity as made
from report_samples import result_of

from vibecalc.core.report.pages import accuracy
from vibecalc.core.report.terminal import plain_summary
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.core.results.tolerance import reached, summarised, tolerance_warning


def quantity(path: str, values: list[float], error: float) -> Quantity:
    return made(path, values, "", Axis(name="row", values=np.arange(len(values))), error=error)


@pytest.fixture
def record() -> Record:
    found = Record()
    for one in (
        quantity("response/torsion/torque", [3.0, -40.0], 4e-9),
        quantity("response/torsion/angle", [2.0], 4e-6),
        replace(quantity("response/torsion/twist", [1e-9], 1e-9), terms=100.0),
        quantity("response/torsion/exceeded/peak_speed", [50.0], 1.0),
        quantity("response/torsion/transient/peak", [7.0], 0.1),
    ):
        found.add(one)
    found.add(replace(quantity("response/torsion/major", [1.0], 0.0), values=np.array([1, 0])))
    return found


def result(record: Record) -> Result:
    plan = ({"stage": "torsion", "why": "asked", "cost": "24 solves"},)
    return result_of(record, {"title": "engine", "accuracy": {"rtol": 1e-8}}, plan=plan)


def test_counts_are_those_of_the_record(record: Record) -> None:
    found = summarised(record, 1e-8)
    shares = {path: reached(one, record) for path, one in record.items()}
    held = {path: share for path, share in shares.items() if share is not None}
    held.pop("response/torsion/major")  # a yes or no has no error
    assert (found.held, found.met) == (len(held), sum(one <= 1e-8 for one in held.values()))
    assert (found.held, found.met) == (2, 1)
    assert found.worst == "response/torsion/angle"
    assert found.share == pytest.approx(2e-6)
    assert sum(count for _, count in found.exempt) == 3
    assert len({words for words, _ in found.exempt}) == 3


def test_what_more_than_rounding_hides_is_missed_and_unresolved() -> None:
    unknown, wide = Record(), quantity("excitation/couple_peak", [196.0], 722.0)
    unknown.add(replace(wide, terms=1e4))
    found = summarised(unknown, 1e-8)
    assert (found.held, found.met, found.exempt) == (1, 0, ())
    text = " ".join(render_report(result(unknown), full=True).split())
    assert "rtol = 1e-08 met by 0 of 1 results; largest relative error unresolved" in text
    assert "196 +-722" in plain_summary(result(unknown))
    warning = tolerance_warning(unknown, 1e-8)
    assert warning is not None and "excitation/couple_peak (unresolved)" in warning
    assert "[excitation] orders" in warning


def test_a_check_is_no_result_that_misses_the_tolerance() -> None:
    record = Record()
    record.add(quantity("response/torsion/modes/holzer_residual", [0.14], 0.14))
    found = summarised(record, 1e-8)
    assert (found.held, sum(count for _, count in found.exempt)) == (0, 1)
    assert tolerance_warning(record, 1e-8) is None
    section = accuracy(result(record))
    assert section is not None and "a check" in section.lines[-1]
