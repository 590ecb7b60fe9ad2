"""Cyclic recursions d[p + 1] = transfer[p] d[p] + offset[p], d[P] = d[0], solved stably.

A scalar recursion is run in the direction in which it does not grow over the whole turn. Blocks
with growing and decaying directions mixed are eliminated in pairs by orthogonal matrices.
"""

import numpy as np

from vibecalc.numerics.typing import FloatArray


def solve_scalar(transfer: FloatArray, offset: FloatArray) -> FloatArray:
    """d (B, P) from transfer and offset (B, P); not finite where the product of transfers is 1."""
    members, panels = transfer.shape
    product = np.multiply.reduce(transfer, axis=1)
    back = np.abs(product) > 1.0
    turned = bool(back.any())
    if turned:
        flipped = transfer[:, ::-1]
        safe = np.where(back[:, None], flipped, 1.0)
        offset = np.where(back[:, None], -offset[:, ::-1] / safe, offset)
        transfer = np.where(back[:, None], 1.0 / safe, transfer)
    if members == 1:
        found = _one_member(transfer[0].tolist(), offset[0].tolist())
    else:
        found = _many_members(transfer, offset)
    if turned:
        # from the last edge backwards: 0, P - 1, ..., 1
        order = np.concatenate([[0], np.arange(panels - 1, 0, -1)])
        found = np.where(back[:, None], found[:, order], found)
    return found


def _one_member(transfer: list[float], offset: list[float]) -> FloatArray:
    product, total = 1.0, 0.0
    for factor, shift in zip(transfer, offset, strict=True):
        product *= factor
        total = factor * total + shift
    if product == 1.0:
        return np.full((1, len(transfer)), np.nan)
    value = total / (1.0 - product)
    found = []
    for factor, shift in zip(transfer, offset, strict=True):
        found.append(value)
        value = factor * value + shift
    return np.array([found])


def _many_members(transfer: FloatArray, offset: FloatArray) -> FloatArray:
    factors, shifts = np.ascontiguousarray(transfer.T), np.ascontiguousarray(offset.T)
    total = np.zeros(factors.shape[1])
    for factor, shift in zip(factors, shifts, strict=True):
        total = factor * total + shift
    value = total / (1.0 - np.multiply.reduce(factors, axis=0))
    found = np.empty_like(factors)
    for place, (factor, shift) in enumerate(zip(factors, shifts, strict=True)):
        found[place] = value
        value = factor * value + shift
    return found.T


def solve_blocks(transfer: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """d (B, P, n) from transfer (B, P, n, n) and offset (B, P, n), with a condition number (B,).

    Equations of neighbouring panels are combined by a QR factorisation of the block column of the
    value between them, level by level, until one remains for d[0]. The condition number is that of
    this last one; it is infinite, and d not finite, where it is singular (a multiplier 1).

    Source: Wright (1992), Stable parallel algorithms for two-point boundary value problems.
    """
    panels, states = offset.shape[1:]
    before = -transfer
    after = np.broadcast_to(np.eye(states), transfer.shape)
    right = offset[..., None]
    levels: list[tuple[FloatArray, ...]] = []
    while panels > 1:
        pairs = panels // 2
        first, second = slice(0, 2 * pairs, 2), slice(1, 2 * pairs, 2)
        column = np.concatenate([after[:, first], before[:, second]], axis=2)
        turn, triangle = np.linalg.qr(column, mode="complete")
        share = np.concatenate([before[:, first], right[:, first]], axis=3)
        other = np.concatenate([after[:, second], right[:, second]], axis=3)
        both = turn.swapaxes(2, 3)
        from_first = both @ np.concatenate([share, np.zeros_like(share)], axis=2)
        from_second = both @ np.concatenate([np.zeros_like(other), other], axis=2)
        top, low = slice(0, states), slice(states, 2 * states)
        levels.append((
            triangle[:, :, top],
            from_first[:, :, top, :states],
            from_second[:, :, top, :states],
            from_first[:, :, top, states:] + from_second[:, :, top, states:],
        ))  # fmt: skip
        rest = slice(2 * pairs, panels)
        before = np.concatenate([from_first[:, :, low, :states], before[:, rest]], axis=1)
        after = np.concatenate([from_second[:, :, low, :states], after[:, rest]], axis=1)
        joined = from_first[:, :, low, states:] + from_second[:, :, low, states:]
        right = np.concatenate([joined, right[:, rest]], axis=1)
        panels = pairs + panels % 2
    return _unfold(before[:, 0], after[:, 0], right[:, 0], levels)


def _unfold(
    before: FloatArray, after: FloatArray, right: FloatArray, levels: list[tuple[FloatArray, ...]]
) -> tuple[FloatArray, FloatArray]:
    """The last equation solved, then the values between, level by level."""
    closing = before + after
    try:
        inverse = np.linalg.inv(closing)
    except np.linalg.LinAlgError:
        inverse = np.stack([_inverse_or_nan(one) for one in closing])
    size = np.linalg.norm(before, axis=(1, 2)) + np.linalg.norm(after, axis=(1, 2))
    condition = np.linalg.norm(inverse, axis=(1, 2)) * size
    condition = np.where(np.isfinite(condition), condition, np.inf)
    found = (inverse @ right)[:, None, :, :]
    for triangle, first, second, value in reversed(levels):
        pairs = triangle.shape[1]
        following = np.concatenate([found[:, 1:], found[:, :1]], axis=1)[:, :pairs]
        known = value - first @ found[:, :pairs] - second @ following
        between = np.linalg.solve(triangle, known)
        whole = np.empty((len(found), pairs + found.shape[1], *found.shape[2:]))
        whole[:, 0 : 2 * pairs : 2] = found[:, :pairs]
        whole[:, 1 : 2 * pairs : 2] = between
        whole[:, 2 * pairs :] = found[:, pairs:]
        found = whole
    return found[..., 0], condition


def _inverse_or_nan(matrix: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full(matrix.shape, np.nan)
