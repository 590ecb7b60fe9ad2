"""Whether body and mounts suit the isolation model asked for."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts.body import DIRECTIONS, build_body, build_frame
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import Mounts, build_mounts
from vibecalc.schema import Case

#: of the distance of mounts from the mass centre, up to which it is one lever
_ONE_LEVER = 1e-9
#: of the distance of mounts from the mass centre, below which they stand at one place
_ONE_PLACE = 1e-12
#: share of the stiffest direction that a body which is held surely has in each
_HELD = 1e-9

MOUNTS: KeyPath = ("machine", "mounts")


def isolation_problems(case: Case) -> list[Problem]:
    """Problems of the chosen model; nothing is judged that it does not ask for."""
    isolation, machine = case.isolation, case.machine
    if isolation is None or machine.body is None or machine.mounts is None:
        return []
    if machine.body.mass_matrix is not None or machine.mounts.stiffness_matrix is not None:
        return []  # matrices have no places; the checks of form say so
    if isolation.model == "planar":
        from vibecalc.isolation.planar import planar_problems  # loads what adds mounts up

        return planar_problems(case)
    if isolation.model == "pitch":
        return [problem() for refused, problem in _pitch_rules(case) if refused]
    motions = never_held(case)
    if not motions:
        return []
    return [
        Problem(
            path=MOUNTS,
            message="the mounts do not restrain the body",
            found="nothing resists " + ", ".join(motions),
            allowed="a stiffness against each of the six motions",
            hint="give stiffness in three directions, spread the mounts, or use model = 'pitch', "
            "or 'planar' for two mounts",
        )
    ]


def isolation_suspects(case: Case) -> BoolArray | None:
    """Points (...) of a case with arrays that `isolation_problems` may refuse; None in a plane."""
    isolation, body, mounts = case.isolation, case.machine.body, case.machine.mounts
    if isolation is None or body is None or mounts is None:
        return np.zeros((), dtype=bool)
    if isolation.model == "planar":
        return None
    if isolation.model != "pitch":
        return _nearly_free(build_mounts(mounts))
    every = np.broadcast_arrays(*(refused for refused, _ in _pitch_rules(case)))
    return np.asarray(np.any(every, axis=0))


def _nearly_free(mounts: Mounts) -> BoolArray:
    """Points (...) at which mounts resist some of the six motions little, or not at all."""
    distance = np.linalg.norm(mounts.position, axis=-1).max(axis=-1)[..., None, None]
    motion = displacement_at(mounts.position / np.where(distance > 0.0, distance, 1.0))
    levels = np.linalg.eigvalsh((motion.mT @ mounts.stiffness @ motion).sum(axis=-3))
    return np.asarray(~(levels[..., 0] > _HELD * levels[..., -1]))


def _pitch_rules(case: Case) -> Iterator[tuple[Any, Callable[[], Problem]]]:
    """Whether (...) each rule of a body in pitch refuses a case, and the problem of one."""
    isolation, machine, train = case.isolation, case.machine, case.machine.crank_train
    assert isolation is not None and machine.body is not None and machine.mounts is not None
    yield (
        isolation.up != train.stroke_axis,
        lambda: Problem(
            path=("isolation", "up"),
            message="in the pitch model up must be the direction of the stroke",
            found=f"up = '{isolation.up}', and stroke_axis = '{train.stroke_axis}'",
            allowed=f"up = '{train.stroke_axis}', or model = 'rigid_body'",
            also=("machine", "crank_train", "stroke_axis"),
        ),
    )
    frame, built = build_frame(train.axis, train.stroke_axis), build_mounts(machine.mounts)
    along, up, turned = (
        int(np.argmax(np.abs(v))) for v in (frame.axis, frame.stroke, frame.across)
    )
    # of mounts (..., n) along the crankshaft from the mass centre, in m
    position = built.position[..., along] - build_body(machine.body).centre[..., along, None]
    stiffness, reach = built.stiffness[..., up, up], np.abs(position)
    free = ~((stiffness * np.square(position)).sum(axis=-1) > 0.0)
    yield (
        free,
        lambda: Problem(
            path=MOUNTS,
            message="the mounts do not restrain the body in pitch",
            found=f"nothing resists rotation about {DIRECTIONS[turned]}",
            allowed="a stiffness along the stroke, away from the mass centre along the crankshaft",
        ),
    )
    counts = np.broadcast_to(stiffness > 0.0, np.broadcast_shapes(stiffness.shape, reach.shape))
    position = np.broadcast_to(position, counts.shape)
    first = np.min(position, axis=-1, where=counts, initial=np.inf)
    last = np.max(position, axis=-1, where=counts, initial=-np.inf)
    farthest = np.max(np.abs(position), axis=-1, where=counts, initial=0.0)
    yield (
        ~free & ~(last - first > _ONE_PLACE * farthest),
        lambda: Problem(
            path=MOUNTS,
            message="all mounts are at one position along the crankshaft, away from the mass "
            "centre: the machine would tip",
            found=f"{farthest:.6g} m from the mass centre",
            allowed="mounts at two positions along the crankshaft or more",
        ),
    )
    if isolation.lever is None:
        yield (
            reach.max(axis=-1) - reach.min(axis=-1) > _ONE_LEVER * reach.max(axis=-1),
            lambda: Problem(
                path=("isolation", "lever"),
                message="the mounts are at different distances from the mass centre: the lever of "
                "couple_over_lever must be given",
                found=f"distances along the crankshaft from {reach.min():.6g} to "
                f"{reach.max():.6g} m",
                allowed=f"lever = {reach.max():.6g}, for example",
                also=MOUNTS,
            ),
        )
