"""Adapter: the motion of each harmonic from its readings, with all that levels leave open."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.measurement.choosing import Reach, choose, reach
from vibecalc.measurement.complex_motion import (
    complex_motion,
    growth_of_deviations,
    over_deviations,
)
from vibecalc.measurement.level_motions import (
    LevelMotion,
    Spread,
    level_gradient,
    level_motions,
    phase_gradient,
)
from vibecalc.measurement.model import Harmonic, Read
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# The motion of each harmonic from its readings, with all that levels leave open.
# ----------------------------------------------------------------------------

#: relative error where first order does not hold: rounding enters by its square root
_IN_LINE = 3e-7
_ROUNDINGS = 8.0
#: of a linear problem
_LINEAR = 4.0


class Solution(NamedTuple):
    """The motion (3,) taken for a harmonic, and how its readings and rounding move it.

    `candidates` are all motions that levels leave, the one taken first, with their largest
    residual in dB; none where there are phases. `reach` bounds what they may be off. `excess` is
    the misfit of readings with phases over their deviations after all harmonics have told these.
    """

    harmonic: Harmonic
    motion: ComplexArray
    spread: Spread
    rounding: Spread
    misfit: float
    misfit_error: float
    excess: float
    decided: bool
    chosen_by_others: bool
    clipped: bool
    candidates: tuple[LevelMotion, ...]
    worst: tuple[float, ...]
    roundings: tuple[Spread, ...]
    reach: Reach | None

    @property
    def folded(self) -> bool:
        """Whether the motions are one family within the rounding, of which slopes say nothing."""
        return self.reach is not None and self.reach.folded

    def level_bound(self, rows: FloatArray, candidate: int = 0) -> FloatArray:
        """How far the levels (m,) at rows (m, 3) may be off, dB."""
        if self.reach is None:
            return self.spread.bound(level_gradient(rows, self.motion))
        return self.reach.bound(self.candidates[candidate], rows)

    def level_deviation(self, rows: FloatArray) -> FloatArray:
        """Standard uncertainty (m,) of the levels at rows (m, 3), dB."""
        if self.reach is None:
            return self.spread.deviation(level_gradient(rows, self.motion))
        return self.reach.deviation(self.candidates[0], rows)

    def phase_deviation(self, row: FloatArray, reference: FloatArray) -> float:
        """Standard uncertainty, rad, of the phase of a row (3,) against another."""
        turn = phase_gradient(row, self.motion) - phase_gradient(reference, self.motion)
        if self.folded:
            return float("inf") if np.any(turn != 0.0) else 0.0
        return float(self.spread.deviation(turn))

    def signal(self, rows: FloatArray) -> WithError:
        """Signals (...) at rows (..., 3) with their numerical error."""
        return signal(self.motion, self.rounding, rows)


def solve_all(harmonics: Sequence[Harmonic], reference: FloatArray) -> list[Solution]:
    """The motion of every harmonic; `reference` (3,) is the row where phases are zero."""
    try:
        growth = growth_of_deviations([one.phasors for one in harmonics if one.is_complex])
    except NumericalFailure:
        for one in harmonics:  # the harmonic that fails is named
            _solve(one, reference, np.ones(2))
        raise
    return [_solve(one, reference, growth) for one in harmonics]


def _solve(harmonic: Harmonic, reference: FloatArray, growth: FloatArray) -> Solution:
    try:
        if harmonic.is_complex:
            return _from_phases(harmonic, growth)
        return _from_levels(harmonic, reference)
    except NumericalFailure as failure:
        raise NumericalFailure(f"harmonic {harmonic.order}: {failure}") from failure


def signal(motion: ComplexArray, rounding: Spread, rows: FloatArray) -> WithError:
    """Signals (...) of a motion at rows (..., 3), and what rounding makes of them."""
    zero = np.zeros_like(rows)
    parts = (np.concatenate([rows, zero], axis=-1), np.concatenate([zero, rows], axis=-1))
    moved = np.hypot(*(rounding.bound(part) for part in parts))
    size = np.abs(rows) @ np.abs(motion)
    moved = np.where(np.isfinite(moved), moved, _IN_LINE * size)
    return WithError(rows @ motion, np.asarray(moved + 8.0 * EPSILON * size))


def _from_levels(harmonic: Harmonic, reference: FloatArray) -> Solution:
    reads = harmonic.solving
    rows, sizes = _rows(reads), np.array([read.amplitude for read in reads])
    half = np.array([read.half_width for read in reads])
    deviations = np.array([read.deviation for read in reads])
    motions = level_motions(rows, sizes, half, reference, deviations)
    bounds = reach(rows, sizes, half)
    others = [read for read in harmonic.reads if read.use == "choose" and read.phase is None]
    choice = choose(
        motions,
        _rows(others),
        np.array([read.amplitude for read in others]),
        np.array([read.half_width for read in others]),
        bounds,
    )
    ranked = tuple(motions[place] for place in choice.ranking)
    by_others = choice.residuals[list(choice.ranking)] if others else None
    worst = tuple(
        float(np.max(np.abs(motion.residual if by_others is None else by_others[place])))
        for place, motion in enumerate(ranked)
    )
    best = ranked[0]
    # the levels carry a few roundings each, and so does the motion that has them
    widths = _ROUNDINGS * EPSILON * (1.0 + np.abs(np.log(sizes / np.max(sizes)))) * DECIBEL
    roundings = tuple(motion.spread._replace(half_widths=widths) for motion in ranked)
    return Solution(
        harmonic=harmonic,
        motion=best.motion,
        spread=best.spread,
        rounding=roundings[0],
        misfit=best.misfit,
        misfit_error=2.0 * _ROUNDINGS * EPSILON * DECIBEL / float(np.min(half)),
        excess=0.0,
        decided=choice.decided,
        chosen_by_others=bool(others),
        clipped=best.clipped,
        candidates=ranked,
        worst=worst,
        roundings=roundings,
        reach=bounds,
    )


def _from_phases(harmonic: Harmonic, growth: FloatArray) -> Solution:
    given = harmonic.phasors
    fit = complex_motion(given._replace(deviations=given.deviations * growth[:, None]))
    stated = over_deviations(fit.residual, given.readings, given.deviations)
    spare = 2 * (len(given.rows) - 3)
    # what is left over is felt by the condition once more
    felt = np.abs(given.readings) + fit.condition * np.abs(fit.residual)
    widths = _LINEAR * EPSILON * np.tile(felt, 2)
    misfit_error = float(np.max(widths / np.ravel(given.deviations)))
    # uncertainties grow with what the readings scatter, and what is not known of the one goes along
    grown = np.any(growth > 1.0) or fit.excess > 1.0
    share = float(np.max(widths / fit.spread.deviations)) if grown else 0.0
    return Solution(
        harmonic=harmonic,
        motion=fit.motion,
        spread=fit.spread._replace(doubt=fit.spread.doubt + share),
        rounding=fit.spread._replace(half_widths=widths),
        misfit=float(np.sum(stated**2) / spare) ** 0.5 if spare else 0.0,
        misfit_error=misfit_error,
        excess=fit.excess,
        decided=True,
        chosen_by_others=False,
        clipped=False,
        candidates=(),
        worst=(),
        roundings=(),
        reach=None,
    )


def _rows(reads: "list[Read] | tuple[Read, ...]") -> FloatArray:
    return np.array([read.row for read in reads]).reshape(-1, 3)


# ----------------------------------------------------------------------------
# Phases of a measured motion against one another.
# ----------------------------------------------------------------------------


def phase_between(one: Solution, row: FloatArray, other: FloatArray) -> WithError:
    """Phase (rad) of the signal of a row (3,) against that of another; 0 where there is none."""
    try:
        return phase_of(one.motion, one.rounding, row, other)
    except NumericalFailure as failure:
        raise NumericalFailure(f"harmonic {one.harmonic.order}: {failure}") from failure


def phase_of(
    motion: ComplexArray, rounding: Spread, row: FloatArray, other: FloatArray
) -> WithError:
    """The same for any motion, in (-pi, pi]."""
    both, errors = signal(motion, rounding, np.stack([row, other]))
    if abs(both[1]) <= errors[1]:
        raise NumericalFailure("the signal that phases refer to is zero: a phase has no meaning")
    if abs(both[0]) <= errors[0]:
        return WithError(np.array(0.0), np.array(0.0))
    phase = float(np.angle(both[0] * np.conj(both[1])))
    error = float(errors[0] / abs(both[0]) + errors[1] / abs(both[1])) + 8.0 * EPSILON
    if phase <= -math.pi + error:
        phase += 2.0 * math.pi
    return WithError(np.array(phase), np.array(error))
