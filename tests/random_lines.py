"""Seeded random shaft lines with everything at once, as case tables.

A row of cylinders, flywheel and pinion, perhaps an elastic coupling that varies; a reduction gear
with a propeller; equal take-offs behind elastic teeth, with or without equal absorbers; a quill
beside the crankshaft that closes a loop.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

Table = dict[str, Any]
#: of the card, shares of a cycle and of the highest pressure: compression, firing, expansion
SHAPE = ((0.0, 0.0), (0.3, 0.02), (0.42, 0.2), (0.5, 0.8), (0.515, 1.0), (0.6, 0.3), (0.8, 0.02),
         (1.0, 0.0))  # fmt: skip


def random_line(seed: int) -> Table:
    """A whole case for `vibecalc.core.case.load.validate`, all values in SI."""
    return _Draw(np.random.default_rng([seed, 39])).case(seed)


#: what may happen in time to the lines of `random_change`, in turn
CHANGES = (
    "load_step", "misfire_onset", "short_circuit", "torque_history", "run_up", "run_down",
)  # fmt: skip


def random_change(seed: int, kinds: Sequence[str] = CHANGES, cycles: float = 1.6) -> Table:
    """A small line of the same kind with dashpots alone, and a short change in time."""
    draw = _Draw(np.random.default_rng([seed, 93]), most=3)
    case, kind = draw.case(seed), kinds[seed % len(kinds)]
    draw.with_dashpots()
    case["title"] = f"random {kind} {seed}"
    line = case["machine"]["shaft_line"]
    if kind.startswith(("run", "start")):  # what goes with the speed, and what its square turns on
        line["dampers"] = [one for one in line.get("dampers", []) if one["kind"] != "pendulum"]
        for beside in line.get("excitations", []):
            beside |= {"exponent": 2.0} if "exponent" in beside else {}
    asked = case["response"]["torsion"]
    case["response"]["torsion"] = {
        "orders": asked["orders"],
        "transient": draw.change(kind, cycles),
    }
    case["accuracy"] = {"rtol": 1e-9}
    return case


def random_variable_line(seed: int) -> Table:
    """A row with dashpots alone, whose light to heavy pistons make its inertia vary."""
    draw = _Draw(np.random.default_rng([seed, 13]), most=2)
    draw.row({})
    draw.dampers()
    kept = draw.line.pop("dampers", ())
    draw.line["dampers"] = [one for one in kept if one["kind"] != "pendulum"]
    draw.with_dashpots()
    case = draw.written(seed)
    train, torsion = case["machine"]["crank_train"], case["response"]["torsion"]
    inertia = 2.0 * draw.size * draw.spread(1e-3, 0.35)
    train["reciprocating_mass"] = inertia / train["crank_radius"] ** 2
    case["response"]["torsion"] = {"orders": torsion["orders"], "variable_inertia": {}}
    if draw.chance(0.5):
        case["response"]["torsion"]["speeds"] = {**torsion["speeds"], "points": 5}
    return case


def random_damper_case(seed: int) -> Table:
    """A small engine with a ring that is to be found."""
    draw = _Draw(np.random.default_rng([seed, 11]), most=3)
    draw.row({})
    for station in draw.stations:
        station.pop("over_speed", None)
    for shaft in draw.shafts:
        shaft["diameter"] = 0.1
    ring = draw.ring("ring", "throw 1") | {"kind": "spring"}
    size, natural = ring["inertia"], draw.natural
    ring |= {"stiffness": 0.7 * size * natural**2, "loss_factor": 0.0}
    draw.line["dampers"] = [ring]
    design: Table = {
        "on": "ring",
        "objective": str(draw.draw.choice(["torque", "twist", "stress"])),
        "compare": {"stiffness": 0.5 * size * natural**2, "damping": 0.5 * size * natural},
    }
    if draw.chance(0.2):
        design |= {"find": ["damping"], "stiffness": 0.6 * size * natural**2}
    elif draw.chance(0.25):  # bounds that may hold the optimum
        design["bounds"] = {"damping": [0.02 * size * natural, 0.2 * size * natural]}
    case = draw.written(seed) | {"damper_design": design}
    orders = {"step": 1.0, "count": int(draw.draw.integers(3, 7))}
    speeds = {"from": 0.6 * draw.speed, "to": 1.2 * draw.speed, "points": 9}
    case["response"]["torsion"] = {"orders": orders, "speeds": speeds}
    return case


class _Draw:
    """What the parts of one line have in common: speed, size of an inertia, a frequency."""

    def __init__(self, draw: np.random.Generator, most: int = 6):
        self.draw = draw
        self.four = self.chance(0.6)
        self.speed = float(draw.uniform(20.0, 300.0))
        self.count = int(draw.integers(1, most + 1))
        self.size = self.spread(0.05, 50.0)
        # the lowest elastic mode of the row is excited by a low to a high order
        self.natural = self.speed * self.spread(0.5, 10.0)
        self.stiff = 0.5 * self.size * (self.natural * self.count) ** 2
        self.stations: list[Table] = []
        self.shafts: list[Table] = []
        self.line: Table = {"stations": self.stations, "shafts": self.shafts}

    def chance(self, share: float) -> bool:
        return bool(self.draw.random() < share)

    def spread(self, low: float, high: float) -> float:
        return float(np.exp(self.draw.uniform(np.log(low), np.log(high))))

    def case(self, seed: int) -> Table:
        soft = self.coupling() if self.chance(0.5) else {}
        if not {"over_frequency", "over_mean_torque"} & {*soft} and self.chance(0.3):
            # by the lowest elastic mode, of which a coupling that varies makes many
            self.line["engine_damping"] = {"magnifier": self.spread(30.0, 300.0)}
        self.row(soft)
        if self.chance(0.7):
            self.propeller()
        if self.chance(0.6):
            self.take_offs()
        if self.count > 2 and self.chance(0.3):
            quill = self.shaft("throw 1", f"throw {self.count}", self.stiff * self.spread(0.01, 1))
            self.shafts.append(quill)
        self.dampers()
        if self.chance(0.5):
            beside = {
                "on": "flywheel",
                "orders": [1.0, 3.0],
                "orders_of": "crankshaft",
                "exponent": 1.0,
            }
            beside["torques"] = [1e-4 * self.stiff, 3e-5 * self.stiff]
            self.line.setdefault("excitations", []).append({**beside, "phases": [0.3, -2.0]})
        return self.written(seed)

    def with_dashpots(self) -> None:
        """No losses of another kind and no couplings that vary."""
        for shaft in self.shafts:
            for loss in ("loss_factor", "magnifier", "lehr_ratio"):
                if shaft.pop(loss, 0.0):
                    shaft["damping"] = shaft["stiffness"] / self.natural * self.spread(2e-3, 5e-2)
            if soft := shaft.pop("coupling", {}):
                shaft["stiffness"] = soft["stiffness"]
                shaft["damping"] = 0.1 * soft["stiffness"] / self.natural
        for damper in self.line.get("dampers", []):
            damper.pop("loss_factor", None)

    def written(self, seed: int) -> Table:
        return {
            "schema": 1,
            "title": f"random line {seed}",
            "machine": {
                "kind": "engine",
                "cycle": "four_stroke" if self.four else "two_stroke",
                "speed": self.speed,
                "crank_train": self.train(),
                "shaft_line": self.line,
            },
            "response": {"torsion": self.asked()},
            "accuracy": {"rtol": 1e-6},
        }

    def train(self) -> Table:
        radius, cycle = 0.1, (4.0 if self.four else 2.0) * np.pi
        highest = self.stiff * self.spread(1e-4, 1e-2) / radius**3
        place, height = np.array(SHAPE).T
        height = highest * height * self.draw.uniform(0.8, 1.2, len(height))
        angles = np.append(0.0, self.draw.uniform(0.0, cycle, self.count - 1))
        return {
            "crank_radius": radius,
            "rod_length": radius / float(self.draw.uniform(0.15, 0.4)),
            "bore": 0.16,
            "reciprocating_mass": self.size / radius**2 * self.spread(1e-3, 0.1),
            "gas_pressure": {
                "crank_angle": (cycle * (place - 0.5)).tolist(),
                "pressure": height.tolist(),
            },
            "cylinders": [
                {"name": str(n + 1), "firing_angle": float(a), "pressure_scale": float(p)}
                for n, (a, p) in enumerate(
                    zip(angles, self.draw.uniform(0.8, 1.1, self.count), strict=True)
                )
            ],
        }

    def change(self, kind: str, cycles: float) -> Table:
        """Over one or two cycles of the machine."""
        draw, cycle = self.draw, (4.0 if self.four else 2.0) * np.pi / self.speed
        found: Table = {"kind": kind, "time_before": 0.1 * cycle, "time_after": 0.7 * cycle}
        on = str(draw.choice([one["name"] for one in self.stations]))
        size = self.stiff * self.spread(1e-4, 1e-2)
        if kind == "misfire_onset":
            return found | {"cylinder": str(draw.integers(1, self.count + 1))}
        if kind == "load_step":
            return found | {"on": on, "torque": size * float(draw.choice([-1.0, 1.0]))}
        if kind == "short_circuit":
            decays = {"amplitude": size, "time_constant": cycle}
            sine = {"frequency": self.natural, "phase": 0.4}
            return found | {"on": on, "terms": [decays | sine, decays | {"phase": 1.2}]}
        if kind == "torque_history":
            rows = {"time": [0.0, 0.15 * cycle, 0.5 * cycle], "torque": [size, -size, 0.3 * size]}
            return found | {"on": on, "history": rows}
        slow, fast = (self.speed * float(draw.uniform(*one)) for one in ((0.6, 0.7), (0.9, 1.1)))
        more = {"from": slow, "to": fast, "duration": cycles * cycle, "time_after": 0.1 * cycle}
        if kind == "run_down":
            more |= {"from": fast, "to": slow}
        if kind == "start":
            del more["from"], found["time_before"]
        return found | more

    def asked(self) -> Table:
        step = float(self.draw.choice([0.5, 1.0])) if self.four else 1.0
        asked: Table = {
            "orders": {"step": step, "count": int(self.draw.integers(6, 17))},
            "speeds": {"from": 0.6 * self.speed, "to": 1.1 * self.speed, "points": 7},
        }
        if self.count > 1 and self.chance(0.5):
            asked["conditions"] = {"misfire": "each"}
        elif self.chance(0.3):
            asked["misfire"] = [str(self.count)]
        return asked

    def station(self, name: str, inertia: float, **more: Any) -> str:
        if self.chance(0.3) and not ("cylinder" in more and "engine_damping" in self.line):
            more["absolute_damping"] = self.size * self.natural * self.spread(1e-4, 0.05)
            if self.chance(0.4):
                exponent = float(self.draw.choice([-1.0, 1.0, 2.0]))
                more["over_speed"] = {"exponent": exponent, "reference": 0.9 * self.speed}
        self.stations.append({"name": name, "inertia": inertia, **more})
        return name

    def shaft(self, first: str, second: str, stiffness: float) -> Table:
        found: Table = {"name": f"{first} to {second}", "between": [first, second]}
        found["stiffness"] = stiffness
        kind = self.draw.choice(["damping", "loss_factor", "magnifier", "lehr_ratio"])
        share = self.spread(2e-3, 5e-2)
        found[str(kind)] = {
            "damping": stiffness / self.natural * share, "magnifier": 1.0 / share
        }.get(str(kind), share)  # fmt: skip
        return found

    def row(self, soft: Table) -> None:
        """Cylinders, flywheel, pinion, with a coupling or a shaft between these two."""
        names = [
            self.station(f"throw {n + 1}", self.size, cylinder=str(n + 1))
            for n in range(self.count)
        ]
        names.append(self.station("flywheel", self.size * self.spread(1.0, 50.0)))
        for first, second in pairwise(names):
            self.shafts.append(self.shaft(first, second, self.stiff * self.spread(0.5, 2.0)))
        self.station("pinion", self.size * self.spread(0.1, 3.0))
        last = self.shaft("flywheel", "pinion", self.stiff * self.spread(0.1, 2.0))
        if soft:
            last = {"name": "rubber", "between": ["flywheel", "pinion"], "coupling": soft}
        self.shafts.append(last)

    def coupling(self) -> Table:
        found: Table = {"stiffness": self.stiff * self.spread(1e-3, 0.1)}
        found["relative_damping"] = self.spread(0.3, 2.0)
        if self.chance(0.6):
            found["over_frequency"] = {
                "frequency": [0.0, self.natural, 10.0 * self.natural],
                "stiffness_factor": [1.0, 1.1, 1.4],
                "relative_damping_factor": [1.0, 0.8, 0.7],
            }
        if self.chance(0.6):
            found["over_mean_torque"] = {
                "torque": [0.0, 1e-3 * self.stiff, 3e-2 * self.stiff],
                "stiffness_factor": [0.7, 1.0, 2.0],
            }
        return found

    def propeller(self) -> None:
        """Behind a rigid gear; its blades excite orders of the engine."""
        # whole multiples of half a crank turn
        blades, teeth = ((4, [20, 40]), (4, [17, 68]), (5, [20, 20]))[int(self.draw.integers(3))]
        wheel = self.station("wheel", self.size * self.spread(1.0, 30.0))
        screw = "propeller"
        self.stations.append({"name": screw, "inertia": self.size * self.spread(5.0, 200.0)})
        gear = {"name": "reduction", "between": ["pinion", wheel], "teeth": teeth}
        self.line["gears"] = [gear | {"reverses": self.chance(0.7)}]
        self.shafts.append(self.shaft(wheel, screw, self.stiff * self.spread(0.05, 5.0)))
        load: Table = {"on": screw, "torque": self.stiff * self.spread(1e-4, 1e-2)}
        load["exponent"] = float(self.draw.choice([0.0, 2.0]))
        if self.chance(0.6):
            load["propeller_damping"] = {"method": "archer", "coefficient": 25.0}
        self.line["absorbed_torques"] = [load]
        self.line["balanced_by"] = str(self.draw.choice(["flywheel", "pinion"]))
        blade = {"on": screw, "blades": blades, "shares": [0.1, 0.02], "phases": [0.4, 1.9]}
        self.line["excitations"] = [blade]

    def take_offs(self) -> None:
        """Two equal branches behind elastic teeth, each perhaps with a ring of its own."""
        state = self.draw.bit_generator.state
        rings = self.chance(0.5)
        self.draw.bit_generator.state = state
        drawn = self.draw.integers(1 << 30)
        for side in "ab":
            self.draw = np.random.default_rng(drawn)  # the same numbers for both
            first = self.station(f"gear {side}", self.size * self.spread(0.05, 1.0))
            last = self.station(f"machine {side}", self.size * self.spread(0.3, 10.0))
            self.shafts.append(self.shaft(first, last, self.stiff * self.spread(0.01, 1.0)))
            gear = {"name": f"mesh {side}", "between": ["flywheel", first], "teeth": [60, 31]}
            gear |= {"pitch_radius": 0.2, "mesh_stiffness": self.stiff * self.spread(3, 100) / 0.04}
            self.line.setdefault("gears", []).append(gear)
            if rings:
                self.line.setdefault("dampers", []).append(self.ring(f"ring {side}", last))

    def ring(self, name: str, on: str) -> Table:
        inertia = self.size * self.spread(0.1, 3.0)
        kind = str(self.draw.choice(["viscous", "spring"]))
        found: Table = {"name": name, "on": on, "kind": kind, "inertia": inertia}
        found["damping"] = inertia * self.natural * self.spread(0.03, 1.0)
        if kind == "spring":
            found["stiffness"] = inertia * (self.natural * self.spread(0.4, 1.2)) ** 2
            found["loss_factor"] = float(self.draw.choice([0.0, 0.1]))
        return found

    def dampers(self) -> None:
        if self.chance(0.5):
            self.line.setdefault("dampers", []).append(self.ring("damper", "throw 1"))
        if self.chance(0.25):
            arm = 0.2
            hung = {"name": "pendulums", "on": "flywheel", "kind": "pendulum", "count": 4}
            hung |= {"order": 2.85, "mass": self.size * self.spread(0.1, 1.0) / arm**2 / 4.0}
            hung |= {"arm_radius": arm, "damping": 0.02 * self.size * self.natural}
            self.line.setdefault("dampers", []).append(hung)
