"""Seeded random machines as case tables: one to eight cylinders, a body, three to twelve mounts."""

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
        "machine": {"kind": "machine", "speed": speed, "crank_train": train},
        "excitation": _excitation(generator),
        "accuracy": {"rtol": float(generator.choice(RTOLS))},
    }
    if generator.random() < 0.5:
        case["kinematics"] = {"series": "exact"}
        if "wrist_pin_offset" not in train and generator.random() < 0.5:
            case["kinematics"] = {"series": "truncated", "terms": int(generator.integers(1, 5))}
    size = generator.uniform(0.2, 1.5, 3)
    case["machine"]["body"] = _body(generator, train, size)
    mounts = _mounts(generator, case["machine"]["body"]["mass"], speed, size)
    case["machine"]["mounts"] = mounts
    case["isolation"] = {
        "model": model,
        "up": train["stroke_axis"],
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


def spread(generator: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def _crank_train(generator: np.random.Generator) -> Table:
    count = int(generator.integers(1, 9))
    radius = spread(generator, 0.02, 0.2)
    even = generator.random() < 0.35
    phases = np.radians(np.arange(count) * 360.0 / count)
    if even:
        phases = phases[generator.permutation(count)]
    else:
        phases = generator.uniform(-np.pi, np.pi, count)
    banks = generator.choice([0.0, np.pi / 4]) * (-1.0) ** np.arange(count)
    spacing = radius * generator.uniform(2.0, 4.0)
    places = (np.arange(count) - 0.5 * (count - 1)) * spacing
    mass = spread(generator, 0.1, 5.0)
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
        "stroke_axis": stroke,
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
    body: Table = {"mass": float(mass), **_inertia(generator, mass, size)}
    if generator.random() < 0.35:
        body["inertia_block"] = {
            "mass": float(mass * generator.uniform(0.02, 0.5)),
            "box": dict(zip(("length", "width", "height"), (0.5 * size).tolist(), strict=True)),
            "position": (generator.normal(0.0, 0.3, 3) * size).tolist(),
        }
    return body


def _inertia(generator: np.random.Generator, mass: float, size: np.ndarray) -> Table:
    if generator.random() < 0.5:
        return {"box": dict(zip(("length", "width", "height"), size.tolist(), strict=True))}
    squares = size**2 * generator.uniform(0.5, 1.5, 3) * mass / 12.0
    return {
        "inertia": (np.sum(squares) - squares).tolist(),
        "inertia_products": (0.1 * generator.normal(size=3) * np.min(squares)).tolist(),
    }


def _mounts(
    generator: np.random.Generator, mass: float, speed: float, size: np.ndarray, most: int = 8
) -> Table:
    """Natural frequencies of a thirtieth to three times the speed, damping light to heavy."""
    count = int(generator.integers(3, most + 1))
    frequency = speed * spread(generator, 0.03, 3.0)
    stiffness = mass * frequency**2 / count
    ratio = spread(generator, 1e-4, 0.5)
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


# ----------------------------------------------------------------------------
# Machines with all that may stand on mounts: gas, a body of parts, laws of mounts, a foundation, a
# base that moves, points.
# ----------------------------------------------------------------------------

KINDS = ("machine", "engine", "compressor", "pump")
TURN = 2.0 * np.pi


def mounted_machine(seed: int) -> Table:
    """A whole case with results of all of these, all values in SI."""
    generator = np.random.default_rng([seed, 12])
    kind, speed = KINDS[seed % len(KINDS)], float(generator.uniform(50.0, 500.0))
    train = _crank_train(generator)
    machine: Table = {"kind": kind, "speed": speed, "crank_train": train}
    case: Table = {
        "schema": 1,
        "title": f"random machine on mounts {seed}",
        "machine": machine,
        "excitation": _excitation(generator),
        "accuracy": {"rtol": float(generator.choice(RTOLS))},
    }
    case["excitation"].pop("balance")
    _GAS[kind](generator, case)
    if "rod" in train and generator.random() < 0.5:
        length, rod = train["rod_length"], train["rod"]
        place = rod["crank_pin_to_mass_centre"]
        rod["inertia"] = rod["mass"] * place * (length - place) * generator.uniform(0.6, 1.3)
    if generator.random() < 0.2:
        moved = _moving_mass(train) * train["crank_radius"] ** 2
        machine["rotor"] = {"inertia": float(moved * generator.uniform(1.0, 20.0))}
    size = generator.uniform(0.3, 1.5, 3)
    mass = float(_moving_mass(train) * generator.uniform(8.0, 50.0))
    machine["body"] = {"parts": _parts(generator, mass, size)}
    mounts = machine["mounts"] = _mounts(generator, mass, speed, size, most=12)
    if generator.random() < 0.3:
        mounts["datum"] = generator.normal(0.0, 0.3, 3).tolist()
    up = str(generator.choice(["x", "y", "z"]))
    case["isolation"] = {"model": "rigid_body", "up": up, "efficiency": True}
    if generator.random() < 0.1:
        case["isolation"]["loads"] = ["shaking"]
    if generator.random() < 0.6:
        ends = speed * generator.uniform([0.3, 1.0], [0.9, 1.3])
        case["isolation"]["run_up"] = {"from": float(ends[0]), "to": float(ends[1])}
        if generator.random() < 0.3:
            case["isolation"]["run_up_maxima"] = 0.5
    foundation = str(generator.choice(["", "", "body", "impedance", "mass"]))
    _laws(generator, case, foundation)
    if foundation:
        case["foundation"] = _FOUNDATIONS[foundation](generator, case, mass, size)
    if foundation in ("", "body") and generator.random() < 0.6:
        case["base_motion"] = _base_motion(generator, speed)
    if generator.random() < 0.6:
        case["point"] = _points(generator, size)
        if generator.random() < 0.6:
            case["vibration_severity"] = {"band": [0.8 * speed, speed * generator.uniform(4, 20)]}
    if "over_frequency" not in mounts["each"] and generator.random() < 0.5:
        case["response"] = {
            "energies": True,
            "method": str(generator.choice(["modal", "direct"])),
            "run_up": {"from": 0.5 * speed, "to": 1.2 * speed},
        }
        if "loads" in case["isolation"]:
            case["response"]["loads"] = case["isolation"]["loads"]
    return case


def _no_gas(generator: np.random.Generator, case: Table) -> None:
    train = case["machine"]["crank_train"]
    if "wrist_pin_offset" not in train and "rod" not in train and generator.random() < 0.3:
        case["kinematics"] = {"series": "truncated", "terms": int(generator.integers(1, 4))}


def _pressure(generator: np.random.Generator, start: float, cycle: float) -> Table:
    """Rows over a cycle with a peak after the top, of two to fifty bar."""
    angle = np.append(np.linspace(0.0, cycle, 12, endpoint=False), [0.15, 0.4, cycle])
    angle = np.sort(angle) + start
    peak = spread(generator, 2e5, 5e6)
    away = np.remainder(angle + 0.5 * cycle, cycle) - 0.5 * cycle
    pressure = peak / (1.0 + 6.0 * (away - 0.2) ** 2) * generator.uniform(0.9, 1.1, len(angle))
    pressure[-1] = pressure[0]
    return {"crank_angle": angle.tolist(), "pressure": pressure.tolist()}


def _of_engine(generator: np.random.Generator, case: Table) -> None:
    machine, train = case["machine"], case["machine"]["crank_train"]
    machine["cycle"] = str(generator.choice(["four_stroke", "two_stroke"]))
    cycle = TURN * (2 if machine["cycle"] == "four_stroke" else 1)
    cylinders, count = train["cylinders"], len(train["cylinders"])
    order = generator.permutation(count).tolist()
    steps = np.full(count, cycle / count)
    if generator.random() < 0.4:
        steps = steps * generator.uniform(0.6, 1.4, count)
        steps *= cycle / steps.sum()
        train["firing_intervals"] = steps.tolist()
    train["firing_order"] = [cylinders[n]["name"] for n in order]
    first = float(generator.uniform(0.0, 6.0))
    for n, fires in zip(order, first + np.append(0.0, np.cumsum(steps)), strict=False):
        cylinders[n]["crank_phase"] = float(np.remainder(cylinders[n]["bank_angle"] - fires, TURN))
        if generator.random() < 0.3:
            cylinders[n]["pressure_scale"] = float(generator.choice([0.0, 0.7, 1.1]))
    train["bore"] = train["crank_radius"] * float(generator.uniform(1.0, 2.0))
    train["gas_interpolation"] = str(generator.choice(["linear", "cubic"]))
    if generator.random() < 0.5:
        train["gas_pressure"] = _pressure(generator, 0.0, cycle)
    else:
        speeds = case["machine"]["speed"] * np.array([0.2, generator.uniform(0.7, 1.1), 1.4])
        train["gas_cards"] = [
            {"speed": float(one), "gas_pressure": _pressure(generator, -1.0, cycle)}
            for one in speeds
        ]


def _of_compressor(generator: np.random.Generator, case: Table) -> None:
    train = case["machine"]["crank_train"]
    train["bore"] = train["crank_radius"] * float(generator.uniform(1.0, 2.0))
    how = str(generator.choice(["linear", "parabola", "cubic"]))
    train["gas_interpolation"] = how
    train["gas_pressure"] = _pressure(generator, 0.0, TURN)
    for cylinder in train["cylinders"]:
        if generator.random() < 0.3:
            rows = _pressure(generator, 0.3, TURN)
            force = (np.array(rows["pressure"]) * train["bore"] ** 2).tolist()
            cylinder["gas_force"] = {"crank_angle": rows["crank_angle"], "force": force}


def _of_pump(generator: np.random.Generator, case: Table) -> None:
    train = case["machine"]["crank_train"]
    bore = train["bore"] = train["crank_radius"] * float(generator.uniform(0.5, 1.0))
    train["pump_cycle"] = {
        "suction_pressure": float(generator.uniform(1e5, 5e5)),
        "discharge_pressure": spread(generator, 2e6, 5e7),
        "bulk_modulus": float(generator.uniform(1e9, 2e9)),
        "dead_volume": float(bore**2 * train["crank_radius"] * generator.uniform(0.3, 3.0)),
    }


_GAS = {
    "machine": _no_gas, "engine": _of_engine, "compressor": _of_compressor, "pump": _of_pump,
}  # fmt: skip


def _parts(generator: np.random.Generator, mass: float, size: np.ndarray) -> list[Table]:
    parts: list[Table] = []
    for share in generator.dirichlet(np.full(int(generator.integers(1, 5)), 3.0)).tolist():
        centre = generator.normal(0.0, 0.3, 3) * size
        part = {"name": f"part {len(parts)}", "mass": share * mass, "centre": centre.tolist()}
        parts.append({**part, **_inertia(generator, share * mass, 0.6 * size)})
    return parts


def _laws(generator: np.random.Generator, case: Table, foundation: str) -> None:
    """Mounts that follow load and frequency, with stops; what they stand on may not have it."""
    machine = case["machine"]
    each, speed = machine["mounts"]["each"], machine["speed"]
    sag = 9.81 * _mass(machine) / (len(_places(machine["mounts"])) * each["stiffness"])
    if generator.random() < 0.4:
        static: Table = {"dynamic_to_static": float(generator.uniform(1.0, 1.6))}
        static["stops"] = {
            "down": float(sag * generator.uniform(4.0, 12.0)),
            "up": float(sag * generator.uniform(3.0, 9.0)),
            "stiffness": 10.0 * each["stiffness"],
        }
        kind = generator.choice(["", "cubic", "rows"])
        if kind == "cubic":
            static["cubic_stiffness"] = float(0.1 * each["stiffness"] / sag**2)
        elif kind == "rows":
            deflection = sag * np.linspace(-60.0, 60.0, 61)
            load = deflection * (1.0 + 0.3 * np.tanh(np.abs(deflection) / sag))
            static["load_deflection"] = {
                "deflection": deflection.tolist(), "load": (load * each["stiffness"]).tolist(),
            }  # fmt: skip
        each["static"] = static
        if kind and generator.random() < 0.5:
            load = sag * each["stiffness"] * np.array([-20.0, -1.0, 0.5, 1.5, 3.0, 20.0])
            factor = np.cumsum(generator.uniform(0.05, 0.3, 6)) + 0.5
            each["over_load"] = {"load": load.tolist(), "stiffness_factor": factor.tolist()}
    if foundation != "mass" and "loss_factor" in each and generator.random() < 0.5:
        del each["loss_factor"]
        rate = speed * np.array([0.2, 0.9, 2.5, 7.0, 20.0])
        each["over_frequency"] = {
            "frequency": rate.tolist(),
            "stiffness_factor": (0.9 + np.cumsum(generator.uniform(0.01, 0.2, 5))).tolist(),
            "loss_factor": generator.uniform(0.02, 0.3, 5).tolist(),
        }


def _places(mounts: Table) -> list[Any]:
    return list(mounts.get("positions") or [one["position"] for one in mounts["individual"]])


def _mass(machine: Table) -> float:
    return float(sum(part["mass"] for part in machine["body"]["parts"]))


def _on_mass(generator: np.random.Generator, case: Table, mass: float, size: np.ndarray) -> Table:
    foundation = mass * spread(generator, 0.3, 10.0)
    own = case["machine"]["speed"] * spread(generator, 0.2, 3.0)
    return {
        "kind": "mass",
        "mass": foundation,
        "stiffness": foundation * own**2,
        "damping": 0.05 * foundation * own,
        "loss_factor": float(generator.uniform(0.02, 0.1)),
    }


def _on_body(generator: np.random.Generator, case: Table, mass: float, size: np.ndarray) -> Table:
    own = float(mass * spread(generator, 0.3, 5.0))
    speed = case["machine"]["speed"]
    springs = _mounts(generator, own + mass, speed, 2.0 * size, most=6)
    springs["each"]["loss_factor"] = 0.05
    springs["each"].pop("damping", None)
    for one in springs.get("individual", ()):
        one.pop("damping", None)
    return {
        "kind": "body",
        "position": generator.normal(0.0, 0.5, 3).tolist(),
        "body": {"mass": own, **_inertia(generator, own, 1.5 * size)},
        "springs": springs,
    }


def _on_tables(generator: np.random.Generator, case: Table, mass: float, size: np.ndarray) -> Table:
    """Feet and, in some, a plate: springs with losses over all frequencies that occur."""
    stiff = case["machine"]["mounts"]["each"]["stiffness"]
    rate = case["machine"]["speed"] * np.array([1e-3, 0.3, 1.0, 3.0, 12.0, 2000.0])

    def table(key: str, level: float) -> Table:
        real = level * generator.uniform(0.5, 2.0, len(rate))
        imaginary = level * generator.uniform(0.02, 0.3, len(rate))
        if key.endswith("impedance"):
            real, imaginary = imaginary / rate, -real / rate
        return {key: {"frequency": rate.tolist(), "real": real.tolist(),
                      "imaginary": imaginary.tolist()}}  # fmt: skip

    ratio = spread(generator, 0.5, 20.0)
    rows: list[Table] = []
    for direction in "xyz":
        if generator.random() < 0.8 or not rows:
            key = str(generator.choice(["dynamic_stiffness", "impedance"]))
            rows.append({"direction": direction, **table(key, ratio * stiff)})
    found: Table = {"kind": "impedance", "flexibilities": rows}
    if generator.random() < 0.5:
        found["position"] = generator.normal(0.0, 0.5, 3).tolist()
        rows.append({"at": "whole", "direction": "z", **table("dynamic_stiffness", 30.0 * stiff)})
        key = str(generator.choice(["angular_dynamic_stiffness", "angular_impedance"]))
        rows.append({"at": "whole", "direction": "rx", **table(key, 10.0 * stiff)})
    return found


_FOUNDATIONS = {"mass": _on_mass, "body": _on_body, "impedance": _on_tables}


def _base_motion(generator: np.random.Generator, speed: float) -> Table:
    harmonics: list[Table] = []
    for n in range(int(generator.integers(1, 4))):
        linear = str(generator.choice(["displacement", "velocity", "acceleration"]))
        turning = str(generator.choice(["angle", "angular_velocity", "angular_acceleration"]))
        at = {"order": 0.5 * (n + 1)}
        if n % 2 == 0:
            at = {"frequency": speed * spread(generator, 0.1, 5.0)}
        harmonics.append({
            "name": f"harmonic {n}",
            **at,
            linear: generator.normal(0.0, 1e-3, 3).tolist(),
            "phase": generator.uniform(-3.0, 3.0, 3).tolist(),
            turning: generator.normal(0.0, 1e-3, 3).tolist(),
        })  # fmt: skip
    motion: Table = {"point": generator.normal(0.0, 1.0, 3).tolist(), "harmonics": harmonics}
    rate = speed * np.array([0.05, 0.4, 1.3, 6.0])
    if generator.random() < 0.6:
        motion["interpolation"] = str(generator.choice(["logarithmic", "linear"]))
        motion["spectra"] = [
            {"direction": direction,
             key: {"frequency": rate.tolist(), "density": generator.uniform(0.01, 1.0, 4).tolist()}}
            for direction, key in (("y", "acceleration"), ("z", "velocity"),
                                   ("rx", "angular_acceleration"))
        ]  # fmt: skip
    return motion


def _points(generator: np.random.Generator, size: np.ndarray) -> list[Table]:
    turned = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    places = (generator.normal(size=(3, 3)) * size).tolist()
    return [
        {"name": "plain", "position": places[0]},
        {"name": "turned", "position": places[1], "axes": turned.tolist()},
        {"name": "one", "position": places[2], "direction": generator.normal(size=3).tolist()},
    ]
