"""Starter cases of compressors, engines and pumps, as plain dicts."""

from typing import Any

# ----------------------------------------------------------------------------
# Starter cases of compressors: plain dicts, as in `scenes.py`.
# ----------------------------------------------------------------------------

_TRAIN: dict[str, Any] = {
    "axis": "z",
    "stroke": "y",
    "crank_radius": "13 mm",
    "rod_length": "60 mm",
    "piston_mass": "300 g",
    "pin_mass": "35 g",
    "rod": {"mass": "60 g", "crank_pin_to_mass_centre": "16 mm"},
    "cylinders": [
        {"name": "upper", "position": "-95 mm"},
        {"name": "lower", "position": "-145 mm", "crank_phase": "180 deg"},
    ],
}
_BODY: dict[str, Any] = {"mass": "36 kg", "inertia": ["0.38 kg*m^2", "0.34 kg*m^2", "0.16 kg*m^2"]}
_MOUNTS: dict[str, Any] = {
    "each": {"stiffness": "60 N/mm", "damping": "40 N*s/m"},
    "positions": [
        ["-90 mm", "-80 mm", "-120 mm"],
        ["90 mm", "-80 mm", "-120 mm"],
        ["0 mm", "100 mm", "-120 mm"],
        ["0 mm", "0 mm", "160 mm"],
    ],
}
_OPERATIONS = [
    {"name": "both", "working": ["upper", "lower"]},
    {"name": "one", "working": ["upper"]},
]
#: a polytropic cycle from 0.2 to 1.5 MPa, above the pressure of the crankcase
_PRESSURE = {
    "crank_angle": [f"{angle} deg" for angle in range(0, 361, 30)],
    "pressure": [f"{value} bar" for value in
                 (13, 2.2, 0, 0, 0, 0, 0, 0.3, 1.2, 3.3, 8.4, 13, 13)],
}  # fmt: skip


def machine(**more: Any) -> dict[str, Any]:
    """The compressor of all these scenes, with more parts."""
    return {"kind": "compressor", "speed": "2900 rpm", "crank_train": _TRAIN, **more}


COMPRESSOR: dict[str, Any] = {
    "schema": 1,
    "title": "Two-cylinder compressor that also runs on one",
    "machine": machine(body=_BODY, mounts=_MOUNTS),
    "excitation": {
        "working": ["upper", "lower"],
        "balanced_for": ["upper", "lower"],
        "driven_machine": "on_body",
    },
    "response": {
        "method": "modal",
        "energies": True,
        "operations": _OPERATIONS,
        "balances": [
            {"name": "both", "balanced_for": ["upper", "lower"]},
            {"name": "one", "balanced_for": ["upper"]},
        ],
    },
    "limit": [
        {
            "quantity": "response/ground_force_peak",
            "max": "200 N",
            "source": "specification of the housing",
        }
    ],
}

SWITCHING: dict[str, Any] = {
    "schema": 1,
    "title": "Compressor that goes from two cylinders to one by turning the other way",
    "machine": machine(body=_BODY, mounts=_MOUNTS),
    "excitation": {
        "working": ["upper", "lower"],
        "balanced_for": ["upper", "lower"],
        "driven_machine": "cancels_torque",
    },
    "response": {
        "operations": _OPERATIONS,
        "switching": {
            "between": ["both", "one"],
            "run_down": "0.8 s",
            "stand": "0.5 s",
            "run_up": "0.4 s",
        },
    },
}

IMPACT: dict[str, Any] = {
    "schema": 1,
    "title": "Impacts in the wrist pin of a compressor",
    "machine": machine(
        crank_train={**_TRAIN, "bore": "41 mm", "gas_pressure": _PRESSURE},
        joints={
            "cylinder": "upper",
            "wrist_pin": {
                "clearance": "30 um",
                "stiffness": "150 kN/mm",
                "contact_damping": "20 N*s/m",
                "film_damping": "20 N*s/m",
            },
        },
    ),
    "response": {
        "impact": {
            "clearances": ["10 um", "30 um"],
            "members": 8,
            "revolutions": 5,
            "discard": 5,
        }
    },
}

BALANCE: dict[str, Any] = {
    "schema": 1,
    "title": "A counterweight that lets two operations shake less, weighted",
    "machine": machine(
        crank_train={
            **_TRAIN,
            "counterweights": [
                {
                    "name": "corrective",
                    "unbalance": "1e-3 kg*m",
                    "phase": "180 deg",
                    "position": "-95 mm",
                }
            ],
        },
        body=_BODY,
        mounts=_MOUNTS,
    ),
    "excitation": {"working": ["upper", "lower"], "balanced_for": ["upper", "lower"]},
    "response": {"operations": _OPERATIONS},
    "optimisation": {
        "variables": [
            {
                "key": "machine.crank_train.counterweights[0].unbalance",
                "lower": "0 kg*m",
                "upper": "0.01 kg*m",
            },
            {
                "key": "machine.crank_train.counterweights[0].phase",
                "lower": "0 deg",
                "upper": "360 deg",
            },
        ],
        "objective": {"quantity": "response/operations/kinetic_energy/weighted", "sense": "min"},
        "starts": 4,
    },
}

# ----------------------------------------------------------------------------
# Starter case of an engine: four cylinders in line with a damper, on a generator.
# ----------------------------------------------------------------------------

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

# ----------------------------------------------------------------------------
# The starter case of a pump, as a case writes it.
# ----------------------------------------------------------------------------

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
