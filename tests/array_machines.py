"""Cases with every key that arrays can vary, and arrays of them held against single runs."""

from collections.abc import Mapping
from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
from shipped_cases import CASES
from sweep_blocks import quantities

from vibecalc.core.case.load import LoadedCase, load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, get_key, parse_key, set_key
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import DONE
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.study.sweep.at_once import unsupported
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.evaluate import ArrayEvaluator, Evaluator, Quantities
from vibecalc.errors import KeyPath

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
    "equal mounts": {
        "isolation.model": "rigid_body",
        "isolation.lever": None,
        "machine.mounts.each": {"stiffness": 1e4, "damping": 50.0},
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
    changes = dict(CHANGES[name])
    loaded = load_case(CASES[str(changes.pop("case", "generator"))])
    own = changes.pop("own", False)
    tables = changed(loaded, changes)
    if own:
        for cylinder in tables["machine"]["crank_train"]["cylinders"][:2]:
            cylinder |= {"reciprocating_mass": 0.6, "rotating_mass": 0.1}
    return as_read(loaded, tables)


def changed(loaded: LoadedCase, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case with other values by key; those of None are left out."""
    tables = deepcopy({k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED})
    for key, value in changes.items():
        path = parse_key(key)
        if value is not None:
            set_key(tables, key, value)
        else:
            above = get_key(tables, path[:-1]) if path[:-1] else tables
            above.pop(path[-1], None)
    return tables


def as_read(loaded: LoadedCase, tables: dict[str, Any]) -> LoadedCase:
    """Tables in place of those of a file."""
    case = validate(tables)
    return LoadedCase(
        case=case, name=loaded.name, path=loaded.path, text="", overrides=(),
        resolved=resolve(case), resolved_toml="", sha256="",
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Arrays and single runs.
# ----------------------------------------------------------------------------


class Counting(ArrayEvaluator):
    """Counts the points that a single run has done."""

    alone = 0

    def run_point(self, settings: Mapping[str, Any]) -> tuple[int, str, Quantities]:
        status, message, found = super().run_point(settings)
        self.alone += status == DONE
        return status, message, found


def numbers(table: Any, above: KeyPath = ()) -> list[KeyPath]:
    """Key paths of all doubles of a case."""
    if isinstance(table, float):
        return [above]
    if not isinstance(table, dict | list):
        return []
    entries = table.items() if isinstance(table, dict) else enumerate(table)
    return [path for name, entry in entries for path in numbers(entry, (*above, name))]


def paths_of(loaded: LoadedCase) -> tuple[str, ...]:
    """All results of a case that arrays can give."""
    case = loaded.case
    return tuple(p for p in planned_quantities(case) if unsupported(case, [], [p]) is None)


def keys_of(loaded: LoadedCase) -> tuple[KeyPath, ...]:
    """All numbers of a case that arrays can vary for these results."""
    paths, every = paths_of(loaded), numbers(loaded.resolved)
    return tuple(key for key in every if unsupported(loaded.case, [key], paths) is None)


def designed(loaded: LoadedCase, axes: list[dict[str, Any]], **more: Any) -> Design:
    return make_design(Sweep.model_validate({"axes": axes, **more}), loaded.resolved)


def hold(
    loaded: LoadedCase,
    design: Design,
    paths: tuple[str, ...],
    fewest: int,
    generous: float | None = 1.5,
) -> Block:
    """Hold arrays against single runs at all points; at least `fewest` come from arrays.

    Estimates of arrays are at most `generous` times those of single runs; None: any.
    """
    every = np.arange(design.count)
    by_arrays = Counting(loaded, design, paths)
    together, alone = by_arrays(every), Evaluator(loaded, design, paths)(every)
    assert together.status.tolist() == alone.status.tolist()
    assert together.message == alone.message
    done = alone.status == DONE
    assert done.sum() - by_arrays.alone >= fewest
    for path, single in quantities(alone).items():
        found = quantities(together)[path]
        assert (found.unit, found.long_name) == (single.unit, single.long_name)
        assert found.amplitude == single.amplitude
        assert [a.name for a in found.axes] == [a.name for a in single.axes]
        for axis, other in zip(found.axes, single.axes, strict=True):
            assert axis.values.tolist() == other.values.tolist()
            assert (axis.unit, axis.long_name) == (other.unit, other.long_name)
        assert np.isnan(found.values[~done]).all() and np.isnan(found.errors[~done]).all()
        same = found.values == single.values  # also where both are infinite
        one, two = (np.where(same, 0.0, part.values) for part in (found, single))
        apart = np.abs(one - two)[done].reshape(int(done.sum()), -1)
        uncertainty = (found.errors + single.errors)[done]
        assert (apart <= uncertainty[:, None]).all(), (path, apart.max(), uncertainty)
        if generous is not None:
            assert (found.errors[done] <= generous * single.errors[done] + 1e-300).all(), path
    return together
