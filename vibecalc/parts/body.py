"""The rigid machine in its axes, with its inertia block, and whether such a body exists."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import KeyPath, Problem
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts import body_tables as parts
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Directions of a crank train in the body's axes x, y, z.
# ----------------------------------------------------------------------------

DIRECTIONS = ("x", "y", "z")


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Right-handed unit vectors (3,): the crank turns right-handed about `axis`.

    `stroke` points up a cylinder at bank angle zero and `across = stroke x axis`, so that a throw
    that has turned by 90 degrees from the stroke points along `-across`.
    """

    axis: NDArray[np.float64]
    stroke: NDArray[np.float64]
    across: NDArray[np.float64]


def unit_vector(name: str) -> NDArray[np.float64]:
    """Unit vector (3,) along the body axis called `x`, `y` or `z`."""
    vector = np.zeros(3)
    vector[DIRECTIONS.index(name)] = 1.0
    return vector


@functools.lru_cache(maxsize=9)
def build_frame(axis: str, stroke: str) -> Frame:
    """Frame of a train from the names of its crankshaft axis and stroke, which differ."""
    along, up = unit_vector(axis), unit_vector(stroke)
    frame = Frame(axis=along, stroke=up, across=np.cross(up, along))
    for vector in (frame.axis, frame.stroke, frame.across):
        vector.flags.writeable = False  # every machine of these directions shares them
    return frame


# ----------------------------------------------------------------------------
# The rigid machine, with or without an inertia block bolted to it.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RigidBody:
    """A rigid body, seen from the mass centre of the machine without its block.

    `mass` in kg; `centre` (3,) of all the mass, in m from the reference point; `mass_matrix`
    (6, 6) about the reference point in the order x y z rx ry rz; `inertia` (3, 3) in kg m^2 about
    `centre`. Where numbers of the case are arrays (points,), so are these with a leading axis.
    """

    mass: float
    centre: Array
    mass_matrix: Array
    inertia: Array


def cross_matrix(vector: Array) -> Array:
    """Matrix (..., 3, 3) of the product `vector x`, for vectors (..., 3)."""
    x, y, z = np.moveaxis(vector, -1, 0)
    none = np.zeros(np.shape(x))
    rows = ([none, -z, y], [z, none, -x], [-y, x, none])
    return side_by_side([side_by_side(row) for row in rows], own=1)


def _diagonal(entries: Sequence[float | Array]) -> Array:
    """Matrix (..., 3, 3) of three numbers or arrays (...) on its diagonal."""
    return np.asarray(side_by_side(entries)[..., None, :] * np.eye(3))


def _sums_of_squares(x: Any, y: Any, z: Any) -> Array:
    return _diagonal([y * y + z * z, x * x + z * z, x * x + y * y])


def point_inertia(mass: float | Array, position: Array) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of point masses about the origin (Huygens, Steiner)."""
    products = position[..., :, None] * position[..., None, :] * (1.0 - np.eye(3))
    squares = _sums_of_squares(*np.moveaxis(position, -1, 0))
    return np.asarray(np.asarray(mass)[..., None, None] * (squares - products))


def box_inertia(mass: float | Array, box: parts.Box) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of a uniform block about its own centre."""
    twelfth = np.asarray(mass / 12.0)[..., None, None]
    return np.asarray(_sums_of_squares(box.length, box.width, box.height) * twelfth)


def bare_mass(body: parts.Body) -> float:
    """Mass in kg of the machine without its block; a body given as a matrix has none."""
    if body.mass is None:
        raise ValueError("the body is given as a matrix")
    return body.mass


def machine_inertia(body: parts.Body) -> Array:
    """Inertia (..., 3, 3) in kg m^2 of the machine without its block, about its mass centre."""
    if body.inertia is None:
        if body.box is None:
            raise ValueError("a body needs a box or moments of inertia")
        return box_inertia(bare_mass(body), body.box)
    xy, xz, yz = body.inertia_products
    rows = ([0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0])
    off_diagonal = side_by_side([side_by_side(row) for row in rows], own=1)
    return np.asarray(_diagonal(body.inertia) - off_diagonal)


