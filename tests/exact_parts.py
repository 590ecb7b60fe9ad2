"""Body and mounts of a case in many digits, every term written out.

Written for tests from docs/theory.md and docs/theory_mounts.md, without anything from the package
but the case.
"""

from typing import NamedTuple

import mpmath
import numpy as np
from exact_train import DIRECTIONS, Vector, vector
from mpmath import mpf

from vibecalc.parts import body_tables as parts
from vibecalc.schema import Case


class Mount(NamedTuple):
    """One mount: position (3,), and stiffness, damping and loss (3, 3) in the body's axes."""

    position: Vector
    stiffness: np.ndarray
    damping: np.ndarray
    loss: np.ndarray


class Body(NamedTuple):
    """Mass, its centre (3,), inertia (3, 3) about the reference point, all with the block."""

    mass: mpf
    centre: Vector
    inertia: np.ndarray


def matrix(rows: list[list[object]]) -> np.ndarray:
    """An object array of mpmath numbers."""
    return np.array([vector(*row) for row in rows], dtype=object)


def point_inertia(mass: mpf, place: Vector) -> np.ndarray:
    """Inertia of a point: m (r.r 1 - r r)."""
    square = sum(x * x for x in place)
    unit = matrix([[float(i == j) for j in range(3)] for i in range(3)])
    return mass * (square * unit - np.outer(place, place))


def _box(mass: mpf, box: parts.Box) -> np.ndarray:
    edges = vector(box.length, box.width, box.height) ** 2
    total = sum(edges)
    return matrix(
        [[mass * (total - edges[i]) / 12 if i == j else 0 for j in range(3)] for i in range(3)]
    )


def body_of(case: Case) -> Body:
    """The machine with its block."""
    body = case.machine.body
    assert body is not None
    mass = mpf(body.mass)
    if body.inertia is None:
        assert body.box is not None
        inertia = _box(mass, body.box)
    else:
        (xx, yy, zz), (xy, xz, yz) = body.inertia, map(mpf, body.inertia_products)
        inertia = matrix([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
    block = body.inertia_block
    if block is None:
        return Body(mass, vector(0, 0, 0), inertia)
    added, place = mpf(block.mass), vector(*block.position)
    inertia = inertia + _box(added, block.box) + point_inertia(added, place)
    return Body(mass + added, added * place / (mass + added), inertia)


def mounts_of(case: Case) -> list[Mount]:
    """Every mount with what `each` gives it."""
    mounts = case.machine.mounts
    assert mounts is not None
    each = mounts.each or parts.MountProperties()
    found = []
    for one in mounts.individual or [
        parts.Mount(name=str(n), position=place) for n, place in enumerate(mounts.positions or ())
    ]:
        stiffness, damping, loss = (
            getattr(each, key) if getattr(one, key) is None else getattr(one, key)
            for key in ("stiffness", "damping", "loss_factor")
        )
        spring = _in_body_axes(stiffness, one.orientation)
        damper = _in_body_axes(damping, one.orientation)
        found.append(Mount(vector(*one.position), spring, damper, mpf(loss or 0) * spring))
    return found


def _in_body_axes(values: object, orientation: tuple[float, float, float]) -> np.ndarray:
    three = values if isinstance(values, tuple) else (values or 0.0,) * 3
    own = matrix([[three[i] if i == j else 0 for j in range(3)] for i in range(3)])
    about = []
    for number, angle in enumerate(map(mpf, orientation)):
        c, s = mpmath.cos(angle), mpmath.sin(angle)
        turn = [[[1, 0, 0], [0, c, -s], [0, s, c]], [[c, 0, s], [0, 1, 0], [-s, 0, c]]]
        turn.append([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        about.append(matrix(turn[number]))
    turned = about[2] @ about[1] @ about[0]
    return np.asarray(turned @ own @ turned.T)


def up_of(case: Case) -> Vector:
    """The direction against which gravity acts."""
    assert case.isolation is not None
    return vector(*(float(case.isolation.up == d) for d in DIRECTIONS))
