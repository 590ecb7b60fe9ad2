"""Claim: the report on a shaft line says what the result has.

Verdicts follow the uses of the limits, tables add up where they have to, what is missing is left
out. What it says of golden results is held by `test_consistency_said.py`.
"""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from report_samples import quantity
from torsion_samples import ROOT, geared, ruled, six

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Axis, Record, Result
from vibecalc.torsion.report.first_page import conclusion
from vibecalc.torsion.report.limits import flags
from vibecalc.torsion.report.line import within
from vibecalc.torsion.report.modes import torsion_modes


def changed(result: Result, **values: Any) -> Result:
    """A copy with other values; `__` stands for `/` in a path, None takes the quantity away."""
    record = Record(quantities=dict(result.record.quantities))
    for name, value in values.items():
        path = ROOT + name.replace("__", "/")
        old = record.quantities.pop(path)
        if value is not None:
            record.add(quantity(path, np.asarray(value), old.unit, *old.axes))
    return replace(result, record=record, verdicts=None)


def section(text: str, title: str) -> list[str]:
    """Lines below a title, up to the next one."""
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(title)) + 2
    rest = lines[start:]
    end = next((i for i, line in enumerate(rest) if re.fullmatch(r"-{3,}", line)), len(rest) + 1)
    return rest[: end - 1]


def row(lines: list[str], start: str, which: int = 0) -> list[str]:
    """Words of a line that starts with `start`."""
    found = [line for line in lines if " ".join(line.split()).startswith(start)]
    return found[which].split()


@pytest.mark.long
@pytest.mark.parametrize("share", [4, 1])
def test_every_part_may_be_missing(share: int) -> None:
    """A result without one of its quantities still has a report, clean as before."""
    for result, every in ((six(), 3), (geared(), 4)):
        for path in list(result.record)[:: share * every]:
            text = render_report(changed(result, **{path.removeprefix(ROOT): None}))
            assert not re.search(r"\b(nan|None)\b", text), path


@pytest.mark.parametrize(
    ("largest", "operating", "transient", "verdict", "words"),
    [
        (0.9, 0.5, 0.5, "kept", "within the limit"),
        (1.2, 0.5, 0.7, "pass only", "within the limit"),
        (1.2, 1.1, 0.7, "BROKEN", "exceeds limit 1 at the operating speed"),
        (2.2, 0.5, 1.3, "BROKEN", "exceeds limit 1 even for passing through"),
        (2.2, 1.4, 1.3, "BROKEN", "at the operating speed and even for passing through"),
    ],
)
def test_verdicts_follow_the_uses(
    largest: float, operating: float, transient: float, verdict: str, words: str
) -> None:
    uses = {"each/use": largest, "operating/use": operating, "each/transient_use": transient}
    shape = np.ones_like(six().record[f"{ROOT}limit/each/use"].values)
    result = changed(six(), **{
        f"limit__{name.replace('/', '__')}": use * shape for name, use in uses.items()
    })  # fmt: skip
    assert flags(result) == [verdict]
    assert words in conclusion(result)


def test_allowed_stresses_are_those_of_the_rule() -> None:
    """A row for each section: what its numbers say in the formula that the full report states."""
    lines = section(render_report(ruled(), full=True), "Limits of the stress")
    _, _, wide, strength, counted, c_k, c_d, rated = row(lines, "1 tail", 1)
    assert float(counted) == min(float(strength), 600.0) == 600.0
    assert float(rated) == 600.0
    assert float(c_d) == pytest.approx(0.35 + 0.93 * float(wide) ** -0.2, rel=1e-4)
    shown = [float(one) for one in row(lines, "1 tail")[2:]]
    speed, stress, lasting, use, passing, through = shown[:6]
    for at, load, allowed, share in (
        (speed, stress, lasting, use),
        (600.0, *shown[6:9]),
    ):
        ratio = at / float(rated)
        bracket = 3.0 - 2.0 * ratio**2 if ratio < 0.9 else 1.38
        tau = (float(counted) + 160.0) / 18.0 * float(c_k) * float(c_d) * bracket
        assert allowed == pytest.approx(tau, rel=3e-3)
        assert share == pytest.approx(100.0 * load / allowed, rel=2e-3)
    assert passing == pytest.approx(1.7 * lasting / math.sqrt(float(c_k)), rel=3e-3)
    assert through == pytest.approx(100.0 * stress / passing, rel=2e-3)


def test_gears_that_hammer_are_named() -> None:
    result = changed(geared(), gear__hammers=[0, 1])
    assert "gear 'wheel - take-off' hammers at the operating speed" in conclusion(result)
    lines = section(render_report(result), "Vibration at the operating speed")
    assert "HAMMER" in " ".join(row(lines, "wheel - take-off", 1))
    assert row(lines, "pinion - wheel")[-3:] == ["stay", "in", "contact"]
    assert "hammer" not in conclusion(changed(geared(), gear__hammers=[0, 0]))


