"""Torque of the cylinders of an engine in long arithmetic, from the case alone.

Pressure cards from their definitions (straight lines, periodic splines, computed cycles), integrals
by Gauss's rule on short panels, the slider-crank exact. Angles count from a cylinder's own firing.
"""

from functools import cache
from itertools import pairwise
from typing import Any

import mpmath
from mpmath import mp, mpc, mpf

from vibecalc.excitation.model import cycle_of, firing_angle
from vibecalc.excitation.pressure_cycle import PressureCycle
from vibecalc.schema import Case

#: nodes of the rule, longest panel in rad, samples of the inertia over a turn
NODES, PANEL, SAMPLES = 20, 0.55, 160


class Card:
    """Gauge pressure over a cycle: `at(angle)`, smooth between the ascending `breaks`."""

    def __init__(self, breaks: list[mpf], at: Any) -> None:
        self.breaks, self.at = breaks, at


class Cylinder:
    """One cylinder: motion of its pin, harmonics of its torques."""

    def __init__(self, case: Case) -> None:
        train = case.machine.crank_train
        self.radius, self.length = mpf(train.crank_radius), mpf(train.rod_length)
        self.offset = mpf(train.wrist_pin_offset)
        self.area = mp.pi * mpf(train.bore or 0) ** 2 / 4
        self.cycle = (4 if (case.machine.cycle or "four_stroke") == "four_stroke" else 2) * mp.pi

    def path(self, angle: mpf) -> tuple[mpf, mpf, mpf]:
        """Place of the pin and its derivatives by the angle."""
        r, e = self.radius, self.offset
        sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
        across = r * sine - e
        rod = mpmath.sqrt(self.length**2 - across**2)
        first = -r * sine - across * r * cosine / rod
        bend = (r * cosine) ** 2 - across * r * sine + (across * r * cosine / rod) ** 2
        return r * cosine + rod, first, -r * cosine - bend / rod

    def rocking(self, angle: mpf) -> mpf:
        """phi' phi'' of the rod."""
        r, length, e = self.radius, self.length, self.offset
        sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
        across = (r * sine - e) / length
        root = mpmath.sqrt(1 - across**2)
        first = r / length * cosine / root
        second = (-r / length * sine + across * first**2) / root
        return first * second

    @property
    def stroke(self) -> mpf:
        far = mpmath.sqrt((self.length + self.radius) ** 2 - self.offset**2)
        return far - mpmath.sqrt((self.length - self.radius) ** 2 - self.offset**2)

    def gas(self, card: Card, orders: list[mpf]) -> tuple[list[mpc], mpf]:
        """Harmonics and mean of -p A s' over the cycle."""
        places, weights = _rule()
        base = 2 * mp.pi / self.cycle
        steps = [int(mpmath.nint(q / base)) for q in orders]
        total, mean = [mpc(0)] * (max(steps, default=0) + 1), mpf(0)
        for low, high in pairwise(card.breaks):
            panels = max(1, int(mpmath.ceil((high - low) / PANEL)))
            width = (high - low) / panels
            for panel in range(panels):
                for place, weight in zip(places, weights, strict=True):
                    angle = low + (panel + place) * width
                    value = -card.at(angle) * self.area * self.path(angle)[1] * weight * width
                    mean += value
                    turn = mpmath.expj(-base * angle)
                    term = mpc(value)
                    for step in range(1, len(total)):
                        term *= turn
                        total[step] += term
        return [2 * total[step] / self.cycle for step in steps], mean / self.cycle

    def inertia(self, mass: mpf, rod: mpf, orders: list[mpf]) -> list[mpc]:
        """Harmonics of -(m s' s'' + dJ phi' phi'') per (rad/s)^2."""
        values = []
        for n in range(SAMPLES):
            angle = 2 * mp.pi * n / SAMPLES
            _, first, second = self.path(angle)
            values.append(-(mass * first * second + rod * self.rocking(angle)))
        return [
            2 * mpmath.fsum(v * mpmath.expj(-2 * mp.pi * ((int(q) * n) % SAMPLES) / SAMPLES)
                            for n, v in enumerate(values)) / SAMPLES
            if q == int(q) else mpc(0)
            for q in orders
        ]  # fmt: skip


