"""The periodic problem of a roll machine, as `numerics.periodic_panels` takes it."""

import numpy as np

from vibecalc.numerics.periodic.panels import PeriodicProblem
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.roll.dynamic_rates import driven_rates
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.rates import Place, free_rates, mounted_rates, place_at
from vibecalc.response.roll.torques import smooth_angles


class RollRates:
    """dy/db at (B, P, s) crank angles; what depends on the angle alone is kept with it.

    For a free shell y = (w,) and `momentum` (B,) is its angular momentum; else y = (w, shell angle,
    shell speed) and `momentum` is None. The fluxes of a motor with transients follow behind.
    """

    def __init__(self, machine: RollMachine, drive: RollDrive, momentum: FloatArray | None):
        self.machine, self.drive, self.momentum = machine, drive, momentum
        self.evaluations = 0
        self._angles: FloatArray | None = None
        self._place: Place | None = None

    def place(self, crank_angle: FloatArray) -> Place:
        """Inertia and torques at the angles (B, P, s), as (B, P s)."""
        if self._place is None or not self._known(crank_angle):
            flat = crank_angle.reshape(len(crank_angle), -1)
            self._place = place_at(self.machine, self.drive, flat)
            self._angles = crank_angle
        return self._place

    def _known(self, crank_angle: FloatArray) -> bool:
        known = self._angles
        return known is crank_angle or (known is not None and np.array_equal(known, crank_angle))

    def __call__(
        self, crank_angle: FloatArray, state: FloatArray, piece: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        members, panels, points = crank_angle.shape
        self.evaluations += crank_angle.size
        place = self.place(crank_angle)
        flat = state.reshape(members, panels * points, -1)
        if self.drive.fluxes:
            safe = np.where(flat[..., :1] > 0.0, flat, np.nan)
            found = driven_rates(self.machine, self.drive, place, self.momentum, safe)
            return found.value.reshape(state.shape), found.jacobian.reshape(
                *state.shape, state.shape[-1]
            )
        chosen = None if piece is None else np.repeat(piece, points, axis=1)
        if self.momentum is not None:
            speed = np.where(flat[..., 0] > 0.0, flat[..., 0], np.nan)
            rate, slope = free_rates(self.machine, self.drive, place, self.momentum, speed, chosen)
            return rate.reshape(state.shape), slope.reshape(*state.shape, 1)
        safe = np.where(flat[..., :1] > 0.0, flat, np.nan)
        found = mounted_rates(self.machine, self.drive, place, safe, chosen)
        return found.value.reshape(state.shape), found.jacobian.reshape(*state.shape, 3)

    def slip(self, state: FloatArray) -> FloatArray:
        """Slip speed at states (B, P, s, n); the piece of the motor's curve hangs on it."""
        return np.asarray(self.drive.synchronous_speed[..., None, None] - state[..., 0])


def roll_problem(
    machine: RollMachine,
    drive: RollDrive,
    momentum: FloatArray | None,
    edges: FloatArray | None = None,
) -> tuple[PeriodicProblem, RollRates]:
    """Problem and right-hand side of the machines (B,); their gas tables stand at equal angles.

    `edges` are the smooth angles of these machines, if they are known.
    """
    rates = RollRates(machine, drive, momentum)
    edges = smooth_angles(machine, drive) if edges is None else edges
    has_kinks = len(drive.motor.threshold) > 0 and drive.circuit is None
    if momentum is None:
        scale = mounted_scale(machine, drive)
    else:
        scale = np.array([float(drive.synchronous_speed.max())])
    if drive.circuit is not None and drive.fluxes:
        scale = np.append(scale, np.full(drive.fluxes, drive.circuit.flux_size))
    return (
        PeriodicProblem(
            rates,
            edges,
            rates.slip if has_kinks else None,
            drive.motor.threshold if has_kinks else None,
            scale,
        ),
        rates,
    )


def mounted_scale(machine: RollMachine, drive: RollDrive) -> FloatArray:
    """Sizes of crank speed, shell angle and shell speed (3,), to weigh corrections with."""
    speed = float(np.max(drive.synchronous_speed))
    share = float(np.max(machine.rotor_inertia / (machine.shell_inertia + machine.rotor_inertia)))
    # a few per cent of the crank's speed go to and fro
    return np.array([speed, 0.05 * share, 0.05 * share * speed])
