"""The shipped two-stroke engines computed in time from the text of their cases alone.

Units are read here, the torque of a cylinder is a discrete Fourier transform of pressure and piston
speed. Of the package only the computed pressure card is used.
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.case.load import load_case
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.excitation.model import gas_cards

CASES = Path(__file__).resolve().parents[1] / "cases"
SAMPLES = 1 << 13
UNITS = {
    "kg*m^2": 1.0, "t*m^2": 1e3, "kg": 1.0, "N*m*s/rad": 1.0, "kN*m*s/rad": 1e3, "MN*m/rad": 1e6,
    "kN*m/rad": 1e3, "mm": 1e-3, "m": 1.0, "rpm": np.pi / 30.0, "deg": np.pi / 180.0, "s": 1.0,
}  # fmt: skip


def number(text: Any) -> float:
    """A value in SI units; what is not said is zero."""
    value, _, unit = str(text or "0 kg").partition(" ")
    return float(value) * UNITS[unit]


class Engine(NamedTuple):
    """n freedoms, rings last; e sections, rings' springs last; c cylinders on the first freedoms.

    `gas` (orders + 1,) of one cylinder over its own angle, the mean first; `phase` (c,) rad.
    """

    inertia: np.ndarray
    link: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    absolute: np.ndarray
    speed: float
    mass: float
    radius: float
    rod: float
    phase: np.ndarray
    gas: np.ndarray

    @property
    def k(self) -> np.ndarray:
        return self.link.T @ (self.stiffness[:, None] * self.link)

    @property
    def c(self) -> np.ndarray:
        return self.link.T @ (self.damping[:, None] * self.link) + np.diag(self.absolute)

    def slope(self, angle: np.ndarray) -> np.ndarray:
        """ds/dtheta of a piston, m."""
        root = np.sqrt(self.rod**2 - (self.radius * np.sin(angle)) ** 2)
        return self.radius * np.sin(angle) * (1.0 + self.radius * np.cos(angle) / root)

    def shaken(self) -> np.ndarray:
        """Harmonics (orders + 1,) of the inertia torque of one cylinder over speed squared."""
        own = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
        wave = np.fft.rfft(self.slope(own))
        bend = np.fft.irfft(1j * np.arange(len(wave)) * wave, SAMPLES)
        found = np.fft.rfft(-self.mass * self.slope(own) * bend) * 2.0 / SAMPLES
        return np.append(0.0, found[1 : len(self.gas)])

    def torques(self, angle: np.ndarray, silent: int = -1) -> np.ndarray:
        """Gas and mean-speed inertia torque (c, t) of the kept orders at crank angles (t,)."""
        order = np.arange(len(self.gas))
        inertial = self.speed**2 * self.shaken()
        turned = np.exp(1j * order[:, None] * (angle + self.phase[:, None, None]))
        fires = (np.arange(len(self.phase)) != silent)[:, None]
        total = fires * self.gas + inertial
        return np.einsum("ck,ckt->ct", total, turned).real


@cache
def text_of(name: str) -> dict[str, Any]:
    return tomllib.loads((CASES / name).read_text(encoding="utf-8"))


@cache
def engine(name: str) -> Engine:
    case = text_of(name)
    machine, train = case["machine"], case["machine"]["crank_train"]
    line = machine["shaft_line"]
    rings = line.get("dampers", [])
    stations = line["stations"]
    n = len(stations)
    link = -np.diff(np.eye(n + len(rings)), axis=0)[: n - 1]
    place = {one["name"]: i for i, one in enumerate(stations)}
    for i, ring in enumerate(rings):
        row = np.eye(n + len(rings))
        link = np.vstack([link, row[place[ring["on"]]] - row[n + i]])
    parts = [*line["shafts"], *rings]
    radius, rod = number(train["crank_radius"]), number(train["rod_length"])
    found = Engine(
        np.array([number(one["inertia"]) for one in [*stations, *rings]]),
        link,
        np.array([number(one.get("stiffness")) for one in parts]),
        np.array([number(one.get("damping")) for one in parts]),
        np.array([number(one.get("absolute_damping")) for one in stations] + [0.0] * len(rings)),
        number(machine["speed"]),
        number(train["reciprocating_mass"]),
        radius,
        rod,
        np.array([number(one.get("crank_phase")) for one in train["cylinders"]]),
        np.zeros(1),
    )
    angle = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    (card,) = gas_cards(load_case(CASES / name).case.machine)[1]
    area = np.pi / 4.0 * number(train["bore"]) ** 2
    wave = np.fft.rfft(pressure_at(card, angle) * area * found.slope(angle)) * 2.0 / SAMPLES
    wave[0] /= 2.0
    return found._replace(gas=wave[: 1 + case["response"]["torsion"]["orders"]["count"]])


def after_misfire(name: str, silent: int, before: float, after: float, step: float) -> np.ndarray:
    """Section torques (t, e) every `step` s; the torque is a straight line over each step.

    From the steady state of all cylinders, which the last station takes in the mean, and goes on
    taking as the line slows down.
    """
    from scipy.linalg import expm

    one = engine(name)
    n, cylinders = len(one.inertia), len(one.phase)
    order = np.arange(1, len(one.gas))
    time = step * np.arange(round((before + after) / step) + 1)
    load = np.zeros((len(time), n))
    angle = one.speed * time
    onset = round(before / step)
    healthy = one.torques(angle[: onset + 1])
    load[: onset + 1, :cylinders] = healthy.T
    load[:, len(text_of(name)["machine"]["shaft_line"]["stations"]) - 1] -= (
        cylinders * one.gas[0].real
    )
    broken = one.torques(angle[onset:], silent)
    # the step begins at the onset itself: both values are kept
    late = load.copy()
    late[onset:, :cylinders] = broken.T
    plain = np.zeros((4 * n, 4 * n))
    plain[:n, n : 2 * n] = np.eye(n)
    plain[n : 2 * n, :n] = -one.k / one.inertia[:, None]
    plain[n : 2 * n, n : 2 * n] = -one.c / one.inertia[:, None]
    plain[n : 2 * n, 2 * n : 3 * n] = np.diag(1.0 / one.inertia)
    plain[2 * n : 3 * n, 3 * n :] = np.eye(n)
    exact = expm(plain * step)[: 2 * n]
    onward, held, rising = exact[:, : 2 * n], exact[:, 2 * n : 3 * n], exact[:, 3 * n :]
    ends = np.where(np.arange(1, len(time))[:, None] > onset, late[1:], load[1:])
    starts = np.where(np.arange(len(time) - 1)[:, None] >= onset, late[:-1], load[:-1])
    drive = starts @ held.T + (ends - starts) @ rising.T / step
    # steady state: harmonics of the healthy torque, and the static twist
    cycle = 2.0 * np.pi * np.arange(256) / 256
    spectrum = np.fft.rfft(one.torques(cycle), axis=1) / 128.0
    state = np.zeros(2 * n)
    for q in order:
        push = np.zeros(n, dtype=complex)
        push[:cylinders] = spectrum[:, q]
        w = q * one.speed
        moved = np.linalg.solve(one.k + 1j * w * one.c - w**2 * np.diag(one.inertia), push)
        state += np.concatenate([moved, 1j * w * moved]).real
    mean = np.zeros(n)
    mean[:cylinders] = one.gas[0].real
    mean += load[0] - np.append(healthy[:, 0], np.zeros(n - cylinders))
    state[:n] += np.linalg.lstsq(one.k, mean, rcond=None)[0]
    states = np.empty((len(time), 2 * n))
    states[0] = state
    for place, push in enumerate(drive):
        state = onward @ state + push
        states[place + 1] = state
    twist, rate = states[:, :n] @ one.link.T, states[:, n:] @ one.link.T
    return twist * one.stiffness + rate * one.damping


def turning_motion(name: str, points: int = 1024) -> np.ndarray:
    """Section torques (points, e) over one turn of the exact motion, inertias as they turn.

    Shooting: Runge-Kutta over a turn from angles and rates that Newton's method brings back to
    themselves. The last station takes the mean; the mean angle, by inertia, is zero.
    """
    from scipy.integrate import solve_ivp

    one = engine(name)
    n, cylinders, w = len(one.inertia), len(one.phase), one.speed
    grid = 2.0 * np.pi * np.arange(256) / 256
    share = one.mass * np.mean(one.slope(grid) ** 2)
    order = np.arange(len(one.gas))
    turn = 2.0 * np.pi / w

    def inertias(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        step = 1e-4
        lever = one.slope(angle)
        nearby = (one.slope(angle + step) - one.slope(angle - step)) / (2.0 * step)
        far = (one.slope(angle + 2 * step) - one.slope(angle - 2 * step)) / (4.0 * step)
        return one.mass * lever**2, 2.0 * one.mass * lever * (4.0 * nearby - far) / 3.0

    def rates(t: float, flat: np.ndarray) -> np.ndarray:
        y = flat.reshape(2 * n + 2, -1)
        x, v = y[:n], y[n : 2 * n]
        own = w * t + one.phase[:, None]
        push = -one.k @ x - one.c @ v
        push[-1] += y[-1]
        push[:cylinders] += (np.exp(1j * own * order) @ one.gas).real[:, None]
        varying, slope = inertias(own + x[:cylinders])
        inertia = np.repeat(one.inertia[:, None], x.shape[1], axis=1)
        inertia[:cylinders] += varying - share
        push[:cylinders] -= 0.5 * slope * (w + v[:cylinders]) ** 2
        mean = (one.inertia @ x / one.inertia.sum())[None]
        return np.concatenate([v, push / inertia, mean / turn, 0.0 * mean]).ravel()

    def marched(start: np.ndarray, times: np.ndarray | None = None) -> Any:
        columns = start.reshape(2 * n + 1, -1)
        y = np.vstack([columns[:-1], np.zeros_like(columns[:1]), columns[-1:]])
        return solve_ivp(
            rates, (0.0, turn), y.ravel(), method="DOP853", rtol=1e-7, atol=1e-10, t_eval=times,
        ).y  # fmt: skip

    # angles, rates, and the torque of the load
    state = np.append(np.zeros(2 * n), -cylinders * one.gas[0].real)
    size = np.concatenate([np.full(n, 1e-4), np.full(n, 1e-2), [100.0]])
    for _ in range(3):
        starts = state[:, None] + np.hstack([np.zeros((2 * n + 1, 1)), np.diag(size)])
        end = marched(starts)[:, -1].reshape(2 * n + 2, -1)[: 2 * n + 1]
        gap = end.copy()
        gap[: 2 * n] -= starts[: 2 * n]
        slope = (gap[:, 1:] - gap[:, :1]) / size
        state = state - np.linalg.solve(slope, gap[:, 0])
    found = marched(state, turn * np.arange(points) / points).reshape(2 * n + 2, -1)
    twist, rate = one.link @ found[:n], one.link @ found[n : 2 * n]
    return (one.stiffness[:, None] * twist + one.damping[:, None] * rate).T


def over_speeds(
    name: str, speed: np.ndarray, ring: tuple[float, float] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Torques (s, e, orders) of the sections and heat (s,) of the last one's dashpot, W.

    `ring` are other stiffness and damping of that section. Dense solves at speeds (s,).
    """
    one = engine(name)
    if ring is not None:
        one = one._replace(
            stiffness=np.append(one.stiffness[:-1], ring[0]),
            damping=np.append(one.damping[:-1], ring[1]),
        )
    n, order = len(one.inertia), np.arange(1, len(one.gas))
    w = speed[:, None] * order
    full = one.k + 1j * w[..., None, None] * one.c - w[..., None, None] ** 2 * np.diag(one.inertia)
    push = np.zeros((*w.shape, n, 1), dtype=complex)
    size = one.gas[1:] + speed[:, None] ** 2 * one.shaken()[1:]
    turned = np.exp(1j * order[:, None] * one.phase)
    push[..., : len(one.phase), 0] = size[..., None] * turned
    twist = np.linalg.solve(full, push)[..., 0] @ one.link.T
    torque = (one.stiffness + 1j * w[..., None] * one.damping) * twist
    heat = 0.5 * one.damping[-1] * np.sum((w * np.abs(twist[..., -1])) ** 2, axis=1)
    return torque.transpose(0, 2, 1), heat


def half_ranges(torque: np.ndarray, samples: int = 512) -> np.ndarray:
    """(highest - lowest) / 2 over the cycle of signals (..., orders), by sampling."""
    spectrum = np.zeros((*torque.shape[:-1], samples // 2 + 1), dtype=complex)
    spectrum[..., 1 : 1 + torque.shape[-1]] = torque / 2.0
    return np.asarray(0.5 * np.ptp(np.fft.irfft(spectrum, axis=-1) * samples, axis=-1))
