"""Claim: the report on a shaft line keeps to the page and says what the result has.

Verdicts follow the uses of the limits, tables add up where they have to, what is missing is left
out, and no number of the line is reported in a unit or a kind of amplitude that it does not have.
"""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from report_samples import quantity
from torsion_samples import ROOT, geared, ruled, six

from vibecalc.core.report.headline import headline_rows
from vibecalc.core.report.text import render_report
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Axis, Record, Result
from vibecalc.torsion.report.first_page import conclusion
from vibecalc.torsion.report.limits import verdicts
from vibecalc.torsion.report.line import firing_words, mode_names, within
from vibecalc.torsion.report.modes import torsion_modes

TITLES = ("Torsional vibration of the shaft line", "Engine and shaft line",
          "Natural frequencies and modes of the line", "Critical speeds, ",
          "Vibration at the operating speed", "Vibration over the speed range",
          "Limits of the stress and barred ranges")  # fmt: skip


def changed(result: Result, **values: Any) -> Result:
    """A copy with other values; `__` stands for `/` in a path, None takes the quantity away."""
    record = Record(quantities=dict(result.record.quantities))
    for name, value in values.items():
        path = ROOT + name.replace("__", "/")
        old = record.quantities.pop(path)
        if value is not None:
            record.add(quantity(path, np.asarray(value), old.unit, *old.axes))
    return replace(result, record=record)


def section(text: str, title: str) -> list[str]:
    """Lines below a title, up to the next one."""
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(title)) + 2
    rest = lines[start:]
    end = next((i for i, line in enumerate(rest) if re.fullmatch(r"-{3,}", line)), len(rest) + 1)
    return rest[: end - 1]


def row(lines: list[str], start: str, which: int = 0) -> list[str]:
    """Words of a line that starts with `start`."""
    found = [line for line in lines if line.strip().startswith(start)]
    return found[which].split()


def test_pages_are_narrow_clean_stable_and_complete() -> None:
    pages = []
    for result in (six(), geared()):
        text = render_report(result, full=True)
        assert max(len(line) for line in text.splitlines()) <= 100
        assert all(line == line.rstrip() for line in text.splitlines())
        assert not re.search(r"\b(nan|inf|None|array|np\.)\b", text)
        assert "Further results" not in text
        pages.append(text)
    assert [one for one in TITLES if f"\n{one}" not in pages[0]] == []
    assert pages[1] == render_report(geared(), full=True)


@pytest.mark.parametrize("share", [4, pytest.param(1, marks=pytest.mark.long)])
def test_every_part_may_be_missing(share: int) -> None:
    """A result without one of its quantities still has a report, clean as before."""
    for result, every in ((six(), 3), (geared(), 4)):
        for path in list(result.record)[:: share * every]:
            text = render_report(changed(result, **{path.removeprefix(ROOT): None}))
            assert not re.search(r"\b(nan|None)\b", text), path


def cells(lines: list[str], words: str) -> list[str]:
    """Cells of the first row of a table that starts with these words, after them."""
    found = next(line for line in lines if line.strip().startswith(words))
    return found.strip().removeprefix(words).split()


def test_variants_stand_side_by_side_with_limit_and_flag() -> None:
    result = six()
    lines = section(render_report(result), TITLES[0])
    head = next(line for line in lines if line.strip().startswith("quantity"))
    assert head.split()[2:] == ["all", "misfire", "misfire", "3,", "limit", "flag"]
    for name, words, path, factor in (
        ("stress, half range, speed range", "N/mm^2", "largest/stress_half_range", 1e-6),
        ("torque, half range, operating", "kN m", "torque_half_range", 1e-3),
        ("heat in a damper, operating", "W", "damper/heat", 1.0),
    ):
        row_ = cells(lines, f"{name} ")
        known = [
            factor * float(np.max(result.record[ROOT + prefix + path].values))
            for prefix in ("healthy/", "", "bare/")
            if ROOT + prefix + path in result.record
        ]
        assert row_ == [*words.split(), *(show(one, digits=4) for one in known)]
    use = [float(result.record[ROOT + f"{one}limit/largest_use"].values[0])
           for one in ("healthy/", "")]  # fmt: skip
    limit = [word for word in cells(lines, "stress over limit 1, speed range") if word != "!"]
    assert [float(one) for one in limit[1:3]] == pytest.approx([100.0 * u for u in use], rel=1e-3)
    assert limit[3:] == ["100", "pass", "only"]
    low, high = (float(result.record[ROOT + f"barred/{end}"].values[0]) for end in ("from", "to"))
    sentence = conclusion(result)
    turns = [f"{speed * 30.0 / math.pi:.4g}" for speed in (low, high)]
    assert f"{turns[0]} to {turns[1]} rpm is barred" in sentence
    assert sentence.count(".") - sentence.count(".0") <= 3
    assert "misfire of cylinder 3" in sentence


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
    result = changed(
        six(), limit__largest_use=[largest], limit__operating_use=[operating],
        limit__transient_use=[transient],
    )  # fmt: skip
    assert verdicts(result.record) == [verdict]
    assert words in conclusion(result)


