"""A shaft line from the equations of motion alone: own angles, full matrices, gears as constraints.

It shares nothing with the program but the table of a case, in SI, and the torque of one cylinder
by order. Nothing is referred to the crankshaft: rigid gears are equations between angles, whose
torques are their multipliers; each order is one solve.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh, null_space

Table = dict[str, Any]
Array = np.ndarray


class Cylinder(NamedTuple):
    """Torque of a healthy one by order (m,): of gas in N m, of masses over the speed squared."""

    order: Array
    gas: Array
    inertia: Array
    mean: float


class Solved(NamedTuple):
    """At one speed: angles (stations + rings, m), torques (sections, m) and those of gears (g, m),
    means of sections and gears, frequencies (m,), complex stiffness (sections, m)."""

    angle: Array
    torque: Array
    gear: Array
    torque_mean: Array
    gear_mean: Array
    frequency: Array
    stiffness: Array


class DenseLine:
    """Stations, then rings of dampers; sections are shafts, elastic gears and dampers."""

    def __init__(self, case: Table, cylinder: Cylinder):
        machine = case["machine"]
        self.line, self.train, self.given = machine["shaft_line"], machine["crank_train"], cylinder
        self.speed = machine["speed"]
        self.names = [one["name"] for one in self.line["stations"]]
        self.dampers = self.line.get("dampers", [])
        self.rings = [one["name"] for one in self.dampers]
        self.count = len(self.names) + len(self.rings)
        self.inertia = np.array(
            [one["inertia"] for one in self.line["stations"]] + [_ring(one) for one in self.dampers]
        )
        self.gears = self.line.get("gears", [])
        self.rows: list[Array] = [self._row(*one["between"]) for one in self.line["shafts"]]
        self.sections = [one["name"] for one in self.line["shafts"]]
        rigid = []
        self.teeth = [one for one in self.gears if "mesh_stiffness" in one]
        self.ratio = self._ratios()
        for gear in self.gears:
            first, second = (self.names.index(name) for name in gear["between"])
            meets = np.zeros(self.count)
            meets[first], meets[second] = -_gear_ratio(gear), 1.0
            if gear in self.teeth:  # the twist on the shaft of the first wheel
                self.rows.append(meets / -_gear_ratio(gear))
                self.sections.append(gear["name"])
            else:
                rigid.append(meets)
        for place, damper in enumerate(self.dampers):
            row = np.zeros(self.count)
            row[self.names.index(damper["on"])], row[len(self.names) + place] = 1.0, -1.0
            self.rows.append(row)
            self.sections.append(damper["name"])
        self.network = np.array(self.rows)
        self.rigid = np.array(rigid).reshape(-1, self.count)
        self.basis = null_space(self.rigid) if rigid else np.eye(self.count)
        self.sense = np.sign(self.ratio)

    def _row(self, first: str, second: str) -> Array:
        row = np.zeros(self.count)
        row[self.names.index(first)], row[self.names.index(second)] = 1.0, -1.0
        return row

    def _ratios(self) -> Array:
        """Own speeds over that of the crankshaft, with their sign, along shafts and gears."""
        found = {self.line["stations"][0]["name"]: 1.0}
        joints = [(*one["between"], 1.0) for one in self.line["shafts"]]
        joints += [(*one["between"], _gear_ratio(one)) for one in self.gears]
        while len(found) < len(self.names):
            for first, second, ratio in joints:
                if first in found:
                    found.setdefault(second, found[first] * ratio)
                elif second in found:
                    found[first] = found[second] / ratio
        rings = [found[one["on"]] for one in self.dampers]
        return np.array([*(found[name] for name in self.names), *rings])

    # --- what varies -------------------------------------------------------

    def section_laws(self, speed: float, rate: Array, mean: Array) -> tuple[Array, Array]:
        """Complex stiffness (sections, m) without dashpots, and dashpots (sections,)."""
        stiffness, dashpot = [], []
        for place, one in enumerate(self.line["shafts"]):
            dashpot.append(one.get("damping", 0.0))
            if "coupling" in one:
                stiffness.append(_coupling(one["coupling"], rate, abs(mean[place])))
                continue
            loss = one.get("loss_factor", 0.0) + 2.0 * one.get("lehr_ratio", 0.0)
            loss += 1.0 / one["magnifier"] if "magnifier" in one else 0.0
            stiffness.append(np.full(len(rate), one["stiffness"] * (1.0 + 1j * loss)))
        for one in self.teeth:
            dashpot.append(0.0)
            size = one["mesh_stiffness"] * one["pitch_radius"] ** 2
            stiffness.append(np.full(len(rate), size + 0j))
        for place, one in enumerate(self.dampers):
            dashpot.append(one["damping"])
            own = one.get("stiffness", 0.0) * (1.0 + 1j * one.get("loss_factor", 0.0))
            if one["kind"] == "pendulum":
                turning = speed * self.ratio[len(self.names) + place]
                own = self.inertia[len(self.names) + place] * (one["order"] * turning) ** 2 + 0j
            stiffness.append(np.full(len(rate), own))
        return np.array(stiffness), np.array(dashpot)

    def absolute(self, speed: float) -> Array:
        """Absolute dampings of stations and rings."""
        found = np.zeros(self.count)
        for place, one in enumerate(self.line["stations"]):
            value = one.get("absolute_damping", 0.0)
            if law := one.get("over_speed"):
                value *= (speed / law["reference"]) ** law["exponent"]
            if "engine_damping" in self.line and "cylinder" in one:
                lowest = self.undamped(self.speed)[self._free_modes()]
                value += one["inertia"] * lowest / self.line["engine_damping"]["magnifier"]
            found[place] = value
        for load in self.line.get("loads", []):
            if "propeller_damping" in load:
                place = self.names.index(load["on"])
                rpm = speed * abs(self.ratio[place]) * 30.0 / np.pi
                a = load["propeller_damping"]["coefficient"]
                found[place] += a * self.taken(load, speed) / rpm
        return found

    def _free_modes(self) -> int:
        """Modes that do not vibrate: the line as a whole, and each ring in oil."""
        return 1 + sum(one["kind"] == "viscous" for one in self.dampers)

    def taken(self, load: Table, speed: float) -> float:
        return float(load["torque"] * (speed / self.speed) ** load["exponent"])

    # --- loads -------------------------------------------------------------

    def loads(self, speed: float, silent: tuple[str, ...]) -> tuple[Array, Array]:
        """Torques (stations + rings, m) in the sense of the angles, and their means."""
        order = self.given.order
        found = np.zeros((self.count, len(order)), dtype=complex)
        mean = np.zeros(self.count)
        for place, station in enumerate(self.line["stations"]):
            for one in self.train["cylinders"]:
                if station.get("cylinder") != one["name"]:
                    continue
                scale = one["pressure_scale"] * (one["name"] not in silent)
                torque = scale * self.given.gas + speed**2 * self.given.inertia
                found[place] += torque * np.exp(-1j * order * one["firing_angle"])
                mean[place] += scale * self.given.mean
        for load in self.line.get("loads", []):
            place = self.names.index(load["on"])
            mean[place] -= self.sense[place] * self.taken(load, speed)
        for place, at, torque in self.beside(speed):
            found[place, at] += self.sense[place] * torque
        last = self.names.index(self.line.get("load", self.names[-1]))
        mean[last] -= self.ratio @ mean / self.ratio[last]
        return found, mean

    def beside(self, speed: float) -> Iterator[tuple[int, int, complex]]:
        """Station, place of the order and torque of what is given at stations."""
        for one in self.line.get("excitations", []):
            place = self.names.index(one["on"])
            if "blades" in one:
                (load,) = [load for load in self.line["loads"] if load["on"] == one["on"]]
                multiples = one["blades"] * (1.0 + np.arange(len(one["shares"])))
                orders = multiples * abs(self.ratio[place])
                sizes = np.array(one["shares"]) * self.taken(load, speed)
            else:
                orders = np.array(one["orders"])
                sizes = np.array(one["torques"]) * (speed / self.speed) ** one["exponent"]
            for order, size, phase in zip(orders, sizes, one["phases"], strict=True):
                at = np.flatnonzero(np.abs(self.given.order - order) < 1e-9)
                if len(at):
                    yield place, int(at[0]), complex(size * np.exp(1j * phase))

    # --- solves ------------------------------------------------------------

    def at(self, speed: float, silent: tuple[str, ...] = ()) -> Solved:
        load, mean = self.loads(speed, silent)
        torque_mean, gear_mean = self.statics(speed, mean)
        rate = self.given.order * speed
        passing, dashpot = self.section_laws(speed, rate, torque_mean)
        whole = passing + 1j * rate * dashpot[:, None]
        absolute = self.absolute(speed)
        angle = np.empty(load.shape, dtype=complex)
        gear = np.empty((len(self.rigid), len(rate)), dtype=complex)
        for n, w in enumerate(rate):
            dynamic = np.diag(-(w**2) * self.inertia + 1j * w * absolute)
            dynamic = dynamic + self.network.T @ (whole[:, n, None] * self.network)
            reduced = self.basis.T @ dynamic @ self.basis
            angle[:, n] = self.basis @ np.linalg.solve(reduced, self.basis.T @ load[:, n])
            left = dynamic @ angle[:, n] - load[:, n]
            gear[:, n] = self._on_first_wheels(left)
        torque = whole * (self.network @ angle)
        return Solved(
            angle, torque, self._of_gears(gear, torque), torque_mean,
            self._of_gears(gear_mean, torque_mean), rate, passing,
        )  # fmt: skip

    def _on_first_wheels(self, left: Array) -> Array:
        """Torques of rigid gears on their first wheels, from what else is not in balance."""
        if not len(self.rigid):
            return np.zeros(0, dtype=left.dtype)
        passed = np.linalg.lstsq(self.rigid.T, left, rcond=None)[0]
        ratios = np.array([_gear_ratio(g) for g in self.gears if g not in self.teeth])
        return np.asarray(ratios * passed)

    def _of_gears(self, rigid: Array, sections: Array) -> Array:
        """All gears in their order; what elastic ones pass is the torque of their section."""
        found, next_rigid = [], iter(rigid)
        for one in self.gears:
            elastic = one in self.teeth
            found.append(
                sections[self.sections.index(one["name"])] if elastic else next(next_rigid)
            )
        return np.array(found)

    def statics(self, speed: float, mean: Array) -> tuple[Array, Array]:
        """Mean torques of sections and rigid gears."""
        springs = self.section_laws(speed, np.zeros(1), np.zeros(len(self.rows)))[0][:, 0].real
        whole = self.network.T @ (springs[:, None] * self.network)
        reduced = self.basis.T @ whole @ self.basis
        angle = self.basis @ np.linalg.pinv(reduced, rcond=1e-13) @ (self.basis.T @ mean)
        gear = self._on_first_wheels(whole @ angle - mean)
        return springs * (self.network @ angle), gear

    def undamped(self, speed: float) -> Array:
        """Natural frequencies in rad/s, ascending."""
        springs = self.section_laws(speed, np.zeros(1), np.zeros(len(self.rows)))[0][:, 0].real
        whole = self.network.T @ (springs[:, None] * self.network)
        basis = self.basis
        mass = basis.T @ (self.inertia[:, None] * basis)
        square = eigh(basis.T @ whole @ basis, mass, eigvals_only=True)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    # --- readings ----------------------------------------------------------

    def heat(self, now: Solved, speed: float) -> tuple[Array, Array]:
        """Mean power of sections and of absolute dampings of stations, W."""
        dashpot = self.section_laws(speed, now.frequency, now.torque_mean)[1]
        twist = np.abs(self.network @ now.angle) ** 2
        w = now.frequency
        sections = 0.5 * (w * now.stiffness.imag + w**2 * dashpot[:, None]) * twist
        stations = 0.5 * w**2 * self.absolute(speed)[:, None] * np.abs(now.angle) ** 2
        return sections.sum(axis=1), stations.sum(axis=1)[: len(self.names)]

    def ends(self, amplitude: Array) -> tuple[Array, Array]:
        """Lowest and highest value over the cycle of rows (n, m) of orders."""
        return -_highest(self.given.order, -amplitude), _highest(self.given.order, amplitude)

    def half_range(self, amplitude: Array) -> Array:
        low, high = self.ends(amplitude)
        return 0.5 * (high - low)


def _ring(damper: Table) -> float:
    if damper["kind"] != "pendulum":
        return float(damper["inertia"])
    reach = damper["arm_radius"] * (1.0 + 1.0 / damper["order"] ** 2)
    return float(damper["count"] * damper["mass"] * reach**2)


def _gear_ratio(gear: Table) -> float:
    """Speed of the second wheel over that of the first, negative where it reverses."""
    size = gear["teeth"][0] / gear["teeth"][1]
    return -size if gear.get("reverses", True) else size


def _coupling(given: Table, rate: Array, mean: float) -> Array:
    """k (1 + i psi / 2 pi) at frequencies, under a mean torque."""
    stiffness = np.full(len(rate), given["stiffness"])
    psi = np.full(len(rate), given["relative_damping"])
    if rows := given.get("over_mean_torque"):
        stiffness = stiffness * np.interp(mean, rows["torque"], rows["stiffness_factor"])
    if rows := given.get("over_frequency"):
        stiffness = stiffness * np.interp(rate, rows["frequency"], rows["stiffness_factor"])
        psi = psi * np.interp(rate, rows["frequency"], rows["relative_damping_factor"])
    return np.asarray(stiffness * (1.0 + 1j * psi / (2.0 * np.pi)))


def _highest(order: Array, amplitude: Array) -> Array:
    """Highest values over two turns: samples, then Newton's method from the eight highest."""
    angle = np.linspace(0.0, 4.0 * np.pi, 2048, endpoint=False)
    wave = np.exp(1j * np.outer(order, angle))
    signal = (amplitude @ wave).real
    at = angle[np.argsort(signal, axis=1)[:, -8:]]
    for _ in range(20):
        turned = amplitude[:, None] * np.exp(1j * at[..., None] * order)
        slope, bend = (turned @ (1j * order)).real, (turned @ -(order**2)).real
        step = np.where(bend < 0.0, slope / np.where(bend < 0.0, bend, -1.0), 0.0)
        at = at - np.clip(step, -5e-3, 5e-3)
    sharp = (amplitude[:, None] * np.exp(1j * at[..., None] * order)).sum(axis=-1).real
    return np.asarray(np.maximum(sharp.max(axis=1), signal.max(axis=1)))
