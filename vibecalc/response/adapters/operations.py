"""Adapter: energies of every way of running the machine with every way of balancing it."""

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.crank_forces import rotating_part, train_excitation
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import UndrivenModes
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import (
    build_crank_train,
    cancelling_weights,
    moving,
    rotating_masses,
    throws,
    weights_and_shafts,
)
from vibecalc.parts.firing import shakes_with_torque
from vibecalc.response.adapters.response import (
    LinearSystem,
    forcing_of,
    linear_system,
    resonances_of,
    undriven_at_operating_point,
)
from vibecalc.response.energies import (
    dropped_mean,
    energy_by_order,
    energy_over_cycle,
    mass_of,
    mean_over_cycle,
    stiffness_of,
)
from vibecalc.response.operations import (
    PhaseRange,
    SuperposedMotion,
    at_phase,
    mean_energy_range,
    peak_energy_range,
    states,
    superpose,
)
from vibecalc.response.results import OperationsEnergy, OperationsKinetic, OperationsPotential
from vibecalc.response.tables import Balance, Operation, Response

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Loads of several operations of a machine, with several balances of its crankshaft.
# ----------------------------------------------------------------------------

AS_IN_CASE = "as in the case"


class OperationLoads(NamedTuple):
    """Loads per crank speed squared: `shaking` of each operation, `residual` of each balance too.

    Shaking is that of pistons, weights and shafts of the case; the residual is that of the throws
    which turn and of the weights which cancel the throws of a balance.
    """

    operations: tuple[str, ...]
    balances: tuple[str, ...]
    shaking: tuple[Bounded, ...]
    residual: tuple[tuple[Bounded, ...], ...]


def operation_loads(
    scene: Scene, operations: Sequence[Operation], balances: Sequence[Balance] = ()
) -> OperationLoads:
    """Loads of some operations with some balances; without these, with that of the case."""
    motion: PistonMotion = scene.handed_on["motion"]
    excitation = scene.case.excitation
    train = scene.case.machine.crank_train
    whole = build_crank_train(train)
    idle = "stopped" if excitation is None else excitation.idle
    named: list[tuple[str, Sequence[str] | None]] = [
        (balance.name, balance.balanced_for) for balance in balances
    ]
    if not named:
        named = [(AS_IN_CASE, None if excitation is None else excitation.balanced_for)]
    fixed = rotating_masses(weights_and_shafts(train))
    acts = shakes_with_torque(scene.case)
    highest = motion.harmonics.shape[-1] - 1
    shaking = [
        train_excitation(
            moving(whole, operation.working, idle), fixed, motion, scene.case.machine, acts
        )
        for operation in operations
    ]

    def residual(case: "Case") -> tuple[tuple[Bounded, ...], ...]:
        """What turns and is not balanced, which no weight of the case changes."""
        train = build_crank_train(case.machine.crank_train)
        running = [throws(moving(train, operation.working, idle)) for operation in operations]
        cancelling = [cancelling_weights(train, names) for _, names in named]
        return tuple(
            tuple(
                rotating_part(train, rotating_masses([*row, *weights]), highest)
                for weights in cancelling
            )
            for row in running
        )

    which = [(operation.name, operation.working) for operation in operations]
    return OperationLoads(
        tuple(operation.name for operation in operations),
        tuple(name for name, _ in named),
        tuple(shaking),
        scene.once(f"residual of {which} with {named} to order {highest}, {idle}", residual),
    )


# ----------------------------------------------------------------------------
# Adapter: energies of every way of running the machine with every way of balancing it.
# ----------------------------------------------------------------------------


def run_operations(scene: Scene) -> None:
    """Emit mean, peak and range of the energies of all combinations."""
    forcing, system = forcing_of(scene), linear_system(scene)
    options = scene.case.response
    if options is None:
        raise ValueError("the case has no [response]")
    scene.cite(
        "operations and balances combined as phasors",
        "energies of every way of running the machine",
        "docs/theory.md; the table of combinations is that of Ong (2000), table 4.4",
    )
    loads = operation_loads(scene, options.operations, options.balances)
    speed, orders = scene.case.machine.speed, forcing.order
    parts = superpose(
        system.matrices,
        orders,
        speed,
        _stacked([at_speed(load, speed) for load in loads.shaking], -3),
        _stacked([_first(row, speed) for row in loads.residual], -3),
        _undriven(scene, system, loads, orders),
    )
    _emit(scene, system, options, forcing, loads, parts)


def _first(row: Sequence[Bounded], speed: float) -> Bounded:
    """Order 1 (..., balances, 6) of each residual load at a crank speed."""
    each = [at_speed(load, speed) for load in row]
    return _stacked([load[..., 0, :] for load in each], -2)


def _stacked(rows: Sequence[Bounded], axis: int) -> Bounded:
    values = np.broadcast_arrays(*(row.value for row in rows))
    errors = np.broadcast_arrays(*(row.error for row in rows))
    return Bounded(np.stack(values, axis), np.stack(errors, axis))


