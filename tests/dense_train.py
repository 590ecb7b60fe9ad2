"""Loads of a crank train on its body from the equations of motion alone, by sums over time.

It shares nothing with the program but the table of a case, in SI: forces are minus mass times
acceleration of every moving mass at many crank angles, and the torque of the gas is integrated over
the rows of its tables.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from math import comb
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

Table = dict[str, Any]
TURN = 2.0 * np.pi
#: crank angles of a turn
SAMPLES = 2048
XYZ = "xyz"


# ----------------------------------------------------------------------------
# Rows of tables.
# ----------------------------------------------------------------------------


class Curve(NamedTuple):
    """A signal over a cycle: breakpoints (b + 1,) in rad and a function between them."""

    ends: np.ndarray
    value: Callable[[np.ndarray], np.ndarray]

    @property
    def cycle(self) -> float:
        return float(self.ends[-1] - self.ends[0])


def rows_over_cycle(angle: Sequence[float], value: Sequence[float], how: str) -> Curve:
    """Straight between rows, a periodic spline, or parabolas through the row before, too."""
    x, y = np.array(angle), np.array(value)
    y[-1] = y[0]
    cycle = x[-1] - x[0]
    if how == "cubic":
        spline = CubicSpline(x, y, bc_type="periodic")
        return Curve(x, lambda a: np.asarray(spline(a)))
    if how == "linear":
        return Curve(x, lambda a: np.interp(a, x, y))

    def parabola(a: np.ndarray) -> np.ndarray:
        i = np.clip(np.searchsorted(x, a, side="right") - 1, 0, len(x) - 2)
        before = np.where(i == 0, x[-2] - cycle, x[i - 1])
        nodes = (before, x[i], x[i + 1])
        heights = (np.where(i == 0, y[-2], y[i - 1]), y[i], y[i + 1])
        total = np.zeros_like(a)
        for n in range(3):
            others = [nodes[m] for m in range(3) if m != n]
            part = heights[n] * (a - others[0]) * (a - others[1])
            total = total + part / ((nodes[n] - others[0]) * (nodes[n] - others[1]))
        return total

    return Curve(x, parabola)


# ----------------------------------------------------------------------------
# Crank and rod.
# ----------------------------------------------------------------------------


class Piston:
    """Distance of the wrist pin from the crank axis and lean of the rod, by crank angle."""

    def __init__(self, train: Table, terms: int | None = None):
        self.radius, self.rod = train["crank_radius"], train["rod_length"]
        self.offset, self.terms = train.get("wrist_pin_offset", 0.0), terms

    def place(self, a: np.ndarray) -> np.ndarray:
        if self.terms is not None:
            square = (self.radius / self.rod * np.sin(a)) ** 2
            root = sum(_binomial(j) * (-square) ** j for j in range(self.terms + 1))
            return np.asarray(self.radius * np.cos(a) + self.rod * root)
        return np.asarray(self.radius * np.cos(a) + self._root(a))

    def slopes(self, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivative by crank angle."""
        x, y = self.radius * np.cos(a), self.radius * np.sin(a)
        if self.terms is not None:
            lam = (self.radius / self.rod) ** 2
            s, c = np.sin(a), np.cos(a)
            first, second = -y, -x
            for j in range(1, self.terms + 1):
                factor = self.rod * _binomial(j) * (-lam) ** j
                first = first + factor * 2 * j * s ** (2 * j - 1) * c
                power = (2 * j - 1) * s ** (2 * j - 2) * c**2 - s ** (2 * j)
                second = second + factor * 2 * j * power
            return first, second
        root, side = self._root(a), y - self.offset
        first = -y - side * x / root
        return first, -x - (x**2 - side * y) / root - (side * x) ** 2 / root**3

    def lean_slopes(self, a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y = self.radius * np.cos(a), self.radius * np.sin(a)
        root = self._root(a)
        return x / root, -y / root + x * (y - self.offset) * x / root**3

    def _root(self, a: np.ndarray) -> np.ndarray:
        return np.asarray(np.sqrt(self.rod**2 - (self.radius * np.sin(a) - self.offset) ** 2))


def _binomial(j: int) -> float:
    """Of 1/2 over j."""
    return (-1.0) ** (j + 1) * comb(2 * j, j) / (4.0**j * (2 * j - 1)) if j else 1.0


def pump_curve(train: Table) -> Curve:
    """Pressure on a plunger against what is outside, over its own turn from crank angle zero on."""
    piston, given = Piston(train), train["pump_cycle"]
    low, high = given["suction_pressure"], given["discharge_pressure"]
    outside, stiff = given.get("outside_pressure", 101325.0), given["bulk_modulus"]
    area = 0.25 * np.pi * train["bore"] ** 2
    longer = np.array([piston.rod + piston.radius, piston.rod - piston.radius])
    far = np.sqrt(longer[0] ** 2 - piston.offset**2)
    leans = np.arcsin(piston.offset / longer)
    top, bottom = float(leans[0]), float(np.pi + leans[1])

    def volume(a: Any) -> Any:
        return given["dead_volume"] + area * (far - piston.place(a))

    def compressed(a: Any) -> Any:
        return low + stiff * np.log(volume(bottom) / volume(a))

    def expanded(a: Any) -> Any:
        return high - stiff * np.log(volume(a) / volume(top))

    opens = brentq(lambda a: expanded(a) - low, top, bottom, xtol=1e-15, rtol=1e-15)
    gives = brentq(lambda a: compressed(a) - high, bottom, top + TURN, xtol=1e-15, rtol=1e-15)

    def pressure(a: np.ndarray) -> np.ndarray:
        conditions = [a < opens, a < bottom, a < gives]
        return np.asarray(np.select(conditions, [expanded(a), low, compressed(a)], high) - outside)

    return Curve(np.array([top, opens, bottom, gives, top + TURN]), pressure)


def integrals(signal: Curve, order: np.ndarray) -> tuple[np.ndarray, float]:
    """Complex amplitudes at the orders (m,) and the mean of a signal, by Gauss rules on pieces."""
    node, weight = np.polynomial.legendre.leggauss(40)
    widest = 20.0 / max(float(order[-1]), 1.0)
    ends = [
        np.linspace(a, b, int(np.ceil((b - a) / widest)) + 1)[:-1]
        for a, b in zip(signal.ends[:-1], signal.ends[1:], strict=True)
    ]
    edge = np.append(np.concatenate(ends), signal.ends[-1])
    half = 0.5 * np.diff(edge)[:, None]
    angle = (0.5 * (edge[1:] + edge[:-1])[:, None] + half * node).ravel()
    value = (half * weight).ravel() * signal.value(angle)
    found = np.exp(-1j * np.outer(order, angle)) @ value
    return found * 2.0 / signal.cycle, float(value.sum() / signal.cycle)


# ----------------------------------------------------------------------------
# What acts on the body.
# ----------------------------------------------------------------------------


class Train:
    """Loads (6,) of a crank train on its body about the reference point, by order and speed."""

    def __init__(self, case: Table):
        self.case, self.machine = case, case["machine"]
        self.train = train = self.machine["crank_train"]
        self.axis = np.eye(3)[XYZ.index(train.get("axis", "x"))]
        self.up = np.eye(3)[XYZ.index(train.get("stroke_axis", "z"))]
        self.across = np.cross(self.up, self.axis)
        self.origin = np.array(train.get("origin", np.zeros(3)))
        kinematics = case.get("kinematics", {})
        cut = kinematics.get("series") == "truncated"
        #: sizes of force and couple per squared speed that may cancel
        self.terms = np.zeros(2)
        self.piston = Piston(train, kinematics.get("terms", 1) if cut else None)
        self.driven = case.get("excitation", {}).get("driven_machine", "on_body")
        self.cycle = TURN * (2 if self.machine.get("cycle") == "four_stroke" else 1)
        self.gas_acts = (
            self.machine["kind"] != "machine"
            and self.driven != "cancels_torque"
            and "torque" in case["isolation"].get("loads", ["torque"])
        )

    def masses(self) -> list[tuple[Table, float, float]]:
        """Each cylinder with what moves with its piston and what turns at its pin."""
        train = self.train
        rod = train.get("rod")
        share = rod["crank_pin_to_mass_centre"] / train["rod_length"] if rod else 0.0
        own = rod["mass"] if rod else 0.0
        common = train.get("reciprocating_mass")
        if common is None:
            common = train.get("piston_mass", 0.0) + train.get("pin_mass", 0.0) + own * share
        pin = train.get("rotating_mass", 0.0) + own * (1.0 - share)
        return [(one, one.get("reciprocating_mass", common), pin) for one in train["cylinders"]]

    @property
    def beyond_points(self) -> float:
        """Moment of a rod beyond that of its two point masses."""
        rod = self.train.get("rod", {})
        if "inertia" not in rod:
            return 0.0
        place = rod["crank_pin_to_mass_centre"]
        return float(rod["inertia"] - rod["mass"] * place * (self.train["rod_length"] - place))

    @cached_property
    def share(self) -> float:
        """Of the torque what turns the rotor, which its body has the other way round."""
        if "rotor" not in self.machine:
            return 1.0
        a = TURN * np.arange(SAMPLES) / SAMPLES
        speed, turned = self.piston.slopes(a)[0], self.piston.lean_slopes(a)[0]
        still = self.machine["rotor"]["inertia"]
        moving = 0.0
        for _, sliding, turning in self.masses():
            still += turning * self.train["crank_radius"] ** 2
            moving += np.mean(sliding * speed**2 + self.beyond_points * turned**2)
        return float(still / (still + moving))

    @cached_property
    def torque_of_masses(self) -> np.ndarray:
        """Torque on the crank (angles,) per squared speed."""
        angle = TURN * np.arange(SAMPLES) / SAMPLES
        total = np.zeros(SAMPLES)
        for one, sliding, _ in self.masses():
            a = angle + one.get("crank_phase", 0.0) - one.get("bank_angle", 0.0)
            first, second = self.piston.slopes(a)
            turned, bent = self.piston.lean_slopes(a)
            total -= sliding * first * second + self.beyond_points * turned * bent
        return total

    @cached_property
    def shaking(self) -> np.ndarray:
        """Forces and couples (orders 0 .., 6) of all that moves per squared speed."""
        angle, load = TURN * np.arange(SAMPLES) / SAMPLES, np.zeros((SAMPLES, 6))

        def act(force: np.ndarray, place: np.ndarray) -> None:
            couple = np.cross(place, force)
            load[:, :3] += force
            load[:, 3:] += couple
            self.terms += np.abs(force).max(), np.abs(couple).max()

        def turning(mass_radius: float, at: np.ndarray, place: np.ndarray, rate: int = 1) -> None:
            direction = np.outer(np.cos(at), self.up) - np.outer(np.sin(at), self.across)
            act(mass_radius * rate**2 * direction, self.origin + place)

        for one, sliding, pin in self.masses():
            bank, phase = one.get("bank_angle", 0.0), one.get("crank_phase", 0.0)
            along = np.cos(bank) * self.up - np.sin(bank) * self.across
            beside = -np.sin(bank) * self.up - np.cos(bank) * self.across
            on_shaft = one.get("position", 0.0) * self.axis
            _, second = self.piston.slopes(angle + phase - bank)
            line = self.origin + on_shaft + self.piston.offset * beside
            act(-sliding * np.outer(second, along), line)
            turning(pin * self.train["crank_radius"], angle + phase, on_shaft)
            bent = self.piston.lean_slopes(angle + phase - bank)[1]
            load[:, 3:] += self.beyond_points * np.outer(bent, self.axis)
        for one in self.train.get("counterweights", ()):
            place = one.get("position", 0.0) * self.axis
            turning(one["unbalance"], angle + one.get("phase", 0.0), place)
        for one in self.train.get("balance_shafts", ()):
            rate, place = one["speed_ratio"], np.array(one.get("position", np.zeros(3)))
            turning(one["unbalance"], rate * angle + one.get("phase", 0.0), place, rate)
        if self.driven != "cancels_torque":
            load[:, 3:] -= self.share * np.outer(self.torque_of_masses, self.axis)
            self.terms[1] += np.abs(self.torque_of_masses).max()
        return 2.0 / SAMPLES * np.fft.rfft(load, axis=0)

    # ------------------------------------------------------------------------
    # Gas.
    # ------------------------------------------------------------------------

    def fires(self) -> list[float]:
        """Crank angle at which each cylinder is at the start of its own cycle."""
        tops = [
            one.get("bank_angle", 0.0) - one.get("crank_phase", 0.0)
            for one in self.train["cylinders"]
        ]
        order = self.train.get("firing_order")
        if not order:
            return tops
        names = [one["name"] for one in self.train["cylinders"]]
        steps = self.train.get("firing_intervals") or [self.cycle / len(order)] * len(order)
        first = tops[names.index(order[0])] % TURN
        angle = dict(zip(order, first + np.cumsum([0.0, *steps[:-1]]), strict=True))
        return [float(angle[name]) for name in names]

    def cards(self) -> list[tuple[float, list[tuple[Curve, float]]]]:
        """At each speed of the cards, for each cylinder a curve and what makes it the force."""
        train = self.train
        area = 0.25 * np.pi * train.get("bore", 0.0) ** 2
        how = train.get("gas_interpolation", "linear")
        cylinders = train["cylinders"]
        if "pump_cycle" in train:
            return [(0.0, [(pump_curve(train), area)] * len(cylinders))]
        tables = train.get("gas_cards") or [{"speed": 0.0, "gas_pressure": train["gas_pressure"]}]
        found = []
        for card in tables:
            rows = card["gas_pressure"]
            common = rows_over_cycle(rows["crank_angle"], rows["pressure"], how)
            each = [(common, area * one.get("pressure_scale", 1.0)) for one in cylinders]
            for place, one in enumerate(cylinders):
                if own := one.get("gas_force"):
                    each[place] = rows_over_cycle(own["crank_angle"], own["force"], how), 1.0
            found.append((card["speed"], each))
        return found

    def torque_of_gas(self, order: np.ndarray) -> list[tuple[float, np.ndarray, float]]:
        """Speed of each card, torque on the crank (m,) of all cylinders, and its mean.

        The force pushes towards the crank, so that its work is minus that of the place of the pin.
        """
        found = []
        for speed, cylinders in self.cards():
            total, mean, known = np.zeros(len(order), dtype=complex), 0.0, dict[int, Any]()
            for fires, (curve, scale) in zip(self.fires(), cylinders, strict=True):
                if id(curve) not in known:
                    known[id(curve)] = integrals(self._torque_of(curve), order)
                value, constant = known[id(curve)]
                total += scale * value * np.exp(-1j * order * fires)
                mean += scale * constant
            found.append((speed, total, mean))
        return sorted(found, key=lambda one: one[0])

    def _torque_of(self, curve: Curve) -> Curve:
        return Curve(curve.ends, lambda a: -curve.value(a) * self.piston.slopes(a)[0])

    def prepare(self, order: np.ndarray) -> None:
        """The orders (m,) that loads are asked at."""
        self.order = order
        self.whole = np.isclose(order % 1.0, 0.0)
        self.gas = self.torque_of_gas(order) if self.gas_acts else []

    def _between(self, speed: float) -> tuple[np.ndarray, float]:
        speeds = [one[0] for one in self.gas]
        if len(speeds) == 1:
            return self.gas[0][1:]
        place = int(np.clip(np.searchsorted(speeds, speed) - 1, 0, len(speeds) - 2))
        low, high = self.gas[place], self.gas[place + 1]
        part = (speed - low[0]) / (high[0] - low[0])
        return (1 - part) * low[1] + part * high[1], (1 - part) * low[2] + part * high[2]

    def loads(self, speed: float) -> np.ndarray:
        """Forces and couples (m, 6)."""
        load = np.zeros((len(self.order), 6), dtype=complex)
        numbers = np.rint(self.order[self.whole]).astype(int)
        load[self.whole] = speed**2 * self.shaking[numbers]
        if self.gas:
            load[:, 3:] -= self.share * np.outer(self._between(speed)[0], self.axis)
        return load

    def torque(self, speed: float) -> np.ndarray:
        """Of these the torque of the cylinders, by gas and masses."""
        masses = 2.0 / SAMPLES * np.fft.rfft(self.torque_of_masses)
        total = self._between(speed)[0].copy()
        numbers = np.rint(self.order[self.whole]).astype(int)
        total[self.whole] += speed**2 * masses[numbers]
        load = np.zeros((len(total), 6), dtype=complex)
        load[:, 3:] = -self.share * np.outer(total, self.axis)
        return load

    def mean_couple(self, speed: float) -> float:
        """About the crankshaft; a machine driven on the body gives it back."""
        return -self._between(speed)[1] if self.gas and self.driven == "separate" else 0.0
