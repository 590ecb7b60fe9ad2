"""A rod on two supports that overhangs the second one, and a body on its free end."""

from typing import NamedTuple

from numpy.typing import ArrayLike


class OverhungRod(NamedTuple):
    """Uniform rod, both supports letting it tilt freely (self-aligning bearings).

    Bending stiffness E I in N m^2, mass per length in kg/m, distance of the supports and length
    beyond the second one in m. One end of the rod is at the first support.
    """

    bending_stiffness: ArrayLike
    mass_per_length: ArrayLike
    span: ArrayLike
    overhang: ArrayLike


class EndBody(NamedTuple):
    """Body fixed to the free end: mass in kg, moments in kg m^2 about its mass centre.

    `diametral_inertia` about a line across the rod, `polar_inertia` about the rod. `offset` is how
    far, in m, the mass centre lies beyond the end of the rod (negative: back over it).
    """

    mass: ArrayLike
    diametral_inertia: ArrayLike = 0.0
    polar_inertia: ArrayLike = 0.0
    offset: ArrayLike = 0.0
