"""Loads of several ways of running a machine, with several ways of balancing its crankshaft."""

from collections.abc import Sequence
from typing import NamedTuple

from vibecalc.case.response_tables import Balance, Operation
from vibecalc.excitation.adapter import rotating_part, train_excitation
from vibecalc.excitation.inertia_forces import Excitation
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.parts.crank_train import (
    build_crank_train,
    cancelling_weights,
    moving,
    rotating_masses,
    throws,
    weights_and_shafts,
)
from vibecalc.parts.firing import shakes_with_torque
from vibecalc.pipeline.scene import Scene

AS_IN_CASE = "as in the case"


class Loads(NamedTuple):
    """Loads per crank speed squared: `shaking` of each operation, `residual` of each balance too.

    Shaking is that of pistons, weights and shafts of the case; the residual is that of the throws
    which turn and of the weights which cancel the throws of a balance.
    """

    operations: tuple[str, ...]
    balances: tuple[str, ...]
    shaking: tuple[Excitation, ...]
    residual: tuple[tuple[Excitation, ...], ...]


def operation_loads(
    scene: Scene, operations: Sequence[Operation], balances: Sequence[Balance] = ()
) -> Loads:
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
    shaking, residual = [], []
    for operation in operations:
        runs = moving(whole, operation.working, idle)
        shaking.append(train_excitation(runs, fixed, motion, scene.case.machine, acts))
        rows = [
            rotating_masses([*throws(runs), *cancelling_weights(whole, names)])
            for _, names in named
        ]
        residual.append(tuple(rotating_part(whole, row, highest) for row in rows))
    return Loads(
        tuple(operation.name for operation in operations),
        tuple(name for name, _ in named),
        tuple(shaking),
        tuple(residual),
    )
