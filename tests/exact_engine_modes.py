"""Modes of a shaft line in long arithmetic: poles, shapes, energies, Holzer tables, criticals."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import mpmath
import numpy as np
from exact_engine_line import ExactModes, exact_pole, solve
from mpmath import mp, mpc, mpf

from vibecalc.torsion.holzer import holzer_rows

ROOT = "response/torsion/"
Truth = tuple[Any, ...]


def modal_results(reader: Any) -> Iterator[Truth]:
    """Frequencies, shapes and what is formed of them, of the line at its operating speed."""
    record, line, undamped = reader.record, reader.line, reader.state.modes
    place, built, modes = f"{ROOT}modes/", line.built, reader.natural
    yield place + "natural_frequency", modes.frequency
    if place + "damping_ratio" in record:
        yield place + "damping_ratio", modes.ratio
    for name in ("undamped_frequency", "transfer_matrix_frequency"):
        if place + name in record:
            yield place + name, undamped.frequency
    shape = [
        [s[f] * r for f, r in zip(built.freedom.tolist(), line.ratio, strict=True)]
        for s in modes.shape
    ]
    yield place + "shape", shape
    if f"{place}ring_shape" in record:
        own = [[s[d.ring] * line.ratio[d.station] for d in built.dampers] for s in modes.shape]
        yield place + "ring_shape", own
    yield place + "modal_inertia", modes.inertia
    yield from _energies(reader, place)
    yield from _holzer(reader, place)


def _energies(reader: Any, place: str) -> Iterator[Truth]:
    state, modes, _record = reader.state, reader.natural, reader.record
    stiffness = [k for _, _, k, _, _ in state.line.at(reader.speed)]
    shares = []
    for w, shape in zip(modes.frequency, modes.shape, strict=True):
        if w == 0:
            shares.append([mpf(0)] * len(stiffness))
            continue
        twist = [shape[a] - shape[b] for a, b, *_ in state.elements]
        energy = [k * abs(t) ** 2 for k, t in zip(stiffness, twist, strict=True)]
        held = mpmath.fsum(g * abs(x) ** 2 for g, x in zip(state.line.ground, shape, strict=True))
        total = mpmath.fsum(energy) + held
        shares.append([e / total for e in energy])
    yield f"{place}strain_energy_share", shares


def _holzer(reader: Any, place: str) -> Iterator[Truth]:
    """Angles and torques of the modes in the order of the table's rows."""
    if f"{place}holzer_angle" not in reader.record:
        return
    line, modes, record = reader.line, reader.state.modes, reader.record
    rows = holzer_rows(line.built.at(float(reader.speed)))
    angles, inertias, sums = [], [], []
    found = record[f"{place}holzer_angle"].values
    for number, (w, shape) in enumerate(zip(modes.frequency, modes.shape, strict=True)):
        own = [shape[f] for f in rows.freedom.tolist()]
        top = max(map(abs, own))
        # a first row that all but stands still is no measure; which it is, is a matter of taste
        first = mpf(1) if abs(found[number, 0]) < 0.999 or own[0] == 0 else own[0]
        assert first != 1 or own[0] == 1 or abs(own[0]) <= mpf(2) / 10**6 * top
        angle = [x / first for x in own]
        torque = [w**2 * line.inertia[f] * x for f, x in zip(rows.freedom, angle, strict=True)]
        total = [
            t - line.ground[f] * x for t, f, x in zip(torque, rows.freedom, angle, strict=True)
        ]
        for row, below in enumerate(rows.below[:-1].tolist()):
            total[below] += total[row]
        for table, part in ((angles, angle), (inertias, torque), (sums, total)):
            table.append(part)
    for name, truth in (("angle", angles), ("inertia_torque", inertias), ("torque", sums)):
        yield f"{place}holzer_{name}", truth


class Natural(NamedTuple):
    """Modes of the line as it vibrates; `inertia` is the sum of J |shape|^2."""

    frequency: list[mpf]
    ratio: list[mpf]
    shape: list[list[Any]]
    inertia: list[mpf]
    pole: list[mpc]


