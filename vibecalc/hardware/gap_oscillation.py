"""How far an oscillating wall is from dragging its film as if it moved steadily.

A wall that oscillates with the angular frequency w over a film of thickness h on a resting wall
feels z coth z times the steady shear, z^2 = i w h^2 / nu (Stokes's layer between walls). The real
part multiplies the damping, 1 + (w h^2/nu)^2 / 45 + ...; the imaginary part is inertia, a third of
the film that moves with the wall while the film is thin.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray

#: beyond this real part of z, coth z is 1 to rounding
_DEEP = 20.0

#: below this |z|^2 the Taylor series of z coth z is used
_NEAR = 0.05

#: coefficients of z coth z in powers of z^2
_SERIES = (1.0, 1.0 / 3.0, -1.0 / 45.0, 2.0 / 945.0, -1.0 / 4725.0, 2.0 / 93555.0,
           -1382.0 / 638512875.0, 4.0 / 18243225.0)  # fmt: skip


class FilmFactor(NamedTuple):
    """Damping over that of steady shear, and inertia times frequency over the same; error of both.

    A film with a steady damping c adds c * inertia / frequency to the moment of inertia.
    """

    damping: FloatArray
    inertia: FloatArray
    error: FloatArray


def film_factor(
    frequency: ArrayLike, clearance: ArrayLike, kinematic_viscosity: ArrayLike
) -> FilmFactor:
    """Factor at an angular frequency (rad/s), clearance (m) and kinematic viscosity (m^2/s)."""
    speed, thin, thick = floats(frequency, clearance, kinematic_viscosity)
    square = 1j * speed * thin * thin / thick
    root = np.sqrt(square)
    near = np.abs(square) < _NEAR
    series = np.polynomial.polynomial.polyval(np.where(near, square, 0.0), np.array(_SERIES))
    safe = np.where(near | (root.real > _DEEP), 1.0, root)
    far = np.where(root.real > _DEEP, root, safe / np.tanh(safe))
    factor = np.where(near, series, far)
    error = 16.0 * UNIT_ROUNDOFF * np.abs(factor) + np.where(near, 3e-5 * _NEAR**8, 0.0)
    return FilmFactor(factor.real, factor.imag, np.asarray(error))