def test_gears_that_hammer_inside_the_range_are_named_with_the_range() -> None:
    """Still in contact at the operating speed is no pass for the range."""
    hammers = np.zeros_like(ruled().record[ROOT + "speeds/gear_hammers"].values)
    hammers[1, 20] = 1
    least = {"largest__gear_minimum_torque": [1.0, -1.0]}
    result = changed(ruled(), gear__hammers=[0, 0], speeds__gear_hammers=hammers, **least)
    for name in ("from", "to", "gear"):
        result.record.quantities.pop(f"{ROOT}hammering/{name}", None)
    axis = Axis(name="hammering", values=np.array([1]))
    for name, value in (("from", 50.0), ("to", 52.0), ("gear", 2)):
        result.record.add(quantity(f"{ROOT}hammering/{name}", [value], "rad/s", axis))
    assert "gear 'wheel - take-off' hammers from 477.5 to 496.6 rpm" in conclusion(result)
    assert "at the operating speed" not in conclusion(result).split("hammers")[1]


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [(40.0, 19.6, "40 +- 20"), (49.82, 28.6, "50 +- 30"), (33.2312, 1e-9, "33.23"),
     (0.1234, 0.0021, "0.123 +- 0.003"), (-5.1, 0.2, "-5.1 +- 0.2"),
     (1234.0, 0.51, "1234.0 +- 0.6"), (3.0, 4.0, "0")],
)  # fmt: skip
def test_a_number_shows_no_digit_that_its_error_hides(
    value: float, error: float, words: str
) -> None:
    assert within(value, error) == words


def test_holzer_tables_close_and_only_modes_that_matter_have_one() -> None:
    result = six()
    section_ = torsion_modes(result)
    assert section_ is not None
    text = "\n".join(section_.detail)
    natural = np.asarray(result.record[ROOT + "modes/undamped_frequency"].values)
    highest = 12.0 * 1000.0 * math.pi / 30.0
    shown = [int(mode) for mode in re.findall(r"Holzer table of undamped mode (\d+)", text)]
    assert shown == [i + 1 for i, w in enumerate(natural) if 0.0 < w <= highest]
    table = text[text.index("Holzer table of undamped mode 2") :]
    table = table[: table.index("Holzer table of undamped mode 3")]
    rows = [line.split() for line in table.splitlines() if re.search(r"cyl \d ", line)]
    angle = [float(cells[4]) for cells in rows]
    for here, after, cells in zip(angle, angle[1:], rows, strict=False):
        assert float(cells[8]) == pytest.approx(here - after, abs=2e-5)
        assert float(cells[6]) == pytest.approx(float(cells[7]) * (here - after), rel=2e-3)
    assert row(table.splitlines(), "flywheel")[-1] == "0"


def test_holzer_tables_of_branches_close_at_the_last_row() -> None:
    """Each sum is what its shaft carries, stiffness times twist, and the last sum is nothing."""
    section_ = torsion_modes(geared())
    assert section_ is not None
    text = "\n".join(section_.detail)
    table = text[text.index("Holzer table of mode 2") :].split("\n\n")[0]
    number_ = r"-?[\d.]+(?:e[+-]\d+)?"
    rows = re.findall(rf"^.{{18}}((?: +{number_}){{7}})$", table, re.MULTILINE)
    assert len(rows) >= 4
    for row_ in rows:
        *_, total, stiffness, twist = (float(cell) for cell in row_.split())
        assert total == pytest.approx(stiffness * twist, rel=2e-3)
    last = next(line for line in reversed(table.splitlines()) if re.search(r"\s0$", line))
    assert len(last.split()) >= 5
    assert re.search(r"Branches: .* joins ", " ".join(table.split()))


def test_what_nothing_damps_is_unbounded_and_said() -> None:
    worst = np.array(six().record[ROOT + "largest/torque_half_range"].values)
    worst[5] = np.inf
    result = changed(six(), largest__torque_half_range=worst)
    axis = Axis(name="masked", values=np.array([1]))
    for name, value in (("from", 50.0), ("to", 50.1), ("mode", 2), ("half_order", 3.0)):
        result.record.quantities.pop(f"{ROOT}masked/{name}")
        result.record.add(quantity(f"{ROOT}masked/{name}", [value], "rad/s", axis))
    text = render_report(result)
    assert "unbounded" in " ".join(row(section(text, "Vibration over the speed range"), "rear"))
    assert "Nothing damps the line at 477.5 to 478.4 rpm (1-node, order 3)" in text
    assert "nothing damps" in conclusion(result)
