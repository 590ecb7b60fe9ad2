"""From a case to arrays: running gear, gas, what turns with the shaft, where the bearings stand."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.bearings.crank_loads import bearing_shares
from vibecalc.bearings.rod_forces import RunningGear, mixed
from vibecalc.excitation.crank_forces import rod_difference
from vibecalc.excitation.gas_tables import (
    card_weights,
    force_at,
    pressure_with_error,
)
from vibecalc.excitation.model import force_curves, has_cards
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.crank_train import CrankTrain, RotatingMasses, crank_geometry, rod_share
from vibecalc.parts.firing import TURN
from vibecalc.unit_table import FREE_FALL

if TYPE_CHECKING:
    from vibecalc.bearings.tables import BearingLoads, ShaftLoad
    from vibecalc.schema import Case

#: gas force (..., c) in N towards the crank, at crank angles (...) in rad and speeds (...) in rad/s
GasAt = Callable[[FloatArray, FloatArray], Bounded]


class Gas(NamedTuple):
    """Gas force of the cylinders, and the crank angles (k,) in rad at which it has kinks."""

    at: GasAt
    breaks: FloatArray


class Shaft(NamedTuple):
    """A crankshaft on b bearings: what each takes of the forces of c rods and of m weights.

    `rod_share` (b, c) and `weight_share` (b, m) are without unit; `unbalance` (m,) in kg m turns
    with the crank, `weight_angle` (m,) its angle at crank angle zero; `at_rest` (b,) in N is what
    each bearing bears of constant loads, complex: along the stroke + i ahead of it.
    """

    names: tuple[str, ...]
    rod_share: FloatArray
    unbalance: FloatArray
    weight_angle: FloatArray
    weight_share: FloatArray
    at_rest: ComplexArray


def running_gear(case: "Case", train: CrankTrain) -> RunningGear:
    """The running gear of the cylinders that move; the others have no mass."""
    written = case.machine.crank_train
    rod, share = written.rod, rod_share(written)
    moves = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    mass, difference = (0.0, 0.0) if rod is None else (rod.mass, 0.0)
    if rod is not None and rod.inertia is not None:
        difference = float(rod_difference(train, rod).value)
    return RunningGear(
        crank_geometry(written),
        train.crank_phase - train.bank_angle,
        train.reciprocating_mass,
        moves * mass * share,
        moves * mass * (1.0 - share),
        moves * difference,
    )


def shaft_of(
    case: "Case", table: "BearingLoads", train: CrankTrain, rotating: RotatingMasses
) -> Shaft:
    """What loads the bearings besides the rods; balance shafts have bearings of their own."""
    bearings = [bearing.position for bearing in table.main_bearings]
    own = np.arange(len(rotating.names)) < len(rotating.names) - len(
        case.machine.crank_train.balance_shafts
    )
    along = rotating.position[own] @ train.axis
    fall = free_fall(case, table, train)
    loads = [_constant(load, train, fall) for load in table.shaft_loads]
    places = [load.position for load in table.shaft_loads]
    shares = bearing_shares(bearings, places)
    return Shaft(
        tuple(bearing.name for bearing in table.main_bearings),
        bearing_shares(bearings, train.position),
        rotating.unbalance[own],
        rotating.phase[own],
        bearing_shares(bearings, along),
        shares @ np.array(loads, dtype=complex),
    )


def _constant(load: "ShaftLoad", train: CrankTrain, fall: FloatArray) -> complex:
    if load.force is not None:
        force = np.asarray(load.force)
    else:
        assert load.mass is not None
        force = load.mass * fall
    return complex(force @ train.stroke, force @ -train.across)


def free_fall(case: "Case", table: "BearingLoads", train: CrankTrain) -> FloatArray:
    """Acceleration (3,) of free fall in m/s^2: that of the body on its mounts, where it has any."""
    isolation = case.isolation
    name = table.up if isolation is None else isolation.up
    up = train.stroke if name is None else np.eye(3)[DIRECTIONS.index(name.strip("-"))]
    size = FREE_FALL if isolation is None else isolation.gravity
    return np.asarray((size if name is not None and name.startswith("-") else -size) * up)


# ----------------------------------------------------------------------------
# The gas in the cylinders: cards of an engine, the liquid of a pump, a pressure or force over a
# turn of a compressor, or nothing.
# ----------------------------------------------------------------------------


def gas_of(case: "Case", train: CrankTrain) -> Gas:
    """The gas force of the cylinders that work.

    Raises NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    working = None if case.excitation is None else case.excitation.working
    runs = np.array([working is None or name in working for name in train.names], dtype=float)
    if has_cards(case.machine):
        return _of_cards(case, train, runs)
    return _of_one_turn(case, train, runs)


