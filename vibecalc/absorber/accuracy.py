"""Questions of absorbers: highest peak, its least by tuning, order of a pendulum's swing."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vibecalc.absorber.adapters.response import family, frequency_ratios
from vibecalc.absorber.adapters.several import STARTS
from vibecalc.absorber.model import build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.pendulum_order import build_pendulum, order_of_swing, terms, tuning_order
from vibecalc.absorber.several import Several, several_amplitude
from vibecalc.absorber.several_peaks import several_peaks
from vibecalc.absorber.stage import asked_of
from vibecalc.absorber.transfer import Absorber, amplitude, transfer_of
from vibecalc.absorber.tuning.closed_forms import METHODS
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import pure_viscous
from vibecalc.absorber.tuning.several import several_tuning
from vibecalc.core.accuracy.kinds import Ask, optimum, ours, peak_over_range, periodic
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import FloatArray

#: what all peaks of one absorber take, in evaluations of |H|: jets, signs of Sturm's chain, poles
ONE, EACH = 120.0, 400.0
Pair = tuple[str, str]


class System(NamedTuple):
    """Ratios (n,) of absorbers on a primary, each on the mass of `parent` (0: the primary)."""

    primary_damping: float
    mass_ratio: FloatArray
    stiffness_ratio: FloatArray
    secondary_damping: FloatArray
    parent: tuple[int, ...]

    def single(self) -> Absorber:
        """As one absorber."""
        m, k, z2 = (float(part[0]) for part in self[1:4])
        return Absorber(self.primary_damping, m, k, z2)

    def highest(self, pair: Pair) -> tuple[float, float]:
        """Height and place of the highest peak, as a run finds them."""
        if len(self.mass_ratio) == 1:
            one = peaks(self.single(), *pair)
            return float(one.largest), float(one.where)
        many = several_peaks(Several(*self), *pair)
        return float(many.largest), float(many.where)

    def magnitude(self, pair: Pair, x: FloatArray) -> FloatArray:
        """|H| at frequency ratios (points,)."""
        if len(self.mass_ratio) == 1:
            return np.asarray(np.abs(amplitude(self.single(), x, *pair)))
        return np.asarray(np.abs(several_amplitude(Several(*self), x, *pair)))


def absorber_topics(scene: Scene) -> list[Topic]:
    """The highest peak of the first curve that has a finite one within the frequencies drawn."""
    case, pair = scene.case, asked_of(scene.case)
    if case.response is None or case.response.absorber is None or not _of_primary(pair):
        return []
    options, parts = case.response.absorber, build_absorber(case)
    ratios = frequency_ratios(options, parts)
    low, high = float(ratios[0]), float(ratios[-1])
    if parts.branches:
        one = scene.handed_on.get("several")
        curves = [] if one is None else [System(*one[:5])]
    else:
        found = family(case, options, parts, scene.handed_on.get("tuned")).absorber
        rows = zip(*(np.asarray(part, dtype=float).tolist() for part in found), strict=True)
        curves = [System(row[0], *_alone(row[1:]), (0,)) for row in rows]
    for system in curves:
        if not np.all(np.isfinite(system.stiffness_ratio)):
            continue
        height, place = system.highest(pair)
        if np.isfinite(height) and low < place < high:
            return [_highest(system, pair, (low, high), place)]
    return []


def _alone(ratios: Iterable[Any]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, stiffness and damping ratio of one absorber, each (1,)."""
    m, k, z2 = (np.atleast_1d(np.asarray(part, dtype=float)) for part in ratios)
    return m, k, z2


def _of_primary(pair: Pair) -> bool:
    return transfer_of(*pair).motion == "primary"


def _highest(system: System, pair: Pair, ends: tuple[float, float], known: float) -> Topic:
    height, _ = system.highest(pair)
    x = np.linspace(*ends, 20001)
    curve = system.magnitude(pair, x)
    tops = (curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])
    # peaks of a tuned absorber are equal, so that the highest has no one place
    alone = int(np.sum(tops & (curve[1:-1] > 0.99 * height))) == 1
    n = len(system.mass_ratio)

    def own(_: float) -> Answer:
        found, place = system.highest(pair)
        return Answer(np.array([found]), ONE if n == 1 else EACH * n**2, place)

    ask = Ask("absorber", "highest peak", f"of the first curve, {pair[0]} to {pair[1]}",
              "response/absorber/largest", "", 12.0 if n == 1 else 30.0 * n**2,
              "every peak is found, with a proof that there is no other")  # fmt: skip
    solver = ours(
        "all peaks", "Newton's method on |H|^2 from the poles, signs of a polynomial", own
    )
    return peak_over_range(ask, [solver], lambda x: system.magnitude(pair, x), *ends,
                           "frequency ratio []" if alone else "", known)  # fmt: skip


