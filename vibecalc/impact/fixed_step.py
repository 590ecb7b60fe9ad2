"""The same machine with an explicit method of fixed step, which runs over its contacts."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.impact.linkage import (
    FREE,
    GapForces,
    Linkage,
    Starts,
    assemble_train,
    contact_force,
    side_of,
)
from vibecalc.impact.roots import in_order
from vibecalc.impact.setup import gas_force
from vibecalc.numerics.explicit_steps import METHODS, explicit_step
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# The same machine with a method of fixed step, which runs over its contacts.
#
# For comparison with published runs and with `simulate.py`. A contact of some steps is resolved
# only roughly and the energy in it is not kept; the numbers carry no error estimate, because an
# explicit method has none here: halving the step changes every run after a few contacts. What
# differs from the event-exact statistics, over the spread of the runs, is their error.
# ----------------------------------------------------------------------------


def simulate_fixed_steps(
    linkage: Linkage, start: Starts, method: str, steps: int, revolutions: int, orders: int
) -> tuple[GapForces, FloatArray]:
    """Run B machines with `steps` equal steps of `method` (a key of METHODS) in a revolution.

    `start` (B, G); `orders`, the highest of the spectra, below steps / 2. Forces (G, B, R) are
    those at the start of each step; with them the gaps (G, B, steps), m, of the last revolution.
    Raises NumericalFailure where the method is unstable.
    """
    state = np.array([one.T for one in start], dtype=np.float64)
    train, drive = assemble_train(linkage, state.shape[-1]), linkage.drive
    tableau, step = METHODS[method], 2.0 * np.pi / (drive.speed * steps)
    angle = (np.arange(steps) + np.array(tableau.fraction)[:, None]) * (2.0 * np.pi / steps)
    shaken = _summed(
        drive.orders, -np.square(drive.orders * drive.speed) * drive.displacement, angle
    )
    gas = gas_force(linkage.gas, angle)
    side_pull = np.zeros(angle.shape)
    if drive.tangent_orders is not None and drive.rod_tangent is not None:
        side_pull = _summed(drive.tangent_orders, drive.rod_tangent, angle)

    def rates(index: int, stage: int, state: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Velocities and accelerations (G, B) at a stage of a step."""
        pull = contact_force(train, *state)
        result = -np.sum(train.couple * pull, axis=1)
        result[train.pin] += shaken[stage, index]
        result[0] -= gas[stage, index] / train.mass
        if train.bore is not None:
            result[train.bore] += side_pull[stage, index] * pull[0] / train.mass
        return state[1], result

    shape = (*state.shape[1:], revolutions)
    forces = GapForces(np.empty((*shape, orders + 1), dtype=np.complex128), *np.zeros((4, *shape)))
    force, gap = np.empty((2, *shape[:2], steps))
    # a gap wider than all that moves: the method has blown up
    widest = np.max(np.abs(state[0]) + train.gaps.clearance)
    limit = 10.0 * (np.sum(np.abs(drive.displacement)) + widest)
    side = side_of(train.gaps, state[0])
    for turn in range(revolutions):
        for k in range(steps):
            with np.errstate(over="ignore", invalid="ignore"):
                force[..., k], gap[..., k] = contact_force(train, *state), state[0]
                state = np.array(explicit_step(tableau, partial(rates, k), tuple(state), step))
            before, side = side, side_of(train.gaps, state[0])
            forces.contacts[..., turn] += (side != FREE) & (side != before)
            forces.contact_time[..., turn] += step * (side != FREE)
        if not np.max(np.abs(gap)) < limit:
            raise NumericalFailure(
                f"{method} with {steps} steps per revolution is unstable in the contacts; "
                f"take more steps or the event-exact method"
            )
        forces.harmonics[:, :, turn] = one_sided(force)[..., : orders + 1]
        forces.mean[..., turn] = np.mean(np.abs(force), axis=-1)
        forces.peak[..., turn] = np.max(np.abs(force), axis=-1)
    return forces, gap


def _summed(orders: IntArray, values: ComplexArray, angle: FloatArray) -> FloatArray:
    """Values at angles (stages, steps) of a sum of harmonics, order after order."""
    return in_order((values[:, None, None] * np.exp(1j * np.multiply.outer(orders, angle))).real)


def one_sided(samples: FloatArray) -> ComplexArray:
    """One-sided 0-to-peak harmonics (..., n/2) of n equal samples over one turn; 0 is the mean."""
    points = samples.shape[-1]
    values = np.fft.rfft(samples)[..., : (points + 1) // 2] * (2.0 / points)
    values[..., 0] *= 0.5
    return np.asarray(values)