def test_a_limit_of_the_case_stands_nearby_its_quantity() -> None:
    bound = {"quantity": ROOT + "damper/heat", "max": "0.5 kW", "source": "maker"}
    result = six()
    text = render_report(replace(result, case={**result.case, "limit": [bound]}))
    lines = section(text, TITLES[0])
    heat = [word for word in cells(lines, "heat in a damper, operating") if word != "!"]
    known = [result.record[f"{ROOT}{one}damper/heat"].values[0] for one in ("healthy/", "")]
    assert heat[1:3] == [show(float(one), digits=4) for one in known]
    assert (heat[0], heat[3:]) == ("W", ["500.0", "BROKEN"])


def test_what_no_case_has_a_limit_for_is_marked_in_other_columns_only() -> None:
    """The bound is for the line as the case has it; a column next to it above it has a mark."""
    result = six()
    worst = float(np.max(result.record[ROOT + "largest/torque_half_range"].values))
    bound = {"quantity": ROOT + "largest/torque_half_range", "max": f"{1.01 * worst:.6g} N*m"}
    text = render_report(replace(result, case={**result.case, "limit": [bound]}))
    torque = cells(section(text, TITLES[0]), "torque, half range, speed range")
    bare = float(np.max(result.record[ROOT + "bare/largest/torque_half_range"].values))
    assert bare > 1.01 * worst
    assert torque[-1] == "kept"
    assert torque[-3] == "!" and torque[-4] == show(1e-3 * bare, digits=4)
    assert "above the limit" in text


def test_allowed_stresses_are_those_of_the_rule() -> None:
    """A row for each section: what its numbers say in the formula that the full report states."""
    lines = section(render_report(ruled(), full=True), TITLES[6])
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
    lines = section(render_report(result), TITLES[4])
    assert "HAMMER" in " ".join(row(lines, "wheel - take-off", 1))
    assert row(lines, "pinion - wheel")[-3:] == ["stay", "in", "contact"]
    assert "hammer" not in conclusion(changed(geared(), gear__hammers=[0, 0]))


def test_gears_that_hammer_inside_the_range_are_named_with_the_range() -> None:
    """Still in contact at the operating speed is no pass for the range."""
    hammers = np.zeros_like(ruled().record[ROOT + "speeds/gear_hammers"].values)
    hammers[1, 20] = 1
    result = changed(ruled(), gear__hammers=[0, 0], speeds__gear_hammers=hammers)
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


def test_an_optimum_on_its_bound_says_so_on_the_terminal() -> None:
    record = Record()
    for key, at, side in (("a", 2.0, 1), ("b", 1.0, 0), ("c", 0.5, -1)):
        record.add(quantity(f"optimisation/variable/{key}", at, "m"))
        record.add(quantity(f"optimisation/active_bound/{key}", side, ""))
    reported = {cells_[0][-1]: cells_[3] for cells_ in headline_rows(record)}
    assert reported == {"a": "at its upper bound", "b": "", "c": "at its lower bound"}


def test_identity_has_the_engine_and_the_values_of_its_parts() -> None:
    lines = section(render_report(six()), TITLES[1])
    assert row(lines, "firing order")[2:] == ["1-5-3-6-2-4,", "every", "120", "deg"]
    assert row(lines, "engine ")[6:12] == ["bore", "200", "mm,", "stroke", "240", "mm,"]
    assert row(lines, "rear")[1:] == ["shaft", "19210", "300", "160"]
    assert row(lines, "cyl 1 to 6") == ["cyl", "1", "to", "6", "station,", "1", "cyl.", "18.64"]
    lines = section(render_report(six(), full=True), TITLES[1])
    assert row(lines, "rear", 1) == ["rear", "804.2"]
    lines = section(render_report(geared()), TITLES[1])
    assert row(lines, "wheel ")[1:] == ["station", "-0.3333", "3"]
    assert row(lines, "wheel - propeller")[4] == "200"
    assert row(lines, "wheel - take-off", 1)[5:] == ["-4", "elastic,", "pitch", "300", "mm"]
    uneven = changed(six(), excitation__firing_angle=np.radians([0, 90, 210, 360, 450, 660]))
    assert firing_words(uneven.record) == "1-2-3-4-5-6, after 90, 120, 150, 90, 210, 60 deg"


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


