"""The shipped cases of the published engine, computed without the package.

Response by openTorsion's `ss_response`, torques of the cylinders by quadrature of the card, time
histories by short steps along which the torque is a straight line.
"""

from typing import NamedTuple

import engine_source as source
import numpy as np
from engine_as_published import gas_torque, inertia_torque, mean_and_harmonics

#: what the cases write: dashpots of the throws, of the last shaft, of cylinders and flywheel, ring
THROW, LAST, CYLINDER, FLYWHEEL, RING = 1082.9, 911.55, 34.21, 4873.0, 2131.976
ORDER = 0.5 * np.arange(1, 31)


class Matrices(NamedTuple):
    """Of the seven stations, then the ring; sections are the shafts, then the ring's spring."""

    inertia: np.ndarray
    link: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    absolute: np.ndarray

    @property
    def k(self) -> np.ndarray:
        return self.link.T @ (self.stiffness[:, None] * self.link)

    @property
    def c(self) -> np.ndarray:
        return self.link.T @ (self.damping[:, None] * self.link) + np.diag(self.absolute)


def engine(ring: bool) -> Matrices:
    inertia, stiffness = list(source.INERTIA), list(source.STIFFNESS)
    damping, absolute = [THROW] * 5 + [LAST], [CYLINDER] * 6 + [FLYWHEEL]
    link = -np.diff(np.eye(7 + ring), axis=0)[:6]
    if ring:
        inertia, absolute = [*inertia, source.DAMPER_INERTIA], [*absolute, 0.0]
        stiffness, damping = [*stiffness, source.DAMPER_STIFFNESS], [*damping, RING]
        link = np.vstack([link, np.eye(8)[0] - np.eye(8)[7]])
    return Matrices(*map(np.array, (inertia, link, stiffness, damping, absolute)))


def torques(speed: float, orders: int, silent: int = -1) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes (orders, 6) and means (6,) of the cylinders; `silent` has no gas."""
    _, inertia = mean_and_harmonics(lambda a: inertia_torque(a, speed))
    mean, gas = mean_and_harmonics(gas_torque)
    works = np.arange(6) != silent
    turn = np.exp(-1j * ORDER[:orders, None] * np.array(source.FIRING_ANGLE))
    value = (gas[:orders, None] * works + inertia[:orders, None]) * turn
    return value, mean * works


def twists(matrices: Matrices, speed: float, torque: np.ndarray) -> np.ndarray:
    """Twists (sections, orders) by openTorsion."""
    import opentorsion as ot

    orders = len(torque)
    shafts = [
        ot.Shaft(int(np.argmax(row)), int(np.argmin(row)), k=k, c=c)
        for row, k, c in zip(matrices.link, matrices.stiffness, matrices.damping, strict=True)
    ]
    discs = [
        ot.Disk(i, j, c=c)
        for i, (j, c) in enumerate(zip(matrices.inertia, matrices.absolute, strict=True))
    ]
    load = np.zeros((len(matrices.inertia), orders), dtype=complex)
    load[:6] = torque.T
    angle, _ = ot.Assembly(shafts, disk_elements=discs).ss_response(load, speed * ORDER[:orders])
    return matrices.link @ angle


def section_torques(matrices: Matrices, speed: float, twist: np.ndarray) -> np.ndarray:
    """Stiffness and damping part (sections, orders)."""
    w = speed * ORDER[: twist.shape[1]]
    return (matrices.stiffness[:, None] + 1j * w * matrices.damping[:, None]) * twist


def run_up(
    begin: float, end: float, acceleration: float, after: float, orders: int, step: float = 2e-5
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times (t,), crank speeds (t,) and section torques (t, 6) of the engine without its ring.

    From the steady state at `begin`; the flywheel takes what keeps the mean speed as prescribed.
    The acceleration rises to the one given in a tenth of the time and falls in the last tenth.
    """
    from scipy.linalg import expm

    line = engine(ring=False)
    duration = (end - begin) / acceleration / 0.9
    time = np.arange(0.0, duration + after + step, step)
    ramp = np.minimum(time, duration - time) / (0.1 * duration)
    rate = acceleration * np.clip(ramp, 0.0, 1.0)

    def summed(value: np.ndarray) -> np.ndarray:
        parts = 0.5 * step * (value[1:] + value[:-1]) - step**2 / 12.0 * np.diff(slope(value))
        return np.append(0.0, np.cumsum(parts))

    def slope(value: np.ndarray) -> np.ndarray:
        return np.gradient(value, step, edge_order=2)

    speed = begin + summed(rate)
    theta = summed(speed)
    gas, means = torques(0.0, orders)
    moving = torques(1.0, orders)[0] - gas
    load = np.zeros((len(time), 7))
    for place, order in enumerate(ORDER[:orders]):
        wave = np.exp(1j * order * theta)[:, None]
        load[:, :6] += (wave * (gas[place] + speed[:, None] ** 2 * moving[place])).real
    mean = np.append(means, -means.sum())
    pulled = rate[:, None] * -line.inertia
    pulled[:, 6] -= pulled.sum(axis=1)
    load += mean + pulled
    # angles and speeds; the torque a straight line over each step
    n = 7
    plain = np.zeros((4 * n, 4 * n))
    plain[:n, n : 2 * n] = np.eye(n)
    plain[n : 2 * n, :n] = -line.k / line.inertia[:, None]
    plain[n : 2 * n, n : 2 * n] = -line.c / line.inertia[:, None]
    plain[n : 2 * n, 2 * n : 3 * n] = np.diag(1.0 / line.inertia)
    plain[2 * n : 3 * n, 3 * n :] = np.eye(n)
    exact = expm(plain * step)
    onward, held, rising = (
        exact[: 2 * n, : 2 * n],
        exact[: 2 * n, 2 * n : 3 * n],
        exact[: 2 * n, 3 * n :],
    )
    drive = load[:-1] @ held.T + np.diff(load, axis=0) @ rising.T / step
    w = begin * ORDER[:orders]
    steady = gas + begin**2 * moving
    state = np.zeros(2 * n)
    for frequency, torque in zip(w, steady, strict=True):
        full = line.k + 1j * frequency * line.c - frequency**2 * np.diag(line.inertia)
        angle = np.linalg.solve(full, np.append(torque, 0.0))
        state += np.concatenate([angle, 1j * frequency * angle]).real
    state[:n] += np.linalg.lstsq(line.k, mean, rcond=None)[0]
    states = np.empty((len(time), 2 * n))
    states[0] = state
    for place, push in enumerate(drive):
        state = onward @ state + push
        states[place + 1] = state
    twist, rate = states[:, :n] @ line.link.T, states[:, n:] @ line.link.T
    return time, speed, twist * line.stiffness + rate * line.damping


