"""Results of two shaft lines for the tests of the report, run once in a test session."""

import tempfile
from functools import cache
from pathlib import Path

from engine_cases import GEARED

from vibecalc.core.results.record import Result
from vibecalc.core.study.execute import execute, load_checked

ROOT = "response/torsion/"
SIX = """schema = 1
title = "Six cylinders in line, ring on springs in front"
[machine]
kind = "engine"
cycle = "four_stroke"
speed = "700 rpm"
[machine.crank_train]
crank_radius = "120 mm"
rod_length = "480 mm"
reciprocating_mass = "40 kg"
bore = "200 mm"
cylinders = [{ name = "1" }, { name = "2" }, { name = "3" }, { name = "4" }, { name = "5" }, { name = "6" }]
firing_order = ["1", "5", "3", "6", "2", "4"]
gas_interpolation = "cubic"
gas_pressure = { crank_angle = ["-360 deg", "-180 deg", "-60 deg", "0 deg", "10 deg", "60 deg", "120 deg", "180 deg", "360 deg"], pressure = ["0 bar", "0 bar", "5 bar", "70 bar", "90 bar", "15 bar", "5 bar", "1 bar", "0 bar"] }
[machine.shaft_line]
stations = [
  { name = "cyl 1", inertia = "18.64 kg*m^2", cylinder = "1" },
  { name = "cyl 2", inertia = "18.64 kg*m^2", cylinder = "2" },
  { name = "cyl 3", inertia = "18.64 kg*m^2", cylinder = "3" },
  { name = "cyl 4", inertia = "18.64 kg*m^2", cylinder = "4" },
  { name = "cyl 5", inertia = "18.64 kg*m^2", cylinder = "5" },
  { name = "cyl 6", inertia = "18.64 kg*m^2", cylinder = "6" },
  { name = "flywheel", inertia = "2655 kg*m^2" },
]
shafts = [
  { stiffness = "2.282e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
  { stiffness = "2.282e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
  { stiffness = "2.282e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
  { stiffness = "2.282e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
  { stiffness = "2.282e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
  { name = "rear", stiffness = "1.921e7 N*m/rad", diameter = "160 mm", damping = "300 N*m*s/rad" },
]
dampers = [{ name = "front ring", on = "cyl 1", kind = "spring", inertia = "27.5 kg*m^2", stiffness = "5.97e5 N*m/rad", damping = "1500 N*m*s/rad" }]
[response.torsion]
speeds = { from = "300 rpm", to = "1000 rpm", points = 351 }
orders = { highest = 12 }
misfire = ["3"]
[[response.torsion.limits]]
curve = { speed = ["300 rpm", "1000 rpm"], stress = ["50 MPa", "46 MPa"] }
"""  # noqa: E501
RULED = """speeds = { from = "300 rpm", to = "620 rpm", points = 33 }
orders = { highest = 6 }
[[response.torsion.limits]]
rule = "iacs_m68"
sections = ["tail"]
tensile_strength = "700 MPa"
design_factor = 0.55
"""


@cache
def six() -> Result:
    """Six cylinders with a damper in front, a range of speeds, a limit and a misfire."""
    return run(SIX, "engine_six")


@cache
def geared() -> Result:
    """Two cylinders, a propeller behind rigid gears and a generator behind elastic ones."""
    return run(GEARED, "engine_geared")


@cache
def ruled() -> Result:
    """The same over a range of speeds, its propeller shaft held against the rule."""
    shaft = 'between = ["wheel", "propeller"],'
    assert shaft in GEARED
    text = GEARED.replace(shaft, f'{shaft} name = "tail", diameter = "90 mm",')
    text = text.replace('N*m/rad" }', 'N*m/rad", damping = "200 N*m*s/rad" }')
    return run(text + RULED, "engine_ruled")


def run(text: str, name: str) -> Result:
    """The result of a case given as a text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        (loaded,) = load_checked([path])
    return execute(loaded)
