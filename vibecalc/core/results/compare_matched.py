"""Comparisons that need a matching: modes by frequency and shape, curves by place."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.compare_rules import Entries, Pair, joined, scale_of, uncertainty
from vibecalc.core.results.record import Axis, Quantity, Record
from vibecalc.core.results.select import label_of

# ----------------------------------------------------------------------------
# Modes of two results matched by frequency and shape, and what is compared over them.
#
# Two computations may flip the sign of a shape, and choose any basis and order where frequencies
# coincide. So modes are matched, shapes are compared by direction (the modal assurance criterion of
# Allemang and Brown 1982) and scale, coinciding modes as a subspace, and other quantities over
# coinciding modes by their sum, which does not depend on the basis. Modes that have changed places
# without coinciding are a difference: an axis of modes has an order.
# ----------------------------------------------------------------------------

#: zero frequencies come out as the root of round-off, relative to the highest one
_ZERO = 1e-7
#: in the name of shapes whose scale is promised for coinciding modes, too
_UNIT_MASS = "of unit modal mass"


class ModeMatch(NamedTuple):
    """Pairs of modes in groups of coinciding frequency, and who stayed alone.

    `groups` are (positions in the reference, positions in the value), `gaps` the distance of each
    group to the next frequency, relative to the larger of the two. `moved` are positions in the
    reference, and in the value, of modes that stand in another order.
    """

    groups: tuple[tuple[tuple[int, ...], tuple[int, ...]], ...]
    gaps: tuple[float, ...]
    missing: tuple[int, ...]
    extra: tuple[int, ...]
    moved: tuple[tuple[int, int], ...]

    def problems(self, one: Quantity, other: Quantity) -> tuple[str, ...]:
        """Modes of two quantities that have no partner, or stand in another order."""
        left, right = axis_of(one, "mode").values, axis_of(other, "mode").values
        return (
            *(f"mode={left[place]} is missing" for place in self.missing),
            *(f"mode={right[place]} is not in the reference" for place in self.extra),
            *(
                f"mode={left[was]} has become mode={right[now]}: the modes stand in another order"
                for was, now in self.moved
            ),
        )


def match_folder(
    reference: Record, value: Record, folder: str, repeated: float
) -> ModeMatch | None:
    """The matching of modes for all quantities of one folder; None without frequencies there."""
    paths = f"{folder}/natural_frequency", f"{folder}/shape"
    frequencies, shapes = ([_over_modes(one, path) for one in (reference, value)] for path in paths)
    left, right = frequencies
    if left is None or right is None:
        return None
    error = uncertainty(reference[paths[0]].error_estimate, value[paths[0]].error_estimate, 0.0)
    return match_modes(left.ravel(), right.ravel(), shapes[0], shapes[1], repeated, float(error))


def _over_modes(record: Record, path: str) -> np.ndarray | None:
    """Values (modes, entries) of a quantity whose axes begin with `mode`."""
    if path not in record or [axis.name for axis in record[path].axes][:1] != ["mode"]:
        return None
    values = np.asarray(record[path].values)
    return values.reshape(len(values), -1) if values.size else None


def match_modes(
    left: np.ndarray,
    right: np.ndarray,
    left_shapes: np.ndarray | None,
    right_shapes: np.ndarray | None,
    repeated: float,
    error: float,
) -> ModeMatch:
    """Match natural frequencies `left` (n,) and `right` (k,), with shapes (n, c), (k, c) if any.

    Frequencies coincide that are within `repeated` of each other, relative, or within `error`.

    The cheapest pair is taken first; its cost is the relative distance of the frequencies and
    what the shape lacks of lying in the space of the reference's coinciding modes. Shapes count
    where all are finite and of the same coordinates.
    """
    shapes = (left_shapes, right_shapes)
    usable = all(one is not None and np.isfinite(one).all() for one in shapes)
    usable = usable and len({one.shape[1] for one in shapes if one is not None}) == 1
    groups = _coinciding(left, repeated, error)
    apart = np.zeros((len(groups), len(right)))
    if usable and left_shapes is not None and right_shapes is not None:
        apart = _shares_outside([left_shapes[list(group)] for group in groups], right_shapes)
    cost = np.empty((len(left), len(right)))
    for group, share in zip(groups, apart, strict=True):
        members = list(group)
        larger = np.maximum(np.abs(left[members, None]), np.abs(right[None, :]))
        far = np.abs(left[members, None] - right[None, :]) / np.maximum(larger, 1e-300)
        near_zero = larger <= _ZERO * max(scale_of(np.abs(left)), scale_of(np.abs(right)))
        cost[members] = np.where(near_zero | ~np.isfinite(far), 0.0, far) + share
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for place in np.argsort(cost, axis=None, kind="stable"):
        one, other = divmod(int(place), len(right))
        if one not in partner and other not in taken:
            partner[one] = other
            taken.add(other)
            if len(taken) == min(cost.shape):
                break
    pairs = []
    for group in groups:
        matched = tuple(one for one in group if one in partner)
        if matched:
            others = sorted((partner[one] for one in matched), key=lambda other: right[other])
            pairs.append((matched, tuple(others)))
    place = {other: k for k, other in enumerate(sorted(partner.values()))}
    rank = {one: k for k, one in enumerate(sorted(partner))}
    moved = [
        (one, partner[one])
        for members, others in pairs
        if {rank[one] for one in members} != {place[other] for other in others}
        for one in members
    ]
    return ModeMatch(
        groups=tuple(pairs),
        gaps=tuple(_gap(left, members) for members, _ in pairs),
        missing=tuple(sorted(set(range(len(left))) - set(partner))),
        extra=tuple(sorted(set(range(len(right))) - set(partner.values()))),
        moved=tuple(sorted(moved)),
    )


def by_spectrum(pair: Pair, match: ModeMatch) -> Entries:
    """Entries over matched modes; sums over coinciding ones, except frequencies themselves."""
    axis, groups = axis_of(pair.reference, "mode"), match.groups
    if pair.reference.path.rpartition("/")[2] == "natural_frequency":
        groups = tuple(((i,), (j,)) for group in groups for i, j in zip(*group, strict=True))
    parts = []
    for members, others in groups:
        left = pair.left[list(members)].sum(axis=0)
        right = pair.right[list(others)].sum(axis=0)
        allowed = pair.allowed(np.abs(left), pair.axes, spread=float(len(members)))
        names = label_of(pair.axes, _mode_label(axis, members))
        parts.append(Entries(names, left, right, pair.apart(left, right), allowed))
    return joined(parts)


def by_mode_shape(pair: Pair, match: ModeMatch) -> Entries:
    """Sine of the angle between a shape and the space of the reference's shapes, and its scale.

    The sine is sqrt(1 - MAC), computed without that cancellation; to it comes, at a right angle, by
    how much the shape is longer or shorter. Of coinciding modes that counts where shapes are of
    unit modal mass, for then a turned basis has the same lengths. A shape turns by what changed
    over the relative gap to the next frequency, so the tolerance is divided by twice the gap.
    """
    left, right = (side.reshape(len(side), -1) for side in (pair.left, pair.right))
    sizes = [
        math.sqrt(left.shape[1]) / np.maximum(np.linalg.norm(side, axis=1), 1e-300)
        for side in (left, right)
    ]
    axis, names, rows = axis_of(pair.reference, "mode"), [], []
    for (members, others), gap in zip(match.groups, match.gaps, strict=True):
        sines = outside(left[list(members)], right[list(others)])
        lengths = _lengths(left[list(members)], right[list(others)], sines)
        if len(members) > 1 and _UNIT_MASS not in pair.reference.long_name:
            lengths = np.ones(len(members))
        turns = min(1.0, 2.0 * max(gap, pair.rule.repeated or 0.0, 1e-15))
        for place, (one, other) in enumerate(zip(members, others, strict=True)):
            known = pair.reference.error_estimate * sizes[0][one]
            margin = pair.rtol + uncertainty(
                known, pair.value.error_estimate * sizes[1][other], pair.rtol
            )
            names.append(_mode_label(axis, (one,)))
            rows.append((sines[place], lengths[place], margin / turns))
    sine, scale, allowed = np.array(rows).reshape(-1, 3).T
    with np.errstate(invalid="ignore"):
        met = scale * np.sqrt(np.maximum(1.0 - sine**2, 0.0))
        difference = np.where(np.isfinite(sine), np.hypot(sine, scale - 1.0), math.inf)
    return Entries(
        names.__getitem__, np.ones(len(names)), met, difference, np.minimum(allowed, 0.5)
    )


def _lengths(basis: np.ndarray, shapes: np.ndarray, sines: np.ndarray) -> np.ndarray:
    """Lengths of shapes (k, c) in terms of the basis (m, c): 1 for the same; of zero shapes 1."""
    if not (np.isfinite(basis).all() and np.isfinite(shapes).all()):
        return np.ones(len(shapes))
    parts = np.linalg.norm(shapes @ np.linalg.pinv(basis), axis=1)
    cosines = np.sqrt(np.maximum(1.0 - sines**2, 0.0))
    known = (parts > 0.0) & (cosines > 0.0)
    return np.where(known, parts / np.where(known, cosines, 1.0), 1.0)


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
    directions = _directions(basis)
    remainder = shapes.T - directions @ (np.conj(directions.T) @ shapes.T)
    # once more: the first leaves round-off
    remainder -= directions @ (np.conj(directions.T) @ remainder)
    share = np.linalg.norm(remainder, axis=0) / np.where(lengths > 0, lengths, 1.0)
    share = np.where(lengths > 0, share, float(directions.shape[1] >= len(basis)))
    return np.where(usable, share, math.inf)


def _directions(basis: np.ndarray) -> np.ndarray:
    """Orthonormal directions (c, r) of the span of `basis` (m, c), r <= m."""
    directions, sizes, _ = np.linalg.svd(basis.T, full_matrices=False)
    return np.asarray(directions[:, sizes > 1e-12 * max(float(sizes.max(initial=0.0)), 1e-300)])


def _shares_outside(bases: Sequence[np.ndarray], shapes: np.ndarray) -> np.ndarray:
    """Squares (groups, k) of what `outside` gives for each of many bases; all entries are finite.

    One product of matrices gives what lies inside. One minus that has lost the digits of a small
    share, which decides nothing about who belongs together.
    """
    lengths = np.linalg.norm(shapes, axis=1)
    units = shapes / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    spans = [_directions(basis) for basis in bases]
    inside = np.abs(np.concatenate(spans, axis=1).conj().T @ units.T) ** 2
    ends = np.cumsum([span.shape[1] for span in spans])
    found = np.empty((len(bases), len(shapes)))
    for place, (basis, span, end) in enumerate(zip(bases, spans, ends, strict=True)):
        share = np.maximum(1.0 - inside[end - span.shape[1] : end].sum(axis=0), 0.0)
        found[place] = np.where(lengths > 0.0, share, float(span.shape[1] >= len(basis)))
    return found


def _coinciding(frequencies: np.ndarray, repeated: float, error: float) -> list[tuple[int, ...]]:
    order = np.argsort(frequencies, kind="stable")
    floor = max(_ZERO * scale_of(np.abs(frequencies)), error)
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


# ----------------------------------------------------------------------------
# Curves over an axis whose samples may lie elsewhere in another run.
# ----------------------------------------------------------------------------


def by_curve(pair: Pair, name: str) -> tuple[Entries, tuple[str, ...]]:
    """Compare at the samples of both curves, straight between samples, within a tube.

    `pair` has the axis `name` first. A sample may be off by `rule.shift` times the highest
    abscissa along the axis, and by the tolerance across it; so a resonance that one run sampled
    a little next to another one's sample is no difference. Samples that are not finite have to
    meet an equal one within the shift.

    Returns the entries, samples of the reference first, and words on ranges that do not agree.
    """
    axes = axis_of(pair.reference, name), axis_of(pair.value, name)
    x_left, x_right = (np.asarray(axis.values, dtype=float) for axis in axes)
    # samples by curves; always complex, so that real curves take the same way
    y_left, y_right = (
        side.reshape(len(side), math.prod(side.shape[1:])).astype(complex)
        for side in (pair.left, pair.right)
    )
    if not x_left.size or not x_right.size:
        problem = f"{name} has {x_left.size} samples in the reference, {x_right.size} in the value"
        return joined([]), (problem,) * (x_left.size != x_right.size)
    shift = (pair.rule.shift or 0.0) * max(np.abs(x_left).max(), np.abs(x_right).max())
    first = max(x_left.min(), x_right.min()) - shift
    last = min(x_left.max(), x_right.max()) + shift
    allowed = pair.allowed(np.abs(pair.left), (axes[0], *pair.axes)).reshape(y_left.shape)
    real = not np.iscomplexobj(pair.left) and not np.iscomplexobj(pair.right)
    parts = []
    for axis, x, y, other_x, other_y in (
        (axes[0], x_left, y_left, x_right, y_right),
        (axes[1], x_right, y_right, x_left, y_left),
    ):
        within = np.flatnonzero((x >= first) & (x <= last))
        limit = _interpolated(x[within], x_left, allowed).real
        met = _interpolated(x[within], other_x, other_y)
        difference = _distances(pair, x[within], y[within], other_x, other_y, shift, limit, met)
        shown = (y[within], met) if axis is axes[0] else (met, y[within])
        one, other = (side.real if real else side for side in shown)
        names = label_of((replace(axis, values=np.asarray(axis.values)[within]), *pair.axes))
        parts.append(Entries(names, one, other, difference, limit))
    ends = [(side.min(), side.max()) for side in (x_left, x_right)]
    if all(abs(one - other) <= shift for one, other in zip(*ends, strict=True)):
        return joined(parts), ()
    ranges = " against ".join(f"{low:.9g} to {high:.9g}" for low, high in ends)
    return joined(parts), (f"{name} covers {ranges} {axes[0].unit}".rstrip(),)


def _distances(
    pair: Pair,
    x: np.ndarray,
    y: np.ndarray,
    other_x: np.ndarray,
    other_y: np.ndarray,
    shift: float,
    limit: np.ndarray,
    met: np.ndarray,
) -> np.ndarray:
    """Distance of samples (n, m) from the other curve within the tube.

    Straight across the axis where that is already within the limit.
    """
    with np.errstate(invalid="ignore"):
        difference = np.abs(y - met)
    difference = np.where(np.isnan(difference), math.inf, difference)
    order = np.argsort(other_x, kind="stable")
    sorted_x, sorted_y = other_x[order], other_y[order]
    for row in np.flatnonzero((difference > limit).any(axis=1)):
        near = _from_polyline(x[row], y[row], sorted_x, sorted_y, shift, bool(pair.rule.nan_equal))
        difference[row] = np.minimum(difference[row], near)
    return difference


def _from_polyline(
    x: float, y: np.ndarray, other_x: np.ndarray, other_y: np.ndarray, shift: float, nan_equal: bool
) -> np.ndarray:
    """Distance of values `y` (m,) at `x` from what the other curves pass within x +- shift."""
    first = max(int(np.searchsorted(other_x, x - shift, "left")) - 1, 0)
    last = min(int(np.searchsorted(other_x, x + shift, "right")), len(other_x) - 1)
    nodes_x, nodes_y = other_x[first : last + 1], other_y[first : last + 1]
    inside = np.abs(nodes_x - x) <= shift
    same = nodes_y == y
    if nan_equal:
        same = same | (np.isnan(nodes_y) & np.isnan(y))
    met = (same & inside[:, None]).any(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        step, change = np.diff(nodes_x)[:, None], np.diff(nodes_y, axis=0)
        offset = x - nodes_x[:-1, None]
        start = np.clip(np.where(step > 0, (offset - shift) / step, 0.0), 0.0, 1.0)
        stop = np.clip(np.where(step > 0, (offset + shift) / step, 1.0), 0.0, 1.0)
        along = (np.conj(change) * (y - nodes_y[:-1])).real / np.abs(change) ** 2
        along = np.clip(np.where(np.isfinite(along), along, start), start, stop)
        gaps = np.abs(y - (nodes_y[:-1] + along * change))
        points = np.where(inside[:, None], np.abs(y - nodes_y), math.inf)
    gaps = np.concatenate([gaps, points])
    gaps = np.where(np.isnan(gaps), math.inf, gaps)
    return np.asarray(np.where(met, 0.0, gaps.min(axis=0)))


def _interpolated(x: np.ndarray, other_x: np.ndarray, other_y: np.ndarray) -> np.ndarray:
    """The other curves (n, m) at `x`, straight between samples, constant beyond the ends."""
    order = np.argsort(other_x, kind="stable")
    found = np.empty((len(x), other_y.shape[1]), dtype=complex)
    with np.errstate(invalid="ignore"):
        for column in range(other_y.shape[1]):
            found[:, column] = np.interp(x, other_x[order], other_y[order, column])
    return found


def axis_of(quantity: Quantity, name: str) -> Axis:
    """The axis of that name."""
    return next(axis for axis in quantity.axes if axis.name == name)
