"""A body on its mounts from the equations of motion alone: dense solves, sums over the cycle.

Like `dense_train.py` it shares nothing with the program but the table of a case, in SI. Each order
is one solve of all coordinates, and peaks are sought in time.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from dense_train import TURN, XYZ, Table
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq


def skew(vector: np.ndarray) -> np.ndarray:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def arm(place: Any) -> np.ndarray:
    """Displacement (3, 6) of a place by translation and rotation: t + r x p."""
    return np.hstack([np.eye(3), -skew(np.asarray(place, dtype=float))])


def monotone(at: Sequence[float], values: Sequence[float]) -> CubicHermiteSpline:
    """Monotone cubic through rows (Fritsch and Butland 1984), level at its ends."""
    x, y = np.array(at), np.array(values)
    step, slope = np.diff(x), np.diff(y) / np.diff(x)
    bent = np.zeros(len(x))
    for i in range(1, len(x) - 1):
        first, second = 2 * step[i] + step[i - 1], step[i] + 2 * step[i - 1]
        if slope[i - 1] * slope[i] > 0.0:
            bent[i] = (first + second) / (first / slope[i - 1] + second / slope[i])
    return CubicHermiteSpline(x, y, bent)


def level(at: Sequence[float], values: Sequence[float], place: Any) -> np.ndarray:
    """The same at places, beyond its ends as at them."""
    return np.asarray(monotone(at, values)(np.clip(place, at[0], at[-1])))


# ----------------------------------------------------------------------------
# The body on its mounts.
# ----------------------------------------------------------------------------


class Solid:
    """Mass, centre and mass matrix about the reference point of a body or of its parts."""

    def __init__(self, body: Table):
        parts = body.get("parts") or [{"centre": np.zeros(3), **body}]
        if "inertia_block" in body:
            block = body["inertia_block"]
            parts.append({**block, "centre": block["position"]})
        self.mass = sum(part["mass"] for part in parts)
        self.matrix = np.zeros((6, 6))
        moment = np.zeros(3)
        for part in parts:
            mass, centre = part["mass"], np.array(part["centre"])
            if "box" in part:
                edges = np.array([part["box"][key] for key in ("length", "width", "height")])
                own = np.diag(mass / 12.0 * (edges @ edges - edges**2))
            else:
                xy, xz, yz = part.get("inertia_products", (0.0, 0.0, 0.0))
                own = np.diag(part["inertia"]) - np.array(
                    [[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]]
                )
            reach = arm(centre)
            self.matrix += mass * reach.T @ reach
            self.matrix[3:, 3:] += own
            moment += mass * centre
        self.centre = moment / self.mass
        #: about the mass centre
        to_centre = np.eye(6)
        to_centre[:3] = arm(-self.centre)
        self.central = to_centre.T @ self.matrix @ to_centre


class Springs:
    """Mounts (n,): places, stiffness and damping (n, 3, 3), what each does at rest."""

    def __init__(self, mounts: Table, up: np.ndarray):
        each = mounts.get("each", {})
        entries = [{"position": p} for p in mounts.get("positions", ())] or mounts["individual"]
        self.entries: list[Table] = [{**each, **one} for one in entries]
        self.names = [one.get("name", str(n + 1)) for n, one in enumerate(self.entries)]
        datum = np.array(mounts.get("datum", np.zeros(3)))
        self.place = np.array([one["position"] for one in self.entries]) + datum
        self.arms = np.array([arm(place) for place in self.place])
        turn = np.array([_turned(one.get("orientation", np.zeros(3))) for one in self.entries])
        self.axis = turn[:, :, int(np.argmax(up))]
        self.damping, self.stiffness = (
            np.einsum("nij,nj,nkj->nik", turn, self._three(key), turn)
            for key in ("damping", "stiffness")
        )
        self.static = self.stiffness
        self.follows_load = any("static" in one for one in self.entries)

    def _three(self, key: str) -> np.ndarray:
        return np.array([np.broadcast_to(one.get(key, 0.0), 3) for one in self.entries], float)

    def passing(self, rate: np.ndarray) -> np.ndarray:
        """Complex stiffness (m, n, 3, 3) of each mount at frequencies (m,) in rad/s."""
        factor = np.stack([_at_frequency(one, rate) for one in self.entries], axis=-1)
        viscous = 1j * rate[:, None, None, None] * self.damping
        return factor[:, :, None, None] * self.stiffness + viscous

    def settle(self, weight: np.ndarray) -> np.ndarray:
        """Rest (6,) of a body under a load; mounts that follow it take the stiffness of it."""
        outer = self.axis[:, :, None] * self.axis[:, None, :]
        along = np.einsum("ni,nij,nj->n", self.axis, self.stiffness, self.axis)
        across = self.stiffness - along[:, None, None] * outer
        given = [one.get("static", {}) for one in self.entries]
        ratio = np.array([one.get("dynamic_to_static", 1.0) for one in given])
        square = across / ratio[:, None, None]
        laws = [_Law(*each) for each in zip(given, along / ratio, strict=True)]
        rest = np.zeros(6)
        for _ in range(200):
            moved = self.arms @ rest
            u = -np.einsum("ni,ni->n", self.axis, moved)
            load, slope = np.array([law(x) for law, x in zip(laws, u, strict=True)]).T
            tangent = square + slope[:, None, None] * outer
            force = np.einsum("nij,nj->ni", square, moved) - load[:, None] * self.axis
            left = weight - np.einsum("nij,ni->j", self.arms, force)
            step = np.linalg.solve(self.whole(tangent), left)
            rest = rest + step
            if np.all(np.abs(self.arms @ step) <= 1e-15 * np.abs(moved).max()):
                break
        self.rest_force, self.load, self.deflection = force, load, u
        self.static, self.slope, self.laws = tangent, slope, laws
        if self.follows_load:
            self._about_the_rest(laws, ratio, along, across, outer)
        return rest

    def _about_the_rest(self, laws: Any, ratio: Any, along: Any, across: Any, outer: Any) -> None:
        for n, (one, law) in enumerate(zip(self.entries, laws, strict=True)):
            if rows := one.get("over_load"):
                factor = float(level(rows["load"], rows["stiffness_factor"], self.load[n]))
                along[n], across[n] = along[n] * factor, across[n] * factor
            elif law.bends:
                along[n] = ratio[n] * law.own(self.deflection[n])[1]
            along[n] += law.stop(self.deflection[n])[1]
        self.stiffness = across + along[:, None, None] * outer

    def whole(self, each: np.ndarray) -> np.ndarray:
        """Sum (..., 6, 6) of stiffnesses (..., n, 3, 3) of the mounts."""
        return summed(self.arms, each)

    def to_stop(self, deepest: np.ndarray, highest: np.ndarray) -> np.ndarray:
        """Distance (n,) to the nearer stop of compressions (n,)."""
        pairs = zip(self.laws, deepest, highest, strict=True)
        return np.array([min(law.down - u, v + law.up) for law, u, v in pairs])


class _Law:
    """Load and its slope over the compression of a mount at rest."""

    def __init__(self, given: Table, linear: float):
        rows = given.get("load_deflection")
        self.linear, self.cubic = linear, given.get("cubic_stiffness", 0.0)
        self.rows = monotone(rows["deflection"], rows["load"]) if rows else None
        self.bends = bool(rows or self.cubic)
        stops = given.get("stops", {})
        self.down, self.up = stops.get("down", np.inf), stops.get("up", np.inf)
        self.hard = stops.get("stiffness", 0.0)

    def own(self, u: float) -> tuple[float, float]:
        if self.rows is not None:
            return float(self.rows(u)), float(self.rows(u, 1))
        return self.linear * u + self.cubic * u**3, self.linear + 3.0 * self.cubic * u**2

    def stop(self, u: float) -> tuple[float, float]:
        """What a stop adds."""
        deep = u - self.down if u > self.down else min(u + self.up, 0.0)
        return self.hard * deep if deep else 0.0, self.hard * bool(deep)

    def __call__(self, u: float) -> tuple[float, float]:
        (load, slope), (more, harder) = self.own(u), self.stop(u)
        return load + more, slope + harder


def _turned(angles: Any) -> np.ndarray:
    """Rotation about x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def _at_frequency(entry: Table, rate: np.ndarray) -> np.ndarray:
    """Complex factor (m,) on the stiffness."""
    rows = entry.get("over_frequency")
    if rows is None:
        return np.full(len(rate), complex(1.0, entry.get("loss_factor", 0.0)))
    factor, loss = (
        level(rows["frequency"], rows[key], rate) for key in ("stiffness_factor", "loss_factor")
    )
    return np.asarray(factor * (1.0 + 1j * loss))


