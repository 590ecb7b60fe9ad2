"""Kinds of problems: the plain numpy or scipy way to each, and the reference that it is held to.

A subject hands over its question: words, its own methods, and the callable or matrices that it is
about. A kind adds what a user would write, and a far finer or independent truth.
"""

import contextlib
import time
from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.accuracy.topic import Answer, Ask, Reference, Solver, Topic
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.cycle_peak import SAMPLES_PER_ORDER, needed_orders, vector_cycle_peak
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF

Curve = Callable[[np.ndarray], np.ndarray]
Rates = Callable[[float, np.ndarray], np.ndarray]
#: M, K, C and H (n, n) first: stiffness of w is K - w^2 M + i (H + w C)
System = tuple[np.ndarray, ...]
TURN = 2.0 * np.pi
DIGITS = 40
#: a way that no case can choose
plain_way = partial(Solver, default=None)


class Counted:
    """A function of points, and how many it has been asked for."""

    def __init__(self, of: Callable[..., Any]):
        self.of, self.asked = of, 0

    def __call__(self, *given: Any, **named: Any) -> Any:
        """What the function gives; the points are given first."""
        self.asked += np.size(given[0])
        return self.of(*given, **named)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference over the largest magnitude."""
    return float(np.max(np.abs(one - other)) / np.max(np.abs(one)))


def of_kind(kind: str, ask: Ask) -> Ask:
    """The same with the kind of problem before its words."""
    return ask._replace(words=f"{kind}: {ask.words}")


# ----------------------------------------------------------------------------
# Harmonics of a signal over a cycle: the Fourier transform of samples; Gauss between the kinks.
# ----------------------------------------------------------------------------

SAMPLES = tuple(float(64 * 4**k) for k in range(5))


def harmonics_of_samples(samples: np.ndarray, highest: int) -> np.ndarray:
    """Complex 0-to-peak amplitudes (..., highest + 1) of a cycle (..., count); order 0 is the mean.

    Raises NumericalFailure where the highest order would fold onto lower ones.
    """
    count = samples.shape[-1]
    if count <= 2 * highest:
        raise NumericalFailure(
            f"{count} samples cannot tell order {highest} from lower ones: more than "
            f"{2 * highest} are needed"
        )
    found: np.ndarray = np.fft.rfft(samples, axis=-1)[..., : highest + 1] * (2.0 / count)
    found[..., 0] *= 0.5
    return found


def harmonics(
    ask: Ask, solvers: Sequence[Solver], signal: Curve, orders: np.ndarray, edges: np.ndarray,
    size: np.ndarray | float = 1.0, counts: Sequence[float] = SAMPLES,
    exact: Callable[[], Reference] | None = None,
) -> Topic:  # fmt: skip
    """Harmonics of `signal` (angle), smooth between `edges`, of which the first to last is a cycle.

    The `orders` are whole per cycle. Values are the harmonics over `size`; `exact` is the truth
    where Gauss's rule would not do.
    """
    places, cycle = np.asarray(orders, dtype=int), float(edges[-1] - edges[0])

    def sampled(count: float) -> Answer:
        values = signal(np.asarray(cycle * np.arange(int(count)) / count))
        found = harmonics_of_samples(values, int(places[-1]))[places]
        return Answer(found / size, count)

    def between(points: int) -> np.ndarray:
        rule, wide = gauss_rule(points), np.diff(edges)[:, None]
        angle = (edges[:-1, None] + wide * rule.nodes).ravel()
        share = (wide * rule.weights).ravel() / cycle * signal(angle)
        found = np.exp(-1j * places[:, None] * (TURN / cycle) * angle) @ share
        return np.asarray(np.where(places == 0, 1.0, 2.0) * found / size)

    def reference() -> Reference:
        fine = between(48)
        agreement = max(apart(fine, between(36)), 16.0 * EPSILON)
        return Reference(fine, agreement, "Gauss's rule between the kinks, 48 points against 36")

    plain = plain_way("numpy.fft of samples", sampled, "samples", counts)
    return Topic(of_kind("harmonics", ask), "angles", exact or reference, (*solvers, plain))


# ----------------------------------------------------------------------------
# Modes of a mass and a stiffness matrix: scipy's and numpy's eigenvalues; forty digits.
# ----------------------------------------------------------------------------


def modes(
    ask: Ask, solvers: Sequence[Solver], mass: np.ndarray, stiffness: np.ndarray,
    size: np.ndarray | float = 1.0, exact: Callable[[], System] | None = None,
) -> Topic:  # fmt: skip
    """Natural frequencies, rad/s, ascending, over `size`; `exact` has M and K in mpmath."""
    n = len(mass)

    def shown(squares: np.ndarray, work: float) -> Answer:
        return Answer(np.sqrt(np.abs(np.sort(np.asarray(squares).real))) / size, work * n**3)

    def by_scipy(_: float) -> Answer:
        from scipy.linalg import eigh

        return shown(eigh(stiffness, mass, eigvals_only=True), 2.0)

    def by_numpy(_: float) -> Answer:
        return shown(np.linalg.eigvals(np.linalg.solve(mass, stiffness)), 6.3)

    def reference() -> Reference:
        import mpmath

        with mpmath.workdps(DIGITS):
            springs = mpmath.matrix((exact()[1] if exact else stiffness).tolist())
            inverse = mpmath.inverse(mpmath.cholesky(mpmath.matrix(mass.tolist())))
            reduced = inverse * springs * inverse.T
            found = mpmath.eigsy((reduced + reduced.T) / 2, eigvals_only=True)
            values = np.array(sorted(float(mpmath.sqrt(abs(one))) for one in found))
        return Reference(values / size, UNIT_ROUNDOFF, f"eigenvalues in {DIGITS} digits (mpmath)")

    plain = (
        plain_way("scipy.linalg.eigh", by_scipy),
        plain_way("numpy.linalg.eigvals", by_numpy),
    )
    return Topic(of_kind("modes", ask), "multiplications", reference, (*solvers, *plain))


# ----------------------------------------------------------------------------
# Forced response of matrices: numpy.linalg.solve; forty digits.
# ----------------------------------------------------------------------------


def forced(
    ask: Ask, solvers: Sequence[Solver], system: System, frequency: np.ndarray, load: np.ndarray,
    read: Callable[[np.ndarray], np.ndarray] = np.asarray,
    exact: Callable[[], System] | None = None,
) -> Topic:  # fmt: skip
    """Amplitudes (m, n) under loads (m, n) at frequencies (m,), rad/s, as `read` shows them."""

    def solved(_: float) -> Answer:
        (m, k, c, h), w = system[:4], frequency[:, None, None]
        found = np.linalg.solve(k - w * w * m + 1j * (h + w * c), load[..., None])[..., 0]
        return Answer(read(found), float(len(load)))

    def reference() -> Reference:
        import mpmath

        found = np.zeros(load.shape, dtype=complex)
        with mpmath.workdps(DIGITS):
            parts = (exact() if exact else system)[:4]
            m, k, c, h = (mpmath.matrix(one.tolist()) for one in parts)
            for row in np.flatnonzero(np.any(load != 0.0, axis=1)).tolist():
                w = mpmath.mpf(float(frequency[row]))
                right = mpmath.matrix([mpmath.mpc(complex(one)) for one in load[row]])
                motion = mpmath.lu_solve(k - w * w * m + mpmath.mpc(0, 1) * (h + w * c), right)
                found[row] = [complex(one) for one in motion]
        return Reference(read(found), 4.0 * EPSILON, f"solved in {DIGITS} digits (mpmath)")

    plain = plain_way("numpy.linalg.solve", solved)
    return Topic(of_kind("forced response", ask), "solutions", reference, (*solvers, plain))


# ----------------------------------------------------------------------------
# The highest point of a curve: a grid, scipy's bounded search about its best; a polynomial there.
# ----------------------------------------------------------------------------

GRIDS = tuple(float(8 * 4**k) for k in range(6))
STARTS = tuple(float(8 * 2**k) for k in range(6))
#: places that a reference samples at least, and how many of the best it follows
FIRST_PLACES, RIVALS = 2001, 3


def bounded(
    curve: Curve, low: float, high: float, tolerance: float, about: float = 0.0
) -> tuple[float, float]:
    """The highest value and its place by scipy's bounded search between two places.

    Counted from the place `about`, scipy tells it to more digits.
    """
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda beyond: -float(curve(np.array([about + beyond]))[0]), method="bounded",
        bounds=(low - about, high - about), options={"xatol": tolerance},
    )  # fmt: skip
    return -float(found.fun), about + float(found.x)


def smooth_place(curve: Curve, at: float, half: float) -> float:
    """Where a polynomial through exact values next to a peak has its top, to more digits.

    The highest value alone tells the place to half the digits only.
    """
    places = []
    for degree in (16, 12):
        near = np.polynomial.Chebyshev.interpolate(
            lambda share: curve(at + half * share), degree, [-1.0, 1.0]
        )
        turns = near.deriv().roots()
        inside = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) < 1.0)]
        places.append(float(inside[np.argmin(np.abs(inside))]) if len(inside) else 0.0)
    return at + half * places[0] if abs(places[0] - places[1]) < 1e-6 else at


def _top_of(curve: Curve, low: float, high: float, count: int) -> Reference:
    places = np.linspace(low, high, count)
    values, step = curve(places), places[1] - places[0]
    padded = np.pad(values, 1, constant_values=-np.inf)
    tops = np.flatnonzero((values >= padded[:-2]) & (values >= padded[2:]))
    found = [(float(values[k]), float(places[k])) for k in (0, -1)]

    for middle in places[tops[np.argsort(-values[tops])][:RIVALS]].tolist():
        ends = max(low, middle - step), min(high, middle + step)
        found.append(bounded(curve, *ends, 1e-12 * step, middle))
    best, place = max(found)
    if min(place - low, high - place) > 1e-9 * (high - low):
        nearer = (smooth_place(curve, place, share * step) for share in (0.3, 0.03, 0.003))
        place = next((one for one in nearer if one != place), place)
    value = max(float(curve(np.array([place]))[0]), best)
    words = (
        f"scipy's bounded search about the highest of {count} samples, polynomial through the peak"
    )
    return Reference(value, max(abs(best / value - 1.0), 4.0 * EPSILON), words, place)


def peak_over_range(
    ask: Ask, solver: Solver, curve: Curve, ends: tuple[float, float], known: float,
    position: str = "", work: str = "values of the curve", *, around: bool = False,
    count: int = FIRST_PLACES,
) -> Topic:  # fmt: skip
    """The highest value of `curve` (places) between two places; `known` is where ours finds it.

    `around`: the ends are one, as of a cycle. A reference begins with `count` samples.
    """
    low, high = ends

    def grid(points: int) -> tuple[float, float, float, float]:
        """The best of even places and where, the step, and how many there are.

        They lie a quarter of a step next to the peak, as those of a grid do on average: one from
        dead centre on might meet it by luck.
        """
        step = (high - low) / points
        places = low + step * (np.arange(points) + ((known - low) / step + 0.25) % 1.0)
        places = places if around else np.concatenate([[low], places, [high]])
        values = curve(places)
        best = int(np.argmax(values))
        return float(values[best]), float(places[best]), step, float(len(places))

    def gridded(points: float) -> Answer:
        value, place, _, asked = grid(int(points))
        return Answer(value, asked, place)

    def searched(points: float) -> Answer:
        _, place, step, asked = grid(int(points))
        counted = Counted(curve)
        near = max(low, place - step), min(high, place + step)
        value, place = bounded(counted, *near, 1e-10 * (high - low))
        return Answer(value, asked + counted.asked, place)

    plain = (
        plain_way("grid", gridded, "places", GRIDS, theory="order 2"),
        plain_way("scipy minimize_scalar", searched, "places", STARTS),
    )
    kind = "peak over a cycle" if around else "peak over a range"
    reference = partial(_top_of, curve, low, high, count)
    return Topic(of_kind(kind, ask), work, reference, (solver, *plain), position)


def peak_over_cycle(ask: Ask, rows: np.ndarray, orders: np.ndarray, angle: str) -> Topic:
    """Largest length over a turn of a vector with harmonics `rows` (components, orders).

    `angle` names the one over which the orders are whole, with its unit.
    """
    used = np.any(rows != 0.0, axis=0) & (orders > 0)
    rows, orders = rows[:, used], orders[used]
    known = vector_cycle_peak(rows, orders)
    first = float(known.angle)

    def curve(angle: np.ndarray) -> np.ndarray:
        waves = np.exp(1j * np.multiply.outer(orders, angle))
        return np.asarray(np.sqrt(np.sum(np.square((rows @ waves).real), axis=0)))

    step = max(int(np.gcd.reduce(orders)), 1)
    # a vector of odd orders is as long half a turn later
    period = TURN / step * (0.5 if np.all(orders // step % 2 == 1) else 1.0)
    points = 96 * int(orders.max())
    around = curve(first + period * (np.arange(points) / points - 0.5))
    tops = (around >= np.roll(around, 1)) & (around > np.roll(around, -1))
    alone = int(np.sum(tops & (around > (1.0 - 1e-3) * float(known.value)))) == 1
    needed = int(needed_orders(rows[None], orders // step)[0][0])
    work = float(SAMPLES_PER_ORDER * needed + 30) if orders.max() > step else 1.0

    def own(_: float) -> Answer:
        found = vector_cycle_peak(rows, orders)
        place = first + (float(found.angle) - first + 0.5 * period) % period - 0.5 * period
        return Answer(float(found.value), work, place)

    extra = max(1.0, float(np.ceil(work / 12.0)))
    why = "no maximum can be missed: every order above rounding is sampled twelvefold"
    ask = ask._replace(extra=extra, why=why if extra > 1.0 else "")
    ends = first - 0.5 * period, first + 0.5 * period
    return peak_over_range(ask, Solver("cycle_peak", own), curve, ends, first,
                           angle if alone else "", around=True,
                           count=max(points, FIRST_PLACES))  # fmt: skip


# ----------------------------------------------------------------------------
# Time histories and periodic states of equations of motion: scipy's solve_ivp, with shooting.
# ----------------------------------------------------------------------------

RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
_EQUATIONS = "evaluations of the equations"


def integrated(
    rates: Rates, start: np.ndarray, times: np.ndarray, rtol: float, scale: np.ndarray | float,
    method: str = "DOP853", stops: np.ndarray | None = None, **more: Any,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """States (k, n) at `times` after the first, by solve_ivp, and its calls.

    With `stops`, where the rates have kinks, it begins anew at each of them and of the times.
    Raises NumericalFailure where scipy gives up.
    """
    from scipy.integrate import solve_ivp

    ends, state, found, calls = times[[0, -1]], np.array(start, float), [], 0
    if stops is not None:
        ends = np.union1d(times, stops[(stops > times[0]) & (stops < times[-1])])
    for now, end in pairwise(ends.tolist()):
        asked = times[(times > now) & (times <= end)]
        with np.errstate(all="ignore"):
            one = solve_ivp(
                rates, (now, end), state, method=method, t_eval=asked if len(asked) else [end],
                rtol=max(rtol, 3e-14), atol=rtol * np.asarray(scale), **more,
            )  # fmt: skip
        if not one.success or not np.all(np.isfinite(one.y)):
            raise NumericalFailure(f"{method} at rtol {rtol:.1g} gave up: {one.message}")
        found.append(one.y.T[: len(asked)])
        state, calls = one.y[:, -1], calls + int(one.nfev)
    return np.concatenate(found), calls


def time_history(
    ask: Ask, solver: Solver, rates: Rates, start: np.ndarray, times: np.ndarray,
    read: Callable[[np.ndarray], np.ndarray], scale: np.ndarray | float,
    fine: Callable[[], Any], jacobian: np.ndarray | None = None,
    stops: np.ndarray | None = None, max_step: float = np.inf,
) -> Topic:  # fmt: skip
    """What `read` shows of the states at `times` (from the start on); `fine` is ours far finer."""

    def march(method: str, rtol: float) -> Answer:
        more = {"jac": jacobian} if method == "Radau" else {}
        found, calls = integrated(
            rates, start, times, rtol, scale, method, max_step=max_step, **more
        )
        return Answer(read(found), float(calls))

    def reference() -> Reference:
        truth, step = fine(), 0.1 * max_step
        other = integrated(rates, start, times, 1e-13, scale, stops=stops, max_step=step)[0]
        agreement = max(apart(truth, read(other)), 16.0 * EPSILON)
        return Reference(truth, agreement, "ours far finer, against DOP853 of scipy at 1e-13")

    plain = [
        plain_way(f"scipy {name}", partial(march, name), "rtol", rtols)
        for name, rtols in (("RK45", RTOLS[:3]), ("DOP853", RTOLS), ("Radau", RTOLS[:3]))
    ]
    return Topic(of_kind("time history", ask), _EQUATIONS, reference, (solver, *plain))


def shot(
    rates: Rates, guess: np.ndarray, unknown: Sequence[int], back: Sequence[int],
    times: np.ndarray, rtol: float, scale: np.ndarray, stops: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, int]:  # fmt: skip
    """Start, states at `times` and calls of the motion that comes back: Newton by differences.

    `unknown` are the states to be found, `back` those that come back; `rates` take rows of states.
    Raises NumericalFailure where they do not come back.
    """
    free, again, n, calls = list(unknown), list(back), len(guess), 0
    starts = np.repeat(guess[None].astype(float), len(free) + 1, axis=0)
    nudge = 1e-5 * scale[free]

    def marched(rows: np.ndarray, times: np.ndarray) -> np.ndarray:
        nonlocal calls
        found, used = integrated(
            lambda t, flat: rates(t, flat.reshape(-1, n)).ravel(), rows.ravel(), times, rtol,
            np.tile(scale, len(rows)), stops=stops,
        )  # fmt: skip
        calls += used * len(rows)
        return found.reshape(len(times) - 1, len(rows), n)

    for _ in range(12):
        starts[1:] = starts[0] + nudge[:, None] * np.eye(n)[free]
        gap = (marched(starts, times[[0, -1]])[-1] - starts)[:, again] / scale[again]
        slope = ((gap[1:] - gap[0]) / nudge[:, None]).T * scale[free]
        step = np.linalg.lstsq(slope, gap[0], rcond=1e-13)[0]
        starts[0, free] -= step * scale[free]
        if np.max(np.abs(step)) <= max(rtol, 1e-11):
            return starts[0], marched(starts[:1], times)[:, 0], calls
    raise NumericalFailure(f"shooting with DOP853 at {rtol:.1g} does not come back to its start")


def periodic(
    ask: Ask, solvers: Sequence[Solver], rates: Rates, guess: np.ndarray, unknown: Sequence[int],
    back: Sequence[int], times: np.ndarray, read: Callable[[np.ndarray, np.ndarray], np.ndarray],
    scale: np.ndarray, fine: Callable[[], Any], stops: np.ndarray | None = None,
    rtols: Sequence[float] = (1e-4, 1e-6, 1e-8, 1e-10),
) -> Topic:  # fmt: skip
    """What `read` (start, states at `times`) shows of the motion that comes back at the last."""

    def shooting(rtol: float, stops: np.ndarray | None = None) -> Answer:
        start, states, calls = shot(rates, guess, unknown, back, times, rtol, scale, stops)
        return Answer(read(start, states), float(calls))

    def reference() -> Reference:
        truth = fine()
        agreement = max(apart(truth, shooting(1e-13, stops).values), 16.0 * EPSILON)
        return Reference(truth, agreement, "ours far finer, against shooting with DOP853 at 1e-13")

    plain = plain_way("scipy DOP853, shooting", shooting, "rtol", rtols)
    return Topic(of_kind("periodic state", ask), _EQUATIONS, reference, (*solvers, plain))


# ----------------------------------------------------------------------------
# Optima: searches of scipy.optimize from where a user would begin.
# ----------------------------------------------------------------------------

#: a margin broken by less counts as kept
NEARLY_KEPT = 1e-6
#: a place on the unit cube or in logarithms -> the objective, and the margins of all limits
Limited = Callable[[np.ndarray], tuple[float, np.ndarray]]


class Optimal(NamedTuple):
    """What a search of ours found: place, objective, its absolute error, what it took."""

    place: np.ndarray
    value: float
    error: float
    work: float


def top_of_samples(curve: np.ndarray) -> np.ndarray:
    """The highest (...) of even samples (points, ...), with a parabola through its neighbours."""
    best = np.clip(curve.argmax(axis=0), 1, len(curve) - 2)[None]
    low, top, high = (np.take_along_axis(curve, best + k, axis=0)[0] for k in (-1, 0, 1))
    bend = np.where(top > np.maximum(low, high), 2.0 * top - low - high, np.inf)
    rise = (high - low) ** 2 / (8.0 * bend)
    return np.asarray(np.maximum(top + rise, curve.max(axis=0)))


class _Spent(Exception):
    """The budget is used up."""


def within_budget(
    method: str, evaluate: Limited, bounds: list[tuple[float, float]], first: np.ndarray,
    budget: int, nearly: float = NEARLY_KEPT,
) -> tuple[float, int]:  # fmt: skip
    """Best value that keeps the limits, and evaluations, of a search of scipy.

    Raises NumericalFailure where no point met keeps them.
    """
    from scipy.optimize import differential_evolution, minimize

    known: dict[bytes, tuple[float, np.ndarray]] = {}

    def at(place: np.ndarray) -> tuple[float, np.ndarray]:
        key = np.ascontiguousarray(place + 0.0).tobytes()
        if key not in known:
            if len(known) >= budget:
                raise _Spent
            try:
                known[key] = evaluate(np.array(place))
            except NumericalFailure:
                if not known:
                    raise
                known[key] = 1e300, np.full(len(next(iter(known.values()))[1]), -1.0)
        return known[key]

    value, margins = at(first)
    size = abs(value) or 1.0

    def penalised(place: np.ndarray) -> float:
        value, margins = at(place)
        return value / size + 10.0 * float(np.sum(np.maximum(-margins, 0.0)))

    limits = [{"type": "ineq", "fun": lambda place: at(place)[1]}] if len(margins) else []
    with contextlib.suppress(_Spent), np.errstate(all="ignore"):
        if method == "differential evolution":
            differential_evolution(penalised, bounds, seed=1, maxiter=100000, tol=0.0,
                                   polish=False, x0=first, popsize=5)  # fmt: skip
        elif method == "Nelder-Mead":
            options = {"maxiter": budget, "xatol": 1e-13, "fatol": 1e-16}
            minimize(penalised, first, method=method, bounds=bounds, options=options)
        else:
            options = {"maxiter": 100000, ("ftol" if method == "SLSQP" else "tol"): 1e-14}
            minimize(lambda place: at(place)[0] / size, first, method=method, bounds=bounds,
                     constraints=limits, options=options)  # fmt: skip
    kept = [value for value, margins in known.values() if np.min(margins, initial=0.0) >= -nearly]
    if not kept or min(kept) == 1e300:
        raise NumericalFailure(
            f"{method} met no point that keeps all limits in {len(known)} evaluations"
        )
    return min(kept), len(known)


def optimum(
    ask: Ask, search: Solver, problem: Callable[[], Limited],
    bounds: ArrayLike, first: np.ndarray, budgets: Sequence[float],
    methods: Sequence[str], work: str, *, sign: float = 1.0, confirm: int = 60,
) -> Topic:  # fmt: skip
    """The least objective that keeps its margins; `problem` gives it, with nothing remembered.

    `search` is ours, to an `Optimal`, and is run once for each setting. A plain search from four
    digits of its place, with `confirm` evaluations, confirms a local optimum and not that it is the
    best. Values shown are `sign` times the objective.
    """
    box = np.asarray(bounds, dtype=float).tolist()

    @cache
    def found(setting: float) -> tuple[Optimal, float]:
        began = time.process_time()
        return search.solve(setting), time.process_time() - began

    def own(setting: float) -> Answer:
        best, seconds = found(setting)
        return Answer(sign * best.value, best.work, None, seconds)

    def searched(method: str, budget: float) -> Answer:
        value, asked = within_budget(method, problem(), box, first, int(budget))
        return Answer(sign * value, float(asked))

    def reference() -> Reference:
        place, value, error, _ = found(float(search.default or 1.0))[0]
        near = np.clip(np.array([float(f"{one:.3e}") for one in place]), *np.array(box).T)
        for method in methods:  # one may meet no point that keeps all limits
            with contextlib.suppress(NumericalFailure):
                again, _ = within_budget(method, problem(), box, near, confirm, 1e-10)
                break
        else:
            raise NumericalFailure(f"none of {', '.join(methods)} confirms the optimum")
        off = max(abs(again - value), error) / (abs(value) or 1.0)
        words = f"ours; {method} from four digits of it confirms a local optimum"
        return Reference(sign * value, max(off, EPSILON), words)

    plain = [
        plain_way(f"scipy {name}", partial(searched, name), "evaluations", budgets)
        for name in methods
    ]
    ours = search._replace(solve=own)
    return Topic(of_kind("optimum", ask), work, reference, (ours, *plain))
