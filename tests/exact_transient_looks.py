"""What is read off an exact change in time: crests, swings, windows, waterfalls, steady ranges."""

from typing import NamedTuple

import numpy as np
from exact_transient import ExactMotion, Part
from study_inputs import StudyInputs

#: Gauss points of a panel of a waterfall's window
_LOOK = 10
#: crests of a steady vibration that are examined
_CRESTS = 4
#: times that speeds about peaks are laid closer
_LOOKS = 9


class Extremes(NamedTuple):
    """Times and referred values of all extremes of a section, kinks and ends among them."""

    time: np.ndarray
    value: np.ndarray


def extremes(motion: ExactMotion, section: int, carried: float = 0.0) -> Extremes:
    """Of a section's torque less `carried` times the crank's acceleration."""
    view, place = motion.view[section], motion.part_of

    def slope(state: np.ndarray, time: np.ndarray, at: np.ndarray) -> np.ndarray:
        rate = np.array([part.rate for part in motion.plan.parts])[at]
        return motion.rates(state, time, at) @ view - carried * rate

    begin = slope(motion.state[:-1], motion.time[:-1], place)
    end = slope(motion.state[1:], motion.time[1:], place)
    here = np.flatnonzero(begin * end < 0.0)
    low, high, own = motion.time[here], motion.time[here + 1], place[here]
    f_low, f_high = begin[here], end[here]
    # false position with halved ends, to the last digits that matter at a peak
    for _ in range(5):
        time = high - f_high * (high - low) / (f_high - f_low)
        f = slope(motion.at(time, own), time, own)
        up = f * f_low > 0.0
        low, f_high = np.where(up, time, low), np.where(up, 0.5 * f_high, f)
        high, f_low = np.where(up, high, time), np.where(up, f, 0.5 * f_low)
    # corners lie where a part begins
    every = np.sort(np.concatenate([time, motion.border]))
    states = motion.at(every)
    return Extremes(every, states @ view - carried * motion.course(every)[0])


