"""The lean of the connecting rod, and Fourier coefficients, in many digits.

Written without anything from the package. Numbers are mpmath's, at the caller's precision.
"""

from collections.abc import Callable, Sequence

import mpmath
from mpmath import mpc, mpf


def fourier(signal: Callable[[mpf], mpf], orders: Sequence[int], samples: int) -> list[mpc]:
    """C_n of Re sum C_n exp(i n t) by the trapezoidal rule."""
    values = [signal(2 * mpmath.pi * j / samples) for j in range(samples)]
    waves = [mpmath.expjpi(mpf(-2) * j / samples) for j in range(samples)]
    found = []
    for n in orders:
        total = mpmath.fdot(values, [waves[n * j % samples] for j in range(samples)])
        found.append(total * (1 if n == 0 else 2) / samples)
    return found


def rod_angle(angle: mpf, radius: mpf, length: mpf, offset: mpf) -> mpf:
    """phi, from sin phi = (R sin t - e) / L."""
    return mpmath.asin((radius * mpmath.sin(angle) - offset) / length)
