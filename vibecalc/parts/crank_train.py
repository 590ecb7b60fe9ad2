"""The crank train as arrays, and whether it can turn: cylinders, throws, rotating weights."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import Problem, listing
from vibecalc.kinds import TRAIN, has_crank_train
from vibecalc.numerics.leading import side_by_side
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts import body_tables
from vibecalc.parts import tables as parts
from vibecalc.parts.body import DIRECTIONS, build_frame
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The crank train as arrays: cylinders, and everything that turns.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]
#: name, unbalance, speed ratio, phase, place
Row = tuple[str, float | Array, int, float | Array, Array]


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class CrankTrain:
    """n cylinders on one crankshaft; lengths in m, masses in kg, angles in rad.

    `position` (n,) runs along the crankshaft from `origin`, which itself counts from the body's
    reference point. `reciprocating_mass` (n,) moves with the pistons, `rotating_mass` (n,) sits at
    the crank pins; a rod is the two point masses that keep its mass and mass centre (its moment of
    inertia is then that of the two points, the usual approximation).

    Where numbers of the case are arrays (points,), so are the lengths, and what follows from them
    is (points, n) or, of the origin, (points, 3).
    """

    crank_radius: Any
    rod_length: Any
    wrist_pin_offset: Any
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


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class RotatingMasses:
    """m unbalances that turn at constant speed: throws, counterweights, balance shafts.

    `unbalance` (m,) is mass times radius in kg m, `speed_ratio` (m,) the shaft speed over the
    crank speed (negative turns the other way), `phase` (m,) the angle from the stroke at crank
    angle zero in the crank's sense of rotation, `position` (m, 3) counts from the train's origin
    along x, y, z of the body. Leading axes as of `CrankTrain`, except for the ratios. Unbalances
    and phases that were sought are `Bounded`.
    """

    names: tuple[str, ...]
    unbalance: Any
    speed_ratio: NDArray[np.int64]
    phase: Any
    position: Array


def rod_share(train: parts.CrankTrain) -> float:
    """Share of the rod's mass that moves with the piston: given, or from its mass centre."""
    rod = train.rod
    if rod is None:
        return 0.0
    if rod.reciprocating_fraction is not None:
        return rod.reciprocating_fraction
    return _given(rod.crank_pin_to_mass_centre) / train.rod_length


def _given(number: float | None) -> float:
    return 0.0 if number is None else number


def reciprocating_mass(train: parts.CrankTrain) -> float | None:
    """Mass in kg that moves with one piston, or None if the train does not say."""
    if train.reciprocating_mass is not None:
        return train.reciprocating_mass
    if train.piston_mass is None and train.pin_mass is None and train.rod is None:
        return None
    rod = 0.0 if train.rod is None else train.rod.mass * rod_share(train)
    return _given(train.piston_mass) + _given(train.pin_mass) + rod


def working_names(train: parts.CrankTrain, works: Sequence[str] | None) -> tuple[str, ...]:
    """Names of the cylinders that work, in their order; `works` None is all of them."""
    names = tuple(cylinder.name for cylinder in train.cylinders)
    return names if works is None else tuple(name for name in names if name in works)


def build_crank_train(train: parts.CrankTrain) -> CrankTrain:
    """Arrays of a validated crank train; a cylinder's own masses override those of the train.

    A cylinder's `reciprocating_mass` is all that moves with its piston; to its `rotating_mass`, as
    to that of the train, the rotating share of the rod is added.
    """
    frame = build_frame(train.axis, train.stroke_axis)
    common = _given(reciprocating_mass(train))
    rod = 0.0 if train.rod is None else train.rod.mass * (1.0 - rod_share(train))
    cylinders = train.cylinders
    masses = [c.reciprocating_mass for c in cylinders]
    pins = [train.rotating_mass if c.rotating_mass is None else c.rotating_mass for c in cylinders]
    return CrankTrain(
        crank_radius=train.crank_radius,
        rod_length=train.rod_length,
        wrist_pin_offset=train.wrist_pin_offset,
        names=tuple(c.name for c in cylinders),
        position=side_by_side([c.position for c in cylinders]),
        crank_phase=side_by_side([c.crank_phase for c in cylinders]),
        bank_angle=side_by_side([c.bank_angle for c in cylinders]),
        reciprocating_mass=side_by_side([common if mass is None else mass for mass in masses]),
        rotating_mass=side_by_side(
            [0.0 if c.articulated else pin + rod for c, pin in zip(cylinders, pins, strict=True)]
        ),
        origin=side_by_side(train.origin),
        axis=frame.axis,
        stroke=frame.stroke,
        across=frame.across,
    )


