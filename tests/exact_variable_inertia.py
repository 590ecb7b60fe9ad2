"""A shaft line whose inertias turn with the crank, by collocation in time over a whole cycle.

Angles at equally spaced crank angles are the unknowns, derivatives are those of the trigonometric
polynomial through them. Multipliers come from Chebyshev points of short panels, in angles and
speeds. Nothing is shared with the harmonic balance and the Gauss points of the package.
"""

from typing import NamedTuple

import numpy as np
from exact_transient_looks import span
from study_inputs import StudyInputs

#: harmonics of the inertia below this share of it do not count
_NEGLIGIBLE = 1e-13
_NEWTON, _STOP = 30, 1e-14
#: Chebyshev intervals of a panel, radians of the fastest in it
_NODES, _PANEL = 16, 1.5


class Motion(NamedTuple):
    """Angles (N + 1, n) in rad, 0-to-peak, of the orders k / turns."""

    order: np.ndarray
    angle: np.ndarray


class VariableTruth:
    """The line of a case; all angles against even turning."""

    def __init__(self, inputs: StudyInputs) -> None:
        self.inputs = inputs
        self.turns = round(inputs.cycle / (2.0 * np.pi))
        self.stiffness, self.damping = inputs.matrices()
        whole = inputs.order % 1.0 == 0.0
        order = inputs.order[whole].astype(int)
        n = len(inputs.inertia)
        variation = np.zeros((int(order.max(initial=0)), n), dtype=complex)
        variation[order - 1] = (2.0j * inputs.inertial[:, 1:][:, whole] / order).T
        size = (np.abs(variation) / inputs.inertia).max(axis=1, initial=0.0)
        last = int(np.flatnonzero(size > _NEGLIGIBLE).max(initial=-1)) + 1
        #: V_h (H, n) of the orders 1 to H
        self.variation = variation[:last]
        self.pieces = self._pieces()

    def _pieces(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Members and shares in the load of each piece that no spring holds to ground."""
        one, n = self.inputs, len(self.inputs.inertia)
        label = np.arange(n)
        for a, b, k in zip(one.first, one.second, one.stiffness, strict=True):
            if k > 0.0:
                label[label == label[b]] = label[a]
        found = []
        for name in np.unique(label):
            member = label == name
            if np.any(one.ground[member] > 0.0):
                continue
            share = np.zeros(n)
            if member[one.built.load_freedom]:
                share[one.built.load_freedom] = 1.0
            else:
                share = member * one.inertia
            found.append((member, share))
        return found

    def inertia(self, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Inertias (..., n) and two derivatives at the freedoms' crank angles (..., n)."""
        h = np.arange(1, len(self.variation) + 1)
        turned = np.exp(1j * angle[..., None] * h) * self.variation.T
        return (
            self.inputs.inertia + turned.real.sum(-1),
            -(turned.imag * h).sum(-1),
            -(turned.real * h**2).sum(-1),
        )

    def gas(self, speed: float, crank: np.ndarray) -> np.ndarray:
        one = self.inputs
        values = one.gas(speed)
        wave = np.exp(1j * crank[:, None] * one.order)
        total: np.ndarray = values[:, 0].real - one.taken(speed) + (wave @ values[:, 1:].T).real
        return total

    def motion(self, speed: float, steps: int, exact: bool) -> Motion:
        """Steady motion with `steps` steps of 1 / turns; exact, or linear in the angles."""
        n, count = len(self.inputs.inertia), 2 * steps + 1
        crank = np.arange(count) * (self.inputs.cycle / count)
        first, second = _derivatives(count)
        rate = speed / self.turns
        first, second = rate * first, rate**2 * second
        gas = self.gas(speed, crank)
        pieces, inertia = self.pieces, self.inputs.inertia
        size = count * n
        angle = np.zeros((count, n))
        held = np.zeros(len(pieces))
        scale = float(np.abs(self.stiffness).max())
        previous = np.inf
        for _ in range(_NEWTON if exact else 1):
            value, slope, bend = self.inertia(crank[:, None] + angle)
            fast, faster = first @ angle, second @ angle
            turning = speed + fast
            left = value * faster + 0.5 * slope * turning**2 - gas
            left += fast @ self.damping + angle @ self.stiffness
            for (_, share), torque in zip(pieces, held, strict=True):
                left += scale * torque * share
            matrix = np.zeros((size + len(pieces),) * 2)
            block = matrix[:size, :size].reshape(count, n, count, n)
            place = np.arange(count)
            block += first[:, None, :, None] * self.damping[None, :, None, :]
            for i in range(n):
                own = value[:, i, None] * second + (slope * turning)[:, i, None] * first
                own[place, place] += (
                    slope[:, i] * faster[:, i] + 0.5 * bend[:, i] * turning[:, i] ** 2
                )
                block[:, i, :, i] += own
            block[place, :, place, :] += self.stiffness
            right = np.append(-left.ravel(), np.zeros(len(pieces)))
            for row, (member, share) in enumerate(pieces):
                matrix[:size, size + row] = scale * np.tile(share, count)
                weight = scale * member * inertia / inertia[member].sum() / count
                matrix[size + row, :size] = np.tile(weight, count)
                right[size + row] = -matrix[size + row, :size] @ angle.ravel()
            answer = np.linalg.solve(matrix, right)
            answer += np.linalg.solve(matrix, right - matrix @ answer)
            step = answer[:size].reshape(count, n)
            angle, held = angle + step, held + answer[size:]
            move = float(np.abs(step).max())
            if move <= _STOP * np.abs(angle).max() or (move > 0.3 * previous and move < 1e-9):
                break
            previous = move
        spectrum = np.fft.rfft(angle, axis=0) / count
        spectrum[1:] *= 2.0
        return Motion(np.arange(steps + 1) / self.turns, spectrum)

    def constant(self, speed: float, steps: int) -> Motion:
        """With mean inertias and the torque of their variation as a load, orders above zero."""
        one, n = self.inputs, len(self.inputs.inertia)
        order = np.arange(steps + 1) / self.turns
        force = np.zeros((steps + 1, n), dtype=complex)
        place = np.rint(one.order * self.turns).astype(int)
        force[place] += one.gas(speed)[:, 1:].T
        h = np.arange(1, len(self.variation) + 1)
        force[h * self.turns] += -0.5j * h[:, None] * self.variation * speed**2
        angle = np.zeros_like(force)
        for k in range(1, steps + 1):
            w = speed * order[k]
            matrix = self.stiffness + 1j * w * self.damping - w**2 * np.diag(one.inertia)
            angle[k] = np.linalg.solve(matrix, force[k])
        return Motion(order, angle)

    def torque(self, motion: Motion, speed: float) -> np.ndarray:
        """Referred section torques (N, e) of the orders above zero."""
        one, w = self.inputs, speed * motion.order[1:, None]
        found: np.ndarray = (motion.angle[1:] @ one.element.T) * (
            one.stiffness + 1j * w * one.damping
        )
        return found

    def half_range(self, motion: Motion, speed: float) -> np.ndarray:
        return span(self.torque(motion, speed), motion.order[1:])[0]

    def relative_variation(self) -> np.ndarray:
        """Half the range of each inertia over the turn, over its mean."""
        if not len(self.variation):
            return np.zeros(len(self.inputs.inertia))
        found: np.ndarray = span(self.variation, np.arange(1.0, len(self.variation) + 1.0))[0]
        return found / self.inputs.inertia

    def growth(self, speed: float, motion: Motion | None) -> float:
        """Of the fastest vibration about a motion (None: even turning), in 1/s."""
        one, n = self.inputs, len(self.inputs.inertia)
        period = self.inputs.cycle / speed
        root = np.sqrt(one.inertia)
        natural = np.sqrt(np.abs(np.linalg.eigvalsh(self.stiffness / root / root[:, None])[-1]))
        top = max(float(natural), speed * max(len(self.variation), 8.0))
        panels = int(np.ceil(period * top / _PANEL))
        nodes, slopes = _chebyshev(_NODES)
        time = (np.arange(panels)[:, None] + nodes) * (period / panels)
        crank = speed * time
        angle, fast, faster = np.zeros((3, *time.shape, n))
        if motion is not None:
            wave = np.exp(1j * crank[..., None] * motion.order)
            turn = 1j * speed * motion.order[:, None]
            angle, fast, faster = ((wave @ (turn**k * motion.angle)).real for k in range(3))
        value, slope, bend = self.inertia(crank[..., None] + angle)
        turning = speed + fast
        spring = slope * faster + 0.5 * bend * turning**2
        block = np.zeros((*time.shape, 2 * n, 2 * n))
        index = np.arange(n)
        block[..., index, n + index] = top
        block[..., n:, :n] = -self.stiffness / value[..., None] / top
        block[..., n + index, index] -= spring / value / top
        block[..., n:, n:] = -self.damping / value[..., None]
        block[..., n + index, n + index] -= slope * turning / value
        # y' = A y at all nodes but the first, where y is given
        size = _NODES * 2 * n
        whole = np.zeros((panels, _NODES, 2 * n, _NODES, 2 * n))
        eye = np.eye(2 * n)
        whole += (slopes[1:, 1:] * (panels / period))[None, :, None, :, None] * eye[:, None, :]
        k = np.arange(_NODES)
        whole[:, k, :, k, :] -= block[:, 1:].swapaxes(0, 1)
        begin = -(slopes[1:, 0] * (panels / period))[:, None, None] * eye
        right = np.broadcast_to(begin.reshape(size, 2 * n), (panels, size, 2 * n))
        ends = np.linalg.solve(whole.reshape(panels, size, size), right)[:, -2 * n :]
        total = eye
        for transfer in ends:
            total = transfer @ total
        multiplier, vector = np.linalg.eig(total)
        twist = vector[:n]
        energy = (one.inertia[:, None] * np.abs(twist) ** 2).sum(axis=0)
        common = np.zeros(2 * n)
        for member, _ in self.pieces:
            weight = member * one.inertia
            common += np.abs(weight @ twist) ** 2 / weight.sum() / energy
        # drifts: two of each free piece, those that turn most as a whole
        vibrates = np.argsort(common)[: 2 * (n - len(self.pieces))]
        return float(np.log(np.abs(multiplier[vibrates]).max()) / period)


def _derivatives(count: int) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative on an odd number of equally spaced points of 2 pi."""
    gap = np.arange(count)[:, None] - np.arange(count)
    sign = np.where(gap % 2 == 0, 1.0, -1.0)
    half = np.pi * gap / count
    off = gap != 0
    sine = np.where(off, np.sin(half), 1.0)
    first = np.where(off, 0.5 * sign / sine, 0.0)
    second = np.where(off, -0.5 * sign * np.cos(half) / sine**2, (1.0 - count**2) / 12.0)
    return first, second


def _chebyshev(intervals: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of 0 ... 1, rising, and the matrix of the derivative there."""
    k = np.arange(intervals + 1)
    x = -np.cos(np.pi * k / intervals)
    weight = np.where((k == 0) | (k == intervals), 2.0, 1.0) * (-1.0) ** k
    gap = x[:, None] - x + np.eye(intervals + 1)
    matrix = weight[:, None] / weight / gap
    matrix -= np.diag(matrix.sum(axis=1))
    return 0.5 * (x + 1.0), 2.0 * matrix
