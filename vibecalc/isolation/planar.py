"""Does a machine stay in the plane of its crank, so that three motions are all of its motion?"""

from collections.abc import Iterator

import numpy as np

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import TRAIN
from vibecalc.parts.body import DIRECTIONS, build_body, dofs_of_model
from vibecalc.parts.matrices import mounted
from vibecalc.parts.mount_state import never_held
from vibecalc.parts.mounts import build_mounts
from vibecalc.schema import Case, Machine

#: a coupling below this share of what it couples is the round-off of none
TOLERANCE = 1e-9

MOUNTS: KeyPath = ("machine", "mounts")
BODY: KeyPath = ("machine", "body")
_OTHERWISE = "model = 'rigid_body', which has all six motions"


def planar_problems(case: Case) -> list[Problem]:
    """Problems of `[isolation] model = "planar"` of a machine with body and mounts."""
    machine, axis = case.machine, case.machine.crank_train.axis
    assert case.isolation is not None
    if case.isolation.up == axis:
        return [
            Problem(
                path=("isolation", "up"),
                message="in the planar model the crankshaft is horizontal",
                found=f"up = '{axis}', which is the direction of the crankshaft",
                allowed=_OTHERWISE,
                also=(*TRAIN, "axis"),
            )
        ]
    problems = [*_places(machine), *_coupled(machine)]
    motions = never_held(case, dofs_of_model("planar", axis))
    if motions:
        problems.append(
            Problem(
                path=MOUNTS,
                message="the mounts do not restrain the body in the plane of the crank",
                found="nothing resists " + ", ".join(motions),
                allowed="a stiffness against each of the three motions",
                hint="one mount resists no turning about itself: two, away from each other across "
                "the crankshaft, do",
            )
        )
    return problems


def _places(machine: Machine) -> Iterator[Problem]:
    """Forces act in the plane of the reference point, or they would tilt the body out of it."""
    train = machine.crank_train
    along = DIRECTIONS.index(train.axis)
    shift, near = train.origin[along], TOLERANCE * train.crank_radius
    parts = {
        "cylinders": [one.position for one in train.cylinders],
        "counterweights": [one.position for one in train.counterweights],
        "balance_shafts": [one.position[along] for one in train.balance_shafts],
    }
    for name, places in parts.items():
        for number, place in enumerate(places):
            if abs(place + shift) > near:
                yield Problem(
                    path=(*TRAIN, name, number),
                    message="the planar model has its forces in the plane of the body's reference "
                    "point, and one of them tilts the body out of it",
                    found=f"{place + shift:.6g} m along the crankshaft",
                    allowed=f"0 m, or {_OTHERWISE}",
                    also=("isolation", "model"),
                )
                return


def _coupled(machine: Machine) -> Iterator[Problem]:
    """Neither masses nor mounts couple the motions of the plane with the three others."""
    assert machine.body is not None and machine.mounts is not None
    kept = dofs_of_model("planar", machine.crank_train.axis)
    left = np.delete(np.arange(6), kept)
    found = mounted(build_body(machine.body), build_mounts(machine.mounts))
    words = [f"moving along {one}" for one in DIRECTIONS]
    words += [f"turning about {one}" for one in DIRECTIONS]
    for path, what, matrix in (
        (BODY, "mass", found.mass),
        (MOUNTS, "stiffness", found.stiffness),
        (MOUNTS, "damping", found.damping),
        (MOUNTS, "loss factor", found.structural),
    ):
        size = np.sqrt(np.abs(np.outer(matrix.diagonal(), matrix.diagonal())))
        coupled = (np.abs(matrix) > TOLERANCE * size)[np.ix_(kept, left)]
        pairs = [f"{words[kept[i]]} with {words[left[j]]}" for i, j in np.argwhere(coupled)]
        if pairs:
            yield Problem(
                path=path,
                message=f"the {what} couples the motions of the planar model with others",
                found=", ".join(pairs[:4]),
                allowed="mass centre and mounts even about the plane of the crank, or "
                + _OTHERWISE,
                also=("isolation", "model"),
            )