def _none(angle: FloatArray, speed: FloatArray, count: int) -> Bounded:
    zero = np.zeros((*np.broadcast_shapes(np.shape(angle), np.shape(speed)), count))
    return Bounded(zero, zero)


def _of_cards(case: "Case", train: CrankTrain, runs: FloatArray) -> Gas:
    from vibecalc.excitation.model import build_firing, gas_cards, misfire_cards

    count, machine = len(train.names), case.machine
    speeds, cards = gas_cards(machine)
    if not cards:
        return Gas(lambda angle, speed: _none(angle, speed, count), np.zeros(0))
    area = crank_geometry(machine.crank_train).piston_area
    if machine.kind == "pump":
        zero, scale = train.bank_angle - train.crank_phase, runs
        silent, dead = np.zeros(count, dtype=bool), cards
    else:
        firing = build_firing(case)
        zero, scale = firing.first + firing.angle, runs * firing.pressure_scale
        silent, dead = ~firing.fires, misfire_cards(case, cards)
    nodes = [card.node + start for card in (*cards, *dead) for start in zero]
    known = speeds if len(speeds) else np.zeros(1)

    def at(angle: FloatArray, speed: FloatArray) -> Bounded:
        own = np.asarray(angle, dtype=float)[..., None] - zero
        weights = card_weights(known, np.asarray(speed, dtype=float))
        found = mixed([pressure_with_error(card, own) for card in cards], weights)
        if silent.any():
            ill = mixed([pressure_with_error(card, own) for card in dead], weights) if dead else 0.0
            found = (~silent).astype(float) * found + silent.astype(float) * ill
        force: Bounded = area * scale * found
        return force

    return Gas(at, np.concatenate(nodes))


def _of_one_turn(case: "Case", train: CrankTrain, runs: FloatArray) -> Gas:
    """Pressure times area, or the force that a cylinder has of its own, over one turn."""
    count, curves = len(train.names), force_curves(case.machine)
    if not any(curve is not None for curve in curves):
        return Gas(lambda angle, speed: _none(angle, speed, count), np.zeros(0))
    turned = train.crank_phase - train.bank_angle
    nodes = [curve.node - turned[i] for i, curve in enumerate(curves) if curve is not None]

    def at(angle: FloatArray, speed: FloatArray) -> Bounded:
        own = np.mod(np.asarray(angle, dtype=float)[..., None] + turned, TURN)
        value, error = np.zeros(own.shape), np.zeros(own.shape)
        for i, curve in enumerate(curves):
            if curve is None or not runs[i]:
                continue
            value[..., i] = force_at(curve, own[..., i])
            steepest = np.abs(curve.coefficient[:, 1:2]).max(initial=0.0)
            order = np.arange(len(curve.harmonics))
            steepest = max(steepest, float((order * np.abs(curve.harmonics)).sum()))
            top = np.abs(curve.coefficient[:, 0]).max(initial=0.0) + np.abs(curve.harmonics).sum()
            error[..., i] = 24.0 * EPSILON * (top + TURN * steepest)
        shape = np.broadcast_shapes(np.shape(angle), np.shape(speed))
        return Bounded(*(np.broadcast_to(part, (*shape, count)) for part in (value, error)))

    return Gas(at, np.concatenate(nodes))
