"""Seeded small engines whose damper is to be found, as case tables: 3 to 6 stations, few orders."""

from typing import Any

import numpy as np

Table = dict[str, Any]


def random_damper_case(seed: int) -> Table:
    """A whole case for `vibecalc.core.case.load.validate`, all values in SI."""
    draw = np.random.default_rng([seed, 11])
    cylinders, wheels = int(draw.integers(1, 4)), int(draw.integers(1, 3))
    four = bool(draw.random() < 0.5)
    radius, speed = float(draw.uniform(0.04, 0.12)), float(draw.uniform(80.0, 250.0))
    size = float(np.exp(draw.uniform(np.log(0.02), np.log(2.0))))
    stations: list[Table] = [
        {"name": f"throw {n}", "inertia": size * float(draw.uniform(0.8, 1.2)), "cylinder": f"{n}"}
        for n in range(1, cylinders + 1)
    ]
    stations += [
        {"name": f"wheel {n}", "inertia": size * float(draw.uniform(3.0, 30.0))}
        for n in range(1, wheels + 1)
    ]
    while len(stations) < 3:
        stations.insert(0, {"name": "front", "inertia": size * float(draw.uniform(0.3, 0.8))})
    # the lowest mode meets one of the first orders inside the range
    natural = speed * float(draw.uniform(1.5, 4.0))
    stiffness = size * (natural * len(stations)) ** 2 * 0.4
    row = [one["name"] for one in stations]
    shafts = [
        {
            "between": [a, b], "name": f"shaft {a}", "stiffness": stiffness * own,
            "damping": stiffness * own / natural * 0.01, "diameter": 0.1,
        }
        for a, b, own in zip(row, row[1:], draw.uniform(0.5, 2.0, len(row)).tolist(), strict=False)
    ]  # fmt: skip
    ring = size * float(draw.uniform(0.3, 1.0))
    design: Table = {
        "on": "ring", "objective": str(draw.choice(["torque", "twist", "stress"])),
        "compare": {"stiffness": 0.5 * ring * natural**2, "damping": 0.5 * ring * natural},
    }  # fmt: skip
    kind = draw.random()
    if kind < 0.2:
        design |= {"find": ["damping"], "stiffness": 0.6 * ring * natural**2}
    elif kind < 0.4:
        # bounds that may hold the optimum
        design["bounds"] = {"damping": [0.02 * ring * natural, 0.2 * ring * natural]}
    step = 0.5 if four and draw.random() < 0.5 else 1.0
    return {
        "schema": 1,
        "title": f"random damper {seed}",
        "machine": {
            "kind": "engine",
            "cycle": "four_stroke" if four else "two_stroke",
            "speed": speed,
            "crank_train": {
                "crank_radius": radius, "rod_length": 3.6 * radius, "bore": 1.8 * radius,
                "reciprocating_mass": 10.0 * size,
                "gas_cycle": {"kind": "diesel", "compression_ratio": 16.0, "peak_pressure": 9e6},
                "cylinders": [
                    {"name": f"{n + 1}", "firing_angle": (4 if four else 2) * np.pi * n / cylinders}
                    for n in range(cylinders)
                ],
            },
            "shaft_line": {
                "stations": stations,
                "shafts": shafts,
                "dampers": [{
                    "name": "ring", "on": row[0], "kind": "spring", "inertia": ring,
                    "stiffness": 0.7 * ring * natural**2, "damping": 0.3 * ring * natural,
                }],
            },
        },
        "response": {"torsion": {
            "speeds": {"from": 0.6 * speed, "to": 1.2 * speed, "points": 9},
            "orders": {"step": step, "count": int(draw.integers(3, 7))},
        }},
        "damper_design": design,
    }  # fmt: skip
