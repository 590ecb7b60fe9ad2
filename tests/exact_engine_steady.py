"""Results of a shaft line at its operating speed in many digits, from the case."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from exact_engine_drive import EngineDrive
from exact_engine_gears import gear_rows, mean_sections
from exact_engine_line import ExactLine
from exact_engine_modes import Natural, are_poles, critical_speeds, natural_modes
from exact_engine_state import State, Sums, sums
from mpmath import mp, mpc, mpf

from vibecalc.core.results.record import Record
from vibecalc.schema import Case

ROOT = "response/torsion/"
#: path and true values, after these the values found where they are not all of the record
Truth = tuple[Any, ...]


class Reader:
    """A record and the exact states of its line."""

    def __init__(self, case: Case, record: Record, seed: int = 1) -> None:
        self.case, self.record = case, record
        self.draw = np.random.default_rng(seed)
        torsion = case.response.torsion  # type: ignore[union-attr]
        assert torsion is not None
        self.torsion = torsion
        self.orders = record[f"{ROOT}excitation/gas"].axes[0].values.tolist()
        self.line = ExactLine(case)
        self.state = State(case, self.line, EngineDrive(case, self.orders))
        self.speed = self.state.operating
        self.natural: Natural = natural_modes(self)
        self.others: dict[str, State] = {"": self.state}
        if self.line.built.dampers and torsion.speeds is not None:
            bare = self.line.without_dampers()
            self.others["bare/"] = State(case, bare, self.state.drive)
        if torsion.misfire:
            healthy = EngineDrive(case, self.orders, all_fire=True)
            self.others["healthy/"] = State(case, self.line, healthy)

    def names(self, path: str, axis: str) -> list[Any]:
        return next(a.values.tolist() for a in self.record[path].axes if a.name == axis)


def excitation(reader: Reader) -> Iterator[Truth]:
    record, drive, speed = reader.record, reader.state.drive, reader.speed
    place, one = f"{ROOT}excitation/", drive.cylinder
    gas, mean = drive.healthy(speed)
    inertia = [speed**2 * i for i in drive.own_inertia(max(drive.mass))]
    total = [g + i for g, i in zip(gas, inertia, strict=True)]
    share = drive.weights(speed)
    angles = record[f"{place}pressure"].axes[0].values
    some = np.unique(reader.draw.integers(0, len(angles), 12))
    at = [mpf(a) for a in angles[some].tolist()]
    pressure = [
        mpmath.fsum(s * c.at(a) for s, c in zip(share, drive.cards, strict=True) if s) for a in at
    ]
    paths = [one.path(a) for a in at]
    own_gas = [-p * one.area * motion[1] for p, motion in zip(pressure, paths, strict=True)]
    mass = max(drive.mass)
    own = [
        -(speed**2) * (mass * m[1] * m[2] + drive.rod * one.rocking(a))
        for m, a in zip(paths, at, strict=True)
    ]
    loads = drive.torques(speed)
    engine_mean = mpmath.fsum(s * mean for s in drive.scale)
    sum_of = [mpmath.fsum(row[k] for row in loads) for k in range(len(gas))]
    ratio = [reader.line.ratio[int(s)] for s in reader.line.built.cylinder_station]
    referred = [
        mpmath.fsum(r * row[k] for r, row in zip(ratio, loads, strict=True))
        for k in range(len(gas))
    ]
    assert all(abs(a - b) <= 1e-20 * abs(b) for a, b in zip(sum_of, referred, strict=True))
    curve = [
        engine_mean + mpmath.fsum((t * mpmath.expj(q * a)).real
                                  for t, q in zip(sum_of, drive.orders, strict=True))
        for a in at
    ]  # fmt: skip
    stations = [[mpc(0)] * len(gas) for _ in reader.line.ratio]
    for station, row in zip(reader.line.built.cylinder_station.tolist(), loads, strict=True):
        stations[station] = [a + b for a, b in zip(stations[station], row, strict=True)]
    truths: dict[str, Any] = {
        "gas": gas,
        "inertia": inertia,
        "total": total,
        "tangential_pressure": [t / (one.area * one.radius) for t in total],
        "mean_torque": engine_mean,
        "power": engine_mean * speed,
        "mean_indicated_pressure": mean * one.cycle / (one.area * one.stroke),
        "firing_angle": drive.firing,
        "station_torque": stations,
    }
    for name, truth in truths.items():
        if place + name in record:
            yield place + name, truth
    curves = {
        "pressure": pressure,
        "gas_torque": own_gas,
        "inertia_torque": own,
        "total_torque": [a + b for a, b in zip(own_gas, own, strict=True)],
        "engine_torque": curve,
    }
    for name, truth in curves.items():
        yield place + name, truth, record[place + name].values[some]
    yield from _phases(reader, place)


def _phases(reader: Reader, place: str) -> Iterator[Truth]:
    """Vector sums and intensities by mode; orders that find all cylinders in phase."""
    record, drive, built = reader.record, reader.state.drive, reader.line.built
    turned = [[mpmath.expj(-q * a) for a in drive.firing] for q in drive.orders]
    rows, works = [], []
    at = reader.state.at(reader.speed)
    for shape in reader.natural.shape:
        own = [shape[f] for f in built.cylinder_freedom.tolist()]
        whole = mpmath.fsum(map(abs, own))
        still = whole < 1e-5
        rows.append([
            mpf(0) if still
            else mpmath.fsum(x * t for x, t in zip(own, turn, strict=True)) / whole
            for turn in turned
        ])  # fmt: skip
        works.append([mpmath.fsum(x * t for x, t in zip(own, load, strict=True))
                      for load in at.load])  # fmt: skip
    sure = _sure(reader)
    yield f"{place}vector_sum", [rows[k] for k in sure], record[f"{place}vector_sum"].values[sure]
    yield f"{place}intensity", [works[k] for k in sure], record[f"{place}intensity"].values[sure]
    major, factor = bank_truth(reader)
    yield f"{place}major", [mpf(int(one)) for one in major]
    if f"{place}bank_factor" in record:
        yield f"{place}bank_factor", factor


def bank_truth(reader: Reader) -> tuple[list[bool], list[mpf]]:
    """Major orders, and what the angle between the banks leaves of each order."""
    drive, train = reader.state.drive, reader.case.machine.crank_train
    banks: dict[float, list[mpf]] = {}
    for one, angle in zip(train.cylinders, drive.firing, strict=True):
        banks.setdefault(one.bank_angle, []).append(angle)
    major, factor, little = [], [], mpf(10) ** -9
    for q in drive.orders:
        own = [mpmath.fsum(mpmath.expj(-q * a) for a in bank) for bank in banks.values()]
        whole = mpmath.fsum(map(abs, own))
        share = abs(mpmath.fsum(own)) / whole if whole > little * len(drive.firing) else mpf(0)
        both = zip(own, banks.values(), strict=True)
        in_phase = all(abs(s) > (1 - little) * len(bank) for s, bank in both)
        major.append(bool(in_phase and share > little))
        factor.append(share)
    return major, factor


def _sure(reader: Reader) -> list[int]:
    return list(range(len(reader.natural.frequency)))


def _silent(reader: Reader) -> list[bool]:
    """Modes near which no response peaks."""
    damped = are_poles(reader.record)
    modes = zip(reader.natural.frequency, reader.natural.ratio, strict=True)
    return [w == 0 or bool(damped and z * z >= 0.5) for w, z in modes]


def operating(reader: Reader, place: str) -> Iterator[Truth]:
    """Half ranges of the line, the bare and the healthy one, at the operating speed."""
    state, record = reader.others[place], reader.record
    ratio = state.line.section_ratio
    twist, torque = (state.sections(reader.speed, what) for what in ("twist", "torque"))
    path = ROOT + place
    halves = [t.half * abs(r) for t, r in zip(twist, ratio, strict=True)]
    yield f"{path}twist_half_range", halves
    own = [t.half / abs(r) for t, r in zip(torque, ratio, strict=True)]
    yield f"{path}torque_half_range", own
    yield from stresses(reader, f"{path}stress_half_range", own)
    if place == "bare/":
        frequency = state.modes.frequency
        yield f"{path}natural_frequency", frequency
    if place == "healthy/":
        mean = mpmath.fsum(s * state.drive.healthy(reader.speed)[1] for s in state.drive.scale)
        yield f"{path}mean_torque", mean
    if f"{path}damper/travel" in record:
        rings = [one.element for one in reader.line.built.dampers]
        travel = [twist[e].peak * abs(ratio[e]) for e in rings]
        yield f"{path}damper/travel", travel
        heat = section_heat(state, reader.speed)
        yield f"{path}damper/heat", [heat[e] for e in rings]


def stresses(reader: Reader, path: str, torque: list[mpf]) -> Iterator[Truth]:
    """Of own torques by section: over the modulus of the sections that have one."""
    if path not in reader.record:
        return
    moduli = section_moduli(reader)
    truth = [torque[e] / w for e, w in moduli.items() if e < len(torque)]
    yield path, truth


def section_moduli(reader: Reader) -> dict[int, mpf]:
    found = {}
    for e, shaft in enumerate(reader.line.parts.shafts):
        if shaft.diameter is not None or shaft.section is not None:
            wide = mpf(shaft.diameter or shaft.section.outer_diameter)
            found[e] = mp.pi * wide**3 / 16
    return found


def section_heat(state: State, speed: mpf) -> list[mpf]:
    found = state.at(speed)
    total = [mpf(0)] * len(state.elements)
    for w, twist in zip(found.frequency, found.twist, strict=True):
        z = state.element_stiffness(speed, w)
        total = [t + w * k.imag * abs(x) ** 2 / 2 for t, k, x in zip(total, z, twist, strict=True)]
    return total


def own_rows(reader: Reader) -> Iterator[Truth]:
    """Angles, twists, torques by order, means and peaks, heat, gears, of the line itself."""
    state, _record, line = reader.state, reader.record, reader.line
    built, found = line.built, state.at(reader.speed)
    ratio, freedom = line.ratio, built.freedom.tolist()
    angle = [[row[f] * r for row in found.angle] for f, r in zip(freedom, ratio, strict=True)]
    yield f"{ROOT}angle", angle
    turned = [state.sum_of(row) for row in angle]
    yield f"{ROOT}angle_half_range", [t.half for t in turned]
    yield f"{ROOT}angle_peak", [t.peak for t in turned]
    section = list(enumerate(line.section_ratio))
    twist = [[row[e] * r for row in found.twist] for e, r in section]
    yield f"{ROOT}twist", twist
    peaks = [state.sum_of(row).peak for row in twist]
    yield f"{ROOT}twist_peak", peaks
    torque = [[row[e] / r for row in found.torque] for e, r in section]
    yield f"{ROOT}torque", torque
    yield from stress_rows(reader, torque)
    totals = [state.sum_of(row) for row in torque]
    mean = [m / r for m, (_, r) in zip(mean_sections(reader, reader.speed), section, strict=True)]
    yield f"{ROOT}torque_mean", mean
    peaks = [max(abs(m + t.highest), abs(m + t.lowest)) for m, t in zip(mean, totals, strict=True)]
    yield f"{ROOT}torque_peak", peaks
    yield f"{ROOT}torque_bound", [t.bound for t in totals]
    yield from heats(reader)
    yield from gears(reader)


def stress_rows(reader: Reader, torque: list[list[mpc]]) -> Iterator[Truth]:
    if f"{ROOT}stress" in reader.record:
        truth = [[t / w for t in torque[e]] for e, w in section_moduli(reader).items()]
        yield f"{ROOT}stress", truth


def heats(reader: Reader) -> Iterator[Truth]:
    state, _record, line = reader.state, reader.record, reader.line
    found = state.at(reader.speed)
    yield f"{ROOT}section_heat", section_heat(state, reader.speed)
    parts = [
        mpmath.fsum(w**2 * abs(a[f]) ** 2 / 2
                    for w, a in zip(found.frequency, found.angle, strict=True))
        for f in range(line.count)
    ]  # fmt: skip
    truth = []
    model = reader.torsion.damping_model
    for k, (inertia, damping, held) in enumerate(line.station_values):
        own = damping
        if model is not None:
            own = state.rayleigh[0] * inertia + state.rayleigh[1] * held
        truth.append(own * parts[int(line.built.freedom[k])])
    for attached in line.built.dampers:
        truth[attached.station] += state.damped[attached.ring] * parts[attached.ring]
    yield f"{ROOT}station_heat", truth
    if state.ratios is not None:
        modes = state.modes
        total = [mpf(0)] * len(modes.frequency)
        for w, angle in zip(found.frequency, found.angle, strict=True):
            for k, (shape, inertia) in enumerate(zip(modes.shape, modes.inertia, strict=True)):
                q = (
                    mpmath.fsum(
                        j * x * a for j, x, a in zip(line.inertia, shape, angle, strict=True)
                    )
                    / inertia
                )
                c = 2 * state.ratios[k] * inertia * modes.frequency[k]
                total[k] += w**2 * c * abs(q) ** 2 / 2
        yield f"{ROOT}modal_heat", total


def gears(reader: Reader) -> Iterator[Truth]:
    if f"{ROOT}gear/mean_torque" not in reader.record:
        return
    _record, place = reader.record, f"{ROOT}gear/"
    mean, rows = gear_rows(reader, reader.speed)
    totals = [sums(reader.state.drive.orders, row) for row in rows]
    least = [least_of(m, t) for m, t in zip(mean, totals, strict=True)]
    yield place + "mean_torque", mean
    yield place + "alternating_torque", [t.half for t in totals]
    yield place + "minimum_torque", least
    hammers = [
        mpf(int(m + t.lowest < 0 < m + t.highest)) for m, t in zip(mean, totals, strict=True)
    ]
    yield place + "hammers", hammers


def least_of(mean: mpf, total: Sums) -> mpf:
    """Least torque in the sense of the mean; of a gear that carries none, the lower one of both."""
    if abs(mean) <= mpf(10) ** -25 * (total.highest - total.lowest):
        return min(-(mean + total.highest), mean + total.lowest)
    return -(mean + total.highest) if mean < 0 else mean + total.lowest


def margins(reader: Reader) -> Iterator[Truth]:
    """Distance of modes from orders at the operating speed; critical speeds."""
    _record, natural = reader.record, reader.natural.frequency
    orders, speed = reader.state.drive.orders, reader.speed
    step = orders[-1] - orders[-2] if len(orders) > 1 else orders[-1]
    distance, nearest = [], []
    for w, none in zip(natural, _silent(reader), strict=True):
        blank = none or w > (orders[-1] + step / 2) * speed
        best = min(orders, key=lambda q: abs(w / (speed * q) - 1))
        distance.append(mpf("inf") if blank else abs(w / (speed * best) - 1))
        nearest.append(mpf(0) if blank else best)
    yield f"{ROOT}margin/distance", distance
    yield f"{ROOT}margin/nearest_order", nearest
    yield f"{ROOT}critical/speed", *critical_speeds(reader)
    yield from separations(reader, "operating", speed, speed)
    if reader.torsion.speeds is not None:
        speeds = reader.torsion.speeds
        yield from separations(reader, "range", mpf(speeds.start), mpf(speeds.stop))


def separations(reader: Reader, where: str, low: mpf, high: mpf) -> Iterator[Truth]:
    """Margins from a range of speeds, by class of the orders."""
    place = f"{ROOT}separation/{where}/margin"
    drive = reader.state.drive
    major, _ = bank_truth(reader)
    step = drive.orders[-1] - drive.orders[-2] if len(drive.orders) > 1 else drive.orders[-1]
    rows = []
    for w, none in zip(reader.natural.frequency, _silent(reader), strict=True):
        blank = none or w > (drive.orders[-1] + step / 2) * high
        row = []
        for wanted in (True, False):
            own = [
                max((q * low - w) / (q * low), (w - q * high) / (q * high))
                for q, one in zip(drive.orders, major, strict=True)
                if one == wanted
            ]
            row.append(mpf("inf") if blank or not own else min(own))
        rows.append(row)
    yield place, rows


def allowed(reader: Reader, number: int, section: int, speed: mpf) -> tuple[mpf, mpf]:
    """Stress that limit `number` allows for lasting and passing; infinite where it is silent."""
    limit, none = reader.torsion.limits[number], mpf("inf")
    if limit.curve is not None:
        nodes = list(zip(limit.curve.speed, limit.curve.stress, strict=True))
        for (a, x), (b, y) in pairwise(nodes):
            if a <= speed <= b:
                return mpf(x) + (mpf(y) - mpf(x)) * (speed - mpf(a)) / (mpf(b) - mpf(a)), none
        return none, none
    shaft = reader.line.parts.shafts[section]
    strength = min(mpf(shaft.tensile_strength or limit.tensile_strength), mpf(600) * 10**6)
    wide = mpf(shaft.diameter or shaft.section.outer_diameter) * 1000
    share = speed / reader.speed
    if share > mpf(105) / 100:
        return none, none
    course = 3 - 2 * share**2 if share < mpf(9) / 10 else mpf(138) / 100
    size = mpf(35) / 100 + mpf(93) / 100 * wide ** (-mpf(1) / 5)
    steady = (strength / 10**6 + 160) / 18 * size * course * 10**6
    factor = mpf(limit.design_factor)
    return steady * factor, mpf(17) / 10 * steady * mpmath.sqrt(factor)


def operating_limits(reader: Reader) -> Iterator[Truth]:
    """Uses at the operating speed, of the line and of the healthy one."""
    if not reader.torsion.limits:
        return
    place, record, moduli = f"{ROOT}limit/", reader.record, section_moduli(reader)
    ratio = reader.line.section_ratio
    rows: dict[str, list[list[mpf]]] = {"stress": [], "allowed": [], "transient": [], "use": []}
    for number in range(len(reader.torsion.limits)):
        found = []
        for e, modulus in moduli.items():
            stress = reader.state.half(reader.speed, e) / abs(ratio[e]) / modulus
            steady, passing = allowed(reader, number, e, reader.speed)
            found.append((stress, steady, passing, stress / steady))
        for name, part in zip(rows, zip(*found, strict=True), strict=True):
            rows[name].append(list(part))
    for name, truth in rows.items():
        path = f"{place}operating/{name}"
        yield path, truth
    path = f"{place}operating_use"
    yield path, [max(row) for row in rows["use"]]
    path = f"{ROOT}healthy/limit/operating_use"
    if path in record:
        healthy = reader.others["healthy/"]
        truth = [
            max(healthy.half(reader.speed, e) / abs(ratio[e]) / w
                / allowed(reader, number, e, reader.speed)[0] for e, w in moduli.items())
            for number in range(len(reader.torsion.limits))
        ]  # fmt: skip
        yield path, truth
