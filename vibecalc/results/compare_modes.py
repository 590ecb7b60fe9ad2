"""Modes of two results matched by frequency and shape, and what is compared over them.

Two computations may list modes in another order, flip the sign of a shape or scale it, and choose
any basis where frequencies coincide. So modes are matched, shapes are compared by direction (the
modal assurance criterion of Allemang and Brown 1982), coinciding modes as a subspace, and other
quantities over coinciding modes by their sum, which does not depend on the basis.
"""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.results.align import Aligned, Entries, labels
from vibecalc.results.compare_kinds import apart, doubt, scale_of, tolerance
from vibecalc.results.record import Axis, Quantity
from vibecalc.results.rules import Rule

#: zero frequencies come out as the root of round-off, relative to the highest one
_ZERO = 1e-7


class ModeMatch(NamedTuple):
    """Pairs of modes in groups of coinciding frequency, and who stayed alone.

    `groups` are (positions in the reference, positions in the value), `gaps` the distance of each
    group to the next frequency, relative to the larger of the two.
    """

    groups: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    gaps: tuple[float, ...]
    missing: tuple[int, ...]
    extra: tuple[int, ...]


def match_modes(
    left: np.ndarray,
    right: np.ndarray,
    left_shapes: np.ndarray | None,
    right_shapes: np.ndarray | None,
    repeated: float,
) -> ModeMatch:
    """Match natural frequencies `left` (n,) and `right` (k,), with shapes (n, c), (k, c) if any.

    The cheapest pair is taken first; its cost is the relative distance of the frequencies and
    what the shape lacks of lying in the space of the reference's coinciding modes.
    """
    groups = _coinciding(left, repeated)
    cost = np.empty((len(left), len(right)))
    for group in groups:
        members = list(group)
        larger = np.maximum(np.abs(left[members, None]), np.abs(right[None, :]))
        far = np.abs(left[members, None] - right[None, :]) / np.maximum(larger, 1e-300)
        near_zero = larger <= _ZERO * max(scale_of(np.abs(left)), scale_of(np.abs(right)))
        cost[members] = np.where(near_zero | ~np.isfinite(far), 0.0, far)
        if left_shapes is not None and right_shapes is not None:
            cost[members] += outside(left_shapes[members], right_shapes)[None, :] ** 2
    partner: dict[int, int] = {}
    for place in np.argsort(cost, axis=None, kind="stable"):
        one, other = divmod(int(place), len(right))
        if one not in partner and other not in partner.values():
            partner[one] = other
    pairs = []
    for group in groups:
        matched = tuple(one for one in group if one in partner)
        if matched:
            others = sorted((partner[one] for one in matched), key=lambda other: right[other])
            pairs.append((matched, tuple(others)))
    return ModeMatch(
        groups=tuple(pairs),
        gaps=tuple(_gap(left, members) for members, _ in pairs),
        missing=tuple(sorted(set(range(len(left))) - set(partner))),
        extra=tuple(sorted(set(range(len(right))) - set(partner.values()))),
    )


def by_spectrum(
    aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule, match: ModeMatch, axis: Axis
) -> Entries:
    """Entries over matched modes; sums over coinciding ones, except frequencies themselves."""
    single = reference.path.rpartition("/")[2] == "natural_frequency"
    left: list[np.ndarray] = []
    right: list[np.ndarray] = []
    spread: list[np.ndarray] = []
    names: list[str] = []
    for group in match.groups:
        pairs = [((i,), (j,)) for i, j in zip(*group, strict=True)] if single else [group]
        for members, others in pairs:
            left.append(aligned.reference[list(members)].sum(axis=0).ravel())
            right.append(aligned.value[list(others)].sum(axis=0).ravel())
            names += labels(aligned.axes, _mode_label(axis, members))
            spread.append(np.full(left[-1].shape, float(len(members))))
    if not left:
        return Entries((), np.empty(0), np.empty(0), np.empty(0), np.empty(0))
    one, other = np.concatenate(left), np.concatenate(right)
    factor = np.concatenate(spread)
    allowed = np.empty(one.shape)
    for count in np.unique(factor):
        all_allowed = tolerance(np.abs(one), reference, value, rule, spread=float(count))
        allowed[factor == count] = all_allowed[factor == count]
    return Entries(tuple(names), one, other, apart(one, other, rule), allowed)


