"""Fit keys of a case to what was measured: the stage groups hold the fitted case."""

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.case.rules import both
from vibecalc.core.results.record import Method, Record
from vibecalc.core.results.select import curving, scalar
from vibecalc.core.run.run import run_case
from vibecalc.core.study.binding import Varied, rows_of
from vibecalc.core.study.measured_points import (
    ROOT,
    MeasuredPoint,
    fit_entries,
    measured_points,
)
from vibecalc.core.study.search.least_squares import (
    Determined,
    LeastSquares,
    least_squares_within,
    what_is_determined,
)
from vibecalc.core.study.search.problem import spread
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure, ResultError
from vibecalc.numerics.rounding import FloatArray

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Measured points as residuals of a case with some of its keys changed.
# ----------------------------------------------------------------------------


class Residuals:
    """Computed less measured over the uncertainty of each point (m,), and what that is off (m,)."""

    def __init__(self, binding: Varied, points: list[MeasuredPoint]):
        self.binding, self.points = binding, points
        self.measured, self.uncertainty = (
            np.array([getattr(point, name) for point in points])
            for name in ("value", "uncertainty")
        )
        self._turns = np.array([point.cyclic for point in points])
        self._wanted = frozenset(point.quantity for point in points)

    def __call__(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of keys (n,) in SI; NumericalFailure where the case has no results."""
        computed, off, _ = self.computed(variables)
        apart = computed - self.measured
        around = np.remainder(apart + math.pi, 2.0 * math.pi) - math.pi
        return np.where(self._turns, around, apart) / self.uncertainty, off / self.uncertainty

    def computed(self, variables: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Results at the points (m,), each in its unit, their errors, and what the straight line
        between two samples of a curve adds to these."""
        record, rows = self.binding.results(variables, self._wanted), []
        for point in self.points:
            quantity = record[point.quantity]
            try:
                value, curved = scalar(quantity, point.where), curving(quantity, point.where)
            except ResultError as error:  # a speed that the curve does not reach with these keys
                raise NumericalFailure(str(error)) from error
            size = float(abs(value) if isinstance(value, complex) else value)
            rows.append((size, float(quantity.error_estimate), curved))
        values, errors, added = np.array(rows).T
        if not np.all(np.isfinite(values)):
            raise NumericalFailure("a result at a measured point is not finite")
        return values, errors, added


# ----------------------------------------------------------------------------
# Run a case to the keys that fit what was measured.
# ----------------------------------------------------------------------------

#: standard deviations of a normal distribution that chance exceeds once in twenty
_LEAST_PROBABILITY = 0.05
_METHOD = Method(
    name="least squares within bounds from many starts, mended by Gauss-Newton steps",
    purpose="fitted keys",
    citation="Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1999, 1-23; "
    "Bjorck, Numerical Methods for Least Squares Problems, 1996, ch. 9",
)


def fit(loaded: "LoadedCase", *, timings: dict[str, float], progress: bool = False) -> Record:
    """The record of the fitted case with `fit/...` added.

    Uncertainties grow by the root of chi square over its degrees of freedom where chance makes chi
    square as large less than once in twenty; they never shrink. Raises NumericalFailure where no
    search ends in a minimum.
    """
    from scipy.special import chdtrc

    case, started = loaded.case, time.perf_counter()
    assert case.fit is not None
    binding = Varied(loaded, rows_of(case.fit.moving))
    residuals = Residuals(binding, measured_points(case))
    with counted("fitting", progress) as advance:

        def counted_residuals(variables: FloatArray) -> tuple[FloatArray, FloatArray]:
            advance("")
            return residuals(variables)

        found = least_squares_within(
            counted_residuals,
            binding.lower,
            binding.upper,
            binding.first,
            spread(case.fit.starts, binding.lower.size),
        )
    least = float(np.linalg.norm(found.slopes_error)) or None
    spare = len(residuals.points) - int(np.linalg.matrix_rank(found.slopes, tol=least))
    # of a chi square at least as large, of so many degrees of freedom
    probability = float(chdtrc(spare, found.chi_square)) if spare > 0 else 1.0
    growth = 1.0
    if probability < _LEAST_PROBABILITY and found.chi_square > spare:
        growth = math.sqrt(found.chi_square / spare)
    scatter = {"degrees_of_freedom": spare, "probability": probability, "growth": growth}
    told = what_is_determined(found.slopes, found.slopes_error, growth)
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(found.variables), timings=timings)
    timings["fit"] = seconds
    _add(record, case, residuals, found, told, scatter)
    record.warnings[:0] = _warnings(binding, residuals.points, found, told, growth)
    record.methods.append(_METHOD)
    return record


# ----------------------------------------------------------------------------
# Numbers of a fit into the record, under the entries of their paths.
# ----------------------------------------------------------------------------


