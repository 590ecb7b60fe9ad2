"""Can this crank train turn, and does anything move in it?"""

import numpy as np

from vibecalc.case import parts
from vibecalc.case.kinds import has_crank_train
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.crank_train import build_crank_train, rod_share
from vibecalc.machine.frame import DIRECTIONS

TRAIN: KeyPath = ("machine", "crank_train")


def crank_train_problems(case: Case) -> list[Problem]:
    """Problems of directions, lengths, masses and of the series chosen for the motion."""
    if not has_crank_train(case.machine):
        return []
    train = case.machine.crank_train
    masses = _masses(case)
    return [*_directions(train), *_lengths(train), *_series(case), *masses]


def _directions(train: parts.CrankTrain) -> list[Problem]:
    if train.axis != train.stroke:
        return []
    others = " or ".join(repr(name) for name in DIRECTIONS if name != train.axis)
    return [
        Problem(
            path=(*TRAIN, "stroke"),
            message="the pistons cannot move along the crankshaft",
            found=f"stroke = '{train.stroke}', and axis = '{train.axis}'",
            allowed=f"{others} with this axis",
            also=(*TRAIN, "axis"),
        )
    ]


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


def _series(case: Case) -> list[Problem]:
    """What the truncated series has no terms for."""
    train = case.machine.crank_train
    if case.kinematics is None or case.kinematics.series != "truncated":
        return []
    problems = []
    if train.wrist_pin_offset != 0.0:
        problems.append(
            Problem(
                path=("kinematics", "series"),
                message="the truncated series has no term for a wrist-pin offset",
                found=f"series = 'truncated' with an offset of {train.wrist_pin_offset:.6g} m",
                allowed="series = 'exact', or no offset",
                also=(*TRAIN, "wrist_pin_offset"),
            )
        )
    if train.rod is not None and train.rod.inertia is not None:
        problems.append(
            Problem(
                path=("kinematics", "series"),
                message="the truncated series has no terms for the turning of the rod",
                found=f"series = 'truncated' with a rod inertia of {train.rod.inertia:.6g} kg*m^2",
                allowed="series = 'exact', or no inertia of the rod",
                also=(*TRAIN, "rod", "inertia"),
            )
        )
    return problems


def _masses(case: Case) -> list[Problem]:
    train = case.machine.crank_train
    problems = []
    rod = train.rod
    if rod is not None and rod_share(train) > 1.0:
        problems.append(
            Problem(
                path=(*TRAIN, "rod", "crank_pin_to_mass_centre"),
                message="the rod's mass centre lies beyond its wrist pin",
                found=f"{rod.crank_pin_to_mass_centre:.6g} m from the crank pin",
                allowed=f"at most the rod length, {train.rod_length:.6g} m",
                also=(*TRAIN, "rod_length"),
            )
        )
    if problems:
        return problems
    arrays = build_crank_train(train)
    moving = float(arrays.reciprocating_mass.sum() + arrays.rotating_mass.sum())
    unbalance = sum(weight.unbalance for weight in train.counterweights)
    unbalance += sum(shaft.unbalance for shaft in train.balance_shafts)
    if moving == 0.0 and unbalance == 0.0:
        problems.append(
            Problem(
                path=(*TRAIN, "reciprocating_mass"),
                message="nothing in the crank train has a mass, so nothing shakes the body",
                found="reciprocating and rotating masses of 0 kg",
                allowed="a mass above zero on at least one cylinder, throw, weight or shaft",
            )
        )
    body = case.machine.body
    whole = None if body is None else _whole_mass(body)
    if body is not None and whole is not None and moving >= whole:
        problems.append(
            Problem(
                path=("machine", "body", "mass" if body.mass_matrix is None else "mass_matrix"),
                message="the moving parts weigh more than the whole machine, which includes them",
                found=f"{whole:.6g} kg, with {moving:.6g} kg of pistons, rods and throws",
                allowed=f"> {moving:.6g} kg",
                hint="masses are in kg unless they carry a unit, as in '400 g'",
                also=TRAIN,
            )
        )
    return problems


def _whole_mass(body: parts.Body) -> float | None:
    """Mass in kg without the block; of a mass matrix the least on the diagonal of translation."""
    if body.mass_matrix is None:
        return body.mass
    from vibecalc.machine.system import block_matrix  # it loads all that solves the motion

    least = float(np.diagonal(block_matrix(body.mass_matrix))[:3].min())
    return least if least > 0.0 else None  # what is no mass at all is told of the matrix
