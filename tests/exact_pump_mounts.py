"""A pump on its mounts under the torque of its liquid and what shakes it, in many digits.

Orders that are kept in long arithmetic. Largest values over a turn mean all orders: those beyond
are added in doubles, at least a thousand, and what still follows is reported as noise.
"""

import copy
from collections.abc import Callable, Iterator
from typing import Any

import mpmath
import numpy as np
from exact_body import BodyTruth
from exact_motion import exact_motion
from exact_parts import up_of
from exact_pump import PumpTruth
from exact_train import Shaking, frame_of, masses_of, vector
from mpmath import mpc, mpf

from vibecalc.core.results.record import Record
from vibecalc.core.results.renamed import current_path
from vibecalc.schema import Case

ROOT = "isolation/torque_reaction/"
CAUSES = "isolation/support_force/by_cause"
ORDERS, TIMES = 1024, 16
#: samples over a turn for each order; places that are examined closer, and how often
SAMPLES, CLOSER, ZOOMS = 8, 4, 4
ROUNDING = 1e-14


class ReactionTruth:
    """Couples by order, the motion they drive, and the same of many more orders."""

    def __init__(
        self, case: Case, body: BodyTruth, shaking: Shaking, pump: PumpTruth, kept: int
    ) -> None:
        self.body, self.kept, self.speed = body, kept, mpf(case.machine.speed)
        self.axis, self.up = frame_of(case).axis, up_of(case)
        self.shaking = shaking
        highest = max(ORDERS, TIMES * kept)
        self.number = np.arange(1, highest + 1)
        liquid, masses = pump.together(pump.harmonics(kept)), self._inertia(case)
        masses += [mpf(0)] * (highest - len(masses))
        self.couple = [-a - b for a, b in zip(liquid, masses[:kept], strict=True)]
        # a driven machine that stands on the body gives the mean back to it
        on_body = case.excitation is not None and case.excitation.driven_machine == "on_body"
        self.mean_couple = mpf(0) if on_body else -pump.mean() * len(pump.ahead)
        load = [self._shaken(n) + self.about(-q) for n, q in enumerate(liquid, start=1)]
        self.moved = self._motion(load)
        liquid_beyond = pump.many(highest)[kept:]
        beyond = [self._shaken(int(n)) for n in self.number[kept:]]
        shaken = np.array(beyond, dtype=complex) - self._in_doubles(liquid_beyond)
        self.wide = self._joined(self.moved, shaken)
        alone = -self._in_doubles(liquid_beyond + np.array(masses[kept:], dtype=complex))
        driven = self._motion([self.about(one) for one in self.couple])
        self.wide_of_torque = self._joined(driven, alone)

    def about(self, couple: mpf | mpc) -> np.ndarray:
        """Load of a couple about the crankshaft."""
        return np.concatenate([vector(0, 0, 0), couple * self.axis])

    def _in_doubles(self, couple: np.ndarray) -> np.ndarray:
        load = np.zeros((len(couple), 6), dtype=complex)
        load[:, 3:] = couple[:, None] * self.axis.astype(float)
        return load

    def _inertia(self, case: Case) -> list[mpc]:
        """Torque by order of the masses that go to and fro, of the motion without a cut."""
        train = case.machine.crank_train
        assert train.rod is None or train.rod.inertia is None
        lengths = map(mpf, (train.crank_radius, train.rod_length, train.wrist_pin_offset))
        masses, _ = masses_of(case)
        ahead = [mpf(one.crank_phase) - mpf(one.bank_angle) for one in train.cylinders]
        return [
            self.speed**2
            * one
            * mpmath.fsum(m * mpmath.expj(n * a) for m, a in zip(masses, ahead, strict=True))
            for n, one in enumerate(exact_motion(*lengths, None).torque)
            if n > 0
        ]

    def _shaken(self, n: int) -> np.ndarray:
        if n > len(self.shaking.orders):
            return np.concatenate([vector(0, 0, 0), vector(0, 0, 0)])
        force, couple = self.shaking.force[n - 1], self.shaking.couple[n - 1]
        return self.speed**2 * np.concatenate([force, couple])

    def _motion(self, loads: list[np.ndarray]) -> list[np.ndarray]:
        driven = copy.copy(self.body)
        driven.orders = list(range(1, len(loads) + 1))
        driven.load = [load / self.speed**2 for load in loads]
        return driven.motion(self.speed)

    def _joined(self, near: list[np.ndarray], loads: np.ndarray) -> np.ndarray:
        """Motion (orders, 6) in doubles: of the first orders as given, of the rest by loads."""
        body = self.body
        kept = body.kept
        block = np.ix_(kept, kept)
        mass, spring, damper, loss = (
            one[block].astype(float) for one in (body.mass, body.stiffness, body.damping, body.loss)
        )
        w = float(self.speed) * self.number[len(near) :, None, None]
        dynamic = spring - w**2 * mass + 1j * (loss + w * damper)
        rest = np.zeros(loads.shape, dtype=complex)
        rest[:, kept] = np.linalg.solve(dynamic, loads[:, kept, None])[..., 0]
        return np.concatenate([np.array([list(x) for x in near], dtype=complex), rest])

    def forces(self, motion: np.ndarray) -> list[np.ndarray]:
        """Of each mount on the ground, (3, orders), in doubles."""
        found = []
        for mount, seen in zip(self.body.mounts, self.body.seen, strict=True):
            spring, damper, loss = (one.astype(float) for one in mount[1:])
            way = motion @ seen.astype(float).T
            rate = 1j * float(self.speed) * self.number[:, None]
            found.append((way @ (spring + 1j * loss).T + rate * (way @ damper.T)).T)
        return found


