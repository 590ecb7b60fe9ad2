"""Gas pressure over a cycle or gas force over a turn, from tables: piecewise polynomials."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Pressure cards: the gas pressure in a cylinder against its own crank angle, over one cycle.
#
# A cycle is 4 pi of crank angle in four-stroke and 2 pi in two-stroke. The angle counts from the
# cylinder's own firing position, where the crank lies along the cylinder (top dead centre if the
# wrist pin has no offset). Pressures are gauge: above that in the crankcase, under the piston.
# ----------------------------------------------------------------------------

FOUR_STROKE = 4.0 * np.pi
TWO_STROKE = 2.0 * np.pi
#: degree of the pieces that stand for a formula, and panels at most on one of its intervals
DEGREE = 9
MOST_PANELS = 1024
#: a fit is accurate enough where it misses the formula by less than this share of the largest value
FIT_TOLERANCE = 1e-13
#: roundings of a formula with two powers of volumes
FORMULA_ROUNDINGS = 16.0


class GasCard(NamedTuple):
    """Periodic gauge pressure, piecewise polynomial.

    On piece i, between `node[i]` and `node[i + 1]` (m + 1,) in rad, it is
    sum_k coefficient[i, k] (angle - node[i])^k in Pa, coefficients (m, d + 1). The last node is the
    first one a `cycle` later. `error` (m,) is how far each piece may be off what it stands for, Pa.
    """

    node: FloatArray
    coefficient: FloatArray
    cycle: float
    error: FloatArray


def gas_card(
    angle: ArrayLike,
    pressure: ArrayLike,
    interpolation: str = "linear",
    *,
    cycle: float,
    crankcase_pressure: float = 0.0,
) -> GasCard:
    """A card through a table over one cycle, from any angle, whose last row repeats the first.

    Parameters
    ----------
    angle, pressure : (m + 1,) in rad, ascending, and Pa.
    interpolation
        "linear": straight lines. "cubic": the periodic cubic spline. "monotone": cubics that
        never leave the range of the two values at their ends (Fritsch and Butland 1984).
    cycle
        4 pi or 2 pi.
    crankcase_pressure
        Subtracted from every pressure; zero where the table is gauge already.
    """
    nodes = np.array(angle, dtype=float)
    nodes[-1] = nodes[0] + cycle
    values = np.array(pressure, dtype=float) - crankcase_pressure
    values[-1] = values[0]
    polynomials = _INTERPOLANTS[interpolation](nodes, values)
    return GasCard(nodes, polynomials, float(cycle), np.zeros(len(polynomials)))


def fitted_card(
    pressure: Callable[[FloatArray], FloatArray], breakpoints: Sequence[float], cycle: float
) -> GasCard:
    """A card for a formula: polynomials of degree 9 on as many panels as it takes.

    Parameters
    ----------
    pressure
        Gauge pressure, Pa, at angles in rad; smooth between the breakpoints.
    breakpoints
        (b + 1,) ascending angles in rad, the last one a cycle after the first. Each interval is cut
        into equal panels, twice as many until the fit agrees with the formula between its points.

    Raises
    ------
    NumericalFailure
        More than 1024 panels on one interval: the formula is not smooth there.
    """
    ends = np.asarray(breakpoints, dtype=float)
    points = 0.5 - 0.5 * np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    between = 0.5 * (points[1:] + points[:-1])
    powers = np.arange(DEGREE + 1)
    to_points, to_between = points[:, None] ** powers, between[:, None] ** powers
    scale = float(np.max(np.abs(pressure(np.linspace(ends[0], ends[-1], 4 * 64 * len(ends))))))
    nodes, polynomials, errors = [], [], []
    for low, high in pairwise(ends.tolist()):
        panels = 4
        while True:
            start, width = np.linspace(low, high, panels, endpoint=False), (high - low) / panels
            values = pressure(start[:, None] + width * points)
            fit = np.linalg.solve(to_points, values.T).T
            exact = pressure(start[:, None] + width * between)
            off = np.abs(fit @ to_between.T - exact).max(axis=1)
            worst = float(off.max())
            if worst <= FIT_TOLERANCE * scale:
                break
            if panels >= MOST_PANELS:
                raise NumericalFailure(
                    f"gas card: the pressure between {low:.6g} and {high:.6g} rad cannot be "
                    f"followed by {panels} polynomials of degree {DEGREE}; it is off by "
                    f"{worst:.3g} Pa; the formula has to be smooth there"
                )
            panels *= 2
        nodes.append(start)
        polynomials.append(fit / width**powers)
        # the formula itself is rounded, and between the points examined the fit may be worse
        size = np.abs(exact).max(axis=1)
        errors.append(2.0 * off + FORMULA_ROUNDINGS * EPSILON * size + EPSILON * scale)
    node = np.concatenate([*nodes, [ends[0] + cycle]])
    card = GasCard(node, np.concatenate(polynomials), float(cycle), np.concatenate(errors))
    for array in (card.node, card.coefficient, card.error):  # those who ask for it may share it
        array.flags.writeable = False
    return card


def pressure_at(card: GasCard, angle: ArrayLike) -> FloatArray:
    """Gauge pressure in Pa at the cylinder's own angles, rad, of any cycle."""
    place, away = _piece(card, angle)
    return _height(card.coefficient[place], away)


