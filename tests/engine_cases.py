"""Cases of engines on shaft lines, as texts to be changed and run."""

import tomllib
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import refused

from vibecalc.core.case.load import LoadedCase, validate
from vibecalc.core.results.record import Record, Result
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked

ROOT = "response/torsion"

ENGINE = """schema = 1
title = "three in line"
[machine]
kind = "engine"
cycle = "four_stroke"
speed = "1500 rpm"
[machine.crank_train]
crank_radius = "60 mm"
rod_length = "200 mm"
reciprocating_mass = "2 kg"
bore = "100 mm"
cylinders = [{ name = "1" }, { name = "2" }, { name = "3" }]
firing_order = ["1", "3", "2"]
gas_pressure = { crank_angle = ["0 deg", "90 deg", "720 deg"], pressure = ["60 bar", "0 bar", "60 bar"] }
[machine.shaft_line]
stations = [
  { name = "a", inertia = "0.1 kg*m^2", cylinder = "1" },
  { name = "b", inertia = "0.1 kg*m^2", cylinder = "2" },
  { name = "c", inertia = "0.1 kg*m^2", cylinder = "3" },
  { name = "flywheel", inertia = "2 kg*m^2" },
]
shafts = [
  { stiffness = "1e6 N*m/rad", diameter = "70 mm" },
  { stiffness = "1e6 N*m/rad" },
  { name = "rear", stiffness = "2e6 N*m/rad", damping = "5 N*m*s/rad" },
]
dampers = [{ name = "ring", on = "a", kind = "viscous", inertia = "0.2 kg*m^2", damping = "30 N*m*s/rad" }]
[response.torsion]
speeds = { from = "800 rpm", to = "2000 rpm" }
orders = { highest = 6 }
"""  # noqa: E501

#: an engine, a reduction gear, a propeller and a generator on its own pinion
GEARED = """schema = 1
title = "two in line on a gear"
[machine]
kind = "engine"
cycle = "two_stroke"
speed = "600 rpm"
[machine.crank_train]
crank_radius = "60 mm"
rod_length = "200 mm"
reciprocating_mass = "2 kg"
bore = "100 mm"
cylinders = [{ name = "1" }, { name = "2", crank_phase = "180 deg" }]
gas_pressure = { crank_angle = ["0 deg", "90 deg", "360 deg"], pressure = ["60 bar", "0 bar", "60 bar"] }
[machine.shaft_line]
stations = [
  { name = "a", inertia = "0.1 kg*m^2", cylinder = "1" },
  { name = "b", inertia = "0.1 kg*m^2", cylinder = "2" },
  { name = "pinion", inertia = "0.05 kg*m^2" },
  { name = "wheel", inertia = "3 kg*m^2" },
  { name = "propeller", inertia = "9 kg*m^2" },
  { name = "take-off", inertia = "0.02 kg*m^2" },
  { name = "generator", inertia = "0.4 kg*m^2" },
]
shafts = [
  { between = ["a", "b"], stiffness = "1e6 N*m/rad" },
  { between = ["b", "pinion"], stiffness = "4e5 N*m/rad" },
  { between = ["wheel", "propeller"], stiffness = "2e5 N*m/rad" },
  { between = ["take-off", "generator"], stiffness = "3e4 N*m/rad" },
]
gears = [
  { between = ["pinion", "wheel"], teeth = [20, 60] },
  { between = ["wheel", "take-off"], ratio = 4.0, mesh_stiffness = "1e8 N/m", pitch_radius = "0.3 m" },
]
balanced_by = "propeller"
[response.torsion]
"""  # noqa: E501


CARD = next(line for line in ENGINE.splitlines() if line.startswith("gas_pressure"))
DESIGN = '[damper_design]\non = "a"\ninertia = "0.3 kg*m^2"\n'


def cards(low: str, high: str) -> str:
    """The card of `ENGINE` at two speeds."""
    card = CARD.partition(" = ")[2]
    listed = ", ".join(f'{{ speed = "{one}", gas_pressure = {card} }}' for one in (low, high))
    return f"gas_cards = [{listed}]"


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    """The text with each first of a pair, which it has to hold, replaced by the second."""
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


#: the engine with a generator behind an elastic coupling of known loss factor
GENSET = replaced(
    ENGINE,
    ('speeds = { from = "800 rpm", to = "2000 rpm" }\n', ""),
    (
        '  { name = "flywheel", inertia = "2 kg*m^2" },\n',
        '  { name = "flywheel", inertia = "2 kg*m^2" },\n'
        '  { name = "generator", inertia = "1 kg*m^2" },\n',
    ),
    (
        'damping = "5 N*m*s/rad" },\n]',
        'damping = "5 N*m*s/rad" },\n  { name = "coupling", stiffness = "2e4 N*m/rad", '
        'loss_factor = 0.1, diameter = "80 mm", fatigue = { stress = "12 MPa", slope = 6 } },\n]',
    ),
)


#: a throw for the rule for crankshafts
CRANK = (
    'crank = { pin_diameter = "70 mm", journal_diameter = "80 mm", web_thickness = "25 mm", '
    'web_width = "110 mm", pin_fillet = "4 mm", journal_fillet = "4 mm" }'
)


@cache
def loaded_of(text: str) -> LoadedCase:
    """The case of a text, checked."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "engine.toml"
        path.write_text(text, encoding="utf-8")
        (loaded,) = load_checked([path])
    return loaded


@cache
def ran(text: str) -> Result:
    """The finished run of a text."""
    return execute(loaded_of(text))


@cache
def record(text: str) -> Record:
    """All that a run of a text computes, without its studies."""
    return run_case(validate(tomllib.loads(text)))


def value(text: str, path: str) -> np.ndarray:
    """A result of the shaft line."""
    return np.asarray(record(text)[f"{ROOT}/{path}"].values)


def at_speed(text: str, speed: float) -> str:
    """The case at one speed in rad/s, without a range."""
    lines = [one for one in text.splitlines() if not one.startswith("speeds")]
    return "\n".join(f"speed = {speed!r}" if one.startswith("speed ") else one for one in lines)


def refusal(folder: Path, text: str, **files: str) -> str:
    """What `check` says of a case that it refuses, "" if it takes it."""
    return refused.refusal(folder, "engine", text, **files)
