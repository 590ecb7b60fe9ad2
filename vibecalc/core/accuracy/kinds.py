"""Kinds of problems: the plain numpy or scipy way to each, and the reference that it is held to.

A subject hands over its question: words, its own methods as `ours`, and the callable or matrices
that it is about. A kind adds what a user would write, and a far finer or independent truth.
"""

import contextlib
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.cycle_peak import SAMPLES_PER_ORDER, needed_orders, vector_cycle_peak
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF

Curve = Callable[[np.ndarray], np.ndarray]
Rates = Callable[[float, np.ndarray], np.ndarray]
TURN = 2.0 * np.pi
DIGITS = 40


class Ask(NamedTuple):
    """What is asked: stage, name, in words, the path and unit of the result that it stands for.

    `extra` is by how much the default's work may exceed the least as accurate, and `why`.
    """

    stage: str
    name: str
    words: str
    quantity: str
    unit: str
    extra: float = 1.0
    why: str = ""


def ours(
    name: str, words: str, solve: Callable[[float], Answer], setting: str = "",
    settings: Iterable[float] = NOTHING_TO_SET, default: float | None = 1.0, theory: str = "",
    citation: str = "", falling: bool = False,
) -> Solver:  # fmt: skip
    """A method that a case can choose, from coarse to fine; its default is among the settings."""
    every = {float(one) for one in settings} | ({float(default)} if default is not None else set())
    steps = tuple(sorted(every, reverse=falling))
    return Solver(name, words, setting, steps, solve, default, theory, citation)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference over the largest magnitude."""
    return float(np.max(np.abs(one - other)) / np.max(np.abs(one)))


def _topic(
    kind: str, ask: Ask, work: str, reference: Callable[[], Reference], solvers: Iterable[Solver],
    position: str = "",
) -> Topic:  # fmt: skip
    return Topic(
        ask.stage, ask.name, f"{kind}: {ask.words}", ask.quantity, ask.unit, work, reference,
        tuple(solvers), position, ask.extra, ask.why,
    )  # fmt: skip


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
    ask: Ask, solvers: Sequence[Solver], signal: Curve, orders: np.ndarray, cycle: float = TURN,
    edges: np.ndarray | None = None, size: np.ndarray | float = 1.0, counts: Sequence[float] = (),
    exact: Callable[[], Reference] | None = None, work: str = "angles",
) -> Topic:  # fmt: skip
    """Harmonics `orders`, whole per `cycle`, of `signal` (angle), which is smooth between `edges`.

    Values are the harmonics over `size`; `exact` is the truth where Gauss's rule would not do.
    """
    places = np.asarray(orders, dtype=int)

    def sampled(count: float) -> Answer:
        values = signal(np.asarray(cycle * np.arange(int(count)) / count))
        found = harmonics_of_samples(values, int(places[-1]))[places]
        return Answer(found / size, count)

    def between(points: int) -> np.ndarray:
        ends = np.array([0.0, cycle]) if edges is None else edges
        rule, wide = gauss_rule(points), np.diff(ends)[:, None]
        angle = (ends[:-1, None] + wide * rule.nodes).ravel()
        share = (wide * rule.weights).ravel() / cycle * signal(angle)
        found = np.exp(-1j * places[:, None] * (TURN / cycle) * angle) @ share
        return np.asarray(np.where(places == 0, 1.0, 2.0) * found / size)

    def reference() -> Reference:
        fine = between(48)
        agreement = max(apart(fine, between(36)), 16.0 * EPSILON)
        return Reference(fine, agreement, "Gauss's rule between the kinks, 48 points against 36")

    settings = tuple(sorted(set(counts))) or SAMPLES
    plain = Solver("numpy.fft of samples", "at even angles", "samples", settings, sampled)
    return _topic("harmonics", ask, work, exact or reference, (*solvers, plain))


# ----------------------------------------------------------------------------
# Modes of a mass and a stiffness matrix: scipy's and numpy's eigenvalues; forty digits.
# ----------------------------------------------------------------------------


def modes(
    ask: Ask, solvers: Sequence[Solver], mass: np.ndarray, stiffness: np.ndarray,
    size: np.ndarray | float = 1.0, exact: Callable[[], Any] | None = None,
) -> Topic:  # fmt: skip
    """Natural frequencies, rad/s, ascending, over `size`; `exact` has the stiffness in mpmath."""
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
            springs = mpmath.matrix((exact() if exact else stiffness).tolist())
            inverse = mpmath.inverse(mpmath.cholesky(mpmath.matrix(mass.tolist())))
            reduced = inverse * springs * inverse.T
            found = mpmath.eigsy((reduced + reduced.T) / 2, eigvals_only=True)
            values = np.array(sorted(float(mpmath.sqrt(abs(one))) for one in found))
        return Reference(values / size, UNIT_ROUNDOFF, f"eigenvalues in {DIGITS} digits (mpmath)")

    plain = (
        Solver("scipy.linalg.eigh", "stiffness and mass", "", NOTHING_TO_SET, by_scipy),
        Solver("numpy.linalg.eigvals", "of mass^-1 stiffness", "", NOTHING_TO_SET, by_numpy),
    )
    return _topic("modes", ask, "multiplications", reference, (*solvers, *plain))


# ----------------------------------------------------------------------------
# Forced response of matrices: numpy.linalg.solve order by order; thirty-four digits.
# ----------------------------------------------------------------------------


class Matrices(NamedTuple):
    """M, K, C and H (n, n): stiffness of w is K - w^2 M + i (H + w C)."""

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray


def forced(
    ask: Ask, solvers: Sequence[Solver], parts: Matrices, frequency: np.ndarray, load: np.ndarray,
    read: Callable[[np.ndarray], np.ndarray] = np.asarray,
    exact: Callable[[], Matrices] | None = None,
) -> Topic:  # fmt: skip
    """Amplitudes (m, n) under loads (m, n) at frequencies (m,), rad/s, as `read` shows them."""

    def system(w: Any) -> np.ndarray:
        m, k, c, h = parts
        return np.asarray(k - w * w * m + 1j * (h + w * c))

    def looped(_: float) -> Answer:
        rows = zip(frequency.tolist(), load, strict=True)
        found = [np.linalg.solve(system(w), one) for w, one in rows]
        return Answer(read(np.array(found)), float(len(load)))

    def stacked(_: float) -> Answer:
        found = np.linalg.solve(system(frequency[:, None, None]), load[..., None])[..., 0]
        return Answer(read(found), float(len(load)))

    def reference() -> Reference:
        import mpmath

        found = np.zeros(load.shape, dtype=complex)
        with mpmath.workdps(DIGITS):
            m, k, c, h = (mpmath.matrix(one.tolist()) for one in (exact() if exact else parts))
            for row in np.flatnonzero(np.any(load != 0.0, axis=1)).tolist():
                w = mpmath.mpf(float(frequency[row]))
                right = mpmath.matrix([mpmath.mpc(complex(one)) for one in load[row]])
                motion = mpmath.lu_solve(k - w * w * m + mpmath.mpc(0, 1) * (h + w * c), right)
                found[row] = [complex(one) for one in motion]
        return Reference(read(found), 4.0 * EPSILON, f"solved in {DIGITS} digits (mpmath)")

    plain = (
        Solver("numpy.linalg.solve", "one after the other", "", NOTHING_TO_SET, looped),
        Solver("numpy.linalg.solve, all", "all together", "", NOTHING_TO_SET, stacked),
    )
    return _topic("forced response", ask, "solutions", reference, (*solvers, *plain))


# ----------------------------------------------------------------------------
# The highest point of a curve: a grid, scipy's bounded search about its best; a polynomial there.
# ----------------------------------------------------------------------------

GRIDS = tuple(float(8 * 4**k) for k in range(6))
STARTS = tuple(float(8 * 2**k) for k in range(6))
#: places that a reference samples first, and how many of the best it follows
FIRST_PLACES, RIVALS = 2001, 3


class Highest(NamedTuple):
    """The largest value, its place, and how often the curve was asked."""

    value: float
    place: float
    asked: float


def grid_maximum(
    curve: Curve, low: float, high: float, points: int, peak: float, ends: bool = True
) -> Highest:
    """The best of even places, laid a quarter of a step next to the peak, as a grid is on average.

    One from dead centre on might meet the peak by luck; `ends` are examined, too.
    """
    step = (high - low) / points
    inner = low + step * (np.arange(points) + ((peak - low) / step + 0.25) % 1.0)
    places = np.concatenate([[low], inner, [high]]) if ends else inner
    values = curve(places)
    best = int(np.argmax(values))
    return Highest(float(values[best]), float(places[best]), float(len(places)))


def bounded(curve: Curve, low: float, high: float, tolerance: float) -> Highest:
    """scipy's bounded search between two places."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda at: -float(curve(np.array([at]))[0]), bounds=(low, high), method="bounded",
        options={"xatol": tolerance},
    )  # fmt: skip
    return Highest(-float(found.fun), float(found.x), float(found.nfev))


