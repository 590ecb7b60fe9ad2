"""The prescribed mean motion of a transient, with the torque on every station along it."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# The prescribed mean motion of a transient and the torque on the way, stretch by stretch.
#
# A run is a list of stretches in each of which the acceleration of the crank is a straight line in
# time. What jumps (a load that steps, a cylinder that stops firing) jumps between two stretches.
# ----------------------------------------------------------------------------


class TorqueInTime(NamedTuple):
    """A torque in time on stations, whatever the crank does.

    At the time t in s after a stretch began it is Re sum_k amplitude_k exp(rate_k t) + start +
    slope t + bend t^2 / 2 on a station of share 1: amplitude (k,) complex and start in N m, rate
    (k,) complex in 1/s, slope in N m/s, bend in N m/s^2; `share` (n,) says how much of it each
    station gets, with the sign.
    """

    share: FloatArray
    amplitude: ComplexArray
    rate: ComplexArray
    start: float = 0.0
    slope: float = 0.0
    bend: float = 0.0

    def at(self, time: FloatArray) -> FloatArray:
        """Torque (...) on a station of share 1 at times (...) in s."""
        waves = np.exp(np.asarray(time)[..., None] * self.rate) @ self.amplitude
        grown = (self.slope + 0.5 * self.bend * time) * time
        return np.asarray(waves.real + self.start + grown)

    @property
    def fastest(self) -> float:
        """Largest magnitude of the rates in 1/s, 0 for a straight line."""
        return float(np.max(np.abs(self.rate), initial=0.0))


class Stretch(NamedTuple):
    """n stations, m orders; `duration` in s, `acceleration` of the crank in rad/s^2 at the begin.

    It changes by `acceleration_rate` (rad/s^3), but not its sign.

    The torque on station i at the speed w is scale Re sum_q (gas + w^2 inertia)_iq exp(i q theta)
    + sum_k load_ki w^exponent_k, with gas (n, m) in N m, inertia (n, m) in N m/(rad/s)^2, firing
    angles already in their phases, load (k, n) in N m/(rad/s)^exponent. The gas goes linearly *in
    the speed* from `gas` at the begin to `gas_end`, the scale linearly in time. What acts `in_time`
    comes on top; nothing balances it.
    """

    duration: float
    acceleration: float
    gas: ComplexArray
    gas_end: ComplexArray
    inertia: ComplexArray
    scale_start: float
    scale_end: float
    load: FloatArray
    exponent: FloatArray
    acceleration_rate: float = 0.0
    in_time: TorqueInTime | None = None


class SpeedProfile(NamedTuple):
    """Where the stretches begin: b stretches, b + 1 borders; angle in the widest float there is."""

    time: FloatArray
    speed: FloatArray
    angle: np.ndarray


def stretch(
    duration: float,
    acceleration: float,
    gas: ComplexArray,
    inertia: ComplexArray | None = None,
    scale: tuple[float, float] = (1.0, 1.0),
    load: FloatArray | None = None,
    exponent: FloatArray | None = None,
    acceleration_rate: float = 0.0,
    gas_end: ComplexArray | None = None,
) -> Stretch:
    """A stretch with what is left out being zero; a gas without `gas_end` stays as it is.

    A load (n,) without `exponent` is constant.
    """
    gas = np.asarray(gas, dtype=complex)
    mass_torque = np.zeros_like(gas) if inertia is None else np.asarray(inertia, dtype=complex)
    last = gas if gas_end is None else np.asarray(gas_end, dtype=complex)
    taken = np.atleast_2d(np.zeros(gas.shape[0]) if load is None else load).astype(float)
    power = np.zeros(len(taken)) if exponent is None else np.asarray(exponent, dtype=float)
    return Stretch(
        float(duration), float(acceleration), gas, last, mass_torque, *scale, taken, power,
        float(acceleration_rate),
    )  # fmt: skip


def speed_after(part: Stretch, speed: float, time: FloatArray) -> FloatArray:
    """Speed (...) of the crank in rad/s at times (...) in s after a stretch began at `speed`."""
    grown = 0.5 * part.acceleration_rate * time
    return np.asarray(np.maximum(speed + (part.acceleration + grown) * time, 0.0))


def turned_after(part: Stretch, speed: float, time: Any) -> Any:
    """Angle (...) in rad by which the crank turns in that time, in the float of `time`."""
    kind = np.asarray(time).dtype.type
    grown = kind(part.acceleration_rate) * time / 3
    return (kind(speed) + (kind(part.acceleration) + grown) * time / 2) * time


def mean_torque(part: Stretch, speeds: FloatArray, speed: float, time: float) -> FloatArray:
    """Mean torque (n,) in N m of gas and loads, `time` s after a stretch between `speeds` began."""
    passed = (speed - speeds[0]) / (speeds[1] - speeds[0]) if speeds[1] != speeds[0] else 0.0
    gas = part.gas[:, 0] + passed * (part.gas_end - part.gas)[:, 0]
    mean = (gas + speed**2 * part.inertia[:, 0]).real
    scale = part.scale_start + (part.scale_end - part.scale_start) * time / part.duration
    torque: FloatArray = scale * mean + speed**part.exponent @ part.load
    return torque


def time_of_speed(part: Stretch, speed: float, wanted: float) -> float:
    """Time in s after which a stretch that began at `speed` reaches another one on its way."""
    change = wanted - speed
    root = np.sqrt(max(part.acceleration**2 + 2.0 * part.acceleration_rate * change, 0.0))
    return float(2.0 * change / (part.acceleration + np.copysign(root, change)))


def speed_profile(stretches: Sequence[Stretch], speed: float, angle: float = 0.0) -> SpeedProfile:
    """Time in s, speed in rad/s and crank angle in rad at every border.

    Raises NumericalFailure if a stretch does not last, its acceleration changes its sign or the
    crank would turn backwards. A speed
    within rounding of zero at the end of a stretch is zero: the line stands still.
    """
    times, speeds, angles = [0.0], [float(speed)], [np.longdouble(angle)]
    for number, part in enumerate(stretches, start=1):
        if not part.duration > 0.0:
            raise NumericalFailure(f"stretch {number} of the transient has no duration")
        last = part.acceleration + part.acceleration_rate * part.duration
        if part.acceleration * last < -EPSILON * max(abs(part.acceleration), abs(last)) ** 2:
            raise NumericalFailure(
                f"the acceleration changes its sign within stretch {number} of the transient"
            )
        change = 0.5 * (part.acceleration + last) * part.duration
        end = speeds[-1] + change
        if abs(end) <= 8.0 * EPSILON * (abs(change) + max(speeds)):
            end = 0.0
        if end < 0.0 or speeds[-1] < 0.0:
            raise NumericalFailure(
                f"the crank would turn backwards in stretch {number} of the transient: its speed "
                f"goes from {speeds[-1]:.6g} to {end:.6g} rad/s"
            )
        long = np.longdouble(part.duration)
        angles.append(angles[-1] + turned_after(part, speeds[-1], long))
        times.append(times[-1] + part.duration)
        speeds.append(end)
    return SpeedProfile(np.array(times), np.array(speeds), np.array(angles))


def speed_at(stretches: Sequence[Stretch], borders: SpeedProfile, time: FloatArray) -> FloatArray:
    """Speed of the crank in rad/s at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[0]
    return found


