"""Tables of tangential effort for the cases of tests, made from cards or from a formula."""

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibecalc.excitation.cylinder_torque import gas_harmonics
from vibecalc.excitation.model import gas_cards
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.parts.firing import cycle_angle
from vibecalc.schema import Machine

COLUMNS = ("mean_indicated_pressure", "order", "cosine", "sine")
#: rows (load in Pa, order, cosine, sine) of a four-stroke engine, up to order 6
ROWS = [
    (load, order, load * (0.4 / order - 0.05), 3e4 + load * 0.9 / (1.0 + order))
    for load in (4e5, 12e5, 20e5)
    for order in np.arange(0.5, 6.1, 0.5).tolist()
]
OVER_SPEED = {"speed": [80.0, 150.0, 210.0], "mean_indicated_pressure": [6e5, 14e5, 18e5]}


def table(rows: Sequence[tuple[float, ...]]) -> dict[str, Any]:
    """Columns of rows."""
    return {name: [row[k] for row in rows] for k, name in enumerate(COLUMNS)}


def swept_volume(machine: Machine) -> float:
    """Piston area times the way between the dead centres, by Pythagoras."""
    radius, length, bore, offset = crank_geometry(machine.crank_train)
    far, near = ((length + sign * radius) ** 2 - offset**2 for sign in (1.0, -1.0))
    return float(0.25 * np.pi * bore**2 * (np.sqrt(far) - np.sqrt(near)))


def from_cards(data: dict[str, Any], machine: Machine, orders: np.ndarray) -> dict[str, Any]:
    """The case with the harmonics of its cards in place of them, over their own loads."""
    geometry, cycle = crank_geometry(machine.crank_train), cycle_angle(machine)
    lever = geometry.piston_area * geometry.crank_radius
    speeds, cards = gas_cards(machine)
    rows, loads = [], []
    for card in cards:
        gas, mean = gas_harmonics(card, geometry, orders)
        loads.append(float(mean.value) * cycle / swept_volume(machine))
        pressure = gas.value / lever
        parts = zip(orders.tolist(), pressure.real.tolist(), (-pressure.imag).tolist(), strict=True)
        rows += [(loads[-1], *part) for part in parts]
    changed = copy.deepcopy(data)
    train = changed["machine"]["crank_train"]
    for key in ("gas_cards", "gas_interpolation"):
        train.pop(key)
    train["tangential_effort"] = {
        "harmonics": table(rows),
        "over_speed": {"speed": speeds.tolist(), "mean_indicated_pressure": loads},
    }
    return changed
