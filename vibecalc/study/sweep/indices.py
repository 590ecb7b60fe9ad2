"""Sobol indices: which share of a result's variance each axis of a sweep brings about."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.study.sweep.sequences import resample
from vibecalc.study.sweep.statistics import Statistic

FEWEST = 16  # sampled points; below, resampling says nothing
REPETITIONS = 200
_SEED = 2010


class Indices(NamedTuple):
    """Sobol indices (axes, ...) and the number of sampled points they rest on.

    `first` is what an axis brings about alone, `total` with all its interactions.
    """

    first: Statistic
    total: Statistic
    samples: int


def sobol_indices(
    values: np.ndarray,
    axes: int,
    errors: np.ndarray | float = 0.0,
    usable: np.ndarray | None = None,
) -> Indices:
    """First-order and total Sobol indices of a result (n (axes + 2), ...) in the order of a design.

    First-order after Saltelli et al. 2010, Computer Physics Communications 181, table 2 (b), total
    after Jansen 1999 (f). `errors` are absolute, as the values; a sampled point of which a run is
    not `usable` (n (axes + 2),) is left out with all its runs. Standard errors are from resampling
    the points with a fixed draw, and like those of `mean` too large for Sobol points. An estimate
    may lie a little outside 0 to 1. NumericalFailure for fewer than 16 points, for values that are
    not finite, and for a result that does not vary beyond its own numerical error.
    """
    values = np.asarray(values, dtype=float)
    trailing = values.shape[1:]
    runs = values.reshape(-1, axes + 2, *trailing)
    wrong = np.broadcast_to(np.asarray(errors, dtype=float), values.shape).reshape(runs.shape)
    if usable is not None:
        whole = np.asarray(usable, dtype=bool).reshape(-1, axes + 2).all(axis=1)
        runs, wrong = runs[whole], wrong[whole]
    _check(runs)
    largest = np.max(wrong, axis=(0, 1))
    terms = _terms(runs)
    parts = _parts(*(term.mean(axis=0) for term in terms))
    if not np.all(parts.variance > largest**2):
        raise NumericalFailure(
            "no Sobol indices: the result does not vary beyond its own numerical error"
        )
    first_error, total_error = _errors(runs, terms, parts, largest)
    spread = _resampled(terms)
    return Indices(
        Statistic(parts.first, first_error, spread.first),
        Statistic(parts.total, total_error, spread.total),
        len(runs),
    )


class _Terms(NamedTuple):
    """What is averaged, for each sampled point; values count from their mean."""

    product: np.ndarray  # f(B) (f(AB) - f(A)), (n, axes, ...)
    step: np.ndarray  # f(AB) - f(A)
    half_square: np.ndarray  # (f(AB) - f(A))^2 / 2
    square: np.ndarray  # (f(A)^2 + f(B)^2) / 2, (n, ...)
    centre: np.ndarray  # (f(A) + f(B)) / 2


class _Parts(NamedTuple):
    first: np.ndarray
    total: np.ndarray
    variance: np.ndarray


def _terms(runs: np.ndarray) -> _Terms:
    centred = runs - np.mean(runs[:, :2], axis=(0, 1))
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    step = mixed - a
    square, centre = 0.5 * (a**2 + b**2)[:, 0], 0.5 * (a + b)[:, 0]
    return _Terms(b * step, step, 0.5 * step**2, square, centre)


def _parts(
    product: np.ndarray,
    step: np.ndarray,
    half_square: np.ndarray,
    square: np.ndarray,
    centre: np.ndarray,
) -> _Parts:
    """Indices from averaged terms; 0 where nothing varies."""
    variance = np.maximum(square - centre**2, 0.0)
    safe = np.where(variance > 0.0, variance, np.inf)
    return _Parts((product - centre * step) / safe, half_square / safe, variance)


def _resampled(terms: _Terms) -> _Parts:
    """Standard deviation of the indices over repeated draws of the sampled points."""
    size = len(terms.square)
    draws = [resample(size, repetition, _SEED) for repetition in range(REPETITIONS)]
    found = [_parts(*(term[draw].mean(axis=0) for term in terms)) for draw in draws]
    return _Parts(*(np.std(np.stack(part), axis=0, ddof=1) for part in zip(*found, strict=True)))


def _errors(
    runs: np.ndarray, terms: _Terms, parts: _Parts, largest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of what errors of the values, at most `largest`, and round-off do to the indices."""
    centred = np.abs(runs - np.mean(runs[:, :2], axis=(0, 1)))
    # a centred value is off by the error of the value and that of the mean
    off = 2.0 * largest + 4.0 * UNIT_ROUNDOFF * np.max(np.abs(runs), axis=(0, 1))
    size, steps = np.mean(centred[:, :2], axis=(0, 1)), np.mean(np.abs(terms.step), axis=0)
    counted = (len(runs) + 8) * UNIT_ROUNDOFF
    of_variance = off * (2.0 * size + off) + counted * parts.variance
    of_product = off * (np.mean(centred[:, 1], axis=0) + steps + off)
    of_product = of_product + counted * np.mean(np.abs(terms.product), axis=0)
    of_square = off * (steps + 0.5 * off) + counted * np.mean(terms.half_square, axis=0)
    return (
        (of_product + np.abs(parts.first) * of_variance) / parts.variance,
        (of_square + parts.total * of_variance) / parts.variance,
    )


def _check(runs: np.ndarray) -> None:
    if len(runs) < FEWEST:
        raise NumericalFailure(
            f"{len(runs)} sampled points are too few for Sobol indices, they take {FEWEST}"
        )
    if not np.all(np.isfinite(runs)):
        raise NumericalFailure("Sobol indices need finite values, and some runs have no bound")
