"""Steady response of a shaft line at all speeds and orders at once, and what its elements carry."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, bounded, reshaped, rounded, square, where
from vibecalc.numerics.rounding import (
    EPSILON,
    SINGULAR,
    UNIT_ROUNDOFF,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
)
from vibecalc.numerics.synthesis import over_cycle
from vibecalc.torsion.elimination import LineSolution, eliminate, plan_of, room_for
from vibecalc.torsion.line import (
    Line,
    complex_stiffness,
    damping_matrix,
    dynamic_stiffness,
    free_parts,
    mapped,
    network_matrix,
    part_of,
    spring_twists,
    stiffness_matrix,
    walk,
)
from vibecalc.torsion.modes import Modes
from vibecalc.torsion.network import network_solution

#: entries (station times frequency) of one block at most: with fewer frequencies along a long line
#: the calls take longer than the arithmetic
BLOCK = 1 << 24

#: frequencies of one block, at most
LONGEST = 8192

#: the same of a network, that is solved several times, frequencies of a block of it at least, and
#: entries of the matrices of dense solves
NETWORK, LEAST, ENTRIES = 1 << 17, 64, 1 << 17

#: places along each axis at which the size of a torque is examined
SAMPLES = 16

#: with a relative error above this a frequency is solved again
UNCERTAIN = 7e-10


class ForcedResponse(NamedTuple):
    """Angles (..., n) in rad, complex, 0-to-peak, and their absolute error (...), over stations.

    The error bounds the round-off for the line, frequency and torques as given. It is empty (size
    0) where no estimate was asked for. Stations are the slowest axis in memory.
    """

    angle: ComplexArray
    error: FloatArray


class MaskedResponse(NamedTuple):
    """As `ForcedResponse`; `masked` (...) where there is none: angle 0, error infinite."""

    angle: ComplexArray
    error: FloatArray
    masked: BoolArray


def forced(
    line: Line,
    frequency: ArrayLike,
    torque: ArrayLike,
    *,
    stations: Sequence[int] | None = None,
    estimate: bool = True,
) -> ForcedResponse:
    """Steady angles of all stations.

    Parameters
    ----------
    line : Line
        Any network; trees by one elimination, loops by several. Leading axes go with frequency.
    frequency : array (...)
        In rad/s, 0 or above.
    torque : complex array (..., n)
        In N m, 0-to-peak, x(t) = Re(X exp(i w t)). Axes in front of those of `frequency` are
        several torques at the same frequencies: factorised once.
    stations : sequence of int, optional
        The stations that the last axis of `torque` stands for; without it all of them.
    estimate : bool
        Without it no error is formed (half the time); frequencies where elimination grew by 1e4
        or more are solved with it all the same, and what is singular is still refused.

    Raises
    ------
    NumericalFailure
        Some frequency is at a resonance without damping to within four digits, or is zero with
        torques on a free line that do not balance. Balanced ones leave a twist; the angles then
        have a mean of zero, weighted with inertia (the limit of low frequency).
    """
    masked = forced_masked(line, frequency, torque, stations=stations, estimate=estimate)
    if np.any(masked.masked):
        w = np.broadcast_to(np.asarray(frequency, dtype=float), masked.masked.shape)
        first = float(w[masked.masked][0])
        why = (
            "the torques on a line that is free to turn do not balance"
            if first == 0.0
            else "it is a natural frequency of the line, and nothing there damps it"
        )
        raise NumericalFailure(
            f"forced torsional response: no steady response at {first:.12g} rad/s: {why}"
        )
    return ForcedResponse(masked.angle, masked.error)


def forced_masked(
    line: Line,
    frequency: ArrayLike,
    torque: ArrayLike,
    *,
    stations: Sequence[int] | None = None,
    estimate: bool = True,
    dense: bool = False,
) -> MaskedResponse:
    """As `forced` for a range of frequencies: what is singular is masked instead of refused.

    `dense` asks for a full solve with pivoting at each frequency, where elimination would do.
    """
    w, load = np.asarray(frequency, dtype=float), np.asarray(torque, dtype=np.complex128)
    n = line.inertia.shape[-1]
    leading = np.broadcast_shapes(*(one.shape[:-1] for one in (line.inertia, line.stiffness)))
    extra = max(load.ndim - 1 - max(w.ndim, len(leading)), 0)
    shape = np.broadcast_shapes(w.shape, leading, load.shape[extra:-1])
    several = load.shape[:extra]
    count, copies = math.prod(shape), math.prod(several)
    if not count:  # no frequency is asked for, as of a range without a peak
        none = np.zeros((*several, *shape, n), dtype=np.complex128)
        return MaskedResponse(none, none[..., 0].real, none[..., 0] != 0.0)
    flat = _flat_line(line, shape)
    flat_w = np.broadcast_to(w, shape).reshape(count)
    loads: list[ComplexArray | None] = [None] * n
    flat_load, sizes = _flat_loads(load, several, shape)
    heaviest = np.zeros(n)
    for one, size_of, i in zip(
        flat_load, sizes.tolist(), range(n) if stations is None else stations, strict=True
    ):
        if size_of or np.any(one):
            # stations that a rigid gear joins are one
            before = loads[i]
            loads[i] = one if before is None else before + one
            heaviest[i] += size_of
    angle = np.empty((n, copies, count), dtype=np.complex128)
    error, largest = np.zeros((copies, count)), np.zeros((copies, count))
    growth = np.full(count, True)
    # as the root it needs no torque carried down to it; which one it is need not be known exactly
    root = int(np.argmax(heaviest))
    plan = None if dense else plan_of(line, root, shape)
    if plan is not None:
        size = max(1, min(LONGEST, BLOCK // n) // copies)
        # blocks of one length: a short last one would cost as many calls as the others
        size = max(1, -(-count // max(1, -(-count // size))))
        room = room_for(plan, [one is not None for one in loads], size, estimate)
        for start in range(0, count, size):
            part = slice(start, min(start + size, count))
            block, place = _of_rows(loads, part), angle[..., part]
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                solution = eliminate(plan.cut(part), flat_w[part], block, estimate, place, room)
            if estimate:
                error[:, part], largest[:, part] = solution.error, solution.largest
            else:
                growth[part] = solution.growth
        if estimate:
            growth = np.any(~(error <= UNCERTAIN * largest), axis=0)
        else:
            error[:, growth] = np.inf
    again = np.flatnonzero(growth)
    # where elimination along a tree loses digits, and of what is no tree
    method = dense_solution if dense else network_solution
    size = (ENTRIES // (n * n) if dense else max(LEAST, NETWORK // n)) // copies + 1
    for start in range(0, len(again), size):
        few = again[start : start + size]
        place = np.empty((n, copies, len(few)), dtype=np.complex128)
        with np.errstate(all="ignore"):
            found = method(
                mapped(flat, partial(_rows, rows=few)), flat_w[few], _of_rows(loads, few), place
            )
        known = error[:, few] if plan is not None else np.full((copies, len(few)), np.inf)
        better = ~(known <= found.error)
        angle[..., few] = np.where(better, found.angle, angle[..., few])
        error[:, few] = np.where(better, found.error, known)
        largest[:, few] = np.where(better, found.largest, largest[:, few])
    masked = np.zeros((copies, count), dtype=bool)
    uncertainty = ~(error[:, again] < SINGULAR * largest[:, again])
    masked[:, again] = uncertainty & ~((error[:, again] == 0.0) & (largest[:, again] == 0.0))
    still = np.flatnonzero(flat_w == 0.0)
    if len(still):
        angle[..., still] = _without_turning(flat, angle[..., still], slice(0, count), still)
    if np.any(masked):
        angle[:, masked] = 0.0
        error[masked] = np.inf
    whole = (*several, *shape)
    reported = np.reshape(error, whole) if estimate else np.zeros(0)
    by_station = np.moveaxis(angle.reshape(n, *whole), 0, -1)
    return MaskedResponse(by_station, reported, masked.reshape(whole))


def _without_turning(line: Line, angle: ComplexArray, part: slice, still: IntArray) -> ComplexArray:
    """Angles (n, r, f) at rest, less the mean of each part that nothing holds."""
    joined = (line.stiffness != 0.0) | (line.damping != 0.0)
    group = part_of(line, np.any(joined, axis=tuple(range(joined.ndim - 1))))
    for one in set(group.tolist()):
        inside = np.flatnonzero(group == one)
        inertia = line.inertia[..., inside]
        if inertia.ndim > 1:
            inertia = inertia[part][still]
        if np.any(line.ground_stiffness[..., inside]) or not np.all(inertia.sum(axis=-1)):
            continue
        weight = (inertia / inertia.sum(axis=-1, keepdims=True)).T
        weight = weight.reshape(len(inside), 1, -1)
        angle[inside] -= np.sum(weight * angle[inside], axis=0)
    return angle


def _flat_line(line: Line, shape: tuple[int, ...]) -> Line:
    """Values with leading axes as one flat axis; those without stay as they are."""

    def flat(values: FloatArray) -> FloatArray:
        if values.ndim == 1:
            return values
        return np.broadcast_to(values, (*shape, values.shape[-1])).reshape(-1, values.shape[-1])

    return mapped(line, flat)


def _flat_loads(
    load: ComplexArray, several: tuple[int, ...], shape: tuple[int, ...]
) -> tuple[ComplexArray, FloatArray]:
    """Torques (..., k) as (k, r, f) or (k, r, 1), and the largest of each among some of them."""
    copies, count = math.prod(several), load.shape[-1]
    if load.size == copies * count and load.shape[: len(several)] == several:
        whole = load
    else:
        whole = np.broadcast_to(load, (*several, *shape, count))
    flat = np.moveaxis(whole, -1, 0).reshape(count, copies, -1)
    _, across, along = (1 + size // SAMPLES for size in flat.shape)
    return flat, np.max(np.abs(flat[:, ::across, ::along]), axis=(1, 2), initial=0.0)


def _rows(values: FloatArray, rows: IntArray) -> FloatArray:
    return values[rows] if values.ndim > 1 else values


def _of_rows(loads: list[ComplexArray | None], rows: IntArray | slice) -> list[ComplexArray | None]:
    return [one if one is None or one.shape[1] == 1 else one[:, rows] for one in loads]


# ----------------------------------------------------------------------------
# Damping of a line seen from its undamped modes, and whether it leaves them uncoupled.
# ----------------------------------------------------------------------------

#: coupling between modes, as a share of their own damping, that still counts as round-off
UNCOUPLED = 1e-9


class ModalDamping(NamedTuple):
    """Dashpots (m,) in N m s/rad and loss (m,) in N m/rad of each mode, and their coupling.

    `coupling` is the largest share |d_rs| / sqrt(d_rr d_ss) of either kind that couples two modes;
    0 for proportional damping.
    """

    dashpot: FloatArray
    loss: FloatArray
    coupling: float


def modal_damping(line: Line, shape: ArrayLike) -> ModalDamping:
    """Damping of a line seen from modes of shape (m, n)."""
    modes = np.asarray(shape, dtype=float)
    loss = network_matrix(line, line.stiffness * line.loss_factor, np.zeros_like(line.inertia))
    ratios, coupling = [], 0.0
    for matrix in (damping_matrix(line), loss):
        between = modes @ matrix @ modes.T
        diagonal = np.diagonal(between).copy()
        coupled = np.abs(between - np.diag(diagonal))
        # round-off of the triple product, in what is added up
        coupled -= 8.0 * EPSILON * (np.abs(modes) @ np.abs(matrix) @ np.abs(modes).T)
        scale = np.sqrt(np.outer(np.abs(diagonal), np.abs(diagonal)))
        share = np.where(scale > 0.0, coupled / np.where(scale > 0.0, scale, 1.0), 0.0)
        coupling = max(coupling, float(np.max(share, initial=0.0)))
        ratios.append(diagonal)
    return ModalDamping(ratios[0], ratios[1], coupling)


# ----------------------------------------------------------------------------
# Forced response as a sum over undamped modes that nothing couples, each with its own damping.
# ----------------------------------------------------------------------------


class ModalLine(NamedTuple):
    """Modes with dashpot (m,) in N m s/rad and loss (m,) in N m/rad, of their modal inertia."""

    modes: Modes
    dashpot: FloatArray
    loss: FloatArray


def modal_line(
    modes: Modes, *, ratios: FloatArray | None = None, line: Line | None = None
) -> ModalLine:
    """From damping ratios (m,), 2 ratio modal inertia frequency, or from the damping of a line.

    Raises NumericalFailure for a line whose damping couples the modes.
    """
    if line is None:
        given = np.zeros(len(modes.frequency)) if ratios is None else ratios
        return ModalLine(modes, 2.0 * given * modes.modal_inertia * modes.frequency, 0.0 * given)
    found = modal_damping(line, modes.shape)
    if found.coupling > UNCOUPLED:
        raise NumericalFailure(
            f"modal response: damping couples the undamped modes (by {found.coupling:.2g} of "
            "their own damping), so that a sum over modes is not the response; use elimination"
        )
    return ModalLine(modes, found.dashpot, found.loss)


def ratio_response(
    modal: ModalLine, frequency: FloatArray, torque: ComplexArray, freedom: IntArray
) -> MaskedResponse:
    """Angles (..., n) for torques (..., k) on k freedoms at frequencies (...) in rad/s.

    A frequency on a mode that is driven and not damped, to within four digits, is masked. The
    error counts the rounding of the sum and the errors of frequencies and shapes.
    """
    modes, w = modal.modes, np.asarray(frequency)[..., None]
    natural, inertia = modes.frequency, modes.modal_inertia
    at_freedom = modes.shape[:, freedom]
    drive = torque @ at_freedom.T
    size = np.abs(torque).sum(axis=-1, keepdims=True)
    drive_uncertainty = size * (
        8.0 * EPSILON * np.max(np.abs(at_freedom), axis=1) + modes.shape_error
    )
    stiffness = inertia * (natural - w) * (natural + w) + 1j * (w * modal.dashpot + modal.loss)
    uncertainty = 8.0 * EPSILON * np.abs(stiffness)
    uncertainty = uncertainty + 2.0 * inertia * (natural * modes.frequency_error + EPSILON * w**2)
    weak = np.abs(stiffness) * SINGULAR <= uncertainty
    driven = np.abs(drive) > drive_uncertainty
    masked = np.any(weak & driven, axis=-1)
    stiffness = np.where(weak, 1.0, stiffness)
    part = np.where(weak, 0.0, drive / stiffness)
    angle = np.asarray(part @ modes.shape, dtype=np.complex128)
    slack = (drive_uncertainty + np.abs(part) * uncertainty) / np.abs(stiffness)
    slack = slack + np.abs(part) * (8.0 * EPSILON + modes.shape_error)
    error = np.sum(np.where(weak, 0.0, slack), axis=-1)
    angle[masked] = 0.0
    return MaskedResponse(angle, np.where(masked, np.inf, error), masked)


# ----------------------------------------------------------------------------
# Forced response by dense elimination with pivoting: any network, loops too, and as a check.
# ----------------------------------------------------------------------------

#: roundings of a row's sum in the residual, for the few elements that meet at a station
DENSE_ROUNDINGS = 16.0 * EPSILON


def dense_solution(
    line: Line,
    frequency: FloatArray,
    torque: list[ComplexArray | None],
    angle: ComplexArray,
) -> LineSolution:
    """As `eliminate`, by inverting the dynamic stiffness; one step of refinement.

    The error is |inverse| (|residual| + round-off of data and residual), row by row. Frequencies
    whose matrix is singular have an infinite error.
    """
    n, copies, count = angle.shape
    matrix = dynamic_stiffness(line, frequency)
    load = np.zeros((count, n, copies), dtype=np.complex128)
    for i, one in enumerate(torque):
        if one is not None:
            load[:, i, :] = np.broadcast_to(one, (copies, count)).T
    # one scale for each station makes stiff and soft stations alike
    scale = np.sqrt(np.max(np.abs(matrix), axis=-1))
    scale = np.where(
        scale > 0.0, np.exp2(np.round(np.log2(np.where(scale > 0.0, scale, 1.0)))), 1.0
    )
    scaled = matrix / (scale[:, :, None] * scale[:, None, :])
    inverse, singular = _inverse(scaled)
    right = load / scale[..., None]
    solution = inverse @ right
    solution += inverse @ (right - scaled @ solution)
    size, right_size = np.abs(scaled), np.abs(right)
    if np.any(frequency == 0.0):
        _held(line, frequency, scaled, right, inverse, solution, singular)
    residual = np.abs(right - scaled @ solution)
    data = _data_size(line, frequency) / (scale[:, :, None] * scale[:, None, :])
    uncertainty = residual + DENSE_ROUNDINGS * ((size + data) @ np.abs(solution) + right_size)
    error = np.abs(inverse) @ uncertainty / scale[..., None]
    angle[...] = (solution / scale[..., None]).transpose(1, 2, 0)
    angle[:, :, singular] = 0.0
    largest = np.max(np.abs(angle), axis=0)
    worst = np.max(error, axis=1).T + 2.0 * EPSILON * largest
    worst[:, singular] = np.inf
    worst[~np.isfinite(worst)] = np.inf
    return LineSolution(angle, worst, np.zeros(count, dtype=bool), largest)


def _data_size(line: Line, frequency: FloatArray) -> FloatArray:
    """Sizes of what is added up on the diagonal: cancelling sums lose that much."""
    n = line.inertia.shape[-1]
    w = frequency[:, None]
    diagonal = np.abs(line.ground_stiffness) + w**2 * line.inertia + w * line.absolute_damping
    element = line.stiffness * (1.0 + np.abs(line.loss_factor)) + w * line.damping
    diagonal = np.broadcast_to(diagonal, (len(frequency), n)).copy()
    for e, (a, b) in enumerate(zip(line.first, line.second, strict=True)):
        diagonal[:, a] += element[:, e]
        diagonal[:, b] += element[:, e]
    return diagonal[:, :, None] * np.eye(n)


def _inverse(matrix: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Inverses, zero for the exactly singular ones, and which those are."""
    singular: BoolArray = np.zeros(len(matrix), dtype=np.bool_)
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.complex128), singular
    except np.linalg.LinAlgError:
        inverse = np.zeros_like(matrix)
        for i, one in enumerate(matrix):
            try:
                inverse[i] = np.linalg.inv(one)
            except np.linalg.LinAlgError:
                singular[i] = True
    return inverse, singular


