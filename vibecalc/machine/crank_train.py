"""The crank train as arrays: cylinders, and everything that turns."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts
from vibecalc.case.tables import Excitation
from vibecalc.machine.frame import build_frame

Array = NDArray[np.float64]
Row = tuple[str, float, int, float, Array]


@dataclass(frozen=True, kw_only=True)
class CrankTrain:
    """n cylinders on one crankshaft; lengths in m, masses in kg, angles in rad.

    `position` (n,) runs along the crankshaft from `origin`, which itself counts from the body's
    reference point. `reciprocating_mass` (n,) moves with the pistons, `rotating_mass` (n,) sits at
    the crank pins; a rod is the two point masses that keep its mass and mass centre (its moment of
    inertia is then that of the two points, the usual approximation).
    """

    crank_radius: float
    rod_length: float
    wrist_pin_offset: float
    names: tuple[str, ...]
    position: Array
    crank_phase: Array
    bank_angle: Array
    reciprocating_mass: Array
    rotating_mass: Array
    origin: Array
    axis: Array
    stroke: Array
    across: Array


@dataclass(frozen=True, kw_only=True)
class RotatingMasses:
    """m unbalances that turn at constant speed: throws, counterweights, balance shafts.

    `unbalance` (m,) is mass times radius in kg m, `speed_ratio` (m,) the shaft speed over the
    crank speed (negative turns the other way), `phase` (m,) the angle from the stroke at crank
    angle zero in the crank's sense of rotation, `position` (m, 3) counts from the train's origin
    along x, y, z of the body.
    """

    names: tuple[str, ...]
    unbalance: Array
    speed_ratio: NDArray[np.int64]
    phase: Array
    position: Array


def rod_share(train: parts.CrankTrain) -> float:
    """Share of the rod's mass that moves with the piston: given, or from its mass centre."""
    rod = train.rod
    if rod is None:
        return 0.0
    if rod.reciprocating_fraction is not None:
        return float(rod.reciprocating_fraction)
    return float((rod.crank_pin_to_mass_centre or 0.0) / train.rod_length)


def reciprocating_mass(train: parts.CrankTrain) -> float | None:
    """Mass in kg that moves with one piston, or None if the train does not say."""
    if train.reciprocating_mass is not None:
        return float(train.reciprocating_mass)
    if train.piston_mass is None and train.pin_mass is None and train.rod is None:
        return None
    rod = 0.0 if train.rod is None else train.rod.mass * rod_share(train)
    return float((train.piston_mass or 0.0) + (train.pin_mass or 0.0) + rod)


def working_names(train: parts.CrankTrain, options: Excitation | None) -> tuple[str, ...]:
    """Names of the cylinders that work, in their order."""
    names = tuple(cylinder.name for cylinder in train.cylinders)
    works = None if options is None else options.working
    return names if works is None else tuple(name for name in names if name in works)


def build_crank_train(train: parts.CrankTrain) -> CrankTrain:
    """Arrays of a validated crank train; a cylinder's own masses override those of the train.

    A cylinder's `reciprocating_mass` is all that moves with its piston; to its `rotating_mass`, as
    to that of the train, the rotating share of the rod is added.
    """
    frame = build_frame(train.axis, train.stroke)
    common = reciprocating_mass(train) or 0.0
    rod = 0.0 if train.rod is None else train.rod.mass * (1.0 - rod_share(train))
    cylinders = train.cylinders
    own = [c.reciprocating_mass for c in cylinders]
    pins = [train.rotating_mass if c.rotating_mass is None else c.rotating_mass for c in cylinders]
    return CrankTrain(
        crank_radius=train.crank_radius,
        rod_length=train.rod_length,
        wrist_pin_offset=train.wrist_pin_offset,
        names=tuple(c.name for c in cylinders),
        position=np.array([c.position for c in cylinders]),
        crank_phase=np.array([c.crank_phase for c in cylinders]),
        bank_angle=np.array([c.bank_angle for c in cylinders]),
        reciprocating_mass=np.array([common if mass is None else mass for mass in own]),
        rotating_mass=np.array([pin + rod for pin in pins]),
        origin=np.array(train.origin),
        axis=frame.axis,
        stroke=frame.stroke,
        across=frame.across,
    )


def moving(train: CrankTrain, working: Sequence[str] | None, idle: str) -> CrankTrain:
    """The train with the cylinders that do not work left out of what moves.

    `working` names cylinders, None all of them. An idle cylinder that is "stopped" has no moving
    mass (its throw stands still or has no eccentricity), one that is "unloaded" moves as before.
    """
    if working is None or idle == "unloaded":
        return train
    runs = np.array([name in working for name in train.names], dtype=float)
    return replace(
        train,
        reciprocating_mass=runs * train.reciprocating_mass,
        rotating_mass=runs * train.rotating_mass,
    )


def throws(train: CrankTrain) -> list[Row]:
    """The unbalance of every throw that has a rotating mass."""
    return [
        (f"throw {name}", mass * train.crank_radius, 1, phase, place * train.axis)
        for name, mass, phase, place in zip(
            train.names, train.rotating_mass, train.crank_phase, train.position, strict=True
        )
        if mass != 0.0
    ]


def cancelling_weights(train: CrankTrain, balanced_for: Sequence[str] | None) -> list[Row]:
    """Weights opposite to the throws of the named cylinders, in the plane of each.

    They cancel the rotating masses of these throws as they are when their cylinders work, so
    `train` is the whole one.
    """
    names = balanced_for or ()
    return [
        (f"weight for {name}", mass * train.crank_radius, 1, phase + np.pi, place * train.axis)
        for name, mass, phase, place in zip(
            train.names, train.rotating_mass, train.crank_phase, train.position, strict=True
        )
        if name in names and mass != 0.0
    ]


def weights_and_shafts(train: parts.CrankTrain) -> list[Row]:
    """Counterweights and balance shafts, as the case has them."""
    along = build_frame(train.axis, train.stroke).axis
    weights: list[Row] = [
        (weight.name, weight.unbalance, 1, weight.phase, weight.position * along)
        for weight in train.counterweights
    ]
    shafts: list[Row] = [
        (shaft.name, shaft.unbalance, shaft.speed_ratio, shaft.phase, np.array(shaft.position))
        for shaft in train.balance_shafts
    ]
    return [*weights, *shafts]


def rotating_masses(rows: Sequence[Row]) -> RotatingMasses:
    """Rows of name, unbalance, speed ratio, phase and place as arrays."""
    return RotatingMasses(
        names=tuple(row[0] for row in rows),
        unbalance=np.array([row[1] for row in rows], dtype=float),
        speed_ratio=np.array([row[2] for row in rows], dtype=np.int64),
        phase=np.array([row[3] for row in rows], dtype=float),
        position=np.array([row[4] for row in rows], dtype=float).reshape(len(rows), 3),
    )


def build_rotating_masses(
    train: parts.CrankTrain, options: Excitation | None = None
) -> RotatingMasses:
    """All that turns: throws with a rotating mass, then weights, then balance shafts.

    `options` says which cylinders work and for which the crankshaft is balanced.
    """
    whole = build_crank_train(train)
    runs = whole if options is None else moving(whole, options.working, options.idle)
    ideal = [] if options is None else cancelling_weights(whole, options.balanced_for)
    return rotating_masses([*throws(runs), *ideal, *weights_and_shafts(train)])
