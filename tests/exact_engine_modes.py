"""Modes of a shaft line in long arithmetic: shapes, energies, Holzer tables, poles, criticals."""

from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
from exact_engine_line import exact_pole, solve
from mpmath import mp, mpc, mpf

from vibecalc.response.torsion.holzer import holzer_rows

ROOT = "response/torsion/"
Truth = tuple[str, Any, Any]


def modal_results(reader: Any) -> Iterator[Truth]:
    """Frequencies, shapes and what is formed of them, of the line at its operating speed."""
    record, line, modes = reader.record, reader.line, reader.state.modes
    place, built = f"{ROOT}modes/", line.built
    for name in ("natural_frequency", "transfer_matrix_frequency"):
        if place + name in record:
            yield place + name, record[place + name].values, modes.frequency
    shape = [
        [s[f] * r for f, r in zip(built.freedom.tolist(), line.ratio, strict=True)]
        for s in modes.shape
    ]
    yield place + "shape", record[place + "shape"].values, shape
    if f"{place}ring_shape" in record:
        own = [[s[d.ring] * line.ratio[d.station] for d in built.dampers] for s in modes.shape]
        yield place + "ring_shape", record[place + "ring_shape"].values, own
    yield place + "modal_inertia", record[place + "modal_inertia"].values, modes.inertia
    yield from _energies(reader, place)
    yield from _holzer(reader, place)
    yield from _poles(reader)


def _energies(reader: Any, place: str) -> Iterator[Truth]:
    state, modes, record = reader.state, reader.state.modes, reader.record
    stiffness = [k for _, _, k, _, _ in state.line.at(reader.speed)]
    shares, ratios = [], []
    for number, (w, shape) in enumerate(zip(modes.frequency, modes.shape, strict=True)):
        if w == 0:
            shares.append([mpf(0)] * len(stiffness))
            ratios.append(mpf(0))
            continue
        twist = [shape[a] - shape[b] for a, b, *_ in state.elements]
        energy = [k * t**2 for k, t in zip(stiffness, twist, strict=True)]
        held = mpmath.fsum(g * x**2 for g, x in zip(state.line.ground, shape, strict=True))
        total = mpmath.fsum(energy) + held
        shares.append([e / total for e in energy])
        if state.ratios is not None:
            ratios.append(state.ratios[number])
            continue
        work = mpmath.fsum(
            (w * c + k * eta) * t**2
            for (_, _, _, c, eta, _), k, t in zip(state.elements, stiffness, twist, strict=True)
        )
        work += w * mpmath.fsum(c * x**2 for c, x in zip(state.damped, shape, strict=True))
        ratios.append(work / (2 * modes.inertia[number] * w**2))
    for name, truth in (("strain_energy_share", shares), ("energy_damping_ratio", ratios)):
        yield place + name, record[place + name].values, truth


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
        yield f"{place}holzer_{name}", record[f"{place}holzer_{name}"].values, truth


def _poles(reader: Any) -> Iterator[Truth]:
    """Every pole from the one found; no two alike, and all of them together add up."""
    place, record, state = f"{ROOT}damped/", reader.record, reader.state
    if f"{place}frequency" not in record:
        return
    size, ratio = (record[place + name].values for name in ("frequency", "damping_ratio"))
    line, loss = state.line, any(eta for *_, eta, _ in state.elements)
    standing = [k + s * reader.speed**2 for _, _, k, _, _, s in state.elements]
    poles: list[mpc] = []
    for number, (w, zeta) in enumerate(zip(size.tolist(), ratio.tolist(), strict=True)):
        if w == 0.0:
            poles.append(mpc(0))
            continue
        natural = state.modes.frequency[number] if loss else mpf(1)
        elements = [
            (a, b, k, c + eta * k / natural)
            for (a, b, _, c, eta, _), k in zip(state.elements, standing, strict=True)
        ]
        guess = mpc(-w * zeta, w * np.sqrt(max(1.0 - zeta**2, 0.0)))
        poles.append(exact_pole(line, elements, state.damped, guess))
    moving = [p for p in poles if p != 0]
    # damping of the inertias gives all pieces that nothing holds one and the same real pole
    alike = loss or reader.torsion.damping_model is not None
    for k, one in enumerate(moving):
        assert alike or all(abs(one - p) > mpf(10) ** -20 * abs(one) for p in moving[:k])
    if not loss:
        trace = mpmath.fsum(c / j for c, j in zip(state.damped, line.inertia, strict=True))
        for a, b, _, c, _, _ in state.elements:
            trace += c / line.inertia[a] + c / line.inertia[b]
        total = mpmath.fsum(
            (2 if abs(p.imag) > mpf(10) ** -15 * abs(p) else 1) * p.real for p in moving
        )
        assert abs(total + trace) <= mpf(10) ** -15 * abs(trace), "poles are missing"
    yield place + "frequency", size, [abs(p) for p in poles]
    yield place + "damping_ratio", ratio, [-p.real / abs(p) if p else mpf(0) for p in poles]


def critical_speeds(reader: Any) -> tuple[Any, Any]:
    """Found values and critical speeds (mode, order); with pendulums from the values found."""
    path = f"{ROOT}critical/speed"
    found, state = reader.record[path].values, reader.state
    orders = state.drive.orders
    if not any(s for *_, s in state.elements):
        return found, [[w / q for q in orders] for w in state.modes.frequency]
    truth = [
        [_met(state, q, one) for q, one in zip(orders, row, strict=True)] for row in found.tolist()
    ]
    return found, truth


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


def _kinetic(state: Any, order: mpf, shape: list[mpf]) -> list[mpf]:
    """(q^2 J - S) x."""
    found = [order**2 * j * x for j, x in zip(state.line.inertia, shape, strict=True)]
    for a, b, _, _, _, s in state.elements:
        found[a] -= s * (shape[a] - shape[b])
        found[b] -= s * (shape[b] - shape[a])
    return found
