"""Fit keys of a case to what was measured: the stage groups hold the fitted case."""

import math
import time
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.case.rules import both
from vibecalc.core.results.record import Method, Record
from vibecalc.core.results.select import scalar, select
from vibecalc.core.run.run import run_case
from vibecalc.core.study.binding import Varied
from vibecalc.core.study.measured_points import measured_points
from vibecalc.core.study.planned import FIT, fit_entries
from vibecalc.core.study.search.least_squares import LeastSquares
from vibecalc.core.study.search.problem import spread
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure, ResultError
from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# Measured points as residuals of a case with some of its keys changed.
# ----------------------------------------------------------------------------


class Residuals(Varied):
    """A case with some keys changed, held against its measured points (m,)."""

    def __init__(self, loaded: LoadedCase):
        assert loaded.case.fit is not None
        super().__init__(loaded, loaded.case.fit.moving)
        self.points = points = measured_points(loaded.case)
        self.measured = np.array([point.value for point in points])
        self.uncertainty = np.array([point.uncertainty for point in points])
        self._turns = np.array([point.cyclic for point in points])
        self._wanted = frozenset(point.quantity for point in points)

    def apart(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Computed less measured over the uncertainty of each point, and what that is off."""
        computed, off, _ = self.computed(variables)
        apart = computed - self.measured
        around = np.remainder(apart + math.pi, 2.0 * math.pi) - math.pi
        return np.where(self._turns, around, apart) / self.uncertainty, off / self.uncertainty

    def computed(self, variables: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Results at the points, each in its unit, their errors, and what the straight line
        between two samples of a curve adds to these; NumericalFailure where there are none."""
        record, rows = self.results(variables, self._wanted), []
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

#: of the largest part of a combination, below which a part is not named
_NAMED = 0.02
_METHOD = Method(
    name="least squares within bounds from many starts, mended by Gauss-Newton steps",
    purpose="fitted keys",
    citation="Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1999, 1-23; "
    "Bjorck, Numerical Methods for Least Squares Problems, 1996, ch. 9",
)


def fit(loaded: LoadedCase, *, timings: dict[str, float], progress: bool = False) -> Record:
    """The record of the fitted case with `fit/...` added.

    Uncertainties grow by the root of chi square over its degrees of freedom where chance makes chi
    square as large less than once in twenty; they never shrink. Raises NumericalFailure where no
    search ends in a minimum.
    """
    started, of, asked = time.perf_counter(), Residuals(loaded), loaded.case.fit
    assert asked is not None
    with counted("fitting", progress) as advance:

        def apart(variables: FloatArray) -> tuple[FloatArray, FloatArray]:
            advance("")
            return of.apart(variables)

        places = spread(asked.starts, of.lower.size)
        found = LeastSquares(apart, of.lower, of.upper, of.first, places)
    seconds = time.perf_counter() - started
    record = run_case(of.case_at(found.variables), timings=timings)
    timings["fit"] = seconds
    record.warnings[:0] = _warnings(of, found)
    _add(record, loaded, of, found)
    record.methods.append(_METHOD)
    return record


def _add(record: Record, loaded: LoadedCase, of: Residuals, found: LeastSquares) -> None:
    """Put the numbers into a record, under the entries of their paths."""
    scale = np.sqrt(np.diag(found.covariance))
    deviation, finite = scale * found.widths, np.isfinite(scale) & (scale > 0.0)
    unit = np.where(finite, scale, 1.0)
    correlation = found.covariance / np.outer(unit, unit)
    correlation = np.where(np.outer(finite, finite), correlation, np.eye(scale.size))
    # what slopes are off, of uncertainties and of what is made of them
    weakest = float(np.max(np.where(np.isfinite(found.deviations), found.deviations, 0.0)))
    share = min(float(np.linalg.norm(found.slopes_error)) * weakest / found.growth, 1.0)
    computed, rounding, curved = of.computed(found.variables)
    off, exact = rounding + curved, np.zeros(len(of.points))
    noise = off / of.uncertainty
    variables_error = found.variables_error + found.moved_by @ noise
    moved = np.abs(found.slopes) @ (variables_error / found.widths) + noise
    now, chi_square = found.residuals, found.chi_square
    numbers: dict[str, tuple[Any, float]] = {
        "correlation": (correlation, 2.0 * share),
        "chi_square": (chi_square, float(2.0 * np.abs(now) @ noise) + 1e-12),
        "residual": (now, float(np.max(moved))),
        "combination": (found.combinations, share),
        "combination_uncertainty": (found.deviations, share * weakest),
        "combination_told": (found.told.astype(int), 0.0),
        "search_chi_square": (found.searches, 1e-9 * chi_square),
        "evaluations": (found.evaluations, 0.0),
        "failures": (len(found.failures), 0.0),
        "degrees_of_freedom": (found.spare, 0.0),
        "probability": (found.probability, 1e-9 * found.probability),
        "growth": (found.growth, 1e-9 * found.growth),
    }
    for i, key in enumerate(of.keys):
        off_by = share * float(deviation[i]) if np.isfinite(deviation[i]) else 0.0
        numbers[f"value/{key}"] = (found.variables[i], float(variables_error[i]))
        numbers[f"standard_error/{key}"] = (deviation[i], off_by)
        numbers[f"start/{key}"] = (of.first[i], 0.0)
        numbers[f"active_bound/{key}"] = (int(found.active[i]), 0.0)
    columns = {
        "measured": (of.measured, exact),
        "uncertainty": (of.uncertainty, exact),
        "computed": (computed, off),
    }
    try:
        before, _ = of.apart(of.first)
        columns["at_start"] = of.computed(of.first)[0], off
        numbers["start_chi_square"] = (before @ before, 1e-9 * float(before @ before))
        numbers["start_residual"] = (before, float(np.max(noise)))
    except NumericalFailure as failure:
        words = f"{FIT}/at_start is left out, the case as written fails: {failure}"
        record.warnings.append(words)
    entries, keys = fit_entries(loaded.case), np.array(of.keys, dtype=object)
    labels: dict[str, Any] = {
        "variable": keys,
        "other_variable": keys,
        "measured_point": _unique([point.name for point in of.points]),
        "combination": np.arange(1, len(found.deviations) + 1),
        "search": np.arange(1, len(found.searches) + 1),
    }
    for path, (values, error) in numbers.items():
        record.add(entries[f"{FIT}/{path}"].quantity(values, error, labels))
    for path in dict.fromkeys(point.quantity for point in of.points):
        own = [place for place, point in enumerate(of.points) if point.quantity == path]
        labels["point"] = _unique([of.points[place].place or "-" for place in own])
        for name, (column, errors) in columns.items():
            entry = entries[f"{FIT}/{name}/{path}"]
            record.add(entry.quantity(column[own], float(np.max(errors[own])), labels))


def _warnings(of: Residuals, found: LeastSquares) -> list[str]:
    """What has to be said of the fit in words."""
    said = [
        f"no measured point depends on {key}: it keeps its start value"
        for key, felt in zip(of.keys, found.felt, strict=True)
        if not felt
    ]
    for vector, uncertainty, known in zip(
        found.combinations, found.deviations, found.told, strict=True
    ):
        named = np.flatnonzero(np.abs(vector) > _NAMED).tolist()
        if known or not np.all(found.felt[named]):
            continue
        how = "not identifiable" if np.isinf(uncertainty) else "known no better than by bounds"
        if len(named) == 1:
            said.append(f"from the measured points {of.keys[named[0]]} is {how}")
            continue
        # changes in percent, of the largest part by one percent
        size = np.where(found.variables != 0.0, np.abs(found.variables), found.widths)
        steps = vector * found.widths / size
        steps = steps / steps[max(named, key=lambda one: abs(steps[one]))]
        together = " with ".join(
            f"{steps[one]:+.3g} % of {of.keys[one].rpartition('.')[2]}" for one in named
        )
        said.append(
            f"the measured points cannot separate {both([of.keys[one] for one in named])}: "
            f"{together} is {how}"
        )
    said += [
        f"{key} is at its {'lower' if side < 0 else 'upper'} bound: the points fit better "
        "beyond it, and its standard uncertainty ignores the bound"
        for key, side in zip(of.keys, found.active, strict=True)
        if side
    ]
    if found.growth > 1.0:
        worst = int(np.argmax(np.abs(found.residuals)))
        said.append(
            f"residuals are {found.growth:.3g} times as large as the measurement uncertainties: "
            "the uncertainties of the keys are scaled by that factor; largest residual: "
            f"{of.points[worst].name}, {abs(found.residuals[worst]):.3g} times its uncertainty"
        )
    if found.failures:
        why = "; ".join(dict.fromkeys([*found.failures.values()][:3]))
        points = f"{len(found.failures)} of {found.evaluations} points"
        said.append(f"{points} could not be evaluated: {why}")
    return said


def _unique(names: list[str]) -> np.ndarray:
    """Names as entries of an axis; a second reading of one entry gets a number."""
    counts = [names[:place].count(name) + 1 for place, name in enumerate(names)]
    entries = [f"{name} ({n})" if n > 1 else name for name, n in zip(names, counts, strict=True)]
    return np.array(entries, dtype=object)
