"""Results of a shaft line over a range of speeds in many digits: curves at three of the speeds,
largest values by a search of their own, ends of ranges as zeros."""

from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
from exact_engine_gears import gear_rows, mean_sections
from exact_engine_modes import frequencies_at
from exact_engine_search import Grid, Highest, highest, root, sharpened
from exact_engine_state import State, sums
from exact_engine_steady import (
    ROOT,
    Reader,
    Truth,
    allowed,
    least_of,
    section_heat,
    section_moduli,
)
from mpmath import mpf

#: sections of each state whose largest value is looked for, next to those of largest entries
FEW = 2
#: speeds of a curve, next to that of its largest value
MOST = 2


def range_results(reader: Reader) -> Iterator[Truth]:
    """Everything of [response.torsion] speeds."""
    path = f"{ROOT}speeds/torque_half_range"
    speeds = reader.record[path].axes[1].values
    some = _telling(reader, path)
    at = [mpf(v) for v in speeds[some].tolist()]
    tops: dict[str, dict[int, Highest]] = {}
    for place, state in reader.others.items():
        own = _telling(reader, f"{ROOT}{place}speeds/torque_half_range")
        yield from _curves(reader, place, state, own, [mpf(v) for v in speeds[own].tolist()])
        grid = Grid(state, float(speeds[0]), float(speeds[-1]), len(speeds))
        reader.grids = {**getattr(reader, "grids", {}), place: grid}  # type: ignore[attr-defined]
        tops[place] = {}
        yield from _largest(reader, place, state, grid, tops[place])
    yield from _own_curves(reader, some, at)
    yield from _reduction(reader, tops)
    yield from _peaks(reader)
    yield from _limits(reader, some, at)
    yield from _barred(reader)
    yield from _hammering(reader)
    path = f"{ROOT}campbell/natural_frequency"
    if path in reader.record:
        axis, values = reader.record[path].axes[1].values, reader.record[path].values
        chosen = [0, len(axis) - 1]
        rows = [frequencies_at(reader, mpf(axis[k]), values[:, k].tolist()) for k in chosen]
        yield path, rows, values[:, chosen].T


def _telling(reader: Reader, path: str) -> list[int]:
    """Places of speeds at which some sections have their largest finite torque."""
    curve = reader.record[path].values
    finite = np.flatnonzero(np.all(np.isfinite(curve), axis=0))
    best = finite[np.argmax(curve[:, finite], axis=1)]
    most = finite[np.argmax(np.max(curve[:, finite], axis=0))]
    return sorted({int(most), *reader.draw.choice(best, min(MOST, len(best))).tolist()})


def _curves(
    reader: Reader, place: str, state: State, some: list[int], at: list[mpf]
) -> Iterator[Truth]:
    ratio, path = state.line.section_ratio, f"{ROOT}{place}speeds/"
    rows: dict[str, list[list[mpf]]] = {"twist_half_range": [], "torque_half_range": []}
    for speed in at:
        twist, torque = (state.sections(speed, what) for what in ("twist", "torque"))
        rows["twist_half_range"].append(
            [t.half * abs(r) for t, r in zip(twist, ratio, strict=True)]
        )
        rows["torque_half_range"].append(
            [t.half / abs(r) for t, r in zip(torque, ratio, strict=True)]
        )
    for name, truth in rows.items():
        yield path + name, truth, reader.record[path + name].values[:, some].T
    name = f"{path}stress_half_range"
    if name in reader.record:
        moduli = section_moduli(reader)
        truth = [[row[e] / w for e, w in moduli.items()] for row in rows["torque_half_range"]]
        yield name, truth, reader.record[name].values[:, some].T