def worst_torque(
    stiffness: float, damping: float, speeds: tuple[float, float], orders: int
) -> tuple[float, float]:
    """Largest half range of a shaft's torque, N m, and its speed, by looking ever closer.

    With the ring behind another spring and dashpot; that spring's own torque does not count.
    """
    line = engine(ring=True)
    spring, dashpot = line.stiffness.copy(), line.damping.copy()
    spring[6], dashpot[6] = stiffness, damping
    line = line._replace(stiffness=spring, damping=dashpot)
    gas, _ = torques(0.0, orders)
    moving = torques(1.0, orders)[0] - gas
    low, high = speeds
    best, where = 0.0, low
    for count in (481, 61, 41):
        speed = np.linspace(low, high, count)
        w = speed[:, None] * ORDER[:orders]
        full = line.k + 1j * w[..., None, None] * line.c
        full = full - w[..., None, None] ** 2 * np.diag(line.inertia)
        load = np.zeros((*w.shape, 8, 1), dtype=complex)
        load[..., :6, 0] = gas + speed[:, None, None] ** 2 * moving
        twist = np.linalg.solve(full, load)[..., 0] @ line.link.T
        torque = (line.stiffness + 1j * w[..., None] * line.damping) * twist
        spectrum = np.zeros((count, 1025, 6), dtype=complex)
        spectrum[:, 1 : 1 + orders] = torque[..., :6] / 2.0
        signal = np.fft.irfft(spectrum, axis=1) * 2048
        half = 0.5 * (signal.max(axis=1) - signal.min(axis=1)).max(axis=1)
        place = int(np.argmax(half))
        best, where = float(half[place]), float(speed[place])
        step = speed[1] - speed[0]
        low, high = max(speeds[0], where - 2.0 * step), min(speeds[1], where + 2.0 * step)
    return best, where
