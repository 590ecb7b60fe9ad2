"""Readings of the body's motion: forces of the mounts on the ground, couple over a lever."""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.pitch import Pitch
from vibecalc.numerics.rounding import UNIT_ROUNDOFF


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


def distinct(readout: Readout) -> tuple[Readout, np.ndarray]:
    """Leave out rows that repeat another up to sign; also tell which one each row is (rows,).

    Equal supports at the same distance on either side feel the same force at opposite times.
    """
    count = len(readout.spring)
    spring, damper = readout.spring.reshape(count, -1), readout.damper.reshape(count, -1)
    entries = np.concatenate([spring.real, spring.imag, damper], axis=1)
    leading = entries[np.arange(count), np.argmax(entries != 0.0, axis=1)]
    kept: dict[tuple[float, ...], int] = {}
    rows = (entries * np.where(leading < 0.0, -1.0, 1.0)[:, None]).tolist()
    which = np.array([kept.setdefault(tuple(row), len(kept)) for row in rows])
    first = [int(np.argmax(which == number)) for number in range(len(kept))]
    return Readout(readout.spring[first], readout.damper[first], readout.doubt), which


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