def _add(
    record: Record,
    case: "Case",
    residuals: Residuals,
    found: LeastSquares,
    told: Determined,
    scatter: dict[str, float],
) -> None:
    binding, points = residuals.binding, residuals.points
    scale = np.sqrt(np.diag(told.covariance))
    deviation, finite = scale * found.widths, np.isfinite(scale) & (scale > 0.0)
    scales = np.outer(np.where(finite, scale, 1.0), np.where(finite, scale, 1.0))
    correlation = np.where(np.outer(finite, finite), told.covariance / scales, np.eye(scale.size))
    # what slopes are off, of uncertainties and of what is made of them
    weakest = float(np.max(np.where(np.isfinite(told.deviations), told.deviations, 0.0)))
    slopes_off = float(np.linalg.norm(found.slopes_error))
    share = min(slopes_off * weakest / scatter["growth"], 1.0)
    computed, rounding, curved = residuals.computed(found.variables)
    now, _ = residuals(found.variables)
    off = rounding + curved
    noise = off / residuals.uncertainty
    variables_error = found.variables_error + found.moved_by @ noise
    moved = np.abs(found.slopes) @ (variables_error / found.widths) + noise
    numbers: dict[str, tuple[Any, float]] = {
        "correlation": (correlation, 2.0 * share),
        "chi_square": (found.chi_square, float(2.0 * np.abs(now) @ noise) + 1e-12),
        "residual": (now, float(np.max(moved))),
        "combination": (told.combinations, share),
        "combination_uncertainty": (told.deviations, share * weakest),
        "combination_told": (told.told.astype(int), 0.0),
        "search_chi_square": (found.searches, 1e-9 * found.chi_square),
        "evaluations": (found.evaluations, 0.0),
        "failures": (len(found.failures), 0.0),
    }
    for name, value in scatter.items():
        numbers[name] = (value, 0.0 if isinstance(value, int) else 1e-9 * value)
    for i, key in enumerate(binding.keys):
        off_by = share * float(deviation[i]) if np.isfinite(deviation[i]) else 0.0
        numbers[f"value/{key}"] = (found.variables[i], float(variables_error[i]))
        numbers[f"standard_error/{key}"] = (deviation[i], off_by)
        numbers[f"start/{key}"] = (binding.first[i], 0.0)
        numbers[f"active_bound/{key}"] = (int(found.active[i]), 0.0)
    columns = {
        "measured": (residuals.measured, np.zeros(len(points))),
        "uncertainty": (residuals.uncertainty, np.zeros(len(points))),
        "computed": (computed, off),
    }
    try:
        before, _ = residuals(binding.first)
        columns["at_start"] = residuals.computed(binding.first)[0], off
        numbers["start_chi_square"] = (before @ before, 1e-9 * float(before @ before))
        numbers["start_residual"] = (before, float(np.max(noise)))
    except NumericalFailure as failure:
        record.warnings.append(f"{ROOT}/at_start is left out, the case as written fails: {failure}")
    keys = np.array(binding.keys, dtype=object)
    labels: dict[str, Any] = {
        "variable": keys,
        "other_variable": keys,
        "measured_point": _unique([point.name for point in points]),
        "combination": np.arange(1, len(told.deviations) + 1),
        "search": np.arange(1, len(found.searches) + 1),
    }
    entries = fit_entries(case)
    for path, (values, error) in numbers.items():
        record.add(entries[f"{ROOT}/{path}"].quantity(values, error, labels))
    for path in dict.fromkeys(point.quantity for point in points):
        own = [place for place, point in enumerate(points) if point.quantity == path]
        labels["point"] = _unique([points[place].place or "-" for place in own])
        for name, (column, errors) in columns.items():
            entry = entries[f"{ROOT}/{name}/{path}"]
            record.add(entry.quantity(column[own], float(np.max(errors[own])), labels))


def _unique(names: list[str]) -> np.ndarray:
    """Names as entries of an axis; a second reading of one entry gets a number."""
    counts = [names[:place].count(name) + 1 for place, name in enumerate(names)]
    entries = [f"{name} ({n})" if n > 1 else name for name, n in zip(names, counts, strict=True)]
    return np.array(entries, dtype=object)


# ----------------------------------------------------------------------------
# What has to be said of a fit in words.
# ----------------------------------------------------------------------------

#: of the largest part of a combination, below which a part is not named
_NAMED = 0.02


def _warnings(
    binding: Varied,
    points: list[MeasuredPoint],
    found: LeastSquares,
    told: Determined,
    growth: float,
) -> list[str]:
    keys = binding.keys
    said = [
        f"no measured point depends on {key}: it stays as written"
        for key, felt in zip(keys, told.felt, strict=True)
        if not felt
    ]
    for vector, uncertainty, known in zip(
        told.combinations, told.deviations, told.told, strict=True
    ):
        named = [place for place in range(len(keys)) if abs(vector[place]) > _NAMED]
        if known or not all(told.felt[place] for place in named):
            continue
        how = "nothing" if np.isinf(uncertainty) else "no more than their bounds do"
        if len(named) == 1:
            said.append(f"the measured points tell {how} of {keys[named[0]]}")
        else:
            said.append(
                f"the measured points cannot tell {both([keys[one] for one in named])} apart: "
                f"of {_together(binding, found, vector, named)} they tell {how}"
            )
    for place, side in enumerate(found.active):
        if side:
            which = "lower" if side < 0 else "upper"
            said.append(
                f"{keys[place]} is at its {which} bound: the points would have it beyond, and its "
                "standard uncertainty is theirs alone"
            )
    if growth > 1.0:
        worst = int(np.argmax(np.abs(found.residuals)))
        said.append(
            f"the points scatter {growth:.3g} times as far as their uncertainties say, more than "
            f"chance does: those of the keys have grown by that; {points[worst].name} is off most, "
            f"by {abs(found.residuals[worst]):.3g} of its own"
        )
    if found.failures:
        why = "; ".join(dict.fromkeys(found.failures[:3]))
        said.append(
            f"{len(found.failures)} of {found.evaluations} points could not be evaluated: {why}"
        )
    return said


def _together(binding: Varied, found: LeastSquares, vector: FloatArray, named: list[int]) -> str:
    """A combination as changes of its keys in percent, of the largest part by one percent."""
    scale = np.where(found.variables != 0.0, np.abs(found.variables), found.widths)
    steps = vector * found.widths / scale
    largest = max(named, key=lambda one: abs(steps[one]))
    steps = steps / steps[largest]
    return " with ".join(
        f"{steps[one]:+.3g} % of {binding.keys[one].rpartition('.')[2]}" for one in named
    )
