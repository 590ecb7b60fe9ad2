"""Adapter: pistons, turning weights, skewed conductors to forces and couples on the body."""

from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.axial_force import axial_force
from vibecalc.excitation.balance import balance_table, bank_sums, residual
from vibecalc.excitation.crank_forces import rod_difference, train_excitation
from vibecalc.excitation.inertia_forces import (
    at_speed,
    couples_of,
    forces_of,
    size_of_terms,
    with_terms,
)
from vibecalc.excitation.results import (
    BalanceColumns,
    BankColumns,
    Counterweights,
    Masses,
    OfRod,
    OnBody,
)
from vibecalc.kinematics.adapter import PistonMotion
from vibecalc.numerics.bounded import Bounded, Summed, reshaped, rounded
from vibecalc.numerics.cycle_peak import numbered, vector_cycle_peak
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import CrankTrain
from vibecalc.parts.firing import shakes_with_torque

# ----------------------------------------------------------------------------
# Adapter: pistons and turning weights to forces and couples on the body.
# ----------------------------------------------------------------------------

DIRECTIONS = ("x", "y", "z")
#: of what the dropped orders add, how much the few that stand for them must carry
LEADING_SHARE = 0.9


class Forcing(NamedTuple):
    """Loads (..., m, 6) per crank speed squared for orders 1 .. retained, then guard orders.

    The response to the guard orders tells what dropping the rest costs: `tail` (...) times as much.
    """

    per_speed_squared: Bounded
    order: np.ndarray
    retained: int
    tail: np.ndarray


class Orders(Protocol):
    """Orders (m,) of forces or of what follows from them: the first `retained` are results.

    Those behind them stand, `tail` (...) times, for all that is left out.
    """

    @property
    def order(self) -> np.ndarray: ...

    @property
    def retained(self) -> int: ...

    @property
    def tail(self) -> np.ndarray | float: ...


class MotionByOrder(NamedTuple):
    """Motion of a body at its speed, handed on to those who read it at other places.

    `motion` (..., m, 6) are complex amplitudes about the reference point at the orders `order`
    (m,) of the crank speed. The first `retained` are results; what follows stands, `tail` (...)
    times, for all that is left out.
    """

    order: np.ndarray
    retained: int
    tail: np.ndarray | float
    motion: Bounded


def left_out(harmonics: Bounded, of: Orders) -> tuple[np.ndarray, np.ndarray]:
    """Rounding of the kept orders and size of the dropped ones, summed: (...) of (..., orders)."""
    value, error = harmonics
    used, tail = of.retained, of.tail
    dropped = np.abs(value[..., used:]).sum(-1)
    tail = np.reshape(tail, (*np.shape(tail), *(1,) * (dropped.ndim - np.ndim(tail))))
    return error[..., :used].sum(-1), tail * dropped


def kept(harmonics: Bounded, of: Orders) -> Summed:
    """The orders that are results, of harmonics (..., orders), with the size of their terms."""
    return with_terms(harmonics[..., : of.retained])


def peak_with_tail(harmonics: Bounded, of: Orders) -> Summed:
    """Peaks over the cycle of harmonics (..., orders), the dropped ones in their errors.

    The first axes are those of the points, if there are. Without the dropped orders the error is
    rounding, which tells the size of the terms.
    """
    return length_over_cycle(harmonics[..., None, :], of)


def length_over_cycle(vector: Bounded, of: Orders) -> Summed:
    """Largest length (...) over the cycle of vectors (..., directions, orders)."""
    used = of.retained
    peak = vector_cycle_peak(vector.value[..., :used], numbered(of.order[:used]))
    rounding, dropped = left_out(vector, of)
    whole = peak.error + np.linalg.norm(rounding + dropped, axis=-1)
    return Summed(peak.value, whole, size_of_terms(peak.error + np.linalg.norm(rounding, axis=-1)))


