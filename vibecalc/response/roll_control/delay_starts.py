"""Where to begin looking for the poles of a loop with a delay."""

import math

import numpy as np

from vibecalc.response.roll_control.model import Loop


def first_guesses(loop: Loop, order: int, branches: int) -> np.ndarray:
    """Approximate roots (m,) in 1/s of P(s) + Q(s) exp(-s delay), the delay positive.

    Near the origin those without the delay and those with its diagonal Pade approximant, of
    `order`; far away those of the leading terms alone, by branches of Lambert's W function, or
    the chain of a loop without a lag. One loop, all coefficients scalars. Only starts: some lead
    nowhere.
    """
    plain = np.roots([loop.p2, loop.p1 + loop.q1, loop.p0 + loop.q0])
    return np.concatenate([plain, _by_pade(loop, order), _by_leading_terms(loop, branches)])


def _by_pade(loop: Loop, order: int) -> np.ndarray:
    top = math.factorial(2 * order)
    weight = np.array([
        math.factorial(2 * order - k) * math.factorial(order)
        / (top * math.factorial(k) * math.factorial(order - k))
        for k in range(order, -1, -1)
    ])  # fmt: skip
    sign = np.array([(-1.0) ** k for k in range(order, -1, -1)])
    time = float(loop.delay)
    direct = np.array([loop.p2 / time**2, loop.p1 / time, loop.p0])
    back = np.array([loop.q1 / time, loop.q0])
    poly = np.polyadd(np.polymul(direct, weight), np.polymul(back, weight * sign))
    found: np.ndarray = np.roots(np.trim_zeros(poly, "f")) / time
    return found


def _by_leading_terms(loop: Loop, branches: int) -> np.ndarray:
    from scipy.special import lambertw

    time = float(loop.delay)
    number = np.arange(-branches, branches + 1)
    if loop.p2 == 0.0 and loop.q1 != 0.0:
        level = complex(-loop.q1 / loop.p1)
        chain: np.ndarray = (np.log(level) + 2j * math.pi * number) / time
        return chain
    if loop.p2 > 0.0 and loop.q1 != 0.0:
        found: np.ndarray = lambertw(-loop.q1 * time / loop.p2, number) / time
        return found
    if loop.q0 == 0.0:
        return np.zeros(0, dtype=complex)
    if loop.p2 == 0.0:
        single: np.ndarray = lambertw(-loop.q0 * time / loop.p1, number) / time
        return single
    root = np.sqrt(complex(-loop.q0 / loop.p2)) * time / 2.0
    both = [2.0 * lambertw(sign * root, number) / time for sign in (1.0, -1.0)]
    return np.concatenate(both)
