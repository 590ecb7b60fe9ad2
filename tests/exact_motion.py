"""The piston's motion in many digits, by sampling: a slow and obvious truth for tests.

Written without anything from the package. Numbers are mpmath's, at the caller's precision.
"""

from collections.abc import Callable
from typing import NamedTuple

import mpmath
from mpmath import mpc, mpf


class Motion(NamedTuple):
    """Harmonics of s (m) and of the torque -s' s'' (m^2), orders 0 .. highest, and s(angle).

    `at` gives position, velocity and acceleration per crank angle (m) at an angle.
    """

    position: list[mpc]
    torque: list[mpc]
    at: Callable[[mpf], tuple[mpf, mpf, mpf]]


def exact_motion(
    radius: mpf, length: mpf, offset: mpf, terms: int | None, digits: int = 26
) -> Motion:
    """Motion of a slider-crank, exact, or of the series cut after `terms`.

    Orders reach until n^2 C_n is below 10^-digits of the first.
    """
    if terms is None:
        at = _on_a_rod(radius, length, offset)
        reach = (radius + abs(offset)) / length
        decay = -mpmath.log(reach / (1 + mpmath.sqrt(1 - reach**2)))
        highest = 4
        while highest**2 * mpmath.exp(-decay * highest) > mpf(10) ** -digits:
            highest += 2
        samples = 2 * highest + int(40 / decay) + 8
    else:
        at = _cut_series(radius, length, terms)
        highest = 4 * terms + 2  # the torque of a cut series ends at twice its highest order
        samples = 3 * highest
    samples += samples % 2
    angles = [2 * mpmath.pi * j / samples for j in range(samples)]
    points = [at(angle) for angle in angles]
    waves = [mpmath.expj(-angle) for angle in angles]
    position = _transform([point[0] for point in points], waves, highest)
    torque = _transform([-point[1] * point[2] for point in points], waves, highest)
    return Motion(position, torque, at)


def _transform(values: list[mpf], waves: list[mpc], highest: int) -> list[mpc]:
    """C_n of Re sum C_n exp(i n t), from equally spaced samples."""
    count = len(values)
    found = [mpc(sum(values)) / count]
    for n in range(1, highest + 1):
        real = sum(v * waves[n * j % count].real for j, v in enumerate(values))
        imag = sum(v * waves[n * j % count].imag for j, v in enumerate(values))
        found.append(2 * mpc(real, imag) / count)
    return found


def _on_a_rod(radius: mpf, length: mpf, offset: mpf) -> Callable[[mpf], tuple[mpf, mpf, mpf]]:
    """By the angle b of the rod: L sin b = R sin t - e, s = R cos t + L cos b."""

    def at(angle: mpf) -> tuple[mpf, mpf, mpf]:
        sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
        rod_sine = (radius * sine - offset) / length
        rod_cosine = mpmath.sqrt(1 - rod_sine**2)
        swing = radius * cosine / (length * rod_cosine)
        bend = (-radius * sine + length * rod_sine * swing**2) / (length * rod_cosine)
        return (
            radius * cosine + length * rod_cosine,
            -radius * sine - length * rod_sine * swing,
            -radius * cosine - length * (rod_cosine * swing**2 + rod_sine * bend),
        )

    return at


def _cut_series(radius: mpf, length: mpf, terms: int) -> Callable[[mpf], tuple[mpf, mpf, mpf]]:
    """L sqrt(1 - u) to the power `terms` of u = (R/L sin t)^2, derivatives by the chain rule."""
    factors = [(-1) ** j * mpmath.binomial(mpf(1) / 2, j) for j in range(terms + 1)]
    square = (radius / length) ** 2

    def at(angle: mpf) -> tuple[mpf, mpf, mpf]:
        sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
        u, du, ddu = square * sine**2, 2 * square * sine * cosine, 2 * square * (1 - 2 * sine**2)
        root = sum(b * u**j for j, b in enumerate(factors))
        slope = sum(b * j * u ** (j - 1) for j, b in enumerate(factors) if j)
        bend = sum(b * j * (j - 1) * u ** (j - 2) for j, b in enumerate(factors) if j > 1)
        return (
            radius * cosine + length * root,
            -radius * sine + length * slope * du,
            -radius * cosine + length * (bend * du**2 + slope * ddu),
        )

    return at
