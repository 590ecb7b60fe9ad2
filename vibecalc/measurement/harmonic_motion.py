"""The motion of each harmonic from its readings, with all that levels leave open."""

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
    MotionSpread,
    level_gradient,
    level_motions,
    phase_gradient,
)
from vibecalc.measurement.model import Harmonic, InstrumentReading
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.level import DECIBEL
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

#: relative error where first order does not hold: rounding enters by its square root
_IN_LINE = 3e-7
_ROUNDINGS = 8.0
#: of a linear problem
_LINEAR = 4.0
#: relative error of bounds from paths of centres
OF_BOUNDS = 1e-5


class Candidate(NamedTuple):
    """A motion (3,) that readings allow, and how rounding moves it.

    `level` is what levels leave, None where there are phases; `worst` its largest residual in dB.
    """

    motion: ComplexArray
    rounding: MotionSpread
    level: LevelMotion | None = None
    worst: float = 0.0

    def signal(self, rows: FloatArray) -> Bounded:
        """Signals (...) at rows (..., 3), and what rounding makes of them."""
        zero = np.zeros_like(rows)
        parts = (np.concatenate([rows, zero], axis=-1), np.concatenate([zero, rows], axis=-1))
        moved = np.hypot(*(self.rounding.bound(part) for part in parts))
        size = np.abs(rows) @ np.abs(self.motion)
        moved = np.where(np.isfinite(moved), moved, _IN_LINE * size)
        return Bounded(rows @ self.motion, np.asarray(moved + 8.0 * EPSILON * size))

    def phase(self, row: FloatArray, other: FloatArray) -> Bounded:
        """Phase in (-pi, pi] of the signal of a row (3,) against another; 0 where there is none."""
        both, errors = self.signal(np.stack([row, other]))
        if abs(both[1]) <= errors[1]:
            raise NumericalFailure(
                "the signal that phases refer to is zero: a phase has no meaning"
            )
        if abs(both[0]) <= errors[0]:
            return Bounded(np.array(0.0), np.array(0.0))
        phase = float(np.angle(both[0] * np.conj(both[1])))
        error = float(errors[0] / abs(both[0]) + errors[1] / abs(both[1])) + 8.0 * EPSILON
        if phase <= -math.pi + error:
            phase += 2.0 * math.pi
        return Bounded(np.array(phase), np.array(error))


class HarmonicMotion(NamedTuple):
    """The motions that the readings of a harmonic leave, the one taken first.

    `spread` is how readings move that one; `reach` bounds what motions of levels may be off, None
    where there are phases. `misfit` with its error is that of the readings over what they may be
    off.
    """

    harmonic: Harmonic
    candidates: tuple[Candidate, ...]
    spread: MotionSpread
    misfit: Bounded
    decided: bool = True
    chosen_by_others: bool = False
    reach: Reach | None = None

    @property
    def taken(self) -> Candidate:
        """The motion taken."""
        return self.candidates[0]

    @property
    def of_levels(self) -> tuple[Candidate, ...]:
        """All motions that levels leave; none where there are phases."""
        return self.candidates if self.reach is not None else ()

    @property
    def folded(self) -> bool:
        """Whether the motions are one family within the rounding, of which slopes say nothing."""
        return self.reach is not None and self.reach.folded

    def phase(self, row: FloatArray, other: FloatArray) -> Bounded:
        """Phase in (-pi, pi] of the signal of a row (3,) against another."""
        try:
            return self.taken.phase(row, other)
        except NumericalFailure as error:
            raise NumericalFailure(f"harmonic {self.harmonic.order}: {error}") from error

    def level_bound(self, rows: FloatArray, candidate: int = 0) -> FloatArray:
        """How far the levels (m,) at rows (m, 3) may be off, dB."""
        level = self.candidates[candidate].level
        if self.reach is None or level is None:
            return self.spread.bound(level_gradient(rows, self.taken.motion))
        return self.reach.bound(level, rows)

    def level_deviation(self, rows: FloatArray) -> FloatArray:
        """Standard uncertainty (m,) of the levels at rows (m, 3), dB."""
        if self.reach is None or self.taken.level is None:
            return self.spread.deviation(level_gradient(rows, self.taken.motion))
        return self.reach.deviation(self.taken.level, rows)

    def phase_deviation(self, row: FloatArray, reference: FloatArray) -> float:
        """Standard uncertainty, rad, of the phase of a row (3,) against another."""
        motion = self.taken.motion
        turn = phase_gradient(row, motion) - phase_gradient(reference, motion)
        if self.folded:
            return float("inf") if np.any(turn != 0.0) else 0.0
        return float(self.spread.deviation(turn))

    def uncertain(self, values: FloatArray) -> Bounded:
        """Uncertainties with their own error; an infinite one is as it is."""
        share = self.spread.uncertainty + (self.reach is not None) * OF_BOUNDS
        return Bounded(values, np.where(np.isfinite(values), values, 0.0) * share)