def _held(
    line: Line,
    frequency: FloatArray,
    matrix: ComplexArray,
    right: ComplexArray,
    inverse: ComplexArray,
    solution: ComplexArray,
    singular: BoolArray,
) -> None:
    """At rest: the least twist that meets balanced torques, where a piece is free to turn."""
    if np.all(np.any(line.ground_stiffness, axis=-1)):
        return
    for i in np.flatnonzero(frequency == 0.0).tolist():
        inverse[i] = np.linalg.pinv(matrix[i], rcond=1e-12, hermitian=False)
        solution[i] = inverse[i] @ right[i]
        left = np.abs(right[i] - matrix[i] @ solution[i])
        size = np.abs(matrix[i]) @ np.abs(solution[i]) + np.abs(right[i])
        singular[i] = bool(np.any(left > 1e-10 * np.max(size)))


#: of a complex stiffness
STIFFNESS_ROUNDINGS = 4.0

# ----------------------------------------------------------------------------
# Torque of the elements of a shaft line, and the largest half range against speed.
# ----------------------------------------------------------------------------


def twist_and_torque(line: Line, frequency: ArrayLike, angle: Bounded) -> tuple[Bounded, Bounded]:
    """Twists phi[first] - phi[second] in rad and torques in N m, (..., e), complex, 0-to-peak.

    From angles (..., n) at frequencies (...) in rad/s. The twist of a shaft much stiffer than what
    it drives is a small difference of angles: its relative error is large then, and counted.
    """
    twist = angle[..., line.first] - angle[..., line.second]
    stiffness = complex_stiffness(line, np.asarray(frequency, dtype=float))
    return twist, rounded(stiffness, STIFFNESS_ROUNDINGS) * twist


