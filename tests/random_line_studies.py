"""Seeded random engines with a change in time, or with inertias that vary, as small case tables."""

from itertools import pairwise
from typing import Any

import numpy as np

Table = dict[str, Any]
KINDS = ("run_up", "run_down", "start", "load_step", "misfire_onset")
#: of the cards, shares of a cycle and of the highest pressure: compression, firing, expansion
SHAPE = ((0.0, 0.0), (0.3, 0.02), (0.42, 0.2), (0.5, 0.8), (0.515, 1.0), (0.6, 0.3), (0.8, 0.02),
         (1.0, 0.0))  # fmt: skip


def random_transient(seed: int) -> Table:
    """A whole case with `[response.torsion.transient]`, of each kind in turn."""
    draw = np.random.default_rng([seed, 11])
    kind = KINDS[seed % len(KINDS)]
    table = _engine(draw, f"random {kind} {seed}", int(draw.integers(1, 4)), wide=kind != "start")
    machine, speed = table["machine"], table["machine"]["speed"]
    cycle = (4.0 if machine["cycle"] == "four_stroke" else 2.0) * np.pi
    options: Table = {"kind": kind}
    if kind in ("load_step", "misfire_onset"):
        options["time_after"] = cycle / speed * float(draw.uniform(2.0, 8.0))
        if draw.random() < 0.5:
            options["time_before"] = cycle / speed * float(draw.uniform(1.0, 2.0))
        if kind == "load_step":
            stations = machine["shaft_line"]["stations"]
            options["on"] = stations[int(draw.integers(len(stations)))]["name"]
            size = stations[0]["inertia"] * speed**2
            options["torque"] = size * _spread(draw, 1e-2, 1.0) * float(draw.choice([-1.0, 1.0]))
        else:
            options["cylinder"] = str(draw.choice(machine["crank_train"]["cylinders"])["name"])
    else:
        slow, fast = speed * float(draw.uniform(0.5, 0.7)), speed * float(draw.uniform(0.9, 1.3))
        ends = {"run_up": (slow, fast), "run_down": (fast, slow), "start": (0.0, fast)}[kind]
        length = cycle / (0.5 * sum(ends)) * float(draw.uniform(8.0, 16.0))
        if kind != "start":
            options["from"] = ends[0]
            options["time_before"] = cycle / speed * float(draw.choice([0.0, 1.3]))
        options["to"] = ends[1]
        options["time_after"] = cycle / speed * float(draw.uniform(0.2, 2.0))
        if draw.random() < 0.5:
            options["duration"] = length
        else:
            options["acceleration"] = abs(ends[1] - ends[0]) / length * 1.1
    table["response"]["torsion"]["transient"] = options
    return table


def random_variable_line(seed: int) -> Table:
    """A whole case with `[response.torsion.variable_inertia]`, light to heavy pistons."""
    draw = np.random.default_rng([seed, 13])
    table = _engine(draw, f"random variable inertia {seed}", int(draw.integers(1, 3)), wide=False)
    train, speed = table["machine"]["crank_train"], table["machine"]["speed"]
    inertia = table["machine"]["shaft_line"]["stations"][0]["inertia"]
    share = _spread(draw, 1e-3, 0.35)
    train["reciprocating_mass"] = 2.0 * share * inertia / train["crank_radius"] ** 2
    options: Table = {}
    if draw.random() < 0.4:
        options["orders"] = int(draw.integers(16, 25))
    torsion = table["response"]["torsion"]
    torsion["variable_inertia"] = options
    if draw.random() < 0.5:
        torsion["speeds"] = {"from": 0.7 * speed, "to": 1.15 * speed, "points": 5}
    return table


