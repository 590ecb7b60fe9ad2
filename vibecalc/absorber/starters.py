"""Starter cases: an absorber in ratios, a rig that ends in parts to buy, pendulums on a rotor."""

from typing import Any

ABSORBER: dict[str, Any] = {
    "schema": 1,
    "title": "The best spring and damper for an absorber of 8 % of the primary's mass",
    "machine": {
        "kind": "absorber",
        "primary": {"damping_ratio": 0.02},
        "secondary": {"mass_ratio": 0.08},
    },
    "response": {"absorber": {"frequency_ratios": {"from": 0.5, "to": 1.5}, "limits": True}},
    "tuning": {
        "compare": ["den_hartog"],
        "mistuning": ["1 %", "5 %", "10 %"],
        "sensitivity": True,
    },
}

ABSORBER_RIG: dict[str, Any] = {
    "schema": 1,
    "title": "A damper for a torsional rig: spring, oil and clearance to buy",
    "machine": {
        "kind": "absorber",
        "primary": {"damping_ratio": 0.01, "inertia": "0.42 kg*m^2"},
        "rod": {
            "length": "1.5 m",
            "diameter": "24 mm",
            "shear_modulus": "80 GPa",
            "total_length": "1.65 m",
            "span": "1.5 m",
            "elastic_modulus": "205 GPa",
            "density": "7850 kg/m^3",
        },
        "flywheel": {"mass": "22 kg", "diametral_inertia": "0.2 kg*m^2"},
        "springs": {"count": 4, "radius": "130 mm", "angle": "15 deg"},
        "ring": {
            "outer_radius": "140 mm",
            "inner_radius": "70 mm",
            "width": "18 mm",
            "density": "7850 kg/m^3",
        },
        "gap": {
            "outer_radius": "140 mm",
            "inner_radius": "70 mm",
            "width": "18 mm",
            "clearance": "0.6 mm",
            "temperature": "40 degC",
        },
        "stock_springs": [
            {"name": "soft", "rate": "2 N/mm"},
            {"name": "middle", "rate": "3.5 N/mm"},
            {"name": "stiff", "rate": "4.5 N/mm"},
        ],
        "oil_catalogue": {
            "part": [100, 220, 460, 1000],
            "viscosity_40": ["100 cSt", "220 cSt", "460 cSt", "1000 cSt"],
            "viscosity_100": ["11.4 cSt", "19.4 cSt", "31 cSt", "51 cSt"],
            "density": ["881 kg/m^3", "890 kg/m^3", "902 kg/m^3", "915 kg/m^3"],
        },
    },
    "tuning": {"temperatures": {"from": "20 degC", "to": "100 degC"}},
}

PENDULUM: dict[str, Any] = {
    "schema": 1,
    "title": "Pendulums that follow the second order of a crankshaft",
    "machine": {
        "kind": "absorber",
        "pendulum": {
            "order": 2.0,
            "mass": "0.9 kg",
            "count": 4,
            "vertex_distance": "95 mm",
            "path": "epicycloidal",
            "damping_ratio": 0.01,
            "rotor_inertia": "0.35 kg*m^2",
            "speed": "1800 rpm",
            "torque": "120 N*m",
            "swings": {"to": "60 deg", "points": 31},
        },
    },
}
