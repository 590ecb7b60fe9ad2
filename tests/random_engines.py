"""Seeded random engines as case tables: rows, branches, gears, dampers, cards and cycles."""

from itertools import pairwise
from typing import Any

import numpy as np

Table = dict[str, Any]
RTOLS = (1e-3, 1e-6, 1e-9)
#: of the cards, shares of a cycle and of the highest pressure: compression, firing, expansion
SHAPE = ((0.0, 0.0), (0.25, 0.01), (0.42, 0.2), (0.5, 0.8), (0.513, 1.0), (0.56, 0.5),
         (0.64, 0.15), (0.75, 0.04), (0.9, 0.005), (1.0, 0.0))  # fmt: skip


def random_engine(seed: int) -> Table:
    """A whole case for `vibecalc.core.case.load.validate`, all values in SI."""
    draw = np.random.default_rng([seed, 7])
    four = bool(draw.random() < 0.7)
    speed = float(draw.uniform(20.0, 400.0))
    cylinders = int(draw.integers(1, 9))
    train = _train(draw, cylinders, four, speed)
    line = _line(draw, train, speed)
    torsion = _torsion(draw, train, line, speed, four)
    return {
        "schema": 1,
        "title": f"random engine {seed}",
        "machine": {
            "kind": "engine",
            "cycle": "four_stroke" if four else "two_stroke",
            "speed": speed,
            "crank_train": train,
            "shaft_line": line,
        },
        "response": {"torsion": torsion},
        "accuracy": {"rtol": float(draw.choice(RTOLS))},
    }


