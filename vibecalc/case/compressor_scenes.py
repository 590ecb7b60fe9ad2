"""Starter cases of compressors: plain dicts, as in `scenes.py`."""

from typing import Any

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
