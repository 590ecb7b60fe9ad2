"""The same machine with an explicit method of fixed step, which runs over its contacts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.impact.linkage import (
    FREE,
    Drive,
    GasForce,
    Joint,
    Train,
    assemble_train,
    law_of,
    side_of,
    starts,
)
from vibecalc.impact.setup import gas_force
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Explicit one-step methods of fixed step, as their tables.
# ----------------------------------------------------------------------------


class Tableau(NamedTuple):
    """Stage k is taken at `fraction[k]` of the step from the earlier ones by `stage[k]`."""

    order: int
    fraction: tuple[float, ...]
    stage: tuple[tuple[float, ...], ...]
    weight: tuple[float, ...]


#: Euler; Heun (1900); Runge and Kutta (1901); Dormand and Prince (1980), the solution of order 5
METHODS = {
    "euler": Tableau(1, (0.0,), ((),), (1.0,)),
    "heun": Tableau(2, (0.0, 1.0), ((), (1.0,)), (0.5, 0.5)),
    "rk4": Tableau(
        4,
        (0.0, 0.5, 0.5, 1.0),
        ((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
        (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    ),
    "dormand_prince": Tableau(
        5,
        (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0),
        (
            (),
            (1 / 5,),
            (3 / 40, 9 / 40),
            (44 / 45, -56 / 15, 32 / 9),
            (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
            (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        ),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    ),
}

# ----------------------------------------------------------------------------
# The same machine with a method of fixed step, which runs over its contacts.
#
# For comparison with published runs and with `simulate.py`. A contact of some steps is resolved
# only roughly and the energy in it is not kept; the numbers carry no error estimate, because an
# explicit method has none here: halving the step changes every run after a few contacts. What
# differs from the event-exact statistics, over the spread of the runs, is their error.
# ----------------------------------------------------------------------------


class SampledRecord(NamedTuple):
    """One gap of every run, from its force at the start of each step; arrays (B, revolutions).

    `force_harmonics` (B, revolutions, N + 1) as in `results.GapRecord`, by a discrete transform;
    `mean_absolute_force`, `peak_force` N over the samples; `impact_count` contacts seen;
    `contact_time` s; `force` N and `gap` m (B, steps) over the last revolution.
    """

    force_harmonics: ComplexArray
    mean_absolute_force: FloatArray
    peak_force: FloatArray
    impact_count: IntArray
    contact_time: FloatArray
    force: FloatArray
    gap: FloatArray


class FixedSteps(NamedTuple):
    """Runs by a fixed-step method; the fields are those of `results.Revolutions`."""

    wrist_pin: SampledRecord
    crank_pin: SampledRecord | None
    wall: SampledRecord | None
    end_gap: FloatArray
    end_velocity: FloatArray
    angle: FloatArray


class _Pushes(NamedTuple):
    """What acts from outside at every stage of every step (stages, steps)."""

    pin: FloatArray
    gas: FloatArray
    tangent: FloatArray | None


def simulate_fixed_steps(
    drive: Drive,
    gas: GasForce,
    mass: ArrayLike,
    joint: Joint,
    gap: ArrayLike,
    gap_velocity: ArrayLike,
    *,
    method: str,
    steps: int,
    revolutions: int,
    orders_retained: int,
    crank_joint: Joint | None = None,
    rod_mass: ArrayLike | None = None,
    wall: Joint | None = None,
) -> FixedSteps:
    """Run B machines with `steps` equal steps of `method` (a key of METHODS) in a revolution.

    The other arguments are those of `simulate.simulate`; `orders_retained` below steps / 2.
    Raises NumericalFailure where the method is unstable.
    """
    z, velocity = starts(gap), starts(gap_velocity)
    rod = None if rod_mass is None else np.asarray(rod_mass, dtype=np.float64)
    piston = np.asarray(mass, dtype=np.float64)
    train = assemble_train(z.shape[1], piston, joint, crank_joint, rod, wall)
    tableau, step = METHODS[method], 2.0 * np.pi / (drive.speed * steps)
    pushes = _pushes(drive, gas, tableau, steps)
    shape = (*z.shape, revolutions)
    spectra = np.empty((*shape, orders_retained + 1), dtype=np.complex128)
    absolute, peak, contact_time = np.empty(shape), np.empty(shape), np.empty(shape)
    count, ends = np.empty(shape, dtype=np.int64), np.empty((2, *shape))
    force, trace = np.empty((*z.shape, steps)), np.empty((*z.shape, steps))
    # a gap wider than all that moves: the method has blown up
    limit = 10.0 * (np.sum(np.abs(drive.displacement)) + np.max(np.abs(z) + train.gaps.clearance))
    side = side_of(train.gaps, z)
    for turn in range(revolutions):
        made, touching = np.zeros_like(side), np.zeros_like(side)
        for k in range(steps):
            with np.errstate(over="ignore", invalid="ignore"):
                force[..., k], trace[..., k] = contact_force(train, z, velocity), z
                z, velocity = _step(train, pushes, tableau, k, step, z, velocity)
            before, side = side, side_of(train.gaps, z)
            made += (side != FREE) & (side != before)
            touching += side != FREE
        if not np.max(np.abs(trace)) < limit:
            raise NumericalFailure(
                f"{method} with {steps} steps per revolution is unstable in the contacts; "
                f"take more steps or the event-exact method"
            )
        spectra[:, :, turn] = one_sided(force)[..., : orders_retained + 1]
        absolute[..., turn] = np.mean(np.abs(force), axis=-1)
        peak[..., turn] = np.max(np.abs(force), axis=-1)
        count[..., turn], contact_time[..., turn] = made, touching * step
        ends[0, ..., turn], ends[1, ..., turn] = z, velocity
    columns = (spectra, absolute, peak, count, contact_time, force, trace)
    records = [SampledRecord(*(column[each] for column in columns)) for each in range(len(z))]
    return FixedSteps(
        records[0],
        records[1] if train.pin == 1 else None,
        None if train.bore is None else records[train.bore],
        np.moveaxis(ends[0], 0, -1),
        np.moveaxis(ends[1], 0, -1),
        2.0 * np.pi * np.arange(steps) / steps,
    )


def one_sided(samples: FloatArray) -> ComplexArray:
    """One-sided 0-to-peak harmonics (..., n/2) of n equal samples over one turn; 0 is the mean."""
    points = samples.shape[-1]
    values = np.fft.rfft(samples)[..., : (points + 1) // 2] * (2.0 / points)
    values[..., 0] *= 0.5
    return np.asarray(values)


def contact_force(train: Train, gap: FloatArray, velocity: FloatArray) -> FloatArray:
    """Force of each gap (G, B), N, for its place and velocity."""
    law = law_of(train.gaps, side_of(train.gaps, gap))
    return law.spring * (gap - law.free_position) + law.damper * velocity


def _step(
    train: Train,
    pushes: _Pushes,
    tableau: Tableau,
    index: int,
    step: float,
    gap: FloatArray,
    velocity: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    rates: list[tuple[FloatArray, FloatArray]] = []
    for k, weights in enumerate(tableau.stage):
        z, v = _moved(gap, velocity, weights, rates, step)
        rates.append((v, _acceleration(train, pushes, k, index, z, v)))
    return _moved(gap, velocity, tableau.weight, rates, step)


def _moved(
    gap: FloatArray,
    velocity: FloatArray,
    weights: tuple[float, ...],
    rates: list[tuple[FloatArray, FloatArray]],
    step: float,
) -> tuple[FloatArray, FloatArray]:
    for weight, (rate, acceleration) in zip(weights, rates, strict=True):
        gap, velocity = gap + step * weight * rate, velocity + step * weight * acceleration
    return gap, velocity


def _acceleration(
    train: Train,
    pushes: _Pushes,
    stage: int,
    index: int,
    gap: FloatArray,
    velocity: FloatArray,
) -> FloatArray:
    force = contact_force(train, gap, velocity)
    result = -np.sum(train.couple * force, axis=1)
    result[train.pin] += pushes.pin[stage, index]
    result[0] -= pushes.gas[stage, index] / train.mass
    if train.bore is not None and pushes.tangent is not None:
        result[train.bore] += pushes.tangent[stage, index] * force[0] / train.mass
    return np.asarray(result)


def _pushes(drive: Drive, gas: GasForce, tableau: Tableau, steps: int) -> _Pushes:
    angle = (np.arange(steps) + np.array(tableau.fraction)[:, None]) * (2.0 * np.pi / steps)

    def summed(orders: IntArray, values: ComplexArray) -> FloatArray:
        total = np.zeros(angle.shape)
        for order, value in zip(orders.tolist(), values.tolist(), strict=True):
            total += (value * np.exp(1j * order * angle)).real
        return total

    orders = np.asarray(drive.orders)
    acceleration = -np.square(orders * drive.speed) * np.asarray(drive.displacement)
    tangent = None
    if drive.tangent_orders is not None and drive.rod_tangent is not None:
        tangent = summed(drive.tangent_orders, drive.rod_tangent)
    return _Pushes(summed(orders, acceleration), gas_force(gas, angle), tangent)
