"""The text of a machine with one piston and nothing else."""

SMALL = """\
schema = 1
title = "Größe µ 三"

[machine]
kind = "machine"
speed = "3000 rpm"

[machine.crank_train]
crank_radius = "45 mm"
rod_length = "160 mm"
reciprocating_mass = "0.5 kg"
cylinders = [{ name = "1" }]

[excitation]
"""