def by_mode_shape(
    aligned: Aligned, reference: Quantity, value: Quantity, rule: Rule, match: ModeMatch, axis: Axis
) -> Entries:
    """Sine of the angle between a shape and the space of the reference's shapes, per mode.

    It is sqrt(1 - MAC), computed without that cancellation. A shape turns by what changed over
    the relative gap to the next frequency, so the tolerance is divided by twice the gap.
    """
    left = aligned.reference.reshape(aligned.reference.shape[0], -1)
    right = aligned.value.reshape(aligned.value.shape[0], -1)
    names: list[str] = []
    sines: list[float] = []
    allowed: list[float] = []
    for (members, others), gap in zip(match.groups, match.gaps, strict=True):
        found = outside(left[list(members)], right[list(others)])
        for position, other in enumerate(others):
            names.append(_mode_label(axis, members[position : position + 1]))
            sines.append(float(found[position]))
            lengths = np.linalg.norm(left[members[position]]), np.linalg.norm(right[other])
            known, own = (
                quantity.error_estimate * math.sqrt(left.shape[1]) / max(float(length), 1e-300)
                for quantity, length in zip((reference, value), lengths, strict=True)
            )
            rtol = rule.rtol or 0.0
            margin = rtol + doubt(known, own, rtol)
            allowed.append(margin / min(1.0, 2.0 * max(gap, rule.repeated or 0.0, 1e-15)))
    difference = np.array(sines)
    with np.errstate(invalid="ignore"):
        cosines = np.sqrt(np.maximum(1.0 - difference**2, 0.0))
    return Entries(
        tuple(names), np.ones(len(names)), cosines, difference, np.minimum(np.array(allowed), 0.5)
    )


def outside(basis: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Share of each shape (k, c), by length, that lies outside the span of `basis` (m, c).

    A zero shape, of a mode that moves nothing that is shown, lies outside unless one of the basis
    is zero (or twice the same), too; shapes with NaN or infinities give infinity.
    """
    if not np.isfinite(basis).all():
        return np.full(len(shapes), math.inf)
    usable = np.isfinite(shapes).all(axis=1)
    shapes = np.where(usable[:, None], shapes, 0.0)
    lengths = np.linalg.norm(shapes, axis=1)
    directions, sizes, _ = np.linalg.svd(basis.T, full_matrices=False)
    directions = directions[:, sizes > 1e-12 * max(float(sizes.max(initial=0.0)), 1e-300)]
    rest = shapes.T - directions @ (np.conj(directions.T) @ shapes.T)
    rest -= directions @ (np.conj(directions.T) @ rest)  # once more: the first leaves round-off
    share = np.linalg.norm(rest, axis=0) / np.where(lengths > 0, lengths, 1.0)
    share = np.where(lengths > 0, share, float(directions.shape[1] >= len(basis)))
    return np.where(usable, share, math.inf)


def _coinciding(frequencies: np.ndarray, repeated: float) -> list[tuple[int, ...]]:
    order = np.argsort(frequencies, kind="stable")
    floor = _ZERO * scale_of(np.abs(frequencies))
    groups: list[list[int]] = []
    for position in order:
        here = float(frequencies[position])
        before = float(frequencies[groups[-1][-1]]) if groups else math.nan
        if here - before <= max(repeated * abs(here), floor):
            groups[-1].append(int(position))
        else:
            groups.append([int(position)])
    return [tuple(group) for group in groups]


def _gap(frequencies: np.ndarray, members: tuple[int, ...]) -> float:
    others = np.delete(frequencies, list(members))
    if not others.size:
        return 1.0
    mine = frequencies[list(members)][:, None]
    larger = np.maximum(np.maximum(np.abs(mine), np.abs(others[None, :])), 1e-300)
    return float((np.abs(mine - others[None, :]) / larger).min())


def _mode_label(axis: Axis, members: tuple[int, ...]) -> str:
    return f"{axis.name}=" + "+".join(str(axis.values[position]) for position in members)