def natural_modes(reader: Any) -> Natural:
    """From the ones found: every pole once more, no two alike, and all together add up."""
    record, state, place = reader.record, reader.state, f"{ROOT}modes/"
    undamped, line = state.modes, state.line
    size, ratios = record[place + "natural_frequency"].values, state.ratios
    if place + "damping_ratio" not in record:  # a mode that no longer vibrates, as a warning says
        assert any("no damping ratios" in text for text in record.warnings)
        ratios = [mpf(0)] * len(size)
    if ratios is not None:
        return Natural(undamped.frequency, ratios, undamped.shape, undamped.inertia, [])
    ratio = record[place + "damping_ratio"].values
    damped = are_poles(record)
    still = int(np.count_nonzero(size == 0.0))
    resting = _resting(reader)
    found = Natural([], [], [], [], [])
    for number, (w, zeta) in enumerate(zip(size.tolist(), ratio.tolist(), strict=True)):
        if w == 0.0:
            shape = undamped.shape[number]
            if damped:
                shape = resting[number] if number < len(resting) else [mpf(0)] * line.count
            mass = mpmath.fsum(j * x**2 for j, x in zip(line.inertia, shape, strict=True))
            assert (zeta == 1.0) == (mass == 0)
            _append(found, mpf(0), mpf(zeta), shape, mass, mpc(0))
            continue
        pole, shape = _pole(state, reader.speed, w, zeta, damped)
        truth = -pole.real / abs(pole)
        if not damped:
            _append(found, undamped.frequency[number], truth, undamped.shape[number],
                    undamped.inertia[number], pole)  # fmt: skip
            continue
        shape = _scaled(shape, line.count - len(reader.line.built.dampers))
        mass = mpmath.fsum(j * abs(x) ** 2 for j, x in zip(line.inertia, shape, strict=True))
        _append(found, abs(pole), truth, shape, mass, pole)
    poles = [pole for pole in found.pole if pole != 0]
    for k, one in enumerate(poles):
        assert all(abs(one - p) > mpf(10) ** -20 * abs(one) for p in poles[:k])
    assert len(poles) == len(size) - still
    return found


def are_poles(record: Any) -> bool:
    """Whether the modes of a result are those of the damped line."""
    path = f"{ROOT}modes/undamped_frequency"
    if path not in record:
        return False
    natural = record[f"{ROOT}modes/natural_frequency"].values
    return not np.array_equal(record[path].values, natural)


def _pole(state: Any, speed: mpf, w: float, zeta: float, damped: bool) -> tuple[mpc, list[Any]]:
    """Pole and shape next to a frequency and damping ratio found.

    Loss factors are dashpots at the size of the pole itself.
    """
    own = mpf(w)
    standing = [k + s * speed**2 for _, _, k, _, _, s in state.elements]
    guess = mpc(-w * zeta, w * np.sqrt(max(1.0 - zeta**2, 0.0)))
    if not damped:  # undamped frequencies can be far from the poles of modes that damping couples
        found = _rough_poles(state, standing, float(own))
        off = np.abs(-found.real / np.abs(found) / zeta - 1.0) + np.abs(np.abs(found) / w - 1.0)
        guess = mpc(found[np.argmin(off)]) if zeta > 0.0 else guess
    for _ in range(60):
        elements = [
            (a, b, k, c + eta * k / own)
            for (a, b, _, c, eta, _), k in zip(state.elements, standing, strict=True)
        ]
        pole, shape = exact_pole(state.line, elements, state.damped, guess)
        before, guess = own, pole
        own = abs(pole)
        if abs(own - before) <= mpf(10) ** -30 * own:
            break
    return pole, shape


def _rough_poles(state: Any, standing: list[mpf], own: float) -> np.ndarray:
    """Poles of modes that vibrate, in doubles."""
    n = state.line.count
    k = np.diag([float(g) for g in state.line.ground])
    c = np.diag([float(d) for d in state.damped])
    for (a, b, _, dashpot, eta, _), spring in zip(state.elements, standing, strict=True):
        for table, one in ((k, float(spring)), (c, float(dashpot + eta * spring / own))):
            table[[a, b], [a, b]] += one
            table[[a, b], [b, a]] -= one
    inverse = 1.0 / np.array([[float(j)] for j in state.line.inertia])
    whole = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse * k, -inverse * c]])
    found = np.linalg.eigvals(whole)
    return found[found.imag > 0.0]


def frequencies_at(reader: Any, speed: mpf, found: list[float]) -> list[mpf]:
    """Natural frequencies at another speed: where rings are damped, of poles next to `found`."""
    record, place = reader.record, f"{ROOT}modes/"
    if reader.state.ratios is not None or not are_poles(record):
        return ExactModes(reader.line, speed).frequency
    ratio = record[place + "damping_ratio"].values.tolist()
    sizes = [
        mpf(0) if w == 0.0 else abs(_pole(reader.state, speed, w, zeta, True)[0])
        for w, zeta in zip(found, ratio, strict=True)
    ]
    moving = [size for size in sizes if size]
    assert all(b - a > mpf(10) ** -20 * b for a, b in pairwise(moving))
    return sizes


def _resting(reader: Any) -> list[list[mpf]]:
    """Where nothing brings a line of one piece back: all together, each ring without a spring."""
    line = reader.state.line
    found = [] if any(line.ground) else [[mpf(1)] * line.count]
    rings = {one.ring for one in reader.line.built.dampers}
    held = {b for _, b, k, _, _, s in line.elements if k or s}
    for ring in sorted(rings - held):
        found.append([mpf(int(f == ring)) for f in range(line.count)])
    return found


def _append(found: Natural, *parts: Any) -> None:
    for row, part in zip(found, parts, strict=True):
        row.append(part)


def _scaled(shape: list[mpc], stations: int) -> list[mpc]:
    """The largest of the stations at 1, of several within a thousandth the first."""
    size = [abs(x) for x in shape[:stations]]
    top = max(size)
    first = next(k for k, x in enumerate(size) if x >= top * (1 - mpf(1) / 1000))
    return [x * size[first] / (shape[first] * top) for x in shape]


