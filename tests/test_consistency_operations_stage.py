"""Claim: the ranges over the phase of the weights are those of machines turned by hand.

Throws and weights are written out as counterweights and turned; and what happens where parts cancel
on a resonance, or nobody is balanced for.
"""

import copy
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from random_machines import Table
from response_machines import bare, run, shipped
from scipy.optimize import minimize_scalar

from vibecalc.core.results.record import Record
from vibecalc.errors import NumericalFailure

KINDS = ("kinetic", "potential")
OPERATIONS = {"A+B": ["A", "B"], "A": ["A"], "B": ["B"]}
STEM = "response/operations"
TRAIN_MASSES = ("piston_mass", "pin_mass", "rod")


def short(table: Table) -> Table:
    """As many orders as the tolerance needs, and energies alone."""
    table["excitation"].pop("orders", None)
    del table["kinematics"]
    return table


@cache
def combined() -> Record:
    return run(short(shipped()))


def test_ranges_hold_the_nominal_phase() -> None:
    record = combined()
    for kind in KINDS:
        for what in ("mean", "peak"):
            low, middle, high = (
                record[f"{STEM}/{kind}_energy/{what}{end}"] for end in ("_low", "", "_high")
            )
            slack = low.error_estimate + middle.error_estimate + high.error_estimate
            assert np.all(low.values <= middle.values + slack)
            assert np.all(middle.values <= high.values + slack)
            own = np.diagonal(high.values - low.values)
            assert np.all(own <= slack), "a balanced throw has no phase"
            others = (high.values - low.values)[~np.eye(3, dtype=bool)]
            assert np.all(others > 1e-3 * middle.values.max())


def written_out(working: list[str], balanced: list[str]) -> Callable[[float], Record]:
    """The machine at a phase: its throws that turn, and its weights, as counterweights."""
    masses = combined()
    table = short(bare())
    train = table["machine"]["crank_train"]
    for key in TRAIN_MASSES:
        del train[key]
    train["reciprocating_mass"] = float(masses["excitation/mass/reciprocating"].values[0])
    throw = 0.0127 * float(masses["excitation/mass/rotating"].values[0])
    table["excitation"] = {"working": working, "driven_machine": "cancels_torque"}

    def at(phase: float) -> Record:
        moved = copy.deepcopy(table)
        weights = []
        for cylinder, lead in zip(train["cylinders"], (0.0, np.pi), strict=True):
            for names, turn in ((working, 0.0), (balanced, np.pi)):
                if cylinder["name"] in names:
                    weights.append(
                        {
                            "name": f"{cylinder['name']} {turn}",
                            "unbalance": throw,
                            "phase": lead + turn + phase,
                            "position": cylinder["position"],
                        }
                    )
        moved["machine"]["crank_train"]["counterweights"] = weights
        return run(
            moved, *(f"response/{k}_energy/{what}" for k in KINDS for what in ("mean", "peak"))
        )

    return at


@pytest.mark.long
@pytest.mark.parametrize(("working", "balanced"), [("A+B", "A"), ("A", "B")])
def test_ranges_are_those_of_a_scan_over_the_phase(working: str, balanced: str) -> None:
    at = written_out(OPERATIONS[working], OPERATIONS[balanced])
    phases = np.arange(8) * (2.0 * np.pi / 8)
    records = [at(float(phase)) for phase in phases]
    cell = (list(OPERATIONS).index(working), list(OPERATIONS).index(balanced))
    for kind in KINDS:
        for what in ("mean", "peak"):
            stem, path = f"{STEM}/{kind}_energy/{what}", f"response/{kind}_energy/{what}"
            nominal = combined()[stem].values[cell]
            seen = np.array([float(record[path].values) for record in records])
            assert nominal == pytest.approx(seen[0], rel=1e-11)
            for end, sign in (("low", 1.0), ("high", -1.0)):
                ours = combined()[f"{stem}_{end}"]
                start = float(phases[np.argmin(sign * seen)])
                found = minimize_scalar(
                    lambda p, sign=sign, path=path: sign * float(at(p)[path].values),
                    bounds=(start - 0.8, start + 0.8),
                    method="bounded",
                    options={"xatol": 1e-7},
                )
                best = sign * found.fun
                assert sign * ours.values[cell] <= sign * best + ours.error_estimate
                # a kink is met to the search's step, a smooth end to its square
                assert ours.values[cell] == pytest.approx(
                    best, rel=1e-6 if what == "peak" else 1e-11
                )


def balanced_out() -> Table:
    """A weight that takes the first order of its piston away, on a mode that order would drive."""
    table = short(bare(method="direct"))
    machine = table["machine"]
    machine["speed"] = 200.0
    train = machine["crank_train"]
    for key in TRAIN_MASSES:
        del train[key]
    train["reciprocating_mass"] = 0.5
    first, second = train["cylinders"]
    first["position"] = second["position"] = 0.0
    second["crank_phase"] = 0.0
    first["rotating_mass"], second["rotating_mass"] = 0.25, 0.75
    table["excitation"] = {"working": ["A"], "balanced_for": ["B"]}
    mass = np.diag([4.0, 4.0, 4.0, 0.5, 0.5, 0.5])
    natural = np.array([311.0, 200.0, 343.0, 367.0, 389.0, 411.0])
    machine["body"] = {"mass_matrix": {"values": mass.tolist()}}
    stiffness = mass * natural**2
    machine["mounts"] = {"stiffness_matrix": {"values": stiffness.tolist()}}
    return table


def test_parts_that_cancel_on_a_resonance_have_no_range() -> None:
    """At the nominal phase nothing drives the mode; at the others the body has no bound."""
    table = balanced_out()
    record = run(table)
    (warning,) = [text for text in record.warnings if "natural frequency" in text]
    assert "order 1" in warning and "does not drive it" in warning
    table["response"]["operations"] = [{"name": "A", "working": ["A"]}]
    with pytest.raises(NumericalFailure, match=r"order 1 at 1909\.86 rpm"):
        run(table)


def test_a_mode_that_no_part_drives_is_left_out() -> None:
    table = balanced_out()
    table["machine"]["speed"] = 343.0 / 2.0  # along the crankshaft nothing moves
    table["response"]["operations"] = [{"name": "A", "working": ["A"]}]
    record = run(table)
    assert any("does not drive it" in text for text in record.warnings)
    cell = record[f"{STEM}/kinetic_energy/mean"]
    want = float(record["response/kinetic_energy/mean"].values)
    assert float(cell.values[0, 0]) == pytest.approx(want, rel=1e-12)
    assert want < 10.0


def test_a_balance_for_nobody_is_a_run_without_weights() -> None:
    table = short(shipped())
    table["response"]["balances"] = [{"name": "none", "balanced_for": []}]
    found = run(table)
    for name, working in OPERATIONS.items():
        alone = short(shipped())
        alone["excitation"]["working"] = working
        alone["excitation"].pop("balanced_for", None)
        alone["response"] = {"energies": True, "method": table["response"].get("method", "direct")}
        mean = run(alone)["response/kinetic_energy/mean"]
        quantity = found[f"{STEM}/kinetic_energy/mean"]
        row = list(quantity.axes[0].values).index(name)
        assert quantity.values[row, 0] == pytest.approx(float(mean.values), rel=1e-9)
