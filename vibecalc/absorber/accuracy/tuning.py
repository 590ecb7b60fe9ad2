"""Accuracy of the tuning: the least highest peak, and the spring and damper that bring it."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.accuracy.by_other_means import (
    Question,
    System,
    first_place,
    grid_of,
    highest,
    is_of_primary,
    least_highest_peak,
    rounded,
    true_peak,
)
from vibecalc.absorber.adapters.several import STARTS
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.tuning.closed_forms import METHODS
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import pure_viscous
from vibecalc.absorber.tuning.several import several_tuning
from vibecalc.core.accuracy.other_searches import Searched, evolution, least_ceiling, nelder_mead
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene

# ----------------------------------------------------------------------------
# Topics of the stage "tuning": the least highest peak, and the spring and damper that bring it.
# ----------------------------------------------------------------------------

_STAGE = "tuning"
_NEWTON = "Newton's method on the balance of peaks"
_WHY_CLOSED = (
    "the closed form holds for an undamped primary only; the default starts from it and adds the "
    "steps that hold for any damping"
)
_WHY_STARTS = (
    "a minimax of several absorbers is as surely the global one as its starts are many; the best "
    "four of their ends are followed to the last digits"
)
_FINALISTS = 4

#: a place of a search to what is asked of it
Reading = Callable[[System], np.ndarray]


class _Found(NamedTuple):
    """A tuning, its peak where the method gives it, and tunings whose peaks were evaluated."""

    system: System
    work: float
    peak: float | None = None


def absorber_tuning_topics(scene: Scene) -> list[Topic]:
    """Least highest peak and its tuning, for absorbers on the primary tuned for it."""
    options, parts = scene.case.tuning, build_absorber(scene.case)
    if options is None or options.norm != "h_infinity" or (options.bounds and parts.branches):
        return []
    pair = options.excitation, options.response
    if options.kind not in ("free", "viscous") or not is_of_primary(*pair):
        return []
    record = scene.record
    if "tuning/active/frequency_ratio" not in record.quantities:
        return []
    system = _system(scene, parts, pair)
    if system is None:
        return []
    places, weights = (
        np.asarray(record[f"tuning/active/{name}"].values) for name in ("frequency_ratio", "weight")
    )
    question = Question(system, options.kind == "free")
    if not len(places):
        return []
    truth = _reference(question, places, weights)
    solvers = _solvers(question)
    many = len(system.mass_ratio) > 1
    exact = not many and system.primary_damping == 0.0 and pair == ("force", "displacement")
    extra, why = 1.0, ""
    if many:
        extra, why = float(STARTS + _FINALISTS), _WHY_STARTS
    elif exact:
        extra, why = float(record["tuning/evaluations"].values), _WHY_CLOSED
    made = []
    for name, words, quantity, reading in (
        ("least peak", "the largest response of the tuning found", "tuning/peak", _peak),
        ("tuning", "frequency ratio and damping ratio of each absorber", "tuning/", _tuning),
    ):
        made.append(
            Topic(
                stage=_STAGE,
                name=name,
                words=f"{words}, {pair[0]} to {pair[1]}; peaks are read exactly, which is no work",
                quantity=quantity,
                unit="",
                work="tunings whose highest peaks are evaluated",
                reference=truth[name],
                solvers=tuple(one(reading) for one in solvers),
                default_extra=extra,
                default_why=why,
            )
        )
    return made


def _system(scene: Scene, parts: AbsorberParts, pair: tuple[str, str]) -> System | None:
    """Ratios with the tuning found; None for absorbers that hang on one another."""
    z1 = parts.primary_damping
    if parts.branches:
        found = scene.handed_on["several"]
        if any(found.parent):
            return None
        return System(z1, found.mass_ratio, found.stiffness_ratio, found.secondary_damping,
                      found.parent, *pair)  # fmt: skip
    tuned = scene.handed_on["tuned"]
    ratios = [np.atleast_1d(np.asarray(part, dtype=float)) for part in tuned[1:]]
    return System(z1, ratios[0], ratios[1], ratios[2], (0,), *pair)


def _reference(
    question: Question, places: np.ndarray, weights: np.ndarray
) -> dict[str, Callable[[], Reference]]:
    """Newton's method in many digits, from the tuning cut to four."""

    @cache
    def solved() -> tuple[System, float, float]:
        own = question.system
        begin = own._replace(
            stiffness_ratio=rounded(np.asarray(own.stiffness_ratio)),
            secondary_damping=rounded(np.asarray(own.secondary_damping)),
        )
        found = least_highest_peak(begin, question.spring, rounded(places), rounded(weights))
        count, place = len(own.mass_ratio), np.array(found.place)
        exact = own._replace(stiffness_ratio=place[:count], secondary_damping=place[count:])
        return exact, found.value, found.agreement

    words = "balance of the active peaks in 50 digits, from the tuning cut to four; held against 34"

    def peak() -> Reference:
        _, value, agreement = solved()
        return Reference(np.array([value]), agreement, words)

    def tuning() -> Reference:
        system, _, agreement = solved()
        return Reference(_tuning(system), 4.0 * agreement, words)

    return {"least peak": peak, "tuning": tuning}


def _peak(system: System) -> np.ndarray:
    return np.array([true_peak(system)])


