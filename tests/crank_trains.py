"""Crank trains and cases for tests, and the piston's motion by a fast Fourier transform."""

import tomllib
from typing import Any

import numpy as np

from vibecalc.schema import Case

AXIS, STROKE, ACROSS = np.eye(3)[0], np.eye(3)[2], np.eye(3)[1]

GENERATOR = """
schema = 1
title = "three cylinders"
[machine]
kind = "generator"
speed = "4900 rpm"
[machine.crank_train]
crank_radius = 0.06
rod_length = 0.2
reciprocating_mass = 0.4
cylinders = [
  { name = "1", position = -0.3, crank_phase = "120 deg" },
  { name = "2", position = 0.0, crank_phase = 0.0 },
  { name = "3", position = 0.3, crank_phase = "240 deg" },
]
[machine.body]
mass = 100.0
box = { length = 0.8, width = 0.5, height = 0.35 }
[machine.mounts]
each = { stiffness = 10000.0, damping = 50.0 }
positions = [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.4, -0.2, 0.0], [0.4, 0.2, 0.0]]
[isolation]
model = "pitch"
"""


def generator(**changes: Any) -> Case:
    """The generator with some keys changed: `machine__body__mass=3.0`; None takes a key out."""
    data = tomllib.loads(GENERATOR)
    for key, value in changes.items():
        *tables, last = key.split("__")
        table = data
        for name in tables:
            table = table.setdefault(name, {})
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return Case.model_validate(data)


def motion(ratio: float, highest: int, offset: float = 0.0, samples: int = 4096) -> np.ndarray:
    """Harmonics C_n of s / R for R / L = ratio and e / R = offset, sampled and transformed."""
    angle = 2 * np.pi * np.arange(samples) / samples
    s = np.cos(angle) + np.sqrt(1 / ratio**2 - (np.sin(angle) - offset) ** 2)
    harmonics = np.fft.rfft(s)[: highest + 1] * 2 / samples
    harmonics[0] /= 2
    return harmonics


def train(
    phases: Any,
    banks: Any = 0.0,
    positions: Any = 0.0,
    masses: Any = 0.4,
    radius: float = 0.06,
    offset: float = 0.0,
    origin: Any = (0.0, 0.0, 0.0),
) -> dict[str, Any]:
    """Arguments of `reciprocating_excitation` for a shaft along x and a stroke along z."""
    phases = np.asarray(phases, dtype=float)
    fill = lambda values: np.broadcast_to(np.asarray(values, dtype=float), phases.shape)  # noqa: E731
    return {
        "crank_radius": radius,
        "wrist_pin_offset": offset,
        "reciprocating_mass": fill(masses),
        "crank_phase": phases,
        "bank_angle": fill(banks),
        "position": fill(positions),
        "origin": np.asarray(origin, dtype=float),
        "axis": AXIS,
        "stroke": STROKE,
        "across": ACROSS,
    }


def turning(
    unbalance: Any,
    ratio: Any,
    phase: Any = 0.0,
    position: Any = (0.0, 0.0, 0.0),
    origin: Any = (0.0, 0.0, 0.0),
    highest: int = 4,
) -> dict[str, Any]:
    """Arguments of `rotating_excitation` in the same frame."""
    unbalance = np.atleast_1d(np.asarray(unbalance, dtype=float))
    return {
        "unbalance": unbalance,
        "speed_ratio": np.broadcast_to(np.asarray(ratio), unbalance.shape),
        "phase": np.broadcast_to(np.asarray(phase, dtype=float), unbalance.shape),
        "position": np.broadcast_to(np.asarray(position, dtype=float), (*unbalance.shape, 3)),
        "origin": np.asarray(origin, dtype=float),
        "stroke": STROKE,
        "across": ACROSS,
        "highest_order": highest,
    }
