"""A geared line with a branch as a case, and its response by the full matrices of `dense_line.py`.

Of the package only the harmonics of one cylinder are used, as reported at the operating speed.
"""

from functools import cache
from typing import Any

import numpy as np
from dense_line import DenseLine, cylinder_of
from dense_line import half_range as half_range_of
from engine_cases import loaded_of, ran

from vibecalc.core.case.load import resolve
from vibecalc.core.results.record import Result

#: rad/s; half orders
RPM = np.pi / 30.0
OPERATING, LOW, HIGH = 1200.0 * RPM, 500.0 * RPM, 1300.0 * RPM
SPEED, ORDER = np.linspace(LOW, HIGH, 61), np.arange(1, 19) / 2.0
ROOT = "response/torsion/"
TEXT = """schema = 1
title = "Three cylinders, a gear and a branch"
[machine]
kind = "engine"
cycle = "four_stroke"
speed = "1200.0 rpm"
[machine.crank_train]
crank_radius = "60 mm"
rod_length = "220 mm"
reciprocating_mass = "3 kg"
bore = "110 mm"
cylinders = [{ name = "1" }, { name = "2" }, { name = "3" }]
firing_order = ["1", "3", "2"]
[machine.crank_train.gas_pressure]
crank_angle = ["-360 deg", "-180 deg", "-40 deg", "10 deg", "60 deg", "130 deg", "360 deg"]
pressure = ["0 bar", "0 bar", "12 bar", "80 bar", "15 bar", "3 bar", "0 bar"]
[machine.shaft_line]
balanced_by = "propeller"
stations = [
  { name = "c1", inertia = 0.9, absolute_damping = 4.0, cylinder = "1" },
  { name = "c2", inertia = 0.8, absolute_damping = 4.0, cylinder = "2" },
  { name = "c3", inertia = 0.9, absolute_damping = 4.0, cylinder = "3" },
  { name = "flywheel", inertia = 11.0 },
  { name = "pinion", inertia = 0.4 },
  { name = "wheel", inertia = 6.0 },
  { name = "propeller", inertia = 40.0, absolute_damping = 900.0 },
  { name = "take-off", inertia = 0.15 },
  { name = "generator", inertia = 1.3, absolute_damping = 2.0 },
]
shafts = [
  { name = "s1", between = ["c1", "c2"], stiffness = 3.1e6, damping = 150.0, section_modulus = 9e-5 },
  { name = "s2", between = ["c2", "c3"], stiffness = 2.9e6, damping = 150.0, section_modulus = 9e-5 },
  { name = "s3", between = ["c3", "flywheel"], stiffness = 3.6e6, damping = 120.0, section_modulus = 1.2e-4 },
  { name = "rubber", between = ["flywheel", "pinion"], stiffness = 2.4e4, loss_factor = 0.17 },
  { name = "tail", between = ["wheel", "propeller"], stiffness = 2.1e5, damping = 40.0, section_modulus = 1.4e-4 },
  { name = "quill", between = ["take-off", "generator"], stiffness = 3.3e4, damping = 3.0, section_modulus = 2e-5 },
]
gears = [
  { between = ["pinion", "wheel"], teeth = [20, 53] },
  { name = "teeth", between = ["pinion", "take-off"], ratio = 2.0, mesh_stiffness = 3e7, pitch_radius = 0.12 },
]
[response.torsion]
speeds = { from = "500.0 rpm", to = "1300.0 rpm", points = 61 }
orders = { highest = 9.0 }
"""  # noqa: E501


def text(asked: str) -> str:
    """The case; `asked` stands in [response.torsion]."""
    return f"{TEXT}{asked}\n"


def run(asked: str) -> Result:
    """The result of such a case."""
    return ran(text(asked))


def values(result: Result, path: str) -> Any:
    return np.asarray(result.record[ROOT + path].values)


# ----------------------------------------------------------------------------
# Full matrices.
# ----------------------------------------------------------------------------


@cache
def dense() -> DenseLine:
    case = resolve(loaded_of(text("")).case)
    cylinder = cylinder_of(run("").record, case)
    return DenseLine(case, lambda speed: cylinder)


def ratio(name: str) -> float:
    """Own speed of a station over that of the crank."""
    return float(dense().ratio[dense().names.index(name)])


def response(speed: float, scale: dict[str, float] | None = None) -> tuple[dict[str, Any], Any]:
    """Own angles (orders,) by station and torques (sections, orders) at one speed in rad/s.

    `scale` are factors on the gas pressure of some cylinders.
    """
    found = dense().at(speed, scale)
    return dict(zip(dense().names, found.angle, strict=True)), found.torque


def half_range(amplitude: np.ndarray) -> float:
    """(highest - lowest) / 2 over the cycle of a signal by half orders (m,)."""
    return float(half_range_of(ORDER, amplitude))
