"""The connecting rod in many digits, from positions alone: a slow and obvious truth for tests.

Written without anything from the package. Numbers are mpmath's, at the caller's precision; speeds
are one radian per second. In the plane of the crank the first component runs outwards along the
cylinder, the second 90 degrees ahead in the crank's sense of rotation.
"""

from collections.abc import Callable, Sequence

import mpmath
from mpmath import mpc, mpf

Point = tuple[mpf, mpf]


def fourier(signal: Callable[[mpf], mpf], orders: Sequence[int], samples: int) -> list[mpc]:
    """C_n of Re sum C_n exp(i n t) by the trapezoidal rule."""
    values = [signal(2 * mpmath.pi * j / samples) for j in range(samples)]
    waves = [mpmath.expjpi(mpf(-2) * j / samples) for j in range(samples)]
    found = []
    for n in orders:
        total = mpmath.fdot(values, [waves[n * j % samples] for j in range(samples)])
        found.append(total * (1 if n == 0 else 2) / samples)
    return found


def rod_angle(angle: mpf, radius: mpf, length: mpf, offset: mpf) -> mpf:
    """phi, from sin phi = (R sin t - e) / L."""
    return mpmath.asin((radius * mpmath.sin(angle) - offset) / length)


def bearings(angle: mpf, radius: mpf, length: mpf, offset: mpf) -> tuple[Point, Point]:
    """Crank pin and wrist pin."""
    pin = (radius * mpmath.cos(angle), radius * mpmath.sin(angle))
    reach = mpmath.sqrt(length**2 - (pin[1] - offset) ** 2)
    return pin, (pin[0] + reach, mpf(offset))


def on_the_rod(share: mpf, *geometry: mpf) -> Callable[[mpf], Point]:
    """Path of the point that lies at `share` of the way from the crank pin to the wrist pin."""

    def at(angle: mpf) -> Point:
        pin, wrist = bearings(angle, *geometry)
        return tuple(p + share * (w - p) for p, w in zip(pin, wrist, strict=True))

    return at


def couple_of(masses: Sequence[tuple[mpf, Callable[[mpf], Point]]], angle: mpf) -> mpf:
    """Couple on the body about the crank axis: minus sum m r x a, positive as the crank turns."""
    total = mpf(0)
    for mass, path in masses:
        here = path(angle)
        pull = [mpmath.diff(lambda t, i=i, path=path: path(t)[i], angle, 2) for i in (0, 1)]
        total -= mass * (here[0] * pull[1] - here[1] * pull[0])
    return total


def energy_of(masses: Sequence[tuple[mpf, Callable[[mpf], Point]]], angle: mpf) -> mpf:
    """Kinetic energy."""
    total = mpf(0)
    for mass, path in masses:
        speed = [mpmath.diff(lambda t, i=i, path=path: path(t)[i], angle) for i in (0, 1)]
        total += mass * (speed[0] ** 2 + speed[1] ** 2) / 2
    return total


def three_masses(mass: mpf, first: mpf, inertia: mpf, *geometry: mpf) -> list:
    """A rod of mass m, its centre at l1 from the crank pin, of moment J: at pins and centre."""
    length = geometry[1]
    second = length - first
    upper, lower = inertia / (second * length), inertia / (first * length)
    return [
        (upper, on_the_rod(mpf(1), *geometry)),
        (lower, on_the_rod(mpf(0), *geometry)),
        (mass - upper - lower, on_the_rod(first / length, *geometry)),
    ]


def two_masses(mass: mpf, first: mpf, *geometry: mpf) -> list:
    """The rod as its two point masses at the pins."""
    share = first / geometry[1]
    return [
        (mass * share, on_the_rod(mpf(1), *geometry)),
        (mass * (1 - share), on_the_rod(mpf(0), *geometry)),
    ]
