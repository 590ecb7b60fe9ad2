"""The rigid machine, with or without an inertia block bolted to it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RigidBody:
    """A rigid body, seen from the mass centre of the machine without its block.

    `mass` in kg; `centre` (3,) of all the mass, in m from the reference point; `mass_matrix`
    (6, 6) about the reference point in the order x y z rx ry rz; `inertia` (3, 3) in kg m^2 about
    `centre`.
    """

    mass: float
    centre: Array
    mass_matrix: Array
    inertia: Array


def cross_matrix(vector: Array) -> Array:
    """Matrix (3, 3) of the product `vector x`."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def point_inertia(mass: float, position: Array) -> Array:
    """Inertia (3, 3) in kg m^2 of a point mass about the origin (Huygens, Steiner)."""
    x, y, z = position
    squares = np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    products = np.outer(position, position)
    np.fill_diagonal(products, 0.0)
    return np.asarray(mass * (squares - products))


def box_inertia(mass: float, box: parts.Box) -> Array:
    """Inertia (3, 3) in kg m^2 of a uniform block about its own centre."""
    x, y, z = box.length, box.width, box.height
    squares = np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    return np.asarray(squares * (mass / 12.0))


def own_mass(body: parts.Body) -> float:
    """Mass in kg of the machine without its block; a body given as a matrix has none."""
    if body.mass is None:
        raise ValueError("the body is given as a matrix")
    return float(body.mass)


def machine_inertia(body: parts.Body) -> Array:
    """Inertia (3, 3) in kg m^2 of the machine without its block, about its mass centre."""
    if body.inertia is None:
        if body.box is None:
            raise ValueError("a body needs a box or moments of inertia")
        return box_inertia(own_mass(body), body.box)
    xy, xz, yz = body.inertia_products
    off_diagonal = np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]])
    return np.asarray(np.diag(body.inertia) - off_diagonal)


def build_body(body: parts.Body) -> RigidBody:
    """Mass matrix of a validated body; a block adds its mass, its inertia and a static moment.

    The kinetic energy is m v.v/2 + v.(w x S) + w.J w/2 with v of the reference point, the static
    moment S and the inertia J about that point (Goldstein, Classical Mechanics, ch. 5).
    """
    own = machine_inertia(body)
    block = body.inertia_block
    added = 0.0 if block is None else block.mass
    if block is None or added == 0.0:
        place, block_inertia = np.zeros(3), np.zeros((3, 3))
    else:
        place, block_inertia = np.array(block.position), box_inertia(added, block.box)
    bare = own_mass(body)
    mass = bare + added
    static_moment = added * place
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = mass * np.eye(3)
    matrix[:3, 3:] = -cross_matrix(static_moment)
    matrix[3:, :3] = matrix[:3, 3:].T
    matrix[3:, 3:] = own + block_inertia + point_inertia(added, place)
    # Two masses about their common centre act as the reduced mass: no difference of large terms.
    reduced = added * (bare / mass)
    return RigidBody(
        mass=mass,
        centre=static_moment / mass,
        mass_matrix=matrix,
        inertia=own + block_inertia + point_inertia(reduced, place),
    )