def _own_curves(reader: Reader, some: list[int], at: list[mpf]) -> Iterator[Truth]:
    state, record, line, path = reader.state, reader.record, reader.line, f"{ROOT}speeds/"
    rows: dict[str, list[Any]] = {}
    rings = [one.element for one in line.built.dampers]
    for speed in at:
        found = state.at(speed)
        angle = [
            state.sum_of([row[f] for row in found.angle]).half * abs(r)
            for f, r in zip(line.built.freedom.tolist(), line.ratio, strict=True)
        ]
        mean = mean_sections(reader, speed)
        torque = state.sections(speed, "torque")
        peak = [
            max(abs(m + t.highest), abs(m + t.lowest)) / abs(r)
            for m, t, r in zip(mean, torque, line.section_ratio, strict=True)
        ]
        healthy = state.drive.healthy(speed)[1]
        total = mpmath.fsum(s * healthy for s in state.drive.scale)
        one: dict[str, Any] = {"angle_half_range": angle, "torque_peak": peak, "mean_torque": total}
        twist = state.sections(speed, "twist")
        one["twist_peak"] = [
            t.peak * abs(r) for t, r in zip(twist, line.section_ratio, strict=True)
        ]
        if rings:
            heat = section_heat(state, speed)
            one["heat"] = [heat[e] for e in rings]
            one["travel"] = [twist[e].peak * abs(line.section_ratio[e]) for e in rings]
        if line.parts.gears:
            means, orders = gear_rows(reader, speed)
            totals = [sums(state.drive.orders, row) for row in orders]
            one["gear_mean_torque"] = means
            one["gear_torque"] = [t.half for t in totals]
            least = [least_of(m, t) for m, t in zip(means, totals, strict=True)]
            one["gear_minimum_torque"] = least
            one["gear_hammers"] = [mpf(int(v < 0)) for v in least]
        for name, value in one.items():
            rows.setdefault(name, []).append(value)
    for name, truth in rows.items():
        yield path + name, truth, np.moveaxis(record[path + name].values, -1, 0)[some]


def _largest(
    reader: Reader, place: str, state: State, grid: Grid, tops: dict[int, Highest]
) -> Iterator[Truth]:
    """The most loaded section and another one."""
    path, ratio = f"{ROOT}{place}largest/", state.line.section_ratio
    found = reader.record[f"{path}torque_half_range"].values
    known = np.flatnonzero(np.isfinite(found) & (found > 0.0))
    if not len(known):
        return
    # an estimate speaks for the worst of all sections: those with the largest entries are examined
    chosen = {int(known[np.argmax(found[known])]), *reader.draw.choice(known, FEW - 1).tolist()}
    twist = reader.record[f"{path}twist_half_range"].values
    chosen.add(int(known[np.argmax(twist[known])]))
    stress, moduli = reader.record.get(f"{path}stress_half_range"), list(section_moduli(reader))
    if stress is not None:
        chosen.add(moduli[int(np.argmax(np.where(np.isfinite(stress.values), stress.values, 0.0)))])
    chosen &= set(known.tolist())
    order, spots = sorted(chosen), reader.record[f"{path}speed"].values
    for e in order:
        tops[e] = highest(  # type: ignore[misc]
            grid, e, lambda v, e=e: state.half(v, e), lambda v: 1.0, float(spots[e])
        )
    truth = [tops[e].value / abs(ratio[e]) for e in order]
    yield f"{path}torque_half_range", truth, found[order]
    speeds = [tops[e].speed for e in order]
    yield f"{path}speed", speeds, reader.record[f"{path}speed"].values[order]
    twist = [
        state.sum_of([row[e] for row in state.at(tops[e].speed).twist]).half * abs(ratio[e])
        for e in order
    ]
    yield f"{path}twist_half_range", twist, reader.record[f"{path}twist_half_range"].values[order]
    name, moduli = f"{path}stress_half_range", list(section_moduli(reader).items())
    if name in reader.record:
        rows = [(k, e, w) for k, (e, w) in enumerate(moduli) if e in order]
        values = reader.record[name].values[[k for k, *_ in rows]]
        if rows:
            yield name, [tops[e].value / abs(ratio[e]) / w for _, e, w in rows], values


def _reduction(reader: Reader, tops: dict[str, dict[int, Highest]]) -> Iterator[Truth]:
    path = f"{ROOT}reduction"
    if path not in reader.record or "bare/" not in tops:
        return
    both = sorted(set(tops[""]) & set(tops["bare/"]))
    if both:
        truth = [tops["bare/"][e].value / tops[""][e].value for e in both]
        yield path, truth, reader.record[path].values[both]


