"""The distance of an answer from the truth, in the three norms that an engineer reads."""

from typing import NamedTuple

import numpy as np

#: entries below this share of the largest have no level worth comparing
LEAST_SHARE = 1e-6


class Errors(NamedTuple):
    """Worst relative error, worst level difference in dB, distance of the peak's position."""

    worst_relative: float
    worst_level: float
    position: float | None


def errors_of(
    values: np.ndarray,
    truth: np.ndarray,
    position: float | None = None,
    true_position: float | None = None,
) -> Errors:
    """Errors of `values`, real or complex, against `truth` of the same shape.

    The relative error is max|x - ref| / max|ref|: entries are held against the largest one, and a
    complex entry is a point in the plane. Where the truth is zero altogether it is 0 or infinite.
    The level difference is the largest |20 log10(|x| / |ref|)| over entries of at least
    `LEAST_SHARE` of the largest; a magnitude of zero there is infinitely far off. The position is
    None unless both sides have one.

    Raises ValueError for another shape, which is a mistake in the topic.
    """
    values, truth = np.asarray(values), np.asarray(truth)
    if values.shape != truth.shape:
        raise ValueError(f"an answer of shape {values.shape} for a truth of shape {truth.shape}")
    size = np.abs(truth)
    largest = float(np.max(size, initial=0.0))
    difference = float(np.max(np.abs(values - truth), initial=0.0))
    if largest == 0.0:
        relative = 0.0 if difference == 0.0 else float("inf")
        level = 0.0 if difference == 0.0 else float("inf")
    else:
        relative = difference / largest
        told = size >= LEAST_SHARE * largest
        with np.errstate(divide="ignore"):
            levels = 20.0 * np.log10(np.abs(values[told]) / size[told])
        level = float(np.max(np.abs(levels)))
    away = None
    if position is not None and true_position is not None:
        away = abs(float(position) - float(true_position))
    return Errors(relative, level, away)
