"""Exact motion of slave rods hinged on a master rod, at crank angles and as harmonics."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# A slave rod turns about a knuckle pin that is fixed on the master rod, at the distance r from the
# crank pin and at the angle gamma from the master rod's axis, in the sense of rotation. In the
# plane of the crank, stroke + i ahead of it, with the crank at the angle t, the master in the
# cylinder at the angle b0 and the slave in that at b:
#
#     crank pin   R exp(i t),
#     master rod  D = exp(i (b0 + psi)),  L sin psi = o - R sin(t - b0),
#     knuckle pin z = R exp(i t) + r exp(i gamma) D,
#     slave pin   s = u + sqrt(l^2 - (v - o)^2),   u + i v = z exp(-i b),
#
# L and l the lengths of master and slave, o the offset of the cylinder axes. The slave rod stands
# at the angle b + chi with l sin chi = o - v. All derivatives are by the crank angle. (Own
# derivation; cf. Biezeno and Grammel, Technische Dynamik, ch. XI.)
# ----------------------------------------------------------------------------


class SlaveRods(NamedTuple):
    """k slaves (k, 1) of one machine, lengths in m, angles in rad; crank radius, L, o are numbers.

    `phase` is that of the throw, `master_bank` and `bank` the angles of both cylinders.
    """

    crank_radius: float
    master_length: float
    wrist_pin_offset: float
    phase: FloatArray
    master_bank: FloatArray
    bank: FloatArray
    knuckle_radius: FloatArray
    knuckle_angle: FloatArray
    rod_length: FloatArray


class SlaveMotion(NamedTuple):
    """Wrist pin of each slave along its cylinder, its knuckle pin in the plane of the crank.

    Position with first and second derivative by the crank angle, (k, ...) in m; the knuckle pin is
    complex: along the stroke + i ahead of it. `turn` and `bend` are the first and second
    derivative of the angle of the slave rod, positive in the crank's sense of rotation.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    knuckle: ComplexArray
    knuckle_velocity: ComplexArray
    knuckle_acceleration: ComplexArray
    turn: FloatArray
    bend: FloatArray


def slave_motion(rods: SlaveRods, crank_angle: FloatArray) -> SlaveMotion:
    """Motion of k slaves at crank angles (...) or (k, ...), rad."""
    radius, length, offset = rods.crank_radius, rods.master_length, rods.wrist_pin_offset
    turned = crank_angle + rods.phase
    pin = radius * np.exp(1j * turned)
    local = turned - rods.master_bank
    aside = offset - radius * np.sin(local)
    upright = np.sqrt((length - aside) * (length + aside))
    swing = -radius * np.cos(local) / upright
    bend = (radius * np.sin(local) + aside * swing * swing) / upright
    arm = (upright + 1j * aside) / length
    arm = arm * (rods.knuckle_radius * np.exp(1j * (rods.master_bank + rods.knuckle_angle)))
    knuckle = pin + arm
    velocity = 1j * pin + 1j * swing * arm
    acceleration = -pin + (1j * bend - swing * swing) * arm
    back = np.exp(-1j * rods.bank)
    place, rate, change = knuckle * back, velocity * back, acceleration * back
    across = place.imag - offset
    rod = np.sqrt((rods.rod_length - across) * (rods.rod_length + across))
    pull = across / rod
    turn = -rate.imag / rod
    return SlaveMotion(
        place.real + rod,
        rate.real - pull * rate.imag,
        change.real - pull * change.imag - rate.imag**2 * (1.0 + pull * pull) / rod,
        knuckle,
        velocity,
        acceleration,
        turn,
        -(change.imag + across * turn * turn) / rod,
    )


# ----------------------------------------------------------------------------
# Harmonics of what follows from the motion, by transforms that are refined until they converge.
# ----------------------------------------------------------------------------

#: samples of a turn at first and at most
FIRST_SAMPLES, MOST_SAMPLES = 256, 65536
#: roundings of a sample, of the largest
SAMPLE_ROUNDINGS = 16.0


def harmonics_of_turn(signals: Callable[[FloatArray], FloatArray], highest: int) -> Bounded:
    """One-sided harmonics (..., highest + 1), 0-to-peak, of real signals (..., n) over a turn.

    `signals` takes crank angles (n,). The motion is analytic in the crank angle, so that the
    harmonics fall off geometrically: samples are doubled until the upper half of what they resolve
    is within rounding. The error holds that and the rounding of the samples, which the transform
    spreads evenly.

    Raises NumericalFailure where 65536 samples do not suffice.
    """
    samples = FIRST_SAMPLES
    while samples < 4 * (highest + 1):
        samples *= 2
    while True:
        angle = 2.0 * np.pi * np.arange(samples) / samples
        values = signals(angle)
        series = np.fft.rfft(values, axis=-1) * (2.0 / samples)
        series[..., 0] *= 0.5
        size = np.max(np.abs(values), axis=-1)
        upper = np.abs(series[..., samples // 4 :]).max(axis=-1)
        rounding = SAMPLE_ROUNDINGS * EPSILON * size
        if np.all(upper <= rounding):
            break
        if samples >= MOST_SAMPLES:
            raise NumericalFailure(
                f"articulated rods: {samples} crank angles do not resolve the motion of a slave "
                "rod; a rod this close to its dead position has no usable harmonics"
            )
        samples *= 2
    error = np.broadcast_to((rounding + upper)[..., None], series.shape)
    return Bounded(series[..., : highest + 1], error[..., : highest + 1])


def dead_centres(
    motion: Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]],
) -> tuple[Bounded, Bounded, Bounded]:
    """Crank angles (k,) in rad of top and bottom dead centre, and the stroke (k,) in m, of pistons.

    `motion` takes crank angles (n,) or (k, 1) and gives position, velocity and acceleration (k, n).
    Newton's method starts from the best of a grid.

    Raises NumericalFailure where a dead centre is not found.
    """
    grid = 2.0 * np.pi * np.arange(FIRST_SAMPLES) / FIRST_SAMPLES
    position = motion(grid)[0]
    ends = []
    for best in (np.argmax(position, axis=-1), np.argmin(position, axis=-1)):
        angle = grid[best][:, None]
        for _ in range(12):
            _, velocity, acceleration = motion(angle)
            step = velocity / acceleration
            angle = angle - step
        place, velocity, acceleration = motion(angle)
        if not np.all(np.abs(step) < 1e-9):
            raise NumericalFailure("articulated rods: a dead centre of a piston was not found")
        size = np.abs(position).max(axis=-1, keepdims=True)
        slip = np.abs(step) + SAMPLE_ROUNDINGS * EPSILON * (1.0 + size / np.abs(acceleration))
        ends.append((Bounded(np.mod(angle, 2.0 * np.pi), slip)[:, 0],
                     Bounded(place, SAMPLE_ROUNDINGS * EPSILON * size)[:, 0]))  # fmt: skip
    (top, high), (bottom, low) = ends
    return top, bottom, high - low
