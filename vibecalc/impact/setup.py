"""What stays the same while a batch runs: panels of crank angle, power series, transforms."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.impact.linkage import FREE, LOWER, UPPER, Drive, GasForce, Law, Train, law_of
from vibecalc.impact.roots import in_order
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Panels of crank angle: on each one the gas force is a straight line and the drive is smooth.
#
# The motion inside a step is a power series of degree DEGREE in local time. A panel is short enough
# for the series of the drive, a step short enough for that of the contacts (see `series.py`), so
# that what the series leave out is below rounding.
# ----------------------------------------------------------------------------

#: degree of the power series of every gap
DEGREE = 28

#: highest order times half the width of a panel, for the moments of `spectrum.py`
_HALF_PHASE = 5.0
_MOST_PANELS = 20_000


class Panels(NamedTuple):
    """Start, width (rad), gas force at the start (N) and its slope (N/rad) of each panel (p,)."""

    start: FloatArray
    width: FloatArray
    gas: FloatArray
    gas_slope: FloatArray


def make_panels(drive: Drive, gas: GasForce, highest_order: int, subdivision: int = 1) -> Panels:
    """Panels over one turn from crank angle 0, each node of the gas table between two of them.

    `subdivision` cuts every panel into that many, to show that nothing depends on them.
    Raises NumericalFailure for a drive that would need more than 20 000.
    """
    node, force = _gas_nodes(gas)
    widest = min(_drive_width(drive), 2.0 * _HALF_PHASE / max(highest_order, 1))
    counts = np.ceil(np.diff(node) / widest * (1.0 - 1e-12)).astype(np.int64) * subdivision
    if np.sum(counts) > _MOST_PANELS:
        raise NumericalFailure(
            f"one revolution would need {np.sum(counts)} panels, more than {_MOST_PANELS}: the "
            f"motion of the crank pin has harmonics too high, or too many orders are kept"
        )
    starts, gas_starts, slopes = [], [], []
    for k, count in enumerate(counts.tolist()):
        width, slope = node[k + 1] - node[k], (force[k + 1] - force[k]) / (node[k + 1] - node[k])
        local = width * np.arange(count) / count
        starts.append(node[k] + local)
        gas_starts.append(force[k] + slope * local)
        slopes.append(np.full(count, slope))
    start = np.concatenate(starts)
    width = np.diff(np.append(start, 2.0 * np.pi))
    return Panels(start, width, np.concatenate(gas_starts), np.concatenate(slopes))


def gas_force(gas: GasForce, angle: FloatArray) -> FloatArray:
    """Gas force, N, at crank angles of any shape, rad."""
    node, force = _gas_nodes(gas)
    return np.asarray(np.interp(np.mod(angle, 2.0 * np.pi), node, force))


def _gas_nodes(gas: GasForce) -> tuple[FloatArray, FloatArray]:
    """The table over one turn from 0 to 2 pi, with nodes at both ends."""
    turn = 2.0 * np.pi
    angle = np.asarray(gas.angle, dtype=np.float64)
    force = np.asarray(gas.force, dtype=np.float64)
    if not angle.size:
        return np.array([0.0, turn]), np.zeros(2)
    if angle.size > 1 and angle[-1] - angle[0] > turn * (1.0 - 1e-12):
        angle, force = angle[:-1], force[:-1]
    angle = np.mod(angle, turn)
    order = np.argsort(angle, kind="stable")
    angle, force = angle[order], force[order]
    at_zero = float(np.interp(0.0, angle, force, period=turn))
    inside = (angle > 1e-12) & (angle < turn - 1e-12)
    node = np.concatenate([[0.0], angle[inside], [turn]])
    return node, np.concatenate([[at_zero], force[inside], [at_zero]])


def _drive_width(drive: Drive) -> float:
    """Widest panel, rad, whose series of degree DEGREE of the drive's motion is exact to rounding.

    The first term left out of sum |a_n| (n width)^k / k! stays below rounding of sum |a_n|.
    """
    width = 2.0 * np.pi
    series = [(np.asarray(drive.orders), np.square(drive.orders) * np.abs(drive.displacement))]
    if drive.rod_tangent is not None and drive.tangent_orders is not None:
        series.append((np.asarray(drive.tangent_orders), np.abs(drive.rod_tangent)))
    # k = DEGREE - 1 is the first term that the acceleration leaves out
    term = DEGREE - 1
    factorial = float(np.prod(np.arange(1.0, term + 1.0)))
    for orders, size in series:
        total = float(np.sum(size))
        highest = float(np.sum(size * orders.astype(np.float64) ** term)) / factorial
        if highest > 0.0:
            width = min(width, (UNIT_ROUNDOFF * total / highest) ** (1.0 / term))
    return width


# ----------------------------------------------------------------------------
# Power series of the gaps over one step: between events the system is linear.
#
# With s the fraction of the step, a gap is z = sum_k z_k s^k. The equation of motion gives z_(k+2)
# from z_k and z_(k+1): the series of the matrix exponential and of the forced motion together,
# which has no trouble at resonance, with damping above critical, or in the double integral of a
# free flight. Steps are at most REACH over the fastest rate of the contacts, which leaves out
# REACH^(DEGREE+1)/(DEGREE+1)! = 2e-17 of the motion.
# ----------------------------------------------------------------------------

#: longest step times the fastest rate of the contacts
REACH = 3.1
_RANK = np.arange(1.0, DEGREE + 1.0)
_FACTORIAL = np.cumprod(np.concatenate([[1.0], _RANK]))


class DrivePart(NamedTuple):
    """Some columns of a table: sums of `factor` (m, c) times rows (m,) of the `waves`."""

    columns: IntArray
    factor: FloatArray
    waves: slice


class DriveTable(NamedTuple):
    """An angle series of a sum of harmonics `orders` (n,): columns k are its derivative k over k!.

    Waves are cosine and sine of each order in turn. Columns that have one of the two alone, as
    all of a symmetric drive, leave the other out.
    """

    orders: FloatArray
    width: int
    parts: tuple[DrivePart, ...]


def _rising(orders: IntArray, values: ComplexArray) -> list[ComplexArray]:
    """Rows (DEGREE - 1, n) of the angle series of a sum of harmonics."""
    rows = [values]
    for k in range(1, DEGREE - 1):
        rows.append(np.asarray(rows[-1] * (1j * orders) / k, dtype=np.complex128))
    return rows


def _table(orders: IntArray, series: list[ComplexArray]) -> DriveTable:
    rows = np.array(series)
    used = np.any(rows != 0.0, axis=0)
    factor = np.empty((2 * int(np.count_nonzero(used)), len(rows)))
    factor[0::2], factor[1::2] = rows[:, used].real.T, -rows[:, used].imag.T
    cosine, sine = np.any(factor[0::2] != 0.0, axis=0), np.any(factor[1::2] != 0.0, axis=0)
    kinds = (
        (cosine & ~sine, slice(0, None, 2)),
        (sine & ~cosine, slice(1, None, 2)),
        (cosine & sine, slice(None)),
    )
    parts = tuple(
        DrivePart(np.flatnonzero(mine), np.ascontiguousarray(factor[waves][:, mine]), waves)
        for mine, waves in kinds
        if np.any(mine)
    )
    return DriveTable(np.asarray(orders, dtype=np.float64)[used], len(rows), parts)


def drive_series(table: DriveTable, angle: FloatArray) -> FloatArray:
    """The columns of a table at crank angles (A,), as an array (k, A).

    Sums run over the orders one by one, so that a run does not depend on its company in a batch.
    """
    waves = np.empty((2 * len(table.orders), len(angle)))
    phase = table.orders[:, None] * angle
    np.cos(phase, out=waves[0::2])
    np.sin(phase, out=waves[1::2])
    total = np.zeros((table.width, len(angle)))
    for columns, factor, mine in table.parts:
        total[columns] = in_order(factor[:, :, None] * waves[mine, None])
    return total


def fastest_rate(couple: FloatArray, law: Law) -> FloatArray:
    """Bound (A,), rad/s, on every rate of the linear system z'' = -couple (K z + D z').

    A row-sum norm: a root obeys r^2 <= d r + k, so r <= sqrt(k) + d.
    """
    size = np.abs(couple)
    stiff = np.max(np.sum(size * law.spring, axis=1), axis=0)
    damped = np.max(np.sum(size * law.damper, axis=1), axis=0)
    return np.asarray(np.sqrt(stiff) + damped)


class GapSeries(NamedTuple):
    """Coefficients (DEGREE + 1, G, A) of the gaps, m, and (DEGREE, G, A) of the forces, N."""

    gap: FloatArray
    force: FloatArray


def motion_series(
    gap: FloatArray,
    velocity: FloatArray,
    law: Law,
    couple: FloatArray,
    push: FloatArray,
    duration: FloatArray,
    side_pull: FloatArray | None,
) -> GapSeries:
    """Series of every gap over a step of `duration` (A,), s.

    `gap`, `velocity` (G, A) at its start; `couple` (G, G, A); `push` (DEGREE - 1, G, A) the
    series in s of what accelerates the gaps besides their forces; `side_pull` (DEGREE - 1, A)
    that of tan(rod angle) over the piston mass, if the last gap is the bore.
    """
    gaps, members = gap.shape
    square = duration * duration
    push = push * (square * _FACTORIAL[: DEGREE - 1, None, None])
    if side_pull is not None:
        side_pull = side_pull * square
    damper = law.damper / duration
    # derivatives by s, z_k k!: with them every order has the same two matrices, springs and dampers
    pulling = square * np.stack([couple * law.spring, couple * damper])
    pulling = np.ascontiguousarray(pulling.swapaxes(1, 2).reshape(2 * gaps, gaps, members))
    z = np.empty((DEGREE + 1, gaps, members))
    z[0], z[1] = gap - law.free_position, velocity * duration
    terms, side = np.empty_like(pulling), np.empty((DEGREE - 1, members))
    for k in range(DEGREE - 1):
        np.multiply(pulling, z[k : k + 2].reshape(2 * gaps, 1, members), out=terms)
        np.subtract(push[k], np.add.reduce(terms, axis=0), out=z[k + 2])
        if side_pull is not None:
            side[k] = (law.spring[0] * z[k, 0] + damper[0] * z[k + 1, 0]) / _FACTORIAL[k]
            z[k + 2, -1] += _FACTORIAL[k] * in_order(side_pull[k::-1] * side[: k + 1])
    z /= _FACTORIAL[:, None, None]
    force = law.spring * z[:-1] + _RANK[:, None, None] * damper * z[1:]
    z[0] = gap
    return GapSeries(z, force)


# ----------------------------------------------------------------------------
# Harmonics of a force over one revolution from its moments on panels.
#
# On a panel of half width h around m, exp(-i n theta) is exp(-i n m) times a series of Chebyshev
# polynomials whose coefficients, Bessel functions of n h, die out faster than any power beyond n h.
# So the integrals of the force times the first MOMENTS of them, summed up while a run passes the
# panel, hold every harmonic to rounding, and the cost of a step does not depend on the number of
# orders.
# ----------------------------------------------------------------------------

#: Chebyshev polynomials kept: 2 J_28(5) is below 1e-18, see _HALF_PHASE
MOMENTS = 28
#: points of a Gauss rule that integrates force series times these, or two series, exactly
_COUNT = (DEGREE + MOMENTS) // 2 + 1
#: pieces whose moments are taken at once: their tables stay in the cache
_TOGETHER = 512

_nodes, _weights = np.polynomial.legendre.leggauss(_COUNT)
#: the rule on [0, 1], and the powers of its points (points, DEGREE + 1)
POINTS = 0.5 * (1.0 + _nodes)
WEIGHTS = 0.5 * _weights
POWERS = POINTS[:, None] ** np.arange(DEGREE + 1)


class Transform(NamedTuple):
    """`phase` (p, N + 1), `shape` (distinct widths, MOMENTS, N + 1), `kind` (p,) which width."""

    phase: ComplexArray
    shape: ComplexArray
    kind: IntArray


def make_transform(panels: Panels, highest_order: int) -> Transform:
    """Tables that take moments to harmonics of order 0 to `highest_order`."""
    orders = np.arange(highest_order + 1)
    middle = panels.start + 0.5 * panels.width
    phase = np.exp(-1j * np.outer(middle, orders)) / np.pi
    phase[:, 0] *= 0.5
    widths, kind = np.unique(np.round(panels.width, 13), return_inverse=True)
    count = MOMENTS + 24
    node = np.pi * (np.arange(count) + 0.5) / count
    rows = 2.0 / count * np.cos(np.outer(np.arange(MOMENTS), node))
    rows[0] *= 0.5
    shape = []
    for each in range(len(widths)):
        # panels of one kind differ by rounding; their moments count from the mean width
        half = 0.5 * np.mean(panels.width[kind == each])
        shape.append(rows @ np.exp(-1j * half * np.outer(np.cos(node), orders)))
    return Transform(phase, np.array(shape), np.asarray(kind.reshape(-1), dtype=np.int64))


def moments(
    force: FloatArray, offset: FloatArray, length: FloatArray, width: FloatArray
) -> FloatArray:
    """Moments (MOMENTS, n) of pieces of force with values (points, n) at POINTS, in N rad.

    A piece begins at `offset` (n,) from the start of its panel and is `length` (n,) long, the
    panel is `width` (n,) wide, all in rad.
    """
    found = np.empty((MOMENTS, force.shape[1]))
    for first in range(0, force.shape[1], _TOGETHER):
        some = slice(first, first + _TOGETHER)
        pull = force[:, some] * (WEIGHTS[:, None] * length[some])
        place = (offset[some] + length[some] * POINTS[:, None]) / (0.5 * width[some]) - 1.0
        np.sum(pull, axis=0, out=found[0, some])
        before, now, twice = np.ones_like(place), place, 2.0 * place
        for rank in range(1, MOMENTS):
            np.einsum("qn,qn->n", now, pull, out=found[rank, some])
            # Chebyshev polynomials: T_(k+1) = 2 x T_k - T_(k-1)
            following = twice * now
            following -= before
            before, now = now, following
    return found


def harmonics(values: FloatArray, transform: Transform) -> ComplexArray:
    """One-sided 0-to-peak harmonics (n, N + 1) of order 0 (the mean) to N, in N.

    `values` (n, p, MOMENTS) are the moments over one revolution, already in N rad.
    """
    count, orders = len(values), transform.phase.shape[1]
    total = np.zeros((count, orders), dtype=np.complex128)
    for each in range(len(transform.shape)):
        mine = transform.kind == each
        rows = np.swapaxes(values[:, mine], 1, 2).reshape(count * MOMENTS, -1)
        # real times complex, as one real product
        turned = (rows @ transform.phase[mine].view(np.float64)).view(np.complex128)
        total += np.einsum(
            "nmk,mk->nk", turned.reshape(count, MOMENTS, orders), transform.shape[each]
        )
    return total


# ----------------------------------------------------------------------------
# Everything about a batch that stays the same while it runs.
# ----------------------------------------------------------------------------

#: steps of one run in one revolution that count as no progress
MOST_STEPS = 200_000


class Setup(NamedTuple):
    """Machine, crank-angle panels and tables; `rate_couple` (G, G, B) bounds all couplings.

    `laws` (5, 3, G, B) are the force laws in the lower contact, free and in the upper contact;
    `pin` has the velocity Y' of the pin in its column 0 and the angle series of Y'' in the others,
    `tangent` the angle series of tan(rod angle).
    """

    train: Train
    laws: FloatArray
    speed: float
    panels: Panels
    pin: DriveTable
    tangent: DriveTable | None
    rate_couple: FloatArray
    transform: Transform
    pin_velocity_at_start: float


def make_setup(
    train: Train, drive: Drive, gas: GasForce, highest_order: int, subdivision: int = 1
) -> Setup:
    """Tables of a batch. Raises NumericalFailure for a drive of too many harmonics."""
    tangent, rate_couple = None, np.abs(train.couple)
    if drive.tangent_orders is not None and drive.rod_tangent is not None:
        tangent = _table(drive.tangent_orders, _rising(drive.tangent_orders, drive.rod_tangent))
        # the bound on |tan| of the rod angle; a sum of harmonics is never above that of sizes
        rate_couple[train.bore, 0] = np.sum(np.abs(drive.rod_tangent)) / train.mass
    panels = make_panels(drive, gas, highest_order, subdivision)
    rate = 1j * drive.orders * drive.speed
    velocity = drive.displacement * rate
    pin = _table(drive.orders, [velocity, *_rising(drive.orders, velocity * rate)])
    shape = train.gaps.clearance.shape
    laws = [law_of(train.gaps, np.full(shape, side)) for side in (LOWER, FREE, UPPER)]
    return Setup(
        train,
        np.stack([np.stack(law) for law in laws], axis=1),
        drive.speed,
        panels,
        pin,
        tangent,
        rate_couple,
        make_transform(panels, highest_order),
        float(drive_series(pin, np.zeros(1))[0, 0]),
    )
