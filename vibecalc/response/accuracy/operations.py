"""Methods for energies of several operations and balances, against other ways to them."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_searches import (
    Highest,
    cyclic_parabola_maximum,
    golden_maximum,
    grid_maximum,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import Excitation, as_loads, at_speed
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.rounding import WithError
from vibecalc.response.adapters.operations import operation_loads
from vibecalc.response.adapters.response import forcing_of, linear_system
from vibecalc.response.energies import energy_by_order, energy_signal, mass_of
from vibecalc.response.operations import (
    Rows,
    SuperposedMotion,
    mean_energy_range,
    search_phases,
    superpose,
)

# ----------------------------------------------------------------------------
# One operation with one balance: its state by order, and the part that a balance weight turns.
# ----------------------------------------------------------------------------


class Combination(NamedTuple):
    """Velocities of the operation and balance whose weight matters most, and their mass matrix.

    `state` holds `shaking` (1, orders, 6) and `residual` (1, 1, 6) as `SuperposedMotion` does, of
    the orders (orders,) kept; the energy is the kinetic one.
    """

    weight: WithError
    state: SuperposedMotion
    orders: np.ndarray
    operation: str
    balance: str


def strongest(scene: Scene) -> Combination | None:
    """The combination whose kinetic energy a turn of the weight changes most; None without one."""
    options = scene.case.response
    if options is None or not options.operations:
        return None
    forcing, system = forcing_of(scene), linear_system(scene)
    loads = operation_loads(scene, options.operations, options.balances)
    speed, orders = scene.case.machine.speed, forcing.orders[: forcing.retained]

    def at_operating_speed(load: Excitation) -> WithError:
        return as_loads(at_speed(load, speed))

    shaking = [at_operating_speed(load) for load in loads.shaking]
    residual = [[at_operating_speed(load) for load in row] for row in loads.residual]
    parts = superpose(
        system.matrices,
        orders,
        speed,
        WithError(*(np.stack([x[k][: forcing.retained] for x in shaking]) for k in (0, 1))),
        WithError(*(np.stack([[x[k][0] for x in row] for row in residual]) for k in (0, 1))),
    )
    rate = 1j * orders * speed
    weight = mass_of(system.matrices)
    first = parts.shaking.value[:, None, parts.first]
    swing = np.abs(np.sum(first.conj() * (parts.residual.value @ weight.value), axis=-1))
    if not np.any(swing > 0.0):
        return None
    at = np.unravel_index(int(np.argmax(swing)), swing.shape)
    one = slice(at[0], at[0] + 1)
    state = SuperposedMotion(
        WithError(
            parts.shaking.value[one] * rate[:, None],
            parts.shaking.error[one] * np.abs(rate)[:, None],
        ),
        WithError(
            parts.residual.value[one, at[1] : at[1] + 1] * rate[parts.first],
            parts.residual.error[one, at[1] : at[1] + 1] * abs(rate[parts.first]),
        ),
        parts.first,
    )
    return Combination(weight, state, orders, loads.operations[at[0]], loads.balances[at[1]])


# ----------------------------------------------------------------------------
# Both ends of a curve over all angles of a balance weight, by grids.
# ----------------------------------------------------------------------------

TURN = 2.0 * np.pi

#: energies (k,) at angles (k,) of the weight
Curve = Callable[[np.ndarray], np.ndarray]


def words_of(one: Combination, kind: str) -> str:
    """What is asked of the "mean" or "peak" energy."""
    return (
        f"lowest and highest {kind} kinetic energy of operation {one.operation!r} with balance "
        f"{one.balance!r} over all angles of the weight"
    )


def whole_turn(curve: Curve, points: int) -> Highest:
    """The highest of `points` angles of one turn."""
    return grid_maximum(curve, 0.0, TURN * (points - 1) / points, points)


def with_parabola(curve: Curve, points: int) -> Highest:
    """The same with a parabola through the best and its neighbours."""
    return cyclic_parabola_maximum(curve, TURN, points)


def both_ends(curve: Curve, points: float, search: Callable[[Curve, int], Highest]) -> Answer:
    """Lowest and highest value as `search` finds them on the same `points`."""
    high = search(curve, int(points))
    low = search(lambda phase: -curve(phase), int(points))
    return Answer(np.array([-low.value, high.value]), points)


# ----------------------------------------------------------------------------
# Topic of the operations: range of the peak energy over all angles of a balance weight.
# ----------------------------------------------------------------------------

#: grids begin here, in rad: at zero, the nominal angle, an end may lie by luck
START = 0.1
PEAK_GRIDS = tuple(float(4 * 4**k) for k in range(5))
REFERENCE_GRID = 128
#: tolerance of the search that the reference is held against
PROVEN = 1e-13


def peak_range(one: Combination, rtol: float) -> Topic:
    """The range of the peak over the cycle; vibecalc seeks it to within `rtol`."""
    rows = _rows(one)

    def at(phase: np.ndarray) -> np.ndarray:
        signal = np.repeat(rows.harmonics, len(phase), axis=0)
        first = int(np.flatnonzero(rows.orders == 1)[0])
        signal[..., first] += np.exp(1j * phase)[:, None] * rows.turned
        return np.asarray(0.5 * np.square(vector_cycle_peak(signal, rows.orders).value))

    def later(phase: np.ndarray) -> np.ndarray:
        return at(START + phase)

    def bounded(tolerance: float) -> Answer:
        found = search_phases(rows, tolerance)
        return Answer(np.array([found.low[0], found.high[0]]), float(found.peaks[0]))

    def brent(points: float) -> Answer:
        return _brent(at, int(points))

    tolerances = sorted({1e-1, 1e-2, 1e-3, 1e-4, 1e-6, rtol}, reverse=True)
    return Topic(
        stage="operations",
        name="range of the peak energy",
        words=words_of(one, "peak"),
        quantity="response/operations/kinetic_energy/peak_low, peak_high",
        unit="J",
        work="peaks over the cycle",
        reference=lambda: _peak_reference(at, rows),
        solvers=(
            Solver(
                "branch and bound",
                "intervals that can hold neither end are dropped, the others halved",
                "rtol",
                tuple(tolerances),
                bounded,
                default=rtol,
                theory="what is left open falls with the square of the intervals",
                citation="docs/theory.md",
            ),
            Solver(
                "grid",
                "lowest and highest of N angles",
                "angles",
                PEAK_GRIDS,
                lambda points: both_ends(later, points, whole_turn),
                theory="order 2, at kinks order 1",
            ),
            Solver(
                "scipy minimize_scalar",
                "bounded Brent search around the lowest and highest of N angles",
                "angles",
                (4.0, 8.0, 16.0, 32.0, 64.0),
                brent,
            ),
        ),
        default_extra=4.0,
        default_why="no angle is left out: the ends are proven to within rtol",
    )


def _rows(one: Combination) -> Rows:
    """Signals whose squared length is twice the energy, as `peak_energy_range` makes them."""
    shaking = energy_signal(one.weight, one.state.shaking)
    part = one.state.residual
    residual = energy_signal(one.weight, WithError(part.value[:, 0, None], part.error[:, 0, None]))
    used = shaking.used.copy()
    used[one.state.first] = True
    return Rows(shaking.harmonics[..., used], one.orders[used], residual.harmonics[..., 0])


def _brent(curve: Curve, points: int) -> Answer:
    from scipy.optimize import minimize_scalar

    ends, work, step = [], float(points), TURN / points
    phase = START + step * np.arange(points)
    values = curve(phase)
    for sign in (1.0, -1.0):
        best = float(phase[int(np.argmin(sign * values))])
        found = minimize_scalar(
            lambda at, sign=sign: sign * float(curve(np.array([at]))[0]),
            bounds=(best - step, best + step),
            method="bounded",
            options={"xatol": 1e-10},
        )
        ends.append(sign * float(found.fun))
        work += float(found.nfev)
    return Answer(np.array(ends), work)


def _peak_reference(curve: Curve, rows: Rows) -> Reference:
    """Golden section about the ends of a fine grid, against the proven range."""
    phase = START + TURN * np.arange(REFERENCE_GRID) / REFERENCE_GRID
    values, step = curve(phase), TURN / REFERENCE_GRID
    ends = []
    for sign in (-1.0, 1.0):

        def turned(at: np.ndarray, sign: float = sign) -> np.ndarray:
            return sign * curve(at)

        # the three best grid points: next to a kink the best one may lie in the wrong valley
        best = phase[np.argsort(-sign * values)[:3]].tolist()
        found = [golden_maximum(turned, at - step, at + step, 50).value for at in best]
        ends.append(sign * max(found))
    known = search_phases(rows, PROVEN)
    proven = np.array([known.low[0], known.high[0]])
    reference = np.array(ends)
    agreement = float(np.max(np.abs(proven - reference)) / np.max(np.abs(reference)))
    return Reference(
        reference,
        agreement,
        f"golden section about the best of {REFERENCE_GRID} angles; branch and bound at rtol "
        f"{PROVEN:g} agrees to {agreement:.1e}",
    )


# ----------------------------------------------------------------------------
# Topics of the operations: range of the kinetic energy over all angles of a balance weight.
# ----------------------------------------------------------------------------

#: of a step, how far next to a point of a grid the highest mean lies, as on average it does
MISSED = 0.25
MEAN_GRIDS = tuple(float(4 * 4**k) for k in range(6))
#: what the closed form evaluates: both energies and what they have in common
PARTS = 3.0


def operations_topics(scene: Scene) -> list[Topic]:
    """The operation and balance that the weight's angle matters most to; none without a weight."""
    one = strongest(scene)
    if one is None:
        return []
    return [_mean(one), peak_range(one, scene.case.accuracy.rtol)]


