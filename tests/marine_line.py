"""The line of cases/marine_propulsion.toml by the full matrices of `dense_line.py`.

The torque of a cylinder is a Gauss quadrature of pressure and piston speed over each interval of
the cards. Of the package only the curve through the points of a card is used.
"""

from functools import cache
from typing import Any

import numpy as np
from dense_line import Cylinder, DenseLine, half_range
from shipped_cases import CASES

from vibecalc.core.case.load import load_case, resolve
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.excitation.model import gas_cards
from vibecalc.schema import Case


@cache
def loaded() -> Case:
    return load_case(CASES["marine_propulsion"]).case


@cache
def tables() -> dict[str, Any]:
    """The case as tables, in SI."""
    return resolve(loaded())


@cache
def orders() -> np.ndarray:
    asked = tables()["response"]["torsion"]["orders"]
    return asked["step"] * np.arange(1.0, asked["count"] + 1.0)


def speed_of_crank() -> float:
    return float(tables()["machine"]["speed"])


def train() -> dict[str, Any]:
    return tables()["machine"]["crank_train"]


def motion(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of the way of a piston from its top by the crank angle."""
    r, rod = train()["crank_radius"], train()["rod_length"]
    sine, cosine = r * np.sin(angle), r * np.cos(angle)
    foot = np.sqrt(rod**2 - sine**2)
    first = sine + sine * cosine / foot
    second = cosine + (cosine**2 - sine**2) / foot + (sine * cosine) ** 2 / foot**3
    return first, second


@cache
def quadrature() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angles, weights, speeds of the cards and their pressures at the angles."""
    speeds, cards = gas_cards(loaded().machine)
    nodes = np.unique(np.concatenate([np.mod(card.node, 2.0 * np.pi) for card in cards]))
    ends = np.append(nodes, nodes[0] + 2.0 * np.pi)
    place, weight = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(ends)
    angle = (ends[:-1, None] + half[:, None] * (1.0 + place)).ravel()
    pressure = np.array([pressure_at(card, angle) for card in cards])
    return angle, (half[:, None] * weight).ravel(), np.asarray(speeds), pressure


@cache
def cylinder(speed: float) -> Cylinder:
    """Of a healthy one at a crank speed in rad/s."""
    angle, weight, speeds, cards = quadrature()
    area = np.pi * train()["bore"] ** 2 / 4.0
    above = int(np.clip(np.searchsorted(speeds, speed), 1, len(speeds) - 1))
    share = (speed - speeds[above - 1]) / (speeds[above] - speeds[above - 1])
    pressure = (1.0 - share) * cards[above - 1] + share * cards[above]
    first, second = motion(angle)
    wave = np.exp(-1j * orders()[:, None] * angle)
    gas, inertia = (
        (wave * torque) @ weight / np.pi
        for torque in (pressure * area * first, -train()["reciprocating_mass"] * second * first)
    )
    return Cylinder(orders(), gas, inertia)


@cache
def line() -> DenseLine:
    return DenseLine(tables(), cylinder)


def halves(speed: float, misfires: str = "") -> np.ndarray:
    """Half ranges of the torques of all sections, all cylinders firing or one without gas."""
    return half_range(orders(), line().at(speed, {misfires: 0.0}).torque)
