"""The cylinders of a pump in many digits, from the case alone: valves, volumes, work, torque.

Written without anything from the package. Numbers are mpmath's, at the caller's precision; angles
are a cylinder's own, from where its crank points along it, which is near top dead centre.
"""

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
from mpmath import mpc, mpf

from vibecalc.core.results.record import Record
from vibecalc.schema import Case

#: nodes of Gauss's rule; longest panel and largest phase of the highest order over one, in rad;
#: steps that halve a turn below 50 digits
NODES, PANEL, PHASE, HALVINGS = 32, 0.4, 24.0, 176
ROOT = "excitation/pump/"


class PumpTruth:
    """Dead centres, valve events and torque of one cylinder, and the turn of each one of them."""

    def __init__(self, case: Case) -> None:
        train = case.machine.crank_train
        given = train.pump_cycle
        assert given is not None
        self.radius, self.length = mpf(train.crank_radius), mpf(train.rod_length)
        self.offset = mpf(train.wrist_pin_offset)
        self.area = mpmath.pi * mpf(train.bore or 0) ** 2 / 4
        self.suction, self.discharge = mpf(given.suction_pressure), mpf(given.discharge_pressure)
        self.modulus, self.dead = mpf(given.bulk_modulus), mpf(given.dead_volume)
        self.outside = mpf(given.outside_pressure)
        self.top = mpmath.asin(self.offset / (self.length + self.radius))
        self.bottom = mpmath.pi + mpmath.asin(self.offset / (self.length - self.radius))
        self.outer, self.inner = self.place(self.top), self.place(self.bottom)
        self.swept = self.area * (self.outer - self.inner)
        self.full, self.end = self.dead + self.swept, self.top + 2 * mpmath.pi
        # one falls from the discharge pressure, the other rises from the suction pressure
        self.opens = _crossing(lambda t: self.expanding(t) - self.suction, self.top, self.bottom)
        self.closes = _crossing(
            lambda t: self.discharge - self.compressing(t), self.bottom, self.end
        )
        named = None if case.excitation is None else case.excitation.working
        #: angles by which the cylinders that work are ahead of the crank
        self.ahead = [
            mpf(one.crank_phase) - mpf(one.bank_angle)
            for one in train.cylinders
            if named is None or one.name in named
        ]
        orders = (None if case.excitation is None else case.excitation.orders) or 0
        self.samples = list(self._samples(min(PANEL, PHASE / max(orders, 1))))

    def place(self, angle: mpf) -> mpf:
        """Of the wrist pin, along the cylinder."""
        across = self.radius * mpmath.sin(angle) - self.offset
        return self.radius * mpmath.cos(angle) + mpmath.sqrt(self.length**2 - across**2)

    def volume(self, angle: mpf) -> mpf:
        return self.dead + self.area * (self.outer - self.place(angle))

    def expanding(self, angle: mpf) -> mpf:
        """Pressure of what is left at top dead centre, both valves shut."""
        return self.discharge - self.modulus * mpmath.log(self.volume(angle) / self.dead)

    def compressing(self, angle: mpf) -> mpf:
        """Pressure of a full cylinder, both valves shut."""
        return self.suction + self.modulus * mpmath.log(self.full / self.volume(angle))

    def pressure(self, angle: mpf) -> mpf:
        """Absolute, at an angle of any turn."""
        turned = angle
        while turned < self.top:
            turned += 2 * mpmath.pi
        while turned >= self.end:
            turned -= 2 * mpmath.pi
        if turned < self.bottom:
            return self.expanding(turned) if turned < self.opens else self.suction
        return self.compressing(turned) if turned < self.closes else self.discharge

    def torque_at(self, angle: mpf) -> mpf:
        """Torque of the gauge pressure by the lever of the rod's line about the crank."""
        sine, cosine = mpmath.sin(angle), mpmath.cos(angle)
        across = self.radius * sine - self.offset
        rod = mpmath.sqrt(self.length**2 - across**2)
        lever = self.radius * (sine + cosine * across / rod)
        return (self.pressure(angle) - self.outside) * self.area * lever

    def _samples(self, longest: float) -> Iterator[tuple[mpf, mpc]]:
        """Torque times weight over a turn, and exp(-i angle), of panels between the events."""
        events = [self.top, self.opens, self.bottom, self.closes, self.end]
        for low, high in pairwise(events):
            panels = int(mpmath.ceil((high - low) / longest))
            width = (high - low) / panels
            for panel in range(panels):
                for node, weight in gauss(NODES, mpmath.mp.dps):
                    angle = low + (panel + node) * width
                    share = weight * width / (2 * mpmath.pi)
                    yield self.torque_at(angle) * share, mpmath.expj(-angle)

    def mean(self) -> mpf:
        """Mean torque of one cylinder."""
        return mpmath.fsum(value for value, _ in self.samples)

    def harmonics(self, highest: int) -> list[mpc]:
        """Of the torque of one cylinder, orders 1 to `highest` of its own angle."""
        rest, found = [2 * value * turn for value, turn in self.samples], []
        turns = [turn for _, turn in self.samples]
        for _ in range(highest):
            found.append(mpmath.fsum(rest))
            rest = [value * turn for value, turn in zip(rest, turns, strict=True)]
        return found

    def together(self, own: list[mpc]) -> list[mpc]:
        """Harmonics of all cylinders over the crank angle, from those of one."""
        return [
            value * mpmath.fsum(mpmath.expj(order * angle) for angle in self.ahead)
            for order, value in enumerate(own, start=1)
        ]

    def many(self, highest: int) -> np.ndarray:
        """The same as `together`, in doubles, for as many orders as one likes."""
        nodes, weights = np.polynomial.legendre.leggauss(20)
        value, turn = [], []
        events = [self.top, self.opens, self.bottom, self.closes, self.end]
        for (low, high), pressed in zip(pairwise(events), range(4), strict=True):
            start, width = float(low), float(high - low)
            panels = int(np.ceil(width * highest / 12.0))
            place = (np.arange(panels)[:, None] + 0.5 + 0.5 * nodes) / panels
            angle = start + width * place
            weight = np.broadcast_to(0.5 * weights * width / panels / np.pi, place.shape)
            value.append((weight * self._torque_in_doubles(angle, pressed)).ravel())
            turn.append(np.exp(-1j * angle).ravel())
        rest, once = np.concatenate(value).astype(complex), np.concatenate(turn)
        ahead = np.array([float(angle) for angle in self.ahead])
        found = np.empty(highest, dtype=complex)
        for order in range(1, highest + 1):
            rest = rest * once
            found[order - 1] = rest.sum() * np.exp(1j * order * ahead).sum()
        return found

    def _torque_in_doubles(self, angle: np.ndarray, piece: int) -> np.ndarray:
        r, length, e = (float(one) for one in (self.radius, self.length, self.offset))
        across = r * np.sin(angle) - e
        rod = np.sqrt(length**2 - across**2)
        most = float(self.dead + self.area * self.outer)
        volume = most - float(self.area) * (r * np.cos(angle) + rod)
        modulus, low, high = (float(x) for x in (self.modulus, self.suction, self.discharge))
        pressure = (
            high - modulus * np.log(volume / float(self.dead)),
            np.full_like(angle, low),
            low + modulus * np.log(float(self.full) / volume),
            np.full_like(angle, high),
        )[piece]
        lever = r * (np.sin(angle) + np.cos(angle) * across / rod)
        return np.asarray((pressure - float(self.outside)) * float(self.area) * lever)


