"""The prescribed mean motion of a transient and the torque on the way, stretch by stretch.

A run is a list of stretches in each of which the acceleration of the crank is a straight line in
time. What jumps (a load that steps, a cylinder that stops firing) jumps between two stretches.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray


class Stretch(NamedTuple):
    """n stations, m orders; `duration` in s, `acceleration` of the crank in rad/s^2 at the begin.

    It changes by `acceleration_rate` (rad/s^3), but not its sign.

    The torque on station i at the speed w is scale Re sum_q (gas + w^2 inertia)_iq exp(i q theta)
    + sum_k load_ki w^exponent_k, with gas (n, m) in N m, inertia (n, m) in N m/(rad/s)^2, firing
    angles already in their phases, load (k, n) in N m/(rad/s)^exponent. The gas goes linearly *in
    the speed* from `gas` at the begin to `gas_end`, the scale linearly in time.
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


class Course(NamedTuple):
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
    own = np.zeros_like(gas) if inertia is None else np.asarray(inertia, dtype=complex)
    last = gas if gas_end is None else np.asarray(gas_end, dtype=complex)
    taken = np.atleast_2d(np.zeros(gas.shape[0]) if load is None else load).astype(float)
    power = np.zeros(len(taken)) if exponent is None else np.asarray(exponent, dtype=float)
    return Stretch(
        float(duration), float(acceleration), gas, last, own, *scale, taken, power,
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


def course(stretches: Sequence[Stretch], speed: float, angle: float = 0.0) -> Course:
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
    return Course(np.array(times), np.array(speeds), np.array(angles))


def speed_at(stretches: Sequence[Stretch], borders: Course, time: FloatArray) -> FloatArray:
    """Speed of the crank in rad/s at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[0]
    return found


def angle_at(stretches: Sequence[Stretch], borders: Course, time: FloatArray) -> FloatArray:
    """Angle of the crank in rad at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[1]
    return found


def acceleration_at(stretches: Sequence[Stretch], borders: Course, time: FloatArray) -> FloatArray:
    """Acceleration of the crank in rad/s^2 at times (...) in s from the start of the run."""
    found: FloatArray = _by_stretch(stretches, borders, time)[2]
    return found


def _by_stretch(stretches: Sequence[Stretch], borders: Course, time: FloatArray) -> FloatArray:
    """Speeds, angles and accelerations (3, ...)."""
    time = np.asarray(time, dtype=float)
    place = np.searchsorted(borders.time, time, side="right") - 1
    place = np.clip(place, 0, len(stretches) - 1)
    found = np.empty((3, *time.shape))
    for k in np.unique(place):
        part, here = stretches[k], place == k
        since, speed = time[here] - borders.time[k], float(borders.speed[k])
        found[0, here] = speed_after(part, speed, since)
        found[1, here] = float(borders.angle[k]) + turned_after(part, speed, since)
        found[2, here] = part.acceleration + part.acceleration_rate * since
    return found