def test_order_table_has_the_phases_that_it_says() -> None:
    result = six()
    lines = section(render_report(result, full=True), TITLES[3])
    lines = lines[next(i for i, line in enumerate(lines) if "Torque of one cylinder" in line) :]
    total = np.asarray(result.record[ROOT + "excitation/total"].values)
    cells = [float(cell) for cell in row(lines, "2.5 ")]
    assert cells[5] == pytest.approx(1e-3 * total[4].real, rel=1e-3)
    assert cells[6] == pytest.approx(-1e-3 * total[4].imag, rel=1e-3)
    assert math.hypot(cells[5], cells[6]) == pytest.approx(cells[7], rel=1e-3)
    assert cells[8] == pytest.approx(math.degrees(math.atan2(-cells[6], cells[5])), abs=0.1)
    starred = {line.split()[0] for line in lines if re.match(r"\s+[\d.]+ \*", line)}
    assert starred == {"3", "6", "9", "12"}
    reported = np.abs(result.record[ROOT + "excitation/vector_sum"].values)
    assert row(lines, "3 *")[2] == f"{reported[1, 5]:.4f}" and reported[1, 5] > 0.99


def test_criticals_are_those_within_the_range() -> None:
    result = six()
    speed = 30.0 / math.pi * np.asarray(result.record[ROOT + "critical/speed"].values)[1:5]
    inside = (speed >= 300.0) & (speed <= 1000.0)
    lines = section(render_report(result, full=True), TITLES[3])
    start = next(i for i, line in enumerate(lines) if line.strip().startswith("order"))
    stop = next(i for i, line in enumerate(lines) if i > start and not line.strip())
    shown = [cell for line in lines[start + 2 : stop] for cell in line.replace("*", "").split()[1:]]
    assert sorted(shown) == sorted(f"{one:.4g}" for one in speed[inside])
    assert len(shown) > 20
    # first the strongest five of each mode
    work = np.abs(result.record[ROOT + "excitation/intensity"].values)[1:5]
    strongest = np.argsort(-np.where(inside, work, 0.0), axis=1)[:, :5]
    cells = [re.findall(r"([\d.]+)\*? at ([\d.]+)", line) for line in lines[2:6]]
    for mode, found in enumerate(cells):
        places = [i for i in strongest[mode] if inside[mode, i]]
        assert found == [(f"{(i + 1) / 2:g}", f"{speed[mode, i]:.4g}") for i in places]


def test_modes_have_the_names_of_engineers() -> None:
    """Nodes of a row of inertias; numbers of the elastic modes where a line branches."""
    lines = section(render_report(six()), TITLES[2])
    natural = six().record[ROOT + "modes/natural_frequency"].values / (2.0 * math.pi)
    assert row(lines, "1-node")[1:3] == ["2", f"{natural[1]:.4g}"]
    shape = np.asarray(six().record[ROOT + "modes/holzer_angle"].values)
    nodes = np.count_nonzero(np.diff(np.sign(shape), axis=1), axis=1)
    assert list(nodes) == list(range(len(nodes)))
    assert mode_names(six()) == ["rigid", *(f"{n}-node" for n in nodes[1:])]
    assert mode_names(geared())[:3] == ["rigid", "elastic 1", "elastic 2"]


def test_what_nothing_damps_is_unbounded_and_said() -> None:
    worst = np.array(six().record[ROOT + "largest/torque_half_range"].values)
    worst[5] = np.inf
    result = changed(six(), largest__torque_half_range=worst)
    axis = Axis(name="masked", values=np.array([1]))
    for name, value in (("from", 50.0), ("to", 50.1), ("mode", 2), ("half_order", 3.0)):
        result.record.quantities.pop(f"{ROOT}masked/{name}")
        result.record.add(quantity(f"{ROOT}masked/{name}", [value], "rad/s", axis))
    text = render_report(result)
    assert "unbounded" in " ".join(row(section(text, TITLES[5]), "rear"))
    assert "Nothing damps the line at 477.5 to 478.4 rpm (1-node, order 3)" in text
    assert "nothing damps" in conclusion(result)


def test_the_terminal_shows_the_lowest_elastic_mode_and_the_worst_section() -> None:
    rows = {(cells[0], cells[3].split(" at ")[0]): cells for cells in headline_rows(six().record)}
    natural = six().record[ROOT + "modes/natural_frequency"].values / (2.0 * np.pi)
    first = rows["natural frequency, elastic mode", "1st elastic"]
    assert float(first[1]) == pytest.approx(natural[1], rel=1e-3) and first[2] == "Hz"
    assert ("vibratory stress over the speeds, half range", "section rear") in rows
    names = {name for name, _ in rows}
    assert {"stress over that allowed, over the speeds", "heat in a damper at speed, mean"} <= names
