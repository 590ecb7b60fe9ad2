"""What is asked of a damper: the line, its torque, what is made small, and the limits."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.optimisation.damper.speed_torque import SpeedTorque
from vibecalc.response.torsion.line import Line


class Damper(NamedTuple):
    """Ring inertia in kg m^2, spring in N m/rad, dashpot in N m s/rad, all referred."""

    inertia: float
    stiffness: float
    damping: float


class Problem(NamedTuple):
    """A line without the ring of its damper, and what is made small.

    `station` the freedom that carries the damper; its hub belongs to the line.
    `order` (m,) multiples of the crank speed, each a multiple of 2 pi / `cycle`.
    `cycle` crank angle of one cycle in rad: 4 pi for four strokes, 2 pi for two.
    `torque` on all freedoms by order; `speed` (lowest, highest) of the range in rad/s.
    `weight` (e,) of each element: what is made small is weight times half range. With `quantity`
    "torque" the half range is of its torque, spring and dashpot together (a stress is a torque with
    the weight 1 / section modulus), with "twist" of its twist. Weight 0 leaves an element out.
    """

    line: Line
    station: int
    order: FloatArray
    cycle: float
    torque: SpeedTorque
    speed: tuple[float, float]
    weight: FloatArray
    quantity: str = "torque"


class Limits(NamedTuple):
    """Bounds (low, high) of the damper, and what it must bear.

    Equal bounds hold a value; `stiffness` (0, 0) is a viscous damper. `heat` in W is the mean power
    of the dashpot at the worst speed, `travel` in rad the largest angle between ring and hub over
    the cycle at the worst speed. `inertia_price` is added to what is made small for each kg m^2.
    """

    inertia: tuple[float, float]
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    heat: float = np.inf
    travel: float = np.inf
    inertia_price: float = 0.0

    @property
    def bounds(self) -> FloatArray:
        """(3, 2): inertia, stiffness, damping by low, high."""
        return np.array([self.inertia, self.stiffness, self.damping], dtype=float)


def harmonics(problem: Problem) -> IntArray:
    """Number of periods in a cycle of each order (m,); refuses orders that are not whole there."""
    exact = np.asarray(problem.order, dtype=float) * problem.cycle / (2.0 * np.pi)
    whole = np.rint(exact)
    if np.any(np.abs(exact - whole) > 1e-9) or np.any(whole < 1):
        raise NumericalFailure("orders of a damper design have to repeat with the cycle, above 0")
    return whole.astype(np.int64)


def check(problem: Problem, limits: Limits) -> None:
    """Raise NumericalFailure for a design that has no meaning."""
    bounds = limits.bounds
    low, high = bounds.T
    if not np.all(np.isfinite(bounds)) or np.any(low > high) or np.any(low < 0.0):
        raise NumericalFailure("bounds of the damper need 0 <= low <= high < infinity")
    if low[0] <= 0.0 or low[2] <= 0.0:
        raise NumericalFailure("ring inertia and damping need a lower bound above zero")
    if low[1] == 0.0 and high[1] > 0.0:
        raise NumericalFailure(
            "a spring between zero and some bound is searched by its logarithm: give a lower bound "
            "above zero, or (0, 0) for a damper without spring"
        )
    slow, fast = problem.speed
    if not 0.0 < slow < fast < np.inf:
        raise NumericalFailure("the range of speeds needs 0 < lowest < highest")
    knot = problem.torque.knot
    if slow < knot[0] or fast > knot[-1]:
        raise NumericalFailure(
            f"the torque is known from {knot[0]:.6g} to {knot[-1]:.6g} rad/s, the range asks for "
            f"{slow:.6g} to {fast:.6g}"
        )
    if problem.quantity not in ("torque", "twist"):
        raise NumericalFailure(f"no quantity {problem.quantity!r}: it is torque or twist")
    if not 0 <= problem.station < problem.line.inertia.size:
        raise NumericalFailure(f"the line has no freedom {problem.station} to carry a damper")
    if not np.any(np.asarray(problem.weight) > 0.0) or np.any(np.asarray(problem.weight) < 0.0):
        raise NumericalFailure("the weights of the sections are negative or all zero")
    if limits.heat <= 0.0 or limits.travel <= 0.0:
        raise NumericalFailure("limits on heat and travel have to be above zero")
    harmonics(problem)