def solve_all(harmonics: Sequence[Harmonic], reference: FloatArray) -> list[HarmonicMotion]:
    """The motion of every harmonic; `reference` (3,) is the row where phases are zero.

    Raises NumericalFailure, which names the harmonic, where readings determine none.
    """
    growth, failure = np.ones(2), None
    try:
        growth = growth_of_deviations([one.phasors for one in harmonics if one.is_complex])
    except NumericalFailure as error:
        failure = error
    found = []
    for one in harmonics:
        try:
            solved = _from_phases(one, growth) if one.is_complex else _from_levels(one, reference)
        except NumericalFailure as error:
            raise NumericalFailure(f"harmonic {one.order}: {error}") from error
        found.append(solved)
    if failure is not None:
        raise failure
    return found


def _from_levels(harmonic: Harmonic, reference: FloatArray) -> HarmonicMotion:
    reads = harmonic.solving
    rows, sizes, half = _given(reads)
    deviations = np.array([read.deviation for read in reads])
    motions = level_motions(rows, sizes, half, reference, deviations)
    bounds = reach(rows, sizes, half)
    others = [read for read in harmonic.reads if read.use == "choose" and read.phase is None]
    choice = choose(motions, *_given(others), bounds)
    # the levels carry a few roundings each, and so does the motion that has them
    widths = _ROUNDINGS * EPSILON * (1.0 + np.abs(np.log(sizes / np.max(sizes)))) * DECIBEL
    candidates = []
    for place in choice.ranking:
        one = motions[place]
        worst = float(np.max(np.abs(choice.residuals[place] if others else one.residual)))
        rounding = one.spread._replace(half_widths=widths)
        candidates.append(Candidate(one.motion, rounding, one, worst))
    best, off = motions[choice.ranking[0]], 2.0 * _ROUNDINGS * EPSILON * DECIBEL
    return HarmonicMotion(
        harmonic=harmonic,
        candidates=tuple(candidates),
        spread=best.spread,
        misfit=Bounded(np.asarray(best.misfit), np.asarray(off / np.min(half))),
        decided=choice.decided,
        chosen_by_others=bool(others),
        reach=bounds,
    )


def _from_phases(harmonic: Harmonic, growth: FloatArray) -> HarmonicMotion:
    given = harmonic.phasors
    fit = complex_motion(given._replace(deviations=given.deviations * growth[:, None]))
    stated = over_deviations(fit.residual, given.readings, given.deviations)
    spare = 2 * (len(given.rows) - 3)
    # what is left over is felt by the condition once more
    felt = np.abs(given.readings) + fit.condition * np.abs(fit.residual)
    widths = _LINEAR * EPSILON * np.tile(felt, 2)
    misfit = float(np.sum(stated**2) / spare) ** 0.5 if spare else 0.0
    off = np.max(widths / np.ravel(given.deviations))
    # uncertainties grow with what the readings scatter, and what is not known of the one goes along
    grown = np.any(growth > 1.0) or fit.excess > 1.0
    share = float(np.max(widths / fit.spread.deviations)) if grown else 0.0
    return HarmonicMotion(
        harmonic=harmonic,
        candidates=(Candidate(fit.motion, fit.spread._replace(half_widths=widths)),),
        spread=fit.spread._replace(uncertainty=fit.spread.uncertainty + share),
        misfit=Bounded(np.asarray(misfit), np.asarray(off)),
    )


def _given(reads: Sequence[InstrumentReading]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Rows (r, 3), amplitudes and half widths (r,)."""
    rows = np.array([read.row for read in reads]).reshape(-1, 3)
    sizes, half = (np.array([getattr(read, key) for read in reads])
                   for key in ("amplitude", "half_width"))  # fmt: skip
    return rows, sizes, half