def _piece(card: GasCard, angle: ArrayLike) -> tuple[IntArray, FloatArray]:
    """Places (...) of the pieces that angles (...) are on, and how far from their nodes, rad."""
    turned = card.node[0] + np.mod(np.asarray(angle, dtype=float) - card.node[0], card.cycle)
    place = np.clip(
        np.searchsorted(card.node, turned, side="right") - 1, 0, len(card.coefficient) - 1
    )
    return place, np.asarray(turned - card.node[place])


def _height(rows: FloatArray, away: FloatArray) -> FloatArray:
    """Polynomials (...) of the coefficients (..., d + 1), the constant first."""
    value = rows[..., -1]
    for power in range(rows.shape[-1] - 2, -1, -1):
        value = value * away + rows[..., power]
    return np.asarray(value)


#: by how much, relative, a value may be beyond the cards and still be that of the last one
ROUNDED = 1e-12


def within_cards(known: ArrayLike, value: ArrayLike) -> BoolArray:
    """Whether cards at values (c,), in any order, cover positive values (...) but for roundings."""
    low, high = np.min(known) * (1.0 - ROUNDED), np.max(known) * (1.0 + ROUNDED)
    return np.asarray((np.asarray(value) >= low) & (np.asarray(value) <= high))


def card_weights(card_value: ArrayLike, value: ArrayLike) -> FloatArray:
    """Weights (..., c) of c cards taken at ascending speeds (or loads) at the values (...) asked.

    Speeds are in rad/s. Linear between two neighbours. The torque is linear in the pressure, so
    that the same weights hold for its harmonics. A single card holds at every value, one at an end
    also for what is beyond it by roundings, as of values in other units.

    Raises
    ------
    NumericalFailure
        A value beyond the range of the cards: nothing is extrapolated.
    """
    known = np.asarray(card_value, dtype=float)
    asked = np.asarray(value, dtype=float)
    if len(known) == 1:
        return np.ones((*asked.shape, 1))
    outside = ~within_cards(known, asked)
    if np.any(outside):
        turns = convert(1.0, "rad/s", "rpm")
        raise NumericalFailure(
            f"gas cards: {turns * np.extract(outside, asked)[0]:.6g} rpm lies outside the cards' "
            f"range, {turns * known[0]:.6g} to {turns * known[-1]:.6g} rpm; give a card at or "
            "beyond that speed"
        )
    asked = np.clip(asked, known[0], known[-1])
    upper = np.clip(np.searchsorted(known, asked, side="left"), 1, len(known) - 1)
    share = (asked - known[upper - 1]) / (known[upper] - known[upper - 1])
    index = np.arange(len(known))
    above = np.where(index == upper[..., None], share[..., None], 0.0)
    below = np.where(index == upper[..., None] - 1, 1.0 - share[..., None], 0.0)
    return np.asarray(above + below)


def straight(node: FloatArray, value: FloatArray) -> FloatArray:
    """Coefficients (m, 2) of straight lines between values (m + 1,) at nodes."""
    return np.stack([value[:-1], np.diff(value) / np.diff(node)], axis=1)


def _cubic(node: FloatArray, value: FloatArray) -> FloatArray:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(node, value, bc_type="periodic").c[::-1].T)


def _parabola(node: FloatArray, value: FloatArray) -> FloatArray:
    step = np.diff(node)
    slope = np.diff(value) / step
    bend = (slope - np.roll(slope, 1)) / (step + np.roll(step, 1))
    return np.stack([value[:-1], slope - bend * step, bend], axis=1)


