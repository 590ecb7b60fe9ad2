"""Seeded random pumps as case tables: one to three plungers, planar, pitch or rigid body."""

from typing import Any

import numpy as np
from random_machines import Table, random_machine, spread

MODELS = ("planar", "planar", "rigid_body", "pitch")
RTOLS = (1e-3, 1e-6, 1e-9)
#: kg/m^3 of plungers with what moves with them, so that pressure and masses are of one size
DENSITY = 2e4


def random_pump(seed: int) -> Table:
    """A whole case for `vibecalc.core.case.load.validate`, all values in SI."""
    model = MODELS[seed % len(MODELS)]
    generator = np.random.default_rng([seed, 61])
    table = random_machine(seed, "pitch" if model == "pitch" else "rigid_body")
    table["title"] = f"random pump {seed}, {model}"
    table["machine"]["kind"] = "pump"
    table["isolation"]["model"] = model
    table["accuracy"]["rtol"] = float(generator.choice(RTOLS))
    train = table["machine"]["crank_train"]
    train["cylinders"] = train["cylinders"][: int(generator.integers(1, 4))]
    moved = train.get("reciprocating_mass", 2.0 * train.get("piston_mass", 0.0))
    long = (4.0 * moved / (np.pi * DENSITY * train["crank_radius"])) ** 0.5
    train["bore"] = float(long * spread(generator, 0.5, 2.0))
    train["pump_cycle"] = _pump_cycle(generator, train)
    _asked(generator, table)
    if model == "planar":
        _flatten(generator, table)
    return table


def _pump_cycle(generator: np.random.Generator, train: Table) -> Table:
    """A liquid from stiff to soft, of which something is drawn in every turn."""
    rise = spread(generator, 2e5, 1e8)
    strain = spread(generator, 1e-5, 0.3)
    if generator.random() < 0.6:
        strain = rise / float(generator.uniform(1.2e9, 2.3e9))  # water and oil
    swept = 0.5 * np.pi * train["bore"] ** 2 * train["crank_radius"]
    most = 0.95 * swept / np.expm1(strain)
    suction = float(generator.uniform(0.3e5, 5e5))
    found: dict[str, Any] = {
        "suction_pressure": suction,
        "discharge_pressure": suction + rise,
        "bulk_modulus": rise / strain,
        "dead_volume": float(min(swept * spread(generator, 0.03, 3.0), most)),
    }
    if generator.random() < 0.3:
        found["outside_pressure"] = float(generator.uniform(0.9e5, 3e5))
    return found


def _asked(generator: np.random.Generator, table: Table) -> None:
    """Where the motor stands, what idles, how many orders, with or without a run-up."""
    asked, isolation = table["excitation"], table["isolation"]
    asked["driven_machine"] = "separate" if generator.random() < 0.8 else "on_body"
    asked.pop("orders", None)
    if generator.random() < 0.3:
        asked["orders"] = int(generator.choice([3, 6, 12, 40, 60]))
    train = table["machine"]["crank_train"]
    if len(train["cylinders"]) > 1 and generator.random() < 0.3:
        asked["working"] = [one["name"] for one in train["cylinders"][1:]]
        # the truth takes away masses that stop, and those of rods are not of a cylinder alone
        stops = "rod" not in train and generator.random() < 0.5
        asked["idle"] = "stopped" if stops else "unloaded"
    if generator.random() < 0.4:
        del isolation["run_up"]


def _flatten(generator: np.random.Generator, table: Table) -> None:
    """All forces in the plane of the crank through the reference point, the rest even about it."""
    machine = table["machine"]
    train, body = machine["crank_train"], machine["body"]
    along = "xyz".index(train["axis"])
    for part in ("cylinders", "counterweights"):
        for one in train.get(part, ()):
            one["position"] = 0.0
    for shaft in train.get("balance_shafts", ()):
        shaft["position"][along] = 0.0
    if "origin" in train:
        train["origin"][along] = 0.0
    if "inertia_products" in body:
        # xy, xz and yz: the one of the plane may stay
        in_plane = ("yz", "xz", "xy")[along]
        body["inertia_products"] = [
            value if name == in_plane else 0.0
            for name, value in zip(("xy", "xz", "yz"), body["inertia_products"], strict=True)
        ]
    if "inertia_block" in body:
        body["inertia_block"]["position"][along] = 0.0
    machine["mounts"] = _even_mounts(
        generator, machine["mounts"]["each"], along, train["stroke_axis"]
    )


def _even_mounts(generator: np.random.Generator, each: Table, along: int, stroke: str) -> Table:
    """Two mounts in the plane, perhaps turned about the crankshaft, or pairs next to it."""
    wide, low = generator.uniform(0.2, 0.6, 2), float(generator.uniform(0.0, 0.4))
    up = "xyz".index(stroke)
    across = 3 - along - up
    places = np.zeros((2, 3))
    places[:, across], places[:, up] = [-wide[0], wide[1]], -low
    if generator.random() < 0.3:
        pairs = np.repeat(places, 2, axis=0)
        pairs[:, along] = float(generator.uniform(0.1, 0.5)) * np.array([1.0, -1.0, 1.0, -1.0])
        return {"each": each, "positions": pairs.tolist()}
    individual: list[Table] = []
    for number, place in enumerate(places.tolist()):
        factor, angle = generator.uniform(0.3, 2.0, 3), float(generator.uniform(-np.pi, np.pi))
        turn = [0.0, 0.0, 0.0]
        turn[along] = angle
        one: Table = {"name": f"m{number}", "position": place, "orientation": turn}
        one["stiffness"] = (each["stiffness"] * factor).tolist()
        if "damping" in each:
            one["damping"] = (each["damping"] * factor).tolist()
        individual.append(one)
    return {"each": each, "individual": individual}
