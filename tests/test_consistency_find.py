"""Claim: what [[find]] finds in a case is what closed forms and a run with that value say."""

import json
import math
from pathlib import Path
from typing import Any

import pytest
from find_samples import (
    ARMS,
    FORCE,
    FREQUENCY,
    HEAD,
    INERTIA,
    PHASE,
    RADIUS,
    RIGID,
    ROD,
    STIFFNESS,
    row,
    undamped,
)
from fuzzing import command

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record, Result
from vibecalc.core.results.store import read_result
from vibecalc.core.study import binding
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.planned import find_entries
from vibecalc.core.study.sweep.at_once import compute

#: the generator without its run-up
PLAIN = HEAD.split("run_up =")[0] + "\n"


def few(row: str) -> str:
    """A search that first examines five places."""
    return row.replace("[[find]]\n", "[[find]]\npoints = 5\n")


def run(folder: Path, *rows: str, head: str = PLAIN, settings: tuple[str, ...] = ()) -> Result:
    path = folder / "one.toml"
    path.write_text(head + "".join(map(few, rows)), encoding="utf-8")
    return execute(load_checked([path], settings)[0])


def close(record: Record, path: str, exact: float, rtol: float) -> None:
    """Within its error, which is not large."""
    quantity = record[path]
    assert abs(float(quantity.values) - exact) <= quantity.error_estimate + 1e-15 * abs(exact)
    assert quantity.error_estimate <= rtol * abs(exact)


def test_the_stiffness_for_a_frequency_is_a_square_law(tmp_path: Path) -> None:
    wanted = row("ten", STIFFNESS, "1 N/mm", "1 kN/mm", FREQUENCY, 'target = "10 Hz"')
    double = row("double", STIFFNESS, "1 N/mm", "1 kN/mm", FREQUENCY,
                 f"change = {math.sqrt(ARMS * 1e4 / INERTIA)!r}")  # fmt: skip
    record = run(tmp_path, wanted, double).record
    close(record, "find/ten/value", (20.0 * math.pi) ** 2 * INERTIA / ARMS, 1e-12)
    assert record["find/ten/value"].unit == "N/m" and record["find/ten/reached"].unit == "rad/s"
    close(record, "find/ten/reached", 20.0 * math.pi, 1e-12)
    close(record, "find/double/ratio", 4.0, 1e-12)
    assert float(record["find/double/written"].values) == 1e4
    assert not record["find/double/others"].values.size
    # the case itself is what it was
    close(record, FREQUENCY, math.sqrt(ARMS * 1e4 / INERTIA), 1e-12)


def test_keys_that_follow_keep_their_ratio(tmp_path: Path) -> None:
    """At one ratio of rod to crank the inertia force goes with the crank radius."""
    search = row(
        "radius", RADIUS, "2 cm", "20 cm", RIGID, f'scaled_with = ["{ROD}"]', 'target = "5 kN"'
    )
    record = run(tmp_path, search).record
    close(record, "find/radius/ratio", 5000.0 / float(record[RIGID].values), 1e-12)
    value = float(record["find/radius/value"].values)
    alone = run(tmp_path, settings=(f"{RADIUS}={value!r}", f"{ROD}={value / 0.06 * 0.2!r}")).record
    assert float(alone[RIGID].values) == pytest.approx(5000.0, rel=1e-12)
    only = run(tmp_path, search.replace("scaled_with", "# scaled_with")).record
    assert abs(float(only["find/radius/value"].values) - value) > 1e-3


def test_all_solutions_and_the_nearest_first(tmp_path: Path) -> None:
    """The sines of cylinders 1 and 3 cancel: what is left is the sine of the phase of the 2nd."""
    quantity = "excitation/balance/total_sine"
    search = row("phase", PHASE, "-100 deg", "700 deg", quantity, "where = { order = 1 }",
                 "target = 0.5")  # fmt: skip
    record = run(tmp_path, search).record
    close(record, "find/phase/value", math.pi / 6.0, 1e-12)
    others = record["find/phase/others"]
    exact = [5.0 * math.pi / 6.0, 13.0 * math.pi / 6.0, 17.0 * math.pi / 6.0]
    assert others.values == pytest.approx(exact, rel=1e-12)
    assert others.axes[0].name == "solution" and list(others.axes[0].values) == [1, 2, 3]
    assert record["find/phase/others_reached"].values == pytest.approx([0.5] * 3, abs=1e-12)
    assert "find/phase/ratio" not in record  # the phase as written is zero


