"""Round-off of an elimination along a tree, as a running bound in magnitudes."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.elimination_plan import Plan

#: roundings of one reciprocal and two products in complex numbers
ROUNDINGS = 4.5 * EPSILON


class Check:
    """Running bound of the round-off, carried along with the elimination in magnitudes.

    `room` (2, n, f) is what it works in: memory that is asked for once. `error` (r, f) and
    `largest` (r, f) are those of the angles, over the stations so far. All errors are in units of
    `unit`, the roundings of a step at the station where most branches meet.
    """

    def __init__(self, plan: Plan, frequency: FloatArray, square: FloatArray, room: FloatArray):
        n = len(plan.inertia)
        self.room = room
        self.plan, self.frequency, self.square = plan, frequency, square
        self.children = [0] * n
        for p in plan.tree.parent:
            if p >= 0:
                self.children[p] += 1
        self.unit = ROUNDINGS + 0.5 * EPSILON * max(self.children)
        self.waiting = list(self.children)
        self.last: tuple[object, ...] | None = None
        self.kept = square
        self.stiffness: list[FloatArray | None] = [None] * n
        self.torque: list[FloatArray | None] = [None] * n
        self.share: list[FloatArray] = [square] * n
        self.turn: list[FloatArray] = [square] * n
        self.angle: list[FloatArray] = [square] * n
        self.wrong: list[FloatArray] = [square] * n
        self.error: FloatArray = np.zeros(())
        self.largest: FloatArray = np.zeros(())

    def _own(self, i: int) -> FloatArray:
        """Doubt of a station's dynamic stiffness: products, and one addition for each branch.

        That of the last station is kept for neighbours that are alike; not to be written into.
        """
        plan, branches = self.plan, self.children[i]
        inertia, stiffness, damping = (
            plan.inertia[i], plan.ground_stiffness[i], plan.absolute_damping[i],
        )  # fmt: skip
        varied = any(isinstance(one, np.ndarray) for one in (inertia, stiffness, damping))
        same = None if varied else (branches, inertia, stiffness, damping)
        if same is None or same != self.last:
            roundings = (2.0 + 0.5 * branches) * EPSILON / self.unit
            self.last = same
            self.kept = self.square * (0.0 if inertia is None else roundings * inertia)
            if stiffness is not None:
                self.kept += roundings * np.abs(stiffness)
            if damping is not None:
                self.kept += self.frequency * (roundings * damping)
        return self.kept

    def down(
        self, i: int, p: int, r: FloatArray, element: float | FloatArray, passed: ComplexArray,
        alone: ComplexArray | None,
    ) -> None:  # fmt: skip
        """Of k g / (k + g), `passed` to the parent, and of what the torque does `alone`.

        r and `element` are |1 / (k + g)| and a bound of |k|.
        """
        gathered = self.stiffness[i]
        self.stiffness[i] = None
        self.turn[i] = t = np.multiply(r, element, out=self.room[0, i])
        doubt = np.multiply(self._own(i) if gathered is None else gathered, r, out=gathered)
        self.share[i] = share = np.add(doubt, 1.0, out=self.room[1, i])
        if alone is not None:
            size, own = np.abs(alone), self.torque[i]
            carried = share * size
            if own is not None:
                own *= r
                carried += own
                size += own
            carried *= element
            above = self.torque[p]
            self.torque[p] = carried if above is None else np.add(above, carried, out=carried)
            self.torque[i] = size
        doubt *= t
        doubt *= element
        doubt += np.abs(passed)
        above = self.stiffness[p]
        doubt += self._own(p) if above is None else above
        self.stiffness[p] = doubt

    def root(self, i: int, x: ComplexArray, r: ComplexArray, load: ComplexArray | None) -> None:
        """Of the angle of a root with the compliance r."""
        size, own, doubt = np.abs(x), self.torque[i], self.stiffness[i]
        bend = np.abs(r)
        wrong = bend * (self._own(i) if doubt is None else doubt)
        wrong = size * (wrong + 1.0)
        if load is not None:
            rounded = np.abs(load)
            wrong += bend * (rounded if own is None else rounded + own)
        self._keep(i, size, wrong)

    def up(self, i: int, p: int, x: ComplexArray) -> None:
        """Of the angle of any other station; without a torque |x| is that of the parent times t."""
        torque, above = self.torque[i], self.wrong[p]
        t, share = self.turn[i][None], self.share[i][None]
        size = t * self.angle[p] if torque is None else np.abs(x)
        # in the room of t and of the share, unless several torques are solved together
        alone = len(above) == 1
        wrong = np.multiply(t, above, out=t if alone else None)
        wrong += np.multiply(share, size, out=share if alone else None)
        if torque is not None:
            wrong += torque
        self._keep(i, size, wrong)
        self.waiting[p] -= 1
        if self.waiting[p] == 0:
            self.angle[p] = self.square

    def _keep(self, i: int, size: FloatArray, wrong: FloatArray) -> None:
        self.angle[i], self.wrong[i] = size, wrong
        # the first one is kept as it is and must not be written into
        first = self.error.ndim == 0
        self.error = np.maximum(self.error, wrong, out=None if first else self.error)
        self.largest = np.maximum(self.largest, size, out=None if first else self.largest)
