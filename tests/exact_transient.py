"""A change in time of a shaft line, followed in modes of the damped line with Gauss's rule.

State: twists of springs and velocities of freedoms. Its eigenvectors part the equations; each is
integrated over panels so short that twelve points hold all digits. Nothing is shared with the
march of the package: no steps, no exponential of a matrix, no Legendre polynomials.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq
from study_inputs import StudyInputs

POINTS = 12
#: radians of the fastest of torque and line in a panel
PANEL = 0.45
#: of a sweep: share of a start and of other changes in which the acceleration grows, and fades
RAMP, SWING = 0.25, 0.1
STEPS = ("load_step", "misfire_onset")
#: two turns in the widest float
TURNS = 16 * np.arctan(np.longdouble(1))


class Part(NamedTuple):
    """Acceleration goes by `rate` and the scale of the gas along straight lines.

    Gas and load are those of the speed at each time where none are given.
    """

    duration: float
    acceleration: float
    rate: float
    scale: tuple[float, float] = (1.0, 1.0)
    gas: np.ndarray | None = None
    load: np.ndarray | None = None


class Plan(NamedTuple):
    """Parts, speed at the begin, shares (n,) that take what the mean leaves, time that moves."""

    parts: list[Part]
    speed: float
    share: np.ndarray
    steady: bool
    moving: tuple[float, float]


def plan(inputs: StudyInputs) -> Plan:
    """The motion that `[response.torsion.transient]` asks for, as docs/ describe it."""
    asked, speed = inputs.torsion.transient, inputs.speed
    n = len(inputs.inertia)
    if asked.kind in STEPS:
        gas, load = inputs.gas(speed), -inputs.taken(speed)
        if not inputs.ground.any():
            load[inputs.built.load_freedom] -= gas[:, 0].real.sum() + load.sum()
        after, left = load.copy(), gas
        if asked.kind == "load_step":
            at = inputs.built.station_names.index(asked.on)
            after[inputs.built.freedom[at]] -= asked.torque * abs(inputs.ratio[at])
        else:
            names = [str(k + 1) for k in range(len(inputs.built.cylinder_station))]
            left = gas - inputs.by_cylinder(speed)[names.index(asked.cylinder)]
        before = asked.before or inputs.cycle / speed
        parts = [
            Part(before, 0.0, 0.0, gas=gas, load=load),
            Part(asked.after, 0.0, 0.0, gas=left, load=after),
        ]
        return Plan(parts, speed, inputs.inertia, True, (0.0, 0.0))
    share = np.zeros(n)
    share[inputs.built.load_freedom] = 1.0
    starts = asked.kind == "start"
    begin, end = (0.0 if starts else asked.start), asked.stop
    grows = RAMP if starts else SWING
    whole = 1.0 - 0.5 * (grows + SWING)
    lasts = asked.duration or abs(end - begin) / asked.acceleration / whole
    before = 0.0 if begin == 0.0 else asked.before
    # the gas has a corner at each card
    passed = [
        brentq(lambda x, c=card: begin + (end - begin) * _gone(x, grows) - c, 0.0, 1.0, xtol=1e-15)
        for card in inputs.card_speed
        if min(begin, end) < card < max(begin, end)
    ]
    cuts = np.union1d([0.0, grows, 1.0 - SWING, 1.0], passed)
    level = np.minimum(np.minimum(cuts / grows, (1.0 - cuts) / SWING), 1.0)
    level *= (end - begin) / (lasts * whole)
    parts = [Part(before, 0.0, 0.0)] if before else []
    for k, length in enumerate(np.diff(cuts) * lasts):
        ramp = np.minimum(cuts[k : k + 2] / RAMP, 1.0) if starts else np.ones(2)
        rate = (level[k + 1] - level[k]) / length
        parts.append(Part(length, level[k], rate, (ramp[0], ramp[1])))
    if end > 0.0:
        parts.append(Part(asked.after, 0.0, 0.0))
    return Plan(parts, begin, share, begin > 0.0, (before, before + lasts))


def _gone(time: float, grows: float) -> float:
    """Share of the change of speed that lies behind at a share of its time."""
    whole = 1.0 - 0.5 * (grows + SWING)
    if time < grows:
        return 0.5 * time**2 / grows / whole
    if time > 1.0 - SWING:
        return 1.0 - 0.5 * (1.0 - time) ** 2 / SWING / whole
    return (time - 0.5 * grows) / whole


class ExactMotion:
    """States at the ends of panels, and anywhere by `at`; torques are referred to the crank."""

    def __init__(self, inputs: StudyInputs, finer: float = 1.0) -> None:
        self.inputs, self.plan = inputs, plan(inputs)
        #: extremes that were found, by section
        self.kept: dict[int, Any] = {}
        self._system()
        self._borders()
        self._march(finer)

    def _system(self) -> None:
        one, plan_ = self.inputs, self.plan
        n = len(one.inertia)
        held = np.flatnonzero(one.ground > 0.0)
        springs = np.flatnonzero(one.stiffness > 0.0)
        rows = np.concatenate([one.element[springs], np.eye(n)[held]])
        stiff = np.concatenate([one.stiffness[springs], one.ground[held]])
        root, mass = np.sqrt(stiff), np.sqrt(one.inertia)
        _, damping = one.matrices()
        s = len(stiff)
        matrix = np.zeros((s + n, s + n))
        matrix[:s, s:] = root[:, None] * rows / mass
        matrix[s:, :s] = -matrix[:s, s:].T
        matrix[s:, s:] = -damping / mass / mass[:, None]
        self.matrix, self.drive = matrix, np.concatenate([np.zeros((s, n)), np.diag(1.0 / mass)])
        view = np.zeros((len(one.first), s + n))
        view[springs, np.arange(len(springs))] = one.stiffness[springs] / root[: len(springs)]
        view[:, s:] = one.damping[:, None] * one.element / mass
        self.view = view
        self.balance = np.eye(n)
        if not len(held):
            self.balance = self.balance - np.outer(plan_.share / plan_.share.sum(), np.ones(n))
        self.values, self.vectors = np.linalg.eig(matrix)
        self.inverse = np.linalg.inv(self.vectors)

    def _borders(self) -> None:
        times, speeds, angles = [0.0], [self.plan.speed], [np.longdouble(0)]
        for part in self.plan.parts:
            d = np.longdouble(part.duration)
            angles.append(
                angles[-1] + d * (speeds[-1] + d * (part.acceleration / 2 + d * part.rate / 6))
            )
            speeds.append(max(speeds[-1] + part.duration * (
                part.acceleration + 0.5 * part.duration * part.rate), 0.0))  # fmt: skip
            times.append(times[-1] + part.duration)
        self.border, self.border_speed = np.array(times), np.array(speeds)
        self.border_angle = np.array(angles)
        self.end = float(times[-1])

    def place(self, time: np.ndarray) -> np.ndarray:
        """Number of the part in which each time lies."""
        found = np.searchsorted(self.border, time, side="right") - 1
        return np.clip(found, 0, len(self.plan.parts) - 1)

    def course(self, time: np.ndarray, place: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
        """Acceleration, speed, angle of the crank."""
        place = self.place(time) if place is None else place
        rows = [(p.acceleration, p.rate) for p in self.plan.parts]
        first, rate = np.moveaxis(np.array(rows)[place], -1, 0)
        since = time - self.border[place]
        speed = self.border_speed[place] + since * (first + 0.5 * rate * since)
        long = since.astype(np.longdouble)
        turned = long * (self.border_speed[place] + long * (first / 2 + long * rate / 6))
        return first + rate * since, speed, self.border_angle[place] + turned

    def time_of(self, angle: np.ndarray) -> np.ndarray:
        low, high = np.zeros(angle.shape), np.full(angle.shape, self.end)
        for _ in range(70):
            half = 0.5 * (low + high)
            later = self.course(half)[2] < angle
            low, high = np.where(later, half, low), np.where(later, high, half)
        return 0.5 * (low + high)

    def torque(self, time: np.ndarray, place: np.ndarray) -> np.ndarray:
        """Balanced torque (..., n) on every freedom."""
        one = self.inputs
        acceleration, speed, angle = self.course(time, place)
        reduced = np.asarray(angle % TURNS, dtype=float)
        wave = np.exp(1j * reduced[..., None] * one.order)
        out = np.empty((*time.shape, len(one.inertia)))
        mean_of = np.zeros(out.shape)
        for k in np.unique(place):
            part, here = self.plan.parts[k], place == k
            share = ((time[here] - self.border[k]) / part.duration)[:, None]
            scale = part.scale[0] + (part.scale[1] - part.scale[0]) * share
            load = -one.taken(np.maximum(speed[here], 0.0)) if part.load is None else part.load
            mean, waves = 0.0, 0.0
            for card, weight in self.cards(part, speed[here]):
                mean = mean + weight * card[:, 0].real
                waves = waves + weight * (wave[here] @ card[:, 1:].T).real
            own = (wave[here] @ one.inertial[:, 1:].T).real * speed[here][:, None] ** 2
            # the cylinders' inertia torques come in with their gas
            out[here] = scale * (waves + own)
            mean_of[here] = scale * mean + load
            mean_of[here] -= acceleration[here][:, None] * one.inertia
        total: np.ndarray = out + mean_of @ self.balance.T
        return total

    def cards(self, part: Part, speed: np.ndarray) -> Any:
        """Gas (n, m + 1) of each card, with its weight (t, 1) at speeds (t,)."""
        if part.gas is not None:
            return [(part.gas, 1.0)]
        one = self.inputs
        return zip(one.gas_of.sum(axis=1), one.weights(speed).T[..., None], strict=True)

    def given(self, part: Part, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """Gas (n, m + 1) and load (n,) at one speed."""
        one = self.inputs
        gas = one.gas(speed) if part.gas is None else part.gas
        return gas, -one.taken(speed) if part.load is None else part.load

    def steady_state(self, part: Part, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """State held by the mean, and amplitudes (m, s) of the orders at one speed."""
        one = self.inputs
        gas, load = self.given(part, speed)
        mean = self.balance @ (gas[:, 0].real + load)
        still = np.linalg.lstsq(self.matrix, -self.drive @ mean, rcond=1e-12)[0]
        force = gas[:, 1:] + speed**2 * one.inertial[:, 1:]
        size = np.eye(len(self.matrix))
        waves = [
            np.linalg.solve(1j * q * speed * size - self.matrix, self.drive @ force[:, k])
            for k, q in enumerate(one.order)
        ]
        return still, np.array(waves)

    def _march(self, finer: float) -> None:
        one = self.inputs
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        self.nodes, self.weights = 0.5 * (nodes + 1.0), 0.5 * weights
        fastest = float(np.abs(self.values).max())
        times = [np.zeros(1)]
        for k, part in enumerate(self.plan.parts):
            top = max(self.border_speed[k : k + 2]) * one.order[-1]
            count = max(24, int(np.ceil(part.duration * max(fastest, top) / PANEL * finer)))
            times.append(self.border[k] + part.duration * np.arange(1, count + 1) / count)
            times[-1][-1] = self.border[k + 1]
        self.time = np.concatenate(times)
        self.part_of = self.place(0.5 * (self.time[1:] + self.time[:-1]))
        if self.plan.steady:
            still, waves = self.steady_state(self.plan.parts[0], self.plan.speed)
            begin = still + waves.real.sum(axis=0)
        else:
            begin = np.zeros(len(self.matrix))
        width = np.diff(self.time)
        gain = self._integral(self.time[:-1], width, self.part_of)
        grown = np.exp(self.values * width[:, None])
        state = np.empty((len(self.time), len(self.values)), dtype=complex)
        state[0] = self.inverse @ begin
        for k in range(len(width)):
            state[k + 1] = grown[k] * state[k] + gain[k]
        self.modal = state
        self.state = (state @ self.vectors.T).real

    def _integral(self, start: np.ndarray, width: np.ndarray, place: np.ndarray) -> np.ndarray:
        at = start[:, None] + width[:, None] * self.nodes
        torque = self.torque(at, np.broadcast_to(place[:, None], at.shape))
        force = torque @ (self.inverse @ self.drive).T
        left = width[:, None] * (1.0 - self.nodes)
        fade = np.exp(left[..., None] * self.values) * (self.weights[:, None])
        total: np.ndarray = (fade * force).sum(axis=1) * width[:, None]
        return total

    def at(self, time: np.ndarray, place: np.ndarray | None = None) -> np.ndarray:
        """States (..., s) at any times."""
        time = np.asarray(time, dtype=float)
        panel = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        place = self.part_of[panel] if place is None else place
        width = time - self.time[panel]
        gain = self._integral(self.time[panel], width, place)
        modal = np.exp(self.values * width[:, None]) * self.modal[panel] + gain
        return (modal @ self.vectors.T).real

    def rates(self, state: np.ndarray, time: np.ndarray, place: np.ndarray) -> np.ndarray:
        return state @ self.matrix.T + self.torque(time, place) @ self.drive.T
