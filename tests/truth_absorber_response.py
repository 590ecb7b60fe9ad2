"""What stands below `response/absorber/` of a primary with absorbers, in many digits."""

from collections.abc import Callable, Iterator
from typing import Any

import mpmath
from exact_tree import Peaks, Tree, peaks, response, roots_of, tree, value_at
from mpmath import mp, mpc, mpf
from truth_absorber_tuning import TRAVEL, NoTruth, Truth, alone, best_of

from vibecalc.absorber.model import AbsorberParts
from vibecalc.absorber.stage import asked_of
from vibecalc.core.results.record import Record
from vibecalc.schema import Case


def response_truth(case: Case, record: Record, parts: AbsorberParts) -> Iterator[Truth]:
    """Path, values, truth and size (None: that of the truth) of curves, peaks and landmarks."""
    root = "response/absorber"
    if f"{root}/curve" not in record:
        return
    pair = asked_of(case)
    try:
        systems = _systems(case, record, parts)
    except NoTruth:
        return

    def reported(name: str, truth: Any, size: float | None = None) -> Iterator[Truth]:
        path = f"{root}/{name}"
        if path in record:
            yield path, record[path].values, truth, size

    ratios = [mpf(float(x)) for x in record[f"{root}/curve"].axes[1].values]
    if parts.scale is not None:
        own = mp.sqrt(mpf(parts.scale.stiffness) / mpf(parts.scale.inertia))
        yield from reported("primary_frequency", own)
        yield from reported("frequency", [own * x for x in ratios])
    for name, what in (("curve", pair[1]), ("relative_curve", TRAVEL)):
        rows = [_curve(system, pair[0], what, ratios) for system in systems]
        yield from reported(name, rows)
    found = [peaks(system, *pair) for system in systems]
    if parts.branches:  # an infinite resonance is shown by the largest response alone
        found = [_finite(one) for one in found]
    yield from _peaks(record, found, reported)
    travels = [peaks(system, pair[0], TRAVEL) for system in systems]
    yield from reported("largest_travel", [one.largest for one in travels])
    if len(systems[0].m) == 1:
        yield from _landmarks(record, systems[0], pair, reported)


def _systems(case: Case, record: Record, parts: AbsorberParts) -> list[Tree]:
    names = [str(name) for name in record["response/absorber/curve"].axes[0].values]
    assert case.response is not None and case.response.absorber is not None
    if names[0] == "tuned":
        first = best_of(case, record, parts)[0]
    elif parts.branches:
        rows = [(b.mass_ratio, b.stiffness_ratio, b.secondary_damping) for b in parts.branches]
        m, k, z = zip(*rows, strict=True)
        parent = [branch.carrier + 1 for branch in parts.branches]
        first = tree(parts.primary_damping, m, k, z, parent)
    else:
        assert parts.absorber is not None
        first = tree(parts.absorber.primary_damping, *([part] for part in parts.absorber[1:]))
    systems, n = [], len(first.m)
    vary = case.response.absorber.vary
    varied = {} if vary is None else {
        f"{word} {value:g}": (key, value)
        for key, word in (("primary_damping", "primary damping"), ("mass_ratio", "mass ratio"))
        for value in getattr(vary, key)
    }  # fmt: skip
    for name in names:
        one = first
        if name == "locked":
            one = first._replace(k=(mp.inf,) * n)
        elif name == "free":
            one = alone(first)
        elif name in varied:
            key, value = varied[name]
            wide = mpf(value)
            one = first._replace(z1=wide) if key == "primary_damping" else first._replace(m=(wide,))
        systems.append(one)
    return systems


def _curve(system: Tree, excitation: str, what: str, ratios: list[mpf]) -> list[Any]:
    above, below = response(system, excitation, what)
    sign = -1 if what == TRAVEL or (excitation, what) == ("base", "transmitted_force") else 1
    sign *= -1 if excitation == "unbalance" else 1
    values = []
    for x in ratios:
        top, bottom = (value_at(side, mpc(0, x)) for side in (above, below))
        values.append(mp.inf if bottom == 0 else sign * top / bottom)
    return values


def _peaks(
    record: Record, found: list[Peaks], reported: Callable[..., Iterator[Truth]]
) -> Iterator[Truth]:
    path = "response/absorber/peak/magnitude"
    if path in record:
        width = record[path].values.shape[1]
        assert all(len(one.frequency) <= width for one in found), found
        for name, key in (("magnitude", "magnitude"), ("frequency_ratio", "frequency")):
            rows = [getattr(one, key) + [mpf(0)] * (width - len(one.frequency)) for one in found]
            yield from reported(f"peak/{name}", rows)
    yield from reported("largest", [one.largest for one in found])
    yield from reported("largest_frequency_ratio", [one.where for one in found])


def _finite(one: Peaks) -> Peaks:
    both = [(x, h) for x, h in zip(one.frequency, one.magnitude, strict=True) if mp.isfinite(h)]
    return one._replace(frequency=[x for x, _ in both], magnitude=[h for _, h in both])


def _landmarks(
    record: Record, system: Tree, pair: tuple[str, str], reported: Callable[..., Iterator[Truth]]
) -> Iterator[Truth]:
    m, k = system.m[0], system.k[0]
    total, ratio = 1 + k / m * (1 + m), k / m
    gap = mp.sqrt(total * total - 4 * ratio)
    both = [mp.sqrt((total - gap) / 2), mp.sqrt((total + gap) / 2)]
    yield from reported("natural_frequency_ratio", both)
    yield from reported("antiresonance", mp.sqrt(ratio))
    yield from reported("locked_frequency_ratio", 1 / mp.sqrt(1 + m))
    below = response(system, "force", "displacement")[1]
    roots = roots_of(below)
    exact = []
    for value in record["response/absorber/pole"].values:
        nearest = min(roots, key=lambda root: abs(root - mpmath.mpmathify(complex(value))))
        roots.remove(nearest)
        exact.append(nearest)
    yield from reported("pole", exact)
    total = 2 * (1 + ratio * (1 + m)) / (2 + m)
    gap = mp.sqrt(total * total - 8 * ratio / (2 + m))
    squares = [(total - gap) / 2, (total + gap) / 2]
    yield from reported("fixed_point/frequency_ratio", [mp.sqrt(u) for u in squares])
    power = {"velocity": 1, "acceleration": 2}.get(pair[1], 0) + 2 * (pair[0] == "unbalance")
    heights = [mp.sqrt(u) ** power / abs(1 - (1 + m) * u) for u in squares]
    yield from reported("fixed_point/magnitude", heights)
