"""When a body has settled into its final motion."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.free_motion import modal_size, propagator
from vibecalc.response.switching.system import ModalSystem

_HALVINGS = 100


class Settling(NamedTuple):
    """`time` in s from the course's start, with its error; `after` in s from the last change.

    `deviation` is the size of the deviation just after the last change, over the reference size.
    """

    time: float
    error: float
    after: float
    deviation: float


def settling(
    system: ModalSystem,
    deviation: np.ndarray,
    deviation_error: np.ndarray,
    last_change: float,
    reference: float,
    reference_error: float,
    tolerance: float,
) -> Settling:
    """When free motion from the state `deviation` (modes, 2) has died down.

    The size of the deviation is sqrt(2 E), E being the kinetic and potential energy of the
    difference between the motion and the final one: a length in the space of states, so that it
    falls with the amplitude and mixes metres and radians as the machine does. Once the load no
    longer changes, E only falls, hence one time divides before from after. Settled means
    sqrt(2 E) <= tolerance * reference.

    Parameters
    ----------
    deviation, deviation_error
        State at `last_change` (s), and the error (modes,) of its sizes.
    reference, reference_error
        The size that counts as whole: sqrt(2 E) of the final steady motion at its highest.

    Returns
    -------
    Settling
        The time is `last_change` where the deviation is small enough from there on. Its error
        is that of both sizes carried over; where energy pauses at the threshold it is as long.

    Raises
    ------
    NumericalFailure
        The threshold lies below the error of the deviation.
    """
    start = float(np.sqrt(np.sum(modal_size(system, deviation) ** 2)))
    doubt = float(np.sqrt(np.sum(deviation_error**2))) + 4.0 * EPSILON * start
    doubt += tolerance * reference_error
    threshold = tolerance * reference
    if start <= threshold:
        return Settling(last_change, 0.0, 0.0, start / reference if reference else 0.0)
    if threshold <= doubt:
        raise NumericalFailure(
            "no settling time: the final motion is so small that the deviation from it drowns in "
            "rounding, or in what the dropped orders may add, before it is a small part of it; ask "
            "for a larger settle tolerance or keep more orders ([excitation] orders)"
        )

    def size(time: float) -> float:
        moved = propagator(system, np.asarray(time))(deviation)
        return float(np.sqrt(np.sum(modal_size(system, moved) ** 2)))

    after = _first_below(size, threshold)
    low, high = (_first_below(size, level) for level in (threshold + doubt, threshold - doubt))
    error = max(high - after, after - low) + 8.0 * EPSILON * (after + last_change)
    return Settling(last_change + after, error, after, start / reference)


def _first_below(size: Callable[[float], float], level: float) -> float:
    """The time at which a falling size reaches a level, by doubling and halving."""
    if size(0.0) <= level:
        return 0.0
    low, high = 0.0, 1e-6
    while size(high) > level:
        low, high = high, 2.0 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if size(middle) > level else (low, middle)
    return high
