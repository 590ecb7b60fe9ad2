"""Mounts as stiffness and damping matrices, and the motions of a body that no mount resists."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.numerics.leading import side_by_side
from vibecalc.parts import body_tables as parts
from vibecalc.parts.body import DIRECTIONS, cross_matrix
from vibecalc.parts.mount_needs import mount_properties

if TYPE_CHECKING:
    from vibecalc.parts.equilibrium import Rest
    from vibecalc.parts.mount_curves import Law, Spectrum

# ----------------------------------------------------------------------------
# Mounts as stiffness and damping matrices in the axes of the body.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]
Scalars = float | tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Mounts:
    """n mounts: force on the body is -(k (1 + i loss factor) + i w c) times its displacement there.

    `position` (n, 3) in m from the body's reference point; `stiffness` and `structural`
    (loss factor times stiffness) (n, 3, 3) in N/m, `damping` (n, 3, 3) in N s/m, all in the axes
    of the body. Where numbers of the case are arrays (points,), these have a leading axis.

    Of mounts whose properties depend on what they carry or on the frequency (`mount_state.py`):
    `static` (n, 3, 3) is the stiffness against loads that stay, `rest` where the body stands,
    `axis` (n, 3) and `laws` the direction and law of the load of each, `relative_error` (n,) what
    the load leaves uncertain of the stiffness; over the `spectrum` that changes, and `stiffness`
    is then of no one frequency: `at` gives it.
    """

    names: tuple[str, ...]
    position: Array
    stiffness: Array
    damping: Array
    structural: Array
    static: Array | None = None
    rest: "Rest | None" = None
    axis: Array | None = None
    laws: "tuple[Law, ...]" = ()
    relative_error: Array | None = None
    spectrum: "Spectrum | None" = None

    def at(self, rate: Any) -> "Mounts":
        """With stiffness and structural (..., n, 3, 3) of vibration at rates (...), rad/s."""
        if self.spectrum is None:
            return self
        factor = self.spectrum(rate)[..., None, None]
        return replace(
            self,
            stiffness=factor.real * self.stiffness,
            structural=factor.imag * self.stiffness,
            spectrum=None,
        )


def mount_entries(mounts: parts.Mounts) -> tuple[parts.Mount, ...]:
    """All mounts of a case, with what they do not say taken from `each`.

    Those given by position only are named 1, 2, 3 ...; of what stands in rows the nominal value is
    that of the first.
    """
    each = mounts.each or parts.MountProperties()
    given = mounts.individual or tuple(
        parts.Mount.model_construct(name=str(n), position=place)
        for n, place in enumerate(mounts.positions or (), start=1)
    )

    def filled(mount: parts.Mount) -> parts.Mount:
        found: dict[str, Any] = {}
        for key in parts.MountProperties.model_fields:
            own = getattr(mount, key)
            found[key] = getattr(each, key) if own is None else own
        for rows in (found["over_frequency"], found["over_load"]):
            for key in ("stiffness", "loss_factor"):
                if (column := getattr(rows, key, None)) is not None:
                    found[key] = column[0]
        return mount.model_copy(update=found)

    return tuple(filled(mount) for mount in given)


def rotation(about_x: float, about_y: float, about_z: float) -> Array:
    """Rotation (3, 3) about the body's x, then y, then z; its columns are the mount's own axes."""
    (cx, cy, cz), (sx, sy, sz) = (f([about_x, about_y, about_z]) for f in (np.cos, np.sin))
    first = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    second = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    third = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    turn: Array = third @ second @ first
    return turn


def in_body_axes(values: Scalars | None, orientation: tuple[float, float, float]) -> Array:
    """Matrix (..., 3, 3) in body axes of one value for all directions, or of three principal ones.

    The values are numbers or arrays (...).
    """
    if values is None:
        return np.zeros((3, 3))
    if not isinstance(values, tuple):
        return np.asarray(np.asarray(values, dtype=float)[..., None, None] * np.eye(3))
    principal = side_by_side(values)[..., None, :]
    if not any(orientation):
        return np.asarray(principal * np.eye(3))
    turn = rotation(*orientation)
    matrix = (turn * principal) @ turn.T
    return np.asarray(0.5 * (matrix + np.swapaxes(matrix, -1, -2)))


def build_mounts(mounts: parts.Mounts) -> Mounts:
    """Matrices of validated mounts; a property that is nowhere given is zero."""
    entries = mount_entries(mounts)
    stiffness, damping = (
        side_by_side([in_body_axes(getattr(e, name), e.orientation) for e in entries], own=2)
        for name in ("stiffness", "damping")
    )
    loss = side_by_side([0.0 if e.loss_factor is None else e.loss_factor for e in entries])
    position = side_by_side([side_by_side(e.position) for e in entries], own=1)
    if mounts.datum is not None:
        position = position + side_by_side(mounts.datum)[..., None, :]
    return Mounts(
        names=tuple(e.name for e in entries),
        position=position,
        stiffness=stiffness,
        damping=damping,
        structural=loss[..., None, None] * stiffness,
    )


# ----------------------------------------------------------------------------
# Motions of a body that no mount resists, in words.
# ----------------------------------------------------------------------------

#: A stiffness below this share of the largest of its mount is the round-off of a turned zero.
STIFFNESS_TOLERANCE = 1e-13
#: Singular values of the mounts' deformations, which go with the root of a stiffness.
RANK_TOLERANCE = 1e-11


def free_motions(mounts: Mounts, dofs: Sequence[int] | NDArray[np.intp] = range(6)) -> list[str]:
    """Motions in which no spring is deformed, as `moving along z` or `turning about x through ...`.

    Of `dofs`, indices into x y z rx ry rz; all six if not said.

    The rows root(k_i) (e_i . displacement) of all principal directions e_i of all mounts are
    stacked; their null space is what is free. Rotations are measured at the mounts' distance.
    """
    distance = float(np.linalg.norm(mounts.position, axis=1).max()) or 1.0
    rows = []
    for place, stiffness in zip(mounts.position, mounts.stiffness, strict=True):
        values, directions = np.linalg.eigh(stiffness)
        values = np.where(values > STIFFNESS_TOLERANCE * max(values[-1], 0.0), values, 0.0)
        motion = np.hstack([np.eye(3), -cross_matrix(place) / distance])[:, dofs]
        rows.append((np.sqrt(values) * directions).T @ motion)
    _, sizes, vectors = np.linalg.svd(np.vstack([*rows, np.zeros((len(dofs), len(dofs)))]))
    null_space = vectors[sizes <= RANK_TOLERANCE * max(sizes[0], np.finfo(float).tiny)]
    free = np.zeros((len(null_space), 6))
    free[:, dofs] = null_space
    # Rotations first, so that elimination leaves the pure translations in the last rows.
    reduced = _row_echelon(np.hstack([free[:, 3:], free[:, :3]]))
    return [_words(row[:3] / distance, row[3:], distance) for row in reduced]


def _row_echelon(matrix: Array) -> Array:
    """Reduced row echelon form, the largest pivot of each column first."""
    rows = matrix.copy()
    done = 0
    for column in range(rows.shape[1]):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) < 1e-9:
            continue
        rows[[done, pivot]] = rows[[pivot, done]]
        rows[done] /= rows[done, column]
        others = np.arange(len(rows)) != done
        rows[others] -= np.outer(rows[others, column], rows[done])
        done += 1
    rows[np.abs(rows) < 1e-9] = 0.0
    return rows


def _direction(vector: Array) -> str:
    unit: Array = vector / np.linalg.norm(vector)
    for name, share in zip(DIRECTIONS, np.abs(unit), strict=True):
        if share > 1.0 - 1e-9:
            return name
    return _triple(unit)


def _triple(vector: Array) -> str:
    """Three numbers in brackets, what is zero but for round-off as 0."""
    small = 1e-9 * float(np.abs(vector).max())
    return "(" + ", ".join(f"{0.0 if abs(x) <= small else x:.3g}" for x in vector) + ")"


def _words(turn: Array, shift: Array, distance: float) -> str:
    if not turn.any():
        return f"moving along {_direction(shift)}"
    # The points of the axis of a turn w with a shift v satisfy w x p = v - (its part along w).
    point = np.cross(turn, shift) / (turn @ turn)
    words = f"turning about {_direction(turn)}"
    if np.linalg.norm(point) > 1e-9 * distance:
        words += f" through {_triple(point)} m"
    return words


def has_loss_factor(mounts: parts.Mounts) -> bool:
    """Tell whether any stiffness is complex."""
    individual = any(properties.loss_factor for properties in mount_properties(mounts))
    return individual or bool(mounts.loss_factor)
