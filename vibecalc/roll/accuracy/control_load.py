"""The load on the rotor at constant speed as harmonics: panels, samples, and thirty digits."""

from itertools import pairwise
from math import ceil, pi
from typing import Any

import numpy as np

from vibecalc.core.accuracy.other_integrators import harmonics_of_samples
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import EPSILON, ComplexArray
from vibecalc.roll.adapters.control import Setup
from vibecalc.roll.between_kinks import Slots, slots_of
from vibecalc.roll.control.loop import disturbance
from vibecalc.roll.mechanism import RollMachine, gas_forces, member, smooth_angles
from vibecalc.roll.rates import place_at

#: digits of the reference, and its Gauss points between two kinks
_DIGITS, _POINTS = 30, 14
#: what vibecalc takes on a panel: points next to those of the highest order, and a finer look
_OWN, _MORE = 10, 4
_SAMPLES = (36.0, 72.0, 144.0, 360.0, 1440.0, 3600.0)


def load_topic(given: Setup) -> Topic:
    """Mean and harmonics of the torque on the rotor at the target speed, N m."""
    orders = len(given.orders)
    return Topic(
        stage="control",
        name="load",
        words=f"mean and harmonics 1 to {orders} of the load on the rotor at the target speed",
        quantity="response/control/disturbance",
        unit="N*m",
        work="crank angles at which gas and inertia are taken",
        reference=lambda: _reference(given, orders),
        solvers=(
            Solver(
                "two Gauss rules",
                "panels between all kinks, two numbers of points on each; as a run does",
                "",
                NOTHING_TO_SET,
                lambda _: _own(given, orders),
                default=NOTHING_TO_SET[0],
            ),
            Solver(
                "Gauss panels", "one rule on each panel between kinks", "points a panel",
                (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0),
                lambda points: _panels(given, orders, int(points)), theory="geometric",
            ),
            Solver(
                "Fourier transform of samples", "even angles, blind to the kinks of the gas",
                "angles a turn", _SAMPLES, lambda count: _samples(given, orders, int(count)),
                theory="order 2",
            ),
            Solver(
                "sums with the two-term stroke",
                "as published: the piston's motion cut after its second harmonic",
                "angles a turn", _SAMPLES, lambda count: _two_terms(given, orders, int(count)),
                citation="Herold (1977), section 7.1",
            ),
        ),
        default_extra=6.0,
        default_why="two rules prove the error, and their points do for any table of gas forces",
    )  # fmt: skip


def _of(gas: np.ndarray, slope: np.ndarray, speed: float) -> ComplexArray:
    """Mean, then harmonics, from sums of the load and of half the slope of Q."""
    found = gas - speed**2 * slope
    # in a whole turn Q comes back to itself: its slope has no mean
    found[0] = gas[0]
    return np.asarray(found)


def _own(given: Setup, orders: int) -> Answer:
    found = disturbance(given.machine, given.drive, orders)
    values = np.append(found.mean.value + 0j, found.at(given.target).value)
    points = _OWN + ceil(0.5 * orders * pi / 18.0)
    panels = len(smooth_angles(given.machine, given.drive)) - 1
    return Answer(values, float(panels * (2 * points + _MORE)))


def _panels(given: Setup, orders: int, points: int) -> Answer:
    edges, rule = smooth_angles(given.machine, given.drive), gauss_rule(points)
    widths = np.diff(edges)[:, None]
    angle = (edges[:-1, None] + widths * rule.nodes).ravel()
    weight = (widths * rule.weights).ravel() / (2.0 * pi)
    place = place_at(given.machine, given.drive, angle[None])
    wave = np.exp(-1j * np.arange(orders + 1)[:, None] * angle) * weight
    wave[1:] *= 2.0
    values = _of(wave @ place.load[0], 0.5 * (wave @ place.moved.crank_slope[0]), given.target)
    return Answer(values, float(len(angle)))


def _samples(given: Setup, orders: int, count: int) -> Answer:
    angle = np.linspace(0.0, 2.0 * pi, count, endpoint=False, dtype=np.float64)
    place = place_at(given.machine, given.drive, angle[None])
    gas, slope = (
        harmonics_of_samples(part[0], orders) for part in (place.load, place.moved.crank_slope)
    )
    return Answer(_of(gas, 0.5 * slope, given.target), float(count))


