"""What the same course would do if it were run infinitely slowly."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.response.switching.readings import reading_peak, reading_peaks, steady_peaks
from vibecalc.response.switching.steady import steady_motion
from vibecalc.response.switching.system import Loads, ModalLoads, ModalSystem, Piece, modal_loads

_BASE, _NEAR = 100, 6
_PARTS, _ROUNDS = 9, 25
#: a search ends when neighbouring speeds differ by less than this share
_FINE = 1e-11
#: summits on the first speeds that are searched, as a share of the highest
_NEARLY = 0.9


class SlowPeaks(NamedTuple):
    """Largest steady peak of each reading (columns,) over all speeds, its error and the speed."""

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray


def slow_peaks(system: ModalSystem, loads: Loads, pieces: Sequence[Piece]) -> SlowPeaks:
    """Largest steady readings at any speed that the course passes or stays at.

    Speeds stand close around each resonance and evenly between; around the highest of each
    reading the step is then halved until it no longer matters. Divide the peaks of the transient
    by these to see what its haste is worth. Loads that grow with acceleration have no part here.

    Raises
    ------
    NumericalFailure
        The search does not settle, or `modal_loads` refuses the loads.
    """
    modal = modal_loads(system, loads)
    width = 2 * len(system.shape) + 3
    value, error, best = np.zeros((3, width))
    for operation in sorted({piece.operation for piece in pieces}):
        mine = [piece for piece in pieces if piece.operation == operation]
        speeds = np.unique(np.concatenate([_speeds(system, modal, piece) for piece in mine]))
        motion = _motions(system, modal, operation, speeds)
        heights = reading_peaks(system, *motion, modal.orders)[0]
        for column in range(width):
            for low, high in _promising(speeds, heights[:, column]):
                top, missing, at = _summit(system, modal, operation, low, high, column)
                if top > value[column]:
                    steady = steady_motion(system, modal, operation, at)
                    doubt = steady_peaks(system, steady, modal.orders, at).error[column]
                    value[column], error[column], best[column] = top, doubt + missing, at
    return SlowPeaks(value, error, best)


def _speeds(system: ModalSystem, loads: ModalLoads, piece: Piece) -> np.ndarray:
    low, high = sorted((piece.start_speed, piece.end_speed))
    spread = np.concatenate([[0.0], np.geomspace(0.1, 30.0, _NEAR)])
    spread = np.concatenate([-spread[:0:-1], spread])
    centre = (system.frequency / loads.orders[:, None])[..., None]
    near = np.ravel(centre * (1.0 + np.minimum(system.damping_ratio, 1.0)[:, None] * spread))
    near = np.concatenate([near, -near])
    inside = near[(near > low) & (near < high)]
    return np.concatenate([np.linspace(low, high, _BASE), inside])


def _promising(speeds: np.ndarray, heights: np.ndarray) -> list[tuple[float, float]]:
    """Neighbours of each summit on the speeds that nearly reaches the highest."""
    padded = np.concatenate([[-1.0], heights, [-1.0]])
    summit = (heights >= padded[:-2]) & (heights > padded[2:]) & (heights > 0.0)
    tops = np.flatnonzero(summit & (heights >= _NEARLY * np.max(heights)))
    last = len(speeds) - 1
    return [(speeds[max(top - 1, 0)], speeds[min(top + 1, last)]) for top in tops.tolist()]


def _motions(
    system: ModalSystem, loads: ModalLoads, operation: int, speeds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Steady amplitudes (speeds, orders, modes) of q and q'."""
    amplitude = np.array(
        [steady_motion(system, loads, operation, speed).amplitude for speed in speeds.tolist()]
    )
    return amplitude, 1j * (loads.orders * speeds[:, None])[..., None] * amplitude


def _summit(
    system: ModalSystem,
    loads: ModalLoads,
    operation: int,
    low: float,
    high: float,
    column: int,
) -> tuple[float, float, float]:
    """Highest value of one column between two speeds, what may be missing, and its speed.

    Of three equally spaced points on a parabola the middle one, if highest, lacks at most a
    quarter of the larger drop to the others; twice that is granted.
    """
    top = drop = at = 0.0
    for _ in range(_ROUNDS):
        between = np.linspace(low, high, _PARTS)
        motion = _motions(system, loads, operation, between)
        heights = reading_peak(system, *motion, loads.orders, column)[0]
        number = int(np.argmax(heights))
        sides = (max(number - 1, 0), min(number + 1, _PARTS - 1))
        top, at = float(heights[number]), float(between[number])
        drop = top - float(np.min(heights[list(sides)]))
        low, high = (float(between[side]) for side in sides)
        if drop <= _FINE * top or low == high:
            return top, 0.5 * drop, at
    raise NumericalFailure(
        f"the largest steady motion near {at:.9g} rad/s was not found: it still changes by "
        f"{drop / top:.1g} of itself between neighbouring speeds"
    )