def _monotone(node: FloatArray, value: FloatArray) -> FloatArray:
    """Hermite pieces with slopes that are weighted harmonic means, zero at every extreme."""
    step = np.diff(node)
    secant = np.diff(value) / step
    before, width = np.roll(secant, 1), np.roll(step, 1)
    same = before * secant > 0.0
    near, far = 2.0 * step + width, step + 2.0 * width
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (near + far) / (near / before + far / secant)
    slope = np.where(same, mean, 0.0)
    after = np.roll(slope, -1)
    square = (3.0 * secant - 2.0 * slope - after) / step
    cube = (slope + after - 2.0 * secant) / step**2
    return np.stack([value[:-1], slope, square, cube], axis=1)


_INTERPOLANTS = {
    "linear": straight,
    "parabola": _parabola,
    "cubic": _cubic,
    "monotone": _monotone,
}

# ----------------------------------------------------------------------------
# Force of the gas on a piston over one turn of its crank, from a table: piecewise polynomials.
#
# Positive pushes the piston towards the crank. Herold (1977) gives such tables every 10 degrees and
# runs the parabola of `parabola` through them (NLFGEN of his program).
# ----------------------------------------------------------------------------

TURN = 2.0 * np.pi


class GasForce(NamedTuple):
    """A periodic curve: m pieces from each `node` (m,) of [0, 2 pi) on, or harmonics.

    On piece i the force is sum_k coefficient[i, k] (angle - node[i])^k in N; the last piece runs
    on to the first node of the next turn. With `harmonics` (n + 1,), one-sided and complex, it is
    Re sum_k harmonics[k] exp(i k angle) instead, and there are no nodes.
    """

    node: FloatArray
    coefficient: FloatArray
    harmonics: ComplexArray


FORCE_INTERPOLATIONS = ("linear", "parabola", "cubic", "trigonometric")


def gas_force(angle: ArrayLike, force: ArrayLike, interpolation: str) -> GasForce:
    """A curve through a table over one turn, whose last row repeats the first.

    Parameters
    ----------
    angle, force : (m + 1,) in rad, ascending, and N.
    interpolation
        As of `gas_card`. "parabola": on each interval the parabola through its ends and the node
        before it. "trigonometric": the trigonometric polynomial of least degree; its nodes have to
        be evenly spaced.

    Raises
    ------
    ValueError
        "trigonometric" with nodes that are not evenly spaced.
    """
    angle, force = np.asarray(angle, dtype=float), np.asarray(force, dtype=float)
    if interpolation == "trigonometric":
        return GasForce(np.empty(0), np.empty((0, 1)), _harmonics(angle, force))
    closed = np.append(force[:-1], force[0])
    polynomials = _INTERPOLANTS[interpolation](angle, closed)
    start = np.mod(angle[:-1], TURN)
    order = np.argsort(start)
    return GasForce(start[order], polynomials[order], np.empty(0, dtype=complex))


def card_of_force(gas: GasForce) -> GasCard:
    """The same as a card, of a piston of 1 m^2; NumericalFailure where none can follow it."""
    if not len(gas.node):
        ends = np.linspace(0.0, TURN, 2 + len(gas.harmonics) // 4)
        return fitted_card(lambda angle: force_at(gas, angle), ends.tolist(), TURN)
    node = np.append(gas.node, gas.node[0] + TURN)
    return GasCard(node, gas.coefficient, TURN, np.zeros(len(gas.node)))


def force_at(gas: GasForce, angle: FloatArray) -> FloatArray:
    """Force in N at the cylinder's own crank angles, rad, of any turn."""
    if not len(gas.node):
        order = np.arange(len(gas.harmonics))
        return np.asarray(np.real(np.exp(1j * angle[..., None] * order) @ gas.harmonics))
    turned = np.mod(angle, TURN)
    place = np.searchsorted(gas.node, turned, side="right") - 1
    away = turned - gas.node[place]
    if gas.node[0] > 0.0:
        away += np.where(place < 0, TURN, 0.0)
    return _height(gas.coefficient[place], away)


def _harmonics(angle: FloatArray, force: FloatArray) -> ComplexArray:
    count = len(angle) - 1
    step = TURN / count
    if np.max(np.abs(np.diff(angle) - step)) > 1e-9:
        raise ValueError("trigonometric interpolation needs evenly spaced angles")
    found = np.fft.rfft(force[:-1]) / count
    found[1:] *= 2.0
    if count % 2 == 0:
        found[-1] *= 0.5
    return np.asarray(found * np.exp(-1j * np.arange(len(found)) * angle[0]))
