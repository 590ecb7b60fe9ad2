"""Highest points of a sum of harmonics, by a fine grid and Newton's method in many digits."""

from collections.abc import Callable, Sequence

import mpmath
import numpy as np
from mpmath import mpc, mpf

#: harmonics [component][n] of one row at a crank speed
RowAt = Callable[[mpf], list[list[mpc]]]


def cycle_peak(harmonics: Sequence[Sequence[mpc]], orders: Sequence[int]) -> tuple[mpf, mpf]:
    """Largest length over the cycle, and its angle, of a vector with harmonics [component][n]."""
    scale = max((abs(value) for row in harmonics for value in row), default=mpf(0))
    if scale == 0:
        return mpf(0), mpf(0)
    rows = [[value / scale for value in row] for row in harmonics]
    best = (mpf(-1), mpf(0))
    for start in _starts(rows, orders):
        angle = mpf(start)
        for _ in range(2):
            f, slope, bend = _signals(rows, orders, angle)
            first = _dot(f, slope)
            second = _dot(slope, slope) + _dot(f, bend)
            if second < -(mpf(10) ** -12):
                angle -= first / second
        best = max(best, (mpmath.sqrt(_dot(*2 * [_signals(rows, orders, angle)[0]])), angle))
    return best[0] * scale, best[1]


def peak(row_at: RowAt, orders: Sequence[int], speed: mpf) -> tuple[mpf, mpf]:
    """Largest length near a speed, over speed and angle together, and the speed it is reached at.

    Slopes by speed are differences over a step far below the digits of a double, and far above
    those in use here.
    """
    angle: mpf | None = None
    for _ in range(12):
        step = speed * mpf(10) ** -(mpmath.mp.dps // 3)
        below, here, above = (row_at(speed + by) for by in (-step, mpf(0), step))
        if angle is None:
            angle = cycle_peak(here, orders)[1]
        rising, bent = _slopes(below, here, above, step)
        f, f_a, f_aa = _signals(here, orders, angle)
        f_v, f_va, _ = _signals(rising, orders, angle)
        f_vv = _signals(bent, orders, angle)[0]
        v, a = _dot(f, f_v), _dot(f, f_a)
        vv, va = _dot(f_v, f_v) + _dot(f, f_vv), _dot(f_v, f_a) + _dot(f, f_va)
        aa = _dot(f_a, f_a) + _dot(f, f_aa)
        determinant = vv * aa - va * va
        if not (vv < 0 and determinant > 0):
            raise ArithmeticError(f"no maximum near a speed of {mpmath.nstr(speed, 12)} rad/s")
        by_speed, by_angle = (va * a - aa * v) / determinant, (va * v - vv * a) / determinant
        speed, angle = speed + by_speed, angle + by_angle
        if abs(by_speed) < speed * mpf(10) ** -22 and abs(by_angle) < mpf(10) ** -18:
            value = mpmath.sqrt(_dot(*2 * [_signals(row_at(speed), orders, angle)[0]]))
            return value, speed
    raise ArithmeticError(f"Newton's method did not settle near {mpmath.nstr(speed, 12)} rad/s")


def _slopes(
    below: list[list[mpc]], here: list[list[mpc]], above: list[list[mpc]], step: mpf
) -> tuple[list[list[mpc]], list[list[mpc]]]:
    """First and second derivative by speed, from central differences."""
    rising, bent = [], []
    for b, h, a in zip(below, here, above, strict=True):
        each = list(zip(b, h, a, strict=True))
        rising.append([(after - before) / (2 * step) for before, _, after in each])
        bent.append([(after - 2 * now + before) / step**2 for before, now, after in each])
    return rising, bent


def _dot(a: Sequence[mpf], b: Sequence[mpf]) -> mpf:
    return mpmath.fsum(x * y for x, y in zip(a, b, strict=True))


def _signals(
    rows: Sequence[Sequence[mpc]], orders: Sequence[int], angle: mpf
) -> tuple[list[mpf], list[mpf], list[mpf]]:
    """Each component at an angle, with two derivatives by it."""
    turn = [mpmath.expj(n * angle) for n in orders]
    waves = [[value * w for value, w in zip(row, turn, strict=True)] for row in rows]
    return (
        [mpmath.fsum(w.real for w in row) for row in waves],
        [mpmath.fsum(-n * w.imag for n, w in zip(orders, row, strict=True)) for row in waves],
        [mpmath.fsum(-(n**2) * w.real for n, w in zip(orders, row, strict=True)) for row in waves],
    )


def _starts(rows: Sequence[Sequence[mpc]], orders: Sequence[int]) -> list[float]:
    """Angles of the maxima that doubles cannot tell from the highest, up to a dozen."""
    values = np.array([[complex(value) for value in row] for row in rows])
    order = np.array(orders)
    angle = np.arange(64 * order.max()) * (2 * np.pi / (64 * order.max()))
    height = np.square((values @ np.exp(1j * np.outer(order, angle))).real).sum(axis=0)
    around = np.maximum(np.roll(height, 1), np.roll(height, -1))
    chosen = angle[(height >= around) & (height >= 0.98 * height.max())]
    for _ in range(4):
        waves = values[:, :, None] * np.exp(1j * np.outer(order, chosen))
        f = waves.real.sum(axis=1)
        slope = -(order[:, None] * waves.imag).sum(axis=1)
        bend = -(np.square(order)[:, None] * waves.real).sum(axis=1)
        first, second = (f * slope).sum(axis=0), (slope**2 + f * bend).sum(axis=0)
        chosen = chosen - np.where(second < -1e-9, first / np.where(second < -1e-9, second, 1), 0)
    height = np.square((values @ np.exp(1j * np.outer(order, chosen))).real).sum(axis=0)
    return [float(a) for a in chosen[height >= (1.0 - 1e-13) * height.max()][:12]]
