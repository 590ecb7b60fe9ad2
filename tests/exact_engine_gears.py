"""Mean torques of a line and torques of its gears in long arithmetic, by balance."""

from typing import Any

import mpmath
from exact_engine_line import solve
from mpmath import mpc, mpf


def mean_stations(reader: Any, speed: mpf, drive: Any = None) -> list[mpf]:
    """Mean torques of all stations, referred, with what takes them up."""
    line, drive = reader.line, drive or reader.state.drive
    mean = drive.healthy(speed)[1]
    found = [mpf(0)] * len(line.ratio)
    for station, scale in zip(line.built.cylinder_station.tolist(), drive.scale, strict=True):
        found[station] += scale * mean * line.ratio[station]
    names = [one.name for one in line.parts.stations]
    for load in line.parts.absorbed_torques:
        at = names.index(load.on)
        taken = mpf(load.torque) * (speed / reader.speed) ** mpf(load.exponent)
        found[at] -= taken * abs(line.ratio[at])
    last = names.index(line.parts.balanced_by) if line.parts.balanced_by else len(names) - 1
    found[last] -= mpmath.fsum(found)
    return found


def mean_sections(reader: Any, speed: mpf) -> list[mpf]:
    """Referred mean torques of the sections, from statics at the operating speed."""
    line, mean = reader.line, mean_stations(reader, speed)
    right = [mpf(0)] * line.count
    for f, one in zip(line.built.freedom.tolist(), mean, strict=True):
        right[f] += one
    elements = line.at(reader.speed)
    links = [(a, b, k) for a, b, k, _, _ in elements if k != 0]
    own = list(line.ground)
    held = {s for a, b, _ in links for s in (a, b)}
    for s in range(line.count):
        if s not in held:  # a ring in oil carries nothing
            own[s] = mpf(1)
    if not any(line.ground):
        own[0] += mpf(1)  # balanced torques do not load what holds the line
    angle = solve(own, links, right)
    return [k * (angle[a] - angle[b]) for a, b, k, _, _ in elements]


def _braking(state: Any, w: mpf, angle: list[mpc]) -> list[mpc]:
    """Torque per inertia that damping ratios of the modes take."""
    modes, inertia = state.modes, state.line.inertia
    total = [mpc(0)] * len(angle)
    for own, shape, whole, ratio in zip(
        modes.frequency, modes.shape, modes.inertia, state.ratios, strict=True
    ):
        lever = mpmath.fsum(j * x * a for j, x, a in zip(inertia, shape, angle, strict=True))
        part = mpc(0, w) * 2 * ratio * own * lever / whole
        total = [t + part * x for t, x in zip(total, shape, strict=True)]
    return total


def gear_rows(reader: Any, speed: mpf, state: Any = None) -> tuple[list[mpf], list[list[mpc]]]:
    """Mean torque and its orders on the first wheel of each gear."""
    line, state = reader.line, state or reader.state
    parts, built, found = line.parts, line.built, state.at(speed)
    names = [one.name for one in parts.stations]
    mean, sections = mean_stations(reader, speed), mean_sections(reader, speed)
    rigid = [g for g in parts.gears if g.mesh_stiffness is None]
    element, means, rows = len(parts.shafts), [], []
    for gear in parts.gears:
        own = 1 / line.ratio[names.index(gear.between[0])]
        if gear.mesh_stiffness is not None:
            means.append(sections[element] * own)
            rows.append([row[element] * own for row in found.torque])
            element += 1
            continue
        side = {names.index(gear.between[1])}
        for _ in names:
            for other in rigid:
                ends = {names.index(name) for name in other.between}
                if other is not gear and ends & side:
                    side |= ends
        out = []
        for a, b in built.section_ends.tolist():
            out.append(int(a in side) - int(b in side))
        total = -mpmath.fsum(mean[s] for s in side)
        means.append((total + mpmath.fsum(o * m for o, m in zip(out, sections, strict=True))) * own)
        inertia, damping, held = (
            mpmath.fsum(line.station_values[s][k] for s in side) for k in range(3)
        )
        if reader.torsion.damping_model is not None:
            damping = state.rayleigh[0] * inertia + state.rayleigh[1] * held
        wheel = int(built.freedom[names.index(gear.between[1])])
        row = []
        for place, w in enumerate(found.frequency):
            value = mpc(held - w**2 * inertia, w * damping) * found.angle[place][wheel]
            if state.ratios is not None:  # damping of the modes goes with the inertias
                value += inertia * _braking(state, w, found.angle[place])[wheel]
            torque = found.torque[place]
            value += mpmath.fsum(o * t for o, t in zip(out, torque, strict=True) if o)
            for station, load in zip(
                built.cylinder_station.tolist(), found.load[place], strict=True
            ):
                if station in side:
                    value -= load
            row.append(value * own)
        rows.append(row)
    return means, rows