def _mean(one: Combination) -> Topic:
    still = float(np.sum(energy_by_order(one.weight, one.state.shaking).mean))
    shaking = one.state.shaking.value[0, one.state.first]
    rest = still - 0.25 * float((shaking.conj() @ one.weight.value @ shaking).real)

    def at(phase: np.ndarray) -> np.ndarray:
        turned = shaking + np.exp(1j * phase)[:, None] * one.state.residual.value[0, 0]
        each = energy_by_order(one.weight, WithError(turned, 0.0 * np.abs(turned)))
        return np.asarray(rest + each.mean)

    highest = float(mean_energy_range(one.weight, one.state).high_phase[0, 0])

    def nearby(points: float) -> Curve:
        return lambda phase: at(highest + MISSED * TURN / points + phase)

    def closed(_: float) -> Answer:
        found = mean_energy_range(one.weight, one.state)
        return Answer(np.array([found.low[0, 0], found.high[0, 0]]), PARTS)

    return Topic(
        stage="operations",
        name="range of the mean energy",
        words=words_of(one, "mean"),
        quantity="response/operations/kinetic_energy/mean_low, mean_high",
        unit="J",
        work="energies",
        reference=lambda: _mean_reference(one, at),
        solvers=(
            Solver(
                "closed form",
                "the weight turns one phasor: a + b cos of its angle",
                "",
                NOTHING_TO_SET,
                closed,
                default=1.0,
                citation="docs/theory.md",
            ),
            Solver(
                "grid",
                "lowest and highest of N angles, a quarter of a step next to the known highest",
                "angles",
                MEAN_GRIDS,
                lambda points: both_ends(nearby(points), points, whole_turn),
                theory="order 2",
            ),
            Solver(
                "grid with parabola",
                "parabolas through the best of N angles and their neighbours",
                "angles",
                MEAN_GRIDS,
                lambda points: both_ends(nearby(points), points, with_parabola),
                theory="order 4",
            ),
        ),
    )


