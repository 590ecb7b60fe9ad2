"""Every result path below `isolation/`, in many digits; see `exact_results.py`."""

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from exact_body import BodyTruth, about_centre
from exact_parts import up_of
from exact_peaks import cycle_peak, peak
from exact_pitch import PitchTruth
from mpmath import mpf

from vibecalc.core.results.record import Record
from vibecalc.schema import Case

#: a path, the entries of the result that are compared, and their exact values
Truth = tuple[str, np.ndarray, Any]
RUN_UP_SPEEDS = 5


class Upright(NamedTuple):
    """Of each mount: motion and force upwards ([component][order]), sag and share of the weight."""

    motion: list[Any]
    force: list[Any]
    sag: list[mpf]
    share: list[mpf]


def pitch_results(case: Case, record: Record, pitch: PitchTruth) -> Iterator[Truth]:
    speed = mpf(case.machine.speed)

    def reported(name: str, exact: Any) -> Truth:
        return f"isolation/{name}", record[f"isolation/{name}"].values, exact

    yield reported("pitch/inertia", pitch.inertia)
    yield reported("pitch/stiffness", pitch.stiffness)
    yield reported("pitch/damping", pitch.damping)
    yield reported("pitch/natural_frequency", pitch.frequency)
    viscous = pitch.damping / (pitch.frequency * pitch.inertia)
    yield reported("pitch/damping_ratio", (viscous + pitch.loss / pitch.stiffness) / 2)
    kept = record["isolation/pitch/transmissibility"].axes[0].values.tolist()
    through = [pitch.passing(n * speed) / pitch.resisting(n * speed) for n in kept]
    yield reported("pitch/transmissibility", through)
    ratios = record["isolation/pitch/transmissibility_curve"].axes[0].values.tolist()
    rates = [mpf(ratio) * pitch.frequency for ratio in ratios]
    curve = [pitch.passing(w) / pitch.resisting(w) for w in rates]
    yield reported("pitch/transmissibility_curve", curve)
    angle = pitch.angle(speed)
    yield reported("pitch/angle_harmonics", _at(kept, pitch.orders, angle))
    yield reported("pitch/angle_peak", cycle_peak([angle], pitch.orders)[0])
    rigid = [speed**2 * c / pitch.lever for c in pitch.couple]
    rows = pitch.rows(speed)
    for name, force in (("blocked", rigid), ("steady", rows[0][0])):
        yield reported(f"couple_over_lever/{name}_harmonics", _at(kept, pitch.orders, force))
        yield reported(f"couple_over_lever/{name}_peak", cycle_peak([force], pitch.orders)[0])
    still = cycle_peak([rigid], pitch.orders)[0] * pitch.lever
    share = [abs(k * x) / pitch.stiffness for k, x in zip(pitch.spring, pitch.place, strict=True)]
    yield reported("support_force/blocked_peak", [still * s for s in share])
    sag = pitch.sag()
    yield reported("support_displacement/static", sag)
    yield reported("support_force/static", [k * s for k, s in zip(pitch.spring, sag, strict=True)])
    for name, vectors in pitch.left_out.items():
        parts = [[speed**2 * one[i] for one in vectors] for i in range(3)]
        yield reported(f"pitch/{name}_left_out", cycle_peak(parts, pitch.orders)[0])
    moved = [[[-x * q for q in angle]] for x in pitch.place]
    share = [k * s for k, s in zip(pitch.spring, sag, strict=True)]
    upright = Upright(moved, rows[1:], sag, share)
    yield from _supports(record, pitch.orders, kept, moved, rows[1:], upright)
    if case.isolation is not None and case.isolation.run_up is not None:
        yield from _run_up(case, record, pitch, "couple_over_lever", [0])
        yield from _run_up(case, record, pitch, "support_force", list(range(1, len(rows))))


def body_results(case: Case, record: Record, body: BodyTruth) -> Iterator[Truth]:
    speed = mpf(case.machine.speed)

    def reported(name: str, exact: Any) -> Truth:
        return f"isolation/{name}", record[f"isolation/{name}"].values, exact

    frequency, shapes = body.modes()
    yield reported("modes/natural_frequency", frequency)
    yield reported("modes/shape", [v.tolist() for v in shapes])
    yield reported("modes/energy_fraction", [about_centre(body.mass, v) for v in shapes])
    ratio = [
        v @ (body.damping @ v) / (2 * w) + v @ (body.loss @ v) / (2 * w**2)
        for v, w in zip(shapes, frequency, strict=True)
    ]
    yield reported("modes/damping_ratio", ratio)
    yield reported("support_displacement/static", body.sag)
    yield reported("support_force/static", body.share)
    motion = body.motion(speed)
    kept = record["isolation/body/translation_harmonics"].axes[0].values.tolist()
    each = _at(kept, body.orders, [x.tolist() for x in motion], [mpf(0)] * 6)
    yield reported("body/translation_harmonics", [x[:3] for x in each])
    yield reported("body/rotation_harmonics", [x[3:] for x in each])
    moved = body.displacement(motion)
    up = up_of(case)
    rows = body.rows(speed, motion)
    upwards, lifting = (
        [[[sum(up * np.array(c)) for c in zip(*mount, strict=True)]] for mount in each]
        for each in (moved, rows)
    )
    upright = Upright(upwards, lifting, body.sag, body.share)
    yield from _supports(record, body.orders, kept, moved, rows, upright)
    if case.isolation is not None and case.isolation.run_up is not None:
        yield from _run_up(case, record, body, "support_force", list(range(len(rows))))


