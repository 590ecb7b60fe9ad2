"""A periodic vector as harmonics: its length with derivatives, its summits by Newton's method."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure

#: maxima that agree to this share count as equal
EQUAL = 1e-10
NEWTON_STEPS = 8
#: samples of each order on which summits are looked for
SAMPLES_PER_ORDER = 48


class Signal(NamedTuple):
    """Harmonics (components, orders) of a vector, 0-to-peak, and their orders (orders,)."""

    harmonics: np.ndarray
    orders: np.ndarray


def square_and_slopes(signal: Signal, angle: np.ndarray) -> tuple[np.ndarray, ...]:
    """Squared length (k,) at crank angles (k,), with its first two derivatives by the angle."""
    waves = np.exp(1j * np.multiply.outer(signal.orders, angle))
    factor = 1j * signal.orders
    value, slope, bend = (((signal.harmonics * factor**power) @ waves).real for power in (0, 1, 2))
    return (
        np.sum(value * value, axis=0),
        2.0 * np.sum(value * slope, axis=0),
        2.0 * np.sum(slope * slope + value * bend, axis=0),
    )


def lengths(signal: Signal, angle: np.ndarray) -> np.ndarray:
    """Length of the vector (k,) at crank angles (k,)."""
    waves = np.exp(1j * np.multiply.outer(signal.orders, angle))
    return np.asarray(np.sqrt(np.sum(np.square((signal.harmonics @ waves).real), axis=0)))


def newton_maximum(signal: Signal, angle: float) -> tuple[float, float, int]:
    """Newton's method on the slope of the squared length: length, angle, evaluations.

    Raises NumericalFailure where it leads to no maximum.
    """
    taken, moved = 0, 1.0
    while taken < NEWTON_STEPS and abs(moved) >= 1e-12:
        _, slope, bend = (float(part[0]) for part in square_and_slopes(signal, np.array([angle])))
        if not bend < 0.0:
            raise NumericalFailure(f"Newton's method leaves the summit near {angle:.6g} rad")
        moved = -slope / bend
        angle += moved
        taken += 1
    return float(lengths(signal, np.array([angle]))[0]), angle, 3 * taken + 1


def equal_maxima(signal: Signal, first: float, value: float) -> list[float]:
    """Angles in [0, 2 pi) of all maxima as high as `value`, that at `first` before the others."""
    points = SAMPLES_PER_ORDER * int(signal.orders.max())
    angle = 2.0 * np.pi * np.arange(points) / points
    height = lengths(signal, angle)
    top = (height >= np.roll(height, 1)) & (height >= np.roll(height, -1))
    found = [first % (2.0 * np.pi)]
    for start in angle[top & (height > 0.98 * value)]:
        try:
            length, place, _ = newton_maximum(signal, float(start))
        except NumericalFailure:
            continue
        place %= 2.0 * np.pi
        new = all(abs(turned(place - other)) > 1e-6 for other in found)
        if new and length >= value * (1.0 - EQUAL):
            found.append(place)
    return found


def turned(angle: float) -> float:
    """The angle between -pi and pi."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