def _peaks(reader: Reader) -> Iterator[Truth]:
    """Maxima next to the places found; those at an end of the range stay."""
    path, record = f"{ROOT}peak/", reader.record
    if f"{path}speed" not in record or not len(record[f"{path}speed"].values):
        return
    speeds = record[f"{path}speed"].values
    sections = record[f"{path}section"].values.astype(int) - 1
    heights = record[f"{path}torque_half_range"].values
    chosen = sorted({int(np.argmax(heights)), int(reader.draw.integers(0, len(speeds)))})
    found = []
    for k in chosen:
        e = int(sections[k])
        exact = lambda v, e=e: reader.state.half(v, e)  # type: ignore[misc]  # noqa: E731
        found.append((e, sharpened(exact, float(speeds[k]), 1e-4 * float(speeds[k]))))
    truth = [top.value / abs(reader.line.section_ratio[e]) for e, top in found]
    yield f"{path}torque_half_range", truth, record[f"{path}torque_half_range"].values[chosen]
    yield f"{path}speed", [top.speed for _, top in found], speeds[chosen]


def _use(reader: Reader, state: State, number: int, section: int) -> Any:
    modulus = section_moduli(reader)[section] * abs(state.line.section_ratio[section])

    def exact(speed: mpf) -> mpf:
        steady = allowed(reader, number, section, speed)[0]
        return state.half(speed, section) / modulus / steady if mpmath.isfinite(steady) else mpf(0)

    def scale(speed: float) -> float:
        steady = allowed(reader, number, section, mpf(speed))[0]
        return float(1 / (modulus * steady)) if mpmath.isfinite(steady) else 0.0

    return exact, scale


def _limits(reader: Reader, some: list[int], at: list[mpf]) -> Iterator[Truth]:
    """Courses of the limits, and their largest uses in any section."""
    place, record = f"{ROOT}limit/", reader.record
    if f"{place}largest_use" not in record:
        return
    worst = record[f"{place}section"].values.astype(int) - 1
    for k, name in enumerate(("allowed", "transient")):
        truth = [
            [allowed(reader, number, int(e), v)[k] for v in at] for number, e in enumerate(worst)
        ]
        yield place + name, truth, record[place + name].values[:, some]
    for prefix, which in (("", ""), ("healthy/", "healthy/")):
        path = f"{ROOT}{prefix}limit/largest_use"
        if path not in record:
            continue
        finite = np.isfinite(record[path].values)
        grid = reader.grids[which]  # type: ignore[attr-defined]
        tops = [
            _highest_use(reader, reader.others[which], grid, number) if on else None
            for number, on in enumerate(finite.tolist())
        ]
        numbers = np.flatnonzero(finite)
        kept = [top for top in tops if top is not None]
        if not kept:
            continue
        yield path, [top.value for top, _ in kept], record[path].values[numbers]
        if not prefix:
            yield (
                f"{place}speed",
                [top.speed for top, _ in kept],
                record[f"{place}speed"].values[numbers],
            )
            passing = []
            for number, (top, e) in zip(numbers.tolist(), kept, strict=True):
                steady, through = allowed(reader, number, e, top.speed)
                passing.append(top.value * steady / through)
            yield (
                f"{place}transient_use",
                passing,
                record[f"{place}transient_use"].values[numbers],
            )


def _highest_use(reader: Reader, state: State, grid: Grid, number: int) -> tuple[Highest, int]:
    """Over all sections: the best of the grid decides which two are examined."""
    ranked = []
    for e in section_moduli(reader):
        exact, scale = _use(reader, state, number, e)
        curve = grid.halves[:, e] * np.array([scale(v) for v in grid.speed.tolist()])
        ranked.append((float(curve.max()), e, exact, scale))
    ranked.sort(key=lambda one: -one[0])
    found, spots = [], reader.record[f"{ROOT}limit/speed"].values
    for value, e, exact, scale in ranked[:2]:
        if value < 0.9 * ranked[0][0]:
            continue
        top = highest(grid, e, exact, scale, float(spots[number]))
        for corner in _corners(reader, number):
            if grid.start < corner < grid.stop:
                there = exact(corner)
                if there > top.value:
                    top = Highest(corner, there, False)
        found.append((top, e))
    return max(found, key=lambda one: one[0].value)


