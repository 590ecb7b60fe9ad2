"""The rigid body in many digits, from docs/theory_mounts.md, section 1; nothing of the package."""

from typing import Any

import mpmath
import numpy as np
from exact_parts import body_of, matrix, mounts_of, up_of
from exact_train import DIRECTIONS, Shaking, Vector, cross, vector
from mpmath import mpc, mpf

from vibecalc.schema import Case


class BodyTruth:
    """All six freedoms about the reference point, or those of the plane of the crank.

    Vectors keep six entries; those that the plane does not have are zero.
    """

    def __init__(self, case: Case, shaking: Shaking) -> None:
        body, self.mounts = body_of(case), mounts_of(case)
        assert case.isolation is not None
        self.kept = np.arange(6)
        if case.isolation.model == "planar":
            along = DIRECTIONS.index(case.machine.crank_train.axis)
            self.kept = np.array([*(i for i in range(3) if i != along), 3 + along])
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
        static = self.held(self.stiffness, np.concatenate([weight, cross(body.centre, weight)]))
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
            found.append(self.held(dynamic, speed**2 * load))
        return found

    def held(self, left: np.ndarray, load: Vector) -> Vector:
        """Displacement under a load, where a stiffness resists it."""
        return self._six(solve(left[np.ix_(self.kept, self.kept)], load[self.kept]))

    def _six(self, kept: Vector) -> Vector:
        found = matrix([[0] * 6])[0]
        found[self.kept] = kept
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
        block = np.ix_(self.kept, self.kept)
        lower = mpmath.cholesky(mpmath.matrix(self.mass[block].tolist()))
        inverse = lower**-1
        reduced = inverse * mpmath.matrix(self.stiffness[block].tolist()) * inverse.T
        values, vectors = mpmath.eigsy((reduced + reduced.T) / 2)
        shapes = []
        for column in range(len(self.kept)):
            shape = self._six(vector(*(inverse.T * vectors[:, column])))
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


def about_centre(mass: np.ndarray, shape: np.ndarray) -> list[Any]:
    """Shares (6,) in the energy of a mode (6,): motion of the mass centre, turning about it.

    `mass` (6, 6) about the reference point, of which the centre's motion is t + levers w.
    """
    weight, beside = mass[:3, :3], mass[:3, 3:]
    inverse = np.array(mpmath.inverse(mpmath.matrix(weight.tolist())).tolist())
    levers = inverse @ beside
    moved, turned = shape[:3] + levers @ shape[3:], shape[3:]
    inertia = mass[3:, 3:] - levers.T @ weight @ levers
    return [*(moved * (weight @ moved)).tolist(), *(turned * (inertia @ turned)).tolist()]
