"""Seeded random machines as case tables: one to eight cylinders, a body, three to eight mounts."""

from typing import Any

import numpy as np

Table = dict[str, Any]
RTOLS = (1e-3, 1e-6, 1e-9, 1e-12)


def random_machine(seed: int, model: str, **isolation: Any) -> Table:
    """A whole case for `vibecalc.core.case.load.validate`, all values in SI."""
    generator = np.random.default_rng([seed, len(model)])
    speed = float(generator.uniform(50.0, 700.0))
    train = _crank_train(generator)
    case: Table = {
        "schema": 1,
        "title": f"random machine {seed}, {model}",
        "machine": {"kind": "generator", "speed": speed, "crank_train": train},
        "excitation": _excitation(generator),
        "accuracy": {"rtol": float(generator.choice(RTOLS))},
    }
    if generator.random() < 0.5:
        case["kinematics"] = {"series": "exact"}
        if "wrist_pin_offset" not in train and generator.random() < 0.5:
            case["kinematics"] = {"series": "truncated", "terms": int(generator.integers(1, 5))}
    size = generator.uniform(0.2, 1.5, 3)
    case["machine"]["body"] = _body(generator, train, size)
    case["machine"]["mounts"] = _mounts(generator, case, speed, size)
    case["isolation"] = {
        "model": model,
        "up": train["stroke"],
        "lever": float(generator.uniform(0.1, 1.0)),
        "run_up": {"from": float(generator.choice([0.0, 0.2 * speed])), "to": 1.2 * speed},
        **isolation,
    }
    return case


def without_damping(case: Table) -> Table:
    """The same machine on springs alone."""
    mounts = case["machine"]["mounts"]
    for properties in (mounts["each"], *mounts.get("individual", ())):
        properties.pop("damping", None)
        properties.pop("loss_factor", None)
    return case