class EngineDrive:
    """All cylinders: harmonics by card, masses, firing angles, what misfires."""

    def __init__(self, case: Case, orders: list[float], all_fire: bool = False) -> None:
        self.orders = [mpf(q) for q in orders]
        self.cylinder = one = Cylinder(case)
        train, machine = case.machine.crank_train, case.machine
        self.speeds, self.cards = cards_of(case, one)
        self.gas = [one.gas(card, self.orders) for card in self.cards]
        self.mass, self.rod = masses_of(case)
        self.moved = one.inertia(mpf(1), mpf(0), self.orders)
        self.rocked = one.inertia(mpf(0), mpf(1), self.orders)
        self.first, self.firing = exact_firing(case, one.cycle)
        for own, angle in zip(self.firing, firing_angle(machine), strict=True):
            assert abs(mp.expj(self.first + own) - mp.expj(mpf(angle))) < 1e-9
        torsion = None if case.response is None else case.response.torsion
        silent = () if all_fire or torsion is None else torsion.misfire
        self.scale = [
            mpf(0) if c.name in silent else mpf(1 if c.pressure_scale is None else c.pressure_scale)
            for c in train.cylinders
        ]

    def weights(self, speed: mpf) -> list[mpf]:
        """Of the cards at a speed: straight lines between neighbours."""
        if len(self.cards) == 1:
            return [mpf(1)]
        found = [mpf(0)] * len(self.cards)
        for k, (low, high) in enumerate(pairwise(self.speeds)):
            if low <= speed <= high and not any(found):
                found[k + 1] = (speed - low) / (high - low)
                found[k] = 1 - found[k + 1]
        return found

    def healthy(self, speed: mpf) -> tuple[list[mpc], mpf]:
        """Gas harmonics and mean of a healthy cylinder."""
        share = self.weights(speed)
        parts = list(zip(share, self.gas, strict=True))
        gas = [mpmath.fsum(s * g[0][k] for s, g in parts) for k in range(len(self.orders))]
        return gas, mpmath.fsum(s * g[1] for s, g in parts)

    def own_inertia(self, mass: mpf) -> list[mpc]:
        return [mass * m + self.rod * r for m, r in zip(self.moved, self.rocked, strict=True)]

    def torques(self, speed: mpf) -> list[list[mpc]]:
        """Of every cylinder, by order, turned to its firing."""
        gas, _ = self.healthy(speed)
        rows = []
        for scale, mass, angle in zip(self.scale, self.mass, self.firing, strict=True):
            own = self.own_inertia(mass)
            rows.append([
                (scale * g + speed**2 * i) * mpmath.expj(-q * angle)
                for g, i, q in zip(gas, own, self.orders, strict=True)
            ])  # fmt: skip
        return rows


def masses_of(case: Case) -> tuple[list[mpf], mpf]:
    """Reciprocating masses, and the moment of a rod beyond that of its two points."""
    train = case.machine.crank_train
    rod, common, beyond = train.rod, mpf(train.reciprocating_mass or 0), mpf(0)
    if train.reciprocating_mass is None:
        assert rod is not None
        length = mpf(train.rod_length)
        if rod.reciprocating_fraction is not None:
            first = mpf(rod.reciprocating_fraction) * length
        else:
            first = mpf(rod.crank_pin_to_mass_centre)
        common = mpf(train.piston_mass or 0) + mpf(train.pin_mass or 0)
        common += mpf(rod.mass) * first / length
        if rod.inertia is not None:
            beyond = mpf(rod.inertia) - mpf(rod.mass) * first * (length - first)
    own = [c.reciprocating_mass for c in train.cylinders]
    return [common if mass is None else mpf(mass) for mass in own], beyond


