"""Adapter: energies of every way of running the machine with every way of balancing it."""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rotating_part, train_excitation
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.numerics.bounded import Bounded, reshaped, stack
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
    mass_of,
    mean_over_cycle,
    peak_over_cycle,
    stiffness_of,
)
from vibecalc.response.operations import (
    Parts,
    PhaseRange,
    at_phase,
    mean_energy_range,
    peak_energy_range,
    superpose,
)
from vibecalc.response.results import OperationsEnergy, OperationsKinetic, OperationsPotential
from vibecalc.response.stage import names_of
from vibecalc.response.tables import Balance, Operation
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Loads of several operations of a machine, with several balances of its crankshaft.
# ----------------------------------------------------------------------------


def operation_loads(
    scene: Scene, operations: Sequence[Operation], balances: Sequence[Balance] = ()
) -> Parts:
    """Loads per crank speed squared; without balances, with that of the case."""
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
    shaking = [
        train_excitation(
            moving(whole, operation.working, idle), fixed, motion, scene.case.machine, acts
        )
        for operation in operations
    ]

    def residual(case: Case) -> Bounded:
        """What turns and is not balanced, which no weight of the case changes."""
        train = build_crank_train(case.machine.crank_train)
        running = [throws(moving(train, operation.working, idle)) for operation in operations]
        cancelling = [cancelling_weights(train, names) for names in balanced]
        rows = [
            [rotating_part(train, rotating_masses([*row, *weights]), 1) for weights in cancelling]
            for row in running
        ]
        return _stacked([_stacked(row, -3) for row in rows], -4)[..., 0, :]

    which = [operation.working for operation in operations]
    name = f"residual of {which} with {balanced}, {idle}"
    return Parts(_stacked(shaking, -3), scene.once(name, residual))


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
        "docs/theory_mounts.md; the table of combinations is that of Ong (2000), table 4.4",
    )
    speed, orders = np.asarray(scene.case.machine.speed), forcing.order
    square = np.square(speed)[..., None]
    loads = operation_loads(scene, options.operations, options.balances)
    loads = loads.times(np.broadcast_to(square, (*speed.shape, len(orders))))
    # two that cancel at the nominal phase of a weight do not cancel at the others: one by one
    running, balances = loads.residual.shape[-3:-1]
    each = [loads.shaking[..., i, :, :] for i in range(running)]
    each += [
        loads.residual[..., i, j, None, :] * np.eye(len(orders), 1)
        for i in range(running)
        for j in range(balances)
    ]
    resonances = system.checked(orders, scene.case.machine.speed, scene.warn, *each)
    motion = superpose(system.dynamics(orders * speed[..., None], resonances), loads)
    kinds: tuple[tuple[type[OperationsEnergy], Bounded, Any], ...] = (
        (OperationsKinetic, mass_of(system.matrices), 1j * orders * speed[..., None]),
        (OperationsPotential, stiffness_of(system.matrices), np.ones(len(orders))),
    )
    for group, weight, rate in kinds:
        if scene.wants(*paths_of(group)):
            scene.emit_all(
                _energies(scene, group, weight, motion.times(rate)), names_of(scene.case)
            )


def _energies(
    scene: Scene, group: type[OperationsEnergy], matrix: Bounded, state: Parts
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
    def means() -> tuple[Bounded, Bounded]:
        dropped = dropped_mean(weight, state.shaking[..., used:, :], tail)
        kept = state._replace(shaking=state.shaking[..., :used, :])
        return mean_energy_range(weight, kept, dropped)

    @functools.cache
    def peaks() -> PhaseRange:
        rtol = scene.case.accuracy.rtol
        return peak_energy_range(matrix, state, orders, used, float(forcing.tail), rtol)

    return group(
        mean=mean,
        peak=lambda: peak_over_cycle(of_each, whole, orders, used, tail[..., None]),
        mean_low=lambda: means()[0],
        mean_high=lambda: means()[1],
        peak_low=lambda: peaks().low,
        peak_high=lambda: peaks().high,
        rotating_mean=rotating.mean,
        rotating_peak=rotating.peak,
        difference=mean.max(axis=-2) + (-mean).max(axis=-2),
        weighted=(mean * shares).sum(axis=-2),
    )
