"""The torque on every station along the prescribed motion, at many times at once."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.transient_motion import Stretch

#: one four-stroke cycle, the period of all half orders, in the widest float there is
CYCLE = 8 * np.arctan(np.longdouble(1)) * 2


class TorqueLaw(NamedTuple):
    """Torques of one stretch as matrices; `power` (m,) are the orders times two.

    `harmonic` (3, n, 2 m) takes the real and imaginary parts of exp(i q theta): gas at `speed`, in
    rad/s, that of the begin; gas for each rad/s beyond it; inertia per squared speed. `pull` (2, n)
    is what the acceleration does at begin and end, `load` (k, n) goes with the powers `exponent`
    (k,) of the speed; means are balanced already.
    """

    power: FloatArray
    harmonic: FloatArray
    speed: float
    pull: FloatArray
    load: FloatArray
    exponent: FloatArray


def half_orders(order: FloatArray) -> FloatArray:
    """Orders (m,) times two as whole numbers; raises NumericalFailure for any other order."""
    power = 2.0 * np.asarray(order, dtype=float)
    if np.any(power != np.rint(power)) or np.any(power < 0.0):
        raise NumericalFailure(
            "orders of the torque in a transient are multiples of 1/2, from 0 on"
        )
    return power


def torque_law(
    order: FloatArray, part: Stretch, balance: FloatArray, inertia: FloatArray, speeds: FloatArray
) -> TorqueLaw:
    """Law of one stretch between two `speeds`, in rad/s.

    The mean (order 0), the loads and -J acceleration are balanced. At standstill every order is a
    mean: the torque at the angle where the crank stands.
    """
    power = half_orders(order)
    begin, end = (float(one) for one in speeds)
    mean = power == 0.0 if begin or end else np.ones_like(power, dtype=bool)
    growth = (part.gas_end - part.gas) / (end - begin) if end != begin else 0.0 * part.gas
    split = []
    for torque in (part.gas, growth, part.inertia):
        held = np.where(mean, balance @ torque, torque)
        split.append(np.concatenate([held.real, -held.imag], axis=1))
    last = part.acceleration + part.acceleration_rate * part.duration
    pull = -np.outer([part.acceleration, last], inertia) @ balance.T
    return TorqueLaw(power, np.array(split), begin, pull, part.load @ balance.T, part.exponent)


def load_at(law: TorqueLaw, speed: FloatArray) -> FloatArray:
    """Balanced loads (n, ...) in N m at speeds (...) in rad/s."""
    powers = np.maximum(speed, 0.0)[..., None] ** law.exponent
    return np.asarray(np.moveaxis(powers @ law.load, -1, 0))


def basis(power: FloatArray, angle: FloatArray) -> FloatArray:
    """cos and sin of q theta, (2 m, ...) for angles (...), by powers of exp(i theta / 2)."""
    m = power.size
    values = np.empty((2 * m, *angle.shape))
    root = np.exp(0.5j * angle)
    current, reached = np.ones_like(root), 0
    for place in np.argsort(power, kind="stable"):
        for _ in range(int(power[place]) - reached):
            current = current * root
        reached = int(power[place])
        values[place], values[m + place] = current.real, current.imag
    return values


def torque_at(
    law: TorqueLaw, part: Stretch, angle: FloatArray, speed: FloatArray, share: FloatArray
) -> FloatArray:
    """Torques (n, ...) in N m at angles, speeds and shares of the stretch passed, all (...)."""
    flat = basis(law.power, angle.ravel())
    gas = (law.harmonic[0] @ flat).reshape(-1, *angle.shape)
    for factor, harmonic in ((speed - law.speed, law.harmonic[1]), (speed**2, law.harmonic[2])):
        if np.any(harmonic):
            gas += factor * (harmonic @ flat).reshape(-1, *angle.shape)
    scale = part.scale_start + (part.scale_end - part.scale_start) * share
    outer = (slice(None), *(None,) * angle.ndim)
    pull = law.pull[0][outer] + (law.pull[1] - law.pull[0])[outer] * share
    torque: FloatArray = scale * gas + load_at(law, speed) + pull
    return torque