def crank_geometry(train: parts.CrankTrain) -> CrankGeometry:
    """Lengths of one cylinder; without gas there may be no bore, which counts as zero."""
    return CrankGeometry(
        train.crank_radius, train.rod_length, train.bore or 0.0, train.wrist_pin_offset
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
    columns = [train.rotating_mass, train.crank_phase, train.position]
    parts = (np.moveaxis(column, -1, 0) for column in columns)
    return [
        (f"throw {name}", mass * train.crank_radius, 1, phase, _on_shaft(place, train.axis))
        for name, mass, phase, place in zip(train.names, *parts, strict=True)
        if np.any(mass)
    ]


def _on_shaft(place: float | Array, axis: Array) -> Array:
    """Places (..., 3) of distances (...) along the shaft."""
    return np.asarray(place)[..., None] * axis


def cancelling_weights(train: CrankTrain, balanced_for: Sequence[str] | None) -> list[Row]:
    """Weights opposite to the throws of the named cylinders, in the plane of each.

    They cancel the rotating masses of these throws as they are when their cylinders work, so
    `train` is the whole one.
    """
    names = {f"throw {name}": f"weight for {name}" for name in balanced_for or ()}
    return [
        (names[throw], unbalance, ratio, phase + np.pi, place)
        for throw, unbalance, ratio, phase, place in throws(train)
        if throw in names
    ]


def weights_and_shafts(train: parts.CrankTrain) -> list[Row]:
    """Counterweights and balance shafts, as the case has them."""
    along = build_frame(train.axis, train.stroke_axis).axis
    rows: list[Row] = [
        (weight.name, weight.unbalance, 1, weight.phase, _on_shaft(weight.position, along))
        for weight in train.counterweights
    ]
    rows += (
        (shaft.name, shaft.unbalance, shaft.speed_ratio, shaft.phase, side_by_side(shaft.position))
        for shaft in train.balance_shafts
    )
    return rows


def rotating_masses(rows: Sequence[Row]) -> RotatingMasses:
    """Rows of name, unbalance, speed ratio, phase and place as arrays."""
    places = side_by_side([row[4] for row in rows], own=1) if rows else np.zeros((0, 3))
    return RotatingMasses(
        names=tuple(row[0] for row in rows),
        unbalance=side_by_side([row[1] for row in rows]),
        speed_ratio=np.array([row[2] for row in rows], dtype=np.int64),
        phase=side_by_side([row[3] for row in rows]),
        position=places,
    )


def build_rotating_masses(case: Case) -> RotatingMasses:
    """All that turns: throws with a rotating mass, then weights, then balance shafts.

    `[excitation]` says which cylinders work and for which the crankshaft is balanced.
    """
    train, options = case.machine.crank_train, case.excitation
    whole = build_crank_train(train)
    runs = whole if options is None else moving(whole, options.working, options.idle)
    ideal = [] if options is None else cancelling_weights(whole, options.balanced_for)
    return rotating_masses([*throws(runs), *ideal, *weights_and_shafts(train)])


# ----------------------------------------------------------------------------
# Can this crank train turn, and does anything move in it?
# ----------------------------------------------------------------------------


@listing
def crank_train_problems(case: Case) -> Iterator[Problem]:
    """Problems of directions, lengths, masses and of the series chosen for the motion."""
    if not has_crank_train(case.machine):
        return
    train = case.machine.crank_train
    if train.axis == train.stroke_axis:
        others = " or ".join(repr(name) for name in DIRECTIONS if name != train.axis)
        yield Problem(
            path=(*TRAIN, "stroke_axis"),
            message="the pistons cannot move along the crankshaft",
            found=f"stroke_axis = '{train.stroke_axis}', and axis = '{train.axis}'",
            allowed=f"{others} with this axis",
            also=(*TRAIN, "axis"),
        )
    yield from _lengths(train)
    yield from _series(case)
    yield from _masses(case)


def _lengths(train: parts.CrankTrain) -> list[Problem]:
    return rod_problems(train.crank_radius, train.rod_length, abs(train.wrist_pin_offset))


def turns(train: parts.CrankTrain) -> bool:
    """Whether the rod gets round, so that something can be computed from its motion."""
    return not _lengths(train)


def rod_problems(radius: float, rod_length: float, offset: float) -> list[Problem]:
    """Whether the rod gets round: lengths in m, all zero or more."""
    reach = radius + offset
    if rod_length > reach:
        return []
    what = " plus the wrist-pin offset" if offset else ""
    return [
        Problem(
            path=(*TRAIN, "rod_length"),
            message=f"connecting rod must be longer than the crank radius{what}",
            found=f"{rod_length:.6g} m",
            allowed=f"> {reach:.6g} m",
            hint="the ratio of crank radius to rod length is usually 0.2 to 0.35, i.e. a rod of "
            f"{radius / 0.35:.2g} to {radius / 0.2:.2g} m here",
            also=(*TRAIN, "crank_radius"),
        )
    ]


def _series(case: Case) -> Iterator[Problem]:
    """What the truncated series has no terms for."""
    train = case.machine.crank_train
    if case.kinematics is None or case.kinematics.series != "truncated":
        return
    if train.wrist_pin_offset != 0.0:
        yield Problem(
            path=("kinematics", "series"),
            message="the truncated series has no term for a wrist-pin offset",
            found=f"series = 'truncated' with an offset of {train.wrist_pin_offset:.6g} m",
            allowed="series = 'exact', or no offset",
            also=(*TRAIN, "wrist_pin_offset"),
        )
    if train.rod is not None and train.rod.inertia is not None:
        yield Problem(
            path=("kinematics", "series"),
            message="the truncated series has no terms for the rotation of the rod",
            found=f"series = 'truncated' with a rod inertia of {train.rod.inertia:.6g} kg*m^2",
            allowed="series = 'exact', or no inertia of the rod",
            also=(*TRAIN, "rod", "inertia"),
        )


def _masses(case: Case) -> Iterator[Problem]:
    train = case.machine.crank_train
    rod = train.rod
    if rod is not None and rod_share(train) > 1.0:
        yield Problem(
            path=(*TRAIN, "rod", "crank_pin_to_mass_centre"),
            message="the rod's mass centre lies beyond its wrist pin",
            found=f"{rod.crank_pin_to_mass_centre:.6g} m from the crank pin",
            allowed=f"at most the rod length, {train.rod_length:.6g} m",
            also=(*TRAIN, "rod_length"),
        )
        return
    arrays = build_crank_train(train)
    moving = float(arrays.reciprocating_mass.sum() + arrays.rotating_mass.sum())
    if moving == 0.0 and not any(_unbalances(train)):
        yield Problem(
            path=(*TRAIN, "reciprocating_mass"),
            message="nothing in the crank train has a mass",
            found="reciprocating and rotating masses of 0 kg",
            allowed="a mass above zero on at least one cylinder, throw, weight or shaft",
        )
    body = case.machine.body
    whole = None if body is None else _whole_mass(body)
    if body is not None and whole is not None and moving >= whole:
        yield Problem(
            path=("machine", "body", "mass" if body.mass_matrix is None else "mass_matrix"),
            message="the moving parts weigh more than the whole machine",
            found=f"{whole:.6g} kg, with {moving:.6g} kg of pistons, rods and throws",
            allowed=f"> {moving:.6g} kg",
            hint="masses are in kg unless they carry a unit, as in '400 g'",
            also=TRAIN,
        )


def _unbalances(train: parts.CrankTrain) -> list[Any]:
    weights = [weight.unbalance for weight in train.counterweights]
    return weights + [shaft.unbalance for shaft in train.balance_shafts]


def _whole_mass(body: body_tables.Body) -> float | None:
    """Mass in kg without the block; of a mass matrix the least on the diagonal of translation."""
    if body.mass_matrix is None:
        return sum(part.mass for part in body.parts) if body.parts else body.mass
    from vibecalc.parts.matrices import block_matrix  # it loads all that solves the motion

    least = float(np.diagonal(block_matrix(body.mass_matrix))[:3].min())
    return least if least > 0.0 else None  # what is no mass at all is reported for the matrix


#: crank over rod beyond which series grow long
LONGEST_REACH = 0.98
#: relative slack around bounds of the checks
_MARGIN = 1.0 + 1e-9


def crank_train_suspects(case: Case) -> BoolArray:
    """Points (...) of a case with arrays that `crank_train_problems` may refuse, or slow ones."""
    written = case.machine.crank_train
    train = build_crank_train(written)
    reach = train.crank_radius + np.abs(train.wrist_pin_offset)
    fine = (reach < LONGEST_REACH * train.rod_length) & np.asarray(rod_share(written) <= 1.0)
    if case.kinematics is not None and case.kinematics.series == "truncated":
        fine = fine & np.asarray(train.wrist_pin_offset == 0.0)
    moving = (train.reciprocating_mass + train.rotating_mass).sum(axis=-1)
    fine = fine & (sum(_unbalances(written), moving) > 0.0)
    if written.firing_order or any(c.firing_angle is not None for c in written.cylinders):
        placed = [angle for c in written.cylinders for angle in (c.crank_phase, c.bank_angle)]
        fine = fine & (not any(isinstance(angle, np.ndarray) for angle in placed))
    whole = None if case.machine.body is None else _whole_mass(case.machine.body)
    return np.asarray(~(fine if whole is None else fine & (moving * _MARGIN < whole)))
