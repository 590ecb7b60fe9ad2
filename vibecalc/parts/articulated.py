"""Slave rods of a case as arrays, and what cannot have them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import TRAIN
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.parts import tables as parts
from vibecalc.parts.crank_train import reciprocating_mass, rod_share
from vibecalc.parts.firing import has_gas
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.parts.weight_tables import ArticulatedRod

Array = NDArray[np.float64]


#: slack of bounds of the checks
_MARGIN = 1.0 + 1e-9


class Slaves(NamedTuple):
    """k slave rods, (k,) each: their cylinders and masters by place, lengths in m, angles in rad.

    `knuckle_mass` in kg is what moves with the knuckle pin, `rod_difference` in kg m^2 the moment
    of inertia of the rod beyond that of its two point masses.
    """

    cylinder: NDArray[np.int64]
    master: NDArray[np.int64]
    knuckle_radius: Array
    knuckle_angle: Array
    rod_length: Array
    knuckle_mass: Array
    rod_difference: Bounded


def build_slaves(train: parts.CrankTrain) -> Slaves:
    """Arrays of the slave rods of a validated train.

    Where the knuckle pin's angle is not said, it is that between the two cylinders, and its mass
    that of the train's rod at its crank pin.
    """
    at_crank_pin = 0.0 if train.rod is None else train.rod.mass * (1.0 - rod_share(train))
    names = [cylinder.name for cylinder in train.cylinders]
    rows = []
    for place, cylinder in enumerate(train.cylinders):
        given = cylinder.articulated
        if given is None:
            continue
        master = names.index(given.on)
        angle = given.knuckle_angle
        if angle is None:
            angle = cylinder.bank_angle - train.cylinders[master].bank_angle
        mass = at_crank_pin if given.knuckle_mass is None else given.knuckle_mass
        own, points = given.inertia or 0.0, 0.0  # without a moment it is that of the points
        if given.inertia is not None and given.rod_mass is not None:
            points = mass * (1.0 - mass / given.rod_mass) * given.rod_length**2
        rows.append(
            (place, master, given.knuckle_radius, angle, given.rod_length, mass, own, points)
        )
    columns: list[Any] = [np.array(column) for column in zip(*rows, strict=True)]
    difference = rounded(columns[6], 16) - rounded(columns[7], 16)
    return Slaves(*[*columns[:6], difference])


def steepest_ratio(train: parts.CrankTrain) -> float:
    """Largest ratio of what swings a rod to its length, by which orders fall off."""
    ratio = train.crank_radius / train.rod_length
    for cylinder in train.cylinders:
        given = cylinder.articulated
        if given is not None:
            swung = train.crank_radius + given.knuckle_radius * ratio
            ratio = max(ratio, swung / given.rod_length)
    return min(ratio, 0.999)


# ----------------------------------------------------------------------------
# What articulated rods cannot be, and where they cannot be.
# ----------------------------------------------------------------------------


def articulated_problems(case: Case) -> list[Problem]:
    """Problems of slave rods: their masters, their lengths, and stages without them."""
    train = case.machine.crank_train
    problems = [
        problem for place in range(len(train.cylinders)) for problem in _of_slave(train, place)
    ]
    return [*problems, *_stages(case)]


def _of_slave(train: parts.CrankTrain, place: int) -> Iterator[Problem]:
    cylinder = train.cylinders[place]
    given = cylinder.articulated
    if given is None:
        return
    path: KeyPath = (*TRAIN, "cylinders", place, "articulated")
    at = next((i for i, one in enumerate(train.cylinders) if one.name == given.on), None)
    if at is None:
        return  # said by the rules
    master = train.cylinders[at]
    also: KeyPath = (*TRAIN, "cylinders", at)
    if at == place or master.articulated is not None:
        yield Problem(
            path=(*path, "on"),
            message="a slave rod is hinged to a master rod on the crank pin",
            found=f"on = {given.on!r}, " + ("itself" if at == place else "a slave rod, too"),
            allowed="the name of a cylinder without articulated",
            also=also,
        )
        return
    for key in ("position", "crank_phase"):
        own, its = getattr(cylinder, key), getattr(master, key)
        if abs(own - its) > 1e-9:
            yield Problem(
                path=(*TRAIN, "cylinders", place, key),
                message=f"a slave rod has the {key} of its master",
                found=f"{own:.6g}, and {its:.6g} of {given.on!r}",
                allowed=f"{its:.6g}, as of {given.on!r}",
                also=(*also, key),
            )
    if cylinder.rotating_mass is not None:
        yield Problem(
            path=(*TRAIN, "cylinders", place, "rotating_mass"),
            message="a slave rod has no throw of its own",
            allowed="rotating_mass on its master; knuckle_mass is what the slave rod has at its "
            "knuckle pin",
            also=path,
        )
    yield from _own_inertia(train, given, cylinder, path)
    reach = train.crank_radius + given.knuckle_radius + abs(train.wrist_pin_offset)
    if given.rod_length <= reach:
        yield Problem(
            path=(*path, "rod_length"),
            message="a slave rod must be longer than crank radius and knuckle radius together",
            found=f"{given.rod_length:.6g} m",
            allowed=f"> {reach:.6g} m",
            hint="usual is the length of the master rod less the knuckle radius, here "
            f"{train.rod_length - given.knuckle_radius:.4g} m",
            also=(*path, "knuckle_radius"),
        )


def _own_inertia(
    train: parts.CrankTrain, given: "ArticulatedRod", cylinder: parts.Cylinder, path: KeyPath
) -> Iterator[Problem]:
    """Rods of a moment of inertia of their own: all of them, each with masses that it can have."""
    rod = train.rod
    if given.inertia is None and rod is not None and rod.inertia is not None:
        yield Problem(
            path=path,
            message="the rod of the crank train has a moment of inertia of its own, and the slave "
            "rod has none",
            allowed="inertia and rod_mass of each slave rod, or no inertia of the rod",
            hint="two point masses have knuckle_mass (rod_mass - knuckle_mass) / rod_mass "
            "rod_length^2",
            also=(*TRAIN, "rod", "inertia"),
        )
    if given.rod_mass is None:
        return
    at_knuckle = given.knuckle_mass
    if at_knuckle is None:
        at_knuckle = 0.0 if rod is None else rod.mass * (1.0 - rod_share(train))
    moving = cylinder.reciprocating_mass
    moving = (reciprocating_mass(train) or 0.0) if moving is None else moving
    if not at_knuckle <= given.rod_mass <= (at_knuckle + moving) * _MARGIN:
        yield Problem(
            path=(*path, "rod_mass"),
            message="the mass of a slave rod is that at its knuckle pin and a part of what moves "
            "with the piston",
            found=f"{given.rod_mass:.6g} kg",
            allowed=f"{at_knuckle:.6g} kg to {at_knuckle + moving:.6g} kg",
            also=(*path, "knuckle_mass") if given.knuckle_mass is not None else None,
        )


def _stages(case: Case) -> Iterator[Problem]:
    """Tables that know rods on crank pins alone."""
    machine, train, response = case.machine, case.machine.crank_train, case.response
    excitation = case.excitation
    forces = any(cylinder.gas_force is not None for cylinder in train.cylinders)
    truncated = case.kinematics is not None and case.kinematics.series == "truncated"
    of_response = () if response is None else tuple(response.model_fields_set)
    asked: list[tuple[KeyPath, bool, str]] = [
        (TRAIN, has_gas(case) or forces, "the gas of its cylinders"),
        ((*TRAIN, "firing_order"), bool(train.firing_order), "a firing order"),
        (("machine", "shaft_line"), machine.shaft_line is not None, "a shaft line"),
        (("machine", "rotor"), machine.rotor is not None, "a rotor whose speed varies"),
        (("machine", "shell"), machine.shell is not None, "a shell that rolls"),
        (("machine", "joints"), machine.joints is not None, "joints with play"),
        (("bearing_loads",), case.bearing_loads is not None, "loads on bearings"),
        (("kinematics", "series"), truncated, "a truncated series"),
        (("excitation", "balance"), excitation is not None and excitation.balance is not None,
         "the balance table"),
        (("excitation", "working"), excitation is not None and excitation.working is not None,
         "cylinders that do not work"),
        *((("response", key), key in of_response and bool(getattr(response, key)),
           f"[response.{key}]") for key in ("operations", "switching")),
    ]  # fmt: skip
    first = next(i for i, one in enumerate(train.cylinders) if one.articulated is not None)
    for path, there, what in asked:
        if there:
            yield Problem(
                path=path,
                message=f"{what}: not with articulated rods, whose pistons move differently",
                allowed="inertia forces at constant speed, without it",
                also=(*TRAIN, "cylinders", first, "articulated"),
            )
