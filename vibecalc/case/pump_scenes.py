"""The starter case of a pump, as a case writes it."""

from typing import Any

PUMP: dict[str, Any] = {
    "schema": 1,
    "title": "Plunger pump driven by a belt, on two mounts",
    "machine": {
        "kind": "pump",
        "speed": "450 rpm",
        "crank_train": {
            "crank_radius": "25 mm",
            "rod_length": "125 mm",
            "bore": "40 mm",
            "piston_mass": "4 kg",
            "rod": {"mass": "3 kg", "crank_pin_to_mass_centre": "45 mm"},
            "rotating_mass": "2 kg",
            "pump_cycle": {
                "suction_pressure": "2 bar",
                "discharge_pressure": "100 bar",
                "bulk_modulus": "1.8 GPa",
                "dead_volume": "30 cm^3",
            },
            "origin": ["0 m", "0 m", "-20 mm"],
            "cylinders": [{"name": "1"}],
            "counterweights": [{"name": "webs", "unbalance": "0.15 kg*m", "phase": "180 deg"}],
        },
        "body": {"mass": "180 kg", "inertia": ["7.5 kg*m^2", "8 kg*m^2", "6 kg*m^2"]},
        "mounts": {
            "each": {
                "stiffness": ["150 N/mm", "150 N/mm", "250 N/mm"],
                "damping": ["300 N*s/m", "300 N*s/m", "500 N*s/m"],
            },
            "positions": [["0 m", "-0.25 m", "-0.2 m"], ["0 m", "0.25 m", "-0.2 m"]],
        },
    },
    "excitation": {"driven_machine": "separate"},
    "isolation": {"model": "planar", "run_up": {"from": "0 rpm", "to": "500 rpm"}},
}
