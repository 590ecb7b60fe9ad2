"""Torque of an induction motor over its slip, from a table: piecewise polynomials, odd in slip."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.gas_tables import straight
from vibecalc.numerics.rounding import FloatArray, IntArray


class SlipCurve(NamedTuple):
    """p intervals of a curve of torque over slip; interval i lies between thresholds i - 1 and i.

    `threshold` (p - 1,) ascends, in rad/s, and is symmetrical about zero. In interval i the torque
    is sum_k coefficient[i, k] (slip - base[i])^k in N m. The outermost pieces stand for a slip
    beyond the table, where the last torque is kept; `largest` is the last slip of the table.
    """

    threshold: FloatArray
    base: FloatArray
    coefficient: FloatArray
    largest: float


class Torque(NamedTuple):
    """Torque in N m and its slope by the slip in N m s/rad."""

    value: FloatArray
    slope: FloatArray


def linear_motor(gain: float) -> SlipCurve:
    """A motor whose torque is `gain` (N m s/rad) times its slip, whatever the slip."""
    return SlipCurve(np.empty(0), np.zeros(1), np.array([[0.0, gain]]), np.inf)


def slip_curve(slip: ArrayLike, torque: ArrayLike, interpolation: str) -> SlipCurve:
    """A curve through a table that ascends from slip 0, torque 0.

    Parameters
    ----------
    slip, torque : (m,) in rad/s and N m; the torque at negative slip is the negative one
        (Herold 1977, section 6.2).
    interpolation
        "linear": straight lines, as the source's program has it. "parabola": on each interval the
        parabola through its ends and the node before it. "monotone": cubic Hermite polynomials that
        overshoot no node (Fritsch and Carlson 1980), with a continuous slope.
    """
    slip, torque = np.asarray(slip, dtype=float), np.asarray(torque, dtype=float)
    nodes = np.concatenate([-slip[:0:-1], slip])
    values = np.concatenate([-torque[:0:-1], torque])
    polynomials = _INTERPOLANTS[interpolation](nodes, values)
    last = np.zeros((1, polynomials.shape[1]))
    last[0, 0] = values[-1]
    return SlipCurve(
        nodes,
        np.concatenate([nodes[:1], nodes[:-1], nodes[-1:]]),
        np.concatenate([-last, polynomials, last]),
        float(slip[-1]),
    )


def interval_of(curve: SlipCurve, slip: FloatArray) -> IntArray:
    """The interval in which each slip lies; a threshold belongs to the one above it."""
    return np.searchsorted(curve.threshold, slip, side="right").astype(np.int64)


def slip_torque(curve: SlipCurve, slip: FloatArray, interval: IntArray | None = None) -> Torque:
    """Torque at the slips (...,), rad/s, and its slope.

    With `interval` (...,) the polynomials of those pieces are used, also beyond their ends.
    """
    chosen = interval_of(curve, slip) if interval is None else interval
    away = slip - curve.base[chosen]
    rows = curve.coefficient[chosen]
    last = rows.shape[-1] - 1
    value, slope = rows[..., last], np.zeros_like(away)
    for power in range(last - 1, -1, -1):
        slope = slope * away + value
        value = value * away + rows[..., power]
    return Torque(value, slope)


def breakdown(curve: SlipCurve) -> tuple[float, float]:
    """Slip (rad/s) and torque (N m) of the peak at positive slip; infinite for a linear motor."""
    if not np.isfinite(curve.largest):
        return np.inf, np.inf
    slip, height = _candidates(curve)
    most = height.max()
    return float(slip[height == most].min()), float(most)


def rising_branch(curve: SlipCurve) -> tuple[float, float]:
    """Slip (rad/s) up to which the torque rises from zero, and the least torque beyond it (N m).

    Infinite for a linear motor, and for a table that rises to its end.
    """
    if not np.isfinite(curve.largest):
        return np.inf, np.inf
    slip, height = _candidates(curve)
    order = np.argsort(slip, kind="stable")
    slip, height = slip[order], height[order]
    falls = np.flatnonzero(np.diff(height) < -1e-12 * height.max())
    if not len(falls):
        return np.inf, np.inf
    return float(slip[falls[0]]), float(height[falls[0] :].min())


def _candidates(curve: SlipCurve) -> tuple[FloatArray, FloatArray]:
    """Slips from zero on and torques there (n,): every node, every place of slope zero."""
    first = len(curve.threshold) // 2
    rows, width = curve.coefficient[first + 1 : -1].T, np.diff(curve.threshold[first:])
    away = np.stack([np.zeros_like(width), width, *_flat_places(rows, width)])
    height = rows[-1]
    for row in rows[-2::-1]:
        height = height * away + row
    return (curve.base[first + 1 : -1] + away).ravel(), np.broadcast_to(height, away.shape).ravel()


def _flat_places(rows: FloatArray, width: FloatArray) -> tuple[FloatArray, ...]:
    """Where pieces up to cubics, coefficients (n, pieces), have slope zero, or else their begin."""
    if len(rows) < 3 or not rows[2:].any():
        return ()
    c = rows[1]
    b, a = 2.0 * rows[2], 3.0 * rows[3] if len(rows) > 3 else np.zeros_like(c)
    with np.errstate(all="ignore"):
        half = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        return tuple(np.where((x > 0.0) & (x < width), x, 0.0) for x in (half / a, c / half))


def _parabola(nodes: FloatArray, values: FloatArray) -> FloatArray:
    middle = len(nodes) // 2
    step = np.diff(nodes)
    slope, width = np.diff(values) / step, step[middle:]
    bend = (slope[middle:] - slope[middle - 1 : -1]) / (width + step[middle - 1 : -1])
    begin, rise = values[middle:-1], slope[middle:] - bend * width
    upper = np.stack([begin, rise, bend], axis=1)
    # the odd branch mirrors the other one, so that the curve stays odd
    end = begin + (rise + bend * width) * width
    lower = np.stack([-end, rise + 2.0 * bend * width, -bend], axis=1)
    return np.concatenate([lower[::-1], upper])


def _monotone(nodes: FloatArray, values: FloatArray) -> FloatArray:
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(nodes, values).c[::-1].T)


_INTERPOLANTS = {"linear": straight, "parabola": _parabola, "monotone": _monotone}
