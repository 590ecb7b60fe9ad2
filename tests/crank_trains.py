"""Crank trains and cases for tests, and the piston's motion by a fast Fourier transform."""

import tomllib
from typing import Any

import numpy as np

from vibecalc.core.results.record import Record
from vibecalc.schema import Case

AXIS, STROKE, ACROSS = np.eye(3)[0], np.eye(3)[2], np.eye(3)[1]

GENERATOR = """
schema = 1
title = "three cylinders"
[machine]
kind = "machine"
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


def motion(ratio: float, highest: int) -> np.ndarray:
    """Harmonics C_n of s / R for R / L = ratio, sampled and transformed."""
    angle = 2 * np.pi * np.arange(4096) / 4096
    s = np.cos(angle) + np.sqrt(1 / ratio**2 - np.sin(angle) ** 2)
    harmonics = np.fft.rfft(s)[: highest + 1] * 2 / 4096
    harmonics[0] /= 2
    return harmonics


def train(phases: Any, positions: Any = 0.0) -> dict[str, Any]:
    """Arguments of `reciprocating_excitation` for a shaft along x and a stroke along z."""
    phases = np.asarray(phases, dtype=float)
    return {
        "crank_radius": 0.06,
        "wrist_pin_offset": 0.0,
        "reciprocating_mass": np.full(phases.shape, 0.4),
        "crank_phase": phases,
        "bank_angle": np.zeros(phases.shape),
        "position": np.broadcast_to(np.asarray(positions, dtype=float), phases.shape),
        "origin": np.zeros(3),
        "axis": AXIS,
        "stroke": STROKE,
        "across": ACROSS,
    }


def slopes(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of smooth curves (..., n) over a turn, by their transform."""
    order = np.fft.fftfreq(values.shape[-1], 1.0 / values.shape[-1])
    series = np.fft.fft(values)
    return np.fft.ifft(1j * order * series), np.fft.ifft(-(order**2) * series)


def over_turn(record: Record, angle: np.ndarray, kind: str) -> np.ndarray:
    """Force or couple (3, angles) of the crank train on the body, from its harmonics."""
    quantity = record[f"excitation/{kind}"]
    waves = np.exp(1j * np.multiply.outer(quantity.axes[0].values.astype(float), angle))
    return np.real(quantity.values.T @ waves)