def windows(
    motion: ExactMotion, found: Extremes, section: int, time: np.ndarray, cycle: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Lowest and highest torque (k,) in a cycle about each time, and begins and ends of these."""
    middle = motion.course(time)[2]
    starts, ends = (motion.time_of(middle + side * 0.5 * cycle) for side in (-1.0, 1.0))
    border = motion.at(np.concatenate([starts, ends])) @ motion.view[section]
    border = border.reshape(2, -1)
    low, high = border.min(axis=0), border.max(axis=0)
    for k in range(len(time)):
        inside = found.value[(found.time >= starts[k]) & (found.time <= ends[k])]
        low[k] = min(low[k], inside.min(initial=np.inf))
        high[k] = max(high[k], inside.max(initial=-np.inf))
    return low, high, starts, ends


class Swing(NamedTuple):
    """Half ranges of pairs of extremes within a cycle, and the times midway."""

    half: np.ndarray
    middle: np.ndarray


def swings(
    motion: ExactMotion, found: Extremes, section: int, cycle: float, span: tuple[float, float]
) -> Swing:
    """All pairs between two times; of those a whole cycle apart the largest."""
    ends = motion.at(np.array(span)) @ motion.view[section]
    inside = (found.time > span[0]) & (found.time < span[1])
    time = np.concatenate([span, found.time[inside]])
    value = np.concatenate([ends, found.value[inside]])
    angle = motion.course(time)[2].astype(float)
    i, j = np.triu_indices(len(time), 1)
    near = np.abs(angle[i] - angle[j]) <= cycle
    i, j = i[near], j[near]
    half, middle = 0.5 * np.abs(value[i] - value[j]), 0.5 * (time[i] + time[j])
    low, high = span[0], float(motion.time_of(motion.course(np.array([span[1]]))[2] - cycle)[0])
    if high > low:
        grid = np.linspace(low, high, 2001)
        for _ in range(4):
            far = motion.time_of(motion.course(grid)[2] + cycle)
            gap = 0.5 * np.abs((motion.at(far) - motion.at(grid)) @ motion.view[section])
            best = int(np.argmax(gap))
            half, middle = np.append(half, gap[best]), np.append(middle, 0.5 * (far + grid)[best])
            reach = grid[1] - grid[0]
            grid = np.linspace(max(grid[best] - reach, low), min(grid[best] + reach, high), 41)
    return Swing(half, middle)


def steady_twist(one: StudyInputs, speed: np.ndarray) -> np.ndarray:
    """Steady twists (k, m, e) at speeds."""
    stiffness, damping = one.matrices()
    gas = np.tensordot(np.array([one.weights(w) for w in speed]), one.gas_of.sum(axis=1), 1)
    force = gas[..., 1:] + speed[:, None, None] ** 2 * one.inertial[:, 1:]
    w = speed[:, None] * one.order
    matrix = stiffness + 1j * w[..., None, None] * damping
    index = np.arange(len(one.inertia))
    matrix[..., index, index] -= (w**2)[..., None] * one.inertia
    angle = np.linalg.solve(matrix, force.transpose(0, 2, 1)[..., None])[..., 0]
    twist: np.ndarray = angle @ one.element.T
    return twist


class SteadyCurve:
    """Largest steady half range of every section between any two speeds of a range."""

    def __init__(self, inputs: StudyInputs, low: float, high: float, points: int = 801) -> None:
        self.inputs = inputs
        speed = np.linspace(low, high, points)
        value = self.half_range(speed)
        width = speed[1] - speed[0]
        for look in range(_LOOKS):
            inner = value[1:-1]
            top = ((inner > value[:-2]) & (inner >= value[2:])).any(axis=1)
            # all peaks first, then the highest of each section
            tops = speed[1:-1][top] if look < 3 else np.unique(speed[value.argmax(axis=0)])
            close = (tops[:, None] + width * np.linspace(-1.0, 1.0, 13)).ravel()
            close = np.setdiff1d(close[(close > low) & (close < high)], speed)
            if not len(close):
                break
            both = np.concatenate([speed, close])
            order = np.argsort(both, kind="stable")
            value = np.concatenate([value, self.half_range(close)])[order]
            speed, width = both[order], width / 6.0
        self.speed, self.value = speed, value

    def half_range(self, speed: np.ndarray) -> np.ndarray:
        """Steady half ranges (k, e) at speeds."""
        one, w = self.inputs, speed[:, None, None] * self.inputs.order[:, None]
        stiff = one.stiffness + 1j * w * one.damping
        return span(steady_twist(one, speed) * stiff, one.order)[0]

    def largest(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Largest half range (k, e) between speeds."""
        out = np.maximum(self.half_range(low), self.half_range(high))
        first = np.searchsorted(self.speed, low)
        last = np.searchsorted(self.speed, high, side="right")
        for k in np.flatnonzero(last > first):
            out[k] = np.maximum(out[k], self.value[first[k] : last[k]].max(axis=0))
        return out


def span(torque: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half range and largest magnitude (...) of Re sum torque (..., m, e) exp(i q theta)."""
    step = 0.5 if np.any(order % 1.0) else 1.0
    count = 40 * round(order[-1] / step)
    rows = torque.swapaxes(-1, -2)
    at = np.arange(count) * (2.0 * np.pi / step / count)
    course = (rows @ np.exp(1j * np.outer(order, at))).real
    found = []
    for sign in (1.0, -1.0):
        side = sign * course
        crest = (side >= np.roll(side, 1, -1)) & (side > np.roll(side, -1, -1))
        # crests of nearly equal height are all examined
        place = np.argpartition(-np.where(crest, side, -np.inf), _CRESTS, axis=-1)[..., :_CRESTS]
        angle, parts = at[place], rows[..., None, :]
        for _ in range(4):
            turned = parts * np.exp(1j * angle[..., None] * order)
            first, second = (-(turned.imag * order).sum(-1), -(turned.real * order**2).sum(-1))
            move = np.where(second != 0.0, first / np.where(second != 0.0, second, 1.0), 0.0)
            angle = angle - np.clip(move, -0.5 * at[1], 0.5 * at[1])
        best = sign * (parts * np.exp(1j * angle[..., None] * order)).real.sum(-1)
        found.append(np.maximum(best.max(axis=-1), side.max(axis=-1)))
    return 0.5 * (found[0] + found[1]), np.stack([found[0], -found[1]])


def steady_largest(motion: ExactMotion, part: Part, speed: float) -> np.ndarray:
    """Largest magnitude (e,) of the steady vibration, its mean in it."""
    still, waves = motion.steady_state(part, speed)
    high, low = span(waves @ motion.view.T, motion.inputs.order)[1]
    mean = motion.view @ still
    largest: np.ndarray = np.maximum(np.abs(mean + high), np.abs(mean + low))
    return largest


def hann(
    motion: ExactMotion, section: int, rate: np.ndarray, middle: float, width: float, turned: bool
) -> np.ndarray:
    """Amplitudes (m,) in a Hann window about a time; its width in rad if `turned`, else in s."""
    place = float(motion.course(np.array([middle]))[2][0]) if turned else middle
    ends = np.array([place - 0.5 * width, place + 0.5 * width])
    times = motion.time_of(ends) if turned else ends
    inside = motion.border[(motion.border > times[0]) & (motion.border < times[1])]
    fine = motion.time[(motion.time > times[0]) & (motion.time < times[1])][::3]
    edges = np.unique(np.concatenate([times, inside, fine]))
    nodes, weights = np.polynomial.legendre.leggauss(_LOOK)
    wide = np.diff(edges)[:, None]
    time = (edges[:-1, None] + 0.5 * wide * (nodes + 1.0)).ravel()
    weight = (0.5 * wide * weights).ravel()
    _, speed, angle = motion.course(time)
    axis = np.asarray(angle, dtype=float) if turned else time
    weight = weight * speed if turned else weight
    window = weight * (1.0 + np.cos(2.0 * np.pi * (axis - place) / width))
    signal = window * (motion.at(time) @ motion.view[section])
    # the window's area is its width
    found: np.ndarray = np.exp(-1j * rate[:, None] * axis) @ signal / width
    return np.where(rate == 0.0, 1.0, 2.0) * found
