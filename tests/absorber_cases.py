"""Cases of absorbers, as texts to be changed."""

from pathlib import Path

import refused

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber

RATIOS = """schema = 1
title = "ratios"
[machine]
kind = "absorber"
[machine.primary]
damping_ratio = 0.02
[machine.secondary]
mass_ratio = 0.1
stiffness_ratio = 0.08
damping_over_primary_critical = 0.015
[response.absorber]
frequency_ratios = { from = 0.5, to = 1.5 }
"""
TUNED = """schema = 1
title = "tuned"
[machine]
kind = "absorber"
[machine.primary]
damping_ratio = 0.02
[machine.secondary]
mass_ratio = 0.1
[tuning]
compare = ["den_hartog"]
"""
FLOOR = """schema = 1
title = "in kg, Hz and N"
[machine]
kind = "absorber"
[machine.primary]
mass = "500 kg"
natural_frequency = "8 Hz"
[machine.secondary]
mass = "25 kg"
[tuning]
band = { from = "7 Hz", to = "9 Hz" }
[response.absorber]
force = "200 N"
"""
RIG = """schema = 1
title = "rig as built"
[machine]
kind = "absorber"
[machine.primary]
damping_ratio = 0.01
inertia = "0.42 kg*m^2"
[machine.secondary]
inertia = "0.08 kg*m^2"
[machine.rod]
length = "1.5 m"
diameter = "24 mm"
shear_modulus = "80 GPa"
total_length = "1.65 m"
span = "1.5 m"
elastic_modulus = "205 GPa"
density = "7850 kg/m^3"
[machine.flywheel]
mass = "22 kg"
diametral_inertia = "0.2 kg*m^2"
[machine.springs]
count = 4
radius = "130 mm"
angle = "15 deg"
wire_diameter = "2 mm"
coil_diameter = "16 mm"
turns = 12
shear_modulus = "80 GPa"
[machine.gap]
outer_radius = "140 mm"
inner_radius = "70 mm"
width = "18 mm"
clearance = "0.6 mm"
temperature = "40 degC"
[machine.oil]
viscosities = ["460 cSt", "31 cSt"]
density = "902 kg/m^3"
[[machine.stock_springs]]
name = "soft"
rate = "2 N/mm"
[[machine.stock_oils]]
name = "thin"
viscosities = ["100 cSt", "11.4 cSt"]
density = "881 kg/m^3"
"""
SEVERAL = """schema = 1
title = "two absorbers"
[machine]
kind = "absorber"
[machine.primary]
damping_ratio = 0.02
[[machine.secondaries]]
name = "near"
mass_ratio = 0.05
[[machine.secondaries]]
name = "far"
on = "near"
mass_ratio = 0.03
[tuning]
norm = "h_infinity"
"""
PENDULUM = """schema = 1
title = "pendulums"
[machine]
kind = "absorber"
[machine.pendulum]
order = 2
mass = "0.9 kg"
count = 4
vertex_distance = "95 mm"
path_radius = "19 mm"
path = "cycloidal"
rotor_inertia = "0.35 kg*m^2"
speed = "1800 rpm"
swings = { to = "60 deg" }
"""


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    """The text with pieces changed; each piece has to be there once."""
    for old, new in pairs:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    return text


def refusal(folder: Path, text: str, **files: str) -> str:
    """What `check` says of a case that it refuses, "" if it takes it."""
    return refused.refusal(folder, "absorber", text, **files)


def peaks_of(primary_damping: float, mass_ratio: float):
    """Largest response or travel of springs and dampers (they broadcast), as a stock is read."""

    def read(k, z, what):
        what = "relative_displacement" if what == "travel" else what
        top = peaks(Absorber(primary_damping, mass_ratio, k, z), "force", what)
        return top.largest, top.largest_error

    return read
