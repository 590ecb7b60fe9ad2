"""Least squares of a motor's rotor against a table, from many starts, ended by Newton steps."""

from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor, steady_torque
from vibecalc.excitation.induction_motor_gradient import torque_sensitivity
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray

#: how far a parameter may go from its scale, as a factor
REACH = 1e4
#: a table met to this in every row leaves nothing to search for
EXACT = 1e-11
#: searches that are run to their end, from the best points of the grid
STARTS = 10


class Found(NamedTuple):
    """`logarithms` (2 cages,) of the resistances (ohm), then the leakages (H), of the best minimum.

    `log_error` as in `MotorFit`; `at_bound` whether a parameter ran away from its scale.
    """

    logarithms: FloatArray
    log_error: float
    starts: int
    agreeing: int
    at_bound: bool


class Table(NamedTuple):
    """Rows to fit: slips (rad/s), torques (N m), weights; and the motor without its rotor."""

    motor: InductionMotor
    slip: FloatArray
    torque: FloatArray
    weight: FloatArray

    def residual(self, logarithms: FloatArray) -> FloatArray:
        """Weighted relative differences (..., rows) for parameters (..., 2 cages)."""
        value = steady_torque(self._with(logarithms[..., None, :]), self.slip).value
        return np.asarray((value / self.torque - 1.0) * np.sqrt(self.weight))

    def jacobian(self, logarithms: FloatArray) -> FloatArray:
        """Derivatives (rows, 2 cages) of the residual."""
        change = torque_sensitivity(self._with(logarithms[None, :]), self.slip)[:, 3:]
        return np.asarray(change * (np.sqrt(self.weight) / self.torque)[:, None])

    def gradient(self, logarithms: FloatArray) -> FloatArray:
        """Of half the sum of squares."""
        return self.jacobian(logarithms).T @ self.residual(logarithms)

    def _with(self, logarithms: FloatArray) -> InductionMotor:
        cages = logarithms.shape[-1] // 2
        values = np.exp(logarithms)
        return self.motor._replace(
            rotor_resistance=values[..., :cages], rotor_leakage=values[..., cages:]
        )


def best_start(
    motor: InductionMotor,
    slip: FloatArray,
    torque: FloatArray,
    weight: FloatArray,
    breakdown_slip: float,
) -> Found:
    """Lowest minimum over rotor resistances and leakages, everything else of the motor held.

    The starts lie on a grid of slips at which a cage is strongest and of leakages; they are the
    same for the same table. `motor.rotor_leakage` gives the scale of the leakages.
    """
    from scipy.optimize import least_squares

    table = Table(motor, slip, torque, weight)
    scale, starts = _starts(table, breakdown_slip)

    def descend(start: FloatArray, most: int) -> tuple[float, FloatArray, bool]:
        end = least_squares(
            table.residual, start, table.jacobian,
            bounds=(scale - np.log(REACH), scale + np.log(REACH)),
            xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=most,
        )  # fmt: skip
        met = float(np.max(np.abs(end.fun))) < EXACT
        return float(end.cost), end.x, end.status > 0 or met

    ends = [descend(start, 400) for start in starts]
    cost, logarithms, converged = min(ends, key=lambda end: end[0])
    if not converged:
        cost, logarithms, converged = descend(logarithms, 4000)
    if not converged:
        raise NumericalFailure("the fit of a motor to its torque table does not converge")
    agreeing = max(1, sum(end[0] <= cost * (1.0 + 1e-6) + 1e-20 for end in ends))
    at_bound = bool(np.any(np.abs(logarithms - scale) > np.log(REACH) - 0.1))
    polished, error = (logarithms, np.inf) if at_bound else _newton(table, logarithms)
    return Found(polished, error, len(ends), agreeing, at_bound)


def _starts(table: Table, breakdown_slip: float) -> tuple[FloatArray, FloatArray]:
    """Scale (2 cages,) and starts (n, 2 cages) of the logarithms.

    Of every set of slips at which the cages are strongest, the best leakages; of these the best.
    """
    pairs = float(np.asarray(table.motor.pole_pairs))
    leakage = np.asarray(table.motor.rotor_leakage)
    cages = leakage.size
    slips = [breakdown_slip * np.array([0.1, 0.25, 0.5, 1.0, 2.0])] * cages
    if cages > 1:
        end = max(table.slip[-1], 2.0 * breakdown_slip)
        slips[-1] = end * np.array([0.25, 0.5, 1.0, 2.0, 5.0])
    inductances = leakage[0] * np.array(list(product([0.5, 1.0, 2.0, 5.0], repeat=cages)))
    found = []
    for strongest in product(*slips):
        if np.any(np.diff(strongest) <= 0.0):
            continue  # the same cages in another sequence, or two that would never part
        resistances = pairs * inductances * np.array(strongest)
        family = np.log(np.concatenate([resistances, inductances], axis=1))
        squares = (table.residual(family) ** 2).sum(axis=-1)
        best = int(np.argmin(squares))
        found.append((float(squares[best]), family[best]))
    found.sort(key=lambda entry: entry[0])
    middle = np.concatenate([np.full(cages, pairs * breakdown_slip * leakage[0]), leakage])
    return np.log(middle), np.array([start for _, start in found[:STARTS]])


def _newton(table: Table, start: FloatArray) -> tuple[FloatArray, float]:
    """Newton steps on the gradient and the distance they leave; infinite where it is flat."""
    place, last = start, np.inf
    for _ in range(8):
        width = 1e-5
        shifts = width * np.eye(place.size)
        bend = np.array(
            [(table.gradient(place + s) - table.gradient(place - s)) / (2 * width) for s in shifts]
        )
        curvature, directions = np.linalg.eigh(0.5 * (bend + bend.T))
        if curvature[0] <= 1e-11 * curvature[-1]:
            return start, np.inf
        gradient = table.gradient(place)
        step = directions @ ((directions.T @ gradient) / curvature)
        size = np.abs(table.jacobian(place)).T @ (1.0 + np.abs(table.residual(place)))
        noise = 32.0 * EPSILON * float(np.linalg.norm(size)) / curvature[0]
        length = float(np.linalg.norm(step))
        if length > 0.5 * last or length > 0.1:
            return place, max(2.0 * length, noise)
        place, last = place - step, length
        if length <= noise:
            break
    return place, 2.0 * last + noise
