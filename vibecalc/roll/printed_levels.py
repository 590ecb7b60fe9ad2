"""Levels and lags as the report prints them; what is zero to round-off has neither."""

import math

import numpy as np

from vibecalc.core.report.sections import having
from vibecalc.core.results.record import Quantity, Record

ROLL = "response/roll/"
SHELL = ROLL + "shell_acceleration"


def oscillating(quantity: Quantity) -> np.ndarray:
    """Places along a last axis `order` that are no mean."""
    return np.flatnonzero(np.asarray(quantity.axes[-1].values) != 0)


def acting(harmonics: Quantity) -> np.ndarray:
    """Which harmonics exceed their error estimate; what does not is zero to round-off."""
    return np.asarray(np.abs(harmonics.values) > known_error(harmonics))


def known_error(quantity: Quantity) -> float:
    """The error estimate; 0 where it is not known, since that hides nothing."""
    error = quantity.error_estimate
    return error if math.isfinite(error) else 0.0


def shell_acts(record: Record, orders: np.ndarray) -> np.ndarray:
    """Whether the shell's acceleration has each of the orders; yes where that is not known."""
    harmonics = having(record, SHELL, "order")
    if harmonics is None:
        return np.ones(orders.shape, dtype=bool)
    known = dict(zip(harmonics.axes[0].values.tolist(), acting(harmonics).tolist(), strict=True))
    return np.array([known.get(int(order), True) for order in orders], dtype=bool)


def lag_degrees(lag: float, acts: bool | np.bool_ = True) -> str:
    """An angle of lag in degrees, [0, 360), `-` where nothing lags."""
    if not acts or not math.isfinite(lag):
        return "-"
    return f"{round(math.degrees(lag), 2) % 360.0:.2f}"
