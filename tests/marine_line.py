"""The line of cases/marine_propulsion.toml, solved densely from the text of the case alone.

Units are read here, the torque of a cylinder is a Gauss quadrature of pressure and piston speed
over each interval of the cards, that of the blades a share of what the propeller takes, dampings
are formed anew at each speed and order, and every order is one solve of the full matrix. Of the
package only the curve through the points of a card is used.
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.load import load_case
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.excitation.model import gas_cards

CASE = Path(__file__).resolve().parents[1] / "cases" / "marine_propulsion.toml"
UNITS = {
    "kg*m^2": 1.0, "t*m^2": 1e3, "kg": 1.0, "kN*m*s/rad": 1e3, "MN*m/rad": 1e6, "GN*m/rad": 1e9,
    "kN*m": 1e3, "m": 1.0, "mm": 1e-3, "rpm": np.pi / 30.0, "MPa": 1e6, "deg": np.pi / 180.0,
}  # fmt: skip
SHEAR_MODULUS = 80e9


def number(text: Any) -> float:
    """A value in SI units; what is not said is zero."""
    value, _, unit = str(text or "0 kg").partition(" ")
    return float(value) * UNITS[unit]


@cache
def whole() -> dict[str, Any]:
    return tomllib.loads(CASE.read_text(encoding="utf-8"))


def machine() -> dict[str, Any]:
    return whole()["machine"]


def line() -> dict[str, Any]:
    return machine()["shaft_line"]


def operating_speed() -> float:
    return number(machine()["speed"])


def orders() -> np.ndarray:
    asked = whole()["response"]["torsion"]["orders"]
    return asked["step"] * np.arange(1.0, asked["count"] + 1.0)


def diameter(shaft: dict[str, Any]) -> float:
    return number(shaft["section"]["outer_diameter"])


def stiffness(shaft: dict[str, Any]) -> float:
    if "stiffness" in shaft:
        return number(shaft["stiffness"])
    length = number(shaft["section"]["length"])
    return SHEAR_MODULUS * np.pi * diameter(shaft) ** 4 / 32.0 / length


def loss(shaft: dict[str, Any]) -> float:
    return 1.0 / shaft["magnifier"] if "magnifier" in shaft else 2.0 * shaft["lehr_ratio"]


def inertias() -> np.ndarray:
    return np.array([number(one["inertia"]) for one in line()["stations"]])


def network(links: np.ndarray) -> np.ndarray:
    """Matrix of values between neighbours."""
    count = len(links) + 1
    ends = np.zeros((len(links), count))
    ends[np.arange(count - 1), np.arange(count - 1)] = 1.0
    ends[np.arange(count - 1), np.arange(1, count)] = -1.0
    return ends.T @ (links[:, None] * ends)


def natural_frequencies() -> np.ndarray:
    root = np.sqrt(inertias())
    springs = network(np.array([stiffness(one) for one in line()["shafts"]]))
    found = np.linalg.eigvalsh(springs / np.outer(root, root))
    return np.sqrt(np.maximum(found, 0.0))


def taken(load: dict[str, Any], speed: float) -> float:
    """Mean torque of a load at a crank speed in rad/s, N m."""
    return float(number(load["torque"]) * (speed / operating_speed()) ** load["exponent"])


def station_dampings(speed: float) -> np.ndarray:
    """Absolute dampings at a crank speed in rad/s: of the engine, as given, of the propeller."""
    given = line()
    engine, found = given["engine_damping"], []
    over, w = engine["over_speed"]["table"], natural_frequencies()[1]
    factor = np.interp(speed, [number(one) for one in over["speed"]], over["factor"])
    for station in given["stations"]:
        damping = number(station.get("absolute_damping"))
        if "over_speed" in station:
            damping *= speed / number(station["over_speed"]["reference"])
        if "cylinder" in station:
            damping += factor * number(station["inertia"]) * w / engine["magnifier"]
        for load in given["loads"]:
            if load["on"] == station["name"]:
                coefficient = load["propeller_damping"]["coefficient"]
                damping += coefficient * taken(load, speed) / (speed * 30.0 / np.pi)
        found.append(damping)
    return np.array(found)


def motion(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of the way of a piston from its top by the crank angle."""
    train = machine()["crank_train"]
    r, rod = number(train["crank_radius"]), number(train["rod_length"])
    sine, cosine = r * np.sin(angle), r * np.cos(angle)
    foot = np.sqrt(rod**2 - sine**2)
    first = sine + sine * cosine / foot
    second = cosine + (cosine**2 - sine**2) / foot + (sine * cosine) ** 2 / foot**3
    return first, second


