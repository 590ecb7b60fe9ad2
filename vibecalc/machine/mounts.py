"""Mounts as stiffness and damping matrices in the axes of the body."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vibecalc.case import parts

Array = NDArray[np.float64]
Scalars = float | tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Mounts:
    """n mounts: force on the body is -(k (1 + i loss factor) + i w c) times its displacement there.

    `position` (n, 3) in m from the body's reference point; `stiffness` and `structural`
    (loss factor times stiffness) (n, 3, 3) in N/m, `damping` (n, 3, 3) in N s/m, all in the axes
    of the body.
    """

    names: tuple[str, ...]
    position: Array
    stiffness: Array
    damping: Array
    structural: Array


@dataclass(frozen=True, kw_only=True)
class MountEntry:
    """One mount as the case has it, with what it does not say taken from `each`."""

    name: str
    position: tuple[float, float, float]
    orientation: tuple[float, float, float]
    stiffness: Scalars | None
    damping: Scalars | None
    loss_factor: float | None


def mount_entries(mounts: parts.Mounts) -> tuple[MountEntry, ...]:
    """All mounts of a case; those given by position only are named 1, 2, 3 ..."""
    each = mounts.each or parts.MountProperties()

    def own(mount: parts.MountProperties | None, key: str) -> object:
        value = None if mount is None else getattr(mount, key)
        return getattr(each, key) if value is None else value

    def entry(
        name: str,
        position: tuple[float, float, float],
        orientation: tuple[float, float, float],
        mount: parts.Mount | None,
    ) -> MountEntry:
        return MountEntry(
            name=name,
            position=position,
            orientation=orientation,
            stiffness=own(mount, "stiffness"),  # type: ignore[arg-type]
            damping=own(mount, "damping"),  # type: ignore[arg-type]
            loss_factor=own(mount, "loss_factor"),  # type: ignore[arg-type]
        )

    if mounts.individual is not None:
        return tuple(entry(m.name, m.position, m.orientation, m) for m in mounts.individual)
    level = (0.0, 0.0, 0.0)
    places = mounts.positions or ()
    return tuple(entry(str(n), place, level, None) for n, place in enumerate(places, start=1))


def rotation(about_x: float, about_y: float, about_z: float) -> Array:
    """Rotation (3, 3) about the body's x, then y, then z; its columns are the mount's own axes."""
    (cx, cy, cz), (sx, sy, sz) = (f([about_x, about_y, about_z]) for f in (np.cos, np.sin))
    first = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    second = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    third = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    turn: Array = third @ second @ first
    return turn


def in_body_axes(values: Scalars | None, orientation: tuple[float, float, float]) -> Array:
    """Matrix (3, 3) in body axes of one value for all directions, or of three principal ones."""
    if values is None:
        return np.zeros((3, 3))
    if isinstance(values, float | int):
        return float(values) * np.eye(3)
    principal = np.array(values, dtype=float)
    if not any(orientation):
        return np.diag(principal)
    turn = rotation(*orientation)
    matrix = (turn * principal) @ turn.T
    return np.asarray(0.5 * (matrix + matrix.T))


def build_mounts(mounts: parts.Mounts) -> Mounts:
    """Matrices of validated mounts; a property that is nowhere given is zero."""
    entries = mount_entries(mounts)
    stiffness = np.array([in_body_axes(e.stiffness, e.orientation) for e in entries])
    damping = np.array([in_body_axes(e.damping, e.orientation) for e in entries])
    loss = np.array([e.loss_factor or 0.0 for e in entries])
    return Mounts(
        names=tuple(e.name for e in entries),
        position=np.array([e.position for e in entries], dtype=float),
        stiffness=stiffness,
        damping=damping,
        structural=loss[:, None, None] * stiffness,
    )