def _spread(draw: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def _train(draw: np.random.Generator, count: int, four: bool, speed: float) -> Table:
    radius = _spread(draw, 0.03, 0.3)
    mass = _spread(draw, 0.2, 200.0) * radius / 0.1
    names = [str(n + 1) for n in range(count)]
    train: Table = {
        "crank_radius": radius,
        "rod_length": radius / draw.uniform(0.15, 0.4),
        "bore": radius * draw.uniform(1.2, 2.2),
        "cylinders": [{"name": name} for name in names],
    }
    if draw.random() < 0.25:
        share = float(draw.uniform(0.2, 0.5))
        rod = {"mass": 0.7 * mass, "crank_pin_to_mass_centre": share * train["rod_length"]}
        if draw.random() < 0.5:
            rod["inertia"] = 0.1 * mass * train["rod_length"] ** 2
        train |= {"piston_mass": mass, "pin_mass": 0.2 * mass, "rod": rod}
    else:
        train["reciprocating_mass"] = mass
    if draw.random() < 0.2:
        train["wrist_pin_offset"] = radius * float(draw.uniform(-0.1, 0.1))
    for one in train["cylinders"]:
        if draw.random() < 0.1:
            one["pressure_scale"] = float(draw.uniform(0.7, 1.1))
        if draw.random() < 0.1 and "rod" not in train:
            one["reciprocating_mass"] = mass * float(draw.uniform(0.9, 1.1))
    cycle = (4.0 if four else 2.0) * np.pi
    if draw.random() < 0.6:
        train["firing_order"] = [names[k] for k in draw.permutation(count)]
        if draw.random() < 0.3 and count > 1:
            steps = draw.uniform(0.5, 1.5, count)
            train["firing_intervals"] = (cycle * steps / steps.sum()).tolist()
    else:
        for one in train["cylinders"]:
            one["firing_angle"] = float(draw.uniform(0.0, cycle))
    train |= _gas(draw, cycle, speed)
    return train


def _card(draw: np.random.Generator, cycle: float, highest: float) -> Table:
    place, height = np.array(SHAPE).T
    height = height * draw.uniform(0.8, 1.2, len(height))
    height[-1] = height[0]
    start = -0.5 * cycle
    return {
        "crank_angle": (start + cycle * place).tolist(),
        "pressure": (highest * height).tolist(),
    }


def _gas(draw: np.random.Generator, cycle: float, speed: float) -> Table:
    highest, kind = _spread(draw, 2e6, 2e7), draw.random()
    if kind < 0.35:
        found: Table = {"gas_pressure": _card(draw, cycle, highest)}
    elif kind < 0.6:
        ends = (0.1 * speed, 0.8 * speed, 2.0 * speed)
        cards = [_card(draw, cycle, share * highest) for share in (0.6, 1.0, 0.9)]
        found = {
            "gas_cards": [
                {"speed": at, "gas_pressure": card} for at, card in zip(ends, cards, strict=True)
            ]
        }
    else:
        diesel = bool(draw.random() < 0.6)
        own: Table = {
            "kind": "diesel" if diesel else "spark",
            "compression_ratio": float(draw.uniform(12, 18) if diesel else draw.uniform(7, 11)),
        }
        if draw.random() < 0.5:
            own["peak_pressure"] = float(draw.uniform(1.5e7, 2.2e7) if diesel else 6e6)
        else:
            own["mean_indicated_pressure"] = float(draw.uniform(0.8e6, 2e6))
        return {"gas_cycle": own}
    if draw.random() < 0.4:
        found["gas_interpolation"] = "cubic"
    return found


def _line(draw: np.random.Generator, train: Table, speed: float) -> Table:
    """Cylinders one by one or in pairs, then flywheel and more, perhaps a branch behind gears."""
    names = [one["name"] for one in train["cylinders"]]
    pairs = len(names) > 1 and bool(draw.random() < 0.25)
    throws = [names[k : k + 2] for k in range(0, len(names), 2)] if pairs else [[n] for n in names]
    size = _spread(draw, 0.05, 50.0)
    stations: list[Table] = []
    for number, held in enumerate(throws):
        own = {"cylinder": held[0]} if len(held) == 1 else {"cylinders": held}
        inertia = size * float(draw.uniform(0.9, 1.1) if draw.random() < 0.3 else 1.0)
        stations.append({"name": f"throw {number + 1}", "inertia": inertia, **own})
    behind = int(draw.integers(1, 4))
    for number in range(behind):
        inertia = size * _spread(draw, 0.3, 100.0)
        stations.append({"name": f"wheel {number + 1}", "inertia": inertia})
    row = [one["name"] for one in stations]
    # the lowest elastic mode of the row is excited by a low to a high order
    natural = speed * _spread(draw, 0.5, 12.0)
    stiff = size * (natural * len(throws)) ** 2 * 0.5
    ends = list(pairwise(row))
    branch: list[tuple[str, str]] = []
    gears: list[Table] = []
    if draw.random() < 0.35:
        for which in range(int(draw.integers(1, 3))):
            gears.append(_branch(draw, which, stations, branch, size, stiff))
    damping = draw.choice(["dashpot", "ratio", "loss", "none"], p=[0.5, 0.25, 0.2, 0.05])
    shafts = [_shaft(draw, pair, stiff, size, natural, str(damping)) for pair in (*ends, *branch)]
    if draw.random() < 0.4:
        for one in stations[: len(throws)]:
            one["absolute_damping"] = float(size * natural * _spread(draw, 1e-4, 0.03))
    if draw.random() < 0.08:
        stations[-1]["ground_stiffness"] = stiff * _spread(draw, 1e-3, 1.0)
    line: Table = {"stations": stations, "shafts": shafts}
    if gears:
        line["gears"] = gears
    if draw.random() < 0.45:
        line["dampers"] = [_damper(draw, row, size, natural)]
    if draw.random() < 0.2:
        load = {"on": stations[-1]["name"], "torque": 10.0 * size, "exponent": 2.0}
        line |= {"balanced_by": row[-1], "absorbed_torques": [load]}
    return line


def _branch(
    draw: np.random.Generator, which: int, stations: list[Table],
    shafts: list[tuple[str, str]], size: float, stiff: float,
) -> Table:  # fmt: skip
    first, last = f"gear {which + 1}", f"end {which + 1}"
    driver = [one["name"] for one in stations if one["name"].startswith("wheel")][-1]
    stations.append({"name": first, "inertia": size * _spread(draw, 0.1, 3.0)})
    stations.append({"name": last, "inertia": size * _spread(draw, 0.5, 30.0)})
    shafts.append((first, last))
    gear: Table = {"name": f"mesh {which + 1}", "between": [driver, first]}
    gear["teeth"] = [int(draw.integers(17, 60)), int(draw.integers(17, 140))]
    if draw.random() < 0.4:
        gear |= {"pitch_radius": 0.2, "mesh_stiffness": stiff * _spread(draw, 3.0, 100.0) / 0.04}
    return gear


def _shaft(
    draw: np.random.Generator, pair: tuple[str, str], stiff: float, size: float,
    natural: float, damping: str,
) -> Table:  # fmt: skip
    own = stiff * _spread(draw, 0.2, 3.0) if draw.random() < 0.5 else stiff
    shaft: Table = {"between": list(pair), "stiffness": own}
    if draw.random() < 0.15:
        wide = 0.1
        length = np.pi * wide**4 / 32.0 * 80e9 / own
        shaft = {"between": list(pair), "section": {"outer_diameter": wide, "length": length}}
    elif draw.random() < 0.6:
        shaft["diameter"] = float(draw.uniform(0.05, 0.3))
    if draw.random() < 0.5:
        shaft["tensile_strength"] = 7e8
    if damping == "dashpot":
        shaft["damping"] = own / natural * _spread(draw, 1e-3, 0.05)
    elif damping == "ratio":
        shaft["damping_ratio"] = float(draw.uniform(0.002, 0.05))
    elif damping == "loss":
        shaft["loss_factor"] = float(draw.uniform(0.005, 0.1))
    return shaft


def _damper(draw: np.random.Generator, row: list[str], size: float, natural: float) -> Table:
    kind = str(draw.choice(["viscous", "spring", "pendulum"], p=[0.4, 0.4, 0.2]))
    ring, damper = size * _spread(draw, 0.3, 3.0), {"name": "damper", "on": row[0], "kind": kind}
    if kind == "pendulum":
        order = float(draw.choice([1.5, 3.0, 4.5])) * (1.0 if draw.random() < 0.3 else 0.97)
        arm = 0.2
        damper |= {"order": order, "mass": ring / 4.0 / arm**2, "count": 4, "arm_radius": arm}
        return damper | {"damping": 0.01 * ring * natural}
    damper |= {"inertia": ring, "damping": ring * natural * _spread(draw, 0.03, 1.0)}
    if kind == "spring":
        damper["stiffness"] = ring * (natural * float(draw.uniform(0.4, 1.2))) ** 2
    return damper


def _torsion(
    draw: np.random.Generator, train: Table, line: Table, speed: float, four: bool
) -> Table:
    torsion: Table = {}
    if draw.random() < 0.7:
        torsion["orders"] = {
            "step": float(draw.choice([0.5, 1.0])) if four else 1.0,
            "count": int(draw.integers(4, 25)),
        }
    if draw.random() < 0.75:
        low = float(draw.uniform(0.3, 0.7)) * speed
        torsion["speeds"] = {"from": low, "to": 1.2 * speed, "points": int(draw.integers(21, 80))}
    kind = draw.random()
    shafts = line["shafts"]
    undamped = not any({"damping", "damping_ratio", "loss_factor"} & set(one) for one in shafts)
    if kind < 0.1 or (undamped and "dampers" not in line):
        elastic = 2 + sum(d["kind"] == "viscous" for d in line.get("dampers", ()))
        free = not any("ground_stiffness" in one for one in line["stations"])
        if kind < 0.05 and free and len(line["stations"]) > 3:
            torsion["damping_model"] = {
                "kind": "rayleigh", "modes": [elastic, elastic + 1], "ratios": [0.01, 0.02],
            }  # fmt: skip
        else:
            torsion["damping_model"] = {"kind": "modal", "ratios": [0.01]}
    elif kind < 0.15:
        torsion["method"] = "dense"
    if draw.random() < 0.15 and len(train["cylinders"]) > 1:
        torsion["misfire"] = [train["cylinders"][-1]["name"]]
    stressed = [one for one in shafts if {"diameter", "section"} & set(one)]
    if stressed and draw.random() < 0.5:
        level = _spread(draw, 1e5, 1e8)
        curve = {"speed": [0.2 * speed, speed, 1.5 * speed], "stress": [level, level, 0.6 * level]}
        torsion["limits"] = [{"curve": curve}]
        if all("tensile_strength" in one for one in stressed):
            torsion["limits"].append({"rule": "iacs_m68", "design_factor": 0.55})
    if any(one["kind"] == "pendulum" for one in line.get("dampers", ())):
        torsion["campbell"] = True
    return torsion
