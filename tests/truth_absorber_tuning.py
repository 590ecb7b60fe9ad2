"""What stands below `tuning/` of a primary with absorbers, in many digits.

The truth of a tuning starts where the run ended and is Newton's, on the conditions of the optimum:
it says how far the run is off, not that no other optimum is better.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from exact_mean_square import exact_mean_square
from exact_tree import Held, Tree, peaks, polished, tree
from mpmath import matrix, mp, mpf

from vibecalc.absorber.model import AbsorberParts
from vibecalc.core.results.record import Record
from vibecalc.schema import Case

TRAVEL = "relative_displacement"
SQUARES = {
    ("force", "displacement"): "displacement", ("force", "velocity"): "velocity",
    ("force", "transmitted_force"): "transmitted", ("base", "transmitted_force"): "base",
}  # fmt: skip
#: entries of a map, and of a curve, that are examined
_LOOKS = 6
#: path, values, truth, and size where it is not that of the truth
Truth = tuple[str, Any, Any, float | None]


class NoTruth(Exception):
    """The tuning is one of many, or held by an end of the frequency range."""


def best_of(case: Case, record: Record, parts: AbsorberParts) -> tuple[Tree, Held | None]:
    """The tuned system in many digits; Held where peaks hold it. NoTruth where there is none."""
    assert case.tuning is not None
    pair, z1 = (case.tuning.excitation, case.tuning.response), parts.primary_damping
    if parts.branches:
        m = [branch.mass_ratio for branch in parts.branches]
        parent = tuple(branch.carrier + 1 for branch in parts.branches)
        k, z = (record[f"tuning/each/{n}"].values for n in ("stiffness_ratio", "secondary_damping"))
    else:
        assert parts.absorber is not None
        m, parent = [float(np.asarray(parts.absorber.mass_ratio))], (0,)
        k, z = (
            record[f"tuning/{name}"].values.reshape(1)
            for name in ("stiffness_ratio", "secondary_damping")
        )
        if case.tuning.norm == "h2":
            return _least_squares(pair, z1, m[0], float(k[0]), float(z[0])), None
        if case.tuning.kind == "lanchester":
            return _lanchester(record, z1, mpf(m[0]))
    if not np.any(k) and not np.any(z):
        return tree(z1, m, k, z, parent), None
    start = [x for x in (*k, *z) if x > 0.0]
    active = [
        record[f"tuning/active/{name}"].values if f"tuning/active/{name}" in record else ()
        for name in ("frequency_ratio", "weight")
    ]
    if not len(active[0]):
        raise NoTruth
    given = np.concatenate([k, z])

    def build(ratios: list[Any]) -> Tree:
        rest = iter(ratios)
        full = [next(rest) if value > 0.0 else mpf(0) for value in given]
        here = tree(z1, m, k, z, parent)
        return here._replace(k=tuple(full[: len(m)]), z2=tuple(full[len(m) :]))

    try:
        held = polished(build, pair, start, *active)
    except ArithmeticError as error:
        raise NoTruth from error
    return build(held.ratios), held


def _lanchester(record: Record, z1: float, m: mpf) -> tuple[Tree, Held]:
    best = Tree(mpf(z1), (m,), (mpf(0),), (m / mp.sqrt(2 * (1 + m) * (2 + m)),), (0,))
    near = record["tuning/active/frequency_ratio"].values
    return best, polished(lambda _: best, ("force", "displacement"), [], near, [1.0])


def _least_squares(pair: tuple[str, str], z1: float, m: float, k: float, z: float) -> Tree:
    """Newton's method on the logarithm of the mean square, by the ratios that are not zero."""
    kind = SQUARES[pair]
    free = [value for value in (k, z) if value > 0.0]
    at, h = [mp.log(mpf(value)) for value in free], mpf(10) ** (-mp.dps // 4)

    def level(place: list[mpf]) -> mpf:
        ratios = [mp.exp(p) for p in place]
        return mp.log(exact_mean_square(kind, z1, m, mpf(0) if k == 0.0 else ratios[0], ratios[-1]))

    if not free:
        return tree(z1, [m], [k], [z])
    for _ in range(12):
        n = len(at)
        slope, bend = matrix(n, 1), matrix(n, n)

        def moved(*moves: tuple[int, int], here: list[mpf] = at) -> mpf:
            other = list(here)
            for place, sign in moves:
                other[place] += sign * h
            return level(other)

        for i in range(n):
            slope[i] = (moved((i, 1)) - moved((i, -1))) / (2 * h)
            for j in range(n):
                bend[i, j] = sum(
                    a * b * moved((i, a), (j, b)) for a in (1, -1) for b in (1, -1)
                ) / (4 * h * h)  # fmt: skip
        step = mp.lu_solve(bend, slope)
        at = [a - step[i] for i, a in enumerate(at)]
        if max(abs(x) for x in step) < mpf(10) ** (-0.4 * mp.dps):
            break
    found = [mp.exp(a) for a in at]
    return tree(z1, [m], [k], [z])._replace(k=(mpf(0) if k == 0.0 else found[0],), z2=(found[-1],))


def tuning_truth(case: Case, record: Record, parts: AbsorberParts) -> Iterator[Truth]:
    """Path, values, truth and size (None: that of the truth) of what stands below `tuning/`."""
    if case.tuning is None:
        return
    try:
        best, held = best_of(case, record, parts)
    except NoTruth:
        return

    def reported(name: str, truth: Any, size: float | None = None) -> Iterator[Truth]:
        path = f"tuning/{name}"
        if path in record:
            yield path, record[path].values, truth, size

    options, pair = case.tuning, (case.tuning.excitation, case.tuning.response)
    top, bare = peaks(best, *pair), peaks(alone(best), *pair)
    yield from reported("primary_damping", best.z1)
    yield from reported("mass_ratio", best.m[0])
    yield from reported("stiffness_ratio", best.k[0])
    yield from reported("secondary_damping", best.z2[0])
    own = [z / mp.sqrt(m * k) if k > 0 else mpf(0) for m, k, z in zip(*best[1:4], strict=True)]
    yield from reported("own_damping", own[0])
    for name, values in zip(
        ("mass_ratio", "stiffness_ratio", "secondary_damping", "own_damping"),
        (*best[1:4], own), strict=True,
    ):  # fmt: skip
        yield from reported(f"each/{name}", values)
    yield from reported("peak", top.largest)
    yield from reported("peak_less_one", top.largest - 1)
    yield from reported("peak_alone", bare.largest)
    yield from reported("travel", peaks(best, pair[0], TRAVEL).largest)
    if held is not None:
        order = sorted(range(len(held.places)), key=lambda i: held.places[i])
        yield from reported("active/frequency_ratio", [mp.exp(held.places[i] / 2) for i in order])
        yield from reported("active/magnitude", [held.level] * len(order))
        yield from reported("active/weight", [held.weights[i] for i in order])
        yield from reported("certificate", mpf(0), 1.0)
    if options.norm == "h2":
        kind = SQUARES[pair]
        z1, m = float(best.z1), float(best.m[0])
        least = exact_mean_square(kind, z1, m, best.k[0], best.z2[0])
        yield from reported("mean_square", least)
    if parts.scale is not None:
        yield from _in_units(record, parts, best, reported)
    yield from _nearby(case, record, best, held, reported)


def alone(best: Tree) -> Tree:
    """The primary system alone."""
    nothing = (mpf(0),) * len(best.m)
    return best._replace(k=nothing, z2=nothing)


def _in_units(
    record: Record, parts: AbsorberParts, best: Tree, reported: Callable[..., Iterator[Truth]]
) -> Iterator[Truth]:
    assert parts.scale is not None
    inertia, stiffness = mpf(parts.scale.inertia), mpf(parts.scale.stiffness)
    kind = "torsional" if parts.scale.torsion else "linear"
    yield from reported(f"{kind}_stiffness", stiffness * best.k[0])
    yield from reported(f"{kind}_damping", 2 * mp.sqrt(inertia * stiffness) * best.z2[0])
    yield from reported(
        "secondary_frequency", mp.sqrt(stiffness / inertia) * mp.sqrt(best.k[0] / best.m[0])
    )


def _nearby(
    case: Case,
    record: Record,
    best: Tree,
    held: Held | None,
    reported: Callable[..., Iterator[Truth]],
) -> Iterator[Truth]:
    """Mistuning, the map, other methods, slopes, a chart."""
    assert case.tuning is not None
    options, pair = case.tuning, (case.tuning.excitation, case.tuning.response)

    def level(system: Tree) -> mpf:
        if options.norm == "h2":
            z1, m = float(system.z1), float(system.m[0])
            return exact_mean_square(SQUARES[pair], z1, m, system.k[0], system.z2[0])
        return peaks(system, *pair).largest

    def off(k: Any, z: Any) -> mpf:
        return level(
            best._replace(
                k=tuple(x * (1 + mpf(float(k))) for x in best.k),
                z2=tuple(x * (1 + mpf(float(z))) for x in best.z2),
            )
        )

    least = level(best) if any(best.k) or any(best.z2) else mpf(0)
    if "tuning/mistuning/loss" in record and least:
        shares = record["tuning/mistuning/loss"].axes[1].values
        rows = [[off(s, 0) / least - 1 for s in shares], [off(0, s) / least - 1 for s in shares]]
        yield from reported("mistuning/loss", rows)
    if "tuning/mistuning/worst" in record and least:
        shares = record["tuning/mistuning/worst"].axes[0].values
        signs = [(a, b) for a in (1, -1) for b in (1, -1)]
        worst = [max(off(a * s, b * s) for a, b in signs) / least - 1 for s in shares]
        yield from reported("mistuning/worst", worst)
    if "tuning/map/peak" in record and least:
        found = record["tuning/map/peak"]
        rows_, columns = (axis.values for axis in found.axes)
        random = np.random.default_rng(len(rows_))
        spots = [(int(random.integers(len(rows_))), int(random.integers(len(columns))))
                 for _ in range(_LOOKS)]  # fmt: skip
        exact = [
            peaks(best._replace(k=(mpf(float(rows_[i])),), z2=(mpf(float(columns[j])),)), *pair)
            for i, j in spots
        ]
        values = np.array([found.values[spot] for spot in spots])
        yield "tuning/map/peak", values, [one.largest for one in exact], None
    if "tuning/method/peak" in record:
        yield from _methods(case, record, best, level, reported)
    if "tuning/sensitivity/peak" in record and held is not None and len(best.m) == 1:
        yield from _slopes(record, best, held, pair, reported)


def _methods(
    case: Case, record: Record, best: Tree, level: Callable[[Tree], mpf],
    reported: Callable[..., Iterator[Truth]],
) -> Iterator[Truth]:  # fmt: skip
    assert case.tuning is not None
    pair, m = (case.tuning.excitation, case.tuning.response), best.m[0]
    if case.tuning.norm == "h2":
        return
    root = mp.sqrt(4 + 3 * m)
    tuned = 8 * (16 + 23 * m + 9 * m * m + 2 * (2 + m) * root)
    tuned = tuned / (3 * (64 + 80 * m + 27 * m * m)) / (1 + m) ** 2
    ratio = mp.sqrt(3 * m * (32 + 27 * m) / ((8 + 9 * m + 4 * root) * (1 + m))) / 4
    above = 4096 + m * (10240 + m * (9856 + m * (4320 + 729 * m)))
    below = 1024 + m * (2880 + m * (2592 + 729 * m)) + 128 * root**3
    top = peaks(best, *pair).largest
    forms = {
        "den_hartog": (
            m / (1 + m) ** 2, m * mp.sqrt(3 * m / (8 * (1 + m) ** 3)), mp.sqrt(1 + 2 / m),
        ),
        "nishihara_asami": (m * tuned, ratio * m * mp.sqrt(tuned), mp.sqrt(above / (m * below))),
        "numerical": (best.k[0], best.z2[0], top),
    }  # fmt: skip
    rows = [forms[str(name)] for name in record["tuning/method/peak"].axes[0].values]
    systems = [best._replace(k=(k,), z2=(z,)) for k, z, _ in rows]
    yield from reported("method/stiffness_ratio", [row[0] for row in rows])
    yield from reported("method/secondary_damping", [row[1] for row in rows])
    yield from reported("method/promised", [row[2] for row in rows])
    yield from reported("method/peak", [peaks(one, *pair).largest for one in systems])
    yield from reported("method/loss", [level(one) / level(best) - 1 for one in systems])


def _slopes(
    record: Record, best: Tree, held: Held, pair: tuple[str, str],
    reported: Callable[..., Iterator[Truth]],
) -> Iterator[Truth]:  # fmt: skip
    """Differences of optima in many digits."""
    h = mpf(10) ** (-mp.dps // 5)
    columns = []
    for place in (0, 1):
        ends = []
        for sign in (1, -1):
            moved = best._replace(z1=best.z1 + sign * h) if place == 0 else best._replace(
                m=(best.m[0] + sign * h,)
            )  # fmt: skip

            def build(ratios: list[Any], at: Tree = moved) -> Tree:
                return at._replace(k=(ratios[0],), z2=(ratios[1],))

            start = [float(mp.exp(y / 2)) for y in held.places]
            ends.append(polished(build, pair, held.ratios, start, held.weights))
        columns.append([
            *((ends[0].ratios[i] - ends[1].ratios[i]) / (2 * h) for i in (0, 1)),
            (ends[0].level - ends[1].level) / (2 * h),
        ])  # fmt: skip
    for number, name in enumerate(("stiffness_ratio", "secondary_damping", "peak")):
        yield from reported(f"sensitivity/{name}", [column[number] for column in columns])
