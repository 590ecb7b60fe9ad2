"""The pitching body on its mounts at many points: as `machine.pitch`, with a leading axis."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.parts import tables as parts
from vibecalc.parts.mounts import rotation
from vibecalc.pipeline.arrays.columns import Columns, together
from vibecalc.pipeline.arrays.train import Train

BODY = ("machine", "body")
MOUNTS = ("machine", "mounts")
_PROPERTIES = ("stiffness", "damping")


class Mounted(NamedTuple):
    """Arrays (points or 1,) and (points or 1, mounts) of what `PitchParts` holds.

    `mass` in kg with the block; `spread` (points or 1,) is the relative difference between the
    distances of the mounts, which share the distance `lever` if it is zero to rounding.
    """

    names: tuple[str, ...]
    mass: FloatArray
    inertia: FloatArray
    centre: FloatArray
    across: FloatArray
    position: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    structural: FloatArray
    lever: FloatArray
    spread: FloatArray


def build_mounted(columns: Columns, train: Train) -> Mounted:
    """Body and mounts at all points."""
    frame = train.frame
    along, up, turned = (
        int(np.argmax(np.abs(v))) for v in (frame.axis, frame.stroke, frame.across)
    )
    mass, centre, inertia = _body(columns, turned)
    mounts = columns.case.machine.mounts
    if mounts is None:
        raise ValueError("the machine has no mounts")
    count = len(mounts.individual or mounts.positions or ())
    place = "individual" if mounts.individual else "positions"
    paths = [
        (*MOUNTS, place, i, "position") if mounts.individual else (*MOUNTS, place, i)
        for i in range(count)
    ]
    position = together([columns.number(*path, along) for path in paths]) - centre[:, along, None]
    own = list(mounts.individual or ())
    stiffness, damping = (
        together([_along(columns, own, i, name, up) for i in range(count)]) for name in _PROPERTIES
    )
    loss = together([_property(columns, own, i, "loss_factor") for i in range(count)])
    reach = np.sort(np.abs(position), axis=1)
    longest = reach[:, -1]
    lever = columns.optional("isolation", "lever")
    if lever is None:
        lever = 0.5 * (reach[:, (count - 1) // 2] + reach[:, count // 2])
    return Mounted(
        names=tuple(mount.name for mount in own) or tuple(str(n + 1) for n in range(count)),
        mass=mass,
        inertia=inertia,
        centre=centre,
        across=frame.across,
        position=position,
        stiffness=stiffness,
        damping=damping,
        structural=loss * stiffness,
        lever=lever,
        spread=(longest - reach[:, 0]) / np.where(longest > 0.0, longest, 1.0),
    )


def own_moments(columns: Columns) -> FloatArray:
    """Moments Ixx, Iyy, Izz (points or 1, 3) of the machine without its block."""
    body = columns.case.machine.body
    if body is not None and body.inertia is not None:
        return columns.vector(*BODY, "inertia")
    return _box_moments(columns, BODY)


def _body(columns: Columns, turned: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, its centre (., 3), and moment of inertia about the axis `turned` through it."""
    bare, own = columns.number(*BODY, "mass"), own_moments(columns)[:, turned]
    body = columns.case.machine.body
    if body is None or body.inertia_block is None:
        return bare, np.zeros((1, 3)), own
    block = (*BODY, "inertia_block")
    added, place = columns.number(*block, "mass"), columns.vector(*block, "position")
    mass = bare + added
    away = np.delete(np.square(place), turned, axis=1).sum(1)
    inertia = own + (_box_moments(columns, block)[:, turned] + added * (bare / mass) * away)
    return mass, (added / mass)[:, None] * place, inertia


def _box_moments(columns: Columns, place: tuple[str, ...]) -> FloatArray:
    x, y, z = (columns.number(*place, "box", edge) for edge in ("length", "width", "height"))
    twelfth = columns.number(*place, "mass") / 12.0
    squares = (y * y + z * z, x * x + z * z, x * x + y * y)
    return together([twelfth * square for square in squares])


def _property(
    columns: Columns, own: list[parts.Mount], place: int, name: str, *entry: int
) -> FloatArray:
    path = (*MOUNTS, "individual", place, name)
    if own and columns.written(*path) is not None:
        return columns.number(*path, *entry)
    return columns.number(*MOUNTS, "each", name, *entry)


def _along(columns: Columns, own: list[parts.Mount], place: int, name: str, up: int) -> FloatArray:
    """Stiffness or damping of a mount along one axis of the body."""
    given = columns.written(*MOUNTS, "individual", place, name) if own else None
    if given is None:
        given = columns.written(*MOUNTS, "each", name)
    if not isinstance(given, tuple):
        return _property(columns, own, place, name)
    orientation = own[place].orientation if own else (0.0, 0.0, 0.0)
    if not any(orientation):
        return _property(columns, own, place, name, up)
    share = np.square(rotation(*orientation)[up])
    principal = [_property(columns, own, place, name, entry) for entry in range(3)]
    along: FloatArray = together(principal) @ share
    return along
