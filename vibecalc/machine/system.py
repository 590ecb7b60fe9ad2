"""A body and its suspension as one linear system, from parts or from matrices."""

import numpy as np

from vibecalc.case import parts
from vibecalc.case.matrix_parts import BlockMatrix
from vibecalc.case.schema import Machine
from vibecalc.machine.body import build_body
from vibecalc.machine.mounts import build_mounts
from vibecalc.numerics.rounding import DATA_ROUNDINGS, EPSILON, UNIT_ROUNDOFF, WithError
from vibecalc.response.matrices import Matrices
from vibecalc.units import convert


def block_matrix(matrix: BlockMatrix) -> np.ndarray:
    """A matrix (6, 6) of a case in SI: each block times the factor of its unit."""
    return np.asarray(np.array(matrix.values, dtype=float) * _factors(matrix))


def _factors(matrix: BlockMatrix) -> np.ndarray:
    units = matrix.units or matrix.SI
    along, coupled, turning = (
        convert(1.0, unit, si) for unit, si in zip(units, matrix.SI, strict=True)
    )
    return np.block(
        [
            [np.full((3, 3), along), np.full((3, 3), coupled)],
            [np.full((3, 3), coupled), np.full((3, 3), turning)],
        ]
    )


def _with_rounding(matrix: BlockMatrix) -> WithError:
    """The matrix in SI, its halves made equal; an entry that is given in SI is exact."""
    value = block_matrix(matrix)
    rounding = 2.0 * EPSILON * np.abs(value) * (_factors(matrix) != 1.0)
    return WithError(0.5 * (value + value.T), rounding + 0.5 * np.abs(value - value.T))


def build_system(machine: Machine) -> Matrices:
    """Mass, stiffness, damping and structural damping (6, 6) about the body's reference point.

    Modal damping is not in it: it needs the modes. A machine without body or mounts has no
    such system.
    """
    body, mounts = machine.body, machine.mounts
    if body is None or mounts is None:
        raise ValueError("a system needs a body and mounts")
    given = None if body.mass_matrix is None else _with_rounding(body.mass_matrix)
    mass = build_body(body).mass_matrix if given is None else given.value
    system = _with_mounts(mass, mounts)
    return system if given is None else system._replace(mass_error=given.error)


def _with_mounts(mass: np.ndarray, mounts: parts.Mounts) -> Matrices:
    if mounts.stiffness_matrix is None:
        from vibecalc.isolation.rigid_body import assemble

        built = build_mounts(mounts)
        return assemble(mass, built.position, built.stiffness, built.damping, built.structural)
    stiffness = _with_rounding(mounts.stiffness_matrix)
    damping = WithError(np.zeros((6, 6)), np.zeros((6, 6)))
    if mounts.damping_matrix is not None:
        damping = _with_rounding(mounts.damping_matrix)
    loss = mounts.loss_factor or 0.0
    structural = loss * stiffness.value
    return Matrices(
        mass,
        stiffness.value,
        damping.value,
        structural,
        DATA_ROUNDINGS * UNIT_ROUNDOFF * np.abs(mass),
        stiffness.error,
        damping.error,
        loss * stiffness.error + EPSILON * np.abs(structural),
    )
