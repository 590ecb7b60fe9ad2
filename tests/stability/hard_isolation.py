"""Hard cases of a machine on its mounts: narrow and half-order peaks, exact zeros, masks.

Gibson (2008): his peak is one arbitrary instant per speed and adds magnitudes without phases.
"""

from functools import cache

import mpmath
import numpy as np
from exact_peaks import peak
from isolation_machines import (
    COUPLE,
    INERTIA,
    LEVER,
    ORDERS,
    RADIUS_TO_ROD,
    gibson,
    gibson_couple,
    rows_of,
)
from stability.hard_case import HardCase, Numbers, Way, condition_of, singular

from vibecalc.excitation.balance import balance_table
from vibecalc.isolation.run_up import Range, run_up
from vibecalc.numerics.bounded import Bounded, concatenate

STIFFNESS, ARM = 1e4, 0.4


def rows_at(
    speed: mpmath.mpf, damping: mpmath.mpf, stiffness: mpmath.mpf, inertia: mpmath.mpf
) -> list[list[mpmath.mpc]]:
    """Couple through the mounts over the lever, orders 1 and 2, from the equation of motion."""
    k, c = (4 * one * mpmath.mpf(ARM) ** 2 for one in (stiffness, damping))
    row = []
    for n, part in ((1, mpmath.mpc(0, -1)), (2, mpmath.mpc(0, 1) * mpmath.mpf(RADIUS_TO_ROD))):
        w = n * speed
        couple = mpmath.mpf(float(COUPLE)) * part * speed**2
        through = mpmath.mpc(k, w * c)
        row.append(couple * through / (through - w**2 * inertia) / mpmath.mpf(LEVER))
    return [row]


def highest(
    damping: mpmath.mpf, stiffness: mpmath.mpf, inertia: mpmath.mpf, order: int
) -> list[mpmath.mpf]:
    """Largest force and its speed, next to where an order meets the natural frequency."""
    near = mpmath.sqrt(4 * stiffness * mpmath.mpf(ARM) ** 2 / inertia) / order
    if order == 1:
        near *= 1 + 2 * (4 * damping * mpmath.mpf(ARM) ** 2 / (inertia * near * 2)) ** 2
    return list(peak(lambda v: rows_at(v, damping, stiffness, inertia), [1, 2], near))


@cache
def truth_of(damping: float, order: int) -> Numbers:
    with mpmath.workdps(60):
        data = (mpmath.mpf(one) for one in (damping, STIFFNESS, float(INERTIA)))
        return highest(*data, order)


def own_peak(damping: float, stop: float) -> Bounded:
    pitch, readout = gibson(damping)
    couple = gibson_couple()
    rows = rows_of(pitch, readout, ORDERS, couple)
    seen = np.ones((1, 5), dtype=bool)
    met = pitch.resonances(couple[:, None])
    found = run_up(Range(rows, ORDERS, met, 0.0, stop, seen)).peak
    value, speed = found.value.ravel()[0], found.speed.ravel()[0]
    uncertainty = np.array([found.error.ravel()[0], found.speed_error.ravel()[0]])
    return Bounded(np.array([value, speed]), uncertainty)


def forces(damping: float, speed: np.ndarray) -> np.ndarray:
    """Harmonics (speeds, 2) in plain floats."""
    k, c = 4 * STIFFNESS * ARM**2, 4 * damping * ARM**2
    w = speed[:, None] * ORDERS
    through = k + 1j * w * c
    couple = COUPLE * np.array([-1j, 1j * RADIUS_TO_ROD]) * speed[:, None] ** 2
    return np.asarray(couple * through / (through - w**2 * INERTIA) / LEVER)


def on_grid(damping: float, stop: float, step: float, way: str) -> np.ndarray:
    """Highest point over a grid of speeds: over the cycle, of magnitudes, or at one instant."""
    speed = np.arange(step, stop, step)
    with np.errstate(divide="ignore", invalid="ignore"):
        harmonics = forces(damping, speed)
    if way == "magnitudes":
        height = np.sum(np.abs(harmonics), axis=1)
    else:
        angle = np.zeros(1) if way == "instant" else np.linspace(0.0, 2.0 * np.pi, 73)
        wave = np.exp(1j * np.multiply.outer(ORDERS, angle))
        height = np.max(np.abs((harmonics @ wave).real), axis=1)
    best = int(np.argmax(height))
    return np.array([height[best], speed[best]])


def narrow(name: str, damping: float, order: int) -> HardCase:
    stop = 200.0 if order == 1 else 25.0
    return HardCase(
        name,
        lambda: condition_of(lambda c, k, j: highest(c, k, j, order), damping, STIFFNESS,
                             float(INERTIA)),
        lambda: truth_of(damping, order), lambda: own_peak(damping, stop),
        (Way("grid of .05 rad/s and 5 degrees",
             lambda: on_grid(damping, stop, 0.05, "cycle")),
         Way("magnitudes added, the same grid",
             lambda: on_grid(damping, stop, 0.05, "magnitudes")),
         Way("one instant of each speed, the same grid",
             lambda: on_grid(damping, stop, 0.05, "instant"))),
    )  # fmt: skip


def masked() -> HardCase:
    stop = 200.0
    return HardCase(
        "run-up through an undamped resonance", singular, None,
        lambda: own_peak(0.0, stop),
        (Way("grid of .05 rad/s and 5 degrees", lambda: on_grid(0.0, stop, 0.05, "cycle")),),
    )  # fmt: skip


PHASES = {count: 2.0 * np.pi * np.arange(count) / count for count in (3, 4)}


def own_sum(count: int) -> Bounded:
    phase = PHASES[count]
    one, two = np.zeros(count), np.arange(count, dtype=float)
    table = balance_table(np.array([1, 2]), crank_phase=phase, bank_angle=one, position=two)
    return concatenate([table["total_sine"], table["total_cosine"]])


def plain_sum(count: int) -> np.ndarray:
    angle = np.multiply.outer(np.array([1, 2]), PHASES[count])
    return np.concatenate([np.sin(angle).sum(axis=1), np.cos(angle).sum(axis=1)])


def zeros() -> HardCase:
    return HardCase(
        "three cranks at 120 degrees: the sums of the balance table are zero",
        singular, lambda: [mpmath.mpf(0)] * 4, lambda: own_sum(3),
        (Way("sums in plain floats, which say nothing", lambda: plain_sum(3), loose=True),),
        scale=1.0,
    )  # fmt: skip


def cases() -> tuple[HardCase, ...]:
    return (
        narrow("run-up peak of the source's machine", 50.0, 1),
        narrow("order 2 at half the natural frequency, damping ratio 1e-7", 0.063, 2),
        masked(),
        zeros(),
    )  # fmt: skip
