"""A body in the plane of its crank in many digits: three motions of the six, the rest held."""

import mpmath
import numpy as np
from exact_body import BodyTruth, solve
from exact_parts import body_of, matrix, mounts_of, point_inertia, up_of
from exact_train import DIRECTIONS, Shaking, Vector, cross, vector
from mpmath import mpc, mpf

from vibecalc.schema import Case


class PlanarTruth(BodyTruth):
    """Vectors keep all six entries; those that the plane does not have are zero."""

    def __init__(self, case: Case, shaking: Shaking) -> None:
        body, self.mounts = body_of(case), mounts_of(case)
        assert case.isolation is not None
        along = DIRECTIONS.index(case.machine.crank_train.axis)
        self.kept = np.array([*(i for i in range(3) if i != along), 3 + along])
        self.seen = [self._seen(m.position) for m in self.mounts]
        # twice the kinetic energy: of the mass centre, and of turning about it
        centre = self._seen(body.centre)
        self.mass = body.mass * (centre.T @ centre)
        self.mass[3:, 3:] = self.mass[3:, 3:] + body.inertia - point_inertia(body.mass, body.centre)
        self.stiffness, self.damping, self.loss = (
            sum(g.T @ block[i] @ g for g, block in zip(self.seen, self._blocks(), strict=True))
            for i in range(3)
        )
        self.orders = shaking.orders
        self.load = [np.concatenate(p) for p in zip(shaking.force, shaking.couple, strict=True)]
        up = up_of(case)
        weight = -body.mass * mpf(case.isolation.gravity) * up
        sunk = self.still(np.concatenate([weight, cross(body.centre, weight)]))
        self.sag = [-(g @ sunk) @ up for g in self.seen]
        self.share = [
            -(m.stiffness @ (g @ sunk)) @ up for m, g in zip(self.mounts, self.seen, strict=True)
        ]

    def still(self, load: Vector) -> Vector:
        """Displacement under a constant load."""
        return self._held(self.stiffness, load)

    def motion(self, speed: mpf) -> list[Vector]:
        """Six coordinates of each order."""
        found = []
        for n, load in zip(self.orders, self.load, strict=True):
            w = n * speed
            dynamic = self.stiffness - w**2 * self.mass + mpc(0, 1) * (self.loss + w * self.damping)
            found.append(self._held(dynamic, speed**2 * load))
        return found

    def modes(self) -> tuple[list[mpf], list[Vector]]:
        """As of the whole body, of the three motions; by Cholesky's factor of the stiffness."""
        block = np.ix_(self.kept, self.kept)
        lower = mpmath.cholesky(mpmath.matrix(self.stiffness[block].tolist()))
        inverse = lower**-1
        reduced = inverse * mpmath.matrix(self.mass[block].tolist()) * inverse.T
        values, vectors = mpmath.eigsy((reduced + reduced.T) / 2)
        frequencies, shapes = [], []
        for column in reversed(range(3)):  # values are one over squared frequencies
            frequency = 1 / mpmath.sqrt(values[column])
            shape = frequency * vector(*(inverse.T * vectors[:, column]))
            own = [self.mass[place, place] for place in self.kept]
            weighed = [abs(x) * mpmath.sqrt(m) for x, m in zip(shape, own, strict=True)]
            sign = 1 if shape[weighed.index(max(weighed))] > 0 else -1
            frequencies.append(frequency)
            shapes.append(self._six(sign * shape))
        return frequencies, shapes

    def _held(self, left: np.ndarray, load: Vector) -> Vector:
        return self._six(solve(left[np.ix_(self.kept, self.kept)], load[self.kept]))

    def _six(self, three: Vector) -> Vector:
        found = matrix([[0] * 6])[0]
        found[self.kept] = three
        return found