def _mean_reference(one: Combination, curve: Curve) -> Reference:
    """The closed form in 40 digits, against golden section on energies in doubles."""
    import mpmath

    with mpmath.workdps(40):

        def row(values: np.ndarray) -> list[Any]:
            return [mpmath.mpc(complex(x)) for x in values]

        weight = [[mpmath.mpf(float(x)) for x in line] for line in one.weight.value]

        def product(left: list[Any], right: list[Any]) -> Any:
            return mpmath.fsum(
                mpmath.conj(a) * w * b
                for a, line in zip(left, weight, strict=True)
                for w, b in zip(line, right, strict=True)
            )

        states = [row(values) for values in one.state.shaking.value[0]]
        turned = row(one.state.residual.value[0, 0])
        middle = mpmath.fsum(mpmath.re(product(x, x)) for x in [*states, turned]) / 4
        swing = abs(product(states[one.state.first], turned)) / 2
        ends = np.array([float(middle - swing), float(middle + swing)])
    place = whole_turn(curve, 256).position
    half = TURN / 256.0
    high = golden_maximum(curve, place - half, place + half).value
    agreement = abs(high / ends[1] - 1.0)
    return Reference(
        ends,
        agreement,
        f"closed form in 40 digits (mpmath); golden section over the angle agrees to "
        f"{agreement:.1e}",
    )
