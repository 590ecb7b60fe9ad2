"""Whether body and mounts suit the isolation model asked for."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import KeyPath, Problem
from vibecalc.numerics.rounding import BoolArray
from vibecalc.parts import body_tables
from vibecalc.parts import tables as parts
from vibecalc.parts.body import DIRECTIONS, build_body, build_frame
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import Mounts, build_mounts
from vibecalc.schema import Case

Array = NDArray[np.float64]


#: of the distance of mounts from the mass centre, up to which it is one lever
_ONE_LEVER = 1e-9
#: of the distance of mounts from the mass centre, below which they stand at one place
_ONE_PLACE = 1e-12


class Arms(NamedTuple):
    """What holds a body in pitch: `position` (..., n) of mounts in m along the crankshaft from the
    mass centre, `stiffness` (..., n) along the stroke. It turns about the axis called `turned`.
    """

    position: Array
    stiffness: Array
    turned: str

    def free(self) -> BoolArray:
        """Whether (...) nothing resists turning."""
        return np.asarray(~((self.stiffness * np.square(self.position)).sum(axis=-1) > 0.0))

    def tips(self) -> BoolArray:
        """Whether (...) all mounts that count stand at one place."""
        counts = self.stiffness > 0.0
        first = np.min(self.position, axis=-1, where=counts, initial=np.inf)
        last = np.max(self.position, axis=-1, where=counts, initial=-np.inf)
        farthest = np.max(np.abs(self.position), axis=-1, where=counts, initial=0.0)
        return np.asarray(~(last - first > _ONE_PLACE * farthest))

    def has_lever(self) -> BoolArray:
        """Whether (...) all mounts have one distance from the mass centre."""
        reach = np.abs(self.position)
        longest = reach.max(axis=-1)
        return np.asarray(longest - reach.min(axis=-1) <= _ONE_LEVER * longest)


def arms_of(body: body_tables.Body, mounts: body_tables.Mounts, train: parts.CrankTrain) -> Arms:
    """Those of a validated case."""
    frame, built = build_frame(train.axis, train.stroke), build_mounts(mounts)
    along, up, turned = (
        int(np.argmax(np.abs(v))) for v in (frame.axis, frame.stroke, frame.across)
    )
    position = built.position[..., along] - build_body(body).centre[..., along, None]
    position, stiffness = np.broadcast_arrays(position, built.stiffness[..., up, up])
    return Arms(position, stiffness, DIRECTIONS[turned])


# ----------------------------------------------------------------------------
# Do body and mounts suit the isolation model that is asked for?
# ----------------------------------------------------------------------------

MOUNTS: KeyPath = ("machine", "mounts")


def isolation_problems(case: Case) -> list[Problem]:
    """Problems of the chosen model; nothing is judged that it does not ask for."""
    isolation, machine = case.isolation, case.machine
    if isolation is None or machine.body is None or machine.mounts is None:
        return []
    if machine.body.mass_matrix is not None or machine.mounts.stiffness_matrix is not None:
        return []  # matrices have no places; the checks of form say so
    if isolation.model == "rigid_body":
        return _held(never_held(case))
    if isolation.model == "planar":
        from vibecalc.isolation.planar import planar_problems  # loads what adds mounts up

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
    pitch = arms_of(machine.body, machine.mounts, train)
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


def _pitch_held(pitch: Arms) -> list[Problem]:
    if pitch.free():
        return [
            Problem(
                path=MOUNTS,
                message="the mounts leave the body free to pitch",
                found=f"nothing resists turning about {pitch.turned}",
                allowed="a stiffness along the stroke, away from the mass centre along the "
                "crankshaft",
            )
        ]
    if not pitch.tips():
        return []
    return [
        Problem(
            path=MOUNTS,
            message="all mounts stand at one position along the crankshaft and the mass "
            "centre does not: the machine would tip",
            found=f"{np.abs(pitch.position).max(where=pitch.stiffness > 0.0, initial=0.0):.6g} m "
            "from the mass centre",
            allowed="mounts at two positions along the crankshaft or more",
        )
    ]


def _lever(case: Case, pitch: Arms) -> list[Problem]:
    reach = np.abs(pitch.position)
    if case.isolation is None or case.isolation.lever is not None or pitch.has_lever():
        return []
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


def isolation_suspects(case: Case) -> BoolArray | None:
    """Points (...) of a case with arrays that `isolation_problems` may refuse; None in a plane."""
    isolation, body, mounts = case.isolation, case.machine.body, case.machine.mounts
    if isolation is None or body is None or mounts is None:
        return np.zeros((), dtype=bool)
    if isolation.model == "planar":
        return None
    if isolation.model != "pitch":
        return _nearly_free(build_mounts(mounts))
    train = case.machine.crank_train
    pitch = arms_of(body, mounts, train)
    refused = pitch.free() | pitch.tips() | np.array(isolation.up != train.stroke)
    return np.asarray(refused if isolation.lever is not None else refused | ~pitch.has_lever())


#: share of the stiffest direction that a body which is held surely has in each
_HELD = 1e-9


def _nearly_free(mounts: Mounts) -> BoolArray:
    """Points (...) at which mounts resist some of the six motions little, or not at all."""
    distance = np.linalg.norm(mounts.position, axis=-1).max(axis=-1)[..., None, None]
    motion = displacement_at(mounts.position / np.where(distance > 0.0, distance, 1.0))
    levels = np.linalg.eigvalsh((motion.mT @ mounts.stiffness @ motion).sum(axis=-3))
    return np.asarray(~(levels[..., 0] > _HELD * levels[..., -1]))
