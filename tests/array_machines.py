"""Cases that between them have every key that arrays can vary, and every result they can give."""

from copy import deepcopy
from functools import cache
from typing import Any

from shipped_cases import CASES

from vibecalc.core.case.load import LoadedCase, load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, parse_key, set_key

#: tables put in place of those of the shipped generator, or of another `case`
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
    "six freedoms": {
        "kinematics": {},
        "isolation.model": "rigid_body",
        "isolation.lever": None,
        "isolation.run_up": None,
        "machine.body.inertia_block": {
            "mass": 30.0,
            "box": {"length": 0.9, "width": 0.5, "height": 0.1},
            "position": [0.02, 0.01, -0.2],
        },
        "machine.mounts.each": {"stiffness": [1e4, 2e4, 5e4], "damping": 15.0, "loss_factor": 0.02},
    },
    "run-up of six freedoms": {
        "kinematics": {},
        "isolation.model": "rigid_body",
        "isolation.lever": None,
        "machine.mounts.each": {"stiffness": [1e4, 2e4, 5e4], "damping": 15.0, "loss_factor": 0.02},
    },
    "energies": {
        "kinematics": {},
        "isolation": None,
        "response": {"energies": True, "method": "modal"},
        "machine.mounts.each": {"stiffness": 3e4, "damping": [20.0, 30.0, 40.0]},
    },
    "direct": {
        "isolation": None,
        "response": {"energies": True, "method": "direct"},
        "machine.mounts.each": {"stiffness": [1e4, 2e4, 5e4], "loss_factor": 0.04},
    },
    "parts": {
        "isolation": {"model": "rigid_body"},
        "machine.body": {
            "parts": [
                {
                    "name": "engine",
                    "mass": 70.0,
                    "centre": [0.1, 0.02, 0.05],
                    "box": {"length": 0.6, "width": 0.4, "height": 0.5},
                },
                {
                    "name": "generator",
                    "mass": 50.0,
                    "centre": [-0.4, 0.0, 0.02],
                    "inertia": [2.0, 3.0, 4.0],
                    "inertia_products": [0.1, 0.05, -0.1],
                },
            ],
        },
        "machine.mounts.datum": [0.02, 0.0, -0.05],
    },
    "own centre": {"isolation": {"model": "rigid_body"}, "machine.body.centre": [0.01, 0.02, 0.03]},
    "matrices": {"case": "compressor", "response.operations": [], "response.balances": []},
    "operations": {
        "kinematics": {},
        "isolation": None,
        "excitation": {"driven_machine": "separate", "idle": "stopped"},
        "response": {
            "method": "direct",
            "operations": [
                {"name": "all", "working": ["1", "2", "3"], "weight": 1.5},
                {"name": "two", "working": ["1", "3"]},
            ],
            "balances": [
                {"name": "for all", "balanced_for": ["1", "2", "3"]},
                {"name": "for one", "balanced_for": ["2"]},
                {"name": "none", "balanced_for": []},
            ],
        },
        "machine.crank_train.rotating_mass": 0.3,
        "machine.crank_train.counterweights": [
            {"name": "front", "unbalance": 0.01, "phase": 3.0, "position": 0.1},
        ],
        "machine.mounts.each": {"stiffness": [1e4, 2e4, 5e4], "damping": 15.0, "loss_factor": 0.02},
    },
    "undamped operations": {"case": "compressor"},
    "on a floor": {
        "isolation.run_up": None,
        "foundation": {"mass": 400.0, "stiffness": 2e6, "damping": 300.0, "loss_factor": 0.03},
    },
    "points": {
        "isolation": {"model": "rigid_body"},
        "machine.mounts.each": {"stiffness": [1e4, 2e4, 5e4], "loss_factor": 0.04},
        "point": [
            {"name": "bearing", "position": [0.3, 0.0, -0.1]},
            {"name": "cover", "position": [0.0, 0.1, 0.4], "direction": [0.0, 1.0, 2.0]},
        ],
        "vibration_severity": {"grades": [4.5, 18.0]},
    },
    "own masses": {
        "kinematics": {"series": "truncated", "terms": 3},
        "machine.crank_train.reciprocating_mass": 0.7,
        "machine.crank_train.rotating_mass": 0.2,
        "own": True,
    },
}


@cache
def machine(name: str) -> LoadedCase:
    """One of the cases, as if read from a file."""
    loaded = load_case(CASES[str(CHANGES[name].get("case", "generator"))])
    tables = deepcopy({k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED})
    for key, value in CHANGES[name].items():
        if key == "case":
            continue
        if key == "own":
            for cylinder in tables["machine"]["crank_train"]["cylinders"][:2]:
                cylinder |= {"reciprocating_mass": 0.6, "rotating_mass": 0.1}
            continue
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