#: speeds of one block of `largest_half_range`
ROWS = 64


def largest_half_range(
    line: Line,
    order: FloatArray,
    torque: Callable[[FloatArray], ComplexArray],
    stations: Sequence[int],
    weight: FloatArray,
    speed: FloatArray,
    *,
    of_twist: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Largest weighted half range (s,) of torque or twist at speeds (s,) in rad/s, and its error.

    `torque` gives for speeds (s,) the torques (s, m, k) in N m of the orders (m,) on k `stations`;
    elements whose `weight` (e,) is zero do not count. Infinite where nothing damps an order.
    """
    counts = np.flatnonzero(weight > 0.0)
    value, error = np.empty(len(speed)), np.zeros(len(speed))
    for start in range(0, len(speed), ROWS):
        part = slice(start, start + ROWS)
        frequency = speed[part, None] * order
        solved = forced_masked(line, frequency, torque(speed[part]), stations=stations)
        uncertainty = np.where(solved.masked, 0.0, solved.error)[..., None]
        both = twist_and_torque(line, frequency, Bounded(solved.angle, uncertainty))
        wave = reshaped(
            both[0 if of_twist else 1][..., counts], lambda one: np.moveaxis(one, 1, -1)
        )
        half = weight[counts] * over_cycle(order, wave).half_range
        masked = np.any(solved.masked, axis=-1)
        value[part], error[part] = where(masked, np.inf, half.max())
    return value, error


# ----------------------------------------------------------------------------
# Steady torque that the elements of a line carry, from the mean torques at its freedoms.
# ----------------------------------------------------------------------------


#: of a stiffness, and of sums of a few torques
SHARE_ROUNDINGS = 4.0


def steady_shares(line: Line) -> Bounded:
    """Torque (e, n) of each element for a mean torque of one at each freedom of a line at rest.

    With mean torques M (n,) that balance, shares @ M is k (phi[first] - phi[second]). In a tree
    that nothing holds, or one spring to ground, which has nothing to carry then, equilibrium alone
    tells it (shares of 0 and 1, without rounding), else the stiffnesses do. An element without
    stiffness carries nothing.
    """
    count, elements = len(line.inertia), len(line.stiffness)
    neighbours: dict[int, dict[int, int]] = {station: {} for station in range(count)}
    springs = np.flatnonzero(line.stiffness).tolist()
    for e in springs:
        a, b = int(line.first[e]), int(line.second[e])
        neighbours[a][b] = neighbours[b][a] = e
    above: dict[int, int] = {}
    for root in range(count):
        if root not in above:
            above |= walk(neighbours, root)
    held = np.count_nonzero(line.ground_stiffness)
    if len(springs) > sum(parent >= 0 for parent in above.values()) or held > 1:
        return _shares_by_stiffness(line)
    below = np.eye(count)
    shares = np.zeros((elements, count))
    for station, parent in reversed(above.items()):
        if parent >= 0:
            # what stands below an element is kept in balance by it
            edge = neighbours[station][parent]
            shares[edge] = below[station] * (1.0 if line.first[edge] == station else -1.0)
            below[parent] += below[station]
    return bounded(shares)


def _shares_by_stiffness(line: Line) -> Bounded:
    """The same where loops or several springs to ground share the torques.

    With shares S of all springs, whose twists the rows D read, torques t that lack equilibrium by r
    are off by S r; a torque that comes out wrong, or by another stiffness, by d in one spring alone
    leaves (1 - S D^T) d: nothing in springs outside of loops.
    """
    rows, stiffness = spring_twists(line)
    parts = free_parts(line, line.stiffness != 0.0)
    load = np.eye(rows.shape[1]) - parts.T @ (parts / parts.sum(axis=1, keepdims=True))
    shares = stiffness[:, None] * (rows @ np.linalg.pinv(stiffness_matrix(line), hermitian=True))
    shares = shares + shares @ (load - rows.T @ shares)
    size, lost = np.abs(shares), SHARE_ROUNDINGS * UNIT_ROUNDOFF
    left = np.abs(load - rows.T @ shares) + lost * (np.abs(load) + np.abs(rows.T) @ size)
    round_loops = np.abs(np.eye(len(rows)) - shares @ rows.T)
    error = size @ left + round_loops @ (lost * size)
    return Bounded(shares, error)[: line.stiffness.size]


# ----------------------------------------------------------------------------
# Mean power that the dashpots and loss factors of a shaft line turn into heat.
# ----------------------------------------------------------------------------


def ground_heat(line: Line, frequency: FloatArray, angle: Bounded) -> Bounded:
    """Mean power (..., n) of absolute damping in W, w^2 c |angle|^2 / 2."""
    return 0.5 * frequency[..., None] ** 2 * line.absolute_damping * square(abs(angle))
