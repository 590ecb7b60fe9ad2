"""Adapter, continued: what the error of a tuning does to everything that is read at it.

A tuning is known to some last digits, and a sharp peak moves with them by many more. How much is
looked at: each ratio is moved by a millionth, and what that does is scaled to the error.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.absorber.model import Absorber, Transfer
from vibecalc.response.absorber.several import Several
from vibecalc.response.absorber.several_slopes import several_slopes

#: relative change of a ratio
_STEP = 1e-6
#: roundings granted to a slope of a peak
_ROUNDINGS = 64.0


class Doubt(NamedTuple):
    """Absolute errors of stiffness and damping ratio: numbers, or (n,) of several absorbers."""

    stiffness: FloatArray
    damping: FloatArray


def doubt_of(stiffness: object, damping: object) -> Doubt:
    """Errors as arrays; an unknown one (of a tuning that is one of many) counts as none."""
    both = (np.asarray(part, dtype=float) for part in (stiffness, damping))
    return Doubt(*(np.where(np.isfinite(part), part, 0.0) for part in both))


def moved(read: Callable[[Absorber], np.ndarray], tuned: Absorber, doubt: Doubt) -> FloatArray:
    """What the errors of one tuned absorber do to a reading of it, absolute."""
    return _moved(read, tuned, doubt, ("stiffness_ratio", "secondary_damping"))


def moved_several(
    read: Callable[[Several], np.ndarray], tuned: Several, doubt: Doubt
) -> FloatArray:
    """The same of several absorbers, each ratio by itself."""
    return _moved(read, tuned, doubt, ("stiffness_ratio", "secondary_damping"))


def _moved(read, tuned, doubt: Doubt, names: tuple[str, str]) -> FloatArray:  # type: ignore[no-untyped-def]
    own = np.asarray(read(tuned))
    total = np.zeros(own.shape)
    for name, errors in zip(names, doubt, strict=True):
        ratios = np.atleast_1d(np.asarray(getattr(tuned, name), dtype=float))
        for place, error in enumerate(np.atleast_1d(errors).tolist()):
            size = float(ratios[place])
            if error == 0.0 or size == 0.0 or not np.isfinite(size):
                continue
            off = ratios.copy()
            off[place] *= 1.0 + _STEP
            one = off if np.ndim(getattr(tuned, name)) else float(off[0])
            there = np.asarray(read(tuned._replace(**{name: one})))
            if there.shape != own.shape:
                continue
            with np.errstate(invalid="ignore"):
                change = np.abs(there - own)
            total += np.where(np.isfinite(change), change, 0.0) * (error / (_STEP * size))
    return total


def weight_error(
    system: Several, transfer: Transfer, frequency: FloatArray, weight: FloatArray, doubt: Doubt
) -> FloatArray:
    """Error (a,) of the weights with which the slopes of active peaks at `frequency` (a,) cancel.

    The slopes move with the ratios by their second derivatives, and are rounded.
    """
    found = several_slopes(system, frequency, transfer)
    errors = np.concatenate([np.atleast_1d(part) for part in doubt])
    size = len(errors)
    slope = found.first[:, :size]
    ratios = np.concatenate([np.atleast_1d(part) for part in system[2:4]]).astype(float)
    scale = np.where((ratios > 0.0) & np.isfinite(ratios), ratios, 0.0)
    off = np.abs(found.second[:, :size, :size]) @ errors
    off = (off + _ROUNDINGS * EPSILON * np.abs(slope)) * scale
    table = np.vstack([(slope * scale).T, np.ones(len(weight))])
    return np.asarray(np.abs(np.linalg.pinv(table))[:, :size] @ (off.T @ np.abs(weight)))