def _spread(generator: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def _crank_train(generator: np.random.Generator) -> Table:
    count = int(generator.integers(1, 9))
    radius = _spread(generator, 0.02, 0.2)
    even = generator.random() < 0.35
    phases = np.radians(np.arange(count) * 360.0 / count)
    if even:
        phases = phases[generator.permutation(count)]
    else:
        phases = generator.uniform(-np.pi, np.pi, count)
    banks = generator.choice([0.0, np.pi / 4]) * (-1.0) ** np.arange(count)
    spacing = radius * generator.uniform(2.0, 4.0)
    places = (np.arange(count) - 0.5 * (count - 1)) * spacing
    mass = _spread(generator, 0.1, 5.0)
    axis, stroke = generator.permutation(["x", "y", "z"])[:2].tolist()
    cylinders: list[Table] = [
        {
            "name": str(n + 1),
            "position": float(places[n]),
            "crank_phase": float(phases[n]),
            "bank_angle": float(banks[n]),
        }
        for n in range(count)
    ]
    train: Table = {
        "axis": axis,
        "stroke": stroke,
        "crank_radius": radius,
        "rod_length": radius / generator.uniform(0.05, 0.6),
        "cylinders": cylinders,
    }
    if generator.random() < 0.25:
        fraction = float(generator.uniform(0.2, 0.5))
        train["piston_mass"], train["pin_mass"] = mass, 0.2 * mass
        train["rod"] = {"mass": 0.7 * mass, "crank_pin_to_mass_centre": fraction * radius}
    else:
        train["reciprocating_mass"] = mass
    if not even and generator.random() < 0.5:
        for cylinder in cylinders:
            cylinder["reciprocating_mass"] = mass * float(generator.uniform(0.8, 1.2))
    if generator.random() < 0.4:
        train["rotating_mass"] = 0.5 * mass
    if generator.random() < 0.3:
        train["wrist_pin_offset"] = radius * float(generator.uniform(-0.15, 0.15))
    if generator.random() < 0.5:
        train["origin"] = generator.normal(0.0, 0.1, 3).tolist()
    unbalance = mass * radius
    if generator.random() < 0.4:
        train["counterweights"] = [
            {
                "name": f"weight {n}",
                "unbalance": unbalance * float(generator.uniform(0.1, 1.0)),
                "phase": float(generator.uniform(-np.pi, np.pi)),
                "position": float(generator.choice(places)),
            }
            for n in range(2)
        ]
    if generator.random() < 0.4:
        train["balance_shafts"] = [
            {
                "name": f"shaft {ratio}",
                "unbalance": unbalance * float(generator.uniform(0.02, 0.3)),
                "speed_ratio": ratio,
                "phase": float(generator.uniform(-np.pi, np.pi)),
                "position": generator.normal(0.0, 0.2, 3).tolist(),
            }
            for ratio in generator.choice([[-2, 2], [-1, 1], [-1, 2]]).tolist()
        ]
    return train


def _excitation(generator: np.random.Generator) -> Table:
    table: Table = {
        "driven_machine": str(generator.choice(["cancels_torque", "on_body", "separate"])),
        "balance": {"orders": [1, 2, 4, 7]},
        "residual": {
            "force_weight": float(generator.uniform(0.0, 2.0)),
            "couple_weight": float(generator.uniform(0.0, 2.0)),
            "reference_length": float(generator.uniform(0.1, 1.0)),
        },
    }
    if generator.random() < 0.25:
        table["orders"] = int(generator.choice([2, 3, 4, 6]))
    return table


def _moving_mass(train: Table) -> float:
    common = train.get("reciprocating_mass", 2.0 * train.get("piston_mass", 0.0))
    pistons = sum(c.get("reciprocating_mass", common) for c in train["cylinders"])
    return float(pistons + len(train["cylinders"]) * train.get("rotating_mass", 0.0))


def _body(generator: np.random.Generator, train: Table, size: np.ndarray) -> Table:
    mass = _moving_mass(train) * generator.uniform(5.0, 50.0)
    body: Table = {"mass": float(mass)}
    if generator.random() < 0.5:
        body["box"] = dict(zip(("length", "width", "height"), size.tolist(), strict=True))
    else:
        squares = size**2 * generator.uniform(0.5, 1.5, 3) * mass / 12.0
        body["inertia"] = (np.sum(squares) - squares).tolist()
        body["inertia_products"] = (0.1 * generator.normal(size=3) * np.min(squares)).tolist()
    if generator.random() < 0.35:
        body["inertia_block"] = {
            "mass": float(mass * generator.uniform(0.02, 0.5)),
            "box": dict(zip(("length", "width", "height"), (0.5 * size).tolist(), strict=True)),
            "position": (generator.normal(0.0, 0.3, 3) * size).tolist(),
        }
    return body


def _mounts(generator: np.random.Generator, case: Table, speed: float, size: np.ndarray) -> Table:
    """Natural frequencies of a thirtieth to three times the speed, damping light to heavy."""
    count = int(generator.integers(3, 9))
    frequency = speed * _spread(generator, 0.03, 3.0)
    stiffness = case["machine"]["body"]["mass"] * frequency**2 / count
    ratio = _spread(generator, 1e-4, 0.5)
    viscous = generator.random() < 0.6
    each: Table = {"stiffness": stiffness}
    if viscous:
        each["damping"] = 2.0 * ratio * stiffness / frequency
    else:
        each["loss_factor"] = 2.0 * ratio
    places = generator.normal(size=(count, 3)) * 0.6 * size
    if generator.random() < 0.3:
        return {"each": each, "positions": places.tolist()}
    individual: list[Table] = []
    for number, place in enumerate(places.tolist()):
        mount: Table = {"name": f"m{number}", "position": place}
        if generator.random() < 0.7:
            mount["stiffness"] = (stiffness * generator.uniform(0.2, 2.0, 3)).tolist()
            mount["orientation"] = generator.uniform(-np.pi, np.pi, 3).tolist()
            if viscous:
                mount["damping"] = (each["damping"] * generator.uniform(0.2, 2.0, 3)).tolist()
        individual.append(mount)
    return {"each": each, "individual": individual}