def angle_at(stretches: Sequence[Stretch], borders: SpeedProfile, time: FloatArray) -> FloatArray:
    """Angle of the crank in rad at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[1]
    return found


def acceleration_at(
    stretches: Sequence[Stretch], borders: SpeedProfile, time: FloatArray
) -> FloatArray:
    """Acceleration of the crank in rad/s^2 at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[2]
    return found


def _by_stretch(
    stretches: Sequence[Stretch], borders: SpeedProfile, time: FloatArray
) -> FloatArray:
    """Speeds, angles and accelerations (3, ...)."""
    time = np.asarray(time, dtype=float)
    place = np.searchsorted(borders.time, time, side="right") - 1
    place = np.clip(place, 0, len(stretches) - 1)
    values = np.empty((3, *time.shape))
    for k in np.unique(place):
        part, here = stretches[k], place == k
        since, speed = time[here] - borders.time[k], float(borders.speed[k])
        values[0, here] = speed_after(part, speed, since)
        values[1, here] = float(borders.angle[k]) + turned_after(part, speed, since)
        values[2, here] = part.acceleration + part.acceleration_rate * since
    return values


# ----------------------------------------------------------------------------
# The torque on every station along the prescribed motion, at many times at once.
# ----------------------------------------------------------------------------

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


def doubled_orders(order: FloatArray) -> FloatArray:
    """Orders (m,) times two; raises NumericalFailure for one below zero."""
    power = 2.0 * np.asarray(order, dtype=float)
    if np.any(power < 0.0):
        raise NumericalFailure("orders of the torque in a transient go from 0 on")
    return power


def repeats(power: FloatArray) -> bool:
    """Whether orders (m,) times two are whole numbers, so that two turns are a period of all."""
    return bool(np.all(power == np.rint(power)))


def torque_law(
    order: FloatArray, part: Stretch, balance: FloatArray, inertia: FloatArray, speeds: FloatArray
) -> TorqueLaw:
    """Law of one stretch between two `speeds`, in rad/s.

    The mean (order 0), the loads and -J acceleration are balanced. At standstill every order is a
    mean: the torque at the angle where the crank stands.
    """
    power = doubled_orders(order)
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
    """cos and sin of q theta, (2 m, ...) for angles (...).

    By powers of exp(i theta / 2) where all orders are multiples of 1/2.
    """
    m = power.size
    if not repeats(power):
        turned = 0.5 * np.multiply.outer(power, angle)
        return np.concatenate([np.cos(turned), np.sin(turned)])
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
    if part.in_time is not None:
        torque += np.multiply.outer(part.in_time.share, part.in_time.at(share * part.duration))
    return torque
