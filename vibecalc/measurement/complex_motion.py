"""The motion from complex amplitudes: weighted linear least squares, for any number of readings."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.level_motions import MotionSpread
from vibecalc.measurement.plate import scaled, span_of
from vibecalc.measurement.second_moments import NO_RANK
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

#: degrees of freedom from which on amplitudes and phases each have a growth of their own
_SPARE = 6
_ROUNDS = 20
#: standard deviations of a normal distribution that chance exceeds once in twenty
_CHANCE = 1.645


class ComplexMotion(NamedTuple):
    """Motion (3,) in SI, residual (r,) computed less read, and its standard uncertainty's source.

    `condition` is the ratio of the largest to the smallest weighed singular value, with angular
    accelerations counted at the span of the plate; `excess` the root mean square of the residuals
    over the given deviations, per degree of freedom (0 where there is none to spare). Where that
    is more than chance makes it once in twenty, the deviations of `spread` are the given ones
    times `excess`.
    """

    motion: ComplexArray
    residual: ComplexArray
    condition: float
    excess: float
    spread: MotionSpread


class Phasors(NamedTuple):
    """Rows (r, 3), readings (r,) complex, and their half widths and deviations > 0, both (2, r).

    Half widths and deviations, in the unit of the reading, hold along its phasor, where the
    amplitude errs, and across it, where the phase does.
    """

    rows: FloatArray
    readings: ComplexArray
    half_widths: FloatArray
    deviations: FloatArray


def complex_motion(given: Phasors) -> ComplexMotion:
    """Least squares, each part of a reading weighed by its deviation.

    To first order in the errors of phases: along and across are the directions read.

    Raises
    ------
    NumericalFailure : the readings leave a motion free, such as the roll about a line of points.
    """
    span, count = span_of(given.rows), len(given.rows)
    fit = _fit(given, given.deviations)
    slopes = fit.slopes / np.tile([1.0, span, span], 2)[:, None]
    parts = slopes[:, :count] @ np.abs(given.readings)  # nothing is read across a phasor
    motion = parts[:3] + 1j * parts[3:]
    spare, squares = 2 * (count - 3), float(np.sum(fit.squares))
    excess = (squares / spare) ** 0.5 if spare else 0.0
    growth = excess if _beyond_chance(squares, spare) else 1.0
    return ComplexMotion(
        motion,
        given.rows @ motion - given.readings,
        fit.condition,
        excess,
        MotionSpread(
            slopes,
            np.ravel(given.half_widths),
            np.ravel(given.deviations) * growth,
            16.0 * EPSILON * fit.condition,
        ),
    )


def growth_of_deviations(sets: Sequence[Phasors]) -> FloatArray:
    """Factors (2,) of the deviations of amplitudes and of phases that the scatter of all sets asks
    for; none is below 1.

    Both are 1 where all sets together scatter no more than chance makes them once in twenty, and
    the same where few degrees of freedom are to spare. Else squared residuals of either kind, over
    its grown deviations, sum up to its share of the degrees of freedom (Foerstner's estimate of
    variance components).
    """
    growth = np.ones(2)
    fits = [_fit(one, one.deviations) for one in sets]
    spare = sum(2 * (len(one.rows) - 3) for one in sets)
    squares = sum((fit.squares for fit in fits), np.zeros(2))
    if not _beyond_chance(float(np.sum(squares)), spare):
        return growth
    if spare < _SPARE:
        return growth * (np.sum(squares) / spare) ** 0.5
    for _ in range(_ROUNDS):
        left = sum((fit.spare for fit in fits), np.zeros(2))
        growth = np.maximum(growth * np.sqrt(squares / left), 1.0)
        fits = [_fit(one, one.deviations * growth[:, None]) for one in sets]
        squares = sum((fit.squares for fit in fits), np.zeros(2))
    return growth


def _beyond_chance(squares: float, spare: int) -> bool:
    """Whether a chi squared of so many degrees of freedom is above its 95th percentile.

    Wilson and Hilferty's approximation, good to 2 % from two degrees of freedom on.
    """
    if spare == 0:
        return False
    bend = 2.0 / (9.0 * spare)
    return bool(squares > spare * (1.0 - bend + _CHANCE * bend**0.5) ** 3)


class _Fit(NamedTuple):
    """Slopes (6, 2 r) of the parts of a scaled motion by what is read along and across; of
    amplitudes and of phases summed squared residuals over deviations, and degrees of freedom (2,).
    """

    slopes: FloatArray
    condition: float
    squares: FloatArray
    spare: FloatArray


def _fit(given: Phasors, deviations: FloatArray) -> _Fit:
    rows, count = scaled(given.rows, span_of(given.rows)), len(given.rows)
    lean = np.linalg.svd(rows, compute_uv=False)
    if len(lean) < 3 or lean[-1] <= NO_RANK * lean[0]:
        raise NumericalFailure("the readings leave a motion of the plate free")
    weights = 1.0 / np.ravel(deviations)
    table = along_and_across(rows, given.readings)
    left, size, right = np.linalg.svd(table * weights[:, None], full_matrices=False)
    if size[-1] <= NO_RANK * size[0]:
        raise NumericalFailure(
            "the uncertainties of amplitudes and phases lie too far apart to solve for a motion"
        )
    slopes = (right.T / size) @ left.T * weights
    read = np.concatenate([np.abs(given.readings), np.zeros(count)])
    over = (table @ (slopes @ read) - read) * weights
    both = (over**2, 1.0 - np.sum(left**2, axis=1))
    squares, spare = (part.reshape(2, count).sum(axis=1) for part in both)
    return _Fit(slopes, float(size[0] / size[-1]), squares, np.maximum(spare, EPSILON))


def along_and_across(rows: FloatArray, readings: ComplexArray) -> FloatArray:
    """Rows (2 r, 6) on real, then imaginary parts of a motion: parts of each signal along the
    phasor read, then those across it, a quarter turn ahead."""
    turn = np.angle(readings)
    cosine, sine = rows * np.cos(turn)[:, None], rows * np.sin(turn)[:, None]
    return np.block([[cosine, sine], [-sine, cosine]])


def over_deviations(
    residual: ComplexArray, readings: ComplexArray, deviations: FloatArray
) -> FloatArray:
    """Magnitudes (r,) of residuals, each part over its own deviation (2, r)."""
    turned = residual * np.exp(-1j * np.angle(readings))
    return np.asarray(np.hypot(turned.real / deviations[0], turned.imag / deviations[1]))