def _corners(reader: Reader, number: int) -> list[mpf]:
    limit = reader.torsion.limits[number]
    if limit.curve is not None:
        return [mpf(v) for v in limit.curve.speed]
    return [reader.speed * mpf(9) / 10, reader.speed * mpf(105) / 100]


def _barred(reader: Reader) -> Iterator[Truth]:
    """Ends of ranges as zeros of the excess of the worst section; what a rule makes of them."""
    place, record = f"{ROOT}exceeded/", reader.record
    if f"{place}from" not in record or not len(record[f"{place}from"].values):
        return
    numbers = record[f"{place}limit"].values.astype(int) - 1
    ends_of: dict[str, list[mpf]] = {}
    for name in ("from", "to"):
        values, truth, kept = record[place + name].values, [], []
        ends_of[name] = truth
        for k, (number, at) in enumerate(zip(numbers.tolist(), values.tolist(), strict=True)):
            exacts = [_use(reader, reader.state, number, e)[0] for e in section_moduli(reader)]
            end = at in (reader.torsion.speeds.start, reader.torsion.speeds.stop)
            uses = [exact(mpf(at)) for exact in exacts]
            if end or any(abs(at - c) < 1e-9 * at for c in _corners(reader, number)):
                truth.append(mpf(at))
            else:
                best = exacts[uses.index(max(uses))]
                truth.append(root(lambda v, f=best: f(v) - 1, at, 1e-9 * at))  # type: ignore[misc]
            kept.append(k)
        yield place + name, truth, values[kept]
    peaks = record[f"{place}peak_speed"].values
    speeds, lower, upper = [], [], []
    for number, at in zip(numbers.tolist(), peaks.tolist(), strict=True):
        exacts = [_use(reader, reader.state, number, e)[0] for e in section_moduli(reader)]
        best = max(exacts, key=lambda f: f(mpf(at)))
        top = sharpened(best, at, 1e-4 * at)
        ends = reader.torsion.speeds.start, reader.torsion.speeds.stop
        within = top.inside and ends[0] < top.speed < ends[1]
        speeds.append(top.speed if within else mpf(at))
        share = 18 - speeds[-1] / reader.speed
        ruled = reader.torsion.limits[number].rule is not None
        lower.append(16 * speeds[-1] / share if ruled else mpf(0))
        upper.append(share * speeds[-1] / 16 if ruled else mpf(0))
    for name, truth in (("peak_speed", speeds), ("formula_from", lower), ("formula_to", upper)):
        yield place + name, truth
    starts = [min(a, b) if b else a for a, b in zip(ends_of["from"], lower, strict=True)]
    united: list[list[mpf]] = []
    for low, high in sorted(zip(starts, map(max, ends_of["to"], upper), strict=True)):
        if united and low <= united[-1][1]:
            united[-1][1] = max(high, united[-1][1])
        else:
            united.append([low, high])
    for k, name in enumerate(("from", "to")):
        yield f"{ROOT}barred/{name}", [o[k] for o in united]


def _hammering(reader: Reader) -> Iterator[Truth]:
    """Ends of ranges in which the torque of a gear changes its sign."""
    place, record = f"{ROOT}hammering/", reader.record
    if f"{place}from" not in record or not len(record[f"{place}from"].values):
        return
    gears = record[f"{place}gear"].values.astype(int) - 1
    for name in ("from", "to"):
        truth = []
        for gear, at in zip(gears.tolist(), record[place + name].values.tolist(), strict=True):

            def least(speed: mpf, gear: int = gear) -> mpf:
                means, rows = gear_rows(reader, speed)
                return least_of(means[gear], sums(reader.state.drive.orders, rows[gear]))

            end = at in (reader.torsion.speeds.start, reader.torsion.speeds.stop)
            truth.append(mpf(at) if end else root(least, at, 1e-9 * at))
        yield place + name, truth
