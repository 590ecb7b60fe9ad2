"""Results of a body that is assembled of parts."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, q
from vibecalc.core.results.record import CANCELLING, Headline


class OfParts(Group):
    """What the parts of the body add up to."""

    ROOT: ClassVar[str] = "body"
    mass: Any = q("", "kg", "mass of all parts", headline=Headline("mass of the body", "kg"))
    centre: Any = q(
        "direction", "m", "common mass centre, from the reference point", exempt=CANCELLING
    )
    moments: Any = q("direction", "kg*m^2", "moments of inertia about the mass centre")
    products: Any = q(
        "product", "kg*m^2",
        "products of inertia about the mass centre: sums of m x y, m x z, m y z",
        exempt=CANCELLING,
    )  # fmt: skip
    principal_moments: Any = q("principal", "kg*m^2", "principal moments of inertia")
    principal_axes: Any = q(
        "principal direction", "", "unit vector of a principal axis, its largest entry positive"
    )


AXES = {
    "product": ("", "pair of axes of a product of inertia"),
    "principal": ("", "principal axis of inertia, smallest moment first"),
}
NAMES = {"product": ("xy", "xz", "yz")}
ENTRIES = tuple(entries_of(OfParts))
