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

    def later(self, time: float) -> "TorqueInTime":
        """The same, begun so many s later."""
        return self._replace(
            amplitude=self.amplitude * np.exp(self.rate * time),
            start=self.start + (self.slope + 0.5 * self.bend * time) * time,
            slope=self.slope + self.bend * time,
        )

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


def split(part: Stretch, speed: float, time: float) -> tuple[Stretch, Stretch]:
    """What of a stretch that began at a speed in rad/s lies before and after a time in s in it."""
    middle, end = speed_after(part, speed, np.array([time, part.duration])).tolist()
    passed = (middle - speed) / (end - speed) if end != speed else 0.0
    gas = part.gas + passed * (part.gas_end - part.gas)
    scale = part.scale_start + (part.scale_end - part.scale_start) * time / part.duration
    rest = part._replace(
        duration=part.duration - time,
        acceleration=part.acceleration + part.acceleration_rate * time,
        gas=gas,
        scale_start=scale,
        in_time=None if part.in_time is None else part.in_time.later(time),
    )
    return part._replace(duration=time, gas_end=gas, scale_end=scale), rest


def turned_after(part: Stretch, speed: float, time: Any) -> Any:
    """Angle (...) in rad by which the crank turns in that time, in the float of `time`."""
    kind = np.asarray(time).dtype.type
    grown = kind(part.acceleration_rate) * time / 3
    return (kind(speed) + (kind(part.acceleration) + grown) * time / 2) * time


def time_of_speed(part: Stretch, speed: float, wanted: float) -> float:
    """Time in s after which a stretch that began at `speed` reaches another one on its way."""
    change = wanted - speed
    root = np.sqrt(max(part.acceleration**2 + 2.0 * part.acceleration_rate * change, 0.0))
    return float(2.0 * change / (part.acceleration + np.copysign(root, change)))


#: halvings of the time in search of an angle
_HALVINGS = 60


class Course(NamedTuple):
    """Stretches on end, with the crank where they begin and the last one ends, (b + 1,) each.

    `time` in s, `speed` in rad/s, `angle` in rad, in the widest float there is.
    """

    parts: tuple[Stretch, ...]
    time: FloatArray
    speed: FloatArray
    angle: np.ndarray

    def at(self, time: FloatArray) -> FloatArray:
        """Speed in rad/s, angle in rad and acceleration in rad/s^2 (3, ...) at times (...) in s."""
        time = np.asarray(time, dtype=float)
        place = np.searchsorted(self.time, time, side="right") - 1
        place = np.clip(place, 0, len(self.parts) - 1)
        values = np.empty((3, *time.shape))
        for k in np.unique(place):
            part, here = self.parts[k], place == k
            since, speed = time[here] - self.time[k], float(self.speed[k])
            values[0, here] = speed_after(part, speed, since)
            values[1, here] = float(self.angle[k]) + turned_after(part, speed, since)
            values[2, here] = part.acceleration + part.acceleration_rate * since
        return values

    def time_of(self, angle: FloatArray) -> FloatArray:
        """Times (...) in s at which the crank has turned that far, within the run."""
        low, high = np.zeros_like(angle), np.full_like(angle, self.time[-1])
        for _ in range(_HALVINGS):
            half = 0.5 * (low + high)
            later = self.at(half)[1] < angle
            low, high = np.where(later, half, low), np.where(later, high, half)
        return np.where(low > 0.0, high, low)


def course_of(stretches: Sequence[Stretch], speed: float, angle: float = 0.0) -> Course:
    """Raises NumericalFailure if a stretch does not last, its acceleration changes its sign or the
    crank would turn backwards. A speed within rounding of zero at the end of a stretch is zero:
    the line stands still.
    """
    times, speeds, angles = [0.0], [float(speed)], [np.longdouble(angle)]
    for number, part in enumerate(stretches, start=1):
        if not part.duration > 0.0:
            raise NumericalFailure(f"stretch {number} of the transient has no duration")
        last = part.acceleration + part.acceleration_rate * part.duration
        most = max(abs(part.acceleration), abs(last))
        if part.acceleration * last < -8.0 * EPSILON * most**2:
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
        angles.append(angles[-1] + turned_after(part, speeds[-1], np.longdouble(part.duration)))
        times.append(times[-1] + part.duration)
        speeds.append(end)
    return Course(tuple(stretches), np.array(times), np.array(speeds), np.array(angles))


