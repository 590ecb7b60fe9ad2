"""Seeded random engines on mounts that drive a machine elsewhere, as case tables."""

import tomllib
from typing import Any

import numpy as np
from engine_mounted import SEPARATE
from random_machines import Table


def random_mounted(seed: int) -> Table:
    """Three cylinders in line that drive a machine elsewhere."""
    draw = np.random.default_rng([seed, 23])
    table: dict[str, Any] = tomllib.loads(SEPARATE)
    machine = table["machine"]
    machine["speed"] = float(draw.uniform(60.0, 300.0))
    train = machine["crank_train"]
    for key in ("piston_mass", "rod"):
        del train[key]
    train |= {"reciprocating_mass": float(draw.uniform(0.5, 3.0)),
              "wrist_pin_offset": float(draw.uniform(-0.006, 0.006)),
              "rod_length": float(draw.uniform(0.16, 0.26))}  # fmt: skip
    if draw.random() < 0.5:
        train["gas_cycle"] = {"kind": "diesel", "compression_ratio": 16.0, "peak_pressure": 9e6}
    for place, one in enumerate(train["cylinders"]):
        one["pressure_scale"] = float(draw.uniform(0.8, 1.1))
        one["position"] = 0.15 * (place - 1.0)
    size = float(np.exp(draw.uniform(-1.0, 2.0)))
    if draw.random() < 0.3:
        each: Table = {"stiffness": [2e5 * size, 2e5 * size, 4e5 * size], "loss_factor": 0.1}
    else:
        each = {"stiffness": [2e5 * size, 3e5 * size, 4e5 * size], "damping": [200.0, 300.0, 400.0]}
    machine["mounts"]["each"] = each
    if draw.random() < 0.5:
        table["excitation"]["orders"] = int(draw.integers(4, 20))
    return table