def test_an_extreme_at_a_known_place(tmp_path: Path) -> None:
    """With the phase of the 2nd cylinder at zero the cosines cancel, and their sum is largest."""
    quantity = "excitation/balance/total_cosine"
    search = row("phase", PHASE, "-1.1 rad", "4 rad", quantity, "where = { order = 1 }",
                 'sense = "max"')  # fmt: skip
    record = run(tmp_path, search, settings=(f"{PHASE}=0.3",)).record
    value = record["find/phase/value"]
    assert abs(float(value.values)) <= value.error_estimate <= 1e-6
    assert abs(float(record["find/phase/reached"].values)) <= 1e-12
    assert "find/phase/wanted" not in record
    low = row("low", PHASE, "-1.1 rad", "4 rad", quantity, "where = { order = 1 }",
              'sense = "min"')  # fmt: skip
    value = run(tmp_path, low).record["find/low/value"]
    assert abs(float(value.values) - math.pi) <= value.error_estimate <= 1e-6


def test_the_ends_of_a_turn_are_one_place(tmp_path: Path) -> None:
    """The sum of sines is that of the phase: half at 30 and 150 degrees, most at 90."""
    quantity, where = "excitation/balance/total_sine", "where = { order = 1 }"
    most = row("most", PHASE, "90 deg", "450 deg", quantity, where, 'sense = "max"')
    half = row("half", PHASE, "30 deg", "390 deg", quantity, where, "target = 0.5")
    record = run(tmp_path, most, half).record
    assert not [text for text in record.warnings if "find" in text]
    value = record["find/most/value"]
    assert abs(float(value.values) - math.pi / 2.0) <= value.error_estimate <= 1e-6
    assert record["find/most/others"].values.size == 0
    found = [float(record["find/half/value"].values), *record["find/half/others"].values]
    assert sorted(found) == pytest.approx([math.pi / 6.0, 5.0 * math.pi / 6.0], rel=1e-12)


def test_a_resonance_between_the_bounds_is_gone_around_and_said(tmp_path: Path) -> None:
    """The middle of the first look is on the resonance of order 1."""
    stiffness = 500.0**2 * INERTIA / ARMS
    search = row("k", STIFFNESS, repr(0.5 * stiffness), repr(1.5 * stiffness), FORCE,
                 'target = "100 kN"')  # fmt: skip
    result = run(tmp_path, search, head=undamped())
    record = result.record
    # below and above, both next to the resonance
    low = float(record["find/k/value"].values)
    (high,) = record["find/k/others"].values
    assert low < stiffness < high
    for value in (low, float(high)):
        peak = run(tmp_path, head=undamped(), settings=(f"{STIFFNESS}={value!r}",)).record[FORCE]
        assert float(peak.values) == pytest.approx(1e5, rel=1e-9)
    (said,) = [text for text in record.warnings if text.startswith("find 'k'")]
    assert "could not be computed" in said and "undamped natural frequency" in said
    assert int(record["find/k/failures"].values) > 0