def _spread(draw: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def _engine(draw: np.random.Generator, title: str, cylinders: int, *, wide: bool) -> Table:
    """Some cylinders, a wheel or two, perhaps a gear and a damper; `wide`: cards by speed too."""
    four = bool(draw.random() < 0.7)
    speed = float(draw.uniform(30.0, 300.0))
    radius, size = _spread(draw, 0.03, 0.2), _spread(draw, 0.05, 10.0)
    natural = speed * _spread(draw, 0.8, 8.0)
    cycle = (4.0 if four else 2.0) * np.pi
    # twists of some hundredths at most
    highest = size * natural**2 * _spread(draw, 1e-4, 1e-2) / radius**3
    train: Table = {
        "crank_radius": radius,
        "rod_length": radius / float(draw.uniform(0.15, 0.35)),
        "bore": radius * float(draw.uniform(1.2, 2.0)),
        "reciprocating_mass": size / radius**2 * _spread(draw, 1e-3, 0.2),
        "cylinders": [{"name": str(k + 1)} for k in range(cylinders)],
    }
    if draw.random() < 0.2:
        train["wrist_pin_offset"] = radius * float(draw.uniform(-0.1, 0.1))
    if draw.random() < 0.5:
        train["firing_order"] = [str(k + 1) for k in draw.permutation(cylinders)]
    else:
        for one in train["cylinders"]:
            one["firing_angle"] = float(draw.uniform(0.0, cycle))
    if wide and draw.random() < 0.25:
        cards = [(0.3, 0.6), (0.9, 1.0), (1.5, 0.8)]
        train["gas_cards"] = [
            {"speed": at * speed, "gas_pressure": _card(draw, cycle, share * highest)}
            for at, share in cards
        ]
    else:
        train["gas_pressure"] = _card(draw, cycle, highest)
    return {
        "schema": 1,
        "title": title,
        "machine": {
            "kind": "engine",
            "cycle": "four_stroke" if four else "two_stroke",
            "speed": speed,
            "crank_train": train,
            "shaft_line": _line(draw, cylinders, size, natural),
        },
        "response": {"torsion": {"orders": {
            "step": float(draw.choice([0.5, 1.0])) if four else 1.0,
            "count": int(draw.integers(4, 11)),
        }}},
        "accuracy": {"rtol": float(draw.choice([1e-3, 1e-6, 1e-9]))},
    }  # fmt: skip


def _card(draw: np.random.Generator, cycle: float, highest: float) -> Table:
    place, height = np.array(SHAPE).T
    height = height * draw.uniform(0.8, 1.2, len(height))
    return {
        "crank_angle": (cycle * (place - 0.5)).tolist(),
        "pressure": (highest * height).tolist(),
    }


def _line(draw: np.random.Generator, cylinders: int, size: float, natural: float) -> Table:
    stations: list[Table] = [
        {"name": f"throw {k + 1}", "cylinder": str(k + 1), "inertia": size}
        for k in range(cylinders)
    ]
    for k in range(int(draw.integers(1, 3))):
        stations.append({"name": f"wheel {k + 1}", "inertia": size * _spread(draw, 0.5, 30.0)})
    row = [one["name"] for one in stations]
    stiff = 0.5 * size * (natural * cylinders) ** 2
    pairs, gears = list(pairwise(row)), []
    if draw.random() < 0.2:
        stations += [{"name": name, "inertia": size * _spread(draw, 0.3, 3.0)} for name in "gw"]
        pairs.append(("g", "w"))
        teeth = [int(draw.integers(17, 60)), int(draw.integers(17, 90))]
        gears.append({"name": "mesh", "between": [row[-1], "g"], "teeth": teeth})
    shafts = []
    kind = str(draw.choice(["damping", "damping_ratio"]))
    for pair in pairs:
        own = stiff * _spread(draw, 0.3, 2.0)
        share = _spread(draw, 2e-3, 5e-2)
        value = share if kind == "damping_ratio" else own / natural * share
        shafts.append({"between": list(pair), "stiffness": own, kind: value})
    line: Table = {"stations": stations, "shafts": shafts}
    if gears:
        line["gears"] = gears
    if draw.random() < 0.3:
        for one in stations[:cylinders]:
            one["absolute_damping"] = size * natural * _spread(draw, 1e-4, 0.03)
    if draw.random() < 0.1:
        stations[-1]["ground_stiffness"] = stiff * _spread(draw, 1e-2, 1.0)
    if draw.random() < 0.35:
        ring = size * _spread(draw, 0.2, 1.0)
        damper: Table = {"name": "damper", "on": row[0], "kind": "viscous", "inertia": ring}
        damper["damping"] = ring * natural * _spread(draw, 0.03, 0.5)
        if draw.random() < 0.5:
            own = natural * float(draw.uniform(0.5, 1.2))
            damper |= {"kind": "spring", "stiffness": ring * own**2}
        line["dampers"] = [damper]
    if draw.random() < 0.2:
        load = {"on": row[-1], "torque": 1e-3 * stiff, "exponent": 2.0}
        line |= {"balanced_by": row[-1], "absorbed_torques": [load]}
    return line
