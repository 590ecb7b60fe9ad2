"""Readings of the body's motion: forces of the mounts on the ground, couple over a lever."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.pitch import Pitch
from vibecalc.isolation.rounding import UNIT_ROUNDOFF


class Readout(NamedTuple):
    """Rows that are read as (spring + i w damper) X, each array (rows, components, coordinates).

    A row of three components is a vector, whose length counts; `doubt` is the relative error of
    the entries.
    """

    spring: np.ndarray
    damper: np.ndarray
    doubt: float


def pitch_readout(
    pitch: Pitch,
    lever: float,
    position: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Readout:
    """Couple over lever in the first row, then the vertical force of each mount on the ground."""
    passing = -position * (stiffness + 1j * structural)
    couple = (pitch.stiffness + 1j * pitch.structural) / lever
    spring = np.concatenate([[couple], passing])
    damper = np.concatenate([[pitch.damping / lever], -position * damping])
    rounding = pitch.rounding + 8.0 * UNIT_ROUNDOFF
    return Readout(spring[:, None, None], damper[:, None, None], rounding)


def join(first: Readout, second: Readout) -> Readout:
    """Rows of both; the one with fewer components is filled up with zeros, which add nothing."""
    width = max(first.spring.shape[1], second.spring.shape[1])

    def filled(block: np.ndarray) -> np.ndarray:
        return np.pad(block, ((0, 0), (0, width - block.shape[1]), (0, 0)))

    return Readout(
        np.concatenate([filled(first.spring), filled(second.spring)]),
        np.concatenate([filled(first.damper), filled(second.damper)]),
        max(first.doubt, second.doubt),
    )


def shows(readout: Readout, shape: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Which modes, `shape` (coordinates, modes), can be seen in which rows: (modes, rows).

    A mode with a node at a mount does not show in it: its reading cancels to rounding.
    """
    rate = np.asarray(frequency)[:, None, None]
    passing = readout.spring + 1j * rate[..., None] * readout.damper
    reading = np.abs((passing @ shape.T[:, None, :, None])[..., 0])
    terms = (np.abs(passing) @ np.abs(shape.T)[:, None, :, None])[..., 0]
    seen: np.ndarray = np.any(reading > 1e3 * UNIT_ROUNDOFF * terms, axis=-1)
    return seen
