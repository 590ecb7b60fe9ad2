"""The body and what it stands on, as a case writes them."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    DampingOrThree,
    Inertia,
    Length,
    Mass,
    Name,
    Number,
    Point,
    StiffnessOrThree,
    Table,
    Unit,
    key,
    later,
)
from vibecalc.core.case.raw import Data, misspelt, read_number, table_at, tables_at
from vibecalc.core.case.rules import Row, Rule, at_most_one, needs, one_of, refuse, unique
from vibecalc.errors import Problem

if TYPE_CHECKING:
    from vibecalc.parts.matrix_tables import DampingMatrix, MassMatrix, StiffnessMatrix
    from vibecalc.parts.mount_tables import OverFrequency, OverLoad, Static
else:
    globals().update(
        later(
            {
                "vibecalc.parts.matrix_tables": "DampingMatrix MassMatrix StiffnessMatrix",
                "vibecalc.parts.mount_tables": "OverFrequency OverLoad Static",
            }
        )
    )

# ----------------------------------------------------------------------------
# The rigid machine, its inertia block, its mounts.
# ----------------------------------------------------------------------------


class Box(Table):
    """A uniform block, edges along x, y and z."""

    length: Length = key("edge along x", gt=0)
    width: Length = key("edge along y", gt=0)
    height: Length = key("edge along z", gt=0)


class InertiaBlock(Table):
    """A block bolted to the body, with its mass, inertia and weight."""

    mass: Mass = key("mass of the block", ge=0)
    box: Box = key("its edges, for its own inertia")
    position: Point = key("of its mass centre, from the body's reference point", (0.0, 0.0, 0.0))


Moment3 = Annotated[float, Field(gt=0), Unit("kg*m^2")]
#: of a part of the body, which may be a point
PartMoment = Annotated[float, Field(ge=0), Unit("kg*m^2")]


def _numbers_said(row: Row) -> bool:
    """Whether the body is one of mass and inertia: not of parts, nor of a matrix with a slip."""
    complete = "mass" in row and not row.data.keys().isdisjoint({"inertia", "box"})
    return row.data.keys().isdisjoint({"mass_matrix", "parts"}) and (
        complete or not misspelt(row.data, row.path, "mass_matrix", "parts")
    )


def _products_of_a_box(row: Row) -> bool:
    return "box" in row and any(read_number(x, "kg*m^2") for x in row.entries("inertia_products"))


_BOX_HAS_NONE = "inertia_products go with inertia: a box has none"


class BodyPart(Table):
    """One part of the body: an engine, a generator, a skid, a block."""

    name: Name = key("label used in messages")
    mass: Mass = key("of the part", gt=0)
    centre: Point = key("its mass centre, from the body's reference point")
    box: Box | None = key("inertia from a uniform block; or give inertia", None)
    inertia: tuple[PartMoment, PartMoment, PartMoment] | None = key(
        "moments Ixx, Iyy, Izz about its own mass centre; zeros for a point", None
    )
    inertia_products: tuple[Inertia, Inertia, Inertia] = key(
        "products Ixy, Ixz, Iyz: sums of m x y, m x z, m y z", (0.0, 0.0, 0.0)
    )
    RULES = (
        one_of("inertia", "box"),
        refuse("inertia_products", _BOX_HAS_NONE, _products_of_a_box, also="box"),
    )


class Body(Table):
    """The rigid machine. All places are measured from its reference point.

    That is the mass centre without the inertia block, unless `centre` or the parts say otherwise.
    """

    mass: Mass | None = key("of the whole machine", None, gt=0)
    centre: Point | None = key(
        "its mass centre without the block, from the reference point; default: there", None
    )
    box: Box | None = key("inertia from a uniform block; or give inertia", None)
    inertia: tuple[Moment3, Moment3, Moment3] | None = key(
        "moments Ixx, Iyy, Izz about the mass centre", None
    )
    inertia_products: tuple[Inertia, Inertia, Inertia] = key(
        "products Ixy, Ixz, Iyz: sums of m x y, m x z, m y z", (0.0, 0.0, 0.0)
    )
    inertia_block: InertiaBlock | None = key("a block added to the machine", None)
    parts: tuple[BodyPart, ...] | None = key(
        "parts that it is assembled from, instead of all of these",
        None,
        min_length=1,
        max_length=64,
    )
    mass_matrix: MassMatrix | None = key("of the whole machine, instead of all of these", None)
    RULES = (
        at_most_one(
            "mass_matrix", "mass centre box inertia inertia_products inertia_block", "parts"
        ),
        needs(
            "",
            "mass mass_matrix parts",
            allowed="a mass > 0 kg, e.g. '0.4 kg' or '400 g', or [[machine.body.parts]]",
        ),
        one_of("inertia", "box", when=_numbers_said),
        refuse(
            "inertia_products",
            _BOX_HAS_NONE,
            lambda t: _numbers_said(t) and _products_of_a_box(t),
            also="box",
        ),
        unique("parts"),
    )


class MountProperties(Table):
    """Stiffness and damping, one number for all directions or three along the mount's own axes."""

    stiffness: StiffnessOrThree | None = key(
        "one number, or three along the mount's own axes", None
    )
    damping: DampingOrThree | None = key(
        "viscous, one number or three along the mount's own axes", None
    )
    loss_factor: Number | None = key(
        "of a complex stiffness k (1 + i loss_factor)", None, ge=0, le=10
    )
    static: Static | None = key("static stiffness, load over deflection, stops", None)
    over_frequency: OverFrequency | None = key(
        "stiffness and loss factor over frequency: a table or a CSV", None
    )
    over_load: OverLoad | None = key("stiffness over the static load: a table or a CSV", None)


