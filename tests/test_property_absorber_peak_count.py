"""Claim: signs of Sturm's chain count the maxima right, or say that rounding hides their number.

Counts are held against polynomials of known roots, and the peaks of absorbers against roots in 60
digits: none is missed, and none is given twice.
"""

import mpmath
import numpy as np
import pytest
from exact_tree import roots_of

from vibecalc.absorber.peaks import UNCERTAIN, Response, maxima_counted, peaks, quick_maxima
from vibecalc.absorber.squared_magnitude import measure
from vibecalc.absorber.transfer import Absorber, coupling, transfer_of
from vibecalc.numerics.maxima import Maxima

#: z1, m, k, z2 of absorbers one of whose peaks was once given twice
TWICE = (
    (0.13149114242082516, 0.061297333546748704, 0.029297435736876126, 6.990679771011391e-05),
    (0.2774871804001779, 0.007860098423333147, 0.009202808147693977, 1.0777497281203065e-05),
)


def grown(real: list[float], pairs: list[complex]) -> np.ndarray:
    """Coefficients by rising power, the highest negative: the function falls at the end."""
    roots = np.array([*real, *pairs, *np.conj(pairs)])
    return -np.real(np.poly(roots))[::-1]


@pytest.mark.parametrize(("real", "pairs", "maxima"), [
    ([1.0], [], 1),
    ([0.5, 1.0, 2.0], [], 2),
    ([0.5, 1.0, 2.0], [0.7 + 0.2j], 2),
    ([1.0, 2.0], [1.5 + 0.1j], 1),
    ([-1.0, 0.9, 1.0, 1.1], [], 2),
    ([-2.0], [1.1 + 0.3j], 0),
    ([0.2, 0.5, 1.0, 2.0, 5.0], [], 3),
    ([], [1.0 + 1e-3j], 0),
])  # fmt: skip
def test_known_roots_are_counted(real: list[float], pairs: list[complex], maxima: int) -> None:
    polynomial = grown(real, pairs)
    for scale in (1e-6, 1.0, 1e6):
        moved = (polynomial * scale ** -np.arange(len(polynomial)))[None]
        padded = np.concatenate([moved, np.zeros((1, 3))], axis=1)
        assert maxima_counted(moved, np.abs(moved)).tolist() == [maxima]
        assert maxima_counted(padded, np.abs(padded)).tolist() == [maxima]


def test_a_pair_within_rounding_is_not_reported() -> None:
    for apart in (0.0, 1e-9j, 1e-12):
        polynomial = grown([3.0], [1.0 + apart]) if np.imag(apart) else grown(
            [1.0 - apart, 1.0 + apart, 3.0], []
        )  # fmt: skip
        assert maxima_counted(polynomial[None], np.abs(polynomial)[None]).tolist() == [UNCERTAIN]
    assert maxima_counted(np.zeros((2, 4)), np.zeros((2, 4))).tolist() == [UNCERTAIN, UNCERTAIN]


def maxima_in_digits(z1: float, m: float, k: float, z2: float) -> list[float]:
    """Frequency ratios of all maxima of |H|, force to displacement, in 60 digits."""
    with mpmath.workdps(60):
        z1, m, k, z2 = (mpmath.mpf(float(part)) for part in (z1, m, k, z2))

        def times(a: list, b: list) -> list:
            out = [mpmath.mpf(0)] * (len(a) + len(b) - 1)
            for i, x in enumerate(a):
                for j, y in enumerate(b):
                    out[i + j] += x * y
            return out

        def plus(a: list, b: list) -> list:
            size = max(len(a), len(b))
            wide = [[*part, *[mpmath.mpf(0)] * (size - len(part))] for part in (a, b)]
            return [x + y for x, y in zip(*wide, strict=True)]

        def slope(a: list) -> list:
            return [i * x for i, x in enumerate(a)][1:]

        away = [k, -m]
        top = plus(times(away, away), [0, 4 * z2**2])
        real = plus(times([1, -1], away), [0, -4 * z1 * z2 - m * k])
        imaginary = plus([2 * z1 * x for x in away], [2 * z2, -2 * z2 * (1 + m)])
        bottom = plus(times(real, real), times([0, 1], times(imaginary, imaginary)))
        still = plus(times(slope(top), bottom), [-x for x in times(top, slope(bottom))])
        while still[-1] == 0:
            still.pop()
        roots = roots_of(still)
        places = [r.real for r in roots if r.real > 0 and abs(r.imag) < mpmath.mpf(10) ** -40]
        bend = slope(still)
        tops = [u for u in places if sum(x * u**i for i, x in enumerate(bend)) < 0]
        return sorted(float(mpmath.sqrt(u)) for u in tops)


def absorbers(count: int) -> np.ndarray:
    draw = np.random.default_rng(3)
    z1, m = 10.0 ** draw.uniform(-3, -0.1, count), 10.0 ** draw.uniform(-3, 0.5, count)
    k = m * 10.0 ** draw.uniform(-0.5, 0.5, count)
    return np.stack([z1, m, k, np.sqrt(m * k) * 10.0 ** draw.uniform(-3, 0.3, count)])


def test_peaks_are_those_of_sixty_digits_each_once() -> None:
    every = np.concatenate([absorbers(40), np.array(TWICE).T], axis=1)
    found = peaks(Absorber(*every))
    parts, transfer = coupling(Absorber(*every)), transfer_of("force", "displacement")
    whole = Response(parts, measure(parts, transfer), measure(parts, transfer, plain=True))
    # most are sure without any eigenvalues
    assert len(quick_maxima(whole)[1]) < 0.3 * len(parts.mass)
    for row, one in enumerate(every.T):
        true = maxima_in_digits(*one)
        own = found.frequency[row][found.present[row]]
        assert len(own) == len(true), one
        assert own == pytest.approx(true, rel=1e-7)


def test_the_quick_way_gives_what_the_thorough_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    from vibecalc.absorber import peaks as module

    every = Absorber(*absorbers(60))
    kinds = [("force", "velocity"), ("base", "displacement"), ("unbalance", "displacement"),
             ("force", "acceleration"), ("force", "relative_displacement")]  # fmt: skip
    quick = [peaks(every, *kind) for kind in kinds]

    def none(whole: Response) -> tuple[Maxima, np.ndarray]:
        found = quick_maxima(whole)[0]
        return found.some(np.zeros(0, dtype=int)), np.arange(len(whole.parts.mass))

    monkeypatch.setattr(module, "quick_maxima", none)
    for kind, one in zip(kinds, quick, strict=True):
        other = peaks(every, *kind)
        assert np.array_equal(one.present, other.present)
        apart = np.abs(one.largest - other.largest)
        assert np.all(apart <= one.largest_error + other.largest_error)
        assert np.allclose(one.frequency, other.frequency, rtol=1e-7, atol=0.0)