def norm_with_tail(sizes: Bounded, of: Orders) -> Summed:
    """Root of the sum of squares (...) of sizes (..., orders), the dropped ones in its error."""
    first = sizes[..., : of.retained].norm()
    dropped = of.tail * np.linalg.norm(sizes.value[..., of.retained :], axis=-1)
    # hypot(first, dropped) - first
    total = first.value + np.hypot(first.value, dropped)
    added = dropped * (dropped / np.where(total > 0.0, total, 1.0))
    return with_terms(Bounded(first.value, first.error + added), first.error)


def run_excitation(scene: Scene) -> None:
    """Emit forces, couples, their peaks, the balance table and the residual, as asked."""
    motion: PistonMotion = scene.handed_on["motion"]
    train, machine = scene.parts.crank_train, scene.case.machine
    per_square = train_excitation(
        train, scene.parts.rotating_masses, motion, machine, shakes_with_torque(scene.case)
    )
    masses = Masses(
        reciprocating=rounded(train.reciprocating_mass, 8),
        rotating=rounded(train.rotating_mass, 8),
    )
    scene.emit_all(masses, {"cylinder": train.names})
    orders = np.arange(1, per_square.shape[-2] + 1)
    forcing = Forcing(per_square, orders, motion.highest_order, motion.tail)
    scene.handed_on["forcing"] = forcing
    scene.cite(
        "d'Alembert sums of the crank train",
        "forces and couples on the body",
        "Biezeno and Grammel, Technische Dynamik, 2nd ed. 1953, ch. XI",
    )
    driven, used = at_speed(per_square, machine.speed), forcing.retained
    if machine.crank_train.has_slave_rods:
        from vibecalc.excitation.articulated import emit_slaves

        emit_slaves(scene, driven, used)
    square = np.square(machine.speed)

    def peak(part: Bounded) -> Summed:
        """Of all speeds at once."""
        by_order = reshaped(part, lambda each: np.swapaxes(each, -1, -2))
        found = peak_with_tail(by_order, forcing)
        value, error = Bounded(found.value, found.error) * np.asarray(square)[..., None]
        return Summed(value, error, found.terms * float(np.max(square)))

    results = OnBody(
        force=with_terms(forces_of(driven)[..., :used, :]),
        couple=with_terms(couples_of(driven)[..., :used, :]),
        force_peak=lambda: peak(forces_of(per_square)),
        couple_peak=lambda: peak(couples_of(per_square)),
    )
    scene.emit_all(results, {"order": orders[:used], "direction": DIRECTIONS})
    if machine.crank_train.counterweights and scene.wants(*paths_of(Counterweights)):
        _counterweights(scene, train)
    if scene.wants(*paths_of(OfRod)):
        _rod(scene, train, forcing)
    options = scene.case.excitation
    table = (*paths_of(BalanceColumns), *paths_of(BankColumns))
    if options is not None and options.balance is not None and scene.wants(*table):
        _balance(scene, train, np.array(options.balance.orders))
    if options is not None and options.residual is not None:
        given = options.residual
        weights = given.force_weight, given.couple_weight, given.reference_length
        every = residual(driven, *weights)
        scene.emit_all(OnBody(residual=norm_with_tail(every, forcing)))


def _counterweights(scene: Scene, train: CrankTrain) -> None:
    """Force of each weight at operating speed, and the couple that its place makes of it."""
    weights = scene.case.machine.crank_train.counterweights
    unbalance, position = (
        side_by_side([getattr(weight, name) for weight in weights])
        for name in ("unbalance", "position")
    )
    force = unbalance * np.square(scene.case.machine.speed)[..., None]
    # the weight turns across the shaft, so the part of its lever along the shaft counts always
    along = np.abs((train.origin @ train.axis)[..., None] + position)
    found = Counterweights(force=rounded(force, 4), couple=rounded(force * along, 12))
    scene.emit_all(found, {"counterweight": [weight.name for weight in weights]})