@cache
def quadrature() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Angles, weights, speeds of the cards and their pressures at the angles."""
    speeds, cards = gas_cards(load_case(CASE).case.machine)
    nodes = np.unique(np.concatenate([np.mod(card.node, 2.0 * np.pi) for card in cards]))
    ends = np.append(nodes, nodes[0] + 2.0 * np.pi)
    place, weight = np.polynomial.legendre.leggauss(16)
    half = 0.5 * np.diff(ends)
    angle = (ends[:-1, None] + half[:, None] * (1.0 + place)).ravel()
    pressure = np.array([pressure_at(card, angle) for card in cards])
    return angle, (half[:, None] * weight).ravel(), np.asarray(speeds), pressure


def cylinder_torque(speed: float, gas: float = 1.0) -> np.ndarray:
    """Of one cylinder (m,), complex 0-to-peak, at a crank speed in rad/s; gas = 0 in a misfire."""
    angle, weight, speeds, cards = quadrature()
    train = machine()["crank_train"]
    area = np.pi * number(train["bore"]) ** 2 / 4.0
    above = int(np.clip(np.searchsorted(speeds, speed), 1, len(speeds) - 1))
    share = (speed - speeds[above - 1]) / (speeds[above] - speeds[above - 1])
    pressure = (1.0 - share) * cards[above - 1] + share * cards[above]
    first, second = motion(angle)
    mass = number(train["reciprocating_mass"])
    torque = gas * pressure * area * first - mass * speed**2 * second * first
    wave = np.exp(-1j * orders()[:, None] * angle)
    return (wave * torque) @ weight / np.pi


class Solved(NamedTuple):
    """Angles (stations, orders) in rad and torques (sections, orders) in N m."""

    angle: np.ndarray
    torque: np.ndarray


def blade_torques(speed: float) -> np.ndarray:
    """Torques (stations, m) of what is given at stations, by blades, complex 0-to-peak."""
    given, order = line(), orders()
    names = [one["name"] for one in given["stations"]]
    found = np.zeros((len(names), len(order)), dtype=complex)
    for one in given["excitations"]:
        (load,) = [load for load in given["loads"] if load["on"] == one["on"]]
        for times, (share, phase) in enumerate(zip(one["shares"], one["phases"], strict=True), 1):
            turned = np.exp(1j * number(phase))
            place = order == times * one["blades"]
            found[names.index(one["on"]), place] += share * taken(load, speed) * turned
    return found


def solved(speed: float, misfires: str = "") -> Solved:
    """At one speed in rad/s, all cylinders firing or one of them without gas."""
    given, firing = line(), machine()["crank_train"]["firing_order"]
    lag = {name: 2.0 * np.pi * place / len(firing) for place, name in enumerate(firing)}
    torque = {0.0: cylinder_torque(speed, 0.0), 1.0: cylinder_torque(speed)}
    load = blade_torques(speed)
    for place, station in enumerate(given["stations"]):
        if "cylinder" in station:
            name = station["cylinder"]
            load[place] += torque[float(name != misfires)] * np.exp(-1j * orders() * lag[name])
    k = np.array([stiffness(one) * (1.0 + 1j * loss(one)) for one in given["shafts"]])
    springs, damping, inertia = network(k), np.diag(station_dampings(speed)), np.diag(inertias())
    angle = np.array(
        [
            np.linalg.solve(springs + 1j * w * damping - w**2 * inertia, column)
            for w, column in zip(orders() * speed, load.T, strict=True)
        ]
    ).T
    return Solved(angle, k[:, None] * (angle[:-1] - angle[1:]))


def half_ranges(amplitude: np.ndarray) -> np.ndarray:
    """Half of highest less lowest over a turn, of rows of orders."""
    samples = 4096
    grid = np.arange(samples) * 2.0 * np.pi / samples
    q = orders()

    def values(row: np.ndarray, angle: np.ndarray) -> list[np.ndarray]:
        wave = np.exp(1j * np.multiply.outer(angle, q)) * row
        return [(wave * (1j * q) ** power).real.sum(axis=-1) for power in range(3)]

    found = []
    for row in amplitude:
        signal, ends = values(row, grid)[0], []
        for place in (np.argmax(signal), np.argmin(signal)):
            angle = grid[place]
            for _ in range(6):  # Newton's method on the slope
                _, slope, bend = values(row, angle)
                angle = angle - slope / bend
            ends.append(values(row, angle)[0])
        found.append(0.5 * (ends[0] - ends[1]))
    return np.array(found)
