"""Curves over an axis whose samples may lie elsewhere in another run."""

import math

import numpy as np

from vibecalc.results.align import Aligned, Entries, labels
from vibecalc.results.compare_kinds import tolerance
from vibecalc.results.record import Axis, Quantity
from vibecalc.results.rules import Rule


def by_curve(
    aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule, name: str
) -> tuple[Entries, tuple[str, ...]]:
    """Compare at the samples of both curves, straight between samples, within a tube.

    `aligned` has the axis `name` first. A sample may be off by `rule.shift` times the highest
    abscissa along the axis, and by the tolerance across it; so a resonance that one run sampled
    a little beside another one's sample is no difference. Samples that are not finite have to
    meet an equal one within the shift.

    Returns the entries, samples of the reference first, and words on ranges that do not agree.
    """
    axis_left, axis_right = _axis(reference, name), _axis(value, name)
    x_left, x_right = _abscissa(axis_left), _abscissa(axis_right)
    y_left, y_right = _columns(aligned.reference), _columns(aligned.value)
    if not x_left.size or not x_right.size:
        problem = f"{name} has {x_left.size} samples in the reference, {x_right.size} in the value"
        none = Entries((), np.empty(0), np.empty(0), np.empty(0), np.empty(0))
        return none, () if x_left.size == x_right.size else (problem,)
    shift = (rule.shift or 0.0) * max(np.abs(x_left).max(), np.abs(x_right).max())
    ends = (max(x_left.min(), x_right.min()) - shift, min(x_left.max(), x_right.max()) + shift)
    allowed = tolerance(np.abs(y_left), reference, value, rule)
    names: list[str] = []
    parts: list[tuple[np.ndarray, ...]] = []
    for x, y, other_x, other_y, axis in (
        (x_left, y_left, x_right, y_right, axis_left),
        (x_right, y_right, x_left, y_left, axis_right),
    ):
        kept = np.flatnonzero((x >= ends[0]) & (x <= ends[1]))
        limit = _interpolated(x[kept], x_left, allowed).real
        met = _interpolated(x[kept], other_x, other_y)
        difference = _distances(x[kept], y[kept], other_x, other_y, shift, limit, met, rule)
        shown = (y[kept], met) if axis is axis_left else (met, y[kept])
        names += _names(axis, kept, aligned.axes)
        parts.append((*shown, difference, limit))
    real = not np.iscomplexobj(aligned.reference) and not np.iscomplexobj(aligned.value)
    flat = [np.concatenate([part[i].ravel() for part in parts]) for i in range(4)]
    one, other = (flat[0].real, flat[1].real) if real else (flat[0], flat[1])
    problems = _range_problems(name, axis_left.unit, x_left, x_right, shift)
    return Entries(tuple(names), one, other, flat[2], flat[3]), problems


def _distances(
    x: np.ndarray,
    y: np.ndarray,
    other_x: np.ndarray,
    other_y: np.ndarray,
    shift: float,
    limit: np.ndarray,
    met: np.ndarray,
    rule: Rule,
) -> np.ndarray:
    """Distance of samples (n, m) from the other curve within the tube.

    Straight across the axis where that is already within the limit.
    """
    with np.errstate(invalid="ignore"):
        difference = np.abs(y - met)
    difference = np.where(np.isnan(difference), math.inf, difference)
    order = np.argsort(other_x, kind="stable")
    sorted_x, sorted_y = other_x[order], other_y[order]
    for row in np.flatnonzero((difference > limit).any(axis=1)):
        near = _from_polyline(x[row], y[row], sorted_x, sorted_y, shift, bool(rule.nan_equal))
        difference[row] = np.minimum(difference[row], near)
    return difference


def _from_polyline(
    x: float, y: np.ndarray, other_x: np.ndarray, other_y: np.ndarray, shift: float, nan_equal: bool
) -> np.ndarray:
    """Distance of values `y` (m,) at `x` from what the other curves pass within x +- shift."""
    first = max(int(np.searchsorted(other_x, x - shift, "left")) - 1, 0)
    last = min(int(np.searchsorted(other_x, x + shift, "right")), len(other_x) - 1)
    nodes_x, nodes_y = other_x[first : last + 1], other_y[first : last + 1]
    inside = np.abs(nodes_x - x) <= shift
    same = nodes_y == y
    if nan_equal:
        same = same | (np.isnan(nodes_y) & np.isnan(y))
    met = (same & inside[:, None]).any(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        step, rise = np.diff(nodes_x)[:, None], np.diff(nodes_y, axis=0)
        offset = x - nodes_x[:-1, None]
        start = np.clip(np.where(step > 0, (offset - shift) / step, 0.0), 0.0, 1.0)
        stop = np.clip(np.where(step > 0, (offset + shift) / step, 1.0), 0.0, 1.0)
        along = (np.conj(rise) * (y - nodes_y[:-1])).real / np.abs(rise) ** 2
        along = np.clip(np.where(np.isfinite(along), along, start), start, stop)
        gaps = np.abs(y - (nodes_y[:-1] + along * rise))
        points = np.where(inside[:, None], np.abs(y - nodes_y), math.inf)
    gaps = np.concatenate([gaps, points])
    gaps = np.where(np.isnan(gaps), math.inf, gaps)
    return np.asarray(np.where(met, 0.0, gaps.min(axis=0)))


def _interpolated(x: np.ndarray, other_x: np.ndarray, other_y: np.ndarray) -> np.ndarray:
    """The other curves (n, m) at `x`, straight between samples, constant beyond the ends."""
    order = np.argsort(other_x, kind="stable")
    found = np.empty((len(x), other_y.shape[1]), dtype=complex)
    with np.errstate(invalid="ignore"):
        for column in range(other_y.shape[1]):
            found[:, column] = np.interp(x, other_x[order], other_y[order, column])
    return found


def _axis(quantity: Quantity, name: str) -> Axis:
    return next(axis for axis in quantity.axes if axis.name == name)


def _abscissa(axis: Axis) -> np.ndarray:
    return np.asarray(axis.values, dtype=float)


def _columns(values: np.ndarray) -> np.ndarray:
    """Samples by curves; always complex, so that real curves take the same way."""
    return values.reshape(values.shape[0], -1).astype(complex)


def _names(axis: Axis, kept: np.ndarray, others: tuple[Axis, ...]) -> tuple[str, ...]:
    values = np.asarray(axis.values)[kept]
    shown = Axis(name=axis.name, values=values, unit=axis.unit)
    return labels((shown, *others))


def _range_problems(
    name: str, unit: str, left: np.ndarray, right: np.ndarray, shift: float
) -> tuple[str, ...]:
    if abs(left.min() - right.min()) <= shift and abs(left.max() - right.max()) <= shift:
        return ()
    ranges = " against ".join(f"{x.min():.9g} to {x.max():.9g}" for x in (left, right))
    return (f"{name} covers {ranges} {unit}".rstrip(),)