def test_paths_units_plan_and_file_say_the_same(tmp_path: Path) -> None:
    searches = [
        row("ten", STIFFNESS, "1 N/mm", "1 kN/mm", FREQUENCY, 'target = "10 Hz"'),
        row(
            "radius", RADIUS, "2 cm", "20 cm", RIGID, f'scaled_with = ["{ROD}"]', 'change = "-1 kN"'
        ),
        row("phase", PHASE, "-1 rad", "4 rad", "excitation/balance/total_cosine",
            "where = { order = 1 }", 'sense = "min"'),
    ]  # fmt: skip
    reference = '\n[[reference]]\nquantity = "find/ten/value"\nvalue = "39.2 N/mm"\n'
    reference += 'source = "a page"\n\n[[limit]]\nquantity = "find/radius/ratio"\nmin = 0.5\n'
    path = tmp_path / "one.toml"
    path.write_text(PLAIN + "".join(map(few, searches)) + reference, encoding="utf-8")
    done = command("run", str(path), "-o", str(tmp_path / "one.h5"), "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)[0]["quantities"]["find/ten/written"]["value"] == 1e4
    result = read_result(tmp_path / "one.h5")
    entries = find_entries(load_checked([path])[0].case)
    own = [name for name in result.record if name.startswith("find/")]
    assert set(own) == set(entries)
    for name in own:
        quantity = result.record[name]
        assert quantity.unit == entries[name].unit
        assert tuple(axis.name for axis in quantity.axes) == entries[name].axes
        assert quantity.amplitude == entries[name].amplitude
    assert max(map(len, render_report(result, full=True).splitlines())) <= 100
    plan = command("check", str(path)).out
    assert "5 + 5 + 5 runs" in plan and "find/phase: value, reached, written" in plan


def test_the_machine_found_stands_nearby_the_one_written(tmp_path: Path) -> None:
    search = row("ten", STIFFNESS, "1 N/mm", "1 kN/mm", FREQUENCY, 'target = "10 Hz"')
    record = run(tmp_path, search).record
    found = float(record["find/ten/value"].values)
    plain = execute(load_checked([tmp_path / "one.toml"], [f"{STIFFNESS}={found!r}"])[0]).record
    machine = "find/ten/machine/"
    paths = [path for path in record if path.startswith(machine)]
    assert f"{machine}isolation/pitch/stiffness" in paths
    for path in paths:
        expected = plain[path.removeprefix(machine)]
        assert record[path].unit == expected.unit
        assert float(record[path].values) == pytest.approx(float(expected.values), rel=1e-12)


def test_a_result_without_bound_stays_without_bound_at_the_machine_found(tmp_path: Path) -> None:
    head = """schema = 1
title = "an absorber on a mass without damping, whose own peak is infinite"
[machine]
kind = "absorber"
primary = { mass = "40 kg", linear_stiffness = "50 N/mm" }
secondary = { mass = "4 kg" }
[tuning]
"""
    search = row("peak", "machine.secondary.mass", "3 kg", "5 kg", "tuning/peak", "target = 4.5")
    record = run(tmp_path, search, head=head).record
    ratio = float(record["find/peak/value"].values) / 40.0
    close(record, "find/peak/machine/tuning/mass_ratio", ratio, 1e-9)
    alone = record["find/peak/machine/tuning/peak_alone"]
    assert float(alone.values) == math.inf and math.isfinite(alone.error_estimate)


def test_a_sweep_does_not_search(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    search = row("none", STIFFNESS, "1 N/mm", "2 N/mm", FREQUENCY, 'target = "10 Hz"')
    path.write_text(PLAIN + few(search), encoding="utf-8")
    grid = ("--grid", f"{STIFFNESS}=5000,6000", "--keep", FREQUENCY, "-q")
    with_search = command("sweep", str(path), *grid, "-o", str(tmp_path / "a.h5"))
    assert with_search.code == 0, with_search.err
    assert command("run", str(path), "-q", "-o", str(tmp_path / "b.h5")).code == 3


def test_searches_for_one_result_are_computed_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = []

    def counted(case: object, varied: object, count: int, *more: Any) -> Any:
        counts.append(count)
        return compute(case, varied, count, *more)

    monkeypatch.setattr(binding, "compute", counted)
    along = [
        row(name, key, lower, upper, RIGID, 'change = "-20 N"')
        for name, key, lower, upper in (
            ("radius", RADIUS, "40 mm", "60 mm"),
            ("rod", ROD, "150 mm", "3 m"),
        )
    ]
    both, rounds = run(tmp_path, *along).record, len(counts)
    apart = 0
    for one, name in zip(along, ("radius", "rod"), strict=True):
        counts.clear()
        alone = run(tmp_path, one).record[f"find/{name}/value"]
        apart += len(counts)
        value = both[alone.path]
        assert abs(value - alone) <= value.error_estimate + alone.error_estimate
    assert 0 < rounds < 0.7 * apart