def _two_terms(given: Setup, orders: int, count: int) -> Answer:
    machine = given.machine
    angle = np.linspace(0.0, 2.0 * pi, count, endpoint=False, dtype=np.float64)
    own = angle[:, None] + machine.crank_angle_offset[0]
    radius = float(machine.crank_radius[0])
    ratio = radius / float(machine.rod_length[0])
    stroke = -radius * (np.sin(own) + 0.5 * ratio * np.sin(2.0 * own))
    bend = -radius * (np.cos(own) + ratio * np.cos(2.0 * own))
    forces = gas_forces(machine, given.drive, angle[None])[0]
    load = -np.sum(forces * stroke, axis=1) - float(machine.friction_torque[0])
    inertia = np.sum(machine.reciprocating_mass[0] * stroke * bend, axis=1)
    gas, slope = (harmonics_of_samples(part, orders) for part in (load, inertia))
    return Answer(_of(gas, slope, given.target), float(count))


def _reference(given: Setup, orders: int) -> Reference:
    alone = RollMachine(*(field[0] for field in member(given.machine, 0)))
    drive = given.drive._replace(synchronous_speed=np.asarray(given.synchronous))
    slots = slots_of(alone, drive)
    if slots.tabled:
        values = _in_digits(alone, slots, orders, given.target)
        return Reference(
            values, 16.0 * EPSILON,
            f"{_POINTS} Gauss points between kinks in {_DIGITS} digits, formulas of their own",
        )  # fmt: skip
    fine, finer = (_panels(given, orders, points).values for points in (20, 28))
    apart = float(np.max(np.abs(fine - finer)) / np.max(np.abs(finer)))
    grid = _samples(given, orders, 1 << 14).values
    apart = max(apart, float(np.max(np.abs(grid - finer)) / np.max(np.abs(finer))))
    return Reference(
        finer, max(apart, 16.0 * EPSILON), "28 Gauss points a panel against 20 and 16384 samples"
    )


def _in_digits(machine: RollMachine, slots: Slots, orders: int, speed: float) -> ComplexArray:
    import mpmath as mp

    with mp.workdps(_DIGITS):
        rule = _rule(mp)
        sums = [mp.mpc(0) for _ in range(orders + 1)]
        square = mp.mpf(speed) ** 2
        edges = [mp.mpf(float(edge)) for edge in slots.edge]
        for slot, (low, high) in enumerate(pairwise(edges)):
            for node, weight in rule:
                angle = low + (high - low) * node
                torque = _torque(mp, machine, slots, slot, angle, square)
                share = torque * weight * (high - low) / (2 * mp.pi)
                wave = mp.expj(-angle)
                for order in range(orders + 1):
                    sums[order] += share
                    share *= wave
        doubled = [sums[0], *(2 * part for part in sums[1:])]
        return np.array([complex(part) for part in doubled])


def _torque(mp: Any, machine: RollMachine, slots: Slots, slot: int, angle: Any, square: Any) -> Any:
    """Gas, dry friction and inertia at a crank angle, N m; all from the closed forms."""
    radius, length, offset = (
        mp.mpf(float(part))
        for part in (machine.crank_radius, machine.rod_length, machine.wrist_pin_offset)
    )
    total = -mp.mpf(float(machine.friction_torque))
    rub = mp.mpf(float(machine.piston_friction))
    for place in range(slots.base.shape[0]):
        own = angle + mp.mpf(float(machine.crank_angle_offset[place]))
        high, lever = radius * mp.sin(own), radius * mp.cos(own)
        across = high - offset
        rod = mp.sqrt(length**2 - across**2)
        stroke = -high - lever * across / rod
        bend = high * across / rod - lever - (lever * length) ** 2 / rod**3
        away = angle - mp.mpf(float(slots.base[place, slot]))
        force = mp.mpf(0)
        for factor in slots.coefficient[place, slot, ::-1].tolist():
            force = force * away + mp.mpf(factor)
        tilt, tilted = -lever / rod, high / rod - across * lever**2 / rod**3
        moved = mp.mpf(float(machine.reciprocating_mass[place])) * stroke * bend
        moved += mp.mpf(float(machine.rod_inertia_difference[place])) * tilt * tilted
        total -= force * stroke + rub * abs(stroke) + square * moved
    return total


def _rule(mp: Any) -> list[tuple[Any, Any]]:
    """Gauss points and weights on [0, 1], polished from those of double precision."""
    found = []
    for start in gauss_rule(_POINTS).nodes.tolist():
        x = mp.mpf(2.0 * start - 1.0)
        for _ in range(3):
            before, now = mp.mpf(1), x
            for degree in range(2, _POINTS + 1):
                before, now = now, ((2 * degree - 1) * x * now - (degree - 1) * before) / degree
            slope = _POINTS * (x * now - before) / (x * x - 1)
            x -= now / slope
        found.append(((1 + x) / 2, 1 / ((1 - x * x) * slope**2)))
    return found
