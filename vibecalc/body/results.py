"""Results of a body that is assembled of parts."""

from vibecalc.core.results.record import CANCELLING, Headline, entry

ROOT = "body"
AXES = {
    "product": ("", "pair of axes of a product of inertia"),
    "principal": ("", "principal axis of inertia, least moment first"),
}
NAMES = {"product": ("xy", "xz", "yz")}
ENTRIES = (
    entry(
        f"{ROOT}/mass", "", "kg", "mass of all parts", headline=Headline("mass of the body", "kg")
    ),
    entry(
        f"{ROOT}/centre",
        "direction",
        "m",
        "common mass centre, from the reference point",
        exempt=CANCELLING,
    ),
    entry(f"{ROOT}/moments", "direction", "kg*m^2", "moments of inertia about the mass centre"),
    entry(
        f"{ROOT}/products",
        "product",
        "kg*m^2",
        "products of inertia about the mass centre: sums of m x y, m x z, m y z",
        exempt=CANCELLING,
    ),
    entry(f"{ROOT}/principal_moments", "principal", "kg*m^2", "principal moments of inertia"),
    entry(
        f"{ROOT}/principal_axes",
        "principal direction",
        "",
        "unit vector of a principal axis, its largest entry positive",
    ),
)
