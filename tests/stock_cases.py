"""A block on four mounts with two masses on its crank, and what a search picks for it."""

BASE = """
schema = 1
title = "a block on mounts of a stock"
[machine]
kind = "machine"
speed = "1500 rpm"
[machine.crank_train]
crank_radius = "50 mm"
rod_length = "180 mm"
reciprocating_mass = "1 kg"
cylinders = [
  { name = "1", position = "-200 mm", crank_phase = "0 deg" },
  { name = "2", position = "200 mm", crank_phase = "180 deg" },
]
[machine.body]
mass = "120 kg"
box = { length = "0.8 m", width = "0.5 m", height = "0.5 m" }
[machine.mounts]
each = { stiffness = "100 kN/m", damping = "100 N*s/m" }
positions = [
  ["-0.4 m", "-0.2 m", 0.0],
  ["-0.4 m", "0.2 m", 0.0],
  ["0.4 m", "-0.2 m", 0.0],
  ["0.4 m", "0.2 m", 0.0],
]
[excitation]
driven_machine = "cancels_torque"
[isolation]
model = "pitch"
"""
#: mounts at -x and x, all at the same distance
DISTANCE = """{ key = "machine.mounts.positions[2][0]", min = "0.2 m", max = "0.6 m", \
  followed_by = [
  { key = "machine.mounts.positions[3][0]" },
  { key = "machine.mounts.positions[0][0]", factor = -1 },
  { key = "machine.mounts.positions[1][0]", factor = -1 } ] }"""
PICKED = """
[optimisation]
objective = { quantity = "isolation/support_force/steady_peak" }
starts = 1
variables = [
  { key = "machine.body.mass", choices = ["110 kg", "120 kg", "150 kg"] },
  { key = "machine.mounts.each.damping", choices = ["80 N*s/m", "150 N*s/m"] },
]
[[optimisation.stock]]
name = "mount"
table = "machine.mounts.each"
items = [
  { name = "soft", values = { stiffness = "60 kN/m" } },
  { name = "middle", values = { stiffness = "90 kN/m" } },
  { name = "hard", values = { stiffness = "140 kN/m" } },
]
[[limit]]
quantity = "isolation/support_displacement/static"
max = "4 mm"
"""
ROBUST = """
[optimisation]
objective = { quantity = "QUANTITY" }
starts = 1
variables = [ { key = "machine.mounts.each.stiffness", min = "50 kN/m", max = "500 kN/m" } ]
[optimisation.robust]
tolerances = [ TOLERANCES ]
"""
