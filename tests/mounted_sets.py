"""A set of engine, generator and skid on mounts, for tests."""

import tomllib
from typing import Any

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case

SET = """schema = 1
title = "set"

[machine]
kind = "machine"
speed = "1500 rpm"

[machine.crank_train]
crank_radius = "60 mm"
rod_length = "200 mm"
reciprocating_mass = "1.4 kg"
origin = [0.5, 0.0, 0.45]
cylinders = [
  { name = "1", position = -0.06 },
  { name = "2", position = 0.06, crank_phase = "180 deg" },
]

[[machine.body.parts]]
name = "engine"
mass = 320
centre = [0.5, 0.0, 0.55]
box = { length = 0.7, width = 0.5, height = 0.7 }

[[machine.body.parts]]
name = "generator"
mass = 240
centre = [1.25, 0.01, 0.45]
inertia = [9, 14, 13]
inertia_products = [0.1, 0.5, -0.2]

[[machine.body.parts]]
name = "skid"
mass = 150
centre = [0.9, 0.0, 0.1]
box = { length = 1.9, width = 0.8, height = 0.2 }

[machine.mounts]
each = { stiffness = ["200 N/mm", "200 N/mm", "400 N/mm"], loss_factor = 0.1 }
positions = [[0.1, -0.35, 0.0], [0.1, 0.35, 0.0], [1.7, -0.35, 0.0], [1.7, 0.35, 0.0]]

[excitation]
driven_machine = "cancels_torque"
orders = 6

[isolation]
model = "rigid_body"
"""


def tables(text: str = SET) -> dict[str, Any]:
    """The tables of a case."""
    return tomllib.loads(text)


def ran(data: dict[str, Any]) -> Record:
    """What a run of a case records."""
    return run_case(validate(data))
