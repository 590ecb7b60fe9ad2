"""Claim: searches and optimisations over keys of an engine find what closed forms say."""

import math
from pathlib import Path

import pytest
from engine_cases import replaced

from vibecalc.core.results.record import Record
from vibecalc.core.study.execute import execute, load_checked

RING = "machine.shaft_line.dampers[0].damping"
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
