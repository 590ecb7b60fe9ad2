"""The absorber with many digits: response from the equations of motion, peaks, true minimax.

Nothing is taken from the package: |H|^2 comes from the 2 x 2 matrix of the motion, derivatives
from differences with twice the digits, optima from the conditions that hold them.
"""

from collections.abc import Sequence

from mpmath import mp, mpc, mpf

#: power of s, factors 1 + 2 z1 s on the way in and on the way out, what moves
KINDS = {
    ("force", "displacement"): (0, 0), ("force", "velocity"): (1, 0),
    ("force", "acceleration"): (2, 0), ("force", "transmitted_force"): (0, 1),
    ("base", "displacement"): (0, 1), ("base", "velocity"): (1, 1),
    ("base", "transmitted_force"): None, ("unbalance", "displacement"): (2, 0),
}  # fmt: skip


def motions(z1: mpf, m: mpf, k: mpf, z2: mpf, x: mpf) -> tuple[mpc, mpc]:
    """Primary and secondary amplitude under a unit force, from the matrix of eq. 2.8."""
    s = mpc(0, x)
    g = k + 2 * z2 * s
    a, b, d = s * s + 2 * z1 * s + 1 + g, -g, m * s * s + g
    det = a * d - b * b
    return d / det, -b / det


def squared(kind: tuple[str, str], z1: mpf, m: mpf, k: mpf, z2: mpf, u: mpf) -> mpf:
    """|H|^2 at u = x^2."""
    x = mp.sqrt(u)
    s = mpc(0, x)
    theta = motions(z1, m, k, z2, x)[0]
    ground = 1 + 2 * z1 * s
    if KINDS[kind] is None:
        value = ground * (ground * theta - 1)
    else:
        power, factors = KINDS[kind]
        value = theta * s**power * ground**factors
    return value.real**2 + value.imag**2


def peak(kind: tuple[str, str], ratios: Sequence[float], near: float) -> tuple[mpf, mpf]:
    """Frequency and |H| of the stationary point next to x = near."""
    z1, m, k, z2 = (mpf(float(r)) for r in ratios)

    def slope(y: mpf) -> mpf:
        return mp.diff(lambda t: mp.log(squared(kind, z1, m, k, z2, mp.exp(t))), y)

    start = 2 * mp.log(mpf(float(near)))
    # a second place close by: a narrow peak is lost from a quarter of a unit away
    y = mp.findroot(slope, (start, start + mpf(10) ** -14))
    return mp.exp(y / 2), mp.sqrt(squared(kind, z1, m, k, z2, mp.exp(y)))


def optimum(
    kind: tuple[str, str], z1: float, m: float, start: Sequence[float], floor: mpf | int = 0
) -> tuple[mpf, mpf, mpf]:
    """k, z2 and |H| - floor at the balance of two peaks next to start (k, z2, x1, x2).

    Both peaks stationary and equal, their gradients by (k, z2) parallel; that they oppose each
    other is asserted. Digits: those of mp; the levels are taken above the floor, so that digits
    remain where |H| is close to it.
    """
    e, r = mpf(float(z1)), mpf(float(m))

    def level(y: mpf, a: mpf, b: mpf) -> mpf:
        return mp.log(squared(kind, e, r, mp.exp(a), mp.exp(b), mp.exp(y)) - mpf(floor) ** 2)

    def slopes(y: mpf, a: mpf, b: mpf) -> list[mpf]:
        return [mp.diff(level, (y, a, b), order) for order in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]

    def conditions(a: mpf, b: mpf, y1: mpf, y2: mpf) -> list[mpf]:
        one, two = slopes(y1, a, b), slopes(y2, a, b)
        gap = level(y1, a, b) - level(y2, a, b)
        return [one[0], two[0], gap, one[1] * two[2] - one[2] * two[1]]

    k, z2, x1, x2 = (mp.log(mpf(float(v))) for v in start)
    a, b, y1, y2 = mp.findroot(conditions, (k, z2, 2 * x1, 2 * x2), tol=mpf(10) ** -30, maxsteps=20)
    one, two = slopes(y1, a, b), slopes(y2, a, b)
    assert one[1] * two[1] < 0 or one[2] * two[2] < 0
    above = mp.exp(level(y1, a, b))
    return mp.exp(a), mp.exp(b), above / (mp.sqrt(above + mpf(floor) ** 2) + mpf(floor))
