"""Do body and mounts suit the isolation model that is asked for?"""

import numpy as np

from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.frame import DIRECTIONS
from vibecalc.machine.free_motions import free_motions
from vibecalc.machine.mounts import build_mounts
from vibecalc.machine.pitch import PitchParts, build_pitch

MOUNTS: KeyPath = ("machine", "mounts")


def isolation_problems(case: Case) -> list[Problem]:
    """Problems of the chosen model; nothing is judged that it does not ask for."""
    isolation, machine = case.isolation, case.machine
    if isolation is None or machine.body is None or machine.mounts is None:
        return []
    if machine.body.mass is None or machine.mounts.stiffness_matrix is not None:
        return []  # matrices have no places; the checks of form say so
    if isolation.model == "rigid_body":
        return _held(free_motions(build_mounts(machine.mounts)))
    if isolation.model == "planar":
        from vibecalc.machine.planar_checks import planar_problems  # loads what adds mounts up

        return planar_problems(case)
    train = machine.crank_train
    problems = []
    if isolation.up != train.stroke:
        problems.append(
            Problem(
                path=("isolation", "up"),
                message="the pitch model stands upright: up must be the direction of the stroke",
                found=f"up = '{isolation.up}', and stroke = '{train.stroke}'",
                allowed=f"up = '{train.stroke}', or model = 'rigid_body'",
                also=("machine", "crank_train", "stroke"),
            )
        )
    pitch = build_pitch(machine.body, machine.mounts, train)
    return [*problems, *_pitch_held(pitch), *_lever(case, pitch)]


def _held(motions: list[str]) -> list[Problem]:
    if not motions:
        return []
    return [
        Problem(
            path=MOUNTS,
            message="the mounts leave the body free",
            found="nothing resists " + ", ".join(motions),
            allowed="a stiffness against each of the six motions",
            hint="give stiffness in three directions, spread the mounts, or use model = 'pitch', "
            "or 'planar' for two mounts",
        )
    ]


def _pitch_name(pitch: PitchParts) -> str:
    return DIRECTIONS[int(np.argmax(np.abs(pitch.across)))]


def _pitch_held(pitch: PitchParts) -> list[Problem]:
    if float(pitch.stiffness @ pitch.position**2) > 0.0:
        return []
    return [
        Problem(
            path=MOUNTS,
            message="the mounts leave the body free to pitch",
            found=f"nothing resists turning about {_pitch_name(pitch)}",
            allowed="a stiffness along the stroke, away from the mass centre along the crankshaft",
        )
    ]


def _lever(case: Case, pitch: PitchParts) -> list[Problem]:
    if case.isolation is None or case.isolation.lever is not None or pitch.lever is not None:
        return []
    reach = np.abs(pitch.position)
    return [
        Problem(
            path=("isolation", "lever"),
            message="the mounts stand at different distances from the mass centre, so the lever "
            "of lever_force has to be given",
            found=f"distances along the crankshaft from {reach.min():.6g} to {reach.max():.6g} m",
            allowed=f"lever = {reach.max():.6g}, for example",
            also=MOUNTS,
        )
    ]
