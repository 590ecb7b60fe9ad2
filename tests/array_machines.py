"""Machines with many of the keys that arrays can vary; shipped cases have the others."""

from copy import deepcopy
from functools import cache
from typing import Any

from shipped_cases import CASES

from vibecalc.core.case.load import LoadedCase, load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, parse_key, set_key

#: tables put in place of those of the shipped generator
CHANGES: dict[str, dict[str, Any]] = {
    "classic": {},
    "exact": {
        "kinematics": {},
        "excitation": {
            "driven_machine": "separate",
            "balance": {"orders": [1, 2, 4]},
            "residual": {"reference_length": 0.2, "couple_weight": 0.5},
        },
        "machine.crank_train.reciprocating_mass": None,
        "machine.crank_train.piston_mass": 0.3,
        "machine.crank_train.pin_mass": 0.05,
        "machine.crank_train.rod": {
            "mass": 0.5,
            "crank_pin_to_mass_centre": 0.05,
            "inertia": 0.003,
        },
        "machine.crank_train.wrist_pin_offset": 0.004,
        "machine.crank_train.counterweights": [
            {"name": "front", "unbalance": 0.01, "phase": 3.0, "position": 0.1},
            {"name": "rear", "unbalance": 0.02, "phase": 1.0, "position": -0.15},
        ],
        "machine.crank_train.balance_shafts": [
            {"unbalance": 0.003, "speed_ratio": 2, "phase": 0.3, "position": [0.01, 0.05, 0.02]},
            {"unbalance": 0.004, "speed_ratio": -1, "phase": 0.1},
        ],
        "machine.mounts": {
            "individual": [
                {
                    "name": "tilted",
                    "position": [-0.4, -0.3, 0.0],
                    "orientation": [0.2, 0.4, 0.1],
                    "stiffness": [2e4, 3e4, 4e4],
                    "damping": [20.0, 30.0, 40.0],
                },
                {"name": "own", "position": [-0.4, 0.3, 0.0], "stiffness": 3e4, "damping": 10.0},
                {"name": "upright", "position": [0.3, 0.0, 0.0], "damping": [1.0, 2.0, 3.0]},
                {"name": "lossy", "position": [0.45, 0.1, 0.0], "loss_factor": 0.05},
            ],
            "each": {"stiffness": [1e4, 2e4, 5e4], "damping": 15.0, "loss_factor": 0.02},
        },
        "isolation.lever": 0.4,
        "isolation.run_up": None,
    },
    "moments": {
        "kinematics": {},
        "excitation": {
            "working": ["1", "2"],
            "balanced_for": ["2", "3"],
            "orders": 7,
            "balance": {"orders": [1, 2]},
        },
        "machine.crank_train.cylinders[1].bank_angle": 1.0,
        "machine.crank_train.reciprocating_mass": None,
        "machine.crank_train.piston_mass": 0.3,
        "machine.crank_train.rod": {"mass": 0.4, "reciprocating_fraction": 0.3, "inertia": 0.004},
        "machine.body": {
            "mass": 120.0,
            "inertia": [5.0, 8.0, 9.0],
            "inertia_products": [0.1, 0.2, -0.1],
            "inertia_block": {
                "mass": 60.0,
                "box": {"length": 0.9, "width": 0.5, "height": 0.1},
                "position": [0.0, 0.02, -0.2],
            },
        },
        "machine.mounts.each": {"stiffness": 2e4, "damping": [10.0, 20.0, 30.0]},
        "isolation.lever": 0.35,
    },
}


@cache
def machine(name: str) -> LoadedCase:
    """One of the cases, as if read from a file."""
    loaded = load_case(CASES["generator"])
    tables = deepcopy({k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED})
    for key, value in CHANGES[name].items():
        path = parse_key(key)
        if value is None:
            above = tables
            for part in path[:-1]:
                above = above[part]
            above.pop(path[-1], None)
        else:
            set_key(tables, key, value)
    case = validate(tables)
    return LoadedCase(
        case=case,
        name=name,
        path=loaded.path,
        text="",
        overrides=(),
        resolved=resolve(case),
        resolved_toml="",
        sha256="",
    )
