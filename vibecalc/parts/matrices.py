"""Mass and stiffness matrices of a body on its mounts: put together, or given and checked."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.core.case.number_range import LARGEST, SMALLEST
from vibecalc.errors import KeyPath, Problem, listing
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.linear import Linear, added_up
from vibecalc.numerics.rounding import DATA_ROUNDINGS, EPSILON
from vibecalc.parts import body_tables as parts
from vibecalc.parts.body import COORDINATES, RigidBody, build_body, cross_matrix
from vibecalc.parts.mount_state import mounts_of
from vibecalc.parts.mounts import Mounts
from vibecalc.schema import Case
from vibecalc.units import convert

if TYPE_CHECKING:
    from vibecalc.parts.matrix_tables import BlockMatrix

# ----------------------------------------------------------------------------
# Mass, stiffness and damping of a rigid body on its mounts, put together.
# ----------------------------------------------------------------------------


def displacement_at(position: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 6) that take body coordinates to the displacement of points (..., 3).

    u = t + r x p for a translation t and a small rotation r, in metres.
    """
    point = np.asarray(position, dtype=float)
    along = np.broadcast_to(np.eye(3), (*point.shape, 3))
    return np.concatenate([along, -cross_matrix(point)], axis=-1)


def assemble(
    mass_matrix: np.ndarray,
    position: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Linear:
    """Add up the mounts of a body; all matrices get the same leading axes.

    Parameters
    ----------
    mass_matrix : (..., 6, 6) about the reference point, static moments included, positive definite.
    position : (..., mounts, 3) from the reference point, m.
    stiffness, damping, structural : (..., mounts, 3, 3) symmetric, along the body's axes, in N/m,
        N s/m and N/m (loss factor times stiffness).

    Source: C. M. Harris and A. G. Piersol, Shock and Vibration Handbook, 5th ed., chapter 3.
    """
    mass = rounded(np.asarray(mass_matrix, dtype=float), DATA_ROUNDINGS)
    return added_up(mass, displacement_at(position), stiffness, damping, structural)


# ----------------------------------------------------------------------------
# A body and its suspension as one linear system, from parts or from matrices.
# ----------------------------------------------------------------------------


def block_matrix(matrix: "BlockMatrix") -> np.ndarray:
    """A matrix (6, 6) of a case in SI: each block times the factor of its unit."""
    return np.asarray(np.array(matrix.values, dtype=float) * _factors(matrix))


def _factors(matrix: "BlockMatrix") -> np.ndarray:
    units = matrix.units or matrix.SI
    along, coupled, turning = map(lambda unit, si: convert(1.0, unit, si), units, matrix.SI)
    return np.kron([[along, coupled], [coupled, turning]], np.ones((3, 3)))


def _with_rounding(matrix: "BlockMatrix") -> Bounded:
    """The matrix in SI, its halves made equal; an entry that is given in SI is exact."""
    value = block_matrix(matrix)
    rounding = 2.0 * EPSILON * np.abs(value) * (_factors(matrix) != 1.0)
    return Bounded(0.5 * (value + value.T), rounding + 0.5 * np.abs(value - value.T))


def build_system(case: Case) -> Linear:
    """Mass, stiffness, damping and structural damping (6, 6) about the body's reference point.

    Modal damping is not in it: it needs the modes. A machine without body or mounts has no
    such system.
    """
    body, mounts = case.machine.body, case.machine.mounts
    if body is None or mounts is None:
        raise ValueError("a system needs a body and mounts")
    given = body.mass_matrix
    mass = build_body(body).bounded_mass() if given is None else _with_rounding(given)
    placed = mounts_of(case)
    if placed is None:
        return _with_matrix(mass, mounts)
    return on_springs(mass, displacement_at(placed.position), placed)


def mounted(body: RigidBody, mounts: Mounts) -> Linear:
    """Matrices (..., 6, 6) of a body on its mounts."""
    return on_springs(body.bounded_mass(), displacement_at(mounts.position), mounts)


def on_springs(mass: Bounded, stretch: np.ndarray, mounts: Mounts) -> Linear:
    """The same of coordinates (n,) of which `stretch` (..., mounts, d, n) makes deflections."""
    off = 0.0 if mounts.relative_error is None else mounts.relative_error
    return added_up(mass, stretch, mounts.stiffness, mounts.damping, mounts.structural, off)


def _with_matrix(mass: Bounded, mounts: parts.Mounts) -> Linear:
    if mounts.stiffness_matrix is None:
        raise ValueError("the mounts are given one by one")
    stiffness = _with_rounding(mounts.stiffness_matrix)
    damping = Bounded(np.zeros((6, 6)), np.zeros((6, 6)))
    if mounts.damping_matrix is not None:
        damping = _with_rounding(mounts.damping_matrix)
    loss = mounts.loss_factor or 0.0
    structural = loss * stiffness.value
    return Linear(
        mass.value,
        stiffness.value,
        damping.value,
        structural,
        mass.error,
        stiffness.error,
        damping.error,
        loss * stiffness.error + EPSILON * np.abs(structural),
    )


# ----------------------------------------------------------------------------
# Are these the matrices of a body and of a suspension? Symmetric, and of no negative energy.
# ----------------------------------------------------------------------------

Array = NDArray[np.float64]
#: Entries that differ by more, relative to the diagonal entries they belong to, are two numbers.
SYMMETRY = 1e-12
#: Share of the diagonal below which an energy is the round-off of zero.
SEMIDEFINITE = 1e-12


class _Kind(NamedTuple):
    """What a matrix stands for: its name, the energy it gives, and whether that may be zero."""

    name: str
    energy: str
    unit: str
    per_second: bool
    may_vanish: bool


_MASS = _Kind("mass", "kinetic energy", "J", True, False)
_STIFFNESS = _Kind("stiffness", "potential energy", "J", False, True)
_DAMPING = _Kind("damping", "dissipated power", "W", True, True)


@listing
def matrix_problems(case: Case) -> Iterator[Problem]:
    """Problems of the matrices of the case; of each matrix the first kind found."""
    for part, key, kind in (
        ("body", "mass_matrix", _MASS),
        ("mounts", "stiffness_matrix", _STIFFNESS),
        ("mounts", "damping_matrix", _DAMPING),
    ):
        matrix = getattr(getattr(case.machine, part), key, None)
        if matrix is None:
            continue
        path, values = ("machine", part, key), block_matrix(matrix)
        found = (list(check(path, matrix, values, kind)) for check in _CHECKS)
        yield from next((faults for faults in found if faults), ())


def _written(matrix: "BlockMatrix", row: int, column: int) -> str:
    unit = (matrix.units or matrix.SI)[(row >= 3) + (column >= 3)]
    return f"row {row + 1}, column {column + 1}: {matrix.values[row][column]:.10g} {unit}"


def _range(path: KeyPath, matrix: "BlockMatrix", values: Array, kind: _Kind) -> Iterator[Problem]:
    size = np.abs(values)
    small = np.diag((np.diagonal(size) > 0.0) & (np.diagonal(size) < SMALLEST))
    for row, column in np.argwhere((size > LARGEST) | small)[:1].tolist():
        yield Problem(
            path=(*path, "values", row, column),
            message=f"an entry of the {kind.name} matrix is too large or too small to compute with",
            found=f"{_written(matrix, row, column)}, {values[row, column]:.6g} in SI units",
            allowed=f"magnitude up to {LARGEST:.0e} in SI units, on the diagonal from "
            f"{SMALLEST:.0e}",
        )


def _symmetry(
    path: KeyPath, matrix: "BlockMatrix", values: Array, kind: _Kind
) -> Iterator[Problem]:
    root = np.sqrt(np.abs(np.diagonal(values)))
    size = np.maximum(np.abs(values), np.abs(values).T)
    apart = np.abs(values - values.T) > SYMMETRY * np.maximum(size, np.outer(root, root))
    pairs = np.argwhere(np.triu(apart)).tolist()
    if not pairs:
        return
    shown = [f"{_written(matrix, i, j)}; {_written(matrix, j, i)}" for i, j in pairs[:3]]
    more = [f"and {len(pairs) - 3} more pairs"] if len(pairs) > 3 else []
    row, column = pairs[0]
    yield Problem(
        path=(*path, "values", row, column),
        message=f"the {kind.name} matrix is not symmetric",
        found=" | ".join([*shown, *more]),
        allowed="the same number in both places",
        hint="check both against the source of the matrix",
        also=(*path, "values", column, row),
    )


def _diagonal(
    path: KeyPath, matrix: "BlockMatrix", values: Array, kind: _Kind
) -> Iterator[Problem]:
    for place, entry in enumerate(np.diagonal(values).tolist()):
        others = np.delete(values[place], place)
        if entry < 0.0 or (entry == 0.0 and not kind.may_vanish):
            bound = "zero or more" if kind.may_vanish else "above zero"
            yield Problem(
                path=(*path, "values", place, place),
                message=f"{COORDINATES[place]} has a {kind.name} of "
                + ("zero" if entry == 0.0 else "less than zero"),
                found=_written(matrix, place, place),
                allowed=bound,
            )
        elif entry == 0.0 and others.any():
            column = int(np.argmax(np.abs(np.where(np.arange(6) == place, 0.0, values[place]))))
            yield Problem(
                path=(*path, "values", place, column),
                message=f"{COORDINATES[place]} has no {kind.name} of its own but is coupled with "
                f"{COORDINATES[column]}: the {kind.energy} of some motion is then negative",
                found=f"{_written(matrix, place, place)}; {_written(matrix, place, column)}",
                allowed="zero in the whole row, or an entry above zero on the diagonal",
            )


def _energy(path: KeyPath, matrix: "BlockMatrix", values: Array, kind: _Kind) -> Iterator[Problem]:
    """The least energy over all motions, each coordinate measured by its own diagonal entry."""
    positive = np.flatnonzero(np.diagonal(values) > 0.0)
    if not positive.size:
        return
    root = np.sqrt(np.diagonal(values)[positive])
    scaled = values[np.ix_(positive, positive)] / np.outer(root, root)
    levels, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    least = float(levels[0])
    if least > SEMIDEFINITE or (kind.may_vanish and least >= -SEMIDEFINITE):
        return
    share = np.where(np.abs(vectors[:, 0]) > 1e-6, vectors[:, 0], 0.0)
    motion = np.zeros(6)
    motion[positive] = share / root
    motion /= motion[int(np.argmax(np.abs(motion)))]
    energy = 0.0 if abs(least) <= SEMIDEFINITE else 0.5 * float(motion @ values @ motion)
    if kind is _DAMPING:
        energy *= 2.0
    yield Problem(
        path=(*path, "values"),
        message=f"some motion has a negative {kind.name}"
        if energy < 0.0
        else f"some motion has no {kind.name}",
        found=f"{kind.energy} of {energy:.4g} {kind.unit} in {_words(motion, kind.per_second)}",
        allowed=f"{kind.energy} of zero or more in every motion"
        if kind.may_vanish
        else f"{kind.energy} above zero in every motion",
        hint="a sign or a digit of an entry off the diagonal, or a unit, may be wrong",
    )


def _words(motion: Array, per_second: bool) -> str:
    rate = "/s" if per_second else ""
    return ", ".join(
        f"{name} = {amount:.4g} {'m' if place < 3 else 'rad'}{rate}"
        for place, (name, amount) in enumerate(zip(COORDINATES, motion.tolist(), strict=True))
        if amount
    )


_CHECKS = (_range, _symmetry, _diagonal, _energy)
