"""Slave rods of a case as arrays, and what cannot have them."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import TRAIN
from vibecalc.parts import tables as parts
from vibecalc.parts.crank_train import rod_share
from vibecalc.parts.firing import has_gas
from vibecalc.schema import Case

Array = NDArray[np.float64]


class Slaves(NamedTuple):
    """k slave rods, (k,) each: their cylinders and masters by place, lengths in m, angles in rad.

    `knuckle_mass` in kg is what moves with the knuckle pin.
    """

    cylinder: NDArray[np.int64]
    master: NDArray[np.int64]
    knuckle_radius: Array
    knuckle_angle: Array
    rod_length: Array
    knuckle_mass: Array


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
        rows.append((place, master, given.knuckle_radius, angle, given.rod_length, mass))
    columns = list(zip(*rows, strict=True))
    return Slaves(
        np.array(columns[0], dtype=np.int64),
        np.array(columns[1], dtype=np.int64),
        *(np.array(column, dtype=float) for column in columns[2:]),
    )


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
            message="a slave rod hangs on a master rod, which itself sits on the crank pin",
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
