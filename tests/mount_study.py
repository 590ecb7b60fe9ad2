"""The generator on four equal mounts in closed form: a second way to its mount design.

Pitch only: inertia of a uniform block, four mounts at x = -0.4 m and 0.4 m, couples of three
cranks at 120 degrees. Written for tests, without anything from the package.
"""

import numpy as np

GRAVITY = 9.80665
OPERATING_SPEED = 4900 * 2 * np.pi / 60
LEVER = 0.4
MACHINE_MASS = 100.0
CRANK_RADIUS, ROD_LENGTH, RECIPROCATING_MASS = 0.06, 0.2, 0.4
STEADY_LIMIT, RUN_UP_LIMIT = 100.0, 400.0
CLASSIC = {1: 1.0, 2: CRANK_RADIUS / ROD_LENGTH}


def exact_series(highest):
    """Acceleration coefficients of the exact motion over r w^2, by a transform of the position."""
    angle = 2 * np.pi * np.arange(256) / 256
    position = CRANK_RADIUS * np.cos(angle) + np.sqrt(
        ROD_LENGTH**2 - (CRANK_RADIUS * np.sin(angle)) ** 2
    )
    cosines = 2 * np.fft.rfft(position).real / 256
    return {n: n**2 * cosines[n] / CRANK_RADIUS for n in (1, *range(2, highest + 1, 2))}


class MountStudy:
    """Sag, amplitude and forces of one support for arrays of stiffness, damping and block mass.

    `share` is 1 for the force of one of four supports and 4 for the couple over the lever.
    """

    def __init__(self, series=None, share=1.0):
        self.share = share
        series = CLASSIC if series is None else series
        position = np.array([-0.3, 0.0, 0.3])
        phase = np.array([2, 0, 4]) * np.pi / 3
        orders = np.array(list(series))
        throw = np.exp(1j * orders[:, None] * phase) @ position
        self.couple = RECIPROCATING_MASS * CRANK_RADIUS * np.array(list(series.values())) * throw
        self.orders = orders

    def rotation_and_force(self, stiffness, damping, block, speed):
        """Complex amplitudes (..., orders) of the pitch angle and of the force of one support."""
        stiffness, damping, block, speed = (
            np.asarray(value)[..., None] for value in (stiffness, damping, block, speed)
        )
        inertia = (MACHINE_MASS * (0.35**2 + 0.8**2) + block * (0.8**2 + 0.05**2)) / 12
        rate = 1j * self.orders * speed
        arm = 4 * LEVER**2
        angle = (
            self.couple * speed**2 / (arm * stiffness + arm * damping * rate + inertia * rate**2)
        )
        return angle, LEVER * (stiffness + damping * rate) * angle

    def peak(self, amplitudes):
        """Largest magnitude over the cycle of the sum of orders, (...)."""
        grid = 2 * np.pi * np.arange(48) / 48
        signal = np.abs((amplitudes @ np.exp(1j * self.orders[:, None] * grid)).real)
        angle = grid[np.argmax(signal, axis=-1)]
        for _ in range(6):
            waves = amplitudes * np.exp(1j * self.orders * angle[..., None])
            slope = np.sum(1j * self.orders * waves, axis=-1).real
            bend = np.sum(-(self.orders**2) * waves, axis=-1).real
            angle = angle - slope / np.where(bend == 0, 1, bend)
        return np.abs(
            np.sum(amplitudes * np.exp(1j * self.orders * angle[..., None]), axis=-1).real
        )

    def force_at(self, stiffness, damping, block, speed):
        """Peak over the cycle of the force of one support, times `share`."""
        return self.share * self.peak(self.rotation_and_force(stiffness, damping, block, speed)[1])

    def run_up(self, stiffness, damping, block):
        """Largest of these peaks from rest to the operating speed, by zooming in on the best."""
        stiffness, damping, block = (
            np.asarray(value, dtype=float)[..., None] for value in (stiffness, damping, block)
        )
        inertia = (MACHINE_MASS * (0.35**2 + 0.8**2) + block * (0.8**2 + 0.05**2)) / 12
        resonance = np.sqrt(4 * LEVER**2 * stiffness / inertia)
        steps = np.concatenate([np.geomspace(0.2, 0.7, 12), np.linspace(0.72, 3.0, 40)])
        speed = np.minimum(resonance * steps, OPERATING_SPEED)
        best = np.argmax(self.force_at(stiffness, damping, block, speed), axis=-1)[..., None]
        middle = np.take_along_axis(speed, best, -1)
        half = 0.05 * resonance
        for _ in range(10):
            speed = np.minimum(middle + half * np.linspace(-1, 1, 13), OPERATING_SPEED)
            force = self.force_at(stiffness, damping, block, speed)
            best = np.argmax(force, axis=-1)[..., None]
            middle = np.take_along_axis(speed, best, -1)
            half = half / 5
        at_end = self.force_at(stiffness, damping, block, OPERATING_SPEED)
        return np.maximum(np.max(force, axis=-1), at_end[..., 0])

    def objective(self, stiffness, damping, block):
        """Sag plus the amplitude of a support at operating speed, m."""
        angle, _ = self.rotation_and_force(stiffness, damping, block, OPERATING_SPEED)
        sag = (MACHINE_MASS + np.asarray(block)) * GRAVITY / (4 * np.asarray(stiffness))
        return sag + LEVER * self.peak(angle)

    def margins(self, stiffness, damping, block):
        """Dimensionless margins of the force at operating speed and in run-up."""
        steady = self.force_at(stiffness, damping, block, OPERATING_SPEED)
        return 1 - steady / STEADY_LIMIT, 1 - self.run_up(stiffness, damping, block) / RUN_UP_LIMIT

    def evaluate(self, variables):
        """As `minimise` asks for it; variables are stiffness, damping and block mass."""
        return float(self.objective(*variables)), np.array(self.margins(*variables))