def build_body(body: parts.Body) -> RigidBody:
    """Mass matrix of a validated body; a block adds its mass, its inertia and a static moment.

    The kinetic energy is m v.v/2 + v.(w x S) + w.J w/2 with v of the reference point, the static
    moment S and the inertia J about that point (Goldstein, Classical Mechanics, ch. 5).
    """
    bare_inertia = machine_inertia(body)
    block = body.inertia_block
    added = 0.0 if block is None else block.mass
    if block is None or not np.any(added):
        place, block_inertia = np.zeros(3), np.zeros((3, 3))
    else:
        place, block_inertia = side_by_side(block.position), box_inertia(added, block.box)
    bare = bare_mass(body)
    mass = np.asarray(bare + added)
    static_moment = np.asarray(added)[..., None] * place
    about_reference = bare_inertia + block_inertia + point_inertia(added, place)
    points = np.broadcast_shapes(mass.shape, static_moment.shape[:-1], about_reference.shape[:-2])
    matrix = np.zeros((*points, 6, 6))
    matrix[..., :3, :3] = mass[..., None, None] * np.eye(3)
    matrix[..., :3, 3:] = -cross_matrix(static_moment)
    matrix[..., 3:, :3] = np.swapaxes(matrix[..., :3, 3:], -1, -2)
    matrix[..., 3:, 3:] = about_reference
    # Two masses about their common centre act as the reduced mass: no difference of large terms.
    reduced = added * (bare / mass)
    return RigidBody(
        mass=bare + added,
        centre=static_moment / mass[..., None],
        mass_matrix=matrix,
        inertia=bare_inertia + block_inertia + point_inertia(reduced, place),
    )


# ----------------------------------------------------------------------------
# Is there a body with these moments of inertia?
# ----------------------------------------------------------------------------

BODY: KeyPath = ("machine", "body")
#: Slack of the triangle inequality, relative: flat bodies are on its edge, digits are rounded.
SLACK = 1e-6


def body_problems(case: Case) -> list[Problem]:
    """Problems of the moments and products of inertia."""
    body = case.machine.body
    if body is None or body.inertia is None:
        return []
    with_products = any(body.inertia_products)
    principal = np.linalg.eigvalsh(machine_inertia(body))
    shown = ", ".join(f"{moment:.6g}" for moment in principal)
    if principal[0] <= 1e-12 * principal[2]:
        return [
            Problem(
                path=(*BODY, "inertia_products"),
                message="no body has these products of inertia: they are too large for its moments",
                found=f"principal moments of {shown} kg*m^2",
                allowed="all principal moments > 0",
                also=(*BODY, "inertia"),
            )
        ]
    if principal[2] > (principal[0] + principal[1]) * (1.0 + SLACK):
        what = "principal moments" if with_products else "moments"
        return [
            Problem(
                path=(*BODY, "inertia"),
                message="no body has these moments of inertia: the largest must not exceed the "
                "sum of the other two",
                found=f"{what} of {shown} kg*m^2",
                allowed=f"the largest at most {principal[0] + principal[1]:.6g} kg*m^2",
            )
        ]
    return []


def body_suspects(case: Case) -> BoolArray:
    """Points (...) of a case with arrays that `body_problems` may refuse: its bounds, narrower."""
    body = case.machine.body
    if body is None or body.inertia is None:
        return np.zeros((), dtype=bool)
    matrix = machine_inertia(body)
    finite = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    principal = np.linalg.eigvalsh(np.where(finite[..., None, None], matrix, np.eye(3)))
    low, middle, high = np.moveaxis(principal, -1, 0)
    positive = np.all(np.diagonal(matrix, axis1=-2, axis2=-1) > 0.0, axis=-1)
    flat = high <= (low + middle) * (1.0 + 0.9 * SLACK)
    return np.asarray(~(finite & positive & (low > 1e-11 * high) & flat))
