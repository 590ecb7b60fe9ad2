"""Fit keys of a case to what was measured: the stage groups hold the fitted case."""

import math
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.case.rules import both
from vibecalc.core.results.record import Entry, Method, Record
from vibecalc.core.results.select import scalar, select
from vibecalc.core.run.run import run_case
from vibecalc.core.study.binding import Varied, rows_of
from vibecalc.core.study.measured_points import (
    ROOT,
    MeasuredPoint,
    fit_entries,
    measured_points,
)
from vibecalc.core.study.search.least_squares import (
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
                value = scalar(quantity, point.where)
                curved = select(quantity, point.where).curving
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
#: of the largest part of a combination, below which a part is not named
_NAMED = 0.02
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
    case, started = loaded.case, time.perf_counter()
    assert case.fit is not None
    binding = Varied(loaded, rows_of(case.fit.moving))
    residuals = Residuals(binding, measured_points(case))
    with counted("fitting", progress) as advance:

        def counted_residuals(variables: FloatArray) -> tuple[FloatArray, FloatArray]:
            advance("")
            return residuals(variables)

        places = spread(case.fit.starts, binding.lower.size)
        bounds = binding.lower, binding.upper, binding.first
        fitted = Fitted(residuals, least_squares_within(counted_residuals, *bounds, places))
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(fitted.found.variables), timings=timings)
    timings["fit"] = seconds
    fitted.add_to(record, fit_entries(case))
    record.warnings[:0] = fitted.warnings()
    record.methods.append(_METHOD)
    return record