def reaction_rows(
    record: Record, truth: ReactionTruth, noise: dict[str, float]
) -> Iterator[tuple[str, Any, Any]]:
    """Every result but the order that is nearest, which is a number of a row."""

    def reported(name: str, exact: Any) -> tuple[str, Any, Any]:
        path = current_path(f"{ROOT}{name}")
        return path, record[path].values, exact

    body = truth.body
    yield reported("couple", truth.couple)
    yield reported("mean_couple", truth.mean_couple)
    yield reported("translation", [x[:3].tolist() for x in truth.moved])
    yield reported("rotation", [x[3:].tolist() for x in truth.moved])
    driven = copy.copy(body)
    driven.orders = list(range(1, truth.kept + 1))
    yield reported("support_force", driven.rows(truth.speed, truth.moved))
    load = truth.about(truth.mean_couple)
    still = body.held(body.stiffness, load)
    mean = [m.stiffness @ (g @ still) for m, g in zip(body.mounts, body.seen, strict=True)]
    yield reported("mean_support_force", [one.tolist() for one in mean])
    order, frequency = record[f"{ROOT}nearest_order"].values.tolist(), body.modes()[0]
    yield reported("margin", [
        mpf(n) * truth.speed / w - 1 if n else mpf("inf")
        for n, w in zip(order, frequency, strict=True)
    ])  # fmt: skip
    yield from _over_the_turn(record, truth, mean, noise)


def _over_the_turn(
    record: Record, truth: ReactionTruth, mean: list[np.ndarray], noise: dict[str, float]
) -> Iterator[tuple[str, Any, Any]]:
    up = truth.up.astype(float)
    force, of_torque = truth.forces(truth.wide), truth.forces(truth.wide_of_torque)
    constant = [float(s - m @ truth.up) for s, m in zip(truth.body.share, mean, strict=True)]
    downwards = [-(up @ f)[None] for f in force]
    roll = (truth.wide[:, 3:] @ truth.axis.astype(float))[None]
    for name, each, measure, start in (
        ("roll_peak", [roll], length_of, [0.0]),
        ("support_force_peak", force, length_of, [0.0] * len(force)),
        ("support_force_of_torque", of_torque, length_of, [0.0] * len(force)),
        ("largest_load", downwards, _plain, constant),
        ("minimum_load", [-one for one in downwards], _plain, [-one for one in constant]),
    ):
        tops = [at + largest(one, measure) for one, at in zip(each, start, strict=True)]
        size = [float(np.abs(one).sum()) + abs(at) for one, at in zip(each, start, strict=True)]
        after = [float(np.abs(one[:, one.shape[1] // 2 :]).sum()) for one in each]
        path = CAUSES if name == "support_force_of_torque" else current_path(f"{ROOT}{name}")
        noise[path] = max(ROUNDING * s + a for s, a in zip(size, after, strict=True))
        found = -1.0 if name == "minimum_load" else 1.0
        values = record[path].values[:, 0] if path == CAUSES else record[path].values
        yield path, np.atleast_1d(values), [mpf(found * top) for top in tops]


def length_of(signal: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.square(signal).sum(axis=0)))


def _plain(signal: np.ndarray) -> np.ndarray:
    return np.asarray(signal[0])


def largest(harmonics: np.ndarray, measure: Callable[[np.ndarray], np.ndarray]) -> float:
    """Largest measure over a turn of signals (components, orders): a grid, and closer grids."""
    components, highest = harmonics.shape
    count = SAMPLES * highest
    spectrum = np.zeros((components, count), dtype=complex)
    spectrum[:, 1 : highest + 1] = harmonics
    height = measure(count * np.fft.ifft(spectrum, axis=1).real)
    peak = (height >= np.roll(height, 1)) & (height >= np.roll(height, -1))
    places = np.flatnonzero(peak)
    places = places[np.argsort(height[places])[-CLOSER:]]
    angle, step = 2.0 * np.pi * places / count, 2.0 * np.pi / count
    best = float(height.max())
    number = np.arange(1, highest + 1)
    for _ in range(ZOOMS):
        near = angle[:, None] + step * np.linspace(-1.0, 1.0, 17)
        seen = measure((harmonics @ np.exp(1j * np.outer(number, near.ravel()))).real)
        seen = seen.reshape(near.shape)
        angle, step = near[np.arange(len(near)), np.argmax(seen, axis=1)], step / 8.0
        best = max(best, float(seen.max()))
    return best
