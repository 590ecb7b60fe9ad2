"""Questions of absorbers: highest peak, its least by tuning, order of a pendulum's swing."""

from functools import partial

import numpy as np

from vibecalc.absorber.adapters.motion import absorbers_of
from vibecalc.absorber.adapters.response import family, frequency_ratios, on_modes
from vibecalc.absorber.adapters.several import system_of
from vibecalc.absorber.modal import Fitted, fitted, highest, magnitude, on_one_mode, one_mode
from vibecalc.absorber.model import build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.pendulum_order import build_pendulum, order_of_swing, terms, tuning_order
from vibecalc.absorber.stage import asked_of
from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.absorber.tuning.band import STARTS, band_tuning
from vibecalc.absorber.tuning.closed_forms import METHODS
from vibecalc.absorber.tuning.levels import BandProblem
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import pure_viscous
from vibecalc.core.accuracy.kinds import Optimal, optimum, peak_over_range, periodic, top_of_samples
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import FloatArray

#: what all peaks of one absorber take, in evaluations of |H|: jets, signs of Sturm's chain, poles
ONE, EACH = 120.0, 400.0
Pair = tuple[str, str]


def _highest_peak(system: Fitted, pair: Pair) -> tuple[float, float]:
    """Height and place of the highest peak, as a run of one absorber or of several finds them."""
    if len(system.carrier) == 1:
        z1 = float(system.modes.damping[0, 0])
        one = peaks(Absorber(z1, *(float(part[0, 0]) for part in system[1:4])), *pair)
        return float(one.largest), float(one.where)
    height, _, place = highest(system, *pair)
    return float(height[0]), float(place[0])


def _magnitude(system: Fitted, pair: Pair, x: FloatArray) -> FloatArray:
    """|H| at frequency ratios (points,)."""
    return np.asarray(np.abs(magnitude(system, x, *pair)[0][0]))


def absorber_topics(scene: Scene) -> list[Topic]:
    """The highest peak of the first curve that has a finite one within the frequencies drawn."""
    case, pair = scene.case, asked_of(scene.case)
    if case.response is None or case.response.absorber is None or not _of_primary(pair):
        return []
    options, parts = case.response.absorber, build_absorber(case)
    ratios = frequency_ratios(options, parts)
    low, high = float(ratios[0]), float(ratios[-1])
    if parts.branches:
        tuned = scene.handed_on.get("several") is not None
        curves = [system_of(parts, *absorbers_of(scene, parts)[:2])] if tuned else []
    else:
        found = family(case, options, parts, scene.handed_on.get("tuned")).absorber
        curves = on_modes(found)
    for system in curves:
        if np.all(np.isfinite(system.stiffness)):
            height, place = _highest_peak(system, pair)
            if np.isfinite(height) and low < place < high:
                return [_highest(system, pair, (low, high), place)]
    return []


def _of_primary(pair: Pair) -> bool:
    return transfer_of(*pair).motion == "primary"


def _highest(system: Fitted, pair: Pair, ends: tuple[float, float], known: float) -> Topic:
    height, _ = _highest_peak(system, pair)
    curve = _magnitude(system, pair, np.linspace(*ends, 20001))
    tops = (curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])
    # peaks of a tuned absorber are equal, so that the highest has no one place
    alone = int(np.sum(tops & (curve[1:-1] > 0.99 * height))) == 1
    n = len(system.carrier)

    def own(_: float) -> Answer:
        found, place = _highest_peak(system, pair)
        return Answer(found, ONE if n == 1 else EACH * n**2, place)

    ask = Ask("highest peak", f"of the first curve, {pair[0]} to {pair[1]}",
              "response/absorber/largest", 12.0 if n == 1 else 30.0 * n**2,
              "every peak is found, with a proof that there is no other")  # fmt: skip
    position, magnitude = "frequency ratio []" if alone else "", partial(_magnitude, system, pair)
    return peak_over_range(ask, Solver("all peaks", own), magnitude, ends, known, position)