class Mount(MountProperties):
    """One mount; keys it lacks come from `each`."""

    name: Name = key("label in tables and `where`")
    position: Point = key("from the body's reference point")
    orientation: tuple[Angle, Angle, Angle] = key(
        "rotations of the mount's axes about x, then y, then z", (0.0, 0.0, 0.0)
    )


_WITH_MATRIX = ("damping_matrix", "loss_factor")
_FOR_A_MATRIX = "mounts with positions have theirs in [machine.mounts.each] or individually"


def _mounts_needed(row: Row) -> bool:
    return row.data.keys().isdisjoint(_WITH_MATRIX)


def _stiff(mount: Data) -> bool:
    """Whether a stiffness stands here, in rows, or along the axis as load over deflection."""
    return (
        "stiffness" in mount
        or "load_deflection" in table_at(mount, "static")
        or any(
            "stiffness" in table_at(mount, rows) or isinstance(mount.get(rows), str)
            for rows in ("over_frequency", "over_load")
        )
    )


def _no_stiffness(row: Row) -> Iterator[Problem]:
    """The stiffness of mounts stands in `each`, or on each of them."""
    each = table_at(row.data, "each")
    known = _stiff(each) or "stiffness_matrix" in row
    if known or not isinstance(row.data.get("each", {}), dict):
        return
    if "positions" in row:
        yield row.problem(
            "each" if each else "",
            "mounts given by positions have no stiffness",
            allowed="each = { stiffness = ... }",
        )
    for place, mount in tables_at(row.data, "individual"):
        if not _stiff(mount):
            yield row.problem(
                (*row.path, "individual", place),
                f"mount {mount.get('name', place + 1)!r} has no stiffness",
                allowed="a stiffness of its own, or one in [machine.mounts.each]",
            )


class Mounts(Table):
    """Mounts below the body."""

    each: MountProperties | None = key("common to all mounts", None)
    positions: tuple[Point, ...] | None = key(
        "of equal mounts, named 1, 2, 3 ...", None, min_length=1, max_length=256
    )
    individual: tuple[Mount, ...] | None = key(
        "mounts one by one, instead of positions", None, min_length=1, max_length=256
    )
    datum: Point | None = key(
        "origin of the mounts' positions; default: the body's reference point", None
    )
    stiffness_matrix: StiffnessMatrix | None = key(
        "of the whole suspension, instead of mounts", None
    )
    damping_matrix: DampingMatrix | None = key(
        "of the whole suspension, with stiffness_matrix", None
    )
    loss_factor: Number | None = key(
        "of a complex stiffness_matrix K (1 + i loss_factor)", None, ge=0, le=10
    )
    modal_damping: Number | None = key("damping ratio added to every mode", None, ge=0, le=10)
    RULES = (
        one_of(
            "stiffness_matrix",
            "positions",
            "individual",
            when=_mounts_needed,
            allowed="positions of equal mounts, individual mounts, or one stiffness_matrix",
        ),
        at_most_one("stiffness_matrix", "each datum"),
        *(needs(key, "stiffness_matrix", _FOR_A_MATRIX) for key in _WITH_MATRIX),
        unique("individual"),
        _no_stiffness,
    )


def _no_matrix(part: str, matrix: str, instead: str, hint: str) -> Rule:
    return refuse(
        "",
        f"{{header}} needs {instead}, not a {matrix}",
        lambda t: matrix in table_at(t.machine, part),
        hint=hint,
        also=("machine", part, matrix),
    )


def no_matrices(hint: str = "") -> list[Rule]:
    """Of a table that needs the mass of the body and its mounts one by one."""
    return [
        _no_matrix("body", "mass_matrix", "a body with mass and inertia", hint),
        _no_matrix("mounts", "stiffness_matrix", "mounts with positions", hint),
    ]


#: directions about the axes
TURNS = ("rx", "ry", "rz")


def along_or_about(
    linear: str, about: str, angular: str, along: str, allowed: str = ""
) -> list[Rule]:
    """Keys for a `direction` along an axis, and those for one about an axis.

    `about` are the words for a `linear` key with a direction about an axis, `along` those for an
    `angular` one with a direction along it.
    """

    def met(directions: tuple[str, ...], keys: str) -> Callable[[Row], bool]:
        return lambda t: t["direction"] in directions and any(key in t for key in keys.split())

    said = "direction = '{direction}'"
    return [
        refuse("direction", about, met(TURNS, linear), allowed, found=said),
        refuse("direction", along, met(("x", "y", "z"), angular), "rx, ry or rz", found=said),
    ]
