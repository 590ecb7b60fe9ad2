"""Points that the array path leaves to single runs, which refuse them, or not, in their own words.

Every case that a check of `case` or `machine` refuses is among them, and some that it does not:
the bounds here are a little narrower.
"""

import operator

import numpy as np

from vibecalc.case.walk import shape_at
from vibecalc.core.case.number_range import ANGLES, LARGEST, LARGEST_ANGLE, SMALLEST
from vibecalc.numerics.typing import BoolArray
from vibecalc.pipeline.arrays.columns import Columns
from vibecalc.pipeline.arrays.mounted import BODY, Mounted, build_mounted, own_moments
from vibecalc.pipeline.arrays.train import TRAIN, Train, build_train

_COMPARE = {"gt": operator.gt, "ge": operator.ge, "lt": operator.lt, "le": operator.le}
#: crank over rod beyond which series grow long
_LONGEST_REACH = 0.98
#: relative slack around bounds of the checks
_SLACK = 1e-9
_MARGIN = 1.0 + _SLACK


def suspects(columns: Columns) -> BoolArray:
    """Points (points,) that a check may refuse, or whose series are long."""
    with np.errstate(all="ignore"):
        found = _numbers(columns)
        train = build_train(columns)
        found |= _train(columns, train)
        if columns.case.machine.body is not None:
            found |= _body(columns)
        if columns.case.isolation is not None:
            found |= _held(columns, build_mounted(columns, train))
    return found


def _numbers(columns: Columns) -> BoolArray:
    """Outside the bounds of the schema, or of what can be computed with."""
    found = np.zeros(columns.count, dtype=bool)
    for path, values in columns.varied.items():
        shape, size = shape_at(path), np.abs(values)
        inside = np.isfinite(values)
        for name, bound in () if shape is None else shape.bounds:
            inside &= _COMPARE[name](values, bound)
        name = next(str(part) for part in reversed(path) if isinstance(part, str))
        inside &= size <= (LARGEST_ANGLE if name in ANGLES else LARGEST)
        inside &= (size == 0.0) | (size >= SMALLEST)
        found |= ~inside
    return found


def _train(columns: Columns, train: Train) -> BoolArray:
    """A rod that does not get round, no mass that moves, more of it than the machine weighs."""
    case = columns.case
    reach = train.crank_radius + np.abs(train.wrist_pin_offset)
    fine = reach < _LONGEST_REACH * train.rod_length
    if case.kinematics is not None and case.kinematics.series == "truncated":
        fine = fine & (train.wrist_pin_offset == 0.0)
    fine = fine & (train.rod_share <= 1.0)
    moving = (train.whole_reciprocating_mass + train.whole_rotating_mass).sum(1)
    written = case.machine.crank_train
    unbalance = [
        columns.number(*TRAIN, table, place, "unbalance")
        for table in ("counterweights", "balance_shafts")
        for place in range(len(getattr(written, table)))
    ]
    fine = fine & (sum(unbalance, moving) > 0.0)
    body = case.machine.body
    if body is not None:
        if body.mass_matrix is None:
            whole = columns.number(*BODY, "mass")
        else:
            from vibecalc.parts.matrices import block_matrix

            whole = np.min(np.diagonal(block_matrix(body.mass_matrix))[:3], keepdims=True)
        fine = fine & (moving * _MARGIN < whole)
    return _everywhere(columns, ~fine)


def _body(columns: Columns) -> BoolArray:
    """Moments of inertia that no body has."""
    body = columns.case.machine.body
    if body is None or body.inertia is None:
        return np.zeros(columns.count, dtype=bool)
    moments, products = own_moments(columns), columns.vector(*BODY, "inertia_products")
    matrix = np.zeros((max(len(moments), len(products)), 3, 3))
    matrix[:, range(3), range(3)] = moments
    for place, (row, column) in enumerate(((0, 1), (0, 2), (1, 2))):
        matrix[:, row, column] = matrix[:, column, row] = -products[:, place]
    finite: BoolArray = np.all(np.isfinite(matrix), axis=(1, 2))
    principal = np.linalg.eigvalsh(np.where(finite.reshape(-1, 1, 1), matrix, np.eye(3)))
    low, middle, high = principal.T
    fine = finite & (moments > 0.0).all(1) & (low > 1e-11 * high)
    return _everywhere(columns, ~(fine & (high <= (low + middle) * (1.0 + 0.9e-6))))


def _held(columns: Columns, mounted: Mounted) -> BoolArray:
    """A body that is free to pitch, and mounts without a lever of their own."""
    isolation, train = columns.case.isolation, columns.case.machine.crank_train
    pitch = (mounted.stiffness * np.square(mounted.position)).sum(1)
    fine = (pitch > 0.0) & np.isfinite(pitch)
    if columns.optional("isolation", "lever") is None:
        fine = fine & (mounted.spread <= 0.9e-9) & (mounted.lever > 0.0)
    if isolation is not None and isolation.up != train.stroke:
        fine = fine & False
    return _everywhere(columns, ~fine)


def _everywhere(columns: Columns, found: np.ndarray) -> BoolArray:
    return np.broadcast_to(found, columns.count).copy()
