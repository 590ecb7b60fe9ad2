"""The gaps of a cylinder with play in its joints, and the masses on their sides."""

from collections.abc import Iterator
from typing import NamedTuple

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts import tables as parts
from vibecalc.parts.crank_train import build_crank_train, rod_share
from vibecalc.parts.tables import Play

JOINTS: KeyPath = ("machine", "joints")


class Gap(NamedTuple):
    """A joint with play: its place in the case and the inverse of the mass that it moves, 1/kg."""

    path: KeyPath
    play: Play
    mobility: float


def piston_and_pin(train: parts.CrankTrain, whole: float) -> float:
    """Mass (kg) beyond the wrist pin's play, of the `whole` mass that moves with the piston."""
    return whole - rod_beside_piston(train)


def rod_beside_piston(train: parts.CrankTrain) -> float:
    """The rod's reciprocating point mass, kg; zero for a train without a rod."""
    return 0.0 if train.rod is None else float(train.rod.mass * rod_share(train))


def plays(case: Case) -> Iterator[tuple[KeyPath, Play]]:
    """Every joint with play, with its place in the case."""
    joints = case.machine.joints
    for name in ("wrist_pin", "crank_pin", "bore"):
        play = getattr(joints, name)
        if play is not None:
            yield (*JOINTS, name), play


def gaps(case: Case, problems: list[Problem]) -> list[Gap]:
    """The gaps with the masses they move; where a mass is missing, a problem instead."""
    joints, train = case.machine.joints, case.machine.crank_train
    place = _cylinder(case)
    name = train.cylinders[place].name
    moving = float(build_crank_train(train).reciprocating_mass[place])
    play_at_crank = joints is not None and joints.crank_pin is not None
    rod = rod_beside_piston(train)
    if play_at_crank and rod <= 0.0:
        problems.append(
            Problem(
                path=(*JOINTS, "crank_pin"),
                message="play in the crank pin needs a rod: it is then a mass between two gaps",
                found=f"{rod:.6g} kg of rod that moves with the piston",
                allowed="rod = { mass = ..., crank_pin_to_mass_centre = ... } in the crank train",
            )
        )
        return []
    piston = piston_and_pin(train, moving)
    if piston <= 0.0:
        problems.append(
            Problem(
                path=(*JOINTS, "wrist_pin"),
                message=f"nothing has a mass on the piston's side of the wrist pin of {name!r}",
                found=f"{moving:.6g} kg that move with the piston, {rod:.6g} kg of them rod",
                allowed="a mass above zero of piston and pin",
                also=("machine", "crank_train"),
            )
        )
        return []
    across = {
        "wrist_pin": 1.0 / piston + (1.0 / rod if play_at_crank else 0.0),
        "crank_pin": 1.0 / rod if rod else 0.0,
        "bore": 1.0 / piston,
    }
    return [Gap(path, play, across[str(path[-1])]) for path, play in plays(case)]


def _cylinder(case: Case) -> int:
    """Return which cylinder has the joints with play: the named one, or the first that works."""
    names = [cylinder.name for cylinder in case.machine.crank_train.cylinders]
    joints = case.machine.joints
    if joints is not None and joints.cylinder in names:
        return names.index(joints.cylinder)
    working = None if case.excitation is None else case.excitation.working
    works = [place for place, name in enumerate(names) if working is None or name in working]
    return works[0] if works else 0