def _at(kept: list[int], orders: list[int], values: list[Any], absent: Any = 0) -> list[Any]:
    """Values of the kept orders; of one that nothing drives, nothing."""
    known = dict(zip(orders, values, strict=True))
    return [known.get(n, absent) for n in kept]


def _supports(
    record: Record,
    orders: list[int],
    kept: list[int],
    moved: list[Any],
    forces: list[Any],
    upright: Upright,
) -> Iterator[Truth]:
    for name, values in (("displacement", moved), ("force", forces)):
        path = f"isolation/support_{name}/steady_harmonics"
        exact = [[_at(kept, orders, component) for component in mount] for mount in values]
        yield path, record[path].values, exact
    path = "isolation/support_force/steady_peak"
    yield path, record[path].values, [cycle_peak(mount, orders)[0] for mount in forces]
    heights = [cycle_peak(mount, orders)[0] for mount in upright.motion]
    path = "isolation/support_displacement/vertical_peak"
    yield path, record[path].values, heights
    path = "isolation/support_displacement/total"
    ends = [
        [abs(_highest(sense * s, mount, orders, -sense)) for sense in (1, -1)]
        for s, mount in zip(upright.sag, upright.motion, strict=True)
    ]
    yield path, record[path].values, [max(one) for one in ends]
    for name, sense in (("largest_load", 1), ("minimum_load", -1)):
        path = f"isolation/support_force/{name}"
        loads = [
            sense * _highest(sense * s, mount, orders, -sense)
            for s, mount in zip(upright.share, upright.force, strict=True)
        ]
        yield path, record[path].values, loads


def _highest(constant: mpf, mount: list[Any], orders: list[int], sense: int) -> mpf:
    """Highest value over a turn of a constant and one component, which counts with its sense."""
    (harmonics,) = mount
    far = 4 * (abs(constant) + sum(abs(one) for one in harmonics) + 1)
    row = [far + constant, *(sense * one for one in harmonics)]
    return cycle_peak([row], [0, *orders])[0] - far


def _run_up(
    case: Case,
    record: Record,
    model: PitchTruth | BodyTruth,
    group: str,
    rows: list[int],
    peaks: int = 2,
) -> Iterator[Truth]:
    assert case.isolation is not None and case.isolation.run_up is not None
    if "isolation/resonances_skipped/centre" in record and group == "support_force":
        yield from _masked(record, model)
    path = f"isolation/{group}/run_up"
    found = record[path]
    speeds, values = found.axes[-1].values, np.atleast_2d(found.values)
    chosen = {int(np.argmax(row)) for row in values[:RUN_UP_SPEEDS]}
    spread = np.random.default_rng(len(speeds)).permutation(len(speeds))
    chosen = sorted({*chosen, *spread[: RUN_UP_SPEEDS - 2].tolist()})
    exact = []
    for index in chosen:
        at_speed = model.rows(mpf(float(speeds[index])))
        exact.append([cycle_peak(at_speed[row], model.orders)[0] for row in rows])
    yield path, values[:, chosen], np.array(exact, dtype=object).T.tolist()

    top = np.atleast_1d(record[f"{path}_peak"].values)
    where = np.atleast_1d(record[f"{path}_peak_speed"].values)
    ends = (case.isolation.run_up.start, case.isolation.run_up.stop)
    # the highest row and the last ones: a peak takes as long as all the rest
    chosen = sorted({int(np.argmax(top)), *range(len(top))[-(peaks - 1) :]})
    found_at = []
    for index in chosen:
        start, row_at = mpf(float(where[index])), partial(model.row, row=rows[index])
        if not np.isfinite(top[index]):
            found_at.append((mpf("inf"), _resonance(model, start)))
        elif top[index] == 0.0 or where[index] in ends:
            found_at.append((cycle_peak(row_at(start), model.orders)[0], start))
        else:
            found_at.append(peak(row_at, model.orders, start))
    yield f"{path}_peak", top[chosen], [height for height, _ in found_at]
    yield f"{path}_peak_speed", where[chosen], [speed for _, speed in found_at]


def _frequencies(model: PitchTruth | BodyTruth) -> list[mpf]:
    return [model.frequency] if isinstance(model, PitchTruth) else model.modes()[0]


def _resonance(model: PitchTruth | BodyTruth, near: mpf) -> mpf:
    """The speed nearest to one at which an order meets a natural frequency."""
    speeds = [w / n for w in _frequencies(model) for n in model.orders]
    return min(speeds, key=lambda speed: abs(speed - near))


def _masked(record: Record, model: PitchTruth | BodyTruth) -> Iterator[Truth]:
    """Centres are natural frequencies over orders; the ends are the speeds computed, no more."""
    found = {
        name: record[f"isolation/resonances_skipped/{name}"].values
        for name in ("low", "centre", "high", "order", "mode")
    }
    frequency = _frequencies(model)
    pairs = zip(found["mode"].tolist(), found["order"].tolist(), strict=True)
    exact = {"centre": [frequency[mode - 1] / order for mode, order in pairs]}
    assert np.all((found["low"] < found["centre"]) & (found["centre"] < found["high"]))
    for name, values in found.items():
        path = f"isolation/resonances_skipped/{name}"
        yield path, values, exact.get(name, [mpf(value) for value in values.tolist()])
