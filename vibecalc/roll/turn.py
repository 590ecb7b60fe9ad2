"""One turn of a running machine: what it means, whether it balances, where its peaks are."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.roll.mechanism import (
    AngleTerms,
    Inertia,
    RollDrive,
    RollMachine,
    accelerations,
    friction_torque,
    gas_forces,
    gas_torque,
    inertia,
    is_mounted,
    motor_torque,
    mount_torque,
)

# ----------------------------------------------------------------------------
# One turn of a running machine at quadrature points, whatever method has found it.
# ----------------------------------------------------------------------------


class Turn(NamedTuple):
    """A periodic motion over one turn of the crank, at k points that ascend with the crank angle.

    `crank_angle`, `weight`, `time`, `crank_speed`, `shell_speed` and `shell_angle` (..., k) in rad,
    rad, s, rad/s, rad/s, rad. `weight` integrates over the crank angle, `time` counts from crank
    angle zero; `period` (...,) is that of the turn in s. `motor_torque` (..., k) in N m is None
    where it follows from the speed.
    """

    crank_angle: FloatArray
    weight: FloatArray
    time: FloatArray
    crank_speed: FloatArray
    shell_speed: FloatArray
    shell_angle: FloatArray
    period: FloatArray
    motor_torque: FloatArray | None = None


def trapezoids(x: FloatArray) -> FloatArray:
    """Weights (k,) of the rule of trapezoids at ascending points (k,)."""
    step = np.diff(x)
    weight = np.zeros(len(x))
    weight[:-1] += 0.5 * step
    weight[1:] += 0.5 * step
    return weight


def harmonics(turn: Turn, values: FloatArray, orders: FloatArray) -> ComplexArray:
    """Harmonics in time of `values` (..., k): complex, zero-to-peak, (..., orders).

    x(t) = Re sum X_n exp(i n W t), W = 2 pi / period, t = 0 where the crank angle is 0; `orders`
    ascend, order 0 is the mean. With the lag phi of Herold (1977), equations 92 to 96,
    X_n = C_n exp(-i phi_n).
    """
    rate = 2.0 * np.pi / turn.period[..., None]
    shares = values * turn.weight / turn.crank_speed * (2.0 / turn.period[..., None])
    numbers = np.asarray(orders)
    coefficients = np.empty((*shares.shape[:-1], len(numbers)), dtype=complex)
    steps = np.diff(numbers, prepend=0.0)
    # powers of one wave: an exponential of every order would cost most of the work
    wave, single = np.ones(shares.shape, dtype=complex), np.exp(-1j * (rate * turn.time))
    for place, (order, step) in enumerate(zip(numbers, steps, strict=True)):
        wave = wave * (single if step == 1.0 else single**step)
        total = np.einsum("...k,...k->...", shares, wave)
        coefficients[..., place] = 0.5 * total if order == 0 else total
    return coefficients


def mean(turn: Turn, values: FloatArray) -> FloatArray:
    """Mean in time of `values` (..., k)."""
    return np.asarray(np.sum(values * turn.weight / turn.crank_speed, axis=-1) / turn.period)


def level(amplitude: ComplexArray) -> FloatArray:
    """20 log10 of magnitudes, dB against one unit; minus infinity for zero."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.abs(amplitude)))


# ----------------------------------------------------------------------------
# What a turn of the machine means: accelerations, torques, and the forces at each piston.
# ----------------------------------------------------------------------------


class Readings(NamedTuple):
    """Values (..., k) at the points of a turn; SI. Those of cylinders are (..., k, c).

    Accelerations and speeds are positive in the crank's sense of rotation; `rotor_acceleration` is
    against the ground, `crank_speed` against the shell. `motor_torque`, `gas_torque` and
    `friction_torque` act on the crankshaft, `mount_torque` on the shell. `rod_force` is positive in
    compression. `wall_force` is that of a piston on its wall, positive where it turns the shell in
    the crank's sense; `gas_force` pushes the piston towards the crank.
    """

    shell_acceleration: FloatArray
    rotor_acceleration: FloatArray
    crank_speed: FloatArray
    slip: FloatArray
    motor_torque: FloatArray
    gas_torque: FloatArray
    friction_torque: FloatArray
    mount_torque: FloatArray
    rod_force: FloatArray
    wall_force: FloatArray
    gas_force: FloatArray