def tuning_topics(scene: Scene) -> list[Topic]:
    """The least highest peak, for absorbers on the primary tuned for it."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    if options is None or options.norm != "h_infinity" or (options.bounds and parts.branches):
        return []
    pair = options.excitation, options.response
    if options.kind not in ("free", "viscous") or not _of_primary(pair):
        return []
    if parts.branches:
        system = system_of(parts, *absorbers_of(scene, parts)[:2])
    else:
        system = on_one_mode(scene.handed_on["tuned"])
    if max(system.carrier) >= 0 or not np.all(np.isfinite(system.stiffness)):
        return []
    z1, m = parts.primary_damping, system.mass[0]
    spring, n, many = options.kind == "free", len(m), len(m) > 1

    def search(starts: float) -> Optimal:
        if many:
            found = band_tuning(BandProblem(one_mode(z1, n), m, *pair), int(starts))
            tuning = *found.stiffness_ratio.tolist(), *found.secondary_damping.tolist()
            return Optimal(np.log(tuning), found.largest, 0.0, float(found.evaluations))
        if not spring:
            line = pure_viscous(z1, float(m[0]), *pair)
            work = float(np.max(line.evaluations))
            return Optimal(np.log(np.ravel(line.value)[:1]), float(line.largest), 0.0, work)
        one = minimax(z1, float(m[0]), *pair)
        place = np.log([float(one.stiffness_ratio), float(one.secondary_damping)])
        return Optimal(place, float(one.largest), 0.0, float(one.evaluations))

    def looked_up(place: FloatArray) -> tuple[float, FloatArray]:
        """The highest peak at logarithms of all k (with a spring), then of all z2."""
        values = np.exp(place)
        k = values[:n] if spring else system.stiffness[0]
        at = fitted(one_mode(z1, n), m, k, values[-n:])
        return _looked_up(at, pair), np.zeros(0)

    ask = Ask("least peak", f"{n} absorber{'s' * many}, {pair[0]} to {pair[1]}", "tuning/peak",
              float(STARTS[1] + 4) if many else 2.0,
              "the global one as its starts are many" if many else "proven, to rounding",
              )  # fmt: skip
    ours = Solver("Newton's method on the balance of peaks", search)
    if many:
        ours = ours._replace(setting="starts", settings=(1, 2, 4, 8), default=STARTS[1])
    first = _first_place(m, spring)
    return [optimum(
        ask, ours, lambda: looked_up, [(one - 1.0, one + 1.0) for one in first], first,
        (20, 40, 80, 160, 320), ("Nelder-Mead", "differential evolution"),
        "tunings whose peaks are evaluated", confirm=300 * n,
    )]  # fmt: skip


def _looked_up(system: Fitted, pair: Pair) -> float:
    """The highest peak as a user finds it: even frequencies, finer ones, a parabola."""
    x = np.linspace(0.0, 2.0, 801)
    curve = _magnitude(system, pair, x)
    tops = np.flatnonzero((curve[1:-1] >= curve[:-2]) & (curve[1:-1] > curve[2:])) + 1
    tops = tops[np.argsort(-curve[tops])][: len(system.carrier) + 1]
    near = np.linspace(x[tops - 1], x[tops + 1], 81)
    fine = _magnitude(system, pair, near.ravel()).reshape(near.shape)
    return float(np.max(top_of_samples(fine), initial=np.max(curve)))


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
        """Angle, its speed and the period in rows, over a time that is 1 after a period."""
        angle, speed, period = state.T
        at = terms(pendulum, angle)
        pull = 0.5 * at.carried_slope - 0.5 * at.swing_slope * speed**2
        return np.stack([period * speed, period * pull / at.swing, 0.0 * period], axis=-1)

    tuned = float(tuning_order(pendulum).value)
    ask = Ask("order of swing", f"at a swing of {np.degrees(swing):.4g} degrees",
              "pendulum/order_of_swing")  # fmt: skip
    turn = 2.0 * np.pi / tuned
    guess, size = np.array([swing, 0.0, turn]), np.array([swing, tuned, turn])
    return [periodic(
        ask, [Solver("mean of the swing", own)], rates, guess, (2,), (1,), np.linspace(0.0, 1.0, 3),
        lambda start, _: np.array([2.0 * np.pi / start[2]]), size, lambda: own(1.0).values,
    )]  # fmt: skip