def smooth_place(curve: Curve, at: float, half: float) -> float:
    """Where a polynomial through exact values next to a peak has its top, to more digits.

    The highest value alone tells the place to half the digits only.
    """
    share = np.cos(np.pi * np.arange(17) / 16)
    values = curve(at + half * share)
    fine, coarse = (
        np.polynomial.Polynomial.fit(share, values, degree, domain=[-1.0, 1.0]).deriv()
        for degree in (14, 10)
    )
    places = []
    for slope in (fine, coarse):
        turns = slope.roots()
        inside = turns.real[(np.abs(turns.imag) < 1e-9) & (np.abs(turns.real) < 1.0)]
        places.append(float(inside[np.argmin(np.abs(inside))]) if len(inside) else 0.0)
    return at + half * places[0] if abs(places[0] - places[1]) < 1e-6 else at


def _top_of(curve: Curve, low: float, high: float) -> Reference:
    places = np.linspace(low, high, FIRST_PLACES)
    values, step = curve(places), places[1] - places[0]
    padded = np.pad(values, 1, constant_values=-np.inf)
    tops = np.flatnonzero((values >= padded[:-2]) & (values >= padded[2:]))
    found = [Highest(float(values[k]), float(places[k]), 0) for k in (0, FIRST_PLACES - 1)]
    for k in tops[np.argsort(-values[tops])][:RIVALS].tolist():
        ends = max(low, places[k] - step), min(high, places[k] + step)
        found.append(bounded(curve, *ends, 1e-12 * max(abs(low), abs(high))))
    best = max(found, key=lambda one: one.value)
    place, inner = best.place, low + 1e-9 * (high - low) < best.place < high - 1e-9 * (high - low)
    for half in (0.3 * step, 0.03 * step, 0.003 * step) if inner else ():
        nearer = smooth_place(curve, best.place, half)
        if nearer != best.place:
            place = nearer
            break
    value = max(float(curve(np.array([place]))[0]), best.value)
    agreement = max(abs(best.value / value - 1.0), 4.0 * EPSILON)
    words = (
        f"scipy's bounded search about the highest of {FIRST_PLACES}, a polynomial through the top"
    )
    return Reference(np.array([value]), agreement, words, place)


