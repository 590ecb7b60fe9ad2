"""A primary system with one absorber by its equations of motion, solved by hand: the truth next to
the solver of `modal.py`, which knows no closed form.

Source: Baca Vasquez (2007), eqs. 2.8 to 2.10, 3.13 and 3.14.
"""

from typing import Any

import numpy as np

from vibecalc.absorber.transfer import Absorber

#: what is read -> power of s
_POWERS = {"velocity": 1, "acceleration": 2}
#: frequency ratio that stands for rest, where what has no spring may be anywhere
_REST = 1e-30


def amplitude(
    absorber: Absorber, frequency: Any, excitation: str = "force", response: str = "displacement"
) -> np.ndarray:
    """Complex amplitude H(x) of a unit excitation; infinite on a resonance without damping.

    Arrays broadcast.
    """
    z1, m, k, z2, x = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (*absorber, frequency))
    )
    x = np.maximum(x, _REST)
    s, u = 1j * x, x * x
    locked, free = np.isinf(k) | np.isinf(z2), (k == 0.0) & (z2 == 0.0)
    g = np.where(locked, 1.0, k) + 2.0 * s * np.where(locked, 0.0, np.where(free, 0.0, z2))
    own = np.where(locked, 0.0, np.where(free, 1.0, m * u))  # of a free mass u is divided out
    first = g - own
    ground = 1.0 + 2.0 * z1 * s
    below = (ground - u) * first - np.where(free, 0.0, m * u * g)
    above = {"secondary_displacement": g, "relative_displacement": own}.get(response, first)
    factor = s ** _POWERS.get(response, 0)
    if response == "transmitted_force":
        factor = ground
        if excitation == "base":  # against the ground both masses feel their own inertia
            above = first + m * np.where(free, 0.0, g)
            factor, excitation = u * ground, "force"
    factor = factor * {"force": 1.0, "base": ground, "unbalance": u}[excitation]
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.where(below == 0.0, np.where(above == 0.0, 0.0, np.inf), above / below)
    return np.asarray(value * factor)
