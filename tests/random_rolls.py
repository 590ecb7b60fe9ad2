"""Seeded random machines whose shell rolls, as case tables: one to four cylinders, any motor."""

from typing import Any

import numpy as np
from random_machines import Table

RTOLS = (1e-3, 1e-5, 1e-7, 1e-9)
#: nodes of the gas tables of a turn
NODES = 24
#: what some machines ask for next to their motion, by the last digits of the seed
NEARBY: dict[int, Table] = {
    1: {"interpolations": True},
    2: {"compare": ["rk4", "fourier"], "step": 2e-4},
    3: {"sensitivity": True},
    4: {"compare": ["euler", "shooting"], "step": 5e-4},
    5: {"method": "fourier"},
    6: {"method": "shooting"},
    7: {"points": 5},
    8: {"method": "rk4", "step": 2e-4},
}


def random_roll(seed: int, **roll: Any) -> Table:
    """A whole case for `validate`, all values in SI; `roll` adds options."""
    random = np.random.default_rng([seed, 7])
    count = int(random.choice([1, 2, 2, 3, 4]))
    radius = float(random.uniform(0.02, 0.1))
    sync = float(random.choice([750.0, 900.0, 1500.0, 1800.0])) * np.pi / 30.0
    mass = float(random.uniform(20.0, 400.0)) * radius
    train = {
        "axis": "x",
        "stroke_axis": "z",
        "crank_radius": radius,
        "rod_length": radius / float(random.uniform(0.12, 0.4)),
        "gas_interpolation": str(random.choice(["linear", "parabola", "cubic", "trigonometric"])),
        "cylinders": _cylinders(random, count, mass, mass * radius * sync**2),
    }
    if random.random() < 0.3:
        train["wrist_pin_offset"] = radius * float(random.uniform(-0.1, 0.1))
    # the rotor evens out the work of a turn to some tens of per cent of the speed
    work = mass * (radius * sync) ** 2
    rotor = work / sync**2 * float(random.uniform(2.0, 20.0))
    machine: Table = {
        "kind": "compressor",
        "crank_train": train,
        "rotor": {"inertia": rotor},
        "shell": {"inertia": rotor * float(random.uniform(3.0, 60.0))},
        "motor": _motor(random, sync, 0.5 * work * count),
    }
    if random.random() < 0.35:
        own = sync * float(random.choice([0.1, 0.3, 0.6, 1.4, 2.5]))
        stiffness = machine["shell"]["inertia"] * own**2
        machine["shell"] |= {
            "stiffness": stiffness,
            "damping": 2.0 * float(random.uniform(0.02, 0.3)) * stiffness / own,
        }
    if random.random() < 0.5:
        machine["friction"] = {
            "torque": 0.01 * work,
            "viscous": float(random.choice([0.0, 0.01])) * work / sync,
            "piston_force": float(random.choice([0.0, 0.01])) * work / radius,
        }
    options: Table = {"orders": int(random.integers(3, 16)), "classical": random.random() < 0.3}
    if random.random() < 0.3 and "stiffness" not in machine["shell"]:
        options["started_at"] = sync
    options |= NEARBY.get(seed % 20, {})
    return {
        "schema": 1,
        "title": f"random rolling machine {seed}",
        "machine": machine,
        "response": {"roll": options | roll},
        "accuracy": {"rtol": float(random.choice(RTOLS))},
    }


def _cylinders(random: np.random.Generator, count: int, mass: float, force: float) -> list[Table]:
    angles = np.linspace(0.0, 2.0 * np.pi, NODES + 1)
    phases = np.arange(count) * 2.0 * np.pi / count
    if random.random() < 0.3:
        phases = random.uniform(0.0, 2.0 * np.pi, count)
    found = []
    for number in range(count):
        # compression before the dead centre, expansion of what is left after it
        away = 2.0 * np.pi - angles
        top = float(random.uniform(0.1, 0.8)) * force
        before = np.exp(-((away / float(random.uniform(0.6, 1.4))) ** 2))
        after = np.exp(-((angles / float(random.uniform(0.2, 0.4))) ** 2))
        pushed = top * (before + after + float(random.uniform(0.0, 0.1)))
        pushed[-1] = pushed[0]
        found.append(
            {
                "name": str(number + 1),
                "crank_phase": float(phases[number]),
                "reciprocating_mass": mass * float(random.uniform(0.7, 1.3)),
                "gas_force": {"crank_angle": angles.tolist(), "force": pushed.tolist()},
            }
        )
    return found


def _motor(random: np.random.Generator, sync: float, torque: float) -> Table:
    motor: Table = {"synchronous_speed": sync}
    if random.random() < 0.25:
        return motor | {"kind": "linear", "gain": torque / (0.03 * sync)}
    critical = float(random.uniform(0.1, 0.25))
    slips = np.array([0.0, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0])
    torques = 2.5 * torque * 2.0 / (slips / critical + critical / np.maximum(slips, 1e-9))
    torques[0] = 0.0
    return motor | {
        "kind": "slip_table",
        "slip_table": {"slip": (slips * sync).tolist(), "torque": torques.tolist()},
        "interpolation": str(random.choice(["linear", "parabola", "monotone"])),
        "extrapolation": "hold",
    }
