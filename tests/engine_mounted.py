"""Engines on mounts, as texts: three cylinders in line, with and without a shaft line."""

from functools import cache

from engine_cases import loaded_of, replaced

from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

#: the driven machine stands elsewhere; the first to fire is not the one at its top at crank angle 0
SEPARATE = """schema = 1
title = "three in line on four mounts"
[machine]
kind = "engine"
cycle = "four_stroke"
speed = "1500 rpm"
[machine.crank_train]
crank_radius = "60 mm"
rod_length = "200 mm"
piston_mass = "1.7 kg"
wrist_pin_offset = "4 mm"
rod = { mass = "1 kg", inertia = "0.01 kg*m^2", crank_pin_to_mass_centre = "60 mm" }
bore = "100 mm"
gas_cycle = { kind = "spark", peak_pressure = "60 bar" }
cylinders = [
  { name = "1", position = "-150 mm", crank_phase = "50 deg", bank_angle = "20 deg" },
  { name = "2", crank_phase = "170 deg", bank_angle = "20 deg", pressure_scale = 1.1 },
  { name = "3", position = "150 mm", crank_phase = "290 deg", bank_angle = "20 deg" },
]
firing_order = ["2", "3", "1"]
[machine.body]
mass = "300 kg"
inertia = ["12 kg*m^2", "25 kg*m^2", "22 kg*m^2"]
inertia_products = ["1 kg*m^2", "0 kg*m^2", "0 kg*m^2"]
[machine.mounts]
each = { stiffness = [2e5, 2e5, 4e5], damping = [200.0, 200.0, 400.0] }
positions = [
  ["-0.4 m", "-0.3 m", "-0.2 m"],
  ["-0.4 m", "0.3 m", "-0.2 m"],
  ["0.5 m", "-0.3 m", "-0.2 m"],
  ["0.5 m", "0.25 m", "-0.2 m"],
]
[excitation]
driven_machine = "separate"
[isolation]
model = "rigid_body"
"""

LINE = """[machine.shaft_line]
stations = [
  { name = "a", inertia = "0.05 kg*m^2", cylinder = "1", absolute_damping = "6 N*m*s/rad" },
  { name = "b", inertia = "0.05 kg*m^2", cylinder = "2", absolute_damping = "2 N*m*s/rad" },
  { name = "c", inertia = "0.05 kg*m^2", cylinder = "3", absolute_damping = "2 N*m*s/rad" },
  { name = "flywheel", inertia = "1 kg*m^2" },
  { name = "generator", inertia = "0.6 kg*m^2", absolute_damping = "40 N*m*s/rad" },
]
shafts = [
  { stiffness = "1e6 N*m/rad" },
  { stiffness = "1e6 N*m/rad" },
  { stiffness = "2e6 N*m/rad" },
  { stiffness = "2e4 N*m/rad", loss_factor = 0.1 },
]
[[machine.shaft_line.dampers]]
name = "ring"
on = "a"
kind = "viscous"
inertia = "0.1 kg*m^2"
damping = "30 N*m*s/rad"
[machine.body]"""

#: all of it on the body, one cylinder without combustion
ON_BODY = replaced(
    SEPARATE,
    ("[machine.body]", LINE),
    ('driven_machine = "separate"\n', "orders = 12\n"),
    ("[isolation]", '[response.torsion]\nmisfire = ["3"]\nmisfire_kind = "motored"\n[isolation]'),
)

#: the flywheel's like turns the other way round, on teeth: no angular momentum at all
COUNTER = replaced(
    SEPARATE,
    (
        "[machine.body]",
        """[machine.shaft_line]
stations = [
  { name = "throws", inertia = "0.7 kg*m^2", cylinders = ["1", "2", "3"] },
  { name = "other", inertia = "0.7 kg*m^2" },
]
gears = [{ between = ["throws", "other"], ratio = 1.0 }]
[machine.body]""",
    ),
    ('driven_machine = "separate"', "orders = 6"),
)


def mounted(text: str) -> Case:
    """The case itself."""
    return loaded_of(text).case


@cache
def wanted_of(text: str, *paths: str) -> Record:
    """The results of the supports and of the torque, and `paths`, of a case's text."""
    from vibecalc.core.run.plan import planned_quantities

    case = mounted(text)
    starts = ("isolation/torque_reaction/", "isolation/support_force/")
    reaction = [p for p in planned_quantities(case) if p.startswith(starts) and "run_up" not in p]
    return run_case(case, wanted=frozenset([*reaction, *paths]))
