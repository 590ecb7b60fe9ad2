"""What the pitch model needs of a machine: one rotation about the axis across the crankshaft."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts
from vibecalc.machine.body import RigidBody, build_body
from vibecalc.machine.frame import build_frame
from vibecalc.machine.mounts import Mounts, build_mounts

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PitchParts:
    """Inertia in kg m^2 about `across` (3,) through `centre` (3,), and the mounts along the shaft.

    `position` (n,) in m along the crankshaft from the mass centre; `stiffness`, `structural` in
    N/m and `damping` in N s/m (n,) along the stroke. A rotation q about `across` moves a mount by
    -position * q along the stroke. `lever` is the one distance |position| that all mounts share, or
    None if they differ.
    """

    names: tuple[str, ...]
    inertia: float
    centre: Array
    across: Array
    position: Array
    stiffness: Array
    damping: Array
    structural: Array
    lever: float | None


def common_lever(position: Array) -> float | None:
    """The distance |position| (n,) that all mounts share to a billionth, or None."""
    reach = np.abs(position)
    longest = float(reach.max())
    if longest == 0.0 or float(longest - reach.min()) > 1e-9 * longest:
        return None
    ascending = np.sort(reach)  # np.median would import the masked arrays of numpy
    return 0.5 * float(ascending[(len(reach) - 1) // 2] + ascending[len(reach) // 2])


def pitch_parts(body: RigidBody, mounts: Mounts, axis: str, stroke: str) -> PitchParts:
    """Pitch model of a body and its mounts, by projection on the crankshaft and the stroke."""
    frame = build_frame(axis, stroke)
    position = (mounts.position - body.centre) @ frame.axis

    def along_stroke(matrices: Array) -> Array:
        return np.asarray((matrices @ frame.stroke) @ frame.stroke)

    return PitchParts(
        names=mounts.names,
        inertia=float(frame.across @ body.inertia @ frame.across),
        centre=body.centre,
        across=frame.across,
        position=position,
        stiffness=along_stroke(mounts.stiffness),
        damping=along_stroke(mounts.damping),
        structural=along_stroke(mounts.structural),
        lever=common_lever(position),
    )


def build_pitch(body: parts.Body, mounts: parts.Mounts, train: parts.CrankTrain) -> PitchParts:
    """Pitch model of a validated case."""
    return pitch_parts(build_body(body), build_mounts(mounts), train.axis, train.stroke)
