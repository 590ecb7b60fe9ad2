"""A sprung and damped primary system with one absorber: its ratios and what may be asked of it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure


class Absorber(NamedTuple):
    """The four ratios of primary and secondary system; arrays that broadcast.

    `primary_damping` z1 = c1 / (2 sqrt(K1 J1)), `mass_ratio` m = J2 / J1, `stiffness_ratio`
    k = K2 / K1 and `secondary_damping` z2 = c2 / (2 sqrt(K1 J1)), a coefficient referred to the
    primary system, so that it keeps its meaning at k = 0. Zero and infinite k and z2 are limits:
    an infinite one locks the secondary to the primary, two zeros set it free.
    """

    primary_damping: ArrayLike
    mass_ratio: ArrayLike
    stiffness_ratio: ArrayLike
    secondary_damping: ArrayLike


class Transfer(NamedTuple):
    """H = sign s^power (1 + 2 z1 s)^ground M(s) / D(s), s = i x; M by its name.

    `motion` is "primary" for N1 = m s^2 + g, "secondary" for g = k + 2 z2 s, "relative" for
    secondary less primary, -m s^2, and "ground" for N1 + m g.
    """

    sign: float
    power: int
    ground: int
    motion: str


_RESPONSES = {
    "displacement": Transfer(1.0, 0, 0, "primary"),
    "velocity": Transfer(1.0, 1, 0, "primary"),
    "acceleration": Transfer(1.0, 2, 0, "primary"),
    "transmitted_force": Transfer(1.0, 0, 1, "primary"),
    "secondary_displacement": Transfer(1.0, 0, 0, "secondary"),
    "relative_displacement": Transfer(1.0, 0, 0, "relative"),
}

#: what drives the system
EXCITATIONS = ("force", "base", "unbalance")
#: what is read: of the primary system, except for the last two
RESPONSES = tuple(_RESPONSES)


def transfer_of(excitation: str, response: str) -> Transfer:
    """What divides what for one pair of excitation and response.

    Amplitudes are relative to T0 / K1 for a force of amplitude T0, to the amplitude Y of the
    ground's motion, and to T0 / K1 with T0 = m_u r w1^2 for a rotating unbalance m_u r (the force
    grows with x^2). Velocity and acceleration are further divided by w1 and w1^2; the transmitted
    force, on the ground through K1 and c1, by T0, K1 Y and m_u r w1^2.
    Raises NumericalFailure on an unknown name.
    """
    if excitation not in EXCITATIONS or response not in _RESPONSES:
        raise NumericalFailure(
            f"no response {response!r} to {excitation!r}; excitations: {', '.join(EXCITATIONS)}; "
            f"responses: {', '.join(RESPONSES)}"
        )
    plain = _RESPONSES[response]
    if excitation == "base":
        if response == "transmitted_force":  # (1 + 2 z1 s) (theta1 - y), by the ground's motion
            return Transfer(-1.0, 2, 1, "ground")
        return plain._replace(ground=plain.ground + 1)
    if excitation == "unbalance":  # the force is x^2 = -s^2
        return plain._replace(sign=-1.0, power=plain.power + 2)
    return plain


def damping_from_own_ratio(
    ratio: ArrayLike, mass_ratio: ArrayLike, stiffness_ratio: ArrayLike
) -> np.ndarray:
    """z2 from the ratio on the secondary's own frequency, c2 / (2 J2 w2): z2 = ratio sqrt(m k).

    Source: Baca Vasquez (2007), eq. 2.7; meaningless at k = 0.
    """
    own = np.sqrt(np.multiply(mass_ratio, stiffness_ratio))
    damping: np.ndarray = np.asarray(ratio, dtype=float) * own
    return damping


def damping_from_primary_ratio(ratio: ArrayLike, mass_ratio: ArrayLike) -> np.ndarray:
    """z2 from c2 / (2 J2 w1), as eq. 3.13 uses it: z2 = ratio m.

    Eq. 3.12 of the source prints J1 for J2; its Table 3.2 follows eq. 3.13, its Table 3.9 eq. 3.12.
    """
    damping: np.ndarray = np.asarray(ratio, dtype=float) * np.asarray(mass_ratio, dtype=float)
    return damping


def own_damping_ratio(absorber: Absorber) -> np.ndarray:
    """c2 / (2 J2 w2) = z2 / sqrt(m k): eps2 of eq. 2.7. Infinite at k = 0 with z2 > 0."""
    root = np.sqrt(np.multiply(absorber.mass_ratio, absorber.stiffness_ratio))
    damping = np.asarray(absorber.secondary_damping, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: np.ndarray = np.where(damping == 0.0, 0.0, damping / root)
    return ratio
