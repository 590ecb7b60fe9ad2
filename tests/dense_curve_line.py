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

#: name, inertia, absolute damping, cylinder
STATIONS = (
    ("c1", 0.9, 4.0, "1"),
    ("c2", 0.8, 4.0, "2"),
    ("c3", 0.9, 4.0, "3"),
    ("flywheel", 11.0, 0.0, ""),
    ("pinion", 0.4, 0.0, ""),
    ("wheel", 6.0, 0.0, ""),
    ("propeller", 40.0, 900.0, ""),
    ("take-off", 0.15, 0.0, ""),
    ("generator", 1.3, 2.0, ""),
)
#: name, ends, stiffness, damping, loss factor, section modulus
SHAFTS = (
    ("s1", "c1", "c2", 3.1e6, 150.0, 0.0, 9e-5),
    ("s2", "c2", "c3", 2.9e6, 150.0, 0.0, 9e-5),
    ("s3", "c3", "flywheel", 3.6e6, 120.0, 0.0, 1.2e-4),
    ("rubber", "flywheel", "pinion", 2.4e4, 0.0, 0.17, 0.0),
    ("tail", "wheel", "propeller", 2.1e5, 40.0, 0.0, 1.4e-4),
    ("quill", "take-off", "generator", 3.3e4, 3.0, 0.0, 2e-5),
)
#: of the rigid gear: pinion, wheel and speed of the wheel over that of the pinion
RIGID = ("pinion", "wheel", -20 / 53)
#: of the elastic teeth: first wheel, second one, their radii in m, stiffness in N/m
TEETH = ("pinion", "take-off", 0.12, 0.06, 3e7)
OPERATING, LOW, HIGH, POINTS, HIGHEST = 1200.0, 500.0, 1300.0, 61, 9.0
FIRING = ("1", "3", "2")
RPM = np.pi / 30.0
ROOT = "response/torsion/"
ORDER = np.arange(1, round(2 * HIGHEST) + 1) / 2.0
SPEED = np.linspace(LOW, HIGH, POINTS) * RPM


def text(asked: str, scales: dict[str, float] | None = None) -> str:
    """The case; `asked` stands in [response.torsion]."""
    stations = [
        f'  {{ name = "{name}", inertia = {j}, absolute_damping = {c}'
        + (f', cylinder = "{cylinder}" }},' if cylinder else " },")
        for name, j, c, cylinder in STATIONS
    ]
    shafts = [
        f'  {{ name = "{name}", between = ["{a}", "{b}"], stiffness = {k}, damping = {c}, '
        f"loss_factor = {eta}" + (f", section_modulus = {modulus} }}," if modulus else " },")
        for name, a, b, k, c, eta, modulus in SHAFTS
    ]
    first, second, radius, other, stiffness = TEETH
    scales = scales or {}
    cylinders = [f'{{ name = "{n}", pressure_scale = {scales.get(n, 1.0)} }}' for n in "123"]
    return "\n".join([
        'schema = 1\ntitle = "Three cylinders, a gear and a branch"',
        '[machine]\nkind = "engine"\ncycle = "four_stroke"',
        f'speed = "{OPERATING} rpm"\n[machine.crank_train]\ncrank_radius = "60 mm"',
        'rod_length = "220 mm"\nreciprocating_mass = "3 kg"\nbore = "110 mm"',
        f"cylinders = [{', '.join(cylinders)}]\nfiring_order = {[*FIRING]}",
        'gas_pressure = { crank_angle = ["-360 deg", "-180 deg", "-40 deg", "10 deg", "60 deg", '
        '"130 deg", "360 deg"], pressure = ["0 bar", "0 bar", "12 bar", "80 bar", "15 bar", '
        '"3 bar", "0 bar"] }',
        '[machine.shaft_line]\nbalanced_by = "propeller"\nstations = [', *stations, "]\nshafts = [",
        *shafts, "]\ngears = [", '  { between = ["pinion", "wheel"], teeth = [20, 53] },',
        f'  {{ name = "teeth", between = ["{first}", "{second}"], ratio = {radius / other}, '
        f"mesh_stiffness = {stiffness}, pitch_radius = {radius} }},",
        "]\n[response.torsion]",
        f'speeds = {{ from = "{LOW} rpm", to = "{HIGH} rpm", points = {POINTS} }}',
        f"orders = {{ highest = {HIGHEST} }}", asked, "",
    ])  # fmt: skip


@cache
def run(asked: str, scales: tuple[tuple[str, float], ...] = ()) -> Result:
    """The result of such a case."""
    return ran(text(asked, dict(scales)))


def values(result: Result, path: str) -> Any:
    return np.asarray(result.record[ROOT + path].values)


# ----------------------------------------------------------------------------
# Full matrices.
# ----------------------------------------------------------------------------

AT = {name: place for place, (name, *_) in enumerate(STATIONS)}
#: own speed of each station over that of the crank
RATIO = np.array([1.0] * 5 + [RIGID[2]] * 2 + [-TEETH[2] / TEETH[3]] * 2)
SECTIONS = (*(name for name, *_ in SHAFTS), "teeth")


@cache
def dense() -> DenseLine:
    case = resolve(loaded_of(text("")).case)
    cylinder = cylinder_of(run("").record, case)
    return DenseLine(case, lambda speed: cylinder)


def response(speed: float, scale: dict[str, float] | None = None) -> tuple[Any, Any]:
    """Own angles (stations, orders) and torques (sections, orders) at one speed in rad/s.

    `scale` are factors on the gas pressure of some cylinders.
    """
    found = dense().at(speed, scale)
    return found.angle, found.torque


def half_range(amplitude: np.ndarray) -> float:
    """(highest - lowest) / 2 over the cycle of a signal by half orders (m,)."""
    return float(half_range_of(ORDER, amplitude))
