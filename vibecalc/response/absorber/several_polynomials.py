"""Numerator and denominator of any response of several absorbers as polynomials in s."""

import numpy as np

from vibecalc.response.absorber.model import Transfer
from vibecalc.response.absorber.several import Several, checked_parents, path_to

Polynomial = np.ndarray


def several_polynomials(
    system: Several, transfer: Transfer, absorber: int = 1
) -> tuple[Polynomial, Polynomial]:
    """Coefficients of N and D, H = N / D, lowest power first, of one system (no leading axes).

    Built from sums and products of positive numbers only: every coefficient keeps its relative
    accuracy. Factors s common to both (an absorber without a spring) stay in.
    """
    parent = checked_parents(system)
    z1 = float(np.asarray(system.primary_damping))
    m, k, z = (np.asarray(part, dtype=float) for part in system[1:4])
    count = len(parent)
    inner: list[tuple[Polynomial, Polynomial]] = [(np.ones(1), np.ones(1))]
    inner += [(m[i : i + 1], np.ones(1)) for i in range(count)]
    outer_bottom = [np.ones(1)] * (count + 1)
    for i in reversed(range(count)):
        top, bottom = inner[i + 1]
        if np.isinf(k[i]) or np.isinf(z[i]):
            above, below = top, bottom
        else:
            stiff = np.array([k[i], 2.0 * z[i]])
            above = np.convolve(stiff, top)
            below = added(np.convolve(stiff, bottom), np.concatenate([[0.0, 0.0], top]))
        outer_bottom[i + 1] = below
        base = inner[parent[i]]
        inner[parent[i]] = (
            added(np.convolve(base[0], below), np.convolve(above, base[1])),
            np.convolve(base[1], below),
        )
    top, bottom = inner[0]
    drag = np.array([1.0, 2.0 * z1])
    denominator = added(np.convolve(drag, bottom), np.concatenate([[0.0, 0.0], top]))
    if transfer.motion == "primary":
        numerator = bottom
    elif transfer.motion == "ground":
        numerator = top
    else:
        numerator = _along_path(parent, absorber, transfer, k, z, inner, outer_bottom)
    numerator = np.concatenate([np.zeros(transfer.power), numerator])
    for _ in range(transfer.ground):
        numerator = np.convolve(numerator, drag)
    return transfer.sign * numerator, denominator


def added(first: Polynomial, second: Polynomial) -> Polynomial:
    """Sum of two polynomials."""
    result = np.zeros(max(len(first), len(second)))
    result[: len(first)] += first
    result[: len(second)] += second
    return result


def _along_path(
    parent: tuple[int, ...], absorber: int, transfer: Transfer, k: np.ndarray, z: np.ndarray,
    inner: list[tuple[Polynomial, Polynomial]], outer_bottom: list[Polynomial],
) -> Polynomial:  # fmt: skip
    """What w's denominators along the path leave, times what is transferred."""
    result = np.ones(1)
    path = path_to(parent, absorber)
    for number in path:
        for other, above in enumerate(parent, start=1):
            if above == parent[number - 1] and other != number:
                result = np.convolve(result, outer_bottom[other])
        last = number == absorber
        locked = np.isinf(k[number - 1]) or np.isinf(z[number - 1])
        if last and transfer.motion == "relative":
            inertia = np.concatenate([[0.0, 0.0], -inner[number][0]])
            result = np.zeros(1) if locked else np.convolve(result, inertia)
        elif not locked:
            result = np.convolve(result, [k[number - 1], 2.0 * z[number - 1]])
        if last and transfer.motion == "secondary":
            result = np.convolve(result, inner[number][1])
    return result


def squared(polynomial: Polynomial) -> Polynomial:
    """|p(i x)|^2 as a polynomial in u = x^2, lowest power first."""
    even, odd = polynomial[0::2].copy(), polynomial[1::2].copy()
    even[1::2] *= -1.0
    odd[1::2] *= -1.0
    if not len(odd):
        return np.convolve(even, even)
    return added(np.convolve(even, even), np.concatenate([[0.0], np.convolve(odd, odd)]))