def _undriven(
    scene: Scene, system: LinearSystem, loads: OperationLoads, orders: np.ndarray
) -> UndrivenModes:
    """Modes that no part of a load drives where an order meets them.

    The parts are judged one by one: two that cancel at the nominal phase of a weight do not cancel
    at the others, over which the range of the energies goes.
    """
    parts = [*loads.shaking, *(residual for row in loads.residual for residual in row)]
    known = resonances_of(system, parts[0])
    found = [undriven_at_operating_point(scene, system, load, orders, known) for load in parts]
    pairs = functools.reduce(np.logical_and, (each.pairs for each in found))
    return found[0]._replace(pairs=pairs)


def _emit(
    scene: Scene,
    system: LinearSystem,
    options: Response,
    forcing: Forcing,
    loads: OperationLoads,
    parts: SuperposedMotion,
) -> None:
    orders, speed = forcing.order, scene.case.machine.speed
    axes = {"operation": loads.operations, "balance": loads.balances}
    weights = np.array([operation.weight for operation in options.operations])
    kinds: tuple[tuple[type[OperationsEnergy], Bounded, np.ndarray], ...] = (
        (OperationsKinetic, mass_of(system.matrices), 1j * orders * np.asarray(speed)[..., None]),
        (OperationsPotential, stiffness_of(system.matrices), np.ones(len(orders))),
    )
    for group, matrix, rate in kinds:
        if not scene.wants(*paths_of(group)):
            continue
        weight = matrix[..., None, :, :]  # the same for all operations
        state = states(parts, rate)
        mean = _emit_cycle(scene, group, weight[..., None, :, :], at_phase(state), forcing, axes)
        _emit_together(scene, group, mean, weights, axes)
        rotating = energy_by_order(weight, state.residual)
        of_weights = group(
            rotating_mean=Bounded(rotating.mean, rotating.mean_error),
            rotating_peak=Bounded(rotating.peak, rotating.peak_error),
        )
        scene.emit_all(of_weights, axes)
        if scene.wants(*paths_of(group, "mean_low", "mean_high")):
            low, high = _ends(_mean_range(weight, state, forcing))
            scene.emit_all(group(mean_low=low, mean_high=high), axes)
        if scene.wants(*paths_of(group, "peak_low", "peak_high")):
            rtol, tail = scene.case.accuracy.rtol, float(forcing.tail)
            low, high = _ends(
                peak_energy_range(matrix, state, orders, forcing.retained, tail, rtol)
            )
            scene.emit_all(group(peak_low=low, peak_high=high), axes)


def _emit_cycle(
    scene: Scene,
    group: type[OperationsEnergy],
    weight: Bounded,
    state: Bounded,
    forcing: Forcing,
    axes: dict[str, tuple[str, ...]],
) -> Bounded:
    """Mean and peak over the cycle; the peak, which is sought, only where somebody wants it."""
    used, tail = forcing.retained, np.asarray(forcing.tail)[..., None, None]
    if scene.wants(*paths_of(group, "peak")):
        whole = energy_over_cycle(weight, state, forcing.order, used, tail)
        mean = Bounded(whole.mean, whole.mean_error)
        scene.emit_all(group(peak=Bounded(whole.peak, whole.peak_error)), axes)
    else:
        mean = mean_over_cycle(weight, state, used, tail)
    scene.emit_all(group(mean=mean), axes)
    return mean


def _mean_range(weight: Bounded, state: SuperposedMotion, forcing: Forcing) -> PhaseRange:
    used, shaking = forcing.retained, state.shaking
    guards, first = shaking[..., used:, :], shaking[..., :used, :]
    dropped = dropped_mean(weight, guards, np.asarray(forcing.tail)[..., None])
    return mean_energy_range(weight, state._replace(shaking=first), dropped)


def _ends(found: PhaseRange) -> tuple[Bounded, Bounded]:
    return Bounded(found.low, found.low_error), Bounded(found.high, found.high_error)


def _emit_together(
    scene: Scene,
    group: type[OperationsEnergy],
    energy: Bounded,
    weights: np.ndarray,
    axes: dict[str, tuple[str, ...]],
) -> None:
    """How far the operations are apart, and their weighted mean, for each balance."""
    mean, error = energy
    apart = mean.max(axis=-2) - mean.min(axis=-2)
    uncertainty = 2.0 * error.max(axis=-2) + EPSILON * mean.max(axis=-2)
    scene.emit_all(group(difference=Bounded(apart, uncertainty)), axes)
    total = float(weights.sum())
    if total > 0.0:
        share = weights / total
        together = np.einsum("o,...ob->...b", share, mean)
        spread = np.einsum("o,...ob->...b", share, error) + len(share) * EPSILON * together
        scene.emit_all(group(weighted=Bounded(together, spread)), axes)
