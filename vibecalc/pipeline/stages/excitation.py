"""Adapter: pistons and turning weights to forces and couples on the body."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.balance import balance_table
from vibecalc.excitation.reciprocating import reciprocating_excitation
from vibecalc.excitation.residual import residual
from vibecalc.excitation.rotating import rotating_excitation
from vibecalc.excitation.sums import Excitation, add, at_speed
from vibecalc.machine.crank_train import CrankTrain
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.pipeline.catalogue import CATALOGUE
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.kinematics import PistonMotion

DIRECTIONS = ("x", "y", "z")
#: of what the dropped orders add, how much the few that stand for them must carry
LEADING_SHARE = 0.9
BALANCE = tuple(path for path in CATALOGUE if path.startswith("excitation/balance/"))


class Forcing(NamedTuple):
    """Forces and couples per crank speed squared for orders 1 .. kept, then guard orders.

    The response to the guard orders tells what dropping the rest costs: `tail` times as much.
    Where a response is wanted thousands of times, the few orders at the places `few` stand for
    all of them: the rest costs `few_tail` times as much as they do.
    """

    per_speed_squared: Excitation
    orders: np.ndarray
    kept: int
    tail: float
    few: np.ndarray
    few_tail: float


def run(scene: Scene) -> None:
    """Emit forces, couples, their peaks, the balance table and the residual, as asked."""
    motion: PistonMotion = scene.handed_on["motion"]
    train = scene.parts.crank_train
    per_square = _sum_of_parts(scene, motion)
    orders = np.arange(1, per_square.force.shape[0] + 1)
    few, share = _leading(per_square, motion.kept)
    few_tail = motion.tail / share if few.size else 0.0
    forcing = Forcing(per_square, orders, motion.kept, motion.tail, few, few_tail)
    scene.handed_on["forcing"] = forcing
    scene.cite(
        "d'Alembert sums of the crank train",
        "forces and couples on the body",
        "Biezeno and Grammel, Technische Dynamik, 2nd ed. 1953, ch. XI",
    )
    driven = at_speed(per_square, scene.case.machine.speed)
    axes = {"order": orders[: motion.kept], "direction": DIRECTIONS}
    for name, value, error in (
        ("force", driven.force, driven.force_error),
        ("couple", driven.couple, driven.couple_error),
    ):
        scene.emit(f"excitation/{name}", value[: motion.kept], error[: motion.kept], axes)
        if not scene.wants(f"excitation/{name}_peak"):
            continue
        peak = cycle_peak(value[: motion.kept].T, orders[: motion.kept])
        spread = error[: motion.kept].sum(0) + forcing.tail * np.abs(value[motion.kept :]).sum(0)
        scene.emit(
            f"excitation/{name}_peak", peak.value, peak.error + spread, {"direction": DIRECTIONS}
        )
    options = scene.case.excitation
    if options is not None and options.balance is not None and scene.wants(*BALANCE):
        _balance(scene, train, np.array(options.balance.orders))
    if options is not None and options.residual is not None:
        _residual(scene, driven, forcing)


def _residual(scene: Scene, driven: Excitation, forcing: Forcing) -> None:
    options = scene.case.excitation.residual if scene.case.excitation else None
    if options is None:
        raise ValueError("the case has no residual")
    kept, rest = (
        residual(
            Excitation._make(part[orders] for part in driven),
            force_weight=options.force_weight,
            couple_weight=options.couple_weight,
            reference_length=options.reference_length,
        )
        for orders in (slice(forcing.kept), slice(forcing.kept, None))
    )
    dropped = forcing.tail * float(rest.value)
    # hypot(kept, dropped) - kept
    total = float(kept.value + np.hypot(kept.value, dropped))
    added = dropped * (dropped / total) if total else 0.0
    scene.emit("excitation/residual", kept.value, kept.error + added)


def _leading(whole: Excitation, kept: int) -> tuple[np.ndarray, float]:
    """Places of the dropped orders that carry nine tenths of each component, and their share."""
    size = np.concatenate([np.abs(whole.force), np.abs(whole.couple)], axis=-1)[kept:]
    doubt = np.concatenate([whole.force_error, whole.couple_error], axis=-1)[kept:]
    size = np.where(size > doubt, size, 0.0)
    share = size / np.maximum(size.sum(0), np.finfo(float).tiny)
    downwards = np.argsort(-share, axis=0, kind="stable")
    ranked = np.take_along_axis(share, downwards, axis=0)
    needed = (np.cumsum(ranked, axis=0) - ranked < LEADING_SHARE) & (ranked > 0.0)
    # not np.unique, which imports the masked arrays of numpy
    leads = np.zeros(len(size), dtype=bool)
    leads[downwards[needed]] = True
    chosen = np.flatnonzero(leads)
    covered = share[chosen].sum(0)[size.any(0)]
    return kept + chosen, float(covered.min(initial=1.0))


def _sum_of_parts(scene: Scene, motion: PistonMotion) -> Excitation:
    train, rotating = scene.parts.crank_train, scene.parts.rotating_masses
    highest = motion.harmonics.shape[-1] - 1
    parts = [
        reciprocating_excitation(
            motion.harmonics,
            crank_radius=train.crank_radius,
            reciprocating_mass=train.reciprocating_mass,
            crank_phase=train.crank_phase,
            bank_angle=train.bank_angle,
            position=train.position,
            origin=train.origin,
            axis=train.axis,
            stroke=train.stroke,
            across=train.across,
            wrist_pin_offset=train.wrist_pin_offset,
            motion_error=motion.error,
        )
    ]
    if rotating.names:
        parts.append(
            rotating_excitation(
                unbalance=rotating.unbalance,
                speed_ratio=rotating.speed_ratio,
                phase=rotating.phase,
                position=rotating.position,
                origin=train.origin,
                stroke=train.stroke,
                across=train.across,
                highest_order=highest,
            )
        )
    options = scene.case.excitation
    if options is not None and options.driven_machine == "separate":
        parts.append(_reaction(train, motion, highest))
    return add(*parts)


def _reaction(train: CrankTrain, motion: PistonMotion, highest: int) -> Excitation:
    from vibecalc.excitation.inertia_torque import inertia_torque, torque_reaction

    torque = inertia_torque(
        motion.harmonics,
        highest,
        dropped_acceleration=motion.dropped_after_guard,
        motion_error=motion.error,
    )
    return torque_reaction(
        torque,
        crank_radius=train.crank_radius,
        reciprocating_mass=train.reciprocating_mass,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        axis=train.axis,
    )


def _balance(scene: Scene, train: CrankTrain, orders: np.ndarray) -> None:
    table = balance_table(
        orders,
        crank_phase=train.crank_phase,
        bank_angle=train.bank_angle,
        position=train.position,
    )
    values = table._asdict()
    for column in ("sine", "cosine", "position_sine", "position_cosine"):
        scene.emit(
            f"excitation/balance/{column}",
            values[column],
            values[f"{column}_error"],
            {"order": orders, "cylinder": train.names},
        )
        total = f"total_{column}"
        scene.emit(
            f"excitation/balance/{total}",
            values[total],
            values[f"{total}_error"],
            {"order": orders},
        )