def tuning_topics(scene: Scene) -> list[Topic]:
    """The least highest peak, for absorbers on the primary tuned for it."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    if options is None or options.norm != "h_infinity" or (options.bounds and parts.branches):
        return []
    pair = options.excitation, options.response
    if options.kind not in ("free", "viscous") or not _of_primary(pair):
        return []
    if parts.branches:
        system = System(*scene.handed_on["several"][:5])
        if any(system.parent):
            return []
    else:
        tuned = scene.handed_on["tuned"]
        system = System(parts.primary_damping, *_alone(tuned[1:]), (0,))
    if not np.all(np.isfinite([system.stiffness_ratio, system.secondary_damping])):
        return []
    z1, m, spring, n = (
        system.primary_damping,
        system.mass_ratio,
        options.kind == "free",
        len(system[1]),
    )

    def at(place: FloatArray) -> System:
        """The system with logarithms of all k (with a spring), then of all z2."""
        values = np.exp(place)
        k = values[:n] if spring else system.stiffness_ratio
        return system._replace(stiffness_ratio=k, secondary_damping=values[-n:])

    @cache
    def run(starts: float) -> tuple[float, float, tuple[float, ...]]:
        if n > 1:
            several = several_tuning(z1, m, system.parent, *pair, starts=int(starts))
            tuning = *several.stiffness_ratio.tolist(), *several.secondary_damping.tolist()
            return float(several.peak), float(several.evaluations), tuning
        if not spring:
            line = pure_viscous(z1, float(m[0]), *pair)
            work = float(np.max(line.evaluations))
            return float(line.largest), work, (float(np.ravel(line.value)[0]),)
        one = minimax(z1, float(m[0]), *pair)
        tuning = float(one.stiffness_ratio), float(one.secondary_damping)
        return float(one.largest), float(one.evaluations), tuning

    def own(starts: float) -> Answer:
        return Answer(np.array([run(starts)[0]]), run(starts)[1])

    def problem() -> Callable[[FloatArray], tuple[float, FloatArray]]:
        return lambda place: (_looked_up(at(place), pair), np.zeros(0))

    many = n > 1
    ask = Ask(
        "tuning",
        "least peak",
        f"{n} absorber{'s' * many}, {pair[0]} to {pair[1]}",
        "tuning/peak",
        "",
        float(STARTS + 4) if many else 2.0,
        "the global one as its starts are many" if many else "proven, to rounding",
    )
    solver = ours("Newton's method on the balance of peaks", "levels of all peaks", own,
                  "starts" if many else "", (1, 2, 4, 8) if many else (1,), STARTS if many else 1,
                  citation="Nishihara and Asami (2002) for z1 = 0")  # fmt: skip
    last = float(STARTS if many else 1)
    first = _first_place(m, spring)
    return [optimum(
        ask, [solver], problem, [(value - 1.0, value + 1.0) for value in first], first, float,
        lambda: (np.log(run(last)[2]), run(last)[0], 0.0), (20, 40, 80, 160, 320),
        ("Nelder-Mead", "differential evolution"), "tunings whose peaks are evaluated",
        300 * n,
    )]  # fmt: skip


def _looked_up(system: System, pair: Pair) -> float:
    """The highest peak as a user finds it: even frequencies, finer ones, a parabola."""
    x = np.linspace(0.0, 2.0, 801)
    curve = system.magnitude(pair, x)
    tops = np.flatnonzero((curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:])) + 1
    best = float(np.max(curve))
    for top in tops[np.argsort(-curve[tops])][: len(system.mass_ratio) + 1].tolist():
        near = system.magnitude(pair, np.linspace(x[top - 1], x[top + 1], 81))
        middle = min(max(int(np.argmax(near)), 1), 79)
        low, mid, high = near[middle - 1 : middle + 2]
        bend = 2.0 * mid - low - high
        best = max(best, float(mid + (high - low) ** 2 / (8.0 * bend) if bend > 0.0 else mid))
    return best


def _first_place(m: FloatArray, spring: bool) -> FloatArray:
    """Where a user would begin: the closed form for the mass of all, springs spread apart."""
    whole = np.asarray(np.sum(m))
    if not spring:
        return np.asarray(np.log(METHODS["lanchester"].formula(whole)[1] * m / whole))
    k, z2, _ = METHODS["den_hartog_brock"].formula(whole)
    apart = np.linspace(0.9, 1.1, len(m)) if len(m) > 1 else np.ones(1)
    each = k * m / whole * apart, z2 * m / whole / np.sqrt(len(m))
    return np.asarray(np.log(np.concatenate(each)))


def pendulum_topics(scene: Scene) -> list[Topic]:
    """The order of free swings at the largest swing of the case."""
    parts = build_pendulum(scene.case)
    if not np.any(parts.swings > 0.0):
        return []
    pendulum, swing = parts.pendulum, float(parts.swings.max())
    circle = float(np.asarray(pendulum.path_exponent)) == 0.0

    def own(_: float) -> Answer:
        work = 1.0 if circle else 48.0 * 21.0
        return Answer(np.atleast_1d(order_of_swing(pendulum, np.array([swing])).value), work)

    def rates(_: float, state: FloatArray) -> FloatArray:
        """Angle, its speed and the period, over a time that is 1 after a period."""
        at, period = terms(pendulum, state[0]), state[2]
        pull = 0.5 * at.carried_slope - 0.5 * at.swing_slope * state[1] ** 2
        return np.array([period * state[1], period * pull / at.swing, 0.0])

    tuned = float(tuning_order(pendulum).value)
    words = f"at a swing of {np.degrees(swing):.4g} degrees"
    ask = Ask("pendulum", "order of swing", words, "pendulum/order_of_swing", "")
    solver = ours("mean of the swing", "arithmetic-geometric mean, or a midpoint rule", own,
                  citation="Gauss; docs/theory_absorber.md")  # fmt: skip
    guess, size = (
        np.array([swing, 0.0, 2.0 * np.pi / tuned]),
        np.array([swing, tuned, 2.0 * np.pi / tuned]),
    )
    return [periodic(ask, [solver], rates, guess, (2,), np.linspace(0.0, 1.0, 3),
                     lambda start, _: np.array([2.0 * np.pi / start[2]]), size,
                     lambda: own(1.0).values, back=(1,))]  # fmt: skip
