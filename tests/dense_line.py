"""A shaft line from the equations of motion alone: own angles, full matrices, gears as constraints.

It shares nothing with the program but the table of a case, in SI, and the torque of one cylinder
by order. Nothing is referred to the crankshaft: rigid gears are equations between angles, whose
torques are their multipliers; each order is one solve.
"""

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
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
    mean: float = 0.0


def cylinder_of(record: Mapping[str, Any], case: Table) -> Cylinder:
    """The one of a run: its mean torque is the work of the indicated pressure."""
    train, machine, path = (
        case["machine"]["crank_train"],
        case["machine"],
        "response/torsion/excitation/",
    )
    gas, inertia = (record[path + one] for one in ("gas", "inertia"))
    turns = 2.0 if machine["cycle"] == "four_stroke" else 1.0
    stroke = np.pi * train["bore"] ** 2 / 4.0 * 2.0 * train["crank_radius"]
    mean = float(record[path + "mean_indicated_pressure"].values) * stroke / (2.0 * np.pi * turns)
    order = np.array(gas.axes[-1].values, dtype=float)
    return Cylinder(order, gas.values, inertia.values / machine["speed"] ** 2, mean)


class Conditions(NamedTuple):
    """What a coupling is taken at: mean torque and half range in N m, temperature in K."""

    mean: float = 0.0
    temperature: float = 0.0
    amplitude: float = 0.0


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

    def __init__(self, case: Table, cylinder: Callable[[float], Cylinder] | None = None):
        machine = case["machine"]
        self.line, self.train = machine["shaft_line"], machine.get("crank_train", {})
        self.cycle = (4.0 if machine.get("cycle") == "four_stroke" else 2.0) * np.pi
        self.cylinder, self.speed = cylinder, machine["speed"]
        self.names = [one["name"] for one in self.line["stations"]]
        self.dampers = self.line.get("dampers", [])
        self.rings = [one["name"] for one in self.dampers]
        self.count = len(self.names) + len(self.rings)
        self.inertia = np.array(
            [one["inertia"] for one in self.line["stations"]] + [_ring(one) for one in self.dampers]
        )
        self.ground = np.zeros(self.count)
        self.ground[: len(self.names)] = [
            one.get("ground_stiffness", 0.0) for one in self.line["stations"]
        ]
        self.gears = self.line.get("gears", [])
        rows = zip(self.line["shafts"], pairwise(self.names), strict=False)
        self.between = [one.get("between") or pair for one, pair in rows]
        self.between += [one["between"] for one in self.line["shafts"][len(self.between) :]]
        self.rows: list[Array] = [self._row(*pair) for pair in self.between]
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
        found = {self.line.get("speed_of", self.names[0]): 1.0}
        joints = [(*pair, 1.0) for pair in self.between]
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

    def section_laws(
        self, speed: float, rate: Array, mean: Array, now: Conditions | None = None
    ) -> tuple[Array, Array]:
        """Complex stiffness (sections, m) without dashpots, and dashpots (sections,)."""
        stiffness, dashpot = [], []
        for place, one in enumerate(self.line["shafts"]):
            law = self._law(one, self.between[place][0], speed)
            dashpot.append(law * one.get("damping", 0.0))
            if "coupling" in one:
                at = now or Conditions(mean[place])
                stiffness.append([_coupling(one["coupling"], w, at) for w in rate])
                continue
            loss = one.get("loss_factor", 0.0) + 2.0 * one.get("lehr_ratio", 0.0)
            loss += 1.0 / one["magnifier"] if "magnifier" in one else 0.0
            stiffness.append(np.full(len(rate), _shaft(one) * (1.0 + 1j * law * loss)))
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
            value = self._law(one, one["name"], speed) * one.get("absolute_damping", 0.0)
            if "engine_damping" in self.line and "cylinder" in one:
                engine = self.line["engine_damping"]
                mode = engine["mode"] - 1 if "mode" in engine else self._free_modes()
                size = self.undamped(self.speed)[mode] * self._law(engine, one["name"], speed)
                value += one["inertia"] * size / engine["magnifier"]
            found[place] = value
        for load in self.line.get("absorbed_torques", []):
            if "propeller_damping" in load:
                place, given = self.names.index(load["on"]), load["propeller_damping"]
                own = speed * abs(self.ratio[place])
                # Archer's a T / n, n in rpm, or a multiple of T / w
                unit = np.pi / 30.0 if given["method"] == "archer" else 1.0
                found[place] += unit * given["coefficient"] * self.taken(load, speed) / own
        return found

    def _law(self, given: Table, on: str, speed: float) -> float:
        """Factor on a damping at a crank speed: 1 without a law, by a power or by rows."""
        if not (law := given.get("over_speed")):
            return 1.0
        if law.get("of") == "own":
            speed = speed * abs(self.ratio[self.names.index(on)])
        if rows := law.get("table"):
            return float(np.interp(speed, rows["speed"], rows["factor"]))
        return float((speed / law["reference"]) ** law["exponent"])

    def _free_modes(self) -> int:
        """Modes that do not vibrate: the line as a whole, and each ring in oil."""
        return 1 + sum(one["kind"] == "viscous" for one in self.dampers)

    def taken(self, load: Table, speed: float) -> float:
        if rows := load.get("curve"):
            return float(np.interp(speed, rows["speed"], rows["torque"]))
        return float(load["torque"] * (speed / self.speed) ** load["exponent"])

    # --- loads -------------------------------------------------------------

    def loads(self, speed: float, scales: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Orders, torques (stations + rings, m) in the sense of the angles, and their means."""
        assert self.cylinder is not None
        one = self.cylinder(speed)
        found = np.zeros((self.count, len(one.order)), dtype=complex)
        mean = np.zeros(self.count)
        for place, station in enumerate(self.line["stations"]):
            if name := station.get("cylinder"):
                given, angle = self.fires(name)
                scale = given * scales.get(name, 1.0)
                torque = scale * one.gas + speed**2 * one.inertia
                found[place] += torque * np.exp(-1j * one.order * angle)
                mean[place] += scale * one.mean
        for load in self.line.get("absorbed_torques", []):
            place = self.names.index(load["on"])
            mean[place] -= self.sense[place] * self.taken(load, speed)
        for place, order, torque in self.beside(speed):
            found[place, np.abs(one.order - order) < 1e-9] += self.sense[place] * torque
        last = self.names.index(self.line.get("balanced_by", self.names[-1]))
        mean[last] -= self.ratio @ mean / self.ratio[last]
        return one.order, found, mean

    def fires(self, name: str) -> tuple[float, float]:
        """Factor on the pressure and firing angle of a cylinder."""
        (one,) = [one for one in self.train["cylinders"] if one["name"] == name]
        if row := self.train.get("firing_order"):
            angle = self.cycle * row.index(name) / len(row)
        else:
            angle = one.get("firing_angle", -one.get("crank_phase", 0.0) % self.cycle)
        return one.get("pressure_scale", 1.0), angle

    def beside(self, speed: float) -> Iterator[tuple[int, float, complex]]:
        """Station, order and torque of what is given at stations."""
        for one in self.line.get("excitations", []):
            place = self.names.index(one["on"])
            if "blades" in one:
                (load,) = [
                    load for load in self.line["absorbed_torques"] if load["on"] == one["on"]
                ]
                multiples = one["blades"] * (1.0 + np.arange(len(one["shares"])))
                orders = multiples * abs(self.ratio[place])
                sizes = np.array(one["shares"]) * self.taken(load, speed)
            else:
                orders = np.array(one["orders"])
                sizes = np.array(one["torques"]) * (speed / self.speed) ** one["exponent"]
            for order, size, phase in zip(orders, sizes, one["phases"], strict=True):
                yield place, order, complex(size * np.exp(1j * phase))

    # --- solves ------------------------------------------------------------

    def at(self, speed: float, scales: Mapping[str, float] | None = None) -> Solved:
        """Under all torques of the case, those of gas times factors by cylinder."""
        order, load, mean = self.loads(speed, scales or {})
        return self.under(speed, order * speed, load, mean)

    def under(
        self, speed: float, rate: Array, load: Array, mean: Array, now: Conditions | None = None
    ) -> Solved:
        """Under torques (stations + rings, m) at frequencies (m,) and their means."""
        torque_mean, gear_mean = self.statics(speed, mean)
        passing, dashpot = self.section_laws(speed, rate, torque_mean, now)
        whole = passing + 1j * rate * dashpot[:, None]
        absolute = self.absolute(speed)
        angle = np.empty(load.shape, dtype=complex)
        gear = np.empty((len(self.rigid), len(rate)), dtype=complex)
        for n, w in enumerate(rate):
            dynamic = np.diag(self.ground - w**2 * self.inertia + 1j * w * absolute)
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

    def alone(self, w: float, station: str, amplitude: complex) -> Solved:
        """Under one torque at one frequency, positive as its station turns."""
        place, load = self.names.index(station), np.zeros((self.count, 1), dtype=complex)
        load[place] = amplitude * self.sense[place]
        return self.under(self.speed, np.array([w]), load, np.zeros(self.count))

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
        whole = np.diag(self.ground) + self.network.T @ (springs[:, None] * self.network)
        reduced = self.basis.T @ whole @ self.basis
        angle = self.basis @ np.linalg.pinv(reduced, rcond=1e-13) @ (self.basis.T @ mean)
        gear = self._on_first_wheels(whole @ angle - mean)
        return springs * (self.network @ angle), gear

    def undamped(self, speed: float, w: float = 0.0, now: Conditions | None = None) -> Array:
        """Natural frequencies in rad/s, ascending, with couplings as they are at a frequency."""
        rate, none = np.array([w]), np.zeros(len(self.rows))
        springs = self.section_laws(speed, rate, none, now)[0][:, 0].real
        whole = np.diag(self.ground) + self.network.T @ (springs[:, None] * self.network)
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


def ends(order: Array, amplitude: Array) -> tuple[Array, Array]:
    """Lowest and highest value over two turns of rows (..., m) of orders."""
    return -_highest(order, -amplitude), _highest(order, amplitude)


def half_range(order: Array, amplitude: Array) -> Array:
    low, high = ends(order, amplitude)
    return np.asarray(0.5 * (high - low))


def _ring(damper: Table) -> float:
    if damper["kind"] != "pendulum":
        return float(damper["inertia"])
    reach = damper["arm_radius"] * (1.0 + 1.0 / damper["order"] ** 2)
    return float(damper["count"] * damper["mass"] * reach**2)


def _gear_ratio(gear: Table) -> float:
    """Speed of the second wheel over that of the first, negative where it reverses."""
    size = gear["ratio"] if "ratio" in gear else gear["teeth"][0] / gear["teeth"][1]
    return -size if gear.get("reverses", True) else size


def _shaft(given: Table) -> float:
    """Stiffness, as given or of a round section."""
    if "stiffness" in given:
        return float(given["stiffness"])
    of = given["section"]
    second = np.pi * (of["outer_diameter"] ** 4 - of["inner_diameter"] ** 4) / 32.0
    return float(of["shear_modulus"] * second / of["length"])


def _coupling(given: Table, frequency: float, now: Conditions) -> complex:
    """k (1 + i psi / 2 pi) at a frequency in rad/s: rows are linear, constant beyond their ends."""
    found = {"stiffness": given.get("stiffness"), "relative_damping": given.get("relative_damping")}
    factor = dict.fromkeys(found, 1.0)
    for key, axis, x in (
        ("over_mean_torque", "torque", abs(now.mean)),
        ("over_temperature", "temperature", now.temperature),
        ("over_frequency", "frequency", frequency),
        ("over_amplitude", "torque", now.amplitude),
    ):
        rows = given.get(key, {})
        for name in found:
            if name in rows:
                found[name] = np.interp(x, rows[axis], rows[name])
            elif f"{name}_factor" in rows:
                factor[name] *= np.interp(x, rows[axis], rows[f"{name}_factor"])
    k, psi = (found[name] * factor[name] for name in ("stiffness", "relative_damping"))
    return complex(k * (1.0 + 1j * psi / (2.0 * np.pi)))


def _highest(order: Array, amplitude: Array) -> Array:
    """Highest values over two turns: samples, then Newton's method from the eight highest."""
    angle = np.linspace(0.0, 4.0 * np.pi, 2048, endpoint=False)
    wave = np.exp(1j * np.outer(order, angle))
    signal = (amplitude @ wave).real
    at = angle[np.argsort(signal, axis=-1)[..., -8:]]
    for _ in range(20):
        turned = amplitude[..., None, :] * np.exp(1j * at[..., None] * order)
        slope, bend = (turned @ (1j * order)).real, (turned @ -(order**2)).real
        step = np.where(bend < 0.0, slope / np.where(bend < 0.0, bend, -1.0), 0.0)
        at = at - np.clip(step, -5e-3, 5e-3)
    sharp = (amplitude[..., None, :] * np.exp(1j * at[..., None] * order)).sum(axis=-1).real
    return np.asarray(np.maximum(sharp.max(axis=-1), signal.max(axis=-1)))