def summed(reach: np.ndarray, each: np.ndarray) -> np.ndarray:
    """Sum (..., k, k) of matrices (..., n, 3, 3) that a motion reaches by (n, 3, k)."""
    columns = each @ reach
    flat = columns.reshape(*columns.shape[:-3], -1, reach.shape[-1])
    return np.asarray(reach.reshape(-1, reach.shape[-1]).T @ flat)


class Moved(NamedTuple):
    """Amplitudes by order (m, ...): of the body and of what it stands on (6,), of feet, deflection
    and force (mounts, 3) of the mounts, and the load (6,) on the ground, about the same point."""

    body: np.ndarray
    below: np.ndarray
    foot: np.ndarray
    deflection: np.ndarray
    force: np.ndarray
    ground: np.ndarray


class OnMounts:
    """A body on mounts on rigid ground, a mass or a body on springs, or tables over frequency.

    Twelve coordinates: those of the body and of what the mounts stand on, each about its own
    reference point. `free` are those that move.
    """

    def __init__(self, case: Table, rigid_ground: bool = False):
        options, machine = case["isolation"], case["machine"]
        self.up = np.eye(3)[XYZ.index(options.get("up", "z"))]
        self.solid, self.mounts = Solid(machine["body"]), Springs(machine["mounts"], self.up)
        pull = -options.get("gravity", 9.80665) * self.solid.mass * self.up
        self.weight = np.concatenate([pull, np.cross(self.solid.centre, pull)])
        self.rest = self.mounts.settle(self.weight)
        given = {} if rigid_ground else case.get("foundation", {})
        self.tables: list[Table] = given.get("flexibilities", [])
        self.springs = Springs(given["springs"], self.up) if "springs" in given else None
        self.place = np.array(given.get("position", np.zeros(3)))
        self.mass = np.zeros((12, 12))
        self.mass[:6, :6] = self.solid.matrix
        self.free = np.arange(6)
        if self.springs is not None:
            self.mass[6:, 6:] = Solid(given["body"]).matrix
            self.free = np.arange(12)
        #: where a mass on a spring moves, which does so up and down only
        self.floor = 6 + int(np.argmax(self.up))
        self.below_floor = given if "mass" in given else None
        if self.below_floor is not None:
            self.mass[self.floor, self.floor] = given["mass"]
            self.free = np.append(self.free, self.floor)
        plate = ["x", "y", "z", "rx", "ry", "rz"]
        self.plate = {
            6 + plate.index(one["direction"]): one
            for one in self.tables
            if one.get("at") == "whole"
        }
        if self.plate:
            self.free = np.append(self.free, sorted(self.plate))
        below = np.array([arm(place - self.place) for place in self.mounts.place])
        self.stretch = np.concatenate([self.mounts.arms, -below], axis=-1)
        self.below = below
        #: the foundation moving with the body as one
        self.rigid = np.vstack([np.eye(6), np.eye(6)])
        self.rigid[6:9] = arm(self.place)

    def _feet(self, rate: np.ndarray) -> np.ndarray:
        """Flexibility (m, mounts, 3) under each mount."""
        names = self.mounts.names
        soft = np.zeros((len(rate), len(names), 3), dtype=complex)
        for one in self.tables:
            if one.get("at") != "whole":
                which = [name in one.get("mounts", names) for name in names]
                soft[:, which, XYZ.index(one["direction"])] = 1.0 / _table_at(one, rate)[:, None]
        return soft

    def parts(self, rate: np.ndarray) -> tuple[np.ndarray, ...]:
        """Complex stiffness (m, 12, 12), that of mount and foot in series, flexibility of feet."""
        soft, passing = self._feet(rate), self.mounts.passing(rate)
        series = passing
        if self.tables:
            series = np.linalg.solve(np.eye(3) + passing * soft[..., None, :], passing)
        stiff = summed(self.stretch, series)
        if self.springs is not None:
            stiff[:, 6:, 6:] += self.springs.whole(self.springs.passing(rate))
        stiff[:, self.floor, self.floor] += self._under_floor(rate)
        for place, one in self.plate.items():
            stiff[:, place, place] += _table_at(one, rate)
        return stiff, series, soft

    def _under_floor(self, rate: np.ndarray) -> np.ndarray:
        """Dynamic stiffness (m,) of the spring below a mass."""
        given = self.below_floor or {"stiffness": 0.0}
        loss = 1.0 + 1j * given.get("loss_factor", 0.0)
        return np.asarray(given["stiffness"] * loss + 1j * rate * given.get("damping", 0.0))

    def moved(self, rate: np.ndarray, load: np.ndarray) -> Moved:
        """Under loads (m, 6) on the body at frequencies (m,) in rad/s."""
        stiff, series, soft = self.parts(rate)
        force = np.concatenate([load, np.zeros(load.shape)], axis=-1)
        return self._at_mounts(rate, self._solve(rate, stiff, force), series, soft)

    def _solve(self, rate: np.ndarray, stiff: np.ndarray, force: np.ndarray) -> np.ndarray:
        motion = np.zeros((len(rate), 12), dtype=complex)
        few = (slice(None), self.free[:, None], self.free)
        dynamic = (stiff - np.square(rate)[:, None, None] * self.mass)[few]
        found = np.linalg.solve(dynamic, force[:, self.free, None])
        motion[:, self.free] = found[..., 0]
        return motion

    def _at_mounts(
        self, rate: np.ndarray, motion: np.ndarray, series: np.ndarray, soft: np.ndarray
    ) -> Moved:
        column = motion[:, None, :, None]
        force = (series @ (self.stretch @ column))[..., 0]
        foot = (self.below @ column[..., 6:, :])[..., 0] + soft * force
        deflection = (self.mounts.arms @ column[..., :6, :])[..., 0] - foot
        if self.springs is None:
            ground = (self.mounts.arms.mT @ force[..., None])[..., 0].sum(axis=1)
            if self.below_floor is not None:
                ground[:, self.floor - 6] = self._under_floor(rate) * motion[:, self.floor]
        else:
            held = self.springs.whole(self.springs.passing(rate))
            ground = (held @ motion[:, 6:, None])[..., 0] @ self.rigid[6:]
        return Moved(motion[:, :6], motion[:, 6:], foot, deflection, force, ground)

    def on_base(self, rate: np.ndarray, base: np.ndarray) -> tuple[np.ndarray, ...]:
        """Motion (m, 12), the same against the base, deflection and force of the mounts.

        The base moves by (m, 6) with what stands on it, mounts or the springs of the foundation.
        """
        stiff, series, _ = self.parts(rate)
        carried = base @ self.rigid.T
        if self.springs is None:
            carried[:, 6:] = 0.0
            series = self.mounts.passing(rate)
        force = (stiff @ carried[..., None])[..., 0]
        motion = self._solve(rate, stiff, force)
        against = motion - carried
        deflection = (self.stretch @ against[:, None, :, None])[..., 0]
        return motion, against, deflection, (series @ deflection[..., None])[..., 0]

    def constant(self, couple: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Deflection and force (mounts, 3) of the mounts under a couple (3,) that stays."""
        load = np.concatenate([np.zeros(3), couple])
        still = np.linalg.solve(self.mounts.whole(self.mounts.static), load)
        deflection = self.mounts.arms @ still
        return deflection, (self.mounts.static @ deflection[..., None])[..., 0]

    def matrices(self, rate: float = 0.0) -> tuple[np.ndarray, ...]:
        """Mass, stiffness, loss and damping of the free coordinates, without tables."""
        few = np.ix_(self.free, self.free)
        stiff = self.parts(np.array([rate]))[0][0][few]
        damping = summed(self.stretch, self.mounts.damping)
        if self.springs is not None:
            damping[6:, 6:] += self.springs.whole(self.springs.damping)
        if self.below_floor is not None:
            damping[self.floor, self.floor] += self.below_floor.get("damping", 0.0)
        damping = damping[few]
        return self.mass[few], stiff.real, stiff.imag - rate * damping, damping

    def modes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Natural frequencies, shapes (modes, coordinates) of unit modal mass, damping ratios."""
        mass, _, _, damping = self.matrices()
        root = np.linalg.inv(np.linalg.cholesky(mass))

        def solved(rate: float) -> tuple[np.ndarray, np.ndarray]:
            squares, vectors = np.linalg.eigh(root @ self.matrices(rate)[1] @ root.T)
            return np.sqrt(np.maximum(squares, 0.0)), (root.T @ vectors).T

        frequency, shapes = solved(0.0)
        if any("over_frequency" in one for one in self.mounts.entries):
            top = 2.0 * solved(1e9)[0][-1]
            for mode in range(len(frequency)):
                frequency[mode] = brentq(
                    lambda w, m=mode: solved(w)[0][m] - w, 0.0, top, xtol=1e-14, rtol=1e-14
                )
                shapes[mode] = solved(frequency[mode])[1][mode]
        ratio = []
        for w, v in zip(frequency, shapes, strict=True):
            loss = self.matrices(w)[2]
            ratio.append(v @ damping @ v / (2.0 * w) + v @ loss @ v / (2.0 * w**2))
        return frequency, shapes, np.array(ratio)


def _table_at(one: Table, rate: np.ndarray) -> np.ndarray:
    """Dynamic stiffness (m,): parts straight between rows, and level beyond them."""
    keys = ("dynamic_stiffness", "impedance", "angular_dynamic_stiffness", "angular_impedance")
    key = next(key for key in keys if key in one)
    rows = one[key]
    real, imaginary = (np.interp(rate, rows["frequency"], rows[k]) for k in ("real", "imaginary"))
    value = real + 1j * imaginary
    return np.asarray(1j * rate * value if key.endswith("impedance") else value)


# ----------------------------------------------------------------------------
# Over the cycle.
# ----------------------------------------------------------------------------


#: highest samples from which a peak is climbed
CANDIDATES = 8


def over_cycle(harmonics: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest value (...) over the cycle of signals (..., orders)."""
    ends = [_highest(sign * harmonics, order) for sign in (-1.0, 1.0)]
    return -ends[0], ends[1]


def _highest(harmonics: np.ndarray, order: np.ndarray) -> np.ndarray:
    found = [_top(one[None], order, signed=True) for one in harmonics.reshape(-1, len(order))]
    return np.array(found).reshape(harmonics.shape[:-1])


def longest(vector: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Largest length (...) over the cycle of vectors (..., components, orders)."""
    flat = vector.reshape(-1, *vector.shape[-2:])
    return np.array([_top(one, order) for one in flat]).reshape(vector.shape[:-2])


def peak(harmonics: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Largest magnitude (...) over the cycle of signals (..., orders)."""
    return longest(harmonics[..., None, :], order)


def _top(vector: np.ndarray, order: np.ndarray, signed: bool = False) -> float:
    """Of one vector (components, orders), or of a signal with its sign: samples, then Newton."""
    step = 0.5 if np.any(np.abs(order % 1.0 - 0.5) < 1e-9) else 1.0
    number = np.rint(order / step).astype(int)
    count = int(2 ** np.ceil(np.log2(32 * number[-1] + 32)))
    spectrum = np.zeros((len(vector), count // 2 + 1), dtype=complex)
    spectrum[:, number] = 0.5 * count * vector
    signal = np.fft.irfft(spectrum, count, axis=-1)
    height = signal[0] if signed else (signal**2).sum(axis=0)
    near = np.flatnonzero((height >= np.roll(height, 1)) & (height >= np.roll(height, -1)))
    angle, width = TURN * near[np.argsort(-height[near])[:CANDIDATES]] / count, TURN / count

    def at(place: np.ndarray) -> tuple[np.ndarray, ...]:
        turned = np.exp(1j * np.outer(number, place))
        parts = [(vector * (1j * number) ** n @ turned).real for n in range(3)]
        if signed:
            return parts[0][0], parts[1][0], parts[2][0]
        x, v, a = parts
        return (x * x).sum(0), 2.0 * (x * v).sum(0), 2.0 * (v * v + x * a).sum(0)

    best = float(height.max())
    place = angle.copy()
    for _ in range(4):
        value, slope, bend = at(place)
        best = max(best, float(value.max()))
        move = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), 0.0)
        place = np.clip(place + move, angle - width, angle + width)
    return best if signed else float(np.sqrt(best))
