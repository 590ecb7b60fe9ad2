"""The stations and elements of a tree at the frequencies of a block."""

from typing import TypeAlias

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.elimination_plan import Plan

#: a value (f,), a bound (f,) or () of its magnitude, and the largest of all
Element: TypeAlias = tuple[FloatArray | ComplexArray, float | FloatArray, float]


class Branches:
    """k (1 + i loss factor) + i w c of the branches to the parents, one at a time.

    Neighbours are often alike, as the throws of a crankshaft are; then the last one is kept.
    """

    def __init__(self, plan: Plan, frequency: FloatArray):
        self.plan, self.frequency = plan, frequency
        self.highest = float(np.max(frequency, initial=0.0))
        self.space = np.empty(len(frequency), dtype=np.complex128)
        self.last: tuple[float, ...] = ()
        self.kept: Element = (self.space, 0.0, 0.0)

    def element(self, i: int) -> Element:
        plan = self.plan
        stiffness, loss, damping = (
            0.0 if one is None else one
            for one in (plan.stiffness[i], plan.loss[i], plan.damping[i])
        )
        if (
            isinstance(stiffness, np.ndarray)
            or isinstance(loss, np.ndarray)
            or isinstance(damping, np.ndarray)
        ):
            self.last = ()
            return self._varied(stiffness, loss, damping)
        if (stiffness, loss, damping) != self.last:
            self.last = (stiffness, loss, damping)
            self.kept = self._constant(stiffness, loss, damping)
        return self.kept

    def _constant(self, stiffness: float, loss: float, damping: float) -> Element:
        imaginary = abs(loss) + self.highest * damping
        largest = float(np.hypot(stiffness, imaginary))
        if imaginary == 0.0:
            return np.asarray(stiffness), largest, largest
        self.space.real = stiffness
        np.multiply(self.frequency, damping, out=self.space.imag)
        if loss != 0.0:
            self.space.imag += loss
        # where damping adds next to nothing one bound will do, even along many stations
        little = largest <= stiffness * (1.0 + 0.4 / len(self.plan.inertia))
        return self.space, largest if little else np.abs(self.space), largest

    def _varied(
        self, stiffness: float | FloatArray, loss: float | FloatArray, damping: float | FloatArray
    ) -> Element:
        if not np.any(loss) and not np.any(damping):
            size = np.abs(stiffness)
            return np.asarray(stiffness), size, float(np.max(size))
        self.space.real = stiffness
        self.space.imag = loss + self.frequency * damping
        size = np.abs(self.space)
        return self.space, size, float(np.max(size))


class Stations:
    """k - w^2 J + i w c of the stations against the frame; real on a line without damping.

    As with `Branches` the last one is kept for neighbours that are alike; not to be written into.
    """

    def __init__(self, plan: Plan, frequency: FloatArray, negative: ComplexArray):
        self.plan, self.frequency, self.negative = plan, frequency, negative
        self.last: tuple[float, ...] = ()
        self.kept = negative

    def own(self, i: int) -> ComplexArray:
        """(f,), `negative` being -w^2."""
        inertia, stiffness, damping = (
            0.0 if one is None else one
            for one in (
                self.plan.inertia[i], self.plan.ground_stiffness[i], self.plan.absolute_damping[i],
            )
        )  # fmt: skip
        if (
            isinstance(inertia, np.ndarray)
            or isinstance(stiffness, np.ndarray)
            or isinstance(damping, np.ndarray)
        ):
            self.last = ()
            self.kept = self._formed(inertia, stiffness, damping)
        elif (inertia, stiffness, damping) != self.last:
            self.last = (inertia, stiffness, damping)
            self.kept = self._formed(inertia, stiffness, damping)
        return self.kept

    def _formed(
        self,
        inertia: float | FloatArray,
        stiffness: float | FloatArray,
        damping: float | FloatArray,
    ) -> ComplexArray:
        own = np.asarray(self.negative * inertia)
        if np.any(stiffness):
            own.real += stiffness
        if np.any(damping):
            np.multiply(self.frequency, damping, out=own.imag)
        return own