def _tuning(system: System) -> np.ndarray:
    """sqrt(k / m) and z2 / sqrt(m k) of each, by rising frequency; z2 / m without a spring."""
    m, k, z2 = (np.asarray(part, dtype=float) for part in system[1:4])
    if not np.any(k):
        return np.asarray(z2 / m)
    pairs = np.stack([np.sqrt(k / m), z2 / np.sqrt(m * k)], axis=-1)
    return np.asarray(pairs[np.argsort(pairs[:, 0])].reshape(-1))


def _solvers(question: Question) -> list[Callable[[Reading], Solver]]:
    """Every method, each still to be given what is read of its tuning."""
    system, first = question.system, first_place(question)
    count = len(system.mass_ratio)
    levels = highest(question, count + 1)
    box = [(value - 1.0, value + 1.0) for value in first]

    def top(place: np.ndarray) -> float:
        return float(np.max(levels(place)))

    def searched(search: Callable[[float], Searched]) -> Callable[[float], _Found]:
        def found(setting: float) -> _Found:
            end = search(setting)
            return _Found(question.at(end.place), end.evaluations)

        return found

    generations = (2.0, 5.0, 10.0, 20.0) if count == 1 else (2.0, 4.0, 8.0, 12.0)
    rows = [
        _own(question),
        ("SLSQP of scipy", "least t above the highest peaks", "tolerance",
         (1e-2, 1e-4, 1e-6, 1e-9, 1e-12), searched(lambda t: least_ceiling(levels, first, t)),
         None, ""),
        ("Nelder-Mead of scipy", "simplex on the largest peak, at most 600 evaluations",
         "tolerance", (1e-2, 1e-3, 1e-4, 1e-6),
         searched(lambda t: nelder_mead(top, first, t)), None, ""),
        ("differential evolution of scipy", "population in a box of e about the closed form",
         "generations", generations, searched(lambda n: evolution(top, box, int(n))), None, ""),
    ]  # fmt: skip
    if count == 1:
        rows.append(
            ("grid", "least of the largest over a grid in spring, damper and frequency", "step",
             (0.02, 0.01, 0.005, 0.002, 0.001), lambda h: _on_grid(question, h), None,
             "Baca Vasquez (2007), Appendix I")
        )  # fmt: skip
        names = ("den_hartog_brock", "nishihara_asami") if question.spring else ("lanchester",)
        rows += [_closed(question, name) for name in names]
    return [_solver(*row) for row in rows]


_Row = tuple[str, str, str, tuple[float, ...], Callable[[float], _Found], float | None, str]


def _solver(
    name: str, words: str, setting: str, settings: tuple[float, ...],
    find: Callable[[float], _Found], default: float | None, citation: str,
) -> Callable[[Reading], Solver]:  # fmt: skip
    def reported(reading: Reading) -> Solver:
        def solve(at: float) -> Answer:
            found = find(at)
            known = found.peak is not None and reading is _peak
            return Answer(np.array([found.peak]) if known else reading(found.system), found.work)

        return Solver(name, words, setting, settings, solve, default, citation=citation)

    return reported


def _own(question: Question) -> _Row:
    system = question.system
    pair = system.excitation, system.response
    z1, m = system.primary_damping, np.asarray(system.mass_ratio, dtype=float)

    def one(_: float) -> _Found:
        if not question.spring:
            line = pure_viscous(z1, float(m[0]), *pair)
            done = system._replace(secondary_damping=np.atleast_1d(line.value))
            return _Found(done, float(np.max(line.evaluations)), float(line.largest))
        found = minimax(z1, float(m[0]), *pair)
        done = system._replace(
            stiffness_ratio=np.atleast_1d(found.stiffness_ratio),
            secondary_damping=np.atleast_1d(found.secondary_damping),
        )
        return _Found(done, float(found.evaluations), float(found.largest))

    def many(starts: float) -> _Found:
        found = several_tuning(z1, m, system.parent, *pair, starts=int(starts))
        done = system._replace(
            stiffness_ratio=found.stiffness_ratio, secondary_damping=found.secondary_damping
        )
        return _Found(done, float(found.evaluations), found.peak)

    if len(m) > 1:
        words = "descents on the levels of all peaks, the best ends by Newton's method"
        settings = (1.0, 2.0, 4.0, 8.0, float(STARTS))
        return (_NEWTON, words, "starts", settings, many, float(STARTS), "")
    words = "peaks and tuning together, from an undamped primary"
    if not question.spring:
        words = "exact peaks along the damping, then Newton's method"
    return (_NEWTON, words, "", NOTHING_TO_SET, one, 1.0, "Nishihara and Asami (2002) for z1 = 0")


def _on_grid(question: Question, step: float) -> _Found:
    place, count = grid_of(question, step)
    return _Found(question.at(place), float(count))


def _closed(question: Question, name: str) -> _Row:
    method = METHODS[name]

    def find(_: float) -> _Found:
        k, z2, _promised = method.formula(np.asarray(question.system.mass_ratio, dtype=float))
        return _Found(question.system._replace(stiffness_ratio=k, secondary_damping=z2), 1.0)

    return (f"closed form {name}", method.validity, "", NOTHING_TO_SET, find, None, method.source)