def _rod(scene: Scene, train: CrankTrain, forcing: Forcing) -> None:
    """What the two point masses that stand for a rod leave out, at operating speed."""
    rod = scene.case.machine.crank_train.rod
    if rod is None or rod.crank_pin_to_mass_centre is None:
        return
    from vibecalc.excitation.rod_inertia import rod_couple_peak
    from vibecalc.kinematics.rod_angle import rod_angle_harmonics

    square = np.square(scene.case.machine.speed)
    lengths = (train.crank_radius, train.rod_length, train.wrist_pin_offset)
    difference = rod_difference(train, rod)
    points = (0.0 if rod.inertia is None else rod.inertia) - difference.value
    scene.emit_all(OfRod(split_inertia=Bounded(points, difference.error + EPSILON * points)))
    peak = square * rod_couple_peak(difference, *lengths)
    if rod.inertia is None:
        scene.emit_all(OfRod(couple_bound=peak))
        return
    scene.cite(
        "moment of the rod beyond its two point masses", "couple on the body", "docs/theory.md"
    )
    turning = rod_angle_harmonics(*lengths, highest_order=forcing.retained).acceleration
    couple = (square * difference)[..., None] * turning
    orders = np.arange(forcing.retained + 1)
    scene.emit_all(OfRod(couple=couple, couple_peak=peak), {"order": orders})


def few_orders(forcing: Forcing) -> tuple[np.ndarray, np.ndarray | float]:
    """Places of the dropped orders that carry nine tenths of each component, of any point.

    They stand for all where a response is wanted thousands of times: the rest costs so many times
    as much as they do (...).
    """
    retained = forcing.retained
    beyond = forcing.per_speed_squared[..., retained:, :]
    size = np.abs(beyond.value)
    size = np.where(size > beyond.error, size, 0.0)
    share = size / np.maximum(size.sum(-2, keepdims=True), np.finfo(float).tiny)
    downwards = np.argsort(-share, axis=-2, kind="stable")
    ranked = np.take_along_axis(share, downwards, axis=-2)
    needed = (np.cumsum(ranked, axis=-2) - ranked < LEADING_SHARE) & (ranked > 0.0)
    leads = np.zeros(share.shape, dtype=bool)
    np.put_along_axis(leads, downwards, needed, axis=-2)
    chosen = np.flatnonzero(leads.any(axis=(*range(share.ndim - 2), -1)))
    covered = np.where(size.any(-2), share[..., chosen, :].sum(-2), 1.0)
    tail = forcing.tail / covered.min(axis=-1, initial=1.0) if chosen.size else 0.0
    return retained + chosen, tail


def _balance(scene: Scene, train: CrankTrain, orders: np.ndarray) -> None:
    known = {"order": orders, "cylinder": train.names, "direction": DIRECTIONS}
    # a sweep may make banks of one and one of banks: it gets what it asks for
    every = scene.wanted is not None
    banks = not every and scene.case.machine.crank_train.has_banks
    placed = {
        "crank_phase": train.crank_phase,
        "bank_angle": train.bank_angle,
        "position": train.position,
    }
    place, one = np.abs(train.position), np.ones(len(train.names))

    def summed(columns: dict[str, Bounded], whole: bool) -> dict[str, Summed]:
        """With terms of 1, or of the place of a cylinder, which a sine or cosine leaves."""
        found = {}
        for name, column in columns.items():
            terms = place if "position" in name else one
            size = terms.sum() if whole or name.startswith("total_") else terms.max()
            if not (banks and name.startswith("total_")):
                found[name] = Summed(column.value, column.error, float(size))
        return found

    scene.emit_all(BalanceColumns(**summed(balance_table(orders, **placed), False)), known)
    if (every or banks) and scene.wants(*paths_of(BankColumns)):
        sums = bank_sums(orders, **placed, stroke=train.stroke, across=train.across)
        scene.emit_all(BankColumns(**summed(sums, True)), known)


# ----------------------------------------------------------------------------
# Adapter: torque harmonics of the motor to the axial force of its skewed conductors.
# ----------------------------------------------------------------------------


def run_motor(scene: Scene) -> None:
    """Emit the axial force by order, its mean, bound, peak and effective value."""
    order, found = axial_force(scene.case.machine.motor)
    scene.emit_all(found, {"order": order})
    scene.cite(
        "normal force on skewed conductors",
        "axial force of the motor",
        "Ong (2000), equations 6.1 to 6.6, with the tangent of the skew angle",
    )
