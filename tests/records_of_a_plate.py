"""Records of a plate with a tachometer that may be uneven, late or coarse."""

from typing import NamedTuple

import numpy as np

TURN = 2.0 * np.pi
#: translation, roll and pitch of orders 1 to 4, complex against the mark of the shaft
TRUTH = np.array(
    [
        [0.31 * np.exp(0.7j), 1.4 * np.exp(-2j), 0.12 * np.exp(1j), 0.6 * np.exp(2.6j)],
        [1.9 * np.exp(-1.1j), 5.2 * np.exp(0.4j), 0.3 * np.exp(2j), 1.2 * np.exp(-2.9j)],
        [0.8 * np.exp(2.2j), 2.1 * np.exp(1j), 0.5 * np.exp(-0.3j), 0.9 * np.exp(0.1j)],
    ]
)
ORDERS = np.arange(1.0, 5.0)


class Plate(NamedTuple):
    """Times (n,), translation, roll and pitch (3, n), tachometer (n,), its mark in rad."""

    times: np.ndarray
    motion: np.ndarray
    tachometer: np.ndarray
    mark: float


def plate(
    draw: np.random.Generator, *, rate: float = 2000.0, length: float = 4.0,
    speed: tuple[float, float] = (24.3, 24.9), pulses: int = 4, smooth: bool = False,
    jitter: float = 0.0, noise: float = 0.02, pattern: tuple[float, ...] = (),
    torsion: float = 0.0,
) -> Plate:  # fmt: skip
    """From one speed to another, in turns per second; angles of the tachometer in rad."""
    times = np.arange(int(length * rate)) / rate
    first, last = speed
    steady = TURN * (first * times + (last - first) * times**2 / (2.0 * length))
    angle = steady + torsion * np.sin(2.0 * steady + 0.3)
    motion = np.real(TRUTH @ np.exp(1j * np.outer(ORDERS, angle)))
    motion = motion + noise * draw.standard_normal(motion.shape)
    step, mark = TURN / pulses, float(draw.uniform(0.0, TURN / pulses))
    if smooth:
        return Plate(times, motion, np.sin(pulses * (angle - mark)), mark)
    number = np.arange(-2, int(angle[-1] / step) + 3)
    late = np.array(pattern or np.zeros(pulses))
    off = late[number % pulses] + jitter * draw.standard_normal(len(number))
    edges = mark + number * step + off
    last_edge = edges[np.searchsorted(edges, angle, side="right") - 1]
    return Plate(times, motion, np.where(angle - last_edge < 0.25 * step, 5.0, 0.0), mark)