def exact_firing(case: Case, cycle: mpf) -> tuple[mpf, list[mpf]]:
    """Crank angle of the first firing, and all from there: as said, or one after the other."""
    train = case.machine.crank_train
    own = {c.name: c for c in train.cylinders}
    if not train.firing_order:
        # as the case says it, or at the dead centre it was given
        said = [
            mpf(angle if c.firing_angle is None else c.firing_angle) % cycle
            for c, angle in zip(train.cylinders, firing_angle(case.machine).tolist(), strict=True)
        ]
        return min(said), [one - min(said) for one in said]
    first = own[train.firing_order[0]]
    angle = (mpf(first.bank_angle) - mpf(first.crank_phase)) % (2 * mp.pi)
    angle = mpf(0) if 2 * mp.pi - angle < 1e-9 else angle
    steps = [mpf(s) for s in train.firing_intervals] or [cycle / len(own)] * len(own)
    found, since = {}, mpf(0)
    for name, step in zip(train.firing_order, steps, strict=True):
        found[name] = since % cycle
        since += step
    return angle, [found[c.name] for c in train.cylinders]


def cards_of(case: Case, one: Cylinder) -> tuple[list[mpf], list[Card]]:
    train = case.machine.crank_train
    cubic = train.gas_interpolation == "cubic"
    if train.gas_cards:
        cards = sorted(train.gas_cards, key=lambda card: card.speed)
        made = [table_card(c.gas_pressure, one.cycle, cubic) for c in cards]
        return [mpf(card.speed) for card in cards], made
    if train.gas_pressure is not None:
        return [], [table_card(train.gas_pressure, one.cycle, cubic)]
    return [], [cycle_card(case, one)]


def table_card(table: Any, cycle: mpf, cubic: bool) -> Card:
    """Straight lines, or the periodic cubic spline, through the rows."""
    node = [mpf(a) for a in table.crank_angle]
    node[-1] = node[0] + cycle
    value = [mpf(p) for p in table.pressure]
    value[-1] = value[0]
    count = len(node) - 1
    step = [b - a for a, b in pairwise(node)]
    rise = [(b - a) / h for (a, b), h in zip(pairwise(value), step, strict=True)]
    bend = [mpf(0)] * (count + 1)
    if cubic:
        matrix, right = mpmath.matrix(count, count), mpmath.matrix(count, 1)
        for k in range(count):  # second derivatives at the nodes
            before = (k - 1) % count
            matrix[k, before] += step[before]
            matrix[k, k] += 2 * (step[before] + step[k])
            matrix[k, (k + 1) % count] += step[k]
            right[k] = 6 * (rise[k] - rise[before])
        found = mpmath.lu_solve(matrix, right)
        bend = [*found, found[0]]

    def at(angle: mpf) -> mpf:
        away = angle
        while away >= node[-1]:
            away -= cycle
        while away < node[0]:
            away += cycle
        k = max(i for i in range(count) if node[i] <= away)
        x, h = away - node[k], step[k]
        slope = rise[k] - h * (2 * bend[k] + bend[k + 1]) / 6
        return value[k] + x * (slope + x * (bend[k] / 2 + x * (bend[k + 1] - bend[k]) / (6 * h)))

    return Card(node, at)