def readings(
    machine: RollMachine,
    drive: RollDrive,
    turn: Turn,
    *,
    pistons: bool = True,
    place: AngleTerms | None = None,
) -> Readings:
    """Everything that follows from angles and speeds.

    Without `pistons` the forces in rods and on walls are left out (zero). `place` is what depends
    on the crank angle alone, if it is known at the points of the turn.
    """
    moved = inertia(machine, turn.crank_angle) if place is None else place.moved
    forces = gas_forces(machine, drive, turn.crank_angle) if place is None else place.gas_force
    speed, shell = turn.crank_speed, turn.shell_speed
    motor = turn.motor_torque
    if motor is None:
        motor = motor_torque(machine, drive, speed).value
    gas = gas_torque(moved, forces)
    friction = friction_torque(machine, moved, speed)
    mounts = mount_torque(machine, turn.shell_angle, shell)
    accelerated = accelerations(moved, speed, shell, mounts, motor + gas + friction)
    rod = wall = np.zeros_like(forces)
    if pistons:
        rod, wall = piston_forces(
            machine,
            turn,
            moved,
            forces,
            shell_acceleration=accelerated.shell,
            acceleration=accelerated.crank,
        )
    return Readings(
        accelerated.shell,
        accelerated.shell + accelerated.crank,
        speed,
        drive.synchronous_speed[..., None] - speed,
        motor,
        gas,
        friction,
        mounts,
        rod,
        wall,
        forces,
    )


def shell_harmonics(
    machine: RollMachine,
    drive: RollDrive,
    turn: Turn,
    orders: int | FloatArray,
    place: AngleTerms | None = None,
) -> ComplexArray:
    """Harmonics (..., orders) of the shell's acceleration, of orders 1 to `orders` or of those."""
    read = readings(machine, drive, turn, pistons=False, place=place)
    numbers = np.arange(1.0, orders + 1) if isinstance(orders, int) else orders
    return harmonics(turn, read.shell_acceleration, numbers)


def spectrum(turn: Turn, read: Readings, name: str, orders: FloatArray) -> ComplexArray:
    """Harmonics (..., orders) of a reading by name, those of pistons (..., c, orders)."""
    by_order = by_cylinder if name in _OF_PISTONS else harmonics
    return by_order(turn, np.asarray(getattr(read, name)), orders)


