"""What this machine does at best with numpy: seconds for one operation of each kind, measured.

Operations on arrays are timed on pieces that stay in the cache, written into memory that is there
already; `byte` is copying pieces that do not fit; the calls are one of numpy on an array of one
entry, and one of a Python function that does nothing.
"""

import math
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from timing import Work, each_of

#: entries of a piece in the cache, and of one that is not
INSIDE, OUTSIDE = 4096, 1 << 22
MATRIX = 300


def nothing() -> None:
    """As little as a function can do."""


def pieces(count: int, kind: type) -> list[np.ndarray]:
    """Three arrays without zeros or special values."""
    generator = np.random.default_rng(1)
    real = 0.5 + generator.random((3, count))
    values = real if kind is float else real + 1j * real[::-1]
    return [np.ascontiguousarray(one) for one in values]


def works() -> dict[str, tuple[Work, float]]:
    """What does each kind of operation, and how often one call does it."""
    a, b, c = pieces(INSIDE, float)
    x, y, z = pieces(INSIDE, complex)
    far, there, _ = pieces(OUTSIDE, float)
    matrix, other, product = np.random.default_rng(2).random((3, MATRIX, MATRIX))
    small = np.random.default_rng(3).random((2000, 6, 6)) + 4.0 * np.eye(6) + 0.1j
    load, one = np.ones((2000, 6, 1), dtype=complex), np.ones(1)
    knots = np.linspace(0.0, 2.0, 37)
    spectrum, samples = pieces(65, complex)[0], 128
    rows = np.tile(spectrum, (64, 1))
    transform = samples * math.log2(samples) * len(rows)
    return {
        "real product": (lambda: np.multiply(a, b, out=c), INSIDE),
        "real sum": (lambda: np.add(a, b, out=c), INSIDE),
        "real quotient": (lambda: np.divide(a, b, out=c), INSIDE),
        "root": (lambda: np.sqrt(a, out=c), INSIDE),
        "sine": (lambda: np.sin(a, out=c), INSIDE),
        "power": (lambda: np.power(a, b, out=c), INSIDE),
        "comparison": (lambda: np.maximum(a, b, out=c), INSIDE),
        "look-up": (lambda: np.interp(a, knots, knots), INSIDE),
        "complex product": (lambda: np.multiply(x, y, out=z), INSIDE),
        "complex sum": (lambda: np.add(x, y, out=z), INSIDE),
        "complex reciprocal": (lambda: np.divide(1.0, x, out=z), INSIDE),
        "flop of matrices": (lambda: np.matmul(matrix, other, out=product), 2.0 * MATRIX**3),
        "6 x 6 solution": (lambda: np.linalg.solve(small, load), len(small)),
        "transform of m, over m log2 m": (lambda: np.fft.irfft(rows, samples), transform),
        "byte": (lambda: np.copyto(there, far), 16.0 * OUTSIDE),
        "numpy call on one entry": (lambda: np.multiply(one, one, out=one), 1.0),
        "Python call": (lambda: [nothing() for _ in range(100)], 100.0),
    }


def peaks() -> dict[str, float]:
    """Seconds of one operation of each kind."""
    return {name: each_of(work, 0.02) / count for name, (work, count) in works().items()}
