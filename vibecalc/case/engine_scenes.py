"""Starter case of an engine: four cylinders in line with a damper, on a generator."""

from typing import Any

_CYLINDERS = [{"name": str(n + 1), "position": f"{135 * n - 202.5:g} mm"} for n in range(4)]
_STATIONS = [
    {"name": "pulley", "inertia": "0.024 kg*m^2"},
    *(
        {
            "name": f"throw {n}",
            "inertia": "0.031 kg*m^2",
            "cylinder": str(n),
            "absolute_damping": "0.8 N*m*s/rad",
        }
        for n in range(1, 5)
    ),
    {"name": "flywheel", "inertia": "1.35 kg*m^2"},
    {"name": "generator", "inertia": "0.85 kg*m^2"},
]
_SHAFTS = [
    {"name": "front", "stiffness": "0.55 MN*m/rad", "diameter": "60 mm"},
    *(
        {"name": f"crank {n}", "stiffness": "0.92 MN*m/rad", "diameter": "70 mm"}
        for n in range(1, 4)
    ),
    {"name": "rear", "stiffness": "1.4 MN*m/rad", "diameter": "75 mm"},
    {"name": "coupling", "stiffness": "18 kN*m/rad", "loss_factor": 0.12, "diameter": "70 mm"},
]

ENGINE: dict[str, Any] = {
    "schema": 1,
    "title": "Four-cylinder diesel on a generator: torsional vibration with a viscous damper",
    "machine": {
        "kind": "engine",
        "cycle": "four_stroke",
        "speed": "1500 rpm",
        "crank_train": {
            "crank_radius": "66 mm",
            "rod_length": "215 mm",
            "piston_mass": "1.9 kg",
            "pin_mass": "600 g",
            "rod": {"mass": "2.4 kg", "reciprocating_fraction": 0.34},
            "bore": "108 mm",
            "gas_cycle": {"kind": "diesel", "peak_pressure": "130 bar"},
            "cylinders": _CYLINDERS,
            "firing_order": ["1", "3", "4", "2"],
        },
        "shaft_line": {
            "stations": _STATIONS,
            "shafts": _SHAFTS,
            "dampers": [
                {
                    "name": "ring",
                    "on": "pulley",
                    "kind": "viscous",
                    "inertia": "0.045 kg*m^2",
                    "damping": "45 N*m*s/rad",
                }
            ],
        },
    },
    "response": {
        "torsion": {
            "speeds": {"from": "600 rpm", "to": "1900 rpm", "points": 401},
            "orders": {"highest": 12},
        }
    },
}