def piston_forces(
    machine: RollMachine,
    turn: Turn,
    moved: Inertia,
    gas: FloatArray,
    *,
    shell_acceleration: FloatArray,
    acceleration: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Force along each rod and of each piston on its wall (..., k, c), N.

    Newton's law for the piston in the turning shell (Herold 1977, equations 71 to 77), with a wrist
    pin offset, friction, and the moment of the rod beyond its two point masses.
    """
    speed, shell = turn.crank_speed[..., None], turn.shell_speed[..., None]
    turning, crank = shell_acceleration[..., None], acceleration[..., None]
    offset = machine.wrist_pin_offset[..., None, None]
    mass = machine.reciprocating_mass[..., None, :]
    angle = turn.crank_angle[..., None] + machine.crank_angle_offset[..., None, :]
    radius = machine.crank_radius[..., None, None]
    length = machine.rod_length[..., None, None]
    outward = moved.stroke * crank + moved.curvature * speed * speed
    along = mass * (outward - moved.position * shell * shell - offset * turning)
    along = along + gas
    along = along + machine.piston_friction[..., None, None] * np.sign(moved.stroke * speed)
    across = mass * (
        moved.position * turning + 2.0 * moved.stroke * speed * shell - offset * shell * shell
    )
    projection = moved.position - radius * np.cos(angle)
    sine, cosine = (radius * np.sin(angle) - offset) / length, projection / length
    difference = machine.rod_inertia_difference[..., None, :]
    twist: FloatArray | float = 0.0
    if np.any(difference):
        lever = radius * np.cos(angle)
        turn_ = -lever / projection
        bend = radius * np.sin(angle) / projection - sine * length * lever**2 / projection**3
        twist = -difference * (turning + turn_ * crank + bend * speed * speed) / length
    rod = (along - twist * sine) / cosine
    return np.asarray(rod), np.asarray(-across - rod * sine + twist * cosine)


# ----------------------------------------------------------------------------
# Do energy and angular momentum balance over a turn? The check that a found motion has to pass.
# ----------------------------------------------------------------------------


class Balance(NamedTuple):
    """Work over a turn (...,) in J, and what is left over; angular momentum in N m s.

    `gas`, `friction` and `mounts` are what these take up. `residual` is the work of the motor less
    all of them and would be zero. `momentum` is the mean angular momentum about the crank axis,
    `momentum_residual` how far it strays in the turn from what the torque of the mounts explains.
    """

    motor: FloatArray
    gas: FloatArray
    friction: FloatArray
    mounts: FloatArray
    residual: FloatArray
    momentum: FloatArray
    momentum_residual: FloatArray


def balance(machine: RollMachine, turn: Turn, read: Readings) -> Balance:
    """Work of every torque and the course of the angular momentum, from the points of a turn."""
    moved = inertia(machine, turn.crank_angle)
    motor = np.sum(turn.weight * read.motor_torque, axis=-1)
    gas = -np.sum(turn.weight * read.gas_torque, axis=-1)
    friction = -np.sum(turn.weight * read.friction_torque, axis=-1)
    rate = turn.weight / turn.crank_speed
    mounts = -np.sum(rate * read.mount_torque * turn.shell_speed, axis=-1)
    momentum = moved.shell * turn.shell_speed + moved.coupling * turn.crank_speed
    middle = np.sum(rate * momentum, axis=-1) / turn.period
    if is_mounted(machine):
        # over a turn the mounts may not change it
        strayed = np.abs(np.sum(rate * read.mount_torque, axis=-1))
    else:
        strayed = np.max(np.abs(momentum - middle[..., None]), axis=-1)
    return Balance(
        motor, gas, friction, mounts, motor - gas - friction - mounts, middle, np.asarray(strayed)
    )


# ----------------------------------------------------------------------------
# What the textbook leaves out: forces at constant speed in a shell that stands still.
#
# Herold (1977) concludes that these assumptions cost little in the forces; here by how much.
# ----------------------------------------------------------------------------


def constant_speed(turn: Turn) -> Turn:
    """The turn with the same mean speed held all the time, and the shell at rest."""
    speed = 2.0 * np.pi / turn.period[..., None]
    still = np.zeros_like(turn.shell_speed)
    return turn._replace(
        time=turn.crank_angle / speed,
        crank_speed=np.broadcast_to(speed, turn.crank_speed.shape),
        shell_speed=still,
        shell_angle=still,
    )


def classical(machine: RollMachine, drive: RollDrive, turn: Turn) -> dict[str, FloatArray]:
    """Forces (..., k, c), N, under the textbook's assumptions at the points of `turn`, by name."""
    held = constant_speed(turn)
    still = np.zeros_like(held.crank_speed)
    moved, gas = inertia(machine, held.crank_angle), gas_forces(machine, drive, held.crank_angle)
    both = piston_forces(machine, held, moved, gas, shell_acceleration=still, acceleration=still)
    return dict(zip(("rod_force", "wall_force"), both, strict=True))


def by_cylinder(turn: Turn, values: FloatArray, orders: FloatArray) -> ComplexArray:
    """Harmonics (..., c, orders) of what has one column for each cylinder, (..., k, c)."""
    each = [harmonics(turn, values[..., place], orders) for place in range(values.shape[-1])]
    return np.stack(each, axis=-2)


# ----------------------------------------------------------------------------
# Harmonics that are there but smaller than what the points leave open of them.
# ----------------------------------------------------------------------------

#: values at the points of which no spectrum is shown
_NOT_SHOWN = frozenset({"friction_torque", "gas_force"})
#: those with an entry for each cylinder
_OF_PISTONS = frozenset({"rod_force", "wall_force"})
_SAFE = 2.0


def rounding_left(machine: RollMachine, read: Readings, name: str) -> float:
    """What rounding leaves in the harmonics of one reading of one machine (B = 1), its own unit."""
    size = float(np.max(np.abs(getattr(read, name)), initial=0.0))
    if name.endswith("_acceleration"):
        # the torques balance each other before anything is left
        crank = float(np.max(np.abs(read.motor_torque)) + np.max(np.abs(read.gas_torque)))
        size += crank / float(machine.shell_inertia[0])
    return 32.0 * EPSILON * size


def hides(machine: RollMachine, drive: RollDrive, one: Turn, other: Turn, orders: int) -> bool:
    """Whether a harmonic above rounding is smaller than about the difference of the two turns.

    It would pass for zero, and be none.
    """
    both = [readings(machine, drive, turn) for turn in (one, other)]
    numbers = np.arange(1.0, orders + 1)
    for name in Readings._fields:
        if name in _NOT_SHOWN:
            continue
        first, second = (
            spectrum(turn, read, name, numbers)
            for turn, read in zip((one, other), both, strict=True)
        )
        rounding = rounding_left(machine, both[1], name)
        size, apart = np.abs(second), np.abs(second - first)
        if np.any((size > _SAFE * rounding) & (size <= _SAFE * apart + rounding)):
            return True
    return False


# ----------------------------------------------------------------------------
# The highest peak of a function of the crank angle over a turn, smooth or not.
# ----------------------------------------------------------------------------

_FULL = 2.0 * np.pi
#: coarse samples of a turn, rounds of closer ones at most, peaks followed
_COARSE, _ROUNDS, _PEAKS = 720, 60, 4
#: of an interval, how far next to a parabola's top samples are; more left of it is slow progress,
#: less the sign of a smooth peak
_CLOSE, _SLOW, _SMOOTH = 0.025, 0.3, 0.1
#: values that differ by so many roundings are alike
_FLAT = 16.0
#: a peak rises at most by so many times what the last samples added
_RISES = 16.0


def peak(
    values_at: Callable[[FloatArray], FloatArray],
    known: tuple[FloatArray, FloatArray] | None = None,
) -> tuple[float, float]:
    """Largest value of a function of the crank angle over a turn, and what sampling leaves open.

    `values_at` takes ascending angles (k,) in [0, 2 pi). `known` are ascending angles (k,) within a
    turn that resolve the function, with its values there; without, a coarse sampling comes first.
    Then each of the highest peaks is closed in between two angles: by a parabola, and where that
    does not help, as next to a jump or a kink, by even steps. Next to a jump, as of friction at a
    dead centre, or with peaks of nearly one height, the coarse sampling may take the wrong one, so
    that several are followed until they cannot be the highest. The error is the gain of the last
    samples.
    """
    if known is None:
        angles = np.linspace(0.0, _FULL, _COARSE, endpoint=False)
        known = angles, values_at(angles)
    at, values = _brackets(*known)
    best, gain = float(np.max(values)), np.inf
    even = np.zeros(len(at), dtype=bool)
    for _ in range(_ROUNDS):
        near = _sample_angles(at, values, even)
        turned = np.mod(near, _FULL)
        turned = np.where(turned < _FULL, turned, 0.0)
        order = np.argsort(turned, axis=None, kind="stable")
        sampled = np.empty(near.size)
        sampled[order] = values_at(turned.ravel()[order])
        width, top = at[:, 2] - at[:, 0], values[:, 1]
        at, values = _closer(at, values, near, sampled.reshape(near.shape))
        shrunk = (at[:, 2] - at[:, 0]) / np.maximum(width, np.finfo(float).tiny)
        even = ~even & (shrunk > _SLOW)
        gain, best = float(np.max(values)) - best, max(best, float(np.max(values)))
        # a smooth peak, which a parabola closes in at once, that is far below cannot win
        smooth = shrunk < _SMOOTH
        may = ~smooth | (values[:, 1] + _RISES * (values[:, 1] - top) >= best)
        at, values, even = at[may], values[may], even[may]
        # a sample that gains nothing proves nothing while the values next to it are lower
        flat = values[:, 1] - values.min(axis=1) <= _FLAT * EPSILON * abs(best)
        flat &= at[:, 2] - at[:, 0] < _FULL * EPSILON**0.5
        if np.all(flat | (at[:, 2] - at[:, 0] <= _FLAT * EPSILON * _FULL)):
            break
    return best, abs(gain)


def _brackets(angles: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The highest few of the samples that are no lower than their neighbours, with these.

    Angles and values (peaks, 3); angles may lie a little outside the turn.
    """
    before, after = np.roll(values, 1), np.roll(values, -1)
    tops = np.flatnonzero((values >= before) & (values >= after))
    tops = tops[np.argsort(-values[tops], kind="stable")][:_PEAKS]
    place = tops[:, None] + np.array([-1, 0, 1])
    turns, place = np.divmod(place, len(values))
    return angles[place] + _FULL * turns, values[place]


def _sample_angles(at: FloatArray, values: FloatArray, even: BoolArray) -> FloatArray:
    """Angles (peaks, 3) to sample next: close about the parabola's top, or in even steps."""
    left, right = at[:, 1] - at[:, 0], at[:, 2] - at[:, 1]
    tiny = np.finfo(float).tiny
    up = (values[:, 1] - values[:, 0]) / np.maximum(left, tiny)
    down = (values[:, 2] - values[:, 1]) / np.maximum(right, tiny)
    bend = up - down
    curved = (bend > 0.0) & (left > 0.0) & (right > 0.0) & ~even
    slope = (up * right + down * left) / np.maximum(left + right, tiny)
    top = at[:, 1] + np.where(curved, 0.5 * slope * (left + right), 0.0) / np.where(
        curved, bend, 1.0
    )
    width = at[:, 2] - at[:, 0]
    about = np.clip(top[:, None] + _CLOSE * width[:, None] * np.array([-1.0, 0.0, 1.0]),
                    at[:, :1], at[:, 2:])  # fmt: skip
    steps = at[:, :1] + width[:, None] * np.array([0.25, 0.5, 0.75])
    return np.asarray(np.where(curved[:, None], about, steps))


def _closer(
    at: FloatArray, values: FloatArray, near: FloatArray, sampled: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The highest of the old and new angles of each peak between its neighbours."""
    angles, heights = np.concatenate([at, near], axis=1), np.concatenate([values, sampled], axis=1)
    order = np.argsort(angles, axis=1, kind="stable")
    angles = np.take_along_axis(angles, order, axis=1)
    heights = np.take_along_axis(heights, order, axis=1)
    place = np.argmax(heights, axis=1)[:, None] + np.array([-1, 0, 1])
    place = np.clip(place, 0, angles.shape[1] - 1)
    return np.take_along_axis(angles, place, axis=1), np.take_along_axis(heights, place, axis=1)
