"""Tunings in closed form, and the primary damping from which no absorber lowers the peak."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Tunings in closed form, each with the name it goes by and what it holds for.
# ----------------------------------------------------------------------------


class ClosedForm(NamedTuple):
    """k, z2 and the largest |H| with that tuning (...), its absolute error, and what was said.

    `promised` is the peak that the formula itself gives: the true one for an exact formula, the
    height of the fixed points for the others.
    """

    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    largest: np.ndarray
    largest_error: np.ndarray
    promised: np.ndarray


class Method(NamedTuple):
    """A formula: m -> k, z2, promised peak; the responses it is for, and how far to trust it."""

    formula: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
    excitation: str
    response: str
    exact: bool
    validity: str
    source: str


def den_hartog(m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Equal fixed points, k = m / (1 + m)^2; damping by Brock's mean of the two slopes."""
    k = m / np.square(1.0 + m)
    z2 = m * np.sqrt(3.0 * m / (8.0 * (1.0 + m) ** 3))
    return k, z2, np.sqrt(1.0 + 2.0 / m)


def nishihara_asami(m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The exact minimax for an undamped primary, with the differences of like numbers removed."""
    root = np.sqrt(4.0 + 3.0 * m)
    tuning = (
        8.0 * (16.0 + 23.0 * m + 9.0 * m * m + 2.0 * (2.0 + m) * root)
        / (3.0 * (64.0 + 80.0 * m + 27.0 * m * m)) / np.square(1.0 + m)
    )  # fmt: skip
    ratio = np.sqrt(3.0 * m * (32.0 + 27.0 * m) / ((8.0 + 9.0 * m + 4.0 * root) * (1.0 + m))) / 4.0
    above = 4096.0 + m * (10240.0 + m * (9856.0 + m * (4320.0 + 729.0 * m)))
    below = 1024.0 + m * (2880.0 + m * (2592.0 + 729.0 * m)) + 128.0 * root**3
    return m * tuning, ratio * m * np.sqrt(tuning), np.sqrt(above / (m * below))


def warburton_acceleration(m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Equal fixed points of x^2 H: unbalance and displacement, or force and acceleration."""
    k = m / (1.0 + m)
    z2 = m * np.sqrt(3.0 * m / (8.0 * (1.0 + m / 2.0))) / np.sqrt(1.0 + m)
    return k, z2, np.sqrt(2.0 / (m * (1.0 + m)))


def lanchester(m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pure viscous damper (k = 0): the peak stands on the only fixed point. Exact."""
    z2 = m / np.sqrt(2.0 * (1.0 + m) * (2.0 + m))
    return np.zeros_like(m), z2, 1.0 + 2.0 / m


#: formulas by name; all of them for an undamped primary
METHODS = {
    "den_hartog_brock": Method(
        den_hartog, "force", "displacement", False,
        "undamped primary; actual peak about m / 60 above the predicted one",
        "Den Hartog, Mechanical Vibrations (1956); J. E. Brock, J. Appl. Mech. 13 (1946)",
    ),
    "nishihara_asami": Method(
        nishihara_asami, "force", "displacement", True,
        "undamped primary, any mass ratio; base motion to displacement and force to the ground too",
        "O. Nishihara and T. Asami, J. Vib. Acoust. 124 (2002)",
    ),
    "warburton_acceleration": Method(
        warburton_acceleration, "force", "acceleration", False,
        "undamped primary; unbalance to displacement too; small mass ratios",
        "G. B. Warburton, Earthq. Eng. Struct. Dyn. 10 (1982)",
    ),
    "lanchester": Method(
        lanchester, "force", "displacement", True, "undamped primary, no spring",
        "F. W. Lanchester (1914); J. P. Den Hartog, Mechanical Vibrations (1956)",
    ),
}  # fmt: skip


def closed_form(
    name: str, mass_ratio: ArrayLike, primary_damping: ArrayLike = 0.0,
    excitation: str | None = None, response: str | None = None,
) -> ClosedForm:  # fmt: skip
    """Tuning by a named formula, and the peak it really gives.

    With a damped primary the tuning is that of the undamped one and the peak the true one with
    damping; `promised` stays what the formula says. Raises NumericalFailure on an unknown name
    and on mass ratios that are not positive and finite.
    """
    if name not in METHODS:
        raise NumericalFailure(f"no closed form {name!r}; known: {', '.join(METHODS)}")
    method = METHODS[name]
    m, z1 = np.broadcast_arrays(
        np.asarray(mass_ratio, dtype=float), np.asarray(primary_damping, dtype=float)
    )
    if not np.all((m > 0.0) & np.isfinite(m)):
        raise NumericalFailure("a tuning needs mass ratios above 0 and below infinity")
    asked = excitation or method.excitation, response or method.response
    transfer_of(*asked)
    k, z2, promised = method.formula(m)
    there = peaks(Absorber(z1, m, k, z2), *asked)
    # rounding of k moves a peak along a slope of about its own height, rounding of z2 does not
    slope = np.where(k > 0.0, there.largest, 0.0)
    slack = 16.0 * UNIT_ROUNDOFF * there.largest * (1.0 + slope)
    return ClosedForm(k, z2, there.largest, there.largest_error + slack, promised)


# ----------------------------------------------------------------------------
# How much damping of the primary system leaves nothing to gain from an absorber: largest response.
#
# Where the largest response lies at a finite frequency, a weak damper on a free secondary lowers
# it: to first order |H| changes by the factor 1 - 4 z1 z2 x^2 / |1 - x^2 + 2 i z1 x|^2, below one.
# It is of no use where the largest response is the limit at x = 0 (nothing but K1 acts) or at x ->
# infinity (nothing but J1 acts), which no spring and damper to a secondary changes. The threshold
# is the damping at which the primary system alone comes down to that limit, and so is the same for
# every mass ratio.
# ----------------------------------------------------------------------------


class Threshold(NamedTuple):
    """`primary_damping` from which on no absorber helps: infinite (none), a number, or zero.

    `exact` is the number in words, `why` the reason. `bounded_damped`: the largest response is
    finite with a damped primary system; where it is not, there is no optimum to be had.
    """

    primary_damping: float
    exact: str
    why: str
    bounded_damped: bool = True


_NONE = "the peak lies at a finite frequency for every damping, and a weak damper lowers it"
_SLOW = "from there on the largest response is the static one, which no absorber changes"
_FAST = (
    "from there on the largest response is the limit at high frequency, where the inertia J1 acts "
    "alone; only a mass fastened rigidly lowers it, to 1 / (1 + m) of it"
)
_GROWS = "with damping in the primary system the response grows with frequency without bound"
_ALWAYS = "the response grows with frequency without bound, damped or not"
_ROOT = 1.0 / math.sqrt(2.0)
_NEVER = Threshold(math.inf, "none", _NONE)
_UNBOUND = Threshold(0.0, "0", _GROWS, False)

_TABLE = {
    ("force", "displacement"): Threshold(_ROOT, "1 / sqrt 2", _SLOW),
    ("force", "velocity"): _NEVER,
    ("force", "acceleration"): Threshold(_ROOT, "1 / sqrt 2", _FAST),
    ("force", "transmitted_force"): _NEVER,
    ("base", "displacement"): _NEVER,
    ("base", "velocity"): Threshold(
        0.5 * math.sqrt(1.0 + math.sqrt(2.0)), "sqrt(1 + sqrt 2) / 2",
        "from there on the largest response is the limit 2 z1 at high frequency, where c1 drives J1"
        " alone; only a mass fastened rigidly lowers it",
    ),
    ("base", "acceleration"): _UNBOUND,
    ("base", "transmitted_force"): _UNBOUND,
    ("unbalance", "displacement"): Threshold(_ROOT, "1 / sqrt 2", _FAST),
    ("unbalance", "velocity"): Threshold(0.0, "0", _ALWAYS, False),
    ("unbalance", "acceleration"): Threshold(0.0, "0", _ALWAYS, False),
    ("unbalance", "transmitted_force"): _UNBOUND,
}  # fmt: skip


def threshold(excitation: str = "force", response: str = "displacement") -> Threshold:
    """Threshold for the largest response (H-infinity), the same for every mass ratio.

    Raises NumericalFailure for a response of the secondary: locked, it has no relative motion,
    and its own motion is not what an absorber is for.
    """
    transfer_of(excitation, response)  # refuses unknown names
    found = _TABLE.get((excitation, response))
    if found is None:
        raise NumericalFailure(f"{response} is no response of the primary system: no threshold")
    return found