def cycle_card(case: Case, one: Cylinder) -> Card:
    """The computed cycle from its formula; its level is linear in what it has to reach."""
    given: PressureCycle = cycle_of(case.machine)
    c = type(given)(*(mpf(v) if isinstance(v, float) else v for v in given))
    top = mpmath.sqrt((one.length + one.radius) ** 2 - one.offset**2)

    def volume(angle: mpf) -> mpf:
        way = top - one.path(angle)[0]
        return 1 + (mpf(given.compression_ratio) - 1) * way / one.stroke

    def step(x: mpf) -> mpf:
        x = min(max(x, mpf(0)), mpf(1))
        return x**3 * (10 + x * (6 * x - 15))

    start = volume(c.inlet_closes)
    held = volume(c.injection_ends) if c.kind == "diesel" else mpf(1)

    def burnt(angle: mpf) -> mpf:
        return step((angle - c.combustion_starts) / (c.combustion_ends - c.combustion_starts))

    def base(angle: mpf) -> mpf:
        share = 1 - burnt(angle)
        if share == 0:
            return share
        return share * c.intake_pressure * (start / volume(angle)) ** c.compression_exponent

    def unit(angle: mpf) -> mpf:
        share = burnt(angle)
        if share == 0:
            return share
        if c.kind == "diesel" and angle <= c.injection_ends:
            return share
        return share * (volume(angle) / held) ** -c.expansion_exponent

    def card(level: mpf) -> Card:
        # angles of the code are roundings of what they are meant to be; the card takes pi as pi
        end = c.inlet_closes + one.cycle
        pi = mp.pi

        def at(angle: mpf) -> mpf:
            angle = (angle - c.inlet_closes) % one.cycle + c.inlet_closes
            blown = step((angle - c.exhaust_opens) / (pi - c.exhaust_opens))
            if c.stroke == "four_stroke":
                filled = step((angle - 2 * pi + c.overlap) / (2 * c.overlap))
            else:
                filled = step((angle - pi) / (end - pi))
            outside = c.exhaust_pressure + filled * (c.intake_pressure - c.exhaust_pressure)
            closed = mpf(0) if blown == 1 else base(angle) + level * unit(angle)
            return (1 - blown) * closed + blown * outside - c.crankcase_pressure

        inside = {c.combustion_starts, c.combustion_ends, c.exhaust_opens, pi}
        if c.kind == "diesel":
            inside.add(c.injection_ends)
        if c.stroke == "four_stroke":
            inside |= {2 * pi - c.overlap, 2 * pi + c.overlap}
        return Card([c.inlet_closes, *sorted(inside), end], at)

    wanted = case.machine.crank_train.gas_cycle
    assert wanted is not None
    if wanted.peak_pressure is not None:
        return card(_level_of_peak(mpf(wanted.peak_pressure), base, unit, c))
    works = []
    for level in (mpf(0), mpf(given.intake_pressure)):
        mean = one.gas(card(level), [])[1]
        works.append(mean * one.cycle / (one.area * one.stroke))
    gain = (works[1] - works[0]) / mpf(given.intake_pressure)
    return card((mpf(wanted.mean_indicated_pressure) - works[0]) / gain)


def _level_of_peak(peak: mpf, base: Any, unit: Any, c: Any) -> mpf:
    """Least level that some angle of the combustion allows, by ever closer looks."""
    last = max(c.combustion_ends, c.injection_ends, mpf(0))
    low, high = c.combustion_starts, last
    best = mpf("inf")
    for _ in range(24):
        grid = [low + (high - low) * k / 16 for k in range(17)]
        allowed = [(peak - base(a)) / unit(a) if unit(a) > 0 else mpf("inf") for a in grid]
        at = allowed.index(min(allowed))
        best = min(best, allowed[at])
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, 16)]
    return best


@cache
def _rule() -> tuple[list[mpf], list[mpf]]:
    """Gauss's places and weights on (0, 1)."""
    import numpy as np

    with mpmath.workdps(60):
        places, weights = [], []
        for x in np.polynomial.legendre.leggauss(NODES)[0].tolist():
            root = mpmath.findroot(lambda t: mpmath.legendre(NODES, t), mpf(x))
            slope = NODES * (root * mpmath.legendre(NODES, root)
                             - mpmath.legendre(NODES - 1, root)) / (root**2 - 1)  # fmt: skip
            places.append((1 + root) / 2)
            weights.append(1 / ((1 - root**2) * slope**2))
    return places, weights
