"""Forced response of a shaft line in long arithmetic, from the plain equations of motion."""

import mpmath as mp
import numpy as np
from exact_engine_line import solve

from vibecalc.torsion.line import Line


def exact_angles(line: Line, frequency: float, torque: np.ndarray) -> np.ndarray:
    """Angles (n,) rounded from the caller's digits."""
    w = mp.mpf(float(frequency))
    elements = zip(
        *(part.tolist() for part in (line.first, line.second)),
        *(part.tolist() for part in (line.stiffness, line.loss_factor, line.damping)),
        strict=True,
    )
    links = [(a, b, mp.mpf(k) * mp.mpc(1, eta) + mp.mpc(0, w) * c) for a, b, k, eta, c in elements]
    stations = zip(
        *(p.tolist() for p in (line.ground_stiffness, line.absolute_damping, line.inertia)),
        strict=True,
    )
    own = [mp.mpc(mp.mpf(k) - w**2 * j, w * c) for k, c, j in stations]
    right = [mp.mpc(complex(one)) for one in torque]
    return np.array([complex(one) for one in solve(own, links, right)])