def pump_rows(case: Case, record: Record, pump: PumpTruth) -> Iterator[tuple[str, Any, Any]]:
    """Every result of the cylinders, what was found and what is exact."""
    rate, count = mpf(case.machine.speed) / (2 * mpmath.pi), len(pump.ahead)
    drawn, mean = pump.full - pump.volume(pump.opens), pump.mean()
    order, angle = (
        record[f"{ROOT}{name}"].axes[0].values.tolist() for name in ("torque", "pressure")
    )
    # the crank gives the liquid what the liquid takes from the crank
    work = -2 * mpmath.pi * mean
    for name, exact in (
        ("suction_opens", pump.opens - pump.top),
        ("discharge_opens", pump.closes - pump.bottom),
        ("swept_volume", pump.swept),
        ("volumetric_efficiency", drawn / pump.swept),
        ("flow", count * rate * drawn),
        ("work", work),
        ("power", count * rate * work),
        ("mean_torque", count * mean),
        ("torque", pump.together(pump.harmonics(len(order)))),
        ("pressure", [pump.pressure(mpf(one)) for one in angle]),
    ):
        yield f"{ROOT}{name}", record[f"{ROOT}{name}"].values, exact


def _crossing(falling: Callable[[mpf], mpf], low: mpf, high: mpf) -> mpf:
    """Where a function that falls through zero does so, by bisection."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if falling(middle) > 0 else (low, middle)
    return (low + high) / 2


@cache
def gauss(count: int, digits: int) -> list[tuple[mpf, mpf]]:
    """Nodes on (0, 1) and weights of Gauss's rule, by Newton's method on Legendre's recurrence."""
    found = []
    with mpmath.workdps(digits + 5):
        for k in range(count):
            x = mpmath.cos(mpmath.pi * (k + mpf(3) / 4) / (count + mpf(1) / 2))
            for _ in range(8):
                before, here = mpf(1), x
                for n in range(2, count + 1):
                    before, here = here, ((2 * n - 1) * x * here - (n - 1) * before) / n
                slope = count * (x * here - before) / (x**2 - 1)
                x -= here / slope
            found.append(((1 - x) / 2, 1 / ((1 - x**2) * slope**2)))
    return found
