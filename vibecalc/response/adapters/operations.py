"""Adapter: energies of every way of running the machine with every way of balancing it."""

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rotating_part, train_excitation
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.numerics.bounded import Bounded, reshaped, stack
from vibecalc.numerics.linear import UndrivenModes
from vibecalc.parts.crank_train import (
    build_crank_train,
    cancelling_weights,
    moving,
    rotating_masses,
    throws,
    weights_and_shafts,
)
from vibecalc.parts.firing import shakes_with_torque
from vibecalc.response.adapters.response import forcing_of, mounted_body
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
from vibecalc.response.stage import names_of
from vibecalc.response.system import MountedBody
from vibecalc.response.tables import Balance, Operation

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Loads of several operations of a machine, with several balances of its crankshaft.
# ----------------------------------------------------------------------------


class OperationLoads(NamedTuple):
    """Loads per crank speed squared on the body, of operations and balances.

    `shaking` (..., operations, orders, 6) is that of pistons, weights and shafts of the case;
    `residual` (..., operations, balances, orders, 6) that of the throws which turn and of the
    weights which cancel the throws of a balance.
    """

    shaking: Bounded
    residual: Bounded


def operation_loads(
    scene: Scene, operations: Sequence[Operation], balances: Sequence[Balance] = ()
) -> OperationLoads:
    """Loads of some operations with some balances; without these, with that of the case."""
    motion: PistonMotion = scene.handed_on["motion"]
    excitation = scene.case.excitation
    train = scene.case.machine.crank_train
    whole = build_crank_train(train)
    idle = "stopped" if excitation is None else excitation.idle
    balanced: list[Sequence[str] | None] = [balance.balanced_for for balance in balances]
    if not balanced:
        balanced = [None if excitation is None else excitation.balanced_for]
    fixed = rotating_masses(weights_and_shafts(train))
    acts = shakes_with_torque(scene.case)
    highest = motion.harmonics.shape[-1] - 1
    shaking = [
        train_excitation(
            moving(whole, operation.working, idle), fixed, motion, scene.case.machine, acts
        )
        for operation in operations
    ]

    def residual(case: "Case") -> Bounded:
        """What turns and is not balanced, which no weight of the case changes."""
        train = build_crank_train(case.machine.crank_train)
        running = [throws(moving(train, operation.working, idle)) for operation in operations]
        cancelling = [cancelling_weights(train, names) for names in balanced]
        rows = [
            [
                rotating_part(train, rotating_masses([*row, *weights]), highest)
                for weights in cancelling
            ]
            for row in running
        ]
        return _stacked([_stacked(row, -3) for row in rows], -4)

    which = [operation.working for operation in operations]
    return OperationLoads(
        _stacked(shaking, -3),
        scene.once(f"residual of {which} with {balanced} to order {highest}, {idle}", residual),
    )


def _stacked(rows: Sequence[Bounded], axis: int) -> Bounded:
    shape = np.broadcast_shapes(*(row.shape for row in rows))
    return stack([reshaped(row, lambda part: np.broadcast_to(part, shape)) for row in rows], axis)


# ----------------------------------------------------------------------------
# Adapter: energies of every way of running the machine with every way of balancing it.
# ----------------------------------------------------------------------------


def run_operations(scene: Scene) -> None:
    """Emit mean, peak and range of the energies of all combinations."""
    forcing, system, options = forcing_of(scene), mounted_body(scene), scene.case.response
    assert options is not None
    scene.cite(
        "operations and balances combined as phasors",
        "energies of every way of running the machine",
        "docs/theory.md; the table of combinations is that of Ong (2000), table 4.4",
    )
    loads = operation_loads(scene, options.operations, options.balances)
    speed, orders = np.asarray(scene.case.machine.speed), forcing.order
    square = np.square(speed)[..., None, None, None]
    parts = superpose(
        system.matrices,
        orders,
        speed,
        loads.shaking * square,
        loads.residual[..., 0, :] * square,
        _undriven(scene, system, loads, orders),
    )
    kinds: tuple[tuple[type[OperationsEnergy], Bounded, np.ndarray], ...] = (
        (OperationsKinetic, mass_of(system.matrices), 1j * orders * speed[..., None]),
        (OperationsPotential, stiffness_of(system.matrices), np.ones(len(orders))),
    )
    for group, weight, rate in kinds:
        if scene.wants(*paths_of(group)):
            scene.emit_all(
                _energies(scene, group, weight, states(parts, rate)), names_of(scene.case)
            )


def _undriven(
    scene: Scene, system: MountedBody, loads: OperationLoads, orders: np.ndarray
) -> UndrivenModes:
    """Modes that no part of a load drives where an order meets them.

    The parts are judged one by one: two that cancel at the nominal phase of a weight do not cancel
    at the others, over which the range of the energies goes.
    """
    running, balances = loads.residual.shape[-4:-2]
    parts = [loads.shaking[..., i, :, :] for i in range(running)]
    parts += [loads.residual[..., i, j, :, :] for i in range(running) for j in range(balances)]
    speed, warn = scene.case.machine.speed, scene.warn
    found = [system.undriven(system.checked(one, orders, speed, warn)) for one in parts]
    pairs = functools.reduce(np.logical_and, (each.pairs for each in found))
    return found[0]._replace(pairs=pairs)


def _energies(
    scene: Scene, group: type[OperationsEnergy], matrix: Bounded, state: SuperposedMotion
) -> OperationsEnergy:
    """Energies of one kind; what is sought, and not summed, only where somebody wants it."""
    forcing, options = forcing_of(scene), scene.case.response
    assert options is not None
    orders, used, tail = forcing.order, forcing.retained, np.asarray(forcing.tail)[..., None]
    weight = matrix[..., None, :, :]  # the same for all operations
    whole, of_each = at_phase(state), weight[..., None, :, :]
    mean = mean_over_cycle(of_each, whole, used, tail[..., None])
    rotating = energy_by_order(weight, state.residual)
    shares = np.array([operation.weight for operation in options.operations])
    shares = (shares / shares.sum())[:, None]

    @functools.cache
    def means() -> PhaseRange:
        dropped = dropped_mean(weight, state.shaking[..., used:, :], tail)
        kept = state._replace(shaking=state.shaking[..., :used, :])
        return mean_energy_range(weight, kept, dropped)

    @functools.cache
    def peaks() -> PhaseRange:
        rtol = scene.case.accuracy.rtol
        return peak_energy_range(matrix, state, orders, used, float(forcing.tail), rtol)

    return group(
        mean=mean,
        peak=lambda: energy_over_cycle(of_each, whole, orders, used, tail[..., None]).peak,
        mean_low=lambda: means().low,
        mean_high=lambda: means().high,
        peak_low=lambda: peaks().low,
        peak_high=lambda: peaks().high,
        rotating_mean=rotating.mean,
        rotating_peak=rotating.peak,
        difference=mean.max(axis=-2) + (-mean).max(axis=-2),
        weighted=(mean * shares).sum(axis=-2),
    )