# ----------------------------------------------------------------------------
# The torque on every station along the prescribed motion, at many times at once.
# ----------------------------------------------------------------------------

#: one four-stroke cycle, the period of all half orders, in the widest float there is
CYCLE = 8 * np.arctan(np.longdouble(1)) * 2


class TorqueLaw(NamedTuple):
    """Torques of the stretch `part` as matrices; `power` (m,) are the orders times two.

    `harmonic` (3, n, 2 m) takes the real and imaginary parts of exp(i q theta): gas at `speed`, in
    rad/s, that of the begin; gas for each rad/s beyond it; inertia per squared speed. `pull` (2, n)
    is what the acceleration does at begin and end, `load` (k, n) what goes with powers of the
    speed; means are balanced already.
    """

    part: Stretch
    power: FloatArray
    harmonic: FloatArray
    speed: float
    pull: FloatArray
    load: FloatArray

    def loads(self, speed: FloatArray) -> FloatArray:
        """Balanced loads (n, ...) in N m at speeds (...) in rad/s."""
        powers = np.maximum(speed, 0.0)[..., None] ** self.part.exponent
        return np.asarray(np.moveaxis(powers @ self.load, -1, 0))

    def at(self, angle: FloatArray, speed: FloatArray, share: FloatArray) -> FloatArray:
        """Torques (n, ...) in N m at angles, speeds and shares of the stretch passed, all (...)."""
        part, flat = self.part, basis(self.power, angle.ravel())
        gas = (self.harmonic[0] @ flat).reshape(-1, *angle.shape)
        for factor, harmonic in (
            (speed - self.speed, self.harmonic[1]), (speed**2, self.harmonic[2]),
        ):  # fmt: skip
            if np.any(harmonic):
                gas += factor * (harmonic @ flat).reshape(-1, *angle.shape)
        scale = part.scale_start + (part.scale_end - part.scale_start) * share
        outer = (slice(None), *(None,) * angle.ndim)
        pull = self.pull[0][outer] + (self.pull[1] - self.pull[0])[outer] * share
        torque: FloatArray = scale * gas + self.loads(speed) + pull
        if part.in_time is not None:
            torque += np.multiply.outer(part.in_time.share, part.in_time.at(share * part.duration))
        return torque


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
    power = 2.0 * np.asarray(order, dtype=float)
    if np.any(power < 0.0):
        raise NumericalFailure("orders of the torque in a transient go from 0 on")
    begin, end = (float(one) for one in speeds)
    mean = power == 0.0 if begin or end else np.ones_like(power, dtype=bool)
    growth = (part.gas_end - part.gas) / (end - begin) if end != begin else 0.0 * part.gas
    split = []
    for torque in (part.gas, growth, part.inertia):
        held = np.where(mean, balance @ torque, torque)
        split.append(np.concatenate([held.real, -held.imag], axis=1))
    last = part.acceleration + part.acceleration_rate * part.duration
    pull = -np.outer([part.acceleration, last], inertia) @ balance.T
    return TorqueLaw(part, power, np.array(split), begin, pull, part.load @ balance.T)


def mean_law(
    part: Stretch, balance: FloatArray, inertia: FloatArray, speeds: FloatArray
) -> TorqueLaw:
    """That of the mean torque alone, order 0 being the first of the stretch."""
    means = part._replace(
        gas=part.gas[:, :1], gas_end=part.gas_end[:, :1], inertia=part.inertia[:, :1]
    )
    return torque_law(np.zeros(1), means, balance, inertia, speeds)


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
