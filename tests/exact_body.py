"""The machine on its mounts in many digits: pitch or all six freedoms, every term written out.

Written for tests from docs/theory.md, without anything from the package but the case.
"""

from typing import NamedTuple

import mpmath
import numpy as np
from exact_train import DIRECTIONS, Shaking, Vector, cross, frame_of, vector
from mpmath import mpc, mpf

from vibecalc.case import parts
from vibecalc.case.schema import Case


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


def _point(mass: mpf, place: Vector) -> np.ndarray:
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
    inertia = inertia + _box(added, block.box) + _point(added, place)
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


class PitchTruth:
    """One rotation about the axis across the crankshaft, through the mass centre."""

    def __init__(self, case: Case, shaking: Shaking) -> None:
        frame, body, mounts = frame_of(case), body_of(case), mounts_of(case)
        assert case.isolation is not None
        at_centre = body.inertia - _point(body.mass, body.centre)
        self.inertia = frame.across @ at_centre @ frame.across
        self.place = [(m.position - body.centre) @ frame.axis for m in mounts]
        along = [(m.stiffness, m.damping, m.loss) for m in mounts]
        self.spring, self.damper, self.lag = (
            [frame.stroke @ of[i] @ frame.stroke for of in along] for i in range(3)
        )
        self.stiffness, self.damping, self.loss = (
            sum(k * x**2 for k, x in zip(values, self.place, strict=True))
            for values in (self.spring, self.damper, self.lag)
        )
        self.frequency = mpmath.sqrt(self.stiffness / self.inertia)
        given = case.isolation.lever
        # the cases of this truth give a lever unless all mounts share one distance
        self.lever = mpf(given) if given is not None else abs(self.place[0])
        self.orders = shaking.orders
        self.couple = [
            (m - cross(body.centre, f)) @ frame.across
            for f, m in zip(shaking.force, shaking.couple, strict=True)
        ]
        self.weight = body.mass * mpf(case.isolation.gravity)

    def passing(self, rate: mpf) -> mpc:
        """Couple on the ground per unit angle at an excitation frequency."""
        return mpc(self.stiffness, self.loss + rate * self.damping)

    def resisting(self, rate: mpf) -> mpc:
        """Couple on the body per unit angle."""
        return self.passing(rate) - rate**2 * self.inertia

    def angle(self, speed: mpf) -> list[mpc]:
        """Pitch angle of each order."""
        return [
            speed**2 * c / self.resisting(n * speed)
            for n, c in zip(self.orders, self.couple, strict=True)
        ]

    def row(self, speed: mpf, row: int) -> list[list[mpc]]:
        """Couple over lever (row 0), or force of a mount (from row 1): [component][order]."""
        turned = [(n * speed, q) for n, q in zip(self.orders, self.angle(speed), strict=True)]
        if row == 0:
            return [[self.passing(w) * q / self.lever for w, q in turned]]
        x, k = self.place[row - 1], self.spring[row - 1]
        c, h = self.damper[row - 1], self.lag[row - 1]
        return [[-x * mpc(k, h + w * c) * q for w, q in turned]]

    def rows(self, speed: mpf) -> list[list[list[mpc]]]:
        """All rows."""
        return [self.row(speed, row) for row in range(1 + len(self.place))]

    def sag(self) -> list[mpf]:
        """Way down of each mount: heave z and turn q from force and moment balance."""
        k0 = sum(self.spring)
        k1 = sum(k * x for k, x in zip(self.spring, self.place, strict=True))
        heave = self.weight * self.stiffness / (k0 * self.stiffness - k1**2)
        tilt = -self.weight * k1 / (k0 * self.stiffness - k1**2)
        return [heave + tilt * x for x in self.place]