def peak_over_range(
    ask: Ask, solvers: Sequence[Solver], curve: Curve, low: float, high: float, position: str,
    known: float, exact: Callable[[], Reference] | None = None, kind: str = "peak over a range",
    ends: bool = True, work: str = "values of the curve",
) -> Topic:  # fmt: skip
    """The highest value of `curve` (places) between two places; `known` is where ours finds it."""

    def gridded(points: float) -> Answer:
        found = grid_maximum(curve, low, high, int(points), known, ends)
        return Answer(np.array([found.value]), found.asked, found.place)

    def searched(points: float) -> Answer:
        first = grid_maximum(curve, low, high, int(points), known, ends)
        step = (high - low) / points
        near = max(low, first.place - step), min(high, first.place + step)
        found = bounded(curve, *near, 1e-10 * (high - low))
        return Answer(np.array([found.value]), first.asked + found.asked, found.place)

    plain = (
        Solver("grid", "the best of even places", "places", GRIDS, gridded, theory="order 2"),
        Solver(
            "scipy minimize_scalar", "bounded search about the best of some places", "places",
            STARTS, searched,
        ),
    )  # fmt: skip
    reference = exact or cache(lambda: _top_of(curve, low, high))
    return _topic(kind, ask, work, reference, (*solvers, *plain), position)


