"""Torque and stress of the elements of a shaft line, and their peaks against speed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray
from vibecalc.response.torsion.forced import forced_masked
from vibecalc.response.torsion.line import Line, Values
from vibecalc.response.torsion.synthesis import Synthesis, synthesis

#: angles of one block
BLOCK = 1 << 17


class SectionTorque(NamedTuple):
    """Torques (..., e) in N m, complex, 0-to-peak, on the twist phi[first] - phi[second] in rad.

    `stiffness` is what the twist does, k times it; `damping` what dashpot and loss factor add.
    `error` (..., e) is absolute, of `total`.
    """

    twist: ComplexArray
    stiffness: ComplexArray
    damping: ComplexArray
    error: FloatArray

    @property
    def total(self) -> ComplexArray:
        """What the element carries."""
        return self.stiffness + self.damping


class SectionPeaks(NamedTuple):
    """Total torque of each element against speed, (speed, e), as `Synthesis`.

    `masked` (speed,): some order is on an undamped natural frequency; the values are infinite.
    """

    torque: Synthesis
    masked: BoolArray


def section_torque(
    line: Line, frequency: ArrayLike, angle: ArrayLike, error: ArrayLike = 0.0
) -> SectionTorque:
    """From angles (..., n) with absolute errors (...) at frequencies (...) in rad/s.

    The twist of a shaft much stiffer than what it drives is a small difference of angles: its
    relative error is large then, and counted.
    """
    w = np.asarray(frequency, dtype=float)[..., None]
    value = np.asarray(angle)
    one, other = value[..., line.first], value[..., line.second]
    twist = one - other
    stiffness = line.stiffness * twist
    damping = 1j * (line.stiffness * line.loss_factor + w * line.damping) * twist
    size = line.stiffness * (1.0 + np.abs(line.loss_factor)) + w * line.damping
    doubt = 2.0 * np.asarray(error)[..., None] + 4.0 * EPSILON * np.abs(twist)
    return SectionTorque(twist, stiffness, damping, size * doubt)


def shear_stress(torque: Values, section_modulus: FloatArray) -> Values:
    """Nominal stress (..., e) in Pa, torque over polar section modulus (e,) in m^3."""
    stress: Values = torque / section_modulus
    return stress


def section_peaks(
    line: Line,
    speed: ArrayLike,
    order: ArrayLike,
    torque: Callable[[FloatArray], ComplexArray],
    rows: int | None = None,
) -> SectionPeaks:
    """Peak, half range and the rest of each element's torque against speed (speeds,) in rad/s.

    `torque` gives for speeds (s,) the torques (s, m, n) or (m, n) of the orders (m,); those of an
    order 0 must balance on a line that is free to turn, or every speed is masked. Speeds are
    taken `rows` at a time (default: what fits some megabytes): what is stored beyond the result
    does not grow with their number.
    """
    speeds, orders = np.asarray(speed, dtype=float), np.asarray(order, dtype=float)
    rows = rows or min(256, 1 + BLOCK // (len(orders) * line.inertia.shape[-1]))
    found, masks = [], []
    for start in range(0, len(speeds), rows):
        part = speeds[start : start + rows]
        w = part[:, None] * orders
        solved = forced_masked(line, w, torque(part))
        masked = np.any(solved.masked, axis=-1)
        sections = section_torque(line, w, solved.angle, np.where(solved.masked, 0.0, solved.error))
        total = np.moveaxis(sections.total, -1, 1)
        result = synthesis(orders, total, np.moveaxis(sections.error, -1, 1))
        infinite = masked[:, None]
        found.append(Synthesis(*(np.where(infinite, np.inf, one) for one in result)))
        masks.append(masked)
    parts = zip(*found, strict=True)
    return SectionPeaks(Synthesis(*(np.concatenate(one) for one in parts)), np.concatenate(masks))