class BodyTruth:
    """All six freedoms about the reference point."""

    def __init__(self, case: Case, shaking: Shaking) -> None:
        body, self.mounts = body_of(case), mounts_of(case)
        assert case.isolation is not None
        self.mass = matrix([[0] * 6 for _ in range(6)])
        for i in range(3):
            self.mass[i, i] = body.mass
            unit = vector(*(float(i == j) for j in range(3)))
            # velocity of the centre when the body turns about axis i: unit x centre
            self.mass[:3, 3 + i] = body.mass * cross(unit, body.centre)
            self.mass[3 + i, :3] = self.mass[:3, 3 + i]
        self.mass[3:, 3:] = body.inertia
        self.seen = [self._seen(m.position) for m in self.mounts]
        self.stiffness, self.damping, self.loss = (
            sum(g.T @ block[i] @ g for g, block in zip(self.seen, self._blocks(), strict=True))
            for i in range(3)
        )
        self.orders = shaking.orders
        self.load = [np.concatenate(p) for p in zip(shaking.force, shaking.couple, strict=True)]
        up = up_of(case)
        weight = -body.mass * mpf(case.isolation.gravity) * up
        static = solve(self.stiffness, np.concatenate([weight, cross(body.centre, weight)]))
        self.sag = [-(g @ static) @ up for g in self.seen]
        self.share = [
            -(m.stiffness @ (g @ static)) @ up for m, g in zip(self.mounts, self.seen, strict=True)
        ]

    def _blocks(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        return [(m.stiffness, m.damping, m.loss) for m in self.mounts]

    @staticmethod
    def _seen(place: Vector) -> np.ndarray:
        """Displacement at a place: t + r x p."""
        units = [vector(*(float(i == j) for j in range(3))) for i in range(3)]
        return np.column_stack([*units, *(cross(unit, place) for unit in units)])

    def motion(self, speed: mpf) -> list[Vector]:
        """Six coordinates of each order."""
        found = []
        for n, load in zip(self.orders, self.load, strict=True):
            w = n * speed
            dynamic = self.stiffness - w**2 * self.mass + mpc(0, 1) * (self.loss + w * self.damping)
            found.append(solve(dynamic, speed**2 * load))
        return found

    def displacement(self, motion: list[Vector]) -> list[list[list[mpc]]]:
        """Of every mount: [mount][component][order]."""
        return [np.array([g @ x for x in motion], dtype=object).T.tolist() for g in self.seen]

    def row(self, speed: mpf, row: int, motion: list[Vector] | None = None) -> list[list[mpc]]:
        """Force of one mount on the ground: [component][order]."""
        motion = self.motion(speed) if motion is None else motion
        mount, seen = self.mounts[row], self.seen[row]
        forces = [
            (mount.stiffness + mpc(0, 1) * (mount.loss + n * speed * mount.damping)) @ (seen @ x)
            for n, x in zip(self.orders, motion, strict=True)
        ]
        found: list[list[mpc]] = np.array(forces, dtype=object).T.tolist()
        return found

    def rows(self, speed: mpf, motion: list[Vector] | None = None) -> list[list[list[mpc]]]:
        """Force of every mount: [mount][component][order]."""
        motion = self.motion(speed) if motion is None else motion
        return [self.row(speed, row, motion) for row in range(len(self.mounts))]

    def modes(self) -> tuple[list[mpf], list[Vector]]:
        """Natural frequencies and modes of unit modal mass, largest share of energy positive."""
        lower = mpmath.cholesky(mpmath.matrix(self.mass.tolist()))
        inverse = lower**-1
        reduced = inverse * mpmath.matrix(self.stiffness.tolist()) * inverse.T
        values, vectors = mpmath.eigsy((reduced + reduced.T) / 2)
        shapes = []
        for column in range(6):
            shape = vector(*(inverse.T * vectors[:, column]))
            weighed = [abs(shape[i]) * mpmath.sqrt(self.mass[i, i]) for i in range(6)]
            shapes.append(shape if shape[weighed.index(max(weighed))] > 0 else -shape)
        return [mpmath.sqrt(value) for value in values], shapes


def solve(left: np.ndarray, right: Vector) -> Vector:
    """Gauss's elimination with row exchanges."""
    rows = [[*line, value] for line, value in zip(left.tolist(), right.tolist(), strict=True)]
    size = len(rows)
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(complex(rows[i][k])))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        top, inverse = rows[k], 1 / rows[k][k]
        for line in rows[k + 1 :]:
            factor = line[k] * inverse
            for j in range(k + 1, size + 1):
                line[j] -= factor * top[j]
    found = [mpf(0)] * size
    for i in reversed(range(size)):
        rest = sum(rows[i][j] * found[j] for j in range(i + 1, size))
        found[i] = (rows[i][size] - rest) / rows[i][i]
    return vector(*found)