def peak_over_cycle(ask: Ask, rows: np.ndarray, orders: np.ndarray) -> Topic:
    """Largest length over a turn of a vector with harmonics `rows` (components, orders)."""
    used = np.any(rows != 0.0, axis=0) & (orders > 0)
    rows, orders = rows[:, used], orders[used]
    known = vector_cycle_peak(rows, orders)
    value, first = float(known.value), float(known.angle)

    def curve(angle: np.ndarray) -> np.ndarray:
        waves = np.exp(1j * np.multiply.outer(orders, angle))
        return np.asarray(np.sqrt(np.sum(np.square((rows @ waves).real), axis=0)))

    step = max(int(np.gcd.reduce(orders)), 1)
    # a vector of odd orders is as long half a turn later
    period = TURN / step * (0.5 if np.all(orders // step % 2 == 1) else 1.0)
    points = 96 * int(orders.max())
    around = curve(first + period * (np.arange(points) / points - 0.5))
    tops = (around >= np.roll(around, 1)) & (around > np.roll(around, -1))
    alone = int(np.sum(tops & (around > (1.0 - 1e-3) * value))) == 1
    needed = int(needed_orders(rows[None], orders // step)[0][0])
    work = float(SAMPLES_PER_ORDER * needed + 30) if orders.max() > step else 1.0

    def own(_: float) -> Answer:
        found = vector_cycle_peak(rows, orders)
        place = first + (float(found.angle) - first + 0.5 * period) % period - 0.5 * period
        return Answer(np.array([float(found.value)]), work, place if alone else None)

    def reference() -> Reference:
        import mpmath

        with mpmath.workdps(DIGITS):
            at = mpmath.mpf(first)
            for _ in range(6):
                square = slope = bend = mpmath.mpf(0)
                for row in rows.tolist():
                    parts = [
                        x * mpmath.expj(n * at) for n, x in zip(orders.tolist(), row, strict=True)
                    ]
                    x = mpmath.fsum(part.real for part in parts)
                    v = mpmath.fsum(
                        -n * p.imag for n, p in zip(orders.tolist(), parts, strict=True)
                    )
                    a = mpmath.fsum(
                        -n * n * p.real for n, p in zip(orders.tolist(), parts, strict=True)
                    )
                    square, slope, bend = square + x * x, slope + x * v, bend + v * v + x * a
                if not (alone and bend < 0):
                    break
                at -= slope / bend
            height = float(mpmath.sqrt(square))
        agreement = max(abs(value / height - 1.0), float(around.max()) / height - 1.0)
        words = f"Newton's method in {DIGITS} digits (mpmath); no angle of a dense grid is higher"
        return Reference(np.array([height]), agreement, words, float(at) if alone else None)

    solvers = [ours(
        "cycle_peak", "samples that cannot miss, Newton in concave cells", own,
        citation="M. Riesz (1914); Ehlich and Zeller (1964)",
    )]  # fmt: skip
    extra = max(1.0, float(np.ceil(work / 12.0)))
    why = "no maximum can be missed: every order above rounding is sampled twelvefold"
    ask = ask._replace(extra=extra, why=why if extra > 1.0 else "")
    return peak_over_range(
        ask, solvers, curve, first - 0.5 * period, first + 0.5 * period,
        "crank angle [rad]" if alone else "", first, reference, "peak over a cycle", False,
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Time histories and periodic states of equations of motion: scipy's solve_ivp, with shooting.
# ----------------------------------------------------------------------------

RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)


def integrated(
    rates: Rates, start: np.ndarray, times: np.ndarray, rtol: float, scale: np.ndarray | float,
    method: str = "DOP853", stops: np.ndarray | None = None, **more: Any,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """States (k, n) at `times` after the first, by solve_ivp anew from each of `stops`; calls.

    Raises NumericalFailure where scipy gives up.
    """
    from scipy.integrate import solve_ivp

    inner = [] if stops is None else stops[(stops > times[0]) & (stops < times[-1])].tolist()
    ends, state, found, calls = [*inner, float(times[-1])], np.array(start, float), [], 0
    now = float(times[0])
    for end in ends:
        asked = times[1:][(times[1:] > now) & (times[1:] <= end)]
        grid = asked if len(asked) and asked[-1] == end else np.append(asked, end)
        with np.errstate(all="ignore"):
            one = solve_ivp(
                rates, (now, end), state, method=method, t_eval=grid, rtol=max(rtol, 3e-14),
                atol=rtol * np.asarray(scale), **more,
            )  # fmt: skip
        if not one.success or not np.all(np.isfinite(one.y)):
            raise NumericalFailure(f"{method} at rtol {rtol:.1g} gave up: {one.message}")
        found.append(one.y.T[: len(asked)])
        state, now, calls = one.y[:, -1], end, calls + int(one.nfev)
    return np.concatenate(found), calls


def time_history(
    ask: Ask, solvers: Sequence[Solver], rates: Rates, start: np.ndarray, times: np.ndarray,
    read: Callable[[np.ndarray], np.ndarray], scale: np.ndarray | float,
    fine: Callable[[], np.ndarray], jacobian: np.ndarray | None = None,
    stops: np.ndarray | None = None, max_step: float = np.inf,
) -> Topic:  # fmt: skip
    """What `read` shows of the states at `times` (from the start on); `fine` is ours far finer."""

    def march(method: str, rtol: float) -> Answer:
        more: dict[str, Any] = {"max_step": max_step} if np.isfinite(max_step) else {}
        if method == "Radau" and jacobian is not None:
            more["jac"] = jacobian
        states, calls = integrated(rates, start, times, rtol, scale, method, **more)
        return Answer(read(states), float(calls))

    def reference() -> Reference:
        truth = fine()
        more: dict[str, Any] = {"max_step": 0.1 * max_step} if np.isfinite(max_step) else {}
        other = read(integrated(rates, start, times, 1e-13, scale, stops=stops, **more)[0])
        agreement = max(apart(truth, other), 16.0 * EPSILON)
        return Reference(truth, agreement, "ours far finer, against DOP853 of scipy at 1e-13")

    plain = [
        Solver(
            f"scipy {name}", "solve_ivp", "rtol", RTOLS if name == "DOP853" else RTOLS[:3],
            lambda rtol, name=name: march(name, rtol),  # type: ignore[misc]
        )
        for name in ("RK45", "DOP853", "Radau")
    ]  # fmt: skip
    work = "evaluations of the equations"
    return _topic("time history", ask, work, cache(reference), (*solvers, *plain))


def shot(
    rates: Rates, guess: np.ndarray, unknown: Sequence[int], times: np.ndarray, rtol: float,
    scale: np.ndarray, stops: np.ndarray | None = None, back: Sequence[int] | None = None,
    in_rows: bool = False,
) -> tuple[np.ndarray, np.ndarray, int]:  # fmt: skip
    """Start, states at `times` and calls of the motion that comes back: Newton by differences.

    `unknown` are the states to be found, `back` those that come back, the same without; rates
    `in_rows` take all starts at once. Raises NumericalFailure where they do not come back.
    """
    free = list(unknown)
    again, n, calls = free if back is None else list(back), len(guess), 0
    starts = np.repeat(guess[None].astype(float), len(free) + 1, axis=0)
    nudge = 1e-5 * scale[free]

    def marched(rows: np.ndarray, times: np.ndarray) -> np.ndarray:
        nonlocal calls
        if in_rows:
            found, used = integrated(
                lambda t, flat: rates(t, flat.reshape(-1, n)).ravel(), rows.ravel(), times, rtol,
                np.tile(scale, len(rows)), stops=stops,
            )  # fmt: skip
            calls += used * len(rows)
            return found.reshape(len(times) - 1, len(rows), n)
        every = [integrated(rates, row, times, rtol, scale, stops=stops) for row in rows]
        calls += sum(used for _, used in every)
        return np.stack([states for states, _ in every], axis=1)

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
    times: np.ndarray, read: Callable[[np.ndarray, np.ndarray], np.ndarray], scale: np.ndarray,
    fine: Callable[[], np.ndarray], stops: np.ndarray | None = None,
    rtols: Sequence[float] = (1e-4, 1e-6, 1e-8, 1e-10), back: Sequence[int] | None = None,
    in_rows: bool = False,
) -> Topic:  # fmt: skip
    """What `read` (start, states at `times`) shows of the motion that comes back at the last."""

    def shooting(rtol: float, stops: np.ndarray | None = None) -> Answer:
        given = (rates, guess, unknown, times, rtol, scale, stops, back, in_rows)
        start, states, calls = shot(*given)
        return Answer(read(start, states), float(calls))

    def reference() -> Reference:
        truth = fine()
        agreement = max(apart(truth, shooting(1e-13, stops).values), 16.0 * EPSILON)
        return Reference(truth, agreement, "ours far finer, against shooting with DOP853 at 1e-13")

    plain = Solver(
        "scipy DOP853, shooting", "Newton by differences", "rtol", tuple(rtols), shooting
    )
    work = "evaluations of the equations"
    return _topic("periodic state", ask, work, cache(reference), (*solvers, plain))


# ----------------------------------------------------------------------------
# Optima and wanted values: searches of scipy.optimize from where a user would begin.
# ----------------------------------------------------------------------------

#: a margin broken by less counts as kept
NEARLY_KEPT = 1e-6
Limited = Callable[[np.ndarray], tuple[float, np.ndarray]]


class _Spent(Exception):
    """The budget is used up."""


def within_budget(
    method: str, evaluate: Limited, bounds: list[tuple[float, float]], first: np.ndarray,
    budget: int, nearly: float = NEARLY_KEPT,
) -> tuple[np.ndarray, float, int]:  # fmt: skip
    """Best place that keeps the limits, its value, evaluations, of a search of scipy.

    Raises NumericalFailure where no point met keeps them.
    """
    from scipy.optimize import differential_evolution, minimize

    known: dict[bytes, tuple[float, np.ndarray]] = {}
    best: tuple[float, np.ndarray] = (np.inf, first)

    def at(place: np.ndarray) -> tuple[float, np.ndarray]:
        nonlocal best
        key = np.ascontiguousarray(place + 0.0).tobytes()
        if key not in known:
            if len(known) >= budget:
                raise _Spent
            try:
                found = evaluate(np.array(place))
            except NumericalFailure:
                if not known:
                    raise
                found = 1e300, np.full(len(next(iter(known.values()))[1]), -1.0)
            known[key] = found
            if np.min(found[1], initial=0.0) >= -nearly and found[0] < best[0]:
                best = found[0], np.array(place)
        return known[key]

    size = abs(at(first)[0]) or 1.0

    def penalised(place: np.ndarray) -> float:
        value, margins = at(place)
        return value / size + 10.0 * float(np.sum(np.maximum(-margins, 0.0)))

    try:
        with np.errstate(all="ignore"):
            if method == "differential evolution":
                differential_evolution(
                    penalised, bounds, seed=1, maxiter=100000, tol=0.0, polish=False, x0=first,
                    popsize=5,
                )  # fmt: skip
            elif method == "Nelder-Mead":
                options = {"maxiter": budget, "xatol": 1e-13, "fatol": 1e-16}
                minimize(penalised, first, method=method, bounds=bounds, options=options)
            else:
                limits = {"type": "ineq", "fun": lambda place: at(place)[1]}
                minimize(
                    lambda place: at(place)[0] / size, first, method=method, bounds=bounds,
                    constraints=[limits] if len(at(first)[1]) else [],
                    options={"maxiter": 100000, ("ftol" if method == "SLSQP" else "tol"): 1e-14},
                )  # fmt: skip
    except _Spent:
        pass
    if not np.isfinite(best[0]):
        raise NumericalFailure(
            f"{method} met no point that keeps all limits in {len(known)} evaluations"
        )
    return best[1], best[0], len(known)


def optimum(
    ask: Ask, solvers: Sequence[Solver], problem: Callable[[], Limited],
    bounds: list[tuple[float, float]], first: np.ndarray, shown: Callable[[float], float],
    found: Callable[[], tuple[np.ndarray, float, float]], budgets: Sequence[float],
    methods: Sequence[str], work: str, confirm: int = 60,
) -> Topic:  # fmt: skip
    """The least objective that keeps its margins; `problem` gives it, with nothing remembered.

    `found` is the place, objective and relative error of ours; a plain search from four digits of
    the place, with `confirm` evaluations, confirms a local optimum and not that it is the best.
    """

    def searched(method: str, budget: float) -> Answer:
        _, value, asked = within_budget(method, problem(), bounds, first, int(budget))
        return Answer(np.array([shown(value)]), float(asked))

    def reference() -> Reference:
        place, value, error = found()
        low, high = np.array(bounds).T
        near = np.clip(np.array([float(f"{one:.3e}") for one in place]), low, high)
        for method in methods:  # one may meet no point that keeps all limits
            with contextlib.suppress(NumericalFailure):
                again = within_budget(method, problem(), bounds, near, confirm, 1e-10)[1]
                break
        else:
            raise NumericalFailure(f"none of {', '.join(methods)} confirms the optimum")
        size = abs(value) or 1.0
        words = f"ours; {method} from four digits of it confirms a local optimum"
        return Reference(
            np.array([shown(value)]), max(abs(again - value) / size, error / size, EPSILON), words
        )

    plain = [
        Solver(
            f"scipy {name}", "the best point met", "evaluations", tuple(budgets),
            lambda budget, name=name: searched(name, budget),  # type: ignore[misc]
        )
        for name in methods
    ]  # fmt: skip
    return _topic("optimum", ask, work, cache(reference), (*solvers, *plain))


def wanted_value(
    ask: Ask, solvers: Sequence[Solver], fresh: Callable[[], Callable[[float], float]], low: float,
    high: float, found: Callable[[], float], before: int = 0,
) -> Topic:  # fmt: skip
    """The key at which a function is zero; `before` counts what was asked to set it up."""

    def brent(tolerance: float, low: float = low, high: float = high) -> Answer:
        from scipy.optimize import brentq

        off, asked = fresh(), [0]

        def counted(key: float) -> float:
            asked[0] += 1
            return off(key)

        try:
            key = brentq(
                counted, low, high, xtol=tolerance * abs(high), rtol=max(tolerance, 4.0 * EPSILON)
            )
        except ValueError as error:
            raise NumericalFailure(f"no root is known between the bounds: {error}") from error
        return Answer(np.array([float(key)]), float(asked[0] + before))

    def reference() -> Reference:
        key = found()
        near = max(key * (1.0 - 1e-3), low), min(key * (1.0 + 1e-3), high)
        again = float(brent(1e-14, *near).values[0])
        words = "ours; Brent's method of scipy around it confirms it, not that there is no other"
        return Reference(np.array([key]), max(abs(again / key - 1.0), UNIT_ROUNDOFF), words)

    plain = Solver(
        "scipy brentq", "between the bounds", "tolerance", (1e-2, 1e-4, 1e-8, 1e-12), brent
    )
    work = "evaluations of the case"
    return _topic("optimum", ask, work, cache(reference), (*solvers, plain))
