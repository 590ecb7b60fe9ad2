"""Claim: sweeps, searches and optimisations over keys of an engine give what single runs give."""

import math
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from engine_cases import ENGINE, replaced
from fuzzing import command

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.sweep_file import open_sweep
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.sweep import prepare as strategy

RING = "machine.shaft_line.dampers[0].damping"
KEEP = (
    "response/torsion/torque_half_range",
    "response/torsion/modes/natural_frequency",
    "response/torsion/largest/torque_half_range",
    "response/torsion/as_published/largest_twist",
    "response/torsion/transient/peak",
)
#: three in line with a ring on springs, each stage that a short line can have
SHORT = replaced(
    ENGINE,
    ('kind = "viscous"', 'kind = "spring", stiffness = "2 kN*m/rad"'),
    ('to = "2000 rpm" }', 'to = "2000 rpm", points = 5 }'),
    ("highest = 6", "highest = 3"),
) + (
    "as_published = {}\n"
    'transient = { kind = "load_step", on = "flywheel", torque = "9 N*m", time_after = "0.05 s" }\n'
)

#: a crank and a viscous ring, nothing else; a two-stroke engine's first order, and no other
ONE = """schema = 1
title = "one cylinder and a ring"
[machine]
kind = "engine"
cycle = "two_stroke"
speed = "100 rad/s"
[machine.crank_train]
crank_radius = "60 mm"
rod_length = "200 mm"
reciprocating_mass = "2 kg"
bore = "100 mm"
cylinders = [{ name = "1" }]
gas_pressure = { crank_angle = ["0 deg", "90 deg", "360 deg"], pressure = ["60 bar", "0 bar", "60 bar"] }
[machine.shaft_line]
stations = [
  { name = "crank", inertia = "0.1 kg*m^2", cylinder = "1" },
  { name = "flywheel", inertia = "2 kg*m^2" },
]
shafts = [{ name = "shaft", stiffness = "1e6 N*m/rad" }]
[response.torsion]
orders = { count = 1 }
"""  # noqa: E501
RINGED = ONE.replace(
    "[response.torsion]",
    'dampers = [{ name = "ring", on = "crank", kind = "viscous", inertia = "0.05 kg*m^2", '
    'damping = "30 N*m*s/rad" }]\n[response.torsion]',
)


def run(folder: Path, text: str) -> Record:
    path = folder / "one.toml"
    path.write_text(text, encoding="utf-8")
    return execute(load_checked([path])[0]).record


@cache
def alone(damping: float) -> Record:
    data: dict[str, Any] = tomllib.loads(SHORT)
    data["machine"]["shaft_line"]["dampers"][0]["damping"] = damping
    return run_case(validate(data), wanted=frozenset(KEEP))


@pytest.mark.long
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_sweep_over_a_damper_is_its_single_runs(
    jobs: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(strategy, "_SHORT", 0.0)  # two processes, although it is short
    monkeypatch.chdir(tmp_path)
    Path("line.toml").write_text(SHORT, encoding="utf-8")
    kept = [word for path in KEEP for word in ("--keep", path)]
    grid = ("--grid", f"{RING}=20 N*m*s/rad,30 N*m*s/rad,60 N*m*s/rad")
    outcome = command("sweep", "line.toml", *grid, *kept, "-j", jobs, "-o", "line.h5")
    assert outcome.code == 0, outcome.err
    with open_sweep("line.h5") as found:
        for path in KEEP:
            values = found.read(path)
            for row, damping in enumerate((20.0, 30.0, 60.0)):
                assert np.array_equal(values[row], alone(damping)[path].values), path


def test_find_a_shaft_for_a_frequency(tmp_path: Path) -> None:
    search = """
[[find]]
name = "shaft"
key = "machine.shaft_line.shafts[0].stiffness"
min = "1e4 N*m/rad"
max = "1e7 N*m/rad"
quantity = "response/torsion/modes/natural_frequency"
where = { mode = 2 }
target = "100 Hz"
points = 5
"""
    found = run(tmp_path, ONE + search)["find/shaft/value"]
    exact = (200.0 * math.pi) ** 2 * 0.1 * 2.0 / 2.1
    assert abs(float(found.values) - exact) <= found.error_estimate <= 1e-9 * exact


@pytest.mark.long
def test_the_damping_that_takes_the_most_heat(tmp_path: Path) -> None:
    """A slip v between ring and crank is T / (c + Z), Z the impedance of both in series.

    T is what the dashpot would carry, were it rigid, times a share that c does not change; half of
    c |v|^2 is largest at c = |Z|, as Z is imaginary without any other damping.
    """
    search = f"""
[optimisation]
variables = [{{ key = "{RING}", min = "0.5 N*m*s/rad", max = "50 N*m*s/rad" }}]
objective = {{ quantity = "response/torsion/damper/heat", where = {{ damper = "ring" }}, sense = "max" }}
starts = 1
"""  # noqa: E501
    record = run(tmp_path, RINGED + search)
    w, k = 100.0, 1e6
    rest = -0.1 * w**2 + k - k * k / (k - 2.0 * w**2)  # dynamic stiffness at the crank
    ring = -0.05 * w**2
    best = abs(1.0 / (w / ring + w / rest))
    found = record[f"optimisation/variable/{RING}"]
    assert abs(float(found.values) - best) <= found.error_estimate + 1e-12 * best
    assert found.error_estimate < 1e-4 * best
    text = replaced(RINGED, ("30 N*m*s/rad", f"{best!r} N*m*s/rad"))
    heat = run(tmp_path, text)["response/torsion/damper/heat"].values[0]
    assert float(record["optimisation/objective"].values) == pytest.approx(heat, rel=1e-9)