def critical_speeds(reader: Any) -> tuple[Any, Any]:
    """Critical speeds (mode, order), with pendulums from the values found, and these."""
    path = f"{ROOT}critical/speed"
    found, state = reader.record[path].values, reader.state
    orders = state.drive.orders
    modes = reader.natural
    damped = are_poles(reader.record)
    if not any(s for *_, s in state.elements):
        # nothing peaks near a mode that is damped by more than 1 / sqrt 2
        none = [damped and w > 0 and z * z >= 0.5 for w, z in zip(*modes[:2], strict=True)]
        return [
            [mpf("inf") if no else w / q for q in orders]
            for w, no in zip(modes.frequency, none, strict=True)
        ], found
    truth = []
    met = _met_by_pole if damped else _met
    for row in found.tolist():
        truth.append([met(state, q, one) for q, one in zip(orders, row, strict=True)])
    return truth, found


def _met_by_pole(state: Any, order: mpf, guess: float) -> mpf:
    """Speed near a guess at which a pole has |s| = q w, by the secant method."""
    if guess == 0.0 or not np.isfinite(guess):
        return mpf(guess)
    line = state.line

    def dashed(at: mpf) -> list[tuple[int, int, mpf, mpf]]:
        return [
            (a, b, k + s * at**2, c + eta * (k + s * at**2) / (order * at))
            for a, b, k, c, eta, s in state.elements
        ]

    def left(at: mpf, pole: mpc) -> tuple[mpf, mpc]:
        pole, _ = exact_pole(line, dashed(at), state.damped, pole)
        return abs(pole) - order * at, pole

    at = mpf(guess)
    one, pole = left(at, _nearest_pole(line, dashed(at), state.damped, order * at))
    assert abs(one) < mpf(10) ** -6 * order * at, "the pole at a critical speed is another one"
    other = at * (1 + mpf(10) ** -8)
    two, pole = left(other, pole)
    for _ in range(40):
        if two == one or abs(two) <= mpf(10) ** -32 * order * at:
            return other
        at, other, one = other, other - two * (other - at) / (two - one), two
        two, pole = left(other, pole)
    raise AssertionError("a critical speed of a pole did not settle")


def _met(state: Any, order: mpf, guess: float) -> mpf:
    """Speed near a guess at which K + w^2 S - q^2 w^2 J is singular, by inverse iteration."""
    if guess == 0.0 or not np.isfinite(guess):
        return mpf(guess)
    line, square = state.line, mpf(guess) ** 2
    # first a little off, then with the quotient of the vector
    shape = [mpf(1) + mpf(k) / 7 for k in range(line.count)]
    near = square * (1 + mpf(10) ** -13)
    for _ in range(30):
        links = [(a, b, k + near * s) for a, b, k, _, _, s in state.elements]
        own = [g - order**2 * near * j for g, j in zip(line.ground, line.inertia, strict=True)]
        turned = _kinetic(state, order, shape)
        shape = solve(own, links, turned)
        top = max(map(abs, shape))
        shape = [x / top for x in shape]
        weight = mpmath.fsum(
            x * y for x, y in zip(shape, _kinetic(state, order, shape), strict=True)
        )
        energy = mpmath.fsum(k * (shape[a] - shape[b]) ** 2 for a, b, k, *_ in state.elements)
        energy += mpmath.fsum(g * x**2 for g, x in zip(line.ground, shape, strict=True))
        last, square = square, energy / weight
        if abs(square - last) <= mpf(10) ** (12 - mp.dps) * abs(square):
            return mpmath.sqrt(square)
        if abs(square - mpf(guess) ** 2) < mpf(10) ** -6 * square:
            near = square * (1 + mpf(10) ** (6 - mp.dps))
    raise AssertionError("a critical speed did not settle")


def _nearest_pole(line: Any, elements: list[Any], damped: list[mpf], size: mpf) -> mpc:
    """The swinging pole of nearly that magnitude, in floats."""
    n = line.count
    damping = np.diag([float(c) for c in damped])
    stiffness = np.diag([float(g) for g in line.ground])
    for a, b, k, c in elements:
        ends = np.zeros(n)
        ends[[a, b]] = 1.0, -1.0
        stiffness += float(k) * np.outer(ends, ends)
        damping += float(c) * np.outer(ends, ends)
    inertia = np.array([[float(j)] for j in line.inertia])
    lower = np.hstack([-stiffness / inertia, -damping / inertia])
    poles = np.linalg.eigvals(np.vstack([np.eye(n, 2 * n, n), lower]))
    poles = poles[poles.imag > 0.1 * np.abs(poles)]
    return mpc(complex(poles[np.argmin(np.abs(np.abs(poles) - float(size)))]))


def _kinetic(state: Any, order: mpf, shape: list[mpf]) -> list[mpf]:
    """(q^2 J - S) x."""
    found = [order**2 * j * x for j, x in zip(state.line.inertia, shape, strict=True)]
    for a, b, _, _, _, s in state.elements:
        found[a] -= s * (shape[a] - shape[b])
        found[b] -= s * (shape[b] - shape[a])
    return found