class Fitted:
    """Least squares `found`, what they tell of the keys, and how far the points scatter.

    `spare` are the degrees of freedom, `probability` that of a chi square at least as large,
    `growth` the factor of all uncertainties.
    """

    def __init__(self, residuals: Residuals, found: LeastSquares):
        from scipy.special import chdtrc

        self.residuals, self.found = residuals, found
        self.binding, self.points = residuals.binding, residuals.points
        least = float(np.linalg.norm(found.slopes_error)) or None
        self.spare = len(self.points) - int(np.linalg.matrix_rank(found.slopes, tol=least))
        self.probability = float(chdtrc(self.spare, found.chi_square)) if self.spare > 0 else 1.0
        self.growth = 1.0
        if self.probability < _LEAST_PROBABILITY and found.chi_square > self.spare:
            self.growth = math.sqrt(found.chi_square / self.spare)
        self.told = what_is_determined(found.slopes, found.slopes_error, self.growth)

    def add_to(self, record: Record, entries: Mapping[str, Entry]) -> None:
        """Put the numbers into a record, under the entries of their paths."""
        found, told, residuals, points = self.found, self.told, self.residuals, self.points
        scale = np.sqrt(np.diag(told.covariance))
        deviation, finite = scale * found.widths, np.isfinite(scale) & (scale > 0.0)
        unit = np.where(finite, scale, 1.0)
        correlation = told.covariance / np.outer(unit, unit)
        correlation = np.where(np.outer(finite, finite), correlation, np.eye(scale.size))
        # what slopes are off, of uncertainties and of what is made of them
        weakest = float(np.max(np.where(np.isfinite(told.deviations), told.deviations, 0.0)))
        share = min(float(np.linalg.norm(found.slopes_error)) * weakest / self.growth, 1.0)
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
            "degrees_of_freedom": (self.spare, 0.0),
            "probability": (self.probability, 1e-9 * self.probability),
            "growth": (self.growth, 1e-9 * self.growth),
        }
        for i, key in enumerate(self.binding.keys):
            off_by = share * float(deviation[i]) if np.isfinite(deviation[i]) else 0.0
            numbers[f"value/{key}"] = (found.variables[i], float(variables_error[i]))
            numbers[f"standard_error/{key}"] = (deviation[i], off_by)
            numbers[f"start/{key}"] = (self.binding.first[i], 0.0)
            numbers[f"active_bound/{key}"] = (int(found.active[i]), 0.0)
        exact = np.zeros(len(points))
        columns = {
            "measured": (residuals.measured, exact),
            "uncertainty": (residuals.uncertainty, exact),
            "computed": (computed, off),
        }
        try:
            before, _ = residuals(self.binding.first)
            columns["at_start"] = residuals.computed(self.binding.first)[0], off
            numbers["start_chi_square"] = (before @ before, 1e-9 * float(before @ before))
            numbers["start_residual"] = (before, float(np.max(noise)))
        except NumericalFailure as failure:
            words = f"{ROOT}/at_start is left out, the case as written fails: {failure}"
            record.warnings.append(words)
        keys = np.array(self.binding.keys, dtype=object)
        labels: dict[str, Any] = {
            "variable": keys,
            "other_variable": keys,
            "measured_point": _unique([point.name for point in points]),
            "combination": np.arange(1, len(told.deviations) + 1),
            "search": np.arange(1, len(found.searches) + 1),
        }
        for path, (values, error) in numbers.items():
            record.add(entries[f"{ROOT}/{path}"].quantity(values, error, labels))
        for path in dict.fromkeys(point.quantity for point in points):
            own = [place for place, point in enumerate(points) if point.quantity == path]
            labels["point"] = _unique([points[place].place or "-" for place in own])
            for name, (column, errors) in columns.items():
                entry = entries[f"{ROOT}/{name}/{path}"]
                record.add(entry.quantity(column[own], float(np.max(errors[own])), labels))

    def warnings(self) -> list[str]:
        """What has to be said of the fit in words."""
        keys, found, told = self.binding.keys, self.found, self.told
        said = [
            f"no measured point depends on {key}: it stays as written"
            for key, felt in zip(keys, told.felt, strict=True)
            if not felt
        ]
        for vector, uncertainty, known in zip(
            told.combinations, told.deviations, told.told, strict=True
        ):
            named = np.flatnonzero(np.abs(vector) > _NAMED).tolist()
            if known or not np.all(told.felt[named]):
                continue
            how = "nothing" if np.isinf(uncertainty) else "no more than their bounds do"
            if len(named) == 1:
                said.append(f"the measured points tell {how} of {keys[named[0]]}")
            else:
                said.append(
                    f"the measured points cannot tell {both([keys[one] for one in named])} apart: "
                    f"of {self._together(vector, named)} they tell {how}"
                )
        said += [
            f"{key} is at its {'lower' if side < 0 else 'upper'} bound: the points would have it "
            "beyond, and its standard uncertainty is theirs alone"
            for key, side in zip(keys, found.active, strict=True)
            if side
        ]
        if self.growth > 1.0:
            worst = int(np.argmax(np.abs(found.residuals)))
            said.append(
                f"the points scatter {self.growth:.3g} times as far as their uncertainties say, "
                "more than chance does: those of the keys have grown by that; "
                f"{self.points[worst].name} is off most, by {abs(found.residuals[worst]):.3g} of "
                "its own"
            )
        if found.failures:
            why = "; ".join(dict.fromkeys(found.failures[:3]))
            points = f"{len(found.failures)} of {found.evaluations} points"
            said.append(f"{points} could not be evaluated: {why}")
        return said

    def _together(self, vector: FloatArray, named: list[int]) -> str:
        """A combination as changes of its keys in percent, of the largest part by one percent."""
        values, widths = self.found.variables, self.found.widths
        steps = vector * widths / np.where(values != 0.0, np.abs(values), widths)
        steps = steps / steps[max(named, key=lambda one: abs(steps[one]))]
        return " with ".join(
            f"{steps[one]:+.3g} % of {self.binding.keys[one].rpartition('.')[2]}" for one in named
        )


def _unique(names: list[str]) -> np.ndarray:
    """Names as entries of an axis; a second reading of one entry gets a number."""
    counts = [names[:place].count(name) + 1 for place, name in enumerate(names)]
    entries = [f"{name} ({n})" if n > 1 else name for name, n in zip(names, counts, strict=True)]
    return np.array(entries, dtype=object)
